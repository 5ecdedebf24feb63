//! What a name or a word of the language means, where the pointer rests on it.

use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind, Position};

use super::analysis::Analysis;
use super::document::Document;
use super::index::{Kind, Symbol, Value};
use super::keywords::keyword;
use crate::source::Span;
use crate::syntax::layout::layout;

/// Returns what stands at a position.
pub(super) fn hover(document: &Document, analysis: &Analysis, position: Position) -> Option<Hover> {
    let at = document.lines.offset(&document.text, position);
    let (span, text) = match analysis.index.at(analysis.file, at) {
        Some(found) => (found.span, described(analysis, analysis.index.get(found.symbol))),
        None => word_at(analysis, &document.text, at)?,
    };
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent {
            kind: MarkupKind::Markdown,
            value: text,
        }),
        range: Some(document.lines.range(&document.text, span)),
    })
}

/// Returns the keyword at a byte and its meaning.
fn word_at(analysis: &Analysis, text: &str, at: usize) -> Option<(Span, String)> {
    let layout = layout(text);
    let after = layout.tokens.partition_point(|t| t.0 <= at);
    let (start, end) = *layout.tokens.get(after.checked_sub(1)?)?;
    let found = keyword(text.get(start..end)?).filter(|_| at <= end)?;
    let span = Span::new(analysis.file, start, end);
    Some((span, format!("```hatp\n{}\n```\n\n{}", found.form, found.meaning)))
}

/// Returns a symbol's declaration, what it belongs to, and its comment, as Markdown.
pub(super) fn described(analysis: &Analysis, symbol: &Symbol) -> String {
    let index = &analysis.index;
    let mut out = format!("```hatp\n{}\n```", symbol.head);
    let owner = symbol.owner.map(|o| index.get(o));
    let mut line = match (symbol.kind, owner) {
        (Kind::Attribute, Some(owner)) => format!("attribute of `{}`", owner.name),
        (Kind::Parameter, Some(owner)) => format!("parameter of {} `{}`", owner.kind.word(), owner.name),
        (Kind::Entity, _) if symbol.declared.is_none() => {
            "not declared in this file; a world file may declare it".to_owned()
        }
        (Kind::Variable, _) if symbol.value == Value::Unknown => "variable of an unknown type".to_owned(),
        _ => symbol.kind.word().to_owned(),
    };
    if symbol.is_builtin() {
        line.push_str(", built in");
    }
    out.push_str("\n\n");
    out.push_str(&line);
    if let Some(doc) = doc(analysis, symbol) {
        out.push_str("\n\n---\n\n");
        out.push_str(&doc);
    }
    out
}

/// Returns the comment of a symbol's declaration. Parameters and labels stand within a line and have none of their own.
pub(super) fn doc(analysis: &Analysis, symbol: &Symbol) -> Option<String> {
    if matches!(symbol.kind, Kind::Parameter | Kind::Label) {
        return None;
    }
    if symbol.name == "Agent" && symbol.declared.is_none() {
        return Some("Robots and humans. Always there, never declared.".into());
    }
    analysis.comment(symbol.declared?.whole)
}
