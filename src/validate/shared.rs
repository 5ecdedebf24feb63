//! Shared attributes (thesis 4.3.3): their values as read from geometry, held against what the plan claims.
//!
//! The document lists changes only. What it says of an attribute after an action is the last value listed, so that a
//! wrong fact is found at the first action after which it is wrong. Of the start it says nothing: facts that are unclear
//! there are guesses, and are not held against the plan.

use std::collections::BTreeSet;
use std::sync::Arc;

use indexmap::IndexMap;

use super::{
    Settings, Verdict,
    bodies::Bodies,
    facts::{self, Status},
    fault::{Checked, Kind},
    notation, slot_name,
};
use crate::ir::{Base, Domain, EntityId, EntitySet, Param, SlotId, TypeId, Value};
use crate::world::{EntityRef, State};

/// An attribute of an entity of the world that is read from a fact.
pub(super) struct SharedSlot {
    slot: SlotId,
    name: String,
    fact: String,
    is_set: bool,
    ty: TypeId,
    owner: EntityRef,
    /// Entities of the attribute's type that are in the world.
    candidates: Vec<(EntityId, EntityRef)>,
}

/// All shared attributes, and which of their elements are guesses.
pub(super) struct Shared<'a> {
    domain: &'a Domain,
    bodies: &'a Bodies<'a>,
    settings: &'a Settings,
    slots: Vec<SharedSlot>,
    guessed: BTreeSet<(SlotId, EntityId)>,
}

impl<'a> Shared<'a> {
    /// Finds the shared attributes of the world's entities.
    pub(super) fn new(domain: &'a Domain, bodies: &'a Bodies<'a>, settings: &'a Settings) -> Checked<Self> {
        let mut slots = Vec::new();
        for (i, slot) in domain.slots.iter().enumerate() {
            let attribute = &domain.attributes[slot.attribute.index()];
            let owner = bodies.scene.find(&domain.entities[slot.entity.index()].name);
            let (Some(fact), Some(owner)) = (&attribute.fact, owner) else {
                continue;
            };
            let name = slot_name(domain, slot);
            let Base::Entity(ty) = attribute.base else {
                return Err(Kind::FactUnchecked {
                    attribute: name,
                    fact: fact.clone(),
                }
                .into());
            };
            let entities = domain.types[ty.index()].entities.iter();
            let found = entities.filter_map(|e| Some((*e, bodies.scene.find(&domain.entities[e.index()].name)?)));
            slots.push(SharedSlot {
                slot: SlotId(i as u32),
                name,
                fact: fact.clone(),
                is_set: attribute.is_set,
                ty,
                owner,
                candidates: found.collect(),
            });
        }
        Ok(Shared {
            domain,
            bodies,
            settings,
            slots,
            guessed: BTreeSet::new(),
        })
    }

    /// Says whether any element of the slot is a guess.
    pub(super) fn is_guess(&self, slot: SlotId) -> bool {
        self.guessed.iter().any(|(s, _)| *s == slot)
    }

    /// Takes the plan's word for the slot from now on.
    pub(super) fn settle(&mut self, slot: SlotId) {
        self.guessed.retain(|(s, _)| *s != slot);
    }

    /// Reads the facts of the start state into `values`.
    pub(super) fn read_start(&mut self, state: &State, values: &mut [Value], verdict: &mut Verdict) -> Checked<()> {
        for shared in &self.slots {
            let mut members = EntitySet::default();
            for (e, with) in &shared.candidates {
                let status = shared.status(self.bodies, state, *with, None, self.settings)?;
                verdict.facts += 1;
                if status.guess() {
                    members.insert(*e);
                }
                if let Status::Unclear(_) = status {
                    self.guessed.insert((shared.slot, *e));
                }
            }
            values[shared.slot.index()] = shared.value(&members, None);
        }
        Ok(())
    }

    /// Reads the facts of the state after an action, against `changes`, into `values`; `before` are the values before it.
    pub(super) fn read(
        &mut self,
        state: &State,
        before: &[Value],
        values: &mut [Value],
        changes: &IndexMap<String, String>,
        verdict: &mut Verdict,
    ) -> Checked<()> {
        for shared in &self.slots {
            let carried = &before[shared.slot.index()];
            let listed = match changes.get(&shared.name) {
                Some(text) => Some(shared.parse(self.domain, text)?),
                None => None,
            };
            let claimed = listed.as_ref().unwrap_or(carried);
            let mut members = EntitySet::default();
            for (e, with) in &shared.candidates {
                let claim = match claimed {
                    Value::Set(s) => s.contains(*e),
                    other => *other == Value::Entity(*e),
                };
                // Of two things that an atom could name, the plan names one.
                let other_named = !shared.is_set && !claim && *claimed != Value::Null;
                let known = listed.is_some() || !self.guessed.contains(&(shared.slot, *e));
                let status = shared.status(self.bodies, state, *with, known.then_some(claim), self.settings)?;
                verdict.facts += 1;
                let fact = || {
                    let (of, with) = (self.bodies.scene.id(shared.owner), self.bodies.scene.id(*with));
                    format!("{}({of}, {with})", shared.fact)
                };
                match (known, claim, status) {
                    (true, true, Status::Fails) => return Err(Kind::FactUnconfirmed { fact: fact() }.into()),
                    (true, false, Status::Holds) if !other_named => {
                        return Err(Kind::FactContradicted { fact: fact() }.into());
                    }
                    _ => {}
                }
                if if known { claim } else { status.guess() } {
                    members.insert(*e);
                }
                if known || !matches!(status, Status::Unclear(_)) {
                    self.guessed.remove(&(shared.slot, *e));
                }
            }
            values[shared.slot.index()] = shared.value(&members, Some(claimed));
        }
        Ok(())
    }

    /// Returns the values of all shared attributes.
    pub(super) fn snapshot(&self, values: &[Value]) -> Vec<(SlotId, Value)> {
        let slots = self.slots.iter().map(|s| s.slot);
        slots.map(|s| (s, values[s.index()].clone())).collect()
    }
}

impl SharedSlot {
    fn status(
        &self,
        bodies: &Bodies<'_>,
        state: &State,
        with: EntityRef,
        claim: Option<bool>,
        settings: &Settings,
    ) -> Checked<Status> {
        let status = facts::status(bodies, state, &self.fact, self.owner, with, claim, settings);
        status.ok_or_else(|| {
            Kind::FactUnchecked {
                attribute: self.name.clone(),
                fact: self.fact.clone(),
            }
            .into()
        })
    }

    /// Returns the members as the attribute holds them; an atom prefers the one that is claimed.
    fn value(&self, members: &EntitySet, claimed: Option<&Value>) -> Value {
        if self.is_set {
            return Value::Set(Arc::new(members.clone()));
        }
        match claimed {
            Some(Value::Entity(e)) if members.contains(*e) => Value::Entity(*e),
            _ => members.iter().next().map_or(Value::Null, Value::Entity),
        }
    }

    fn parse(&self, domain: &Domain, text: &str) -> Checked<Value> {
        if !self.is_set && text == "NULL" {
            return Ok(Value::Null);
        }
        let param = Param {
            name: self.name.clone(),
            base: Base::Entity(self.ty),
            is_set: self.is_set,
        };
        notation::argument(domain, &param, text)
    }
}
