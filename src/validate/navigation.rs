//! Plays the motions of an action that goes, and checks them: the arms in their posture, the base on its floor.
//!
//! The base's trajectory is linear in x, y and heading between the samples; it is looked at every [`Settings::step`] of the point that moves most.
//! Speeds and accelerations follow the rule of `motion`, for the length of the velocity on the floor and for the turning rate. The cost of the
//! way is not judged, as that of no geometric action is.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::TAU;

use nalgebra::RealField;

use super::{
    Settings, Verdict, bases,
    bodies::Bodies,
    facts::{self, Status},
    fault::{Checked, Fault, Kind},
    geometric::{mismatch, same, unknown, word},
    motion::{self, ACCELERATION, CONTINUITY, Mover, SPEED},
};
use crate::geom::{Pose, Vec3};
use crate::ir::geometric::{Geometric, Space};
use crate::ir::{Domain, Value};
use crate::plan::{Geometry, Motion, SubAction, Trajectory};
use crate::world::{BaseKind, EntityRef, State};

/// How far a joint may be from its posture [rad or m].
const POSTURE: f64 = 1e-3;
/// How far the stand's numbers may be from where the base ends [m], [rad].
const STAND: f64 = 1e-6;
/// How far a differential base may leave its heading [m], and turn while it goes [rad], from one sample to the next: rounding.
const SIDEWAYS: f64 = 1e-6;
/// The posture of an agent that goes.
const NAVIGATION: &str = "navigation";

/// An action that goes, at work.
pub(super) struct Journey<'a, 'b> {
    domain: &'a Domain,
    bodies: &'a Bodies<'a>,
    settings: &'a Settings,
    action: &'a Geometric,
    args: &'b [Value],
    geometry: &'b Geometry,
    agent: usize,
    target: EntityRef,
}

impl<'a, 'b> Journey<'a, 'b> {
    /// Checks the document's choices against the call; `None` where the action does not go.
    pub(super) fn new(
        domain: &'a Domain,
        bodies: &'a Bodies<'a>,
        settings: &'a Settings,
        name: &str,
        args: &'b [Value],
        geometry: &'b Geometry,
    ) -> Checked<Option<Self>> {
        let Some(action) = domain.geometric(name) else {
            return Ok(None);
        };
        let Some((goer, entity)) = action.goes() else {
            return Ok(None);
        };
        same("geometric action", &action.name, &geometry.action)?;
        if args.len() != action.params.len() {
            return Err(Kind::ArgumentCount {
                task: action.name.clone(),
                expected: action.params.len(),
                found: args.len(),
            }
            .into());
        }
        let of = |at: usize| {
            let shown = domain.show(&args[at]);
            let found = match &args[at] {
                Value::Entity(e) => bodies.scene.find(&domain.entities[e.index()].name),
                _ => None,
            };
            found
                .map(|e| (shown.clone(), e))
                .ok_or_else(|| unknown("entity of the world", &shown))
        };
        let ((goer, agent), (entity, target)) = (of(goer.index())?, of(entity.index())?);
        same("acting agent", &goer, &geometry.agent)?;
        same("target", &entity, &geometry.object)?;
        same("arm", "", &geometry.arm)?;
        same("grasp", "", &geometry.grasp)?;
        let EntityRef::Agent(agent) = agent else {
            return Err(unknown("agent of the world", &goer).into());
        };
        if geometry.placement.is_some() {
            return Err(handling(format!("`{name}` has no placement")));
        }
        Ok(Some(Journey {
            domain,
            bodies,
            settings,
            action,
            args,
            geometry,
            agent,
            target,
        }))
    }

