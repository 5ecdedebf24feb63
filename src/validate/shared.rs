//! Shared attributes (thesis 4.3.3): their values as read from geometry, held against what the plan claims.
//!
//! The document lists changes only. What it says of an attribute after an action is the last value listed, so that a
//! wrong fact is found at the first action after which it is wrong. Of the start it says nothing: facts that are unclear
//! there are guesses, and are not held against the plan.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{
    Settings, Verdict,
    bodies::Bodies,
    evaluate::View,
    facts::{self, Status},
    fault::{Checked, Kind},
    notation,
    requests::Asked,
};
use crate::ir::{Base, Domain, EntityId, EntitySet, Param, SlotId, Value};
use crate::plan::Changes;
use crate::world::State;

/// An attribute of an entity of the world that is read from a fact.
pub(super) struct SharedSlot {
    slot: SlotId,
    name: String,
    fact: String,
    is_set: bool,
    base: Base,
    owner: EntityId,
    /// Whose fact with the owner is asked: entities of the attribute's type; the owner itself for a truth value.
    candidates: Vec<EntityId>,
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
            let Some(fact) = &attribute.fact else { continue };
            let is_placed = |e: &EntityId| bodies.scene.find(&domain.entities[e.index()].name).is_some();
            // A fact that the domain defines may speak of what is nowhere; without a world there are none.
            let is_defined = domain.facts.iter().any(|f| f.name == *fact);
            let is_known = if is_defined {
                !(bodies.scene.agents.is_empty() && bodies.scene.objects.is_empty())
            } else {
                is_placed(&slot.entity)
            };
            if !is_known {
                continue;
            }
            let name = domain.slot_name(SlotId(i as u32));
            let candidates = match attribute.base {
                Base::Entity(ty) => {
                    let entities = domain.types[ty.index()].entities.iter();
                    entities.copied().filter(|e| is_defined || is_placed(e)).collect()
                }
                Base::Bool if is_defined => vec![slot.entity],
                Base::Bool | Base::Number | Base::String => {
                    return Err(Kind::FactUnchecked {
                        attribute: name,
                        fact: fact.clone(),
                    }
                    .into());
                }
            };
            slots.push(SharedSlot {
                slot: SlotId(i as u32),
                name,
                fact: fact.clone(),
                is_set: attribute.is_set,
                base: attribute.base,
                owner: slot.entity,
                candidates,
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

    /// Returns the slots with an element that is a guess.
    pub(super) fn guesses(&self) -> BTreeSet<SlotId> {
        self.guessed.iter().map(|(slot, _)| *slot).collect()
    }

    /// Takes the plan's word for the slot from now on.
    pub(super) fn settle(&mut self, slot: SlotId) {
        self.guessed.retain(|(s, _)| *s != slot);
    }

    /// Reads the facts of the start state into `values`.
    pub(super) fn read_start(
        &mut self,
        state: &State,
        asked: &Asked<'_>,
        values: &mut [Value],
        verdict: &mut Verdict,
    ) -> Checked<()> {
        for shared in &self.slots {
            let mut members = EntitySet::default();
            for e in &shared.candidates {
                let status = self.status(shared, state, asked, *e, None)?;
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

    /// Reads the facts of the state after an action, against `changes`, into `values`; `before` is the
    /// snapshot before it.
    pub(super) fn read(
        &mut self,
        state: &State,
        asked: &Asked<'_>,
        before: &[(SlotId, Value)],
        values: &mut [Value],
        changes: &Changes,
        verdict: &mut Verdict,
    ) -> Checked<()> {
        for (shared, (_, carried)) in self.slots.iter().zip(before) {
            let listed = match changes.get(&shared.name) {
                Some(text) => Some(shared.parse(self.domain, text)?),
                None => None,
            };
            let claimed = listed.as_ref().unwrap_or(carried);
            let mut members = EntitySet::default();
            for e in &shared.candidates {
                let claim = match claimed {
                    Value::Set(s) => s.contains(*e),
                    Value::Bool(b) => *b,
                    other => *other == Value::Entity(*e),
                };
                // Of two things that an atom could name, the plan names one.
                let other_named = !shared.is_set && !claim && *claimed != Value::Null;
                let known = listed.is_some() || !self.guessed.contains(&(shared.slot, *e));
                let status = self.status(shared, state, asked, *e, known.then_some(claim))?;
                verdict.facts += 1;
                let fact = || {
                    let name = |e: EntityId| self.domain.entities[e.index()].name.as_str();
                    match shared.base {
                        Base::Entity(_) => format!("{}({}, {})", shared.fact, name(shared.owner), name(*e)),
                        Base::Bool | Base::Number | Base::String => format!("{}({})", shared.fact, name(shared.owner)),
                    }
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

impl Shared<'_> {
    /// Returns what the fact of a slot is about one of its candidates.
    fn status(
        &self,
        shared: &SharedSlot,
        state: &State,
        asked: &Asked<'_>,
        candidate: EntityId,
        claim: Option<bool>,
    ) -> Checked<Status> {
        let domain = self.domain;
        if let Some(fact) = domain.facts.iter().find(|f| f.name == shared.fact) {
            // Its body asks requests and static attributes only: the values at the start will do.
            let view = View::new(domain, &domain.initial, Some(asked));
            let mut frame = vec![Value::Entity(shared.owner)];
            if let Base::Entity(_) = shared.base {
                frame.push(Value::Entity(candidate));
            }
            frame.resize(fact.n_vars.max(frame.len()), Value::Null);
            let may = view.holds(&fact.body, &mut frame);
            return Ok(if !may {
                Status::Fails
            } else if view.strict().holds(&fact.body, &mut frame) {
                Status::Holds
            } else {
                Status::Unclear(claim.unwrap_or(true))
            });
        }
        let place = |e: EntityId| self.bodies.scene.find(&domain.entities[e.index()].name);
        let status = match (place(shared.owner), place(candidate)) {
            (Some(of), Some(with)) => facts::status(self.bodies, state, &shared.fact, of, with, claim, self.settings),
            (None, _) | (_, None) => Some(Status::Fails),
        };
        status.ok_or_else(|| {
            Kind::FactUnchecked {
                attribute: shared.name.clone(),
                fact: shared.fact.clone(),
            }
            .into()
        })
    }
}

impl SharedSlot {
    /// Returns the members as the attribute holds them; an atom prefers the one that is claimed.
    fn value(&self, members: &EntitySet, claimed: Option<&Value>) -> Value {
        if self.is_set {
            return Value::Set(Arc::new(members.clone()));
        }
        if self.base == Base::Bool {
            return Value::Bool(!members.is_empty());
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
            base: self.base,
            is_set: self.is_set,
        };
        notation::argument(domain, &param, text)
    }
}
