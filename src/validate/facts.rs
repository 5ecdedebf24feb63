//! Geometric facts (thesis 3.2.4, 3.3.4.1), written a second time.
//!
//! A fact is clear or it is not: near a threshold, and where one side of the question rests on a search that failed, the
//! plan's word is taken. `docs/validate.md` has the margins.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::{PI, TAU};

use nalgebra::{ComplexField, RealField};

use super::{
    Settings,
    bodies::{Bodies, Owner, Placed},
    handling::{STAND_GAP, is_on},
    reach::{self, Until},
};
use crate::geom::{Vec3, collide, shape::Shape};
use crate::world::{EntityRef, State};

/// What the validator thinks of a fact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Status {
    Holds,
    Fails,
    /// Too near to call; with the better guess.
    Unclear(bool),
}

impl Status {
    pub(super) fn guess(self) -> bool {
        matches!(self, Status::Holds | Status::Unclear(true))
    }

    fn of(holds: bool) -> Self {
        if holds { Status::Holds } else { Status::Fails }
    }
}

/// Two things nearer than this are next to each other [m].
const NEXT_TO: f64 = 0.10;
/// How near to that distance is too near to call [m].
const NEXT_TO_MARGIN: f64 = 0.001;
/// How far a thing may stick out of a container [m], and how near to that is too near to call.
const STICKS_OUT: f64 = 0.001;
const IN_MARGIN: f64 = 0.0005;
/// A triangle is halved at most this often.
const FINEST: u32 = 12;
/// Spacing of the sample points on a surface [m], and the least number of them along an edge.
const SPACING: f64 = 0.02;
const LEAST_SAMPLES: usize = 4;
const MOST_SAMPLES: usize = 16;

/// Returns the fact's status in the state; `None` for a fact that is not known here. `claim` is what the plan says.
pub(super) fn status(
    bodies: &Bodies<'_>,
    state: &State,
    fact: &str,
    of: EntityRef,
    with: EntityRef,
    claim: Option<bool>,
    settings: &Settings,
) -> Option<Status> {
    use EntityRef::{Agent, Object};
    let status = match (fact, of, with) {
        ("isOn", Object(a), Object(b)) => Status::of(is_on(bodies, state, a, b, STAND_GAP)),
        ("hasInHand", Agent(a), Object(o)) => Status::of(state.objects[o].held.as_ref().is_some_and(|h| h.agent == a)),
        ("isReachable", Object(o), Agent(a)) => reachable(bodies, state, o, a, claim, settings),
        ("isVisible", Object(o), Agent(a)) => visible(bodies, state, o, a, settings),
        ("isIn", Object(a), Object(b)) if a != b => inside(bodies, state, a, b),
        ("isNextTo", a, b) if a != b => match apart(bodies, state, a, b) {
            Some(least) => near(NEXT_TO - least, NEXT_TO_MARGIN),
            None => Status::Fails,
        },
        ("isBigger" | "isSmaller", a, b) if a == b => Status::Fails,
        ("isBigger", a, b) => bigger(bodies, a, b),
        ("isSmaller", a, b) => bigger(bodies, b, a),
        ("isOn" | "isIn" | "hasInHand" | "isReachable" | "isVisible" | "isNextTo", _, _) => Status::Fails,
        _ => return None,
    };
    Some(status)
}

/// Returns the least distance between the bodies of two entities [m]: all pairs, one by one. `None` for what is nowhere.
pub(super) fn apart(bodies: &Bodies<'_>, state: &State, a: EntityRef, b: EntityRef) -> Option<f64> {
    let (a, b) = (placed(bodies, state, a), placed(bodies, state, b));
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    pairs
        .map(|(a, b)| collide::distance(a.solid, &a.X_WS, b.solid, &b.X_WS))
        .min_by(f64::total_cmp)
}

