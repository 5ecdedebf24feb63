//! `sgap validate DOMAIN [WORLD] PLAN.json`.

use std::path::PathBuf;

use clap::Args;

use super::disk::Disk;
use super::output::{Failure, print, say};
use super::{Inputs, Ready, code};
use sgap::diag::{Problem, Problems};
use sgap::report::json;
use sgap::source::{Files, Sources};
use sgap::validate;

/// Which plan, against what.
#[derive(Debug, Args)]
// The world may be left out before the plan.
#[command(allow_missing_positional = true)]
pub(super) struct Options {
    #[command(flatten)]
    inputs: Inputs,
    /// Plan as written by `sgap plan --json`
    plan: PathBuf,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let Ready {
        domain, world, goal, ..
    } = options.inputs.load_with_goal()?;
    let path = options.plan.to_string_lossy();
    let plan = Disk.read(&path).and_then(|text| json::read(&text)).or_else(|why| {
        let problem = Problem::unplaced("plan::unreadable", format!("can't read the plan `{path}`: {why}"));
        super::report(Problems(vec![problem]), &Sources::default(), None)
    })?;
    match validate::replay(&plan, &domain, &goal, &world, &validate::Settings::STANDARD) {
        Ok(verdict) => print(&format!("valid: {verdict}\n")),
        Err(fault) => {
            say(&format!("invalid: {fault}\n"));
            Err(Failure::Code(code::PLAN_INVALID))
        }
    }
}