    /// Plays the sub-actions; leaves `state` at their end.
    pub(super) fn play(&self, state: &mut State, verdict: &mut Verdict) -> Checked<()> {
        let written = &self.geometry.sub_actions;
        let (mut time, mut next) = (0.0, 0);
        for demanded in &self.action.sub_actions {
            let in_document = written.get(next).filter(|s| s.name == demanded.name);
            let place = |f: Fault| f.at_time(time).in_sub_action(next, &demanded.name);
            let wanted = match demanded.space {
                Space::Base(_) => Motion::Base,
                Space::Body(_) | Space::Arm(_) | Space::ArmStraight(_) | Space::Gripper(_) => Motion::Posture,
            };
            let Some(sub_action) = in_document else {
                // Arms that are where they should be need not move.
                if wanted == Motion::Posture && self.off_posture(state).is_none() {
                    continue;
                }
                let found = written.get(next).map_or("nothing", |s| s.name.as_str());
                return Err(place(mismatch("sub-action", &demanded.name, found)));
            };
            if sub_action.motion != wanted {
                return Err(place(mismatch("motion", word(wanted), word(sub_action.motion))));
            }
            if sub_action.change.is_some() {
                return Err(place(handling(
                    "who goes takes nothing and lets go of nothing".to_owned(),
                )));
            }
            let checked = if wanted == Motion::Base {
                self.base(state, sub_action, verdict)
            } else {
                let mover = Mover {
                    agent: self.agent,
                    arm: 0,
                    touching: None,
                };
                motion::check(self.bodies, state, mover, sub_action, self.settings, verdict)
            };
            checked.map_err(|f| place(f.later_by(time)))?;
            time += sub_action.trajectory.duration();
            let place = |f: Fault| f.at_time(time).in_sub_action(next, &demanded.name);
            if wanted == Motion::Posture
                && let Some((joint, value)) = self.off_posture(state)
            {
                return Err(place(handling(format!(
                    "`{joint}` is at {value:.4}, not as the posture `{NAVIGATION}` has it"
                ))));
            }
            next += 1;
        }
        if let Some(more) = written.get(next) {
            return Err(mismatch("sub-action", "nothing", &more.name).at_time(time));
        }
        self.stand(state).map_err(|f| f.at_time(time))?;
        self.facts(state, verdict).map_err(|f| f.at_time(time))
    }

    /// Returns a joint of an arm that is not where the posture has it, and where it is.
    fn off_posture(&self, state: &State) -> Option<(&'a str, f64)> {
        let body = &self.bodies.scene.agents[self.agent];
        let posture = body.postures.get(NAVIGATION)?;
        let q = &state.agents[self.agent].q;
        let mut dofs = body.arms.iter().flat_map(|arm| arm.dofs.iter().copied());
        // A NaN is not there.
        let off = dofs.find(|d| {
            let off = (q[*d] - posture[*d]).abs();
            off.is_nan() || off > POSTURE
        })?;
        Some((body.tree.dofs[off].name.as_str(), q[off]))
    }

    /// Checks that the base ended at its stand, and that the entity is reached from there.
    fn stand(&self, state: &State) -> Checked<()> {
        let (bodies, scene) = (self.bodies, self.bodies.scene);
        let stand = self
            .geometry
            .stand
            .ok_or_else(|| handling("it has no stand".to_owned()))?;
        let X_WB = &state.agents[self.agent].X_WB;
        let off = (X_WB.translation.x - stand.x)
            .abs()
            .max((X_WB.translation.y - stand.y).abs());
        let turned = turn(yaw_of(X_WB), stand.yaw).abs();
        // A NaN is off.
        if !(off <= STAND && turned <= STAND) {
            return Err(Kind::TargetMissed {
                what: "the stand",
                distance: off,
                angle: turned,
            }
            .into());
        }
        let is_reached = match self.target {
            EntityRef::Object(o) if scene.objects[o].movable => {
                let (object, agent) = (self.target, EntityRef::Agent(self.agent));
                let claim = facts::status(bodies, state, "isReachable", object, agent, Some(true), self.settings);
                claim != Some(Status::Fails)
            }
            EntityRef::Object(_) | EntityRef::Agent(_) => {
                bases::is_in_arms_length(bodies, state, self.agent, self.target)
            }
            EntityRef::Virtual(_) => false,
        };
        if is_reached {
            return Ok(());
        }
        let (agent, target) = (&scene.agents[self.agent].id, scene.id(self.target));
        Err(Kind::FactUnconfirmed {
            fact: format!("`{agent}` reaches `{target}` from its stand, which"),
        }
        .into())
    }

