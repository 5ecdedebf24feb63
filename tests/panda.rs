//! The 70 problems of `tests/panda`: all are solved, and every path is free at half of the planner's step.
//!
//! What touches something between two of the planner's checks, which one path in some tens does, is searched again more finely.
//!
//! The paths are judged by a test of every pair of exact shapes, one configuration after the other.
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]
#![expect(clippy::print_stderr, reason = "a test that is skipped says so")]

#[path = "panda/arm.rs"]
#[expect(dead_code, reason = "the bench of these problems uses the rest")]
mod arm;

use arm::{Fast, Naive, Problem, RESOLUTION, SEARCH, panda, problems, search, simplify};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::motion::{Path, Space, edge_is_free, length};

/// Starts and goals are beyond the limits of this description by so much at most: the problems were made with another one [rad].
const BEYOND: f64 = 0.002;

fn solve(space: &mut dyn Space, problem: &Problem) -> Option<Path> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let half = 0.5 * RESOLUTION;
    [SEARCH, RESOLUTION, half].into_iter().find_map(|resolution| {
        let path = search(space, problem, resolution, &mut rng).ok()?;
        let (path, is_free) = simplify(space, path, resolution, &mut rng);
        let is_free = is_free
            && path
                .windows(2)
                .all(|edge| edge_is_free(space, &edge[0], &edge[1], half));
        is_free.then_some(path)
    })
}

#[test]
fn all_are_solved_and_paths_are_free_at_half_the_step() {
    let Some(panda) = panda() else { return };
    let problems = problems();
    assert_eq!(problems.len(), 70);
    let mut n_checked = 0;
    for problem in &problems {
        let path = solve(&mut Fast::new(&panda, problem), problem).unwrap_or_else(|| panic!("{}", problem.name));
        assert_eq!((&path[0], &path[path.len() - 1]), (&problem.start, &problem.goal));
        let mut judge = Naive::new(&panda, problem);
        for edge in path.windows(2) {
            let n = (length(&edge[0], &edge[1]) / (0.5 * RESOLUTION)).ceil();
            for k in 0..=n as usize {
                let t = k as f64 / n;
                let q: Vec<f64> = edge[0].iter().zip(&edge[1]).map(|(a, b)| a + t * (b - a)).collect();
                let mut joints = q.iter().zip(&panda.dofs);
                let in_limits = joints.all(|(v, d)| (d.lower - BEYOND..=d.upper + BEYOND).contains(v));
                assert!(in_limits && judge.is_free(&q), "{}: {q:?}", problem.name);
                n_checked += 1;
            }
        }
    }
    assert!(n_checked > 10_000, "{n_checked}");
}

/// The same input gives the same path.
#[test]
fn paths_are_repeated() {
    let Some(panda) = panda() else { return };
    for problem in problems().iter().step_by(10) {
        let solve = || solve(&mut Fast::new(&panda, problem), problem);
        assert_eq!(solve(), solve());
    }
}
