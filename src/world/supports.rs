//! Where things can be placed on an object, from its shape (thesis 3.3.1, supports).
//!
//! The upward faces of boxes and hulls, and the tops of upright cylinders, as rectangles (a disc gives its largest square), unless another part
//! covers the face's middle. Up is the z axis of the object frame.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use super::{Part, Support};
use crate::geom::hull::Hull;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3, pose_xyz_rpy};

/// A face this far from level is no support [rad].
const LEVEL: f64 = 1e-3;
/// A smaller rectangle carries nothing [m], half a side.
const SMALLEST: f64 = 0.01;

/// Returns the supports, highest first; the highest is named `top`, the others `top 2`, `top 3` ..
pub fn supports(parts: &[Part]) -> Vec<Support> {
    let mut found: Vec<Support> = parts
        .iter()
        .enumerate()
        .filter_map(|(p, part)| {
            let (X_SF, half) = up_face(part)?;
            let X_OF = part.X_OS * X_SF;
            let above = X_OF * nalgebra::Point3::new(0.0, 0.0, 1e-3);
            let covered = parts
                .iter()
                .enumerate()
                .any(|(q, other)| q != p && holds(other, &above.coords));
            let wide = half[0] >= SMALLEST && half[1] >= SMALLEST;
            (wide && !covered).then(|| Support {
                name: String::new(),
                X_OF,
                half,
            })
        })
        .collect();
    found.sort_by(|a, b| b.X_OF.translation.z.total_cmp(&a.X_OF.translation.z));
    for (n, support) in found.iter_mut().enumerate() {
        support.name = if n == 0 {
            "top".to_string()
        } else {
            format!("top {}", n + 1)
        };
    }
    found
}

/// Returns the pose of the part's upward face in its shape frame, and half of the rectangle's sides.
fn up_face(part: &Part) -> Option<(Pose, [f64; 2])> {
    let up = part.X_OS.rotation.inverse() * Vec3::z();
    let level = |axis: &Vec3| up.dot(axis).abs() >= 1.0 - LEVEL * LEVEL / 2.0;
    match &part.shape {
        Shape::Box { half } => {
            if level(&Vec3::z()) {
                let turn = if up.z > 0.0 { 0.0 } else { 2.0 * FRAC_PI_2 };
                let X_SF = pose_xyz_rpy([0.0, 0.0, half.z * up.z.signum()], [turn, 0.0, 0.0]);
                Some((X_SF, [half.x, half.y]))
            } else if level(&Vec3::x()) {
                let X_SF = pose_xyz_rpy(
                    [half.x * up.x.signum(), 0.0, 0.0],
                    [0.0, FRAC_PI_2 * up.x.signum(), 0.0],
                );
                Some((X_SF, [half.z, half.y]))
            } else if level(&Vec3::y()) {
                let X_SF = pose_xyz_rpy(
                    [0.0, half.y * up.y.signum(), 0.0],
                    [-FRAC_PI_2 * up.y.signum(), 0.0, 0.0],
                );
                Some((X_SF, [half.x, half.z]))
            } else {
                None
            }
        }
        Shape::Cylinder { radius, half_length } if level(&Vec3::z()) => {
            let turn = if up.z > 0.0 { 0.0 } else { 2.0 * FRAC_PI_2 };
            let X_SF = pose_xyz_rpy([0.0, 0.0, half_length * up.z.signum()], [turn, 0.0, 0.0]);
            Some((X_SF, [radius * FRAC_1_SQRT_2; 2]))
        }
        Shape::Hull(hull) => level_face(hull, &up),
        Shape::Cylinder { .. } | Shape::Sphere { .. } | Shape::Capsule { .. } => None,
    }
}

/// Returns a rectangle about the middle of the hull's level upward face: with the sides' ratio of the box about the face, as large
/// as fits.
fn level_face(hull: &Hull, up_S: &Vec3) -> Option<(Pose, [f64; 2])> {
    let face = hull
        .faces
        .iter()
        .find(|f| f.normal.dot(up_S) >= 1.0 - LEVEL * LEVEL / 2.0)?;
    let corners: Vec<Vec3> = face.corners.iter().map(|c| hull.vertices[*c]).collect();
    let middle = corners.iter().sum::<Vec3>() / corners.len() as f64;
    // Along the longest edge, where most level faces have their long side.
    let edges = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| b - a);
    let x = edges
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))?
        .try_normalize(1e-9)?;
    let y = face.normal.cross(&x);
    let flat: Vec<[f64; 2]> = corners
        .iter()
        .map(|c| [(c - middle).dot(&x), (c - middle).dot(&y)])
        .collect();
    let reach = |axis: usize| flat.iter().map(|p| p[axis].abs()).fold(0.0, f64::max);
    let (a, b) = (reach(0), reach(1));
    // Each edge bounds the scale at which the corner that is farthest along its outward normal is still inside.
    let next = flat.iter().cycle().skip(1);
    let bounds = flat.iter().zip(next).map(|(p, q)| {
        let (nx, ny) = (q[1] - p[1], p[0] - q[0]);
        (nx * p[0] + ny * p[1]) / (nx.abs() * a + ny.abs() * b)
    });
    let scale = bounds.fold(1.0_f64, f64::min).max(0.0);
    let R_SF = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, face.normal]));
    let X_SF = Pose::from_parts(middle.into(), UnitQuaternion::from_rotation_matrix(&R_SF));
    Some((X_SF, [scale * a, scale * b]))
}

/// Says whether the point, measured in O, lies in the part.
pub fn holds(part: &Part, p_O: &Vec3) -> bool {
    let p = part.X_OS.inverse() * nalgebra::Point3::from(*p_O);
    let across = (p.x * p.x + p.y * p.y).sqrt();
    match &part.shape {
        Shape::Hull(hull) => hull.contains(&p.coords),
        Shape::Box { half } => p.x.abs() <= half.x && p.y.abs() <= half.y && p.z.abs() <= half.z,
        Shape::Cylinder { radius, half_length } => across <= *radius && p.z.abs() <= *half_length,
        Shape::Sphere { radius } => p.coords.norm() <= *radius,
        Shape::Capsule { radius, half_length } => {
            let along = (p.z.abs() - half_length).max(0.0);
            (across * across + along * along).sqrt() <= *radius
        }
    }
}
