//! Sets as values: of entities, or of numbers, strings and truth values.
//!
//! An empty set is the same set whatever it could hold. A set changed here is shared by nobody else afterwards.

use std::sync::Arc;

use crate::ir::{EntitySet, ScalarSet, Value};

/// Returns the number of members, or `None` for what is no set.
pub(super) fn len(set: &Value) -> Option<usize> {
    match set {
        Value::Set(s) => Some(s.len()),
        Value::Scalars(s) => Some(s.len()),
        Value::Null | Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Entity(_) => None,
    }
}

/// Says whether `element` is in the set.
pub(super) fn contains(set: &Value, element: &Value) -> bool {
    match (set, element) {
        (Value::Set(s), Value::Entity(e)) => s.contains(*e),
        (Value::Scalars(s), scalar) => s.contains(scalar),
        _ => false,
    }
}

/// Says whether two values are equal; two empty sets are.
pub(super) fn equal(left: &Value, right: &Value) -> bool {
    left == right || (len(left) == Some(0) && len(right) == Some(0))
}

/// Returns the set with `element` (a NULL set counts as empty); `None` where that is no set or no element.
pub(super) fn with(set: Value, element: &Value) -> Option<Value> {
    let is_empty = set == Value::Null || len(&set) == Some(0);
    match (set, element) {
        (Value::Set(mut s), Value::Entity(e)) => {
            Arc::make_mut(&mut s).insert(*e);
            Some(Value::Set(s))
        }
        (Value::Scalars(mut s), Value::Bool(_) | Value::Number(_) | Value::String(_)) => {
            Arc::make_mut(&mut s).insert(element.clone());
            Some(Value::Scalars(s))
        }
        (_, Value::Entity(e)) if is_empty => Some(Value::Set(Arc::new([*e].into_iter().collect()))),
        (_, Value::Bool(_) | Value::Number(_) | Value::String(_)) if is_empty => {
            let mut s = ScalarSet::default();
            s.insert(element.clone());
            Some(Value::Scalars(Arc::new(s)))
        }
        _ => None,
    }
}

/// Returns the set without `element` (a NULL set counts as empty); `None` where that is no set or no element.
pub(super) fn without(set: Value, element: &Value) -> Option<Value> {
    match (set, element) {
        (_, Value::Null | Value::Unknown | Value::Set(_) | Value::Scalars(_)) => None,
        (Value::Null, _) => Some(Value::Set(Arc::new(EntitySet::default()))),
        (Value::Set(mut s), Value::Entity(e)) => {
            Arc::make_mut(&mut s).remove(*e);
            Some(Value::Set(s))
        }
        (Value::Scalars(mut s), scalar) => {
            Arc::make_mut(&mut s).remove(scalar);
            Some(Value::Scalars(s))
        }
        (set @ Value::Set(_), _) if len(&set) == Some(0) => Some(set),
        _ => None,
    }
}
