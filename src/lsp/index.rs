//! Every name of a domain: what it stands for, where it is declared, where it is used.
//!
//! Made from the AST alone, also of a file with mistakes: what can't be resolved is listed as such, and nothing is judged; that is
//! the checker's work. The rules of names are the checker's: attributes belong to a type and its subtypes, a variable lives within its
//! block, whatever else is declared is known in the whole file. A name that stands for an entity and is declared nowhere gets a symbol all the same, since
//! a world file may declare it.

mod declare;
mod resolve;

use indexmap::IndexMap;

use crate::source::{FileId, Span};
use crate::syntax::ast;

/// Stands for the prelude in spans of an index.
pub(super) const PRELUDE: FileId = FileId(u32::MAX);

/// Supertypes looked at above one another; circles are the checker's to report.
const MAX_SUPERTYPES: usize = 32;

/// A place in [`Index::symbols`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct SymbolId(pub usize);

/// What a name is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Type,
    Attribute,
    Entity,
    Action,
    Method,
    Function,
    Geometric,
    Fact,
    Request,
    Parameter,
    Variable,
    Label,
}

impl Kind {
    /// Returns the glossary's word.
    pub(super) fn word(self) -> &'static str {
        match self {
            Kind::Type => "type",
            Kind::Attribute => "attribute",
            Kind::Entity => "entity",
            Kind::Action => "action",
            Kind::Method => "method",
            Kind::Function => "function",
            Kind::Geometric => "geometric action",
            Kind::Fact => "fact",
            Kind::Request => "request",
            Kind::Parameter => "parameter",
            Kind::Variable => "variable",
            Kind::Label => "label",
        }
    }
}

/// What a variable, an attribute or an expression holds; types are symbols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Value {
    Number,
    Bool,
    String,
    Duration,
    Entity(SymbolId),
    Set(Option<SymbolId>),
    /// Not known here: a mistake, an entity of the world, `any` of the prelude.
    Unknown,
}

/// Where a symbol is declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Declared {
    pub name: Span,
    /// The whole declaration.
    pub whole: Span,
}

/// One thing that has a name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Symbol {
    pub kind: Kind,
    pub name: String,
    /// `None`: predefined, or declared in another file.
    pub declared: Option<Declared>,
    /// Its declaration in one line, as the language writes it.
    pub head: String,
    /// What it holds, or gives when it is called.
    pub value: Value,
    /// Names of the parameters of what can be called.
    pub params: Vec<String>,
    /// The type that an attribute stands on, the supertype of a type, the task of a parameter.
    pub owner: Option<SymbolId>,
}

impl Symbol {
    pub(super) fn is_builtin(&self) -> bool {
        match self.declared {
            Some(declared) => declared.name.file == PRELUDE,
            None => self.kind == Kind::Type,
        }
    }
}

/// One place where a name stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Occurrence {
    pub span: Span,
    pub symbol: SymbolId,
    pub is_declaration: bool,
    /// Whether an attribute is changed here.
    pub is_write: bool,
}

/// All names of a domain.
#[derive(Debug, Default)]
pub(super) struct Index {
    symbols: Vec<Symbol>,
    /// Of all files but the prelude, sorted by place.
    occurrences: Vec<Occurrence>,
    /// Steps of paths whose attribute is not known.
    pub unresolved_steps: Vec<ast::Name>,
    types: IndexMap<String, SymbolId>,
    attributes: IndexMap<(SymbolId, String), SymbolId>,
    /// All attributes of that name, of whatever type.
    namesakes: IndexMap<String, Vec<SymbolId>>,
    entities: IndexMap<String, SymbolId>,
    tasks: IndexMap<String, SymbolId>,
    functions: IndexMap<String, SymbolId>,
    requests: IndexMap<String, SymbolId>,
    facts: IndexMap<String, SymbolId>,
    geometrics: IndexMap<String, SymbolId>,
}

impl Index {
    /// Returns the names of `files` and of the prelude.
    pub(super) fn of(prelude: &ast::File, files: &[ast::File]) -> Self {
        let mut index = Index::default();
        let items: Vec<&ast::Item> = prelude
            .items
            .iter()
            .chain(files.iter().flat_map(|f| &f.items))
            .collect();
        declare::declare(&mut index, &items);
        resolve::resolve(&mut index, &items);
        index.occurrences.retain(|o| o.span.file != PRELUDE);
        index.occurrences.sort_by_key(|o| o.span);
        index.occurrences.dedup_by_key(|o| o.span);
        index
    }

    /// Returns the symbol; `id` must come from this index.
    pub(super) fn get(&self, id: SymbolId) -> &Symbol {
        &self.symbols[id.0]
    }

