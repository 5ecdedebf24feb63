//! Which actions of a plan the domain itself orders: their ancestors are ordered subtasks of one decomposition.
//!
//! The pairs of a long chain are too many to be listed. For each action only those are listed that come right before it: the
//! last ones of the subtasks that its own (or its nearest ordered ancestor) comes after. All others come before those. Does
//! not need subtrees to be contiguous: interleaved plans are ordered by the same rule.

use std::rc::Rc;

use rustc_hash::FxHashMap;

use super::outcome::{Found, NONE, Node};
use crate::ir::{Decomposition, Domain, TaskId};

/// Returns for each step the steps that come right before it by the order of the domain.
pub(super) fn right_before(found: &Found, domain: &Domain) -> Vec<Rc<[u32]>> {
    let tree = Family::new(found, domain);
    let none: Rc<[u32]> = Rc::new([]);
    let mut before: Vec<Rc<[u32]>> = Vec::with_capacity(tree.nodes.len());
    let mut last_ones: FxHashMap<u32, Rc<[u32]>> = FxHashMap::default();
    for (i, node) in tree.nodes.iter().enumerate() {
        if node.parent == NONE {
            before.push(Rc::clone(&none));
            continue;
        }
        let siblings = tree.siblings_before(i as u32);
        let own = match siblings.as_slice() {
            // Its parent's also come before the siblings that this one comes after.
            [] => Rc::clone(&before[node.parent as usize]),
            [one] => Rc::clone(last_ones.entry(*one).or_insert_with(|| tree.last_steps(*one).into())),
            several => {
                let all = several.iter().flat_map(|s| {
                    let of_one = last_ones.entry(*s).or_insert_with(|| tree.last_steps(*s).into());
                    of_one.to_vec()
                });
                all.collect()
            }
        };
        before.push(own);
    }
    found
        .steps
        .iter()
        .map(|step| Rc::clone(&before[step.node as usize]))
        .collect()
}

/// The decomposition tree with what hangs below each node.
struct Family<'a> {
    domain: &'a Domain,
    nodes: &'a [Node],
    /// The step of a leaf, or [`NONE`].
    step: Vec<u32>,
    /// Whether there is an action at or below it.
    acts: Vec<bool>,
    last_child: Vec<u32>,
    /// The sibling taken up before it.
    previous: Vec<u32>,
    /// A node by its parent and its position there.
    by_place: FxHashMap<(u32, u32), u32>,
}

impl<'a> Family<'a> {
    fn new(found: &'a Found, domain: &'a Domain) -> Self {
        let nodes = &found.tree.nodes;
        let n = nodes.len();
        let mut family = Family {
            domain,
            nodes,
            step: vec![NONE; n],
            acts: vec![false; n],
            last_child: vec![NONE; n],
            previous: vec![NONE; n],
            by_place: FxHashMap::default(),
        };
        for (i, step) in found.steps.iter().enumerate() {
            family.step[step.node as usize] = i as u32;
            family.acts[step.node as usize] = true;
        }
        for (i, node) in nodes.iter().enumerate().skip(1) {
            family.previous[i] = std::mem::replace(&mut family.last_child[node.parent as usize], i as u32);
            family.by_place.insert((node.parent, node.subtask), i as u32);
        }
        for (i, node) in nodes.iter().enumerate().skip(1).rev() {
            if family.acts[i] {
                family.acts[node.parent as usize] = true;
            }
        }
        family
    }

    fn decomposition(&self, node: u32) -> Option<&'a Decomposition> {
        let Node {
            task, decomposition, ..
        } = self.nodes[node as usize];
        match task {
            TaskId::Method(m) => self.domain.methods[m.index()]
                .decompositions
                .get(decomposition as usize),
            TaskId::Action(_) => None,
        }
    }

    /// Returns the siblings with actions that a node comes after; those without lead on to what they come after.
    fn siblings_before(&self, node: u32) -> Vec<u32> {
        let Node { parent, subtask, .. } = self.nodes[node as usize];
        let Some(decomposition) = self.decomposition(parent) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        let mut seen = Vec::new();
        let mut left = decomposition.subtasks[subtask as usize].after.clone();
        while let Some(position) = left.pop() {
            let Some(sibling) = self.by_place.get(&(parent, position as u32)) else {
                continue;
            };
            if self.acts[*sibling as usize] {
                if !found.contains(sibling) {
                    found.push(*sibling);
                }
            } else if !seen.contains(&position) {
                seen.push(position);
                left.extend(&decomposition.subtasks[position].after);
            }
        }
        found
    }

    /// Returns the steps at or below a node that no other step there comes after by the order of the domain.
    fn last_steps(&self, node: u32) -> Vec<u32> {
        let mut steps = Vec::new();
        let mut left = vec![node];
        while let Some(at) = left.pop() {
            if self.step[at as usize] != NONE {
                steps.push(self.step[at as usize]);
                continue;
            }
            let Some(decomposition) = self.decomposition(at) else {
                continue;
            };
            // Siblings that come after others are taken up after them.
            let mut is_followed = vec![false; decomposition.subtasks.len()];
            let mut child = self.last_child[at as usize];
            while child != NONE {
                let subtask = self.nodes[child as usize].subtask as usize;
                let acts = self.acts[child as usize];
                if acts && !is_followed[subtask] {
                    left.push(child);
                }
                if acts || is_followed[subtask] {
                    for before in &decomposition.subtasks[subtask].after {
                        is_followed[*before] = true;
                    }
                }
                child = self.previous[child as usize];
            }
        }
        steps
    }
}
