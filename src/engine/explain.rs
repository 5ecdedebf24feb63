//! A failed test in the language's own words, with the values that it met.

use super::eval::Context;
use crate::ir::{Domain, Expr, SlotId, Test, Value, Var, show_expr};

/// A literal that is false.
pub(super) struct Failed {
    /// With variables replaced by their values.
    pub literal: String,
    /// The values that it met.
    pub met: String,
    /// As the domain has it.
    pub rule: String,
}

/// Returns the first literal of a false test; `names` are those of the frame's first variables, and grow by the quantified
/// ones.
pub(super) fn failed_literal(
    context: &mut Context<'_>,
    test: &Test,
    frame: &mut [Value],
    names: &mut Vec<(Var, String)>,
) -> Failed {
    if let Test::And(parts) = test
        && let Some(part) = parts.iter().find(|t| !context.holds(t, frame))
    {
        return failed_literal(context, part, frame, names);
    }
    if let Test::Forall { var, ty, guard, body } = test {
        let domain = context.domain;
        for entity in &domain.types[ty.index()].entities {
            frame[var.index()] = Value::Entity(*entity);
            if context.holds(guard, frame) && !context.holds(body, frame) {
                // A quantified variable is named by its type.
                names.push((*var, domain.types[ty.index()].name.clone()));
                return failed_literal(context, body, frame, names);
            }
        }
    }
    let before = context.reads.len();
    context.holds(test, frame);
    let mut slots: Vec<SlotId> = context.reads[before..].to_vec();
    slots.sort();
    slots.dedup();
    let mut met: Vec<String> = slots
        .iter()
        .take(MOST_MET)
        .map(|s| {
            let value = context.slot(*s);
            format!("{} is {}", context.domain.slot_name(*s), context.domain.show(&value))
        })
        .collect();
    let more = if slots.len() > MOST_MET { ", ..." } else { "" };
    let domain = context.domain;
    // What a comparison computes is not to be seen in it.
    if let Test::Compare { left, right, .. } = test {
        for side in [left, right] {
            if is_computed(side) {
                let shown = show_expr(domain, side, &|var| domain.show(&frame[var.index()]));
                let value = context.value(side, frame);
                let value = value.map_or_else(|| "without a value".into(), |v| domain.show(&v));
                met.push(format!("{shown} is {value}"));
            }
        }
    }
    let name = |var: Var| {
        let known = names.iter().rev().find(|(v, _)| *v == var);
        known.map_or_else(|| domain.show(&frame[var.index()]), |(_, name)| name.clone())
    };
    Failed {
        literal: show_test(domain, test, &|var| domain.show(&frame[var.index()])),
        met: met.join(", ") + more,
        rule: show_test(domain, test, &name),
    }
}

/// Says whether an expression has a value that neither its words nor the attributes in it show.
fn is_computed(expr: &Expr) -> bool {
    matches!(
        expr,
        Expr::Size(_) | Expr::Arithmetic { .. } | Expr::Negate(_) | Expr::Request { .. } | Expr::Fact { .. }
    )
}

/// Attribute values shown with a literal.
const MOST_MET: usize = 4;

/// Returns a test in the language's own words; `name` says what stands for a variable.
pub(super) fn show_test(domain: &Domain, test: &Test, name: &dyn Fn(Var) -> String) -> String {
    let show = |e: &Expr| show_expr(domain, e, name);
    let all = |tests: &[Test]| {
        tests
            .iter()
            .map(|t| show_test(domain, t, name))
            .collect::<Vec<_>>()
            .join("; ")
    };
    match test {
        Test::And(parts) => all(parts),
        Test::Or(parts) => {
            let blocks: Vec<String> = parts
                .iter()
                .map(|t| format!("{{{}}}", show_test(domain, t, name)))
                .collect();
            format!("OR{}", blocks.concat())
        }
        Test::Not(inner) => match &**inner {
            Test::Member { element, set } => {
                format!("{} !>> {}", show(element), show(set))
            }
            other => format!("NOT{{{}}}", show_test(domain, other, name)),
        },
        Test::Compare { op, left, right } => {
            format!("{} {} {}", show(left), op.symbol(), show(right))
        }
        Test::Member { element, set } => {
            format!("{} >> {}", show(element), show(set))
        }
        Test::Forall { var, ty, guard, body } | Test::Exist { var, ty, guard, body } => {
            let word = if matches!(test, Test::Forall { .. }) {
                "FORALL"
            } else {
                "EXIST"
            };
            // A quantified variable is named by its type.
            let ty = &domain.types[ty.index()].name;
            let inner = |v: Var| if v == *var { ty.clone() } else { name(v) };
            let [guard, body] = [guard, body].map(|t| show_test(domain, t, &inner));
            format!("{word}({ty}, {{{guard}}}, {{{body}}})")
        }
        Test::Holds(expr) => show(expr),
    }
}
