//! Tasks that come back to themselves, and recursions that do not end.
//!
//! A task that meets itself above it, with the same arguments and no action in between, can do nothing there that it could
//! not do above. When nothing else is to be done after the inner one, what it leads to is what the outer one leads to: the
//! cut loses nothing. Else only plans are lost in which the rest of the decomposition is done over and over (the left
//! recursion `T: T, c or b` gives `b`, and not `b c`): these cuts are counted in `Truncated::cycles`.
//!
//! The 64 tasks right above are looked at, and beyond them one that Brent's method chooses (BIT 20, 1980,
//! doi:10.1007/BF01933190): a longer cycle is found in its second or third round.

use super::outcome::{Cuts, Inner, NONE};
use super::refusals::Kind;
use super::search::{Flow, Search};
use crate::plan::Refusal;

const NEAR: u32 = 64;
/// Tasks of a chain that are named.
const MOST_NAMED: usize = 8;

impl Search<'_> {
    /// Sets how many nodes right above a new one were taken up since the last action, and the one that stands for those
    /// further up.
    pub fn note_streak(&mut self, node: u32) {
        let parent = self.tree.nodes[node as usize].parent;
        let at = self.steps.len() as u32;
        let above = match parent {
            NONE => None,
            parent => self.tree.inner(parent).filter(|p| p.at == at),
        };
        // A node is made with none above it.
        let Some(p) = above else { return };
        let anchor = if p.streak >= NEAR && p.streak.is_power_of_two() {
            parent
        } else {
            p.anchor
        };
        let (streak, returns) = (p.streak + 1, p.returns);
        if let Some(new) = self.tree.inner_mut(node) {
            (new.streak, new.anchor, new.returns) = (streak, anchor, returns);
        }
    }

    /// Refuses a method that is above itself in the same state.
    pub fn refuse_cycle(&mut self, node: u32) -> Option<Flow> {
        if self.settings.cuts == Cuts::Off {
            return None;
        }
        let inner = self.tree.inner(node)?;
        if inner.streak == 0 {
            return None;
        }
        let above = self.same_above(node, inner)?;
        let outer = self.tree.inner(above)?;
        // INVARIANT: what was to be done after the outer task is in cells that stay as they are until it ends.
        if self.settings.interleave || outer.head != inner.head {
            if inner.returns < self.round.returns {
                self.tree.inner_mut(node)?.returns += 1;
                return None;
            }
            self.truncated.cycles += 1;
        }
        self.memo.came_back_to(above);
        self.reads.path();
        Some(self.refuse(Kind::Cycle, node, &[], |search| Refusal::Cycle {
            chain: search.chain(above, node),
        }))
    }

    fn same_above(&self, node: u32, inner: &Inner) -> Option<u32> {
        let domain = self.context.domain;
        let (task, args) = (self.tree.task(node), self.tree.args(domain, node));
        let is_same = |other: u32| self.tree.task(other) == task && self.tree.args(domain, other) == args;
        let mut at = node;
        for _ in 0..inner.streak.min(NEAR) {
            at = self.tree.nodes[at as usize].parent;
            if is_same(at) {
                return Some(at);
            }
        }
        (inner.anchor != NONE && is_same(inner.anchor)).then_some(inner.anchor)
    }

    /// Refuses a method that is too deep, with the last round of its recursion.
    pub fn refuse_depth(&mut self, node: u32) -> Flow {
        self.truncated.depth += 1;
        self.reads.path();
        let task = self.tree.task(node);
        let mut above = self.tree.nodes[node as usize].parent;
        // Where the method was met before: the chain from there is what repeats itself.
        while above != NONE && self.tree.task(above) != task {
            above = self.tree.nodes[above as usize].parent;
        }
        let depth = self.settings.budget.depth;
        self.refuse(Kind::TooDeep, node, &[], |search| Refusal::TooDeep {
            task: search.show(node),
            depth,
            chain: search.chain(above, node),
        })
    }

    /// Names the tasks from `above` down to `node`.
    fn chain(&self, above: u32, node: u32) -> Vec<String> {
        let mut chain = Vec::new();
        let mut at = node;
        while at != NONE {
            chain.push(self.show(at));
            if at == above || chain.len() > 100_000 {
                break;
            }
            at = self.tree.nodes[at as usize].parent;
        }
        chain.reverse();
        if chain.len() > MOST_NAMED {
            chain.splice(MOST_NAMED / 2..chain.len() - MOST_NAMED / 2, ["...".to_owned()]);
        }
        chain
    }
}
