//! A domain without its geometry: what is planned when there is no world.
//!
//! Whatever geometry would have to say is granted. Projections and shared attributes are gone (the attributes are plain
//! ones, and `effects` alone change them); a literal that asks geometry holds, and under a `NOT` or in a guard it fails,
//! so that no test is harder than with geometry; numbers of geometry are 0. Constraints become preconditions: the world
//! they speak of is the one before.

use super::{Action, Base, Binder, Decomposition, Domain, Effect, Expr, Request, SelectOrder, Test, Value};

/// Says whether anything in the domain asks geometry: a projection, or a request in a test.
pub fn asks_geometry(domain: &Domain) -> bool {
    let asking = asking(domain);
    let asks = |test: &Test| test.any(&mut |e| asks_here(&asking, e));
    let filters = |d: &Decomposition| {
        let mut binders = d.binders.iter();
        binders.any(|b| matches!(b, Binder::Select { filter, .. } if asks(filter)))
    };
    let mut actions = domain.actions.iter();
    actions.any(|a| a.projects.is_some() || asks(&a.preconditions))
        || domain.methods.iter().any(|m| {
            let mut decompositions = m.decompositions.iter();
            m.goal.as_ref().is_some_and(asks) || decompositions.any(|d| asks(&d.preconditions) || filters(d))
        })
}

/// Returns the domain with its geometry granted.
pub fn without_geometry(domain: &Domain) -> Domain {
    let mut out = domain.clone();
    for attribute in &mut out.attributes {
        attribute.fact = None;
    }
    let granted = Granted {
        requests: &domain.requests,
        asking: asking(domain),
    };
    for action in &mut out.actions {
        granted.action(action);
    }
    for method in &mut out.methods {
        if let Some(goal) = &mut method.goal {
            granted.test(goal, true);
        }
        for decomposition in &mut method.decompositions {
            granted.decomposition(decomposition);
        }
    }
    out
}

/// Says which facts of the domain ask geometry, by [`super::FactId`].
fn asking(domain: &Domain) -> Vec<bool> {
    let mut asking = vec![false; domain.facts.len()];
    // Facts ask facts without circles, so as many rounds as facts are enough.
    for _ in 0..domain.facts.len() {
        let next: Vec<bool> = domain
            .facts
            .iter()
            .map(|f| f.body.any(&mut |e| asks_here(&asking, e)))
            .collect();
        if next == asking {
            break;
        }
        asking = next;
    }
    asking
}

fn asks_here(asking: &[bool], expr: &Expr) -> bool {
    match expr {
        Expr::Request { .. } | Expr::GeometricCost | Expr::GeometricDuration => true,
        Expr::Fact { fact, .. } => asking.get(fact.index()).copied().unwrap_or(false),
        _ => false,
    }
}

/// Who asks what of geometry.
struct Granted<'a> {
    requests: &'a [Request],
    asking: Vec<bool>,
}

impl Granted<'_> {
    fn asks(&self, expr: &Expr) -> bool {
        expr.any(&mut |e| asks_here(&self.asking, e))
    }

    fn action(&self, action: &mut Action) {
        action.projects = None;
        self.test(&mut action.preconditions, true);
        let mut constraints = std::mem::replace(&mut action.constraints, Test::always());
        self.test(&mut constraints, true);
        if !is_always(&constraints) {
            let preconditions = std::mem::replace(&mut action.preconditions, Test::always());
            action.preconditions = Test::And(vec![preconditions, constraints]);
        }
        self.effects(&mut action.effects);
        self.expr(&mut action.cost);
        self.expr(&mut action.duration.0);
        self.expr(&mut action.duration.1);
    }

    fn decomposition(&self, decomposition: &mut Decomposition) {
        self.test(&mut decomposition.preconditions, true);
        for binder in &mut decomposition.binders {
            match binder {
                Binder::Let { value, .. } => self.expr(value),
                Binder::Select { filter, order, .. } => {
                    self.test(filter, true);
                    if let SelectOrder::Sorted { key, .. } = order {
                        self.expr(key);
                    }
                }
            }
        }
        for subtask in &mut decomposition.subtasks {
            self.exprs(&mut subtask.args);
        }
    }

    /// Grants the literals of `test` that ask geometry; `holds` is what they are then, `false` under a negation.
    fn test(&self, test: &mut Test, holds: bool) {
        let is_asking = match &*test {
            Test::Compare { left, right, .. } => self.asks(left) || self.asks(right),
            Test::Member { element, set } => self.asks(element) || self.asks(set),
            Test::Holds(expr) => self.asks(expr),
            Test::And(_) | Test::Or(_) | Test::Not(_) | Test::Forall { .. } | Test::Exist { .. } => false,
        };
        if is_asking {
            *test = if holds { Test::always() } else { Test::Or(Vec::new()) };
            return;
        }
        match test {
            Test::And(parts) | Test::Or(parts) => parts.iter_mut().for_each(|t| self.test(t, holds)),
            Test::Not(inner) => self.test(inner, !holds),
            Test::Forall { guard, body, .. } => {
                self.test(guard, !holds);
                self.test(body, holds);
            }
            Test::Exist { guard, body, .. } => {
                self.test(guard, holds);
                self.test(body, holds);
            }
            Test::Compare { .. } | Test::Member { .. } | Test::Holds(_) => {}
        }
    }

    /// Writes what geometry would compute as 0, and what it would say as `true`.
    fn expr(&self, expr: &mut Expr) {
        match expr {
            Expr::GeometricCost | Expr::GeometricDuration => *expr = Expr::Const(Value::Number(0.0)),
            Expr::Request { request, .. } => {
                let result = self.requests.get(request.index()).map(|r| r.result);
                let value = match result {
                    Some(Base::Number) => Value::Number(0.0),
                    Some(Base::Bool | Base::String | Base::Entity(_)) | None => Value::Bool(true),
                };
                *expr = Expr::Const(value);
            }
            Expr::Fact { .. } if asks_here(&self.asking, expr) => *expr = Expr::Const(Value::Bool(true)),
            Expr::Fact { args, .. } => self.exprs(args),
            Expr::Const(_) | Expr::Var(_) => {}
            Expr::Attribute { base, args, .. } => {
                self.expr(base);
                self.exprs(args);
            }
            Expr::Size(inner) | Expr::Negate(inner) => self.expr(inner),
            Expr::List(elements) => self.exprs(elements),
            Expr::Arithmetic { left, right, .. } => {
                self.expr(left);
                self.expr(right);
            }
            Expr::SetWith { set, element } | Expr::SetWithout { set, element } => {
                self.expr(set);
                self.expr(element);
            }
        }
    }

    fn exprs(&self, all: &mut [Expr]) {
        all.iter_mut().for_each(|e| self.expr(e));
    }

    fn effects(&self, all: &mut [Effect]) {
        for effect in all {
            match effect {
                Effect::Assign {
                    entity, args, value, ..
                } => {
                    self.expr(entity);
                    self.exprs(args);
                    self.expr(value);
                }
                Effect::Add {
                    entity, args, element, ..
                }
                | Effect::Remove {
                    entity, args, element, ..
                } => {
                    self.expr(entity);
                    self.exprs(args);
                    self.expr(element);
                }
                Effect::Forall { guard, effects, .. } => {
                    self.test(guard, true);
                    self.effects(effects);
                }
                Effect::If { test, then, otherwise } => {
                    self.test(test, true);
                    self.effects(then);
                    self.effects(otherwise);
                }
            }
        }
    }
}

fn is_always(test: &Test) -> bool {
    matches!(test, Test::And(parts) if parts.iter().all(is_always))
}
