//! What each action of a finished plan changed.

use super::eval::Context;
use super::outcome::{Changed, Found, Step};
use super::reasoner::Reasoner;
use super::state::State;
use crate::ir::{Domain, SlotId, Value};

/// Runs the plan once more from the start, reading every shared attribute after every projection; returns what each step
/// changed. The reasoner is left in the world state that it is in.
pub(super) fn changes(domain: &Domain, shared: &[SlotId], found: &Found, reasoner: &mut dyn Reasoner) -> Changed {
    let world = reasoner.save();
    reasoner.rewind();
    let mut state = State::new(domain, shared);
    let mut context = Context::new(domain, &mut state, reasoner);
    let all = (0..domain.slots.len()).map(|i| SlotId(i as u32));
    let mut before: Vec<Value> = all.map(|s| context.slot(s)).collect();
    let mut changed = Changed::default();
    let (mut writes, mut frame) = (Vec::new(), Vec::new());
    for step in &found.steps {
        let action = &domain.actions[step.action.index()];
        let args = found.args(domain, step);
        frame.clear();
        frame.extend_from_slice(args);
        frame.resize(action.n_vars.max(args.len()), Value::Null);
        writes.clear();
        context.reads.clear();
        let charge = found.charge(step);
        context.projection = charge.geometric;
        context.apply(&action.effects, &mut frame, &mut writes);
        if let Some(gas) = charge.gas {
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
                changed.slots.push(*slot);
                changed.values.push(value);
            }
        }
        changed.ends.push(changed.slots.len() as u32);
    }
    reasoner.restore(world);
    changed
}

/// As [`changes`], where no attribute is shared with geometry: of what each step has written, with the values that it had
/// after the step, in order, what it has changed.
pub(super) fn changes_of(domain: &Domain, steps: &[Step], written: &[SlotId], news: &[Value]) -> Changed {
    let mut before: Vec<&Value> = domain.initial.iter().collect();
    let mut changed = Changed::default();
    let mut news = news.iter();
    for step in steps {
        let slots = &written[step.slots[1] as usize..step.slots[2] as usize];
        for (slot, value) in slots.iter().zip(news.by_ref()) {
            if std::mem::replace(&mut before[slot.index()], value) != value {
                changed.slots.push(*slot);
                changed.values.push(value.clone());
            }
        }
        changed.ends.push(changed.slots.len() as u32);
    }
    changed
}
