//! Which pairs of an agent's links may touch: those whose contact says nothing about a collision.
//!
//! Neighbours; pairs that no joint moves against each other; pairs two joints apart that touch in the rest posture; and pairs
//! that touch in every one of a fixed number of seeded random configurations. Deterministic: the seed is part of the algorithm.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::f64::consts::PI;

use super::Body;
use crate::geom::Pose;
use crate::geom::collide::{Solid, touch};
use crate::geom::kinematics::{JointKind, Tree};

/// HEURISTIC: a pair that can be apart was found apart within 20 samples for the models that ship.
const SAMPLES: usize = 64;
const SEED: u64 = 0x5_9a9;

/// Returns the pairs, smaller link first; `given` is part of them.
pub fn pairs(tree: &Tree, bodies: &[Body], rest: &[f64], given: &BTreeSet<(usize, usize)>) -> BTreeSet<(usize, usize)> {
    let solids: Vec<Solid> = bodies.iter().map(|b| Solid::new(&b.shape)).collect();
    let mut pairs = given.clone();
    let links: BTreeSet<usize> = bodies.iter().map(|b| b.link).collect();
    let groups = rigid_groups(tree);
    let mut open: Vec<(usize, usize)> = Vec::new();
    for &a in &links {
        for &b in links.range(a + 1..) {
            if groups[a] == groups[b] || steps(tree, &groups, &links, a, b) == Some(1) {
                pairs.insert((a, b));
            } else if !pairs.contains(&(a, b)) {
                open.push((a, b));
            }
        }
    }
    let at_rest = Placed::new(bodies, &solids, &tree.link_poses(&Pose::identity(), rest));
    open.retain(|&(a, b)| {
        let near = steps(tree, &groups, &links, a, b) == Some(2);
        let excused = near && at_rest.touch(a, b);
        if excused {
            pairs.insert((a, b));
        }
        !excused
    });
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..SAMPLES {
        if open.is_empty() {
            break;
        }
        let q: Vec<f64> = tree
            .dofs
            .iter()
            .map(|d| {
                let (lower, upper) = (d.lower.max(-PI), d.upper.min(PI));
                lower + rng.random::<f64>() * (upper - lower)
            })
            .collect();
        let placed = Placed::new(bodies, &solids, &tree.link_poses(&Pose::identity(), &q));
        open.retain(|&(a, b)| placed.touch(a, b));
    }
    pairs.extend(open);
    pairs
}

/// The bodies in the world, by link.
struct Placed<'a>(Vec<Vec<(&'a Solid, Pose)>>);

impl<'a> Placed<'a> {
    fn new(bodies: &[Body], solids: &'a [Solid], X_WL: &[Pose]) -> Self {
        let mut placed = vec![Vec::new(); X_WL.len()];
        for (body, solid) in bodies.iter().zip(solids) {
            placed[body.link].push((solid, X_WL[body.link] * body.X_LS));
        }
        Placed(placed)
    }

    fn touch(&self, a: usize, b: usize) -> bool {
        self.0[a].iter().any(|(solid_a, X_WA)| {
            self.0[b].iter().any(|(solid_b, X_WB)| {
                // Most pairs are far apart: spheres about their origins tell.
                let reach = solid_a.radius() + solid_b.radius();
                let between = X_WA.translation.vector - X_WB.translation.vector;
                between.norm_squared() <= reach * reach && touch(solid_a, X_WA, solid_b, X_WB)
            })
        })
    }
}

/// Returns for each link the first link of the rigid piece that it is part of.
fn rigid_groups(tree: &Tree) -> Vec<usize> {
    let mut groups = vec![0];
    for (j, joint) in tree.joints.iter().enumerate() {
        let rigid = joint.kind == JointKind::Fixed;
        groups.push(if rigid { groups[joint.parent] } else { j + 1 });
    }
    groups
}

/// Returns how many joints lie between two links on one chain, or next to their common parent (at most 2); rigid pieces without
/// a shape do not count.
fn steps(tree: &Tree, groups: &[usize], links: &BTreeSet<usize>, a: usize, b: usize) -> Option<usize> {
    let up = |group: usize| -> Option<usize> {
        let mut at = group;
        loop {
            at = groups[tree.joints.get(at.checked_sub(1)?)?.parent];
            if links.iter().any(|l| groups[*l] == at) {
                return Some(at);
            }
        }
    };
    let (a, b) = (groups[a], groups[b]);
    let (up_a, up_b) = (up(a), up(b));
    if up_a == Some(b) || up_b == Some(a) {
        return Some(1);
    }
    let grand = up_a.and_then(up) == Some(b) || up_b.and_then(up) == Some(a);
    let siblings = up_a.is_some() && up_a == up_b;
    (grand || siblings).then_some(2)
}
