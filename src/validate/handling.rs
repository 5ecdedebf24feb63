//! Checks what the hand takes and lets go of, and that nothing is left in the air.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::{
    bodies::Bodies,
    fault::{Checked, Kind},
};
use crate::geom::{Pose, Vec3};
use crate::plan::{Geometry, Placement, PoseDocument};
use crate::world::{EntityRef, Held, Object, Stable, State, Support};

/// How far the tool may be from its grasp ([m], [rad]), also for a grasp's pose that was handed on.
pub(super) const GRASP: (f64, f64) = (0.002, 0.02);
/// How far the fingers may be from the object's width [m].
const FINGERS: f64 = 0.002;
/// How far an object may jump when it is taken or let go ([m], [rad]).
const JUMP: (f64, f64) = (0.001, 0.01);
/// How far the numbers of a placement may be from its pose ([m], [rad]).
const PLACEMENT: (f64, f64) = (0.001, 0.01);
/// How far a bottom may be above or below what it was put on [m].
pub(super) const PUT_GAP: f64 = 0.002;
/// The same for the fact `isOn`, and for standing at all [m].
pub(super) const STAND_GAP: f64 = 0.005;
/// How far a bottom may stand out over the edge of a support face [m].
const OVERHANG: f64 = 0.001;

/// Distance [m] and angle [rad] between two poses.
pub(super) fn between(X_WA: &Pose, X_WB: &Pose) -> (f64, f64) {
    let distance = (X_WA.translation.vector - X_WB.translation.vector).norm();
    (distance, X_WA.rotation.angle_to(&X_WB.rotation))
}

pub(super) fn exceeds((distance, angle): (f64, f64), (most, turn): (f64, f64)) -> bool {
    // A NaN exceeds.
    !(distance <= most && angle <= turn)
}

/// An arm of an agent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hand {
    pub(super) agent: usize,
    pub(super) arm: usize,
}

impl Hand {
    pub(super) fn name(self, bodies: &Bodies<'_>) -> String {
        let agent = &bodies.scene.agents[self.agent];
        format!("{}'s {} hand", agent.id, agent.arms[self.arm].name)
    }

    /// Returns by finger joint the gap between the fingers [m].
    fn gaps(self, bodies: &Bodies<'_>, state: &State) -> Vec<(String, f64)> {
        let agent = &bodies.scene.agents[self.agent];
        let q = &state.agents[self.agent].q;
        let Some(gripper) = &agent.arms[self.arm].gripper else {
            return Vec::new();
        };
        let ends = gripper.open.iter().zip(&gripper.closed);
        let fingers = gripper
            .dofs
            .iter()
            .zip(ends)
            .filter(|(_, (open, closed))| open != closed);
        fingers
            .map(|(dof, (open, closed))| {
                let t = (q[*dof] - closed) / (open - closed);
                let gap = gripper.gap_closed + t * (gripper.gap_open - gripper.gap_closed);
                (agent.tree.dofs[*dof].name.clone(), gap)
            })
            .collect()
    }
}

/// Checks that the hand can take the object as said, and attaches it.
pub(super) fn attach(
    bodies: &Bodies<'_>,
    state: &mut State,
    hand: Hand,
    object: usize,
    object_in_tool: &PoseDocument,
    geometry: &Geometry,
) -> Checked<()> {
    let thing = &bodies.scene.objects[object];
    if let Some(held) = &state.objects[object].held {
        let by = Hand {
            agent: held.agent,
            arm: held.arm,
        };
        return Err(Kind::HeldAlready {
            object: thing.id.clone(),
            by: by.name(bodies),
        }
        .into());
    }
    let other = state.objects.iter().position(|o| {
        o.held
            .as_ref()
            .is_some_and(|h| h.agent == hand.agent && h.arm == hand.arm)
    });
    if let Some(other) = other {
        return Err(Kind::HandOccupied {
            arm: hand.name(bodies),
            object: bodies.scene.objects[other].id.clone(),
        }
        .into());
    }
    if !thing.movable {
        return Err(Kind::Handling {
            what: format!("`{}` can't be moved", thing.id),
        }
        .into());
    }
    let grasp = thing.grasps.iter().find(|g| g.name == geometry.grasp);
    let grasp = grasp.ok_or_else(|| Kind::UnknownName {
        what: "grasp",
        name: geometry.grasp.clone(),
    })?;
    let X_WO = state.objects[object].X_WO;
    let X_WT = bodies.tool(state, hand.agent, hand.arm);
    let missed = between(&(X_WO * grasp.X_OT), &X_WT);
    if exceeds(missed, GRASP) {
        return Err(Kind::GraspMissed {
            grasp: grasp.name.clone(),
            distance: missed.0,
            angle: missed.1,
        }
        .into());
    }
    for (finger, gap) in hand.gaps(bodies, state) {
        if (gap - grasp.width).abs() > FINGERS {
            return Err(Kind::FingersOpen {
                finger,
                gap,
                width: grasp.width,
            }
            .into());
        }
    }
    let X_TO = object_in_tool.pose();
    let jump = between(&(X_WT * X_TO), &X_WO);
    if exceeds(jump, JUMP) {
        return Err(Kind::ObjectJump {
            object: thing.id.clone(),
            distance: jump.0,
            angle: jump.1,
        }
        .into());
    }
    state.objects[object].held = Some(Held {
        agent: hand.agent,
        arm: hand.arm,
        X_TO,
    });
    Ok(())
}

