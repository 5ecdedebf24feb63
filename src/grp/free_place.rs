//! Whether a thing fits somewhere on the support faces of an object: the request `virtualPlace` (thesis 4.4.1).
//!
//! Searches positions and yaws by cells. A cell is given up when the thing, shrunk by as much as any place in the cell can
//! differ from its middle, overlaps something or leaves the face even there; the place is found when the thing itself fits at
//! the middle; else the cell is split (subdivision search: Brooks & Lozano-Perez 1985, doi:10.1109/TSMC.1985.6313352). What has [`FINEST`] to
//! spare on all sides is found unless [`MAX_CELLS`] are not enough; what is found is free. No random numbers.
//!
//! Differs from the thesis: agents, and what they hold, do not count, since they can draw back; only things do.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_8, PI, TAU};
use std::sync::Arc;

use nalgebra::ComplexField;

use super::facts::{OVERHANG, is_level, placed_pose};
use super::prepared::{Owner, Placed, Prepared, overlap, place_all};
use crate::geom::collide::Solid;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{EntityRef, Part, Scene, Stable, State, Support};

/// A cell whose places differ by no more than this from its middle is not split further [m].
pub(super) const FINEST: f64 = 0.005;
/// Budget of one question, over all faces and orientations.
const MAX_CELLS: u32 = 20_000;
/// Overlap that is a touch [m].
const TOUCH: f64 = 0.0005;

/// Places (x, y, yaw) on a face: a middle and half widths.
#[derive(Debug, Clone, Copy)]
struct Cell {
    x: f64,
    y: f64,
    yaw: f64,
    half: [f64; 3],
}

/// Returns where `thing` (an object, or a virtual one) can stand on `on`: X_WO; `None` where no place was found.
pub(super) fn find(scene: &Scene, prepared: &Prepared, state: &State, thing: EntityRef, on: usize) -> Option<Pose> {
    let (parts, stable): (&[Part], &[Stable]) = match thing {
        EntityRef::Object(o) => (&scene.objects[o].parts, &scene.objects[o].stable),
        EntityRef::Virtual(v) => (&scene.virtuals[v].parts, &scene.virtuals[v].stable),
        EntityRef::Agent(_) => return None,
    };
    // What stands on a held thing would not move with it.
    if thing == EntityRef::Object(on) || state.objects[on].held.is_some() {
        return None;
    }
    let others = place_all(prepared, state, &[], &|owner| match owner {
        Owner::Link { .. } => true,
        Owner::Object(o) => thing == EntityRef::Object(o) || state.objects[o].held.is_some(),
    });
    let X_WS = state.objects[on].X_WO;
    let mut left = MAX_CELLS;
    let faces = scene.objects[on].supports.iter().filter(|s| is_level(&X_WS, s));
    for face in faces {
        for orientation in stable {
            let found = on_face(face, &(X_WS * face.X_OF), parts, orientation, &others, &mut left);
            if found.is_some() || left == 0 {
                return found;
            }
        }
    }
    None
}

/// Returns balls (centre, radius [m]) outside of which nothing matters to [`find`].
pub(super) fn looked_at(scene: &Scene, state: &State, thing: EntityRef, on: usize) -> Vec<(Vec3, f64)> {
    let (parts, stable): (&[Part], &[Stable]) = match thing {
        EntityRef::Object(o) => (&scene.objects[o].parts, &scene.objects[o].stable),
        EntityRef::Virtual(v) => (&scene.virtuals[v].parts, &scene.virtuals[v].stable),
        EntityRef::Agent(_) => return Vec::new(),
    };
    let X_WS = state.objects[on].X_WO;
    let faces = scene.objects[on].supports.iter().filter(|s| is_level(&X_WS, s));
    faces
        .flat_map(|face| {
            let centre = (X_WS * face.X_OF).translation.vector;
            stable.iter().map(move |orientation| {
                let in_Q = parts.iter().map(|p| (&p.shape, orientation.X_QO * p.X_OS));
                (centre, reach(in_Q, face))
            })
        })
        .collect()
}

