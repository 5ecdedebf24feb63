//! Tokens to brackets, and what stands in braces to statements with their comments.

use super::tokens::{Kind, Token, tokens};

/// A token, or brackets with what is in them.
#[derive(Debug)]
pub(super) enum Node<'t> {
    Token(Token<'t>),
    /// `( )` or `[ ]`: the opening mark, what is within, the closing mark.
    Args(Token<'t>, Vec<Node<'t>>, Token<'t>),
    /// `{ }`
    Block(Block<'t>),
}

impl<'t> Node<'t> {
    pub(super) fn is_block(&self) -> bool {
        matches!(self, Node::Block(_))
    }

    pub(super) fn comment(&self) -> Option<&Token<'t>> {
        match self {
            Node::Token(token) if token.is_comment() => Some(token),
            _ => None,
        }
    }

    /// Returns the text of a token that is no comment.
    pub(super) fn text(&self) -> Option<&'t str> {
        match self {
            Node::Token(token) if !token.is_comment() => Some(token.text),
            _ => None,
        }
    }

    /// Returns the first token.
    fn first(&self) -> Option<&Token<'t>> {
        match self {
            Node::Token(token) | Node::Args(token, ..) => Some(token),
            Node::Block(block) => block.open.as_ref(),
        }
    }
}

/// The statements of a file or of `{ }`.
#[derive(Debug, Default)]
pub(super) struct Block<'t> {
    /// `None` for a file.
    pub(super) open: Option<Token<'t>>,
    /// Comments behind the opening brace.
    pub(super) head: Vec<Token<'t>>,
    pub(super) entries: Vec<Entry<'t>>,
}

impl Block<'_> {
    pub(super) fn is_empty(&self) -> bool {
        self.head.is_empty() && self.entries.is_empty()
    }
}

/// A statement, with the comments behind it; or without nodes, a comment on its own.
#[derive(Debug, Default)]
pub(super) struct Entry<'t> {
    /// A blank line stood before it.
    pub(super) is_apart: bool,
    pub(super) nodes: Vec<Node<'t>>,
    pub(super) comments: Vec<Token<'t>>,
}

/// Returns the statements of a text without syntax errors.
pub(super) fn file(text: &str) -> Block<'_> {
    let tokens = tokens(text);
    let partners = partners(&tokens);
    let mut at = 0;
    block(None, nodes(&tokens, &partners, &mut at, tokens.len()))
}

/// Returns for each opening mark where its closing mark is. In text that the grammar does not look into, round and square
/// brackets may have none; they are marks like others then.
fn partners(tokens: &[Token<'_>]) -> Vec<Option<usize>> {
    let mut partners = vec![None; tokens.len()];
    let mut open: Vec<usize> = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let opening = match token.text {
            "{" | "(" | "[" => {
                open.push(i);
                continue;
            }
            "}" => "{",
            ")" => "(",
            "]" => "[",
            _ => continue,
        };
        let is_partner = |o: &usize| tokens[*o].text == opening;
        match open.last() {
            Some(o) if is_partner(o) => {}
            // A brace closes whatever is open within it.
            Some(_) if opening == "{" => {
                while open.last().is_some_and(|o| !is_partner(o)) {
                    open.pop();
                }
            }
            _ => continue,
        }
        if let Some(o) = open.pop() {
            partners[o] = Some(i);
        }
    }
    partners
}

/// Reads nodes up to `end`. As deep as brackets nest, which the parser has limited.
fn nodes<'t>(tokens: &[Token<'t>], partners: &[Option<usize>], at: &mut usize, end: usize) -> Vec<Node<'t>> {
    let mut out = Vec::new();
    while *at < end {
        let token = tokens[*at];
        let partner = partners[*at];
        *at += 1;
        let Some(close) = partner else {
            out.push(Node::Token(token));
            continue;
        };
        let inner = nodes(tokens, partners, at, close);
        *at = close + 1;
        out.push(if token.text == "{" {
            Node::Block(block(Some(token), inner))
        } else {
            Node::Args(token, inner, tokens[close])
        });
    }
    out
}

/// Nodes that are not yet in a statement.
struct Rest<'t> {
    nodes: std::vec::IntoIter<Node<'t>>,
    /// How many of them are no comments.
    n_words: usize,
}

impl<'t> Rest<'t> {
    fn take(&mut self) -> Option<Node<'t>> {
        let node = self.nodes.next()?;
        self.n_words -= usize::from(node.comment().is_none());
        Some(node)
    }
}

