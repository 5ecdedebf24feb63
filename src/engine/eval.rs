//! Values of expressions, truth of tests, and effects, in the current state.
//!
//! NULL (language, section 2): a path whose step before the last is NULL has no value at all; a literal with such a path is
//! false (`!=`: true). An unset last step is the value `NULL`, equal to `NULL`. A division by zero has no value either.

use std::sync::Arc;

use super::reasoner::{Reasoner, Request};
use super::state::State;
use crate::ir::{
    ArithmeticOp, AttributeId, CompareOp, Domain, Effect, EntityId, EntitySet, Expr, FactId, SlotId, Test, TypeId,
    Value, Var,
};

/// What an evaluation may look at.
pub(super) struct Context<'a> {
    pub domain: &'a Domain,
    pub state: &'a mut State,
    pub reasoner: &'a mut dyn Reasoner,
    /// Slots read since somebody last cleared it; for causal links.
    pub reads: Vec<SlotId>,
    /// Cost and duration [s] of the projection of the action at hand; zeros where there is none.
    pub projection: (f64, f64),
    /// Whether the world state is already the one after the action at hand: shared attributes that nobody has read before
    /// then go to `missed`, and count as NULL.
    pub is_late: bool,
    pub missed: Vec<SlotId>,
}

/// Returns a frame with the arguments first and the other variables unset.
pub(super) fn frame(args: &[Value], n_vars: usize) -> Vec<Value> {
    let mut frame = args.to_vec();
    frame.resize(n_vars.max(args.len()), Value::Null);
    frame
}

impl<'a> Context<'a> {
    /// Returns a context with no projection at hand.
    pub fn new(domain: &'a Domain, state: &'a mut State, reasoner: &'a mut dyn Reasoner) -> Self {
        Context {
            domain,
            state,
            reasoner,
            reads: Vec::new(),
            projection: (0.0, 0.0),
            is_late: false,
            missed: Vec::new(),
        }
    }
}

