//! Values of attributes and variables, and sets as values.

use std::sync::Arc;

use super::domain::{EntityId, StringId};

/// A set of entities as bits: bit `i` is `EntityId(i)`.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EntitySet(Vec<u64>);

impl EntitySet {
    /// Says whether `e` is in the set.
    pub fn contains(&self, e: EntityId) -> bool {
        self.0
            .get(e.index() / 64)
            .is_some_and(|w| w >> (e.index() % 64) & 1 == 1)
    }

    /// Adds `e`.
    pub fn insert(&mut self, e: EntityId) {
        let word = e.index() / 64;
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        self.0[word] |= 1 << (e.index() % 64);
    }

    /// Removes `e`.
    pub fn remove(&mut self, e: EntityId) {
        if let Some(w) = self.0.get_mut(e.index() / 64) {
            *w &= !(1 << (e.index() % 64));
        }
        // INVARIANT: no trailing zero words, so that equal sets are equal values.
        while self.0.last() == Some(&0) {
            self.0.pop();
        }
    }

    /// Returns the number of members.
    pub fn len(&self) -> usize {
        self.0.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Says whether there is no member.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|w| *w == 0)
    }

    /// Returns the members in declaration order.
    pub fn iter(&self) -> impl Iterator<Item = EntityId> + '_ {
        self.iter_from(EntityId(0))
    }

    /// Returns the members from `first` on, in declaration order.
    pub fn iter_from(&self, first: EntityId) -> impl Iterator<Item = EntityId> + '_ {
        let from = first.index() / 64;
        let words = self.0.iter().enumerate().skip(from);
        words.flat_map(move |(i, word)| {
            let mut left = *word;
            if i == from {
                left &= u64::MAX << (first.index() % 64);
            }
            std::iter::from_fn(move || {
                let bit = left.trailing_zeros() as usize;
                // The lowest bit that is left.
                left &= left.checked_sub(1)?;
                Some(EntityId((i * 64 + bit) as u32))
            })
        })
    }
}

impl FromIterator<EntityId> for EntitySet {
    fn from_iter<I: IntoIterator<Item = EntityId>>(iter: I) -> Self {
        let mut set = EntitySet::default();
        for e in iter {
            set.insert(e);
        }
        set
    }
}

/// A value of an attribute or a variable.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Value {
    /// Unset.
    #[default]
    Null,
    Bool(bool),
    Number(f64),
    String(StringId),
    Entity(EntityId),
    Set(Arc<EntitySet>),
    /// A set of numbers, strings or truth values.
    Scalars(Arc<ScalarSet>),
    /// What an agent that knows nothing believes; in slots of beliefs alone.
    Unknown,
}

/// A set of numbers, strings or truth values, in order, none twice.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScalarSet(Vec<Value>);

impl ScalarSet {
    /// Says whether `value` is in the set.
    pub fn contains(&self, value: &Value) -> bool {
        self.position(value).is_ok()
    }

    /// Adds `value`; no effect if it is there, or is no number, string or truth value.
    pub fn insert(&mut self, value: Value) {
        if let (Err(at), Value::Bool(_) | Value::Number(_) | Value::String(_)) = (self.position(&value), &value) {
            self.0.insert(at, value);
        }
    }

    /// Removes `value`.
    pub fn remove(&mut self, value: &Value) {
        if let Ok(at) = self.position(value) {
            self.0.remove(at);
        }
    }

    /// Returns the number of members.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Says whether there is no member.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the members in order: numbers by size, strings by id.
    pub fn iter(&self) -> impl Iterator<Item = &Value> {
        self.0.iter()
    }

    fn position(&self, value: &Value) -> Result<usize, usize> {
        // A rank for each kind, then by size; -0 is 0, as `==` has it.
        let key = |v: &Value| match v {
            Value::Bool(b) => (0, f64::from(u8::from(*b))),
            Value::Number(x) => (1, *x + 0.0),
            Value::String(s) => (2, f64::from(s.0)),
            Value::Null | Value::Entity(_) | Value::Set(_) | Value::Scalars(_) | Value::Unknown => (3, 0.0),
        };
        let wanted = key(value);
        self.0.binary_search_by(|v| {
            let (rank, size) = key(v);
            rank.cmp(&wanted.0).then(size.total_cmp(&wanted.1))
        })
    }
}
