//! Facts whose meaning the domain gives itself: `fact isClose(any A, any B) { distance(A, B) < 0.5; }`.
//!
//! A fact is about the world, so it may ask geometry and other facts and read what never changes, but no dynamic attribute:
//! else nobody could say when the attributes that are read from it change. Recursion is an error.

use indexmap::{IndexMap, IndexSet};

use super::expr::{Scope, Walk};
use super::functions::Functions;
use super::names::{Asks, Names};
use super::{PRELUDE, problems};
use crate::diag::Problems;
use crate::ir::{self, Expr, Test};
use crate::syntax::ast::{self, Item};

/// Facts that ask one another, each inside of the one before: asked by recursion. HEURISTIC: far above real domains.
const MAX_FACTS_DEEP: usize = 32;
/// Facts asked in all to answer one, those within them included. HEURISTIC: 32 facts, each asking the one before twice, would
/// never be answered.
const MAX_FACTS_ASKED: usize = 10_000;

/// Compiles the bodies of all facts of the domain.
pub(super) fn compile(items: &[&Item], names: &mut Names, functions: &Functions, problems: &mut Problems) {
    let mut compiled: IndexMap<usize, &ast::Fact> = IndexMap::new();
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
            compiled.insert(id.index(), fact);
        }
    }
    // After the functions are written out, so that a circle through one is found, too.
    let asked: Vec<Vec<usize>> = names.domain.facts.iter().map(asked).collect();
    let once = |all: &Vec<usize>| all.iter().copied().collect::<IndexSet<_>>().into_iter().collect();
    let after: Vec<Vec<usize>> = asked.iter().map(once).collect();
    let sorted = super::order::sort(&after);
    for declared in sorted.circles.iter().flatten().filter_map(|i| compiled.get(i)) {
        problems.push(problems::recursive_fact(&declared.name));
    }
    let mut depths = vec![0; after.len()];
    let mut sizes = vec![1_usize; after.len()];
    for i in sorted.order {
        let within = asked.get(i).into_iter().flatten().filter_map(|b| sizes.get(*b));
        let mut size = within.fold(1, |sum: usize, s| sum.saturating_add(*s));
        if size > MAX_FACTS_ASKED {
            let fact = compiled.get(&i);
            problems
                .0
                .extend(fact.map(|f| problems::fact_too_large(&f.name, MAX_FACTS_ASKED)));
            // As below: the next one is reported when it is as large again.
            size = 1;
        }
        if let Some(of) = sizes.get_mut(i) {
            *of = size;
        }
        let below = after.get(i).into_iter().flatten().filter_map(|b| depths.get(*b));
        let mut depth = below.max().map_or(1, |d| d + 1);
        if depth > MAX_FACTS_DEEP {
            problems.0.extend(
                compiled
                    .get(&i)
                    .map(|f| problems::too_many_facts(&f.name, MAX_FACTS_DEEP)),
            );
            // The next one is reported when it has as many below it again.
            depth = 1;
        }
        if let Some(of) = depths.get_mut(i) {
            *of = depth;
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

/// Returns the positions of the facts that its body asks, each as often as it does.
fn asked(fact: &ir::Fact) -> Vec<usize> {
    let mut out = Vec::new();
    fact.body.any(&mut |expr| {
        if let Expr::Fact { fact, .. } = expr {
            out.push(fact.index());
        }
        false
    });
    out
}
