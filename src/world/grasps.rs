//! Grasps of a parallel gripper, from an object's shape (thesis 3.3.1, which precomputes them elsewhere).
//!
//! Antipodal: the fingers close on opposite faces, or across a diameter. Each part is grasped on its own,
//! where other parts leave room for the fingers; whether the hand hits them, or a table, is found when the grasp is used, as is whether a given gripper opens wide enough.
//! A gripper is taken for symmetric: turning it half about its approach is the same grasp.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::{ComplexField, Matrix3, Rotation3, UnitQuaternion};
use std::f64::consts::PI;

use super::supports::holds;
use super::{Grasp, Part};
use crate::geom::hull::Hull;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};

/// Nothing wider is grasped [m]. HEURISTIC: a little less than the widest gripper that ships opens.
const WIDEST: f64 = 0.08;
/// The tool goes at most this deep below the near face [m]. HEURISTIC: half of a finger that reaches 0.06 m out of its palm.
const DEPTH: f64 = 0.03;
/// A finger needs this much room beside the face that it closes on [m].
const FINGER: f64 = 0.005;
/// A finger holds on a face this far from square to it, as a cosine. HEURISTIC: the cone of friction of 0.3.
const FRICTION: f64 = 0.957;
/// Directions nearer than this, as a cosine, are one.
const ALIKE: f64 = 0.95;
/// Closing directions of a hull that are tried.
const CLOSINGS: usize = 8;
/// Directions around a round shape.
const AROUND: usize = 8;
/// A round shape longer than this is grasped below and above its middle, too [m].
const LONG: f64 = 0.12;

/// Returns the grasps of all parts. Names tell the side from which the hand comes and the axis along which the fingers close
/// (`+z/x`), with the part before it when there are several (`part 2 +z/x`).
pub fn grasps(parts: &[Part]) -> Vec<Grasp> {
    let mut all = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let prefix = if parts.len() > 1 {
            format!("part {} ", p + 1)
        } else {
            String::new()
        };
        for (name, X_ST, width) in of_shape(&part.shape) {
            let X_OT = part.X_OS * X_ST;
            let room = |side: f64| {
                let p_OF = X_OT * nalgebra::Point3::new(0.0, side * (width / 2.0 + FINGER), 0.0);
                !parts.iter().any(|other| holds(other, &p_OF.coords))
            };
            if room(1.0) && room(-1.0) {
                let name = format!("{prefix}{name}");
                all.push(Grasp { name, X_OT, width });
            }
        }
    }
    all
}

fn of_shape(shape: &Shape) -> Vec<(String, Pose, f64)> {
    match shape {
        Shape::Box { half } => of_box(half),
        Shape::Sphere { radius } => of_box(&Vec3::repeat(*radius)),
        Shape::Cylinder { radius, half_length } => {
            let mut found = of_round(*radius, *half_length, *half_length);
            if 2.0 * half_length <= WIDEST {
                found.extend((0..AROUND).map(|i| {
                    let side = around(i, AROUND);
                    let tool = tool_at(side, side * (radius - radius.min(DEPTH)), Vec3::z());
                    (format!("side {}/z", degrees(i, AROUND)), tool, 2.0 * half_length)
                }));
            }
            found
        }
        Shape::Capsule { radius, half_length } => of_round(*radius, half_length + radius, *half_length),
        Shape::Hull(hull) => of_hull(hull),
    }
}

