//! The part of a file that a report shows: whole lines, or of a line that no screen is wide enough for, a piece.
//!
//! `miette` copies and draws whole lines; one of ten megabytes would drown the message, and its column has no place in a
//! format's width. Lines end with `\n`, before which `\r` may stand.

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// Longest line that is shown whole [bytes].
const WIDEST: usize = 400;
/// What is shown of a longer line: before its mark, of the mark, and after it [bytes].
const BEFORE: usize = 40;
const MARK: usize = 40;
const AFTER: usize = 40;

/// Lines shown before and after those with a mark.
pub(super) const CONTEXT: usize = 1;

/// A file to be shown in part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Excerpt<'a> {
    pub path: &'a str,
    pub text: &'a str,
}

impl Excerpt<'_> {
    /// Says whether a line is too long to be shown whole around `start..end` [bytes].
    pub(super) fn is_wide(&self, start: usize, end: usize) -> bool {
        let (from, to) = self.lines(start, end, CONTEXT);
        let bytes = self.text.as_bytes().get(from..to).unwrap_or_default();
        bytes.split(|b| *b == b'\n').any(|line| line.len() > WIDEST)
    }

    /// Returns where to end the mark `start..end` in a line that is shown in part.
    pub(super) fn mark_end(&self, start: usize, end: usize) -> usize {
        let end = end.min(start.saturating_add(MARK)).min(self.line_end(start));
        self.boundary(end).max(start)
    }

    /// Returns the bytes of the lines of `start..end` and of `n` lines on both sides, the last line's end included.
    fn lines(&self, start: usize, end: usize, n: usize) -> (usize, usize) {
        let text = self.text.as_bytes();
        let mut from = self.line_start(start);
        let mut to = self.line_end(end.saturating_sub(1).max(start));
        for _ in 0..n {
            from = self.line_start(from.saturating_sub(1));
            to = self.line_end((to + 1).min(text.len()));
        }
        (from, (to + 1).min(text.len()))
    }

    fn line_start(&self, at: usize) -> usize {
        let before = self.text.as_bytes().get(..at).unwrap_or_default();
        before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1)
    }

    /// Returns where the newline of the line at `at` is, or the end of the text.
    fn line_end(&self, at: usize) -> usize {
        let after = self.text.as_bytes().get(at..).unwrap_or_default();
        after
            .iter()
            .position(|b| *b == b'\n')
            .map_or(self.text.len(), |i| at + i)
    }

    /// Returns the nearest start of a character at or before `at`.
    fn boundary(&self, at: usize) -> usize {
        let mut at = at.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}

impl SourceCode for Excerpt<'_> {
    fn read_span<'b>(
        &'b self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'b> + 'b>, MietteError> {
        let (start, end) = (span.offset(), span.offset().saturating_add(span.len()));
        let (mut from, mut to) = self.lines(start, end, before.max(after));
        if before == 0 && after == 0 {
            // Asked for the place of a mark alone.
            from = start;
        } else if self.is_wide(start, end) {
            from = self.boundary(start.saturating_sub(BEFORE)).max(self.line_start(start));
            to = self
                .boundary(end.saturating_add(AFTER))
                .min(self.line_end(start))
                .max(end);
        }
        let bytes = self.text.as_bytes();
        let data = bytes.get(from..to).ok_or(MietteError::OutOfBounds)?;
        let lines_before = bytes.iter().take(from).filter(|b| **b == b'\n').count();
        let column = from - self.line_start(from);
        // From the start of the text, as miette's own sources count: it draws two marks in one piece when the second lies
        // within as many lines of the first.
        let n_lines = lines_before + data.iter().filter(|b| **b == b'\n').count();
        let whole = SourceSpan::from((from, to - from));
        let path = self.path.to_owned();
        Ok(Box::new(MietteSpanContents::new_named(
            path,
            data,
            whole,
            lines_before,
            column,
            n_lines,
        )))
    }
}
