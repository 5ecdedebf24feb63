//! Which attributes compiled tests and expressions read, and whether they ask geometry.

use std::collections::BTreeSet;

use crate::ir::{AttributeId, Effect, Expr, Test, Var};

/// What is read.
#[derive(Debug, Default)]
pub(super) struct Read {
    pub attributes: BTreeSet<AttributeId>,
    pub variables: BTreeSet<Var>,
    /// Whether geometry is asked about the world as it is.
    pub asks_geometry: bool,
}

impl Read {
    pub(super) fn expr(&mut self, expr: &Expr) {
        match expr {
            Expr::Const(_) => {}
            Expr::Var(var) => {
                self.variables.insert(*var);
            }
            Expr::GeometricCost | Expr::GeometricDuration => self.asks_geometry = true,
            Expr::Attribute { base, attribute, args } => {
                self.attributes.insert(*attribute);
                self.expr(base);
                args.iter().for_each(|a| self.expr(a));
            }
            Expr::Size(inner) | Expr::Negate(inner) => self.expr(inner),
            Expr::List(elements) => elements.iter().for_each(|e| self.expr(e)),
            Expr::Arithmetic { left, right, .. } => {
                self.expr(left);
                self.expr(right);
            }
            Expr::SetWith { set, element } | Expr::SetWithout { set, element } => {
                self.expr(set);
                self.expr(element);
            }
            Expr::Request { args, .. } | Expr::Fact { args, .. } => {
                self.asks_geometry = true;
                args.iter().for_each(|a| self.expr(a));
            }
        }
    }

    pub(super) fn test(&mut self, test: &Test) {
        match test {
            Test::And(tests) | Test::Or(tests) => tests.iter().for_each(|t| self.test(t)),
            Test::Not(test) => self.test(test),
            Test::Compare { left, right, .. } => {
                self.expr(left);
                self.expr(right);
            }
            Test::Member { element, set } => {
                self.expr(element);
                self.expr(set);
            }
            Test::Forall { guard, body, .. } | Test::Exist { guard, body, .. } => {
                self.test(guard);
                self.test(body);
            }
            Test::Holds(expr) => self.expr(expr),
        }
    }

    /// Adds what the effects read, and gives what they write to `written`.
    pub(super) fn effects(&mut self, effects: &[Effect], written: &mut BTreeSet<AttributeId>) {
        for effect in effects {
            match effect {
                Effect::Assign {
                    entity,
                    attribute,
                    args,
                    value,
                } => {
                    written.insert(*attribute);
                    self.expr(entity);
                    args.iter().for_each(|a| self.expr(a));
                    self.expr(value);
                }
                Effect::Add {
                    entity,
                    attribute,
                    args,
                    element,
                }
                | Effect::Remove {
                    entity,
                    attribute,
                    args,
                    element,
                } => {
                    written.insert(*attribute);
                    self.expr(entity);
                    args.iter().for_each(|a| self.expr(a));
                    self.expr(element);
                }
                Effect::Forall { guard, effects, .. } => {
                    self.test(guard);
                    self.effects(effects, written);
                }
                Effect::If { test, then, otherwise } => {
                    self.test(test);
                    self.effects(then, written);
                    self.effects(otherwise, written);
                }
            }
        }
    }
}
