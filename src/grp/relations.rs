//! How two entities relate by shape and place alone (thesis 3.2.4): in, next to, bigger, and how far apart.
//!
//! Exact but for the tolerances stated here: no search, no sampling, no seed.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::prepared::{Owner, Placed, Prepared, link_poses, place_all};
use crate::geom::collide::distance;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{Container, EntityRef, Scene, State};

/// Two things at most this far apart are next to each other [m] (design: 0.10 m).
pub const NEXT_TO: f64 = 0.10;
/// What a distance may be off by [m]: two things exactly that far apart are next to each other, wherever they stand.
pub(super) const ROUNDING: f64 = 1e-6;
/// How far a thing may stick out of the container that it is in [m].
const STICKS_OUT: f64 = 0.001;
/// Share of the larger volume by which one must exceed the other to be bigger: above rounding.
const VOLUME: f64 = 1e-6;

/// Says whether all of `a` lies in one container of `b`. Who holds them does not matter.
pub(super) fn is_in(scene: &Scene, state: &State, a: usize, b: usize) -> bool {
    a != b && sticks_out(scene, state, a, b).is_some_and(|(_, out)| out <= STICKS_OUT)
}

/// Returns the container of `b` that holds `a` best, and how far `a` sticks out of it [m], negative with room to spare.
pub(super) fn sticks_out<'s>(scene: &'s Scene, state: &State, a: usize, b: usize) -> Option<(&'s str, f64)> {
    let containers = scene.objects[b].containers.iter();
    let out = containers.map(|container| {
        let X_CO = (state.objects[b].X_WO * container.X_OC).inverse() * state.objects[a].X_WO;
        let parts = scene.objects[a].parts.iter();
        let out = parts.map(|part| beyond(&part.shape, &(X_CO * part.X_OS), container));
        (container.name.as_str(), out.fold(f64::NEG_INFINITY, f64::max))
    });
    out.min_by(|x, y| x.1.total_cmp(&y.1))
}

/// Returns how far the shape reaches beyond the container's walls [m].
fn beyond(shape: &Shape, X_CS: &Pose, container: &Container) -> f64 {
    let p_CS = X_CS.translation.vector;
    let sides = (0..3).map(|i| {
        let mut axis_C = Vec3::zeros();
        axis_C[i] = 1.0;
        let reach = extent(shape, &X_CS.rotation.inverse_transform_vector(&axis_C));
        p_CS[i].abs() + reach - container.half[i]
    });
    sides.fold(f64::NEG_INFINITY, f64::max)
}

/// Returns how far the shape reaches from its centre along a unit vector of its own frame [m].
fn extent(shape: &Shape, along_S: &Vec3) -> f64 {
    let across = (along_S.x * along_S.x + along_S.y * along_S.y).sqrt();
    match shape {
        Shape::Box { half } => along_S.abs().dot(half),
        Shape::Cylinder { radius, half_length } => radius * across + half_length * along_S.z.abs(),
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { radius, half_length } => radius + half_length * along_S.z.abs(),
        // Both ways: its frame's origin is not the middle along every direction.
        Shape::Hull(hull) => {
            let reach = |d: &Vec3| hull.support(d).dot(d);
            reach(along_S).max(reach(&-along_S))
        }
    }
}

/// Says whether the volume of `a` exceeds that of `b`; an agent's is that of its links, parts that overlap count twice.
pub(super) fn is_bigger(scene: &Scene, a: EntityRef, b: EntityRef) -> bool {
    let (a, b) = (volume(scene, a), volume(scene, b));
    a - b > VOLUME * a.max(b)
}

/// Returns the volume of an entity's bodies [m^3].
pub(super) fn volume(scene: &Scene, entity: EntityRef) -> f64 {
    match entity {
        EntityRef::Agent(a) => scene.agents[a].bodies.iter().map(|b| b.shape.volume()).sum(),
        EntityRef::Object(o) => scene.objects[o].parts.iter().map(|p| p.shape.volume()).sum(),
        EntityRef::Virtual(v) => scene.virtuals[v].parts.iter().map(|p| p.shape.volume()).sum(),
    }
}

/// Returns the least distance between the bodies of two entities [m], 0 where they touch; what an agent holds is not part of it.
/// `None` for a virtual object, which is nowhere.
pub(super) fn apart(scene: &Scene, prepared: &Prepared, state: &State, a: EntityRef, b: EntityRef) -> Option<f64> {
    let X_WL = link_poses(scene, state);
    let bodies = |entity: EntityRef| -> Option<Vec<Placed<'_>>> {
        let is_own = move |owner: Owner| match (owner, entity) {
            (Owner::Link { agent, .. }, EntityRef::Agent(a)) => agent == a,
            (Owner::Object(object), EntityRef::Object(o)) => object == o,
            (Owner::Link { .. } | Owner::Object(_), _) => false,
        };
        match entity {
            EntityRef::Virtual(_) => None,
            EntityRef::Agent(_) | EntityRef::Object(_) => {
                Some(place_all(prepared, state, &X_WL, &|owner| !is_own(owner)))
            }
        }
    };
    let (a, b) = (bodies(a)?, bodies(b)?);
    let mut least = f64::INFINITY;
    for x in &a {
        for y in &b {
            // Bounding spheres first: most pairs can't be the nearest.
            let between = (x.X_WS.translation.vector - y.X_WS.translation.vector).norm();
            if between - x.solid.radius() - y.solid.radius() < least {
                least = least.min(distance(x.solid, &x.X_WS, y.solid, &y.X_WS));
            }
        }
    }
    least.is_finite().then_some(least)
}
