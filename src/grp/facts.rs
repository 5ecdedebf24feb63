//! Facts of a world state that look at bottoms, hands and eyes (thesis 3.2.4, 3.3.4.1): isOn, hasInHand, isReachable, isVisible.
//!
//! Pure functions of a state and a seed: nobody moves the robot to ask a question, and asking twice gives the same answer.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::arm_space::{ArmSpace, Clearance};
use super::candidates::can_hold;
use super::key::Key;
use super::prepared::{Owner, Prepared, link_poses, place_all};
use crate::geom::collide::ray;
use crate::geom::ik;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{Object, Scene, State, Support};

/// Largest gap or overlap between a bottom and the face that carries it [m].
const CONTACT: f64 = 0.005;
/// How far a bottom polygon may stick out of the face [m].
pub(super) const OVERHANG: f64 = 0.001;
/// Largest angle between a support's normal and the vertical: its cosine.
const LEVEL: f64 = 0.9998;
/// Share of an object's surface that must be seen (design: 30 %).
const VISIBLE_SHARE: f64 = 0.3;
/// How near a bare hand's tool point must come to the object's surface [m]. The validator allows twice as much: it has an
/// inverse kinematics of its own, and a stretched arm is where two of them differ.
const TOUCH: f64 = 0.005;

/// Budget of one inverse kinematics call of isReachable.
const REACH_IK: ik::Settings = ik::Settings {
    max_iterations: 60,
    restarts: 30,
    position_tolerance: 1e-4,
    rotation_tolerance: 1e-3,
};

/// Says whether `a` stands on a support face of `b`: a stable orientation, its bottom inside the face and touching it.
/// A held object stands on nothing.
pub(super) fn is_on(scene: &Scene, state: &State, a: usize, b: usize) -> bool {
    if a == b || state.objects[a].held.is_some() {
        return false;
    }
    let (above, below) = (&scene.objects[a], &scene.objects[b]);
    below.supports.iter().any(|support| {
        let X_WF = state.objects[b].X_WO * support.X_OF;
        if !is_level(&state.objects[b].X_WO, support) {
            return false;
        }
        let X_FO = X_WF.inverse() * state.objects[a].X_WO;
        above.stable.iter().any(|stable| {
            let X_FQ = X_FO * stable.X_QO.inverse();
            let upright = (X_FQ.rotation * Vec3::z()).z >= LEVEL;
            upright
                && X_FQ.translation.vector.z.abs() <= CONTACT
                && stable.footprint.iter().all(|[x, y]| {
                    let p = X_FQ * nalgebra::Point3::new(*x, *y, 0.0);
                    p.x.abs() <= support.half[0] + OVERHANG && p.y.abs() <= support.half[1] + OVERHANG
                })
        })
    })
}

/// Says whether a support face looks up when its object is at `X_WO`.
pub(super) fn is_level(X_WO: &Pose, support: &Support) -> bool {
    (X_WO.rotation * support.X_OF.rotation * Vec3::z()).z >= LEVEL
}

/// Says whether `object` is attached to one of the agent's hands.
pub(super) fn has_in_hand(state: &State, agent: usize, object: usize) -> bool {
    state.objects[object].held.as_ref().is_some_and(|h| h.agent == agent)
}

/// Says whether an arm of the agent, its base and its other joints as they are, has a collision-free configuration at the object:
/// a robot's gripper, open, at one of the object's grasps; a human's palm at the surface, where the way from the arm's first joint to the centre enters it.
/// What an agent holds itself is not reachable to it.
pub(super) fn is_reachable(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    object: usize,
    agent: usize,
    seed: u64,
) -> bool {
    if has_in_hand(state, agent, object) {
        return false;
    }
    let stream = Key::new(seed)
        .text("isReachable")
        .number(object as u64)
        .number(agent as u64);
    let body = &scene.agents[agent];
    (0..body.arms.len()).any(|arm| {
        // A full hand cannot take another object.
        let full = state
            .objects
            .iter()
            .any(|o| o.held.as_ref().is_some_and(|h| h.agent == agent && h.arm == arm));
        !full
            && match body.arms[arm].gripper {
                Some(_) => gripper_reaches(scene, prepared, state, object, agent, arm, stream),
                None => hand_reaches(scene, prepared, state, object, agent, arm, stream),
            }
    })
}

/// Returns the random restarts of one arm at one grasp: the same for each and in every world state, whatever others needed
/// before. So the fact changes only where something in the way has moved.
fn tries(stream: Key) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(stream.0)
}

