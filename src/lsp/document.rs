//! One open document: its text as the editor has it, and what is known of it.

use std::rc::Rc;

use lsp_types::TextDocumentContentChangeEvent;

use super::analysis::Analysis;
use super::position::Lines;

/// A larger document is not looked into [bytes]; the command line reads it all the same.
pub(super) const LARGEST: usize = 8 << 20;

/// An open document.
#[derive(Debug)]
pub(super) struct Document {
    pub text: String,
    pub lines: Lines,
    /// The editor's number of this state.
    pub version: i32,
    analysis: Option<Rc<Analysis>>,
}

impl Document {
    pub(super) fn new(text: String, version: i32) -> Self {
        let lines = Lines::of(&text);
        Document {
            text,
            lines,
            version,
            analysis: None,
        }
    }

    /// Applies what was typed, in order; a change without a range is the whole text.
    pub(super) fn change(&mut self, changes: Vec<TextDocumentContentChangeEvent>, version: i32) {
        for change in changes {
            match change.range {
                Some(range) => {
                    let start = self.lines.offset(&self.text, range.start);
                    let end = self.lines.offset(&self.text, range.end).max(start);
                    self.text.replace_range(start..end, &change.text);
                }
                None => self.text = change.text,
            }
            self.lines = Lines::of(&self.text);
        }
        self.version = version;
        self.analysis = None;
    }

    pub(super) fn is_too_large(&self) -> bool {
        self.text.len() > LARGEST
    }

    /// Returns what is known of the text as it is now; of one that is too large, as if it were empty.
    pub(super) fn analysis(&mut self) -> Rc<Analysis> {
        let text = if self.is_too_large() { "" } else { self.text.as_str() };
        let analysis = self.analysis.get_or_insert_with(|| Rc::new(Analysis::of(text)));
        Rc::clone(analysis)
    }
}
