//! Solves a geometric action: configurations first, motions last (thesis 3.3.3.2, Algorithm 5).
//!
//! For each candidate (an assignment of the description's choices) all end states are found first, by inverse kinematics with
//! collision checks; only then are motions planned. Differs from the paper in three ways:
//! - the end state of a straight motion depends on the way (which branch of the inverse kinematics it follows), so a straight motion
//!   is followed at once: it costs about as much as one inverse kinematics call; motions that need a planner wait;
//! - inverse kinematics is restarted until the sub-actions after it have end states, too: backtracking inside a candidate;
//! - a required fact is tested as soon as the placement is known, before any inverse kinematics, and once more at the end.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::arm_space::{ArmSpace, Clearance};
use super::candidates::{Candidate, arms_and_grasps, placements};
use super::description::{APPROACH, Change, Choice, Condition, Description, Required, Space, SubAction, Until};
use super::facts;
use super::key::Key;
use super::motion::{self, Timed};
use super::prepared::{Owner, Prepared, link_poses, overlap, place_all};
use crate::geom::motion::straight;
use crate::geom::{Pose, ik};
use crate::plan::{ActionRefusal, Cause, CauseCount};
use crate::world::{Held, Scene, State};

/// The entities that an action's arguments name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Arguments {
    pub agent: usize,
    pub object: usize,
    /// Object on which it is put.
    pub support: Option<usize>,
    /// Agent for whom it is done.
    pub receiver: Option<usize>,
}

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
}

/// A sub-action with its end state and how to get there.
#[derive(Debug, Clone)]
pub(super) struct Stage {
    pub sub_action: &'static SubAction,
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
    pub description: &'static Description,
    pub arguments: Arguments,
    /// World state in which it starts.
    pub start: State,
    key: Key,
    candidates: Vec<Candidate>,
    next: usize,
    /// By sub-action (position; `usize::MAX` for the whole action) and cause.
    causes: Vec<CauseCount>,
    pub found: u32,
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
        description: &'static Description,
        arguments: Arguments,
        start: State,
        key: Key,
    ) -> Search {
        let mut search = Search {
            description,
            arguments,
            start,
            key,
            candidates: Vec::new(),
            next: 0,
            causes: Vec::new(),
            found: 0,
        };
        match search.first_candidates(room) {
            Ok(candidates) => search.candidates = candidates,
            Err(why) => search.count("", Cause::NotApplicable(why)),
        }
        search
    }

    fn first_candidates(&self, room: &Room<'_>) -> Result<Vec<Candidate>, String> {
        let Arguments {
            agent, object, support, ..
        } = self.arguments;
        let (body, thing) = (&room.scene.agents[agent], &room.scene.objects[object]);
        if !thing.movable {
            return Err(format!("{} can't be moved", thing.id));
        }
        let holder = self.start.objects[object].held.as_ref();
        match self.description.choice {
            Choice::ArmAndGrasp => {
                if let Some(held) = holder {
                    return Err(format!("{} is held by {}", thing.id, room.scene.agents[held.agent].id));
                }
                if thing.grasps.is_empty() {
                    return Err(format!("{} has no grasp", thing.id));
                }
                if body.arms.iter().all(|a| a.gripper.is_none()) {
                    return Err(format!("{} has no gripper", body.id));
                }
                let all = arms_and_grasps(room.scene, room.prepared, &self.start, agent, object);
                if all.is_empty() {
                    return Err(format!(
                        "{} has no free hand that opens wide enough for {}",
                        body.id, thing.id
                    ));
                }
                Ok(all)
            }
            Choice::Placement => {
                let held = holder.filter(|h| h.agent == agent);
                let Some(held) = held else {
                    return Err(format!("{} is not in a hand of {}", thing.id, body.id));
                };
                let on = support.ok_or("no support is named")?;
                if room.scene.objects[on].supports.is_empty() {
                    return Err(format!("{} has no face to put things on", room.scene.objects[on].id));
                }
                if thing.stable.is_empty() {
                    return Err(format!("{} can't stand by itself", thing.id));
                }
                let held = as_held(room.scene, object, held);
                let mut rng = ChaCha8Rng::seed_from_u64(self.key.text("placements").0);
                let limit = room.settings.placements;
                let all = placements(room.scene, &self.start, object, on, &held, limit, &mut rng);
                if all.is_empty() {
                    let on = &room.scene.objects[on].id;
                    return Err(format!("{} does not fit on {on} in any orientation", thing.id));
                }
                Ok(all)
            }
        }
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
            let mut attempt = Attempt {
                room,
                description: self.description,
                arguments: self.arguments,
                candidate: &candidate,
                rng,
                counts,
                failures: BTreeMap::new(),
            };
            match attempt.solve(&self.start) {
                Ok(stages) => {
                    self.found += 1;
                    return Some(Solution { candidate, stages });
                }
                Err((sub_action, cause)) => self.count(sub_action, cause),
            }
        }
        None
    }

    fn count(&mut self, sub_action: &str, cause: Cause) {
        match self
            .causes
            .iter_mut()
            .find(|c| c.sub_action == sub_action && c.cause == cause)
        {
            Some(c) => c.count += 1,
            None => self.causes.push(CauseCount {
                sub_action: sub_action.to_owned(),
                cause,
                count: 1,
            }),
        }
    }

    /// Returns why there is no further solution.
    pub(super) fn refusal(&self, room: &Room<'_>) -> ActionRefusal {
        let id = |o: usize| room.scene.objects[o].id.clone();
        let Arguments {
            agent,
            object,
            support,
            receiver,
        } = self.arguments;
        let mut names = vec![room.scene.agents[agent].id.clone(), id(object)];
        names.extend(support.map(id));
        names.extend(receiver.map(|r| room.scene.agents[r].id.clone()));
        let mut causes = self.causes.clone();
        causes.sort_by_key(|c| std::cmp::Reverse(c.count));
        // Placements are a sample of a continuous space: all of them tried does not prove that there is none.
        let continuous = self.description.choice == Choice::Placement && !self.candidates.is_empty();
        ActionRefusal {
            call: format!("{}({})", self.description.names[0], names.join(", ")),
            found_before: self.found,
            exhausted: self.next >= self.candidates.len() && !continuous,
            tried: self.next as u32,
            causes,
        }
    }
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

