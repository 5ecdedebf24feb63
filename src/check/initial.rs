//! The state at the start: the domain's assignments, then the world's values, which win.

use std::sync::Arc;

use super::expr::{Scope, Walk};
use super::functions::Functions;
use super::kinds::Kind;
use super::methods::{constant, set_of, typed};
use super::names::Names;
use super::{Given, GivenLiteral, GivenValue, beliefs, problems};
use crate::diag::{Problem, Problems};
use crate::ir::{AttributeId, Base, EntityId, Expr, SlotId, Value};
use crate::syntax::ast::{self, AssignOp, Assignment, ExprKind, Item, Name, Path, PathStep};

/// Fills `names.domain.initial`.
pub(super) fn fill(items: &[&Item], given: &Given, names: &mut Names, functions: &Functions, problems: &mut Problems) {
    for item in items {
        if let Item::Initial(assignment) = item
            && assignment.believer.is_none()
        {
            walk(names, functions, problems).initial(assignment, given);
        }
    }
    for value in &given.values {
        given_value(value, names, problems);
    }
    // What nobody is said to believe otherwise is known.
    beliefs::of_truth(&mut names.domain);
    for item in items {
        if let Item::Initial(assignment) = item
            && assignment.believer.is_some()
        {
            walk(names, functions, problems).initial(assignment, given);
        }
    }
}

fn walk<'a>(names: &'a mut Names, functions: &'a Functions, problems: &'a mut Problems) -> Walk<'a> {
    Walk {
        names,
        functions,
        problems,
        scope: Scope::default(),
        wanted: "number",
    }
}

impl Walk<'_> {
    fn initial(&mut self, assignment: &Assignment, given: &Given) {
        let n_before = self.problems.0.len();
        let Some(place) = self.told_place(assignment) else {
            self.single(&assignment.value);
            return;
        };
        let attribute = place.attribute;
        let value = self.told_value(assignment, attribute, place.kind);
        if self.problems.0.len() > n_before {
            return;
        }
        let entity = |expr: &Expr| match expr {
            Expr::Const(Value::Entity(entity)) => Some(*entity),
            _ => None,
        };
        let args: Option<Vec<EntityId>> = place.args.iter().map(entity).collect();
        let (Some(entity), Some(args)) = (entity(&place.entity), args) else {
            let help = "write `ENTITY.attribute = value;`";
            let message = "an initial value belongs to one entity";
            self.problems
                .push(problems::not_constant(assignment.target.span, message, help));
            return;
        };
        let Some(value) = constant(&value, assignment.value.span, self.problems) else {
            return;
        };
        let domain = &mut self.names.domain;
        if let (Some(entity), Some(declared)) = (
            domain.entities.get(entity.index()),
            domain.attributes.get(attribute.index()),
        ) {
            // A world file shares attributes of domains that are written for other planners, whose values are no slip.
            let is_of_world = given
                .shared
                .iter()
                .any(|(path, ..)| path.rsplit('.').next() == Some(&declared.name));
            if declared.fact.is_some() && !is_of_world {
                let place = assignment.target.span;
                self.problems
                    .push(problems::overruled(&entity.name, &declared.name, place));
            }
        }
        let Some(base) = domain.attributes.get(attribute.index()).map(|a| a.base) else {
            return;
        };
        let slot = domain
            .attributes
            .get(attribute.index())
            .and_then(|a| a.slot(entity, &args));
        let Some(initial) = slot.and_then(|s| domain.initial.get_mut(s.index())) else {
            return;
        };
        match (assignment.op, value) {
            (AssignOp::Set, value) => *initial = typed(value, base),
            (op @ (AssignOp::Add | AssignOp::Remove), member) => change(initial, op, member),
        }
    }
}

fn change(set: &mut Value, op: AssignOp, member: Value) {
    match (set, member, op) {
        (Value::Set(set), Value::Entity(e), AssignOp::Add) => Arc::make_mut(set).insert(e),
        (Value::Set(set), Value::Entity(e), _) => Arc::make_mut(set).remove(e),
        (Value::Scalars(set), member, AssignOp::Add) => Arc::make_mut(set).insert(member),
        (Value::Scalars(set), member, _) => Arc::make_mut(set).remove(&member),
        _ => {}
    }
}

