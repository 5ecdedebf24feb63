//! The symbolic state: a flat vector of attribute values with an undo trail.

use crate::ir::{Domain, SlotId, Value};

/// Values of all slots. A shared attribute's slot is `None` until somebody reads it: facts are computed on demand.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    values: Vec<Option<Value>>,
    trail: Vec<(SlotId, Option<Value>)>,
}

/// A point to come back to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrailMark(usize);

impl State {
    /// Returns the domain's initial state; slots in `unread` are left to be read from geometry.
    pub fn new(domain: &Domain, unread: &[SlotId]) -> Self {
        let mut values: Vec<Option<Value>> = domain.initial.iter().cloned().map(Some).collect();
        for slot in unread {
            values[slot.index()] = None;
        }
        State {
            values,
            trail: Vec::new(),
        }
    }

    /// Returns the value, or `None` if it must be read from geometry first.
    pub fn get(&self, slot: SlotId) -> Option<&Value> {
        self.values[slot.index()].as_ref()
    }

    /// Sets the value; undone by [`State::restore`].
    pub fn set(&mut self, slot: SlotId, value: Value) {
        let old = self.values[slot.index()].replace(value);
        self.trail.push((slot, old));
    }

    /// Forgets a shared attribute's value, since the world has changed; undone by [`State::restore`].
    pub fn forget(&mut self, slot: SlotId) {
        let old = self.values[slot.index()].take();
        self.trail.push((slot, old));
    }

    /// Remembers what was read from geometry. Not on the trail: the value belongs to the world state of now, and every
    /// change of that world state has put the slot on the trail by [`State::forget`].
    pub fn remember(&mut self, slot: SlotId, value: Value) {
        self.values[slot.index()] = Some(value);
    }

    /// Returns a mark of now.
    pub fn mark(&self) -> TrailMark {
        TrailMark(self.trail.len())
    }

    /// Undoes everything since the mark, latest first.
    pub fn restore(&mut self, mark: TrailMark) {
        while self.trail.len() > mark.0 {
            if let Some((slot, old)) = self.trail.pop() {
                self.values[slot.index()] = old;
            }
        }
    }
}
