//! Solves a geometric action: configurations first, motions last (thesis 3.3.3.2, Algorithm 5).
//!
//! For each candidate (an assignment of the description's choices) all end states are found first, by inverse kinematics with
//! collision checks; only then are motions planned. Differs from the paper in three ways:
//! - the end state of a straight motion depends on the way (which branch of the inverse kinematics it follows), so a straight motion
//!   is followed at once: it costs about as much as one inverse kinematics call; motions that need a planner wait;
//! - inverse kinematics is restarted until the sub-actions after it have end states, too: backtracking inside a candidate;
//! - a required fact is tested as soon as the placement is known, before any inverse kinematics, and once more at the end;
//! - so are those constraints of the domain that follow from where the things stand; the others wait for the end states.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::sync::atomic::{AtomicBool, Ordering};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::attempt;
use super::candidates::{Candidate, Wanted, arms_and_grasps, placements};
use super::constraints::{Constraints, Which};
use super::description::{Description, Placing};
use super::facts::is_level;
use super::key::Key;
use super::motion::Timed;
use super::prepared::Prepared;
use crate::plan::{ActionRefusal, Cause, CauseCount};
use crate::world::{Agent, Held, Scene, State};

/// Budgets of one geometric action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Placements tried before an action gives up (thesis 3.3.3.1: 200).
    pub placements: u32,
    /// Tries of inverse kinematics beyond the first, per arm target.
    pub ik_restarts: u32,
    /// Samples of the motion planner per motion.
    pub motion_samples: u32,
}

/// Counts of what was computed (thesis Table 3.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    pub candidates: u64,
    pub ik_calls: u64,
    pub motion_plans: u64,
    pub configurations_checked: u64,
    pub facts: u64,
    pub requests: u64,
}

/// A sub-action with its end state and how to get there.
#[derive(Debug, Clone)]
pub(super) struct Stage {
    /// Position in the description.
    pub sub_action: usize,
    /// World state when it starts.
    pub start: State,
    /// World state when it is over, hand-over done.
    pub end: State,
    pub way: Way,
}

/// How a stage moves.
#[derive(Debug, Clone)]
pub(super) enum Way {
    /// To be planned: the arm's configuration at the end.
    Free { goal: Vec<f64> },
    /// Configurations along the line, both ends included.
    Straight { path: Vec<Vec<f64>> },
    /// The fingers' values at the end.
    Gripper { values: Vec<f64> },
}

/// A solution with all its motions.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub candidate: Candidate,
    pub stages: Vec<(Stage, Timed)>,
}

impl Solution {
    /// Returns the world state that it leads to.
    pub(super) fn end(&self) -> Option<&State> {
        self.stages.last().map(|(stage, _)| &stage.end)
    }
}

/// A geometric action at work: which candidates were tried, what stopped them.
#[derive(Debug)]
pub(super) struct Search {
    pub description: Description,
    constraints: Constraints,
    /// World state in which it starts.
    pub start: State,
    key: Key,
    candidates: Vec<Candidate>,
    next: usize,
    /// By sub-action (position; `usize::MAX` for the whole action) and cause.
    causes: Vec<CauseCount>,
    pub found: u32,
}

/// Counts what stopped a candidate; `sub_action` is empty for the whole action.
pub(super) fn count(causes: &mut Vec<CauseCount>, sub_action: &str, cause: Cause) {
    let known = causes
        .iter_mut()
        .find(|c| c.sub_action == sub_action && c.cause == cause);
    match known {
        Some(c) => c.count += 1,
        None => causes.push(CauseCount {
            sub_action: sub_action.to_owned(),
            cause,
            count: 1,
        }),
    }
}

/// What a search may look at.
#[derive(Debug)]
pub(super) struct Room<'a> {
    pub scene: &'a Scene,
    pub prepared: &'a Prepared,
    pub settings: Settings,
    /// Of the facts' random streams.
    pub seed: u64,
    pub stop: &'a AtomicBool,
}

impl Search {
    /// Starts an action in a world state. An action that its arguments rule out has no candidates and one cause.
    pub(super) fn new(
        room: &Room<'_>,
        description: Description,
        constraints: Constraints,
        start: State,
        key: Key,
    ) -> Search {
        let mut search = Search {
            description,
            constraints,
            start,
            key,
            candidates: Vec::new(),
            next: 0,
            causes: Vec::new(),
            found: 0,
        };
        if let Some(text) = search.constraints.broken(Which::Decided, &mut |_| None) {
            search.count("", Cause::Constraint(text));
            return search;
        }
        match search.first_candidates(room) {
            Ok(candidates) => search.candidates = candidates,
            Err(why) => search.count("", Cause::NotApplicable(why)),
        }
        search
    }

