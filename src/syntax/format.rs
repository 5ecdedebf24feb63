//! One layout for every file: the same words, marks and comments, with other white space between them.
//!
//! Works on brackets and statements, not on the AST, so what a file says cannot change: no word is replaced, no optional
//! `;` comes or goes (`docs/decisions/008-the-formatter-changes-white-space-alone.md`). Where lines break depends on the words alone, where comments
//! and single blank lines stand is the user's.
//! Does not touch a file with errors. Lines are longer than [`WIDTH`] where nothing can be broken.

mod flat;
mod lines;
mod tokens;
mod tree;
mod write;

use super::parser::parse;
use crate::diag::Problems;
use crate::source::FileId;

/// A line has at most so many characters if a break can help it; a comment at its end does not count.
const WIDTH: usize = 110;

/// Spaces for each level.
const INDENT: usize = 2;

/// Returns `text` in the one layout, or its errors.
///
/// Formatting twice changes nothing more, and the result reads as the same [`ast::File`](super::ast::File) but for places.
/// Lines end with `\n`; a byte order mark is dropped.
pub fn format(file: FileId, text: &str) -> Result<String, Problems> {
    let (_, problems) = parse(file, text);
    if problems.has_errors() {
        return Err(problems);
    }
    let block = tree::file(text);
    let mut writer = write::Writer::default();
    writer.entries(&block, 0);
    Ok(writer.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::layout::layout;
    use proptest::prelude::*;

    const FILE: FileId = FileId(0);
    const FILES: [&str; 6] = [
        include_str!("../../domains/three_objects.hatp"),
        include_str!("../../domains/prelude.hatp"),
        include_str!("../../tests/suite/parse/ok/whole_language.hatp"),
        include_str!("../../tests/suite/parse/ok/comments.hatp"),
        include_str!("../../tests/suite/parse/ok/long_lines.hatp"),
        include_str!("../../tests/suite/parse/ok/new_forms.hatp"),
    ];

    /// Words and marks, and apart from them comments; white space within a comment is not compared.
    fn content(text: &str) -> (Vec<String>, Vec<String>) {
        let layout = layout(text);
        let texts = |places: &[(usize, usize)]| places.iter().map(|p| text[p.0..p.1].to_owned()).collect();
        let tokens = texts(&layout.tokens);
        let comments: Vec<String> = texts(&layout.comments);
        let plain = |c: &String| c.split_whitespace().collect::<Vec<_>>().join(" ");
        (tokens, comments.iter().map(plain).collect())
    }

    fn assert_formats(text: &str) -> Result<(), TestCaseError> {
        let once = match format(FILE, text) {
            Ok(once) => once,
            Err(problems) => return Err(TestCaseError::fail(format!("{problems:?}\n{text}"))),
        };
        prop_assert_eq!(content(text), content(&once), "{}\n{}", text, once);
        prop_assert_eq!(format(FILE, &once).ok(), Some(once), "from\n{}", text);
        Ok(())
    }

    /// What may stand between two tokens.
    const GAPS: [&str; 10] = [
        " ",
        " ",
        "\n",
        "\n\n\n",
        " /* c */ ",
        "\n/* c */",
        " /* c */\r\n",
        " // c \n",
        "\n\n  // c\n",
        "\n    /* c\n      d */ ",
    ];

    /// A file with any white space and any comments between its tokens.
    fn rewritten(n_comments: u32) -> impl Strategy<Value = String> {
        let gap = prop_oneof![60 => 0..2_usize, 20 => 2..4_usize, n_comments => 4..GAPS.len()];
        (0..FILES.len(), prop::collection::vec(gap, 1000)).prop_map(|(file, gaps)| {
            let tokens = tokens::tokens(FILES[file]);
            let words = tokens.iter().filter(|t| !t.is_comment());
            let mut text = String::new();
            for (word, gap) in words.zip(gaps.iter().cycle()) {
                text.push_str(GAPS[*gap]);
                text.push_str(word.text);
            }
            text
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn white_space_alone_changes(text in rewritten(5)) {
            assert_formats(&text)?;
        }

        #[test]
        fn comments_anywhere_are_kept(text in rewritten(200)) {
            assert_formats(&text)?;
        }

        #[test]
        fn the_layout_does_not_depend_on_the_old_one(text in rewritten(0)) {
            // Blank lines are the user's; all else comes from the words.
            let without = |t: &str| t.lines().filter(|l| !l.is_empty()).collect::<Vec<_>>().join("\n");
            let on_one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
            let [a, b] = [&text, &on_one_line].map(|t| format(FILE, t).expect("no errors"));
            prop_assert_eq!(without(&a), without(&b));
        }
    }

    #[test]
    fn lines_are_short_where_they_can_break() {
        for text in FILES {
            let text = format(FILE, text).expect("no errors");
            for line in text.lines() {
                let code = line.split("//").next().unwrap_or_default().trim_end();
                assert!(code.chars().count() <= WIDTH, "{code}");
            }
        }
    }
}
