//! Walks over expressions and tests.

use super::{Effect, Expr, Test};

impl Expr {
    /// Calls `f` with every direct part.
    pub fn each_child(&self, f: &mut dyn FnMut(&Expr)) {
        match self {
            Expr::Const(_) | Expr::Var(_) | Expr::GeometricCost | Expr::GeometricDuration => {}
            Expr::Attribute { base, args, .. } => {
                f(base);
                args.iter().for_each(f);
            }
            Expr::Size(inner) | Expr::Negate(inner) => f(inner),
            Expr::List(parts) | Expr::Request { args: parts, .. } | Expr::Fact { args: parts, .. } => {
                parts.iter().for_each(f);
            }
            Expr::Arithmetic { left, right, .. } => {
                f(left);
                f(right);
            }
            Expr::SetWith { set, element } | Expr::SetWithout { set, element } => {
                f(set);
                f(element);
            }
        }
    }

    /// Says whether `found` holds for it or for any part of it.
    pub fn any(&self, found: &mut dyn FnMut(&Expr) -> bool) -> bool {
        if found(self) {
            return true;
        }
        let mut any = false;
        self.each_child(&mut |child| any = any || child.any(found));
        any
    }
}

impl Test {
    /// Says whether `found` holds for any expression in it, at any depth.
    pub fn any(&self, found: &mut dyn FnMut(&Expr) -> bool) -> bool {
        match self {
            Test::And(parts) | Test::Or(parts) => parts.iter().any(|t| t.any(found)),
            Test::Not(inner) => inner.any(found),
            Test::Compare { left, right, .. } => left.any(found) || right.any(found),
            Test::Member { element, set } => element.any(found) || set.any(found),
            Test::Forall { guard, body, .. } | Test::Exist { guard, body, .. } => guard.any(found) || body.any(found),
            Test::Holds(expr) => expr.any(found),
        }
    }
}

impl Effect {
    /// Says whether `found` holds for any expression in it, at any depth.
    pub fn any(&self, found: &mut dyn FnMut(&Expr) -> bool) -> bool {
        match self {
            Effect::Assign {
                entity, args, value, ..
            } => entity.any(found) || args.iter().any(|a| a.any(found)) || value.any(found),
            Effect::Add {
                entity, args, element, ..
            }
            | Effect::Remove {
                entity, args, element, ..
            } => entity.any(found) || args.iter().any(|a| a.any(found)) || element.any(found),
            Effect::Forall { guard, effects, .. } => guard.any(found) || effects.iter().any(|e| e.any(found)),
            Effect::If { test, then, otherwise } => {
                test.any(found) || then.iter().chain(otherwise).any(|e| e.any(found))
            }
        }
    }
}
