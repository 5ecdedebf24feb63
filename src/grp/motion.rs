//! Motions of one arm: plans, shortens and times them with the geometry room's algorithms; the settings of this project's robots.

use rand_chacha::ChaCha8Rng;

use super::arm_space::ArmSpace;
use crate::geom::kinematics::{Dof, Tree};
use crate::geom::motion::{Path, Space, rrt_connect, shortcut, straight, timing};
use crate::geom::{ik, motion};

/// A trajectory: times [s] and one configuration for each, linear in between.
pub(super) type Timed = timing::Timed;

/// Inverse kinematics of end states; restarts come from the caller's settings.
pub(super) const IK: ik::Settings = ik::Settings {
    max_iterations: 60,
    restarts: 0,
    position_tolerance: 1e-5,
    rotation_tolerance: 1e-4,
};

/// Straight contact motions.
pub(super) const STRAIGHT: straight::Settings = straight::Settings {
    spacing: 0.01,
    turn_spacing: 0.05,
    max_joint_step: 0.25,
    resolution: RESOLUTION,
    position_tolerance: 1e-5,
    rotation_tolerance: 1e-4,
};

/// Spacing of the checks of a path [rad]: an arm of 0.8 m moves 8 mm at most between two of them, so that nothing sinks into
/// a margin of 5 mm by more than its half; the validator checks at a finer one.
const RESOLUTION: f64 = 0.01;
/// Spacing while the planner searches; what it finds is checked again at [`RESOLUTION`].
const SEARCH_RESOLUTION: f64 = 0.03;
/// Longest edge of a tree [rad].
const STEP: f64 = 0.6;
/// Tries of shortening, for paths that came from trees.
const SHORTCUT_ROUNDS: u32 = 60;

/// Sampling and rounding of trajectories.
const TIMING: timing::Settings = timing::Settings {
    sample_period: 0.05,
    max_deviation: 0.05,
    resolution: RESOLUTION,
};

/// Why there is no motion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum NoMotion {
    /// An end is not free: names of the two bodies.
    Blocked((String, String)),
    OutOfSamples(u32),
}

/// Plans from the space's start to `goal`, shortens and times it.
pub(super) fn free(
    space: &mut ArmSpace<'_>,
    goal: &[f64],
    samples: u32,
    rng: &mut ChaCha8Rng,
) -> Result<Timed, NoMotion> {
    let start = space.start();
    free_of(space, &start, goal, samples, rng).map_err(|no| match no {
        NoMotion::Blocked(_) => NoMotion::Blocked(space.hit_names().unwrap_or_default()),
        NoMotion::OutOfSamples(samples) => NoMotion::OutOfSamples(samples),
    })
}

/// Plans from `start` to `goal` in any joint space, shortens and times it. Names no bodies where an end is blocked.
pub(super) fn free_of(
    space: &mut dyn Space,
    start: &[f64],
    goal: &[f64],
    samples: u32,
    rng: &mut ChaCha8Rng,
) -> Result<Timed, NoMotion> {
    // A path that is free at the coarse spacing and not at the fine one is rare; the fine spacing then plans once more.
    for resolution in [SEARCH_RESOLUTION, RESOLUTION] {
        let settings = rrt_connect::Settings {
            step: STEP,
            resolution,
            max_samples: samples,
        };
        let path = rrt_connect::rrt_connect(space, start, goal, &settings, rng).map_err(|e| match e {
            rrt_connect::NoPath::Start | rrt_connect::NoPath::Goal => NoMotion::Blocked(Default::default()),
            rrt_connect::NoPath::OutOfSamples { drawn } => NoMotion::OutOfSamples(drawn),
        })?;
        let path = if path.len() > 2 {
            shortcut::shortcut(
                space,
                path,
                &shortcut::Settings {
                    rounds: SHORTCUT_ROUNDS,
                    resolution,
                },
                rng,
            )
        } else {
            path
        };
        if path
            .windows(2)
            .all(|e| motion::edge_is_free(space, &e[0], &e[1], RESOLUTION))
        {
            return Ok(timing::time(space, &path, &TIMING));
        }
    }
    Err(NoMotion::OutOfSamples(samples))
}

/// Times a path that is known to be free.
pub(super) fn along(space: &mut ArmSpace<'_>, path: &Path) -> Timed {
    timing::time(space, path, &TIMING)
}

/// Times the motion of the fingers, which was checked where its end states were found.
pub(super) fn fingers(tree: &Tree, dofs: &[usize], from: &[f64], to: &[f64]) -> Timed {
    struct Fingers(Vec<Dof>);
    impl Space for Fingers {
        fn dofs(&self) -> &[Dof] {
            &self.0
        }
        fn is_free(&mut self, _: &[f64]) -> bool {
            true
        }
    }
    let mut space = Fingers(dofs.iter().map(|d| tree.dofs[*d].clone()).collect());
    timing::time(&mut space, &vec![from.to_vec(), to.to_vec()], &TIMING)
}
