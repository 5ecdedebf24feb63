//! Inverse kinematics of arms of every family: how many random reachable poses are solved, and how long that takes.
//!
//! `cargo bench --bench ik`. A harness of its own, since divan knows no success and no 95th percentile. In one run: `solve`, the
//! numeric way alone (`solve_numerically`), and `solve` from seeds within 0.2 rad. Times are wall times; the fastest of three calls.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a benchmark that fails stops here")]
#![expect(clippy::print_stdout, reason = "what is measured is printed")]
#![expect(clippy::disallowed_methods, reason = "a benchmark has a clock")]

#[path = "../tests/geometry/closed_form.rs"]
#[expect(dead_code, unused_imports, reason = "the tests of that file are not run here")]
mod closed_form;
#[path = "../tests/geometry/kinematics.rs"]
#[expect(dead_code, unused_imports, reason = "the tests of that file are not run here")]
mod kinematics;

use std::time::Instant;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::ik::{self, NoIk, Settings, Target};
use sgap::geom::kinematics::Chain;

/// Poses of each arm.
const N: usize = 2000;

const SETTINGS: Settings = Settings {
    max_iterations: 60,
    restarts: 20,
    position_tolerance: 1e-5,
    rotation_tolerance: 1e-4,
};

type Solve =
    fn(&Chain, &Target, &[f64], &Settings, &mut ChaCha8Rng, &mut dyn FnMut(&[f64]) -> bool) -> Result<Vec<f64>, NoIk>;

fn measure(name: &str, chain: &Chain, problems: &[(Target, Vec<f64>)], solve: Solve) {
    let mut solved = 0;
    let mut times: Vec<f64> = Vec::new();
    for (i, (target, seed)) in problems.iter().enumerate() {
        let mut fastest = f64::INFINITY;
        let mut is_solved = false;
        for _ in 0..3 {
            let mut rng = ChaCha8Rng::seed_from_u64(i as u64);
            let clock = Instant::now();
            is_solved = solve(chain, target, seed, &SETTINGS, &mut rng, &mut |_| true).is_ok();
            fastest = fastest.min(clock.elapsed().as_secs_f64() * 1e6);
        }
        times.push(fastest);
        solved += usize::from(is_solved);
    }
    times.sort_by(f64::total_cmp);
    let n = times.len();
    println!(
        "  {name:9} {:7.2} % solved, median {:5.1} us, 95th percentile {:6.1} us, mean {:5.1} us",
        100.0 * solved as f64 / n as f64,
        times[n / 2],
        times[n * 95 / 100],
        times.iter().sum::<f64>() / n as f64
    );
}

fn main() {
    for (name, chain, n_held) in closed_form::arms() {
        println!("{name}: {} joints, {n_held} held", chain.dofs().len());
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut draw = || closed_form::draw(&chain, &mut rng);
        let places: Vec<(Vec<f64>, Vec<f64>)> = (0..N).map(|_| (draw(), draw())).collect();
        let far: Vec<(Target, Vec<f64>)> = places
            .iter()
            .map(|(q, seed)| (Target::Pose(chain.tool_pose(q)), seed.clone()))
            .collect();
        let near: Vec<(Target, Vec<f64>)> = places
            .iter()
            .map(|(q, _)| {
                let beside = q.iter().map(|v| v + rng.random_range(-0.2..0.2)).collect();
                (Target::Pose(chain.tool_pose(q)), beside)
            })
            .collect();
        measure("solve", &chain, &far, ik::solve);
        measure("numeric", &chain, &far, ik::solve_numerically);
        measure("near", &chain, &near, ik::solve);
    }
}
