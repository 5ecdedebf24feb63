//! isVisible: enough of the object's surface lies in the field of view of the agent's eyes or camera and is not hidden by something else.
//!
//! The object does not hide itself, and the head does not hide what its eyes see. The surface is represented by points, each of which stands for
//! an area. A new body can only make the fact false, and one that goes can only make it true; [`View`] says which ones hide what.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::super::prepared::{Owner, Placed, Prepared, link_poses, place_all};
use crate::geom::collide::Solid;
use crate::geom::shape::Shape;
use crate::geom::sight::{Cone, Sight};
use crate::geom::{Pose, Vec3};
use crate::world::{Camera, Object, Scene, State};

/// Share of an object's surface that must be seen (design: 30 %).
pub(super) const VISIBLE_SHARE: f64 = 0.3;
/// What comes this near to a point does not hide it [m].
const SLACK: f64 = 1e-6;
/// What the sum of all areas may be off by, as a share of it: above rounding.
const ROUNDING: f64 = 1e-9;

/// Points spread over an object's surface.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    /// In the object's frame [m], each with the area that it stands for [m^2].
    points: Vec<(Vec3, f64)>,
    /// Sum of the areas, in that order [m^2].
    area: f64,
    /// Of the ball about the object frame's origin that contains the points [m].
    radius: f64,
}

impl Surface {
    pub(super) fn of(object: &Object) -> Surface {
        let points = spread(surface_points(object));
        Surface {
            area: points.iter().map(|(_, area)| area).sum(),
            radius: points.iter().map(|(p, _)| p.norm()).fold(0.0, f64::max),
            points,
        }
    }
}

/// What is seen of an object.
#[derive(Debug, Clone)]
pub(super) struct View {
    pub is_visible: bool,
    /// Area that is seen, and area outside of the field of view [m^2], as far as they had to be known.
    pub seen: f64,
    pub outside: f64,
    /// Area of the whole surface [m^2].
    pub area: f64,
    /// What hides something, with the area that it hides first [m^2]; the caller's numbers.
    pub hidden_by: Vec<(usize, f64)>,
    /// All that could hide something.
    pub cone: Cone,
}

/// Where a camera is, and what it can see.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eye<'a> {
    pub camera: &'a Camera,
    pub X_WC: Pose,
}

impl Eye<'_> {
    /// Says whether a point is in the field of view.
    fn covers(&self, p_WQ: &Vec3) -> bool {
        let p_CQ = self.X_WC.inverse_transform_point(&nalgebra::Point3::from(*p_WQ));
        let half_h = (self.camera.horizontal / 2.0).min(std::f64::consts::PI - 1e-6);
        let half_v = (self.camera.vertical / 2.0).min(std::f64::consts::FRAC_PI_2 - 1e-6);
        let far = p_CQ.coords.norm();
        if far > self.camera.range || far < 1e-9 {
            return false;
        }
        let azimuth = nalgebra::RealField::atan2(p_CQ.y, p_CQ.x);
        let elevation = nalgebra::RealField::atan2(p_CQ.z, (p_CQ.x * p_CQ.x + p_CQ.y * p_CQ.y).sqrt());
        azimuth.abs() <= half_h && elevation.abs() <= half_v
    }
}

/// Looks at an object at `X_WO` past `others` (number, shape, X_WS). Stops as soon as the fact is certain, unless all is wanted.
pub(super) fn look<'a>(
    eye: &Eye<'_>,
    surface: &Surface,
    X_WO: &Pose,
    others: impl Iterator<Item = (usize, &'a Solid, Pose)>,
    all: bool,
) -> View {
    let p_WE = eye.X_WC.translation.vector;
    let cone = Cone::new(p_WE, X_WO.translation.vector, surface.radius);
    let mut view = View {
        is_visible: false,
        seen: 0.0,
        outside: 0.0,
        area: surface.area,
        hidden_by: Vec::new(),
        cone,
    };
    if surface.points.is_empty() {
        return view;
    }
    let mut sight = Sight::new(cone);
    for (id, solid, X_WS) in others {
        sight.add(id, solid, &X_WS);
    }
    sight.sort();
    let enough = VISIBLE_SHARE * surface.area;
    let mut left = surface.area * (1.0 + ROUNDING);
    for (p_OQ, area) in &surface.points {
        let p_WQ = (X_WO * nalgebra::Point3::from(*p_OQ)).coords;
        left -= area;
        if !eye.covers(&p_WQ) {
            view.outside += area;
        } else if let Some(id) = sight.hidden_by(&p_WQ, SLACK) {
            match view.hidden_by.iter_mut().find(|(known, _)| *known == id) {
                Some((_, hidden)) => *hidden += area,
                None => view.hidden_by.push((id, *area)),
            }
        } else {
            view.seen += area;
        }
        if !all && (view.seen >= enough || view.seen + left < enough * (1.0 - ROUNDING)) {
            break;
        }
    }
    view.is_visible = view.seen >= enough;
    view
}

