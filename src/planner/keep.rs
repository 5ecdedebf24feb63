//! The first actions of an earlier plan, made ready to be kept.

use crate::engine::Kept;
use crate::ir::{Domain, Goal, TaskId};
use crate::plan::{Action, Plan};
use crate::validate::{self, Fault};
use crate::world::World;

/// Returns the first `n` actions of a plan, all if it has fewer, for [`Options::keep`](super::Options::keep).
///
/// Their motions are held against the world with the validator's eyes. Whether their preconditions still hold, and whether
/// they fit into a decomposition of the task, the search will tell.
///
/// # Errors
///
/// The document says what this domain does not know, or its motions don't fit into this world any more: the first fault.
pub fn keep(plan: &Plan, n: usize, domain: &Domain, world: Option<&World>) -> Result<Vec<Kept>, Fault> {
    let empty = World::empty();
    let world = world.unwrap_or(&empty);
    let tasks = validate::prefix(plan, n, domain, world, &validate::Settings::STANDARD)?;
    let kept = plan
        .actions
        .iter()
        .zip(tasks)
        .filter_map(|(written, Goal { task, args })| match task {
            TaskId::Action(action) => Some(Kept {
                action,
                args,
                written: written.clone(),
            }),
            // INVARIANT: the validator takes actions for actions only.
            TaskId::Method(_) => None,
        });
    Ok(kept.collect())
}

/// Numbers that differ by less are the same but for the rounding of a document.
const ROUNDING: f64 = 1e-7;

/// Writes the kept actions of a new plan as the earlier one has them, where they differ by nothing but the rounding of that
/// document's numbers: sums of what was rounded are not the rounded sums.
pub(super) fn as_written(plan: &mut Plan, kept: &[Kept]) {
    for (action, Kept { written, .. }) in plan.actions.iter_mut().zip(kept) {
        let numbers = |a: &Action| [a.cost, a.duration[0], a.duration[1], a.start, a.end];
        let mut pairs = numbers(action).into_iter().zip(numbers(written));
        if !pairs.all(|(a, b)| (a - b).abs() <= ROUNDING) {
            continue;
        }
        let Action {
            cost,
            duration,
            start,
            end,
            ..
        } = *written;
        (action.cost, action.duration, action.start, action.end) = (cost, duration, start, end);
    }
}