/// isIn: the farthest that a surface point of `a` is outside of the container of `b` that holds it best.
fn inside(bodies: &Bodies<'_>, state: &State, a: usize, b: usize) -> Status {
    let thing = &bodies.scene.objects[a];
    let points: Vec<Vec3> = thing
        .parts
        .iter()
        .flat_map(|part| {
            let X_WS = state.objects[a].X_WO * part.X_OS;
            rim(&part.shape)
                .into_iter()
                .map(move |p| (X_WS * nalgebra::Point3::from(p)).coords)
        })
        .collect();
    let containers = bodies.scene.objects[b].containers.iter();
    let out = containers
        .map(|container| {
            let X_CW = (state.objects[b].X_WO * container.X_OC).inverse();
            let outside = points.iter().flat_map(|p_WP| {
                let p_CP = X_CW * nalgebra::Point3::from(*p_WP);
                (0..3).map(move |i| p_CP[i].abs() - container.half[i])
            });
            outside.fold(f64::NEG_INFINITY, f64::max)
        })
        .min_by(f64::total_cmp);
    match out {
        Some(out) => near(STICKS_OUT - out, IN_MARGIN),
        None => Status::Fails,
    }
}

/// Returns points of the shape among which is, to within [`IN_MARGIN`], the farthest one in any direction.
fn rim(shape: &Shape) -> Vec<Vec3> {
    const ROUND: usize = 360;
    let turns = |radius: f64, z: f64| {
        (0..ROUND).map(move |k| {
            let angle = TAU * k as f64 / ROUND as f64;
            Vec3::new(radius * ComplexField::cos(angle), radius * ComplexField::sin(angle), z)
        })
    };
    match *shape {
        Shape::Box { half } => (0..8)
            .map(|corner: usize| {
                let side = |bit: usize, length: f64| if corner & bit == 0 { -length } else { length };
                Vec3::new(side(1, half.x), side(2, half.y), side(4, half.z))
            })
            .collect(),
        Shape::Cylinder { radius, half_length } => {
            turns(radius, half_length).chain(turns(radius, -half_length)).collect()
        }
        Shape::Sphere { radius } => globe(radius, 0.0),
        Shape::Capsule { radius, half_length } => globe(radius, half_length),
        Shape::Hull(ref hull) => hull.vertices.clone(),
    }
}

/// Points of a sphere, a degree or so apart, whose halves are moved apart along z by `lift` each.
fn globe(radius: f64, lift: f64) -> Vec<Vec3> {
    let mut points = Vec::new();
    for i in 0..=180 {
        let (sin, cos) = ComplexField::sin_cos(PI * f64::from(i) / 180.0);
        for j in 0..360 {
            let (s, c) = ComplexField::sin_cos(TAU * f64::from(j) / 360.0);
            for z in [-lift, lift] {
                points.push(Vec3::new(radius * sin * c, radius * sin * s, radius * cos + z));
            }
        }
    }
    points
}

/// Says whether `excess` is positive, unclear within `margin` of 0.
fn near(excess: f64, margin: f64) -> Status {
    if excess.abs() <= margin {
        Status::Unclear(excess > 0.0)
    } else {
        Status::of(excess > 0.0)
    }
}

fn placed<'b>(bodies: &'b Bodies<'_>, state: &State, entity: EntityRef) -> Vec<Placed<'b>> {
    match entity {
        EntityRef::Agent(a) => bodies.agent(state, a),
        EntityRef::Object(o) => bodies.object(state, o),
        EntityRef::Virtual(_) => Vec::new(),
    }
}

fn bigger(bodies: &Bodies<'_>, a: EntityRef, b: EntityRef) -> Status {
    let volume = |entity: EntityRef| -> f64 {
        match entity {
            EntityRef::Agent(a) => bodies.scene.agents[a].bodies.iter().map(|b| b.shape.volume()).sum(),
            EntityRef::Object(o) => bodies.scene.objects[o].parts.iter().map(|p| p.shape.volume()).sum(),
            EntityRef::Virtual(v) => bodies.scene.virtuals[v].parts.iter().map(|p| p.shape.volume()).sum(),
        }
    };
    let (a, b) = (volume(a), volume(b));
    near(a - b, 1e-6 * a.max(b))
}

