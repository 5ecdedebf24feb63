//! Walks over what was written, to see which names it speaks of.

use crate::syntax::ast::{Effect, Expr, ExprKind, Name, Path, Select, Step, Test, TestKind};

/// Calls `f` with the first name of every path in the expression.
pub(super) fn names_of_expr<'a>(expr: &'a Expr, f: &mut dyn FnMut(&'a Name)) {
    match &expr.kind {
        ExprKind::Number(_) | ExprKind::String(_) | ExprKind::Bool(_) | ExprKind::Null => {}
        ExprKind::Path(path) => names_of_path(path, f),
        ExprKind::Call(call) => call.args.iter().for_each(|a| names_of_expr(a, f)),
        ExprKind::List(elements) => elements.iter().for_each(|e| names_of_expr(e, f)),
        ExprKind::Negate(inner) => names_of_expr(inner, f),
        ExprKind::Pair(left, right) | ExprKind::Arithmetic { left, right, .. } => {
            names_of_expr(left, f);
            names_of_expr(right, f);
        }
    }
}

fn names_of_path<'a>(path: &'a Path, f: &mut dyn FnMut(&'a Name)) {
    f(&path.root);
    let args = path.steps.iter().flat_map(|s| &s.args);
    args.for_each(|a| names_of_expr(a, f));
}

/// Calls `f` with the first name of every path in the tests.
pub(super) fn names_of_tests<'a>(tests: &'a [Test], f: &mut dyn FnMut(&'a Name)) {
    for test in tests {
        match &test.kind {
            TestKind::Or(blocks) => blocks.iter().for_each(|b| names_of_tests(b, f)),
            TestKind::Not(tests) => names_of_tests(tests, f),
            TestKind::Forall { guard, body, .. } | TestKind::Exist { guard, body, .. } => {
                names_of_tests(guard, f);
                names_of_tests(body, f);
            }
            TestKind::Compare { left, right, .. } => {
                names_of_expr(left, f);
                names_of_expr(right, f);
            }
            TestKind::Holds(expr) => names_of_expr(expr, f),
            TestKind::Believes(agent, test) => {
                names_of_path(agent, f);
                names_of_tests(std::slice::from_ref(test), f);
            }
        }
    }
}

/// Calls `f` with the first name of every path in the effects.
pub(super) fn names_of_effects<'a>(effects: &'a [Effect], f: &mut dyn FnMut(&'a Name)) {
    for effect in effects {
        match effect {
            Effect::Assign(assignment) => {
                assignment.believer.iter().for_each(|b| names_of_path(b, f));
                names_of_path(&assignment.target, f);
                names_of_expr(&assignment.value, f);
            }
            Effect::Forall { guard, effects, .. } => {
                names_of_tests(guard, f);
                names_of_effects(effects, f);
            }
            Effect::If {
                test, then, otherwise, ..
            } => {
                names_of_tests(test, f);
                names_of_effects(then, f);
                names_of_effects(otherwise, f);
            }
        }
    }
}

/// Calls `f` with the first name of every path in the line.
pub(super) fn names_of_step<'a>(step: &'a Step, f: &mut dyn FnMut(&'a Name)) {
    match step {
        Step::Select(Select { filter, key, .. }) => {
            names_of_tests(filter, f);
            if let Some((key, _)) = key {
                names_of_expr(key, f);
            }
        }
        Step::Let(binding) => names_of_expr(&binding.value, f),
        Step::Subtask(subtask) => subtask.call.args.iter().for_each(|a| names_of_expr(a, f)),
    }
}

/// Calls `f` with every quantified variable of the tests, and with what is said of it.
pub(super) fn quantified_in_tests<'a>(tests: &'a [Test], f: &mut dyn FnMut(&'a Name, &'a [Test], &'a [Test])) {
    for test in tests {
        match &test.kind {
            TestKind::Or(blocks) => blocks.iter().for_each(|b| quantified_in_tests(b, f)),
            TestKind::Not(tests) => quantified_in_tests(tests, f),
            TestKind::Forall { var, guard, body, .. } | TestKind::Exist { var, guard, body, .. } => {
                f(var, guard, body);
                quantified_in_tests(guard, f);
                quantified_in_tests(body, f);
            }
            TestKind::Compare { .. } | TestKind::Holds(_) | TestKind::Believes(..) => {}
        }
    }
}
