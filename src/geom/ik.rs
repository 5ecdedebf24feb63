//! Inverse kinematics within joint limits.
//!
//! [`closed_form`] where the chain's geometry allows it: joints beyond six are held at values of the seed, then at others spread
//! over their limits. Else, and where the closed form finds nothing that is accepted, `numeric`: downhill from the seed, then from random
//! configurations. Near the seed the numeric way goes first: it takes a few steps and stays on the seed's branch.
//! Does not know obstacles: every solution is offered to the caller's `accept`.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

pub mod closed_form;
mod numeric;
mod six;

use nalgebra::{RealField, UnitQuaternion};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use self::closed_form::{ClosedForm, Scratch, apart, range};
use self::numeric::Search;
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
/// HEURISTIC: a seed whose remaining error costs less than this [m^2] is near: some 0.2 m, or 40 degrees.
const NEAR: f64 = 0.02;
/// Solutions are distinct where a joint differs by more than this [rad] or [m].
const DISTINCT: f64 = 0.05;
/// HEURISTIC: values of the held joints for each try. One that has no solution costs a tenth of a numeric try, and a third of the values has one.
const ROUNDS_PER_TRY: u32 = 4;

/// Returns a configuration, in chain order, that brings the tool to `target` within the tolerances and that `accept` takes.
///
/// It lies within the limits; a joint that turns without limits is given the value within pi of the seed. The first try starts from
/// `seed` (clamped to the limits); a solution that was refused counts as a try, too, all of one value of the held joints as one.
/// A closed form without joints to hold offers all solutions that there are, nearest to the seed first, and says no when they are spent.
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
    let form = match target {
        Target::Pose(X_KT) if settings.restarts > 0 => chain.closed_form().map(|form| (form, X_KT)),
        Target::Pose(_) | Target::Point(_) => None,
    };
    search(chain, target, seed, settings, form, rng, accept)
}

