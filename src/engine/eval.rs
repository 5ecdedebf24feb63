//! Values of expressions, truth of tests, and effects, in the current state.
//!
//! NULL (language, section 2): a path whose step before the last is NULL has no value at all; a literal with such a path is
//! false (`!=`: true). An unset last step is the value `NULL`, equal to `NULL`. A division by zero has no value either.

use std::sync::Arc;

use super::reasoner::{Reasoner, Request};
use super::sets;
use super::state::State;
use crate::ir::{
    ArithmeticOp, AttributeId, Base, CompareOp, Domain, Effect, EntityId, EntitySet, Expr, FactId, RequestId, SlotId,
    Test, TypeId, Value, Var,
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
    pub missed: Vec<Missed>,
    /// Answers about the world state before the action at hand, for what asks when it is late.
    pub answers: Vec<(RequestId, Vec<Value>, Option<Value>)>,
}

/// Something about the world state before an action that nobody has looked at in time.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Missed {
    Slot(SlotId),
    Request(RequestId, Vec<Value>),
}

/// What a look at an expression tells without computing anything.
enum Seen<'v> {
    Here(&'v Value),
    /// A step of its path goes through NULL.
    Nowhere,
    /// It has to be computed, or read from geometry.
    NotYet,
}

/// Which entities can pass a guard.
enum Only<'t> {
    Any,
    Is(&'t Expr),
    Member(&'t Expr),
}

/// Returns which entities can pass a guard about `var`, as its first literal says.
fn only(guard: &Test, var: Var) -> Only<'_> {
    let is_var = |e: &Expr| matches!(e, Expr::Var(v) if *v == var);
    let is_free = |e: &Expr| !e.any(&mut |e| is_var(e));
    // What asks geometry is asked for each entity, as it is written.
    let is_path = |e: &Expr| !e.any(&mut |e| matches!(e, Expr::Request { .. } | Expr::Fact { .. })) && is_free(e);
    let first = match guard {
        Test::And(parts) => parts.first(),
        other => Some(other),
    };
    match first {
        Some(Test::Member { element, set }) if is_var(element) && is_path(set) => Only::Member(set),
        Some(Test::Compare {
            op: CompareOp::Equal,
            left,
            right,
        }) => match (is_var(left), is_var(right)) {
            (true, _) if is_path(right) => Only::Is(right),
            (_, true) if is_path(left) => Only::Is(left),
            _ => Only::Any,
        },
        Some(_) | None => Only::Any,
    }
}

