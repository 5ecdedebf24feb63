//! Where the cursor stands: in which block, after which words, with which variables.
//!
//! Reads tokens, not the grammar: what is being typed is no valid text yet. One pass from the beginning of the file to the cursor.

use crate::lsp::index::{Index, Value};
use crate::syntax::layout::layout;

/// What a bracket opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Block {
    File,
    Database,
    Attributes,
    Htn,
    Params,
    Action,
    Method,
    Decomposition,
    Subtasks,
    Tests,
    Effects,
    Projects,
    Settings,
    Social,
    /// Within `undesirable sequence NAME weight N { }`.
    Sequence,
    /// Arguments of SELECT; of FORALL and EXIST, and whether effects stand in the second block.
    Select,
    Quantified {
        has_effects: bool,
    },
    /// Where an expression stands: `cost { }`, arguments, lists.
    Value,
    /// Not looked into.
    Opaque,
}

/// An open bracket.
#[derive(Debug, Clone)]
struct Frame {
    block: Block,
    bracket: &'static str,
    /// The first token of the statement that is being read.
    begin: usize,
    /// Blocks closed within that statement.
    n_blocks: usize,
    /// Variables known when it was opened.
    n_variables: usize,
}

/// Where the cursor stands.
#[derive(Debug)]
pub(super) struct Context<'a> {
    pub block: Block,
    /// Tokens of the statement before the cursor's word.
    pub before: Vec<&'a str>,
    /// What is typed of the word already.
    pub prefix: &'a str,
    /// The innermost last.
    pub variables: Vec<(String, Value)>,
    /// Labels of the block's subtasks.
    pub labels: Vec<&'a str>,
}

/// Returns the context of the byte `at`; `None` in a comment or a string.
pub(super) fn context<'a>(text: &'a str, at: usize, index: &Index) -> Option<Context<'a>> {
    let text = text.get(..at)?;
    let layout = layout(text);
    if layout.open_comment.is_some() || layout.too_deep.is_some() {
        return None;
    }
    let mut tokens: Vec<&str> = layout.tokens.iter().filter_map(|t| text.get(t.0..t.1)).collect();
    let last_end = layout.tokens.last().map_or(0, |t| t.1);
    let gap = text.get(last_end..).unwrap_or("");
    if gap.lines().last().is_some_and(|line| line.contains("//")) && !gap.ends_with('\n') {
        return None;
    }
    let is_word = |w: &str| w.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
    let mut prefix = "";
    if let Some(last) = tokens.last().copied().filter(|_| last_end == at) {
        // A string that is not closed reaches to the end of its line.
        if last.starts_with('"') && (last.len() == 1 || !last.ends_with('"')) {
            return None;
        }
        if is_word(last) {
            prefix = last;
            tokens.pop();
        }
    } else if tokens.last().is_some_and(|t| is_open_string(t)) && !gap.contains('\n') {
        return None;
    }
    let mut scan = Scan {
        tokens,
        index,
        frames: vec![Frame {
            block: Block::File,
            bracket: "",
            begin: 0,
            n_blocks: 0,
            n_variables: 0,
        }],
        variables: Vec::new(),
    };
    for i in 0..scan.tokens.len() {
        scan.step(i);
    }
    let frame = scan.frames.last()?;
    let before = scan.tokens.get(frame.begin..)?.to_vec();
    let labels = scan.labels();
    Some(Context {
        block: frame.block,
        before,
        prefix,
        variables: scan.variables,
        labels,
    })
}

fn is_open_string(token: &str) -> bool {
    token.starts_with('"') && (token.len() == 1 || !token.ends_with('"'))
}

struct Scan<'a, 'i> {
    tokens: Vec<&'a str>,
    index: &'i Index,
    frames: Vec<Frame>,
    variables: Vec<(String, Value)>,
}

