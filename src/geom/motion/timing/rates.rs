//! How fast a sampled motion is, by the rule of [`super`].

use super::Timed;
use crate::geom::kinematics::Dof;

/// A limit that is zero, negative or not a number cannot be kept; it counts as this slow.
const SLOWEST: f64 = 1e-3;
/// A limit that is infinite counts as this fast; a jerk, so that the fastest acceleration comes within a microsecond.
const FASTEST: f64 = 1e6;
const FASTEST_JERK: f64 = 1e12;

/// Limits for each entry of a configuration.
pub struct Limits {
    pub speeds: Vec<f64>,
    pub accelerations: Vec<f64>,
    pub jerks: Vec<f64>,
}

impl Limits {
    /// Returns the limits of `n` entries; one without a dof has none.
    pub fn new(dofs: &[Dof], n: usize) -> Limits {
        let of = |get: fn(&Dof) -> f64, fastest: f64| {
            let sane = |v: f64| if v > 0.0 { v.clamp(SLOWEST, fastest) } else { SLOWEST };
            (0..n).map(|i| dofs.get(i).map_or(fastest, |d| sane(get(d)))).collect()
        };
        Limits {
            speeds: of(|d| d.max_velocity, FASTEST),
            accelerations: of(|d| d.max_acceleration, FASTEST),
            jerks: of(|d| d.max_jerk, FASTEST_JERK),
        }
    }

    /// Returns the longest time that a joint needs to come from rest to its full acceleration [s].
    pub fn time_to_accelerate(&self) -> f64 {
        let times = self.accelerations.iter().zip(&self.jerks).map(|(a, j)| a / j);
        times.fold(0.0, f64::max)
    }
}

/// How much of its limits a motion uses: the largest quotients.
#[derive(Debug, Clone, Copy, Default)]
pub struct Use {
    pub speed: f64,
    pub acceleration: f64,
    pub jerk: f64,
}

impl Use {
    /// Returns the largest quotients of a motion.
    #[expect(clippy::needless_range_loop, reason = "a column of all rows")]
    pub fn of(timed: &Timed, limits: &Limits) -> Use {
        let (times, rows) = (&timed.times, &timed.positions);
        let mut most = Use::default();
        let n = times.len();
        if n < 2 {
            return most;
        }
        for j in 0..limits.speeds.len() {
            let dt = |k: usize| times[k + 1] - times[k];
            // At rest before and after, for as long as the interval beside.
            let (mut v, mut dt_before, mut a, mut dt_before_that) = (0.0, dt(0), 0.0, dt(0));
            for k in 0..=n {
                let (v_next, dt_next) = match k {
                    k if k + 1 < n => ((rows[k + 1][j] - rows[k][j]) / dt(k), dt(k)),
                    _ => (0.0, dt(n - 2)),
                };
                most.speed = most.speed.max(v_next.abs() / limits.speeds[j]);
                let a_next = (v_next - v) / (0.5 * (dt_before + dt_next));
                let at_end = if k == 0 || k + 1 == n { 2.0 } else { 1.0 };
                most.acceleration = most.acceleration.max(at_end * a_next.abs() / limits.accelerations[j]);
                let jerk = 3.0 * (a_next - a) / (dt_before_that + dt_before + dt_next);
                most.jerk = most.jerk.max(jerk.abs() / limits.jerks[j]);
                (v, dt_before_that, dt_before, a) = (v_next, dt_before, dt_next, a_next);
            }
        }
        most
    }

    /// Returns by how much the motion must be slower, as a factor of time; at most 1 when it keeps the limits.
    pub fn slowdown(&self) -> f64 {
        self.speed.max(self.acceleration.sqrt()).max(self.jerk.cbrt())
    }
}
