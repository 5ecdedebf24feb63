//! Tests, expressions and effects on a state, for the replay alone.
//!
//! A plain walk over the tree, with none of the engine's compilation, undo or bit tricks: slow, and easy to believe.
//! A step through NULL has no value: a comparison with it is false, `!=` is true, and `let` names `NULL` (language,
//! section 2). Arithmetic on something that is not a number, a division by zero, and a list or set with a member that is
//! `NULL` have no value either.
//!
//! An answer of geometry may be unclear (`requests`). A test then holds as the plan needs it, unless a view is strict.

use std::cell::RefCell;
use std::sync::Arc;

use super::history::History;
use super::requests::{Answer, Asked, ROUNDING};
use super::sets;
use crate::ir::{
    ArithmeticOp, AttributeId, CompareOp, Domain, Effect, EntityId, EntitySet, Expr, SlotId, Test, TypeId, Value, Var,
    show_expr,
};

/// What an evaluation has looked at, and what effects have changed.
#[derive(Default)]
pub(super) struct Touched {
    pub(super) reads: Vec<SlotId>,
    pub(super) writes: Vec<SlotId>,
    /// What each of `writes` was before.
    pub(super) before: Vec<Value>,
    /// Whether geometry was asked.
    pub(super) asks: bool,
    /// Whether geometry was changed; evaluation never does.
    pub(super) moves: bool,
}

/// Around a state: what geometry computed for the action at hand, and what it answers.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) domain: &'a Domain,
    /// What `GetGRPCost()` and `GetGRPDuration()` give.
    pub(super) geometric: (f64, f64),
    /// The world that requests ask; without one they have no value.
    pub(super) asked: Option<&'a Asked<'a>>,
    /// What becomes of an answer that may or may not hold: whether it is taken in favour of the test.
    pub(super) lenient: bool,
    /// Where to note what is touched, if anybody wants to know.
    pub(super) touched: Option<&'a RefCell<Touched>>,
}

impl<'a> Around<'a> {
    /// Without motions at hand; takes the plan's word for what is unclear.
    pub(super) fn new(domain: &'a Domain, asked: Option<&'a Asked<'a>>) -> Self {
        Around {
            domain,
            geometric: (0.0, 0.0),
            asked,
            lenient: true,
            touched: None,
        }
    }

    pub(super) fn note(&self, note: impl FnOnce(&mut Touched)) {
        if let Some(touched) = self.touched {
            note(&mut touched.borrow_mut());
        }
    }
}

/// A state to look at.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) around: Around<'a>,
    pub(super) values: Values<'a>,
}

/// The values of all slots.
#[derive(Clone, Copy)]
pub(super) enum Values<'a> {
    Now(&'a [Value]),
    /// After so many actions.
    Past(&'a History, usize),
}

impl<'a> Values<'a> {
    fn get(self, slot: SlotId) -> Option<&'a Value> {
        match self {
            Values::Now(values) => values.get(slot.index()),
            Values::Past(history, time) => history.at(time, slot),
        }
    }
}

impl<'a> View<'a> {
    /// Returns a view without motions at hand; it takes the plan's word for what is unclear.
    pub(super) fn new(domain: &'a Domain, values: &'a [Value], asked: Option<&'a Asked<'a>>) -> Self {
        View {
            around: Around::new(domain, asked),
            values: Values::Now(values),
        }
    }

