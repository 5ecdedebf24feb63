//! What may be written at the cursor.
//!
//! The candidates are those of the place: attributes of the type before a `.`, types where a type stands, tasks among subtasks, clauses in an
//! action. The editor itself leaves out what does not begin with the word so far.

mod context;

use lsp_types::{
    CompletionItem, CompletionItemKind, Documentation, InsertTextFormat, MarkupContent, MarkupKind, Position,
};

use super::analysis::Analysis;
use super::document::Document;
use super::hover::doc;
use super::index::{Kind, Symbol, Value};
use super::keywords::meaning;
use context::{Block, Context, context, path_before, path_value};

/// Candidates that are sent. HEURISTIC: a domain has hundreds of names; a made-up one must not fill the line to the editor.
const MAX_ITEMS: usize = 2_000;

/// Returns the candidates, the nearest kind first.
pub(super) fn completion(
    document: &Document,
    analysis: &Analysis,
    position: Position,
    snippets: bool,
) -> Vec<CompletionItem> {
    if document.is_too_large() {
        return Vec::new();
    }
    let at = document.lines.offset(&document.text, position);
    let Some(context) = context(&document.text, at, &analysis.index) else {
        return Vec::new();
    };
    let mut offer = Offer {
        analysis,
        snippets,
        items: Vec::new(),
    };
    offer.fill(&context);
    let mut items = offer.items;
    items.truncate(MAX_ITEMS);
    for (i, item) in items.iter_mut().enumerate() {
        item.sort_text = Some(format!("{i:04}"));
    }
    items
}

const BASES: [&str; 3] = ["number", "bool", "string"];
const CLAUSES: [&str; 7] = [
    "preconditions",
    "projects",
    "constraints",
    "alternatives",
    "effects",
    "cost",
    "duration",
];
const TASK_ITEMS: [&str; 6] = ["action", "method", "function", "fact", "settings", "social"];
const RULES: [&str; 4] = ["undesirable", "effort", "wasted", "intricate"];

struct Offer<'a> {
    analysis: &'a Analysis,
    snippets: bool,
    items: Vec<CompletionItem>,
}

impl<'a> Offer<'a> {
    fn fill(&mut self, context: &Context<'_>) {
        let before = context.before.as_slice();
        if before.last() == Some(&".") {
            self.attributes(context);
            return;
        }
        // A number begins no name, except that of a label.
        if context.prefix.starts_with(|c: char| c.is_ascii_digit()) && context.block != Block::Subtasks {
            return;
        }
        match context.block {
            Block::File | Block::Htn => self.item(context),
            Block::Database => self.database(context),
            Block::Attributes => self.attribute(before),
            Block::Params => match before {
                [] | [.., ","] => {
                    self.words(&["set"]);
                    self.types(true);
                }
                [.., "set"] => self.types(false),
                _ => {}
            },
            Block::Action if before.is_empty() => self.words(&CLAUSES),
            Block::Method if before.is_empty() => self.words(&["goal"]),
            Block::Decomposition if before.is_empty() => self.words(&["preconditions", "subtasks"]),
            Block::Subtasks => self.subtask(context),
            Block::Tests => {
                self.values(context);
                if before.is_empty() {
                    self.words(&["FORALL", "EXIST", "OR", "NOT"]);
                }
            }
            Block::Effects => {
                self.values(context);
                if before.is_empty() {
                    self.words(&["FORALL", "IF", "ELSE"]);
                }
            }
            Block::Projects if before.is_empty() => self.symbols(self.analysis.index.geometrics()),
            Block::Select | Block::Quantified { .. } => match before {
                [] => self.types(false),
                [_] => {}
                _ => self.values(context),
            },
            Block::Value => self.values(context),
            Block::Settings => match before {
                [] => {
                    self.words(&["interleave", "cost"]);
                }
                ["interleave", "="] => self.words(&["true", "false"]),
                _ => {}
            },
            Block::Social => match before {
                [] => self.words(&RULES),
                ["undesirable"] => self.words(&["state", "sequence"]),
                ["effort"] => self.words(&["balance"]),
                ["wasted"] => self.words(&["time"]),
                ["intricate"] => self.words(&["links"]),
                [.., "of"] => self.words(&["cost", "duration"]),
                [.., "among" | ","] => {
                    self.symbols(self.analysis.index.entities());
                    self.types(false);
                }
                [.., "weight"] => {}
                ["effort", ..] => self.words(&["of", "among", "weight"]),
                _ => self.words(&["among", "weight"]),
            },
            Block::Sequence if before.is_empty() => self.symbols(self.analysis.index.tasks()),
            Block::Sequence => self.words(&["immediate"]),
            Block::Action | Block::Method | Block::Decomposition | Block::Projects | Block::Opaque => {}
        }
    }

    fn item(&mut self, context: &Context<'_>) {
        match context.before.as_slice() {
            [] => {
                if context.block == Block::File {
                    self.words(&["factdatabase", "HTN", "import"]);
                }
                self.words(&TASK_ITEMS);
            }
            ["function"] => {
                self.words(&BASES);
                self.words(&["duration"]);
            }
            _ => {}
        }
    }