    fn first_candidates(&self, room: &Room<'_>) -> Result<Vec<Candidate>, String> {
        let object = self.description.object;
        let thing = &room.scene.objects[object];
        if !thing.movable {
            return Err(format!("{} can't be moved", thing.id));
        }
        let holds = if self.description.takes {
            self.grasps_to_take(room)?
        } else {
            vec![self.hold(room)?]
        };
        let Some(Placing { on, is_centred, .. }) = self.description.placing else {
            return Ok(holds);
        };
        let below = &room.scene.objects[on];
        if on == object {
            return Err(format!("{} can't be put on itself", thing.id));
        }
        // What stands on a held thing would not move with it.
        if let Some(held) = &self.start.objects[on].held {
            return Err(format!("{} is held by {}", below.id, room.scene.agents[held.agent].id));
        }
        if below.supports.is_empty() {
            return Err(format!("{} has no face to put things on", below.id));
        }
        if !below.supports.iter().any(|s| is_level(&self.start.objects[on].X_WO, s)) {
            return Err(format!("{} has no level face to put things on", below.id));
        }
        if thing.stable.is_empty() {
            return Err(format!("{} can't stand by itself", thing.id));
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.key.text("placements").0);
        let given = &self.description.given;
        for (what, wanted, names) in [
            (
                "face",
                &given.face,
                below.supports.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(),
            ),
            (
                "orientation",
                &given.stable,
                thing.stable.iter().map(|s| s.name.as_str()).collect(),
            ),
        ] {
            let whose = if what == "face" { below } else { thing };
            if let Some(wanted) = wanted.as_ref().filter(|w| !names.contains(&w.as_str())) {
                return Err(format!(
                    "{} has no {what} `{wanted}`: it has {}",
                    whose.id,
                    names.join(", ")
                ));
            }
        }
        let wanted = Wanted {
            object,
            on,
            is_centred,
            given,
            limit: room.settings.placements,
        };
        let all = placements(room.scene, &self.start, &wanted, &mut rng);
        if all.is_empty() {
            return Err(format!("{} does not fit on {} in any orientation", thing.id, below.id));
        }
        // Placements change slowest: the most promising hold is tried at once, and every hold at every placement.
        let combined = all.iter().flat_map(|placement| {
            holds.iter().map(|hold| Candidate {
                placement: Some(placement.clone()),
                ..hold.clone()
            })
        });
        Ok(combined.collect())
    }

    /// Returns the arms and grasps by which the object can be taken.
    fn grasps_to_take(&self, room: &Room<'_>) -> Result<Vec<Candidate>, String> {
        let Description { agent, object, .. } = self.description;
        let (body, thing) = (&room.scene.agents[agent], &room.scene.objects[object]);
        if let Some(held) = &self.start.objects[object].held {
            return Err(format!("{} is held by {}", thing.id, room.scene.agents[held.agent].id));
        }
        if thing.grasps.is_empty() {
            return Err(format!("{} has no grasp", thing.id));
        }
        if body.arms.iter().all(|a| a.gripper.is_none()) {
            return Err(format!("{} has no gripper", body.id));
        }
        let mut all = arms_and_grasps(room.scene, room.prepared, &self.start, agent, object);
        all.retain(|c| self.moved_along(room, c.arm).is_none());
        let given = &self.description.given;
        if let Some(arm) = &given.arm {
            if body.arms.iter().all(|a| a.name != *arm) {
                return Err(no_arm(body, arm));
            }
            all.retain(|c| body.arms[c.arm].name == *arm);
        }
        if let Some(grasp) = &given.grasp {
            if thing.grasps.iter().all(|g| g.name != *grasp) {
                let names: Vec<&str> = thing.grasps.iter().map(|g| g.name.as_str()).collect();
                return Err(format!(
                    "{} has no grasp `{grasp}`: it has {}",
                    thing.id,
                    names.join(", ")
                ));
            }
            all.retain(|c| c.grasp == *grasp);
        }
        if all.is_empty() {
            return Err(format!(
                "{} has no free hand whose fingers can hold {}",
                body.id, thing.id
            ));
        }
        Ok(all)
    }

