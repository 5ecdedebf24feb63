//! Statements to lines: each on one line if it fits, else broken at its blocks, its arguments or its operators.

use super::flat::{flat, flat_behind, is_declaration};
use super::lines::{Line, render};
use super::tokens::Token;
use super::tree::{Before, Block, Node, as_before, has_space};
use super::{INDENT, WIDTH};

/// A line may break before these.
const OPERATORS: [&str; 12] = ["+", "-", "*", "/", "==", "!=", "<", ">", "<=", ">=", ">>", "!>>"];

/// Lines so far; the last one is being written.
#[derive(Debug, Default)]
pub(super) struct Writer<'t> {
    lines: Vec<Line<'t>>,
    /// The last line ends with a comment that nothing may follow.
    is_full: bool,
}

impl<'t> Writer<'t> {
    pub(super) fn finish(self) -> String {
        render(&self.lines)
    }

    /// Writes the statements of a block, each from a new line on.
    pub(super) fn entries(&mut self, block: &Block<'t>, indent: usize) {
        for (i, entry) in block.entries.iter().enumerate() {
            if entry.is_apart && i > 0 {
                self.new_line(0);
            }
            self.new_line(indent);
            self.statement(&entry.nodes, indent, 0);
            for comment in &entry.comments {
                self.comment(*comment);
            }
        }
    }

    fn new_line(&mut self, indent: usize) {
        self.is_full = false;
        self.lines.push(Line {
            indent,
            ..Line::default()
        });
    }

    fn push(&mut self, text: &str) {
        if let Some(line) = self.lines.last_mut() {
            line.width += text.chars().count();
            line.code.push_str(text);
        }
    }

    /// Ends the line with a comment.
    fn comment(&mut self, comment: Token<'t>) {
        if let Some(line) = self.lines.last_mut() {
            line.comments.push(comment);
        }
        self.is_full = true;
    }

    /// Returns the characters that still fit on the line.
    fn room(&self) -> usize {
        let used = self.lines.last().map_or(0, |l| l.indent + l.width);
        WIDTH.saturating_sub(used)
    }

