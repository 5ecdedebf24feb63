//! Times for a path: a motion from rest to rest within the limits of speed and acceleration.
//!
//! Corners are rounded by circular arcs (Kunz & Stilman, RSS 2012, doi:10.15607/RSS.2012.VIII.027: `blend`), the fastest speed along the
//! result is found on a grid (Pham & Pham, IEEE T-RO 34(3), 2018, doi:10.1109/TRO.2018.2819195: `profile`), and the motion is sampled.
//! The limits hold for the samples with straight lines in between, by this rule, which a validator can check:
//!
//! - velocity of segment k: `v_k = (q_{k+1} - q_k) / dt_k`, each `|v_k|` at most the dof's `max_velocity`;
//! - acceleration at sample k: `(v_k - v_{k-1}) / ((dt_{k-1} + dt_k) / 2)`, and at the two ends, from and to rest, `v / (dt / 2)`;
//!   each at most the dof's `max_acceleration`.
//!
//! A motion whose true velocity and acceleration are within the limits keeps this rule, since its differences are averages of them; what the grid
//! leaves over is stretched away. Does not bound jerk, and does not look for another path that would be faster.

mod blend;
mod profile;

use super::{Path, Space, between_is_free, length};
use crate::geom::kinematics::Dof;
use blend::Curve;
use profile::Profile;

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

/// A limit that is zero, negative or not a number cannot be kept; it counts as this slow.
const SLOWEST: f64 = 1e-3;
/// A limit that is infinite counts as this fast.
const FASTEST: f64 = 1e6;
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
    let (speeds, accelerations) = limits(space.dofs(), &vertices[0]);
    let mut deviations = vec![settings.max_deviation.max(0.0); vertices.len()];
    for (corner, deviation) in deviations.iter_mut().enumerate() {
        allow(space, &vertices, corner, deviation, settings.resolution);
    }
    loop {
        let curve = Curve::new(&vertices, &deviations);
        let profile = Profile::fastest(&curve, &speeds, &accelerations);
        let samples = sample(&curve, &profile, settings.sample_period);
        let blamed = blamed(space, &curve, &samples, settings.resolution);
        if blamed.is_empty() {
            return stretched(samples.timed, &speeds, &accelerations);
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

/// Speed and acceleration limits for each entry of `q`; an entry without a dof has none.
fn limits(dofs: &[Dof], q: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let sane = |v: f64| if v > 0.0 { v.clamp(SLOWEST, FASTEST) } else { SLOWEST };
    let of = |get: fn(&Dof) -> f64| {
        (0..q.len())
            .map(|i| dofs.get(i).map_or(FASTEST, |d| sane(get(d))))
            .collect()
    };
    (of(|d| d.max_velocity), of(|d| d.max_acceleration))
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

/// Samples with their places on the curve.
struct Samples {
    timed: Timed,
    s: Vec<f64>,
}

/// Samples each stretch between two stops evenly, the stops included.
fn sample(curve: &Curve, profile: &Profile, period: f64) -> Samples {
    let mut samples = Samples {
        timed: Timed {
            times: Vec::new(),
            positions: Vec::new(),
        },
        s: Vec::new(),
    };
    let mut push = |t: f64, s: f64, q: Vec<f64>| {
        samples.timed.times.push(t);
        samples.timed.positions.push(q);
        samples.s.push(s);
    };
    push(0.0, 0.0, curve.start().to_vec());
    let mut from = 0.0;
    let mut cursor = 0;
    for stop in curve.stops() {
        let to = profile.time_after(stop.after_piece);
        let n = ((to - from) / period).ceil().clamp(1.0, MAX_SAMPLES) as usize;
        for k in 1..n {
            let t = from + (to - from) * k as f64 / n as f64;
            let s = profile.place_at(t, &mut cursor);
            let mut q = Vec::new();
            curve.position(s, &mut q);
            push(t, s, q);
        }
        push(to, stop.s, stop.q.clone());
        from = to;
    }
    samples
}

/// The corners whose arcs share a line between samples that is not free.
///
/// A line that is not free and shares no arc lies on an edge of the path, about which the caller has been told at that resolution.
fn blamed(space: &mut dyn Space, curve: &Curve, samples: &Samples, resolution: f64) -> Vec<usize> {
    let mut corners = Vec::new();
    let mut scratch = Vec::new();
    for k in 1..samples.s.len() {
        let (a, b) = (&samples.timed.positions[k - 1], &samples.timed.positions[k]);
        if !(space.is_free(b) && between_is_free(space, a, b, resolution, &mut scratch)) {
            corners.extend(curve.corners_within(samples.s[k - 1], samples.s[k]));
        }
    }
    corners
}

/// Slows the whole motion down until the samples keep the rule above.
fn stretched(mut timed: Timed, speeds: &[f64], accelerations: &[f64]) -> Timed {
    // The second round is for what rounding left.
    for _ in 0..3 {
        let excess = excess(&timed, speeds, accelerations);
        if excess <= 1.0 {
            break;
        }
        for t in &mut timed.times {
            *t *= excess * (1.0 + 1e-9);
        }
    }
    timed
}

/// By how much the motion must be slower, as a factor of time; at most 1 when it keeps the rule.
fn excess(timed: &Timed, speeds: &[f64], accelerations: &[f64]) -> f64 {
    let mut worst = 0.0_f64;
    let n = timed.times.len();
    for j in 0..speeds.len() {
        let mut before = 0.0;
        let mut dt_before = 0.0;
        for k in 1..=n {
            // After the last sample: at rest.
            let (v, dt) = if k < n {
                let dt = timed.times[k] - timed.times[k - 1];
                ((timed.positions[k][j] - timed.positions[k - 1][j]) / dt, dt)
            } else {
                (0.0, 0.0)
            };
            let acceleration = (v - before) / (0.5 * (dt_before + dt));
            worst = worst
                .max(v.abs() / speeds[j])
                .max((acceleration.abs() / accelerations[j]).sqrt());
            (before, dt_before) = (v, dt);
        }
    }
    worst
}
