//! Checks links, streams and times: the plan as a partial order, not as a list.
//!
//! Whether a link is missing is not derived from what actions read and write but tried out: each action is moved as
//! early and as late as the links allow, and the plan is run again. Symbolic state only: projected actions must stand
//! in one line by the links, so their geometry is the same in every order.
//!
//! Trying out takes a time that grows with the square of the plan. So it is left out where it can't fail: where every
//! two actions of which one touches what the other writes, as a run of the plan shows, are in order anyway (Bernstein,
//! IEEE Trans. Electronic Computers 1966, doi:10.1109/PGEC.1966.264565).

use std::cell::RefCell;
use std::rc::Rc;

use super::{
    Settings,
    beliefs::{apply_noting, learn},
    evaluate::{Around, Touched, Values, View},
    fault::{Checked, Fault, Kind},
    precedence::{Precedence, by_later},
    requests::Asked,
};
use crate::ir::{Domain, Effect, Goal, SlotId, TaskId, Value};
use crate::plan::{Action, Link, LinkReason, Plan};

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

/// Lists what is right before each action by the links; `None` if one of them goes nowhere.
pub(super) fn by_links(plan: &Plan) -> Option<Vec<Vec<usize>>> {
    let n = plan.actions.len();
    let is_right = |l: &crate::plan::Link| l.before < l.after && l.after < n;
    let links: Vec<(usize, usize)> = plan.links.iter().map(|l| (l.before, l.after)).collect();
    plan.links.iter().all(is_right).then(|| by_later(n, &links))
}

/// Checks everything about order and time, but for the order that the domain gives to subtasks: see `ordered`.
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
    let links: Vec<(usize, usize)> = plan.links.iter().map(|l| (l.before, l.after)).collect();
    let mut all = links.clone();
    for stream in plan.streams.values() {
        all.extend(stream.windows(2).map(|w| (w[0], w[1])));
    }
    let (linked, ordered) = (by_later(n, &links), by_later(n, &all));
    times(plan, settings, &ordered).map_err(|(f, i)| match i {
        Some(i) => named(f, i),
        None => f,
    })?;

    let by_links = Precedence::new(&linked);
    for (before, after) in &links {
        let same = linked[*after].iter().filter(|b| *b == before).count();
        if same > 1 || linked[*after].iter().any(|b| by_links.has(*before, *b)) {
            return Err(Kind::LinkRedundant {
                before: *before,
                after: *after,
            }
            .into());
        }
    }
    let by_order = Precedence::new(&ordered);
    let projected: Vec<usize> = (0..n).filter(|i| done[*i].shared.is_some()).collect();
    for pair in projected.windows(2) {
        if !by_order.has(pair[0], pair[1]) {
            let fault = Kind::MotionOrder {
                before: pair[0],
                after: pair[1],
            };
            return Err(named(fault.into(), pair[1]));
        }
    }
    let all: Vec<usize> = (0..n).collect();
    let mut touched = Vec::with_capacity(n);
    // INVARIANT: in this order the replay has run the plan, so nothing fails.
    linear(domain, done, worlds, first, &all, Some(&mut touched)).map_err(|(broken, condition)| {
        let fault = Kind::LinkMissing {
            after: broken,
            condition,
        };
        named(fault.into(), broken)
    })?;
    for link in &plan.links {
        if let Some(reason) = unfounded(link, domain, done) {
            return Err(Kind::LinkReason {
                before: link.before,
                after: link.after,
                reason,
            }
            .into());
        }
    }
    let (links_suffice, order_suffices) = sufficient(domain, &touched, &by_links, &by_order);
    let run = |order: &[usize]| linear(domain, done, worlds, first, order, None);
    for x in (0..n).filter(|x| !links_suffice[*x]) {
        let needed: Vec<usize> = (0..x).filter(|i| by_links.has(*i, x)).chain([x]).collect();
        if let Err((broken, condition)) = run(&needed)
            && broken == x
        {
            return Err(named(Kind::LinkMissing { after: x, condition }.into(), x));
        }
    }
    if order_suffices {
        return Ok(());
    }
    for x in 0..n {
        let before = |i: &usize| by_order.has(*i, x);
        let early = (0..n).filter(before).chain([x]);
        let early: Vec<usize> = early.chain((0..n).filter(|i| *i != x && !before(i))).collect();
        let late = (0..n).filter(|i| *i != x && !by_order.has(x, *i));
        let late: Vec<usize> = late.chain([x]).chain((0..n).filter(|i| by_order.has(x, *i))).collect();
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
                        let fault = Kind::OutcomeRace {
                            moved: x,
                            attribute: domain.slot_name(SlotId(slot as u32)),
                        };
                        return Err(named(fault.into(), x));
                    }
                }
            }
        }
    }
    Ok(())
}

/// Returns a reason of a link that its actions can't bear out, or that there is none. Not looked at is what actions read, since a
/// test may be decided by the half of it, and the order of the domain.
fn unfounded(link: &Link, domain: &Domain, done: &[Done]) -> Option<String> {
    // An effect that changes nothing has still to come after those who look at the attribute.
    let may_set = |action: usize, slot: &str| {
        let TaskId::Action(id) = done[action].goal.task else {
            return true;
        };
        let attribute = slot.split_once('.').map_or(slot, |(_, rest)| rest);
        let attribute = attribute.split_once('(').map_or(attribute, |(name, _)| name);
        let effects = &domain.actions[id.index()].effects;
        attribute == "believes" || done[action].shared.is_some() || writes(domain, effects, attribute)
    };
    if link.reasons.is_empty() {
        return Some("none is given".into());
    }
    link.reasons.iter().find_map(|reason| match reason {
        LinkReason::Attribute(slot) => {
            (!may_set(link.before, slot)).then(|| format!("action {} never sets `{slot}`", link.before))
        }
        LinkReason::Threat(slot) => {
            (!may_set(link.after, slot)).then(|| format!("action {} never sets `{slot}`", link.after))
        }
        LinkReason::Motion => {
            let is_still = |i: &usize| done[*i].shared.is_none();
            let still = [link.before, link.after].into_iter().find(is_still)?;
            Some(format!("action {still} has no motion"))
        }
        LinkReason::Order => None,
    })
}

