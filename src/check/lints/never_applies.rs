//! Tests that can't hold: of a decomposition, an action or a SELECT.
//!
//! Found are two tests of one conjunction that contradict each other, static tests that no entity of the variable's type
//! passes, and preconditions that repeat the method's goal: where it holds the method is done already. Only whole tests
//! are compared, as they are written; numbers are compared with constants.

use super::read::Read;
use super::{Linted, conjuncts};
use crate::diag::{Problem, Problems};
use crate::ir::{Base, Binder, CompareOp, Domain, EntityId, Expr, Param, Test, Type, TypeId, Value, Var};
use crate::source::Span;
use crate::syntax::ast::{Clause, Step};

/// A test and its place.
type Placed<'a> = (Span, &'a Test);

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    for (written, action) in &linted.actions {
        let of_clause = |clause: &Clause| match clause {
            Clause::Preconditions(tests, _) => conjuncts(tests, &action.preconditions),
            _ => Vec::new(),
        };
        let tests: Vec<Placed<'_>> = written.clauses.iter().flat_map(of_clause).collect();
        let what = format!("action `{}` can never be done", action.name);
        problems
            .0
            .extend(impossible(linted, &what, &tests, &types(&action.params)));
    }
    for (written, method) in &linted.methods {
        let goal = written.goals.first().map(|(tests, _)| tests);
        let goal = goal.zip(method.goal.as_ref());
        let goal: Vec<Placed<'_>> = goal.map(|(written, goal)| conjuncts(written, goal)).unwrap_or_default();
        for (written, decomposition) in written.decompositions.iter().zip(&method.decompositions) {
            let what = format!("a decomposition of `{}` can never apply", method.name);
            let tests = conjuncts(&written.preconditions, &decomposition.preconditions);
            let params = types(&method.params);
            let problem = impossible(linted, &what, &tests, &params);
            problems
                .0
                .extend(problem.or_else(|| repeats_goal(&what, &tests, &goal)));
            let selects = written.steps.iter().filter_map(|step| match step {
                Step::Select(select) => Some(select),
                Step::Let(_) | Step::Subtask(_) => None,
            });
            let compiled = decomposition.binders.iter().filter_map(|binder| match binder {
                Binder::Select { var, ty, filter, .. } => Some((*var, *ty, filter)),
                Binder::Let { .. } => None,
            });
            for (select, (var, ty, filter)) in selects.zip(compiled) {
                let what = format!("SELECT of `{}` never finds anything", select.name.text);
                let tests = conjuncts(&select.filter, filter);
                problems.0.extend(impossible(linted, &what, &tests, &[(var, ty)]));
            }
        }
    }
}

/// Returns the parameters that hold one entity, with their types.
fn types(params: &[Param]) -> Vec<(Var, TypeId)> {
    let of = |(i, param): (usize, &Param)| match param.base {
        Base::Entity(ty) if !param.is_set => Some((Var(i as u32), ty)),
        _ => None,
    };
    params.iter().enumerate().filter_map(of).collect()
}

/// Tests of one conjunction that are compared with one another. HEURISTIC: far above real domains.
const MOST_COMPARED: usize = 200;

/// Returns why the tests can't all hold.
fn impossible(linted: &Linted<'_>, what: &str, tests: &[Placed<'_>], variables: &[(Var, TypeId)]) -> Option<Problem> {
    for (i, (span, test)) in tests.iter().enumerate().take(MOST_COMPARED) {
        let before = tests.iter().take(i);
        if let Some((first, _)) = before.into_iter().find(|(_, other)| contradict(test, other)) {
            let message = format!("{what}: two tests contradict each other");
            let problem = Problem::warning(
                "hatp::never-applies",
                message,
                *span,
                "can't hold together with the other",
            );
            return Some(
                problem
                    .note(*first, "must hold, too")
                    .help("remove one of the two tests"),
            );
        }
    }
    variables
        .iter()
        .find_map(|(var, ty)| nobody(linted, what, tests, *var, *ty))
}

/// Says whether the two can't hold in one state.
fn contradict(a: &Test, b: &Test) -> bool {
    match (a, b) {
        (Test::Not(a), b) | (b, Test::Not(a)) if **a == *b => true,
        (
            Test::Compare { op, left, right },
            Test::Compare {
                op: other_op,
                left: other_left,
                right: other_right,
            },
        ) => {
            let (op, left, right) = turned(*op, left, right);
            let (other_op, other_left, other_right) = turned(*other_op, other_left, other_right);
            if *left != *other_left {
                return false;
            }
            match (op, other_op, right, other_right) {
                (CompareOp::Equal, CompareOp::Equal, a, b) => differ(a, b),
                (CompareOp::Equal, CompareOp::NotEqual, a, b) | (CompareOp::NotEqual, CompareOp::Equal, a, b) => a == b,
                (_, _, Expr::Const(Value::Number(a)), Expr::Const(Value::Number(b))) => is_empty(op, *a, other_op, *b),
                _ => false,
            }
        }
        _ => false,
    }
}