impl Context<'_> {
    /// Returns the value of a slot, read from geometry if need be.
    pub fn slot(&mut self, slot: SlotId) -> Value {
        if let Some(value) = self.state.get(slot) {
            return value.clone();
        }
        if self.is_late {
            self.missed.push(slot);
            return Value::Null;
        }
        let place = self.domain.slots[slot.index()];
        let value = self.reasoner.fact(self.domain, place.attribute, place.entity);
        self.state.remember(slot, value.clone());
        value
    }

    fn slot_of(&self, entity: EntityId, attribute: AttributeId) -> Option<SlotId> {
        self.domain.attributes[attribute.index()].slots[entity.index()]
    }

    /// Returns the value, or `None` when a step of its path goes through NULL (or a number through one), or a number would
    /// not be finite.
    pub fn value(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<Value> {
        Some(match expr {
            Expr::Const(value) => value.clone(),
            Expr::Var(var) => frame[var.index()].clone(),
            Expr::Attribute { base, attribute } => {
                let Value::Entity(entity) = self.value(base, frame)? else {
                    return None;
                };
                let slot = self.slot_of(entity, *attribute)?;
                self.reads.push(slot);
                self.slot(slot)
            }
            Expr::Size(set) => Value::Number(self.set(set, frame)?.len() as f64),
            Expr::List(elements) => {
                let mut set = EntitySet::default();
                for element in elements {
                    let Value::Entity(e) = self.value(element, frame)? else {
                        return None;
                    };
                    set.insert(e);
                }
                Value::Set(Arc::new(set))
            }
            Expr::Arithmetic { op, left, right } => {
                let (l, r) = (self.number(left, frame)?, self.number(right, frame)?);
                let x = match op {
                    ArithmeticOp::Add => l + r,
                    ArithmeticOp::Subtract => l - r,
                    ArithmeticOp::Multiply => l * r,
                    ArithmeticOp::Divide => l / r,
                };
                Value::Number(Some(x).filter(|x| x.is_finite())?)
            }
            Expr::Negate(inner) => Value::Number(-self.number(inner, frame)?),
            Expr::SetWith { set, element } | Expr::SetWithout { set, element } => {
                let mut members = (*self.set(set, frame)?).clone();
                let Value::Entity(e) = self.value(element, frame)? else {
                    return None;
                };
                if matches!(expr, Expr::SetWith { .. }) {
                    members.insert(e);
                } else {
                    members.remove(e);
                }
                Value::Set(Arc::new(members))
            }
            Expr::Request { request, args } => {
                let args: Option<Vec<Value>> = args.iter().map(|a| self.value(a, frame)).collect();
                let name = &self.domain.requests[request.index()].name;
                self.reasoner.request(self.domain, &Request { name, args: &args? })?
            }
            Expr::Fact { fact, args } => {
                let args: Option<Vec<Value>> = args.iter().map(|a| self.value(a, frame)).collect();
                Value::Bool(self.defined(*fact, &args?))
            }
            Expr::GeometricCost => Value::Number(self.projection.0),
            Expr::GeometricDuration => Value::Number(self.projection.1),
        })
    }

    /// Says whether a fact that the domain defines holds of `args`.
    fn defined(&mut self, fact: FactId, args: &[Value]) -> bool {
        let fact = &self.domain.facts[fact.index()];
        self.holds(&fact.body, &mut frame(args, fact.n_vars))
    }

    fn set(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<Arc<EntitySet>> {
        match self.value(expr, frame)? {
            Value::Set(set) => Some(set),
            Value::Null
            | Value::Bool(_)
            | Value::Number(_)
            | Value::String(_)
            | Value::Entity(_)
            | Value::Scalars(_) => None,
        }
    }

    /// Returns the number, or `None` where there is none.
    pub fn number(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<f64> {
        match self.value(expr, frame)? {
            Value::Number(x) => Some(x),
            Value::Null | Value::Bool(_) | Value::Set(_) | Value::String(_) | Value::Entity(_) | Value::Scalars(_) => {
                None
            }
        }
    }

    /// Says whether the test holds.
    pub fn holds(&mut self, test: &Test, frame: &mut [Value]) -> bool {
        match test {
            Test::And(parts) => parts.iter().all(|t| self.holds(t, frame)),
            Test::Or(parts) => parts.iter().any(|t| self.holds(t, frame)),
            Test::Not(inner) => !self.holds(inner, frame),
            Test::Compare { op, left, right } => {
                let (left, right) = (self.value(left, frame), self.value(right, frame));
                match (left, right) {
                    (Some(l), Some(r)) => compare(*op, &l, &r),
                    (None, _) | (_, None) => *op == CompareOp::NotEqual,
                }
            }
            Test::Member { element, set } => match (self.value(element, frame), self.set(set, frame)) {
                (Some(Value::Entity(e)), Some(members)) => members.contains(e),
                _ => false,
            },
            Test::Forall { var, ty, guard, body } => {
                !self.any(*var, *ty, frame, &mut |c, f| c.holds(guard, f) && !c.holds(body, f))
            }
            Test::Exist { var, ty, guard, body } => {
                self.any(*var, *ty, frame, &mut |c, f| c.holds(guard, f) && c.holds(body, f))
            }
            Test::Holds(expr) => self.value(expr, frame) == Some(Value::Bool(true)),
        }
    }

    fn any(
        &mut self,
        var: Var,
        ty: TypeId,
        frame: &mut [Value],
        found: &mut dyn FnMut(&mut Self, &mut [Value]) -> bool,
    ) -> bool {
        let domain = self.domain;
        domain.types[ty.index()].entities.iter().any(|e| {
            frame[var.index()] = Value::Entity(*e);
            found(self, frame)
        })
    }

    /// Applies the effects in order, each in the state that the ones before have left; pushes the slots written.
    pub fn apply(&mut self, effects: &[Effect], frame: &mut [Value], writes: &mut Vec<SlotId>) {
        for effect in effects {
            match effect {
                Effect::Assign {
                    entity,
                    attribute,
                    value,
                } => {
                    let target = self.target(entity, *attribute, frame);
                    if let (Some(slot), Some(value)) = (target, self.value(value, frame)) {
                        self.state.set(slot, value);
                        writes.push(slot);
                    }
                }
                Effect::Add {
                    entity,
                    attribute,
                    element,
                }
                | Effect::Remove {
                    entity,
                    attribute,
                    element,
                } => {
                    let target = self.target(entity, *attribute, frame);
                    let (Some(slot), Some(Value::Entity(e))) = (target, self.value(element, frame)) else {
                        continue;
                    };
                    let mut members = match self.slot(slot) {
                        Value::Set(set) => (*set).clone(),
                        _ => EntitySet::default(),
                    };
                    if matches!(effect, Effect::Add { .. }) {
                        members.insert(e);
                    } else {
                        members.remove(e);
                    }
                    self.state.set(slot, Value::Set(Arc::new(members)));
                    writes.push(slot);
                }
                Effect::Forall {
                    var,
                    ty,
                    guard,
                    effects,
                } => {
                    let domain = self.domain;
                    for e in &domain.types[ty.index()].entities {
                        frame[var.index()] = Value::Entity(*e);
                        if self.holds(guard, frame) {
                            self.apply(effects, frame, writes);
                        }
                    }
                }
                Effect::If { test, then, otherwise } => {
                    let branch = if self.holds(test, frame) { then } else { otherwise };
                    self.apply(branch, frame, writes);
                }
            }
        }
    }

    /// Returns the slot to write; `None` when the path goes through NULL: the effect then changes nothing.
    fn target(&mut self, entity: &Expr, attribute: AttributeId, frame: &mut [Value]) -> Option<SlotId> {
        match self.value(entity, frame)? {
            Value::Entity(e) => self.slot_of(e, attribute),
            _ => None,
        }
    }
}

fn compare(op: CompareOp, left: &Value, right: &Value) -> bool {
    let numbers = match (left, right) {
        (Value::Number(l), Value::Number(r)) => l.partial_cmp(r),
        _ => None,
    };
    match op {
        CompareOp::Equal => left == right,
        CompareOp::NotEqual => left != right,
        CompareOp::Less => numbers.is_some_and(|o| o.is_lt()),
        CompareOp::LessEqual => numbers.is_some_and(|o| o.is_le()),
        CompareOp::Greater => numbers.is_some_and(|o| o.is_gt()),
        CompareOp::GreaterEqual => numbers.is_some_and(|o| o.is_ge()),
    }
}