/// Checks that the hand holds the object by the grasp that the document names.
pub(super) fn holds(bodies: &Bodies<'_>, state: &State, hand: Hand, object: usize, grasp: &str) -> Checked<()> {
    let thing = &bodies.scene.objects[object];
    let held = state.objects[object].held.as_ref();
    let held = held.filter(|h| h.agent == hand.agent && h.arm == hand.arm);
    let held = held.ok_or_else(|| Kind::NotHeld {
        object: thing.id.clone(),
        by: hand.name(bodies),
    })?;
    let known = thing.grasps.iter().find(|g| g.name == grasp);
    let known = known.ok_or_else(|| Kind::UnknownName {
        what: "grasp",
        name: grasp.to_owned(),
    })?;
    let missed = between(&(held.X_TO * known.X_OT), &Pose::identity());
    if exceeds(missed, GRASP) {
        return Err(Kind::GraspMissed {
            grasp: grasp.to_owned(),
            distance: missed.0,
            angle: missed.1,
        }
        .into());
    }
    Ok(())
}

/// Checks that the hand can let go of the object as said, and detaches it.
pub(super) fn detach(
    bodies: &Bodies<'_>,
    state: &mut State,
    hand: Hand,
    object: usize,
    object_in_world: &PoseDocument,
    geometry: &Geometry,
) -> Checked<()> {
    holds(bodies, state, hand, object, &geometry.grasp)?;
    let thing = &bodies.scene.objects[object];
    let X_WO = object_in_world.pose();
    let jump = between(&X_WO, &state.objects[object].X_WO);
    if exceeds(jump, JUMP) {
        return Err(Kind::ObjectJump {
            object: thing.id.clone(),
            distance: jump.0,
            angle: jump.1,
        }
        .into());
    }
    let width = thing.grasps.iter().find(|g| g.name == geometry.grasp).map(|g| g.width);
    let gripper = bodies.scene.agents[hand.agent].arms[hand.arm].gripper.as_ref();
    let widest = gripper.map_or(f64::INFINITY, |g| g.gap_open - 1e-6);
    for (finger, gap) in hand.gaps(bodies, state) {
        // Fingers that have not opened by a millimetre, where they can, would drag the object along.
        if let Some(width) = width.filter(|w| gap < (w + 0.001).min(widest)) {
            return Err(Kind::FingersClosed { finger, gap, width }.into());
        }
    }
    state.objects[object].held = None;
    state.objects[object].X_WO = X_WO;
    match &geometry.placement {
        Some(placement) => placed(bodies, state, object, placement),
        None => Err(Kind::Handling {
            what: format!("`{}` is let go but no placement is given", thing.id),
        }
        .into()),
    }
}

