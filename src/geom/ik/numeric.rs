//! Inverse kinematics downhill: Levenberg-Marquardt whose damping is the remaining error (Sugihara, IEEE T-RO 27(5), 2011,
//! doi:10.1109/TRO.2011.2148230).
//!
//! Differs from the paper: a joint that would leave its limits is held there and the step is solved again without it; a try that stops
//! gaining is given up early; steps are bounded. Finds one solution near where it starts, or none.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::TAU;

use nalgebra::Matrix6;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::super::kinematics::{Chain, Dof, Twist};
use super::closed_form::range;
use super::{Error, METRES_PER_RADIAN, Settings, Target, to_target};

/// HEURISTIC: Sugihara's bias, with which the damping does not vanish before the error does.
const BIAS: f64 = 1e-6;
/// Longest step of one joint [rad] or [m]: beyond, the Jacobian says nothing.
const MAX_STEP: f64 = 0.7;
/// HEURISTIC: a try must lose this share of its error within so many steps, else another start is worth more.
const PATIENCE: u32 = 8;
const GAIN: f64 = 0.8;
/// HEURISTIC: a restart begins at the nearest of so many random configurations; one step costs as much as about three of them.
const DRAWS: u32 = 6;

/// One problem with its scratch memory.
pub(super) struct Search<'a> {
    chain: &'a Chain,
    target: &'a Target,
    /// Within the limits.
    pub(super) seed: Vec<f64>,
    columns: Vec<Twist>,
    held: Vec<bool>,
    step: Vec<f64>,
    drawn: Vec<f64>,
}

impl<'a> Search<'a> {
    pub(super) fn new(chain: &'a Chain, target: &'a Target, seed: &[f64]) -> Search<'a> {
        let clamp = |(i, dof): (usize, &Dof)| {
            let v = seed.get(i).copied().filter(|v| v.is_finite()).unwrap_or(0.0);
            v.max(dof.lower).min(dof.upper)
        };
        let n = chain.dofs().len();
        Search {
            chain,
            target,
            seed: chain.dofs().iter().enumerate().map(clamp).collect(),
            columns: Vec::with_capacity(n),
            held: vec![false; n],
            step: vec![0.0; n],
            drawn: vec![0.0; n],
        }
    }

    /// The nearest of some random configurations within the limits; where there are none, half a turn (or half a metre) about the seed.
    pub(super) fn draw(&mut self, q: &mut [f64], rng: &mut ChaCha8Rng) {
        let mut least = f64::INFINITY;
        for _ in 0..DRAWS {
            for ((v, dof), seed) in self.drawn.iter_mut().zip(self.chain.dofs()).zip(&self.seed) {
                let (lower, upper) = range(dof, *seed);
                *v = lower + rng.random::<f64>() * (upper - lower);
            }
            let cost = to_target(self.target, &self.chain.tool_pose(&self.drawn)).1.cost();
            if cost < least {
                least = cost;
                q.copy_from_slice(&self.drawn);
            }
        }
    }

    /// Walks from `q` downhill; leaves the end in `q`.
    pub(super) fn descend(&mut self, q: &mut [f64], settings: &Settings) -> Error {
        let mut mark = f64::INFINITY;
        for iteration in 0..=settings.max_iterations {
            let X_KT = self.chain.jacobian_into(q, &mut self.columns);
            let (twist, error) = to_target(self.target, &X_KT);
            let cost = error.cost();
            if error.is_within(settings) || iteration == settings.max_iterations {
                return error;
            }
            if iteration % PATIENCE == 0 {
                if cost > GAIN * mark {
                    return error;
                }
                mark = cost;
            }
            if !self.advance(q, twist, cost) {
                return error;
            }
        }
        // Not reached: the last iteration returns.
        Error {
            position: f64::INFINITY,
            rotation: f64::INFINITY,
        }
    }

    /// One damped step towards the remaining twist; false when no joint can move.
    fn advance(&mut self, q: &mut [f64], mut twist: Twist, cost: f64) -> bool {
        for row in 3..6 {
            twist[row] *= METRES_PER_RADIAN;
        }
        for column in &mut self.columns {
            for row in 3..6 {
                // The rows of a free orientation would only stiffen the step.
                column[row] *= if matches!(self.target, Target::Point(_)) {
                    0.0
                } else {
                    METRES_PER_RADIAN
                };
            }
        }
        self.held.fill(false);
        let n = q.len();
        // Each round but the last holds one joint more.
        for _ in 0..=n {
            let mut H = Matrix6::identity() * (cost + BIAS);
            for (column, _) in self.columns.iter().zip(&self.held).filter(|(_, held)| !**held) {
                H.ger(1.0, column, column, 1.0);
            }
            let Some(factor) = H.cholesky() else { return false };
            let y = factor.solve(&twist);
            let mut blocked = false;
            for (i, dof) in self.chain.dofs().iter().enumerate() {
                self.step[i] = if self.held[i] { 0.0 } else { self.columns[i].dot(&y) };
                let outward = (q[i] >= dof.upper && self.step[i] > 0.0) || (q[i] <= dof.lower && self.step[i] < 0.0);
                if outward {
                    self.held[i] = true;
                    blocked = true;
                }
            }
            if !blocked {
                break;
            }
        }
        let longest = self.step.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        if longest.is_nan() || longest < 1e-12 {
            return false;
        }
        let scale = (MAX_STEP / longest).min(1.0);
        for ((v, step), dof) in q.iter_mut().zip(&self.step).zip(self.chain.dofs()) {
            *v = (*v + scale * step).max(dof.lower).min(dof.upper);
        }
        true
    }

    /// Takes whole turns off the joints that have no limits, until each is within pi of the seed.
    pub(super) fn unwind(&self, q: &mut [f64]) {
        for (i, (v, seed)) in q.iter_mut().zip(&self.seed).enumerate() {
            if self.chain.is_continuous(i) {
                *v -= TAU * ((*v - seed) / TAU).round();
            }
        }
    }
}
