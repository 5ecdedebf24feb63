//! The text as a row of marks and words, without meaning: where tokens end, and how deep brackets nest.
//!
//! One pass, no recursion. It runs before the grammar: it takes out comments and white space, and recursion must not
//! follow the text to any depth. After a syntax error it tells the token before.

/// Brackets may nest this deep. HEURISTIC: real domains stay below 12; a parser in a debug build needs about 10 kB of
/// stack for each.
pub const MAX_DEPTH: usize = 64;

/// A file may have this many tokens. HEURISTIC: fifty times the largest domain that we know; the search for pieces of a
/// broken file of that size takes less than a second.
pub const MAX_TOKENS: usize = 400_000;

/// Start and end of a token [bytes].
pub type Token = (usize, usize);

/// What the text is made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Every token, in order; comments and white space are none.
    pub tokens: Vec<Token>,
    /// Every comment, in order, without the end of its line.
    pub comments: Vec<Token>,
    /// The bracket that lies deeper than [`MAX_DEPTH`], if any.
    pub too_deep: Option<Token>,
    /// Open brackets that are never closed, outermost first.
    pub unclosed: Vec<Token>,
    /// A `/*` without its `*/`.
    pub open_comment: Option<usize>,
    /// A `"` without its partner on the same line.
    pub open_string: Option<usize>,
}

/// Returns the layout of `text`.
pub fn layout(text: &str) -> Layout {
    let bytes = text.as_bytes();
    let mut out = Layout {
        tokens: Vec::new(),
        comments: Vec::new(),
        too_deep: None,
        unclosed: Vec::new(),
        open_comment: None,
        open_string: None,
    };
    let at = |i: usize| bytes.get(i).copied().unwrap_or(0);
    let mut i = 0;
    while i < bytes.len() {
        let start = i;
        let c = at(i);
        // Tabs, ends of lines and pages; the end mark of old systems; a byte order mark.
        if matches!(c, b' ' | b'\t'..=b'\r' | 0x1a) {
            i += 1;
            continue;
        }
        if c == 0xef && text[i..].starts_with('\u{FEFF}') {
            i += 3;
            continue;
        }
        if c == b'/' && at(i + 1) == b'/' {
            i += text[i..].find('\n').unwrap_or(bytes.len() - i);
            out.comments.push((start, i));
            continue;
        }
        if c == b'/' && at(i + 1) == b'*' {
            match text[i + 2..].find("*/") {
                Some(n) => {
                    i += n + 4;
                    out.comments.push((start, i));
                }
                None => {
                    out.open_comment = Some(i);
                    i = bytes.len();
                }
            }
            continue;
        }
        if c == b'"' {
            i += 1;
            while i < bytes.len() && at(i) != b'"' && at(i) != b'\n' {
                i += if at(i) == b'\\' && at(i + 1) != b'\n' { 2 } else { 1 };
            }
            if at(i) == b'"' {
                i += 1;
            } else {
                out.open_string.get_or_insert(start);
            }
            i = i.min(bytes.len());
        } else if c.is_ascii_alphanumeric() || c == b'_' {
            i = number_end(bytes, i).unwrap_or(i);
            while at(i).is_ascii_alphanumeric() || at(i) == b'_' {
                i += 1;
            }
        } else {
            const LONG_MARKS: [&str; 8] = ["!>>", "<<=", "=>>", ">>", "==", "!=", "<=", ">="];
            let long = LONG_MARKS.iter().find(|m| text[i..].starts_with(**m));
            i += long.map_or_else(|| text[i..].chars().next().map_or(1, char::len_utf8), |m| m.len());
            match c {
                b'{' | b'(' | b'[' => {
                    out.unclosed.push((start, i));
                    if out.unclosed.len() > MAX_DEPTH && out.too_deep.is_none() {
                        out.too_deep = Some((start, i));
                        return out;
                    }
                }
                b'}' | b')' | b']' => {
                    out.unclosed.pop();
                }
                _ => {}
            }
        }
        // A string cut by the end of the text may have stepped into a character.
        while !text.is_char_boundary(i) {
            i += 1;
        }
        out.tokens.push((start, i));
    }
    out
}

/// Returns where the number that starts at `start` ends, with its fraction and its exponent.
fn number_end(bytes: &[u8], start: usize) -> Option<usize> {
    let digits = |mut at: usize| {
        let from = at;
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        (at > from).then_some(at)
    };
    let mut end = digits(start)?;
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1).unwrap_or(end);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        end = digits(end + 1 + sign).unwrap_or(end);
    }
    Some(end)
}

/// The tokens of a text with one space wherever something else stood between two of them.
#[derive(Debug)]
pub struct Compact {
    pub text: String,
    /// Where each token of the layout starts in `text` [bytes].
    pub starts: Vec<usize>,
    /// For each byte of `text`, and for its end, where it comes from.
    origins: Vec<u32>,
}

impl Compact {
    /// Returns the place in the original text of the byte at `at`.
    pub fn origin(&self, at: usize) -> usize {
        self.origins.get(at).or(self.origins.last()).map_or(0, |o| *o as usize)
    }

    /// Returns where in the original text a piece ends that ends before `at`.
    pub fn origin_of_end(&self, at: usize) -> usize {
        at.checked_sub(1).map_or(0, |last| self.origin(last) + 1)
    }
}

impl Layout {
    /// Returns `text`, whose layout this is, without comments and superfluous white space.
    pub fn compact(&self, text: &str) -> Compact {
        let mut out = Compact {
            text: String::with_capacity(text.len()),
            starts: Vec::with_capacity(self.tokens.len()),
            origins: Vec::with_capacity(text.len() + 1),
        };
        // Text is at most 4 GB: spans are of the same size.
        let cap = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        let mut before = 0;
        for (i, &(start, end)) in self.tokens.iter().enumerate() {
            if i > 0 && start > before {
                out.text.push(' ');
                out.origins.push(cap(before));
            }
            out.starts.push(out.text.len());
            out.text.push_str(&text[start..end]);
            out.origins.extend(cap(start)..cap(end));
            before = end;
        }
        out.origins.push(cap(text.len()));
        out
    }

    /// Returns the last token that starts before `at`, and the first that does not.
    pub fn around(&self, at: usize) -> (Option<Token>, Option<Token>) {
        let next = self.tokens.partition_point(|t| t.0 < at);
        let before = next.checked_sub(1).and_then(|i| self.tokens.get(i)).copied();
        (before, self.tokens.get(next).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_strings_hide_brackets() {
        let text = "a { // {\n \"{\" /* { */ b }";
        let layout = layout(text);
        let words: Vec<&str> = layout.tokens.iter().map(|t| &text[t.0..t.1]).collect();
        assert_eq!(words, ["a", "{", "\"{\"", "b", "}"]);
        assert!(layout.unclosed.is_empty());
        assert_eq!(layout.around(7).0, Some((2, 3)));
    }

    #[test]
    fn the_deep_bracket_is_found() {
        let text = "(".repeat(MAX_DEPTH + 5);
        assert_eq!(layout(&text).too_deep, Some((MAX_DEPTH, MAX_DEPTH + 1)));
    }
}