/// Checks the numbers of a placement against the object's pose.
fn placed(bodies: &Bodies<'_>, state: &State, object: usize, placement: &Placement) -> Checked<()> {
    let thing = &bodies.scene.objects[object];
    let unknown = |what: &'static str, name: &str| Kind::UnknownName {
        what,
        name: name.to_owned(),
    };
    let on = match bodies.scene.find(&placement.on) {
        Some(EntityRef::Object(on)) => on,
        Some(EntityRef::Agent(_) | EntityRef::Virtual(_)) | None => {
            return Err(unknown("object to stand on", &placement.on).into());
        }
    };
    let supports = &bodies.scene.objects[on].supports;
    let support = supports.iter().find(|s| s.name == placement.support);
    let support = support.ok_or_else(|| unknown("support face", &placement.support))?;
    let stable = thing.stable.iter().find(|s| s.name == placement.stable);
    let stable = stable.ok_or_else(|| unknown("stable orientation", &placement.stable))?;

    let X_WO = state.objects[object].X_WO;
    let X_WF = state.objects[on].X_WO * support.X_OF;
    if let Err(why) = stands(&X_WO, stable, &X_WF, support, PUT_GAP) {
        return Err(Kind::NotStanding {
            object: thing.id.clone(),
            on: format!("`{}` of `{}`", support.name, placement.on),
            why,
        }
        .into());
    }
    let yaw = nalgebra::UnitQuaternion::from_axis_angle(&Vec3::z_axis(), placement.yaw);
    let X_FQ = Pose::from_parts(nalgebra::Translation3::new(placement.x, placement.y, 0.0), yaw);
    let by_numbers = between(&(X_WF * X_FQ * stable.X_QO), &X_WO);
    let by_pose = between(&placement.pose.pose(), &X_WO);
    for (what, apart) in [("x, y and yaw", by_numbers), ("pose", by_pose)] {
        // The gap to the face is judged above: here it is height that may differ by as much.
        if exceeds(apart, (PLACEMENT.0 + PUT_GAP, PLACEMENT.1)) {
            return Err(Kind::Placement {
                what,
                distance: apart.0,
                angle: apart.1,
            }
            .into());
        }
    }
    Ok(())
}

/// Says why an object at `X_WO` does not stand on the face in that stable orientation.
fn stands(X_WO: &Pose, stable: &Stable, X_WF: &Pose, support: &Support, gap: f64) -> Result<(), String> {
    let X_WQ = X_WO * stable.X_QO.inverse();
    let normal = X_WF.rotation * Vec3::z();
    if normal.z < 0.99 {
        return Err("the face is not level".to_owned());
    }
    let tilt = (X_WQ.rotation * Vec3::z()).angle(&normal);
    if tilt > 0.02 {
        return Err(format!("it is tilted by {tilt:.3} rad"));
    }
    for [x, y] in &stable.footprint {
        let p_FB = X_WF.inverse_transform_point(&(X_WQ * nalgebra::Point3::new(*x, *y, 0.0)));
        if p_FB.z.abs() > gap {
            return Err(format!("its bottom is {:.4} m above the face", p_FB.z));
        }
        let over = (p_FB.x.abs() - support.half[0]).max(p_FB.y.abs() - support.half[1]);
        if over > OVERHANG {
            return Err(format!("its bottom reaches {over:.4} m over the edge"));
        }
    }
    if stable.footprint.is_empty() {
        return Err("it has no bottom".to_owned());
    }
    Ok(())
}

/// Says whether one object stands on a support face of another; what is held stands on nothing.
pub(super) fn is_on(bodies: &Bodies<'_>, state: &State, object: usize, on: usize, gap: f64) -> bool {
    let (thing, support): (&Object, &Object) = (&bodies.scene.objects[object], &bodies.scene.objects[on]);
    object != on
        && state.objects[object].held.is_none()
        && thing.stable.iter().any(|stable| {
            support.supports.iter().any(|face| {
                let X_WF = state.objects[on].X_WO * face.X_OF;
                stands(&state.objects[object].X_WO, stable, &X_WF, face, gap).is_ok()
            })
        })
}

/// Returns the first movable object that is neither held nor standing, other than one that did not stand at the start
/// either and has not moved since.
pub(super) fn in_the_air(bodies: &Bodies<'_>, state: &State, start: &State) -> Option<String> {
    let objects = bodies.scene.objects.iter().enumerate();
    for (i, object) in objects.filter(|(_, o)| o.movable) {
        let stands = |s: &State| {
            s.objects[i].held.is_some() || (0..s.objects.len()).any(|on| is_on(bodies, s, i, on, STAND_GAP))
        };
        if !stands(state) && (stands(start) || state.objects[i] != start.objects[i]) {
            return Some(object.id.clone());
        }
    }
    None
}
