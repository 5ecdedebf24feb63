//! Lines of sight from one eye: which of many solids, if any, hides a point.
//!
//! Solids that cannot hide anything of the ball looked at are left out once ([`Cone`]: a ball against the hull of the eye and that ball);
//! what is left is tested point by point, first by the spheres about the solids, then by their closed forms
//! (`collide::Seen`). The last one that hid a point is asked first: neighbouring points are mostly hidden by the same one.
//! Does NOT say where a ray first meets something, and knows no field of view.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::collide::{Seen, Solid};
use super::{Pose, Vec3};

/// What can hide points of one ball from an eye E.
#[derive(Debug, Clone)]
pub struct Sight<'a> {
    cone: Cone,
    near: Vec<Around<'a>>,
}

/// One solid, and the ball about it.
#[derive(Debug, Clone)]
struct Around<'a> {
    /// The caller's number.
    id: usize,
    /// Its origin, measured from E and expressed in W [m].
    p_EB: Vec3,
    radius: f64,
    seen: Seen<'a>,
}

impl<'a> Sight<'a> {
    /// Returns an eye at `cone.apex` that looks at points of the cone's ball, with nothing around it.
    pub fn new(cone: Cone) -> Sight<'a> {
        Sight { cone, near: Vec::new() }
    }

    /// Adds a solid at `X_WS`, which answers call `id`, unless it can hide nothing.
    pub fn add(&mut self, id: usize, solid: &'a Solid, X_WS: &Pose) {
        let p_EB = X_WS.translation.vector - self.cone.apex;
        if self.cone.may_touch_from_apex(&p_EB, solid.radius()) {
            self.near.push(Around {
                id,
                p_EB,
                radius: solid.radius(),
                seen: Seen::new(solid, X_WS, &self.cone.apex),
            });
        }
    }

    /// Brings the solids that look larger to the front, so that what is hidden is mostly found at once. The answers are the same
    /// without.
    pub fn sort(&mut self) {
        let size = |s: &Around<'_>| s.radius * s.radius / s.p_EB.norm_squared();
        self.near
            .sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.id.cmp(&b.id)));
    }

    /// Says whether nothing can hide anything.
    pub fn is_clear(&self) -> bool {
        self.near.is_empty()
    }

    /// Returns the number of a solid that comes between the eye and the point `p_WQ` [m], if any does by more than `slack` [m] before
    /// the point; one that contains the eye hides everything.
    pub fn hidden_by(&mut self, p_WQ: &Vec3, slack: f64) -> Option<usize> {
        if self.near.is_empty() {
            return None;
        }
        let way = p_WQ - self.cone.apex;
        let length2 = way.norm_squared();
        let until = 1.0 - slack / length2.sqrt();
        let found = self.near.iter().position(|s| {
            let along = s.p_EB.dot(&way);
            // A little more than the ball, to be above rounding: it is for speed alone.
            let aside2 = s.p_EB.norm_squared() * length2 - along * along;
            let misses = aside2 > 1.001 * s.radius * s.radius * length2;
            !misses && s.seen.cuts(&way, until)
        })?;
        self.near[..=found].rotate_right(1);
        Some(self.near[0].id)
    }
}

/// The hull of a point, the apex, and a ball: all that lines of sight from the apex to points of the ball go through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    pub apex: Vec3,
    /// Middle of the ball, measured from the apex [m].
    axis: Vec3,
    length: f64,
    radius: f64,
}

/// What is nearer than this to a border is taken for touching [m].
const ROUNDING: f64 = 1e-9;

impl Cone {
    /// Returns the hull of `apex` and the ball of `radius` [m] about `centre` [m].
    pub fn new(apex: Vec3, centre: Vec3, radius: f64) -> Cone {
        let axis = centre - apex;
        Cone {
            apex,
            axis,
            length: axis.norm(),
            radius,
        }
    }

    /// Says whether a ball of `radius` [m] about `centre` touches the hull; never no where it does.
    pub fn may_touch(&self, centre: &Vec3, radius: f64) -> bool {
        self.may_touch_from_apex(&(centre - self.apex), radius)
    }

