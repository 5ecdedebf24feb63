//! What is known to fail: a state with the tasks that are still to be done.
//!
//! The same state with the same tasks to do in the same order has the same futures. So a search of it that has come to its
//! end without a plan is not made again, and one that is still on its way is not begun inside itself: each plan which that
//! could lead to is one of the outer search, behind steps that lead nowhere. What makes a failure less than a fact:
//! - something was cut short beneath it (alternatives, depth, geometry): it is not kept;
//! - a branch was left because it came back to something above it: it fails here only, and is not kept;
//! - for the best plan, the branches beneath were left at some cost up to there: it is kept with that cost, and counts for
//!   those that have cost as much;
//! - with plans beneath, it is no failure when all plans are wanted;
//! - in the fall-back (`rounds`), it counts for branches in which tasks have come back to themselves as often, and is
//!   forgotten when the round ends. The rest of the agenda may have been let less often where it was met: then its plan
//!   comes in a later round, of twice as many returns at most.
//! - where the best plan's cost is more than a sum (`objective`), what the actions to come cost depends on those before:
//!   nothing is kept, and only circles are left.
//!
//! States and tasks are compared by fingerprints (`hash`). Geometry is part of the state if the reasoner can name its world
//! state; else nothing is remembered in a domain whose actions are projected.

use rustc_hash::FxHashMap;

use super::agenda::Cell;
use super::effects::Attributes;
use super::hash::Print;
use super::outcome::{Aim, Cuts, NONE, Statistics, Truncated};
use super::search::{Choice, Search};
use crate::ir::Value;

/// What is known of a state with tasks to do.
#[derive(Debug, Clone, Copy)]
enum Known {
    /// Its search is on the way: the first node that is beneath it, and how many actions were done before.
    Open { first: u32, at: u32 },
    /// It has no plan, or none that is better when so much was spent before, and tasks had come back to themselves so often;
    /// with what it has read (`backjump`).
    Failed { cost: f64, returns: u32, read: Attributes },
}

/// A search on its way.
#[derive(Debug)]
struct Watch {
    key: u128,
    /// The first node that is beneath it.
    first: u32,
    cost: f64,
    returns: u32,
    truncated: Truncated,
    left_out: u64,
    plans: u64,
}

/// The table, and the searches on their way, the innermost last.
#[derive(Debug)]
pub(super) struct Memo {
    known: FxHashMap<u128, Known>,
    watches: Vec<Watch>,
    /// The topmost node that a branch beneath the innermost search has come back to.
    highest: u32,
    /// A state with tasks to do that was met deep down, with what the domain said then; renewed at twice as many tasks
    /// each time (Brent, as in `cycle`). Meeting it again wakes the memory.
    anchor: Option<(Print, u128)>,
    renewed_at: u64,
    /// How often a deep search was asked about.
    n_asked: u64,
    is_awake: bool,
}

/// HEURISTIC: choices taken back before failures are remembered, and how many tasks are taken up for each of them at most.
const PATIENCE: u64 = 100;
const RARE: u64 = 64;
/// HEURISTIC: methods inside methods from which on a search is looked at that has not taken back anything.
const DEEP: u32 = 1000;
/// HEURISTIC: of how many methods deep down one is looked at, at least.
const SELDOM: u64 = 64;
/// HEURISTIC: searches remembered, at about 50 bytes each.
const MAX_KNOWN: usize = 1 << 22;

impl Default for Memo {
    fn default() -> Self {
        Memo {
            known: FxHashMap::default(),
            watches: Vec::new(),
            highest: NONE,
            anchor: None,
            renewed_at: 0,
            n_asked: 0,
            is_awake: false,
        }
    }
}

impl Memo {
    /// Notes that a branch has come back to `node`.
    pub fn came_back_to(&mut self, node: u32) {
        self.highest = self.highest.min(node);
    }
}