/// isReachable: what is claimed must be found; what is denied must not be found easily.
fn reachable(
    bodies: &Bodies<'_>,
    state: &State,
    object: usize,
    agent: usize,
    claim: Option<bool>,
    settings: &Settings,
) -> Status {
    if state.objects[object].held.as_ref().is_some_and(|h| h.agent == agent) {
        // Whether one can reach what one holds is a matter of words.
        return Status::Unclear(true);
    }
    if claim != Some(false) {
        let search = reach::search(bodies, state, agent, object, settings, Until::Found);
        match (search.possible, search.found, claim) {
            (false, _, _) | (_, false, Some(true)) => return Status::Fails,
            (_, false, _) => return Status::Unclear(false),
            (_, true, Some(true)) => return Status::Holds,
            (_, true, _) => {}
        }
    }
    let search = reach::search(bodies, state, agent, object, settings, Until::Spent);
    let share = search.clear as f64 / search.restarts.max(1) as f64;
    if !search.possible {
        Status::Fails
    } else if share >= settings.contradiction_share {
        Status::Holds
    } else {
        Status::Unclear(claim != Some(false))
    }
}

/// isVisible: the share of the object's surface that is in view and not hidden by anything else.
fn visible(bodies: &Bodies<'_>, state: &State, object: usize, agent: usize, settings: &Settings) -> Status {
    let Some(camera) = &bodies.scene.agents[agent].camera else {
        return Status::Fails;
    };
    let X_WC = bodies.links(state, agent)[camera.link] * camera.X_LC;
    let p_WC = X_WC.translation.vector;
    let mut all = Vec::new();
    for a in 0..state.agents.len() {
        all.extend(bodies.agent(state, a));
    }
    for o in (0..state.objects.len()).filter(|o| *o != object) {
        all.extend(bodies.object(state, o));
    }
    let head = Owner::Link {
        agent,
        link: camera.link,
    };
    let (mut seen, mut total) = (0.0, 0.0);
    let thing = &bodies.scene.objects[object];
    for part in &thing.parts {
        let X_WS = state.objects[object].X_WO * part.X_OS;
        for (p_SP, area) in surface(&part.shape) {
            total += area;
            let p_WP = (X_WS * nalgebra::Point3::from(p_SP)).coords;
            let p_CP = X_WC.inverse_transform_point(&p_WP.into());
            let distance = (p_WP - p_WC).norm();
            let in_view = distance <= camera.range
                && RealField::atan2(p_CP.y, p_CP.x).abs() <= 0.5 * camera.horizontal
                && RealField::atan2(p_CP.z, p_CP.xy().coords.norm()).abs() <= 0.5 * camera.vertical;
            if !in_view || distance < 1e-6 {
                continue;
            }
            let direction = (p_WP - p_WC) / distance;
            let hidden = Bodies::ray(&all, &p_WC, &direction, distance - 1e-4, &|owner| owner != head);
            if hidden.is_none() {
                seen += area;
            }
        }
    }
    near(seen / total - settings.visible_share, settings.visible_margin)
}

/// Returns points of a shape's surface, in its frame, each with the area that it stands for [m^2].
fn surface(shape: &Shape) -> Vec<(Vec3, f64)> {
    match *shape {
        Shape::Box { half } => {
            let mut points = Vec::new();
            for axis in 0..3 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let (n, m) = (count(2.0 * half[u]), count(2.0 * half[v]));
                let area = 4.0 * half[u] * half[v] / (n * m) as f64;
                for (i, j) in grid(n, m) {
                    let mut p = Vec3::zeros();
                    p[u] = half[u] * middle(i, n);
                    p[v] = half[v] * middle(j, m);
                    for side in [-1.0, 1.0] {
                        p[axis] = side * half[axis];
                        points.push((p, area));
                    }
                }
            }
            points
        }
        Shape::Cylinder { radius, half_length } => {
            let mut points = tube(radius, half_length);
            let (n, m) = (count(radius), count(TAU * radius));
            for (i, j) in grid(n, m) {
                // Rings of equal area.
                let r = radius * ((i as f64 + 0.5) / n as f64).sqrt();
                let angle = TAU * (j as f64 + 0.5) / m as f64;
                let area = PI * radius * radius / (n * m) as f64;
                for side in [-1.0, 1.0] {
                    points.push((
                        Vec3::new(
                            r * ComplexField::cos(angle),
                            r * ComplexField::sin(angle),
                            side * half_length,
                        ),
                        area,
                    ));
                }
            }
            points
        }
        Shape::Sphere { radius } => ball(radius, 0.0),
        Shape::Capsule { radius, half_length } => {
            let mut points = tube(radius, half_length);
            points.extend(ball(radius, half_length));
            points
        }
        Shape::Hull(ref hull) => {
            let triangles = hull.faces.iter().flat_map(|f| f.triangles());
            triangles.flat_map(|t| triangle(t.map(|i| hull.vertices[i]))).collect()
        }
    }
}

