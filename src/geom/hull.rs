//! Convex polytopes that contain a set of points, with few faces.
//!
//! [`Hull::around`] starts with the box about the points and cuts off the corner that is farthest from them, by the plane that
//! supports the points towards it, until no corner is farther than a tolerance or the faces are as many as may be. Every plane is
//! computed from all points, so that the result contains them whatever is rounded; [`Hull::excess`] bounds by how much it is too
//! large. A shape with few flat faces, such as a box, comes out exact but for a skin of a micrometre.
//! The same idea from within, adding extreme points instead of planes, is Kavan, Kolingerova, Zara 2006 ("Fast approximation of
//! convex hull", ACST). Does not know triangles: what is hollow becomes full (see [`super::mesh`]).

use std::collections::BTreeMap;

use super::{Vec3, collide};

/// Corners nearer to the points than this are not cut off [m]. HEURISTIC: below what a model is measured to.
const TOLERANCE: f64 = 5e-4;
/// A hull has at most this many faces, hence at most 124 corners. HEURISTIC: a ball of 0.1 m is exceeded by 4 mm then, and a test
/// of two hulls costs a microsecond.
const MOST_FACES: usize = 64;
/// Each plane is this far outside of the points [m]: flat things have a thickness, and rounding stays inside.
const SKIN: f64 = 1e-6;
/// Points this near to a plane are on it [m].
const ON: f64 = 1e-10;
/// Corners nearer than this are one [m].
const SAME: f64 = 1e-8;
/// Half the side of a box around everything [m].
const LARGEST: f64 = 256.0;
/// Points that spread less than this are no body [m].
const SMALLEST: f64 = 1e-5;

/// A convex polytope in its frame S; the origin is the middle of its box where [`Hull::around`] made it.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Corners, measured in S [m].
    pub vertices: Vec<Vec3>,
    /// Faces, none parallel to another on the same side.
    pub faces: Vec<Face>,
    /// No point of the hull is farther than this from the convex hull of the points that it was made around [m].
    pub excess: f64,
    volume: f64,
    centre: Vec3,
}

/// A side of a hull: its points are those with `normal . p = offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Unit vector out of the hull.
    pub normal: Vec3,
    /// Distance from the origin along the normal [m].
    pub offset: f64,
    /// Indices into [`Hull::vertices`], counter-clockwise as seen from outside.
    pub corners: Vec<usize>,
}

/// A face while it is cut.
#[derive(Debug, Clone)]
struct Polygon {
    normal: Vec3,
    offset: f64,
    corners: Vec<Vec3>,
}

impl Hull {
    /// Returns a hull around the points, and where its frame's origin is, measured like the points; `None` when a number is not
    /// finite, or the points are nearer to each other than any body.
    pub fn around(points: &[Vec3]) -> Option<(Hull, Vec3)> {
        let (middle, half) = bounds(points)?;
        if half.max() < SMALLEST {
            return None;
        }
        let mut points: Vec<Vec3> = points.iter().map(|p| p - middle).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
        points.dedup();
        let mut polygons = a_box(&half.add_scalar(SKIN));
        // Extreme points: the search for planes looks at these alone.
        let mut extreme: Vec<Vec3> = Vec::new();
        for d in directions() {
            add(&mut extreme, farthest(&points, &d));
        }
        let mut known: BTreeMap<[u64; 3], (f64, Vec3)> = BTreeMap::new();
        for _ in 0..4 * MOST_FACES {
            let worst = worst(&polygons, &extreme, &mut known);
            let Some((apart, towards)) = worst.filter(|(apart, _)| *apart > TOLERANCE) else {
                break;
            };
            if polygons.len() >= MOST_FACES || apart <= 0.0 {
                break;
            }
            let support = farthest(&points, &towards);
            let offset = towards.dot(&support) + SKIN;
            let is_new = add(&mut extreme, support);
            // What was measured before that point was known is too much, which does no harm while there is something to cut off.
            if !cut(&mut polygons, &towards, offset) {
                if !is_new {
                    break;
                }
                known.clear();
            }
        }
        known.clear();
        let excess = worst(&polygons, &extreme, &mut known).map_or(0.0, |(apart, _)| apart);
        Some((Hull::of(polygons, excess)?, middle))
    }

