//! Which actions of a plan the domain itself orders: their ancestors are ordered subtasks of one decomposition.
//!
//! The pairs of a long chain are too many to be listed. For each action only those are listed that come right before it: the
//! last ones of the subtasks that its own (or its nearest ordered ancestor) comes after. All others come before those. Does
//! not need subtrees to be contiguous: interleaved plans are ordered by the same rule.

use super::outcome::{Found, NONE, Node, Tree};
use crate::ir::Domain;

/// For each step the steps that come right before it.
pub(super) struct RightBefore {
    lists: Lists,
    of_step: Vec<List>,
}

impl RightBefore {
    pub fn of(&self, step: usize) -> &[u32] {
        self.lists.get(self.of_step[step])
    }
}

/// Where a list of steps begins and ends.
type List = (u32, u32);

/// A list that was not asked for yet.
const UNKNOWN: List = (NONE, NONE);

/// Many short lists, one after the other.
#[derive(Default)]
struct Lists(Vec<u32>);

impl Lists {
    fn get(&self, (from, to): List) -> &[u32] {
        &self.0[from as usize..to as usize]
    }
}

/// Returns for each step the steps that come right before it by the order of the domain.
pub(super) fn right_before(found: &Found, domain: &Domain) -> RightBefore {
    let kin = Kin::new(found);
    let (tree, nodes) = (&found.tree, &found.tree.nodes);
    let family = Family {
        domain,
        tree,
        step: &kin.step,
        acts: &kin.acts,
        last_child: &kin.last_child,
        previous: &kin.previous,
    };
    let mut lists = Lists::default();
    // By node: what comes right before it, and the last steps at or below it.
    let mut before: Vec<List> = Vec::with_capacity(nodes.len());
    let mut last_ones: Vec<List> = vec![UNKNOWN; nodes.len()];
    let (mut siblings, mut passed) = (Vec::new(), Vec::new());
    for (i, node) in nodes.iter().enumerate() {
        if node.parent == NONE {
            before.push((0, 0));
            continue;
        }
        family.siblings_before(i as u32, &mut siblings, &mut passed);
        for sibling in &siblings {
            let last = &mut last_ones[*sibling as usize];
            if *last == UNKNOWN {
                let from = lists.0.len() as u32;
                family.last_steps(*sibling, &mut lists.0);
                *last = (from, lists.0.len() as u32);
            }
        }
        let own = match siblings.as_slice() {
            // Its parent's also come before the siblings that this one comes after.
            [] => before[node.parent as usize],
            [one] => last_ones[*one as usize],
            several => {
                let from = lists.0.len() as u32;
                for sibling in several {
                    let (from, to) = last_ones[*sibling as usize];
                    lists.0.extend_from_within(from as usize..to as usize);
                }
                (from, lists.0.len() as u32)
            }
        };
        before.push(own);
    }
    let of_step = found.steps.iter().map(|step| before[step.node as usize]).collect();
    RightBefore { lists, of_step }
}

/// The decomposition tree with what hangs below each node, by node.
#[derive(Clone, Copy)]
pub(super) struct Family<'a> {
    pub domain: &'a Domain,
    pub tree: &'a Tree,
    /// The step of a leaf, or [`NONE`].
    pub step: &'a [u32],
    /// Whether there is an action at or below it.
    pub acts: &'a [bool],
    pub last_child: &'a [u32],
    /// The sibling taken up before it.
    pub previous: &'a [u32],
}

/// What a [`Family`] looks at, of a whole plan.
struct Kin {
    step: Vec<u32>,
    acts: Vec<bool>,
    last_child: Vec<u32>,
    previous: Vec<u32>,
}

impl Kin {
    fn new(found: &Found) -> Self {
        let nodes = &found.tree.nodes;
        let n = nodes.len();
        let mut kin = Kin {
            step: vec![NONE; n],
            acts: vec![false; n],
            last_child: vec![NONE; n],
            previous: vec![NONE; n],
        };
        for (i, step) in found.steps.iter().enumerate() {
            kin.step[step.node as usize] = i as u32;
            kin.acts[step.node as usize] = true;
        }
        for (i, node) in nodes.iter().enumerate().skip(1) {
            kin.previous[i] = std::mem::replace(&mut kin.last_child[node.parent as usize], i as u32);
        }
        for (i, node) in nodes.iter().enumerate().skip(1).rev() {
            if kin.acts[i] {
                kin.acts[node.parent as usize] = true;
            }
        }
        kin
    }
}

impl Family<'_> {
    /// Lists the siblings with actions that a node comes after; those without lead on to what they come after. Whatever a
    /// node comes after was taken up before it.
    pub fn siblings_before(&self, node: u32, found: &mut Vec<u32>, passed: &mut Vec<usize>) {
        let Node { parent, subtask, .. } = self.tree.nodes[node as usize];
        found.clear();
        passed.clear();
        let Some(decomposition) = self.tree.decomposition_in(self.domain, parent) else {
            return;
        };
        let mut left = decomposition.subtasks[subtask as usize].after.as_slice();
        let mut next = 0;
        loop {
            for position in left {
                let mut sibling = self.previous[node as usize];
                while sibling != NONE && self.subtask(sibling) != *position {
                    sibling = self.previous[sibling as usize];
                }
                if sibling == NONE {
                    continue;
                }
                if self.acts[sibling as usize] {
                    if !found.contains(&sibling) {
                        found.push(sibling);
                    }
                } else if !passed.contains(position) {
                    passed.push(*position);
                }
            }
            let Some(position) = passed.get(next) else { return };
            left = &decomposition.subtasks[*position].after;
            next += 1;
        }
    }

    fn subtask(&self, node: u32) -> usize {
        self.tree.nodes[node as usize].subtask as usize
    }

    /// Lists the steps at or below a node that no other step there comes after by the order of the domain.
    pub fn last_steps(&self, node: u32, steps: &mut Vec<u32>) {
        let mut left = vec![node];
        while let Some(at) = left.pop() {
            if self.step[at as usize] != NONE {
                steps.push(self.step[at as usize]);
                continue;
            }
            let Some(decomposition) = self.tree.decomposition_in(self.domain, at) else {
                continue;
            };
            // Siblings that come after others are taken up after them.
            let mut is_followed = vec![false; decomposition.subtasks.len()];
            let mut child = self.last_child[at as usize];
            while child != NONE {
                let (subtask, acts) = (self.subtask(child), self.acts[child as usize]);
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
    }
}
