//! Plays the motions of a geometric action, and checks that they are what its description in the language demands.
//!
//! Knows no action by name: the description says which sub-actions there are, what moves, where each ends, what changes hands
//! and which facts hold. Where a sub-action ends is worked out here from the document's choices, with kinematics alone.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::{
    Settings, Verdict,
    bodies::{Bodies, Touching},
    fault::{Checked, Fault, Kind},
    handling::{self, GRASP, Hand, between, exceeds},
    motion::{self, Mover},
    requests::{Answer, Asked},
};
use crate::geom::Pose;
use crate::ir::geometric::{Change, ChoiceSet, Condition, FactOf, Geometric, Space, Target};
use crate::ir::{ChoiceId, Domain, ParamId, Projection, Value};
use crate::plan::{AttachmentChange, Geometry, Motion, SubAction};
use crate::world::{EntityRef, Gripper, State};

/// How far from the middle of a face something may be that has to stand there [m].
const CENTRE: f64 = 0.001;
/// How far a straight motion may miss its end ([m], [rad]), against how far up or back it goes.
const SHIFT: (f64, f64) = (0.002, 0.02);
/// How far a finger may be from where it shall be [rad or m]; for what is held there is a test of its own.
const FINGER: f64 = 1e-3;

/// How far a number of a placement may be from the one that the domain gives [m or rad].
const GIVEN: f64 = 1e-9;

/// A geometric action with its arguments, at work.
pub(super) struct Played<'a, 'b> {
    pub(super) domain: &'a Domain,
    pub(super) bodies: &'a Bodies<'a>,
    pub(super) settings: &'a Settings,
    action: &'a Geometric,
    args: &'b [Value],
    geometry: &'b Geometry,
    hand: Hand,
    object: usize,
}

impl<'a, 'b> Played<'a, 'b> {
    /// Checks the document's choices against the call.
    pub(super) fn new(
        domain: &'a Domain,
        bodies: &'a Bodies<'a>,
        settings: &'a Settings,
        projection: &Projection,
        args: &'b [Value],
        geometry: &'b Geometry,
    ) -> Checked<Self> {
        let name = &projection.name;
        let (args, given) = args.split_at(args.len().saturating_sub(projection.given.len()));
        let unchecked = || Kind::GeometryUnchecked { action: name.clone() };
        let action = domain.geometric(name).ok_or_else(unchecked)?;
        same("geometric action", &action.name, &geometry.action)?;
        if args.len() != action.params.len() {
            return Err(Kind::ArgumentCount {
                task: action.name.clone(),
                expected: action.params.len(),
                found: args.len(),
            }
            .into());
        }
        let shown: Vec<String> = args.iter().map(|a| domain.show(a)).collect();
        let mut entities = Vec::new();
        for (arg, shown) in args.iter().zip(&shown) {
            let entity = match arg {
                Value::Entity(e) => bodies.scene.find(&domain.entities[e.index()].name),
                _ => None,
            };
            entities.push(entity.ok_or_else(|| unknown("entity of the world", shown))?);
        }
        let agent = param(action, |from| match from {
            ChoiceSet::Arms(agent) => Some(agent),
            _ => None,
        });
        let agent = agent.ok_or_else(unchecked)?;
        let object = handled(action).ok_or_else(unchecked)?;
        same("acting agent", &shown[agent.index()], &geometry.agent)?;
        same("handled object", &shown[object.index()], &geometry.object)?;
        let (EntityRef::Agent(agent), EntityRef::Object(object)) = (entities[agent.index()], entities[object.index()])
        else {
            return Err(unknown(
                "agent with an object in the world",
                &format!("{}, {}", shown[agent.index()], shown[object.index()]),
            )
            .into());
        };
        let arms = &bodies.scene.agents[agent].arms;
        let arm = arms.iter().position(|a| a.name == geometry.arm);
        let hand = Hand {
            agent,
            arm: arm.ok_or_else(|| unknown("arm", &geometry.arm))?,
        };
        let played = Played {
            domain,
            bodies,
            settings,
            action,
            args,
            geometry,
            hand,
            object,
        };
        played.placement(&shown)?;
        played.given(&projection.given, given)?;
        Ok(played)
    }

