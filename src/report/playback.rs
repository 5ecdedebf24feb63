//! The world at the times of a plan, as `docs/view.md` tells it and the page's `timeline.js` computes it.
//!
//! A plan that names an agent, joint or object that the world lacks is played without it: [`Playback::problems`] names them. Does NOT
//! check anything else; `validate` does.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::UnitQuaternion;

use crate::geom::{Pose, Vec3};
use crate::plan::{AttachmentChange, Geometry, Motion, Plan, Trajectory};
use crate::world::{AgentState, Held, Scene, State};

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
    /// For each column of the trajectory what it is.
    columns: Vec<Column>,
    pub trajectory: &'a Trajectory,
}

/// What a column of a trajectory moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    /// Index into the agent's `q`.
    Dof(usize),
    /// Of the base in the world.
    X,
    Y,
    Yaw,
    /// A joint that the agent lacks.
    Unknown,
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
    At(Pose),
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
            let column = |name: &String| match (sub.motion, name.as_str()) {
                (Motion::Base, "x") => Column::X,
                (Motion::Base, "y") => Column::Y,
                (Motion::Base, "yaw") => Column::Yaw,
                (_, name) => {
                    let dof = body.tree.dofs.iter().position(|d| d.name == name);
                    dof.map_or(Column::Unknown, Column::Dof)
                }
            };
            let columns: Vec<Column> = sub.trajectory.joints.iter().map(column).collect();
            let named = sub.trajectory.joints.iter().zip(&columns);
            for (joint, _) in named.filter(|(_, c)| **c == Column::Unknown) {
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
                columns,
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
                segment.pose(t, &mut state.agents[segment.agent]);
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
        let mut links: Vec<Option<Vec<Pose>>> = vec![None; state.agents.len()];
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
    /// Moves the agent to where it is at `t` [s]; after its end it stays as it ended.
    fn pose(&self, t: f64, agent: &mut AgentState) {
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
        for (column, (a, b)) in self.columns.iter().zip(a.iter().zip(b)) {
            let v = a + share * (b - a);
            match column {
                Column::Dof(dof) => agent.q[*dof] = v,
                Column::X => agent.X_WB.translation.x = v,
                Column::Y => agent.X_WB.translation.y = v,
                // A base that goes stands upright.
                Column::Yaw => agent.X_WB.rotation = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), v),
                Column::Unknown => {}
            }
        }
    }
}
