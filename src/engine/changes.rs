//! What each action of a finished plan changed.

use super::eval::Context;
use super::outcome::{Found, Step};
use super::reasoner::Reasoner;
use super::state::State;
use crate::ir::{Domain, SlotId, Value};

/// Runs the plan once more from the start, reading every shared attribute after every projection; returns the slots whose
/// value a step changed, with the new value, one step after the other, and where each step's end. The reasoner is left in
/// the world state that it is in.
pub(super) fn changes(
    domain: &Domain,
    shared: &[SlotId],
    found: &Found,
    reasoner: &mut dyn Reasoner,
) -> (Vec<(SlotId, Value)>, Vec<usize>) {
    let world = reasoner.save();
    reasoner.rewind();
    let mut state = State::new(domain, shared);
    let mut context = Context::new(domain, &mut state, reasoner);
    let all = (0..domain.slots.len()).map(|i| SlotId(i as u32));
    let mut before: Vec<Value> = all.map(|s| context.slot(s)).collect();
    let (mut changes, mut ends) = (Vec::new(), Vec::with_capacity(found.steps.len()));
    let (mut writes, mut frame) = (Vec::new(), Vec::new());
    for step in &found.steps {
        let action = &domain.actions[step.action.index()];
        let args = found.args(domain, step);
        frame.clear();
        frame.extend_from_slice(args);
        frame.resize(action.n_vars.max(args.len()), Value::Null);
        writes.clear();
        context.reads.clear();
        context.projection = step.geometric;
        context.apply(&action.effects, &mut frame, &mut writes);
        if let Some(gas) = step.gas {
            context.reasoner.replay(gas);
            for slot in shared {
                context.state.forget(*slot);
            }
            writes.extend_from_slice(shared);
        }
        context.learn(action, args, &mut writes);
        writes.sort_unstable();
        writes.dedup();
        for slot in &writes {
            let value = context.slot(*slot);
            if value != before[slot.index()] {
                before[slot.index()] = value.clone();
                changes.push((*slot, value));
            }
        }
        ends.push(changes.len());
    }
    reasoner.restore(world);
    (changes, ends)
}

/// As [`changes`], where no attribute is shared with geometry: of what each step has written, in order, what it has changed.
pub(super) fn changes_of(
    domain: &Domain,
    steps: &[Step],
    mut written: Vec<(SlotId, Value)>,
) -> (Vec<(SlotId, Value)>, Vec<usize>) {
    let mut before = domain.initial.clone();
    let mut ends = Vec::with_capacity(steps.len());
    let (mut from, mut kept) = (0, 0);
    for step in steps {
        let to = from + (step.slots[2] - step.slots[1]) as usize;
        for at in from..to {
            let (slot, value) = &written[at];
            let old = &mut before[slot.index()];
            if value != old {
                old.clone_from(value);
                written.swap(kept, at);
                kept += 1;
            }
        }
        from = to;
        ends.push(kept);
    }
    written.truncate(kept);
    (written, ends)
}