impl Search<'_> {
    fn remembers(&self) -> bool {
        let Statistics {
            backtracks, expansions, ..
        } = self.statistics;
        match self.settings.cuts {
            Cuts::Off => false,
            Cuts::On => self.memo.is_awake || (backtracks >= PATIENCE && backtracks >= expansions / RARE),
            Cuts::Always => true,
        }
    }

    /// Looks whether a search that goes on and on without taking anything back is in a circle.
    fn look_deep(&mut self, node: Option<u32>) {
        // The fingerprint is computed anew each time, and so seldom that a step has no more of it than one slot: whatever
        // goes round in a circle comes by again when it is looked at.
        let interval = SELDOM.max(self.context.state.len() as u64);
        self.memo.n_asked += 1;
        if !self.memo.n_asked.is_multiple_of(interval) {
            return;
        }
        let state = self.context.state.computed_print();
        if self.statistics.expansions >= self.memo.renewed_at {
            let Some(key) = self.key_in(state, node) else { return };
            self.memo.anchor = Some((state, key));
            self.memo.renewed_at = 2 * self.statistics.expansions;
        } else if let Some((anchor, key)) = self.memo.anchor
            && anchor == state
            && self.key_in(state, node) == Some(key)
        {
            self.memo.is_awake = true;
        }
    }

    /// Returns the fingerprint of the state with all that is to be done, and `node` first; `None` where the world state has
    /// none.
    fn key(&mut self, node: Option<u32>) -> Option<u128> {
        let state = self.context.state.print();
        self.key_in(state, node)
    }

    /// As [`Search::key`], with the fingerprint of the symbolic state.
    fn key_in(&mut self, state: Print, node: Option<u32>) -> Option<u128> {
        let world = match self.prepared.projects {
            false => 0,
            true => self.context.reasoner.state_key()?,
        };
        // Which actions are allowed depends on how many of the kept ones are done.
        let n_kept = self.steps.len().min(self.kept.len());
        let print = self.print_of_all(state, node).number(n_kept as u64);
        Some(print.number(world as u64).number((world >> 64) as u64).key())
    }

    /// Says whether the state at hand with all that is to be done, and `node` first, is worth a search. If so, watches it.
    pub fn is_new(&mut self, node: Option<u32>, depth: u32) -> bool {
        if !self.remembers() {
            if depth >= DEEP && self.settings.cuts != Cuts::Off {
                self.look_deep(node);
            }
            return true;
        }
        let Some(key) = self.key(node) else { return true };
        let above = node.unwrap_or_else(|| self.agenda.cell(self.agenda.head).node);
        let returns = self.tree.inner(above).map_or(0, |inner| inner.returns);
        match self.memo.known.get(&key) {
            Some(Known::Open { first, at }) => {
                self.memo.highest = self.memo.highest.min(*first);
                self.reads.path();
                // A circle can be worth its cost where that is not a sum: it evens out efforts, or parts two actions.
                if self.objective.is_some() && *at as usize != self.steps.len() {
                    self.truncated.cycles += 1;
                }
                self.statistics.repeated += 1;
                self.tell_repeated(node);
                return false;
            }
            Some(Known::Failed {
                cost,
                returns: then,
                read,
            }) if self.cost >= *cost && returns >= *then => {
                self.reads.since |= *read;
                self.statistics.repeated += 1;
                self.tell_repeated(node);
                return false;
            }
            Some(Known::Failed { .. }) => {}
            None if self.memo.known.len() >= MAX_KNOWN => return true,
            None => {}
        }
        let first = node.unwrap_or(self.tree.nodes.len() as u32);
        let at = self.steps.len() as u32;
        self.memo.known.insert(key, Known::Open { first, at });
        self.memo.watches.push(Watch {
            key,
            first,
            cost: self.cost,
            returns,
            truncated: self.truncated,
            left_out: self.left_out,
            plans: self.n_derivations,
        });
        self.note_reads();
        self.context.reads.clear();
        let point = self.point();
        self.choices.push((point, Choice::Watch));
        self.begin_noting();
        true
    }

    /// Forgets the searches that are still on their way, when a round ends before they do.
    pub fn forget_open(&mut self) {
        for watch in self.memo.watches.drain(..) {
            self.memo.known.remove(&watch.key);
        }
        self.memo.highest = NONE;
        self.memo.anchor = None;
    }

    /// Ends the innermost search that is watched: every choice beneath it was tried. `before` was read before it.
    pub fn end_watch(&mut self, before: Attributes) {
        self.note_reads();
        self.context.reads.clear();
        let read = self.reads.since;
        self.reads.since |= before;
        let Some(watch) = self.memo.watches.pop() else { return };
        let cut = Truncated {
            cycles: self.truncated.cycles,
            ..watch.truncated
        };
        let is_same = self.truncated == cut && self.left_out == watch.left_out;
        // What came back to something of this search's own would do so anywhere.
        let is_whole = self.memo.highest >= watch.first;
        if is_whole {
            self.memo.highest = NONE;
        }
        let has_failed = match self.settings.aim {
            Aim::First | Aim::Best => true,
            Aim::All(_) => watch.plans == self.n_derivations,
        };
        // Of what else the cost of the actions to come depends on, the key knows nothing.
        if is_whole && has_failed && is_same && self.objective.is_none() {
            let cost = match self.settings.aim {
                Aim::Best => watch.cost,
                Aim::First | Aim::All(_) => f64::NEG_INFINITY,
            };
            let returns = watch.returns;
            self.memo.known.insert(watch.key, Known::Failed { cost, returns, read });
        } else {
            self.memo.known.remove(&watch.key);
        }
    }

    /// Returns the fingerprint of the symbolic state and all that is to be done, with `node` first.
    fn print_of_all(&mut self, state: Print, node: Option<u32>) -> Print {
        let (prepared, tree) = (self.prepared, &self.tree);
        let of_frame = |cell: &Cell| {
            let frame = tree.nodes[cell.node as usize].frame as usize;
            let live = &prepared.order(cell.order).live;
            let print = Print::of(u64::from(cell.order));
            live.iter()
                .map(|var| &tree.values[frame + var.index()])
                .fold(print, |print, value: &Value| print.value(value))
        };
        let mut print = self.agenda.print(prepared, &of_frame).print(state);
        if let Some(node) = node {
            print = self.print_of_task(print, node);
            print = self.agenda.print_of_join(print, node);
        }
        print
    }
}
