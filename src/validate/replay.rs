//! Does the plan's actions one by one, symbols and motions together.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use indexmap::IndexMap;
use rustc_hash::FxHashMap;

use super::{
    Settings, Verdict,
    beliefs::{apply_noting, learn},
    bodies::Bodies,
    evaluate::{Around, Touched, View, apply},
    fault::{Checked, Fault, Kind},
    geometric::Played,
    handling,
    history::History,
    navigation::Journey,
    requests::{self, Asked},
    schedule::Done,
    shared::Shared,
};
use crate::ir::{self, Domain, SlotId, Value};
use crate::plan::{Action, Geometry, Plan};
use crate::world::{State, World};

/// The plan, done.
pub(super) struct Replay<'a> {
    pub(super) states: History,
    /// The world before each action, and the last one.
    pub(super) worlds: Vec<Rc<Asked<'a>>>,
    pub(super) done: Vec<Done>,
}

/// What changes during a replay.
struct Progress<'a, 'v> {
    state: State,
    /// The same, to be asked.
    asked: Rc<Asked<'a>>,
    shared: Shared<'a>,
    verdict: &'v mut Verdict,
}

/// What an action leaves.
struct Outcome {
    /// The slots that may have another value now.
    written: BTreeSet<SlotId>,
    /// The shared attributes, if it was projected.
    shared: Option<Vec<(SlotId, Value)>>,
    /// How the plan takes unclear answers in its effects.
    lenient: bool,
}

/// What stays the same during a replay.
struct Context<'a> {
    domain: &'a Domain,
    bodies: &'a Bodies<'a>,
    start: &'a State,
    settings: &'a Settings,
    /// By the name that the changes of an action have.
    slots: FxHashMap<String, SlotId>,
}

/// Replays all actions.
pub(super) fn run<'a>(
    plan: &Plan,
    domain: &'a Domain,
    world: &'a World,
    bodies: &'a Bodies<'a>,
    settings: &'a Settings,
    actions: &[ir::Goal],
    verdict: &mut Verdict,
) -> Checked<Replay<'a>> {
    let (context, mut values, mut progress) = begin(domain, world, bodies, settings, true, verdict)?;
    let mut replay = Replay {
        states: History::new(&values),
        worlds: vec![progress.asked.clone()],
        done: Vec::with_capacity(actions.len()),
    };
    for (index, (action, goal)) in plan.actions.iter().zip(actions).enumerate() {
        let (written, done) = context.act(action, goal, &mut values, &mut progress).map_err(|f| {
            f.later_by(action.start)
                .at_time(action.start)
                .in_action(index, &text(action))
        })?;
        for slot in written {
            replay.states.note(index + 1, slot, &values[slot.index()]);
        }
        replay.worlds.push(progress.asked.clone());
        replay.done.push(done);
        progress.verdict.actions += 1;
    }
    Ok(replay)
}

/// Plays the actions' motions from the world's start, and takes their effects as this domain has them; preconditions and
/// what the actions claim to change, to cost and to last are not looked at.
pub(super) fn play(
    kept: &[Action],
    domain: &Domain,
    world: &World,
    bodies: &Bodies<'_>,
    settings: &Settings,
    actions: &[ir::Goal],
) -> Checked<()> {
    let mut verdict = Verdict::default();
    let operators = kept
        .iter()
        .zip(actions)
        .map(|(action, goal)| operator(domain, goal, action));
    let operators = operators.collect::<Checked<Vec<_>>>()?;
    // Facts are costly, and most actions read none where it matters here.
    let asks = operators.iter().any(|o| reads_facts(domain, o));
    let (context, mut values, mut progress) = begin(domain, world, bodies, settings, asks, &mut verdict)?;
    for (index, ((action, goal), operator)) in kept.iter().zip(actions).zip(operators).enumerate() {
        let mut frame = goal.args.clone();
        frame.resize(operator.n_vars.max(frame.len()), Value::Null);
        let before = progress.asked.clone();
        let view = View::new(domain, &values, Some(&before));
        let geometric = context
            .move_along(operator, action, view, &mut frame, &mut progress)
            .map_err(|f| {
                f.later_by(action.start)
                    .at_time(action.start)
                    .in_action(index, &text(action))
            })?;
        let around = Around {
            geometric,
            ..Around::new(domain, Some(&before))
        };
        let written = apply_noting(around, &mut values, operator, &mut frame);
        if asks && action.geometry.is_some() {
            let Progress {
                state,
                asked,
                shared,
                verdict,
            } = &mut progress;
            shared.read_start(state, asked, &mut values, verdict)?;
        }
        let around = Around::new(domain, Some(&progress.asked));
        let args = frame.get(..operator.params.len()).unwrap_or_default();
        learn(around, &mut values, operator, args, &written);
    }
    Ok(())
}

