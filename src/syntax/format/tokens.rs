//! Words, marks and comments in one row, each with what the user's line breaks say about it.

use crate::syntax::layout::layout;

/// What a token is, as far as the space around it depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A name, a keyword, a number, a string.
    Word,
    Mark,
    /// `// ...`
    LineComment,
    /// `/* ... */`
    BlockComment,
}

/// A token where it stood.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'t> {
    pub(super) text: &'t str,
    pub(super) kind: Kind,
    /// Line breaks before it: 0, 1, or 2 for a blank line.
    pub(super) breaks: usize,
    /// It ends its line.
    pub(super) ends_line: bool,
    /// It is a comment, and only comments follow before the line ends or a bracket closes.
    pub(super) is_behind: bool,
    /// Characters before it on its line.
    pub(super) column: usize,
}

impl Token<'_> {
    pub(super) fn is_comment(&self) -> bool {
        matches!(self.kind, Kind::LineComment | Kind::BlockComment)
    }

    /// Says whether nothing may follow it on its line.
    pub(super) fn is_hard(&self) -> bool {
        self.kind == Kind::LineComment || self.is_comment() && self.text.contains('\n')
    }
}

/// Returns all tokens and comments of a text without syntax errors.
pub(super) fn tokens(text: &str) -> Vec<Token<'_>> {
    let layout = layout(text);
    let mut places: Vec<(usize, usize)> = Vec::with_capacity(layout.tokens.len() + layout.comments.len());
    let mut comments = layout.comments.iter().copied().peekable();
    for (start, end) in layout.tokens {
        while let Some(comment) = comments.next_if(|c| c.0 < start) {
            places.push(comment);
        }
        places.push((start, end));
    }
    places.extend(comments);

    let mut out: Vec<Token<'_>> = Vec::with_capacity(places.len());
    let (mut line, mut column_of, mut column) = (0, 0, 0);
    for (i, &(start, end)) in places.iter().enumerate() {
        let before = i.checked_sub(1).map_or(0, |i| places[i].1);
        let breaks = text[before..start].matches('\n').count();
        if let Some(at) = text[line..start].rfind('\n') {
            line += at + 1;
            (column_of, column) = (line, 0);
        }
        column += text[column_of..start].chars().count();
        column_of = start;
        let next = places.get(i + 1).map_or(text.len(), |p| p.0);
        let piece = &text[start..end];
        out.push(Token {
            text: piece.trim_end(),
            kind: kind(piece),
            breaks: if i == 0 { 1 } else { breaks.min(2) },
            ends_line: next == text.len() || text[end..next].contains('\n'),
            is_behind: false,
            column,
        });
    }
    let mut next_is_behind = true;
    for token in out.iter_mut().rev() {
        token.is_behind = token.is_comment() && (token.ends_line || next_is_behind);
        next_is_behind = token.is_behind || matches!(token.text, "}" | ")" | "]");
    }
    out
}

fn kind(piece: &str) -> Kind {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '"';
    if piece.starts_with("//") {
        Kind::LineComment
    } else if piece.starts_with("/*") {
        Kind::BlockComment
    } else if piece.starts_with(is_word) {
        Kind::Word
    } else {
        Kind::Mark
    }
}
