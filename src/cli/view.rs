//! `sgap view DOMAIN [WORLD] -o page.html`.

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
    let ready = options.inputs.load_with_goal()?;
    let plan = search(&ready, &options.search)?;
    let name = |path: &Path| {
        path.file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    };
    let domain = name(&options.inputs.domain);
    let title = match options.inputs.world.as_deref().map(name) {
        Some(scene) if scene != domain => format!("{domain}, {scene}"),
        _ => domain,
    };
    let page = html::page(&ready.world.scene, &ready.world.start, Some(&plan), &title);
    write_file(&options.output, &page)?;
    say(&format!("{} written\n", options.output.display()));
    Ok(())
}
