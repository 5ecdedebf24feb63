//! What a file declares, with the comments that stand before it: for people as Markdown, for programs as JSON.
//!
//! The built-ins are declared in the prelude like anything else, so their reference is read from there. Knows no types: a
//! file with errors is shown as far as it can be read.

use serde_json::json;

use crate::check::PRELUDE_TEXT;
use crate::source::{FileId, doc_comment};
use crate::syntax::{self, ast};

/// Begins the reference of the built-ins, `docs/builtins.md`.
pub const TITLE: &str = "# Built-ins

What every domain can use without declaring it. Written from the comments of `domains/prelude.hatp` by `sgap doc`; `sgap doc NAME`
shows one. `any` stands for an entity of any type. Lengths in metres, times in seconds, angles in radians.

";

/// What is declared, in the order in which it is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    Type,
    Attribute,
    Fact,
    Action,
    Method,
    Geometric,
    Request,
    Function,
}

impl What {
    /// Returns the word for one of them.
    fn word(self) -> &'static str {
        match self {
            What::Type => "type",
            What::Attribute => "attribute",
            What::Fact => "fact",
            What::Action => "action",
            What::Method => "method",
            What::Geometric => "geometric action",
            What::Request => "request",
            What::Function => "function",
        }
    }

    /// Returns the heading over all of them, and where they may stand.
    fn heading(self) -> &'static str {
        match self {
            What::Type => "Types",
            What::Attribute => "Attributes",
            What::Fact => "Facts",
            What::Action => "Actions",
            What::Method => "Methods",
            What::Geometric => "Geometric actions",
            What::Request => "Requests",
            What::Function => "Functions",
        }
    }
}

/// A declaration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    pub what: What,
    /// `Pick`; of an attribute `Object.isOn`.
    pub name: String,
    /// The declaration without its body: `action Pick(Agent A, Object O)`.
    pub signature: String,
    /// The `///` lines before it.
    pub doc: Option<String>,
}

/// Returns what the prelude declares.
pub fn builtins() -> Vec<Entry> {
    let (file, _) = syntax::parse(FileId(u32::MAX), PRELUDE_TEXT);
    entries(&file, PRELUDE_TEXT)
}

/// Returns what the file declares; `text` is what it was read from. Entities and initial values are left out.
pub fn entries(file: &ast::File, text: &str) -> Vec<Entry> {
    let mut out = Vec::new();
    let mut add = |what, name: String, signature, span: crate::source::Span| {
        out.push(Entry {
            what,
            name,
            signature,
            doc: doc_comment(text, span.start as usize),
        });
    };
    for item in &file.items {
        match item {
            ast::Item::EntityType(ty) => {
                let parent = ty
                    .parent
                    .as_ref()
                    .map_or_else(String::new, |p| format!(" : {}", p.text));
                let signature = format!("define entityType {}{parent}", ty.name.text);
                add(What::Type, ty.name.text.clone(), signature, ty.span);
            }
            ast::Item::Attributes(block) => {
                for attribute in &block.attributes {
                    let name = format!("{}.{}", block.owner.text, attribute.name.text);
                    add(What::Attribute, name, attribute_line(attribute), attribute.span);
                }
            }
            ast::Item::Action(a) => {
                let signature = format!("action {}", call(&a.name, &a.params));
                add(What::Action, a.name.text.clone(), signature, a.span);
            }
            ast::Item::Method(m) => {
                let signature = format!("method {}", call(&m.name, &m.params));
                add(What::Method, m.name.text.clone(), signature, m.span);
            }
            ast::Item::Function(f) => {
                let signature = format!("function {} {}", f.result.text, call(&f.name, &f.params));
                add(What::Function, f.name.text.clone(), signature, f.span);
            }
            ast::Item::Geometric(g) => {
                let signature = format!("geometric {}", call(&g.name, &g.params));
                add(What::Geometric, g.name.text.clone(), signature, g.span);
            }
            ast::Item::Fact(f) => {
                let signature = format!("fact {}", call(&f.name, &f.params));
                add(What::Fact, f.name.text.clone(), signature, f.span);
            }
            ast::Item::Request(r) => {
                let signature = format!("request {} {}", r.result.text, call(&r.name, &r.params));
                add(What::Request, r.name.text.clone(), signature, r.span);
            }
            ast::Item::Entity(_)
            | ast::Item::Initial(_)
            | ast::Item::Settings(_)
            | ast::Item::Social(_)
            | ast::Item::TimePart(_)
            | ast::Item::Import(_) => {}
        }
    }
    out.sort_by_key(|entry| entry.what);
    out
}

