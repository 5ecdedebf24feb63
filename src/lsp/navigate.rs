//! From a name to its declaration, to its uses, and to all of them marked in the text.

use lsp_types::{DocumentHighlight, DocumentHighlightKind, Location, Position, Uri};

use super::analysis::Analysis;
use super::document::Document;
use super::index::{Occurrence, PRELUDE};
use super::place::uri_of;
use super::position::Lines;
use crate::source::Span;

fn found_at(document: &Document, analysis: &Analysis, position: Position) -> Option<Occurrence> {
    let at = document.lines.offset(&document.text, position);
    analysis.index.at(analysis.file, at)
}

/// Returns the place of a span in the document or in a file that it imports; none in the prelude, which is no file.
pub(super) fn location(uri: &Uri, document: &Document, analysis: &Analysis, span: Span) -> Option<Location> {
    if span.file == analysis.file {
        return Some(Location::new(uri.clone(), document.lines.range(&document.text, span)));
    }
    if span.file == PRELUDE {
        return None;
    }
    let source = analysis.sources.get(span.file);
    let range = Lines::of(&source.text).range(&source.text, span);
    Some(Location::new(uri_of(&source.path)?, range))
}

/// Returns where the name at a position is declared. What is built in or declared by a world file has no place.
pub(super) fn definition(uri: &Uri, document: &Document, analysis: &Analysis, position: Position) -> Option<Location> {
    let found = found_at(document, analysis, position)?;
    let declared = analysis.index.get(found.symbol).declared?;
    location(uri, document, analysis, declared.name)
}

/// Returns every place of the name at a position, in the document and in what it imports; its declaration only if asked for.
pub(super) fn references(
    uri: &Uri,
    document: &Document,
    analysis: &Analysis,
    position: Position,
    with_declaration: bool,
) -> Option<Vec<Location>> {
    let found = found_at(document, analysis, position)?;
    let places = analysis.index.places(found.symbol);
    let places = places.filter(|o| with_declaration || !o.is_declaration);
    let place = |o: &Occurrence| location(uri, document, analysis, o.span);
    Some(places.filter_map(place).collect())
}

/// Returns every place of the name at a position, to be marked in the document.
pub(super) fn highlights(
    document: &Document,
    analysis: &Analysis,
    position: Position,
) -> Option<Vec<DocumentHighlight>> {
    let found = found_at(document, analysis, position)?;
    let highlight = |o: &Occurrence| DocumentHighlight {
        range: document.lines.range(&document.text, o.span),
        kind: Some(if o.is_write || o.is_declaration {
            DocumentHighlightKind::WRITE
        } else {
            DocumentHighlightKind::READ
        }),
    };
    let places = analysis.index.places(found.symbol);
    let here = places.filter(|o| o.span.file == analysis.file);
    Some(here.map(highlight).collect())
}
