//! Triangle meshes, and the convex shapes that stand for them: one hull, or several convex parts.
//!
//! [`Mesh::parts`] halves the surface by planes along the axes, each time the part and the plane that save most volume of hulls, until
//! nothing worth while is saved. Both halves are closed where they were cut, so that the parts together contain the mesh and all that
//! it encloses. Differs from approximate convex decomposition by voxels (Mamou, Lengyel, Peters,
//! Game Engine Gems 3, 2016, chapter 12) in that nothing is lost to a resolution, and in planes along the axes only.
//! Does not know which side of a triangle is outside: a hull has no need of it, and a mirrored mesh is not turned inside out.

use super::Vec3;
use super::hull::Hull;

/// A mesh has at most this many parts.
const MOST_PARTS: usize = 16;
/// A cut that saves less than this share of the volume of the whole is not made. HEURISTIC: a gripper's palm and jaws come apart,
/// rounded edges do not.
const SAVES: f64 = 0.02;
/// Planes that are tried along each axis.
const PLANES: u32 = 7;
/// A mesh that is cut has at most this many triangles: others are coarse enough as one hull, or no model for collisions.
const MOST_TRIANGLES: usize = 200_000;

/// Triangles in one frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// [m]
    pub points: Vec<Vec3>,
    /// Indices into `points`.
    pub triangles: Vec<[u32; 3]>,
}

type Triangle = [Vec3; 3];

impl Mesh {
    /// Returns the hull around the mesh and where its frame's origin is in the mesh's frame; `None` for a mesh without extent.
    ///
    /// Points that no triangle uses do not count, unless there are no triangles.
    pub fn hull(&self) -> Option<(Hull, Vec3)> {
        let used: Vec<Vec3> = self.corners().flatten().collect();
        Hull::around(if used.is_empty() { &self.points } else { &used })
    }

    /// Returns convex parts that together contain the mesh, each with its frame's origin in the mesh's frame; the hull alone where
    /// that is as good. Empty for a mesh without extent.
    pub fn parts(&self) -> Vec<(Hull, Vec3)> {
        if self.triangles.len() > MOST_TRIANGLES {
            return self.hull().into_iter().collect();
        }
        let mut parts = vec![Part::new(self.corners().collect())];
        let whole = parts[0].volume;
        while parts.len() < MOST_PARTS {
            let best = (0..parts.len()).max_by(|a, b| parts[*a].saves().total_cmp(&parts[*b].saves()));
            let Some(best) = best.filter(|b| parts[*b].saves() > SAVES * whole) else {
                break;
            };
            let Some((axis, at, _)) = parts[best].cut else { break };
            let (below, above) = halves(&parts[best].triangles, axis, at);
            parts[best] = Part::new(below);
            parts.push(Part::new(above));
        }
        let hulls = parts.iter().filter_map(|p| Hull::around(p.triangles.as_flattened()));
        hulls.collect()
    }

    fn corners(&self) -> impl Iterator<Item = Triangle> + '_ {
        let point = |i: u32| self.points.get(i as usize).copied();
        self.triangles
            .iter()
            .filter_map(move |[a, b, c]| Some([point(*a)?, point(*b)?, point(*c)?]))
    }
}

/// A piece of the surface.
struct Part {
    triangles: Vec<Triangle>,
    /// Of a coarse hull [m^3].
    volume: f64,
    /// The axis and place of the best cut, and the volume of the two halves.
    cut: Option<(usize, f64, f64)>,
}

impl Part {
    fn new(triangles: Vec<Triangle>) -> Part {
        let points = triangles.as_flattened();
        let volume = Hull::volume_around(points);
        let mut cut: Option<(usize, f64, f64)> = None;
        for axis in 0..3 {
            let (low, high) = points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                    (low.min(p[axis]), high.max(p[axis]))
                });
            for k in 1..=PLANES {
                let at = low + (high - low) * f64::from(k) / f64::from(PLANES + 1);
                let (below, above) = halves(&triangles, axis, at);
                let halves = Hull::volume_around(below.as_flattened()) + Hull::volume_around(above.as_flattened());
                if cut.is_none_or(|(_, _, least)| halves < least) {
                    cut = Some((axis, at, halves));
                }
            }
        }
        Part { triangles, volume, cut }
    }

    /// Returns the volume that the best cut takes off [m^3].
    fn saves(&self) -> f64 {
        self.cut.map_or(0.0, |(_, _, halves)| self.volume - halves)
    }
}

/// Returns the triangles below and above `at` on the axis; those across are cut, and both halves are closed where they were.
fn halves(triangles: &[Triangle], axis: usize, at: f64) -> (Vec<Triangle>, Vec<Triangle>) {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    let mut rim: Vec<[Vec3; 2]> = Vec::new();
    for triangle in triangles {
        let sides = triangle.map(|p| p[axis] - at);
        for i in 0..3 {
            if sides[i] == 0.0 && sides[(i + 1) % 3] == 0.0 {
                rim.push([triangle[i], triangle[(i + 1) % 3]]);
            }
        }
        if sides.iter().all(|s| *s <= 0.0) {
            below.push(*triangle);
        } else if sides.iter().all(|s| *s >= 0.0) {
            above.push(*triangle);
        } else {
            let mut polygons: [Vec<Vec3>; 2] = [Vec::new(), Vec::new()];
            let mut cut = Vec::new();
            for i in 0..3 {
                let (p, q) = (triangle[i], triangle[(i + 1) % 3]);
                let (s, t) = (sides[i], sides[(i + 1) % 3]);
                if s <= 0.0 {
                    polygons[0].push(p);
                }
                if s >= 0.0 {
                    polygons[1].push(p);
                }
                if s == 0.0 {
                    cut.push(p);
                }
                if (s < 0.0 && t > 0.0) || (s > 0.0 && t < 0.0) {
                    let x = p + (q - p) * (s / (s - t));
                    polygons[0].push(x);
                    polygons[1].push(x);
                    cut.push(x);
                }
            }
            if let [p, q] = cut[..] {
                rim.push([p, q]);
            }
            for (polygon, half) in polygons.iter().zip([&mut below, &mut above]) {
                let rest = polygon.get(1..).unwrap_or_default();
                half.extend(rest.windows(2).map(|w| [polygon[0], w[0], w[1]]));
            }
        }
    }
    // The triangles between the rim and any point of the plane cover all that the rim encloses: a ray from that point through one of
    // what is enclosed comes to the rim behind it.
    let middle = rim.as_flattened().iter().sum::<Vec3>() / (2 * rim.len()).max(1) as f64;
    for [p, q] in rim {
        below.push([p, q, middle]);
        above.push([p, q, middle]);
    }
    (below, above)
}
