//! What fits on one line, and how it reads there.

use super::tree::{Before, Block, Entry, Node, as_before, has_space};

/// Blocks that stand open even if they would fit on a line: what is in them is what a file is read for.
const OPEN_BLOCKS: [&str; 7] = [
    "factdatabase",
    "factDatabase",
    "HTN",
    "action",
    "operator",
    "method",
    "task",
];

/// Returns the nodes on one line of at most `most` characters; `None` if that can't be.
///
/// `is_inner` within round brackets: blocks are written without spaces then, and may have several statements.
pub(super) fn flat(nodes: &[Node<'_>], is_inner: bool, most: usize) -> Option<String> {
    let mut line = Line {
        text: String::new(),
        n_left: most,
    };
    line.nodes(nodes, Before::Nothing, is_inner)?;
    Some(line.text)
}

/// As [`flat`] for nodes that stand behind `before`, with the space there.
pub(super) fn flat_behind<'t>(before: Before<'t>, nodes: &[Node<'t>], is_inner: bool, most: usize) -> Option<String> {
    let mut line = Line {
        text: String::new(),
        n_left: most,
    };
    line.nodes(nodes, before, is_inner)?;
    Some(line.text)
}

/// Says whether the nodes declare a type, where `:` stands between two names.
pub(super) fn is_declaration(nodes: &[Node<'_>]) -> bool {
    nodes.iter().find_map(Node::text) == Some("define")
}

struct Line {
    text: String,
    /// Characters that may still come.
    n_left: usize,
}

impl Line {
    fn push(&mut self, text: &str) -> Option<()> {
        self.n_left = self.n_left.checked_sub(text.chars().count())?;
        self.text.push_str(text);
        Some(())
    }

    fn nodes<'t>(&mut self, nodes: &[Node<'t>], mut before: Before<'t>, is_inner: bool) -> Option<()> {
        let is_declaration = is_declaration(nodes);
        let is_open = nodes
            .iter()
            .find_map(Node::text)
            .is_some_and(|w| OPEN_BLOCKS.contains(&w));
        for (i, node) in nodes.iter().enumerate() {
            let after = nodes.get(i + 1);
            if has_space(before, node, after, is_declaration) {
                self.push(" ")?;
            }
            match node {
                Node::Token(token) if token.is_hard() => return None,
                Node::Token(token) => self.push(token.text)?,
                Node::Args(open, inner, close) => {
                    self.push(open.text)?;
                    self.nodes(inner, Before::Nothing, true)?;
                    self.push(close.text)?;
                }
                Node::Block(block) if is_inner => self.inner_block(block)?,
                Node::Block(block) if is_open && !block.is_empty() => return None,
                Node::Block(block) => self.block(block)?,
            }
            before = as_before(before, node, after);
        }
        Some(())
    }

    /// Writes `{a; b;}`.
    fn inner_block(&mut self, block: &Block<'_>) -> Option<()> {
        self.push("{")?;
        self.contents(block, true)?;
        self.push("}")
    }

    /// Writes `{ a; }`: one statement without a block of its own.
    fn block(&mut self, block: &Block<'_>) -> Option<()> {
        let has_block = |e: &Entry<'_>| e.nodes.iter().any(Node::is_block);
        if block.entries.len() > 1 || block.entries.iter().any(has_block) {
            return None;
        }
        self.push("{ ")?;
        self.contents(block, false)?;
        self.push(if block.is_empty() { "}" } else { " }" })
    }

    fn contents(&mut self, block: &Block<'_>, is_inner: bool) -> Option<()> {
        // A comment that the user put on a line of its own stays there.
        let is_own = |e: &Entry<'_>| e.nodes.is_empty();
        if block.entries.iter().any(is_own) || !block.head.is_empty() && !block.entries.is_empty() {
            return None;
        }
        let mut is_first = true;
        let comments = |this: &mut Self, comments: &[super::tokens::Token<'_>], is_first: &mut bool| {
            for comment in comments {
                if comment.is_hard() {
                    return None;
                }
                if !std::mem::take(is_first) {
                    this.push(" ")?;
                }
                this.push(comment.text)?;
            }
            Some(())
        };
        comments(self, &block.head, &mut is_first)?;
        for entry in &block.entries {
            if !std::mem::take(&mut is_first) {
                self.push(" ")?;
            }
            self.nodes(&entry.nodes, Before::Nothing, is_inner)?;
            comments(self, &entry.comments, &mut is_first)?;
        }
        Some(())
    }
}
