//! What passes ask of formulas.

use super::ast::{Formula, PredicateId, Term, VarId};

/// Returns the parts of a conjunction.
pub(super) fn conjuncts(formula: &Formula) -> Vec<&Formula> {
    match formula {
        Formula::And(all) => all.iter().flat_map(conjuncts).collect(),
        other => vec![other],
    }
}

/// Returns the variables that a formula speaks of and does not bind, each once.
pub(super) fn free(formula: &Formula) -> Vec<VarId> {
    let mut found = Vec::new();
    let mut bound = Vec::new();
    visit(formula, &mut |part| match part {
        Formula::Forall(vars, _) | Formula::Exists(vars, _) => bound.extend_from_slice(vars),
        Formula::Atom(_, terms) => found.extend(terms.iter().filter_map(var)),
        Formula::Equal(one, other) => found.extend([one, other].into_iter().filter_map(var)),
        Formula::Is(term, _) => found.extend(var(term)),
        Formula::And(_) | Formula::Or(_) | Formula::Not(_) | Formula::Imply(..) => {}
    });
    // Every quantifier of a scope has variables of its own.
    found.retain(|v| !bound.contains(v));
    found.sort_unstable();
    found.dedup();
    found
}

fn var(term: &Term) -> Option<VarId> {
    match term {
        Term::Var(v) => Some(*v),
        Term::Object(_) => None,
    }
}

/// Returns the predicates that a formula reads.
pub(super) fn read(formula: &Formula) -> Vec<PredicateId> {
    let mut found = Vec::new();
    visit(formula, &mut |part| {
        if let Formula::Atom(predicate, _) = part {
            found.push(*predicate);
        }
    });
    found
}

/// Calls `seen` for a formula and each of its parts. The depth is that of the text's lists, which has a cap.
pub(super) fn visit<'f>(formula: &'f Formula, seen: &mut dyn FnMut(&'f Formula)) {
    seen(formula);
    match formula {
        Formula::And(all) | Formula::Or(all) => all.iter().for_each(|f| visit(f, seen)),
        Formula::Not(inner) | Formula::Forall(_, inner) | Formula::Exists(_, inner) => visit(inner, seen),
        Formula::Imply(one, other) => {
            visit(one, seen);
            visit(other, seen);
        }
        Formula::Atom(..) | Formula::Equal(..) | Formula::Is(..) => {}
    }
}

/// Returns the formula with other terms for its variables.
pub(super) fn renamed(formula: &Formula, term: &dyn Fn(VarId) -> Term) -> Formula {
    let of = |t: &Term| match t {
        Term::Var(v) => term(*v),
        Term::Object(_) => *t,
    };
    let inner = |f: &Formula| Box::new(renamed(f, term));
    // A quantifier's variable becomes a variable.
    let vars = |all: &[VarId]| all.iter().filter_map(|v| var(&term(*v))).collect();
    match formula {
        Formula::And(all) => Formula::And(all.iter().map(|f| renamed(f, term)).collect()),
        Formula::Or(all) => Formula::Or(all.iter().map(|f| renamed(f, term)).collect()),
        Formula::Not(f) => Formula::Not(inner(f)),
        Formula::Imply(one, other) => Formula::Imply(inner(one), inner(other)),
        Formula::Forall(all, f) => Formula::Forall(vars(all), inner(f)),
        Formula::Exists(all, f) => Formula::Exists(vars(all), inner(f)),
        Formula::Atom(predicate, terms) => Formula::Atom(*predicate, terms.iter().map(of).collect()),
        Formula::Equal(one, other) => Formula::Equal(of(one), of(other)),
        Formula::Is(t, kinds) => Formula::Is(of(t), kinds.clone()),
    }
}

/// Says whether this is a predicate, an equality or a type, or the opposite of one.
pub(super) fn is_literal(formula: &Formula) -> bool {
    match formula {
        Formula::Atom(..) | Formula::Equal(..) | Formula::Is(..) => true,
        Formula::Not(inner) => matches!(**inner, Formula::Atom(..) | Formula::Equal(..)),
        Formula::And(_) | Formula::Or(_) | Formula::Imply(..) | Formula::Forall(..) | Formula::Exists(..) => false,
    }
}
