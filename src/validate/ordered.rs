//! Whether links keep the order that the domain gives to subtasks, where no effect depends on it.
//!
//! Of two ordered subtasks, the last actions of the one must be before the first actions of the other; inside of each that
//! was checked before, and precedence is transitive. A subtask without actions hands on what comes before it. What is first
//! and last below a task is looked up from below: where it is below one subtask alone, the walk starts there, so that deep
//! trees cost no more than flat ones.

use std::collections::BTreeMap;

use super::precedence::Precedence;
use crate::ir::Decomposition;
use crate::plan::Node;

/// No action is below the node.
const NONE: usize = usize::MAX;

/// What is first, or last, below each node.
struct Ends {
    /// The node with a choice, or the action, that stands for each node.
    at: Vec<usize>,
    /// Below the nodes with a choice.
    several: BTreeMap<usize, Vec<usize>>,
}

impl Ends {
    /// Says that these children are the first, or last, of a node.
    fn set(&mut self, node: usize, children: &[usize]) {
        match children {
            [] => {}
            [one] => self.at[node] = self.at[*one],
            several => {
                self.at[node] = node;
                self.several.insert(node, several.to_vec());
            }
        }
    }

    /// Returns the actions' nodes.
    fn leaves(&self, node: usize) -> Vec<usize> {
        let (mut left, mut found) = (vec![self.at[node]], Vec::new());
        while let Some(at) = left.pop() {
            match self.several.get(&at) {
                Some(children) => left.extend(children.iter().map(|c| self.at[*c])),
                None => found.push(at),
            }
        }
        found
    }
}

/// What is known of the nodes whose subtasks were looked at.
pub(super) struct Ordered<'a> {
    nodes: &'a [Node],
    links: Precedence<'a>,
    first: Ends,
    last: Ends,
}

impl<'a> Ordered<'a> {
    /// `links` lists what is right before each action.
    pub(super) fn new(nodes: &'a [Node], links: &'a [Vec<usize>]) -> Self {
        let is_action = |node: &Node| node.action.is_some_and(|a| a < links.len());
        let at = nodes
            .iter()
            .enumerate()
            .map(|(i, n)| if is_action(n) { i } else { NONE });
        let at: Vec<usize> = at.collect();
        let ends = |at| Ends {
            at,
            several: BTreeMap::new(),
        };
        Ordered {
            nodes,
            links: Precedence::new(links),
            first: ends(at.clone()),
            last: ends(at),
        }
    }

    fn acts(&self, node: Option<usize>) -> Option<usize> {
        node.filter(|n| self.first.at[*n] != NONE)
    }

    /// Lists the subtasks with actions that one comes after. `nodes` has the node of each subtask.
    fn before(&self, of: &Decomposition, nodes: &[Option<usize>], subtask: usize) -> Vec<usize> {
        let mut left = of.subtasks[subtask].after.clone();
        let (mut seen, mut found) = (vec![false; of.subtasks.len()], Vec::new());
        while let Some(k) = left.pop() {
            if std::mem::replace(&mut seen[k], true) {
                continue;
            }
            match self.acts(nodes[k]) {
                Some(_) => found.push(k),
                None => left.extend(&of.subtasks[k].after),
            }
        }
        found
    }

    /// Returns two actions that the decomposition orders, and the links do not.
    pub(super) fn unordered(&self, of: &Decomposition, nodes: &[Option<usize>]) -> Option<(usize, usize)> {
        let action = |node: usize| self.nodes[node].action;
        for (j, node) in nodes.iter().enumerate() {
            let Some(node) = self.acts(*node) else { continue };
            for before in self.before(of, nodes, j).into_iter().filter_map(|k| nodes[k]) {
                let firsts = self.first.leaves(node);
                for last in self.last.leaves(before).into_iter().filter_map(action) {
                    let unlinked = |first: &usize| !self.links.has(last, *first);
                    if let Some(first) = firsts.iter().filter_map(|n| action(*n)).find(unlinked) {
                        return Some((last, first));
                    }
                }
            }
        }
        None
    }

    /// Notes what is first and last below a node whose subtasks are these.
    pub(super) fn close(&mut self, node: usize, of: &Decomposition, nodes: &[Option<usize>]) {
        let mut is_followed = vec![false; nodes.len()];
        let (mut first, mut last) = (Vec::new(), Vec::new());
        for (j, child) in nodes.iter().enumerate() {
            let Some(child) = self.acts(*child) else { continue };
            let before = self.before(of, nodes, j);
            if before.is_empty() {
                first.push(child);
            }
            before.into_iter().for_each(|k| is_followed[k] = true);
        }
        for (child, is_followed) in nodes.iter().zip(is_followed) {
            last.extend(self.acts(*child).filter(|_| !is_followed));
        }
        self.first.set(node, &first);
        self.last.set(node, &last);
    }
}
