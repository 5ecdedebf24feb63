//! Times for a path: a motion from rest to rest within the limits of speed, acceleration and jerk.
//!
//! Corners are rounded by circular arcs (Kunz & Stilman, RSS 2012, doi:10.15607/RSS.2012.VIII.027: `blend`), the fastest speed along the
//! result is found on a grid (Pham & Pham, IEEE T-RO 34(3), 2018, doi:10.1109/TRO.2018.2819195: `profile`), a moving average takes the steps out of
//! the acceleration (`smooth`), and the motion is sampled.
//! The limits hold for the samples by this rule, which a validator can check; the motion is at rest before its first sample and after its last:
//!
//! - velocity of segment k: `v_k = (q_{k+1} - q_k) / dt_k`, each `|v_k|` at most the dof's `max_velocity`;
//! - acceleration at sample k: `a_k = (v_k - v_{k-1}) / ((dt_{k-1} + dt_k) / 2)`, and at the two ends, from and to rest, `v / (dt / 2)`;
//!   each at most the dof's `max_acceleration`;
//! - jerk of segment k: `3 (a_{k+1} - a_k) / (dt_{k-1} + dt_k + dt_{k+1})`, each at most the dof's `max_jerk`; here the ends have samples at rest
//!   beyond them, as far apart as the samples beside.
//!
//! These are divided differences, hence averages of the true velocity, acceleration and jerk: a motion within the limits keeps the rule. What the grids
//! leave over is stretched away. Does not look for another path that would be faster.

mod blend;
mod profile;
mod rates;
mod smooth;

use super::{Path, Space, length, onward_is_free};
use blend::Curve;
use profile::Profile;
use rates::{Limits, Use};
use smooth::Motion;

/// Sampling and rounding. No `Default`: the caller knows what follows the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Longest time between samples [s], before any stretching.
    pub sample_period: f64,
    /// Farthest that a rounded corner may pass from the path's vertex, in the joint metric [rad]; 0 stops at each corner.
    pub max_deviation: f64,
    /// Spacing of the checks on rounded corners and between samples [rad].
    pub resolution: f64,
}

/// A motion: at `times[k]` it is at `positions[k]`, and on a straight line in between.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// From 0 on, ascending [s].
    pub times: Vec<f64>,
    /// As many configurations.
    pub positions: Vec<Vec<f64>>,
}

impl Timed {
    /// Returns the time of the last sample [s].
    pub fn duration(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }
}

/// Samples of one motion between two stops, whatever the period.
const MAX_SAMPLES: f64 = 100_000.0;
/// A corner that is not free is tried again at half of the deviation, so many times.
const HALVINGS: u32 = 2;

/// Returns the samples of a motion along `path`, which is free at the resolution.
///
/// The first and the last sample are the path's ends, exactly. Rounded corners and the lines between samples are checked with `space`;
/// where they are not free, the motion stops at the corner. A path without length is one sample; an empty path none.
pub fn time(space: &mut dyn Space, path: &Path, settings: &Settings) -> Timed {
    let vertices = distinct(path);
    if vertices.len() < 2 {
        return Timed {
            times: vec![0.0; vertices.len()],
            positions: vertices,
        };
    }
    let limits = Limits::new(space.dofs(), vertices[0].len());
    let mut deviations = vec![settings.max_deviation.max(0.0); vertices.len()];
    for (corner, deviation) in deviations.iter_mut().enumerate() {
        allow(space, &vertices, corner, deviation, settings.resolution);
    }
    loop {
        let curve = Curve::new(&vertices, &deviations);
        let profile = Profile::fastest(&curve, &limits.speeds, &limits.accelerations);
        let samples = smoothed(&curve, &profile, settings.sample_period, &limits);
        let blamed = blamed(space, &curve, &samples, settings.resolution);
        if blamed.is_empty() {
            return stretched(samples.timed, &limits);
        }
        // Each round has more stops, hence this ends.
        for corner in blamed {
            deviations[corner] = 0.0;
        }
    }
}

/// Edges shorter than this are left out [rad], unless there is no other.
const MIN_EDGE: f64 = 1e-7;
/// A path shorter than this has no direction [rad].
const NO_LENGTH: f64 = 1e-12;

/// The path's vertices without repetitions; the ends are the path's own.
fn distinct(path: &Path) -> Path {
    let mut vertices: Path = Vec::with_capacity(path.len());
    for q in path {
        if vertices.last().is_none_or(|last| length(last, q) > MIN_EDGE) {
            vertices.push(q.clone());
        }
    }
    let (Some(start), Some(end)) = (path.first(), path.last()) else {
        return vertices;
    };
    while vertices.len() > 1 && vertices.last().is_some_and(|last| length(last, end) <= MIN_EDGE) {
        vertices.pop();
    }
    if vertices.len() > 1 || length(start, end) > NO_LENGTH {
        vertices.push(end.clone());
    }
    vertices
}

