//! `sgap view DOMAIN [WORLD]`, `sgap view WORLD [PLAN.json]`, `sgap view PLAN.json`: one page, and the browser that shows it.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Failure, check_place, say, write_file};
use super::plan::{SearchOptions, search};
use super::{Inputs, code, load_world, read_plan};
use sgap::plan::Plan;
use sgap::report::html;
use sgap::world::World;

/// What to show, and where.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    inputs: Inputs,
    #[command(flatten)]
    search: SearchOptions,
    /// The page to write
    #[arg(short, long, value_name = "FILE", default_value = "page.html")]
    output: PathBuf,
    /// Write the page only; else a browser shows it, if the command runs on a terminal
    #[arg(long)]
    no_open: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    check_place(&options.output)?;
    let (world, plan) = content(options)?;
    let page = html::page(&world.scene, &world.start, plan.as_ref(), &title(&options.inputs));
    write_file(&options.output, &page)?;
    say(&format!("{} written\n", options.output.display()));
    if !options.no_open
        && std::io::stderr().is_terminal()
        && let Err(why) = opener::open(&options.output)
    {
        say(&format!(
            "no browser could be started ({why}); open the page yourself\n"
        ));
    }
    Ok(())
}

/// Reads the world and the plan to show, or plans first, as the files' kinds say.
fn content(options: &Options) -> Result<(World, Option<Plan>), Failure> {
    let Inputs {
        domain: first,
        world: second,
        problems,
        ..
    } = &options.inputs;
    match (kind(first), second.as_deref()) {
        ("toml", None) => Ok((load_world(first, problems)?, None)),
        ("toml", Some(plan)) if kind(plan) == "json" => {
            let plan = read_plan(plan)?;
            Ok((load_world(first, problems)?, Some(plan)))
        }
        ("json", None) => {
            let plan = read_plan(first)?;
            if plan.actions.iter().any(|action| action.geometry.is_some()) {
                say(&format!(
                    "error: the plan moves bodies, so its world must be named, too\n\n  sgap view WORLD {}\n",
                    first.display()
                ));
                return Err(Failure::Code(code::WRONG_USAGE));
            }
            Ok((World::empty(), Some(plan)))
        }
        _ => {
            let ready = options.inputs.load_with_goal()?;
            let plan = search(&ready, &options.search)?;
            Ok((ready.world, Some(plan)))
        }
    }
}

/// Returns the end of a file's name, which says what is in it.
fn kind(path: &Path) -> &str {
    path.extension().and_then(OsStr::to_str).unwrap_or_default()
}

/// Returns the names of the files, each once.
fn title(inputs: &Inputs) -> String {
    let name = |path: &Path| {
        path.file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    };
    let first = name(&inputs.domain);
    match inputs.world.as_deref().map(name) {
        Some(second) if second != first => format!("{first}, {second}"),
        _ => first,
    }
}