impl<'a> Scan<'a, '_> {
    /// Returns the tokens from the beginning of the current statement up to `i`.
    fn head(&self, i: usize) -> &[&'a str] {
        let begin = self.frames.last().map_or(i, |f| f.begin);
        self.tokens.get(begin..i).unwrap_or(&[])
    }

    fn step(&mut self, i: usize) {
        let Some(token) = self.tokens.get(i).copied() else {
            return;
        };
        match token {
            "{" | "(" | "[" => self.open(i, token),
            "}" | ")" | "]" => self.close(i, token),
            ";" => {
                self.bind_let(i);
                self.end_statement(i + 1);
            }
            _ => self.word(i, token),
        }
    }

    fn end_statement(&mut self, next: usize) {
        if let Some(frame) = self.frames.last_mut() {
            frame.begin = next;
            frame.n_blocks = 0;
            // Parameters of what ended here.
            if matches!(frame.block, Block::File | Block::Database | Block::Htn) {
                self.variables.truncate(frame.n_variables);
            }
        }
    }

    fn open(&mut self, i: usize, bracket: &'a str) {
        let Some(frame) = self.frames.last() else { return };
        let (outer, n_blocks, outer_variables) = (frame.block, frame.n_blocks, frame.n_variables);
        let head = self.head(i);
        let first = head.first().copied().unwrap_or("");
        let last = head.last().copied().unwrap_or("");
        let block = match bracket {
            "{" => braces(outer, first, head, n_blocks),
            "(" => match last {
                "SELECT" | "SELECTORDERED" | "SELECTONCE" => Block::Select,
                "FORALL" | "EXIST" => Block::Quantified {
                    has_effects: outer == Block::Effects,
                },
                _ if matches!(outer, Block::File | Block::Htn | Block::Database) => Block::Params,
                _ => Block::Value,
            },
            _ => Block::Value,
        };
        // The parameters were read before the brace of their task, and end with it.
        let is_item = matches!(outer, Block::File | Block::Htn | Block::Database) && bracket == "{";
        let n_variables = if is_item { outer_variables } else { self.variables.len() };
        self.frames.push(Frame {
            block,
            bracket: match bracket {
                "{" => "}",
                "(" => ")",
                _ => "]",
            },
            begin: i + 1,
            n_blocks: 0,
            n_variables,
        });
    }

    fn close(&mut self, i: usize, bracket: &str) {
        // A brace closes whatever was left open within it; other marks without a partner are skipped.
        let Some(partner) = self.frames.iter().rposition(|f| f.bracket == bracket) else {
            return;
        };
        if bracket != "}" && partner + 1 != self.frames.len() {
            return;
        }
        let closed = self.frames.get(partner).map(|f| (f.block, f.n_variables));
        self.frames.truncate(partner);
        match closed {
            Some((Block::Params, _)) | None => {}
            Some((_, n_variables)) => self.variables.truncate(n_variables),
        }
        if bracket != "}" {
            return;
        }
        let first = self.head(i).first().copied().unwrap_or("");
        let Some(frame) = self.frames.last_mut() else { return };
        frame.n_blocks += 1;
        let goes_on = match frame.block {
            Block::Effects => first == "IF" && frame.n_blocks == 1,
            Block::Select | Block::Quantified { .. } | Block::Value | Block::Params => true,
            _ => false,
        };
        if !goes_on {
            self.end_statement(i + 1);
        }
    }

    /// Notes the variables that a word gives a name.
    fn word(&mut self, i: usize, token: &str) {
        let Some(frame) = self.frames.last() else { return };
        let head = self.head(i);
        match frame.block {
            Block::Params => {
                let after_comma = head.rsplit(|t| *t == ",").next().unwrap_or(&[]);
                let (is_set, ty) = match after_comma {
                    ["set", ty] => (true, *ty),
                    [ty] if *ty != "set" => (false, *ty),
                    _ => return,
                };
                let value = self.index.value_of(ty, is_set);
                self.variables.push((token.to_owned(), value));
            }
            Block::Quantified { .. } => {
                if let [ty] = head {
                    let value = self.index.value_of(ty, false);
                    self.variables.push((token.to_owned(), value));
                }
            }
            Block::Select if head.is_empty() => {
                let value = self.index.value_of(token, false);
                let outer = self.frames.len().checked_sub(2).and_then(|f| self.frames.get(f));
                let name = outer.and_then(|f| self.tokens.get(f.begin)).copied();
                if let (Some(name), Some(frame)) = (name, self.frames.last_mut()) {
                    self.variables.push((name.to_owned(), value));
                    // It lives on behind the parenthesis.
                    frame.n_variables += 1;
                }
            }
            _ => {}
        }
    }

    fn let_value(&self, value: &[&str]) -> Option<Value> {
        // A path from end to end: `A . sees ( O )` has a step less here than tokens.
        let path = path_before(value);
        let is_whole = path.first() == value.first();
        path_value(&path, &self.variables, self.index).filter(|_| is_whole)
    }

    fn bind_let(&mut self, i: usize) {
        let in_subtasks = self.frames.last().is_some_and(|f| f.block == Block::Subtasks);
        if let (true, ["let", name, "=", value @ ..]) = (in_subtasks, self.head(i)) {
            let bound = ((*name).to_owned(), self.let_value(value).unwrap_or(Value::Unknown));
            self.variables.push(bound);
        }
    }

    /// Returns the labels before the cursor in the block of subtasks around it.
    fn labels(&self) -> Vec<&'a str> {
        let is_subtasks = |f: &&Frame| f.block == Block::Subtasks;
        let Some(frame) = self.frames.last().filter(is_subtasks) else {
            return Vec::new();
        };
        // Back to the brace of the block: labels follow a `;`, a `}` or that brace.
        let mut found = Vec::new();
        let mut depth = 0_usize;
        for i in (0..frame.begin).rev() {
            match self.tokens.get(i).copied().unwrap_or("") {
                "}" | ")" | "]" => depth += 1,
                "{" if depth == 0 => break,
                "{" | "(" | "[" => depth = depth.saturating_sub(1),
                ":" if depth == 0 => found.extend(i.checked_sub(1).and_then(|l| self.tokens.get(l)).copied()),
                _ => {}
            }
        }
        found.reverse();
        found
    }
}