/// Like [`solve`] without the closed form: a second way to the same answers.
///
/// # Errors
///
/// When all tries are spent; the errors are those of the best one.
pub fn solve_numerically(
    chain: &Chain,
    target: &Target,
    seed: &[f64],
    settings: &Settings,
    rng: &mut ChaCha8Rng,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Result<Vec<f64>, NoIk> {
    search(chain, target, seed, settings, None, rng, accept)
}

fn search(
    chain: &Chain,
    target: &Target,
    seed: &[f64],
    settings: &Settings,
    form: Option<(&ClosedForm, &Pose)>,
    rng: &mut ChaCha8Rng,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Result<Vec<f64>, NoIk> {
    let mut search = Search::new(chain, target, seed);
    let mut q = search.seed.clone();
    let mut tries = Tries {
        left: settings.restarts.saturating_add(1),
        best: f64::INFINITY,
        no_ik: NoIk {
            position_error: f64::INFINITY,
            rotation_error: f64::INFINITY,
            rejected: 0,
        },
    };
    let (_, start) = to_target(target, &chain.tool_pose(&q));
    if form.is_none() || start.cost() < NEAR {
        let error = search.descend(&mut q, settings);
        if tries.took(error, settings, &search, &mut q, accept) || q.is_empty() {
            return tries.outcome(q);
        }
    }
    if let Some((form, X_KT)) = form {
        let is_redundant = !form.held().is_empty();
        let (mut scratch, mut misses) = (Scratch::default(), Vec::new());
        let held = Held::new(form.held(), rng);
        let before = tries.no_ik.rejected;
        let (rounds, mut open) = (tries.left.saturating_mul(ROUNDS_PER_TRY), tries.left);
        for round in 0..rounds {
            if open == 0 {
                break;
            }
            let rejected = tries.no_ik.rejected;
            held.set(round, chain, &search.seed, &mut q, rng);
            let n = form.candidates(chain, X_KT, &q, &mut scratch);
            for k in 0..n {
                if form.finish(chain, X_KT, k, &mut scratch, &mut q) {
                    let (_, error) = to_target(target, &chain.tool_pose(&q));
                    if tries.took(error, settings, &search, &mut q, accept) {
                        return Ok(q);
                    }
                }
            }
            // Solutions of one value differ by turned-over wrists and elbows, which often hit the same thing: together they are one try.
            open -= u32::from(tries.no_ik.rejected > rejected);
            if let Some((beyond, values)) = scratch.miss {
                form.put(&values, &mut q);
                misses.push((beyond, q.clone()));
            }
            if !is_redundant {
                break;
            }
        }
        if tries.no_ik.rejected > before && !is_redundant {
            return Err(tries.no_ik);
        }
        // Nothing was found, or nothing that is accepted. Of a redundant arm the values that were held may have been the wrong ones; and where two axes fall into one
        // line and an elbow is stretched, the share of each that the seed gave. What missed the limits by least is a good start.
        tries.left = settings.restarts.saturating_add(1);
        misses.sort_by(|a, b| a.0.total_cmp(&b.0));
        misses.push((f64::INFINITY, search.seed.clone()));
        for (_, miss) in misses {
            if tries.left == 0 {
                break;
            }
            q.copy_from_slice(&miss);
            let error = search.descend(&mut q, settings);
            if tries.took(error, settings, &search, &mut q, accept) {
                return Ok(q);
            }
        }
    }
    while tries.left > 0 {
        search.draw(&mut q, rng);
        let error = search.descend(&mut q, settings);
        if tries.took(error, settings, &search, &mut q, accept) {
            return Ok(q);
        }
    }
    Err(tries.no_ik)
}

/// Returns up to `limit` distinct configurations, in chain order, that bring the tool to `target` and that `accept` takes: nearest to
/// the seed first (largest difference of a joint), and those are offered first.
///
/// `settings.restarts` says how many values of the joints beyond six are looked at, or how many numeric tries are made. Of a
/// redundant arm's solutions, which are infinitely many, those are left out that differ from a nearer one by less
/// than 0.05 rad in every joint. A closed form without joints beyond six gives all that there are.
pub fn solutions(
    chain: &Chain,
    target: &Target,
    seed: &[f64],
    settings: &Settings,
    limit: usize,
    rng: &mut ChaCha8Rng,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Vec<Vec<f64>> {
    let mut search = Search::new(chain, target, seed);
    let mut q = search.seed.clone();
    let mut found = Vec::new();
    if let (Target::Pose(X_KT), Some(form)) = (target, chain.closed_form()) {
        let mut scratch = Scratch::default();
        let held = Held::new(form.held(), rng);
        let rounds = if form.held().is_empty() { 0 } else { settings.restarts };
        for round in 0..=rounds {
            held.set(round, chain, &search.seed, &mut q, rng);
            form.solutions(chain, X_KT, &q, &mut scratch, &mut found);
        }
    }
    if found.is_empty() {
        for attempt in 0..=settings.restarts {
            if attempt > 0 {
                search.draw(&mut q, rng);
            } else {
                q.copy_from_slice(&search.seed);
            }
            if search.descend(&mut q, settings).is_within(settings) {
                found.push(q.clone());
            }
        }
    }
    for q in &mut found {
        search.unwind(q);
    }
    found.sort_by(|a, b| apart(a, &search.seed).total_cmp(&apart(b, &search.seed)));
    let mut taken: Vec<Vec<f64>> = Vec::new();
    let mut offered: Vec<Vec<f64>> = Vec::new();
    for q in found {
        if taken.len() >= limit {
            break;
        }
        if offered.iter().all(|other| apart(other, &q) > DISTINCT) {
            if accept(&q) {
                taken.push(q.clone());
            }
            offered.push(q);
        }
    }
    taken
}

/// What is left of the budget, and what came of the rest.
struct Tries {
    left: u32,
    /// Cost of the best one.
    best: f64,
    no_ik: NoIk,
}

impl Tries {
    /// Counts a try that ended at `q` with this error; true when it is a solution that is accepted.
    fn took(
        &mut self,
        error: Error,
        settings: &Settings,
        search: &Search<'_>,
        q: &mut [f64],
        accept: &mut dyn FnMut(&[f64]) -> bool,
    ) -> bool {
        self.left = self.left.saturating_sub(1);
        if error.is_within(settings) {
            search.unwind(q);
            if accept(q) {
                self.no_ik.rejected = 0;
                self.best = -1.0;
                return true;
            }
            self.no_ik.rejected += 1;
        }
        if error.cost() < self.best {
            self.best = error.cost();
            self.no_ik.position_error = error.position;
            self.no_ik.rotation_error = error.rotation;
        }
        false
    }

    fn outcome(self, q: Vec<f64>) -> Result<Vec<f64>, NoIk> {
        if self.best < 0.0 { Ok(q) } else { Err(self.no_ik) }
    }
}

/// Values for the joints that a closed form holds: the seed's, then others, spread over the limits.
struct Held<'a> {
    columns: &'a [usize],
    start: f64,
}

impl<'a> Held<'a> {
    fn new(columns: &'a [usize], rng: &mut ChaCha8Rng) -> Held<'a> {
        Held {
            columns,
            start: rng.random::<f64>(),
        }
    }

    /// Puts the values of a round into `q`, whose other joints become the seed's.
    fn set(&self, round: u32, chain: &Chain, seed: &[f64], q: &mut [f64], rng: &mut ChaCha8Rng) {
        q.copy_from_slice(seed);
        if round == 0 {
            return;
        }
        for (k, i) in self.columns.iter().enumerate() {
            // The first by the golden section, which leaves no gap longer than its neighbours; further ones at random.
            let share = if k == 0 {
                let v = self.start + f64::from(round) * GOLDEN;
                v - v.floor()
            } else {
                rng.random::<f64>()
            };
            let (lower, upper) = range(&chain.dofs()[*i], seed[*i]);
            q[*i] = lower + share * (upper - lower);
        }
    }
}

const GOLDEN: f64 = 0.618_033_988_749_894_9;

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
