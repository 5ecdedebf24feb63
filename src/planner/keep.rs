//! The first actions of an earlier plan, made ready to be kept.

use crate::engine::Kept;
use crate::ir::{Domain, Goal, TaskId};
use crate::plan::Plan;
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
                geometry: written.geometry.clone(),
            }),
            // INVARIANT: the validator takes actions for actions only.
            TaskId::Method(_) => None,
        });
    Ok(kept.collect())
}
