//! What is right and yet hardly meant: one lint for each file, each with its own wording.
//!
//! Lints look at a domain without errors, as written and as compiled. A lint that can't be sure says nothing: a file that
//! was written for LAAS's HATP must not drown in advice. `diag::levels` decides which warnings the user gets.

mod attributes;
mod contradicts_goal;
mod endless_recursion;
mod never_applies;
mod no_agent;
mod read;
mod select_follows;
mod unreached_task;
mod unused;
mod walk;

use super::PRELUDE;
use crate::diag::Problems;
use crate::ir::{self, Test};
use crate::source::{FileId, Span};
use crate::syntax::ast::{self, Item};

/// A domain without errors: what was written beside what it became.
pub(super) struct Linted<'a> {
    pub items: &'a [&'a Item],
    pub domain: &'a ir::Domain,
    /// Where each attribute is declared.
    pub attribute_spans: &'a [Span],
    pub actions: Vec<(&'a ast::Action, &'a ir::Action)>,
    pub methods: Vec<(&'a ast::Method, &'a ir::Method)>,
    /// Whether the world is known: then every entity and every initial value is.
    pub has_world: bool,
    /// The tasks to plan, if any are named.
    pub tasks: &'a [String],
    /// The file that the user named; what it imports may be there for others, too.
    pub main: Option<FileId>,
}

impl<'a> Linted<'a> {
    /// Joins what was written with what it became; `domain` must be compiled from `items` without errors.
    pub(super) fn new(items: &'a [&'a Item], domain: &'a ir::Domain, attribute_spans: &'a [Span]) -> Self {
        let actions = items.iter().filter_map(|item| match item {
            Item::Action(action) => Some(action),
            _ => None,
        });
        let methods = items.iter().filter_map(|item| match item {
            Item::Method(method) => Some(method),
            _ => None,
        });
        Linted {
            items,
            domain,
            attribute_spans,
            actions: actions.zip(&domain.actions).collect(),
            methods: methods.zip(&domain.methods).collect(),
            has_world: false,
            tasks: &[],
            main: None,
        }
    }
}

/// Runs every lint; those that are off by default, too.
pub(super) fn run(linted: &Linted<'_>) -> Problems {
    let mut problems = Problems::default();
    no_agent::lint(linted, &mut problems);
    unused::lint(linted, &mut problems);
    unreached_task::lint(linted, &mut problems);
    never_applies::lint(linted, &mut problems);
    contradicts_goal::lint(linted, &mut problems);
    endless_recursion::lint(linted, &mut problems);
    select_follows::lint(linted, &mut problems);
    attributes::lint(linted, &mut problems);
    // The prelude is no file of the user's.
    let of_user = |span: Span| span.file != PRELUDE;
    problems
        .0
        .retain(|p| p.primary.as_ref().is_none_or(|l| of_user(l.span)));
    problems
}

/// Returns the parts of a conjunction with their places; `test` is what `written` became.
fn conjuncts<'a>(written: &[ast::Test], test: &'a Test) -> Vec<(Span, &'a Test)> {
    match (written, test) {
        ([only], test) => vec![(only.span, test)],
        (several, Test::And(tests)) => several.iter().map(|t| t.span).zip(tests).collect(),
        _ => Vec::new(),
    }
}
