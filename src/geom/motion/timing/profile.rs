//! The fastest speed along a curve, on a grid.
//!
//! Reachability analysis on the square `x` of the speed along the curve, with the acceleration `u` along it as control (Pham & Pham, IEEE
//! T-RO 34(3), 2018, doi:10.1109/TRO.2018.2819195): backwards, the fastest `x` from which the end can still be met; forwards, the
//! largest `u` that keeps below. Limits hold at both ends of each grid interval. The two-variable linear programs are solved by
//! descending on the upper and lower envelopes of the constraints.

use super::blend::Curve;

/// Grid intervals of a whole curve, about; more where it bends.
const INTERVALS: f64 = 300.0;
/// Most that an arc turns within an interval [rad].
const TURN: f64 = 0.15;

/// `u_factor * u + x_factor * x <= bound`, with `bound >= 0`: rest is always allowed.
#[derive(Debug, Clone, Copy)]
struct Row {
    u_factor: f64,
    x_factor: f64,
    bound: f64,
}

/// A speed for each place of a grid on a curve.
#[derive(Debug)]
pub struct Profile {
    s: Vec<f64>,
    /// Square of the speed.
    x: Vec<f64>,
    t: Vec<f64>,
    /// The node at which each piece of the curve ends.
    piece_ends: Vec<usize>,
}

/// The grid with its constraints.
struct Grid {
    s: Vec<f64>,
    /// Largest `x` at each node by the speed limits; 0 at stops.
    x_max: Vec<f64>,
    rows: Vec<Row>,
    /// Where the rows of each interval begin, and where the last ones end.
    first_row: Vec<usize>,
    /// Along each interval, the largest `u` from rest.
    u_rest: Vec<f64>,
    piece_ends: Vec<usize>,
}

impl Grid {
    fn new(curve: &Curve, speeds: &[f64], accelerations: &[f64]) -> Grid {
        let mut grid = Grid {
            s: vec![0.0],
            x_max: vec![0.0],
            rows: Vec::new(),
            first_row: vec![0],
            u_rest: Vec::new(),
            piece_ends: Vec::new(),
        };
        for (start, piece) in curve.pieces() {
            let by_length = INTERVALS * piece.length() / curve.length();
            // Two at least, so that a line between two stops has a place to be fast.
            let n = by_length.max(piece.angle() / TURN).max(2.0).ceil() as usize;
            let step = piece.length() / n as f64;
            let is_arc = piece.angle() > 0.0;
            for k in 0..n {
                let (from, to) = (step * k as f64, step * (k + 1) as f64);
                let mut u_rest = f64::INFINITY;
                let mut x_to = f64::INFINITY;
                for ((j, here), ahead) in piece.derivatives(from).enumerate().zip(piece.derivatives(to)) {
                    let (v, a) = (speeds[j], accelerations[j]);
                    grid.allow(here.0, here.1, a);
                    if is_arc {
                        grid.allow(ahead.0 + 2.0 * step * ahead.1, ahead.1, a);
                    }
                    u_rest = u_rest.min(a / here.0.abs());
                    x_to = x_to.min((v / ahead.0).powi(2));
                    let x_from = (v / here.0).powi(2);
                    if let Some(x) = grid.x_max.last_mut() {
                        *x = x.min(x_from);
                    }
                }
                grid.u_rest.push(u_rest);
                grid.first_row.push(grid.rows.len());
                grid.s.push(start + to);
                grid.x_max.push(x_to);
            }
            grid.piece_ends.push(grid.s.len() - 1);
        }
        for stop in curve.stops() {
            if let Some(node) = grid.piece_ends.get(stop.after_piece) {
                grid.x_max[*node] = 0.0;
            }
        }
        grid
    }

    /// Both signs of `|u_factor u + x_factor x| <= bound`.
    fn allow(&mut self, u_factor: f64, x_factor: f64, bound: f64) {
        self.rows.push(Row {
            u_factor,
            x_factor,
            bound,
        });
        self.rows.push(Row {
            u_factor: -u_factor,
            x_factor: -x_factor,
            bound,
        });
    }

    fn rows(&self, interval: usize) -> &[Row] {
        &self.rows[self.first_row[interval]..self.first_row[interval + 1]]
    }
}