/// Says whether a guard about `var` names no entities, so that all of its type are looked at.
pub(super) fn looks_at_all(guard: &Test, var: Var) -> bool {
    matches!(only(guard, var), Only::Any)
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
            answers: Vec::new(),
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
            self.missed.push(Missed::Slot(slot));
            return Value::Null;
        }
        let place = self.domain.slots[slot.index()];
        let name = self.domain.attributes[place.attribute.index()].fact.as_deref();
        let value = match name.and_then(|name| defined_fact(self.domain, name)) {
            Some(fact) => self.shared_value(fact, place.attribute, place.entity),
            None => self.reasoner.fact(self.domain, place.attribute, place.entity),
        };
        self.state.remember(slot, value.clone());
        value
    }

    /// Returns the value of a shared attribute whose fact the domain defines: a truth value for a fact about one entity,
    /// else the entities about which it holds (the first one, for an attribute that has one value).
    fn shared_value(&mut self, fact: FactId, attribute: AttributeId, entity: EntityId) -> Value {
        let domain = self.domain;
        let attribute = &domain.attributes[attribute.index()];
        // A fact asks requests and static attributes: nothing that an action could write.
        let n_reads = self.reads.len();
        let value = match attribute.base {
            Base::Entity(ty) => {
                let mut holds = domain.types[ty.index()]
                    .entities
                    .iter()
                    .filter(|other| self.is_defined(fact, &[Value::Entity(entity), Value::Entity(**other)]));
                if attribute.is_set {
                    Value::Set(Arc::new(holds.copied().collect()))
                } else {
                    holds.next().map_or(Value::Null, |e| Value::Entity(*e))
                }
            }
            Base::Bool | Base::Number | Base::String => Value::Bool(self.is_defined(fact, &[Value::Entity(entity)])),
        };
        self.reads.truncate(n_reads);
        value
    }

    /// Asks the world state of now; when it is late, that of before the action at hand.
    pub fn ask(&mut self, request: RequestId, args: Vec<Value>) -> Option<Value> {
        if self.is_late {
            let known = self.answers.iter().find(|(r, a, _)| *r == request && *a == args);
            if let Some((.., answer)) = known {
                return answer.clone();
            }
            self.missed.push(Missed::Request(request, args));
            return None;
        }
        let name = &self.domain.requests[request.index()].name;
        self.reasoner.request(self.domain, &Request { name, args: &args })
    }

    /// Looks at what was missed. The world state must be the one before the action at hand.
    pub fn catch_up(&mut self, missed: Vec<Missed>) {
        for missed in missed {
            match missed {
                Missed::Slot(slot) => {
                    self.slot(slot);
                }
                Missed::Request(request, args) => {
                    let answer = self.ask(request, args.clone());
                    self.answers.push((request, args, answer));
                }
            }
        }
    }

    /// Returns the value, or `None` when a step of its path goes through NULL (or a number through one), or a number would
    /// not be finite.
    pub fn value(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<Value> {
        let n_reads = self.reads.len();
        match see(self.domain, self.state, &mut self.reads, expr, frame) {
            Seen::Here(value) => Some(value.clone()),
            Seen::Nowhere => None,
            Seen::NotYet => {
                self.reads.truncate(n_reads);
                self.computed(expr, frame)
            }
        }
    }

    /// Returns the value of an expression that has to be computed.
    fn computed(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<Value> {
        Some(match expr {
            Expr::Const(value) => value.clone(),
            Expr::Var(var) => frame[var.index()].clone(),
            Expr::Attribute { base, attribute, args } => {
                let slot = self.target(base, *attribute, args, frame)?;
                self.reads.push(slot);
                self.slot(slot)
            }
            Expr::Size(set) => {
                let n_reads = self.reads.len();
                let len = match see(self.domain, self.state, &mut self.reads, set, frame) {
                    Seen::Here(set) => sets::len(set),
                    Seen::Nowhere => None,
                    Seen::NotYet => {
                        self.reads.truncate(n_reads);
                        sets::len(&self.computed(set, frame)?)
                    }
                };
                Value::Number(len? as f64)
            }
            Expr::List(elements) => {
                let mut set = Value::Set(Arc::new(EntitySet::default()));
                for element in elements {
                    let element = self.value(element, frame)?;
                    set = sets::with(set, &element)?;
                }
                set
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
                let members = self.value(set, frame)?;
                let element = self.value(element, frame)?;
                if matches!(expr, Expr::SetWith { .. }) {
                    sets::with(members, &element)?
                } else {
                    sets::without(members, &element)?
                }
            }
            Expr::Request { request, args } => {
                let args: Option<Vec<Value>> = args.iter().map(|a| self.value(a, frame)).collect();
                self.ask(*request, args?)?
            }
            Expr::Fact { fact, args } => {
                let args: Option<Vec<Value>> = args.iter().map(|a| self.value(a, frame)).collect();
                Value::Bool(self.is_defined(*fact, &args?))
            }
            Expr::GeometricCost => Value::Number(self.projection.0),
            Expr::GeometricDuration => Value::Number(self.projection.1),
        })
    }

    /// Says whether a fact that the domain defines holds of `args`.
    fn is_defined(&mut self, fact: FactId, args: &[Value]) -> bool {
        let fact = &self.domain.facts[fact.index()];
        self.holds(&fact.body, &mut frame(args, fact.n_vars))
    }

    /// Returns the number, or `None` where there is none.
    pub fn number(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<f64> {
        if let Expr::Const(Value::Number(x)) = expr {
            return Some(*x);
        }
        let n_reads = self.reads.len();
        match see(self.domain, self.state, &mut self.reads, expr, frame) {
            Seen::Here(Value::Number(x)) => Some(*x),
            Seen::Here(_) | Seen::Nowhere => None,
            Seen::NotYet => {
                self.reads.truncate(n_reads);
                match self.computed(expr, frame)? {
                    Value::Number(x) => Some(x),
                    _ => None,
                }
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
                let holds = |l: &Value, r: &Value| compare(*op, l, r);
                self.of_both(left, right, frame, holds)
                    .unwrap_or(*op == CompareOp::NotEqual)
            }
            Test::Member { element, set } => {
                let holds = |e: &Value, s: &Value| sets::contains(s, e);
                self.of_both(element, set, frame, holds).unwrap_or(false)
            }
            Test::Forall { var, ty, guard, body } => !self.any(*var, *ty, guard, frame, &mut |c, f| {
                c.holds(guard, f) && !c.holds(body, f)
            }),
            Test::Exist { var, ty, guard, body } => self.any(*var, *ty, guard, frame, &mut |c, f| {
                c.holds(guard, f) && c.holds(body, f)
            }),
            Test::Holds(expr) => self.value(expr, frame) == Some(Value::Bool(true)),
        }
    }

    /// Returns what `of` says of two values; `None` where one of them is missing. Nothing is copied where both are known.
    #[inline]
    fn of_both(
        &mut self,
        left: &Expr,
        right: &Expr,
        frame: &mut [Value],
        of: impl Fn(&Value, &Value) -> bool,
    ) -> Option<bool> {
        let n_reads = self.reads.len();
        let l = see(self.domain, self.state, &mut self.reads, left, frame);
        let r = see(self.domain, self.state, &mut self.reads, right, frame);
        match (l, r) {
            (Seen::Here(l), Seen::Here(r)) => Some(of(l, r)),
            (Seen::NotYet, _) | (_, Seen::NotYet) => {
                self.reads.truncate(n_reads);
                let (l, r) = (self.value(left, frame), self.value(right, frame));
                Some(of(&l?, &r?))
            }
            (Seen::Nowhere, _) | (_, Seen::Nowhere) => None,
        }
    }

    /// Says whether `found` says so of an entity that may pass the guard. Where the first literal of the guard names the only
    /// ones that may, no other is looked at: the others would read what it reads, and nothing more.
    fn any(
        &mut self,
        var: Var,
        ty: TypeId,
        guard: &Test,
        frame: &mut [Value],
        found: &mut dyn FnMut(&mut Self, &mut [Value]) -> bool,
    ) -> bool {
        let domain = self.domain;
        let entities = &domain.types[ty.index()].entities;
        let mut look = |context: &mut Self, frame: &mut [Value], e: EntityId| {
            frame[var.index()] = Value::Entity(e);
            found(context, frame)
        };
        if entities.is_empty() {
            return false;
        }
        match only(guard, var) {
            Only::Any => entities.iter().any(|e| look(self, frame, *e)),
            Only::Is(value) => match self.value(value, frame) {
                Some(Value::Entity(e)) => entities.binary_search(&e).is_ok() && look(self, frame, e),
                Some(_) | None => false,
            },
            Only::Member(set) => match self.value(set, frame) {
                Some(Value::Set(members)) => members
                    .iter()
                    .any(|e| entities.binary_search(&e).is_ok() && look(self, frame, e)),
                Some(_) | None => false,
            },
        }
    }

    /// Applies the effects in order, each in the state that the ones before have left; pushes the slots written.
    pub fn apply(&mut self, effects: &[Effect], frame: &mut [Value], writes: &mut Vec<SlotId>) {
        for effect in effects {
            match effect {
                Effect::Assign {
                    entity,
                    attribute,
                    args,
                    value,
                } => {
                    let target = self.target(entity, *attribute, args, frame);
                    if let (Some(slot), Some(value)) = (target, self.value(value, frame)) {
                        self.state.set(slot, value);
                        writes.push(slot);
                    }
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
                    let target = self.target(entity, *attribute, args, frame);
                    let (Some(slot), Some(element)) = (target, self.value(element, frame)) else {
                        continue;
                    };
                    let members = self.slot(slot);
                    let changed = if matches!(effect, Effect::Add { .. }) {
                        sets::with(members, &element)
                    } else {
                        sets::without(members, &element)
                    };
                    let Some(members) = changed else { continue };
                    self.state.set(slot, members);
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

    /// Returns the slot of an attribute of what a path leads to; `None` when the path goes through NULL: an effect then
    /// changes nothing.
    fn target(&mut self, entity: &Expr, attribute: AttributeId, args: &[Expr], frame: &mut [Value]) -> Option<SlotId> {
        let entity = self.entity(entity, frame)?;
        let attribute = &self.domain.attributes[attribute.index()];
        let mut slot = attribute.slots[entity.index()]?;
        if args.is_empty() {
            return Some(slot);
        }
        for (argument, arg) in attribute.arguments.iter().chain(&attribute.believer).zip(args) {
            slot.0 += argument.offsets[self.entity(arg, frame)?.index()]?;
        }
        Some(slot)
    }

    /// Returns the entity, or `None` where there is none.
    #[inline]
    fn entity(&mut self, expr: &Expr, frame: &mut [Value]) -> Option<EntityId> {
        if let Expr::Var(var) = expr {
            return match &frame[var.index()] {
                Value::Entity(e) => Some(*e),
                _ => None,
            };
        }
        let n_reads = self.reads.len();
        match see(self.domain, self.state, &mut self.reads, expr, frame) {
            Seen::Here(Value::Entity(e)) => Some(*e),
            Seen::Here(_) | Seen::Nowhere => None,
            Seen::NotYet => {
                self.reads.truncate(n_reads);
                match self.computed(expr, frame)? {
                    Value::Entity(e) => Some(e),
                    _ => None,
                }
            }
        }
    }
}

/// Looks at a constant, a variable, or a path all slots of which are known; notes the slots.
#[inline]
fn see<'v>(domain: &Domain, state: &'v State, reads: &mut Vec<SlotId>, expr: &'v Expr, frame: &'v [Value]) -> Seen<'v> {
    match expr {
        Expr::Const(value) => Seen::Here(value),
        Expr::Var(var) => Seen::Here(&frame[var.index()]),
        Expr::Attribute { base, attribute, args } => see_path(domain, state, reads, base, (*attribute, args), frame),
        _ => Seen::NotYet,
    }
}

fn see_path<'v>(
    domain: &Domain,
    state: &'v State,
    reads: &mut Vec<SlotId>,
    base: &'v Expr,
    (attribute, args): (AttributeId, &'v [Expr]),
    frame: &'v [Value],
) -> Seen<'v> {
    let base = match base {
        Expr::Var(var) => &frame[var.index()],
        base => match see(domain, state, reads, base, frame) {
            Seen::Here(base) => base,
            other => return other,
        },
    };
    let Value::Entity(entity) = base else {
        return Seen::Nowhere;
    };
    let attribute = &domain.attributes[attribute.index()];
    let Some(mut slot) = attribute.slots[entity.index()] else {
        return Seen::Nowhere;
    };
    if args.is_empty() {
        reads.push(slot);
        return state.get(slot).map_or(Seen::NotYet, Seen::Here);
    }
    for (argument, arg) in attribute.arguments.iter().chain(&attribute.believer).zip(args) {
        let arg = match see(domain, state, reads, arg, frame) {
            Seen::Here(arg) => arg,
            other => return other,
        };
        let offset = match arg {
            Value::Entity(arg) => argument.offsets[arg.index()],
            _ => None,
        };
        match offset {
            Some(offset) => slot.0 += offset,
            None => return Seen::Nowhere,
        }
    }
    reads.push(slot);
    state.get(slot).map_or(Seen::NotYet, Seen::Here)
}

/// Returns the fact of that name that the domain defines.
pub(super) fn defined_fact(domain: &Domain, name: &str) -> Option<FactId> {
    let position = domain.facts.iter().position(|f| f.name == name)?;
    Some(FactId(position as u32))
}

#[inline]
pub(super) fn compare(op: CompareOp, left: &Value, right: &Value) -> bool {
    let numbers = match (left, right) {
        (Value::Number(l), Value::Number(r)) => l.partial_cmp(r),
        _ => None,
    };
    match op {
        CompareOp::Equal => sets::equal(left, right),
        CompareOp::NotEqual => !sets::equal(left, right),
        CompareOp::Less => numbers.is_some_and(|o| o.is_lt()),
        CompareOp::LessEqual => numbers.is_some_and(|o| o.is_le()),
        CompareOp::Greater => numbers.is_some_and(|o| o.is_gt()),
        CompareOp::GreaterEqual => numbers.is_some_and(|o| o.is_ge()),
    }
}