/// Cuts what stands in braces into statements.
fn block<'t>(open: Option<Token<'t>>, nodes: Vec<Node<'t>>) -> Block<'t> {
    let mut out = Block {
        open,
        ..Block::default()
    };
    let n_words = nodes.iter().filter(|n| n.comment().is_none()).count();
    let mut rest = Rest {
        nodes: nodes.into_iter(),
        n_words,
    };
    while let Some(first) = rest.take() {
        let breaks = first.first().map_or(0, |t| t.breaks);
        let comment = first.comment().copied();
        match comment {
            Some(comment) if breaks == 0 && (comment.is_hard() || comment.is_behind) => match out.entries.last_mut() {
                Some(last) => last.comments.push(comment),
                None => out.head.push(comment),
            },
            Some(comment) if comment.is_hard() || breaks > 0 && comment.is_behind => out.entries.push(Entry {
                is_apart: breaks > 1,
                nodes: Vec::new(),
                comments: vec![comment],
            }),
            // A short comment may stand before a statement, on its line.
            _ => out.entries.push(Entry {
                is_apart: breaks > 1,
                nodes: statement(first, &mut rest),
                comments: Vec::new(),
            }),
        }
    }
    out
}

/// Takes the rest of a statement: up to its `;`, or to the closing brace that ends it.
fn statement<'t>(first: Node<'t>, rest: &mut Rest<'t>) -> Vec<Node<'t>> {
    let mut nodes = Vec::new();
    let mut word = None;
    let mut next = Some(first);
    while let Some(node) = next {
        let (is_end, is_block) = (node.text() == Some(";"), node.is_block());
        word = word.or(node.text());
        nodes.push(node);
        if is_end {
            let is_mark = |n: &Node<'_>| n.text() == Some(";");
            while rest.nodes.as_slice().first().is_some_and(is_mark) {
                nodes.extend(rest.take());
            }
            break;
        }
        // Comments that remain are behind the last statement, or below it.
        if rest.n_words == 0 || is_block && !goes_on(word, rest) {
            break;
        }
        next = rest.take();
    }
    nodes
}

/// Says whether a statement that begins with `word` goes on after its last block.
fn goes_on(word: Option<&str>, rest: &Rest<'_>) -> bool {
    let Some(next) = rest.nodes.as_slice().iter().find(|n| n.comment().is_none()) else {
        return false;
    };
    match next.text() {
        Some(";") => true,
        Some("ELSE") => word == Some("IF"),
        _ => next.is_block() && matches!(word, Some("IF" | "OR")),
    }
}

/// What stands before a token, as far as the space between them depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Before<'t> {
    /// Nothing, or an opening bracket.
    Nothing,
    /// A minus sign that belongs to what follows.
    Sign,
    /// A word, a closing bracket.
    Operand(&'t str),
    Mark(&'t str),
    Comment,
}

/// Says whether a space stands before `next`; `is_declaration` where `:` is an operator.
pub(super) fn has_space(
    before: Before<'_>,
    next: &Node<'_>,
    after_next: Option<&Node<'_>>,
    is_declaration: bool,
) -> bool {
    let is_name = |w: &str| w.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    match (before, next) {
        (Before::Nothing | Before::Sign, _) => false,
        (Before::Mark("."), _) => false,
        (_, Node::Token(t)) if !t.is_comment() => match t.text {
            ";" | "," | ")" | "]" => false,
            ":" => is_declaration,
            "." => !is_step(before, after_next),
            _ => true,
        },
        (Before::Operand(word), Node::Args(open, ..)) => !(open.text == "(" && is_name(word)),
        _ => true,
    }
}

/// Says whether a `.` leads from a name to an attribute. It is a mark like any other in text that the grammar does not
/// look into.
fn is_step(before: Before<'_>, after: Option<&Node<'_>>) -> bool {
    let is_name = |w: &str| w.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    matches!(before, Before::Operand(word) if is_name(word)) && after.and_then(Node::text).is_some_and(is_name)
}

/// Returns what a node is to the one after it.
pub(super) fn as_before<'t>(before: Before<'t>, node: &Node<'t>, after: Option<&Node<'t>>) -> Before<'t> {
    match node {
        Node::Token(t) if t.is_comment() => Before::Comment,
        Node::Token(t) if t.kind == Kind::Word => Before::Operand(t.text),
        Node::Token(t) => {
            let is_sign = t.text == "-" && !matches!(before, Before::Operand(_));
            let is_operand = match after {
                Some(Node::Token(t)) => t.kind == Kind::Word,
                Some(Node::Args(..)) => true,
                _ => false,
            };
            match t.text {
                "-" if is_sign && is_operand => Before::Sign,
                // A dot with spaces around it is a mark like any other.
                "." if !is_step(before, after) => Before::Mark("·"),
                text => Before::Mark(text),
            }
        }
        Node::Args(..) => Before::Operand(")"),
        Node::Block(_) => Before::Mark("}"),
    }
}
