//! `sgap view DOMAIN WORLD -o page.html`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Inputs;
use super::output::{Failure, check_place, say, write_file};
use super::plan::{SearchOptions, search};
use sgap::report::html;

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
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    check_place(&options.output)?;
    let (domain, world, goal) = options.inputs.load_with_goal()?;
    let plan = search(&domain, &world, &goal, &options.search)?;
    let name = |path: &Path| {
        path.file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    };
    let (domain, scene) = (name(&options.inputs.domain), name(&options.inputs.world));
    let title = if domain == scene {
        domain
    } else {
        format!("{domain}, {scene}")
    };
    let page = html::page(&world.scene, &world.start, Some(&plan), &title);
    write_file(&options.output, &page)?;
    say(&format!("{} written\n", options.output.display()));
    Ok(())
}
