//! Attributes: which type has which, their slots, and the facts that shared ones are read from (thesis 4.3.3).

use indexmap::IndexMap;

use super::names::{Names, Question};
use super::{Given, kinds::Kind, problems};
use crate::diag::{Problem, Problems};
use crate::ir::{self, Base, EntityId, TypeId};
use crate::source::Span;
use crate::syntax::ast::{self, Item, Name};

/// Attributes times entities: the table has a place for each pair. HEURISTIC: 80 MB; real domains stay below 10 000.
const MAX_SLOTS: usize = 10_000_000;
/// Values of attributes with arguments, all together. HEURISTIC: about 100 bytes each while planning; a domain that needs
/// more wants narrower types.
const MAX_ARGUMENT_SLOTS: usize = 5_000_000;

impl Names {
    /// Declares all attributes and gives each entity its slots.
    pub(super) fn collect_attributes(&mut self, items: &[&Item], problems: &mut Problems) {
        for item in items {
            let Item::Attributes(block) = item else { continue };
            let Some(owner) = self.type_named(&block.owner, problems) else {
                continue;
            };
            for attribute in &block.attributes {
                self.add_attribute(owner, attribute, problems);
            }
        }
        // A subtype must not declare again what it inherits; the supertype's block may come later in the file.
        for (i, attribute) in self.domain.attributes.iter().enumerate() {
            let parent = self.domain.types.get(attribute.owner.index()).and_then(|t| t.parent);
            let inherited = parent.and_then(|p| self.attribute_of(p, &attribute.name));
            if let (Some(first), Some(span)) = (inherited, self.attribute_spans.get(i)) {
                let first = self.attribute_spans.get(first.index()).copied();
                problems.push(problems::duplicate("attribute", &attribute.name, *span, first));
            }
        }
        let n_entities = self.domain.entities.len();
        if self.domain.attributes.len().saturating_mul(n_entities) > MAX_SLOTS {
            if let Some(span) = self.attribute_spans.last() {
                problems.push(problems::too_many_slots(
                    self.domain.attributes.len(),
                    n_entities,
                    *span,
                ));
            }
            return;
        }
        for attribute in &mut self.domain.attributes {
            attribute.slots = vec![None; self.domain.entities.len()];
        }
        let Some(n_values) = self.lay_out_arguments(problems) else {
            return;
        };
        for (e, entity) in self.domain.entities.iter().enumerate() {
            let mut at = Some(entity.ty);
            let mut ids: Vec<ir::AttributeId> = Vec::new();
            while let Some(t) = at {
                ids.extend(
                    self.own_attributes
                        .get(t.index())
                        .into_iter()
                        .flatten()
                        .map(|(_, id)| *id),
                );
                at = self.domain.types.get(t.index()).and_then(|t| t.parent);
            }
            ids.sort_unstable();
            for id in ids {
                let Some(attribute) = self.domain.attributes.get_mut(id.index()) else {
                    continue;
                };
                let n = n_values.get(id.index()).copied().unwrap_or(1);
                if let Some(slot) = attribute.slots.get_mut(e).filter(|_| n > 0) {
                    *slot = Some(ir::SlotId(self.domain.slots.len() as u32));
                }
                let slot = ir::Slot {
                    entity: EntityId(e as u32),
                    attribute: id,
                };
                let unset = match (attribute.is_set, attribute.base) {
                    (false, _) => ir::Value::Null,
                    (true, Base::Entity(_)) => ir::Value::Set(Default::default()),
                    (true, Base::Number | Base::Bool | Base::String) => ir::Value::Scalars(Default::default()),
                };
                self.domain.slots.extend(std::iter::repeat_n(slot, n));
                self.domain.initial.extend(std::iter::repeat_n(unset, n));
            }
        }
    }

