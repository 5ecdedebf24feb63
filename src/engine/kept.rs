//! Repair of a plan: its first actions are kept, and the search looks for the rest.
//!
//! What is kept is a forced prefix, as in Höller, Bercher, Behnke and Biundo (HTN plan repair via model transformation,
//! KI 2020, doi:10.1007/978-3-030-58285-2_7): the whole is one plan of the task, and its decomposition has the kept actions
//! where they are due. They compile prefix and unforeseen changes into the domain; here the search refuses every action but
//! the next kept one, and what has changed unforeseen stands in the world file. Motions are not planned anew: the reasoner
//! adopts them, so a kept action has no alternatives.

use super::outcome::{NONE, Place};
use super::refusals::Kind;
use super::search::{Flow, Search};
use crate::ir::{ActionId, TaskId, Value};
use crate::plan::{Action, Refusal};

/// An action of an earlier plan that a plan has to begin with.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    pub action: ActionId,
    pub args: Vec<Value>,
    /// As the earlier plan has it: its motions are for the reasoner.
    pub written: Action,
}

impl Search<'_> {
    /// Returns what the next action has to be, as long as not all that is kept is done.
    pub fn next_kept(&self) -> Option<&Kept> {
        self.kept.get(self.steps.len())
    }

    /// Leaves the branch if something is kept, and an action is not the next of it.
    pub fn refuse_unlike_kept(&mut self, node: u32, action: ActionId) -> Option<Flow> {
        let next = self.next_kept()?;
        if next.action == action && next.args == self.tree.args(self.context.domain, node) {
            return None;
        }
        let at = [self.steps.len() as u64];
        Some(self.refuse(Kind::NotKept, node, &at, |search| Refusal::NotKept {
            task: Some(search.show(node)),
            index: search.steps.len(),
            kept: search.show_next_kept(),
        }))
    }

    /// Leaves the branch if it would be a plan without all that is kept.
    pub fn refuse_short(&mut self) -> Option<Flow> {
        self.next_kept()?;
        let at = [self.steps.len() as u64];
        Some(self.refuse(Kind::NotKept, NONE, &at, |search| Refusal::NotKept {
            task: None,
            index: search.steps.len(),
            kept: search.show_next_kept(),
        }))
    }

    fn show_next_kept(&self) -> String {
        let domain = self.context.domain;
        let show = |next: &Kept| domain.show_task(TaskId::Action(next.action), &next.args);
        self.next_kept().map(show).unwrap_or_default()
    }

    /// Does what is kept, from the start and under no task; returns the first action that can't be done, whose reason is
    /// then the only one counted. Everything is as before afterwards.
    pub fn first_impossible(&mut self) -> Option<usize> {
        let kept = self.kept;
        if kept.is_empty() {
            return None;
        }
        // Those who listen to the search have nothing of a trial under no task.
        let observer = self.observer.take();
        let start = self.point();
        let mut impossible = None;
        for (i, next) in kept.iter().enumerate() {
            let frame = self.tree.values.len() as u32;
            self.tree.values.extend(next.args.iter().cloned());
            let place = Place {
                frame,
                parent: NONE,
                subtask: 0,
            };
            let node = self.tree.push(TaskId::Action(next.action), place, i as u32, NONE);
            self.context.reads.clear();
            if self.try_action(node, next.action) == Flow::Back {
                impossible = Some(i);
                break;
            }
        }
        self.go_back(&start);
        self.observer = observer;
        impossible
    }
}
