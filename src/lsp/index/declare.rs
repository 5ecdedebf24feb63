//! What is known in the whole file: types, attributes, entities, tasks, functions, and what the prelude declares.

use super::{Declared, Index, Kind, Symbol, SymbolId, Value};
use crate::source::Span;
use crate::syntax::ast::{Attribute, Item, Name, Param};

/// Adds every declaration of `items`; of two with one name the first counts.
pub(super) fn declare(index: &mut Index, items: &[&Item]) {
    let agent = Symbol {
        kind: Kind::Type,
        name: "Agent".into(),
        declared: None,
        head: "define entityType Agent".into(),
        value: Value::Unknown,
        params: Vec::new(),
        owner: None,
    };
    let agent = index.add(agent);
    index.types.insert("Agent".into(), agent);
    for item in items {
        let Item::EntityType(t) = item else { continue };
        let head = match &t.parent {
            Some(parent) => format!("define entityType {} : {}", t.name.text, parent.text),
            None => format!("define entityType {}", t.name.text),
        };
        if !index.types.contains_key(&t.name.text) {
            let id = index.declared(Kind::Type, &t.name, t.span, head);
            index.types.insert(t.name.text.clone(), id);
        }
    }
    for item in items {
        let Item::EntityType(t) = item else { continue };
        let ids = (
            index.type_named(&t.name.text),
            t.parent.as_ref().and_then(|p| index.type_named(&p.text)),
        );
        if let (Some(ty), Some(parent)) = ids {
            // The first declaration's; a circle is cut where the chain is walked.
            index.symbols[ty.0].owner.get_or_insert(parent);
        }
    }
    // Entities and tasks need the types; attributes too, whatever the order of the file.
    for item in items {
        match item {
            Item::Attributes(block) => {
                let Some(owner) = index.type_named(&block.owner.text) else {
                    continue;
                };
                for attribute in &block.attributes {
                    index.declare_attribute(owner, attribute);
                }
            }
            Item::Entity(e) => {
                if !index.entities.contains_key(&e.name.text) {
                    let head = format!("{} = new {}", e.name.text, e.ty.text);
                    let id = index.declared(Kind::Entity, &e.name, e.span, head);
                    index.symbols[id.0].value = index.value_of(&e.ty.text, false);
                    index.entities.insert(e.name.text.clone(), id);
                }
            }
            Item::Action(a) => index.declare_callable(Kind::Action, None, &a.name, &a.params, a.span),
            Item::Method(m) => index.declare_callable(Kind::Method, None, &m.name, &m.params, m.span),
            Item::Function(f) => {
                index.declare_callable(Kind::Function, Some(&f.result.text), &f.name, &f.params, f.span);
            }
            Item::Request(r) => {
                index.declare_callable(Kind::Request, Some(&r.result.text), &r.name, &r.params, r.span);
            }
            Item::Fact(f) => index.declare_callable(Kind::Fact, None, &f.name, &f.params, f.span),
            Item::Geometric(g) => index.declare_callable(Kind::Geometric, None, &g.name, &g.params, g.span),
            Item::EntityType(_)
            | Item::Initial(_)
            | Item::Settings(_)
            | Item::Social(_)
            | Item::TimePart(_)
            | Item::Import(_) => {}
        }
    }
}

impl Index {
    pub(super) fn add(&mut self, symbol: Symbol) -> SymbolId {
        self.symbols.push(symbol);
        SymbolId(self.symbols.len() - 1)
    }

    /// Adds a symbol that is declared at `name`, within `whole`.
    pub(super) fn declared(&mut self, kind: Kind, name: &Name, whole: Span, head: String) -> SymbolId {
        self.add(Symbol {
            kind,
            name: name.text.clone(),
            declared: Some(Declared { name: name.span, whole }),
            head,
            value: Value::Unknown,
            params: Vec::new(),
            owner: None,
        })
    }

    fn declare_attribute(&mut self, owner: SymbolId, attribute: &Attribute) {
        let key = (owner, attribute.name.text.clone());
        if self.attributes.contains_key(&key) {
            return;
        }
        let how = if attribute.is_static { "static" } else { "dynamic" };
        let many = if attribute.is_set { "set" } else { "atom" };
        let fact = attribute.fact.as_ref();
        let fact = fact.map_or_else(String::new, |f| format!(" = fact {}", f.text));
        let params = attribute.params_as_written();
        let agents = if attribute.per_agent.is_some() {
            " per agent"
        } else {
            ""
        };
        let head = format!(
            "{how} {many} {} {}{params}{agents}{fact}",
            attribute.base.text, attribute.name.text
        );
        let id = self.declared(Kind::Attribute, &attribute.name, attribute.span, head);
        self.symbols[id.0].value = self.value_of(&attribute.base.text, attribute.is_set);
        self.symbols[id.0].owner = Some(owner);
        self.namesakes.entry(key.1.clone()).or_default().push(id);
        self.attributes.insert(key, id);
    }

    fn declare_callable(&mut self, kind: Kind, result: Option<&str>, name: &Name, params: &[Param], whole: Span) {
        let known = match kind {
            Kind::Action | Kind::Method => &self.tasks,
            Kind::Function => &self.functions,
            Kind::Request => &self.requests,
            Kind::Fact => &self.facts,
            _ => &self.geometrics,
        };
        if known.contains_key(&name.text) {
            return;
        }
        let word = if kind == Kind::Geometric {
            "geometric"
        } else {
            kind.word()
        };
        let result_word = result.map_or_else(String::new, |r| format!(" {r}"));
        let list: Vec<String> = params.iter().map(param_text).collect();
        let head = format!("{word}{result_word} {}({})", name.text, list.join(", "));
        let id = self.declared(kind, name, whole, head);
        self.symbols[id.0].params = params.iter().map(|p| p.name.text.clone()).collect();
        self.symbols[id.0].value = match (kind, result) {
            (Kind::Fact, _) => Value::Bool,
            (_, Some(result)) => self.value_of(result, false),
            (_, None) => Value::Unknown,
        };
        let known = match kind {
            Kind::Action | Kind::Method => &mut self.tasks,
            Kind::Function => &mut self.functions,
            Kind::Request => &mut self.requests,
            Kind::Fact => &mut self.facts,
            _ => &mut self.geometrics,
        };
        known.insert(name.text.clone(), id);
    }
}

/// Returns `set Object Os`.
pub(super) fn param_text(param: &Param) -> String {
    let set = if param.is_set { "set " } else { "" };
    format!("{set}{} {}", param.ty.text, param.name.text)
}