    /// Checks that the document has a placement where the description has one, on what the call says.
    fn placement(&self, shown: &[String]) -> Checked<()> {
        let name = &self.action.name;
        let places = self.action.sub_actions.iter().find_map(|s| match s.until {
            Target::Placement { place, .. } => Some(place),
            _ => None,
        });
        let (place, placement) = match (places, &self.geometry.placement) {
            (None, None) => return Ok(()),
            (Some(place), Some(placement)) => (place, placement),
            (None, Some(_)) => {
                return Err(Kind::Handling {
                    what: format!("a {name} has no placement"),
                }
                .into());
            }
            (Some(_), None) => {
                return Err(Kind::Handling {
                    what: format!("`{name}` needs a placement"),
                }
                .into());
            }
        };
        if let ChoiceSet::Supports(on) = self.action.choices[place.face.index()].from {
            same("support", &shown[on.index()], &placement.on)?;
        }
        let off = placement.x.abs().max(placement.y.abs());
        let is_centred = matches!(self.action.choices[place.point.index()].from, ChoiceSet::Centre(_));
        // A NaN is not in the middle.
        if is_centred && (off.is_nan() || off > CENTRE) {
            return Err(Kind::Placement {
                what: "x, y and yaw",
                distance: off,
                angle: 0.0,
            }
            .into());
        }
        Ok(())
    }

