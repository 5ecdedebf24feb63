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
use crate::ir::{Domain, ParamId, Value};
use crate::plan::{AttachmentChange, Geometry, Motion, SubAction};
use crate::world::{EntityRef, Gripper, State};

/// How far from the middle of a face something may be that has to stand there [m].
const CENTRE: f64 = 0.001;
/// How far a straight motion may miss its end ([m], [rad]), against how far up or back it goes.
const SHIFT: (f64, f64) = (0.002, 0.02);
/// How far a finger may be from where it shall be [rad or m]; for what is held there is a test of its own.
const FINGER: f64 = 1e-3;

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
        name: &str,
        args: &'b [Value],
        geometry: &'b Geometry,
    ) -> Checked<Self> {
        let unchecked = || Kind::GeometryUnchecked {
            action: name.to_owned(),
        };
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
        if is_centred && !(off <= CENTRE) {
            return Err(Kind::Placement {
                what: "x, y and yaw",
                distance: off,
                angle: 0.0,
            }
            .into());
        }
        Ok(())
    }

    /// Plays the sub-actions; leaves `state` at their end. The facts of the last one are left to [`Played::in_the_end`].
    pub(super) fn play(&self, state: &mut State, verdict: &mut Verdict) -> Checked<()> {
        let written = &self.geometry.sub_actions;
        let (mut time, mut next) = (0.0, 0);
        for (at, demanded) in self.action.sub_actions.iter().enumerate() {
            let in_document = written.get(next).filter(|s| s.name == demanded.name);
            let place = |f: Fault| f.at_time(time).in_sub_action(next, &demanded.name);
            for condition in &demanded.when {
                self.condition(condition, state, verdict).map_err(place)?;
            }
            let Some(sub_action) = in_document else {
                // Fingers that are where they should be need not move.
                let is_there = matches!(demanded.space, Space::Gripper(_))
                    && demanded.change.is_none()
                    && self.fingers_are_there(demanded.until, state);
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
            let before = state.clone();
            let mover = self.mover(motion);
            motion::check(self.bodies, state, mover, sub_action, self.settings, verdict)
                .map_err(|f| place(f.later_by(time)))?;
            time += sub_action.trajectory.duration();
            let place = |f: Fault| f.at_time(time).in_sub_action(next, &demanded.name);
            self.target(demanded.until, &before, state).map_err(place)?;
            self.change(demanded.change, sub_action, state, verdict)
                .map_err(place)?;
            if at + 1 < self.action.sub_actions.len() {
                self.facts(&demanded.facts, state, verdict).map_err(place)?;
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
    fn change(
        &self,
        demanded: Option<Change>,
        sub_action: &SubAction,
        state: &mut State,
        verdict: &mut Verdict,
    ) -> Checked<()> {
        let Played {
            bodies,
            hand,
            object,
            geometry,
            ..
        } = *self;
        if let Some(change) = &sub_action.change {
            let of = match change {
                AttachmentChange::Attach { object, .. } | AttachmentChange::Detach { object, .. } => object,
            };
            same("handled object", &geometry.object, of)?;
        }
        match (demanded, &sub_action.change) {
            (None, None) => return Ok(()),
            (Some(Change::Attach(_)), Some(AttachmentChange::Attach { object_in_tool, .. })) => {
                handling::attach(bodies, state, hand, object, object_in_tool, geometry)?;
            }
            (Some(Change::Detach(_)), Some(AttachmentChange::Detach { object_in_world, .. })) => {
                handling::detach(bodies, state, hand, object, object_in_world, geometry)?;
            }
            (demanded, found) => {
                let wanted = match demanded {
                    None => "nothing",
                    Some(Change::Attach(_)) => "that it is taken",
                    Some(Change::Detach(_)) => "that it is let go",
                };
                let is = match found {
                    None => "nothing",
                    Some(AttachmentChange::Attach { .. }) => "that it is taken",
                    Some(AttachmentChange::Detach { .. }) => "that it is let go",
                };
                let what = format!("`{}` demands {wanted}, the document says {is}", sub_action.name);
                return Err(Kind::Handling { what }.into());
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
