//! Rays against solids, in closed form: where one ray enters ([`ray`]), and whether a solid cuts many segments from one point ([`Seen`]).
//!
//! The yes/no test of segments has neither roots nor divisions for balls and boxes (Ericson, Real-Time Collision Detection, 2005, sections
//! 5.2.7 and 5.3.3). Padding is exact for spheres and capsules; a padded box, cylinder or hull is met as the sharp one whose sides are moved out by the margin,
//! which contains the rounded one.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::Matrix3;

use super::{Core, Solid};
use crate::geom::{Pose, Vec3};

/// Returns the distance [m], at most `max`, from the ray's origin R to the first point of the solid along the unit `direction`;
/// `p_WR` and `direction` are expressed in the world. 0 when the origin lies inside,
/// and when an origin or the direction is not finite.
pub fn ray(solid: &Solid, X_WS: &Pose, p_WR: &Vec3, direction: &Vec3, max: f64) -> Option<f64> {
    let between = X_WS.translation.vector - p_WR;
    if !(between.sum() + direction.sum()).is_finite() {
        return Some(0.0);
    }
    let ahead = between.dot(direction);
    let aside2 = between.norm_squared() - ahead * ahead;
    // The bounding sphere is passed by, is behind, or is too far.
    if aside2 > solid.radius * solid.radius || ahead < -solid.radius || ahead - solid.radius > max {
        return None;
    }
    let p = X_WS.rotation.inverse_transform_vector(&-between);
    let d = X_WS.rotation.inverse_transform_vector(direction);
    let round = solid.round;
    let hit = match solid.core {
        Core::Point => ball(&p, &d, round),
        Core::Segment { half_length } => {
            let side = tube(&p, &d, round, half_length);
            let cap = |z: f64| ball(&(p - Vec3::new(0.0, 0.0, z)), &d, round);
            [side, cap(half_length), cap(-half_length)]
                .into_iter()
                .flatten()
                .reduce(f64::min)
        }
        Core::Box { half } => within([
            slab(p.x, d.x, half.x + round),
            slab(p.y, d.y, half.y + round),
            slab(p.z, d.z, half.z + round),
        ]),
        Core::Hull(ref hull) => within([hull.crossing(&p, &d, round).map(|c| (c.enter, c.leave))]),
        Core::Cylinder { radius, half_length } => tube(&p, &d, radius + round, half_length + round),
    };
    hit.filter(|&t| t <= max)
}

/// An interval of the ray's parameter.
type Interval = Option<(f64, f64)>;