/// Why a candidate failed: the sub-action's name (empty for the whole action) and the cause.
type Failure = (&'static str, Cause);

/// One candidate at work.
struct Attempt<'a, 'b> {
    room: &'b Room<'a>,
    description: &'static Description,
    arguments: Arguments,
    candidate: &'b Candidate,
    rng: ChaCha8Rng,
    counts: &'b mut Counts,
    /// What stopped the tries inside this candidate, by how far they came; the furthest one is reported.
    failures: BTreeMap<usize, Failure>,
}

impl Attempt<'_, '_> {
    fn solve(&mut self, start: &State) -> Result<Vec<(Stage, Timed)>, Failure> {
        self.placement_is_possible(start)?;
        let Some(stages) = self.end_states(0, start) else {
            let furthest = self.failures.pop_last();
            let arm = self.arm_name();
            return Err(furthest.map_or(("", Cause::OutOfReach { arm }), |(_, f)| f));
        };
        if let Some(last) = stages.last() {
            self.required_facts(&last.end)?;
        }
        self.motions(stages)
    }

    fn arm_name(&self) -> String {
        self.room.scene.agents[self.arguments.agent].arms[self.candidate.arm]
            .name
            .clone()
    }

    /// Cheap tests of a placement, before any inverse kinematics: free of others, near enough, facts that shall hold.
    fn placement_is_possible(&mut self, start: &State) -> Result<(), Failure> {
        let Some(placement) = &self.candidate.placement else {
            return Ok(());
        };
        let Arguments { agent, object, .. } = self.arguments;
        let room = self.room;
        let ready = &room.prepared.agents[agent].arms[self.candidate.arm];
        let X_WL = link_poses(room.scene, start);
        let p_WTool = (placement.X_WO * self.candidate.X_OT).translation.vector;
        if (p_WTool - X_WL[agent][ready.shoulder_link].translation.vector).norm() > ready.reach {
            return Err(("place", Cause::OutOfReach { arm: self.arm_name() }));
        }
        let others = place_all(room.prepared, start, &X_WL, &|owner| match owner {
            Owner::Link { agent: a, link } => a == agent && ready.moved.contains(&link),
            Owner::Object(o) => o == object || o == placement.on,
        });
        for part in &room.prepared.objects[object] {
            let X_WS = placement.X_WO * part.X_FS;
            if let Some(other) = others.iter().find(|b| overlap(&part.padded, &X_WS, b.solid, &b.X_WS)) {
                let (a, b) = (Owner::Object(object).name(room.scene), other.owner.name(room.scene));
                return Err(("place", Cause::Collision { a, b }));
            }
        }
        if !self.description.required.is_empty() {
            let mut there = start.clone();
            there.objects[object].X_WO = placement.X_WO;
            there.objects[object].held = None;
            self.required_facts(&there)?;
        }
        Ok(())
    }

    fn required_facts(&mut self, state: &State) -> Result<(), Failure> {
        let Arguments { object, receiver, .. } = self.arguments;
        let room = self.room;
        for required in self.description.required {
            let holds = match (required, receiver) {
                (Required::ReachableByReceiver, Some(receiver)) => {
                    self.counts.facts += 1;
                    facts::is_reachable(room.scene, room.prepared, state, object, receiver, room.seed)
                }
                (Required::ReachableByReceiver, None) => false,
            };
            if !holds {
                let receiver = receiver.map_or("nobody", |r| room.scene.agents[r].id.as_str());
                let fact = format!("isReachable({}, {receiver})", room.scene.objects[object].id);
                return Err(("place", Cause::Fact(fact)));
            }
        }
        Ok(())
    }

    fn fail(&mut self, stage: usize, cause: Cause) {
        let name = self.description.sub_actions[stage].name;
        self.failures.entry(stage).or_insert((name, cause));
    }

    fn fail_by_hit(&mut self, stage: usize, space: &ArmSpace<'_>, otherwise: Cause) {
        let cause = space.hit_names().map_or(otherwise, |(a, b)| Cause::Collision { a, b });
        self.fail(stage, cause);
    }

    /// Returns the end states of the sub-actions from `stage` on, or `None` after noting what stopped them.
    fn end_states(&mut self, stage: usize, state: &State) -> Option<Vec<Stage>> {
        let Some(sub_action) = self.description.sub_actions.get(stage) else {
            return Some(Vec::new());
        };
        if !sub_action.when.iter().all(|c| self.condition_holds(*c, state)) {
            self.fail(stage, Cause::NotApplicable("its pre-condition does not hold".into()));
            return None;
        }
        match sub_action.space {
            Space::Gripper => self.gripper_stage(stage, sub_action, state),
            Space::ArmStraight => self.straight_stage(stage, sub_action, state),
            Space::Arm => self.free_stage(stage, sub_action, state),
        }
    }

    fn condition_holds(&self, condition: Condition, state: &State) -> bool {
        let Arguments { agent, object, .. } = self.arguments;
        let in_hand = |o: usize| {
            state.objects[o]
                .held
                .as_ref()
                .is_some_and(|h| h.agent == agent && h.arm == self.candidate.arm)
        };
        match condition {
            Condition::HandFree => !(0..state.objects.len()).any(in_hand),
            Condition::HandFull => in_hand(object),
        }
    }

    fn space(&self, state: &State, clearance: Clearance) -> ArmSpace<'_> {
        let Arguments { agent, object, .. } = self.arguments;
        let (scene, prepared) = (self.room.scene, self.room.prepared);
        ArmSpace::new(
            scene,
            prepared,
            state,
            agent,
            self.candidate.arm,
            Some(object),
            clearance,
        )
    }

    fn gripper_stage(&mut self, stage: usize, sub: &'static SubAction, state: &State) -> Option<Vec<Stage>> {
        let Arguments { agent, .. } = self.arguments;
        let gripper = self.room.scene.agents[agent].arms[self.candidate.arm]
            .gripper
            .as_ref()?;
        let values = match sub.until {
            Until::GripperOpen => gripper.open.clone(),
            _ => gripper.at_gap(self.candidate.width),
        };
        let now: Vec<f64> = gripper.dofs.iter().map(|d| state.agents[agent].q[*d]).collect();
        let there = now.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-6);
        if there && sub.change.is_none() {
            return self.end_states(stage + 1, state);
        }
        let mut end = state.clone();
        for (dof, value) in gripper.dofs.iter().zip(&values) {
            end.agents[agent].q[*dof] = *value;
        }
        let mut moved = self.space(state, Clearance::Contact);
        let q = moved.start();
        // Fingers move little: their ends and three places between show whether something is in their way.
        let free = (0..=4).all(|i| {
            let t = f64::from(i) / 4.0;
            let at: Vec<f64> = now.iter().zip(&values).map(|(a, b)| a + t * (b - a)).collect();
            moved.set_dofs(&gripper.dofs, &at);
            moved.check(&q)
        });
        if !free {
            let cause = moved.hit_names().map(|(a, b)| Cause::Collision { a, b });
            self.fail(
                stage,
                cause.unwrap_or(Cause::NotApplicable("the fingers can't move".into())),
            );
            return None;
        }
        self.change_hands(sub.change, &mut end);
        let rest = self.end_states(stage + 1, &end)?;
        Some(self.stage(sub, state, end, Way::Gripper { values }, rest))
    }

    fn change_hands(&self, change: Option<Change>, state: &mut State) {
        let Arguments { agent, object, .. } = self.arguments;
        match change {
            None => {}
            // The object is held as it is, which differs from the grasp by what inverse kinematics left over.
            Some(Change::Attach) => {
                let X_TO = self.tool(state).inverse() * state.objects[object].X_WO;
                state.objects[object].held = Some(Held {
                    agent,
                    arm: self.candidate.arm,
                    X_TO,
                });
            }
            // Let go, it settles on the support by what inverse kinematics left over.
            Some(Change::Detach) => {
                state.objects[object].held = None;
                if let Some(placement) = &self.candidate.placement {
                    state.objects[object].X_WO = placement.X_WO;
                }
            }
        }
    }

    fn stage(&self, sub: &'static SubAction, start: &State, end: State, way: Way, rest: Vec<Stage>) -> Vec<Stage> {
        let mut all = vec![Stage {
            sub_action: sub,
            start: start.clone(),
            end,
            way,
        }];
        all.extend(rest);
        all
    }

    /// Returns X_WT in a state.
    fn tool(&self, state: &State) -> Pose {
        let Arguments { agent, .. } = self.arguments;
        let (body, at) = (&self.room.scene.agents[agent], &state.agents[agent]);
        let arm = &body.arms[self.candidate.arm];
        body.tree.link_poses(&at.X_WB, &at.q)[arm.tip_link] * arm.X_LT
    }

    /// Returns X_WT where the sub-action ends.
    fn target(&self, until: Until, state: &State) -> Option<Pose> {
        let back = Pose::translation(-APPROACH, 0.0, 0.0);
        let up = Pose::translation(0.0, 0.0, APPROACH);
        let X_WO = &state.objects[self.arguments.object].X_WO;
        let X_OT = &self.candidate.X_OT;
        let placed = self.candidate.placement.as_ref().map(|p| p.X_WO * X_OT);
        match until {
            Until::BeforeGrasp => Some(X_WO * X_OT * back),
            Until::AtGrasp => Some(X_WO * X_OT),
            Until::Lifted => Some(up * self.tool(state)),
            Until::AbovePlacement => placed.map(|X_WT| up * X_WT),
            Until::AtPlacement => placed,
            Until::AwayFromObject => Some(self.tool(state) * back),
            Until::GripperOpen | Until::GripperClosed => None,
        }
    }

    fn with_arm_at(&self, state: &State, q: &[f64]) -> State {
        let Arguments { agent, .. } = self.arguments;
        let mut end = state.clone();
        let chain = &self.room.prepared.agents[agent].arms[self.candidate.arm].chain;
        for (dof, value) in chain.dof_indices().iter().zip(q) {
            end.agents[agent].q[*dof] = *value;
        }
        let X_WT = self.tool(&end);
        for object in &mut end.objects {
            if let Some(held) = &object.held
                && held.agent == agent
                && held.arm == self.candidate.arm
            {
                object.X_WO = X_WT * held.X_TO;
            }
        }
        end
    }

    /// Returns X_KW, K being the frame of the arm's base link.
    fn base(&self, state: &State) -> Pose {
        let Arguments { agent, .. } = self.arguments;
        let (body, at) = (&self.room.scene.agents[agent], &state.agents[agent]);
        body.tree.link_poses(&at.X_WB, &at.q)[body.arms[self.candidate.arm].base_link].inverse()
    }

    fn straight_stage(&mut self, stage: usize, sub: &'static SubAction, state: &State) -> Option<Vec<Stage>> {
        let X_KT = self.base(state) * self.target(sub.until, state)?;
        let chain = &self.room.prepared.agents[self.arguments.agent].arms[self.candidate.arm].chain;
        let mut space = self.space(state, Clearance::Contact);
        let start = space.start();
        let result = straight::straight(chain, &X_KT, &start, &motion::STRAIGHT, &mut |q| space.check(q));
        let (hit, checks) = (space.hit_names(), space.checks);
        self.counts.configurations_checked += checks;
        match result {
            Ok(path) => {
                let end = self.with_arm_at(state, path.last()?);
                let rest = self.end_states(stage + 1, &end)?;
                Some(self.stage(sub, state, end, Way::Straight { path }, rest))
            }
            Err(_) => {
                let arm = self.arm_name();
                self.fail(
                    stage,
                    hit.map_or(Cause::NoStraightMotion { arm }, |(a, b)| Cause::Collision { a, b }),
                );
                None
            }
        }
    }

    fn free_stage(&mut self, stage: usize, sub: &'static SubAction, state: &State) -> Option<Vec<Stage>> {
        let X_WT = self.target(sub.until, state)?;
        let (room, agent) = (self.room, self.arguments.agent);
        let ready = &room.prepared.agents[agent].arms[self.candidate.arm];
        let X_KW = self.base(state);
        let arm = self.arm_name();
        let body = &room.scene.agents[agent];
        let shoulder = body.tree.link_poses(&state.agents[agent].X_WB, &state.agents[agent].q)[ready.shoulder_link];
        if (X_WT.translation.vector - shoulder.translation.vector).norm() > ready.reach {
            self.fail(stage, Cause::OutOfReach { arm });
            return None;
        }
        let (scene, prepared) = (room.scene, room.prepared);
        let object = Some(self.arguments.object);
        // Where the contact motion after this one ends, the hand alone must fit: that rules out most grasps and placements.
        if let Some(next) = self.description.sub_actions.get(stage + 1)
            && next.space == Space::ArmStraight
            && let Some(X_WT_next) = self.target(next.until, state)
        {
            let mut contact = ArmSpace::new(
                scene,
                prepared,
                state,
                agent,
                self.candidate.arm,
                object,
                Clearance::Contact,
            );
            if !contact.hand_is_free(&X_WT_next) {
                self.fail_by_hit(stage + 1, &contact, Cause::OutOfReach { arm });
                return None;
            }
        }
        let mut space = ArmSpace::new(
            scene,
            prepared,
            state,
            agent,
            self.candidate.arm,
            object,
            Clearance::Margin,
        );
        if !space.hand_is_free(&X_WT) {
            self.fail_by_hit(stage, &space, Cause::OutOfReach { arm });
            return None;
        }
        let seed = space.start();
        let settings = ik::Settings {
            restarts: room.settings.ik_restarts,
            ..motion::IK
        };
        let mut rng = self.rng.clone();
        let mut hit = None;
        let mut found = None;
        self.counts.ik_calls += 1;
        let result = ik::solve(
            &ready.chain,
            &ik::Target::Pose(X_KW * X_WT),
            &seed,
            &settings,
            &mut rng,
            &mut |q| {
                if !space.check(q) {
                    hit = space.hit_names();
                    return false;
                }
                let end = self.with_arm_at(state, q);
                found = self.end_states(stage + 1, &end).map(|rest| (end, rest));
                found.is_some()
            },
        );
        self.rng = rng;
        self.counts.configurations_checked += space.checks;
        match (result, found) {
            (Ok(goal), Some((end, rest))) => Some(self.stage(sub, state, end, Way::Free { goal }, rest)),
            _ => {
                self.fail(
                    stage,
                    hit.map_or(Cause::OutOfReach { arm }, |(a, b)| Cause::Collision { a, b }),
                );
                None
            }
        }
    }

    /// Plans and times the motions between the end states.
    fn motions(&mut self, stages: Vec<Stage>) -> Result<Vec<(Stage, Timed)>, Failure> {
        let Arguments { agent, .. } = self.arguments;
        let mut all = Vec::with_capacity(stages.len());
        for stage in stages {
            let name = stage.sub_action.name;
            let timed = match &stage.way {
                Way::Free { goal } => {
                    self.counts.motion_plans += 1;
                    let mut rng = self.rng.clone();
                    let mut space = self.space(&stage.start, Clearance::Margin);
                    let samples = self.room.settings.motion_samples;
                    let planned = motion::free(&mut space, goal, samples, &mut rng);
                    let checks = space.checks;
                    self.rng = rng;
                    self.counts.configurations_checked += checks;
                    planned.map_err(|e| match e {
                        motion::NoMotion::Blocked(hit) => Cause::Collision { a: hit.0, b: hit.1 },
                        motion::NoMotion::OutOfSamples(samples) => Cause::NoPath {
                            arm: self.arm_name(),
                            samples,
                        },
                    })
                }
                Way::Straight { path } => {
                    let mut space = self.space(&stage.start, Clearance::Contact);
                    Ok(motion::along(&mut space, path))
                }
                Way::Gripper { values } => {
                    let body = &self.room.scene.agents[agent];
                    let gripper = body.arms[self.candidate.arm].gripper.as_ref();
                    let dofs: &[usize] = gripper.map_or(&[], |g| &g.dofs);
                    let from: Vec<f64> = dofs.iter().map(|d| stage.start.agents[agent].q[*d]).collect();
                    Ok(motion::fingers(&body.tree, dofs, &from, values))
                }
            };
            match timed {
                Ok(timed) => all.push((stage, timed)),
                Err(cause) => return Err((name, cause)),
            }
        }
        Ok(all)
    }
}
