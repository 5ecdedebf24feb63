//! Facts of a world state (thesis 3.2.4, 3.3.4.1) that look at bottoms, hands, arms and eyes, and the memory of what was asked.
//!
//! A fact is a pure function of a state and a seed: nobody moves the robot to ask a question, and asking twice gives the same answer.
//! [`memory`] keeps answers together with what they rest on; what they say is the same with it and without.

mod layout;
mod memory;
mod reach;
mod sight;
mod standing;
mod why;

pub(super) use layout::States;
pub(super) use memory::Memory;
pub(super) use reach::is_reachable;
pub(super) use sight::is_visible;
pub(super) use standing::{OVERHANG, is_level, is_on, placed_pose};
pub(super) use why::why;

use crate::world::State;

/// Says whether `object` is attached to one of the agent's hands.
pub(super) fn has_in_hand(state: &State, agent: usize, object: usize) -> bool {
    state.objects[object].held.as_ref().is_some_and(|h| h.agent == agent)
}

/// Says whether something is attached to that hand.
fn is_full(state: &State, agent: usize, arm: usize) -> bool {
    let mut held = state.objects.iter().filter_map(|o| o.held.as_ref());
    held.any(|h| h.agent == agent && h.arm == arm)
}
