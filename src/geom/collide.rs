//! Contact, distance and rays between convex shapes: the only user of `parry`.
//!
//! A solid is the Minkowski sum of a core (point, segment, box, cylinder or hull) and a ball, so that spheres, capsules and padding cost
//! nothing. Pairs of round solids, and points against boxes and cylinders, have closed forms; two boxes are tested on 15 axes
//! (Gottschalk, Lin, Manocha, SIGGRAPH 1996, doi:10.1145/237170.237244); the rest goes to parry's GJK (Gilbert, Johnson, Keerthi 1988,
//! doi:10.1109/56.2083) and EPA, on our own support functions, since parry's cylinders lie along y and ours along z.
//! Knows no link and no object: who may touch whom is the caller's affair. Nothing here is a broad phase.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

mod boxes;
mod closed;
mod rays;

use std::sync::Arc;

use parry3d_f64::math::{Pose as ParryPose, Rotation as ParryRotation, Vector as ParryVector};
use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

use super::{Pose, Vec3, hull::Hull, shape::Shape};

pub use rays::{Seen, ray};

/// A shape prepared for queries, in its own frame S.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    pub(in crate::geom) core: Core,
    /// Radius of the ball that is added to the core [m].
    pub(in crate::geom) round: f64,
    /// Half sides of the box about the core, along the axes of S [m].
    pub(in crate::geom) half: Vec3,
    /// Radius of the sphere about the origin of S that contains everything [m].
    radius: f64,
}

/// A convex set about the origin; axes along z [m].
#[derive(Debug, Clone, PartialEq)]
pub(in crate::geom) enum Core {
    Point,
    Segment { half_length: f64 },
    Box { half: Vec3 },
    Cylinder { radius: f64, half_length: f64 },
    Hull(Arc<Hull>),
}

impl Solid {
    /// Returns the solid of a shape.
    pub fn new(shape: &Shape) -> Solid {
        Solid::padded(shape, 0.0)
    }

    /// Returns the set of points within `margin` [m] of the shape.
    ///
    /// A negative margin shrinks: each side moves in by as much, at most to the middle.
    pub fn padded(shape: &Shape, margin: f64) -> Solid {
        let (out, inward) = (margin.max(0.0), margin.min(0.0));
        let shrink = |length: f64| (length + inward).max(0.0);
        let (core, round) = match *shape {
            Shape::Hull(ref hull) if inward == 0.0 => (Core::Hull(Arc::clone(hull)), out),
            Shape::Hull(ref hull) => match hull.moved_in(|_| -inward) {
                Some(smaller) => (Core::Hull(Arc::new(smaller)), out),
                None => (Core::Point, out),
            },
            Shape::Box { half } => (Core::Box { half: half.map(shrink) }, out),
            Shape::Cylinder { radius, half_length } => (
                Core::Cylinder {
                    radius: shrink(radius),
                    half_length: shrink(half_length),
                },
                out,
            ),
            Shape::Sphere { radius } => (Core::Point, shrink(radius) + out),
            Shape::Capsule { radius, half_length } => (Core::Segment { half_length }, shrink(radius) + out),
        };
        let (half, reach) = match core {
            Core::Hull(ref hull) => {
                let reach = hull.vertices.iter().map(Vec3::norm).fold(0.0, f64::max);
                (hull.half_extents(), reach)
            }
            Core::Point => (Vec3::zeros(), 0.0),
            Core::Segment { half_length } => (Vec3::new(0.0, 0.0, half_length), half_length),
            Core::Box { half } => (half, half.norm()),
            Core::Cylinder { radius, half_length } => (
                Vec3::new(radius, radius, half_length),
                (radius * radius + half_length * half_length).sqrt(),
            ),
        };
        Solid {
            core,
            round,
            half,
            radius: reach + round,
        }
    }

    /// Returns the radius of the sphere about the solid's frame origin that contains it [m].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns half the sides [m] of a box around it in the world, its axes along those of W and its middle at the origin of S.
    pub fn half_extent(&self, X_WS: &Pose) -> Vec3 {
        let R_WS = X_WS.rotation.to_rotation_matrix();
        R_WS.matrix().abs() * self.half + Vec3::repeat(self.round)
    }
}

