//! Whether a thing fits somewhere on an object's support faces: a dense grid of places and yaws, all tried.
//!
//! The grid is a centimetre and five degrees fine. Two questions, both answered soundly: nothing fits at all if not even the
//! thing shrunk by as much as a place can differ from the nearest one of the grid; it fits with room to spare if the thing grown
//! by [`SPARE`] does. In between lies what the plan is believed.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::{PI, TAU};

use nalgebra::ComplexField;

use super::bodies::{Bodies, Placed};
use crate::geom::{Pose, Vec3, collide, collide::Solid, shape::Shape};
use crate::world::{EntityRef, Part, Stable, State, Support};

/// Spacing of the grid: [m], and yaws in a full turn.
const STEP: f64 = 0.01;
const YAWS: u32 = 72;
/// What is clearly room: the planner finds what has a quarter of it to spare [m].
const SPARE: f64 = 0.02;
/// Overlap that is a touch, and what a bottom may stick out [m].
const TOUCH: f64 = 0.001;
/// Smallest angle between a face's normal and the vertical that is level: its cosine.
const LEVEL: f64 = 0.9998;

/// Says whether the thing may fit on `on`, and whether it does so with room to spare.
pub(super) fn fits(bodies: &Bodies<'_>, state: &State, thing: EntityRef, on: usize) -> (bool, bool) {
    let scene = bodies.scene;
    let (parts, stable): (&[Part], &[Stable]) = match thing {
        EntityRef::Object(o) => (&scene.objects[o].parts, &scene.objects[o].stable),
        EntityRef::Virtual(v) => (&scene.virtuals[v].parts, &scene.virtuals[v].stable),
        EntityRef::Agent(_) => return (false, false),
    };
    if thing == EntityRef::Object(on) || state.objects[on].held.is_some() {
        return (false, false);
    }
    let others = (0..state.objects.len())
        .filter(|o| *o != on && thing != EntityRef::Object(*o) && state.objects[*o].held.is_none())
        .flat_map(|o| bodies.object(state, o))
        .collect::<Vec<_>>();
    let own = bodies.object(state, on);
    let X_WO = state.objects[on].X_WO;
    let faces = scene.objects[on]
        .supports
        .iter()
        .filter(|s| (X_WO.rotation * s.X_OF.rotation * Vec3::z()).z >= LEVEL);
    let mut may = false;
    for face in faces {
        for orientation in stable {
            let search = Search::new(face, X_WO * face.X_OF, parts, orientation, &others, &own);
            if search.any(&search.grown, SPARE) {
                return (true, true);
            }
            may = may || search.any(&search.shrunk, -search.cover);
        }
    }
    (may, false)
}

/// One face, one orientation.
struct Search<'a> {
    face: &'a Support,
    X_WF: Pose,
    stable: &'a Stable,
    /// The thing's parts: as they are but for a touch, smaller by `cover` along the floor, larger by [`SPARE`].
    exact: Vec<(Solid, Pose)>,
    shrunk: Vec<(Solid, Pose)>,
    grown: Vec<(Solid, Pose)>,
    /// How far a point of the thing can be from where the nearest place of the grid has it [m].
    cover: f64,
    turn: f64,
    others: &'a [Placed<'a>],
    own: &'a [Placed<'a>],
}

impl<'a> Search<'a> {
    fn new(
        face: &'a Support,
        X_WF: Pose,
        parts: &[Part],
        stable: &'a Stable,
        others: &'a [Placed<'a>],
        own: &'a [Placed<'a>],
    ) -> Self {
        let X_QS = |p: &Part| stable.X_QO * p.X_OS;
        let radius = parts
            .iter()
            .map(|p| X_QS(p).translation.vector.xy().norm() + p.shape.bounding_radius())
            .fold(0.0, f64::max);
        let cover = STEP / f64::sqrt(2.0) + radius * PI / f64::from(YAWS);
        let padded = |margin: f64| {
            parts
                .iter()
                .map(move |p| (Solid::padded(&p.shape, margin), X_QS(p)))
                .collect()
        };
        Search {
            face,
            X_WF,
            stable,
            exact: padded(-TOUCH),
            // A part that would shrink to nothing shrinks to its middle instead, which is in every place of the cell as long as
            // the part is larger than that; else it is left out: the answer is then "may be" more often than need be.
            shrunk: parts
                .iter()
                .filter_map(|p| Some((smaller(&p.shape, cover)?, X_QS(p))))
                .collect(),
            grown: padded(SPARE),
            cover,
            turn: if parts.len() == 1 { PI } else { TAU },
            others,
            own,
        }
    }

    /// Says whether there is a place where the bottom is within the face, `margin` inside of its edges, and `bodies` are free.
    fn any(&self, bodies: &[(Solid, Pose)], margin: f64) -> bool {
        let [a, b] = self.face.half;
        let (n, m) = ((2.0 * a / STEP).ceil() as u32, (2.0 * b / STEP).ceil() as u32);
        let yaws = (f64::from(YAWS) * self.turn / TAU).round() as u32;
        for yaw in (0..yaws).map(|k| TAU * f64::from(k) / f64::from(YAWS)) {
            let (sin, cos) = ComplexField::sin_cos(yaw);
            let corners: Vec<[f64; 2]> = self
                .stable
                .footprint
                .iter()
                .map(|[x, y]| [cos * x - sin * y, sin * x + cos * y])
                .collect();
            for (i, j) in (0..=n).flat_map(|i| (0..=m).map(move |j| (i, j))) {
                let x = -a + 2.0 * a * f64::from(i) / f64::from(n.max(1));
                let y = -b + 2.0 * b * f64::from(j) / f64::from(m.max(1));
                let out = |half: f64, at: f64| at.abs() + margin > half + TOUCH;
                if corners.iter().any(|[u, v]| out(a, x + u) || out(b, y + v)) {
                    continue;
                }
                let X_WQ = self.X_WF * Pose::new(Vec3::new(x, y, 0.0), Vec3::z() * yaw);
                let clear = |bodies: &[(Solid, Pose)], obstacles: &[Placed<'_>]| {
                    bodies.iter().all(|(solid, X_QS)| {
                        let X_WS = X_WQ * X_QS;
                        !obstacles.iter().any(|o| collide::touch(solid, &X_WS, o.solid, &o.X_WS))
                    })
                };
                // What the thing stands on touches it: there the thing as it is, or smaller, is what counts.
                let on_own = if margin > 0.0 { &self.exact } else { bodies };
                if clear(bodies, self.others) && clear(on_own, self.own) {
                    return true;
                }
            }
        }
        false
    }
}

/// Returns the shape smaller by `by` [m] all around; `None` where nothing is left for certain.
fn smaller(shape: &Shape, by: f64) -> Option<Solid> {
    let thinnest = match shape {
        Shape::Hull(hull) => return hull.moved_in(|_| by).is_some().then(|| Solid::padded(shape, -by)),
        Shape::Box { half } => half.min(),
        Shape::Cylinder { radius, half_length } => radius.min(*half_length),
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
    };
    (thinnest > by).then(|| Solid::padded(shape, -by))
}
