//! The choices of a geometric action, in the order in which they are tried.
//!
//! Discrete ones (arm and grasp) are sorted by promise; continuous ones (placements) are a bounded, well-spread sequence:
//! Halton points (doi:10.1007/BF01386213) shifted by the seed (Cranley & Patterson, doi:10.1137/0713071).
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::description::Given;
use super::facts::{is_level, placed_pose};
use super::prepared::Prepared;
use crate::geom::{Pose, Vec3};
use crate::world::{Grasp, Gripper, Scene, State, Support};

/// Where an object is to be put.
#[derive(Debug, Clone)]
pub(super) struct Placement {
    /// Object that carries it, and which of its faces.
    pub on: usize,
    pub support: usize,
    /// Index into the object's stable orientations.
    pub stable: usize,
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
    pub X_WO: Pose,
}

/// One assignment of all choices.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub arm: usize,
    /// Name and pose of the tool in the object frame, with the width between the fingers [m].
    pub grasp: String,
    pub X_OT: Pose,
    pub width: f64,
    pub placement: Option<Placement>,
}

/// Says whether the fingers go around what the grasp holds, and close on it.
pub(super) fn can_hold(gripper: &Gripper, grasp: &Grasp) -> bool {
    gripper.gap_closed <= grasp.width && grasp.width < gripper.gap_open
}

/// Returns every arm whose hand is empty with every grasp that its gripper can open for, most promising first.
///
/// HEURISTIC: nearest shoulder first; then grasps whose approach goes down or away from the shoulder, because a hand that
/// comes from below or from behind the object rarely fits.
pub(super) fn arms_and_grasps(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    agent: usize,
    object: usize,
) -> Vec<Candidate> {
    let body = &scene.agents[agent];
    let X_WL = body.tree.link_poses(&state.agents[agent].X_WB, &state.agents[agent].q);
    let X_WO = &state.objects[object].X_WO;
    let mut all: Vec<(f64, f64, Candidate)> = Vec::new();
    for (arm, description) in body.arms.iter().enumerate() {
        let full = state
            .objects
            .iter()
            .any(|o| o.held.as_ref().is_some_and(|h| h.agent == agent && h.arm == arm));
        let Some(gripper) = &description.gripper else { continue };
        if full {
            continue;
        }
        let p_WShoulder = X_WL[prepared.agents[agent].arms[arm].shoulder_link].translation.vector;
        let away = X_WO.translation.vector - p_WShoulder;
        let grasps = &scene.objects[object].grasps;
        for (n, grasp) in grasps.iter().enumerate() {
            // A grasp that the world file gives twice would give the same solution twice.
            let is_known = |g: &Grasp| g.X_OT == grasp.X_OT && g.width == grasp.width;
            if !can_hold(gripper, grasp) || grasps[..n].iter().any(is_known) {
                continue;
            }
            let approach = X_WO.rotation * grasp.X_OT.rotation * Vec3::x();
            let promise = approach.dot(&-Vec3::z()) + 0.5 * approach.dot(&away.normalize());
            let candidate = Candidate {
                arm,
                grasp: grasp.name.clone(),
                X_OT: grasp.X_OT,
                width: grasp.width,
                placement: None,
            };
            all.push((away.norm(), -promise, candidate));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    all.into_iter().map(|(_, _, c)| c).collect()
}

/// What is to be put where.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub object: usize,
    /// Object that is to carry it.
    pub on: usize,
    /// In the middle of a face alone; else anywhere on it.
    pub is_centred: bool,
    /// What is not to be chosen.
    pub given: &'a Given,
    /// Placements at most.
    pub limit: u32,
}

/// Returns placements of an object on the level faces of another; fewer than the limit where some do not fit onto their face.
pub(super) fn placements(scene: &Scene, state: &State, wanted: &Wanted<'_>, rng: &mut ChaCha8Rng) -> Vec<Placement> {
    let Wanted {
        object,
        on,
        is_centred,
        given,
        limit,
    } = *wanted;
    let thing = &scene.objects[object];
    let supports: Vec<(usize, &Support)> = scene.objects[on]
        .supports
        .iter()
        .enumerate()
        .filter(|(_, s)| is_level(&state.objects[on].X_WO, s))
        .filter(|(_, s)| given.face.as_ref().is_none_or(|f| *f == s.name))
        .collect();
    let is_wanted = |i: &usize| given.stable.as_ref().is_none_or(|s| *s == thing.stable[*i].name);
    let orientations: Vec<usize> = (0..thing.stable.len()).filter(is_wanted).collect();
    let shift: [f64; 3] = [rng.random(), rng.random(), rng.random()];
    let mut all = Vec::new();
    if supports.is_empty() || orientations.is_empty() {
        return all;
    }
    let n_kinds = supports.len() * orientations.len();
    let xy = if is_centred { Some([0.0, 0.0]) } else { given.xy };
    // Where all is given there is one placement of each kind.
    let limit = match (xy, given.yaw) {
        (Some(_), Some(_)) => limit.min(n_kinds as u32),
        _ => limit,
    };
    for k in 0..limit {
        let n = k as usize;
        // Faces and orientations alternate fastest, so that each gets its share of well-spread points.
        let (support, face) = supports[n % supports.len()];
        let stable = orientations[n / supports.len() % orientations.len()];
        let point = n / n_kinds + 1;
        let unit = |base: usize, i: usize| (halton(point, base) + shift[i]).fract();
        let yaw = given.yaw.unwrap_or((unit(5, 2) * 2.0 - 1.0) * std::f64::consts::PI);
        let (sin, cos) = nalgebra::ComplexField::sin_cos(yaw);
        let orientation = &thing.stable[stable];
        let turned: Vec<[f64; 2]> = orientation
            .footprint
            .iter()
            .map(|[x, y]| [cos * x - sin * y, sin * x + cos * y])
            .collect();
        let range = |axis: usize| {
            let low = turned.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            let high = turned.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
            (-face.half[axis] - low, face.half[axis] - high)
        };
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        if x0 > x1 || y0 > y1 {
            continue;
        }
        if xy.is_some_and(|[x, y]| !(x0..=x1).contains(&x) || !(y0..=y1).contains(&y)) {
            continue;
        }
        let [x, y] = xy.unwrap_or_else(|| [x0 + unit(2, 0) * (x1 - x0), y0 + unit(3, 1) * (y1 - y0)]);
        let X_WF = state.objects[on].X_WO * face.X_OF;
        let X_WO = placed_pose(&X_WF, &orientation.X_QO, x, y, yaw);
        all.push(Placement {
            on,
            support,
            stable,
            x,
            y,
            yaw,
            X_WO,
        });
    }
    all
}

/// Returns the `i`-th point (from 1) of the van der Corput sequence of a base, in [0, 1).
pub(super) fn halton(mut i: usize, base: usize) -> f64 {
    let (mut fraction, mut value) = (1.0, 0.0);
    while i > 0 {
        fraction /= base as f64;
        value += fraction * (i % base) as f64;
        i /= base;
    }
    value
}
