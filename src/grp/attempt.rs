//! One candidate of a geometric action: its end states, then its motions (thesis 3.3.3.2, Algorithm 5).
//!
//! Knows no action by name: a sub-action's search space says which function finds its end state, its final constraint where that is.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;

use super::arm_space::{ArmSpace, Clearance};
use super::candidates::Candidate;
use super::constraints::{Constraints, Which};
use super::description::{Asked, Description};
use super::motion::{self, Timed};
use super::prepared::{Owner, link_poses, overlap, place_all};
use super::requests::{self, Answer, Fact, Question};
use super::solve::{Counts, Room, Stage, Way};
use crate::geom::motion::straight;
use crate::geom::{Pose, ik};
use crate::ir::geometric::{Change, Condition, Space, SubAction, Target};
use crate::plan::Cause;
use crate::world::{Held, State};

/// Why a candidate failed: the sub-action's name (empty for the whole action) and the cause.
pub(super) type Failure = (String, Cause);

/// What is to be found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'b> {
    pub description: &'b Description,
    /// What must hold in the final state besides what the description says.
    pub constraints: &'b Constraints,
    pub candidate: &'b Candidate,
}

/// One candidate at work.
struct Attempt<'a, 'b> {
    room: &'b Room<'a>,
    description: &'b Description,
    constraints: &'b Constraints,
    candidate: &'b Candidate,
    rng: ChaCha8Rng,
    counts: &'b mut Counts,
    /// What stopped the tries inside this candidate, by how far they came; the furthest one is reported.
    failures: BTreeMap<usize, Failure>,
}

/// Finds the end states and motions of one candidate, or says what stopped it at the furthest sub-action it came to.
pub(super) fn solve(
    room: &Room<'_>,
    wanted: &Wanted<'_>,
    start: &State,
    rng: ChaCha8Rng,
    counts: &mut Counts,
) -> Result<Vec<(Stage, Timed)>, Failure> {
    let failures = BTreeMap::new();
    let Wanted {
        description,
        constraints,
        candidate,
    } = *wanted;
    Attempt {
        room,
        description,
        constraints,
        candidate,
        rng,
        counts,
        failures,
    }
    .solve(start)
}