/// Says whether the arguments of an action's projection, its constraints, its effects or those who see it read a shared
/// attribute.
fn reads_facts(domain: &Domain, operator: &ir::Action) -> bool {
    let mut is_shared = |e: &ir::Expr| matches!(e, ir::Expr::Attribute { attribute, .. } if domain.attributes[attribute.index()].fact.is_some());
    let args = operator.projects.iter().flat_map(|p| &p.args);
    let observes = domain.beliefs.as_ref().and_then(|b| b.observes.as_ref());
    args.clone().any(|a| a.any(&mut is_shared))
        || operator.constraints.any(&mut is_shared)
        || observes.is_some_and(|o| o.body.any(&mut is_shared))
        || operator.effects.iter().any(|e| e.any(&mut is_shared))
}

/// Returns what stays the same, the symbolic state at the start, with its facts or without, and what changes.
fn begin<'a, 'v>(
    domain: &'a Domain,
    world: &'a World,
    bodies: &'a Bodies<'a>,
    settings: &'a Settings,
    asks: bool,
    verdict: &'v mut Verdict,
) -> Checked<(Context<'a>, Vec<Value>, Progress<'a, 'v>)> {
    let slots = (0..domain.slots.len()).map(|i| SlotId(i as u32));
    let context = Context {
        domain,
        bodies,
        start: &world.start,
        settings,
        slots: slots.map(|slot| (domain.slot_name(slot), slot)).collect(),
    };
    let mut state = world.start.clone();
    for agent in 0..state.agents.len() {
        bodies.carry(&mut state, agent);
    }
    let asked = Rc::new(Asked::new(bodies, state.clone(), settings));
    let mut shared = Shared::new(domain, bodies, settings)?;
    let mut values = domain.initial.clone();
    if asks {
        shared.read_start(&state, &asked, &mut values, verdict)?;
    }
    let progress = Progress {
        state,
        asked,
        shared,
        verdict,
    };
    Ok((context, values, progress))
}

fn operator<'a>(domain: &'a Domain, goal: &ir::Goal, action: &Action) -> Checked<&'a ir::Action> {
    match goal.task {
        ir::TaskId::Action(id) => Ok(&domain.actions[id.index()]),
        ir::TaskId::Method(_) => Err(Kind::UnknownName {
            what: "action",
            name: action.name.to_string(),
        }
        .into()),
    }
}

fn text(action: &Action) -> String {
    format!("{}({})", action.name, action.arguments.join(", "))
}

/// Says whether two values are the same length but for rounding: distances are computed twice.
fn same_number(a: Option<&str>, b: Option<&str>) -> bool {
    let number = |text: Option<&str>| text.and_then(|t| t.parse::<f64>().ok());
    matches!((number(a), number(b)), (Some(a), Some(b)) if (a - b).abs() <= requests::ROUNDING)
}

/// Runs an action's effects; returns what they touched.
fn effects(around: Around<'_>, values: &mut [Value], operator: &ir::Action, frame: &mut [Value]) -> Touched {
    let touched = RefCell::new(Touched::default());
    let around = Around {
        touched: Some(&touched),
        ..around
    };
    apply(around, values, &operator.effects, frame);
    touched.into_inner()
}

impl Touched {
    /// Returns what each written slot was at first.
    fn was(&self) -> BTreeMap<SlotId, Value> {
        let mut was = BTreeMap::new();
        for (slot, old) in self.writes.iter().zip(&self.before) {
            was.entry(*slot).or_insert_with(|| old.clone());
        }
        was
    }

    /// Returns what each written slot is now.
    fn now(&self, values: &[Value]) -> BTreeMap<SlotId, Value> {
        let slots = self.writes.iter();
        slots.map(|slot| (*slot, values[slot.index()].clone())).collect()
    }

    /// Takes back what was written.
    fn undo(&self, values: &mut [Value]) {
        for (slot, old) in self.writes.iter().zip(&self.before).rev() {
            values[slot.index()] = old.clone();
        }
    }
}

