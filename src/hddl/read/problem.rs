//! The problem: objects, initial facts, the task network to begin with, the goal.

use indexmap::IndexSet;

use super::super::ast::{Fact, Formula, Name, Scope, Term, Value};
use super::super::problems;
use super::super::tree::Tree;
use super::formulas::number;
use super::{Reader, Section, key};
use crate::source::Span;

const SECTIONS: &[&str] = &[
    ":domain",
    ":objects",
    ":init",
    ":htn",
    ":goal",
    ":metric",
    ":requirements",
];

const CLAUSES: &[&str] = &[
    ":parameters",
    ":ordered-subtasks",
    ":ordered-tasks",
    ":subtasks",
    ":tasks",
    ":ordering",
    ":constraints",
];

impl Reader<'_> {
    pub(super) fn objects(&mut self, sections: &[Section<'_, '_>]) {
        let objects = sections.iter().filter(|(head, ..)| head.is(":objects"));
        objects.for_each(|(_, rest, _)| self.read_objects(rest));
    }

    /// Reads all but the objects.
    pub(super) fn problem(&mut self, sections: &[Section<'_, '_>], domain: &Name, place: Span) {
        let mut seen: Vec<String> = Vec::new();
        let mut has_task = false;
        for (head, rest, span) in sections {
            let word = head.word().unwrap_or_default();
            if seen.contains(&key(word)) {
                self.problems.push(problems::twice(&format!("`{word}`"), *span));
            }
            seen.push(key(word));
            match (key(word).as_str(), rest) {
                (":domain", [name]) if name.word().is_some() => {
                    let found = name.word().unwrap_or_default();
                    if key(found) != key(&domain.text) {
                        let problem = problems::wrong_domain(found, &domain.text, name.span, domain.span);
                        self.problems.push(problem);
                    }
                }
                (":domain", _) => self.problems.push(problems::expected("`(:domain NAME)`", *span)),
                (":objects" | ":requirements", _) => {}
                (":init", facts) => self.read_init(facts),
                (":htn", rest) => {
                    has_task = true;
                    self.read_start(rest);
                }
                (":goal", [goal]) => {
                    let mut scope = Scope::default();
                    self.pair.goal = self.formula(goal, &mut scope, &mut Vec::new());
                    self.pair.goal_scope = scope;
                }
                (":goal", _) => self
                    .problems
                    .push(problems::wrong_count(":goal", 1, rest.len(), head.span)),
                (":metric", [direction, what]) => {
                    let is_total = what
                        .headed()
                        .is_some_and(|(f, args)| f.is("total-cost") && args.is_empty());
                    if !direction.is("minimize") || !is_total {
                        let help = "only `(:metric minimize (total-cost))` is";
                        self.problems
                            .push(problems::not_supported("this metric is", *span, help));
                    }
                }
                (":metric", _) => self
                    .problems
                    .push(problems::wrong_count(":metric", 2, rest.len(), head.span)),
                (":constraints", _) => {
                    let help = "test the conditions in the actions";
                    let problem = problems::not_supported("`:constraints` of a problem is", head.span, help);
                    self.problems.push(problem);
                }
                _ => {
                    let known = SECTIONS.iter().copied();
                    self.problems
                        .push(problems::unknown_part(word, "a problem", head.span, known));
                }
            }
        }
        if !has_task {
            self.problems.push(problems::no_task(place));
        }
    }

    fn read_start(&mut self, rest: &[Tree<'_>]) {
        let clauses = self.clauses(rest, "the initial task network", CLAUSES, &[]);
        let (mut scope, mut visible) = (Scope::default(), Vec::new());
        let params = clauses.iter().find(|(part, ..)| *part == ":parameters");
        if let Some(params) = params.and_then(|(.., value)| value.list()) {
            self.variables(params, &mut scope, &mut visible);
        }
        self.pair.start = self.network(&clauses, &mut scope, &mut visible);
        self.pair.start_scope = scope;
    }

    fn read_init(&mut self, facts: &[Tree<'_>]) {
        let (scope, visible) = (Scope::default(), Vec::new());
        let mut found: IndexSet<Fact> = IndexSet::new();
        for tree in facts {
            let Some((head, rest)) = tree.headed() else {
                self.problems
                    .push(problems::expected("a fact such as `(at truck home)`", tree.span));
                continue;
            };
            match rest {
                // What is not said does not hold.
                [inner] if head.is("not") => {
                    self.atom(inner, &scope, &visible);
                }
                [what, value] if head.is("=") => self.read_value(what, value, tree),
                [time, timed]
                    if head.is("at") && timed.list().is_some() && time.word().is_some_and(|w| number(w).is_some()) =>
                {
                    let help = "facts hold from the start";
                    self.problems
                        .push(problems::not_supported("a fact that begins later is", tree.span, help));
                }
                _ => {
                    if let Some(Formula::Atom(predicate, args)) = self.atom(tree, &scope, &visible) {
                        let args = objects(&args);
                        found.insert(Fact { predicate, args });
                    }
                }
            }
        }
        self.pair.facts = found.into_iter().collect();
    }

    /// Reads `(= (length a b) 3)`.
    fn read_value(&mut self, what: &Tree<'_>, value: &Tree<'_>, tree: &Tree<'_>) {
        let Some((head, rest)) = what.headed() else {
            self.problems
                .push(problems::expected("a value such as `(= (length a b) 3)`", tree.span));
            return;
        };
        let name = head.word().unwrap_or_default();
        let Some((function, args)) = self.function(name, head, rest, &Scope::default(), &Vec::new()) else {
            return;
        };
        match value.word().and_then(number) {
            Some(number) if number >= 0.0 => self.pair.values.push(Value {
                function,
                args: objects(&args),
                number,
            }),
            _ => self
                .problems
                .push(problems::expected("a number, 0 or more", value.span)),
        }
    }
}

/// Returns the objects among terms without variables.
fn objects(terms: &[Term]) -> Vec<usize> {
    let object = |term: &Term| match term {
        Term::Object(object) => Some(*object),
        Term::Var(_) => None,
    };
    terms.iter().filter_map(object).collect()
}
