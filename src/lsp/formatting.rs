//! The one layout (`sgap fmt`), as a change of the lines that differ.

use lsp_types::{Range, TextEdit};

use super::analysis::Analysis;
use super::document::Document;
use crate::syntax;

/// Returns the change; none if the layout is right already, `None` if the text has syntax errors, which the diagnostics tell.
pub(super) fn formatting(document: &Document, analysis: &Analysis) -> Option<Vec<TextEdit>> {
    let old = document.text.as_str();
    let new = syntax::format(analysis.file, old).ok()?;
    if new == old {
        return Some(Vec::new());
    }
    // Lines that stay keep their marks and the cursor.
    let same = old.split_inclusive('\n').zip(new.split_inclusive('\n'));
    let begin: usize = same.take_while(|(a, b)| a == b).map(|(a, _)| a.len()).sum();
    let (old_rest, new_rest) = (old.get(begin..)?, new.get(begin..)?);
    let lines = |text: &str| text.split_inclusive('\n').map(str::len).rev().collect::<Vec<_>>();
    let mut tail = 0;
    for (a, b) in lines(old_rest).into_iter().zip(lines(new_rest)) {
        let (from_old, from_new) = (old_rest.len() - tail - a, new_rest.len() - tail - b);
        if old_rest.get(from_old..) != new_rest.get(from_new..) {
            break;
        }
        tail += a;
    }
    let position = |at| document.lines.position(old, at);
    let range = Range::new(position(begin), position(old.len() - tail));
    let text = new_rest.get(..new_rest.len() - tail)?.to_owned();
    Some(vec![TextEdit::new(range, text)])
}
