//! The declared names: types, entities, attributes, facts, geometric actions, and the heads of functions and tasks.
//!
//! Does not look into tests, effects or expressions: all names are known before any is used, so declarations come in any
//! order.

use indexmap::IndexMap;

use super::{Given, PRELUDE, kinds::Kind, problems};
use crate::diag::{Problem, Problems};
use crate::ir::{self, Base, Domain, EntityId, FactId, RequestId, StringId, TypeId};
use crate::source::Span;
use crate::syntax::ast::{self, Item, Name, Param};

/// Supertypes above one another; each entity is listed in all of them.
const MAX_SUPERTYPES: usize = 32;

/// What may be called with arguments.
#[derive(Debug, Clone)]
pub(super) struct Signature {
    pub params: Vec<(String, Kind)>,
    pub span: Span,
}

/// A question with a truth value or a number for an answer.
#[derive(Debug, Clone)]
pub(super) struct Question {
    pub signature: Signature,
    pub result: Kind,
    pub asks: Asks,
}

/// Who answers a question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asks {
    Geometry(RequestId),
    Domain(FactId),
}

/// All names of a domain; `domain` has the types, entities and attributes already.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub domain: Domain,
    pub types: IndexMap<String, (TypeId, Option<Span>)>,
    pub entities: IndexMap<String, (EntityId, Option<Span>)>,
    /// Places of `domain.attributes`.
    pub attribute_spans: Vec<Span>,
    /// Own attributes by type and name: looked up for every step of every path.
    pub own_attributes: Vec<IndexMap<String, ir::AttributeId>>,
    /// Types whose attributes are not all known.
    pub open_types: Vec<TypeId>,
    pub facts: IndexMap<String, Question>,
    pub requests: IndexMap<String, Question>,
    pub geometrics: IndexMap<String, Signature>,
    /// With the kind of the result.
    pub functions: IndexMap<String, (Signature, Kind)>,
    pub tasks: IndexMap<String, (ir::TaskId, Signature)>,
    strings: IndexMap<String, StringId>,
    /// What functions have been written out to so far [nodes].
    pub n_written_out: usize,
}

impl Names {
    /// Collects the names of `items` and of the world.
    pub(super) fn collect(items: &[&Item], given: &Given, problems: &mut Problems) -> Self {
        let mut names = Names::default();
        names.collect_types(items, problems);
        names.limit_depth(items, problems);
        names.collect_entities(items, given, problems);
        names.collect_callables(items, problems);
        names.collect_attributes(items, problems);
        names.collect_tasks(items, problems);
        names
    }

    fn collect_types(&mut self, items: &[&Item], problems: &mut Problems) {
        self.add_type("Agent", None);
        let declared = || {
            items.iter().filter_map(|item| match item {
                Item::EntityType(t) => Some(t),
                _ => None,
            })
        };
        for t in declared() {
            let name = &t.name;
            if ["number", "int", "float", "bool", "string", "any", "duration"].contains(&name.text.as_str()) {
                let message = format!("`{}` is a word of the language", name.text);
                problems.push(
                    Problem::error("hatp::duplicate-name", message, name.span, "").help("give the type another name"),
                );
                continue;
            }
            match self.types.get(&name.text) {
                // LAAS files never declare Agent; one that does says nothing wrong.
                Some((_, None)) => {}
                Some((_, first)) => problems.push(problems::duplicate("type", &name.text, name.span, *first)),
                None => self.add_type(&name.text, Some(name.span)),
            }
        }
        let mut heads = vec![None; self.domain.types.len()];
        for t in declared() {
            let Some(parent) = &t.parent else { continue };
            let (Some(parent), Some((sub, _))) = (self.type_named(parent, problems), self.types.get(&t.name.text))
            else {
                continue;
            };
            if let (Some(ty), Some(head)) = (self.domain.types.get_mut(sub.index()), heads.get_mut(sub.index())) {
                ty.parent = Some(parent);
                *head = Some(t);
            }
        }
        // Walking up from each type instead would take a long chain of types apart again and again.
        let parents = self.domain.types.iter().map(|t| t.parent.map(|p| p.index()));
        let after: Vec<Vec<usize>> = parents.map(|p| p.into_iter().collect()).collect();
        for circle in super::order::sort(&after).circles {
            let Some(last) = circle.into_iter().max() else { continue };
            if let Some(ty) = self.domain.types.get_mut(last) {
                ty.parent = None;
            }
            problems.0.extend(
                heads
                    .get(last)
                    .copied()
                    .flatten()
                    .map(|t| problems::type_cycle(&t.name)),
            );
        }
    }

