//! Checks one trajectory: form, joints, continuity, limits, speed, acceleration, straightness and contact.
//!
//! Positions are linear between the samples (as the document defines), and looked at every [`Settings::step`].
//! Accelerations are those of the samples: the change of mean speed from one interval to the next over the time between
//! their middles; a trajectory starts and ends at rest, so that an end interval counts as `|v| / (dt / 2)`.
//! Jerks are six times the third divided differences of the samples, two more at rest beyond each end (decision 30).
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::{
    Settings, Verdict,
    bodies::{Bodies, Touching},
    fault::{Checked, Fault, Kind},
};
use crate::geom::Pose;
use crate::plan::{Motion, SubAction, Trajectory};
use crate::world::State;

/// How far a start configuration may be from where the joints are [rad or m].
pub(super) const CONTINUITY: f64 = 1e-6;
/// How far a position may exceed a limit [rad or m].
const LIMIT: f64 = 1e-9;
/// Relative excess of a speed, for rounding.
pub(super) const SPEED: f64 = 1e-6;
/// Relative excess of an acceleration; the samples are of a continuous profile.
pub(super) const ACCELERATION: f64 = 1e-3;
/// Relative excess of a jerk, for rounding, which a third difference of samples shows most.
const JERK: f64 = 1e-3;
/// How far the tool may leave its line [m], and its orientation the one in between [rad].
const STRAIGHT: (f64, f64) = (0.005, 0.02);

/// Who moves, and what the hand may touch meanwhile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mover {
    pub(super) agent: usize,
    pub(super) arm: usize,
    pub(super) touching: Option<Touching>,
}

/// Checks the sub-action's trajectory from `state` on and leaves `state` at its end. Times of faults count from its start.
pub(super) fn check(
    bodies: &Bodies<'_>,
    state: &mut State,
    mover: Mover,
    sub_action: &SubAction,
    settings: &Settings,
    verdict: &mut Verdict,
) -> Checked<()> {
    let trajectory = &sub_action.trajectory;
    let dofs = joints(bodies, state, mover, sub_action)?;
    shape(trajectory)?;
    verdict.trajectories += 1;
    start(bodies, state, mover, trajectory, &dofs)?;

    let standing_state = state.clone();
    let standing = bodies.standing(&standing_state, mover.agent);
    let line = (sub_action.motion == Motion::Straight).then(|| Line::of(bodies, state, mover, trajectory, &dofs));
    let n = trajectory.times.len();
    for i in 0..n {
        let row = &trajectory.positions[i];
        limits(bodies, mover, row, &dofs).map_err(|f| f.at_time(trajectory.times[i]))?;
        rates(bodies, mover, trajectory, &dofs, i).map_err(|f| f.at_time(trajectory.times[i]))?;
        jerk(bodies, mover, trajectory, &dofs, i).map_err(|f| f.at_time(trajectory.times[i]))?;
        let previous = &trajectory.positions[i.saturating_sub(1)];
        let largest = row.iter().zip(previous).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let steps = (largest / settings.step).ceil().max(1.0);
        if verdict.configurations as f64 + steps > settings.max_configurations as f64 {
            return Err(Kind::TooLong {
                budget: settings.max_configurations,
            }
            .into());
        }
        let steps = steps as usize;
        let from = trajectory.times[i.saturating_sub(1)];
        // The first sample alone is one configuration; each interval adds its inner ones and its end.
        for k in (if i == 0 { steps } else { 1 })..=steps {
            let t = k as f64 / steps as f64;
            let q = &mut state.agents[mover.agent].q;
            for (column, dof) in dofs.iter().enumerate() {
                q[*dof] = previous[column] + t * (row[column] - previous[column]);
            }
            bodies.carry(state, mover.agent);
            verdict.configurations += 1;
            let time = from + t * (trajectory.times[i] - from);
            if let Some(line) = &line {
                line.check(&bodies.tool(state, mover.agent, mover.arm))
                    .map_err(|f| f.at_time(time))?;
            }
            let moving = bodies.moving(state, mover.agent);
            let contact = bodies.contact(
                state,
                &moving,
                &standing,
                mover.touching,
                settings.tolerance,
                &mut verdict.pairs,
            );
            if let Some(contact) = contact {
                let fault = Kind::Collision {
                    a: bodies.name(contact.a),
                    b: bodies.name(contact.b),
                    depth: contact.depth,
                };
                return Err(Fault::from(fault).at_time(time));
            }
        }
    }
    Ok(())
}

