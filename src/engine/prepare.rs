//! What is worked out once before a search: which subtask comes when, which variables matter, where a SELECT need not look.

use crate::ir::{
    AttributeId, Base, Binder, CompareOp, Decomposition, Domain, Expr, MethodId, Test, TypeId, Value, Var,
};

/// What is known of every decomposition of a domain.
#[derive(Debug)]
pub(super) struct Prepared {
    orders: Vec<Order>,
    /// The number of each method's first decomposition in `orders`.
    first: Vec<u32>,
    /// Whether some action is projected onto geometry.
    pub projects: bool,
}

/// A decomposition's subtasks and binders.
#[derive(Debug)]
pub(super) struct Order {
    pub n_subtasks: usize,
    /// The subtasks in their order, if there is only one.
    pub chain: Option<Box<[u32]>>,
    /// The positions that come before each subtask.
    pub after: Vec<Vec<usize>>,
    /// The variables that some subtask's argument mentions: all that still matters of a frame.
    pub live: Box<[Var]>,
    /// A short cut for each binder, in their order.
    pub joins: Box<[Join]>,
    /// What is tested before each binder's turn, in their order.
    pub early: Box<[Box<[Early]>]>,
}

/// Literals of a SELECT's filter that do not mention its variable: they are tested as soon as all that they mention is bound.
/// Where they fail, no entity passes that filter, whatever is bound in between.
#[derive(Debug)]
pub(super) struct Early {
    pub binder: u32,
    pub test: Test,
}

/// What a filter says of a SELECT's variable that needs no look at every entity. `rest` is what is left of the filter.
#[derive(Debug)]
pub(super) enum Join {
    /// Nothing: every entity is looked at.
    None { rest: Test },
    /// It is this.
    Is { value: Expr, rest: Test },
    /// A static attribute of it is this, or has this as a member: the positions of those that have an entity there, by that
    /// entity.
    Has {
        value: Expr,
        rest: Test,
        places: Vec<Vec<u32>>,
    },
    /// It is a member of this.
    Member { set: Expr, rest: Test },
}

impl Prepared {
    pub fn new(domain: &Domain) -> Self {
        let mut prepared = Prepared {
            orders: Vec::new(),
            first: Vec::new(),
            projects: domain.actions.iter().any(|a| a.projects.is_some()),
        };
        for method in &domain.methods {
            prepared.first.push(prepared.orders.len() as u32);
            prepared
                .orders
                .extend(method.decompositions.iter().map(|d| order(domain, d)));
        }
        prepared
    }

    /// Returns the number of a decomposition among all of the domain.
    pub fn number(&self, method: MethodId, decomposition: usize) -> u32 {
        self.first[method.index()] + decomposition as u32
    }

    pub fn order(&self, number: u32) -> &Order {
        &self.orders[number as usize]
    }
}

fn order(domain: &Domain, decomposition: &Decomposition) -> Order {
    let subtasks = &decomposition.subtasks;
    let mut live: Vec<Var> = Vec::new();
    for arg in subtasks.iter().flat_map(|s| &s.args) {
        mentioned(arg, &mut |var| live.push(var));
    }
    live.sort();
    live.dedup();
    Order {
        n_subtasks: subtasks.len(),
        chain: chain(decomposition),
        after: subtasks.iter().map(|s| s.after.clone()).collect(),
        live: live.into(),
        joins: decomposition.binders.iter().map(|b| join(domain, b)).collect(),
        early: early(domain, &decomposition.binders),
    }
}

