//! What agents believe after an action, for the replay alone (decision 15).
//!
//! Agents that take part in an action know what it wrote; so do those that observe, by the domain's fact `observes` in the
//! state after it. Other beliefs stay, and so do those that an effect of the same action sets.

use std::cell::RefCell;

use super::evaluate::{Around, Touched, Values, View, apply, put};
use crate::ir::{Action, Domain, EntityId, SlotId, Value};

/// Applies an action's effects; returns what they wrote.
pub(super) fn apply_noting(
    around: Around<'_>,
    values: &mut [Value],
    action: &Action,
    frame: &mut [Value],
) -> Vec<SlotId> {
    let own = RefCell::new(Touched::default());
    apply(
        Around {
            touched: Some(&own),
            ..around
        },
        values,
        &action.effects,
        frame,
    );
    let own = own.into_inner();
    around.note(|touched| {
        touched.reads.extend_from_slice(&own.reads);
        touched.writes.extend_from_slice(&own.writes);
        touched.asks |= own.asks;
    });
    own.writes
}

/// Has agents learn of what was `written`; `values` is the state after the effects, `args` are the action's.
pub(super) fn learn(around: Around<'_>, values: &mut [Value], action: &Action, args: &[Value], written: &[SlotId]) {
    let domain = around.domain;
    let Some(beliefs) = &domain.beliefs else { return };
    let mut news = Vec::new();
    for agent in &domain.types[beliefs.agents.index()].entities {
        for value in written {
            let belief = match domain.belief(*value, *agent) {
                Some(belief) if domain.believer(*value).is_none() && !written.contains(&belief) => belief,
                Some(_) | None => continue,
            };
            if is_in(action, args, *agent)
                || observes(
                    View {
                        around,
                        values: Values::Now(values),
                    },
                    domain,
                    *agent,
                    *value,
                )
            {
                news.push((belief, values[value.index()].clone()));
            }
        }
    }
    for (belief, value) in news {
        put(around, values, belief, value);
    }
}

/// Says whether the agent is an argument of the action, alone or in a set.
fn is_in(action: &Action, args: &[Value], agent: EntityId) -> bool {
    let mut arguments = action.agents.iter().filter_map(|i| args.get(*i));
    arguments.any(|arg| match arg {
        Value::Entity(e) => *e == agent,
        Value::Set(set) => set.iter().any(|e| e == agent),
        _ => false,
    })
}

fn observes(view: View<'_>, domain: &Domain, agent: EntityId, value: SlotId) -> bool {
    let Some(rule) = domain.beliefs.as_ref().and_then(|b| b.observes.as_ref()) else {
        return false;
    };
    let changed = domain.slots[value.index()].entity;
    if let Some(ty) = rule.ty
        && !domain.types[ty.index()].entities.contains(&changed)
    {
        return false;
    }
    let mut frame = vec![Value::Null; rule.n_vars.max(2)];
    (frame[0], frame[1]) = (Value::Entity(agent), Value::Entity(changed));
    view.holds(&rule.body, &mut frame)
}
