//! Actions.

use super::super::ast::{Action, Formula, Name, TaskRef};
use super::super::problems;
use super::super::tree::Tree;
use super::{Reader, key, name_of};
use crate::source::Span;

const CLAUSES: &[&str] = &[":parameters", ":precondition", ":effect"];
const NOT_SUPPORTED: &[&str] = &[":duration", ":condition", ":cost"];

impl Reader<'_> {
    /// Reads the name and the parameters of an action: what methods need to know of it.
    pub(super) fn read_header(&mut self, rest: &[Tree<'_>], span: Span) {
        let Some((name, rest)) = rest.split_first().filter(|(name, _)| name.word().is_some()) else {
            self.problems.push(problems::missing("name", "the action", span));
            return;
        };
        let clauses = self.clauses(rest, "an action", CLAUSES, NOT_SUPPORTED);
        let params = clauses.iter().find(|(part, ..)| *part == ":parameters");
        let params = params.and_then(|(.., value)| value.list()).unwrap_or_default();
        let (name, scope) = self.signature(name, params);
        self.declare_task(&name, TaskRef::Action(self.pair.actions.len()));
        self.pair.actions.push(Action {
            name,
            n_params: scope.0.len(),
            scope,
            precondition: Formula::default(),
            effects: Vec::new(),
            costs: Vec::new(),
        });
    }

    /// Reads precondition and effect of the next action; its header has been read.
    pub(super) fn read_action(&mut self, rest: &[Tree<'_>], next: &mut usize) {
        let Some((_, rest)) = rest.split_first().filter(|(name, _)| name.word().is_some()) else {
            return;
        };
        let action = *next;
        *next += 1;
        let mut scope = self.pair.actions[action].scope.clone();
        let names = scope.0.iter().enumerate();
        let mut visible = names.map(|(v, var)| (key(&var.name.text), v)).collect();
        // Its faults were said with the header.
        for (part, value) in parts(rest) {
            if part.is(":precondition") {
                self.pair.actions[action].precondition = self.formula(value, &mut scope, &mut visible);
            } else if part.is(":effect") {
                let (effects, costs) = self.effects(value, &mut scope, &mut visible);
                self.pair.has_costs |= !costs.is_empty();
                self.pair.actions[action].effects = effects;
                self.pair.actions[action].costs = costs;
            }
        }
        self.pair.actions[action].scope = scope;
    }

    /// Returns the name that the first part is.
    pub(super) fn named(&mut self, rest: &[Tree<'_>], of: &str, span: Span) -> Option<Name> {
        let name = rest
            .first()
            .filter(|name| name.word().is_some_and(|w| !w.starts_with(':')));
        if name.is_none() {
            self.problems.push(problems::missing("name", of, span));
        }
        name.map(name_of)
    }
}

/// Returns each keyword with the list behind it.
fn parts<'a, 't>(rest: &'a [Tree<'t>]) -> impl Iterator<Item = (&'a Tree<'t>, &'a Tree<'t>)> {
    rest.windows(2)
        .filter(|pair| pair[0].word().is_some() && pair[1].list().is_some())
        .map(|pair| (&pair[0], &pair[1]))
}
