//! Takes over a geometric action of an earlier plan document: its motions and choices as they are.
//!
//! Nothing is computed but the world state that the motions lead to, which must begin where the world is. Does NOT look for
//! collisions, nor at facts and constraints: whoever hands over a document has the validator's word for those
//! (`validate::prefix`), which shares none of this code.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::Grp;
use super::description::Description;
use crate::engine::{Call, GasNum, GasRef, Projection};
use crate::geom::{Pose, Vec3};
use crate::ir::Domain;
use crate::plan::{ActionRefusal, AttachmentChange, Geometry, Motion, SubAction};
use crate::world::{Arm, EntityRef, Held, State};

/// How far a joint may be from where its motion begins: rounding in a document [rad or m].
const START: f64 = 1e-6;
/// How far an object may be from where the hand closes or opens, as the validator has it ([m], [rad]).
const PLACE: (f64, f64) = (1e-3, 1e-2);

/// A geometric action of an earlier plan.
#[derive(Debug)]
pub(super) struct Adopted {
    geometry: Geometry,
    start: State,
    end: State,
}

impl Adopted {
    pub(super) fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    pub(super) fn end(&self) -> &State {
        &self.end
    }
}

/// Numbers of adopted actions go down from the largest one, those of searched ones up from 0.
pub(super) fn number(position: usize) -> GasNum {
    GasNum(u32::MAX - position as u32)
}

/// Returns the position of an adopted action, or a number that none has.
pub(super) fn position(gas: GasNum) -> usize {
    (u32::MAX - gas.0) as usize
}

