//! Which chains have a closed form, and what it gives within the limits.
//!
//! A chain has one when six of its revolute joints belong to a family of `six`, from one end or from the other, while all other
//! joints are held; it is looked for when the chain is made, by the chain's geometry alone. Held joints (the seventh of an arm, a
//! torso, a sliding or floating base) are free parameters: each value of them gives up to sixteen solutions, and whoever asks
//! goes through the values. So an arm with spherical shoulder, elbow and spherical wrist, one with offsets at the shoulder (PR2, TIAGo)
//! and one whose wrist is not spherical but whose shoulder is (Panda) are one case. A redundant arm could be given by an elbow angle as
//! well (Shimizu et al., IEEE T-RO 24(5), 2008, doi:10.1109/TRO.2008.2003266); a held joint is within its limits from the start.
//!
//! Does not know chains of fewer than six joints, nor six joints of other families: those have no closed form here.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::TAU;

use nalgebra::{Matrix6, Vector6};

use super::super::Pose;
use super::super::kinematics::{Chain, Dof, Twist};
use super::six::{self, Angles, Family, Line, family, turned_round};
use super::{Error, Target, to_target};

/// How a chain is solved.
#[derive(Debug, Clone)]
pub struct ClosedForm {
    /// Positions in `q` of the joints that are solved for, in chain order.
    solved: [usize; 6],
    /// The other positions: their values are the caller's.
    held: Vec<usize>,
    family: Family,
    /// From the tool's end.
    from_tool: bool,
}

/// A solution that is not exact to this after polishing is none [m], [rad]: at the rim of the reach rounding moves joints by the
/// root of the rounding, and the tool by little.
const EXACT: f64 = 1e-9;
/// Below this there is nothing to polish [m], [rad].
const POLISHED: f64 = 1e-11;
/// Values beyond a limit by no more than this are rounding, and are put on it [rad].
const SLACK: f64 = 1e-9;
/// Solutions that differ by less are one [rad].
const SAME: f64 = 1e-7;
/// Newton steps at most.
const MAX_POLISH: u32 = 3;
/// Chains with more joints to hold than this are not looked at: the choices become many.
const MAX_EXTRA: usize = 2;

impl ClosedForm {
    /// Looks at a chain's geometry in several configurations, since what is held may lie between the axes, and has the closed form
    /// find some of the chain's own poses again.
    pub(in super::super) fn recognise(chain: &Chain) -> Option<ClosedForm> {
        let n = chain.dofs().len();
        let turning: Vec<usize> = (0..n).filter(|i| chain.turns_by(*i).is_some()).collect();
        let extra = turning.len().checked_sub(6).filter(|e| *e <= MAX_EXTRA)?;
        let mut best: Option<ClosedForm> = None;
        for left_out in choices(turning.len(), extra) {
            let mut solved = turning
                .iter()
                .enumerate()
                .filter(|(i, _)| !left_out.contains(i))
                .map(|(_, c)| *c);
            let Some(solved) = six_of(&mut solved) else { continue };
            let held: Vec<usize> = (0..n).filter(|i| !solved.contains(i)).collect();
            for from_tool in [false, true] {
                let mut form = ClosedForm {
                    solved,
                    held: held.clone(),
                    family: Family::Wrist,
                    from_tool,
                };
                let Some(family) = form.family_at(chain, &held_values(chain, 0)) else {
                    continue;
                };
                form.family = family;
                if best.as_ref().is_none_or(|b| family < b.family) && form.proves_itself(chain) {
                    best = Some(form);
                }
            }
        }
        best
    }

    /// Returns every configuration that brings the tool to `X_KT` (in the frame K of the chain's base link) within the limits, the
    /// [held](ClosedForm::held) joints being where they are in `q`; nearest to `q` first, whole turns added to come near to it. Exact
    /// to 1e-9 m and rad. `chain` is the one whose closed form this is; a `q` that is too short has no solutions.
    pub fn solve(&self, chain: &Chain, X_KT: &Pose, q: &[f64]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.solutions(chain, X_KT, q, &mut Scratch::default(), &mut found);
        found
    }

    /// Returns the positions in `q` whose values are the caller's.
    pub fn held(&self) -> &[usize] {
        &self.held
    }

    fn family_at(&self, chain: &Chain, q: &[f64]) -> Option<Family> {
        let (lines, _) = self.lines(chain, q, &mut Scratch::default())?;
        family(&lines)
    }

