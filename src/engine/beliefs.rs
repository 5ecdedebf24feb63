//! What agents learn of an action (decision 15).
//!
//! Those who take part know what the action has changed, as do those of whom the fact `observes` says so in the state after
//! it; the others believe what they did, be it true or not. What an effect itself says of a belief stands.

use super::eval::{Context, frame};
use crate::ir::{Action, EntityId, SlotId, Value};

impl Context<'_> {
    /// Sets the beliefs of those who learn of what has been written, and notes these, too. What `observes` looks at counts
    /// as read by the action.
    pub(super) fn learn(&mut self, action: &Action, args: &[Value], writes: &mut Vec<SlotId>) {
        let domain = self.domain;
        let Some(beliefs) = &domain.beliefs else { return };
        let mut written = writes.clone();
        written.sort_unstable();
        written.dedup();
        // All look before anybody learns: a belief may not decide who sees.
        let mut learned = Vec::new();
        for value in &written {
            if domain.believer(*value).is_some() {
                continue;
            }
            for agent in &domain.types[beliefs.agents.index()].entities {
                let Some(belief) = domain.belief(*value, *agent) else {
                    break;
                };
                let is_told = written.binary_search(&belief).is_ok();
                if !is_told && (takes_part(action, args, *agent) || self.observes(*agent, *value)) {
                    learned.push((belief, self.slot(*value)));
                }
            }
        }
        for (belief, value) in learned {
            self.state.set(belief, value);
            writes.push(belief);
        }
    }

    /// Says whether an agent sees that a value has changed.
    fn observes(&mut self, agent: EntityId, value: SlotId) -> bool {
        let domain = self.domain;
        let Some(observes) = domain.beliefs.as_ref().and_then(|b| b.observes.as_ref()) else {
            return false;
        };
        let of = domain.slots[value.index()].entity;
        if observes
            .ty
            .is_some_and(|ty| !domain.is_subtype(domain.entities[of.index()].ty, ty))
        {
            return false;
        }
        let args = [Value::Entity(agent), Value::Entity(of)];
        self.holds(&observes.body, &mut frame(&args, observes.n_vars))
    }
}

fn takes_part(action: &Action, args: &[Value], agent: EntityId) -> bool {
    action.agents.iter().any(|position| match &args[*position] {
        Value::Entity(one) => *one == agent,
        Value::Set(several) => several.contains(agent),
        Value::Null | Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Scalars(_) => {
            false
        }
    })
}
