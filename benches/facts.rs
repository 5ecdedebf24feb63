//! All facts of a scene of 30 objects and 3 agents (`tests/facts/thirty.toml`): from scratch, and after one thing has moved; geometric
//! requests; lines of sight.
//!
//! `cargo bench --bench facts`; compare figures of one run with each other, since machines drift.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a benchmark that fails stops here")]

#[path = "../tests/facts/moves.rs"]
#[expect(dead_code, reason = "not all of it is used here")]
mod moves;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::UnitQuaternion;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::collide::{Solid, ray};
use sgap::geom::shape::Shape;
use sgap::geom::sight::{Cone, Sight};
use sgap::geom::{Pose, Vec3};
use sgap::grp::{Grp, Settings};
use sgap::world::{State, World};

fn main() {
    divan::main();
}

fn scene() -> World {
    moves::load("tests/facts/thirty.toml")
}

fn grp(world: &World) -> Grp<'_> {
    let settings = Settings {
        placements: 0,
        ik_restarts: 0,
        motion_samples: 0,
    };
    Grp::new(world, settings, 0, Arc::new(AtomicBool::new(false))).unwrap()
}

/// States, each of which differs from the one before by one move.
fn states(world: &World, n: usize, step: fn(&World, &mut State, &mut ChaCha8Rng) -> Option<moves::Move>) -> Vec<State> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut all = vec![world.start.clone()];
    while all.len() < n {
        let mut next = all.last().unwrap().clone();
        step(world, &mut next, &mut rng).unwrap();
        all.push(next);
    }
    all
}

const N: usize = 120;

/// Nothing is known: what a change costs without the memory.
#[divan::bench(sample_count = 10, sample_size = 1)]
fn all_facts_from_scratch(bencher: Bencher) {
    let world = scene();
    let states = states(&world, N, moves::put);
    let mut i = 0;
    bencher
        .with_inputs(|| {
            i += 11;
            let mut grp = grp(&world);
            grp.observe(states[i % N].clone());
            grp
        })
        .bench_local_values(|mut grp| grp.all_facts().len());
}

fn all_facts_after(bencher: Bencher, step: fn(&World, &mut State, &mut ChaCha8Rng) -> Option<moves::Move>) {
    let world = scene();
    let states = states(&world, N, step);
    let mut grp = grp(&world);
    grp.all_facts();
    let mut i = 0;
    // One sample takes one step, so that no state is met twice.
    bencher.bench_local(|| {
        i += 1;
        grp.observe(states[i].clone());
        black_box(grp.all_facts().len())
    });
}

/// A thing stands elsewhere.
#[divan::bench(sample_count = 100, sample_size = 1, skip_ext_time)]
fn all_facts_after_one_object_moved(bencher: Bencher) {
    all_facts_after(bencher, moves::put);
}

/// A thing, a hand, an arm or a base.
#[divan::bench(sample_count = 100, sample_size = 1, skip_ext_time)]
fn all_facts_after_any_move(bencher: Bencher) {
    all_facts_after(bencher, moves::any);
}

/// An eye, 21 obstacles of four kinds, and points on a ball about each of them.
struct Clutter {
    eye: Vec3,
    solids: Vec<(Solid, Pose)>,
    points: Vec<Vec<Vec3>>,
}

const POINTS: usize = 54;

fn clutter() -> Clutter {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let solids: Vec<(Solid, Pose)> = (0..21)
        .map(|i| {
            let mut size = || rng.random_range(0.03..0.2);
            let shape = match i % 4 {
                0 => Shape::Box {
                    half: Vec3::new(size(), size(), size()),
                },
                1 => Shape::Cylinder {
                    radius: size(),
                    half_length: size(),
                },
                2 => Shape::Sphere { radius: size() },
                _ => Shape::Capsule {
                    radius: size(),
                    half_length: size(),
                },
            };
            let mut v = |m: f64| Vec3::from_fn(|_, _| rng.random_range(-m..m));
            let X_WS = Pose::from_parts(v(1.0).into(), UnitQuaternion::from_scaled_axis(v(2.0)));
            (Solid::new(&shape), X_WS)
        })
        .collect();
    let around = |(solid, X_WS): &(Solid, Pose), rng: &mut ChaCha8Rng| {
        let mut point = || {
            let d = Vec3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            X_WS.translation.vector + d.normalize() * solid.radius()
        };
        (0..POINTS).map(|_| point()).collect()
    };
    let points = solids.iter().map(|s| around(s, &mut rng)).collect();
    Clutter {
        eye: Vec3::new(-2.5, 0.3, 0.8),
        solids,
        points,
    }
}

/// Every ray against every obstacle but the one looked at.
#[divan::bench]
fn sight_linear_scan(bencher: Bencher) {
    let Clutter { eye, solids, points } = clutter();
    bencher.counter(ItemsCount::new(solids.len() * POINTS)).bench_local(|| {
        let mut hidden = 0;
        for (i, points) in points.iter().enumerate() {
            for p in points {
                let way = p - eye;
                let far = way.norm();
                let others = solids.iter().enumerate().filter(|(j, _)| *j != i);
                let mut hits = others.map(|(_, (s, X))| ray(s, X, &eye, &(way / far), far - 1e-6));
                hidden += usize::from(hits.any(|h| h.is_some()));
            }
        }
        hidden
    });
}

/// The same rays, those to one obstacle at a time.
#[divan::bench]
fn sight_by_object(bencher: Bencher) {
    let Clutter { eye, solids, points } = clutter();
    bencher.counter(ItemsCount::new(solids.len() * POINTS)).bench_local(|| {
        let mut hidden = 0;
        for (i, points) in points.iter().enumerate() {
            let (solid, X_WS) = &solids[i];
            let mut sight = Sight::new(Cone::new(eye, X_WS.translation.vector, solid.radius()));
            for (j, (solid, X_WS)) in solids.iter().enumerate().filter(|(j, _)| *j != i) {
                sight.add(j, solid, X_WS);
            }
            sight.sort();
            hidden += points.iter().filter(|p| sight.hidden_by(p, 1e-6).is_some()).count();
        }
        hidden
    });
}

/// The same rays without knowing where they go: nothing is left out beforehand.
#[divan::bench]
fn sight_in_all_directions(bencher: Bencher) {
    let Clutter { eye, solids, points } = clutter();
    bencher.counter(ItemsCount::new(solids.len() * POINTS)).bench_local(|| {
        let mut sight = Sight::new(Cone::new(eye, Vec3::zeros(), 3.0));
        for (j, (solid, X_WS)) in solids.iter().enumerate() {
            sight.add(j, solid, X_WS);
        }
        sight.sort();
        let all = points.iter().flatten();
        all.filter(|p| sight.hidden_by(p, 1e-6).is_some()).count()
    });
}
