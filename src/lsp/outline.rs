//! The document's declarations as a tree, for the editor's outline.

use lsp_types::{DocumentSymbol, SymbolKind};

use super::analysis::Analysis;
use super::document::Document;
use crate::source::Span;
use crate::syntax::ast::{Attribute, Attributes, Item, Method, Name, Param, Social, Step};

/// Returns the tree, in the order of the file.
pub(super) fn outline(document: &Document, analysis: &Analysis) -> Vec<DocumentSymbol> {
    let outline = Outline { document };
    analysis
        .ast
        .items
        .iter()
        .filter_map(|item| outline.item(item))
        .collect()
}

struct Outline<'a> {
    document: &'a Document,
}

impl Outline<'_> {
    #[expect(deprecated, reason = "the field must be given, and stays empty")]
    fn symbol(
        &self,
        name: impl Into<String>,
        detail: impl Into<String>,
        kind: SymbolKind,
        whole: Span,
        place: Span,
        children: Vec<DocumentSymbol>,
    ) -> DocumentSymbol {
        let range = |span| self.document.lines.range(&self.document.text, span);
        DocumentSymbol {
            name: name.into(),
            detail: Some(detail.into()).filter(|d| !d.is_empty()),
            kind,
            tags: None,
            deprecated: None,
            range: range(whole),
            selection_range: range(place),
            children: (!children.is_empty()).then_some(children),
        }
    }

    fn item(&self, item: &Item) -> Option<DocumentSymbol> {
        let task = |word: &str, name: &Name, params: &[Param], whole| {
            let list: Vec<&str> = params.iter().map(|p| p.name.text.as_str()).collect();
            let detail = format!("{word}({})", list.join(", "));
            self.symbol(&name.text, detail, SymbolKind::FUNCTION, whole, name.span, Vec::new())
        };
        Some(match item {
            Item::EntityType(t) => {
                let detail = t.parent.as_ref().map_or_else(String::new, |p| format!(": {}", p.text));
                self.symbol(&t.name.text, detail, SymbolKind::CLASS, t.span, t.name.span, Vec::new())
            }
            Item::Attributes(block) => self.attributes(block),
            Item::Entity(e) => self.symbol(
                &e.name.text,
                &e.ty.text,
                SymbolKind::CONSTANT,
                e.span,
                e.name.span,
                Vec::new(),
            ),
            Item::Action(a) => task("action", &a.name, &a.params, a.span),
            Item::Method(method) => self.method(method),
            Item::Function(f) => task("function", &f.name, &f.params, f.span),
            Item::Geometric(g) => task("geometric", &g.name, &g.params, g.span),
            Item::Fact(f) => task("fact", &f.name, &f.params, f.span),
            Item::Request(r) => task("request", &r.name, &r.params, r.span),
            Item::Social(s) => self.symbol("social", "", SymbolKind::OBJECT, s.span, s.span, self.rules(s)),
            Item::Settings(s) => self.symbol("settings", "", SymbolKind::OBJECT, s.span, s.span, Vec::new()),
            Item::Import(i) => self.symbol(&i.path, "import", SymbolKind::FILE, i.span, i.path_span, Vec::new()),
            Item::Initial(_) | Item::TimePart(_) => return None,
        })
        .filter(|s| !s.name.is_empty())
    }

    fn rules(&self, block: &Social) -> Vec<DocumentSymbol> {
        let rules = block
            .rules
            .iter()
            .filter_map(|rule| rule.name.as_ref().map(|name| (rule, name)));
        rules
            .map(|(rule, name)| self.symbol(&name.text, "rule", SymbolKind::EVENT, rule.span, name.span, Vec::new()))
            .collect()
    }

    fn attributes(&self, block: &Attributes) -> DocumentSymbol {
        let child = |a: &Attribute| {
            let many = if a.is_set { "set " } else { "" };
            let detail = format!("{many}{}", a.base.text);
            self.symbol(&a.name.text, detail, SymbolKind::FIELD, a.span, a.name.span, Vec::new())
        };
        let children = block.attributes.iter().map(child).collect();
        let place = block.owner.span;
        self.symbol(
            &block.owner.text,
            "attributes",
            SymbolKind::STRUCT,
            block.span,
            place,
            children,
        )
    }

    fn method(&self, method: &Method) -> DocumentSymbol {
        let decompositions = method.decompositions.iter().enumerate().map(|(i, d)| {
            let subtasks = d.steps.iter().filter_map(|step| match step {
                Step::Subtask(s) => {
                    let label = s.label.as_ref().map_or("", |l| l.text.as_str());
                    let name = &s.call.name;
                    Some(self.symbol(&name.text, label, SymbolKind::EVENT, s.span, name.span, Vec::new()))
                }
                Step::Select(_) | Step::Let(_) => None,
            });
            let name = format!("decomposition {}", i + 1);
            self.symbol(name, "", SymbolKind::NAMESPACE, d.span, d.span, subtasks.collect())
        });
        let list: Vec<&str> = method.params.iter().map(|p| p.name.text.as_str()).collect();
        let detail = format!("method({})", list.join(", "));
        let place = method.name.span;
        self.symbol(
            &method.name.text,
            detail,
            SymbolKind::METHOD,
            method.span,
            place,
            decompositions.collect(),
        )
    }
}
