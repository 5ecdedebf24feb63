//! From a name to its declaration, to its uses, and to all of them marked in the text.

use lsp_types::{DocumentHighlight, DocumentHighlightKind, Location, Position, Uri};

use super::analysis::{Analysis, DOCUMENT};
use super::document::Document;
use super::index::Occurrence;

fn found_at(document: &Document, analysis: &Analysis, position: Position) -> Option<Occurrence> {
    let at = document.lines.offset(&document.text, position);
    analysis.index.at(at)
}

/// Returns where the name at a position is declared. What is built in or declared by a world file has no place.
pub(super) fn definition(uri: &Uri, document: &Document, analysis: &Analysis, position: Position) -> Option<Location> {
    let found = found_at(document, analysis, position)?;
    let declared = analysis.index.get(found.symbol).declared?;
    let is_here = declared.name.file == DOCUMENT;
    is_here.then(|| Location::new(uri.clone(), document.lines.range(&document.text, declared.name)))
}

/// Returns every place of the name at a position, its declaration only if asked for.
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
    let location = |o: &Occurrence| Location::new(uri.clone(), document.lines.range(&document.text, o.span));
    Some(places.map(location).collect())
}

/// Returns every place of the name at a position, to be marked.
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
    Some(analysis.index.places(found.symbol).map(highlight).collect())
}
