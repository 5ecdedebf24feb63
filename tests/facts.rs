//! The memory of facts: what it says after anything has moved is what is found from nothing.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "facts/moves.rs"]
mod moves;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sgap::grp::{Grp, Settings};
use sgap::world::{State, World};

fn grp(world: &World) -> Grp<'_> {
    let settings = Settings {
        placements: 0,
        ik_restarts: 0,
        motion_samples: 0,
    };
    Grp::new(world, settings, 0, Arc::new(AtomicBool::new(false))).unwrap()
}

/// Compares the facts after each of some random moves with those of a reasoner that knows nothing; returns how many facts changed and how
/// many were worked out with the memory and without.
fn compare(path: &str, seed: u64, n: usize) -> (usize, u64, u64) {
    let world = moves::load(path);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut remembering = grp(&world);
    let mut before = remembering.all_facts();
    let begun = remembering.counts().facts;
    let (mut state, mut earlier): (State, Vec<State>) = (world.start.clone(), Vec::new());
    let (mut changed, mut from_nothing) = (0, 0);
    for i in 0..n {
        let done = if i % 5 == 4 {
            // Everything as it was some moves ago.
            state = earlier[i - 3].clone();
            "back".to_owned()
        } else {
            moves::any(&world, &mut state, &mut rng)
                .map_or("nothing".to_owned(), |m| format!("{m:?} {}", moves::name(&world, m)))
        };
        earlier.push(state.clone());
        remembering.observe(state.clone());
        let mut fresh = grp(&world);
        fresh.observe(state.clone());
        let (known, found) = (remembering.all_facts(), fresh.all_facts());
        for (known, found) in known.iter().zip(&found) {
            assert_eq!(known, found, "after move {i} ({done}) of seed {seed} in {path}");
        }
        changed += known.iter().zip(&before).filter(|(a, b)| a.3 != b.3).count();
        from_nothing += fresh.counts().facts;
        before = known;
    }
    (changed, remembering.counts().facts - begun, from_nothing)
}

#[test]
fn what_is_remembered_is_what_is_found_from_nothing() {
    for (path, n) in [("worlds/three_objects.toml", 60), ("tests/facts/thirty.toml", 20)] {
        let (changed, with, without) = compare(path, 1, n);
        assert!(changed > n, "{changed} facts of {path} changed");
        assert!(
            with * 2 < without,
            "{with} facts of {path} worked out, {without} without the memory"
        );
    }
}
