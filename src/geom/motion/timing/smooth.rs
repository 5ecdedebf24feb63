//! A motion with bounded acceleration made one with bounded jerk: its moving average over a window of time.
//!
//! The average's velocity and acceleration are averages of the motion's, hence within the same limits; its jerk is the change of acceleration
//! across the window by the window's length (Biagiotti & Melchiorri, Control Engineering Practice 20(12), 2012,
//! doi:10.1016/j.conengprac.2012.08.001: a trapezoid of speed becomes the double S). From rest to rest it takes a window longer. On a straight
//! line it stays on the line; beside a bend it passes by at most `a w^2 / 24`.

/// Grid points within a window or within a period, whichever is shorter.
const POINTS: f64 = 8.0;
/// Of one motion, whatever its duration.
const MAX_POINTS: f64 = 20_000.0;

/// A motion from rest to rest on an even grid of times, straight in between.
pub struct Motion {
    dim: usize,
    step: f64,
    /// Row by row.
    q: Vec<f64>,
    /// The integral of each column from the start on, row by row.
    integral: Vec<f64>,
}

impl Motion {
    /// Samples a motion of `duration` that is at `position(t)`; fine enough for averages over `window` and samples every `period` [s].
    ///
    /// Times are asked in ascending order.
    pub fn new(duration: f64, window: f64, period: f64, mut position: impl FnMut(f64, &mut Vec<f64>)) -> Motion {
        let fine = window.min(period) / POINTS;
        let n = (duration / fine).ceil().clamp(1.0, MAX_POINTS) as usize;
        let step = duration / n as f64;
        let (mut q, mut row) = (Vec::new(), Vec::new());
        for i in 0..=n {
            position(step * i as f64, &mut row);
            q.extend_from_slice(&row);
        }
        let dim = row.len();
        let mut integral = vec![0.0; dim];
        for i in dim..q.len() {
            let before = integral[i - dim];
            integral.push(before + 0.5 * step * (q[i - dim] + q[i]));
        }
        Motion { dim, step, q, integral }
    }

    /// Puts the mean position between `t - window` and `t` into `mean`; before its start and after its end the motion is at rest.
    pub fn mean(&self, t: f64, window: f64, mean: &mut Vec<f64>) {
        mean.clear();
        let of = |j| (self.integral_of(j, t) - self.integral_of(j, t - window)) / window;
        mean.extend((0..self.dim).map(of));
    }

    /// Of column `j` from the start to `t`.
    fn integral_of(&self, j: usize, t: f64) -> f64 {
        let n = self.q.len() / self.dim.max(1) - 1;
        if t <= 0.0 {
            return self.q[j] * t;
        }
        let i = ((t / self.step) as usize).min(n);
        let (at, tau) = (i * self.dim + j, t - self.step * i as f64);
        let slope = if i < n {
            (self.q[at + self.dim] - self.q[at]) / self.step
        } else {
            0.0
        };
        self.integral[at] + tau * (self.q[at] + 0.5 * slope * tau)
    }
}
