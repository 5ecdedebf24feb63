//! Numeric inverse kinematics within joint limits.
//!
//! Levenberg-Marquardt whose damping is the remaining error (Sugihara, IEEE T-RO 27(5), 2011, doi:10.1109/TRO.2011.2148230), started
//! from the seed and then from random configurations. Differs from the paper: a joint that would leave its limits is held there and
//! the step is solved again without it; a try that stops gaining is given up early; steps are bounded.
//! Does not know obstacles: every solution is offered to the caller's `accept`. Gives one solution, not the set of them.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix6, RealField, UnitQuaternion};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::kinematics::{Chain, Twist};
use super::{Pose, Vec3};

/// Where the tool shall be, in the frame K of the chain's base link.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// `X_KT`.
    Pose(Pose),
    /// `p_KT` [m], with any orientation.
    Point(Vec3),
}

/// Tolerances and budget. No `Default`: the caller knows what the solution is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Steps of one try.
    pub max_iterations: u32,
    /// Random tries after the one from the seed.
    pub restarts: u32,
    /// [m]
    pub position_tolerance: f64,
    /// [rad]
    pub rotation_tolerance: f64,
}

/// No try came to a solution that was accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoIk {
    /// Remaining distance of the best try [m].
    pub position_error: f64,
    /// Remaining angle of the best try [rad]; 0 for a [`Target::Point`].
    pub rotation_error: f64,
    /// Solutions that were found and not accepted.
    pub rejected: u32,
}

/// HEURISTIC: a radian of error weighs like so many metres; about the length of a forearm with its hand.
const METRES_PER_RADIAN: f64 = 0.3;
/// HEURISTIC: Sugihara's bias, with which the damping does not vanish before the error does.
const BIAS: f64 = 1e-6;
/// Longest step of one joint [rad] or [m]: beyond, the Jacobian says nothing.
const MAX_STEP: f64 = 0.7;
/// HEURISTIC: a try must lose this share of its error within so many steps, else another start is worth more.
const PATIENCE: u32 = 8;
const GAIN: f64 = 0.8;
/// HEURISTIC: a restart begins at the nearest of so many random configurations; one step costs as much as about three of them.
const DRAWS: u32 = 6;

/// Returns a configuration, in chain order, that brings the tool to `target` within the tolerances and that `accept` takes.
///
/// It lies within the limits; a joint that turns without limits is given the value within pi of the seed. The first try starts from
/// `seed` (clamped to the limits); each solution that was refused counts as a try, too.
///
/// # Errors
///
/// When all tries are spent; the errors are those of the best one.
pub fn solve(
    chain: &Chain,
    target: &Target,
    seed: &[f64],
    settings: &Settings,
    rng: &mut ChaCha8Rng,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Result<Vec<f64>, NoIk> {
    let mut search = Search::new(chain, target, seed);
    let mut q = search.seed.clone();
    let mut no_ik = NoIk {
        position_error: f64::INFINITY,
        rotation_error: f64::INFINITY,
        rejected: 0,
    };
    let mut best = f64::INFINITY;
    for attempt in 0..=settings.restarts {
        if attempt > 0 {
            search.draw(&mut q, rng);
        }
        let error = search.descend(&mut q, settings);
        if error.is_within(settings) {
            search.unwind(&mut q);
            if accept(&q) {
                return Ok(q);
            }
            no_ik.rejected += 1;
        }
        if error.cost() < best {
            best = error.cost();
            no_ik.position_error = error.position;
            no_ik.rotation_error = error.rotation;
        }
        if q.is_empty() {
            break;
        }
    }
    Err(no_ik)
}

/// What is left between the tool and its target.
#[derive(Debug, Clone, Copy)]
struct Error {
    /// [m]
    position: f64,
    /// [rad]
    rotation: f64,
}

impl Error {
    fn is_within(&self, settings: &Settings) -> bool {
        self.position <= settings.position_tolerance && self.rotation <= settings.rotation_tolerance
    }

    /// Half of the weighted square [m^2].
    fn cost(&self) -> f64 {
        let angle = METRES_PER_RADIAN * self.rotation;
        0.5 * (self.position * self.position + angle * angle)
    }
}

/// One problem with its scratch memory.
struct Search<'a> {
    chain: &'a Chain,
    target: &'a Target,
    /// Within the limits.
    seed: Vec<f64>,
    columns: Vec<Twist>,
    held: Vec<bool>,
    step: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(chain: &'a Chain, target: &'a Target, seed: &[f64]) -> Search<'a> {
        let clamp = |(i, dof): (usize, &super::kinematics::Dof)| {
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
        }
    }

    /// The nearest of some random configurations within the limits; where there are none, half a turn (or half a metre) about the seed.
    fn draw(&mut self, q: &mut [f64], rng: &mut ChaCha8Rng) {
        let mut drawn = vec![0.0; q.len()];
        let mut least = f64::INFINITY;
        for _ in 0..DRAWS {
            for ((v, dof), seed) in drawn.iter_mut().zip(self.chain.dofs()).zip(&self.seed) {
                let lower = if dof.lower.is_finite() { dof.lower } else { seed - PI };
                let upper = if dof.upper.is_finite() { dof.upper } else { seed + PI };
                *v = lower + rng.random::<f64>() * (upper - lower);
            }
            let cost = to_target(self.target, &self.chain.tool_pose(&drawn)).1.cost();
            if cost < least {
                least = cost;
                q.copy_from_slice(&drawn);
            }
        }
    }

    /// Walks from `q` downhill; leaves the end in `q`.
    fn descend(&mut self, q: &mut [f64], settings: &Settings) -> Error {
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
    fn unwind(&self, q: &mut [f64]) {
        for (i, (v, seed)) in q.iter_mut().zip(&self.seed).enumerate() {
            if self.chain.is_continuous(i) {
                *v -= TAU * ((*v - seed) / TAU).round();
            }
        }
    }
}

/// The twist that would bring the tool to its target, in K, and its size.
fn to_target(target: &Target, X_KT: &Pose) -> (Twist, Error) {
    match target {
        Target::Point(p_KT) => {
            let p = p_KT - X_KT.translation.vector;
            (
                Twist::new(p.x, p.y, p.z, 0.0, 0.0, 0.0),
                Error {
                    position: p.norm(),
                    rotation: 0.0,
                },
            )
        }
        Target::Pose(X) => {
            let p = X.translation.vector - X_KT.translation.vector;
            let w = rotation_vector(&(X.rotation * X_KT.rotation.inverse()));
            (
                Twist::new(p.x, p.y, p.z, w.x, w.y, w.z),
                Error {
                    position: p.norm(),
                    rotation: w.norm(),
                },
            )
        }
    }
}

/// Axis times angle, the angle in [0, pi].
fn rotation_vector(r: &UnitQuaternion<f64>) -> Vec3 {
    let (v, w) = (r.imag(), r.scalar());
    let sine = v.norm();
    if sine < 1e-12 {
        return v * if w < 0.0 { -2.0 } else { 2.0 };
    }
    let half_angle = RealField::atan2(sine, w.abs());
    v * (2.0 * half_angle / sine).copysign(w)
}
