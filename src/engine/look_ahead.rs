//! Leaves a branch in which a task that is still to be done can't be done any more.
//!
//! Looked at are the tasks on the agenda, with their arguments as far as they are bound: what one needs (`needs`), is false
//! now, and can't be changed by anything that may come before it (`effects`), ends the branch at once, and not only when
//! the task is reached. In blocks what comes before a task are the cells above its own, and of its own the subtasks that
//! do not wait for it; interleaved, all other cells. No plan is lost.
//!
//! Nothing is asked of geometry ahead of time: what has not been read counts as met. So does an argument whose value may
//! change before the task is reached.

use super::effects::{Attributes, Changes};
use super::explain::failed_literal;
use super::hash::Print;
use super::needs::{Need, Waiting, waiting};
use super::outcome::{Cuts, NONE, Statistics};
use super::search::{Flow, Search};
use crate::ir::{Domain, Test, Value};
use crate::plan::Refusal;

/// What is known of waiting tasks.
#[derive(Debug)]
pub(super) struct LookAhead {
    /// By decomposition, numbered as in `prepare`.
    waiting: Vec<Waiting>,
    /// All that some need looks at.
    looked_at: Attributes,
    pub changes: Changes,
}

/// How often a search has looked ahead, and to what end.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Looks {
    asked: u64,
    ended: u64,
    /// Steps since the last look.
    waited: u64,
}

/// HEURISTIC: choices taken back before a search looks ahead, and how many tasks are taken up for each of them at most.
const PATIENCE: u64 = 50;
const RARE: u64 = 64;
/// HEURISTIC: looks after which it has to have ended one branch in so many; else only one step in so many is looked at.
const TRIAL: u64 = 1000;
const WORTH: u64 = 32;
/// HEURISTIC: cells looked at.
const MOST_CELLS: usize = 64;

impl LookAhead {
    pub fn new(domain: &Domain, changes: Changes) -> Self {
        let waiting = waiting(domain, &changes);
        let needs = waiting.iter().flat_map(|w| w.needs.iter().flatten());
        let looked_at = needs.fold(0, |all, need| all | need.looks_at());
        LookAhead {
            waiting,
            looked_at,
            changes,
        }
    }
}

/// What can't be met.
struct Unmet {
    cell: u32,
    subtask: usize,
    frame: Vec<Value>,
    literal: Test,
}

