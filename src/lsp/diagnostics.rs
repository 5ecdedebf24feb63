//! Problems as the protocol's diagnostics.
//!
//! A document is checked with the files that it imports and without a world file; what is wrong in those files is told where they are open. A name that is no variable and no declared entity may be one of the world's, so
//! it is an *information*, told once for each name; if it is nearly a name that is known it is a *warning* wherever it stands.
//! `sgap check DOMAIN WORLD` knows more.

use std::collections::BTreeSet;

use lsp_types::{Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, DiagnosticTag, NumberOrString, Uri};

use super::analysis::Analysis;
use super::document::Document;
use super::navigate::location;
use crate::diag::{Label, Problem, Severity};

/// Diagnostics of one document; nobody reads more, and each is drawn in the text.
const MAX_DIAGNOSTICS: usize = 500;

/// The code of a name that a world may declare.
const UNKNOWN_NAME: &str = "hatp::unknown-name";

/// Returns the diagnostics of a document.
pub(super) fn diagnostics(uri: &Uri, document: &Document, analysis: &Analysis) -> Vec<Diagnostic> {
    let mut told: BTreeSet<&str> = BTreeSet::new();
    let is_here = |p: &&Problem| p.primary.as_ref().is_some_and(|l| l.span.file == analysis.file);
    let problems = analysis.problems.0.iter().filter(is_here).filter(|problem| {
        let may_be_declared = problem.code == UNKNOWN_NAME && !has_near_name(problem);
        !may_be_declared || told.insert(&problem.message)
    });
    problems
        .map(|p| diagnostic(uri, document, analysis, p))
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

fn diagnostic(uri: &Uri, document: &Document, analysis: &Analysis, problem: &Problem) -> Diagnostic {
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
    let note = |note: &Label| {
        Some(DiagnosticRelatedInformation {
            location: location(uri, document, analysis, note.span)?,
            message: note.text.clone(),
        })
    };
    let related: Vec<DiagnosticRelatedInformation> = problem.notes.iter().filter_map(note).collect();
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
