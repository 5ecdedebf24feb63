//! A decomposition whose last action undoes the method's goal.
//!
//! Told only where it is sure: the action comes after all that could set the attribute again, and its effect stands
//! outside of `IF` and `FORALL`.

use super::never_applies::differ;
use super::{Linted, conjuncts};
use crate::diag::{Problem, Problems};
use crate::ir::{Action, AttributeId, CompareOp, Decomposition, Effect, Expr, TaskId, Test};
use crate::source::Span;
use crate::syntax::ast::{self, Clause, Step};

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    for (written, method) in &linted.methods {
        let goal = written.goals.first().map(|(tests, _)| tests).zip(method.goal.as_ref());
        let goal = goal.map(|(written, goal)| conjuncts(written, goal)).unwrap_or_default();
        for (written_ways, way) in written.decompositions.iter().zip(&method.decompositions) {
            let steps = written_ways.steps.iter().filter_map(|step| match step {
                Step::Subtask(subtask) => Some(subtask),
                Step::Select(_) | Step::Let(_) => None,
            });
            for (i, (step, subtask)) in steps.zip(&way.subtasks).enumerate() {
                let TaskId::Action(action) = subtask.task else { continue };
                let Some((of, action)) = linted.actions.get(action.index()) else {
                    continue;
                };
                let undone = goal.iter().find_map(|(span, goal)| {
                    let (effect, attribute) = undoes(action, &subtask.args, goal)?;
                    let is_last = !may_change_after(linted, way, i, attribute);
                    is_last.then(|| (*span, effect_span(of, effect)))
                });
                if let Some((goal, effect)) = undone {
                    problems.push(problem(&written.name.text, step, goal, effect));
                }
            }
        }
    }
}

/// Returns the position of the effect that surely makes the goal false, and the attribute.
fn undoes(action: &Action, args: &[Expr], goal: &Test) -> Option<(usize, AttributeId)> {
    let (wanted, attribute, owner, value) = wanted(goal)?;
    let mut last = None;
    for (i, effect) in action.effects.iter().enumerate() {
        let found = match effect {
            Effect::Assign {
                entity,
                attribute: changed,
                args: of,
                value: new,
            } if *changed == attribute && of.is_empty() => {
                let (entity, new) = (replaced(entity, args), replaced(new, args));
                let is_false = match wanted {
                    Wanted::Equal => new.is_some_and(|new| differ(&new, value)),
                    Wanted::Unequal => new.is_some_and(|new| new == *value),
                    Wanted::Member => matches!(new, Some(Expr::List(elements)) if elements.is_empty()),
                    Wanted::NoMember => false,
                };
                (entity.as_ref() == Some(owner) && is_false).then_some(i)
            }
            Effect::Add {
                entity,
                attribute: changed,
                element,
                ..
            }
            | Effect::Remove {
                entity,
                attribute: changed,
                element,
                ..
            } if *changed == attribute => {
                let adds = matches!(effect, Effect::Add { .. });
                let against = matches!((&wanted, adds), (Wanted::Member, false) | (Wanted::NoMember, true));
                let same =
                    replaced(entity, args).as_ref() == Some(owner) && replaced(element, args).as_ref() == Some(value);
                (against && same).then_some(i)
            }
            _ if changes(std::slice::from_ref(effect), attribute) => None,
            _ => continue,
        };
        // What is changed again may be right in the end.
        last = found;
    }
    last.map(|i| (i, attribute))
}

/// What a goal asks of an attribute.
enum Wanted {
    Equal,
    Unequal,
    Member,
    NoMember,
}

/// Returns what a goal asks, of which attribute of which entity, and the value.
fn wanted(goal: &Test) -> Option<(Wanted, AttributeId, &Expr, &Expr)> {
    let place = |expr| match expr {
        // The entity at the end of a longer path, or an argument, may be another by then.
        &Expr::Attribute {
            ref base,
            attribute,
            ref args,
        } if args.is_empty() && matches!(**base, Expr::Var(_) | Expr::Const(_)) => Some((attribute, &**base)),
        _ => None,
    };
    match goal {
        Test::Compare { op, left, right } => {
            let wanted = match op {
                CompareOp::Equal => Wanted::Equal,
                CompareOp::NotEqual => Wanted::Unequal,
                _ => return None,
            };
            let sides = place(left).map(|p| (p, right)).or(place(right).map(|p| (p, left)));
            let ((attribute, owner), value) = sides?;
            Some((wanted, attribute, owner, value))
        }
        Test::Member { element, set } => place(set).map(|(a, owner)| (Wanted::Member, a, owner, element)),
        Test::Not(inner) => match &**inner {
            Test::Member { element, set } => place(set).map(|(a, owner)| (Wanted::NoMember, a, owner, element)),
            _ => None,
        },
        _ => None,
    }
}

/// Returns an expression of the action with the subtask's arguments for its parameters, if it is that simple.
fn replaced(expr: &Expr, args: &[Expr]) -> Option<Expr> {
    match expr {
        Expr::Const(_) => Some(expr.clone()),
        Expr::List(elements) if elements.is_empty() => Some(expr.clone()),
        Expr::Var(var) => args.get(var.index()).cloned(),
        _ => None,
    }
}

/// Says whether an effect changes the attribute of any entity.
fn changes(effects: &[Effect], of: AttributeId) -> bool {
    effects.iter().any(|effect| match effect {
        Effect::Assign { attribute, .. } | Effect::Add { attribute, .. } | Effect::Remove { attribute, .. } => {
            *attribute == of
        }
        Effect::Forall { effects, .. } => changes(effects, of),
        Effect::If { then, otherwise, .. } => changes(then, of) || changes(otherwise, of),
    })
}

/// Says whether another subtask may change the attribute after the one at `i`.
fn may_change_after(linted: &Linted<'_>, way: &Decomposition, i: usize, attribute: AttributeId) -> bool {
    let before = before(way, i);
    let others = way.subtasks.iter().enumerate();
    others
        .filter(|(j, _)| *j != i && !before.contains(j))
        .any(|(_, other)| match other.task {
            TaskId::Method(_) => true,
            TaskId::Action(action) => {
                let action = linted.domain.actions.get(action.index());
                action.is_none_or(|a| changes(&a.effects, attribute))
            }
        })
}

/// Returns the subtasks that must be over before the one at `i` starts.
pub(super) fn before(way: &Decomposition, i: usize) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let mut open = vec![i];
    while let Some(at) = open.pop() {
        for j in way.subtasks.get(at).into_iter().flat_map(|s| &s.after) {
            if !found.contains(j) {
                found.push(*j);
                open.push(*j);
            }
        }
    }
    found
}

fn effect_span(action: &ast::Action, i: usize) -> Option<Span> {
    let effects = action.clauses.iter().find_map(|clause| match clause {
        Clause::Effects(effects, _) => Some(effects),
        _ => None,
    });
    match effects?.get(i)? {
        ast::Effect::Assign(assignment) => Some(assignment.span),
        ast::Effect::Forall { span, .. } | ast::Effect::If { span, .. } => Some(*span),
    }
}

fn problem(method: &str, step: &ast::Subtask, goal: Span, effect: Option<Span>) -> Problem {
    let message = format!("`{}` undoes the goal of method `{method}`", step.call.name.text);
    let mut problem = Problem::warning(
        "hatp::contradicts-goal",
        message,
        step.span,
        "the goal does not hold after this",
    );
    problem = problem.note(goal, "the goal");
    if let Some(effect) = effect {
        problem = problem.note(effect, "this effect");
    }
    problem.help("a method's goal should hold when its subtasks are done; change the goal, or the subtasks")
}