/// Returns the dof of each column.
fn joints(bodies: &Bodies<'_>, state: &State, mover: Mover, sub_action: &SubAction) -> Checked<Vec<usize>> {
    let agent = &bodies.scene.agents[mover.agent];
    let arm = &agent.arms[mover.arm];
    let fingers = arm.gripper.iter().flat_map(|g| &g.dofs);
    // Fingers that hold something stay closed while the arm moves.
    let holds = (0..state.objects.len()).any(|o| super::bodies::held_by(state, o, mover.agent) == Some(mover.arm));
    let allowed: Vec<usize> = match sub_action.motion {
        Motion::Gripper => fingers.copied().collect(),
        Motion::Posture => agent.arms.iter().flat_map(|a| a.dofs.iter().copied()).collect(),
        Motion::Base => Vec::new(),
        Motion::Free | Motion::Straight if holds => arm.dofs.clone(),
        Motion::Free | Motion::Straight => arm.dofs.iter().chain(fingers).copied().collect(),
    };
    let mut dofs = Vec::with_capacity(sub_action.trajectory.joints.len());
    for name in &sub_action.trajectory.joints {
        let dof = agent.tree.dofs.iter().position(|d| d.name == *name);
        let dof = dof.ok_or_else(|| Kind::UnknownName {
            what: "joint",
            name: name.clone(),
        })?;
        if dofs.contains(&dof) {
            return Err(Kind::TrajectoryShape {
                what: format!("joint `{name}` has two columns"),
            }
            .into());
        }
        if !allowed.contains(&dof) {
            let part = if sub_action.motion == Motion::Gripper {
                " fingers"
            } else {
                ""
            };
            return Err(Kind::JointForeign {
                joint: name.clone(),
                arm: format!("{}'s {} arm{part}", agent.id, arm.name),
            }
            .into());
        }
        dofs.push(dof);
    }
    Ok(dofs)
}

/// Checks that it is a table of finite numbers with growing times.
pub(super) fn shape(trajectory: &Trajectory) -> Checked<()> {
    let malformed = |what: String| Err(Kind::TrajectoryShape { what }.into());
    let (times, rows) = (&trajectory.times, &trajectory.positions);
    if times.is_empty() {
        return malformed("it has no samples".to_owned());
    }
    if times.len() != rows.len() {
        return malformed(format!("{} times but {} rows", times.len(), rows.len()));
    }
    if let Some(i) = rows.iter().position(|r| r.len() != trajectory.joints.len()) {
        return malformed(format!("row {i} has not {} columns", trajectory.joints.len()));
    }
    if !times.iter().chain(rows.iter().flatten()).all(|x| x.is_finite()) {
        return Err(Kind::NotFinite {
            what: "a time or position of a trajectory".to_owned(),
        }
        .into());
    }
    if times[0] != 0.0 {
        return malformed(format!("its first time is {}, not 0", times[0]));
    }
    match (1..times.len()).find(|i| times[*i] <= times[*i - 1]) {
        Some(index) => Err(Fault::from(Kind::TimeOrder {
            index,
            before: times[index - 1],
            time: times[index],
        })
        .at_time(times[index - 1])),
        None => Ok(()),
    }
}

fn start(bodies: &Bodies<'_>, state: &State, mover: Mover, trajectory: &Trajectory, dofs: &[usize]) -> Checked<()> {
    for (column, dof) in dofs.iter().enumerate() {
        let (expected, found) = (state.agents[mover.agent].q[*dof], trajectory.positions[0][column]);
        if (expected - found).abs() > CONTINUITY {
            let fault = Kind::ConfigurationJump {
                joint: bodies.scene.agents[mover.agent].tree.dofs[*dof].name.clone(),
                expected,
                found,
            };
            return Err(Fault::from(fault).at_time(0.0));
        }
    }
    Ok(())
}

fn limits(bodies: &Bodies<'_>, mover: Mover, row: &[f64], dofs: &[usize]) -> Checked<()> {
    for (value, dof) in row.iter().zip(dofs) {
        let dof = &bodies.scene.agents[mover.agent].tree.dofs[*dof];
        if *value < dof.lower - LIMIT || *value > dof.upper + LIMIT {
            return Err(Kind::JointLimit {
                joint: dof.name.clone(),
                value: *value,
                lower: dof.lower,
                upper: dof.upper,
            }
            .into());
        }
    }
    Ok(())
}