impl<'a> Context<'a> {
    /// Does one action and returns which slots it may have changed. Times of faults count from its start.
    fn act(
        &self,
        action: &Action,
        goal: &ir::Goal,
        values: &mut [Value],
        progress: &mut Progress<'a, '_>,
    ) -> Checked<(BTreeSet<SlotId>, Done)> {
        let domain = self.domain;
        let operator = operator(domain, goal, action)?;
        let mut frame = goal.args.clone();
        frame.resize(operator.n_vars.max(frame.len()), Value::Null);
        let world_before = progress.asked.clone();
        let view = View::new(domain, values, Some(&world_before));
        if let Some(test) = view.failing(&operator.preconditions, &mut frame) {
            return Err(Kind::Precondition { test }.into());
        }
        let geometric = self.move_along(operator, action, view, &mut frame, progress)?;
        let around = Around {
            geometric,
            ..Around::new(domain, Some(&world_before))
        };
        let view = View { around, ..view };
        self.cost_and_duration(operator, action, view, &frame)?;
        let end = action.geometry.as_ref().map_or(action.duration[0], |_| geometric.1);
        self.outcome(operator, action, around, &mut frame, values, progress)
            .map(|outcome| {
                let done = Done {
                    goal: goal.clone(),
                    geometric,
                    lenient: outcome.lenient,
                    shared: outcome.shared,
                };
                (outcome.written, done)
            })
            .map_err(|f| f.at_time(end))
    }

    /// Plays an action's motions, if it has to have any, and tests what must hold where they lead to; returns the cost that
    /// geometry gave it and how long they take [s].
    fn move_along(
        &self,
        operator: &ir::Action,
        action: &Action,
        view: View<'_>,
        frame: &mut [Value],
        progress: &mut Progress<'a, '_>,
    ) -> Checked<(f64, f64)> {
        match (&operator.projects, &action.geometry) {
            (None, None) => Ok((0.0, 0.0)),
            (None, Some(_)) => Err(Kind::GeometryUnexpected {}.into()),
            (Some(projection), None) => Err(Kind::GeometryMissing {
                projection: projection.name.clone(),
            }
            .into()),
            (Some(projection), Some(geometry)) => {
                let args: Vec<Value> = projection
                    .args
                    .iter()
                    .map(|a| view.value(a, frame).unwrap_or_default())
                    .collect();
                self.project(projection, &args, geometry, progress)?;
                let duration = geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
                progress.asked = Rc::new(Asked::new(self.bodies, progress.state.clone(), self.settings));
                let after = View {
                    around: Around::new(self.domain, Some(&progress.asked)),
                    values: view.values,
                };
                if let Some(test) = after.failing(&operator.constraints, frame) {
                    return Err(Fault::from(Kind::Constraint { test }).at_time(duration));
                }
                Ok((geometry.cost_parts.values().sum(), duration))
            }
        }
    }

