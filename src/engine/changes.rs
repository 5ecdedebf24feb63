//! What each action of a finished plan changed.

use super::eval::{Context, frame};
use super::outcome::Step;
use super::reasoner::Reasoner;
use super::state::State;
use crate::ir::{Domain, SlotId, Value};

/// Runs the plan once more from the start, reading every shared attribute after every step; returns the slots whose value
/// a step changed, with the new value. The reasoner is left in the world state that it is in.
pub(super) fn changes(
    domain: &Domain,
    shared: &[SlotId],
    steps: &[Step],
    reasoner: &mut dyn Reasoner,
) -> Vec<Vec<(SlotId, Value)>> {
    let world = reasoner.save();
    reasoner.rewind();
    let mut state = State::new(domain, shared);
    let mut context = Context::new(domain, &mut state, reasoner);
    let all = (0..domain.slots.len()).map(|i| SlotId(i as u32));
    let mut before: Vec<Value> = all.map(|s| context.slot(s)).collect();
    let mut changes = Vec::with_capacity(steps.len());
    for step in steps {
        let action = &domain.actions[step.action.index()];
        let mut frame = frame(&step.args, action.n_vars);
        let mut writes = Vec::new();
        context.projection = step.geometric;
        context.apply(&action.effects, &mut frame, &mut writes);
        if let Some(gas) = step.gas {
            context.reasoner.replay(gas);
            for slot in shared {
                context.state.forget(*slot);
            }
            writes.extend_from_slice(shared);
        }
        writes.sort();
        writes.dedup();
        let mut changed = Vec::new();
        for slot in writes {
            let value = context.slot(slot);
            if value != before[slot.index()] {
                before[slot.index()] = value.clone();
                changed.push((slot, value));
            }
        }
        changes.push(changed);
    }
    reasoner.restore(world);
    changes
}