    /// Checks that choices which the domain makes itself are made so.
    fn given(&self, choices: &[ChoiceId], values: &[Value]) -> Checked<()> {
        let placement = self.geometry.placement.as_ref();
        let mut is_y = false;
        for (i, (choice, value)) in choices.iter().zip(values).enumerate() {
            is_y = i > 0 && choices[i - 1] == *choice && !is_y;
            let number = |what: &'static str, is: Option<f64>| {
                let wanted = if let Value::Number(x) = value { *x } else { f64::NAN };
                let is = is.unwrap_or(f64::NAN);
                // A NaN is not the same.
                if (wanted - is).abs() <= GIVEN {
                    return Ok(());
                }
                Err(mismatch(what, &wanted.to_string(), &is.to_string()))
            };
            let name = |what: &'static str, is: Option<&str>| {
                let wanted = match value {
                    Value::String(s) => self.domain.strings[s.index()].as_str(),
                    _ => "?",
                };
                same(what, wanted, is.unwrap_or("nothing"))
            };
            match self.action.choices[choice.index()].from {
                ChoiceSet::Arms(_) => name("arm", Some(&self.geometry.arm))?,
                ChoiceSet::Grasps(_) => name("grasp", Some(&self.geometry.grasp))?,
                ChoiceSet::Supports(_) => name("support face", placement.map(|p| p.support.as_str()))?,
                ChoiceSet::Stable(_) => name("stable orientation", placement.map(|p| p.stable.as_str()))?,
                ChoiceSet::Points(_) if is_y => number("y of the placement", placement.map(|p| p.y))?,
                ChoiceSet::Points(_) => number("x of the placement", placement.map(|p| p.x))?,
                ChoiceSet::Angles => number("yaw of the placement", placement.map(|p| p.yaw))?,
                ChoiceSet::Centre(_) | ChoiceSet::Stands { .. } => {}
            }
        }
        Ok(())
    }

    /// Plays the sub-actions: motions, what is taken and let go. Leaves `state` at their end, and returns the states between
    /// them, the first one first.
    pub(super) fn play(&self, state: &mut State, verdict: &mut Verdict) -> Checked<Vec<State>> {
        let takes = self
            .action
            .choices
            .iter()
            .any(|c| matches!(c.from, ChoiceSet::Grasps(_)));
        if !takes {
            handling::holds(self.bodies, state, self.hand, self.object, &self.geometry.grasp)
                .map_err(|f| f.at_time(0.0))?;
        }
        let mut states = vec![state.clone()];
        let mut time = 0.0;
        for (i, sub_action) in self.geometry.sub_actions.iter().enumerate() {
            let mover = self.mover(sub_action.motion);
            motion::check(self.bodies, state, mover, sub_action, self.settings, verdict)
                .map_err(|f| f.later_by(time).at_time(time).in_sub_action(i, &sub_action.name))?;
            time += sub_action.trajectory.duration();
            self.change(sub_action, state, verdict)
                .map_err(|f| f.at_time(time).in_sub_action(i, &sub_action.name))?;
            states.push(state.clone());
        }
        Ok(states)
    }

    /// Checks that what was played is what the description demands; `states` are those between the sub-actions. The facts of
    /// the last one are left to [`Played::in_the_end`].
    pub(super) fn demands(&self, states: &[State], verdict: &mut Verdict) -> Checked<()> {
        let written = &self.geometry.sub_actions;
        let mut time = 0.0;
        let mut next = 0;
        for (at, demanded) in self.action.sub_actions.iter().enumerate() {
            let place = |f: Fault| f.at_time(time).in_sub_action(next, &demanded.name);
            let Some(before) = states.get(next) else {
                return Err(place(mismatch("sub-action", &demanded.name, "nothing")));
            };
            for condition in &demanded.when {
                self.condition(condition, before, verdict).map_err(place)?;
            }
            let in_document = written.get(next).filter(|s| s.name == demanded.name);
            let (Some(sub_action), Some(after)) = (in_document, states.get(next + 1)) else {
                // Fingers that are where they should be need not move.
                let is_there = matches!(demanded.space, Space::Gripper(_))
                    && demanded.change.is_none()
                    && self.fingers_are_there(demanded.until, before);
                if is_there {
                    continue;
                }
                let found = written.get(next).map_or("nothing", |s| s.name.as_str());
                return Err(place(mismatch("sub-action", &demanded.name, found)));
            };
            let motion = match demanded.space {
                Space::Arm(_) => Motion::Free,
                Space::ArmStraight(_) => Motion::Straight,
                Space::Gripper(_) => Motion::Gripper,
                Space::Body(_) => Motion::Posture,
                Space::Base(_) => Motion::Base,
            };
            if sub_action.motion != motion {
                return Err(place(mismatch("motion", word(motion), word(sub_action.motion))));
            }
            let kind = |change: Option<bool>| match change {
                None => "nothing",
                Some(true) => "that it is taken",
                Some(false) => "that it is let go",
            };
            let wanted = kind(demanded.change.map(|c| matches!(c, Change::Attach(_))));
            let found = kind(
                sub_action
                    .change
                    .as_ref()
                    .map(|c| matches!(c, AttachmentChange::Attach { .. })),
            );
            if wanted != found {
                let what = format!("`{}` demands {wanted}, the document says {found}", sub_action.name);
                return Err(place(Kind::Handling { what }.into()));
            }
            time += sub_action.trajectory.duration();
            let place = |f: Fault| f.at_time(time).in_sub_action(next, &demanded.name);
            self.target(demanded.until, before, after).map_err(place)?;
            if at + 1 < self.action.sub_actions.len() {
                self.facts(&demanded.facts, after, verdict).map_err(place)?;
            }
            next += 1;
        }
        match written.get(next) {
            Some(more) => Err(mismatch("sub-action", "nothing", &more.name).at_time(time)),
            None => Ok(()),
        }
    }

    /// Checks the facts of the last sub-action.
    pub(super) fn in_the_end(&self, state: &State, verdict: &mut Verdict) -> Checked<()> {
        let last = self.action.sub_actions.last();
        let end: f64 = self.geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
        last.map_or(Ok(()), |last| {
            self.facts(&last.facts, state, verdict).map_err(|f| f.at_time(end))
        })
    }

    /// The hand comes near what it handles on a straight line, or with its fingers.
    fn mover(&self, motion: Motion) -> Mover {
        let Hand { agent, arm } = self.hand;
        let object = self.object;
        Mover {
            agent,
            arm,
            touching: (motion != Motion::Free).then_some(Touching { agent, arm, object }),
        }
    }

    fn condition(&self, condition: &Condition, state: &State, verdict: &mut Verdict) -> Checked<()> {
        match condition {
            Condition::Free(_) => {
                let in_hand = state.objects.iter().position(|o| {
                    let held = o.held.as_ref();
                    held.is_some_and(|h| h.agent == self.hand.agent && h.arm == self.hand.arm)
                });
                match in_hand {
                    None => Ok(()),
                    Some(other) => Err(Kind::HandOccupied {
                        arm: self.hand.name(self.bodies),
                        object: self.bodies.scene.objects[other].id.clone(),
                    }
                    .into()),
                }
            }
            Condition::Holds(..) => handling::holds(self.bodies, state, self.hand, self.object, &self.geometry.grasp),
            Condition::Fact(fact) => self.fact(fact, state, verdict),
        }
    }

    fn facts(&self, facts: &[FactOf], state: &State, verdict: &mut Verdict) -> Checked<()> {
        facts.iter().try_for_each(|fact| self.fact(fact, state, verdict))
    }

    fn fact(&self, of: &FactOf, state: &State, verdict: &mut Verdict) -> Checked<()> {
        fact(self.domain, self.bodies, self.settings, self.args, of, state, verdict)
    }

    fn gripper(&self) -> Option<&'a Gripper> {
        self.bodies.scene.agents[self.hand.agent].arms[self.hand.arm]
            .gripper
            .as_ref()
    }

    /// Returns where the fingers end; `None` where that depends on what they hold.
    fn fingers(&self, until: Target) -> Option<&'a [f64]> {
        match until {
            Target::Open => self.gripper().map(|g| g.open.as_slice()),
            Target::Closed(None) => self.gripper().map(|g| g.closed.as_slice()),
            Target::Closed(Some(_))
            | Target::Grasp { .. }
            | Target::Up(_)
            | Target::Back(_)
            | Target::Posture
            | Target::Stand(_)
            | Target::Placement { .. } => None,
        }
    }

    fn fingers_are_there(&self, until: Target, state: &State) -> bool {
        let (Some(gripper), Some(values)) = (self.gripper(), self.fingers(until)) else {
            return false;
        };
        let q = &state.agents[self.hand.agent].q;
        let mut off = gripper
            .dofs
            .iter()
            .zip(values)
            .map(|(dof, value)| (q[*dof] - value).abs());
        off.all(|off| off <= FINGER)
    }

    /// Says whether anything is taken or let go.
    fn changes(&self) -> bool {
        self.action.sub_actions.iter().any(|s| s.change.is_some())
    }

    /// Checks that a sub-action ends where the description says.
    fn target(&self, until: Target, before: &State, state: &State) -> Checked<()> {
        let tool = |state: &State| self.bodies.tool(state, self.hand.agent, self.hand.arm);
        let thing = &self.bodies.scene.objects[self.object];
        let (X_WT, is, what) = match until {
            Target::Open | Target::Closed(None) => {
                if self.fingers_are_there(until, state) {
                    return Ok(());
                }
                let what = if until == Target::Open { "open" } else { "closed" };
                return Err(Kind::Handling {
                    what: format!("the fingers are not {what}"),
                }
                .into());
            }
            // What takes the object looks at the fingers; an action that goes is checked by `navigation`.
            Target::Closed(Some(_)) | Target::Posture | Target::Stand(_) => return Ok(()),
            // Where it is taken or let go, `handling` has looked at it.
            Target::Grasp { before: 0.0, .. } | Target::Placement { above: 0.0, .. } if self.changes() => return Ok(()),
            Target::Grasp { before: back, .. } => {
                let grasp = thing.grasps.iter().find(|g| g.name == self.geometry.grasp);
                let grasp = grasp.ok_or_else(|| unknown("grasp", &self.geometry.grasp))?;
                let X_WG = state.objects[self.object].X_WO * grasp.X_OT;
                (X_WG * Pose::translation(-back, 0.0, 0.0), tool(state), "the grasp")
            }
            Target::Up(d) => (
                Pose::translation(0.0, 0.0, d) * tool(before),
                tool(state),
                "the place above",
            ),
            Target::Back(d) => (
                tool(before) * Pose::translation(-d, 0.0, 0.0),
                tool(state),
                "the place behind",
            ),
            Target::Placement { above, .. } => {
                let Some(placement) = &self.geometry.placement else {
                    return Ok(());
                };
                let X_WO = Pose::translation(0.0, 0.0, above) * placement.pose.pose();
                (X_WO, state.objects[self.object].X_WO, "the placement")
            }
        };
        let apart = between(&X_WT, &is);
        let (most, turn) = (SHIFT.0.max(GRASP.0), SHIFT.1.max(GRASP.1));
        if exceeds(apart, (most, turn)) {
            return Err(Kind::TargetMissed {
                what,
                distance: apart.0,
                angle: apart.1,
            }
            .into());
        }
        Ok(())
    }

    /// Checks and does what changes hands.
    fn change(&self, sub_action: &SubAction, state: &mut State, verdict: &mut Verdict) -> Checked<()> {
        let (bodies, geometry) = (self.bodies, self.geometry);
        match &sub_action.change {
            None => return Ok(()),
            Some(AttachmentChange::Attach { object, object_in_tool }) => {
                same("handled object", &geometry.object, object)?;
                handling::attach(bodies, state, self.hand, self.object, object_in_tool, geometry)?;
            }
            Some(AttachmentChange::Detach {
                object,
                object_in_world,
            }) => {
                same("handled object", &geometry.object, object)?;
                handling::detach(bodies, state, self.hand, self.object, object_in_world, geometry)?;
            }
        }
        verdict.attachments += 1;
        Ok(())
    }
}

