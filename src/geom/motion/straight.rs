//! The tool on a straight line, its orientation turning evenly from one end to the other.
//!
//! Points on the line are solved one after the other by differential steps from the configuration before ([`ik`] without
//! restarts), so that the arm cannot jump to another posture (resolved-rate motion, Whitney, IEEE T-MMS 10(2), 1969,
//! doi:10.1109/TMMS.1969.299896, with the error fed back). Follows one way only: a line that this posture cannot follow may be possible from
//! another, which is for the caller to try.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{Path, interpolate, length};
use crate::geom::ik::{self, Target};
use crate::geom::kinematics::Chain;
use crate::geom::{Pose, Vec3};

/// Spacing and tolerances. No `Default`: the caller knows the arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Between points on the line that are solved [m].
    pub spacing: f64,
    /// The same for the turning of the tool [rad].
    pub turn_spacing: f64,
    /// Most that a joint may move from one point to the next [rad] or [m].
    pub max_joint_step: f64,
    /// Between the configurations offered to `accept`, in the joint metric [rad].
    pub resolution: f64,
    /// Of each point on the line [m].
    pub position_tolerance: f64,
    /// Of each point on the line [rad].
    pub rotation_tolerance: f64,
}

/// How far the tool came along the line, and what stopped it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoLine {
    /// Of the way, in [0, 1].
    pub fraction: f64,
    pub cause: Cause,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// A joint, by its place in the chain, stands at its limit and the point is not reached.
    Limit { joint: usize },
    /// The point is out of reach, or the arm is singular there.
    OutOfReach { position_error: f64, rotation_error: f64 },
    /// A joint would move farther than a step allows [rad] or [m].
    Jump { joint: usize, step: f64 },
    /// `accept` said no.
    Refused,
}

/// Points on a line, whatever the spacing.
const MAX_POINTS: f64 = 10_000.0;
/// Steps for one point, which lies near the one before: two or three are the rule.
const MAX_ITERATIONS: u32 = 24;

/// Returns the configurations, `q_start` first, that bring the tool from where it is to `X_KT_end` on a straight line.
///
/// `accept` is the caller's collision check; it sees each point and those between, but not `q_start`.
///
/// # Errors
///
/// [`NoLine`], with the cause at the first point that fails.
pub fn straight(
    chain: &Chain,
    X_KT_end: &Pose,
    q_start: &[f64],
    settings: &Settings,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Result<Path, NoLine> {
    let X_KT_start = chain.tool_pose(q_start);
    let p = X_KT_end.translation.vector - X_KT_start.translation.vector;
    // Axis times angle, the shorter way round.
    let w = (X_KT_end.rotation * X_KT_start.rotation.inverse()).scaled_axis();
    let n = (p.norm() / settings.spacing).max(w.norm() / settings.turn_spacing);
    // Less a little, so that a length of ten spacings is ten.
    let n = (n - 1e-9).ceil();
    let n = if n.is_nan() { 1.0 } else { n.clamp(1.0, MAX_POINTS) } as usize;
    let ik_settings = ik::Settings {
        max_iterations: MAX_ITERATIONS,
        restarts: 0,
        position_tolerance: settings.position_tolerance,
        rotation_tolerance: settings.rotation_tolerance,
    };
    // Without restarts nothing is drawn from it.
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut path = vec![q_start.to_vec()];
    let mut between = Vec::new();
    for k in 1..=n {
        let t = k as f64 / n as f64;
        let stop = |cause| NoLine {
            fraction: (k - 1) as f64 / n as f64,
            cause,
        };
        let X_KT = if k == n {
            *X_KT_end
        } else {
            on_line(&X_KT_start, &p, &w, t)
        };
        let Some(before) = path.last() else { break };
        let mut end = before.clone();
        let mut keep = |q: &[f64]| {
            end.copy_from_slice(q);
            true
        };
        if let Err(no) = ik::solve(chain, &Target::Pose(X_KT), before, &ik_settings, &mut rng, &mut keep) {
            return Err(stop(match at_limit(chain, before, settings.max_joint_step) {
                Some(joint) => Cause::Limit { joint },
                None => Cause::OutOfReach {
                    position_error: no.position_error,
                    rotation_error: no.rotation_error,
                },
            }));
        }
        for (joint, (a, b)) in before.iter().zip(&end).enumerate() {
            let step = (b - a).abs();
            if step > settings.max_joint_step {
                return Err(stop(Cause::Jump { joint, step }));
            }
        }
        // In order, not spread: the distance is short, and the fraction shall be right.
        let n_checks = (length(before, &end) / settings.resolution)
            .ceil()
            .clamp(1.0, MAX_POINTS) as usize;
        for i in 1..=n_checks {
            interpolate(before, &end, i as f64 / n_checks as f64, &mut between);
            if !accept(&between) {
                return Err(stop(Cause::Refused));
            }
        }
        path.push(end);
    }
    Ok(path)
}

fn on_line(X_KT_start: &Pose, p: &Vec3, w: &Vec3, t: f64) -> Pose {
    let turned = nalgebra::UnitQuaternion::from_scaled_axis(w * t) * X_KT_start.rotation;
    Pose::from_parts((X_KT_start.translation.vector + p * t).into(), turned)
}

/// The joint that stands nearest to a limit, if it is within a fraction of a step of it.
fn at_limit(chain: &Chain, q: &[f64], max_joint_step: f64) -> Option<usize> {
    let room = |(i, (v, dof)): (usize, (&f64, &crate::geom::kinematics::Dof))| (i, (v - dof.lower).min(dof.upper - v));
    let nearest = q
        .iter()
        .zip(chain.dofs())
        .enumerate()
        .map(room)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.filter(|(_, room)| *room < 0.5 * max_joint_step).map(|(i, _)| i)
}
