//! HDDL text to nested lists of words, with places. One pass with a stack of its own; knows no HDDL but the sections'
//! names, which tell where a bracket was forgotten.

use super::problems::{self, Problems};
use crate::source::{FileId, Span};

/// Lists may nest this deep. HEURISTIC: public domains stay below 12.
pub(super) const MAX_DEPTH: usize = 40;

/// Lists that begin so are sections: they stand directly in `(define ...)`.
const SECTIONS: &[&str] = &[
    ":action",
    ":durative-action",
    ":method",
    ":task",
    ":predicates",
    ":functions",
    ":types",
    ":requirements",
    ":init",
    ":htn",
    ":objects",
];

/// A word or a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Tree<'t> {
    pub span: Span,
    pub kind: Kind<'t>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind<'t> {
    Word(&'t str),
    List(Vec<Tree<'t>>),
}

impl<'t> Tree<'t> {
    /// Returns the word, if it is one.
    pub fn word(&self) -> Option<&'t str> {
        match &self.kind {
            Kind::Word(word) => Some(word),
            Kind::List(_) => None,
        }
    }

    /// Returns the parts of a list, if it is one.
    pub fn list(&self) -> Option<&[Tree<'t>]> {
        match &self.kind {
            Kind::Word(_) => None,
            Kind::List(parts) => Some(parts),
        }
    }

    /// Says whether this is the word, whatever its capitals.
    pub fn is(&self, word: &str) -> bool {
        self.word().is_some_and(|w| w.eq_ignore_ascii_case(word))
    }

    /// Returns the word at the beginning of a list, and what follows it.
    pub fn headed(&self) -> Option<(&Tree<'t>, &[Tree<'t>])> {
        let (head, rest) = self.list()?.split_first()?;
        head.word().map(|_| (head, rest))
    }
}

/// A list that is still open.
struct Open<'t> {
    start: usize,
    parts: Vec<Tree<'t>>,
}

/// Returns what stands in a file; after a problem, what could be read.
pub(super) fn read<'t>(file: FileId, text: &'t str, problems: &mut Problems) -> Vec<Tree<'t>> {
    let bytes = text.as_bytes();
    let mut top: Vec<Tree<'t>> = Vec::new();
    let mut open: Vec<Open<'t>> = Vec::new();
    let mut at = 0;
    // Lists that were closed for the user, whose own brackets may still come.
    let mut n_forgotten = 0;
    while let Some(byte) = bytes.get(at).copied() {
        let start = at;
        match byte {
            b';' => at += text[at..].find('\n').unwrap_or(text.len() - at),
            b'(' => {
                at += 1;
                if open.len() >= MAX_DEPTH {
                    problems.push(problems::too_deep(Span::new(file, start, at)));
                    return Vec::new();
                }
                if open.len() > 1 && begins_section(&text[at..]) && text[..start].ends_with(['\n', ' ', '\t', ')']) {
                    // The list directly in `(define ...)` that holds this one was to be closed before.
                    if let Some(unclosed) = open.get(1) {
                        let place = Span::new(file, unclosed.start, unclosed.start + 1);
                        problems.push(problems::unclosed(place, Some(Span::new(file, start, at))));
                    }
                    n_forgotten += open.len() - 1;
                    while open.len() > 1 {
                        close(file, at - 1, &mut open, &mut top);
                    }
                }
                open.push(Open {
                    start,
                    parts: Vec::new(),
                });
            }
            b')' => {
                at += 1;
                if open.is_empty() && n_forgotten > 0 {
                    n_forgotten -= 1;
                } else if open.is_empty() {
                    problems.push(problems::unopened(Span::new(file, start, at)));
                } else {
                    close(file, at, &mut open, &mut top);
                }
            }
            _ if byte.is_ascii_whitespace() || byte == 0x0b || byte == 0x1a => at += 1,
            _ if text[at..].starts_with('\u{FEFF}') => at += '\u{FEFF}'.len_utf8(),
            _ => {
                let ends = |c: char| c.is_ascii_whitespace() || matches!(c, '(' | ')' | ';' | '\u{0b}' | '\u{1a}');
                at += text[at..].find(ends).unwrap_or(text.len() - at);
                let word = Tree {
                    span: Span::new(file, start, at),
                    kind: Kind::Word(&text[start..at]),
                };
                parts(&mut open, &mut top).push(word);
            }
        }
    }
    if let Some(outermost) = open.first() {
        problems.push(problems::unclosed(
            Span::new(file, outermost.start, outermost.start + 1),
            None,
        ));
    }
    while !open.is_empty() {
        close(file, text.len(), &mut open, &mut top);
    }
    top
}

/// Says whether a list that begins with this text is a section.
fn begins_section(rest: &str) -> bool {
    let end = rest.find(|c: char| c.is_ascii_whitespace() || matches!(c, '(' | ')'));
    let word = &rest[..end.unwrap_or(rest.len())];
    SECTIONS.iter().any(|section| section.eq_ignore_ascii_case(word))
}

fn parts<'a, 't>(open: &'a mut [Open<'t>], top: &'a mut Vec<Tree<'t>>) -> &'a mut Vec<Tree<'t>> {
    match open.last_mut() {
        Some(list) => &mut list.parts,
        None => top,
    }
}

fn close<'t>(file: FileId, end: usize, open: &mut Vec<Open<'t>>, top: &mut Vec<Tree<'t>>) {
    if let Some(list) = open.pop() {
        let list = Tree {
            span: Span::new(file, list.start, end),
            kind: Kind::List(list.parts),
        };
        parts(open, top).push(list);
    }
}