/// Returns where the arm's first joint is in the world [m], and X_KW, K being the frame of the arm's base link.
fn shoulder_and_base(scene: &Scene, prepared: &Prepared, state: &State, agent: usize, arm: usize) -> (Vec3, Pose) {
    let (body, at) = (&scene.agents[agent], &state.agents[agent]);
    let X_WL = body.tree.link_poses(&at.X_WB, &at.q);
    let shoulder = prepared.agents[agent].arms[arm].shoulder_link;
    (
        X_WL[shoulder].translation.vector,
        X_WL[body.arms[arm].base_link].inverse(),
    )
}

fn gripper_reaches(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    object: usize,
    agent: usize,
    arm: usize,
    stream: Key,
) -> bool {
    let Some(gripper) = &scene.agents[agent].arms[arm].gripper else {
        return false;
    };
    let ready = &prepared.agents[agent].arms[arm];
    let (p_WShoulder, X_KW) = shoulder_and_base(scene, prepared, state, agent, arm);
    let mut open = state.clone();
    for (dof, value) in gripper.dofs.iter().zip(&gripper.open) {
        open.agents[agent].q[*dof] = *value;
    }
    let mut space = ArmSpace::new(scene, prepared, &open, agent, arm, Some(object), Clearance::Contact);
    let seed = space.start();
    scene.objects[object]
        .grasps
        .iter()
        .filter(|g| can_hold(gripper, g))
        .any(|grasp| {
            let X_WT = state.objects[object].X_WO * grasp.X_OT;
            (X_WT.translation.vector - p_WShoulder).norm() <= ready.reach
                && space.hand_is_free(&X_WT)
                && ik::solve(
                    &ready.chain,
                    &ik::Target::Pose(X_KW * X_WT),
                    &seed,
                    &REACH_IK,
                    &mut tries(stream),
                    &mut |q| space.check(q),
                )
                .is_ok()
        })
}

fn hand_reaches(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    object: usize,
    agent: usize,
    arm: usize,
    stream: Key,
) -> bool {
    let ready = &prepared.agents[agent].arms[arm];
    let (p_WShoulder, X_KW) = shoulder_and_base(scene, prepared, state, agent, arm);
    let X_WO = &state.objects[object].X_WO;
    let towards = X_WO.translation.vector - p_WShoulder;
    let far = towards.norm();
    if far < 1e-9 {
        return false;
    }
    // Where the way from the shoulder to the centre enters the object.
    let direction = towards / far;
    let entry = prepared.objects[object]
        .iter()
        .filter_map(|part| ray(&part.exact, &(X_WO * part.X_FS), &p_WShoulder, &direction, far))
        .fold(far, f64::min);
    if entry - TOUCH > ready.reach {
        return false;
    }
    let p_KT = X_KW * nalgebra::Point3::from(p_WShoulder + direction * entry);
    let settings = ik::Settings {
        position_tolerance: TOUCH,
        ..REACH_IK
    };
    let mut space = ArmSpace::new(scene, prepared, state, agent, arm, Some(object), Clearance::Contact);
    let seed = space.start();
    ik::solve(
        &ready.chain,
        &ik::Target::Point(p_KT.coords),
        &seed,
        &settings,
        &mut tries(stream),
        &mut |q| space.check(q),
    )
    .is_ok()
}

/// Says whether enough of the object's surface lies in the agent's field of view and is not hidden by something else.
/// The object does not hide itself, and the head does not hide what its eyes see.
pub(super) fn is_visible(scene: &Scene, prepared: &Prepared, state: &State, object: usize, agent: usize) -> bool {
    let Some(camera) = &scene.agents[agent].camera else {
        return false;
    };
    let X_WL = link_poses(scene, state);
    let X_WC = X_WL[agent][camera.link] * camera.X_LC;
    let X_CW = X_WC.inverse();
    let hidden_by = place_all(prepared, state, &X_WL, &|owner| match owner {
        Owner::Link { agent: a, link } => a == agent && link == camera.link,
        Owner::Object(o) => o == object,
    });
    let points = surface_points(&scene.objects[object]);
    let eye = X_WC.translation.vector;
    let half_h = (camera.horizontal / 2.0).min(std::f64::consts::PI - 1e-6);
    let half_v = (camera.vertical / 2.0).min(std::f64::consts::FRAC_PI_2 - 1e-6);
    let seen: f64 = points
        .iter()
        .filter(|(p_O, _)| {
            let p_W = state.objects[object].X_WO * nalgebra::Point3::from(*p_O);
            let p_C = X_CW * p_W;
            let azimuth = nalgebra::RealField::atan2(p_C.y, p_C.x);
            let elevation = nalgebra::RealField::atan2(p_C.z, (p_C.x * p_C.x + p_C.y * p_C.y).sqrt());
            let way = p_W.coords - eye;
            let far = way.norm();
            if far > camera.range || far < 1e-9 || azimuth.abs() > half_h || elevation.abs() > half_v {
                return false;
            }
            let direction = way / far;
            // Spheres first: most bodies are nowhere near the line of sight.
            !hidden_by.iter().any(|b| {
                let to_body = b.X_WS.translation.vector - eye;
                let along = to_body.dot(&direction).clamp(0.0, far);
                (to_body - direction * along).norm_squared() <= b.solid.radius() * b.solid.radius()
                    && ray(b.solid, &b.X_WS, &eye, &direction, far - 1e-6).is_some()
            })
        })
        .map(|(_, area)| area)
        .sum();
    let all: f64 = points.iter().map(|(_, area)| area).sum();
    !points.is_empty() && seen >= VISIBLE_SHARE * all
}