    /// Returns the hand that holds the object, and how.
    fn hold(&self, room: &Room<'_>) -> Result<Candidate, String> {
        let Description { agent, object, .. } = self.description;
        let (body, thing) = (&room.scene.agents[agent], &room.scene.objects[object]);
        let held = self.start.objects[object].held.as_ref().filter(|h| h.agent == agent);
        let Some(held) = held else {
            return Err(format!("{} is not in a hand of {}", thing.id, body.id));
        };
        if let Some(arm) = self
            .description
            .given
            .arm
            .as_ref()
            .filter(|a| **a != body.arms[held.arm].name)
        {
            if body.arms.iter().all(|a| a.name != *arm) {
                return Err(no_arm(body, arm));
            }
            return Err(format!("{} is not in the {arm} hand of {}", thing.id, body.id));
        }
        if body.arms[held.arm].gripper.is_none() {
            return Err(format!("{} has no gripper", body.id));
        }
        if let Some(other) = self.moved_along(room, held.arm) {
            let (arm, other) = (&body.arms[held.arm].name, &room.scene.objects[other].id);
            return Err(format!(
                "the {arm} arm of {} would move {other} in its other hand",
                body.id
            ));
        }
        Ok(as_held(room.scene, object, held))
    }

    /// Returns an object in another hand of the agent that this arm's joints move as well: arms may share a trunk. What is
    /// carried along like that is not planned for, so such an arm is not used.
    fn moved_along(&self, room: &Room<'_>, arm: usize) -> Option<usize> {
        let agent = self.description.agent;
        let moved = &room.prepared.agents[agent].arms[arm].moved;
        self.start.objects.iter().position(|o| {
            o.held.as_ref().is_some_and(|h| {
                h.agent == agent && h.arm != arm && moved.contains(&room.scene.agents[agent].arms[h.arm].tip_link)
            })
        })
    }

    /// Returns the next solution, never one given before; `None` when there is none, or somebody stopped the search.
    pub(super) fn next_solution(&mut self, room: &Room<'_>, counts: &mut Counts) -> Option<Solution> {
        while self.next < self.candidates.len() {
            if room.stop.load(Ordering::Relaxed) {
                return None;
            }
            let index = self.next;
            self.next += 1;
            counts.candidates += 1;
            let candidate = self.candidates[index].clone();
            let rng = ChaCha8Rng::seed_from_u64(self.key.text("candidate").number(index as u64).0);
            match attempt::solve(
                room,
                &attempt::Wanted {
                    description: &self.description,
                    constraints: &self.constraints,
                    candidate: &candidate,
                },
                &self.start,
                rng,
                counts,
            ) {
                Ok(stages) => {
                    self.found += 1;
                    return Some(Solution { candidate, stages });
                }
                Err((sub_action, cause)) => self.count(&sub_action, cause),
            }
        }
        None
    }

    fn count(&mut self, sub_action: &str, cause: Cause) {
        count(&mut self.causes, sub_action, cause);
    }

    /// Returns why there is no further solution.
    pub(super) fn refusal(&self, room: &Room<'_>) -> ActionRefusal {
        let mut causes = self.causes.clone();
        causes.sort_by_key(|c| std::cmp::Reverse(c.count));
        // Placements are a sample of a continuous space: all of them tried does not prove that there is none.
        let Description { placing, given, .. } = &self.description;
        let leaves_open = |p: &Placing| given.yaw.is_none() || given.xy.is_none() && !p.is_centred;
        let continuous = placing.as_ref().is_some_and(leaves_open) && !self.candidates.is_empty();
        ActionRefusal {
            call: self.description.call(room.scene),
            found_before: self.found,
            exhausted: self.next >= self.candidates.len() && !continuous,
            tried: self.next as u32,
            causes,
        }
    }
}

fn no_arm(body: &Agent, arm: &str) -> String {
    let names: Vec<&str> = body.arms.iter().map(|a| a.name.as_str()).collect();
    format!("{} has no arm `{arm}`: it has {}", body.id, names.join(", "))
}

/// Within this a hold is one of the object's grasps: far above what inverse kinematics leaves over, far below what tells two
/// grasps apart [m], [rad].
const SAME_PLACE: f64 = 1e-3;
const SAME_ANGLE: f64 = 1e-2;

/// Returns the grasp by which an object is held, with its name if it is one of the object's own.
fn as_held(scene: &Scene, object: usize, held: &Held) -> Candidate {
    let X_OT = held.X_TO.inverse();
    let same = scene.objects[object].grasps.iter().find(|g| {
        let off = g.X_OT.inverse() * X_OT;
        off.translation.vector.norm() < SAME_PLACE && off.rotation.angle() < SAME_ANGLE
    });
    Candidate {
        arm: held.arm,
        grasp: same.map_or_else(|| "given".to_owned(), |g| g.name.clone()),
        X_OT,
        width: same.map_or(0.0, |g| g.width),
        placement: None,
    }
}