    /// Applies the effects, reads the shared attributes, and compares with the changes listed. Looks at nothing but what is
    /// written or listed: a state may be large, and a plan long.
    fn outcome(
        &self,
        operator: &ir::Action,
        action: &Action,
        around: Around<'_>,
        frame: &mut [Value],
        values: &mut [Value],
        progress: &mut Progress<'a, '_>,
    ) -> Checked<Outcome> {
        let domain = self.domain;
        let Progress {
            state,
            asked,
            shared,
            verdict,
        } = progress;
        let guessed = shared.guesses();
        let shared_before = action.geometry.as_ref().map(|_| shared.snapshot(values));
        let listed: Vec<SlotId> = action
            .changes
            .iter()
            .filter_map(|(name, _)| self.slots.get(&**name))
            .copied()
            .collect();
        let mut lenient = true;
        let mut done = effects(Around { lenient, ..around }, values, operator, frame);
        // Where an effect rests on an unclear answer, the changes listed say how the plan has taken it.
        if done.asks {
            let taken = done.now(values);
            done.undo(values);
            let strict = effects(
                Around {
                    lenient: false,
                    ..around
                },
                values,
                operator,
                frame,
            );
            let was = strict.was();
            let is_listed = was.keys().chain(&listed).all(|slot| {
                let now = domain.show(&values[slot.index()]);
                let place = &domain.slots[slot.index()];
                let is_shared = domain.attributes[place.attribute.index()].fact.is_some();
                // Beliefs follow when all has been read.
                is_shared
                    || domain.believer(*slot).is_some()
                    || match action.changes.get(&domain.slot_name(*slot)) {
                        Some(text) => **text == *now,
                        None => domain.show(was.get(slot).unwrap_or(&values[slot.index()])) == now,
                    }
            });
            if taken != strict.now(values) && is_listed {
                (lenient, done) = (false, strict);
            } else {
                strict.undo(values);
                done = effects(Around { lenient, ..around }, values, operator, frame);
            }
        }
        let mut was = done.was();
        let read = match &shared_before {
            Some(before) => {
                shared.read(state, asked, before, values, &action.changes, verdict)?;
                was.extend(before.iter().cloned());
                Some(shared.snapshot(values))
            }
            None => None,
        };
        let learned = RefCell::new(Touched::default());
        let learning = Around {
            lenient,
            touched: Some(&learned),
            ..around
        };
        let args = frame.get(..operator.params.len()).unwrap_or_default();
        learn(learning, values, operator, args, &done.writes);
        for (slot, old) in learned.into_inner().was() {
            was.entry(slot).or_insert(old);
        }
        let written: BTreeSet<SlotId> = was.keys().copied().collect();
        let looked_at: BTreeSet<SlotId> = written.iter().chain(&listed).chain(&guessed).copied().collect();
        let mut expected = IndexMap::new();
        for slot in looked_at {
            let name = domain.slot_name(slot);
            let now = domain.show(&values[slot.index()]);
            // A guess about the start may have hidden a change, or made one up.
            if guessed.contains(&slot) {
                if action.changes.get(&name).is_some() {
                    shared.settle(slot);
                    expected.insert(name, now);
                }
                continue;
            }
            if was.get(&slot).is_some_and(|was| domain.show(was) != now) {
                expected.insert(name, now);
            }
        }
        let names = expected.keys().map(String::as_str);
        for name in names.chain(action.changes.iter().map(|(name, _)| &**name)) {
            let wanted = expected.get(name).map(String::as_str);
            let found = action.changes.get(name).map(|text| &**text);
            if wanted != found && !same_number(wanted, found) {
                return Err(Kind::Changes {
                    attribute: name.to_owned(),
                    expected: wanted.unwrap_or("unchanged").to_owned(),
                    found: found.unwrap_or("unchanged").to_owned(),
                }
                .into());
            }
        }
        Ok(Outcome {
            written,
            shared: read,
            lenient,
        })
    }

    fn cost_and_duration(
        &self,
        operator: &ir::Action,
        action: &Action,
        view: View<'_>,
        frame: &[Value],
    ) -> Checked<()> {
        let differ = |a: f64, b: f64| (a - b).abs() > self.settings.time_tolerance * a.abs().max(1.0);
        let cost = view.number(&operator.cost, frame).ok_or(Kind::CostUndefined {})?;
        if cost < 0.0 {
            return Err(Kind::CostNegative { cost }.into());
        }
        if differ(cost, action.cost) {
            return Err(Kind::Cost {
                expected: cost,
                found: action.cost,
            }
            .into());
        }
        let end = |e: &ir::Expr| view.number(e, frame).ok_or(Kind::DurationUndefined {});
        let (least, most) = (end(&operator.duration.0)?, end(&operator.duration.1)?);
        // What moves takes at least as long as its motions.
        let expected = [least.max(view.around.geometric.1), most.max(view.around.geometric.1)];
        let [found_least, found_most] = action.duration;
        let disorder = !(0.0 <= least && least <= most);
        if disorder || differ(expected[0], found_least) || differ(expected[1], found_most) {
            return Err(Kind::Duration {
                expected,
                found: action.duration,
            }
            .into());
        }
        Ok(())
    }

    /// Checks the geometric action's choices against its arguments, and plays its motions.
    fn project(
        &self,
        projection: &ir::Projection,
        args: &[Value],
        geometry: &Geometry,
        progress: &mut Progress<'a, '_>,
    ) -> Checked<()> {
        let journey = Journey::new(
            self.domain,
            self.bodies,
            self.settings,
            &projection.name,
            args,
            geometry,
        )?;
        if let Some(journey) = journey {
            journey.play(&mut progress.state, progress.verdict)?;
            return self.nothing_in_the_air(geometry, progress);
        }
        let played = Played::new(self.domain, self.bodies, self.settings, projection, args, geometry)?;
        let states = played.play(&mut progress.state, progress.verdict)?;
        self.nothing_in_the_air(geometry, progress)?;
        played.demands(&states, progress.verdict)?;
        played.in_the_end(&progress.state, progress.verdict)
    }

    fn nothing_in_the_air(&self, geometry: &Geometry, progress: &Progress<'a, '_>) -> Checked<()> {
        if let Some(object) = handling::in_the_air(self.bodies, &progress.state, self.start) {
            let end: f64 = geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
            return Err(Fault::from(Kind::InTheAir { object }).at_time(end));
        }
        Ok(())
    }
}
