//! The symbolic states that a plan goes through: of each attribute of an entity, when it has changed, and to what.
//!
//! Takes as much room as there are changes. A copy of every state would grow with plan times domain.

use crate::ir::{SlotId, Value};

/// Values of all slots at every time: time 0 is the start, time `n` is after `n` actions.
pub(super) struct History {
    /// By slot: since when it has had which value, in order. The first one is that of the start.
    since: Vec<Vec<(usize, Value)>>,
}

impl History {
    pub(super) fn new(start: &[Value]) -> Self {
        History {
            since: start.iter().map(|value| vec![(0, value.clone())]).collect(),
        }
    }

    /// Notes a slot's value from a time on, which must not be before one that was noted.
    pub(super) fn note(&mut self, time: usize, slot: SlotId, value: &Value) {
        let since = &mut self.since[slot.index()];
        match since.last_mut() {
            Some((of, last)) if *of == time => *last = value.clone(),
            Some(_) | None => since.push((time, value.clone())),
        }
    }

    /// Returns a slot's value at a time.
    pub(super) fn at(&self, time: usize, slot: SlotId) -> Option<&Value> {
        let since = self.since.get(slot.index())?;
        let after = since.partition_point(|(of, _)| *of <= time);
        Some(&since.get(after.checked_sub(1)?)?.1)
    }

    /// Returns all values at a time.
    pub(super) fn state(&self, time: usize) -> Vec<Value> {
        let slots = (0..self.since.len()).map(|i| SlotId(i as u32));
        slots
            .map(|slot| self.at(time, slot).cloned().unwrap_or_default())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_that_of_the_last_change_before() {
        let number = |x: i32| Value::Number(f64::from(x));
        let mut history = History::new(&[number(0), number(10)]);
        history.note(2, SlotId(0), &number(1));
        history.note(2, SlotId(0), &number(2));
        history.note(5, SlotId(0), &number(3));
        let seen: Vec<Vec<Value>> = [0, 1, 2, 4, 5, 9].map(|time| history.state(time)).into();
        assert_eq!(seen, [0, 0, 2, 2, 3, 3].map(|x| vec![number(x), number(10)]));
        assert_eq!(history.at(0, SlotId(2)), None);
    }
}
