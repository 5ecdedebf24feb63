//! Sets in the replay: of entities, or of numbers, strings and truth values. An unset one is empty, and all empty ones are equal.

use std::sync::Arc;

use crate::ir::{EntitySet, ScalarSet, Value};

fn is_empty(set: &Value) -> bool {
    match set {
        Value::Null => true,
        Value::Set(s) => s.is_empty(),
        Value::Scalars(s) => s.is_empty(),
        Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Entity(_) => false,
    }
}

/// Says whether two values are the same.
pub(super) fn equal(left: &Value, right: &Value) -> bool {
    let are_sets = [left, right].iter().all(|v| **v != Value::Null && is_empty(v));
    left == right || are_sets
}

/// Returns the set with one member more; `None` when the two do not go together.
pub(super) fn with(set: Value, member: &Value) -> Option<Value> {
    match (member, set) {
        (Value::Entity(e), Value::Set(mut members)) => {
            Arc::make_mut(&mut members).insert(*e);
            Some(Value::Set(members))
        }
        (Value::Entity(e), set) if is_empty(&set) => Some(Value::Set(Arc::new(EntitySet::from_iter([*e])))),
        (Value::Bool(_) | Value::Number(_) | Value::String(_), Value::Scalars(mut members)) => {
            Arc::make_mut(&mut members).insert(member.clone());
            Some(Value::Scalars(members))
        }
        (Value::Bool(_) | Value::Number(_) | Value::String(_), set) if is_empty(&set) => {
            let mut members = ScalarSet::default();
            members.insert(member.clone());
            Some(Value::Scalars(Arc::new(members)))
        }
        _ => None,
    }
}

/// Returns the set with one member less; `None` when there is no member to take.
pub(super) fn without(set: Value, member: &Value) -> Option<Value> {
    match (member, set) {
        (Value::Null | Value::Unknown | Value::Set(_) | Value::Scalars(_), _) => None,
        (_, Value::Null) => Some(Value::Set(Arc::default())),
        (Value::Entity(e), Value::Set(mut members)) => {
            Arc::make_mut(&mut members).remove(*e);
            Some(Value::Set(members))
        }
        (_, Value::Scalars(mut members)) => {
            Arc::make_mut(&mut members).remove(member);
            Some(Value::Scalars(members))
        }
        (_, set @ Value::Set(_)) => is_empty(&set).then_some(set),
        (_, Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Entity(_)) => None,
    }
}