impl Profile {
    /// Returns the fastest profile from rest to rest that stops at the curve's stops.
    pub fn fastest(curve: &Curve, speeds: &[f64], accelerations: &[f64]) -> Profile {
        let grid = Grid::new(curve, speeds, accelerations);
        let n = grid.s.len() - 1;
        // Backwards: from at most this `x`, the rest of the way can be gone.
        let mut x_max = grid.x_max.clone();
        for i in (0..n).rev() {
            let step = grid.s[i + 1] - grid.s[i];
            x_max[i] = largest_x(grid.rows(i), step, x_max[i], x_max[i + 1]);
        }
        let mut x = vec![0.0; n + 1];
        let mut t = vec![0.0; n + 1];
        for i in 0..n {
            let step = grid.s[i + 1] - grid.s[i];
            let (_, upper) = envelopes(grid.rows(i), step, x[i], x_max[i + 1]);
            x[i + 1] = (x[i] + 2.0 * step * upper.0).max(0.0).min(x_max[i + 1]);
            let pace = x[i].sqrt() + x[i + 1].sqrt();
            // From rest to rest within an interval: half of it faster, half slower.
            let dt = if pace > 0.0 {
                2.0 * step / pace
            } else {
                2.0 * (step / grid.u_rest[i]).sqrt()
            };
            t[i + 1] = t[i] + dt;
        }
        Profile {
            s: grid.s,
            x,
            t,
            piece_ends: grid.piece_ends,
        }
    }

    /// The time at the end of a piece of the curve [s].
    pub fn time_after(&self, piece: usize) -> f64 {
        self.piece_ends.get(piece).map_or(0.0, |node| self.t[*node])
    }

    /// The place at a time; `cursor` remembers the interval, since times come in ascending order.
    pub fn place_at(&self, t: f64, cursor: &mut usize) -> f64 {
        while *cursor + 2 < self.t.len() && self.t[*cursor + 1] < t {
            *cursor += 1;
        }
        let i = *cursor;
        let (step, dt) = (self.s[i + 1] - self.s[i], self.t[i + 1] - self.t[i]);
        let tau = (t - self.t[i]).clamp(0.0, dt);
        let (v, w) = (self.x[i].sqrt(), self.x[i + 1].sqrt());
        if v + w > 0.0 {
            self.s[i] + (v * tau + 0.5 * (w - v) / dt * tau * tau).clamp(0.0, step)
        } else {
            self.s[i] + step * tau / dt
        }
    }
}

/// A bound on `u` at some `x`, with the slope of that bound.
type Bound = (f64, f64);

/// The largest lower and the smallest upper bound of `u` at `x`, when the next `x` lies in `[0, next_max]`.
fn envelopes(rows: &[Row], step: f64, x: f64, next_max: f64) -> (Bound, Bound) {
    let slope = -0.5 / step;
    let mut lower = (slope * x, slope);
    let mut upper = (0.5 * next_max / step + slope * x, slope);
    for row in rows {
        if row.u_factor.abs() < TINY {
            continue;
        }
        let u = (row.bound - row.x_factor * x) / row.u_factor;
        let slope = -row.x_factor / row.u_factor;
        if row.u_factor > 0.0 && u < upper.0 {
            upper = (u, slope);
        } else if row.u_factor < 0.0 && u > lower.0 {
            lower = (u, slope);
        }
    }
    (lower, upper)
}

/// A unit tangent's entry below this moves nothing.
const TINY: f64 = 1e-9;

/// The largest `x`, at most `x_max`, from which some `u` leads into `[0, next_max]` within the limits.
fn largest_x(rows: &[Row], step: f64, x_max: f64, next_max: f64) -> f64 {
    let mut x = x_max;
    for row in rows
        .iter()
        .filter(|row| row.u_factor.abs() < TINY && row.x_factor > 0.0)
    {
        x = x.min(row.bound / row.x_factor);
    }
    // Lower minus upper envelope is convex and not positive at rest: Newton's steps from the right come down to its root.
    for _ in 0..rows.len() + 2 {
        let (lower, upper) = envelopes(rows, step, x, next_max);
        let gap = lower.0 - upper.0;
        if gap <= 1e-12 * (1.0 + lower.0.abs()) {
            return x;
        }
        let next = x - gap / (lower.1 - upper.1);
        if next.is_nan() || next >= x || next <= 0.0 {
            return 0.0;
        }
        x = next;
    }
    x
}