impl Grp<'_> {
    /// Applies a known solution to the current world state.
    pub(super) fn adopt_known(
        &mut self,
        domain: &Domain,
        call: &Call<'_>,
        known: Option<&Geometry>,
    ) -> Result<Projection, ActionRefusal> {
        let refuse = |why: String| {
            let args: Vec<String> = call.args.iter().map(|a| domain.show(a)).collect();
            ActionRefusal::not_applicable(format!("{}({})", call.name, args.join(", ")), why)
        };
        let known = known.ok_or_else(|| refuse("the earlier plan has no motions for it".into()))?;
        let start = self
            .states
            .last()
            .ok_or_else(|| refuse("there is no world state".into()))?;
        let found = self
            .adopted
            .iter()
            .position(|a| a.start == *start && a.geometry == *known);
        let at = match found {
            Some(at) => at,
            None => {
                let end = self.end_of(domain, call, known, start).map_err(refuse)?;
                self.adopted.push(Adopted {
                    geometry: known.clone(),
                    start: start.clone(),
                    end,
                });
                self.adopted.len() - 1
            }
        };
        self.states.push(self.adopted[at].end.clone());
        Ok(Projection {
            gas: GasRef {
                gas: number(at),
                alternative: 0,
            },
            cost: known.cost_parts.values().sum(),
            duration: known.sub_actions.iter().map(|s| s.trajectory.duration()).sum(),
        })
    }

    /// Returns the world state that the motions lead to, or a sentence that says why they don't fit.
    fn end_of(&self, domain: &Domain, call: &Call<'_>, known: &Geometry, start: &State) -> Result<State, String> {
        let action = super::geometric(domain, call)?;
        if action.goes().is_some() {
            return self.end_of_journey(domain, call, known, start);
        }
        let description = self.description(domain, call)?;
        let Description { agent, object, .. } = description;
        let (body, thing) = (&self.scene.agents[agent], &self.scene.objects[object]);
        let on = description.placing.map(|p| self.scene.objects[p.on].id.as_str());
        let placed = known.placement.as_ref().map(|p| p.on.as_str());
        for (what, wanted, is) in [
            (
                "action",
                Some(description.action.name.as_str()),
                Some(known.action.as_str()),
            ),
            ("agent", Some(body.id.as_str()), Some(known.agent.as_str())),
            ("object", Some(thing.id.as_str()), Some(known.object.as_str())),
            ("support", on, placed),
        ] {
            if wanted != is {
                let is = is.unwrap_or("none");
                return Err(format!("the {what} of the earlier plan's motions is {is}"));
            }
        }
        let arm = body.arms.iter().position(|a| a.name == known.arm);
        let arm = arm.ok_or_else(|| format!("{} has no arm `{}`", body.id, known.arm))?;
        let mut state = start.clone();
        for sub in &known.sub_actions {
            self.play(sub, (agent, object), arm, &mut state)?;
        }
        Ok(state)
    }

    /// The same for an action that goes.
    fn end_of_journey(
        &self,
        domain: &Domain,
        call: &Call<'_>,
        known: &Geometry,
        start: &State,
    ) -> Result<State, String> {
        let action = super::geometric(domain, call)?;
        let (agent, target) = super::navigate::goer(self.scene, domain, action, call.args)?;
        for (what, wanted, is) in [
            ("action", action.name.as_str(), &known.action),
            ("agent", &self.scene.agents[agent].id, &known.agent),
            ("target", self.scene.id(target), &known.object),
        ] {
            if wanted != is {
                return Err(format!("the {what} of the earlier plan's motions is {is}"));
            }
        }
        self.journey(known, agent, start)
    }

    /// Goes on to the world state that an action of a plan document leads to, by its motions alone: no domain says what they are for,
    /// and nobody looks whether something is in their way.
    ///
    /// # Errors
    ///
    /// A sentence, where the motions do not begin in the current world state, or name what it lacks.
    pub fn follow(&mut self, known: &Geometry) -> Result<(), String> {
        let start = self.states.last().ok_or("there is no world state")?;
        let agent = self.scene.agents.iter().position(|a| a.id == known.agent);
        let agent = agent.ok_or_else(|| format!("there is no agent `{}`", known.agent))?;
        let arm = self.scene.agents[agent].arms.iter().position(|a| a.name == known.arm);
        let goes = known.sub_actions.iter().any(|s| s.motion == Motion::Base);
        let end = match (arm, self.scene.find(&known.object)) {
            (Some(arm), Some(EntityRef::Object(object))) if !goes => {
                let mut state = start.clone();
                for sub in &known.sub_actions {
                    self.play(sub, (agent, object), arm, &mut state)?;
                }
                state
            }
            (_, Some(_)) => self.journey(known, agent, start)?,
            (_, None) => return Err(format!("there is no `{}`", known.object)),
        };
        self.states.push(end);
        Ok(())
    }

    /// Returns the world state that the motions of an action that goes lead to.
    fn journey(&self, known: &Geometry, agent: usize, start: &State) -> Result<State, String> {
        let mut state = start.clone();
        for sub in &known.sub_actions {
            let (Some(first), Some(last)) = (sub.trajectory.positions.first(), sub.trajectory.positions.last()) else {
                return Err(format!("`{}` has no motion", sub.name));
            };
            let joints = &sub.trajectory.joints;
            if first.len() != joints.len() || last.len() != joints.len() {
                return Err(format!("`{}` has no value for each of its joints", sub.name));
            }
            let mut X_WB = state.agents[agent].X_WB;
            if sub.motion == Motion::Base {
                let at = |row: &[f64]| match row {
                    [x, y, yaw] => Ok(Pose::new(Vec3::new(*x, *y, X_WB.translation.z), Vec3::z() * *yaw)),
                    _ => Err(format!("`{}` has no x, y and yaw", sub.name)),
                };
                let off = at(first)?.inverse() * X_WB;
                let is_there = off.translation.vector.norm() <= START && off.rotation.angle() <= START;
                if !is_there {
                    return Err(format!("`{}` does not begin where the base is", sub.name));
                }
                X_WB = at(last)?;
            } else {
                self.move_joints(sub, agent, first, last, &mut state)?;
            }
            state = super::navigate::moved(self.scene, &state, agent, &X_WB);
        }
        Ok(state)
    }

    /// Changes the state to that at the end of a sub-action.
    fn play(
        &self,
        sub: &SubAction,
        (agent, object): (usize, usize),
        arm: usize,
        state: &mut State,
    ) -> Result<(), String> {
        let (body, thing) = (&self.scene.agents[agent], &self.scene.objects[object]);
        let rows = &sub.trajectory.positions;
        let joints = &sub.trajectory.joints;
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return Err(format!("`{}` has no motion", sub.name));
        };
        if first.len() != joints.len() || last.len() != joints.len() {
            return Err(format!("`{}` has no value for each of its joints", sub.name));
        }
        self.move_joints(sub, agent, first, last, state)?;
        let X_WT = self.tool(agent, &body.arms[arm], state);
        if sub.motion != Motion::Gripper {
            for object in &mut state.objects {
                if let Some(held) = object.held.as_ref().filter(|h| h.agent == agent && h.arm == arm) {
                    object.X_WO = X_WT * held.X_TO;
                }
            }
        }
        let about = &mut state.objects[object];
        let (X_WO, held) = match &sub.change {
            None => return Ok(()),
            Some(AttachmentChange::Attach { object_in_tool, .. }) => {
                let X_TO = object_in_tool.pose();
                (X_WT * X_TO, Some(Held { agent, arm, X_TO }))
            }
            Some(AttachmentChange::Detach { object_in_world, .. }) => (object_in_world.pose(), None),
        };
        let off = X_WO.inverse() * about.X_WO;
        let (distance, angle) = (off.translation.vector.norm(), off.rotation.angle());
        let is_there = distance <= PLACE.0 && angle <= PLACE.1;
        if !is_there {
            return Err(format!(
                "`{}` has {} {distance:.4} m and {angle:.4} rad from where it is",
                sub.name, thing.id
            ));
        }
        // Taken, it stays where it is; let go, it settles.
        if held.is_none() {
            about.X_WO = X_WO;
        }
        about.held = held;
        Ok(())
    }

    /// Moves the joints of a trajectory to its end.
    fn move_joints(
        &self,
        sub: &SubAction,
        agent: usize,
        first: &[f64],
        last: &[f64],
        state: &mut State,
    ) -> Result<(), String> {
        let body = &self.scene.agents[agent];
        let joints = &sub.trajectory.joints;
        for ((joint, from), to) in joints.iter().zip(first).zip(last) {
            let dof = body.tree.dofs.iter().position(|d| d.name == *joint);
            let dof = dof.ok_or_else(|| format!("{} has no joint `{joint}`", body.id))?;
            let now = &mut state.agents[agent].q[dof];
            // What is no number is not where the world is either.
            let is_there = (*now - from).abs() <= START;
            if !is_there {
                return Err(format!(
                    "`{}` begins with `{joint}` at {from:.4}, and it is at {now:.4}",
                    sub.name
                ));
            }
            *now = *to;
        }
        Ok(())
    }

    /// Returns X_WT in a state.
    fn tool(&self, agent: usize, arm: &Arm, state: &State) -> Pose {
        let (body, at) = (&self.scene.agents[agent], &state.agents[agent]);
        body.tree.link_poses(&at.X_WB, &at.q)[arm.tip_link] * arm.X_LT
    }

    /// Returns what documents add to the numbers of searched actions, so that they are none of the adopted ones.
    pub(super) fn first_number(&self) -> u32 {
        let numbers = self.adopted.iter().map(|a| a.geometry.gas.saturating_add(1));
        numbers.max().unwrap_or(0)
    }
}