    /// Finds the chain's own poses again.
    fn proves_itself(&self, chain: &Chain) -> bool {
        (0..N_PROOFS).all(|k| {
            let q = held_values(chain, k);
            if self.family_at(chain, &q).is_none_or(|f| f > self.family) {
                return false;
            }
            let mut found = Vec::new();
            self.solutions(chain, &chain.tool_pose(&q), &q, &mut Scratch::default(), &mut found);
            found
                .iter()
                .any(|s| s.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-6))
        })
    }

    /// The lines of the joints that are solved for, in K, where these stand at zero and the others as in `q`; and X_KT there.
    fn lines(&self, chain: &Chain, q: &[f64], scratch: &mut Scratch) -> Option<([Line; 6], Pose)> {
        let Scratch { reference, columns, .. } = scratch;
        reference.clear();
        reference.extend_from_slice(q);
        self.put(&[0.0; 6], reference);
        let X_KT = chain.jacobian_into(reference, columns);
        let mut lines = [Line {
            p: X_KT.translation.vector,
            h: nalgebra::Vector3::z(),
        }; 6];
        for (line, i) in lines.iter_mut().zip(self.solved) {
            // A column is the twist h x (p_T - p), h per unit of q: the nearest point to the tool follows.
            let scale = chain.turns_by(i)?;
            let column = columns.get(i)? / scale;
            line.h = column.fixed_rows::<3>(3).into_owned();
            line.p -= column.fixed_rows::<3>(0).cross(&line.h);
        }
        let lines = if self.from_tool { turned_round(&lines) } else { lines };
        Some((lines, X_KT))
    }

    /// Like [`ClosedForm::solve`], added to `found`.
    pub(super) fn solutions(
        &self,
        chain: &Chain,
        X_KT: &Pose,
        q: &[f64],
        scratch: &mut Scratch,
        found: &mut Vec<Vec<f64>>,
    ) {
        let first = found.len();
        for k in 0..self.candidates(chain, X_KT, q, scratch) {
            let mut solution = q.to_vec();
            if self.finish(chain, X_KT, k, scratch, &mut solution)
                && found[first..].iter().all(|s| apart(s, &solution) > SAME)
            {
                found.push(solution);
            }
        }
    }

    /// Finds the values within the limits that the closed form gives before polishing, nearest to `q` first, and returns how many
    /// they are: see [`ClosedForm::finish`]. What missed the limits by least is in [`Scratch::miss`].
    pub(super) fn candidates(&self, chain: &Chain, X_KT: &Pose, q: &[f64], scratch: &mut Scratch) -> usize {
        scratch.candidates.clear();
        scratch.miss = None;
        let n = chain.dofs().len();
        if q.len() < n || self.solved.iter().any(|i| *i >= n) {
            return 0;
        }
        let Some((lines, X_KT_reference)) = self.lines(chain, q, scratch) else {
            return 0;
        };
        let mut G = X_KT * X_KT_reference.inverse();
        let scale = self.solved.map(|i| chain.turns_by(i).unwrap_or(1.0));
        let near = self.solved.map(|i| q[i]);
        let mut hint: Angles = std::array::from_fn(|k| near[k] * scale[k]);
        if self.from_tool {
            G = G.inverse();
            hint.reverse();
        }
        scratch.angles.clear();
        six::solve(self.family, &lines, &G, &hint, &mut scratch.angles);
        for angles in scratch.angles.iter_mut().filter(|a| a.iter().all(|v| v.is_finite())) {
            if self.from_tool {
                angles.reverse();
            }
            let (mut far, mut beyond) = (0.0_f64, 0.0_f64);
            for k in 0..6 {
                let dof = &chain.dofs()[self.solved[k]];
                let value = nearest_turn(dof, angles[k] / scale[k], TAU / scale[k].abs(), near[k]);
                angles[k] = value.max(dof.lower).min(dof.upper);
                beyond = beyond.max((value - angles[k]).abs());
                far = far.max((angles[k] - near[k]).abs());
            }
            if beyond > SLACK {
                if scratch.miss.is_none_or(|(least, _)| beyond < least) {
                    scratch.miss = Some((beyond, *angles));
                }
                continue;
            }
            scratch.candidates.push((far, *angles));
        }
        scratch.candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        scratch.candidates.len()
    }

    /// Puts the `k`-th candidate into `q`, whose held joints are there already, and polishes it; false when it is no solution.
    pub(super) fn finish(&self, chain: &Chain, X_KT: &Pose, k: usize, scratch: &mut Scratch, q: &mut [f64]) -> bool {
        let Some((_, values)) = scratch.candidates.get(k) else {
            return false;
        };
        self.put(values, q);
        self.polish(chain, X_KT, q, &mut scratch.columns)
    }

    /// Puts the values of the joints that are solved for into `q`.
    pub(super) fn put(&self, values: &Angles, q: &mut [f64]) {
        for (i, v) in self.solved.iter().zip(values) {
            q[*i] = *v;
        }
    }

    /// Newton's method on the joints that were solved for; false when the tool is not where it should be.
    fn polish(&self, chain: &Chain, X_KT: &Pose, q: &mut [f64], columns: &mut Vec<Twist>) -> bool {
        let off = |X: &Pose| -> (Twist, Error) { to_target(&Target::Pose(*X_KT), X) };
        let (mut twist, mut error) = off(&chain.tool_pose(q));
        for _ in 0..MAX_POLISH {
            if error.position.max(error.rotation) < POLISHED {
                break;
            }
            chain.jacobian_into(q, columns);
            let J = Matrix6::from_columns(&self.solved.map(|i| columns[i]));
            // Damped by so little that only singular configurations notice.
            let H = J * J.transpose() + Matrix6::identity() * 1e-14;
            let Some(factor) = H.cholesky() else { break };
            let step: Vector6<f64> = J.transpose() * factor.solve(&twist);
            let mut next = q.to_vec();
            for (s, i) in step.iter().zip(self.solved) {
                let dof = &chain.dofs()[i];
                next[i] = (q[i] + s.clamp(-0.01, 0.01)).max(dof.lower).min(dof.upper);
            }
            let (next_twist, next_error) = off(&chain.tool_pose(&next));
            if next_error.cost() >= error.cost() {
                break;
            }
            q.copy_from_slice(&next);
            (twist, error) = (next_twist, next_error);
        }
        error.position < EXACT && error.rotation < EXACT
    }
}

