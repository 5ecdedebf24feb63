//! The names and values of a plan document, each kept once.

use rustc_hash::FxHashMap;

use crate::ir::{Domain, SlotId, TaskId, Value};
use crate::plan::Text;

/// HEURISTIC: numbers remembered; a counter that goes up and up fills no memory.
const MAX_NUMBERS: usize = 1 << 12;

/// Texts that were needed before.
pub(super) struct Names<'a> {
    domain: &'a Domain,
    entities: Vec<Text>,
    actions: Vec<Text>,
    methods: Vec<Text>,
    slots: Vec<Option<Text>>,
    numbers: FxHashMap<u64, Text>,
}

impl<'a> Names<'a> {
    pub fn new(domain: &'a Domain) -> Self {
        Names {
            domain,
            entities: domain.entities.iter().map(|e| e.name.as_str().into()).collect(),
            actions: domain.actions.iter().map(|a| a.name.as_str().into()).collect(),
            methods: domain.methods.iter().map(|m| m.name.as_str().into()).collect(),
            slots: vec![None; domain.slots.len()],
            numbers: FxHashMap::default(),
        }
    }

    pub fn task(&self, task: TaskId) -> Text {
        match task {
            TaskId::Action(a) => self.actions[a.index()].clone(),
            TaskId::Method(m) => self.methods[m.index()].clone(),
        }
    }

    /// Returns `RED_CUBE.isOn`.
    pub fn slot(&mut self, slot: SlotId) -> Text {
        let name = &mut self.slots[slot.index()];
        name.get_or_insert_with(|| self.domain.slot_name(slot).into()).clone()
    }

    /// Returns the value as the language writes it.
    pub fn value(&mut self, value: &Value) -> Text {
        match value {
            Value::Entity(e) => self.entities[e.index()].clone(),
            Value::Number(x) => {
                if self.numbers.len() >= MAX_NUMBERS {
                    self.numbers.clear();
                }
                let text = self.numbers.entry(x.to_bits());
                text.or_insert_with(|| self.domain.show(value).into()).clone()
            }
            Value::Null | Value::Bool(_) | Value::String(_) | Value::Set(_) | Value::Scalars(_) | Value::Unknown => {
                self.domain.show(value).into()
            }
        }
    }

    pub fn values(&mut self, values: &[Value]) -> Vec<Text> {
        values.iter().map(|v| self.value(v)).collect()
    }
}