    /// Checks the facts that the description demands in the end.
    fn facts(&self, state: &State, verdict: &mut Verdict) -> Checked<()> {
        for fact in self.action.sub_actions.iter().flat_map(|s| &s.facts) {
            super::geometric::fact(self.domain, self.bodies, self.settings, self.args, fact, state, verdict)?;
        }
        Ok(())
    }

    /// Checks the base's trajectory from `state` on and leaves `state` at its end. Times of faults count from its start.
    fn base(&self, state: &mut State, sub_action: &SubAction, verdict: &mut Verdict) -> Checked<()> {
        let (bodies, scene, agent) = (self.bodies, self.bodies.scene, self.agent);
        let body = &scene.agents[agent];
        let trajectory = &sub_action.trajectory;
        if trajectory.joints != ["x", "y", "yaw"] {
            let what = "a base moves in `x`, `y` and `yaw`".to_owned();
            return Err(Kind::TrajectoryShape { what }.into());
        }
        motion::shape(trajectory)?;
        if body.base.drive().is_none() {
            return Err(handling(format!("the base of `{}` does not go on the floor", body.id)));
        }
        verdict.trajectories += 1;
        let rows: Vec<[f64; 3]> = trajectory.positions.iter().map(|r| [r[0], r[1], r[2]]).collect();
        self.starts(state, &rows)?;
        let z = state.agents[agent].X_WB.translation.z;
        // How far the agent reaches from its base's axis.
        let axis = state.agents[agent].X_WB.translation.vector.xy();
        let reach = bodies
            .moving(state, agent)
            .iter()
            .map(|b| (b.X_WS.translation.vector.xy() - axis).norm() + b.solid.radius())
            .fold(0.0, f64::max);
        let standing_state = state.clone();
        let standing = bodies.standing(&standing_state, agent);
        for i in 0..rows.len() {
            let (a, b) = (rows[i.saturating_sub(1)], rows[i]);
            let (from, to) = (trajectory.times[i.saturating_sub(1)], trajectory.times[i]);
            self.rates(trajectory, &rows, i).map_err(|f| f.at_time(to))?;
            let swept = ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt() + (b[2] - a[2]).abs() * reach;
            let steps = (swept / self.settings.step).ceil().max(1.0);
            if verdict.configurations as f64 + steps > self.settings.max_configurations as f64 {
                return Err(Kind::TooLong {
                    budget: self.settings.max_configurations,
                }
                .into());
            }
            let steps = steps as usize;
            for k in (if i == 0 { steps } else { 1 })..=steps {
                let t = k as f64 / steps as f64;
                let [x, y, yaw]: [f64; 3] = std::array::from_fn(|c| a[c] + t * (b[c] - a[c]));
                state.agents[agent].X_WB = Pose::new(Vec3::new(x, y, z), Vec3::z() * yaw);
                bodies.carry(state, agent);
                verdict.configurations += 1;
                let moving = bodies.moving(state, agent);
                let tolerance = self.settings.tolerance;
                if let Some(c) = bodies.contact(state, &moving, &standing, None, tolerance, &mut verdict.pairs) {
                    let fault = Kind::Collision {
                        a: bodies.name(c.a),
                        b: bodies.name(c.b),
                        depth: c.depth,
                    };
                    return Err(Fault::from(fault).at_time(from + t * (to - from)));
                }
            }
        }
        Ok(())
    }

