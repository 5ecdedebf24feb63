//! Checks links, streams and times: the plan as a partial order, not as a list.
//!
//! Whether a link is missing is not derived from what actions read and write but tried out: each action is moved as
//! early and as late as the links allow, and the plan is run again. Symbolic state only: projected actions must stand
//! in one line by the links, so their geometry is the same in every order.

use std::rc::Rc;

use super::{
    Settings,
    evaluate::{Around, View, apply},
    fault::{Checked, Fault, Kind},
    requests::Asked,
};
use crate::ir::{Domain, Goal, SlotId, TaskId, Value};
use crate::plan::{Action, Plan};

/// What the replay has found of each action.
pub(super) struct Done {
    pub(super) goal: Goal,
    /// What geometry gave: cost and time.
    pub(super) geometric: (f64, f64),
    /// How the plan takes unclear answers in its effects.
    pub(super) lenient: bool,
    /// Shared attributes as read from geometry afterwards; `None` for an action without geometry.
    pub(super) shared: Option<Vec<(SlotId, Value)>>,
}

/// Checks everything about order and time.
pub(super) fn check(
    plan: &Plan,
    domain: &Domain,
    settings: &Settings,
    done: &[Done],
    worlds: &[Rc<Asked<'_>>],
    (first, last): (&[Value], &[Value]),
) -> Checked<()> {
    let n = plan.actions.len();
    for link in &plan.links {
        if link.before >= link.after || link.after >= n {
            return Err(Kind::LinkIndex {
                before: link.before,
                after: link.after,
            }
            .into());
        }
    }
    let text = |i: usize| {
        let action: &Action = &plan.actions[i];
        format!("{}({})", action.name, action.arguments.join(", "))
    };
    let named = |f: Fault, i: usize| f.in_action(i, &text(i));
    streams(plan)?;
    times(plan, settings).map_err(|(f, i)| match i {
        Some(i) => named(f, i),
        None => f,
    })?;

    let links: Vec<(usize, usize)> = plan.links.iter().map(|l| (l.before, l.after)).collect();
    let by_links = ancestors(n, &links);
    for (k, (before, after)) in links.iter().enumerate() {
        let around = links
            .iter()
            .enumerate()
            .any(|(j, (b, a))| j != k && a == after && (b == before || by_links[*b][*before]));
        if around {
            return Err(Kind::LinkRedundant {
                before: *before,
                after: *after,
            }
            .into());
        }
    }
    let mut all = links;
    for stream in plan.streams.values() {
        all.extend(stream.windows(2).map(|w| (w[0], w[1])));
    }
    let by_order = ancestors(n, &all);
    let projected: Vec<usize> = (0..n).filter(|i| done[*i].shared.is_some()).collect();
    for pair in projected.windows(2) {
        if !by_order[pair[1]][pair[0]] {
            let fault = Kind::MotionOrder {
                before: pair[0],
                after: pair[1],
            };
            return Err(named(fault.into(), pair[1]));
        }
    }
    let run = |order: &[usize]| linear(domain, done, worlds, first, order);
    for (x, before) in by_links.iter().enumerate() {
        let needed: Vec<usize> = (0..x).filter(|i| before[*i]).chain([x]).collect();
        if let Err((broken, condition)) = run(&needed)
            && broken == x
        {
            return Err(named(Kind::LinkMissing { after: x, condition }.into(), x));
        }
    }
    for (x, before) in by_order.iter().enumerate() {
        let early = (0..n).filter(|i| before[*i]).chain([x]);
        let early: Vec<usize> = early.chain((0..n).filter(|i| *i != x && !before[*i])).collect();
        let late = (0..n).filter(|i| *i != x && !by_order[*i][x]);
        let late: Vec<usize> = late.chain([x]).chain((0..n).filter(|i| by_order[*i][x])).collect();
        for order in [early, late] {
            match run(&order) {
                Err((broken, condition)) => {
                    let fault = Kind::LinkRace {
                        moved: x,
                        broken,
                        condition,
                    };
                    return Err(named(fault.into(), broken));
                }
                Ok(values) => {
                    if let Some(slot) = (0..values.len()).find(|s| values[*s] != last[*s]) {
                        let slot = &domain.slots[slot];
                        let fault = Kind::OutcomeRace {
                            moved: x,
                            attribute: super::slot_name(domain, slot),
                        };
                        return Err(named(fault.into(), x));
                    }
                }
            }
        }
    }
    Ok(())
}

/// Runs the actions in that order; the first whose precondition fails is returned with the failing test.
///
/// Requests ask the world that the last projected action left, `worlds` being those before each action, and the last one.
fn linear(
    domain: &Domain,
    done: &[Done],
    worlds: &[Rc<Asked<'_>>],
    first: &[Value],
    order: &[usize],
) -> Result<Vec<Value>, (usize, String)> {
    let mut values = first.to_vec();
    let mut world = 0;
    for i in order {
        let done = &done[*i];
        let TaskId::Action(id) = done.goal.task else {
            continue;
        };
        let action = &domain.actions[id.index()];
        let mut frame = done.goal.args.clone();
        frame.resize(action.n_vars.max(frame.len()), Value::Null);
        let asked = worlds.get(world).map(Rc::as_ref);
        let around = Around::new(domain, asked);
        let view = View {
            around,
            values: &values,
        };
        if let Some(test) = view.failing(&action.preconditions, &mut frame) {
            return Err((*i, test));
        }
        let around = Around {
            geometric: done.geometric,
            lenient: done.lenient,
            ..around
        };
        apply(around, &mut values, &action.effects, &mut frame);
        if done.shared.is_some() {
            world = i + 1;
        }
        for (slot, value) in done.shared.iter().flatten() {
            values[slot.index()] = value.clone();
        }
    }
    Ok(values)
}

/// Returns for each action which ones must be over before it starts.
fn ancestors(n: usize, edges: &[(usize, usize)]) -> Vec<Vec<bool>> {
    let mut table = vec![vec![false; n]; n];
    for after in 0..n {
        let mut row = vec![false; n];
        for (before, _) in edges.iter().filter(|(_, a)| *a == after) {
            row[*before] = true;
            // INVARIANT: edges go from smaller to larger indices, so the row of `before` is complete.
            for (r, b) in row.iter_mut().zip(&table[*before]) {
                *r |= b;
            }
        }
        table[after] = row;
    }
    table
}

fn streams(plan: &Plan) -> Checked<()> {
    let mut expected: indexmap::IndexMap<&str, Vec<usize>> = indexmap::IndexMap::new();
    for (i, action) in plan.actions.iter().enumerate() {
        for agent in &action.agents {
            expected.entry(agent).or_default().push(i);
        }
    }
    let empty = Vec::new();
    // An agent that does nothing may have an empty stream or none.
    let names = expected.keys().copied().chain(plan.streams.keys().map(String::as_str));
    for agent in names {
        let wanted = expected.get(agent).unwrap_or(&empty);
        let found = plan.streams.get(agent).unwrap_or(&empty);
        if wanted != found {
            return Err(Kind::Stream {
                agent: agent.to_owned(),
                expected: wanted.clone(),
                found: found.clone(),
            }
            .into());
        }
    }
    Ok(())
}

fn times(plan: &Plan, settings: &Settings) -> Result<(), (Fault, Option<usize>)> {
    let differ = |a: f64, b: f64| (a - b).abs() > settings.time_tolerance;
    let mut makespan = 0.0_f64;
    for (i, action) in plan.actions.iter().enumerate() {
        let linked = plan.links.iter().filter(|l| l.after == i).map(|l| l.before);
        let previous = plan.streams.values().filter_map(|s| {
            let at = s.iter().position(|k| *k == i)?;
            s.get(at.checked_sub(1)?).copied()
        });
        let start = linked
            .chain(previous)
            .filter_map(|k| plan.actions.get(k))
            .map(|a| a.end)
            .fold(0.0, f64::max);
        if differ(action.start, start) {
            let fault = Kind::Start {
                expected: start,
                found: action.start,
            };
            return Err((Fault::from(fault).at_time(action.start), Some(i)));
        }
        let end = action.start + action.duration[0];
        if differ(action.end, end) {
            let fault = Kind::End {
                expected: end,
                found: action.end,
            };
            return Err((Fault::from(fault).at_time(action.start), Some(i)));
        }
        makespan = makespan.max(action.end);
    }
    if differ(plan.makespan, makespan) {
        let fault = Kind::Makespan {
            expected: makespan,
            found: plan.makespan,
        };
        return Err((fault.into(), None));
    }
    Ok(())
}
