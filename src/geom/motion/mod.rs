//! Paths and trajectories in a joint space.
//!
//! A path is found by [`rrt_connect`], made shorter by [`shortcut`], and gets its times from [`timing`]; [`straight`] moves the tool on a
//! line instead. All of them ask the caller's [`Space`] whether a configuration is free, at stated distances: what is thinner than the
//! resolution can be missed between two checks, so the caller plans with padded shapes.
//! The metric is Euclid's norm of the joint vector, radians and metres alike.

pub mod rrt_connect;
pub mod shortcut;
pub mod straight;
pub mod timing;

use super::kinematics::Dof;

/// Configurations, straight lines in between; the ends are included.
pub type Path = Vec<Vec<f64>>;

/// The joint space of what moves, with everything in its way.
pub trait Space {
    /// Returns the degrees of freedom, in the order of `q`.
    fn dofs(&self) -> &[Dof];
    /// Returns whether nothing is hit at `q`. `&mut` for the implementor's scratch memory: the same `q` has the same answer.
    fn is_free(&mut self, q: &[f64]) -> bool;
    /// Returns whether nothing is hit at any of the configurations, which stand one after the other in `qs`; at most [`BATCH`] of them.
    ///
    /// For spaces that look at several at once. The same answer as [`Space::is_free`] of each, which is what the default does.
    fn all_free(&mut self, qs: &[f64]) -> bool {
        let dim = self.dofs().len().max(1);
        qs.chunks_exact(dim).all(|q| self.is_free(q))
    }
}

/// So many configurations are asked for together: as many numbers as the widest registers of common processors hold.
pub const BATCH: usize = 8;

/// An edge is checked at so many points at most, whatever the resolution.
const MAX_CHECKS: usize = 100_000;

/// Returns the distance in the joint metric [rad] or [m].
pub fn length(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
}

/// Returns whether both ends and points between them, at most `resolution` apart in the joint metric, are free.
///
/// The points come in spread order, halves first, so that a hit shows early.
pub fn edge_is_free(space: &mut dyn Space, a: &[f64], b: &[f64], resolution: f64) -> bool {
    space.is_free(a) && onward_is_free(space, a, b, resolution, &mut Vec::new())
}

/// Like [`edge_is_free`] for an `a` that is known to be free.
fn onward_is_free(space: &mut dyn Space, a: &[f64], b: &[f64], resolution: f64, scratch: &mut Vec<f64>) -> bool {
    scratch.clear();
    scratch.extend_from_slice(b);
    spread_is_free(space, a, b, resolution, scratch)
}

/// Like [`edge_is_free`] without the ends.
fn between_is_free(space: &mut dyn Space, a: &[f64], b: &[f64], resolution: f64, scratch: &mut Vec<f64>) -> bool {
    scratch.clear();
    spread_is_free(space, a, b, resolution, scratch)
}

/// Whether the points between `a` and `b` are free, and those that are in `batch` already.
fn spread_is_free(space: &mut dyn Space, a: &[f64], b: &[f64], resolution: f64, batch: &mut Vec<f64>) -> bool {
    let distance = length(a, b);
    if !distance.is_finite() {
        return false;
    }
    // A resolution that is no positive number gives infinity or NaN here, and then the most that is allowed.
    let n = (distance / resolution).ceil();
    let n = if distance == 0.0 || n <= 1.0 {
        1
    } else if n < MAX_CHECKS as f64 {
        n as usize
    } else {
        MAX_CHECKS
    };
    let full = BATCH * a.len();
    // Odd multiples of each power of two below n: every number from 1 to n - 1 once.
    let mut stride = n.next_power_of_two() / 2;
    while stride > 0 {
        for i in (stride..n).step_by(2 * stride) {
            push_between(a, b, i as f64 / n as f64, batch);
            if batch.len() >= full {
                if !space.all_free(batch) {
                    return false;
                }
                batch.clear();
            }
        }
        stride /= 2;
    }
    batch.is_empty() || space.all_free(batch)
}

/// Puts `a + t (b - a)` into `q`.
fn interpolate(a: &[f64], b: &[f64], t: f64, q: &mut Vec<f64>) {
    q.clear();
    push_between(a, b, t, q);
}

/// Appends `a + t (b - a)` to `qs`.
fn push_between(a: &[f64], b: &[f64], t: f64, qs: &mut Vec<f64>) {
    qs.extend(a.iter().zip(b).map(|(a, b)| a + t * (b - a)));
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Recorder(Vec<f64>);
    impl Space for Recorder {
        fn dofs(&self) -> &[Dof] {
            &[]
        }
        fn is_free(&mut self, q: &[f64]) -> bool {
            self.0.push(q[0]);
            true
        }
    }

    #[test]
    fn an_edge_is_checked_once_everywhere_and_halves_first() {
        for n in [1, 2, 3, 7, 8, 9, 100] {
            let mut space = Recorder(Vec::new());
            assert!(edge_is_free(&mut space, &[0.0], &[n as f64], 1.0));
            let first = space.0.get(2).copied();
            assert_eq!(first, (n > 1).then_some((n as usize).next_power_of_two() as f64 / 2.0));
            space.0.sort_by(f64::total_cmp);
            let all: Vec<f64> = (0..=n).map(f64::from).collect();
            assert_eq!(space.0.iter().map(|v| v.round()).collect::<Vec<_>>(), all);
        }
    }

    #[test]
    fn odd_numbers_end() {
        let mut space = Recorder(Vec::new());
        assert!(edge_is_free(&mut space, &[0.0], &[1.0], 0.0));
        assert!(!edge_is_free(&mut space, &[0.0], &[f64::NAN], 0.1));
        assert!(edge_is_free(&mut space, &[1.0], &[1.0], f64::NAN));
    }
}