/// Returns whether two solids have a point in common. Poses that are not finite touch everything.
pub fn touch(a: &Solid, X_WA: &Pose, b: &Solid, X_WB: &Pose) -> bool {
    within(a, X_WA, b, X_WB, 0.0)
}

/// Returns whether two solids come within `margin` of each other [m, not negative]: whether they touch when one is padded by it.
pub fn within(a: &Solid, X_WA: &Pose, b: &Solid, X_WB: &Pose, margin: f64) -> bool {
    let between = (X_WB.translation.vector - X_WA.translation.vector).norm_squared();
    let most = a.radius + margin + b.radius;
    if between > most * most {
        return false;
    }
    let X_AB = X_WA.inv_mul(X_WB);
    if !is_finite(&X_AB) {
        return true;
    }
    let round = a.round + margin + b.round;
    if let Some(distance) = closed::signed_distance(&a.core, &b.core, &X_AB) {
        return distance <= round;
    }
    if let Some(answer) = by_rounder_cores(&a.core, &b.core, round, &X_AB) {
        return answer;
    }
    // The gap between the cores' boxes is at most the gap between the cores.
    let gap = boxes::gap(&a.half, &b.half, &X_AB, round);
    if gap > round {
        return false;
    }
    if gap <= 0.0 && a.core.is_its_box() && b.core.is_its_box() {
        return true;
    }
    if round > 0.0 {
        return gjk_distance(a, b, &X_AB, round).is_some_and(|distance| distance <= round);
    }
    let X_AB = to_parry(&X_AB);
    let mut simplex = start_simplex(&a.core, &b.core, &X_AB);
    match gjk::closest_points(&X_AB, &a.core, &b.core, 0.0, false, &mut simplex) {
        GJKResult::Intersection => true,
        GJKResult::ClosestPoints(..) | GJKResult::Proximity(_) => false,
        // Also returned, with any direction, when the iterations ran out; only a direction that parts the cores is an answer.
        GJKResult::NoIntersection(d) => reach(&a.core, &b.core, &X_AB, d) >= 0.0,
    }
}

/// The answer of the capsules around cylinders, if they are apart, or of those within, if they touch; most pairs need no more.
fn by_rounder_cores(a: &Core, b: &Core, round: f64, X_AB: &Pose) -> Option<bool> {
    let distance = |(c, r): (Core, f64), (d, s): (Core, f64)| {
        closed::signed_distance(&c, &d, X_AB).map(|distance| distance - r - s - round)
    };
    if distance(a.capsule_around()?, b.capsule_around()?)? > 0.0 {
        return Some(false);
    }
    (distance(a.capsule_within(), b.capsule_within())? <= 0.0).then_some(true)
}

/// Returns the least distance between two solids [m]; 0 when they touch, or when a pose is not finite.
pub fn distance(a: &Solid, X_WA: &Pose, b: &Solid, X_WB: &Pose) -> f64 {
    (core_distance(a, b, &X_WA.inv_mul(X_WB)) - a.round - b.round).max(0.0)
}

/// Returns how far one of two solids must move at least for them not to overlap [m]; `None` when they do not overlap.
pub fn penetration(a: &Solid, X_WA: &Pose, b: &Solid, X_WB: &Pose) -> Option<f64> {
    let X_AB = X_WA.inv_mul(X_WB);
    if X_AB.translation.vector.norm() >= a.radius + b.radius {
        return None;
    }
    let round = a.round + b.round;
    let apart = core_distance(a, b, &X_AB);
    let depth = if apart > 0.0 {
        round - apart
    } else {
        round + core_depth(a, b, &X_AB)
    };
    (depth > 0.0).then_some(depth)
}

/// Distance between the cores; 0 when they overlap.
fn core_distance(a: &Solid, b: &Solid, X_AB: &Pose) -> f64 {
    if !is_finite(X_AB) {
        return 0.0;
    }
    if let Some(distance) = closed::signed_distance(&a.core, &b.core, X_AB) {
        return distance.max(0.0);
    }
    gjk_distance(a, b, X_AB, f64::MAX).unwrap_or(0.0)
}