    /// Cuts and reports chains of supertypes that are too long.
    fn limit_depth(&mut self, items: &[&Item], problems: &mut Problems) {
        for item in items {
            let Item::EntityType(t) = item else { continue };
            let Some((id, _)) = self.types.get(&t.name.text) else {
                continue;
            };
            let mut at = Some(*id);
            for _ in 0..MAX_SUPERTYPES {
                at = at.and_then(|t| self.domain.types.get(t.index())).and_then(|t| t.parent);
            }
            if at.is_some() {
                if let Some(ty) = self.domain.types.get_mut(id.index()) {
                    ty.parent = None;
                }
                problems.push(problems::too_many_supertypes(&t.name, MAX_SUPERTYPES));
            }
        }
    }

    fn add_type(&mut self, name: &str, span: Option<Span>) {
        let id = TypeId(self.domain.types.len() as u32);
        self.types.insert(name.into(), (id, span));
        self.domain.types.push(ir::Type {
            name: name.into(),
            parent: None,
            entities: Vec::new(),
        });
    }

    /// Returns the type of entities of that name, or reports it.
    pub(super) fn type_named(&self, name: &Name, problems: &mut Problems) -> Option<TypeId> {
        let found = self.types.get(&name.text).map(|t| t.0);
        if found.is_none() && ["number", "int", "float", "bool", "string"].contains(&name.text.as_str()) {
            problems.push(problems::no_entities(name));
        } else if found.is_none() {
            let candidates = self.types.keys().map(String::as_str);
            problems.push(problems::unknown(
                "hatp::unknown-type",
                "type",
                &name.text,
                name.span,
                candidates,
            ));
        }
        found
    }

    /// Returns what `number`, `bool`, `string` or a type of entities stands for, or reports it.
    pub(super) fn base_named(&self, name: &Name, problems: &mut Problems) -> Option<Base> {
        match name.text.as_str() {
            "number" | "int" | "float" => Some(Base::Number),
            "bool" => Some(Base::Bool),
            "string" => Some(Base::String),
            text => match self.types.get(text) {
                Some((id, _)) => Some(Base::Entity(*id)),
                None => {
                    let words = ["number", "bool", "string"].into_iter();
                    let candidates = words.chain(self.types.keys().map(String::as_str));
                    problems.push(problems::unknown(
                        "hatp::unknown-type",
                        "type",
                        text,
                        name.span,
                        candidates,
                    ));
                    None
                }
            },
        }
    }

    /// Returns the type that every agent of the world has unless it says otherwise.
    pub(super) fn agent(&self) -> TypeId {
        TypeId(0)
    }

    fn add_entity(&mut self, name: &str, ty: TypeId, span: Option<Span>) {
        let id = EntityId(self.domain.entities.len() as u32);
        self.entities.insert(name.into(), (id, span));
        self.domain.entities.push(ir::Entity { name: name.into(), ty });
        let mut at = Some(ty);
        while let Some(t) = at.and_then(|t| self.domain.types.get_mut(t.index())) {
            t.entities.push(id);
            at = t.parent;
        }
    }