fn call(name: &ast::Name, params: &[ast::Param]) -> String {
    let param = |p: &ast::Param| {
        let set = if p.is_set { "set " } else { "" };
        format!("{set}{} {}", p.ty.text, p.name.text)
    };
    let params: Vec<String> = params.iter().map(param).collect();
    format!("{}({})", name.text, params.join(", "))
}

fn attribute_line(attribute: &ast::Attribute) -> String {
    let changes = if attribute.is_static { "static" } else { "dynamic" };
    let holds = if attribute.is_set { "set" } else { "atom" };
    let fact = attribute
        .fact
        .as_ref()
        .map_or_else(String::new, |f| format!(" = fact {}", f.text));
    format!(
        "{changes} {holds} {} {}{}{fact}",
        attribute.base.text,
        attribute.name.text,
        attribute.params_as_written()
            + if attribute.per_agent.is_some() {
                " per agent"
            } else {
                ""
            },
    )
}

/// Returns the entries of that name: in full, or of an attribute the part after the type.
pub fn called(name: &str, entries: &[Entry]) -> Vec<Entry> {
    let is_it = |entry: &&Entry| {
        let short = entry
            .name
            .rsplit_once('.')
            .map_or(entry.name.as_str(), |(_, short)| short);
        entry.name == name || short == name
    };
    entries.iter().filter(is_it).cloned().collect()
}

/// Returns the entries as Markdown: a heading for each kind, the declaration as code, and its comment.
pub fn markdown(entries: &[Entry]) -> String {
    let mut parts = Vec::new();
    let mut last = None;
    for entry in entries {
        if last != Some(entry.what) {
            last = Some(entry.what);
            parts.push(format!("## {}", entry.what.heading()));
        }
        parts.push(format!("### {}\n\n```text\n{}\n```", entry.name, entry.signature));
        parts.extend(entry.doc.clone());
    }
    let text = parts.join("\n\n");
    format!("{text}\n")
}

/// Returns the entries as an array of JSON objects: `kind`, `name`, `signature`, and `doc` where there is a comment.
pub fn json(entries: &[Entry]) -> String {
    let object = |entry: &Entry| {
        let mut object = json!({"kind": entry.what.word(), "name": entry.name, "signature": entry.signature});
        if let (Some(doc), Some(map)) = (&entry.doc, object.as_object_mut()) {
            map.insert("doc".into(), json!(doc));
        }
        object
    };
    let all: Vec<serde_json::Value> = entries.iter().map(object).collect();
    format!("{:#}\n", serde_json::Value::Array(all))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_declaration_comes_with_its_comment() {
        let text = "/// Moves.\naction Go(Agent A, set Cup Cs) { }\nfactdatabase {\n  define entityAttributes Cup {\n    \
                    /// Where it is.\n    dynamic atom Cup isOn = fact isOn;\n  }\n}\n";
        let (file, problems) = syntax::parse(FileId(0), text);
        assert!(problems.0.is_empty());
        let all = entries(&file, text);
        let lines: Vec<(&str, &str, Option<&str>)> = all
            .iter()
            .map(|e| (e.name.as_str(), e.signature.as_str(), e.doc.as_deref()))
            .collect();
        assert_eq!(
            lines,
            [
                ("Cup.isOn", "dynamic atom Cup isOn = fact isOn", Some("Where it is.")),
                ("Go", "action Go(Agent A, set Cup Cs)", Some("Moves.")),
            ]
        );
        assert_eq!(called("isOn", &all).len(), 1);
        assert_eq!(
            markdown(&called("Go", &all)),
            "## Actions\n\n### Go\n\n```text\naction Go(Agent A, set Cup Cs)\n```\n\nMoves.\n"
        );
    }

    #[test]
    fn every_builtin_has_a_comment() {
        for entry in builtins() {
            assert!(entry.doc.is_some(), "{} has no comment", entry.signature);
        }
    }
}