/// Checks that a fact about the arguments may hold in a state.
pub(super) fn fact(
    domain: &Domain,
    bodies: &Bodies<'_>,
    settings: &Settings,
    args: &[Value],
    fact: &FactOf,
    state: &State,
    verdict: &mut Verdict,
) -> Checked<()> {
    let name = &domain.requests[fact.request.index()].name;
    let args: Vec<Value> = fact.args.iter().map(|p| args[p.index()].clone()).collect();
    verdict.facts += 1;
    let answer = Asked::new(bodies, state.clone(), settings).ask(domain, name, &args);
    if matches!(answer, Some(Answer::Truth { may: true, .. })) {
        return Ok(());
    }
    let shown: Vec<String> = args.iter().map(|a| domain.show(a)).collect();
    let fact = format!("{name}({})", shown.join(", "));
    Err(Kind::FactUnconfirmed { fact }.into())
}

pub(super) fn same(what: &'static str, expected: &str, found: &str) -> Checked<()> {
    if expected == found {
        Ok(())
    } else {
        Err(mismatch(what, expected, found))
    }
}

pub(super) fn mismatch(what: &'static str, expected: &str, found: &str) -> Fault {
    Kind::GeometryMismatch {
        what,
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
    .into()
}

pub(super) fn unknown(what: &'static str, name: &str) -> Kind {
    Kind::UnknownName {
        what,
        name: name.to_owned(),
    }
}

pub(super) fn word(motion: Motion) -> &'static str {
    match motion {
        Motion::Free => "free",
        Motion::Straight => "straight",
        Motion::Gripper => "gripper",
        Motion::Posture => "posture",
        Motion::Base => "base",
    }
}

fn param(action: &Geometric, of: impl Fn(ChoiceSet) -> Option<ParamId>) -> Option<ParamId> {
    action.choices.iter().find_map(|c| of(c.from))
}

/// Returns the object that is handled: the one that is grasped, else the one that is in the hand.
fn handled(action: &Geometric) -> Option<ParamId> {
    let grasped = param(action, |from| match from {
        ChoiceSet::Grasps(object) => Some(object),
        _ => None,
    });
    let mut conditions = action.sub_actions.iter().flat_map(|s| &s.when);
    grasped.or_else(|| {
        conditions.find_map(|c| match c {
            Condition::Holds(_, object) => Some(*object),
            Condition::Free(_) | Condition::Fact(_) => None,
        })
    })
}