impl Search<'_> {
    fn looks_ahead(&mut self) -> bool {
        let Statistics {
            backtracks, expansions, ..
        } = self.statistics;
        let looks = &mut self.looks;
        match self.settings.cuts {
            Cuts::Off => return false,
            Cuts::Always => return true,
            Cuts::On if backtracks < PATIENCE || backtracks < expansions / RARE => return false,
            Cuts::On => {}
        }
        looks.waited += 1;
        if looks.asked > TRIAL && looks.ended * WORTH < looks.asked && looks.waited < WORTH {
            return false;
        }
        looks.waited = 0;
        true
    }

    /// Refuses the branch if a task on the agenda can't be done any more.
    pub fn refuse_dead_end(&mut self) -> Option<Flow> {
        if !self.looks_ahead() {
            return None;
        }
        self.looks.asked += 1;
        let n_reads = self.context.reads.len();
        self.context.is_late = true;
        let unmet = self.unmet();
        let flow = unmet.map(|unmet| self.refuse_unmet(unmet));
        self.context.is_late = false;
        self.context.missed.clear();
        self.note_reads();
        self.context.reads.truncate(n_reads);
        flow
    }

    fn unmet(&mut self) -> Option<Unmet> {
        let look_ahead = self.look_ahead;
        let mut cells = Vec::new();
        let mut at = self.agenda.head;
        while at != NONE {
            if cells.len() >= MOST_CELLS {
                // Interleaved, any cell may come first.
                if self.settings.interleave {
                    return None;
                }
                break;
            }
            let cell = self.agenda.cell(at);
            // A cell with too many subtasks may change what it likes.
            let left = self.agenda.left(self.prepared, at);
            let waiting = &look_ahead.waiting[cell.order as usize];
            let of_left = waiting.changes.iter().enumerate().filter(|(i, _)| match left {
                Some(left) => left >> i & 1 == 1,
                None => true,
            });
            let changes = of_left.fold(0, |all, (_, c)| all | c);
            cells.push((at, left, changes));
            at = cell.next;
        }
        let mut above = 0;
        for (i, (cell, left, changes)) in cells.iter().enumerate() {
            if self.settings.interleave {
                let others = cells.iter().enumerate().filter(|(j, _)| *j != i);
                above = others.fold(0, |all, (_, (_, _, c))| all | c);
            }
            if above & look_ahead.looked_at == look_ahead.looked_at {
                if self.settings.interleave {
                    continue;
                }
                return None;
            }
            if let Some(left) = left
                && let Some(unmet) = self.unmet_of(*cell, *left, above)
            {
                return Some(unmet);
            }
            above |= changes;
        }
        None
    }

    /// Looks at the subtasks of one cell that are left, where `above` may be changed before by others.
    fn unmet_of(&mut self, cell: u32, left: u64, above: Attributes) -> Option<Unmet> {
        let node = self.agenda.cell(cell).node;
        let waiting = &self.look_ahead.waiting[self.agenda.cell(cell).order as usize];
        let mut frame = Vec::new();
        for (j, need) in waiting.needs.iter().enumerate() {
            let Some(need) = need.as_ref().filter(|_| left >> j & 1 == 1) else {
                continue;
            };
            let before = left & !waiting.later[j] & !(1 << j);
            let before = waiting.changes.iter().enumerate().filter(|(i, _)| before >> i & 1 == 1);
            let changed = before.fold(above, |all, (_, c)| all | c);
            let looks_at = need.looks_at();
            if changed & looks_at == looks_at && looks_at != 0 {
                continue;
            }
            if frame.is_empty() {
                let from = self.tree.nodes[node as usize].frame as usize;
                let task = self.tree.task(node);
                let to = from + self.n_vars_of(task);
                frame.extend_from_slice(self.tree.values.get(from..to)?);
                frame.resize(waiting.n_vars.max(frame.len()), Value::Null);
            }
            if let Some(literal) = self.missing(need, changed, &mut frame) {
                return Some(Unmet {
                    cell,
                    subtask: j,
                    frame,
                    literal,
                });
            }
        }
        None
    }

    fn n_vars_of(&self, task: crate::ir::TaskId) -> usize {
        let domain = self.context.domain;
        match task {
            crate::ir::TaskId::Action(_) => domain.task_params(task).len(),
            crate::ir::TaskId::Method(m) => {
                let method = &domain.methods[m.index()];
                method.n_vars.max(method.params.len())
            }
        }
    }

    /// Returns a literal that keeps a need from being met, now and later, if there is one.
    fn missing(&mut self, need: &Need, changed: Attributes, frame: &mut [Value]) -> Option<Test> {
        match need {
            Need::Literal(_, looks_at) if looks_at & changed != 0 => None,
            Need::Literal(test, _) => {
                let holds = self.context.holds(test, frame);
                let is_known = self.context.missed.is_empty();
                self.context.missed.clear();
                (is_known && !holds).then(|| test.clone())
            }
            Need::All(parts) => parts.iter().find_map(|p| self.missing(p, changed, frame)),
            Need::Any(parts) => {
                let mut last = None;
                for part in parts {
                    last = Some(self.missing(part, changed, frame)?);
                }
                last
            }
        }
    }

    fn refuse_unmet(&mut self, unmet: Unmet) -> Flow {
        let Unmet {
            cell,
            subtask,
            mut frame,
            literal,
        } = unmet;
        self.looks.ended += 1;
        self.statistics.dead_ends += 1;
        let domain = self.context.domain;
        let node = self.agenda.cell(cell).node;
        let order = u64::from(self.agenda.cell(cell).order);
        // The same task with the same values met is the same reason.
        let n_reads = self.context.reads.len();
        let decomposition = self.tree.decomposition(node) as usize;
        let mut names = self.names(node, Some(decomposition));
        let failed = failed_literal(&mut self.context, &literal, &mut frame, &mut names);
        let mut print = Print::of(order).number(subtask as u64);
        for slot in &self.context.reads[n_reads..] {
            print = print.number(u64::from(slot.0));
            print = self.context.state.get(*slot).map_or(print, |value| print.value(value));
        }
        print = frame.iter().fold(print, Print::value);
        let (task, args) = self.subtask_of(node, subtask);
        let args: Vec<String> = args
            .iter()
            .map(|arg| {
                let value = self.context.value(arg, &mut frame);
                value.map_or_else(|| "?".to_owned(), |v| domain.show(&v))
            })
            .collect();
        let task = format!("{}({})", domain.task_name(task), args.join(", "));
        let key = print.key();
        self.refuse(
            super::refusals::Kind::LookAhead,
            NONE,
            &[key as u64, (key >> 64) as u64],
            |_| Refusal::LookAhead {
                task,
                literal: failed.literal,
                met: failed.met,
                rule: failed.rule,
            },
        )
    }
}