/// Says whether enough of the object's surface lies in the agent's field of view and is not hidden by something else.
/// The object does not hide itself, and the head does not hide what its eyes see.
pub(in crate::grp) fn is_visible(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    object: usize,
    agent: usize,
) -> bool {
    let Some(camera) = &scene.agents[agent].camera else {
        return false;
    };
    let X_WL = link_poses(scene, state);
    let X_WC = X_WL[agent][camera.link] * camera.X_LC;
    let others: Vec<Placed<'_>> = place_all(prepared, state, &X_WL, &|owner| match owner {
        Owner::Link { agent: a, link } => a == agent && link == camera.link,
        Owner::Object(o) => o == object,
    });
    let surface = Surface::of(&scene.objects[object]);
    let others = others.iter().enumerate().map(|(i, b)| (i, b.solid, b.X_WS));
    let X_WO = &state.objects[object].X_WO;
    look(&Eye { camera, X_WC }, &surface, X_WO, others, false).is_visible
}

/// Brings points of all sides to the front: whether enough is seen shows early, whichever side is seen.
fn spread(points: Vec<(Vec3, f64)>) -> Vec<(Vec3, f64)> {
    let n = points.len();
    // A step without a common divisor visits each point once.
    let gcd = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    // HEURISTIC: about the golden section of all, which leaves no gaps.
    let mut step = (n * 618 / 1000).max(1);
    while gcd(step, n.max(1)) != 1 {
        step += 1;
    }
    (0..n).map(|i| points[i * step % n]).collect()
}

/// Returns the number of points along a side of that half length: about one every 5 cm, few enough to stay fast.
fn grid(half: f64) -> u32 {
    (half / 0.025).ceil().clamp(3.0, 8.0) as u32
}

/// Returns points spread over the surfaces of an object's parts, in its frame [m], each with the area that it stands for [m^2].
fn surface_points(object: &Object) -> Vec<(Vec3, f64)> {
    use std::f64::consts::{PI, TAU};
    let mut points = Vec::new();
    for part in &object.parts {
        let mut add = |p: Vec3, area: f64| points.push(((part.X_OS * nalgebra::Point3::from(p)).coords, area));
        match &part.shape {
            Shape::Box { half } => {
                for axis in 0..3 {
                    let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
                    let (n, m) = (grid(half[u_axis]), grid(half[v_axis]));
                    let area = 4.0 * half[u_axis] * half[v_axis] / f64::from(n * m);
                    // Middles of the cells of a grid over the face.
                    let at = |i: u32, n: u32, half: f64| half * ((2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0);
                    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
                        for side in [-1.0, 1.0] {
                            let mut p = Vec3::zeros();
                            p[axis] = side * half[axis];
                            p[u_axis] = at(i, n, half[u_axis]);
                            p[v_axis] = at(j, m, half[v_axis]);
                            add(p, area);
                        }
                    }
                }
            }
            Shape::Cylinder { radius, half_length } | Shape::Capsule { radius, half_length } => {
                let rings = [-0.75, -0.25, 0.25, 0.75];
                for k in 0..12 {
                    let (sin, cos) = nalgebra::ComplexField::sin_cos(f64::from(k) * TAU / 12.0);
                    for z in rings {
                        let area = TAU * radius * 2.0 * half_length / (12.0 * rings.len() as f64);
                        add(Vec3::new(radius * cos, radius * sin, z * half_length), area);
                    }
                }
                // The ends: a disc each, or half a ball each.
                let is_capsule = matches!(part.shape, Shape::Capsule { .. });
                let (top, area) = if is_capsule {
                    (half_length + radius, TAU)
                } else {
                    (*half_length, PI)
                };
                add(Vec3::new(0.0, 0.0, top), area * radius * radius);
                add(Vec3::new(0.0, 0.0, -top), area * radius * radius);
            }
            Shape::Hull(hull) => {
                for [a, b, c] in hull.faces.iter().flat_map(|f| f.triangles()) {
                    let (a, u, v) = (hull.vertices[a], hull.vertices[b], hull.vertices[c]);
                    let (u, v) = (u - a, v - a);
                    // Middles of the cells of a grid of small triangles.
                    let n = grid(u.norm().max(v.norm()).max((u - v).norm()) / 2.0).min(4);
                    let area = u.cross(&v).norm() / 2.0 / f64::from(n * n);
                    let mut at = |i: u32, j: u32, third: f64| {
                        let (s, t) = (f64::from(i) + third, f64::from(j) + third);
                        add(a + (u * s + v * t) / f64::from(n), area);
                    };
                    for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
                        at(i, j, 1.0 / 3.0);
                        if i + j + 1 < n {
                            at(i, j, 2.0 / 3.0);
                        }
                    }
                }
            }
            Shape::Sphere { radius } => {
                let area = 4.0 * PI * radius * radius / 26.0;
                for x in [-1.0, 0.0, 1.0] {
                    for y in [-1.0, 0.0, 1.0] {
                        for z in [-1.0, 0.0, 1.0] {
                            let d = Vec3::new(x, y, z);
                            if d.norm() > 0.0 {
                                add(d.normalize() * *radius, area);
                            }
                        }
                    }
                }
            }
        }
    }
    points
}
