//! Facts whose meaning the domain gives itself: `fact isClose(any A, any B) { distance(A, B) < 0.5; }`.
//!
//! A fact is about the world, so it may ask geometry and other facts and read what never changes, but no dynamic attribute:
//! else nobody could say when the attributes that are read from it change. Recursion is an error.

use super::expr::{Scope, Walk};
use super::functions::Functions;
use super::names::{Asks, Names};
use super::{PRELUDE, problems};
use crate::diag::Problems;
use crate::ir::{self, Expr, Test};
use crate::syntax::ast::{self, Item};

/// Compiles the bodies of all facts of the domain.
pub(super) fn compile(items: &[&Item], names: &mut Names, functions: &Functions, problems: &mut Problems) {
    let mut compiled: Vec<&ast::Fact> = Vec::new();
    for item in items {
        let Item::Fact(fact) = item else { continue };
        let Some(body) = fact.body.as_ref().filter(|_| fact.span.file != PRELUDE) else {
            continue;
        };
        let Some(question) = names.facts.get(&fact.name.text) else {
            continue;
        };
        // A second one of the same name has been refused.
        let Asks::Domain(id) = question.asks else { continue };
        if question.signature.span != fact.name.span {
            continue;
        }
        let kinds = question.signature.params.clone();
        let mut walk = Walk {
            names: &mut *names,
            functions,
            problems: &mut *problems,
            scope: Scope::of_params(&fact.params, &kinds),
            wanted: "bool",
        };
        let mut tests = Vec::new();
        for test in body {
            let compiled = walk.tests(std::slice::from_ref(test));
            if let Some(culprit) = reads_state(&compiled, &walk.names.domain) {
                let problem = problems::state_in_fact(&fact.name, &culprit, test.span);
                walk.problems.push(problem);
            }
            tests.push(compiled);
        }
        let n_vars = walk.scope.n_vars as usize;
        if let Some(out) = names.domain.facts.get_mut(id.index()) {
            out.body = Test::And(tests);
            out.n_vars = n_vars;
            compiled.push(fact);
        }
    }
    // After the functions are written out, so that a circle through one is found, too.
    let after: Vec<Vec<usize>> = names.domain.facts.iter().map(asked).collect();
    for position in super::order::sort(&after).circles.iter().flatten() {
        if let Some(fact) = names.domain.facts.get(*position)
            && let Some(declared) = compiled.iter().find(|f| f.name.text == fact.name)
        {
            problems.push(problems::recursive_fact(&declared.name));
        }
    }
}

/// Returns what the test reads of the symbolic state or of an action, as the language writes it.
fn reads_state(test: &Test, domain: &ir::Domain) -> Option<String> {
    let mut culprit = None;
    test.any(&mut |expr| {
        culprit = match expr {
            Expr::Attribute { attribute, .. } => {
                let declared = domain.attributes.get(attribute.index());
                declared.filter(|a| !a.is_static).map(|a| a.name.clone())
            }
            Expr::GeometricCost => Some("GetGRPCost()".into()),
            Expr::GeometricDuration => Some("GetGRPDuration()".into()),
            _ => None,
        };
        culprit.is_some()
    });
    culprit
}

/// Returns the positions of the facts that its body asks.
fn asked(fact: &ir::Fact) -> Vec<usize> {
    let mut out = Vec::new();
    fact.body.any(&mut |expr| {
        if let Expr::Fact { fact, .. } = expr
            && !out.contains(&fact.index())
        {
            out.push(fact.index());
        }
        false
    });
    out
}
