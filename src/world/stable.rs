//! Orientations in which an object stands on a level face, from its shape (thesis 3.3.1, stable configurations).
//!
//! Tries the six axes of the object frame as "up", and keeps those where the bottom is a polygon with the centre of volume above its
//! inside. So a ball, a capsule and a lying cylinder, which would roll, have none. Orientations between the axes are tried for hulls
//! alone: those with one of the largest faces down.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::{ComplexField, UnitQuaternion};
use std::f64::consts::{FRAC_PI_2, PI};

use super::{Part, Stable};
use crate::geom::hull::Face;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};

/// Points of a shape this near to its lowest one are its bottom [m].
const FLAT: f64 = 1e-6;
/// The centre of volume must lie this far inside the bottom polygon [m].
const INSIDE: f64 = 1e-3;
/// A hull stands on this many of its faces at most, besides those that an axis is normal to.
const FACES: usize = 6;
/// It stands on no face that is smaller than this share of the largest.
const MOST_OF_LARGEST: f64 = 0.2;
/// Corners of the polygon that stands for a disc.
const DISC: usize = 16;

/// Returns the orientations in which the parts together stand, named by the axis of O that points up (`+z`, `-z`, `+x` ..).
pub fn stable_orientations(parts: &[Part]) -> Vec<Stable> {
    let about = |axis: Vec3, angle: f64| UnitQuaternion::from_scaled_axis(axis * angle);
    [
        ("+z", UnitQuaternion::identity()),
        ("-z", about(Vec3::x(), PI)),
        ("+x", about(Vec3::y(), -FRAC_PI_2)),
        ("-x", about(Vec3::y(), FRAC_PI_2)),
        ("+y", about(Vec3::x(), FRAC_PI_2)),
        ("-y", about(Vec3::x(), -FRAC_PI_2)),
    ]
    .into_iter()
    .map(|(name, R_QO)| (name.to_string(), R_QO))
    .chain(on_faces(parts))
    .filter_map(|(name, R_QO)| stand(&name, parts, R_QO))
    .collect()
}

/// Returns the orientations in which a large face of a hull is down, unless an axis of O is up then.
fn on_faces(parts: &[Part]) -> Vec<(String, UnitQuaternion<f64>)> {
    let mut faces: Vec<(f64, Vec3)> = Vec::new();
    for part in parts {
        if let Shape::Hull(hull) = &part.shape {
            let area = |f: &Face| -> f64 {
                let sides =
                    |[a, b, c]: [usize; 3]| (hull.vertices[b] - hull.vertices[a], hull.vertices[c] - hull.vertices[a]);
                f.triangles().map(sides).map(|(u, v)| u.cross(&v).norm() / 2.0).sum()
            };
            faces.extend(hull.faces.iter().map(|f| (area(f), part.X_OS.rotation * f.normal)));
        }
    }
    let is_axis = |normal: &Vec3| normal.amax() > 1.0 - 1e-9;
    let least = MOST_OF_LARGEST * faces.iter().map(|(area, _)| *area).fold(0.0, f64::max);
    faces.retain(|(area, normal)| *area >= least && !is_axis(normal));
    faces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let down = -Vec3::z();
    let turn = |normal: &Vec3| UnitQuaternion::rotation_between(normal, &down);
    let turns = faces.iter().take(FACES).filter_map(|(_, normal)| turn(normal));
    turns.enumerate().map(|(n, R)| (format!("face {}", n + 1), R)).collect()
}

/// Returns how the parts stand when turned by `R_QO`, or `None` when they would tip or roll.
pub fn stand(name: &str, parts: &[Part], R_QO: UnitQuaternion<f64>) -> Option<Stable> {
    let p_OC = centroid(parts);
    let p_QC = R_QO * p_OC;
    let points: Vec<Vec3> = parts
        .iter()
        .flat_map(|part| low_points(&part.shape, &(Pose::from_parts(Vec3::zeros().into(), R_QO) * part.X_OS)))
        .map(|p| p - Vec3::new(p_QC.x, p_QC.y, 0.0))
        .collect();
    let lowest = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let bottom = points.iter().filter(|p| p.z <= lowest + FLAT).map(|p| [p.x, p.y]);
    let footprint = convex_hull(bottom.collect());
    let stands = footprint.len() >= 3 && edges(&footprint).all(|(a, b)| left_of(a, b, [0.0, 0.0]) >= INSIDE);
    stands.then(|| Stable {
        name: name.to_string(),
        X_QO: Pose::from_parts(Vec3::new(-p_QC.x, -p_QC.y, -lowest).into(), R_QO),
        footprint,
    })
}

/// Returns the centre of volume of one part, measured in O.
fn centre(part: &Part) -> Vec3 {
    (part.X_OS * nalgebra::Point3::from(part.shape.centre())).coords
}

/// Returns the centre of volume C, `p_OC`; parts that overlap count twice there.
pub fn centroid(parts: &[Part]) -> Vec3 {
    let volume: f64 = parts.iter().map(|p| p.shape.volume()).sum();
    if volume <= 0.0 {
        return Vec3::zeros();
    }
    let moment: Vec3 = parts.iter().map(|p| centre(p) * p.shape.volume()).sum();
    moment / volume
}

/// Returns points of the shape, among them all corners of its lowest face, edge or the lowest point; `X_QS` is its pose.
fn low_points(shape: &Shape, X_QS: &Pose) -> Vec<Vec3> {
    let point = |x: f64, y: f64, z: f64| (X_QS * nalgebra::Point3::new(x, y, z)).coords;
    let down = Vec3::new(0.0, 0.0, -1.0);
    match shape {
        Shape::Box { half } => (0..8)
            .map(|corner| {
                let side = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
                point(side(1) * half.x, side(2) * half.y, side(4) * half.z)
            })
            .collect(),
        Shape::Cylinder { radius, half_length } => {
            // The rim's lowest point lies where the axis leans; an upright cylinder has a whole rim of them.
            let down_S = X_QS.rotation.inverse() * down;
            let across = Vec3::new(down_S.x, down_S.y, 0.0);
            let rim: Vec<Vec3> = match across.try_normalize(1e-9) {
                Some(lean) => vec![lean * *radius],
                None => (0..DISC)
                    .map(|i| {
                        let angle = 2.0 * PI * i as f64 / DISC as f64;
                        Vec3::new(ComplexField::cos(angle), ComplexField::sin(angle), 0.0) * *radius
                    })
                    .collect(),
            };
            rim.iter()
                .flat_map(|p| [-1.0, 1.0].map(|end| point(p.x, p.y, end * half_length)))
                .collect()
        }
        Shape::Sphere { radius } => vec![point(0.0, 0.0, 0.0) + down * *radius],
        Shape::Hull(hull) => hull.vertices.iter().map(|v| point(v.x, v.y, v.z)).collect(),
        Shape::Capsule { radius, half_length } => [-1.0, 1.0]
            .map(|end| point(0.0, 0.0, end * half_length) + down * *radius)
            .to_vec(),
    }
}

/// Returns twice the area of the triangle a, b, p divided by the length of a b: the distance of p to the left of a b [m].
fn left_of(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = (ab[0] * ab[0] + ab[1] * ab[1]).sqrt();
    if length == 0.0 {
        return 0.0;
    }
    (ab[0] * ap[1] - ab[1] * ap[0]) / length
}

fn edges(polygon: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().copied().zip(next.copied())
}

/// Returns the convex hull, counter-clockwise, without points on its edges (Andrew's monotone chain, 1979,
/// doi:10.1016/0020-0190(79)90072-3).
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain.as_slice()
                && left_of(*a, *b, p) <= FLAT
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}