    /// Returns a hull around the points whose planes have a fixed set of normals: coarser, and much faster. Only its volume is
    /// of use.
    pub(super) fn volume_around(points: &[Vec3]) -> f64 {
        let Some((middle, half)) = bounds(points) else {
            return 0.0;
        };
        let mut polygons = a_box(&half.add_scalar(SKIN));
        let points: Vec<Vec3> = points.iter().map(|p| p - middle).collect();
        for d in directions().skip(6) {
            cut(&mut polygons, &d, d.dot(&farthest(&points, &d)) + SKIN);
        }
        Hull::of(polygons, 0.0).map_or(0.0, |hull| hull.volume)
    }

    /// Returns the hull whose faces are moved inwards, each by what `by` says of its normal [m]; `None` when nothing is left.
    pub fn moved_in(&self, by: impl Fn(&Vec3) -> f64) -> Option<Hull> {
        let mut polygons = a_box(&self.half_extents().add_scalar(SKIN));
        for face in &self.faces {
            cut(&mut polygons, &face.normal, face.offset - by(&face.normal));
        }
        Hull::of(polygons, self.excess).filter(|hull| hull.volume > 0.0)
    }

    fn of(polygons: Vec<Polygon>, excess: f64) -> Option<Hull> {
        let mut vertices: Vec<Vec3> = Vec::new();
        let mut faces = Vec::new();
        for polygon in polygons {
            let mut corners: Vec<usize> = Vec::new();
            for p in polygon.corners {
                let known = vertices.iter().position(|v| (v - p).norm() <= SAME);
                let index = known.unwrap_or(vertices.len());
                if known.is_none() {
                    vertices.push(p);
                }
                if !corners.contains(&index) {
                    corners.push(index);
                }
            }
            if corners.len() >= 3 {
                let Polygon { normal, offset, .. } = polygon;
                faces.push(Face {
                    normal,
                    offset,
                    corners,
                });
            }
        }
        if faces.len() < 4 {
            return None;
        }
        let (mut volume, mut moment) = (0.0, Vec3::zeros());
        for face in &faces {
            for [a, b, c] in face.triangles() {
                let (a, b, c) = (vertices[a], vertices[b], vertices[c]);
                let v = a.dot(&b.cross(&c)) / 6.0;
                volume += v;
                moment += (a + b + c) / 4.0 * v;
            }
        }
        let centre = if volume > 0.0 {
            moment / volume
        } else {
            vertices.iter().sum::<Vec3>() / vertices.len() as f64
        };
        Some(Hull {
            vertices,
            faces,
            excess,
            volume: volume.max(0.0),
            centre,
        })
    }

    /// Returns the numbers from which [`Hull::from_numbers`] makes the same hull: its excess, then normal and offset of each face.
    pub fn as_numbers(&self) -> Vec<f64> {
        let planes = self
            .faces
            .iter()
            .flat_map(|f| [f.normal.x, f.normal.y, f.normal.z, f.offset]);
        std::iter::once(self.excess).chain(planes).collect()
    }

    /// Returns the hull of [`Hull::as_numbers`]; `None` for numbers that bound no body.
    pub fn from_numbers(numbers: &[f64]) -> Option<Hull> {
        let (excess, planes) = numbers.split_first()?;
        if planes.len() % 4 != 0 || planes.len() > 16 * MOST_FACES || numbers.iter().any(|n| !n.is_finite()) {
            return None;
        }
        let mut polygons = a_box(&Vec3::repeat(LARGEST));
        for plane in planes.chunks_exact(4) {
            let normal = Vec3::new(plane[0], plane[1], plane[2]);
            if (normal.norm_squared() - 1.0).abs() > 1e-9 {
                return None;
            }
            cut(&mut polygons, &normal, plane[3]);
        }
        Hull::of(polygons, *excess)
    }

