//! Choices whose options are tried in an order that is drawn: for restarts.
//!
//! All options are looked up when the choice is made, where the order of the files looks for one after the other. What a
//! domain puts in an order (SELECTORDERED) or takes once (SELECTONCE) stays as it is; ties alone are drawn.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::search::{Choice, Flow, Point, Search};
use crate::ir::{Binder, TaskId, Value};

/// Returns the stream of a round.
pub(super) fn stream(seed: Option<u64>) -> Option<ChaCha8Rng> {
    seed.map(ChaCha8Rng::seed_from_u64)
}

impl Search<'_> {
    /// Puts options in a drawn order; leaves them as they are where nothing is drawn.
    pub fn draw<T>(&mut self, options: &mut [T]) {
        if let Some(random) = &mut self.random {
            options.shuffle(random);
        }
    }

    /// Tries the decompositions of a method whose preconditions hold, in a drawn order.
    pub fn decompose_drawn(&mut self, point: Point, node: u32) -> Flow {
        let frame = self.tree.nodes[node as usize].frame;
        let TaskId::Method(id) = self.tree.task(node) else {
            return Flow::Back;
        };
        let prepared = self.prepared;
        let method = &self.context.domain.methods[id.index()];
        let mut left = Vec::new();
        for (index, decomposition) in method.decompositions.iter().enumerate() {
            let folded = &prepared.order(prepared.number(id, index)).preconditions;
            let test = (&decomposition.preconditions, folded);
            if self.passes(test, node, frame as usize, index as u64) {
                left.push(index as u32);
            }
        }
        self.draw(&mut left);
        self.decompose_next(point, node, left)
    }

    /// Applies the last of these decompositions; leaves a choice point for the rest.
    pub fn decompose_next(&mut self, point: Point, node: u32, mut left: Vec<u32>) -> Flow {
        let (TaskId::Method(id), Some(index)) = (self.tree.task(node), left.pop()) else {
            return Flow::Back;
        };
        if !left.is_empty() {
            self.choices.push((point, Choice::Decompositions { node, left }));
        }
        self.set_decomposition(node, index);
        self.bind_from(node, id, index as usize, 0)
    }

    /// Binds a SELECT's variable to one of the entities that pass; `None` if there is none.
    pub fn bind_drawn(&mut self, node: u32, binder: u32) -> Option<Flow> {
        let Some(Binder::Select { ty, .. }) = self.binder(node, binder) else {
            return None;
        };
        let entities = &self.context.domain.types[ty.index()].entities;
        let mut left = Vec::new();
        let mut next = self.passing(node, binder, 0);
        while let Some(at) = next {
            left.push(Value::Entity(entities[at as usize]));
            next = self.passing(node, binder, at + 1);
        }
        self.draw(&mut left);
        let first = left.pop()?;
        if !left.is_empty() {
            let point = self.point();
            self.choices.push((point, Choice::Sorted { node, binder, left }));
        }
        Some(self.bind(node, binder, first))
    }

    /// Returns all subtasks that may come next, from this one on, in a drawn order.
    pub fn orders_drawn(&mut self, cell: u32, subtask: u32) -> Vec<(u32, u32)> {
        let mut left = vec![(cell, subtask)];
        let mut last = (cell, subtask);
        while let Some(next) = self.agenda.ready(self.prepared, last.0, last.1 + 1) {
            left.push(next);
            last = next;
        }
        self.draw(&mut left);
        left
    }

    /// Takes up the last of these subtasks; leaves a choice point for the rest.
    pub fn start_next(&mut self, point: Point, mut left: Vec<(u32, u32)>) -> Flow {
        let Some((cell, subtask)) = left.pop() else {
            return Flow::Back;
        };
        if !left.is_empty() {
            self.choices.push((point, Choice::Orders { left }));
        }
        self.start_subtask(cell, subtask)
    }
}