/// Distance between the cores by GJK; `None` when it is more than `max`.
fn gjk_distance(a: &Solid, b: &Solid, X_AB: &Pose, max: f64) -> Option<f64> {
    let X = to_parry(X_AB);
    let (distance, is_certain) = gjk_once(&a.core, &b.core, &X, max)?;
    if is_certain {
        return Some(distance);
    }
    // A stalled GJK, which happens with long and thin cylinders, still has two points of the cores: the nearer pair is the better answer.
    let other = gjk_once(&b.core, &a.core, &X.inverse(), max);
    Some(other.map_or(distance, |(other, _)| distance.min(other)))
}

/// An upper bound of the distance, and whether a lower bound confirms it.
fn gjk_once(a: &Core, b: &Core, X_AB: &ParryPose, max: f64) -> Option<(f64, bool)> {
    let mut simplex = start_simplex(a, b, X_AB);
    match gjk::closest_points(X_AB, a, b, max, true, &mut simplex) {
        GJKResult::Intersection => Some((0.0, true)),
        GJKResult::ClosestPoints(p, q, _) => {
            let distance = (q - p).length();
            let Some(towards) = (q - p).try_normalize() else {
                return Some((0.0, true));
            };
            Some((
                distance,
                -reach(a, b, X_AB, towards) > distance - CONFIRMED * (1.0 + distance),
            ))
        }
        // The same two cases as in `touch`.
        GJKResult::NoIntersection(d) if -reach(a, b, X_AB, d) > max => None,
        GJKResult::Proximity(_) | GJKResult::NoIntersection(_) => Some((0.0, false)),
    }
}

/// Bounds that differ by less are the same [m].
const CONFIRMED: f64 = 1e-6;

/// How far A - B reaches along the unit `d`: moving B by as much along it parts them; when negative they are apart by at least as much.
fn reach(a: &Core, b: &Core, X_AB: &ParryPose, d: ParryVector) -> f64 {
    CsoPoint::from_shapes(X_AB, a, b, d).point.dot(d)
}

/// Least translation that parts two cores which overlap.
fn core_depth(a: &Solid, b: &Solid, X_AB: &Pose) -> f64 {
    if !is_finite(X_AB) {
        return 0.0;
    }
    if let Some(distance) = closed::signed_distance(&a.core, &b.core, X_AB) {
        return (-distance).max(0.0);
    }
    // An upper bound for all cores, and exact for those that fill their boxes.
    let by_boxes = (-boxes::gap(&a.half, &b.half, X_AB, f64::INFINITY)).max(0.0);
    if a.core.is_its_box() && b.core.is_its_box() {
        return by_boxes;
    }
    // EPA can stall as well. Each way out is an upper bound, so that the least of some is safe: both orders, and across the cores.
    let X = to_parry(X_AB);
    let across = X.translation.reject_from(X.rotation * ParryVector::Z);
    let across = [across, X.translation.reject_from(ParryVector::Z), X.translation];
    let forth = epa_normal(&a.core, &b.core, &X);
    let back = epa_normal(&b.core, &a.core, &X.inverse()).map(|d| X.rotation * d);
    let ways = across
        .into_iter()
        .chain(forth)
        .chain(back)
        .filter_map(|d| d.try_normalize());
    ways.flat_map(|d| [d, -d])
        .map(|d| reach(&a.core, &b.core, &X, d).max(0.0))
        .fold(by_boxes, f64::min)
}

/// The direction in which EPA finds the least overlap.
fn epa_normal(a: &Core, b: &Core, X_AB: &ParryPose) -> Option<ParryVector> {
    let mut simplex = start_simplex(a, b, X_AB);
    if gjk::closest_points(X_AB, a, b, 0.0, true, &mut simplex) != GJKResult::Intersection {
        return None;
    }
    EPA::new()
        .closest_points(X_AB, a, b, &simplex)
        .map(|(_, _, normal)| normal)
}

fn start_simplex(a: &Core, b: &Core, X_AB: &ParryPose) -> VoronoiSimplex {
    let towards = (-X_AB.translation).try_normalize().unwrap_or(ParryVector::X);
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(X_AB, a, b, towards));
    simplex
}

