//! Quick fixes: where a message says "did you mean", the proposed name in place of the marked one.

use lsp_types::{CodeAction, CodeActionKind, Range, TextEdit, Uri, WorkspaceEdit};

use super::analysis::Analysis;
use super::diagnostics::proposed;
use super::document::Document;
use crate::diag::Problem;

/// Returns the fixes of all problems that touch `range`; `edit` wraps changes as the editor wants them.
pub(super) fn fixes(
    uri: &Uri,
    document: &Document,
    analysis: &Analysis,
    range: Range,
    edit: impl Fn(&Uri, &Document, Vec<TextEdit>) -> WorkspaceEdit,
) -> Vec<CodeAction> {
    // Of a syntax error the marked place may be beside the word that is meant.
    let is_name = |p: &&Problem| p.code.starts_with("hatp::unknown-");
    let problems = analysis.problems.0.iter().filter(is_name);
    let fix = |problem: &Problem| -> Option<CodeAction> {
        let name = proposed(problem)?;
        let span = problem.primary.as_ref().filter(|l| l.span.file == analysis.file)?.span;
        let place = document.lines.range(&document.text, span);
        if place.end < range.start || range.end < place.start {
            return None;
        }
        let change = TextEdit::new(place, name.to_owned());
        Some(CodeAction {
            title: format!("change to `{name}`"),
            kind: Some(CodeActionKind::QUICKFIX),
            edit: Some(edit(uri, document, vec![change])),
            is_preferred: Some(true),
            ..CodeAction::default()
        })
    };
    problems.filter_map(fix).collect()
}
