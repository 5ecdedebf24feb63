//! Problems of the user's text: as data here, as words and colours in [`render`], for programs in [`json`].
//!
//! Passes collect problems and go on; they are sorted by place at the end. A *problem* is never a search failure
//! (that is `plan::Refusal`) and never a bug of ours.

pub mod json;
pub mod levels;
pub mod pages;
pub mod render;
pub mod suggest;

use crate::source::Span;

/// How bad a problem is: an error ends with exit code 1, a warning does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    Error,
    Warning,
}

/// A place and a few words about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    pub span: Span,
    pub text: String,
}

/// One thing wrong with the input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    pub severity: Severity,
    /// Stable name, `hatp::unknown-attribute`, `world::unknown-key`, `urdf::missing-joint` ...
    pub code: &'static str,
    /// Headline that stands alone: lower case, no final period, user text in backticks.
    pub message: String,
    /// Where; `None` when there is no text to point at (a file that can't be read).
    pub primary: Option<Label>,
    /// Other places, in any file.
    pub notes: Vec<Label>,
    /// The remedy.
    pub help: Option<String>,
}

impl Problem {
    /// Returns an error at `span`; `label` may be empty.
    pub fn error(code: &'static str, message: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Problem {
            severity: Severity::Error,
            code,
            message: message.into(),
            primary: Some(Label {
                span,
                text: label.into(),
            }),
            notes: Vec::new(),
            help: None,
        }
    }

    /// Returns a warning at `span`.
    pub fn warning(code: &'static str, message: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Problem {
            severity: Severity::Warning,
            ..Problem::error(code, message, span, label)
        }
    }

    /// Returns an error about something without text (a missing file, a flag).
    pub fn unplaced(code: &'static str, message: impl Into<String>) -> Self {
        Problem {
            severity: Severity::Error,
            code,
            message: message.into(),
            primary: None,
            notes: Vec::new(),
            help: None,
        }
    }

    /// Adds the remedy.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the remedy if there is one.
    pub fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }

    /// Adds another place.
    pub fn note(mut self, span: Span, text: impl Into<String>) -> Self {
        self.notes.push(Label {
            span,
            text: text.into(),
        });
        self
    }
}

/// What a pass found wrong, in any order until [`Problems::sorted`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    /// Adds one.
    pub fn push(&mut self, problem: Problem) {
        self.0.push(problem);
    }

    /// Adds all of `other`.
    pub fn extend(&mut self, other: Problems) {
        self.0.extend(other.0);
    }

    /// Says whether any is an error (warnings do not count).
    pub fn has_errors(&self) -> bool {
        self.0.iter().any(|p| p.severity == Severity::Error)
    }

    /// Returns the places of the problems with that code.
    fn of_code(&self, code: &'static str) -> impl Iterator<Item = Span> + '_ {
        let of_code = self.0.iter().filter(move |p| p.code == code);
        of_code.filter_map(|p| p.primary.as_ref()).map(|l| l.span)
    }

    /// Returns them sorted by file and place, without exact repeats and without what follows from a misspelling.
    pub fn sorted(mut self) -> Self {
        self.0.sort_by(|a, b| {
            let key = |p: &Problem| p.primary.as_ref().map(|l| l.span);
            key(a)
                .cmp(&key(b))
                .then(a.code.cmp(b.code))
                .then(a.message.cmp(&b.message))
        });
        self.0.dedup();
        // What is misspelt has a type of its own, and that it does not fit follows.
        let spelling: Vec<Span> = self.of_code("hatp::null-spelling").collect();
        let follows = |p: &Problem| {
            let place = p.primary.as_ref().map(|l| l.span);
            p.code == "hatp::wrong-type" && place.is_some_and(|span| spelling.contains(&span))
        };
        self.0.retain(|p| !follows(p));
        self
    }
}