/// A triangle, halved across its longest side until its pieces are as fine as the grids here.
fn triangle(corners: [Vec3; 3]) -> Vec<(Vec3, f64)> {
    let (mut points, mut open) = (Vec::new(), vec![(corners, 0)]);
    while let Some(([a, b, c], depth)) = open.pop() {
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let longest = sides
            .into_iter()
            .max_by(|(p, q, _), (r, s, _)| (q - p).norm().total_cmp(&(s - r).norm()));
        match longest {
            Some((p, q, r)) if depth < FINEST && (q - p).norm() > SPACING => {
                let middle = (p + q) / 2.0;
                open.extend([([p, middle, r], depth + 1), ([middle, q, r], depth + 1)]);
            }
            _ => points.push(((a + b + c) / 3.0, (b - a).cross(&(c - a)).norm() / 2.0)),
        }
    }
    points
}

/// Side of a cylinder.
fn tube(radius: f64, half_length: f64) -> Vec<(Vec3, f64)> {
    let (n, m) = (count(2.0 * half_length), count(TAU * radius));
    let area = 2.0 * TAU * radius * half_length / (n * m) as f64;
    let point = |(i, j): (usize, usize)| {
        let angle = TAU * (j as f64 + 0.5) / m as f64;
        let p = Vec3::new(
            radius * ComplexField::cos(angle),
            radius * ComplexField::sin(angle),
            half_length * middle(i, n),
        );
        (p, area)
    };
    grid(n, m).map(point).collect()
}

/// A sphere whose halves are moved apart along z by `lift` each.
fn ball(radius: f64, lift: f64) -> Vec<(Vec3, f64)> {
    let (n, m) = (2 * count(radius), count(TAU * radius));
    let area = 4.0 * PI * radius * radius / (n * m) as f64;
    let point = |(i, j): (usize, usize)| {
        // Equal steps of height are equal areas (Archimedes).
        let z = middle(i, n);
        let r = radius * (1.0 - z * z).sqrt();
        let angle = TAU * (j as f64 + 0.5) / m as f64;
        (
            Vec3::new(
                r * ComplexField::cos(angle),
                r * ComplexField::sin(angle),
                radius * z + lift * z.signum(),
            ),
            area,
        )
    };
    grid(n, m).map(point).collect()
}

fn count(length: f64) -> usize {
    ((length / SPACING) as usize).clamp(LEAST_SAMPLES, MOST_SAMPLES)
}

/// Middle of the `i`-th of `n` parts of [-1, 1].
fn middle(i: usize, n: usize) -> f64 {
    (2.0 * i as f64 + 1.0) / n as f64 - 1.0
}

fn grid(n: usize, m: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (0..m).map(move |j| (i, j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_areas_are_those_of_the_shapes() {
        let shapes = [
            (Shape::Sphere { radius: 0.1 }, 4.0 * PI * 0.01),
            (
                Shape::Cylinder {
                    radius: 0.1,
                    half_length: 0.2,
                },
                TAU * 0.1 * 0.4 + TAU * 0.01,
            ),
            (
                Shape::Box {
                    half: Vec3::new(0.1, 0.2, 0.3),
                },
                8.0 * (0.02 + 0.06 + 0.03),
            ),
            (
                Shape::Capsule {
                    radius: 0.1,
                    half_length: 0.2,
                },
                TAU * 0.1 * 0.4 + 4.0 * PI * 0.01,
            ),
        ];
        for (shape, expected) in shapes {
            let area: f64 = surface(&shape).iter().map(|(_, a)| a).sum();
            assert!((area - expected).abs() < 1e-12, "{shape:?}: {area} is not {expected}");
        }
    }
}
