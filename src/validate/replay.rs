//! Does the plan's actions one by one, symbols and motions together.

use std::rc::Rc;

use indexmap::IndexMap;

use super::{
    Settings, Verdict,
    beliefs::{apply_noting, learn},
    bodies::{Bodies, Touching},
    evaluate::{Around, View},
    facts::{self, Status},
    fault::{Checked, Fault, Kind},
    handling::{self, Hand},
    motion::{self, Mover},
    requests::{self, Asked},
    schedule::Done,
    shared::Shared,
};
use crate::ir::{self, Domain, EntityId, SlotId, Value};
use crate::plan::{Action, AttachmentChange, Geometry, Motion, Plan};
use crate::world::{EntityRef, State, World};

/// How far `stack` may be off the middle of the support face [m].
const CENTRE: f64 = 0.001;

/// The plan, done.
pub(super) struct Replay<'a> {
    /// Symbolic state before each action, and the last one.
    pub(super) states: Vec<Vec<Value>>,
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
    values: Vec<Value>,
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
    let (context, values, mut progress) = begin(domain, world, bodies, settings, true, verdict)?;
    let mut replay = Replay {
        states: vec![values],
        worlds: vec![progress.asked.clone()],
        done: Vec::with_capacity(actions.len()),
    };
    for (index, (action, goal)) in plan.actions.iter().zip(actions).enumerate() {
        let before = replay.states[index].clone();
        let (values, done) = context.act(action, goal, &before, &mut progress).map_err(|f| {
            f.later_by(action.start)
                .at_time(action.start)
                .in_action(index, &text(action))
        })?;
        replay.states.push(values);
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
    let context = Context {
        domain,
        bodies,
        start: &world.start,
        settings,
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
            name: action.name.clone(),
        }
        .into()),
    }
}

fn text(action: &Action) -> String {
    format!("{}({})", action.name, action.arguments.join(", "))
}

/// Says whether two values are the same length but for rounding: distances are computed twice.
fn same_number(a: Option<&String>, b: Option<&String>) -> bool {
    let number = |text: Option<&String>| text.and_then(|t| t.parse::<f64>().ok());
    matches!((number(a), number(b)), (Some(a), Some(b)) if (a - b).abs() <= requests::ROUNDING)
}

impl<'a> Context<'a> {
    /// Does one action and returns the symbolic state after it. Times of faults count from its start.
    fn act(
        &self,
        action: &Action,
        goal: &ir::Goal,
        before: &[Value],
        progress: &mut Progress<'a, '_>,
    ) -> Checked<(Vec<Value>, Done)> {
        let domain = self.domain;
        let operator = operator(domain, goal, action)?;
        let mut frame = goal.args.clone();
        frame.resize(operator.n_vars.max(frame.len()), Value::Null);
        let world_before = progress.asked.clone();
        let view = View::new(domain, before, Some(&world_before));
        if let Some(test) = view.failing(&operator.preconditions, &mut frame) {
            return Err(Kind::Precondition { test }.into());
        }
        let geometric = self.move_along(operator, action, view, &mut frame, progress)?;
        let around = Around {
            geometric,
            ..view.around
        };
        let view = View { around, ..view };
        self.cost_and_duration(operator, action, view, &frame)?;
        let end = action.geometry.as_ref().map_or(action.duration[0], |_| geometric.1);
        self.outcome(operator, action, view, &mut frame, progress)
            .map(|outcome| {
                let done = Done {
                    goal: goal.clone(),
                    geometric,
                    lenient: outcome.lenient,
                    shared: outcome.shared,
                };
                (outcome.values, done)
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
                self.project(&projection.name, &args, geometry, progress)?;
                let duration = geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
                progress.asked = Rc::new(Asked::new(self.bodies, progress.state.clone(), self.settings));
                let after = View::new(self.domain, view.values, Some(&progress.asked));
                if let Some(test) = after.failing(&operator.constraints, frame) {
                    return Err(Fault::from(Kind::Constraint { test }).at_time(duration));
                }
                Ok((geometry.cost_parts.values().sum(), duration))
            }
        }
    }