/// Returns what a `{` opens.
fn braces(outer: Block, first: &str, head: &[&str], n_blocks: usize) -> Block {
    match outer {
        Block::File | Block::Htn | Block::Database => match (first, head.get(1).copied()) {
            ("factdatabase" | "factDatabase", _) => Block::Database,
            ("HTN", _) => Block::Htn,
            ("define", Some("entityAttributes")) => Block::Attributes,
            ("action" | "operator", _) => Block::Action,
            ("method" | "task", _) => Block::Method,
            ("function", _) => Block::Value,
            ("fact", _) => Block::Tests,
            ("settings", _) => Block::Settings,
            ("social", _) => Block::Social,
            _ => Block::Opaque,
        },
        Block::Action => match first {
            "preconditions" | "constraints" => Block::Tests,
            "effects" => Block::Effects,
            "projects" => Block::Projects,
            "cost" | "duration" | "alternatives" => Block::Value,
            _ => Block::Opaque,
        },
        Block::Method => match first {
            "goal" | "empty" => Block::Tests,
            "" => Block::Decomposition,
            _ => Block::Opaque,
        },
        Block::Social => match head.get(1).copied() {
            Some("sequence") => Block::Sequence,
            _ => Block::Tests,
        },
        Block::Decomposition => match first {
            "preconditions" => Block::Tests,
            "subtasks" => Block::Subtasks,
            _ => Block::Opaque,
        },
        Block::Tests | Block::Select => Block::Tests,
        Block::Effects if first == "IF" && n_blocks == 0 => Block::Tests,
        Block::Effects => Block::Effects,
        Block::Quantified { has_effects: true } if n_blocks > 0 => Block::Effects,
        Block::Quantified { .. } => Block::Tests,
        Block::Attributes
        | Block::Params
        | Block::Subtasks
        | Block::Projects
        | Block::Settings
        | Block::Sequence
        | Block::Value
        | Block::Opaque => Block::Opaque,
    }
}

/// Returns the path at the end of the tokens without the arguments of its steps: `A . sees . at` of `x == A . sees ( O ) . at`.
pub(super) fn path_before<'t>(tokens: &[&'t str]) -> Vec<&'t str> {
    let mut path = Vec::new();
    let mut rest = tokens;
    while let Some((last, mut before)) = rest.split_last() {
        let mut word = *last;
        if word == ")" {
            let Some(open) = opening(rest) else { break };
            let Some((name, more)) = rest.get(..open).and_then(<[_]>::split_last) else {
                break;
            };
            // A call of a function, or an expression in brackets.
            if more.last() != Some(&".") {
                path.push(word);
                break;
            }
            (word, before) = (name, more);
        }
        path.push(word);
        match before.split_last() {
            Some((&".", more)) => {
                path.push(".");
                rest = more;
            }
            _ => break,
        }
    }
    path.reverse();
    path
}

/// Returns where the bracket opens that the last token closes.
fn opening(tokens: &[&str]) -> Option<usize> {
    let mut depth = 0_usize;
    for (i, token) in tokens.iter().enumerate().rev() {
        match *token {
            ")" => depth += 1,
            "(" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return Some(i);
        }
    }
    None
}

/// Returns what the tokens `A . holding . isAt` hold; `None` if they are no path or it is not known.
pub(super) fn path_value(tokens: &[&str], variables: &[(String, Value)], index: &Index) -> Option<Value> {
    let (root, steps) = tokens.split_first()?;
    let variable = variables.iter().rev().find(|(name, _)| name == root).map(|v| v.1);
    let entity = || index.entity_named(root).map(|e| index.get(e).value);
    let mut value = variable.or_else(entity)?;
    for step in steps.chunks(2) {
        let [".", name] = step else { return None };
        let Value::Entity(ty) = value else { return None };
        value = index.get(index.attribute_of(ty, name)?).value;
    }
    Some(value)
}