/// Memory that is used again.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    columns: Vec<Twist>,
    reference: Vec<f64>,
    angles: Vec<Angles>,
    /// Largest difference from where the joints were, and values of the joints that are solved for.
    candidates: Vec<(f64, Angles)>,
    /// By how much the best of the others is beyond a limit, and its values, put on the limits.
    pub(super) miss: Option<(f64, Angles)>,
}

/// Returns the value plus whole periods that is nearest to `near` among those within the limits; beyond them when there is none.
fn nearest_turn(dof: &Dof, value: f64, period: f64, near: f64) -> f64 {
    let v = value + period * ((near - value) / period).round();
    if v > dof.upper + SLACK {
        let lower = v - period * ((v - dof.upper - SLACK) / period).ceil();
        // The nearer of the two, when neither is within.
        let beyond = dof.lower - lower > SLACK && dof.lower - lower > lower + period - dof.upper;
        if beyond { lower + period } else { lower }
    } else if v < dof.lower - SLACK {
        let upper = v + period * ((dof.lower - SLACK - v) / period).ceil();
        let beyond = upper - dof.upper > SLACK && upper - dof.upper > dof.lower - (upper - period);
        if beyond { upper - period } else { upper }
    } else {
        v
    }
}

/// Largest difference of a joint.
pub(super) fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

const N_PROOFS: u32 = 4;

/// Configurations within the limits, spread, with nothing special about them.
fn held_values(chain: &Chain, k: u32) -> Vec<f64> {
    let share = |i: usize| {
        let v = 0.3819 + 0.618_034 * f64::from(k) + 0.2763 * i as f64;
        0.1 + 0.8 * (v - v.floor())
    };
    let at = |(i, dof): (usize, &Dof)| {
        let (lower, upper) = range(dof, 0.0);
        lower + share(i) * (upper - lower)
    };
    chain.dofs().iter().enumerate().map(at).collect()
}

/// The limits of a dof; where there are none, half a turn (or so many metres) about `seed`.
pub(super) fn range(dof: &Dof, seed: f64) -> (f64, f64) {
    let half = std::f64::consts::PI;
    (
        if dof.lower.is_finite() { dof.lower } else { seed - half },
        if dof.upper.is_finite() { dof.upper } else { seed + half },
    )
}

/// All ways to take `k` of `n`, k being 0, 1 or 2.
fn choices(n: usize, k: usize) -> Vec<Vec<usize>> {
    match k {
        0 => vec![Vec::new()],
        1 => (0..n).map(|i| vec![i]).collect(),
        _ => (0..n).flat_map(|i| (i + 1..n).map(move |j| vec![i, j])).collect(),
    }
}

/// The six of an iterator of six.
fn six_of(columns: &mut dyn Iterator<Item = usize>) -> Option<[usize; 6]> {
    let all: Vec<usize> = columns.collect();
    all.try_into().ok()
}
