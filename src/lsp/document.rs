//! One open document: its text as the editor has it, and what is known of it.

use std::cell::OnceCell;
use std::rc::Rc;

use lsp_types::TextDocumentContentChangeEvent;

use super::analysis::Analysis;
use super::position::Lines;

/// A larger document is not looked into [bytes]; the command line reads it all the same.
pub(super) const LARGEST: usize = 8 << 20;

/// An open document.
#[derive(Debug)]
pub(super) struct Document {
    /// Of its file; a document that was never saved has its address here, which no file has.
    pub path: String,
    pub text: String,
    pub lines: Lines,
    /// The editor's number of this state.
    pub version: i32,
    /// What is known of the text as it is now.
    pub analysis: OnceCell<Rc<Analysis>>,
}

impl Document {
    pub(super) fn new(path: String, text: String, version: i32) -> Self {
        let lines = Lines::of(&text);
        Document {
            path,
            text,
            lines,
            version,
            analysis: OnceCell::new(),
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
        self.analysis = OnceCell::new();
    }

    pub(super) fn is_too_large(&self) -> bool {
        self.text.len() > LARGEST
    }
}