    /// Writes nodes from the start of a line, with `tail` characters to come behind them.
    fn statement(&mut self, nodes: &[Node<'t>], indent: usize, tail: usize) {
        match flat(nodes, tail > 0, self.room().saturating_sub(tail)) {
            Some(text) => self.push(&text),
            None => self.broken(nodes, indent, tail),
        }
    }

    /// Writes nodes that do not fit, or hold a comment that ends its line.
    fn broken(&mut self, nodes: &[Node<'t>], indent: usize, tail: usize) {
        let is_declaration = is_declaration(nodes);
        let is_if = nodes.iter().find_map(Node::text) == Some("IF");
        let (mut before, mut is_begun, mut has_block) = (Before::Nothing, false, false);
        for (i, node) in nodes.iter().enumerate() {
            let after = nodes.get(i + 1);
            let rest = &nodes[i + 1..];
            // What goes on from the line above stands deeper.
            let inner = if is_begun { indent + INDENT } else { indent };
            if let Some(comment) = node.comment().filter(|c| c.is_hard()) {
                if self.is_full || comment.breaks > 0 && i > 0 {
                    self.new_line(inner);
                }
                self.comment(*comment);
                before = Before::Comment;
                continue;
            }
            let mut has_space = has_space(before, node, after, is_declaration);
            let is_operator = node.text().is_some_and(|t| OPERATORS.contains(&t));
            let is_long = is_operator && !matches!(as_before(before, node, after), Before::Sign) && {
                let n = usize::from(has_space) + node.text().map_or(0, str::len);
                n + self.piece(rest, tail) > self.room()
            };
            if self.is_full || is_long {
                let is_end = node.is_block() || node.text() == Some(";");
                self.new_line(if is_end { indent } else { inner });
                has_space = false;
            }
            if has_space {
                self.push(" ");
            }
            match node {
                Node::Token(token) => self.push(token.text),
                Node::Args(open, inner, close) => {
                    let most = self.room().saturating_sub(self.piece(rest, tail));
                    match flat_behind(Before::Nothing, std::slice::from_ref(node), true, most) {
                        Some(text) => self.push(&text),
                        None if inner.iter().any(Node::is_block) => self.around_blocks(open, inner, close, indent),
                        None => self.arguments(open, inner, close, indent),
                    }
                }
                Node::Block(block) => {
                    let is_test = is_if && !std::mem::replace(&mut has_block, true);
                    let most = if is_test { self.room().saturating_sub(2) } else { 0 };
                    match flat(std::slice::from_ref(node), false, most) {
                        Some(text) => self.push(&text),
                        None => self.block(block, indent),
                    }
                }
            }
            is_begun |= node.comment().is_none();
            before = as_before(before, node, after);
        }
    }

    /// Returns the characters from here to the next place where a line may break.
    fn piece(&self, rest: &[Node<'t>], tail: usize) -> usize {
        let ends = |n: &Node<'_>| n.is_block() || n.text().is_some_and(|t| OPERATORS.contains(&t));
        let rest = &rest[..rest.len().min(WIDTH)];
        let end = rest.iter().position(ends);
        let n = match end {
            Some(i) if rest[i].is_block() => 2,
            Some(_) => 0,
            None => tail,
        };
        let piece = &rest[..end.unwrap_or(rest.len())];
        // What is longer than a line breaks within.
        flat_behind(Before::Operand("x"), piece, true, WIDTH).map_or(0, |t| t.chars().count()) + n
    }

    /// Writes `{`, the statements, `}`.
    fn block(&mut self, block: &Block<'t>, indent: usize) {
        if block.is_empty() {
            self.push("{ }");
            return;
        }
        self.push("{");
        for comment in &block.head {
            self.comment(*comment);
        }
        self.entries(block, indent + INDENT);
        self.new_line(indent);
        self.push("}");
    }

    /// Writes `FORALL(Agent B, {guard}, { ... })`: a block that does not fit stands open, the rest stays around it.
    fn around_blocks(&mut self, open: &Token<'t>, inner: &[Node<'t>], close: &Token<'t>, indent: usize) {
        self.push(open.text);
        let mut before = Before::Nothing;
        for (i, node) in inner.iter().enumerate() {
            let after = inner.get(i + 1);
            if let Some(comment) = node.comment().filter(|c| c.is_hard()) {
                if self.is_full || comment.breaks > 0 {
                    self.new_line(indent + INDENT);
                }
                self.comment(*comment);
                before = Before::Comment;
                continue;
            }
            if self.is_full {
                self.new_line(if node.is_block() { indent } else { indent + INDENT });
            } else if has_space(before, node, after, false) {
                self.push(" ");
            }
            // Behind the last block no line can break.
            let rest = &inner[i + 1..];
            let tail = if rest.iter().any(Node::is_block) {
                ", {".len()
            } else {
                let n = flat_behind(as_before(before, node, after), rest, true, WIDTH);
                n.map_or(WIDTH, |t| t.chars().count()) + ");".len()
            };
            let most = self.room().saturating_sub(tail);
            match (node, flat(std::slice::from_ref(node), true, most)) {
                (_, Some(text)) => self.push(&text),
                (Node::Block(block), None) => self.block(block, indent),
                (Node::Token(token), None) => self.push(token.text),
                (Node::Args(open, inner, close), None) => self.arguments(open, inner, close, indent),
            }
            before = as_before(before, node, after);
        }
        if self.is_full {
            self.new_line(indent);
        }
        self.push(close.text);
    }

    /// Writes each argument on a line of its own.
    fn arguments(&mut self, open: &Token<'t>, inner: &[Node<'t>], close: &Token<'t>, indent: usize) {
        self.push(open.text);
        let mut rest = inner;
        while !rest.is_empty() {
            let comma = rest.iter().position(|n| n.text() == Some(","));
            let (argument, others) = rest.split_at(comma.unwrap_or(rest.len()));
            rest = others.get(1..).unwrap_or_default();
            // Comments that stand behind the comma belong to its line.
            let n_behind = rest
                .iter()
                .take_while(|n| n.comment().is_some_and(|c| c.breaks == 0 && c.is_hard()))
                .count();
            let (behind, next) = rest.split_at(n_behind);
            rest = next;
            self.new_line(indent + INDENT);
            self.statement(argument, indent + INDENT, 1);
            if comma.is_some() {
                if self.is_full {
                    self.new_line(indent + INDENT);
                }
                self.push(",");
            }
            for comment in behind.iter().filter_map(Node::comment) {
                self.comment(*comment);
            }
        }
        self.new_line(indent);
        self.push(close.text);
    }
}