/// Checks the speed of the interval that ends at sample `i`, and the accelerations into it and, at the end, out of it.
fn rates(bodies: &Bodies<'_>, mover: Mover, trajectory: &Trajectory, dofs: &[usize], i: usize) -> Checked<()> {
    if i == 0 {
        return Ok(());
    }
    let (times, rows) = (&trajectory.times, &trajectory.positions);
    let dt = times[i] - times[i - 1];
    for (column, dof) in dofs.iter().enumerate() {
        let dof = &bodies.scene.agents[mover.agent].tree.dofs[*dof];
        let v = (rows[i][column] - rows[i - 1][column]) / dt;
        if v.abs() > dof.max_velocity * (1.0 + SPEED) {
            return Err(Kind::Speed {
                joint: dof.name.clone(),
                speed: v.abs(),
                limit: dof.max_velocity,
            }
            .into());
        }
        let into = if i == 1 {
            2.0 * v.abs() / dt
        } else {
            let dt_before = times[i - 1] - times[i - 2];
            let v_before = (rows[i - 1][column] - rows[i - 2][column]) / dt_before;
            (v - v_before).abs() / (0.5 * (dt + dt_before))
        };
        let out = if i + 1 == times.len() { 2.0 * v.abs() / dt } else { 0.0 };
        let acceleration = into.max(out);
        if acceleration > dof.max_acceleration * (1.0 + ACCELERATION) {
            return Err(Kind::Acceleration {
                joint: dof.name.clone(),
                acceleration,
                limit: dof.max_acceleration,
            }
            .into());
        }
    }
    Ok(())
}

/// Checks the jerk over sample `i` and the three before it, and at the end those over the rest after it.
fn jerk(bodies: &Bodies<'_>, mover: Mover, trajectory: &Trajectory, dofs: &[usize], i: usize) -> Checked<()> {
    let (times, rows) = (&trajectory.times, &trajectory.positions);
    let n = times.len();
    if i == 0 {
        return Ok(());
    }
    let beyond = if i + 1 == n { 2 } else { 0 };
    for (column, dof) in dofs.iter().enumerate() {
        let dof = &bodies.scene.agents[mover.agent].tree.dofs[*dof];
        // Sample `k` counted from two before the first one.
        let sample = |k: usize| match k {
            0 | 1 => (times[0] - (2 - k) as f64 * (times[1] - times[0]), rows[0][column]),
            k if k < n + 2 => (times[k - 2], rows[k - 2][column]),
            k => {
                let after = (k - n - 1) as f64 * (times[n - 1] - times[n - 2]);
                (times[n - 1] + after, rows[n - 1][column])
            }
        };
        for end in i + 2..=i + 2 + beyond {
            let [a, b, c, d] = [3, 2, 1, 0].map(|back| sample(end - back));
            let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
            let bend = |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (slope(b, c) - slope(a, b)) / (c.0 - a.0);
            let jerk = 6.0 * (bend(b, c, d) - bend(a, b, c)) / (d.0 - a.0);
            if jerk.abs() > dof.max_jerk * (1.0 + JERK) {
                return Err(Kind::Jerk {
                    joint: dof.name.clone(),
                    jerk: jerk.abs(),
                    limit: dof.max_jerk,
                }
                .into());
            }
        }
    }
    Ok(())
}

/// The line on which a tool should stay.
struct Line {
    X_WT0: Pose,
    X_WT1: Pose,
}

impl Line {
    fn of(bodies: &Bodies<'_>, state: &State, mover: Mover, trajectory: &Trajectory, dofs: &[usize]) -> Self {
        let tool = |row: Option<&Vec<f64>>| {
            let mut state = state.clone();
            for (value, dof) in row.into_iter().flatten().zip(dofs) {
                state.agents[mover.agent].q[*dof] = *value;
            }
            bodies.tool(&state, mover.agent, mover.arm)
        };
        Line {
            X_WT0: tool(trajectory.positions.first()),
            X_WT1: tool(trajectory.positions.last()),
        }
    }

    fn check(&self, X_WT: &Pose) -> Checked<()> {
        let (p0, p1) = (self.X_WT0.translation.vector, self.X_WT1.translation.vector);
        let (along, p) = (p1 - p0, X_WT.translation.vector - p0);
        let length2 = along.norm_squared();
        let s = if length2 > 0.0 {
            (along.dot(&p) / length2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let distance = (p - along * s).norm();
        let (r0, r1) = (self.X_WT0.rotation, self.X_WT1.rotation);
        let between = r0.try_slerp(&r1, s, 1e-9).unwrap_or(r0);
        let angle = between.angle_to(&X_WT.rotation);
        if distance > STRAIGHT.0 || angle > STRAIGHT.1 {
            return Err(Kind::NotStraight { distance, angle }.into());
        }
        Ok(())
    }
}