    /// Checks that the trajectory begins where the base is, upright.
    fn starts(&self, state: &State, rows: &[[f64; 3]]) -> Checked<()> {
        let X_WB = &state.agents[self.agent].X_WB;
        if (X_WB.rotation * Vec3::z()).z < 0.9999 {
            return Err(handling("the base does not stand upright".to_owned()));
        }
        let here = [X_WB.translation.x, X_WB.translation.y, yaw_of(X_WB)];
        for (i, joint) in ["x", "y", "yaw"].into_iter().enumerate() {
            let found = rows.first().map_or(f64::NAN, |r| r[i]);
            let off = if i == 2 { turn(found, here[2]) } else { found - here[i] };
            if off.is_nan() || off.abs() > CONTINUITY {
                let fault = Kind::ConfigurationJump {
                    joint: joint.to_owned(),
                    expected: here[i],
                    found,
                };
                return Err(Fault::from(fault).at_time(0.0));
            }
        }
        Ok(())
    }

    /// Checks the interval that ends at sample `i`: the way of the drive, the speeds, the accelerations into it and, at the end, out
    /// of it.
    fn rates(&self, trajectory: &Trajectory, rows: &[[f64; 3]], i: usize) -> Checked<()> {
        if i == 0 {
            return Ok(());
        }
        let body = &self.bodies.scene.agents[self.agent];
        let limits = &body.base_limits;
        let times = &trajectory.times;
        let velocity = |i: usize| {
            let dt = times[i] - times[i - 1];
            let v: [f64; 3] = std::array::from_fn(|c| (rows[i][c] - rows[i - 1][c]) / dt);
            (v, dt)
        };
        let (v, dt) = velocity(i);
        let on_floor = |v: &[f64; 3]| (v[0] * v[0] + v[1] * v[1]).sqrt();
        if body.base == BaseKind::Differential {
            let (sin, cos) = nalgebra::ComplexField::sin_cos(rows[i][2]);
            let sideways = ((cos * v[1] - sin * v[0]) * dt).abs();
            let turned = (v[2] * dt).abs();
            let goes = on_floor(&v) * dt > SIDEWAYS;
            if sideways > SIDEWAYS || (goes && turned > SIDEWAYS) {
                return Err(Kind::Drive { sideways, turned }.into());
            }
        }
        let (v_before, dt_before) = if i == 1 { ([0.0; 3], 0.0) } else { velocity(i - 1) };
        let change =
            |from: &[f64; 3], to: &[f64; 3], gap: f64| -> [f64; 3] { std::array::from_fn(|c| (to[c] - from[c]) / gap) };
        let into = change(&v_before, &v, 0.5 * (dt + dt_before));
        let out = if i + 1 == rows.len() {
            change(&v, &[0.0; 3], 0.5 * dt)
        } else {
            [0.0; 3]
        };
        for (joint, speed, most, acceleration, limit) in [
            (
                "base",
                on_floor(&v),
                limits.speed,
                on_floor(&into).max(on_floor(&out)),
                limits.acceleration,
            ),
            (
                "yaw",
                v[2].abs(),
                limits.turn_rate,
                into[2].abs().max(out[2].abs()),
                limits.turn_acceleration,
            ),
        ] {
            let joint = joint.to_owned();
            if speed > most * (1.0 + SPEED) {
                return Err(Kind::Speed {
                    joint,
                    speed,
                    limit: most,
                }
                .into());
            }
            if acceleration > limit * (1.0 + ACCELERATION) {
                return Err(Kind::Acceleration {
                    joint,
                    acceleration,
                    limit,
                }
                .into());
            }
        }
        Ok(())
    }
}

/// Returns the heading of a base [rad].
fn yaw_of(X_WB: &Pose) -> f64 {
    let ahead = X_WB.rotation * Vec3::x();
    RealField::atan2(ahead.y, ahead.x)
}

/// Returns the turn from one heading to another, at most half a turn [rad].
fn turn(to: f64, from: f64) -> f64 {
    let turn = to - from;
    turn - TAU * (turn / TAU).round()
}

fn handling(what: String) -> Fault {
    Kind::Handling { what }.into()
}