/// Returns the number of points along a side of that half length: about one every 5 cm, few enough to stay fast.
fn grid(half: f64) -> u32 {
    (half / 0.025).ceil().clamp(3.0, 8.0) as u32
}

/// Returns points spread over the surfaces of an object's parts, in its frame [m], each with the area that it stands for [m^2].
fn surface_points(object: &Object) -> Vec<(Vec3, f64)> {
    use std::f64::consts::{PI, TAU};
    let mut points = Vec::new();
    for part in &object.parts {
        let mut add = |p: Vec3, area: f64| points.push(((part.X_OS * nalgebra::Point3::from(p)).coords, area));
        match &part.shape {
            Shape::Box { half } => {
                for axis in 0..3 {
                    let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
                    let (n, m) = (grid(half[u_axis]), grid(half[v_axis]));
                    let area = 4.0 * half[u_axis] * half[v_axis] / f64::from(n * m);
                    // Middles of the cells of a grid over the face.
                    let at = |i: u32, n: u32, half: f64| half * ((2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0);
                    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
                        for side in [-1.0, 1.0] {
                            let mut p = Vec3::zeros();
                            p[axis] = side * half[axis];
                            p[u_axis] = at(i, n, half[u_axis]);
                            p[v_axis] = at(j, m, half[v_axis]);
                            add(p, area);
                        }
                    }
                }
            }
            Shape::Cylinder { radius, half_length } | Shape::Capsule { radius, half_length } => {
                let rings = [-0.75, -0.25, 0.25, 0.75];
                for k in 0..12 {
                    let (sin, cos) = nalgebra::ComplexField::sin_cos(f64::from(k) * TAU / 12.0);
                    for z in rings {
                        let area = TAU * radius * 2.0 * half_length / (12.0 * rings.len() as f64);
                        add(Vec3::new(radius * cos, radius * sin, z * half_length), area);
                    }
                }
                // The ends: a disc each, or half a ball each.
                let is_capsule = matches!(part.shape, Shape::Capsule { .. });
                let (top, area) = if is_capsule {
                    (half_length + radius, TAU)
                } else {
                    (*half_length, PI)
                };
                add(Vec3::new(0.0, 0.0, top), area * radius * radius);
                add(Vec3::new(0.0, 0.0, -top), area * radius * radius);
            }
            Shape::Hull(hull) => {
                for [a, b, c] in hull.faces.iter().flat_map(|f| f.triangles()) {
                    let (a, u, v) = (hull.vertices[a], hull.vertices[b], hull.vertices[c]);
                    let (u, v) = (u - a, v - a);
                    // Middles of the cells of a grid of small triangles.
                    let n = grid(u.norm().max(v.norm()).max((u - v).norm()) / 2.0).min(4);
                    let area = u.cross(&v).norm() / 2.0 / f64::from(n * n);
                    let mut at = |i: u32, j: u32, third: f64| {
                        let (s, t) = (f64::from(i) + third, f64::from(j) + third);
                        add(a + (u * s + v * t) / f64::from(n), area);
                    };
                    for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
                        at(i, j, 1.0 / 3.0);
                        if i + j + 1 < n {
                            at(i, j, 2.0 / 3.0);
                        }
                    }
                }
            }
            Shape::Sphere { radius } => {
                let area = 4.0 * PI * radius * radius / 26.0;
                for x in [-1.0, 0.0, 1.0] {
                    for y in [-1.0, 0.0, 1.0] {
                        for z in [-1.0, 0.0, 1.0] {
                            let d = Vec3::new(x, y, z);
                            if d.norm() > 0.0 {
                                add(d.normalize() * *radius, area);
                            }
                        }
                    }
                }
            }
        }
    }
    points
}

/// Returns the pose of the object frame when it stands on the support as placed: `X_WF * X_FQ(x, y, yaw) * X_QO`.
pub(super) fn placed_pose(X_WF: &Pose, X_QO: &Pose, x: f64, y: f64, yaw: f64) -> Pose {
    X_WF * Pose::new(Vec3::new(x, y, 0.0), Vec3::z() * yaw) * X_QO
}