    fn collect_entities(&mut self, items: &[&Item], given: &Given, problems: &mut Problems) {
        for item in items {
            let Item::Entity(entity) = item else { continue };
            let name = &entity.name;
            if let Some((_, first)) = self.entities.get(&name.text) {
                problems.push(problems::duplicate("entity", &name.text, name.span, *first));
            } else if let Some(ty) = self.type_named(&entity.ty, problems) {
                self.add_entity(&name.text, ty, Some(name.span));
            }
        }
        for entity in &given.entities {
            let ty = match &entity.ty {
                Some(text) => {
                    let name = Name {
                        text: text.clone(),
                        span: entity.span,
                    };
                    let Some((ty, _)) = self.types.get(text) else {
                        let candidates = self.types.keys().map(String::as_str);
                        problems.push(problems::unknown_type_of(&entity.name, &name, candidates));
                        continue;
                    };
                    Some(*ty)
                }
                None => None,
            };
            let declared = self.entities.get(&entity.name).copied();
            let is_agent = |ty: TypeId| !entity.is_agent || self.domain.is_subtype(ty, self.agent());
            let type_name = |ty: TypeId| self.domain.types.get(ty.index()).map_or("?", |t| t.name.as_str());
            match (declared, ty) {
                (Some((id, first)), ty) => {
                    let Some(old) = self.domain.entities.get(id.index()).map(|e| e.ty) else {
                        continue;
                    };
                    if let Some(ty) = ty.filter(|t| *t != old) {
                        let (one, other) = (type_name(old), type_name(ty));
                        problems.push(problems::type_conflict(&entity.name, one, other, entity.span, first));
                    } else if !is_agent(old) {
                        let span = first.unwrap_or(entity.span);
                        problems.push(problems::not_an_agent(&entity.name, type_name(old), span));
                    }
                }
                (None, Some(ty)) if !is_agent(ty) => {
                    problems.push(problems::not_an_agent(&entity.name, type_name(ty), entity.span));
                }
                (None, Some(ty)) => self.add_entity(&entity.name, ty, Some(entity.span)),
                (None, None) if entity.is_agent => self.add_entity(&entity.name, self.agent(), Some(entity.span)),
                // Furniture without a type is there for geometry only.
                (None, None) => {}
            }
        }
    }

    /// Returns the kind of a parameter, or reports its type.
    fn param_kind(&self, param: &Param, may_be_any: bool, problems: &mut Problems) -> Kind {
        if param.ty.text == "any" && (may_be_any || param.ty.span.file == PRELUDE) {
            return if param.is_set { Kind::Set(None) } else { Kind::Any };
        }
        match self.base_named(&param.ty, problems) {
            Some(base) => Kind::of(base, param.is_set),
            None => Kind::Unknown,
        }
    }

    fn signature(&self, params: &[Param], span: Span, problems: &mut Problems) -> Signature {
        self.signature_with(params, span, false, problems)
    }

    /// As `signature`; `may_be_any` allows parameters of type `any`.
    pub(super) fn signature_with(
        &self,
        params: &[Param],
        span: Span,
        may_be_any: bool,
        problems: &mut Problems,
    ) -> Signature {
        let mut seen: IndexMap<&str, Span> = IndexMap::new();
        let mut out = Vec::new();
        for param in params {
            if let Some(first) = seen.insert(&param.name.text, param.name.span) {
                problems.push(problems::duplicate(
                    "parameter",
                    &param.name.text,
                    param.name.span,
                    Some(first),
                ));
            }
            out.push((param.name.text.clone(), self.param_kind(param, may_be_any, problems)));
        }
        Signature { params: out, span }
    }

    fn collect_callables(&mut self, items: &[&Item], problems: &mut Problems) {
        for item in items {
            match item {
                Item::Function(f) => {
                    let signature = self.signature(&f.params, f.name.span, problems);
                    let result = if f.result.text == "duration" {
                        Kind::Duration
                    } else {
                        self.base_named(&f.result, problems)
                            .map_or(Kind::Unknown, |b| Kind::of(b, false))
                    };
                    let first = self.functions.get(&f.name.text).map(|(s, _)| s.span);
                    if first.is_some() {
                        problems.push(problems::duplicate("function", &f.name.text, f.name.span, first));
                    } else {
                        self.functions.insert(f.name.text.clone(), (signature, result));
                    }
                }
                Item::Fact(fact) => self.collect_fact(fact, problems),
                Item::Request(request) if request.span.file == PRELUDE => {
                    let signature = self.signature(&request.params, request.name.span, problems);
                    let base = self.base_named(&request.result, problems).unwrap_or(Base::Bool);
                    let question = self.ask_geometry(&request.name.text, signature, base);
                    self.requests.insert(request.name.text.clone(), question);
                }
                Item::Geometric(g) => {
                    let signature = self.signature_with(&g.params, g.name.span, true, problems);
                    let first = self.geometrics.get(&g.name.text).map(|s| s.span);
                    if first.is_some() {
                        let what = "geometric action";
                        problems.push(problems::duplicate(what, &g.name.text, g.name.span, first));
                    } else {
                        self.geometrics.insert(g.name.text.clone(), signature);
                    }
                }
                _ => {}
            }
        }
    }