    /// Returns what stands at a byte of a file; the place right behind a name belongs to it.
    pub(super) fn at(&self, file: FileId, at: usize) -> Option<Occurrence> {
        let is_before = |o: &Occurrence| (o.span.file, o.span.start as usize) <= (file, at);
        let after = self.occurrences.partition_point(is_before);
        let found = after.checked_sub(1).and_then(|i| self.occurrences.get(i))?;
        (found.span.file == file && at <= found.span.end as usize).then_some(*found)
    }

    /// Returns every place where the symbol stands, in order.
    pub(super) fn places(&self, symbol: SymbolId) -> impl Iterator<Item = &Occurrence> {
        self.occurrences.iter().filter(move |o| o.symbol == symbol)
    }

    pub(super) fn occurrences(&self) -> &[Occurrence] {
        &self.occurrences
    }

    fn listed<'a>(&'a self, map: &'a IndexMap<String, SymbolId>) -> impl Iterator<Item = &'a Symbol> {
        map.values().map(|id| self.get(*id))
    }

    pub(super) fn types(&self) -> impl Iterator<Item = &Symbol> {
        self.listed(&self.types)
    }

    /// Returns the entities, those of other files that are used here included.
    pub(super) fn entities(&self) -> impl Iterator<Item = &Symbol> {
        self.listed(&self.entities)
    }

    pub(super) fn tasks(&self) -> impl Iterator<Item = &Symbol> {
        self.listed(&self.tasks)
    }

    pub(super) fn facts(&self) -> impl Iterator<Item = &Symbol> {
        self.listed(&self.facts)
    }

    pub(super) fn geometrics(&self) -> impl Iterator<Item = &Symbol> {
        self.listed(&self.geometrics)
    }

    /// Returns what may be called in an expression.
    pub(super) fn callables(&self) -> impl Iterator<Item = &Symbol> {
        let functions = self.listed(&self.functions).chain(self.listed(&self.requests));
        functions.chain(self.listed(&self.facts))
    }

    pub(super) fn type_named(&self, name: &str) -> Option<SymbolId> {
        self.types.get(name).copied()
    }

    pub(super) fn entity_named(&self, name: &str) -> Option<SymbolId> {
        self.entities.get(name).copied()
    }

    /// Returns the type and its supertypes, itself first.
    fn with_supertypes(&self, ty: SymbolId) -> impl Iterator<Item = SymbolId> + '_ {
        std::iter::successors(Some(ty), |t| self.get(*t).owner).take(MAX_SUPERTYPES)
    }

    /// Returns the attribute of that name that entities of type `ty` have, own or inherited.
    pub(super) fn attribute_of(&self, ty: SymbolId, name: &str) -> Option<SymbolId> {
        let key = |t| (t, name.to_owned());
        self.with_supertypes(ty)
            .find_map(|t| self.attributes.get(&key(t)).copied())
    }

    /// Returns the attribute of that name if only one type has it.
    pub(super) fn only_attribute(&self, name: &str) -> Option<SymbolId> {
        match self.namesakes.get(name).map(Vec::as_slice) {
            Some([only]) => Some(*only),
            _ => None,
        }
    }

    /// Returns the attributes that entities of type `ty` have; of every type if it is not known.
    pub(super) fn attributes_of(&self, ty: Option<SymbolId>) -> Vec<&Symbol> {
        let owners: Option<Vec<SymbolId>> = ty.map(|ty| self.with_supertypes(ty).collect());
        let attributes = self.attributes.iter();
        let has = |owner: &SymbolId| owners.as_ref().is_none_or(|o| o.contains(owner));
        let found = attributes.filter(|((owner, _), _)| has(owner));
        found.map(|(_, id)| self.get(*id)).collect()
    }

    /// Returns what a type's name stands for.
    pub(super) fn value_of(&self, ty: &str, is_set: bool) -> Value {
        match ty {
            "number" | "int" | "float" => Value::Number,
            "bool" => Value::Bool,
            "string" => Value::String,
            "duration" => Value::Duration,
            _ => match (self.type_named(ty), is_set) {
                (Some(ty), false) => Value::Entity(ty),
                (ty, true) => Value::Set(ty),
                (None, false) => Value::Unknown,
            },
        }
    }

    /// Returns a value's type as a parameter is declared, `set Object`.
    pub(super) fn words(&self, value: Value) -> String {
        match value {
            Value::Number => "number".into(),
            Value::Bool => "bool".into(),
            Value::String => "string".into(),
            Value::Duration => "duration".into(),
            Value::Entity(ty) => self.get(ty).name.clone(),
            Value::Set(Some(ty)) => format!("set {}", self.get(ty).name),
            Value::Set(None) => "set".into(),
            Value::Unknown => "?".into(),
        }
    }
}
