//! How many geometric alternatives an action gets (thesis 4.3.4), fixed or adaptive.
//!
//! Adaptive: each action, by its name, may take one alternative to its first solution. When an alternative has led to a
//! longer branch than all solutions before it in the same world state, alternatives of that action have paid, and one more is
//! allowed from then on, in all of the search, up to a limit. What was not tried is counted as cut short, as with a fixed
//! number. A number that the action itself sets stays.

use super::outcome::{Branching, NONE};
use super::reasoner::{GasRef, Projection};
use super::search::{Choice, Flow, Point, Search};
use crate::ir::{ActionId, TaskId};

/// HEURISTIC: solutions of an action whose alternatives have not paid yet, and of one whose alternatives always do.
const FEWEST: u32 = 2;
const MOST: u32 = 16;

/// How far branches have got: numbers of actions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    /// Beneath the solutions of this action before the one at hand.
    best: usize,
    /// Beside it, before it was projected.
    beside: usize,
}

/// The numbers that grow, and how far branches got beneath the innermost projected action.
#[derive(Debug)]
pub(super) struct Factors {
    /// By action.
    allowed: Vec<u32>,
    furthest: usize,
}

impl Factors {
    pub fn new(n_actions: usize) -> Self {
        Factors {
            allowed: vec![FEWEST; n_actions],
            furthest: 0,
        }
    }

    /// Notes that a branch has ended after so many actions.
    pub fn note(&mut self, n_steps: usize) {
        self.furthest = self.furthest.max(n_steps);
    }
}

impl Search<'_> {
    /// Returns how many solutions an action gets at most.
    pub fn limit(&self, id: ActionId) -> u32 {
        let own = self.context.domain.actions[id.index()].alternatives;
        own.unwrap_or(match self.settings.branching {
            Branching::Fixed(n) => n,
            Branching::Adaptive => MOST,
        })
    }

    fn is_adaptive(&self, node: u32) -> Option<ActionId> {
        let TaskId::Action(id) = self.tree.nodes.get(node as usize).filter(|_| node != NONE)?.task() else {
            return None;
        };
        let has_own = self.context.domain.actions[id.index()].alternatives.is_some();
        (self.settings.branching == Branching::Adaptive && !has_own).then_some(id)
    }

    /// Leaves a choice point for another solution, if one is allowed; `best` is how far branches beneath those before got.
    pub fn push_alternatives(&mut self, point: Point, node: u32, projection: Projection, limit: u32, best: usize) {
        let GasRef { gas, alternative } = projection.gas;
        let tried = alternative + 1;
        if tried < limit {
            let reached = Reached {
                best,
                beside: self.factors.furthest,
            };
            self.factors.furthest = 0;
            let choice = Choice::Alternative {
                node,
                gas,
                tried,
                limit,
                reached,
            };
            self.choices.push((point, choice));
        } else {
            // HEURISTIC: counted as cut short even if geometry has no further solution: only asking would tell.
            self.truncated.alternatives += 1;
        }
    }

    /// Looks at how far the last solution of an action has led, and says whether another one is allowed, and then how far
    /// they have got so far.
    pub fn next_alternative(&mut self, node: u32, tried: u32, reached: Reached) -> Result<usize, Flow> {
        let got = self.factors.furthest;
        self.factors.furthest = got.max(reached.beside);
        if let Some(id) = self.is_adaptive(node) {
            let allowed = &mut self.factors.allowed[id.index()];
            // What the first solution leads to is no merit of alternatives.
            if tried > 1 && got > reached.best {
                *allowed = (*allowed).max(tried + 1);
            }
            if tried >= *allowed {
                self.truncated.alternatives += 1;
                return Err(Flow::Back);
            }
        }
        Ok(got.max(reached.best))
    }
}
