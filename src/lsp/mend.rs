//! Reads a file that is being typed: statements with syntax errors are blanked out, so that what stands around them is still known.
//!
//! The parser leaves out a whole item with an error in it; while somebody types, that is the item on the screen. Blanks have the
//! length of what they replace, so every span is that of the text as it is. An item with a bracket that is not closed stays left out: editors
//! close brackets by themselves.

use crate::diag::Problems;
use crate::source::FileId;
use crate::syntax::layout::{Token, layout};
use crate::syntax::{self, ast};

/// Times that a text is read again. HEURISTIC: each round mends one error of every item.
const MAX_ROUNDS: usize = 6;

/// Longer files are not mended [tokens]. HEURISTIC: reading one takes a tenth of a second in a debug build.
const MAX_TOKENS: usize = 40_000;

/// Returns what a text with syntax errors says, as far as it can be known; `ast` is what the parser could read of it.
pub(super) fn mended(file: FileId, text: &str, mut ast: ast::File) -> ast::File {
    if layout(text).tokens.len() > MAX_TOKENS {
        return ast;
    }
    let mut text = text.to_owned();
    for _ in 0..MAX_ROUNDS {
        let (read, faults) = syntax::parse(file, &text);
        // Blanking the wrong thing loses items; then what was read before is better.
        if read.items.len() < ast.items.len() {
            break;
        }
        ast = read;
        match without_faults(&text, &faults) {
            Some(next) if faults.has_errors() => text = next,
            _ => break,
        }
    }
    ast
}

/// Returns the text with the statement of every syntax error blanked; `None` if there is nothing to blank.
fn without_faults(text: &str, faults: &Problems) -> Option<String> {
    let row = Row::of(text);
    let mut bytes = text.as_bytes().to_vec();
    let mut changed = false;
    for fault in faults.0.iter().filter(|p| p.code == "hatp::syntax") {
        let at = fault.primary.as_ref()?.span.start as usize;
        let Some((start, end)) = row.statement(at) else {
            continue;
        };
        for byte in bytes.get_mut(start..end)? {
            changed |= !byte.is_ascii_whitespace();
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    }
    let mended = String::from_utf8(bytes).ok()?;
    changed.then_some(mended)
}

/// The tokens of a text, and which brackets belong together.
struct Row<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    partners: Vec<Option<usize>>,
}

impl<'a> Row<'a> {
    fn of(text: &'a str) -> Self {
        let tokens = layout(text).tokens;
        let mut partners = vec![None; tokens.len()];
        let mut open: Vec<usize> = Vec::new();
        for i in 0..tokens.len() {
            match tokens.get(i).and_then(|t| text.get(t.0..t.1)) {
                Some("{" | "(" | "[") => open.push(i),
                Some("}" | ")" | "]") => {
                    if let Some(partner) = open.pop() {
                        partners[partner] = Some(i);
                        partners[i] = Some(partner);
                    }
                }
                _ => {}
            }
        }
        Row { text, tokens, partners }
    }

    fn word(&self, i: usize) -> &'a str {
        self.tokens
            .get(i)
            .and_then(|t| self.text.get(t.0..t.1))
            .unwrap_or_default()
    }

    fn partner(&self, i: usize) -> Option<usize> {
        self.partners.get(i).copied().flatten()
    }

    /// Returns the first token of the statement that token `i` continues.
    fn begin(&self, i: usize) -> usize {
        let mut at = i;
        while let Some(before) = at.checked_sub(1) {
            match self.word(before) {
                ";" | "{" => return at,
                // A block among arguments is part of its statement.
                "}" => match self.partner(before) {
                    Some(open) if open > 0 && self.word(open - 1) == "," => at = open,
                    _ => return at,
                },
                _ => at = before,
            }
        }
        0
    }

    /// Returns the token behind the statement that begins at token `i`.
    fn end(&self, i: usize) -> usize {
        let mut at = i;
        while at < self.tokens.len() {
            match self.word(at) {
                ";" => return at + 1,
                "}" => return at,
                "{" => match self.partner(at) {
                    Some(close) if at > 0 && self.word(at - 1) == "," => at = close + 1,
                    Some(close) => return close + 1,
                    None => return at + 1,
                },
                _ => at += 1,
            }
        }
        at
    }

    /// Returns the bytes of the statement in which `at` lies; of an empty one, those of the block around it with its head.
    fn statement(&self, at: usize) -> Option<(usize, usize)> {
        // An error where something is missing stands at the end of the token before.
        let found = self.tokens.partition_point(|t| t.0 < at);
        let starts_here = self.tokens.get(found).is_some_and(|t| t.0 == at);
        let i = if starts_here { found } else { found.checked_sub(1)? };
        let opens_next = !starts_here && matches!(self.word(i), "{" | ";");
        let mut begin = if opens_next { i + 1 } else { self.begin(i) };
        let mut end = self.end(begin);
        if end <= begin {
            let open = begin.checked_sub(1).filter(|o| self.word(*o) == "{")?;
            begin = self.begin(open);
            end = self.partner(open).unwrap_or(open) + 1;
        }
        let (first, last) = (self.tokens.get(begin)?, self.tokens.get(end.checked_sub(1)?)?);
        (first.0 < last.1).then_some((first.0, last.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::ast::{Clause, Item};

    const FILE: FileId = FileId(0);

    /// Returns the domain read with `broken` in place of a statement of an action's tests.
    fn read_with(broken: &str) -> ast::File {
        let text = format!(
            "HTN {{ action Go(Agent A, Agent B) {{ preconditions {{ A != B; {broken}\n }}; effects {{ A.x = B; }}; }} method M(Agent A) {{ }} }}"
        );
        let (ast, problems) = syntax::parse(FILE, &text);
        assert!(problems.has_errors(), "{broken}");
        mended(FILE, &text, ast)
    }

    #[test]
    fn the_rest_of_an_item_is_read() {
        for broken in [
            "A.",
            "A.x ==",
            "A.x == ;",
            "B >> ",
            "EXIST(Agent C, {C != A;}, {C. });",
            "\"open",
            "OR{ A == }{ B == A; };",
            "] é",
        ] {
            let ast = read_with(broken);
            let names: Vec<&str> = ast
                .items
                .iter()
                .filter_map(|item| match item {
                    Item::Action(a) => Some(a.name.text.as_str()),
                    Item::Method(m) => Some(m.name.text.as_str()),
                    _ => None,
                })
                .collect();
            assert_eq!(names, ["Go", "M"], "{broken}");
        }
    }

    #[test]
    fn other_clauses_stay() {
        let ast = read_with("A.x == ");
        let Some(Item::Action(action)) = ast.items.first() else {
            panic!("{ast:?}")
        };
        assert!(
            matches!(action.clauses.as_slice(), [Clause::Preconditions(tests, _), Clause::Effects(effects, _)]
            if tests.len() == 1 && effects.len() == 1)
        );
    }
}
