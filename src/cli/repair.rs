//! `sgap plan --from PLAN.json --after N`: which actions of an earlier plan are kept.

use std::path::PathBuf;

use clap::Args;

use super::output::{Failure, say};
use super::{Ready, code, fail, read_plan};
use sgap::diag::Problem;
use sgap::engine::Kept;
use sgap::plan::WhyNot;
use sgap::planner;

/// What is kept.
#[derive(Debug, Args)]
pub(super) struct RepairOptions {
    /// Repair this plan: keep its first actions, motions included, and plan the rest
    #[arg(long, value_name = "PLAN", requires = "after")]
    from: Option<PathBuf>,
    /// How many actions of `--from` are kept
    #[arg(long, value_name = "N", requires = "from")]
    after: Option<usize>,
}

impl RepairOptions {
    /// Reads what is kept and holds it against the world; ends with a message where that can't be.
    pub(super) fn kept(&self, ready: &Ready) -> Result<Vec<Kept>, Failure> {
        let (Some(path), Some(n)) = (&self.from, self.after) else {
            return Ok(Vec::new());
        };
        let plan = read_plan(path)?;
        let has = plan.actions.len();
        if n > has {
            let path = path.display();
            let message = format!("`--after {n}`: the plan `{path}` has {}", count(has));
            return Err(fail(
                Problem::unplaced("plan::too-short", message).help(format!("`--after` goes from 0 to {has}")),
            ));
        }
        let world = ready.has_world.then_some(&ready.world);
        planner::keep(&plan, n, &ready.domain, world).map_err(|fault| self.refuse(&fault.to_string()))
    }

    /// Says that the kept action `index` can't be done any more.
    pub(super) fn impossible(&self, index: usize, why: &WhyNot) -> Failure {
        let reasons = why.reasons();
        let reason = reasons.first().map_or("", |(text, _)| text);
        self.refuse(&format!("action {index}, {reason}"))
    }

    fn refuse(&self, why: &str) -> Failure {
        let n = self.after.unwrap_or(0);
        let path = self.from.as_deref().unwrap_or(std::path::Path::new("")).display();
        let first = if n == 1 { "action" } else { "actions" };
        say(&format!("can't keep the first {n} {first} of `{path}`: {why}\n"));
        Failure::Code(code::PLAN_INVALID)
    }
}

fn count(n: usize) -> String {
    match n {
        1 => "1 action".to_owned(),
        n => format!("{n} actions"),
    }
}