    /// As [`View::new`], of the state after so many actions.
    pub(super) fn past(
        domain: &'a Domain,
        (history, time): (&'a History, usize),
        asked: Option<&'a Asked<'a>>,
    ) -> Self {
        View {
            around: Around::new(domain, asked),
            values: Values::Past(history, time),
        }
    }

    /// Returns a view for which a test holds only if it certainly does.
    pub(super) fn strict(mut self) -> Self {
        self.around.lenient = false;
        self
    }

    fn flipped(mut self) -> Self {
        self.around.lenient = !self.around.lenient;
        self
    }

    /// Returns the place of an attribute's value; `None` where its entity or an argument is NULL.
    fn slot(&self, base: &Expr, attribute: AttributeId, args: &[Expr], frame: &[Value]) -> Option<SlotId> {
        let entity = |expr| match self.value(expr, frame)? {
            Value::Entity(e) => Some(e),
            _ => None,
        };
        let base = entity(base)?;
        let args: Option<Vec<EntityId>> = args.iter().map(entity).collect();
        self.around.domain.attributes[attribute.index()].slot(base, &args?)
    }

    /// Returns the expression's value; `None` after a step through NULL.
    pub(super) fn value(&self, expr: &Expr, frame: &[Value]) -> Option<Value> {
        match expr {
            Expr::Const(v) => Some(v.clone()),
            Expr::Var(v) => frame.get(v.index()).cloned(),
            Expr::Attribute { base, attribute, args } => {
                let slot = self.slot(base, *attribute, args, frame)?;
                self.around.note(|touched| touched.reads.push(slot));
                self.values.get(slot).cloned()
            }
            Expr::Request { request, args } => {
                self.around.note(|touched| touched.asks = true);
                let args: Option<Vec<Value>> = args.iter().map(|a| self.value(a, frame)).collect();
                let name = &self.around.domain.requests[request.index()].name;
                match self.around.asked?.ask(self.around.domain, name, &args?)? {
                    Answer::Truth { may, must } => Some(Value::Bool(if self.around.lenient { may } else { must })),
                    Answer::Length(x) => Some(Value::Number(x)),
                }
            }
            Expr::Fact { fact, args } => {
                let fact = &self.around.domain.facts[fact.index()];
                let args: Option<Vec<Value>> = args.iter().map(|a| self.value(a, frame)).collect();
                let mut frame = args?;
                frame.resize(fact.n_vars.max(frame.len()), Value::Null);
                Some(Value::Bool(self.holds(&fact.body, &mut frame)))
            }
            Expr::Size(set) => match self.value(set, frame)? {
                Value::Set(s) => Some(Value::Number(s.len() as f64)),
                Value::Scalars(s) => Some(Value::Number(s.len() as f64)),
                _ => None,
            },
            Expr::List(elements) => {
                let mut set = Value::Set(Arc::new(EntitySet::default()));
                for e in elements {
                    set = sets::with(set, &self.value(e, frame)?)?;
                }
                Some(set)
            }
            Expr::Arithmetic { op, left, right } => {
                let (a, b) = (self.number(left, frame)?, self.number(right, frame)?);
                let x = match op {
                    ArithmeticOp::Add => a + b,
                    ArithmeticOp::Subtract => a - b,
                    ArithmeticOp::Multiply => a * b,
                    ArithmeticOp::Divide => a / b,
                };
                x.is_finite().then_some(Value::Number(x))
            }
            Expr::Negate(inner) => Some(Value::Number(-self.number(inner, frame)?)),
            Expr::SetWith { set, element } => sets::with(self.value(set, frame)?, &self.value(element, frame)?),
            Expr::SetWithout { set, element } => sets::without(self.value(set, frame)?, &self.value(element, frame)?),
            Expr::GeometricCost => Some(Value::Number(self.around.geometric.0)),
            Expr::GeometricDuration => Some(Value::Number(self.around.geometric.1)),
        }
    }

    /// Returns the expression's number, if it is one.
    pub(super) fn number(&self, expr: &Expr, frame: &[Value]) -> Option<f64> {
        match self.value(expr, frame)? {
            Value::Number(x) => Some(x),
            _ => None,
        }
    }

    /// Says whether the test holds; `frame` comes back as it was.
    pub(super) fn holds(&self, test: &Test, frame: &mut [Value]) -> bool {
        match test {
            Test::And(tests) => tests.iter().all(|t| self.holds(t, frame)),
            Test::Or(tests) => tests.iter().any(|t| self.holds(t, frame)),
            Test::Not(inner) => !self.flipped().holds(inner, frame),
            Test::Compare { op, left, right } => {
                let asks = self.asks(left) || self.asks(right);
                self.either(asks, &|view| {
                    let (a, b) = (view.value(left, frame), view.value(right, frame));
                    match (&a, &b) {
                        // Two lengths that rounding can't tell apart compare as the plan needs it.
                        (Some(Value::Number(x)), Some(Value::Number(y))) if asks && (x - y).abs() <= ROUNDING => {
                            self.around.lenient
                        }
                        _ => compare(*op, a, b),
                    }
                })
            }
            Test::Member { element, set } => self.either(self.asks(element) || self.asks(set), &|view| match (
                view.value(element, frame),
                view.value(set, frame),
            ) {
                (Some(Value::Entity(e)), Some(Value::Set(s))) => s.contains(e),
                (Some(scalar), Some(Value::Scalars(s))) => s.contains(&scalar),
                _ => false,
            }),
            Test::Forall { var, ty, guard, body } => self.over(*var, *ty, frame, &mut |frame| {
                !self.flipped().holds(guard, frame) || self.holds(body, frame)
            }),
            Test::Exist { var, ty, guard, body } => !self.over(*var, *ty, frame, &mut |frame| {
                !(self.holds(guard, frame) && self.holds(body, frame))
            }),
            Test::Holds(expr) => self.value(expr, frame) == Some(Value::Bool(true)),
        }
    }

    /// Says whether a literal holds with unclear answers taken one way or the other, as the test needs it.
    fn either(&self, asks: bool, literal: &dyn Fn(View<'_>) -> bool) -> bool {
        if !asks {
            return literal(*self);
        }
        let (one, other) = (literal(*self), literal(self.flipped()));
        if self.around.lenient {
            one || other
        } else {
            one && other
        }
    }

    /// Says whether the expression asks the world.
    fn asks(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Request { .. } | Expr::Fact { .. } => true,
            Expr::Const(_) | Expr::Var(_) | Expr::GeometricCost | Expr::GeometricDuration => false,
            Expr::Attribute { base, args, .. } => self.asks(base) || args.iter().any(|e| self.asks(e)),
            Expr::Size(inner) | Expr::Negate(inner) => self.asks(inner),
            Expr::List(elements) => elements.iter().any(|e| self.asks(e)),
            Expr::Arithmetic { left, right, .. } => self.asks(left) || self.asks(right),
            Expr::SetWith { set, element } | Expr::SetWithout { set, element } => self.asks(set) || self.asks(element),
        }
    }

    /// Says whether `body` says yes for every entity of the type.
    fn over(&self, var: Var, ty: TypeId, frame: &mut [Value], body: &mut dyn FnMut(&mut [Value]) -> bool) -> bool {
        let before = frame[var.index()].clone();
        let mut all = true;
        for e in &self.around.domain.types[ty.index()].entities {
            frame[var.index()] = Value::Entity(*e);
            if !body(frame) {
                all = false;
                break;
            }
        }
        frame[var.index()] = before;
        all
    }

    /// Returns the first literal that makes the test fail, with its values; `None` if the test holds.
    pub(super) fn failing(&self, test: &Test, frame: &mut [Value]) -> Option<String> {
        match test {
            Test::And(tests) => tests.iter().find_map(|t| self.failing(t, frame)),
            _ if self.holds(test, frame) => None,
            Test::Forall { var, ty, guard, body } => {
                let before = frame[var.index()].clone();
                let mut found = None;
                for e in &self.around.domain.types[ty.index()].entities {
                    frame[var.index()] = Value::Entity(*e);
                    if self.flipped().holds(guard, frame) {
                        found = self.failing(body, frame);
                    }
                    if found.is_some() {
                        break;
                    }
                }
                frame[var.index()] = before;
                found
            }
            _ => Some(self.show_test(test, frame)),
        }
    }

    fn show_test(&self, test: &Test, frame: &[Value]) -> String {
        let expr = |e: &Expr| self.show_expr(e, frame);
        let with = |e: &Expr| match (e, self.value(e, frame)) {
            (Expr::Const(_) | Expr::Var(_), _) => String::new(),
            (_, Some(v)) => format!(" (it is {})", self.around.domain.show(&v)),
            (_, None) => " (a step through NULL)".to_owned(),
        };
        match test {
            Test::And(tests) => {
                let all: Vec<String> = tests.iter().map(|t| self.show_test(t, frame)).collect();
                all.join("; ")
            }
            Test::Or(tests) => {
                let all: Vec<String> = tests.iter().map(|t| self.show_test(t, frame)).collect();
                format!("none of {}", all.join(" or "))
            }
            Test::Not(inner) => format!("not {}", self.show_test(inner, frame)),
            Test::Compare { op, left, right } => {
                format!(
                    "`{} {} {}`{}{}",
                    expr(left),
                    op.symbol(),
                    expr(right),
                    with(left),
                    with(right)
                )
            }
            Test::Member { element, set } => format!("`{} >> {}`{}", expr(element), expr(set), with(set)),
            Test::Forall { ty, .. } => format!("a test of every `{}`", self.around.domain.types[ty.index()].name),
            Test::Exist { ty, .. } => format!("some `{}`", self.around.domain.types[ty.index()].name),
            Test::Holds(inner) => format!("`{}`{}", expr(inner), with(inner)),
        }
    }

    fn show_expr(&self, expr: &Expr, frame: &[Value]) -> String {
        let name = |var: Var| {
            frame
                .get(var.index())
                .map_or_else(String::new, |v| self.around.domain.show(v))
        };
        show_expr(self.around.domain, expr, &name)
    }
}

fn compare(op: CompareOp, left: Option<Value>, right: Option<Value>) -> bool {
    let (Some(left), Some(right)) = (left, right) else {
        return op == CompareOp::NotEqual;
    };
    let numbers = match (&left, &right) {
        (Value::Number(a), Value::Number(b)) => Some((*a, *b)),
        _ => None,
    };
    match op {
        CompareOp::Equal => sets::equal(&left, &right),
        CompareOp::NotEqual => !sets::equal(&left, &right),
        CompareOp::Less => numbers.is_some_and(|(a, b)| a < b),
        CompareOp::LessEqual => numbers.is_some_and(|(a, b)| a <= b),
        CompareOp::Greater => numbers.is_some_and(|(a, b)| a > b),
        CompareOp::GreaterEqual => numbers.is_some_and(|(a, b)| a >= b),
    }
}

/// Runs effects in order, each seeing what the ones before have changed. An effect whose target or value goes through NULL
/// does nothing.
pub(super) fn apply(around: Around<'_>, values: &mut [Value], effects: &[Effect], frame: &mut [Value]) {
    for effect in effects {
        let view = View {
            around,
            values: Values::Now(values),
        };
        match effect {
            Effect::Assign {
                entity,
                attribute,
                args,
                value,
            } => {
                let slot = view.slot(entity, *attribute, args, frame);
                if let (Some(slot), Some(value)) = (slot, view.value(value, frame)) {
                    put(around, values, slot, value);
                }
            }
            Effect::Add {
                entity,
                attribute,
                args,
                element,
            } => alter(view, (entity, *attribute, args), element, frame, sets::with)
                .into_iter()
                .for_each(|(slot, set)| put(around, values, slot, set)),
            Effect::Remove {
                entity,
                attribute,
                args,
                element,
            } => alter(view, (entity, *attribute, args), element, frame, sets::without)
                .into_iter()
                .for_each(|(slot, set)| put(around, values, slot, set)),
            Effect::Forall {
                var,
                ty,
                guard,
                effects,
            } => {
                let before = frame[var.index()].clone();
                for e in &around.domain.types[ty.index()].entities {
                    frame[var.index()] = Value::Entity(*e);
                    let view = View {
                        around,
                        values: Values::Now(values),
                    };
                    if view.holds(guard, frame) {
                        apply(around, values, effects, frame);
                    }
                }
                frame[var.index()] = before;
            }
            Effect::If { test, then, otherwise } => {
                let branch = if view.holds(test, frame) { then } else { otherwise };
                apply(around, values, branch, frame);
            }
        }
    }
}

/// Sets a slot's value, and notes what it was. Where NULL would be added to a set or removed nothing is written, and nobody
/// learns of it.
pub(super) fn put(around: Around<'_>, values: &mut [Value], slot: SlotId, value: Value) {
    let old = std::mem::replace(&mut values[slot.index()], value);
    around.note(|touched| {
        touched.writes.push(slot);
        touched.before.push(old);
    });
}

fn alter(
    view: View<'_>,
    (entity, attribute, args): (&Expr, AttributeId, &[Expr]),
    element: &Expr,
    frame: &[Value],
    change: fn(Value, &Value) -> Option<Value>,
) -> Option<(SlotId, Value)> {
    let slot = view.slot(entity, attribute, args, frame)?;
    let element = view.value(element, frame)?;
    view.around.note(|touched| touched.reads.push(slot));
    let set = view.values.get(slot)?.clone();
    Some((slot, change(set, &element)?))
}
