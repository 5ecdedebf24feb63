//! What is worked out once before a search: which subtask comes when, which variables matter, where a SELECT need not look.

use super::fold::{Fixed, Folded, Folder, literals};
use crate::ir::{
    Action, ActionId, AttributeId, Base, Binder, CompareOp, Decomposition, Domain, Expr, MethodId, Test, TypeId, Value,
    Var,
};

/// What is known of every decomposition of a domain.
#[derive(Debug)]
pub(super) struct Prepared {
    orders: Vec<Order>,
    /// The number of each method's first decomposition in `orders`.
    first: Vec<u32>,
    /// Whether some action is projected onto geometry.
    pub projects: bool,
    /// By action.
    actions: Vec<OfAction>,
    /// By method: its goal.
    goals: Vec<Option<Folded>>,
    /// By slot: whether it keeps its first value.
    pub is_fixed: Vec<bool>,
}

/// An action's precondition and numbers.
#[derive(Debug)]
pub(super) struct OfAction {
    pub preconditions: Folded,
    /// Cost, least and most duration [s], where these are the same whatever the arguments and the state are, and valid.
    pub numbers: Option<[f64; 3]>,
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
    pub preconditions: Folded,
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
    pub test: Rest,
}

/// A test that is made here, with what never changes worked out.
#[derive(Debug)]
pub(super) struct Rest {
    pub test: Test,
    pub folded: Folded,
}

/// What a filter says of a SELECT's variable that needs no look at every entity. `rest` is what is left of the filter.
#[derive(Debug)]
pub(super) enum Join {
    /// Nothing: every entity is looked at.
    None { rest: Rest },
    /// It is this.
    Is { value: Expr, rest: Rest },
    /// A static attribute of it is this, or has this as a member: the positions of those that have an entity there, by that
    /// entity.
    Has {
        value: Expr,
        rest: Rest,
        places: Vec<Vec<u32>>,
    },
    /// It is a member of this.
    Member { set: Expr, rest: Rest },
}

impl Prepared {
    pub fn new(domain: &Domain, fixed: &Fixed) -> Self {
        let mut folder = Folder::new(domain, fixed);
        let action = |a: &crate::ir::Action| OfAction {
            preconditions: folder.fold(&a.preconditions),
            numbers: numbers(a),
        };
        let mut prepared = Prepared {
            orders: Vec::new(),
            first: Vec::new(),
            projects: domain.actions.iter().any(|a| a.projects.is_some()),
            actions: domain.actions.iter().map(action).collect(),
            goals: Vec::new(),
            is_fixed: domain.slots.iter().map(|s| fixed.has(s.attribute)).collect(),
        };
        for method in &domain.methods {
            prepared.first.push(prepared.orders.len() as u32);
            prepared.goals.push(method.goal.as_ref().map(|goal| folder.fold(goal)));
            let orders = method.decompositions.iter().map(|d| order(domain, &mut folder, d));
            prepared.orders.extend(orders);
        }
        prepared
    }

    /// Returns the number of a decomposition among all of the domain.
    pub fn number(&self, method: MethodId, decomposition: usize) -> u32 {
        self.first[method.index()] + decomposition as u32
    }

    #[inline]
    pub fn order(&self, number: u32) -> &Order {
        &self.orders[number as usize]
    }

    #[inline]
    pub fn action(&self, action: ActionId) -> &OfAction {
        &self.actions[action.index()]
    }

    #[inline]
    pub fn goal(&self, method: MethodId) -> Option<&Folded> {
        self.goals[method.index()].as_ref()
    }
}

/// Returns an action's cost and durations where they are constants that it may have.
fn numbers(action: &Action) -> Option<[f64; 3]> {
    let number = |e: &Expr| match e {
        Expr::Const(Value::Number(x)) => Some(*x),
        _ => None,
    };
    let (least, most) = &action.duration;
    let numbers @ [cost, least, most] = [number(&action.cost)?, number(least)?, number(most)?];
    (cost >= 0.0 && least >= 0.0 && most >= least).then_some(numbers)
}

fn order(domain: &Domain, folder: &mut Folder<'_>, decomposition: &Decomposition) -> Order {
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
        preconditions: folder.fold(&decomposition.preconditions),
        joins: decomposition.binders.iter().map(|b| join(domain, folder, b)).collect(),
        early: early(domain, folder, &decomposition.binders),
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

fn early(domain: &Domain, folder: &mut Folder<'_>, binders: &[Binder]) -> Box<[Box<[Early]>]> {
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
                test: rest(folder, literal.clone()),
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

fn rest(folder: &mut Folder<'_>, test: Test) -> Rest {
    Rest {
        folded: folder.fold(&test),
        test,
    }
}

fn join(domain: &Domain, folder: &mut Folder<'_>, binder: &Binder) -> Join {
    let Binder::Select { var, ty, filter, .. } = binder else {
        return Join::None {
            rest: rest(folder, Test::always()),
        };
    };
    let fixed = folder.fixed;
    let late = literals(filter).iter().filter(|t| !is_early(domain, t, *var));
    let parts: Vec<Test> = late.cloned().collect();
    let is_var = |e: &Expr| matches!(e, Expr::Var(v) if v == var);
    let is_free = |e: &Expr| {
        let mut free = true;
        mentioned(e, &mut |v| free &= v != *var);
        free
    };
    let mut without = |i: usize| rest(folder, Test::And([&parts[..i], &parts[i + 1..]].concat()));
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
                        && let Some(places) = places(domain, fixed, *ty, *attribute)
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
                    && let Some(places) = places(domain, fixed, *ty, *attribute)
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
    has.or(member).unwrap_or_else(|| Join::None {
        rest: rest(folder, Test::And(parts)),
    })
}

/// Returns, for each entity, the positions of those of a type that have it as the value of an attribute, or as a member of
/// it; `None` where that may change, or where values are no entities.
fn places(domain: &Domain, fixed: &Fixed, ty: TypeId, attribute: AttributeId) -> Option<Vec<Vec<u32>>> {
    let of = &domain.attributes[attribute.index()];
    if !fixed.has(attribute) || !matches!(of.base, Base::Entity(_)) {
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