/// Where `|p + t d| <= half` on one axis.
fn slab(p: f64, d: f64, half: f64) -> Interval {
    if d == 0.0 {
        return (p.abs() <= half).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (s, t) = ((-half - p) / d, (half - p) / d);
    Some((s.min(t), s.max(t)))
}

/// Where a quadratic `a t^2 + 2 b t + c <= 0`, with `a >= 0`.
fn quadratic(a: f64, b: f64, c: f64) -> Interval {
    if a <= 0.0 {
        return (c <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    Some(((-b - root) / a, (-b + root) / a))
}

/// First parameter that is not negative and lies in all intervals.
fn within<const N: usize>(intervals: [Interval; N]) -> Option<f64> {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for interval in intervals {
        let (from, to) = interval?;
        enter = enter.max(from);
        leave = leave.min(to);
    }
    (enter <= leave).then_some(enter)
}

fn ball(p: &Vec3, d: &Vec3, radius: f64) -> Option<f64> {
    within([quadratic(
        d.norm_squared(),
        p.dot(d),
        p.norm_squared() - radius * radius,
    )])
}

/// A cylinder along z with its flat ends.
fn tube(p: &Vec3, d: &Vec3, radius: f64, half_length: f64) -> Option<f64> {
    let (a, b) = (d.x * d.x + d.y * d.y, p.x * d.x + p.y * d.y);
    let c = p.x * p.x + p.y * p.y - radius * radius;
    // Below this the ray runs along the axis and the quadratic's roots mean nothing.
    let side = if a < 1e-18 {
        quadratic(0.0, 0.0, c)
    } else {
        quadratic(a, b, c)
    };
    within([side, slab(p.z, d.z, half_length)])
}

/// A solid as it is seen from one point E: made ready for many segments that begin there.
#[derive(Debug, Clone)]
pub struct Seen<'a> {
    solid: &'a Solid,
    R_SW: Matrix3<f64>,
    /// E, measured and expressed in S [m].
    p_SE: Vec3,
    /// Whether all is finite; what is not hides everything.
    is_sound: bool,
}

impl<'a> Seen<'a> {
    /// Makes the solid at `X_WS` ready for segments from `p_WE` [m].
    pub fn new(solid: &'a Solid, X_WS: &Pose, p_WE: &Vec3) -> Seen<'a> {
        let R_SW = X_WS.rotation.to_rotation_matrix().matrix().transpose();
        let p_SE = R_SW * (p_WE - X_WS.translation.vector);
        Seen {
            solid,
            R_SW,
            p_SE,
            is_sound: (R_SW.sum() + p_SE.sum()).is_finite(),
        }
    }

    /// Returns the radius of the sphere about the solid's origin that contains it [m], and that origin measured from E [m].
    pub fn ball(&self) -> (Vec3, f64) {
        (-self.R_SW.tr_mul(&self.p_SE), self.solid.radius)
    }

    /// Says whether the segment of points `E + t * way_W`, t from 0 to `until` (at most 1), has a point in the solid; `way_W` [m] is
    /// expressed in the world. The same answer as that of [`ray`] but for rounding.
    pub fn cuts(&self, way_W: &Vec3, until: f64) -> bool {
        let (p, d) = (&self.p_SE, &(self.R_SW * way_W));
        let round = self.solid.round;
        if !self.is_sound || !(d.sum() + until).is_finite() {
            return true;
        }
        match self.solid.core {
            Core::Point => ball_cut(p, d, until, round),
            Core::Segment { half_length } => {
                let cap = |z: f64| ball_cut(&(p - Vec3::new(0.0, 0.0, z)), d, until, round);
                cap(half_length) || cap(-half_length) || tube(p, d, round, half_length).is_some_and(|t| t <= until)
            }
            Core::Box { half } => box_cut(p, d, until, &half.add_scalar(round)),
            Core::Cylinder { radius, half_length } => {
                tube(p, d, radius + round, half_length + round).is_some_and(|t| t <= until)
            }
            Core::Hull(ref hull) => hull.cuts(p, d, until, round),
        }
    }
}

/// Whether the segment passes within `radius` of the origin.
fn ball_cut(p: &Vec3, d: &Vec3, until: f64, radius: f64) -> bool {
    let (along, length2) = (-p.dot(d), d.norm_squared());
    let (r2, p2) = (radius * radius, p.norm_squared());
    if along <= 0.0 {
        return p2 <= r2;
    }
    if along >= until * length2 {
        return (p + d * until).norm_squared() <= r2;
    }
    // The distance from the line, squared, times the length squared.
    (p2 - r2) * length2 <= along * along
}

/// Separating axes of a segment and a box about the origin: the box's own and their cross products with the segment.
fn box_cut(p: &Vec3, d: &Vec3, until: f64, half: &Vec3) -> bool {
    let h = d * (0.5 * until);
    let m = p + h;
    let a = h.abs();
    if m.x.abs() > half.x + a.x || m.y.abs() > half.y + a.y || m.z.abs() > half.z + a.z {
        return false;
    }
    (m.y * h.z - m.z * h.y).abs() <= half.y * a.z + half.z * a.y
        && (m.z * h.x - m.x * h.z).abs() <= half.x * a.z + half.z * a.x
        && (m.x * h.y - m.y * h.x).abs() <= half.x * a.y + half.y * a.x
}
