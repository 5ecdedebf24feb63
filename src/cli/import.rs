//! `sgap import DOMAIN.hddl PROBLEM.hddl`.

use std::path::PathBuf;

use clap::Args;

use super::output::{Failure, check_place, deliver, note};
use super::problems::{ProblemOptions, To};
use sgap::load::import_pair;
use sgap::planner::Disk;
use sgap::source::Sources;
use sgap::syntax;

/// What to import.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Domain file (.hddl)
    domain: PathBuf,
    /// Problem file (.hddl)
    problem: PathBuf,
    /// Write to this file instead of the standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    problems: ProblemOptions,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if let Some(path) = &options.output {
        check_place(path)?;
    }
    let mut sources = Sources::default();
    let [domain, problem] = [&options.domain, &options.problem].map(|path| path.to_string_lossy());
    let (imported, problems) = import_pair(&domain, &problem, &mut sources, &Disk);
    let imported = options.problems.report(problems, &sources, imported, To::Error)?;
    let task = imported.names.task();
    let file = sources.add("the imported domain", imported.hatp);
    let text = match syntax::format(file, &sources.get(file).text) {
        Ok(text) => text,
        Err(problems) => return options.problems.report(problems, &sources, None, To::Error),
    };
    deliver(options.output.as_deref(), &mut |out| out.write_all(text.as_bytes()))?;
    if let Some(path) = &options.output {
        note(&format!("plan it with: sgap plan {} --task '{task}'\n", path.display()));
    }
    Ok(())
}
