//! The comment that stands with a declaration, for hover.
//!
//! The reference takes doc comments alone ([`doc_comment`]). An editor shows whatever the author wrote there: older files have
//! no other comments.

use crate::source::{Span, doc_comment};
use crate::syntax::layout::layout;

/// Returns the doc comment of `declaration`; else the text of the comment lines right above it; else of the comment behind it on its last line.
///
/// A line of dashes is a heading and belongs to nothing; so does a comment with an empty line below it.
pub(super) fn comment_of(text: &str, declaration: Span) -> Option<String> {
    let start = declaration.start as usize;
    if let Some(doc) = doc_comment(text, start) {
        return Some(doc);
    }
    let line_start = text.get(..start)?.rfind('\n').map_or(0, |i| i + 1);
    // Something else on the same line before it: then what stands above belongs to that.
    let alone = text.get(line_start..start)?.trim().is_empty();
    let above = if alone { above(text, line_start) } else { None };
    above.or_else(|| behind(text, declaration.end as usize))
}

fn above(text: &str, line_start: usize) -> Option<String> {
    let before = text.get(..line_start)?;
    if let Some(block) = before.trim_end().strip_suffix("*/") {
        let gap = before.get(block.len() + 2..)?;
        let body = block.get(block.rfind("/*")? + 2..)?;
        let lines = body.lines().map(|l| l.trim().trim_start_matches('*').trim());
        let joined = lines.filter(|l| !l.is_empty()).collect::<Vec<_>>().join("\n");
        return (gap.matches('\n').count() == 1 && !joined.is_empty()).then_some(joined);
    }
    let comment = |line: &str| -> Option<String> {
        let body = line.trim().strip_prefix("//")?.trim_start_matches('/').trim();
        (!body.starts_with("--")).then(|| body.to_owned())
    };
    let mut lines: Vec<String> = before.lines().rev().map_while(comment).collect();
    lines.reverse();
    let joined = lines.join("\n");
    (!joined.trim().is_empty()).then_some(joined)
}

fn behind(text: &str, end: usize) -> Option<String> {
    let rest = text.get(end..)?.lines().next()?;
    let at = rest.find("//")?;
    // A word between the two: then the comment belongs to that.
    let nothing_between = layout(rest.get(..at)?).tokens.is_empty();
    let body = rest.get(at..)?.trim_start_matches('/').trim();
    (nothing_between && !body.is_empty()).then(|| body.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::FileId;

    fn doc(text: &str, declaration: &str) -> Option<String> {
        let start = text.find(declaration).expect("it is there");
        comment_of(text, Span::new(FileId(0), start, start + declaration.len()))
    }

    #[test]
    fn comments_above_and_behind() {
        let text = "// ---- heading ----\n\n/// One.\n/// `Two`.\nfact a();\n// lost\n\nfact b(); // é\n/* over\n * two lines */\n  fact c(); fact d(); // last";
        assert_eq!(doc(text, "fact a();").as_deref(), Some("One.\n`Two`."));
        assert_eq!(doc(text, "fact b();").as_deref(), Some("é"));
        assert_eq!(doc(text, "fact c();").as_deref(), Some("over\ntwo lines"));
        assert_eq!(doc(text, "fact d();").as_deref(), Some("last"));
        assert_eq!(doc("// ---- x\nfact a();", "fact a();"), None);
    }
}
