//! The cost that geometry computes for an action, with its parts (thesis 3.3.4.2).
//!
//! Of the thesis's three parts there are two: the distance to humans and the length of the motion (its effort, without the
//! potential energy). The visibility of the robot by the humans is not there.

#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use indexmap::IndexMap;

use super::prepared::{Owner, Prepared, link_poses, place_all};
use super::solve::{Solution, Way};
use crate::geom::collide::distance;
use crate::geom::motion::length;
use crate::world::{AgentKind, Scene, State};

/// Cost of a radian of motion of the joint that moves most.
pub(super) const LENGTH_WEIGHT: f64 = 0.1;
/// Cost of being [`COMFORTABLE`] away from a human, at the nearest end state; inversely related to the distance.
const PROXIMITY_WEIGHT: f64 = 1.0;
/// [m] HEURISTIC: about the border between personal and social distance (Hall 1966).
const COMFORTABLE: f64 = 1.2;
/// Nearer than this costs no more [m]: the inverse must stay finite.
const NEAREST: f64 = 0.05;

/// Returns the parts by name; their sum is the cost.
pub(super) fn parts(scene: &Scene, prepared: &Prepared, solution: &Solution, agent: usize) -> IndexMap<String, f64> {
    let mut parts = IndexMap::new();
    let moved: f64 = solution
        .stages
        .iter()
        .filter(|(stage, _)| !matches!(stage.way, Way::Gripper { .. }))
        .flat_map(|(_, timed)| timed.positions.windows(2).map(|w| length(&w[0], &w[1])))
        .sum();
    parts.insert("length".to_owned(), LENGTH_WEIGHT * moved);
    if scene.agents[agent].kind == AgentKind::Robot {
        let nearest = solution
            .stages
            .iter()
            .filter_map(|(stage, _)| nearest_human(scene, prepared, &stage.end, agent))
            .fold(f64::INFINITY, f64::min);
        if nearest.is_finite() {
            parts.insert(
                "proximity".to_owned(),
                PROXIMITY_WEIGHT * COMFORTABLE / nearest.max(NEAREST),
            );
        }
    }
    parts
}

/// Returns the least distance between the agent and a human [m]; `None` without humans.
fn nearest_human(scene: &Scene, prepared: &Prepared, state: &State, agent: usize) -> Option<f64> {
    let X_WL = link_poses(scene, state);
    let is_human = |a: usize| a != agent && scene.agents[a].kind == AgentKind::Human;
    let own = place_all(
        prepared,
        state,
        &X_WL,
        &|o| !matches!(o, Owner::Link { agent: a, .. } if a == agent),
    );
    let humans = place_all(
        prepared,
        state,
        &X_WL,
        &|o| !matches!(o, Owner::Link { agent: a, .. } if is_human(a)),
    );
    let mut least: Option<f64> = None;
    for a in &own {
        for b in &humans {
            let apart = (a.X_WS.translation.vector - b.X_WS.translation.vector).norm();
            // Bounding spheres first: most pairs can't be the nearest.
            if least.is_none_or(|l| apart - a.solid.radius() - b.solid.radius() < l) {
                let d = distance(a.solid, &a.X_WS, b.solid, &b.X_WS);
                least = Some(least.map_or(d, |l| l.min(d)));
            }
        }
    }
    least
}