    /// As [`Cone::may_touch`], the centre measured from the apex.
    fn may_touch_from_apex(&self, centre: &Vec3, radius: f64) -> bool {
        let reach = radius + ROUNDING;
        let is_within = |p: &Vec3, r: f64| p.norm_squared() <= r * r;
        if is_within(centre, reach) || is_within(&(centre - self.axis), reach + self.radius) {
            return true;
        }
        // The apex lies in the ball, which is all there is.
        if self.length <= self.radius {
            return false;
        }
        // Beside the cone's side: the plane through the axis and the centre; x along the axis, y across, y >= 0.
        let u = self.axis / self.length;
        let x = centre.dot(&u);
        let y = (centre.norm_squared() - x * x).max(0.0).sqrt();
        let sine = self.radius / self.length;
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        // Along the side from the apex, and the distance from it outwards.
        let (along, out) = (x * cosine + y * sine, y * cosine - x * sine);
        // Beyond the ends of the side the apex and the ball decide, which are too far.
        along >= 0.0 && along <= self.length * cosine && out <= reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::collide::ray;
    use crate::geom::shape::Shape;
    use nalgebra::UnitQuaternion;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random_shape(rng: &mut ChaCha8Rng) -> Shape {
        let kind = rng.random_range(0..5);
        let mut size = || rng.random_range(0.02..0.4);
        match kind {
            0 => Shape::Box {
                half: Vec3::new(size(), size(), size()),
            },
            1 => Shape::Cylinder {
                radius: size(),
                half_length: size(),
            },
            2 => Shape::Sphere { radius: size() },
            3 => Shape::Capsule {
                radius: size(),
                half_length: size(),
            },
            _ => {
                let points: Vec<Vec3> = (0..12)
                    .map(|_| Vec3::new(size(), size(), size()) - Vec3::repeat(0.2))
                    .collect();
                match crate::geom::hull::Hull::around(&points) {
                    Some((hull, _)) => Shape::Hull(std::sync::Arc::new(hull)),
                    None => Shape::Sphere { radius: 0.1 },
                }
            }
        }
    }

    fn random_point(rng: &mut ChaCha8Rng, far: f64) -> Vec3 {
        Vec3::from_fn(|_, _| rng.random_range(-far..far))
    }

    #[test]
    fn what_hides_a_point_is_what_a_ray_meets() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut hidden, mut seen, mut differ) = (0, 0, 0);
        for _ in 0..400 {
            let solids: Vec<(Solid, Pose)> = (0..12)
                .map(|i| {
                    let shape = random_shape(&mut rng);
                    let solid = if i % 3 == 0 {
                        Solid::padded(&shape, 0.01)
                    } else {
                        Solid::new(&shape)
                    };
                    let turn = UnitQuaternion::from_scaled_axis(random_point(&mut rng, 2.0));
                    (solid, Pose::from_parts(random_point(&mut rng, 1.5).into(), turn))
                })
                .collect();
            let eye = random_point(&mut rng, 2.5);
            let (centre, radius) = (random_point(&mut rng, 1.5), rng.random_range(0.05..0.5));
            let mut sight = Sight::new(Cone::new(eye, centre, radius));
            for (i, (solid, X_WS)) in solids.iter().enumerate() {
                sight.add(i, solid, X_WS);
            }
            sight.sort();
            for _ in 0..40 {
                let p = centre + random_point(&mut rng, 1.0).normalize() * radius;
                let way = p - eye;
                let far = way.norm();
                let enters = |slack: f64| {
                    solids
                        .iter()
                        .any(|(s, X)| ray(s, X, &eye, &(way / far), far - slack).is_some())
                };
                let fast = sight.hidden_by(&p, 1e-6).is_some();
                if fast != enters(1e-6) {
                    // Only rounding at a border may tell the two apart.
                    let grown = |by: f64| {
                        solids.iter().any(|(s, X)| {
                            let (p_WR, towards) = (eye, way / far);
                            // A parallel ray beside it.
                            let aside = towards.cross(&Vec3::x()).normalize() * by;
                            ray(s, X, &(p_WR + aside), &towards, far - 1e-6).is_some()
                        })
                    };
                    assert!(
                        grown(1e-6) != grown(-1e-6) || enters(0.0) != enters(2e-6),
                        "{p} from {eye}"
                    );
                    differ += 1;
                }
                *(if fast { &mut hidden } else { &mut seen }) += 1;
            }
        }
        assert!(
            hidden > 2000 && seen > 2000 && differ < 5,
            "{hidden} hidden, {seen} seen, {differ} differ"
        );
    }

    #[test]
    fn a_cone_touches_what_some_line_of_sight_comes_near_to() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let (mut touching, mut apart) = (0, 0);
        for _ in 0..3000 {
            let (apex, centre) = (random_point(&mut rng, 1.0), random_point(&mut rng, 1.0));
            let (radius, p, r) = (
                rng.random_range(0.0..0.6),
                random_point(&mut rng, 0.8),
                rng.random_range(0.01..0.4),
            );
            let cone = Cone::new(apex, centre, radius);
            // The least distance from the hull: that of the balls which fill it, from the apex (0) to the centre (1).
            let least = (0..=2000)
                .map(|k| {
                    let t = f64::from(k) / 2000.0;
                    (apex + (centre - apex) * t - p).norm() - radius * t
                })
                .fold(f64::INFINITY, f64::min);
            if least < r - 1e-3 {
                assert!(cone.may_touch(&p, r), "{p} within {r} of the hull, {least}");
                touching += 1;
            } else if least > r + 1e-3 {
                assert!(!cone.may_touch(&p, r), "{p} not within {r} of the hull, {least}");
                apart += 1;
            }
        }
        assert!(touching > 300 && apart > 300, "{touching} touching, {apart} apart");
    }
}
