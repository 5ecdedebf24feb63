//! The symbolic state: a flat vector of attribute values with an undo trail and a running fingerprint.

use super::hash::Print;
use crate::ir::{Domain, SlotId, Value};

/// Values of all slots. A shared attribute's slot is `None` until somebody reads it: facts are computed on demand.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    values: Vec<Option<Value>>,
    /// Whether a slot's value was read from geometry: it then says no more than the world state does.
    is_read: Vec<bool>,
    trail: Vec<Change>,
    /// The fingerprint of all values but those that were read from geometry; kept up once somebody has asked for it.
    print: Option<Print>,
}

#[derive(Debug, Clone, PartialEq)]
struct Change {
    slot: SlotId,
    was_read: bool,
    old: Option<Value>,
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
            is_read: vec![false; values.len()],
            values,
            trail: Vec::new(),
            print: None,
        }
    }

    /// Returns the value, or `None` if it must be read from geometry first.
    #[inline]
    pub fn get(&self, slot: SlotId) -> Option<&Value> {
        self.values[slot.index()].as_ref()
    }

    /// Sets the value; undone by [`State::restore`].
    #[inline]
    pub fn set(&mut self, slot: SlotId, value: Value) {
        self.change(slot, Some(value));
    }

    /// Forgets a shared attribute's value, since the world has changed; undone by [`State::restore`].
    pub fn forget(&mut self, slot: SlotId) {
        // A slot that nobody has read goes on the trail, too: it may be read in the world state to come.
        self.change(slot, None);
    }

    fn change(&mut self, slot: SlotId, value: Option<Value>) {
        let i = slot.index();
        let was_read = self.is_read[i];
        if let Some(print) = self.print {
            let mut print = print;
            if let (Some(old), false) = (&self.values[i], was_read) {
                print = print.toggle(said(slot, old));
            }
            if let Some(new) = &value {
                print = print.toggle(said(slot, new));
            }
            self.print = Some(print);
        }
        let old = std::mem::replace(&mut self.values[i], value);
        self.is_read[i] = false;
        self.trail.push(Change { slot, was_read, old });
    }

    /// Remembers what was read from geometry. Not on the trail: the value belongs to the world state of now, and every
    /// change of that world state has put the slot on the trail by [`State::forget`].
    pub fn remember(&mut self, slot: SlotId, value: Value) {
        self.values[slot.index()] = Some(value);
        self.is_read[slot.index()] = true;
    }

    /// Returns the number of slots.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns a mark of now.
    #[inline]
    pub fn mark(&self) -> TrailMark {
        TrailMark(self.trail.len())
    }

    /// Forgets how to go back. All marks end.
    pub fn keep(&mut self) {
        self.trail.clear();
    }

    /// Undoes everything since the mark, latest first.
    pub fn restore(&mut self, mark: TrailMark) {
        while self.trail.len() > mark.0 {
            if let Some(Change { slot, was_read, old }) = self.trail.pop() {
                let i = slot.index();
                if let Some(print) = &mut self.print {
                    if let (Some(new), false) = (&self.values[i], self.is_read[i]) {
                        *print = print.toggle(said(slot, new));
                    }
                    if let (Some(old), false) = (&old, was_read) {
                        *print = print.toggle(said(slot, old));
                    }
                }
                self.values[i] = old;
                self.is_read[i] = was_read;
            }
        }
    }

    /// Returns the fingerprint of what the domain has said; what was read from geometry is not in it.
    pub fn print(&mut self) -> Print {
        if let Some(print) = self.print {
            return print;
        }
        let print = self.computed_print();
        self.print = Some(print);
        print
    }

    /// As [`State::print`], without keeping it up from now on: for who asks seldom.
    pub fn computed_print(&self) -> Print {
        let said = (0..self.values.len()).filter(|i| !self.is_read[*i]).filter_map(|i| {
            let value = self.values[i].as_ref()?;
            Some(said(SlotId(i as u32), value))
        });
        said.fold(Print::default(), Print::toggle)
    }
}

/// Returns what one slot's value adds to the fingerprint.
fn said(slot: SlotId, value: &Value) -> Print {
    Print::of(u64::from(slot.0)).value(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SLOTS: u32 = 5;
    /// The last two slots are shared.
    const SHARED: [SlotId; 2] = [SlotId(3), SlotId(4)];

    #[derive(Debug, Clone)]
    enum Step {
        Set(u32, u8),
        Read(usize),
        /// The world changes to the state of that number: every shared slot is forgotten.
        Move(u8),
        Mark,
        /// Back to one of the marks that are left.
        Restore(usize),
    }

    fn step() -> impl Strategy<Value = Step> {
        prop_oneof![
            (0..SLOTS, any::<u8>()).prop_map(|(slot, value)| Step::Set(slot, value)),
            (0..SHARED.len()).prop_map(Step::Read),
            any::<u8>().prop_map(Step::Move),
            Just(Step::Mark),
            any::<usize>().prop_map(Step::Restore),
        ]
    }

    fn number(x: u8) -> Value {
        Value::Number(f64::from(x))
    }

    /// What geometry says of a shared slot in a world state.
    fn fact(world: u8, slot: SlotId) -> Value {
        Value::Number(f64::from(world) * 10.0 + f64::from(slot.0))
    }

    /// What anybody would see who reads all slots now.
    fn seen(state: &State, world: u8) -> Vec<Value> {
        let slots = (0..SLOTS).map(SlotId);
        slots
            .map(|s| state.get(s).cloned().unwrap_or_else(|| fact(world, s)))
            .collect()
    }

    proptest! {
        /// A state with a trail is a state that is copied at every mark.
        #[test]
        fn undo_gives_back_what_a_copy_would_have_kept(steps in prop::collection::vec(step(), 0..60)) {
            let domain = Domain { initial: vec![number(0); SLOTS as usize], ..Domain::default() };
            let mut state = State::new(&domain, &SHARED);
            let mut world = 0;
            let mut model = seen(&state, world);
            let mut marks = Vec::new();
            for step in steps {
                match step {
                    Step::Set(slot, value) => {
                        state.set(SlotId(slot), number(value));
                        model[slot as usize] = number(value);
                    }
                    Step::Read(which) => {
                        let slot = SHARED[which];
                        if state.get(slot).is_none() {
                            state.remember(slot, fact(world, slot));
                        }
                    }
                    Step::Move(to) => {
                        world = to;
                        for slot in SHARED {
                            state.forget(slot);
                            model[slot.index()] = fact(world, slot);
                        }
                    }
                    Step::Mark => marks.push((state.mark(), world, model.clone())),
                    Step::Restore(which) => {
                        if !marks.is_empty() {
                            marks.truncate(which % marks.len() + 1);
                            if let Some((mark, then, copy)) = marks.last() {
                                state.restore(*mark);
                                (world, model) = (*then, copy.clone());
                            }
                        }
                    }
                }
                prop_assert_eq!(seen(&state, world), model.clone());
                prop_assert_eq!(state.print(), state.computed_print());
            }
        }
    }
}
