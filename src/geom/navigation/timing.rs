//! Times for a path of a base: from rest to rest within the limits of its speeds and accelerations.
//!
//! Uses the timing of joint motions (`geom::motion::timing`), with the same rule for what the samples keep: here for the length of the velocity on
//! the floor and for the turning rate. A differential base stops wherever it begins or ends a turn; a holonomic one rounds corners
//! where the rounded way is free.

use super::path::Way;
use super::{BasePose, Drive, Floor, apart};
use crate::geom::kinematics::Dof;
use crate::geom::motion::Space;
use crate::geom::motion::timing::{self, Timed};

/// What a base can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// [m/s], [rad/s]
    pub speed: f64,
    pub turn_rate: f64,
    /// [m/s^2], [rad/s^2]
    pub acceleration: f64,
    pub turn_acceleration: f64,
}

impl Default for Limits {
    /// Of a careful robot in a house; a model file says better.
    fn default() -> Self {
        Limits {
            speed: 0.6,
            turn_rate: 1.0,
            acceleration: 0.5,
            turn_acceleration: 1.0,
        }
    }
}

/// Longest time between samples [s].
const PERIOD: f64 = 0.1;
/// How far a rounded corner passes from its vertex at most, metres and radians alike.
const DEVIATION: f64 = 0.1;

/// Returns the motion along the ways: rows are x, y [m] and heading [rad], linear in between.
///
/// Rounded corners are looked at with `floor`, at its margin.
pub fn time(floor: &mut dyn Floor, ways: &[Way], drive: Drive, limits: &Limits) -> Timed {
    let mut corners: Vec<BasePose> = ways.first().map(|w| w.from).into_iter().collect();
    corners.extend(ways.iter().map(|w| w.to));
    let timed = match drive {
        Drive::Differential => one_by_one(&corners, limits),
        Drive::Holonomic => rounded(floor, &corners, limits),
    };
    slowed(timed, limits)
}

fn dof(name: &str, max_velocity: f64, max_acceleration: f64) -> Dof {
    Dof {
        name: name.to_owned(),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        max_velocity,
        max_acceleration,
        max_jerk: f64::INFINITY,
    }
}

/// The way along a line, as a share of it; nothing is asked about it.
struct Along([Dof; 1]);

impl Space for Along {
    fn dofs(&self) -> &[Dof] {
        &self.0
    }

    fn is_free(&mut self, _: &[f64]) -> bool {
        true
    }
}

/// From rest to rest along each line.
fn one_by_one(corners: &[BasePose], limits: &Limits) -> Timed {
    let mut all = Timed {
        times: vec![0.0; corners.len().min(1)],
        positions: corners.first().map(|c| c.to_vec()).into_iter().collect(),
    };
    for line in corners.windows(2) {
        let (a, b) = (&line[0], &line[1]);
        let (metres, angle) = (apart([a[0], a[1]], [b[0], b[1]]), (b[2] - a[2]).abs());
        // What there is none of limits nothing.
        let least = |on_floor: f64, turning: f64| {
            let by = |limit: f64, much: f64| if much > 0.0 { limit / much } else { f64::INFINITY };
            by(on_floor, metres).min(by(turning, angle))
        };
        let share = dof(
            "share",
            least(limits.speed, limits.turn_rate),
            least(limits.acceleration, limits.turn_acceleration),
        );
        let settings = timing::Settings {
            sample_period: PERIOD,
            max_deviation: 0.0,
            resolution: 1.0,
        };
        let timed = timing::time(&mut Along([share]), &vec![vec![0.0], vec![1.0]], &settings);
        let begin = all.times.last().copied().unwrap_or(0.0);
        for (t, row) in timed.times.iter().zip(&timed.positions).skip(1) {
            all.times.push(begin + t);
            let share = row.first().copied().unwrap_or(1.0);
            all.positions
                .push((0..3).map(|i| a[i] + share * (b[i] - a[i])).collect());
        }
    }
    all
}

/// The base's own space: x, y and the heading.
struct OnFloor<'a> {
    floor: &'a mut dyn Floor,
    dofs: [Dof; 3],
}

impl Space for OnFloor<'_> {
    fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        matches!(q, [x, y, yaw] if self.floor.is_free(&[*x, *y, *yaw]))
    }
}

/// All lines in one go, corners rounded.
fn rounded(floor: &mut dyn Floor, corners: &[BasePose], limits: &Limits) -> Timed {
    // Between two poses looked at, no point of the agent moves farther than twice the margin.
    let resolution = 2.0 * floor.margin() / (1.0 + floor.radius() * floor.radius()).sqrt();
    let mut space = OnFloor {
        floor,
        dofs: [
            dof("x", limits.speed, limits.acceleration),
            dof("y", limits.speed, limits.acceleration),
            dof("yaw", limits.turn_rate, limits.turn_acceleration),
        ],
    };
    let settings = timing::Settings {
        sample_period: PERIOD,
        max_deviation: DEVIATION,
        resolution,
    };
    let path = corners.iter().map(|c| c.to_vec()).collect();
    timing::time(&mut space, &path, &settings)
}

/// Slows the whole motion down until speeds and accelerations on the floor are within their limits, whatever their direction.
fn slowed(mut timed: Timed, limits: &Limits) -> Timed {
    // The second round is for what rounding left.
    for _ in 0..3 {
        let excess = excess(&timed, limits);
        if excess <= 1.0 {
            break;
        }
        for t in &mut timed.times {
            *t *= excess * (1.0 + 1e-9);
        }
    }
    timed
}

/// By how much the motion must be slower, as a factor of time; at most 1 when it is within its limits.
fn excess(timed: &Timed, limits: &Limits) -> f64 {
    let mut worst = 0.0_f64;
    let (mut before, mut dt_before) = ([0.0; 3], 0.0);
    let n = timed.times.len();
    for k in 1..=n {
        let (v, dt): ([f64; 3], f64) = if k < n {
            let dt = timed.times[k] - timed.times[k - 1];
            let (a, b) = (&timed.positions[k - 1], &timed.positions[k]);
            (std::array::from_fn(|i| (b[i] - a[i]) / dt), dt)
        } else {
            ([0.0; 3], 0.0)
        };
        let gap = 0.5 * (dt_before + dt);
        let a: [f64; 3] = std::array::from_fn(|i| (v[i] - before[i]) / gap);
        let length = |v: &[f64; 3]| (v[0] * v[0] + v[1] * v[1]).sqrt();
        worst = worst
            .max(length(&v) / limits.speed)
            .max(v[2].abs() / limits.turn_rate)
            .max((length(&a) / limits.acceleration).sqrt())
            .max((a[2].abs() / limits.turn_acceleration).sqrt());
        (before, dt_before) = (v, dt);
    }
    worst
}
