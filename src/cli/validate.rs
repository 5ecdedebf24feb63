//! `sgap validate DOMAIN [WORLD] PLAN.json`.

use std::path::PathBuf;

use clap::Args;

use super::output::{Failure, print, say};
use super::{Inputs, Ready, code, read_plan};
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
    let plan = read_plan(&options.plan)?;
    match validate::replay(&plan, &domain, &goal, &world, &validate::Settings::STANDARD) {
        Ok(verdict) => print(&format!("valid: {verdict}\n")),
        Err(fault) => {
            say(&format!("invalid: {fault}\n"));
            Err(Failure::Code(code::PLAN_INVALID))
        }
    }
}
