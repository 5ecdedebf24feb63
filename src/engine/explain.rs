//! A failed test in the language's own words, with the values that it met.

use super::eval::Context;
use crate::ir::{Domain, Expr, SlotId, Test, Value, Var, show_expr};

/// Returns the first literal of a false test with variables replaced by their values, and the attribute values that it met.
pub(super) fn failed_literal(context: &mut Context<'_>, test: &Test, frame: &mut [Value]) -> (String, String) {
    if let Test::And(parts) = test
        && let Some(part) = parts.iter().find(|t| !context.holds(t, frame))
    {
        return failed_literal(context, part, frame);
    }
    if let Test::Forall { var, ty, guard, body } = test {
        let domain = context.domain;
        for entity in &domain.types[ty.index()].entities {
            frame[var.index()] = Value::Entity(*entity);
            if context.holds(guard, frame) && !context.holds(body, frame) {
                return failed_literal(context, body, frame);
            }
        }
    }
    let before = context.reads.len();
    context.holds(test, frame);
    let mut slots: Vec<SlotId> = context.reads[before..].to_vec();
    slots.sort();
    slots.dedup();
    let met: Vec<String> = slots
        .iter()
        .take(MOST_MET)
        .map(|s| {
            let value = context.slot(*s);
            format!("{} is {}", context.domain.slot_name(*s), context.domain.show(&value))
        })
        .collect();
    let more = if slots.len() > MOST_MET { ", ..." } else { "" };
    let domain = context.domain;
    let literal = show_test(domain, test, &|var| domain.show(&frame[var.index()]));
    (literal, met.join(", ") + more)
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
        Test::Forall { ty, .. } => format!("FORALL over {}", domain.types[ty.index()].name),
        Test::Exist { ty, .. } => format!("EXIST over {}", domain.types[ty.index()].name),
        Test::Holds(expr) => show(expr),
    }
}
