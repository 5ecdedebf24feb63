//! Counts why branches fail. A reason is put into words once: the same one again only adds to its count.

use rustc_hash::FxHashMap;

use super::explain::failed_literal;
use super::fold::{Folded, literals};
use super::hash::Print;
use super::outcome::{NONE, Step, Tree};
use super::search::{Flow, Search};
use crate::ir::{ActionId, Binder, Domain, TaskId, Test, Value, Var};
use crate::plan::{Refusal, WhyNot};

/// Why branches failed so far.
#[derive(Debug, Default)]
pub(super) struct Reasons {
    why: WhyNot,
    /// The number of the reason of each refusal met, by fingerprint.
    known: FxHashMap<u128, Option<usize>>,
    /// The longest branch.
    deepest: Vec<(ActionId, Box<[Value]>)>,
    /// How many of its steps are also the first ones of the branch at hand.
    common: usize,
    /// The reason of the last refusal, since the search went back last; and that of the longest branch.
    last: Option<usize>,
    stuck: Option<usize>,
}

/// HEURISTIC: refusals told apart; those after them are counted without words.
const MAX_KNOWN: usize = 100_000;

impl Reasons {
    /// Counts a refusal again, if it was met before.
    fn is_known(&mut self, print: Print) -> bool {
        match self.known.get(&print.key()) {
            Some(number) => {
                self.last = *number;
                self.why.add_again(*number);
            }
            None if self.known.len() >= MAX_KNOWN => self.why.add_again(None),
            None => return false,
        }
        true
    }

    fn add(&mut self, print: Print, refusal: &Refusal) {
        let number = self.why.add(refusal);
        self.last = number;
        self.known.insert(print.key(), number);
    }

    /// Counts a refusal of geometry, which says something new each time.
    pub fn add_geometry(&mut self, refusal: &Refusal) {
        self.last = self.why.add(refusal);
    }

    /// Notes that only the first `n` steps of the branch are left.
    pub fn shortened(&mut self, n: usize) {
        self.common = self.common.min(n);
        self.last = None;
    }

    /// Remembers the branch at hand if none was longer. Called where a branch ends.
    pub fn note_deepest(&mut self, domain: &Domain, steps: &[Step], tree: &Tree) {
        if steps.len() <= self.deepest.len() {
            // Of a search without any action, what failed first.
            if self.deepest.is_empty() {
                self.stuck = self.stuck.or(self.last);
            }
            return;
        }
        self.stuck = self.last;
        self.deepest.truncate(self.common);
        for step in &steps[self.common..] {
            self.deepest
                .push((step.action, tree.args(domain, step.node).to_vec().into()));
        }
        self.common = steps.len();
    }

    /// Returns all reasons, with the longest branch in words.
    pub fn finish(mut self, domain: &Domain) -> WhyNot {
        let show = |(action, args): &(ActionId, Box<[Value]>)| {
            let args: Vec<String> = args.iter().map(|v| domain.show(v)).collect();
            format!("{}({})", domain.actions[action.index()].name, args.join(", "))
        };
        self.why.deepest = self.deepest.iter().map(show).collect();
        self.why.stuck = self.stuck.and_then(|n| self.why.sentence(n)).map(str::to_owned);
        self.why
    }
}

/// Which refusal a fingerprint is of.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Precondition,
    NoBinding,
    NullArgument,
    Number,
    TooCostly,
    TooDeep,
    Cycle,
    LookAhead,
    NotKept,
}