impl<'b> Attempt<'_, 'b> {
    fn solve(&mut self, start: &State) -> Result<Vec<(Stage, Timed)>, Failure> {
        self.placement_is_possible(start)?;
        let Some(stages) = self.end_states(0, start) else {
            let furthest = self.failures.pop_last();
            let arm = self.arm_name();
            return Err(furthest.map_or((String::new(), Cause::OutOfReach { arm }), |(_, f)| f));
        };
        if let Some(last) = stages.last() {
            self.required_facts(last.sub_action, &last.end)?;
            let name = self.name(last.sub_action);
            self.constraints_hold(Which::All, name, &last.end)?;
        }
        self.motions(stages)
    }

    fn arm_name(&self) -> String {
        self.room.scene.agents[self.description.agent].arms[self.candidate.arm]
            .name
            .clone()
    }

    /// Cheap tests of a placement, before any inverse kinematics: free of others, near enough, facts that shall hold.
    fn placement_is_possible(&mut self, start: &State) -> Result<(), Failure> {
        let Some(placement) = &self.candidate.placement else {
            return Ok(());
        };
        let Description { agent, object, .. } = *self.description;
        let room = self.room;
        let name = || self.description.placing_name().to_owned();
        let ready = &room.prepared.agents[agent].arms[self.candidate.arm];
        let X_WL = link_poses(room.scene, start);
        let p_WTool = (placement.X_WO * self.candidate.X_OT).translation.vector;
        if (p_WTool - X_WL[agent][ready.shoulder_link].translation.vector).norm() > ready.reach {
            return Err((name(), Cause::OutOfReach { arm: self.arm_name() }));
        }
        let others = place_all(room.prepared, start, &X_WL, &|owner| match owner {
            Owner::Link { agent: a, link } => a == agent && ready.moved.contains(&link),
            Owner::Object(o) => o == object || o == placement.on,
        });
        for part in &room.prepared.objects[object] {
            let X_WS = placement.X_WO * part.X_FS;
            if let Some(other) = others.iter().find(|b| overlap(&part.padded, &X_WS, b.solid, &b.X_WS)) {
                let (a, b) = (Owner::Object(object).name(room.scene), other.owner.name(room.scene));
                return Err((name(), Cause::Collision { a, b }));
            }
        }
        let wanted = self.facts_of_placement();
        if !wanted.is_empty() || !self.constraints.is_empty() {
            let mut there = start.clone();
            there.objects[object].X_WO = placement.X_WO;
            there.objects[object].held = None;
            self.constraints_hold(Which::AboutThings, self.description.placing_name(), &there)?;
            self.facts_hold(&wanted, self.description.placing_name(), &there)?;
        }
        Ok(())
    }

    /// Returns the facts that hold once the object stands, as far as it matters little where the agent's own arm is then.
    fn facts_of_placement(&self) -> Vec<&'b Asked> {
        let Description { agent, placing, .. } = *self.description;
        let from = placing.map_or(usize::MAX, |p| p.sub_action);
        let later = self.description.after.iter().skip(from).flatten();
        // HEURISTIC: a place that another agent can reach now it can mostly reach when the arm has drawn back, and the other
        // way round; the test is made again in the final state. Views are more often in the way of an arm.
        let is_settled = |asked: &&Asked| match asked.question {
            Some(Question::Fact(Fact::IsReachable { agent: other, .. })) => other != agent,
            Some(question) => question.is_about_things(),
            None => true,
        };
        later.filter(is_settled).collect()
    }

    /// Tests facts in a state.
    fn facts_hold(&mut self, facts: &[&Asked], sub_action: &str, state: &State) -> Result<(), Failure> {
        for asked in facts {
            let holds = asked.question.and_then(|q| self.ask(q, state)) == Some(Answer::Truth(true));
            if !holds {
                return Err((sub_action.to_owned(), Cause::Fact(asked.text.clone())));
            }
        }
        Ok(())
    }

    fn ask(&mut self, question: Question, state: &State) -> Option<Answer> {
        match question {
            Question::Fact(_) => self.counts.facts += 1,
            _ => self.counts.requests += 1,
        }
        let Room {
            scene, prepared, seed, ..
        } = *self.room;
        requests::answer(scene, prepared, state, seed, question)
    }

    /// Tests the domain's constraints in a state: the final one, or one in which the things already are as in the final one.
    fn constraints_hold(&mut self, which: Which, sub_action: &str, state: &State) -> Result<(), Failure> {
        let constraints = self.constraints;
        let mut ask = |question: Question| self.ask(question, state);
        match constraints.broken(which, &mut ask) {
            Some(text) => Err((sub_action.to_owned(), Cause::Constraint(text))),
            None => Ok(()),
        }
    }

    /// Tests the facts of the last sub-action in the final state.
    fn required_facts(&mut self, last: usize, state: &State) -> Result<(), Failure> {
        let facts: Vec<&Asked> = self.description.after.get(last).into_iter().flatten().collect();
        let name = match self.description.placing_name() {
            "" => self.name(last),
            name => name,
        };
        self.facts_hold(&facts, name, state)
    }

    fn name(&self, sub_action: usize) -> &'b str {
        self.description
            .action
            .sub_actions
            .get(sub_action)
            .map_or("", |s| s.name.as_str())
    }

    fn fail(&mut self, stage: usize, cause: Cause) {
        let name = self.name(stage).to_owned();
        self.failures.entry(stage).or_insert((name, cause));
    }

    fn fail_by_hit(&mut self, stage: usize, space: &ArmSpace<'_>, otherwise: Cause) {
        let cause = space.hit_names().map_or(otherwise, |(a, b)| Cause::Collision { a, b });
        self.fail(stage, cause);
    }

    /// Returns the end states of the sub-actions from `stage` on, or `None` after noting what stopped them.
    fn end_states(&mut self, stage: usize, state: &State) -> Option<Vec<Stage>> {
        let Some(sub_action) = self.description.action.sub_actions.get(stage) else {
            return Some(Vec::new());
        };
        if !sub_action.when.iter().all(|c| self.condition_holds(c, state)) {
            self.fail(stage, Cause::NotApplicable("its pre-condition does not hold".into()));
            return None;
        }
        let facts: Vec<&Asked> = self.description.before[stage].iter().collect();
        if let Err((_, cause)) = self.facts_hold(&facts, "", state) {
            self.fail(stage, cause);
            return None;
        }
        match sub_action.space {
            Space::Gripper(_) => self.gripper_stage(stage, sub_action, state),
            Space::ArmStraight(_) => self.straight_stage(stage, sub_action, state),
            Space::Arm(_) => self.free_stage(stage, sub_action, state),
            // INVARIANT: an action that goes does nothing else (`check`), and is solved by `navigate`.
            Space::Body(_) | Space::Base(_) => None,
        }
    }

    /// Returns what comes after the end state of a sub-action, if its facts hold there. Those of the last one are tested
    /// later, with the constraints of the domain.
    fn rest(&mut self, stage: usize, end: &State) -> Option<Vec<Stage>> {
        let facts: Vec<&Asked> = self.description.after[stage].iter().collect();
        let is_last = stage + 1 == self.description.action.sub_actions.len();
        if !is_last && let Err((_, cause)) = self.facts_hold(&facts, "", end) {
            self.fail(stage, cause);
            return None;
        }
        self.end_states(stage + 1, end)
    }

    /// Facts are asked apart.
    fn condition_holds(&self, condition: &Condition, state: &State) -> bool {
        let Description { agent, object, .. } = *self.description;
        let in_hand = |o: usize| {
            state.objects[o]
                .held
                .as_ref()
                .is_some_and(|h| h.agent == agent && h.arm == self.candidate.arm)
        };
        match condition {
            Condition::Free(_) => !(0..state.objects.len()).any(in_hand),
            Condition::Holds(..) => in_hand(object),
            Condition::Fact(_) => true,
        }
    }

    fn space(&self, state: &State, clearance: Clearance) -> ArmSpace<'_> {
        let Description { agent, object, .. } = *self.description;
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

    fn gripper_stage(&mut self, stage: usize, sub: &SubAction, state: &State) -> Option<Vec<Stage>> {
        let agent = self.description.agent;
        let gripper = self.room.scene.agents[agent].arms[self.candidate.arm]
            .gripper
            .as_ref()?;
        let values = match sub.until {
            Target::Open => gripper.open.clone(),
            Target::Closed(Some(_)) => gripper.at_gap(self.candidate.width),
            Target::Closed(None) => gripper.closed.clone(),
            Target::Grasp { .. }
            | Target::Up(_)
            | Target::Back(_)
            | Target::Placement { .. }
            | Target::Posture
            | Target::Stand(_) => return None,
        };
        let now: Vec<f64> = gripper.dofs.iter().map(|d| state.agents[agent].q[*d]).collect();
        let there = now.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-6);
        if there && sub.change.is_none() {
            return self.rest(stage, state);
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
        let rest = self.rest(stage, &end)?;
        Some(stage_before(stage, state, end, Way::Gripper { values }, rest))
    }

    fn change_hands(&self, change: Option<Change>, state: &mut State) {
        let Description { agent, object, .. } = *self.description;
        match change {
            None => {}
            // The object is held as it is, which differs from the grasp by what inverse kinematics left over.
            Some(Change::Attach(_)) => {
                let X_TO = self.tool(state).inverse() * state.objects[object].X_WO;
                state.objects[object].held = Some(Held {
                    agent,
                    arm: self.candidate.arm,
                    X_TO,
                });
            }
            // Let go, it settles on the support by what inverse kinematics left over.
            Some(Change::Detach(_)) => {
                state.objects[object].held = None;
                if let Some(placement) = &self.candidate.placement {
                    state.objects[object].X_WO = placement.X_WO;
                }
            }
        }
    }

    /// Returns X_WT in a state.
    fn tool(&self, state: &State) -> Pose {
        let agent = self.description.agent;
        let (body, at) = (&self.room.scene.agents[agent], &state.agents[agent]);
        let arm = &body.arms[self.candidate.arm];
        body.tree.link_poses(&at.X_WB, &at.q)[arm.tip_link] * arm.X_LT
    }

    /// Returns X_WT where the sub-action ends.
    fn target(&self, until: Target, state: &State) -> Option<Pose> {
        let back = |d: f64| Pose::translation(-d, 0.0, 0.0);
        let up = |d: f64| Pose::translation(0.0, 0.0, d);
        let object = &state.objects[self.description.object];
        match until {
            Target::Grasp { before, .. } => Some(object.X_WO * self.candidate.X_OT * back(before)),
            Target::Up(d) => Some(up(d) * self.tool(state)),
            Target::Back(d) => Some(self.tool(state) * back(d)),
            Target::Placement { above, .. } => {
                let X_OT = object.held.as_ref().map_or(self.candidate.X_OT, |h| h.X_TO.inverse());
                let placement = self.candidate.placement.as_ref()?;
                Some(up(above) * (placement.X_WO * X_OT))
            }
            Target::Open | Target::Closed(_) | Target::Posture | Target::Stand(_) => None,
        }
    }

    fn with_arm_at(&self, state: &State, q: &[f64]) -> State {
        let agent = self.description.agent;
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
        let agent = self.description.agent;
        let (body, at) = (&self.room.scene.agents[agent], &state.agents[agent]);
        body.tree.link_poses(&at.X_WB, &at.q)[body.arms[self.candidate.arm].base_link].inverse()
    }

    fn straight_stage(&mut self, stage: usize, sub: &SubAction, state: &State) -> Option<Vec<Stage>> {
        let X_KT = self.base(state) * self.target(sub.until, state)?;
        let chain = &self.room.prepared.agents[self.description.agent].arms[self.candidate.arm].chain;
        let mut space = self.space(state, Clearance::Contact);
        let start = space.start();
        let result = straight::straight(chain, &X_KT, &start, &motion::STRAIGHT, &mut |q| space.check(q));
        let (hit, checks) = (space.hit_names(), space.checks);
        self.counts.configurations_checked += checks;
        match result {
            Ok(path) => {
                let end = self.with_arm_at(state, path.last()?);
                let rest = self.rest(stage, &end)?;
                Some(stage_before(stage, state, end, Way::Straight { path }, rest))
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

    fn free_stage(&mut self, stage: usize, sub: &SubAction, state: &State) -> Option<Vec<Stage>> {
        let X_WT = self.target(sub.until, state)?;
        let (room, agent) = (self.room, self.description.agent);
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
        let object = Some(self.description.object);
        // Where the contact motion after this one ends, the hand alone must fit: that rules out most grasps and placements.
        if let Some(next) = self.description.action.sub_actions.get(stage + 1)
            && matches!(next.space, Space::ArmStraight(_))
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
                found = self.rest(stage, &end).map(|rest| (end, rest));
                found.is_some()
            },
        );
        self.rng = rng;
        self.counts.configurations_checked += space.checks;
        match (result, found) {
            (Ok(goal), Some((end, rest))) => Some(stage_before(stage, state, end, Way::Free { goal }, rest)),
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
        let agent = self.description.agent;
        let mut all = Vec::with_capacity(stages.len());
        for stage in stages {
            let name = self.name(stage.sub_action);
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
                Err(cause) => return Err((name.to_owned(), cause)),
            }
        }
        Ok(all)
    }
}

/// Puts a stage before those that come after it.
fn stage_before(sub_action: usize, start: &State, end: State, way: Way, rest: Vec<Stage>) -> Vec<Stage> {
    let mut all = vec![Stage {
        sub_action,
        start: start.clone(),
        end,
        way,
    }];
    all.extend(rest);
    all
}
