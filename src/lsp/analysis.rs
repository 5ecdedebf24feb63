//! What is known of one open document: what it says, its names, what is wrong with it.

use super::comment::comment_of;
use super::index::{Index, PRELUDE};
use super::mend::{Reading, read};
use crate::check::{self, Given, PRELUDE_TEXT};
use crate::diag::{Problems, Severity};
use crate::source::{FileId, Span};
use crate::syntax::{self, ast};

/// Stands for the document in spans.
pub(super) const DOCUMENT: FileId = FileId(0);

/// All about a text; made anew after each change.
#[derive(Debug)]
pub(super) struct Analysis {
    pub ast: ast::File,
    pub index: Index,
    /// As [`check`] says, sorted by place.
    pub problems: Problems,
    /// Whether the text has syntax errors, so that parts of it are not in `ast`.
    pub is_broken: bool,
}

impl Analysis {
    pub(super) fn of(text: &str) -> Self {
        let reading = read(DOCUMENT, text);
        let (prelude, _) = syntax::parse(PRELUDE, PRELUDE_TEXT);
        let index = Index::of(&prelude, &reading.ast);
        let is_broken = reading.is_broken();
        let problems = problems(&reading);
        Analysis {
            ast: reading.ast,
            index,
            problems,
            is_broken,
        }
    }

    /// Returns the comment that belongs to a declaration of the document or of the prelude.
    pub(super) fn doc(&self, text: &str, declaration: Span) -> Option<String> {
        let text = if declaration.file == PRELUDE {
            PRELUDE_TEXT
        } else {
            text
        };
        comment_of(text, declaration)
    }
}

/// Returns what parser and checker say. Beside syntax errors only those errors of the checker count that do not come from what
/// could not be read: no unknown names, and no warnings.
fn problems(reading: &Reading) -> Problems {
    let mut problems = reading.problems.clone();
    let (_, mut found) = check::compile(std::slice::from_ref(&reading.ast), &Given::default());
    if reading.is_broken() {
        let is_unknown = |code: &str| code.split("::").any(|name| name.starts_with("unknown"));
        found.0.retain(|p| p.severity == Severity::Error && !is_unknown(p.code));
    }
    problems.extend(found);
    problems.sorted()
}
