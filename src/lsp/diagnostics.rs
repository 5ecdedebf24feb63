//! Problems as the protocol's diagnostics.
//!
//! A document is checked alone, without a world file. A name that is no variable and no declared entity may be one of the world's, so
//! it is an *information*, told once for each name; if it is nearly a name that is known it is a *warning* wherever it stands.
//! `sgap check DOMAIN WORLD` knows more.

use std::collections::BTreeSet;

use lsp_types::{
    Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, DiagnosticTag, Location, NumberOrString, Uri,
};

use super::analysis::{Analysis, DOCUMENT};
use super::document::Document;
use crate::diag::{Problem, Severity};

/// Diagnostics of one document; nobody reads more, and each is drawn in the text.
const MAX_DIAGNOSTICS: usize = 500;

/// The code of a name that a world may declare.
const UNKNOWN_NAME: &str = "hatp::unknown-name";

/// Returns the diagnostics of a document.
pub(super) fn diagnostics(uri: &Uri, document: &Document, analysis: &Analysis) -> Vec<Diagnostic> {
    let mut told: BTreeSet<&str> = BTreeSet::new();
    let problems = analysis.problems.0.iter().filter(|problem| {
        let may_be_declared = problem.code == UNKNOWN_NAME && !has_near_name(problem);
        !may_be_declared || told.insert(&problem.message)
    });
    problems
        .map(|p| diagnostic(uri, document, p))
        .take(MAX_DIAGNOSTICS)
        .collect()
}

/// Says whether the help names something that is declared.
fn has_near_name(problem: &Problem) -> bool {
    proposed(problem).is_some()
}

/// Returns the name that the help of a problem proposes in place of the marked one.
pub(super) fn proposed(problem: &Problem) -> Option<&str> {
    let rest = problem.help.as_deref()?.strip_prefix("did you mean `")?;
    let (name, _) = rest.split_once('`')?;
    let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    is_name.then_some(name)
}

fn diagnostic(uri: &Uri, document: &Document, problem: &Problem) -> Diagnostic {
    let range = |span| document.lines.range(&document.text, span);
    let severity = match (problem.severity, problem.code == UNKNOWN_NAME) {
        (Severity::Warning, _) => DiagnosticSeverity::WARNING,
        (Severity::Error, false) => DiagnosticSeverity::ERROR,
        (Severity::Error, true) if has_near_name(problem) => DiagnosticSeverity::WARNING,
        (Severity::Error, true) => DiagnosticSeverity::INFORMATION,
    };
    let message = match &problem.help {
        Some(help) => format!("{}\nhelp: {help}", problem.message),
        None => problem.message.clone(),
    };
    let notes = problem.notes.iter().filter(|n| n.span.file == DOCUMENT);
    let related: Vec<DiagnosticRelatedInformation> = notes
        .map(|note| DiagnosticRelatedInformation {
            location: Location::new(uri.clone(), range(note.span)),
            message: note.text.clone(),
        })
        .collect();
    let unused = problem.code == "hatp::unused-variable";
    Diagnostic {
        range: problem.primary.as_ref().map(|l| range(l.span)).unwrap_or_default(),
        severity: Some(severity),
        code: Some(NumberOrString::String(problem.code.into())),
        source: Some("sgap".into()),
        message,
        related_information: (!related.is_empty()).then_some(related),
        tags: unused.then(|| vec![DiagnosticTag::UNNECESSARY]),
        ..Diagnostic::default()
    }
}