    /// Returns the volume [m^3].
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Returns the centre of volume, measured in S [m].
    pub fn centre(&self) -> Vec3 {
        self.centre
    }

    /// Returns the corner that is farthest along `d`.
    #[inline]
    pub fn support(&self, d: &Vec3) -> Vec3 {
        farthest(&self.vertices, d)
    }

    /// Returns half of the sides of the box about the hull with its middle at the origin of S [m].
    pub fn half_extents(&self) -> Vec3 {
        self.vertices.iter().fold(Vec3::zeros(), |half, v| half.sup(&v.abs()))
    }

    /// Says whether the point, measured in S, lies in the hull.
    pub fn contains(&self, p: &Vec3) -> bool {
        self.faces.iter().all(|f| f.normal.dot(p) <= f.offset)
    }

    /// Returns where the line `p + t d` is in the hull grown by `margin` [m], and through which faces it comes and goes.
    pub fn crossing(&self, p: &Vec3, d: &Vec3, margin: f64) -> Option<Crossing> {
        let mut found = Crossing {
            enter: f64::NEG_INFINITY,
            leave: f64::INFINITY,
            enter_face: 0,
            leave_face: 0,
        };
        for (i, face) in self.faces.iter().enumerate() {
            let (along, left) = (face.normal.dot(d), face.offset + margin - face.normal.dot(p));
            if along == 0.0 {
                if left < 0.0 {
                    return None;
                }
            } else if along > 0.0 && left / along < found.leave {
                (found.leave, found.leave_face) = (left / along, i);
            } else if along < 0.0 && left / along > found.enter {
                (found.enter, found.enter_face) = (left / along, i);
            }
        }
        (found.enter <= found.leave).then_some(found)
    }

    /// Says whether the segment of points `p + t d`, t from 0 to `until`, has a point in the hull grown by `margin` [m].
    pub fn cuts(&self, p: &Vec3, d: &Vec3, until: f64, margin: f64) -> bool {
        let (mut enter, mut leave) = (0.0, until);
        for face in &self.faces {
            let (along, left) = (face.normal.dot(d), face.offset + margin - face.normal.dot(p));
            if along > 0.0 {
                // Divides only where the interval becomes shorter.
                if left < leave * along {
                    leave = left / along;
                }
            } else if left < enter * along {
                if along == 0.0 {
                    return false;
                }
                enter = left / along;
            }
            if enter > leave {
                return false;
            }
        }
        true
    }
}

/// A line's way through a hull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Parameters of the line where it enters and leaves.
    pub enter: f64,
    pub leave: f64,
    /// Indices into [`Hull::faces`].
    pub enter_face: usize,
    pub leave_face: usize,
}

impl Face {
    /// Returns the face's triangles, as indices into [`Hull::vertices`], counter-clockwise as seen from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        let rest = self.corners.get(1..).unwrap_or_default();
        let first = self.corners.first().copied().unwrap_or_default();
        rest.windows(2).map(move |w| [first, w[0], w[1]])
    }
}

/// Returns the middle of the box about the points and half of its sides; `None` without points or with one that is not finite.
fn bounds(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = points.first()?;
    let (mut low, mut high) = (*first, *first);
    for p in points {
        if !p.sum().is_finite() {
            return None;
        }
        (low, high) = (low.inf(p), high.sup(p));
    }
    Some(((low + high) / 2.0, (high - low) / 2.0))
}

/// Directions towards faces, edges and corners of a cube; the six faces first.
fn directions() -> impl Iterator<Item = Vec3> {
    let all = (0..27).map(|i| Vec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1)));
    let (faces, others): (Vec<Vec3>, Vec<Vec3>) = all
        .filter(|d| *d != Vec3::zeros())
        .partition(|d| d.norm_squared() == 1.0);
    faces.into_iter().chain(others).map(|d| d.normalize())
}

/// Returns the point that is farthest along `d`, the origin if there is none.
#[inline]
fn farthest(points: &[Vec3], d: &Vec3) -> Vec3 {
    let mut best = (f64::NEG_INFINITY, Vec3::zeros());
    for p in points {
        let along = d.x * p.x + d.y * p.y + d.z * p.z;
        if along > best.0 {
            best = (along, *p);
        }
    }
    best.1
}

