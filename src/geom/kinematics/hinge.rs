//! A joint made ready: its motion is linear in sine and cosine of half the angle.
//!
//! The child's pose in the parent is `X_PJ` times the joint's motion. With the unit quaternions q_PJ and (axis sin(v/2), cos(v/2)),
//! the product is `q_PJ cos(v/2) + (q_PJ * axis) sin(v/2)`: eight products in place of sixteen. One configuration and eight of them
//! take the same steps in the same order ([`product`]), so that they agree to the last bit.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use super::lanes::{Eight, Lanes};
use super::trig::{sin_cos, sin_cos_x8};
use super::{Joint, JointKind};
use crate::geom::{Pose, Vec3};

/// A joint between a parent link P and its child link C.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hinge {
    kind: JointKind,
    /// Translation of `X_PJ` [m].
    p: Vec3,
    /// Rotation of `X_PJ`: x, y, z, w.
    q: [f64; 4],
    /// The same times the quaternion of no real part whose imaginary part is the axis.
    q_axis: [f64; 4],
    /// The axis, measured in P; used by sliding joints.
    axis_P: Vec3,
}

impl Hinge {
    #[inline(always)]
    pub(super) fn new(joint: &Joint) -> Hinge {
        Hinge::of(&joint.X_PJ, joint.kind, &joint.axis)
    }

    #[inline(always)]
    pub(super) fn of(X_PJ: &Pose, kind: JointKind, axis: &Vec3) -> Hinge {
        let c = &X_PJ.rotation.coords;
        let q = [c.x, c.y, c.z, c.w];
        let (q_axis, axis_P) = match kind {
            // Most axes are the frame's z: the same product without its zeros.
            JointKind::Revolute if axis.x == 0.0 && axis.y == 0.0 => {
                let z = axis.z;
                ([q[1] * z, -(q[0] * z), q[3] * z, -(q[2] * z)], Vec3::zeros())
            }
            JointKind::Revolute => (times(&q, &[axis.x, axis.y, axis.z, 0.0]), Vec3::zeros()),
            JointKind::Prismatic => ([0.0; 4], X_PJ.rotation * axis),
            JointKind::Fixed => ([0.0; 4], Vec3::zeros()),
        };
        Hinge {
            kind,
            p: X_PJ.translation.vector,
            q,
            q_axis,
            axis_P,
        }
    }

    /// Returns `X_PC` at the joint's value `v` [rad] or [m].
    #[inline(always)]
    pub(super) fn at(&self, v: f64) -> Rigid<f64> {
        let (s, c) = match self.kind {
            JointKind::Revolute => sin_cos(0.5 * v),
            JointKind::Fixed | JointKind::Prismatic => (0.0, 0.0),
        };
        self.turned(v, s, c)
    }

    /// Eight times [`Hinge::at`].
    #[inline(always)]
    pub(super) fn at_x8(&self, v: &[f64; 8]) -> Rigid<Eight> {
        let (s, c) = match self.kind {
            JointKind::Revolute => sin_cos_x8(&halves(v)),
            JointKind::Fixed | JointKind::Prismatic => (Eight::of(0.0), Eight::of(0.0)),
        };
        self.turned(Eight(*v), s, c)
    }

    /// `s` and `c` are sine and cosine of half of `v`.
    #[inline(always)]
    fn turned<T: Lanes>(&self, v: T, s: T, c: T) -> Rigid<T> {
        let of = T::of;
        let (p, q, e, a) = (&self.p, &self.q, &self.q_axis, &self.axis_P);
        match self.kind {
            JointKind::Fixed => Rigid {
                p: [of(p.x), of(p.y), of(p.z)],
                q: [of(q[0]), of(q[1]), of(q[2]), of(q[3])],
            },
            JointKind::Revolute => Rigid {
                p: [of(p.x), of(p.y), of(p.z)],
                q: [
                    of(q[0]) * c + of(e[0]) * s,
                    of(q[1]) * c + of(e[1]) * s,
                    of(q[2]) * c + of(e[2]) * s,
                    of(q[3]) * c + of(e[3]) * s,
                ],
            },
            JointKind::Prismatic => Rigid {
                p: [of(p.x) + of(a.x) * v, of(p.y) + of(a.y) * v, of(p.z) + of(a.z) * v],
                q: [of(q[0]), of(q[1]), of(q[2]), of(q[3])],
            },
        }
    }
}

#[inline(always)]
fn halves(v: &[f64; 8]) -> [f64; 8] {
    let mut halves = *v;
    for h in &mut halves {
        *h *= 0.5;
    }
    halves
}

/// A pose, or several: translation, and unit quaternion x, y, z, w.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rigid<T> {
    pub p: [T; 3],
    pub q: [T; 4],
}

impl From<&Pose> for Rigid<f64> {
    #[inline(always)]
    fn from(X: &Pose) -> Rigid<f64> {
        let (p, q) = (&X.translation.vector, &X.rotation.coords);
        Rigid {
            p: [p.x, p.y, p.z],
            q: [q.x, q.y, q.z, q.w],
        }
    }
}

impl From<Rigid<f64>> for Pose {
    #[inline(always)]
    fn from(X: Rigid<f64>) -> Pose {
        let ([x, y, z], [i, j, k, w]) = (X.p, X.q);
        Pose::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)),
        )
    }
}

/// Hamilton's product of quaternions x, y, z, w.
#[inline(always)]
fn times<T: Lanes>(a: &[T; 4], b: &[T; 4]) -> [T; 4] {
    [
        (a[3] * b[0] + a[0] * b[3]) + (a[1] * b[2] - a[2] * b[1]),
        (a[3] * b[1] + a[1] * b[3]) + (a[2] * b[0] - a[0] * b[2]),
        (a[3] * b[2] + a[2] * b[3]) + (a[0] * b[1] - a[1] * b[0]),
        (a[3] * b[3] - a[0] * b[0]) - (a[1] * b[1] + a[2] * b[2]),
    ]
}

/// Returns `X_AB * X_BC`.
#[inline(always)]
pub(super) fn product<T: Lanes>(X_AB: &Rigid<T>, X_BC: &Rigid<T>) -> Rigid<T> {
    // The vector v turned by q is v + w t + u x t, with t = 2 u x v, u the imaginary part and w the real one.
    let [ux, uy, uz, w] = X_AB.q;
    let [x, y, z] = X_BC.p;
    let (tx, ty, tz) = (uy * z - uz * y, uz * x - ux * z, ux * y - uy * x);
    let (tx, ty, tz) = (tx + tx, ty + ty, tz + tz);
    let p = [
        (X_AB.p[0] + x) + (w * tx + (uy * tz - uz * ty)),
        (X_AB.p[1] + y) + (w * ty + (uz * tx - ux * tz)),
        (X_AB.p[2] + z) + (w * tz + (ux * ty - uy * tx)),
    ];
    Rigid {
        p,
        q: times(&X_AB.q, &X_BC.q),
    }
}
