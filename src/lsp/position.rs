//! Byte offsets of a text, and the protocol's positions: a line and UTF-16 units within it.

use lsp_types::{Position, Range};

use crate::source::Span;

/// Where the lines of a text begin; a line ends with `\n`, `\r\n` or `\r`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        let bytes = text.as_bytes();
        let ends_line = |i: usize| match bytes.get(i) {
            Some(b'\n') => true,
            Some(b'\r') => bytes.get(i + 1) != Some(&b'\n'),
            _ => false,
        };
        let after = (0..bytes.len()).filter(|i| ends_line(*i)).map(|i| i + 1);
        Lines {
            starts: std::iter::once(0).chain(after).collect(),
        }
    }

    /// Returns start and end of a line of `text`, its mark of the end left out [bytes].
    fn line(&self, text: &str, line: usize) -> Option<(usize, usize)> {
        let start = *self.starts.get(line)?;
        let end = self.starts.get(line + 1).copied().unwrap_or(text.len());
        let content = text.get(start..end)?.trim_end_matches(['\n', '\r']);
        Some((start, start + content.len()))
    }

    /// Returns the position of a byte; one inside of a character counts as its beginning.
    pub(super) fn position(&self, text: &str, at: usize) -> Position {
        let mut at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let line = self.starts.partition_point(|s| *s <= at).saturating_sub(1);
        let start = self.starts.get(line).copied().unwrap_or(0);
        let units: usize = text.get(start..at).unwrap_or("").chars().map(char::len_utf16).sum();
        let cap = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Position::new(cap(line), cap(units))
    }

    /// Returns the byte of a position; behind the end of a line or of the text it is that end.
    pub(super) fn offset(&self, text: &str, position: Position) -> usize {
        let Some((start, end)) = self.line(text, position.line as usize) else {
            return text.len();
        };
        let mut units = 0;
        for (i, c) in text.get(start..end).unwrap_or("").char_indices() {
            units += c.len_utf16();
            if units > position.character as usize {
                return start + i;
            }
        }
        end
    }

    pub(super) fn range(&self, text: &str, span: Span) -> Range {
        Range::new(
            self.position(text, span.start as usize),
            self.position(text, span.end as usize),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_character_outside_of_the_basic_plane_counts_twice() {
        let text = "// é𝄞x\r\nB";
        let lines = Lines::of(text);
        let x = text.find('x').expect("there is one");
        assert_eq!(lines.position(text, x), Position::new(0, 6));
        assert_eq!(lines.position(text, text.len() - 1), Position::new(1, 0));
        assert_eq!(lines.offset(text, Position::new(0, 6)), x);
        // Between the two units of the clef: its beginning.
        assert_eq!(
            lines.offset(text, Position::new(0, 5)),
            text.find('𝄞').expect("there is one")
        );
        // Behind the end of the line: before its mark.
        assert_eq!(lines.offset(text, Position::new(0, 99)), x + 1);
        assert_eq!(lines.offset(text, Position::new(7, 0)), text.len());
    }

    proptest! {
        #[test]
        fn every_byte_has_its_position(text in "([a-zé𝄞]|\r|\n|\r\n){0,40}") {
            let lines = Lines::of(&text);
            for (at, c) in text.char_indices() {
                // Between the two bytes of `\r\n` there is no position of its own.
                if !(c == '\n' && text[..at].ends_with('\r')) {
                    prop_assert_eq!(lines.offset(&text, lines.position(&text, at)), at);
                }
            }
        }
    }
}