/// Makes the deviation at a corner smaller until the arc is free; 0 when none is.
fn allow(space: &mut dyn Space, vertices: &Path, corner: usize, deviation: &mut f64, resolution: f64) {
    for _ in 0..=HALVINGS {
        let Some(arc) = blend::arc_at(vertices, corner, *deviation) else {
            return;
        };
        let n = (arc.length() / resolution).ceil().clamp(1.0, MAX_SAMPLES) as usize;
        let mut q = Vec::new();
        let free = (0..=n).all(|i| {
            arc.position(arc.length() * i as f64 / n as f64, &mut q);
            space.is_free(&q)
        });
        if free {
            return;
        }
        *deviation *= 0.5;
    }
    *deviation = 0.0;
}

/// Samples, and the part of the curve that each one but the first and the one before it are means of.
struct Samples {
    timed: Timed,
    parts: Vec<(f64, f64)>,
}

/// Samples with a window as short as the limits of jerk allow.
///
/// In time `a / j` a joint can go from rest to full acceleration; from full braking to full acceleration takes twice as long.
fn smoothed(curve: &Curve, profile: &Profile, period: f64, limits: &Limits) -> Samples {
    let window = limits.time_to_accelerate();
    let samples = sample(curve, profile, period, window);
    let jerk = Use::of(&samples.timed, limits).jerk;
    if (NEAR_ENOUGH..=1.0).contains(&jerk) {
        return samples;
    }
    sample(curve, profile, period, window * jerk.clamp(0.0, 2.0))
}

/// A window that uses as much of the limits of jerk is short enough.
const NEAR_ENOUGH: f64 = 0.95;
/// A window that is shorter than this changes nothing [s]: jerk has no limit.
const NO_WINDOW: f64 = 1e-5;

/// Samples each stretch between two stops evenly, the stops included.
fn sample(curve: &Curve, profile: &Profile, period: f64, window: f64) -> Samples {
    let window = if window > NO_WINDOW { window } else { 0.0 };
    let mut samples = Samples {
        timed: Timed {
            times: vec![0.0],
            positions: vec![curve.start().to_vec()],
        },
        parts: Vec::new(),
    };
    let (mut from, mut s_from, mut start) = (0.0, 0.0, 0.0);
    for stop in curve.stops() {
        let to = profile.time_after(stop.after_piece);
        let mut cursor = 0;
        let motion = (window > 0.0).then(|| {
            Motion::new(to - from, window, period, |t, q| {
                curve.position(profile.place_at(from + t, &mut cursor), q);
            })
        });
        let duration = to - from + window;
        let n = (duration / period).ceil().clamp(1.0, MAX_SAMPLES) as usize;
        let (mut oldest, mut newest, mut s_oldest) = (0, 0, s_from);
        for k in 1..=n {
            let t = duration * k as f64 / n as f64;
            let s_newest = profile.place_at((from + t).min(to), &mut newest);
            samples.parts.push((s_oldest, s_newest));
            s_oldest = profile.place_at((from + t - window).clamp(from, to), &mut oldest);
            let mut q = Vec::new();
            match &motion {
                _ if k == n => q.extend_from_slice(&stop.q),
                Some(motion) => motion.mean(t, window, &mut q),
                None => curve.position(s_newest, &mut q),
            }
            samples.timed.times.push(start + t);
            samples.timed.positions.push(q);
        }
        start += duration;
        (from, s_from) = (to, stop.s);
    }
    samples
}

/// The corners whose arcs share a line between samples that is not free.
///
/// A line that is not free and shares no arc lies on an edge of the path, about which the caller has been told at that resolution.
fn blamed(space: &mut dyn Space, curve: &Curve, samples: &Samples, resolution: f64) -> Vec<usize> {
    let mut corners = Vec::new();
    let mut scratch = Vec::new();
    for (line, (from, to)) in samples.timed.positions.windows(2).zip(&samples.parts) {
        if !onward_is_free(space, &line[0], &line[1], resolution, &mut scratch) {
            corners.extend(curve.corners_within(*from, *to));
        }
    }
    corners
}

/// Slows the whole motion down until the samples keep the rule above.
fn stretched(mut timed: Timed, limits: &Limits) -> Timed {
    // The second round is for what rounding left.
    for _ in 0..3 {
        let slowdown = Use::of(&timed, limits).slowdown();
        if slowdown <= 1.0 {
            break;
        }
        for t in &mut timed.times {
            *t *= slowdown * (1.0 + 1e-9);
        }
    }
    timed
}