/// Says whether the two are different values for sure: a variable holds an entity, a number ..., and hardly `NULL`.
pub(super) fn differ(a: &Expr, b: &Expr) -> bool {
    match (a, b) {
        (Expr::Const(a), Expr::Const(b)) => a != b,
        (Expr::Const(Value::Null), Expr::Var(_)) | (Expr::Var(_), Expr::Const(Value::Null)) => true,
        _ => false,
    }
}

/// Returns the comparison with a constant, or else with a variable, on its right.
fn turned<'a>(op: CompareOp, left: &'a Expr, right: &'a Expr) -> (CompareOp, &'a Expr, &'a Expr) {
    let is_plain = matches!(left, Expr::Const(_)) || matches!(left, Expr::Var(_)) && !matches!(right, Expr::Const(_));
    if !is_plain {
        return (op, left, right);
    }
    let op = match op {
        CompareOp::Equal => CompareOp::Equal,
        CompareOp::NotEqual => CompareOp::NotEqual,
        CompareOp::Less => CompareOp::Greater,
        CompareOp::LessEqual => CompareOp::GreaterEqual,
        CompareOp::Greater => CompareOp::Less,
        CompareOp::GreaterEqual => CompareOp::LessEqual,
    };
    (op, right, left)
}

/// Says whether no number stands in both relations, to `a` and to `b`.
fn is_empty(op: CompareOp, a: f64, other: CompareOp, b: f64) -> bool {
    // Least and greatest number, each with whether it is allowed itself; `!=` leaves all but one.
    let range = |op: CompareOp, x: f64| match op {
        CompareOp::Equal => Some(((x, true), (x, true))),
        CompareOp::Less => Some(((f64::NEG_INFINITY, true), (x, false))),
        CompareOp::LessEqual => Some(((f64::NEG_INFINITY, true), (x, true))),
        CompareOp::Greater => Some(((x, false), (f64::INFINITY, true))),
        CompareOp::GreaterEqual => Some(((x, true), (f64::INFINITY, true))),
        CompareOp::NotEqual => None,
    };
    let (Some(one), Some(two)) = (range(op, a), range(other, b)) else {
        return false;
    };
    let apart = |most: (f64, bool), least: (f64, bool)| most.0 < least.0 || most.0 == least.0 && !(most.1 && least.1);
    apart(one.1, two.0) || apart(two.1, one.0)
}

/// Returns that no entity of the type passes all static tests that speak of `var` alone.
fn nobody(linted: &Linted<'_>, what: &str, tests: &[Placed<'_>], var: Var, ty: TypeId) -> Option<Problem> {
    let domain = linted.domain;
    let of_type = domain.types.get(ty.index())?;
    let is_static = |test: &Test| {
        let mut read = Read::default();
        read.test(test);
        let known = read.attributes.iter().filter_map(|a| domain.attributes.get(a.index()));
        let mut known = known;
        let alone = read.variables.iter().eq([&var]);
        alone && !read.asks_geometry && !read.attributes.is_empty() && known.all(|a| a.is_static && a.fact.is_none())
    };
    let tests: Vec<&Placed<'_>> = tests.iter().filter(|(_, test)| is_static(test)).collect();
    let (first, _) = tests.first()?;
    let passes = |entity: &EntityId| {
        let eval = Eval {
            domain,
            has_world: linted.has_world,
            var,
            entity: *entity,
        };
        tests.iter().all(|(_, test)| eval.test(test) != Some(false))
    };
    if of_type.entities.is_empty() || of_type.entities.iter().any(passes) {
        return None;
    }
    let whom = &of_type.name;
    let message = format!("{what}: no `{whom}` passes its static tests");
    let label = format!("holds for no `{whom}`");
    let label = if tests.len() == 1 {
        label
    } else {
        "the first of them".into()
    };
    let problem = Problem::warning("hatp::never-applies", message, *first, label);
    let help = values(domain, tests.iter().map(|(_, test)| test), of_type);
    Some(problem.help(help))
}

/// Values listed in a help line.
const MOST_LISTED: usize = 8;