impl Search<'_> {
    /// Counts a refusal of a task with its arguments, put into words if it was not met before. `more` is what else tells
    /// it from others; with no node it tells all.
    pub fn refuse(&mut self, kind: Kind, node: u32, more: &[u64], words: impl FnOnce(&Self) -> Refusal) -> Flow {
        let of = if node == NONE { self.last_node() } else { node };
        self.refuse_in(of, kind, node, more, words)
    }

    /// As [`Search::refuse`], with words that take questions to the state.
    pub fn refuse_asking(
        &mut self,
        kind: Kind,
        node: u32,
        more: &[u64],
        words: impl FnOnce(&mut Self) -> Refusal,
    ) -> Flow {
        let print = self.print_of_task(Print::of(kind as u64), node);
        let print = more.iter().fold(print, |print, x| print.number(*x));
        self.count(node, print, words);
        Flow::Back
    }

    /// As [`Search::refuse`], where the branch ends at the task `of`.
    pub fn refuse_in(
        &mut self,
        of: u32,
        kind: Kind,
        node: u32,
        more: &[u64],
        words: impl FnOnce(&Self) -> Refusal,
    ) -> Flow {
        let mut print = Print::of(kind as u64);
        if node != NONE {
            print = self.print_of_task(print, node);
        }
        let print = more.iter().fold(print, |print, x| print.number(*x));
        self.count(of, print, |search| words(search));
        Flow::Back
    }

    /// Counts a refusal and tells it to the observer; `words` is asked if one of the two has not met it.
    fn count(&mut self, of: u32, print: Print, words: impl FnOnce(&mut Self) -> Refusal) {
        let (is_known, is_wanted) = (self.reasons.is_known(print), self.wants_words(print.key()));
        let n_reads = self.context.reads.len();
        let refusal = (!is_known || is_wanted).then(|| words(self));
        // What is looked at for the words alone has decided nothing.
        self.context.reads.truncate(n_reads);
        if let Some(refusal) = &refusal
            && !is_known
        {
            self.reasons.add(print, refusal);
        }
        self.tell_refused(of, print.key(), refusal.as_ref().filter(|_| is_wanted));
    }

    /// Adds a task with its arguments to a fingerprint.
    pub fn print_of_task(&self, print: Print, node: u32) -> Print {
        let task = match self.tree.task(node) {
            TaskId::Action(a) => u64::from(a.0) << 1,
            TaskId::Method(m) => u64::from(m.0) << 1 | 1,
        };
        let args = self.tree.args(self.context.domain, node);
        args.iter().fold(print.number(task), Print::value)
    }

    /// Says whether test number `which` of a task holds, whose frame begins at `from`. If not, the literal that fails is
    /// counted as the reason.
    pub fn passes(&mut self, (test, folded): (&Test, &Folded), node: u32, from: usize, which: u64) -> bool {
        for (i, part) in literals(test).iter().enumerate() {
            let n_reads = self.context.reads.len();
            if self.context.holds_part(folded, i, part, &mut self.tree.values[from..]) {
                continue;
            }
            // The same task with the same values met is the same reason.
            let mut print = self.print_of_task(Print::of(Kind::Precondition as u64), node);
            print = print.number(which).number(i as u64);
            for slot in &self.context.reads[n_reads..] {
                print = print.number(u64::from(slot.0));
                print = self.context.state.get(*slot).map_or(print, |value| print.value(value));
            }
            self.count(node, print, |search| {
                let task = search.show(node);
                let mut names = search.names(node, Some(which as usize));
                let frame = &mut search.tree.values[from..];
                let failed = failed_literal(&mut search.context, part, frame, &mut names);
                Refusal::Precondition {
                    task,
                    literal: failed.literal,
                    met: failed.met,
                    rule: failed.rule,
                }
            });
            return false;
        }
        true
    }

    /// Returns the variables of a task with their names: parameters, and what a decomposition binds.
    pub fn names(&self, node: u32, decomposition: Option<usize>) -> Vec<(Var, String)> {
        let (domain, task) = (self.context.domain, self.tree.task(node));
        let params = domain.task_params(task).iter().map(|p| p.name.clone());
        let mut names: Vec<(Var, String)> = params.enumerate().map(|(i, name)| (Var(i as u32), name)).collect();
        if let (TaskId::Method(m), Some(which)) = (task, decomposition)
            && let Some(decomposition) = domain.methods[m.index()].decompositions.get(which)
        {
            names.extend(decomposition.binders.iter().map(|b| match b {
                Binder::Select { var, var_name, .. } | Binder::Let { var, var_name, .. } => (*var, var_name.clone()),
            }));
        }
        names
    }

    pub fn show(&self, node: u32) -> String {
        self.tree.show(self.context.domain, node)
    }
}