    /// Says how far each argument moves a slot; returns how many values each attribute has for one entity. Reports the first
    /// attribute with which they are too many.
    fn lay_out_arguments(&mut self, problems: &mut Problems) -> Option<Vec<usize>> {
        let domain = &mut self.domain;
        let mut n_all = 0_usize;
        let mut n_values = Vec::with_capacity(domain.attributes.len());
        for (attribute, span) in domain.attributes.iter_mut().zip(&self.attribute_spans) {
            let entities_of = |ty: TypeId| domain.types.get(ty.index()).map_or(&[][..], |t| &t.entities);
            let sizes = attribute.arguments.iter().map(|a| entities_of(a.ty).len());
            let n_known = sizes.fold(1, usize::saturating_mul);
            let n_views = attribute.believer.as_ref().map_or(1, |b| 1 + entities_of(b.ty).len());
            let n = n_known.saturating_mul(n_views);
            n_values.push(n);
            if attribute.arguments.is_empty() && attribute.believer.is_none() {
                continue;
            }
            n_all = n_all.saturating_add(n.saturating_mul(entities_of(attribute.owner).len()));
            if n_all > MAX_ARGUMENT_SLOTS {
                let name = Name {
                    text: attribute.name.clone(),
                    span: *span,
                };
                problems.push(problems::too_many_argument_slots(&name, MAX_ARGUMENT_SLOTS));
                return None;
            }
            let mut step = 1_u32;
            for argument in attribute.arguments.iter_mut().rev() {
                argument.offsets = vec![None; domain.entities.len()];
                let of_type = entities_of(argument.ty);
                for (i, entity) in of_type.iter().enumerate() {
                    if let Some(offset) = argument.offsets.get_mut(entity.index()) {
                        // INVARIANT: below the number of values, which is small here unless there are none at all.
                        *offset = Some(step.saturating_mul(i as u32));
                    }
                }
                step = step.saturating_mul(of_type.len() as u32);
            }
            if let Some(believer) = &mut attribute.believer {
                believer.offsets = vec![None; domain.entities.len()];
                for (i, agent) in entities_of(believer.ty).iter().enumerate() {
                    if let Some(offset) = believer.offsets.get_mut(agent.index()) {
                        *offset = Some(step.saturating_mul(1 + i as u32));
                    }
                }
            }
        }
        Some(n_values)
    }

    fn add_attribute(&mut self, owner: TypeId, attribute: &ast::Attribute, problems: &mut Problems) {
        let name = &attribute.name;
        let own = self.own_attribute(owner, &name.text);
        if let Some(first) = own.and_then(|id| self.attribute_spans.get(id.index())) {
            problems.push(problems::duplicate("attribute", &name.text, name.span, Some(*first)));
            return;
        }
        let Some(base) = self.base_named(&attribute.base, problems) else {
            return;
        };
        let mut arguments = Vec::new();
        for param in &attribute.params {
            match self.base_named(&param.ty, problems) {
                Some(Base::Entity(ty)) => arguments.push(ir::Argument {
                    ty,
                    offsets: Vec::new(),
                }),
                Some(other @ (Base::Number | Base::Bool | Base::String)) => {
                    let found = Kind::of(other, false).words(&self.domain);
                    let problem = problems::wrong_type(param.ty.span, "a type of entities", &found);
                    problems
                        .push(problem.help("there is a value for each choice of entities, and they must be countable"));
                    return;
                }
                None => return,
            }
        }
        let Ok(believer) = self.believer(attribute, problems) else {
            return;
        };
        let declared = ir::Attribute {
            name: name.text.clone(),
            owner,
            is_static: attribute.is_static,
            is_set: attribute.is_set,
            base,
            fact: None,
            arguments,
            believer,
            slots: Vec::new(),
        };
        self.domain.attributes.push(declared);
        self.attribute_spans.push(name.span);
        let id = ir::AttributeId(self.domain.attributes.len() as u32 - 1);
        self.own_attributes.resize_with(self.domain.types.len(), IndexMap::new);
        if let Some(own) = self.own_attributes.get_mut(owner.index()) {
            own.insert(name.text.clone(), id);
        }
        if let Some(fact) = &attribute.fact {
            let id = self.domain.attributes.len() - 1;
            self.share(id, &fact.text, fact.span, problems);
        }
    }

    /// Makes attribute `id` read from `fact`, if it fits.
    fn share(&mut self, id: usize, fact: &str, span: Span, problems: &mut Problems) {
        let Some(Question { signature, .. }) = self.facts.get(fact) else {
            let candidates = self.facts.keys().map(String::as_str);
            problems.push(problems::unknown("hatp::unknown-fact", "fact", fact, span, candidates));
            return;
        };
        let Some(attribute) = self.domain.attributes.get(id) else {
            return;
        };
        let name = &attribute.name;
        if let Some(old) = attribute.fact.as_deref().filter(|old| *old != fact) {
            let message = format!("`{name}` is read from fact `{old}` in the domain and from `{fact}` here");
            problems.push(problems::wrong_fact(message, span, "remove one of the two"));
            return;
        }
        if attribute.believer.is_some() {
            let message = format!("fact `{fact}` is the same for all, and `{name}` is per agent");
            let problem = Problem::error("hatp::not-supported", message, span, "not yet");
            problems.push(problem.help("set the attribute in effects, or declare a second one that is shared"));
            return;
        }
        if !attribute.arguments.is_empty() {
            let message = format!("fact `{fact}` gives one value for each entity, and `{name}` has arguments");
            problems.push(problems::wrong_fact(message, span, "ask the fact in a test instead"));
            return;
        }
        if attribute.is_static {
            let message = format!("static attribute `{name}` can't follow fact `{fact}`, which changes");
            problems.push(problems::wrong_fact(message, span, "declare the attribute `dynamic`"));
            return;
        }
        let (owner, holds) = (
            Kind::Entity(attribute.owner),
            Kind::of(attribute.base, attribute.is_set),
        );
        let params: Vec<String> = signature
            .params
            .iter()
            .map(|(n, k)| format!("{} {n}", k.declared(&self.domain)))
            .collect();
        let shown = format!("{fact}({})", params.join(", "));
        let kinds: Vec<Kind> = signature.params.iter().map(|p| p.1).collect();
        // Each is what stands there, and what the fact wants there.
        let (parts, help) = match kinds[..] {
            [subject, object] => (
                vec![
                    ("of", owner, subject),
                    ("holding", Kind::of(attribute.base, false), object),
                ],
                format!("the fact is `{shown}`: the attribute stands on the first and holds the second"),
            ),
            [subject] => (
                vec![("of", owner, subject), ("holding", holds, Kind::Bool)],
                format!("the fact is `{shown}`: the attribute stands on its parameter and holds a bool"),
            ),
            _ => {
                let message = format!(
                    "fact `{shown}` is about {} entities, and an attribute has room for one or two",
                    kinds.len()
                );
                problems.push(problems::wrong_fact(message, span, "ask it in a test instead"));
                return;
            }
        };
        for (part, kind, wanted) in parts {
            if !kind.fits(wanted, &self.domain) {
                let (kind, wanted) = (kind.words(&self.domain), wanted.words(&self.domain));
                let message = format!("fact `{fact}` needs {wanted}, and `{name}` is an attribute {part} {kind}");
                problems.push(problems::wrong_fact(message, span, help));
                return;
            }
        }
        if let Some(attribute) = self.domain.attributes.get_mut(id) {
            attribute.fact = Some(fact.to_owned());
        }
    }

