//! The world at the times of a plan, as `docs/view.md` tells it and the page's `timeline.js` computes it.
//!
//! A plan that names an agent, joint or object that the world lacks is played without it: [`Playback::problems`] names them. Does NOT
//! check anything else; `validate` does.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use crate::plan::{AttachmentChange, Geometry, Plan, Trajectory};
use crate::world::{Held, Scene, State};

/// What moves when, and who takes or lets go of what when.
#[derive(Debug)]
pub(super) struct Playback<'a> {
    scene: &'a Scene,
    start: &'a State,
    /// By start.
    pub segments: Vec<Segment<'a>>,
    /// By time.
    changes: Vec<Change>,
    /// When the last action or motion ends [s].
    pub duration: f64,
    /// What the plan names and the world lacks, as sentences.
    pub problems: Vec<String>,
}

/// The motion of one sub-action.
#[derive(Debug)]
pub(super) struct Segment<'a> {
    /// Index of the action in the plan.
    pub action: usize,
    /// Index into `Scene::agents`.
    pub agent: usize,
    /// Index into its arms.
    pub arm: Option<usize>,
    /// [s]
    pub start: f64,
    pub end: f64,
    /// For each joint of the trajectory its index in the agent's `q`.
    pub dofs: Vec<Option<usize>>,
    pub trajectory: &'a Trajectory,
}

/// A hand that takes or lets go.
#[derive(Debug)]
struct Change {
    time: f64,
    object: usize,
    to: Stands,
}

#[derive(Debug)]
enum Stands {
    InHand(Held),
    At(crate::geom::Pose),
}

impl<'a> Playback<'a> {
    /// Prepares the plan in its world; without a plan nothing moves.
    pub(super) fn new(scene: &'a Scene, start: &'a State, plan: Option<&'a Plan>) -> Self {
        let mut playback = Playback {
            scene,
            start,
            segments: Vec::new(),
            changes: Vec::new(),
            duration: 0.0,
            problems: Vec::new(),
        };
        for action in plan.map_or(&[][..], |plan| &plan.actions) {
            playback.duration = playback.duration.max(action.end);
            if let Some(geometry) = &action.geometry {
                playback.add(action.index, action.start, geometry);
            }
        }
        // The sorts are stable: of two at the same time, the later in the plan comes last and wins.
        playback.segments.sort_by(|a, b| a.start.total_cmp(&b.start));
        playback.changes.sort_by(|a, b| a.time.total_cmp(&b.time));
        playback
    }

    fn add(&mut self, action: usize, begin: f64, geometry: &'a Geometry) {
        let Some(agent) = self.scene.agents.iter().position(|a| a.id == geometry.agent) else {
            let who = &geometry.agent;
            self.problems
                .push(format!("the plan moves {who}, who is not in this world"));
            return;
        };
        let body = &self.scene.agents[agent];
        let arm = body.arms.iter().position(|a| a.name == geometry.arm);
        let mut start = begin;
        for sub in &geometry.sub_actions {
            let joints = sub.trajectory.joints.iter();
            let dofs: Vec<_> = joints
                .map(|name| body.tree.dofs.iter().position(|d| d.name == *name))
                .collect();
            for (joint, _) in sub.trajectory.joints.iter().zip(&dofs).filter(|(_, dof)| dof.is_none()) {
                self.problems
                    .push(format!("the plan moves {joint}, which {} does not have", body.id));
            }
            let end = start + sub.trajectory.duration();
            self.segments.push(Segment {
                action,
                agent,
                arm,
                start,
                end,
                dofs,
                trajectory: &sub.trajectory,
            });
            if let Some(change) = &sub.change {
                self.change(change, end, agent, arm);
            }
            start = end;
        }
        self.duration = self.duration.max(start);
    }

    fn change(&mut self, change: &AttachmentChange, time: f64, agent: usize, arm: Option<usize>) {
        let (AttachmentChange::Attach { object: id, .. } | AttachmentChange::Detach { object: id, .. }) = change;
        let object = self.scene.objects.iter().position(|o| o.id == *id);
        let (Some(object), Some(arm)) = (object, arm) else {
            let text = format!("the plan handles {id} with a hand or a thing that is not in this world");
            self.problems.push(text);
            return;
        };
        let to = match change {
            AttachmentChange::Attach { object_in_tool, .. } => Stands::InHand(Held {
                agent,
                arm,
                X_TO: object_in_tool.pose(),
            }),
            AttachmentChange::Detach { object_in_world, .. } => Stands::At(object_in_world.pose()),
        };
        self.changes.push(Change { time, object, to });
    }

    /// Calls `see` with the world at each of `times` [s], which ascend, and with the segments that go on or end then (indices).
    pub(super) fn visit(&self, times: &[f64], see: &mut dyn FnMut(&State, &[usize])) {
        let mut state = self.start.clone();
        let (mut begun, mut changed) = (0, 0);
        let mut active: Vec<usize> = Vec::new();
        for &t in times {
            while self.segments.get(begun).is_some_and(|s| s.start <= t) {
                active.push(begun);
                begun += 1;
            }
            // In the order of their starts: of two that move one joint, the later wins.
            for segment in active.iter().map(|i| &self.segments[*i]) {
                segment.pose(t, &mut state.agents[segment.agent].q);
            }
            while let Some(change) = self.changes.get(changed).filter(|c| c.time <= t) {
                let object = &mut state.objects[change.object];
                match &change.to {
                    Stands::InHand(held) => object.held = Some(held.clone()),
                    Stands::At(X_WO) => (object.held, object.X_WO) = (None, *X_WO),
                }
                changed += 1;
            }
            self.carry(&mut state);
            see(&state, &active);
            active.retain(|i| self.segments[*i].end > t);
        }
    }

    /// Puts what is held where its hand is.
    fn carry(&self, state: &mut State) {
        let mut links: Vec<Option<Vec<crate::geom::Pose>>> = vec![None; state.agents.len()];
        for object in &mut state.objects {
            let Some(held) = &object.held else { continue };
            let (body, at) = (&self.scene.agents[held.agent], &state.agents[held.agent]);
            let X_WL = links[held.agent].get_or_insert_with(|| body.tree.link_poses(&at.X_WB, &at.q));
            let arm = &body.arms[held.arm];
            object.X_WO = X_WL[arm.tip_link] * arm.X_LT * held.X_TO;
        }
    }
}

impl Segment<'_> {
    /// Writes the configuration at `t` [s] into `q`; after its end it stays as it ended.
    fn pose(&self, t: f64, q: &mut [f64]) {
        let Trajectory { times, positions, .. } = self.trajectory;
        let after = times.partition_point(|x| *x <= t - self.start);
        let before = after.saturating_sub(1);
        let after = after.min(times.len().saturating_sub(1));
        let (Some(a), Some(b)) = (positions.get(before), positions.get(after)) else {
            return;
        };
        let span = times[after] - times[before];
        let share = if span > 0.0 {
            (t - self.start - times[before]) / span
        } else {
            0.0
        };
        for (dof, (a, b)) in self.dofs.iter().zip(a.iter().zip(b)) {
            if let Some(v) = dof.and_then(|dof| q.get_mut(dof)) {
                *v = a + share * (b - a);
            }
        }
    }
}