/// A hull: lines across it that meet both faces within the cone of friction, at a depth below each side from which the hand comes.
///
/// The fingers close along an axis of the frame or the normal of a large face; the hand comes from the four sides about it.
fn of_hull(hull: &Hull) -> Vec<(String, Pose, f64)> {
    let axes = [(Vec3::x(), "x"), (Vec3::y(), "y"), (Vec3::z(), "z")];
    let mut closings: Vec<(Vec3, String)> = axes.iter().map(|(d, n)| (*d, (*n).to_string())).collect();
    for (i, face) in hull.faces.iter().enumerate() {
        let is_known = closings.iter().any(|(d, _)| d.dot(&face.normal).abs() > ALIKE);
        if !is_known && closings.len() < CLOSINGS {
            closings.push((face.normal, format!("face {}", i + 1)));
        }
    }
    let centre = hull.centre();
    let mut found = Vec::new();
    for (closing, closing_name) in &closings {
        let mut sides: Vec<(Vec3, String)> = Vec::new();
        for (axis, axis_name) in axes.iter().rev() {
            // The axis as far as it is across the closing direction.
            let Some(across) = (axis - closing * axis.dot(closing)).try_normalize(0.5) else {
                continue;
            };
            if sides.iter().any(|(side, _)| side.dot(&across).abs() > ALIKE) {
                continue;
            }
            sides.push((across, format!("+{axis_name}")));
            sides.push((-across, format!("-{axis_name}")));
        }
        for (outward, side_name) in sides {
            let Some(way) = hull.crossing(&centre, &outward, 0.0) else {
                continue;
            };
            let p = centre + outward * (way.leave - way.leave.min(DEPTH));
            let Some(chord) = hull.crossing(&p, closing, 0.0) else {
                continue;
            };
            let width = chord.leave - chord.enter;
            let (far, near) = (&hull.faces[chord.leave_face], &hull.faces[chord.enter_face]);
            let holds = far.normal.dot(closing) >= FRICTION && -near.normal.dot(closing) >= FRICTION;
            if holds && width <= WIDEST {
                let middle = p + closing * ((chord.enter + chord.leave) / 2.0);
                let tool = tool_at(outward, middle, *closing);
                found.push((format!("{side_name}/{closing_name}"), tool, width));
            }
        }
    }
    found
}

/// A box: each pair of faces that is near enough, from each of the four sides between them.
fn of_box(half: &Vec3) -> Vec<(String, Pose, f64)> {
    let axes = [
        (Vec3::x(), half.x, "x"),
        (Vec3::y(), half.y, "y"),
        (Vec3::z(), half.z, "z"),
    ];
    let mut found = Vec::new();
    for (closing, h_closing, closing_name) in &axes {
        if 2.0 * h_closing > WIDEST {
            continue;
        }
        for (side, h_side, side_name) in axes.iter().rev().filter(|(_, _, n)| n != closing_name) {
            for (sign, sign_name) in [(1.0, "+"), (-1.0, "-")] {
                let outward = side * sign;
                let tool = tool_at(outward, outward * (h_side - h_side.min(DEPTH)), *closing);
                found.push((format!("{sign_name}{side_name}/{closing_name}"), tool, 2.0 * h_closing));
            }
        }
    }
    found
}

/// A round shape about z: from both ends, `end` from its middle; from around, at heights within `straight` of its middle.
fn of_round(radius: f64, end: f64, straight: f64) -> Vec<(String, Pose, f64)> {
    let mut found = Vec::new();
    let width = 2.0 * radius;
    if width > WIDEST {
        return found;
    }
    for (sign, sign_name) in [(1.0, "+"), (-1.0, "-")] {
        for i in 0..AROUND / 2 {
            let outward = Vec3::z() * sign;
            let tool = tool_at(outward, outward * (end - end.min(DEPTH)), around(i, AROUND));
            found.push((format!("{sign_name}z/{}", degrees(i, AROUND)), tool, width));
        }
    }
    let heights: &[(f64, &str)] = if 2.0 * end > LONG {
        &[(0.0, "middle"), (0.5, "high"), (-0.5, "low")]
    } else {
        &[(0.0, "middle")]
    };
    for (share, height_name) in heights {
        for i in 0..AROUND {
            let side = around(i, AROUND);
            let p_ST = side * (radius - radius.min(DEPTH)) + Vec3::z() * (share * straight);
            let tool = tool_at(side, p_ST, Vec3::z().cross(&side));
            found.push((format!("side {} {height_name}", degrees(i, AROUND)), tool, width));
        }
    }
    found
}

/// Returns the pose of a tool at `p_ST` that came from the side `outward` and closes along `closing`.
fn tool_at(outward: Vec3, p_ST: Vec3, closing: Vec3) -> Pose {
    let x = -outward;
    let R_ST = Matrix3::from_columns(&[x, closing, x.cross(&closing)]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R_ST));
    Pose::from_parts(p_ST.into(), turn)
}

/// Returns the `i`-th of `n` directions around z.
fn around(i: usize, n: usize) -> Vec3 {
    let angle = 2.0 * PI * i as f64 / n as f64;
    Vec3::new(ComplexField::cos(angle), ComplexField::sin(angle), 0.0)
}

fn degrees(i: usize, n: usize) -> usize {
    360 * i / n
}