    /// Applies the effects, reads the shared attributes, and compares with the changes listed.
    fn outcome(
        &self,
        operator: &ir::Action,
        action: &Action,
        view: View<'_>,
        frame: &mut [Value],
        progress: &mut Progress<'a, '_>,
    ) -> Checked<Outcome> {
        let (domain, before) = (self.domain, view.values);
        let Progress {
            state,
            asked,
            shared,
            verdict,
        } = progress;
        let guessed: Vec<bool> = (0..domain.slots.len())
            .map(|i| shared.is_guess(SlotId(i as u32)))
            .collect();
        // Where an effect rests on an unclear answer, the changes listed say how the plan has taken it.
        let mut done = [true, false].map(|lenient| {
            let around = Around { lenient, ..view.around };
            let mut values = before.to_vec();
            let written = apply_noting(around, &mut values, operator, frame);
            (lenient, values, written)
        });
        let is_listed = |values: &[Value]| {
            domain.slots.iter().enumerate().all(|(i, slot)| {
                let (now, was) = (domain.show(&values[i]), domain.show(&before[i]));
                let listed = action.changes.get(&domain.slot_name(SlotId(i as u32)));
                let is_apart = domain.attributes[slot.attribute.index()].fact.is_some();
                // Beliefs follow when all has been read.
                is_apart || domain.believer(SlotId(i as u32)).is_some() || listed.unwrap_or(&was) == &now
            })
        };
        if done[0].1 != done[1].1 && is_listed(&done[1].1) {
            done.swap(0, 1);
        }
        let [(lenient, mut values, written), _] = done;
        let read = if action.geometry.is_some() {
            shared.read(state, asked, before, &mut values, &action.changes, verdict)?;
            Some(shared.snapshot(&values))
        } else {
            None
        };
        let args = frame.get(..operator.params.len()).unwrap_or_default();
        learn(Around { lenient, ..view.around }, &mut values, operator, args, &written);
        let mut expected = IndexMap::new();
        for i in 0..domain.slots.len() {
            let name = domain.slot_name(SlotId(i as u32));
            let listed = action.changes.get(&name);
            // A guess about the start may have hidden a change, or made one up.
            if guessed[i] {
                if listed.is_some() {
                    shared.settle(SlotId(i as u32));
                    expected.insert(name, domain.show(&values[i]));
                }
                continue;
            }
            let (now, was) = (domain.show(&values[i]), domain.show(&before[i]));
            if now != was {
                expected.insert(name, now);
            }
        }
        let none = "unchanged".to_owned();
        for name in expected.keys().chain(action.changes.keys()) {
            let (wanted, found) = (expected.get(name), action.changes.get(name));
            if wanted != found && !same_number(wanted, found) {
                return Err(Kind::Changes {
                    attribute: name.clone(),
                    expected: wanted.unwrap_or(&none).clone(),
                    found: found.unwrap_or(&none).clone(),
                }
                .into());
            }
        }
        Ok(Outcome {
            values,
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

    fn entity(&self, value: Option<&Value>) -> Option<EntityRef> {
        let Some(Value::Entity(EntityId(e))) = value else {
            return None;
        };
        self.bodies.scene.find(&self.domain.entities[*e as usize].name)
    }

    /// Checks the geometric action's choices against its arguments, and plays its motions.
    fn project(&self, name: &str, args: &[Value], geometry: &Geometry, progress: &mut Progress<'a, '_>) -> Checked<()> {
        // The thesis's name for it.
        let name = if name == "placeR" { "placeReachable" } else { name };
        let same = |what: &'static str, expected: &str, found: &str| {
            if expected == found {
                Ok(())
            } else {
                Err(Fault::from(Kind::GeometryMismatch {
                    what,
                    expected: expected.to_owned(),
                    found: found.to_owned(),
                }))
            }
        };
        same("geometric action", name, &geometry.action)?;
        let arity = match name {
            "pick" => 2,
            "place" | "stack" => 3,
            "placeReachable" => 4,
            _ => {
                return Err(Kind::GeometryUnchecked {
                    action: name.to_owned(),
                }
                .into());
            }
        };
        if args.len() != arity {
            return Err(Kind::ArgumentCount {
                task: name.to_owned(),
                expected: arity,
                found: args.len(),
            }
            .into());
        }
        let shown: Vec<String> = args.iter().map(|a| self.domain.show(a)).collect();
        same("acting agent", &shown[0], &geometry.agent)?;
        same("handled object", &shown[1], &geometry.object)?;
        let unknown = |what: &'static str, name: &str| Kind::UnknownName {
            what,
            name: name.to_owned(),
        };
        let (Some(EntityRef::Agent(agent)), Some(EntityRef::Object(object))) =
            (self.entity(args.first()), self.entity(args.get(1)))
        else {
            return Err(unknown(
                "agent with an object in the world",
                &format!("{}, {}", shown[0], shown[1]),
            )
            .into());
        };
        let arms = &self.bodies.scene.agents[agent].arms;
        let arm = arms.iter().position(|a| a.name == geometry.arm);
        let hand = Hand {
            agent,
            arm: arm.ok_or_else(|| unknown("arm", &geometry.arm))?,
        };
        match (name, &geometry.placement) {
            ("pick", None) => {}
            ("pick", Some(_)) => {
                return Err(Kind::Handling {
                    what: "a pick has no placement".to_owned(),
                }
                .into());
            }
            (_, None) => {
                return Err(Kind::Handling {
                    what: format!("`{name}` needs a placement"),
                }
                .into());
            }
            (_, Some(placement)) => {
                same("support", &shown[2], &placement.on)?;
                let off = placement.x.abs().max(placement.y.abs());
                if name == "stack" && off > CENTRE {
                    return Err(Kind::Placement {
                        what: "x, y and yaw",
                        distance: off,
                        angle: 0.0,
                    }
                    .into());
                }
            }
        }
        self.moves(name, geometry, hand, object, progress)?;
        let end: f64 = geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
        if let Some(object) = handling::in_the_air(self.bodies, &progress.state, self.start) {
            return Err(Fault::from(Kind::InTheAir { object }).at_time(end));
        }
        if name == "placeReachable" {
            let Some(EntityRef::Agent(other)) = self.entity(args.get(3)) else {
                return Err(unknown("agent", &shown[3]).into());
            };
            let claim = facts::status(
                self.bodies,
                &progress.state,
                "isReachable",
                EntityRef::Object(object),
                EntityRef::Agent(other),
                Some(true),
                self.settings,
            );
            progress.verdict.facts += 1;
            if claim == Some(Status::Fails) {
                let fact = format!("isReachable({}, {})", shown[1], shown[3]);
                return Err(Fault::from(Kind::FactUnconfirmed { fact }).at_time(end));
            }
        }
        Ok(())
    }

    /// Plays the sub-actions.
    fn moves(
        &self,
        name: &str,
        geometry: &Geometry,
        hand: Hand,
        object: usize,
        progress: &mut Progress<'a, '_>,
    ) -> Checked<()> {
        let Progress { state, verdict, .. } = progress;
        let (mut time, mut taken, mut left) = (0.0, 0_usize, 0_usize);
        if name != "pick" {
            handling::holds(self.bodies, state, hand, object, &geometry.grasp).map_err(|f| f.at_time(0.0))?;
        }
        for (i, sub_action) in geometry.sub_actions.iter().enumerate() {
            // The hand comes near what it handles on a straight line, or with its fingers.
            let touching = (sub_action.motion != Motion::Free).then_some(Touching {
                agent: hand.agent,
                arm: hand.arm,
                object,
            });
            let mover = Mover {
                agent: hand.agent,
                arm: hand.arm,
                touching,
            };
            let place = |f: Fault| f.later_by(time).at_time(time).in_sub_action(i, &sub_action.name);
            motion::check(self.bodies, state, mover, sub_action, self.settings, verdict).map_err(place)?;
            let end = time + sub_action.trajectory.duration();
            let Some(change) = &sub_action.change else {
                time = end;
                continue;
            };
            let of = match change {
                AttachmentChange::Attach { object, .. } | AttachmentChange::Detach { object, .. } => object,
            };
            let changed = if *of == geometry.object {
                match change {
                    AttachmentChange::Attach { object_in_tool, .. } => {
                        taken += 1;
                        handling::attach(self.bodies, state, hand, object, object_in_tool, geometry)
                    }
                    AttachmentChange::Detach { object_in_world, .. } => {
                        left += 1;
                        handling::detach(self.bodies, state, hand, object, object_in_world, geometry)
                    }
                }
            } else {
                Err(Kind::GeometryMismatch {
                    what: "handled object",
                    expected: geometry.object.clone(),
                    found: of.clone(),
                }
                .into())
            };
            changed.map_err(|f| f.at_time(end).in_sub_action(i, &sub_action.name))?;
            verdict.attachments += 1;
            time = end;
        }
        let wanted = if name == "pick" { (1, 0) } else { (0, 1) };
        if (taken, left) != wanted {
            let fault = Kind::Handling {
                what: format!(
                    "`{name}` takes {} and lets go of {} objects, here it is {taken} and {left}",
                    wanted.0, wanted.1
                ),
            };
            return Err(Fault::from(fault).at_time(time));
        }
        Ok(())
    }
}
