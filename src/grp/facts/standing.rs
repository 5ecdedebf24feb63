//! isOn: the bottom of one object lies in a support face of another and touches it.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use crate::geom::{Pose, Vec3};
use crate::world::{Scene, Stable, State, Support};

/// Largest gap or overlap between a bottom and the face that carries it [m].
pub(super) const CONTACT: f64 = 0.005;
/// How far a bottom polygon may stick out of the face [m].
pub(in crate::grp) const OVERHANG: f64 = 0.001;
/// Largest angle between a support's normal and the vertical, and between the bottom and the face: its cosine (1.15 degrees).
const LEVEL: f64 = 0.9998;

/// Says whether `a` stands on a support face of `b`: a stable orientation, its bottom inside the face and touching it.
/// A held object stands on nothing.
pub(in crate::grp) fn is_on(scene: &Scene, state: &State, a: usize, b: usize) -> bool {
    if a == b || state.objects[a].held.is_some() {
        return false;
    }
    let (X_WA, X_WB) = (&state.objects[a].X_WO, &state.objects[b].X_WO);
    let (above, below) = (&scene.objects[a], &scene.objects[b]);
    below.supports.iter().any(|support| {
        // Where the frame of `a` is above the face, before anything is turned: mostly far away.
        let X_WF = X_WB * support.X_OF;
        let apart2 = (X_WA.translation.vector - X_WF.translation.vector).norm_squared();
        let half2 = support.half[0] * support.half[0] + support.half[1] * support.half[1];
        is_level(X_WB, support)
            && above.stable.iter().any(|stable| {
                let reach = stable.X_QO.translation.vector.norm() + half2.sqrt() + OVERHANG + CONTACT;
                apart2 <= reach * reach + 1e-9 && {
                    let bottom = Bottom::new(&X_WF, X_WA, stable, support);
                    bottom.is_upright() && bottom.gap.abs() <= CONTACT && bottom.sticks_out <= OVERHANG
                }
            })
    })
}

/// Says whether a support face looks up when its object is at `X_WO`.
pub(in crate::grp) fn is_level(X_WO: &Pose, support: &Support) -> bool {
    (X_WO.rotation * support.X_OF.rotation * Vec3::z()).z >= LEVEL
}

/// How a bottom lies over a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bottom {
    /// Cosine of the angle between the two.
    level: f64,
    /// Height of the bottom's middle above the face [m].
    pub gap: f64,
    /// How far the bottom polygon reaches beyond the face [m]; negative inside.
    pub sticks_out: f64,
}

impl Bottom {
    pub(super) fn new(X_WF: &Pose, X_WO: &Pose, stable: &Stable, support: &Support) -> Bottom {
        let X_FQ = X_WF.inv_mul(X_WO) * stable.X_QO.inverse();
        let corners = stable.footprint.iter().map(|[x, y]| {
            let p = X_FQ * nalgebra::Point3::new(*x, *y, 0.0);
            (p.x.abs() - support.half[0]).max(p.y.abs() - support.half[1])
        });
        Bottom {
            level: (X_FQ.rotation * Vec3::z()).z,
            gap: X_FQ.translation.vector.z,
            sticks_out: corners.fold(f64::NEG_INFINITY, f64::max),
        }
    }

    pub(super) fn is_upright(&self) -> bool {
        self.level >= LEVEL
    }
}

/// Returns the pose of the object frame when it stands on the support as placed: `X_WF * X_FQ(x, y, yaw) * X_QO`.
pub(in crate::grp) fn placed_pose(X_WF: &Pose, X_QO: &Pose, x: f64, y: f64, yaw: f64) -> Pose {
    X_WF * Pose::new(Vec3::new(x, y, 0.0), Vec3::z() * yaw) * X_QO
}
