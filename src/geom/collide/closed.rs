//! Distances between cores that have a closed form: segments and points with each other, a point with a box or a cylinder.
//!
//! Segments after Ericson, Real-Time Collision Detection, 2005, section 5.1.9.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::Core;
use crate::geom::{Pose, Vec3};

/// Returns the distance between two cores [m], negative by the depth when a point lies inside; `None` when there is no closed form.
#[inline]
pub fn signed_distance(a: &Core, b: &Core, X_AB: &Pose) -> Option<f64> {
    match (a, b) {
        (Core::Point, Core::Point) => Some(X_AB.translation.vector.norm()),
        (Core::Point, _) => Some(point(b, &X_AB.inverse().translation.vector)?),
        (_, Core::Point) => point(a, &X_AB.translation.vector),
        (Core::Segment { half_length: h }, Core::Segment { half_length: k }) => {
            Some(segments(*h, *k, &X_AB.translation.vector, &(X_AB.rotation * Vec3::z())))
        }
        _ => None,
    }
}

/// Signed distance of the point `p` to a core, in the core's frame.
fn point(core: &Core, p: &Vec3) -> Option<f64> {
    Some(match *core {
        Core::Point => p.norm(),
        Core::Segment { half_length } => {
            let beyond = (p.z.abs() - half_length).max(0.0);
            (p.x * p.x + p.y * p.y + beyond * beyond).sqrt()
        }
        Core::Box { half } => {
            let out = p.abs() - half;
            let apart = out.map(|v| v.max(0.0)).norm();
            if apart > 0.0 { apart } else { out.max() }
        }
        // A corner or an edge may be nearest: not worth a closed form.
        Core::Hull(_) => return None,
        Core::Cylinder { radius, half_length } => {
            let across = (p.x * p.x + p.y * p.y).sqrt() - radius;
            let along = p.z.abs() - half_length;
            let apart = (across.max(0.0).powi(2) + along.max(0.0).powi(2)).sqrt();
            if apart > 0.0 { apart } else { across.max(along) }
        }
    })
}

/// Distance between the segment of half length `h` about the origin along z, and that of half length `k` about `p` along the unit `d`.
fn segments(h: f64, k: f64, p: &Vec3, d: &Vec3) -> f64 {
    // Points s z and p + t d; their distance is a convex quadratic of (s, t).
    let (cosine, sine2) = (d.z, d.x * d.x + d.y * d.y);
    let along_d = p.dot(d);
    let clamp = |v: f64, limit: f64| v.max(-limit).min(limit);
    let mut s = if sine2 > 1e-12 {
        clamp((p.z - cosine * along_d) / sine2, h)
    } else {
        clamp(p.z, h)
    };
    let t = clamp(s * cosine - along_d, k);
    s = clamp(p.z + t * cosine, h);
    // Parallel segments: any `s` will do from which both steps end at a nearest pair, which the second clamp ensures.
    (p + d * t - Vec3::new(0.0, 0.0, s)).norm()
}