/// The literals of a filter.
fn literals(filter: &Test) -> &[Test] {
    match filter {
        Test::And(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    }
}

fn mentions(test: &Test, var: Var) -> bool {
    test.any(&mut |e| matches!(e, Expr::Var(v) if *v == var))
}

/// Says whether a literal of a filter can be tested before entities are looked at. One that asks geometry stays where it
/// is: what is asked, and how often, can be seen.
fn is_early(domain: &Domain, literal: &Test, var: Var) -> bool {
    let asks = |e: &Expr| match e {
        Expr::Request { .. } | Expr::Fact { .. } => true,
        Expr::Attribute { attribute, .. } => domain.attributes[attribute.index()].fact.is_some(),
        Expr::Const(_)
        | Expr::Var(_)
        | Expr::Size(_)
        | Expr::List(_)
        | Expr::Arithmetic { .. }
        | Expr::Negate(_)
        | Expr::SetWith { .. }
        | Expr::SetWithout { .. }
        | Expr::GeometricCost
        | Expr::GeometricDuration => false,
    };
    !mentions(literal, var) && !literal.any(&mut |e| asks(e))
}

fn early(domain: &Domain, binders: &[Binder]) -> Box<[Box<[Early]>]> {
    let mut early: Vec<Vec<Early>> = binders.iter().map(|_| Vec::new()).collect();
    for (i, binder) in binders.iter().enumerate() {
        let Binder::Select { var, filter, .. } = binder else {
            continue;
        };
        for literal in literals(filter).iter().filter(|t| is_early(domain, t, *var)) {
            let is_bound_by = |b: &Binder| match b {
                Binder::Select { var, .. } | Binder::Let { var, .. } => mentions(literal, *var),
            };
            let last = binders[..i].iter().rposition(is_bound_by);
            early[last.map_or(0, |last| last + 1)].push(Early {
                binder: i as u32,
                test: literal.clone(),
            });
        }
    }
    early.into_iter().map(Vec::into_boxed_slice).collect()
}

/// Returns the only order of the subtasks, if there is only one.
fn chain(decomposition: &Decomposition) -> Option<Box<[u32]>> {
    let subtasks = &decomposition.subtasks;
    let mut waits: Vec<usize> = subtasks.iter().map(|s| s.after.len()).collect();
    let mut followers: Vec<Vec<usize>> = vec![Vec::new(); subtasks.len()];
    for (i, subtask) in subtasks.iter().enumerate() {
        subtask.after.iter().for_each(|a| followers[*a].push(i));
    }
    let mut ready: Vec<usize> = (0..subtasks.len()).filter(|i| waits[*i] == 0).collect();
    let mut chain = Vec::with_capacity(subtasks.len());
    while let Some(i) = ready.pop() {
        if !ready.is_empty() {
            return None;
        }
        chain.push(i as u32);
        for f in &followers[i] {
            waits[*f] -= 1;
            if waits[*f] == 0 {
                ready.push(*f);
            }
        }
    }
    Some(chain.into())
}

fn join(domain: &Domain, binder: &Binder) -> Join {
    let Binder::Select { var, ty, filter, .. } = binder else {
        return Join::None { rest: Test::always() };
    };
    let late = literals(filter).iter().filter(|t| !is_early(domain, t, *var));
    let parts: Vec<Test> = late.cloned().collect();
    let is_var = |e: &Expr| matches!(e, Expr::Var(v) if v == var);
    let is_free = |e: &Expr| {
        let mut free = true;
        mentioned(e, &mut |v| free &= v != *var);
        free
    };
    let without = |i: usize| Test::And([&parts[..i], &parts[i + 1..]].concat());
    let (mut has, mut member) = (None, None);
    for (i, part) in parts.iter().enumerate() {
        match part {
            Test::Compare {
                op: CompareOp::Equal,
                left,
                right,
            } => {
                for (one, other) in [(left, right), (right, left)] {
                    if !is_free(other) {
                        continue;
                    }
                    if is_var(one) {
                        return Join::Is {
                            value: other.clone(),
                            rest: without(i),
                        };
                    }
                    if let (Expr::Attribute { base, attribute, args }, None) = (one, &has)
                        && is_var(base)
                        && args.is_empty()
                        && is_cheap(other)
                        && let Some(places) = places(domain, *ty, *attribute)
                    {
                        has = Some(Join::Has {
                            value: other.clone(),
                            rest: without(i),
                            places,
                        });
                    }
                }
            }
            Test::Member { element, set } if is_var(element) && is_free(set) && is_cheap(set) => {
                member.get_or_insert_with(|| Join::Member {
                    set: set.clone(),
                    rest: without(i),
                });
            }
            Test::Member {
                element,
                set: Expr::Attribute { base, attribute, args },
            } if is_var(base) && args.is_empty() && is_free(element) && is_cheap(element) => {
                if has.is_none()
                    && let Some(places) = places(domain, *ty, *attribute)
                {
                    has = Some(Join::Has {
                        value: element.clone(),
                        rest: without(i),
                        places,
                    });
                }
            }
            _ => {}
        }
    }
    has.or(member).unwrap_or(Join::None { rest: Test::And(parts) })
}

/// Returns, for each entity, the positions of those of a type that have it as the value of an attribute, or as a member of
/// it; `None` where that may change, or where values are no entities.
fn places(domain: &Domain, ty: TypeId, attribute: AttributeId) -> Option<Vec<Vec<u32>>> {
    let of = &domain.attributes[attribute.index()];
    if !is_static(domain, attribute) || !matches!(of.base, Base::Entity(_)) {
        return None;
    }
    let mut places = vec![Vec::new(); domain.entities.len()];
    for (at, entity) in domain.types[ty.index()].entities.iter().enumerate() {
        let Some(slot) = of.slots[entity.index()] else { continue };
        match &domain.initial[slot.index()] {
            Value::Entity(value) => places[value.index()].push(at as u32),
            Value::Set(members) => members.iter().for_each(|e| places[e.index()].push(at as u32)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Scalars(_) | Value::Unknown => {
            }
        }
    }
    Some(places)
}

/// Says whether a set is there to be looked at, so that looking once more costs nothing.
fn is_cheap(set: &Expr) -> bool {
    match set {
        Expr::Const(_) | Expr::Var(_) => true,
        Expr::Attribute { base, args, .. } => is_cheap(base) && args.iter().all(is_cheap),
        _ => false,
    }
}

/// Calls `found` for each variable of an expression.
pub(super) fn mentioned(expr: &Expr, found: &mut dyn FnMut(Var)) {
    match expr {
        Expr::Var(var) => found(*var),
        Expr::Const(_) | Expr::GeometricCost | Expr::GeometricDuration => {}
        Expr::Attribute { base, args, .. } => {
            mentioned(base, found);
            args.iter().for_each(|e| mentioned(e, found));
        }
        Expr::Size(inner) | Expr::Negate(inner) => mentioned(inner, found),
        Expr::List(all) | Expr::Request { args: all, .. } | Expr::Fact { args: all, .. } => {
            all.iter().for_each(|e| mentioned(e, found));
        }
        Expr::Arithmetic { left: a, right: b, .. }
        | Expr::SetWith { set: a, element: b }
        | Expr::SetWithout { set: a, element: b } => {
            mentioned(a, found);
            mentioned(b, found);
        }
    }
}

/// Says whether an attribute never changes.
pub(super) fn is_static(domain: &Domain, attribute: AttributeId) -> bool {
    let attribute = &domain.attributes[attribute.index()];
    attribute.is_static && attribute.fact.is_none()
}
