//! Whole plans and single geometric actions on the project's own scenarios. `cargo bench --bench planning`.
//!
//! Each sample has another seed, so that the median is over plans, not over repetitions of one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use divan::Bencher;
use sgap::engine::{self, Aim, Branching, Budget, Call, Cuts, Formula, Reasoner, Request};
use sgap::grp::{self, Grp};
use sgap::ir::Value;
use sgap::load::{Input, load};
use sgap::source::{Files, Sources};

fn main() {
    divan::main();
}

struct Disk;

impl Files for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        std::fs::read_to_string(path).map_err(|e| e.to_string())
    }
}

const GEOMETRY: grp::Settings = grp::Settings {
    placements: 200,
    ik_restarts: 8,
    motion_samples: 3000,
};

fn input(name: &str) -> Input {
    let (domain, world) = (format!("domains/{name}.hatp"), format!("worlds/{name}.toml"));
    let (input, problems) = load(&domain, &world, None, &mut Sources::default(), &Disk);
    input.unwrap_or_else(|| panic!("{problems:?}"))
}

fn reasoner(input: &Input, seed: u64) -> Grp<'_> {
    Grp::new(&input.world, GEOMETRY, seed, Arc::new(AtomicBool::new(false))).expect("the arms are chains")
}

/// Returns 0, 1, 2, ... one for each sample.
fn seeds() -> impl Fn() -> u64 {
    let next = AtomicU64::new(0);
    move || next.fetch_add(1, Ordering::Relaxed)
}

/// Files to plan, as `sgap plan` does.
#[divan::bench(args = ["three_objects", "ramification"], sample_count = 100, sample_size = 1)]
fn plan(bencher: Bencher<'_, '_>, name: &str) {
    bencher.with_inputs(seeds()).bench_values(|seed| {
        let input = input(name);
        let mut grp = reasoner(&input, seed);
        let budget = Budget {
            expansions: 100_000,
            depth: 10_000,
        };
        let settings = engine::Settings {
            branching: Branching::Fixed(3),
            strategy: engine::Strategy::DepthFirst,
            aim: Aim::First,
            interleave: false,
            cuts: Cuts::On,
            fall_back: None,
            budget,
        };
        let goal = input.goal.as_ref().expect("the world names a task");
        engine::solve(
            &input.domain,
            goal,
            &mut grp,
            &settings,
            &AtomicBool::new(false),
            &mut |_, _| {},
        )
    });
}

/// Loading alone.
#[divan::bench(args = ["three_objects"])]
fn load_files(name: &str) -> Input {
    input(name)
}

fn names(input: &Input, names: &[&str]) -> Vec<Value> {
    names
        .iter()
        .map(|n| Value::Entity(input.domain.entity(n).expect("declared")))
        .collect()
}

/// One Pick with its motions, from the start state.
#[divan::bench(args = ["RED_CUBE", "GREY_BOOK", "ORANGE_BOX"], sample_count = 100, sample_size = 1)]
fn pick(bencher: Bencher<'_, '_>, object: &str) {
    let input = input("three_objects");
    let args = names(&input, &["PR2", object]);
    bencher.with_inputs(seeds()).bench_values(|seed| {
        let mut grp = reasoner(&input, seed);
        grp.project(
            &input.domain,
            &Call {
                name: "pick",
                args: &args,
                given: &[],
                constraints: &Formula::TRUE,
            },
        )
        .expect("it can be picked")
    });
}

/// One PlaceReachable with its motions, after a Pick that is not counted.
#[divan::bench(args = ["RED_CUBE", "GREY_BOOK", "ORANGE_BOX"], sample_count = 100, sample_size = 1)]
fn place_reachable(bencher: Bencher<'_, '_>, object: &str) {
    let input = input("three_objects");
    let (pick, place) = (
        names(&input, &["PR2", object]),
        names(&input, &["PR2", object, "TABLE", "BOB"]),
    );
    let seed = seeds();
    let held = || {
        let mut grp = reasoner(&input, seed());
        grp.project(
            &input.domain,
            &Call {
                name: "pick",
                args: &pick,
                given: &[],
                constraints: &Formula::TRUE,
            },
        )
        .expect("it can be picked");
        grp
    };
    bencher.with_inputs(held).bench_values(|mut grp| {
        grp.project(
            &input.domain,
            &Call {
                name: "placeReachable",
                args: &place,
                given: &[],
                constraints: &Formula::TRUE,
            },
        )
    });
}

/// A request about the start state, answered for the first time: names of a world, the request and its arguments.
#[divan::bench(args = [
    "virtual_place_a virtualPlace VOLUME TABLE",
    "virtual_place_a virtualPlace VOLUME ASIDE",
    "three_objects canReach PR2 RED_CUBE",
    "three_objects canReach BOB RED_CUBE",
    "three_objects canSee BOB RED_CUBE",
    "three_objects distance PR2 BOB",
    "three_objects enoughRoom PR2 BOB RED_CUBE",
    "three_objects enoughRoom BOB PR2 RED_CUBE",
    "three_objects pathExists PR2 RED_CUBE",
    "three_objects pathExists BOB RED_CUBE",
    "three_objects pathExists PR2 BOB",
], sample_count = 100, sample_size = 1)]
fn request(bencher: Bencher<'_, '_>, words: &str) {
    let words: Vec<&str> = words.split(' ').collect();
    let [world, name, args @ ..] = words.as_slice() else {
        panic!("a world, a request, its arguments");
    };
    let domain = if *world == "virtual_place_a" {
        "virtual_place"
    } else {
        world
    };
    let (domain, world) = (format!("domains/{domain}.hatp"), format!("worlds/{world}.toml"));
    let (input, problems) = load(&domain, &world, None, &mut Sources::default(), &Disk);
    let input = input.unwrap_or_else(|| panic!("{problems:?}"));
    let args = names(&input, args);
    bencher
        .with_inputs(|| reasoner(&input, 0))
        .bench_local_values(|mut grp| grp.request(&input.domain, &Request { name, args: &args }));
}
