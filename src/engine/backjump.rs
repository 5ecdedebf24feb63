//! Goes back over choices that had no part in a failure (decision 36).
//!
//! Where a task with choices left inside it is done, a *mark* is set, and from there on the attributes that are read are
//! noted. If all that comes after has failed, and has read nothing that the task may change (`effects`), every other way of
//! doing the task ends in the same failure, and all choices inside it are dropped at once (conflict-directed backjumping:
//! Prosser, Computational Intelligence 9, 1993, doi:10.1111/j.1467-8640.1993.tb00310.x; here over tasks and attributes instead
//! of variables). What has been read since the mark is then why the search of the task with all after it has failed; what
//! the task itself has read is no part of it.
//!
//! Why no plan is lost. In blocks, what comes after a task that is done depends on three things: on the frames of the tasks that
//! wait, on the state, and on the path. The frames are bound before the task is taken up. The states in which two ways of
//! doing it end are the same but for attributes that it may change. So by induction over the search of what comes after, as
//! long as no such attribute is read, the same tests give the same answers and the same values are bound. Where the path
//! decides (a task above itself, a state met again, the depth, another option too many), and where there is a plan, everything
//! counts as read, and nothing is jumped. The least that this says of another way: it fails, too, or is cut by its path besides.
//!
//! Noted are reads since the topmost mark or watch (`memo`) on the stack. When that is taken off, they belong to what is
//! below it. A search that is known to fail keeps what it has read, and whoever meets it again reads the same.
//!
//! In blocks alone, and not where attributes are read from geometry or believed, actions are projected or kept, or the best
//! plan is wanted: its bounds look at costs.

use super::effects::{Attributes, bit};
use super::outcome::{Aim, Cuts, NONE, Statistics};
use super::search::{Choice, Search};

/// Everything: the path, too.
pub(super) const ALL: Attributes = Attributes::MAX;

/// HEURISTIC: choices taken back before reads are noted, and how many tasks are taken up for each of them at most.
const PATIENCE: u64 = 50;
const RARE: u64 = 64;
/// HEURISTIC: entries of the stack looked at for the last choice.
const NEAR: usize = 64;

/// What a search has read.
#[derive(Debug)]
pub(super) struct Reads {
    /// Whether the search may jump at all.
    may_jump: bool,
    /// Whether reads are noted. Before, everything counts as read.
    is_awake: bool,
    /// Since the topmost mark or watch.
    pub since: Attributes,
}

impl Default for Reads {
    fn default() -> Self {
        Reads {
            may_jump: false,
            is_awake: false,
            since: ALL,
        }
    }
}

impl Reads {
    /// Counts everything as read.
    pub fn path(&mut self) {
        self.since = ALL;
    }
}

impl Search<'_> {
    /// Looks whether the search may jump. Called once, before it begins.
    pub fn begin_reads(&mut self) {
        let domain = self.context.domain;
        self.reads.may_jump = self.settings.cuts != Cuts::Off
            && !self.settings.interleave
            && self.settings.aim != Aim::Best
            && self.kept.is_empty()
            && self.shared.is_empty()
            && !self.prepared.projects
            && domain.attributes.iter().all(|a| a.believer.is_none());
    }

    /// Wakes up once a search has shown that it needs it: a plan that comes straight away costs nothing.
    fn may_note(&mut self) -> bool {
        if self.reads.is_awake || !self.reads.may_jump {
            return self.reads.is_awake;
        }
        let Statistics {
            backtracks, expansions, ..
        } = self.statistics;
        self.reads.is_awake = match self.settings.cuts {
            Cuts::Off => false,
            Cuts::On => backtracks >= PATIENCE && backtracks >= expansions / RARE,
            Cuts::Always => true,
        };
        self.reads.is_awake
    }

    /// Notes what was read since somebody last cleared it.
    #[inline]
    pub fn note_reads(&mut self) {
        if !self.reads.is_awake {
            return;
        }
        let domain = self.context.domain;
        for slot in &self.context.reads {
            self.reads.since |= bit(domain.slots[slot.index()].attribute);
        }
    }

    /// Begins to note anew, for a mark or a watch that is put on the stack next, whose point has been made.
    pub fn begin_noting(&mut self) {
        if self.reads.is_awake {
            self.reads.since = 0;
        }
    }

    /// Marks the end of a task with choices left inside it. Called where the next task is about to be taken up.
    pub fn mark_done(&mut self) {
        if !self.may_note() {
            return;
        }
        let mut near = self.choices.iter().rev().take(NEAR);
        let last = near.find(|(_, choice)| !matches!(choice, Choice::Watch));
        // Where the last entry is a mark, nothing was left open since.
        let Some(mut node) = last.and_then(|(_, choice)| self.owner(choice)) else {
            return;
        };
        let at_work = self.agenda.cell(self.agenda.head).node;
        // INVARIANT: a node stands before all below it, and what is not done has nodes from that of the first cell on.
        if node <= at_work {
            return;
        }
        // The largest task that is done by now: those that wait belong to the first cell or to cells behind it.
        loop {
            let parent = self.tree.nodes[node as usize].parent;
            if parent == NONE || parent <= at_work {
                break;
            }
            node = parent;
        }
        self.note_reads();
        self.context.reads.clear();
        let point = self.point();
        self.choices.push((point, Choice::Done { node }));
        self.begin_noting();
    }

    /// Returns the node to which a choice belongs; of a mark or a watch, none.
    fn owner(&self, choice: &Choice) -> Option<u32> {
        match choice {
            Choice::Decomposition { node, .. }
            | Choice::Decompositions { node, .. }
            | Choice::Binding { node, .. }
            | Choice::Sorted { node, .. }
            | Choice::Alternative { node, .. } => Some(*node),
            Choice::Order { cell, .. } => Some(self.agenda.cell(*cell).node),
            Choice::Orders { left } => left.last().map(|(cell, _)| self.agenda.cell(*cell).node),
            Choice::Watch | Choice::Done { .. } => None,
        }
    }

    /// Ends the search after a task that was done, whose mark has been taken off: drops the choices inside the task if they
    /// had no part in its failure. `before` was read before the mark.
    pub fn end_done(&mut self, node: u32, before: Attributes) {
        self.note_reads();
        self.context.reads.clear();
        let why = self.reads.since;
        if why == ALL || self.look_ahead.changes.of(self.tree.task(node)) & why != 0 {
            self.reads.since |= before;
            return;
        }
        let mut before = before;
        let mut n_dropped = 0;
        while let Some((point, choice)) = self.choices.last() {
            let is_inside = match choice {
                // What is inside the task was put there after it was taken up.
                Choice::Watch | Choice::Done { .. } => point.n_nodes() > node,
                choice => self.owner(choice).is_some_and(|owner| owner >= node),
            };
            if !is_inside {
                break;
            }
            before = point.read;
            if let Some((_, Choice::Watch)) = self.choices.pop() {
                // What it watches has failed, for the same reason.
                self.reads.since = why;
                self.end_watch(before);
            } else {
                n_dropped += 1;
            }
        }
        self.statistics.jumps += u64::from(n_dropped > 0);
        self.reads.since = before | why;
    }
}