/// Returns which values the entities of the type have, if the tests ask for one attribute.
fn values<'a>(domain: &Domain, tests: impl Iterator<Item = &'a &'a Test>, of_type: &Type) -> String {
    let mut read = Read::default();
    tests.for_each(|test| read.test(test));
    let attribute = read.attributes.first().and_then(|a| domain.attributes.get(a.index()));
    let Some(attribute) = attribute.filter(|a| read.attributes.len() == 1 && a.arguments.is_empty()) else {
        return "compare with values that are set in `factdatabase` or in the world file".into();
    };
    let slots = of_type.entities.iter().filter_map(|e| *attribute.slots.get(e.index())?);
    let mut values: Vec<String> = Vec::new();
    for value in slots.filter_map(|slot| domain.initial.get(slot.index())) {
        let shown = domain.show(value);
        if !values.contains(&shown) {
            values.push(shown);
        }
    }
    let more = if values.len() > MOST_LISTED { " and others" } else { "" };
    values.truncate(MOST_LISTED);
    format!(
        "`{}.{}` is `{}`{more}",
        of_type.name,
        attribute.name,
        values.join("` or `")
    )
}

/// Evaluates static tests of one entity; `None` where it can't be known.
struct Eval<'a> {
    domain: &'a Domain,
    has_world: bool,
    var: Var,
    entity: EntityId,
}

impl Eval<'_> {
    fn test(&self, test: &Test) -> Option<bool> {
        match test {
            Test::And(tests) => {
                let all: Vec<Option<bool>> = tests.iter().map(|t| self.test(t)).collect();
                if all.contains(&Some(false)) {
                    return Some(false);
                }
                (!all.contains(&None)).then_some(true)
            }
            Test::Or(tests) => {
                let all: Vec<Option<bool>> = tests.iter().map(|t| self.test(t)).collect();
                if all.contains(&Some(true)) {
                    return Some(true);
                }
                (!all.contains(&None)).then_some(false)
            }
            Test::Not(test) => self.test(test).map(|holds| !holds),
            Test::Compare { op, left, right } => {
                let (left, right) = (self.expr(left)?, self.expr(right)?);
                match (op, left, right) {
                    (CompareOp::Equal, left, right) => Some(left == right),
                    (CompareOp::NotEqual, left, right) => Some(left != right),
                    (op, Value::Number(a), Value::Number(b)) => Some(match op {
                        CompareOp::Less => a < b,
                        CompareOp::LessEqual => a <= b,
                        CompareOp::Greater => a > b,
                        CompareOp::GreaterEqual => a >= b,
                        CompareOp::Equal | CompareOp::NotEqual => return None,
                    }),
                    _ => None,
                }
            }
            Test::Member { element, set } => match (self.expr(element)?, self.expr(set)?) {
                (Value::Entity(e), Value::Set(set)) => Some(set.contains(e)),
                (value, Value::Scalars(set)) => Some(set.contains(&value)),
                _ => None,
            },
            Test::Holds(expr) => match self.expr(expr)? {
                Value::Bool(b) => Some(b),
                _ => None,
            },
            Test::Forall { .. } | Test::Exist { .. } => None,
        }
    }

    fn expr(&self, expr: &Expr) -> Option<Value> {
        match expr {
            Expr::Const(value) => Some(value.clone()),
            Expr::Var(var) if *var == self.var => Some(Value::Entity(self.entity)),
            Expr::Attribute { base, attribute, args } => {
                let entity = |expr| match self.expr(expr)? {
                    Value::Entity(entity) => Some(entity),
                    _ => None,
                };
                let args: Option<Vec<EntityId>> = args.iter().map(entity).collect();
                let slot = self
                    .domain
                    .attributes
                    .get(attribute.index())?
                    .slot(entity(base)?, &args?)?;
                let value = self.domain.initial.get(slot.index())?.clone();
                // A domain alone leaves values to the world.
                let is_unset = match &value {
                    Value::Null => true,
                    Value::Set(set) => set.is_empty(),
                    Value::Scalars(set) => set.is_empty(),
                    Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Entity(_) => false,
                };
                (self.has_world || !is_unset).then_some(value)
            }
            _ => None,
        }
    }
}

/// Returns that the tests hold only where the goal does.
fn repeats_goal(what: &str, tests: &[Placed<'_>], goal: &[Placed<'_>]) -> Option<Problem> {
    let said = |(_, wanted): &Placed<'_>| tests.iter().find(|(_, test)| test == wanted).map(|(span, _)| *span);
    let places: Vec<Span> = goal.iter().map(said).collect::<Option<_>>()?;
    let (place, (goal, _)) = (places.first()?, goal.first()?);
    let message = format!("{what}: it tests the goal, and where that holds nothing is to be done");
    let problem = Problem::warning("hatp::never-applies", message, *place, "the same test as the goal");
    Some(
        problem
            .note(*goal, "the goal")
            .help("remove the test, or the decomposition"),
    )
}
