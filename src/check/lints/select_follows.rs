//! A SELECT whose filter names its one entity already. Old files have no other way to name a value; so this is off unless
//! asked for.

use super::{Linted, conjuncts};
use crate::diag::{Problem, Problems};
use crate::ir::{Binder, CompareOp, Expr, Test};
use crate::syntax::ast::{Select, Step};

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    for (written, method) in &linted.methods {
        for (written, decomposition) in written.decompositions.iter().zip(&method.decompositions) {
            let selects = written.steps.iter().filter_map(|step| match step {
                Step::Select(select) => Some(select),
                Step::Let(_) | Step::Subtask(_) => None,
            });
            let compiled = decomposition.binders.iter().filter_map(|binder| match binder {
                Binder::Select { var, filter, .. } => Some((*var, filter)),
                Binder::Let { .. } => None,
            });
            for (select, (var, filter)) in selects.zip(compiled) {
                // With more tests in the filter a `let` would not say the same.
                let [(_, Test::Compare { op, left, right })] = conjuncts(&select.filter, filter)[..] else {
                    continue;
                };
                let follows = |one: &Expr, other: &Expr| {
                    matches!(one, Expr::Var(v) if *v == var) && matches!(other, Expr::Attribute { .. })
                };
                if *op == CompareOp::Equal && (follows(left, right) || follows(right, left)) {
                    problems.push(follows_only(select));
                }
            }
        }
    }
}

fn follows_only(select: &Select) -> Problem {
    let name = &select.name.text;
    let message = format!("SELECT of `{name}` only follows an attribute");
    Problem::warning("hatp::select-follows", message, select.kind_span, "no choice").help(format!(
        "write `let {name} = ENTITY.attribute;`, which looks at one entity instead of all"
    ))
}
