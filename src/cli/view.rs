//! `sgap view DOMAIN [WORLD]`, `sgap view WORLD [PLAN.json]`, `sgap view PLAN.json`: one page, and the browser that shows it.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Failure, check_place, deliver, note, say, write_file};
use super::plan::{SearchOptions, search};
use super::{Inputs, code, export, load_world, picture, read_plan};
use sgap::plan::Plan;
use sgap::report::{html, svg};
use sgap::world::World;

/// What to show, and where.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    inputs: Inputs,
    #[command(flatten)]
    search: SearchOptions,
    /// What to write [default: page.html; with a `--format` other than a page's, the standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the page only; else a browser shows it, if the command runs on a terminal
    #[arg(long)]
    no_open: bool,
    /// Write a picture for papers, too: top view with the ways of the tools, schedule, decomposition
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write a picture of the page, too; a Chromium or Chrome in the PATH draws it
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Instant of the plan that `--png` shows [s]
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, requires = "png", value_parser = instant)]
    at: f64,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    for path in [&options.output, &options.svg, &options.png].into_iter().flatten() {
        check_place(path)?;
    }
    let form = options.inputs.problems.format.export();
    let default = Path::new("page.html");
    let output = options.output.as_deref();
    if form.is_none() && output.is_none() {
        check_place(default)?;
    }
    let (world, plan) = content(options)?;
    let (world, plan, title) = (&world, plan.as_ref(), options.inputs.title());
    if let Some(path) = &options.svg {
        write_file(path, &svg::write(&world.scene, &world.start, plan, &title))?;
        note(&format!("{} written\n", path.display()));
    }
    let page = || html::page(&world.scene, &world.start, plan, &title);
    if let Some(path) = &options.png {
        picture::write(&page(), options.at, path)?;
        note(&format!("{} written\n", path.display()));
    }
    if let Some(form) = form {
        let text = export::text(form, world, plan, &title)?;
        return deliver(output, &mut |out| out.write_all(text.as_bytes()));
    }
    let output = output.unwrap_or(default);
    write_file(output, &page())?;
    note(&format!("{} written\n", output.display()));
    if !options.no_open
        && std::io::stderr().is_terminal()
        && let Err(why) = opener::open(output)
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

fn instant(text: &str) -> Result<f64, String> {
    let t = text.parse().ok().filter(|t: &f64| t.is_finite() && *t >= 0.0);
    t.ok_or_else(|| "write a number of seconds from 0 on".into())
}
