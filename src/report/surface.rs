//! Shapes as triangles, for formats that know nothing else.

use std::f64::consts::{PI, TAU};

use nalgebra::ComplexField;

use crate::geom::Vec3;
use crate::geom::shape::Shape;

/// Triangles of a surface; each corner has the normal of the surface there, so that edges stay sharp and round things look round.
#[derive(Debug, Default)]
pub(super) struct Surface {
    /// In the shape's frame [m].
    pub positions: Vec<Vec3>,
    /// Unit vectors out of the body, one for each position.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Sides of a round thing.
const AROUND: u32 = 32;
/// Rings from the pole of a ball to its equator.
const RINGS: u32 = 8;

impl Surface {
    /// Returns the surface of a shape.
    pub(super) fn of(shape: &Shape) -> Surface {
        let mut surface = Surface::default();
        match shape {
            Shape::Box { half } => surface.add_box(half),
            Shape::Cylinder { radius, half_length } => {
                surface.revolve(&[
                    (0.0, *half_length, Vec3::z()),
                    (*radius, *half_length, Vec3::z()),
                    (*radius, *half_length, Vec3::x()),
                    (*radius, -half_length, Vec3::x()),
                    (*radius, -half_length, -Vec3::z()),
                    (0.0, -half_length, -Vec3::z()),
                ]);
            }
            Shape::Sphere { radius } => surface.revolve(&ball(*radius, 0.0)),
            Shape::Capsule { radius, half_length } => surface.revolve(&ball(*radius, *half_length)),
            Shape::Hull(hull) => {
                for face in &hull.faces {
                    let first = surface.positions.len() as u32;
                    for &corner in &face.corners {
                        surface.push(hull.vertices[corner], face.normal);
                    }
                    for i in 2..face.corners.len() as u32 {
                        surface.triangles.push([first, first + i - 1, first + i]);
                    }
                }
            }
        }
        surface
    }

    fn push(&mut self, position: Vec3, normal: Vec3) {
        self.positions.push(position);
        self.normals.push(normal);
    }

    fn add_box(&mut self, half: &Vec3) {
        for axis in 0..3 {
            for side in [1.0, -1.0] {
                let mut normal = Vec3::zeros();
                normal[axis] = side;
                // Turned with the side, so that the corners run counter-clockwise as seen from outside.
                let mut u = Vec3::zeros();
                u[(axis + 1) % 3] = side;
                let v = normal.cross(&u);
                let first = self.positions.len() as u32;
                for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    self.push((normal + u * s + v * t).component_mul(half), normal);
                }
                self.triangles.push([first, first + 1, first + 2]);
                self.triangles.push([first, first + 2, first + 3]);
            }
        }
    }

    /// Turns a profile about z: points (distance from the axis, height) with their normals in the plane of x and z, from the top down.
    fn revolve(&mut self, profile: &[(f64, f64, Vec3)]) {
        let n = profile.len() as u32;
        for k in 0..=AROUND {
            // The last column is the first one again, to the bit.
            let (sin, cos) = ComplexField::sin_cos(f64::from(k % AROUND) * TAU / f64::from(AROUND));
            for (r, z, normal) in profile {
                self.push(
                    Vec3::new(r * cos, r * sin, *z),
                    Vec3::new(normal.x * cos, normal.x * sin, normal.z),
                );
            }
        }
        for k in 0..AROUND {
            for i in 0..n - 1 {
                let (upper, lower) = (&profile[i as usize], &profile[i as usize + 1]);
                // An edge: one place with two normals.
                if (upper.0, upper.1) == (lower.0, lower.1) {
                    continue;
                }
                let (a, b) = (k * n + i, (k + 1) * n + i);
                // A triangle with two corners on the axis has no area.
                if lower.0 > 0.0 {
                    self.triangles.push([a, a + 1, b + 1]);
                }
                if upper.0 > 0.0 {
                    self.triangles.push([a, b + 1, b]);
                }
            }
        }
    }
}

/// The profile of a ball whose halves are drawn apart by `half_length` each.
fn ball(radius: f64, half_length: f64) -> Vec<(f64, f64, Vec3)> {
    let at = |ring: u32, middle: f64| {
        let (sin, cos) = ComplexField::sin_cos(f64::from(ring) * PI / f64::from(2 * RINGS));
        // Exactly on the axis at the poles.
        let sin = if ring == 2 * RINGS { 0.0 } else { sin };
        (radius * sin, middle + radius * cos, Vec3::new(sin, 0.0, cos))
    };
    let upper = (0..=RINGS).map(|ring| at(ring, half_length));
    let lower = (RINGS..=2 * RINGS).map(|ring| at(ring, -half_length));
    upper.chain(lower).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The volume that the triangles enclose [m^3]; negative if they are wound the wrong way.
    fn volume(surface: &Surface) -> f64 {
        let p = &surface.positions;
        let corners = surface.triangles.iter().map(|t| t.map(|i| p[i as usize]));
        corners.map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum()
    }

    #[test]
    fn surfaces_enclose_their_volume_and_look_outward() {
        let shapes = [
            Shape::Box {
                half: Vec3::new(0.1, 0.2, 0.3),
            },
            Shape::Cylinder {
                radius: 0.2,
                half_length: 0.5,
            },
            Shape::Sphere { radius: 0.3 },
            Shape::Capsule {
                radius: 0.1,
                half_length: 0.4,
            },
        ];
        for shape in shapes {
            let surface = Surface::of(&shape);
            let share = volume(&surface) / shape.volume();
            assert!((0.97..1.0 + 1e-9).contains(&share), "{shape:?}: {share}");
            for t in &surface.triangles {
                let [a, b, c] = t.map(|i| surface.positions[i as usize]);
                let across = (b - a).cross(&(c - a));
                for i in t {
                    assert!(across.dot(&surface.normals[*i as usize]) > 0.0, "{shape:?}");
                }
            }
        }
    }
}
