//! A domain without its geometry: what is planned when there is no world.
//!
//! Whatever geometry would have to say is granted. Projections and shared attributes are gone (the attributes are plain
//! ones, and `effects` alone change them); a literal that asks geometry holds, and under a `NOT` or in a guard it fails,
//! so that no test is harder than with geometry; numbers of geometry are 0. Constraints become preconditions: the world
//! they speak of is the one before.

use super::{Action, Base, Binder, Decomposition, Domain, Effect, Expr, Request, SelectOrder, Test, Value};

/// Says whether any action projects.
pub fn projects(domain: &Domain) -> bool {
    domain.actions.iter().any(|a| a.projects.is_some())
}

/// Returns the domain with its geometry granted.
pub fn without_geometry(domain: &Domain) -> Domain {
    let mut out = domain.clone();
    for attribute in &mut out.attributes {
        attribute.fact = None;
    }
    let requests = &domain.requests;
    for action in &mut out.actions {
        grant_action(requests, action);
    }
    for method in &mut out.methods {
        if let Some(goal) = &mut method.goal {
            test(goal, true);
        }
        for decomposition in &mut method.decompositions {
            grant_decomposition(requests, decomposition);
        }
    }
    out
}

fn grant_action(requests: &[Request], action: &mut Action) {
    action.projects = None;
    test(&mut action.preconditions, true);
    let mut constraints = std::mem::replace(&mut action.constraints, Test::always());
    test(&mut constraints, true);
    if !is_always(&constraints) {
        let preconditions = std::mem::replace(&mut action.preconditions, Test::always());
        action.preconditions = Test::And(vec![preconditions, constraints]);
    }
    effects(requests, &mut action.effects);
    expr(requests, &mut action.cost);
    expr(requests, &mut action.duration.0);
    expr(requests, &mut action.duration.1);
}

fn grant_decomposition(requests: &[Request], decomposition: &mut Decomposition) {
    test(&mut decomposition.preconditions, true);
    for binder in &mut decomposition.binders {
        match binder {
            Binder::Let { value, .. } => expr(requests, value),
            Binder::Select { filter, order, .. } => {
                test(filter, true);
                if let SelectOrder::Sorted { key, .. } = order {
                    expr(requests, key);
                }
            }
        }
    }
    for subtask in &mut decomposition.subtasks {
        exprs(requests, &mut subtask.args);
    }
}

fn is_always(test: &Test) -> bool {
    matches!(test, Test::And(parts) if parts.iter().all(is_always))
}

/// Grants the literals of `test` that ask geometry; `granted` is what they are then, `false` under a negation.
fn test(at: &mut Test, granted: bool) {
    let asks_here = match &*at {
        Test::Compare { left, right, .. } => asks(left) || asks(right),
        Test::Member { element, set } => asks(element) || asks(set),
        Test::Holds(holds) => asks(holds),
        Test::And(_) | Test::Or(_) | Test::Not(_) | Test::Forall { .. } | Test::Exist { .. } => false,
    };
    if asks_here {
        *at = if granted { Test::always() } else { Test::Or(Vec::new()) };
        return;
    }
    match at {
        Test::And(parts) | Test::Or(parts) => parts.iter_mut().for_each(|t| test(t, granted)),
        Test::Not(inner) => test(inner, !granted),
        Test::Forall { guard, body, .. } => {
            test(guard, !granted);
            test(body, granted);
        }
        Test::Exist { guard, body, .. } => {
            test(guard, granted);
            test(body, granted);
        }
        Test::Compare { .. } | Test::Member { .. } | Test::Holds(_) => {}
    }
}

/// Says whether the expression asks geometry.
fn asks(expr: &Expr) -> bool {
    match expr {
        Expr::Request { .. } | Expr::Fact { .. } | Expr::GeometricCost | Expr::GeometricDuration => true,
        Expr::Const(_) | Expr::Var(_) => false,
        Expr::Attribute { base: inner, .. } | Expr::Size(inner) | Expr::Negate(inner) => asks(inner),
        Expr::List(elements) => elements.iter().any(asks),
        Expr::Arithmetic { left, right, .. } => asks(left) || asks(right),
        Expr::SetWith { set, element } | Expr::SetWithout { set, element } => asks(set) || asks(element),
    }
}

/// Writes what geometry would compute as 0, and what it would say as `true`.
fn expr(requests: &[Request], at: &mut Expr) {
    match at {
        Expr::GeometricCost | Expr::GeometricDuration => *at = Expr::Const(Value::Number(0.0)),
        Expr::Request { request, .. } => {
            let is_number = requests.get(request.index()).is_some_and(|r| r.result == Base::Number);
            let value = if is_number {
                Value::Number(0.0)
            } else {
                Value::Bool(true)
            };
            *at = Expr::Const(value);
        }
        Expr::Fact { .. } => *at = Expr::Const(Value::Bool(true)),
        Expr::Const(_) | Expr::Var(_) => {}
        Expr::Attribute { base: inner, .. } | Expr::Size(inner) | Expr::Negate(inner) => expr(requests, inner),
        Expr::List(elements) => exprs(requests, elements),
        Expr::Arithmetic { left, right, .. } => {
            expr(requests, left);
            expr(requests, right);
        }
        Expr::SetWith { set, element } | Expr::SetWithout { set, element } => {
            expr(requests, set);
            expr(requests, element);
        }
    }
}

fn exprs(requests: &[Request], all: &mut [Expr]) {
    all.iter_mut().for_each(|e| expr(requests, e));
}

fn effects(requests: &[Request], all: &mut [Effect]) {
    for effect in all {
        match effect {
            Effect::Assign { entity, value, .. } => {
                expr(requests, entity);
                expr(requests, value);
            }
            Effect::Add { entity, element, .. } | Effect::Remove { entity, element, .. } => {
                expr(requests, entity);
                expr(requests, element);
            }
            Effect::Forall {
                guard, effects: inner, ..
            } => {
                test(guard, true);
                effects(requests, inner);
            }
            Effect::If {
                test: when,
                then,
                otherwise,
            } => {
                test(when, true);
                effects(requests, then);
                effects(requests, otherwise);
            }
        }
    }
}