    /// Applies the world's `[facts]`.
    pub(super) fn share_given(&mut self, given: &Given, problems: &mut Problems) {
        for (target, fact, span) in &given.shared {
            let (owner, attribute) = match target.split_once('.') {
                Some((owner, attribute)) => {
                    let owner = Name {
                        text: owner.into(),
                        span: *span,
                    };
                    match self.type_named(&owner, problems) {
                        Some(owner) => (Some(owner), attribute),
                        None => continue,
                    }
                }
                None => (None, target.as_str()),
            };
            let attributes = self.domain.attributes.iter().enumerate();
            let ids: Vec<usize> = attributes
                .filter(|(_, a)| a.name == attribute && owner.is_none_or(|o| o == a.owner))
                .map(|(i, _)| i)
                .collect();
            if ids.is_empty() {
                let known = self
                    .domain
                    .attributes
                    .iter()
                    .filter(|a| owner.is_none_or(|o| o == a.owner));
                let known = known.map(|a| a.name.as_str());
                let code = "hatp::unknown-attribute";
                problems.push(problems::unknown(code, "attribute", attribute, *span, known));
            }
            for id in ids {
                self.share(id, fact, *span, problems);
            }
        }
    }

    fn own_attribute(&self, ty: TypeId, name: &str) -> Option<ir::AttributeId> {
        self.own_attributes.get(ty.index())?.get(name).copied()
    }

    /// Returns the attribute of that name that entities of type `ty` have, own or inherited.
    pub(super) fn attribute_of(&self, ty: TypeId, name: &str) -> Option<ir::AttributeId> {
        let mut at = Some(ty);
        while let Some(t) = at {
            let own = self.own_attribute(t, name);
            if own.is_some() {
                return own;
            }
            at = self.domain.types.get(t.index()).and_then(|t| t.parent);
        }
        None
    }

    /// Says whether there is such an entity, and its type has such an attribute.
    pub(super) fn declares(&self, entity: &str, attribute: &str) -> bool {
        let ty = self
            .entities
            .get(entity)
            .and_then(|e| self.domain.entities.get(e.0.index()));
        ty.is_some_and(|e| self.attribute_of(e.ty, attribute).is_some())
    }

    /// Returns the attribute, or reports it with the nearest of those that `ty` has.
    pub(super) fn attribute_named(&self, ty: TypeId, name: &Name, problems: &mut Problems) -> Option<ir::AttributeId> {
        let found = self.attribute_of(ty, &name.text);
        let mut open = self.open_types.iter();
        if found.is_none() && !open.any(|open| self.domain.is_subtype(ty, *open)) {
            let own = self.domain.attributes.iter().zip(&self.attribute_spans);
            let own = own.filter(|(a, _)| self.domain.is_subtype(ty, a.owner));
            let candidates = own.map(|(a, span)| (a.name.as_str(), *span));
            let owner = self.domain.types.get(ty.index()).map_or("?", |t| t.name.as_str());
            let below = self
                .domain
                .attributes
                .iter()
                .find(|a| a.name == name.text && self.domain.is_subtype(a.owner, ty));
            let below = below
                .and_then(|a| self.domain.types.get(a.owner.index()))
                .map(|t| t.name.as_str());
            problems.push(problems::unknown_attribute(
                owner, &name.text, name.span, candidates, below,
            ));
        }
        found
    }
}