/// Says whether effects speak of an attribute of that name.
fn writes(domain: &Domain, effects: &[Effect], name: &str) -> bool {
    effects.iter().any(|effect| match effect {
        Effect::Assign { attribute, .. } | Effect::Add { attribute, .. } | Effect::Remove { attribute, .. } => {
            domain.attributes[attribute.index()].name == name
        }
        Effect::Forall { effects, .. } => writes(domain, effects, name),
        Effect::If { then, otherwise, .. } => writes(domain, then, name) || writes(domain, otherwise, name),
    })
}

/// Says for each action whether all that it reads was written by actions which it comes after by the links alone, and
/// whether the same is true of all that it comes after; and whether links and streams put all accesses in order. Then
/// another order changes nothing.
fn sufficient(domain: &Domain, touched: &[Touched], links: &Precedence, order: &Precedence) -> (Vec<bool>, bool) {
    // Behind the slots, the world.
    let n_slots = domain.slots.len();
    let mut last_writer: Vec<Option<usize>> = vec![None; n_slots + 1];
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); n_slots + 1];
    let (mut by_links, mut in_order) = (Vec::with_capacity(touched.len()), true);
    for (x, touched) in touched.iter().enumerate() {
        let slots = |slots: &[SlotId], world: bool| -> Vec<usize> {
            let mut all: Vec<usize> = slots
                .iter()
                .map(|s| s.index())
                .chain(world.then_some(n_slots))
                .collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (reads, writes) = (
            slots(&touched.reads, touched.asks),
            slots(&touched.writes, touched.moves),
        );
        let writers = reads.iter().filter_map(|slot| last_writer[*slot]);
        let above = links.right_before(x).iter().all(|b| by_links[*b]);
        by_links.push(above && writers.clone().all(|w| links.has(w, x)));
        in_order = in_order && writers.clone().all(|w| order.has(w, x));
        for slot in &writes {
            let read = std::mem::take(&mut readers[*slot]);
            let written = last_writer[*slot].replace(x);
            in_order = in_order && read.into_iter().chain(written).all(|y| order.has(y, x));
        }
        for slot in reads {
            if last_writer[slot] != Some(x) {
                readers[slot].push(x);
            }
        }
    }
    (by_links, in_order)
}

/// Runs the actions in that order; the first whose precondition fails is returned with the failing test. What each one
/// touches is added to `touched`.
///
/// Requests ask the world that the last projected action left, `worlds` being those before each action, and the last one.
fn linear(
    domain: &Domain,
    done: &[Done],
    worlds: &[Rc<Asked<'_>>],
    first: &[Value],
    order: &[usize],
    mut touched: Option<&mut Vec<Touched>>,
) -> Result<Vec<Value>, (usize, String)> {
    let mut values = first.to_vec();
    let mut world = 0;
    for i in order {
        let done = &done[*i];
        let TaskId::Action(id) = done.goal.task else {
            if let Some(touched) = &mut touched {
                touched.push(Touched::default());
            }
            continue;
        };
        let seen = RefCell::new(Touched::default());
        let action = &domain.actions[id.index()];
        let mut frame = done.goal.args.clone();
        frame.resize(action.n_vars.max(frame.len()), Value::Null);
        let asked = worlds.get(world).map(Rc::as_ref);
        let around = Around {
            touched: touched.is_some().then_some(&seen),
            ..Around::new(domain, asked)
        };
        let view = View {
            around,
            values: Values::Now(&values),
        };
        if let Some(test) = view.failing(&action.preconditions, &mut frame) {
            return Err((*i, test));
        }
        let around = Around {
            geometric: done.geometric,
            lenient: done.lenient,
            ..around
        };
        let written = apply_noting(around, &mut values, action, &mut frame);
        if done.shared.is_some() {
            world = i + 1;
        }
        for (slot, value) in done.shared.iter().flatten() {
            values[slot.index()] = value.clone();
        }
        learn(around, &mut values, action, &done.goal.args, &written);
        if let Some(touched) = &mut touched {
            let mut seen = seen.into_inner();
            seen.before = Vec::new();
            seen.moves = done.shared.is_some();
            seen.writes.extend(done.shared.iter().flatten().map(|(slot, _)| *slot));
            touched.push(seen);
        }
    }
    Ok(values)
}

fn streams(plan: &Plan) -> Checked<()> {
    let mut expected: indexmap::IndexMap<&str, Vec<usize>> = indexmap::IndexMap::new();
    for (i, action) in plan.actions.iter().enumerate() {
        for agent in &action.agents {
            expected.entry(&**agent).or_default().push(i);
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

/// `before` lists what comes right before each action by links and streams.
fn times(plan: &Plan, settings: &Settings, before: &[Vec<usize>]) -> Result<(), (Fault, Option<usize>)> {
    let differ = |a: f64, b: f64| (a - b).abs() > settings.time_tolerance;
    let mut makespan = 0.0_f64;
    for (i, action) in plan.actions.iter().enumerate() {
        let start = before[i]
            .iter()
            .filter_map(|k| plan.actions.get(*k))
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
