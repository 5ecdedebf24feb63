//! The 70 problems of `tests/panda`, planned and simplified by the maker's Panda: how long each takes.
//!
//! `ROS_PACKAGE_PATH=<share> cargo bench --bench panda`, where `<share>` is the folder that holds the package `example-robot-data`; without it
//! the bench says that it was skipped. One thread; each problem is planned with several seeds, and the least time of some runs counts, so that what else the
//! machine does is left out. A number behind `--` sets how many seeds.
#![expect(clippy::unwrap_used, reason = "a benchmark that fails stops here")]
#![expect(clippy::print_stdout, reason = "a benchmark prints its figures")]
#![expect(clippy::print_stderr, reason = "a benchmark that is skipped says so")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

#[path = "../tests/panda/arm.rs"]
#[expect(dead_code, reason = "the test of those problems uses the rest")]
mod arm;

use std::time::Instant;

use arm::{Fast, Panda, Problem, RESOLUTION, SEARCH, panda, problems, search, simplify};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::motion::{Path, length};

/// Runs of which the fastest counts.
const RUNS: usize = 3;

/// What one problem took with one seed.
#[derive(Clone, Copy)]
struct Took {
    /// [ms]
    planning: f64,
    simplification: f64,
    /// Of the simplified path [rad].
    length: f64,
    checks: u64,
}

fn main() {
    let Some(panda) = panda() else { return };
    let seeds = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(10);
    let problems = problems();
    let mut all = Vec::new();
    println!("{:20}{:>44}{:>44}", "", "planning [ms]", "simplification [ms]");
    let names = ["mean", "median", "95 %", "worst"];
    let head: String = names.iter().map(|n| format!("{n:>11}")).collect();
    println!("{:20}{head}{head}{:>10}{:>9}", "", "length", "checks");
    for set in problems.chunk_by(|a, b| a.set == b.set) {
        let took: Vec<Took> = set
            .iter()
            .flat_map(|p| (0..seeds).map(|seed| solve(&panda, p, seed)).collect::<Vec<_>>())
            .collect();
        row(&set[0].set, &took);
        all.extend(took);
    }
    row("all", &all);
}

fn solve(panda: &Panda, problem: &Problem, seed: u64) -> Took {
    let mut best: Option<Took> = None;
    for _ in 0..RUNS {
        let mut space = Fast::new(panda, problem);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut took = Took {
            planning: 0.0,
            simplification: 0.0,
            length: 0.0,
            checks: 0,
        };
        let mut solved = false;
        for resolution in [SEARCH, RESOLUTION] {
            let start = Instant::now();
            let found = search(&mut space, problem, resolution, &mut rng);
            took.planning += 1e3 * start.elapsed().as_secs_f64();
            let Ok(found) = found else { break };
            let start = Instant::now();
            let (path, is_free) = simplify(&mut space, found, resolution, &mut rng);
            took.simplification += 1e3 * start.elapsed().as_secs_f64();
            took.length = path_length(&path);
            solved = is_free;
            if is_free {
                break;
            }
        }
        assert!(solved, "{} is not solved with seed {seed}", problem.name);
        took.checks = space.checks();
        best = Some(best.map_or(took, |b| Took {
            planning: b.planning.min(took.planning),
            simplification: b.simplification.min(took.simplification),
            ..took
        }));
    }
    best.unwrap()
}

fn path_length(path: &Path) -> f64 {
    path.windows(2).map(|w| length(&w[0], &w[1])).sum()
}

fn row(name: &str, took: &[Took]) {
    let mean = |of: &dyn Fn(&Took) -> f64| took.iter().map(of).sum::<f64>() / took.len() as f64;
    let column = |of: &dyn Fn(&Took) -> f64| {
        let mut sorted: Vec<f64> = took.iter().map(of).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
        [mean(of), at(0.5), at(0.95), at(1.0)]
            .map(|v| format!("{v:>11.3}"))
            .concat()
    };
    println!(
        "{name:20}{}{}{:>10.2}{:>9.0}",
        column(&|t| t.planning),
        column(&|t| t.simplification),
        mean(&|t| t.length),
        mean(&|t| t.checks as f64),
    );
}