/// Adds a point that is not there yet; says whether it did.
fn add(points: &mut Vec<Vec3>, p: Vec3) -> bool {
    let is_new = !points.contains(&p);
    if is_new {
        points.push(p);
    }
    is_new
}

/// Returns how far the corner farthest from the extreme points is from their hull, and the unit vector from there to it.
fn worst(polygons: &[Polygon], extreme: &[Vec3], known: &mut BTreeMap<[u64; 3], (f64, Vec3)>) -> Option<(f64, Vec3)> {
    let corners = polygons.iter().flat_map(|p| &p.corners);
    let apart = corners.map(|corner| {
        let key = [corner.x, corner.y, corner.z].map(f64::to_bits);
        *known.entry(key).or_insert_with(|| {
            let away = corner - collide::nearest_of_hull(extreme, corner);
            let apart = away.norm();
            (apart, away.try_normalize(ON).unwrap_or(Vec3::x()))
        })
    });
    apart.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Returns the faces of the box about the origin.
fn a_box(half: &Vec3) -> Vec<Polygon> {
    let mut polygons = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [1.0, -1.0] {
            let mut normal = Vec3::zeros();
            normal[axis] = side;
            // Counter-clockwise seen from outside: the axes u, v, axis are right-handed.
            let turns = [(1.0, 1.0), (-side, side), (-1.0, -1.0), (side, -side)];
            let corners = turns.map(|(a, b)| {
                let mut p = Vec3::zeros();
                (p[axis], p[u], p[v]) = (side * half[axis], a * half[u], b * half[v]);
                p
            });
            polygons.push(Polygon {
                normal,
                offset: half[axis],
                corners: corners.to_vec(),
            });
        }
    }
    polygons
}

/// Cuts off what lies beyond the plane `normal . p = offset`; says whether there was something.
fn cut(polygons: &mut Vec<Polygon>, normal: &Vec3, offset: f64) -> bool {
    let beyond = |p: &Vec3| normal.dot(p) - offset;
    if !polygons.iter().flat_map(|p| &p.corners).any(|p| beyond(p) > ON) {
        return false;
    }
    let mut rim: Vec<Vec3> = Vec::new();
    for polygon in polygons.iter_mut() {
        let old = std::mem::take(&mut polygon.corners);
        for (i, p) in old.iter().enumerate() {
            let q = &old[(i + 1) % old.len()];
            let (s, t) = (beyond(p), beyond(q));
            if s <= ON {
                polygon.corners.push(*p);
                if s >= -ON {
                    rim.push(*p);
                }
            }
            // INVARIANT: one end is off the plane by more than `ON` on each side, so that the divisor is not zero.
            if (s > ON && t < -ON) || (s < -ON && t > ON) {
                let x = p + (q - p) * (s / (s - t));
                polygon.corners.push(x);
                rim.push(x);
            }
        }
    }
    polygons.retain(|p| p.corners.len() >= 3);
    let corners = around(rim, normal);
    if !polygons.is_empty() && corners.len() >= 3 {
        polygons.push(Polygon {
            normal: *normal,
            offset,
            corners,
        });
    }
    true
}

/// Returns points of a plane in counter-clockwise order about their middle, those that are the same once.
fn around(mut points: Vec<Vec3>, normal: &Vec3) -> Vec<Vec3> {
    let middle = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    // Any axis that is not along the normal spans the plane with it.
    let least = normal.abs().imin();
    let mut aside = Vec3::zeros();
    aside[least] = 1.0;
    let u = normal.cross(&aside).normalize();
    let v = normal.cross(&u);
    let angle = |p: &Vec3| nalgebra::RealField::atan2((p - middle).dot(&v), (p - middle).dot(&u));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points.dedup_by(|a, b| (*a - *b).norm() <= SAME);
    if points.len() > 1 && (points[0] - points[points.len() - 1]).norm() <= SAME {
        points.pop();
    }
    points
}
