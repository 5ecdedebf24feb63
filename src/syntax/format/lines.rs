//! Finished lines: comments at the ends of neighbouring lines begin in one column.

use super::tokens::Token;

/// A line before its comment has its column.
#[derive(Debug, Default)]
pub(super) struct Line<'t> {
    pub(super) indent: usize,
    pub(super) code: String,
    /// Characters of `code`.
    pub(super) width: usize,
    pub(super) comments: Vec<Token<'t>>,
}

impl Line<'_> {
    fn is_blank(&self) -> bool {
        self.code.is_empty() && self.comments.is_empty()
    }

    /// Says whether its comment may begin where those of its neighbours do.
    fn is_aligned(&self) -> bool {
        !self.code.is_empty() && !self.comments.is_empty()
    }
}

/// Returns the lines as text.
pub(super) fn render(lines: &[Line<'_>]) -> String {
    let mut out = String::new();
    let mut i = 0;
    while i < lines.len() {
        let neighbours = lines[i..]
            .iter()
            .take_while(|l| l.is_aligned() && l.indent == lines[i].indent)
            .count()
            .max(1);
        let widest = lines[i..i + neighbours].iter().map(|l| l.width).max().unwrap_or(0);
        for line in &lines[i..i + neighbours] {
            if !line.is_blank() {
                push_line(&mut out, line, widest);
            }
            out.push('\n');
        }
        i += neighbours;
    }
    out
}

fn push_line(out: &mut String, line: &Line<'_>, widest: usize) {
    let spaces = |out: &mut String, n: usize| out.extend(std::iter::repeat_n(' ', n));
    spaces(out, line.indent);
    out.push_str(&line.code);
    let mut column = line.indent + line.width;
    for (i, comment) in line.comments.iter().enumerate() {
        if !line.code.is_empty() || i > 0 {
            let gap = if i == 0 { widest - line.width + 2 } else { 1 };
            spaces(out, gap);
            column += gap;
        }
        // The further lines of a comment move with its first.
        for (i, text) in comment.text.split('\n').enumerate() {
            if i == 0 {
                out.push_str(text.trim_end());
                continue;
            }
            out.push('\n');
            let text = text.trim_end();
            let inner = text.trim_start();
            if inner.is_empty() {
                continue;
            }
            let shift = column.saturating_sub(comment.column);
            let back = comment.column.saturating_sub(column);
            let n_white = text.len() - inner.len();
            // White space in front may be tabs: what is not taken away stays as it was.
            spaces(out, shift);
            out.push_str(&text[text.ceil_char_boundary(back.min(n_white))..]);
        }
        column += comment.text.chars().count();
    }
}
