//! What a search tells whoever listens, while it goes on. Nothing is put together for nobody.
//!
//! A task instance is named by its place in the decomposition tree at hand. Places are used again: after
//! [`Event::WentBack`] only the first `kept` of them stand, and the next task taken up has the number `kept`.

use super::outcome::{Ending, NONE, Statistics};
use super::reasoner::{Call, GasRef};
use super::search::{Choice, Search};
use crate::ir::{Domain, TaskId, Value};
use crate::plan::Refusal;

/// Listens to a search.
pub trait Observer {
    /// Hears of an event, at once.
    fn hear(&mut self, domain: &Domain, event: &Event<'_>);

    /// Says whether it remembers the refusal with this fingerprint: then that is not put into words again.
    fn remembers(&self, refusal: u128) -> bool {
        let _ = refusal;
        false
    }
}

/// Something that a search does.
#[derive(Debug)]
pub enum Event<'a> {
    /// A task is taken up; the root has no parent.
    TakenUp {
        node: u32,
        parent: Option<u32>,
        task: TaskId,
        args: &'a [Value],
        depth: u32,
    },
    /// Nothing is to be done: the goal of the method holds.
    GoalHeld { node: u32 },
    /// The precondition of a decomposition holds, and that decomposition is tried (numbers from 0).
    Decomposed { node: u32, decomposition: u32 },
    /// A SELECT has given its variable a value.
    Bound {
        node: u32,
        variable: &'a str,
        value: &'a Value,
    },
    /// Geometry is asked for a first solution.
    Projecting { node: u32, call: &'a Call<'a> },
    /// Geometry is asked for a further solution, after so many.
    Alternative { node: u32, tried: u32 },
    /// An action is applied; `n_actions` counts it, too.
    Applied {
        node: u32,
        cost: f64,
        gas: Option<GasRef>,
        n_actions: usize,
    },
    /// A branch ends at this task. `words` is missing if the observer remembers them.
    Refused {
        node: u32,
        refusal: u128,
        words: Option<&'a Refusal>,
    },
    /// A branch ends at this task: the same state with the same tasks to do is known to fail, or is on its own path.
    Repeated { node: u32 },
    /// A choice is taken back: its next option is tried; or all is, and the search begins again (`round`). Tasks from number `kept` on are undone.
    WentBack {
        node: u32,
        choice: &'static str,
        kept: u32,
        n_actions: usize,
    },
    /// A plan is found, the `number`th one.
    Found { number: u64, cost: f64, n_actions: usize },
    /// The last event.
    Ended { ending: Ending, statistics: &'a Statistics },
}

impl Choice {
    fn kind(&self) -> &'static str {
        match self {
            Choice::Decomposition { .. } | Choice::Decompositions { .. } => "decomposition",
            Choice::Binding { .. } | Choice::Sorted { .. } => "binding",
            Choice::Order { .. } | Choice::Orders { .. } => "order",
            Choice::Alternative { .. } => "alternative",
            Choice::Watch => "watch",
            Choice::Done { .. } => "mark",
        }
    }
}

impl Search<'_> {
    /// Tells an event to the observer, if there is one.
    #[inline]
    pub fn tell(&mut self, event: impl for<'b> FnOnce(&'b Self) -> Event<'b>) {
        if self.observer.is_some() {
            self.tell_now(event);
        }
    }

    #[cold]
    fn tell_now(&mut self, event: impl for<'b> FnOnce(&'b Self) -> Event<'b>) {
        if let Some(observer) = self.observer.take() {
            observer.hear(self.context.domain, &event(self));
            self.observer = Some(observer);
        }
    }

    /// Says whether the observer wants a refusal in words.
    pub fn wants_words(&self, refusal: u128) -> bool {
        self.observer.as_ref().is_some_and(|o| !o.remembers(refusal))
    }

    /// Tells a refusal; one of geometry says something new each time, and has no fingerprint.
    pub fn tell_refused(&mut self, node: u32, refusal: u128, words: Option<&Refusal>) {
        if let Some(observer) = &mut self.observer {
            observer.hear(self.context.domain, &Event::Refused { node, refusal, words });
        }
    }

    pub fn tell_projecting(&mut self, node: u32, call: &Call<'_>) {
        if let Some(observer) = &mut self.observer {
            observer.hear(self.context.domain, &Event::Projecting { node, call });
        }
    }

    pub fn tell_taken_up(&mut self, node: u32) {
        self.tell(|search| {
            let (tree, n) = (&search.tree, &search.tree.nodes[node as usize]);
            Event::TakenUp {
                node,
                parent: Some(n.parent).filter(|p| *p != NONE),
                task: n.task(),
                args: tree.args(search.context.domain, node),
                depth: tree.depth(node),
            }
        });
    }

    /// `node` is the task that was to be decomposed; without one an order was to be chosen.
    pub fn tell_repeated(&mut self, node: Option<u32>) {
        self.tell(|search| Event::Repeated {
            node: node.unwrap_or(search.last_node()),
        });
    }

    /// Returns the task taken up last.
    pub fn last_node(&self) -> u32 {
        (self.tree.nodes.len() as u32).saturating_sub(1)
    }

    pub fn tell_went_back(&mut self, choice: &Choice) {
        let kind = choice.kind();
        let node = match choice {
            Choice::Decomposition { node, .. }
            | Choice::Decompositions { node, .. }
            | Choice::Binding { node, .. }
            | Choice::Sorted { node, .. }
            | Choice::Alternative { node, .. } => *node,
            Choice::Order { cell, .. } => self.agenda.cell(*cell).node,
            Choice::Orders { left } => left.last().map_or(0, |(cell, _)| self.agenda.cell(*cell).node),
            Choice::Watch | Choice::Done { .. } => return,
        };
        self.tell(|search| Event::WentBack {
            node,
            choice: kind,
            kept: search.tree.nodes.len() as u32,
            n_actions: search.steps.len(),
        });
    }
}