/// Returns how far from the face's middle a thing that stands on it can have a point [m].
fn reach<'s>(in_Q: impl Iterator<Item = (&'s Shape, Pose)>, face: &Support) -> f64 {
    let far = in_Q.map(|(s, X)| X.translation.vector.norm() + s.bounding_radius());
    far.fold(0.0, f64::max) + Vec3::new(face.half[0], face.half[1], 0.0).norm()
}

fn on_face(
    face: &Support,
    X_WF: &Pose,
    parts: &[Part],
    stable: &Stable,
    others: &[Placed<'_>],
    left: &mut u32,
) -> Option<Pose> {
    let in_Q: Vec<(&Shape, Pose)> = parts.iter().map(|p| (&p.shape, stable.X_QO * p.X_OS)).collect();
    let wide = in_Q.iter().map(|(shape, X_QS)| wide(shape, X_QS)).fold(0.0, f64::max);
    let reach = reach(in_Q.iter().copied(), face);
    let near: Vec<&Placed<'_>> = others
        .iter()
        .filter(|b| (b.X_WS.translation.vector - X_WF.translation.vector).norm() <= reach + b.solid.radius())
        .collect();
    let exact: Vec<(Solid, Pose)> = in_Q.iter().map(|(s, X)| (Solid::padded(s, -TOUCH), *X)).collect();
    let is_free = |bodies: &[(Solid, Pose)], cell: &Cell| {
        let X_WQ = placed_pose(X_WF, &Pose::identity(), cell.x, cell.y, cell.yaw);
        bodies.iter().all(|(solid, X_QS)| {
            let X_WS = X_WQ * X_QS;
            !near.iter().any(|b| overlap(solid, &X_WS, b.solid, &b.X_WS))
        })
    };
    // A single convex part is the same after half a turn about its centre.
    let turn = if parts.len() == 1 { PI } else { TAU };
    let n = (turn / (2.0 * FRAC_PI_8)).round() as u32;
    let mut cells: VecDeque<Cell> = (0..n)
        .map(|k| Cell {
            x: 0.0,
            y: 0.0,
            yaw: 2.0 * FRAC_PI_8 * f64::from(k),
            half: [face.half[0], face.half[1], FRAC_PI_8],
        })
        .collect();
    while let Some(cell) = cells.pop_front() {
        if *left == 0 {
            return None;
        }
        *left -= 1;
        let turned = wide * cell.half[2];
        let differs = (cell.half[0] * cell.half[0] + cell.half[1] * cell.half[1]).sqrt() + turned;
        let out = sticks_out(face, stable, &cell);
        if out > OVERHANG + differs {
            continue;
        }
        if out <= OVERHANG && is_free(&exact, &cell) {
            return Some(placed_pose(X_WF, &stable.X_QO, cell.x, cell.y, cell.yaw));
        }
        if differs <= FINEST {
            continue;
        }
        let shrunk: Option<Vec<(Solid, Pose)>> = in_Q
            .iter()
            .map(|(shape, X_QS)| Some((shrunk(shape, X_QS, differs + TOUCH)?, *X_QS)))
            .collect();
        if shrunk.is_some_and(|bodies| !is_free(&bodies, &cell)) {
            continue;
        }
        split(&cell, turned, &mut cells);
    }
    None
}

/// Adds the parts of a cell: thirds of its yaws, so that the middle one stays, or halves of its longer side.
fn split(cell: &Cell, turned: f64, cells: &mut VecDeque<Cell>) {
    let [a, b, c] = cell.half;
    if turned > a.max(b) {
        cells.extend([0.0, -1.0, 1.0].map(|k| Cell {
            yaw: cell.yaw + k * 2.0 * c / 3.0,
            half: [a, b, c / 3.0],
            ..*cell
        }));
    } else if a >= b {
        cells.extend([-1.0, 1.0].map(|k| Cell {
            x: cell.x + k * a / 2.0,
            half: [a / 2.0, b, c],
            ..*cell
        }));
    } else {
        cells.extend([-1.0, 1.0].map(|k| Cell {
            y: cell.y + k * b / 2.0,
            half: [a, b / 2.0, c],
            ..*cell
        }));
    }
}

/// Returns how far the bottom sticks out of the face at the cell's middle [m]; negative when it is inside.
fn sticks_out(face: &Support, stable: &Stable, cell: &Cell) -> f64 {
    let (sin, cos) = ComplexField::sin_cos(cell.yaw);
    let corners = stable.footprint.iter().map(|[x, y]| {
        let (u, v) = (cos * x - sin * y + cell.x, sin * x + cos * y + cell.y);
        (u.abs() - face.half[0]).max(v.abs() - face.half[1])
    });
    corners.fold(f64::NEG_INFINITY, f64::max)
}

/// Returns how far the shape reaches from the vertical axis of Q at most [m].
pub(super) fn wide(shape: &Shape, X_QS: &Pose) -> f64 {
    let flat = |p: Vec3| p.xy().norm();
    match shape {
        Shape::Box { half } => (0..8)
            .map(|corner| {
                let side = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
                let p_S = nalgebra::Point3::new(side(1) * half.x, side(2) * half.y, side(4) * half.z);
                flat((X_QS * p_S).coords)
            })
            .fold(0.0, f64::max),
        Shape::Cylinder { radius, half_length } | Shape::Capsule { radius, half_length } => {
            let axis = X_QS.rotation * Vec3::z();
            flat(X_QS.translation.vector) + radius + half_length * flat(axis)
        }
        Shape::Sphere { radius } => flat(X_QS.translation.vector) + radius,
        Shape::Hull(hull) => {
            let corners = hull
                .vertices
                .iter()
                .map(|v| flat((X_QS * nalgebra::Point3::from(*v)).coords));
            corners.fold(0.0, f64::max)
        }
    }
}

/// Returns the points of the shape that stay in it however it is moved by up to `by` [m] along the floor; `None` if that could be
/// none.
fn shrunk(shape: &Shape, X_QS: &Pose, by: f64) -> Option<Solid> {
    let up_S = X_QS.rotation.inverse() * Vec3::z();
    // A side that is level need not be moved: nothing in a cell moves up or down.
    let is_level = |axis: f64| axis.abs() > 1.0 - 1e-9;
    let shape = match shape {
        Shape::Box { half } => {
            let mut half = *half;
            let upright = (0..3).find(|i| is_level(up_S[*i]));
            for i in (0..3).filter(|i| Some(*i) != upright) {
                half[i] -= by;
            }
            if let Some(i) = upright {
                half[i] -= TOUCH;
            }
            (half.min() > 0.0).then_some(Shape::Box { half })
        }
        Shape::Cylinder { radius, half_length } => {
            let (radius, half_length) = if is_level(up_S.z) {
                (radius - by, half_length - TOUCH)
            } else {
                (radius - by, half_length - by)
            };
            (radius.min(half_length) > 0.0).then_some(Shape::Cylinder { radius, half_length })
        }
        Shape::Sphere { radius } => (*radius > by).then(|| Shape::Sphere { radius: radius - by }),
        Shape::Capsule { radius, half_length } => (*radius > by).then(|| Shape::Capsule {
            radius: radius - by,
            half_length: *half_length,
        }),
        Shape::Hull(hull) => {
            let smaller = hull.moved_in(|normal| if is_level(up_S.dot(normal)) { TOUCH } else { by });
            smaller.map(|hull| Shape::Hull(Arc::new(hull)))
        }
    };
    shape.map(|shape| Solid::new(&shape))
}