    /// Returns a question that geometry answers.
    fn ask_geometry(&mut self, name: &str, signature: Signature, result: Base) -> Question {
        let id = RequestId(self.domain.requests.len() as u32);
        self.domain.requests.push(ir::Request {
            name: name.into(),
            result,
        });
        Question {
            signature,
            result: Kind::of(result, false),
            asks: Asks::Geometry(id),
        }
    }

    fn collect_fact(&mut self, fact: &ast::Fact, problems: &mut Problems) {
        let name = &fact.name;
        if fact.span.file == PRELUDE {
            let signature = self.signature(&fact.params, name.span, problems);
            let question = self.ask_geometry(&name.text, signature, Base::Bool);
            self.facts.insert(name.text.clone(), question);
            return;
        }
        if let Some(first) = self.facts.get(&name.text).map(|q| q.signature.span) {
            problems.push(problems::duplicate("fact", &name.text, name.span, Some(first)));
            return;
        }
        // No fact about the world, but who sees what: `beliefs` has it.
        if name.text == super::beliefs::OBSERVES {
            return;
        }
        let signature = self.signature_with(&fact.params, name.span, true, problems);
        let id = FactId(self.domain.facts.len() as u32);
        self.domain.facts.push(ir::Fact {
            name: name.text.clone(),
            params: signature.params.iter().map(|p| p.0.clone()).collect(),
            n_vars: signature.params.len(),
            body: ir::Test::always(),
        });
        let question = Question {
            signature,
            result: Kind::Bool,
            asks: Asks::Domain(id),
        };
        self.facts.insert(name.text.clone(), question);
    }

    /// Notes the types, by name, that have attributes which could not be read.
    pub(super) fn leave_open<'a>(&mut self, names: impl Iterator<Item = &'a String>) {
        self.open_types = names.filter_map(|name| self.types.get(name)).map(|t| t.0).collect();
    }

    fn collect_tasks(&mut self, items: &[&Item], problems: &mut Problems) {
        let (mut n_actions, mut n_methods) = (0, 0);
        for item in items {
            let (name, params, id) = match item {
                Item::Action(a) => (&a.name, &a.params, ir::TaskId::Action(ir::ActionId(n_actions))),
                Item::Method(m) => (&m.name, &m.params, ir::TaskId::Method(ir::MethodId(n_methods))),
                _ => continue,
            };
            // Positions count every declaration, also a repeated one, so that they are those of the tables.
            match id {
                ir::TaskId::Action(_) => n_actions += 1,
                ir::TaskId::Method(_) => n_methods += 1,
            }
            let signature = self.signature(params, name.span, problems);
            match self.tasks.get(&name.text) {
                Some((_, first)) => {
                    problems.push(problems::duplicate("task", &name.text, name.span, Some(first.span)));
                }
                None => {
                    self.tasks.insert(name.text.clone(), (id, signature));
                }
            }
        }
    }

    /// Takes over a compiled domain.
    pub(super) fn set_domain(&mut self, domain: &Domain) {
        self.domain = domain.clone();
        self.own_attributes = vec![IndexMap::new(); domain.types.len()];
        for (i, attribute) in domain.attributes.iter().enumerate() {
            if let Some(own) = self.own_attributes.get_mut(attribute.owner.index()) {
                own.insert(attribute.name.clone(), ir::AttributeId(i as u32));
            }
        }
        self.strings = domain
            .strings
            .iter()
            .enumerate()
            .map(|(i, s)| (s.clone(), StringId(i as u32)))
            .collect();
    }

    /// Returns the id of a string constant.
    pub(super) fn string(&mut self, text: &str) -> StringId {
        if let Some(id) = self.strings.get(text) {
            return *id;
        }
        let id = StringId(self.domain.strings.len() as u32);
        self.domain.strings.push(text.into());
        self.strings.insert(text.into(), id);
        id
    }
}