impl Core {
    /// Whether the core fills the box about it, so that the test of boxes is exact.
    fn is_its_box(&self) -> bool {
        match self {
            Core::Point | Core::Segment { .. } | Core::Box { .. } => true,
            Core::Cylinder { .. } | Core::Hull(_) => false,
        }
    }

    /// A rounder core and the radius to add [m], which contain this one; `None` for a box.
    fn capsule_around(&self) -> Option<(Core, f64)> {
        match *self {
            Core::Box { .. } | Core::Hull(_) => None,
            Core::Cylinder { radius, half_length } => Some((Core::Segment { half_length }, radius)),
            Core::Point | Core::Segment { .. } => Some((self.clone(), 0.0)),
        }
    }

    /// A core and the radius to add [m] that lie within this one.
    fn capsule_within(&self) -> (Core, f64) {
        match *self {
            Core::Cylinder { radius, half_length } if half_length > radius => (
                Core::Segment {
                    half_length: half_length - radius,
                },
                radius,
            ),
            Core::Cylinder { half_length, .. } => (Core::Point, half_length),
            Core::Point | Core::Segment { .. } | Core::Box { .. } | Core::Hull(_) => (self.clone(), 0.0),
        }
    }
}

impl SupportMap for Core {
    #[inline]
    fn local_support_point(&self, d: ParryVector) -> ParryVector {
        match *self {
            Core::Point => ParryVector::ZERO,
            Core::Segment { half_length } => ParryVector::new(0.0, 0.0, half_length.copysign(d.z)),
            Core::Box { half } => ParryVector::new(half.x.copysign(d.x), half.y.copysign(d.y), half.z.copysign(d.z)),
            Core::Cylinder { radius, half_length } => {
                let across = (d.x * d.x + d.y * d.y).sqrt();
                let scale = if across > 0.0 { radius / across } else { 0.0 };
                ParryVector::new(scale * d.x, scale * d.y, half_length.copysign(d.z))
            }
            Core::Hull(ref hull) => {
                let v = hull.support(&Vec3::new(d.x, d.y, d.z));
                ParryVector::new(v.x, v.y, v.z)
            }
        }
    }
}

/// Returns the point of the convex hull of `points` that is nearest to `p`, or one almost as near; `p` itself without points.
pub(super) fn nearest_of_hull(points: &[Vec3], p: &Vec3) -> Vec3 {
    let (cloud, X) = (Cloud(points), to_parry(&Pose::translation(p.x, p.y, p.z)));
    let mut simplex = VoronoiSimplex::new();
    let towards = X.translation.try_normalize().unwrap_or(ParryVector::X);
    simplex.reset(CsoPoint::from_shapes(&X, &cloud, &Core::Point, towards));
    match gjk::closest_points(&X, &cloud, &Core::Point, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(q, _, _) => Vec3::new(q.x, q.y, q.z),
        GJKResult::Intersection => *p,
        // The iterations ran out.
        GJKResult::Proximity(_) | GJKResult::NoIntersection(_) => {
            let nearest = points.iter().min_by(|a, b| (*a - p).norm().total_cmp(&(*b - p).norm()));
            nearest.copied().unwrap_or(*p)
        }
    }
}

/// The convex hull of some points.
struct Cloud<'a>(&'a [Vec3]);

impl SupportMap for Cloud<'_> {
    fn local_support_point(&self, d: ParryVector) -> ParryVector {
        let along = |p: &Vec3| d.x * p.x + d.y * p.y + d.z * p.z;
        let best = self.0.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
        best.map_or(ParryVector::ZERO, |p| ParryVector::new(p.x, p.y, p.z))
    }
}

/// The one door between nalgebra's types and parry's.
#[inline]
fn to_parry(X: &Pose) -> ParryPose {
    let (p, r) = (&X.translation.vector, X.rotation.coords);
    ParryPose::from_parts(
        ParryVector::new(p.x, p.y, p.z),
        ParryRotation::from_xyzw(r.x, r.y, r.z, r.w),
    )
}

#[inline]
fn is_finite(X: &Pose) -> bool {
    (X.translation.vector.sum() + X.rotation.coords.sum()).is_finite()
}