    fn database(&mut self, context: &Context<'_>) {
        match context.before.as_slice() {
            [] => {
                self.words(&["define"]);
                self.symbols(self.analysis.index.entities());
            }
            ["define"] => self.words(&["entityType", "entityAttributes"]),
            ["define", "entityAttributes"] | ["define", "entityType", _, ":"] | [_, "=", "new"] => self.types(false),
            [_, "="] => self.words(&["new"]),
            [.., "=" | "<<=" | "=>>" | "[" | ","] => self.values(context),
            _ => {}
        }
    }

    fn attribute(&mut self, before: &[&str]) {
        match before {
            [] => self.words(&["static", "dynamic"]),
            ["static" | "dynamic"] => self.words(&["atom", "set"]),
            [_, "atom"] => self.types(true),
            [_, "set"] => self.types(false),
            [.., "="] => self.words(&["fact"]),
            [.., "fact"] => {
                let facts: Vec<&Symbol> = self.analysis.index.facts().collect();
                for fact in facts {
                    let mut item = self.symbol(fact);
                    item.insert_text = None;
                    item.insert_text_format = None;
                    self.items.push(item);
                }
            }
            _ => {}
        }
    }

    fn subtask(&mut self, context: &Context<'_>) {
        match context.before.as_slice() {
            [] => {
                self.symbols(self.analysis.index.tasks());
                self.words(&["let"]);
            }
            [_, ":"] => self.symbols(self.analysis.index.tasks()),
            [_, "="] => self.words(&["SELECT", "SELECTORDERED", "SELECTONCE"]),
            [.., ">" | "after"] | [.., ">" | "after", _, ","] => {
                for label in &context.labels {
                    let kind = CompletionItemKind::REFERENCE;
                    self.items.push(plain(label, kind, "label"));
                }
            }
            [.., ")"] => self.words(&["after"]),
            ["let", _, "=", ..] => self.values(context),
            _ => {}
        }
    }

    /// Offers the attributes of what stands before the `.`; those of all types if that is not known.
    fn attributes(&mut self, context: &Context<'_>) {
        let before = context.before.as_slice();
        let path = before.get(..before.len().saturating_sub(1)).unwrap_or(&[]);
        let path = path_before(path);
        let path = path.as_slice();
        let index = &self.analysis.index;
        if path
            .first()
            .is_none_or(|root| root.starts_with(|c: char| c.is_ascii_digit()))
        {
            return;
        }
        let found = match path_value(path, &context.variables, index) {
            Some(Value::Entity(ty)) => index.attributes_of(Some(ty)),
            Some(Value::Unknown) | None => index.attributes_of(None),
            // A number or a set has none.
            Some(_) => Vec::new(),
        };
        self.symbols(found.into_iter());
    }

    fn values(&mut self, context: &Context<'_>) {
        for (name, value) in context.variables.iter().rev() {
            let words = self.analysis.index.words(*value);
            self.items.push(plain(name, CompletionItemKind::VARIABLE, &words));
        }
        self.symbols(self.analysis.index.entities());
        self.symbols(self.analysis.index.callables());
        self.words(&["NULL", "true", "false"]);
    }

    fn types(&mut self, with_bases: bool) {
        self.symbols(self.analysis.index.types());
        if with_bases {
            self.words(&BASES);
        }
    }

    fn symbols(&mut self, symbols: impl Iterator<Item = &'a Symbol>) {
        for symbol in symbols.take(MAX_ITEMS) {
            let item = self.symbol(symbol);
            self.items.push(item);
        }
    }

    fn symbol(&self, symbol: &Symbol) -> CompletionItem {
        let kind = match symbol.kind {
            Kind::Type => CompletionItemKind::CLASS,
            Kind::Attribute => CompletionItemKind::FIELD,
            Kind::Entity => CompletionItemKind::CONSTANT,
            Kind::Action | Kind::Method | Kind::Function | Kind::Geometric | Kind::Fact | Kind::Request => {
                CompletionItemKind::FUNCTION
            }
            Kind::Parameter | Kind::Variable => CompletionItemKind::VARIABLE,
            Kind::Label => CompletionItemKind::REFERENCE,
        };
        let mut item = plain(&symbol.name, kind, &symbol.head);
        item.documentation = doc(self.analysis, symbol).map(markdown);
        if self.snippets && kind == CompletionItemKind::FUNCTION {
            let holes = symbol.params.iter().enumerate();
            let holes: Vec<String> = holes.map(|(i, p)| format!("${{{}:{p}}}", i + 1)).collect();
            item.insert_text = Some(format!("{}({})", symbol.name, holes.join(", ")));
            item.insert_text_format = Some(InsertTextFormat::SNIPPET);
        }
        item
    }

    fn words(&mut self, words: &[&str]) {
        for word in words {
            let documentation = meaning(word).map(|m| markdown(m.to_owned()));
            self.items.push(CompletionItem {
                label: (*word).to_owned(),
                kind: Some(CompletionItemKind::KEYWORD),
                documentation,
                ..CompletionItem::default()
            });
        }
    }
}

fn plain(label: &str, kind: CompletionItemKind, detail: &str) -> CompletionItem {
    CompletionItem {
        label: label.to_owned(),
        kind: Some(kind),
        detail: Some(detail.to_owned()),
        ..CompletionItem::default()
    }
}

fn markdown(value: String) -> Documentation {
    Documentation::MarkupContent(MarkupContent {
        kind: MarkupKind::Markdown,
        value,
    })
}