/// Applies one line of the world's `[state]`.
fn given_value(value: &GivenValue, names: &mut Names, problems: &mut Problems) {
    if value.is_implied && !names.declares(&value.entity, &value.attribute) {
        return;
    }
    let Some(entity) = names.entities.get(&value.entity).map(|e| e.0) else {
        let candidates = names.entities.keys().map(String::as_str);
        let mut problem = problems::unknown("hatp::unknown-name", "entity", &value.entity, value.span, candidates);
        if problem.help.is_none() {
            problem = problem.help("give the object a `type` of the domain, or declare the entity in the domain");
        }
        problems.push(problem);
        return;
    };
    let Some(ty) = names.domain.entities.get(entity.index()).map(|e| e.ty) else {
        return;
    };
    let Some(step) = given_step(value) else {
        let message = format!("`{}` is no attribute", value.attribute);
        let problem = Problem::error("hatp::unknown-attribute", message, value.span, "");
        problems.push(problem.help("write `attribute`, or with arguments `attribute(ENTITY)`"));
        return;
    };
    let Some(attribute) = names.attribute_named(ty, &step.name, problems) else {
        return;
    };
    let Some(args) = given_arguments(attribute, &step, names, problems) else {
        return;
    };
    let Some(declared) = names.domain.attributes.get(attribute.index()) else {
        return;
    };
    if declared.fact.is_some() {
        problems.push(problems::overruled(&value.entity, &value.attribute, value.span));
    }
    let (base, is_set) = (declared.base, declared.is_set);
    let slot: Option<SlotId> = declared.slot(entity, &args);
    let literals: Option<Vec<Value>> = value
        .values
        .iter()
        .map(|l| literal(l, base, value, names, problems))
        .collect();
    let Some(mut literals) = literals else { return };
    let new = if is_set {
        typed(set_of(literals), base)
    } else if value.is_list || literals.len() != 1 {
        let wanted = Kind::of(base, false).words(&names.domain);
        problems.push(problems::wrong_type(value.span, &wanted, "an array").help("write one value without brackets"));
        return;
    } else {
        literals.pop().unwrap_or_default()
    };
    if let Some(initial) = slot.and_then(|s| names.domain.initial.get_mut(s.index())) {
        *initial = new;
    }
}

/// Reads `can_traverse(W1, W2)`.
fn given_step(value: &GivenValue) -> Option<PathStep> {
    let (text, args) = match value.attribute.split_once('(') {
        Some((name, args)) => (name, args.strip_suffix(')')?.split(',').collect()),
        None => (value.attribute.as_str(), Vec::new()),
    };
    let name = |text: &str| Name {
        text: text.trim().into(),
        span: value.span,
    };
    let args = args.into_iter().map(|arg| ast::Expr {
        kind: ExprKind::Path(Path {
            root: name(arg),
            steps: Vec::new(),
            span: value.span,
        }),
        span: value.span,
    });
    Some(PathStep {
        name: name(text),
        args: args.collect(),
        span: value.span,
    })
}

/// Returns the entities of `can_traverse(W1, W2)`.
fn given_arguments(
    attribute: AttributeId,
    step: &PathStep,
    names: &mut Names,
    problems: &mut Problems,
) -> Option<Vec<EntityId>> {
    let n_before = problems.0.len();
    let args = walk(names, &Functions::default(), problems).attribute_arguments(attribute, step)?;
    let entities = args.iter().map(|arg| match arg {
        Expr::Const(Value::Entity(entity)) => Some(*entity),
        _ => None,
    });
    let entities = entities.collect();
    (problems.0.len() == n_before).then_some(entities)?
}

fn literal(
    literal: &GivenLiteral,
    base: Base,
    place: &GivenValue,
    names: &mut Names,
    problems: &mut Problems,
) -> Option<Value> {
    let wanted = Kind::of(base, false);
    let found = match (literal, base) {
        (GivenLiteral::Bool(b), Base::Bool) => return Some(Value::Bool(*b)),
        (GivenLiteral::Number(x), Base::Number) => return Some(Value::Number(*x)),
        (GivenLiteral::Text(text), Base::String) => return Some(Value::String(names.string(text))),
        (GivenLiteral::Text(text), Base::Entity(ty)) => {
            let found: Option<EntityId> = names.entities.get(text).map(|e| e.0);
            let Some(found) = found else {
                let candidates = names.entities.keys().map(String::as_str);
                problems.push(problems::unknown(
                    "hatp::unknown-name",
                    "entity",
                    text,
                    place.span,
                    candidates,
                ));
                return None;
            };
            let kind = names
                .domain
                .entities
                .get(found.index())
                .map_or(Kind::Unknown, |e| Kind::Entity(e.ty));
            if kind.fits(Kind::Entity(ty), &names.domain) {
                return Some(Value::Entity(found));
            }
            kind
        }
        (GivenLiteral::Bool(_), _) => Kind::Bool,
        (GivenLiteral::Number(_), _) => Kind::Number,
        (GivenLiteral::Text(_), _) => Kind::String,
    };
    let (wanted, found) = (wanted.words(&names.domain), found.words(&names.domain));
    problems.push(problems::wrong_type(place.span, &wanted, &found));
    None
}
