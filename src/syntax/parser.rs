//! Text to AST by the grammar of `grammar/hatp.pest`, and syntax errors in the language's own words.
//!
//! Never fails: what can't be read is left out and reported. pest stops at the first error, so after one the text is cut
//! where items begin (rule `pieces`) and each piece is read alone; every faulty item then has its own error.
//! Knows no names and no types.

mod build;

use pest::Parser as _;
use pest::error::{Error, ErrorVariant, InputLocation};

use super::ast;
use super::layout::{Layout, MAX_DEPTH, layout};
use super::words::word;
use crate::diag::{Problem, Problems};
use crate::source::{FileId, Span};

// Rule names are in `words`, for users; the derived type needs no documentation of its own.
#[derive(Debug, pest_derive::Parser)]
#[grammar = "../grammar/hatp.pest"]
struct HatpParser;

/// Returns what `text` says, and its syntax errors; items with errors are left out.
///
/// Spans are byte ranges of `text`.
pub fn parse(file: FileId, text: &str) -> (ast::File, Problems) {
    let mut out = ast::File {
        items: Vec::new(),
        span: Span::new(file, 0, text.len()),
    };
    let place = Place {
        file,
        offset: 0,
        end: "the end of the file",
    };
    let mut problems = Problems::default();
    let layout = layout(text);
    if let Some(problem) = unreadable(&layout, &place) {
        problems.push(problem);
        return (out, problems);
    }
    let whole = match HatpParser::parse(Rule::file, text) {
        Ok(pairs) => {
            out.items = build::Builder::new(file, 0, &mut problems).items(pairs);
            return (out, problems);
        }
        Err(error) => error,
    };
    if let Ok(pairs) = HatpParser::parse(Rule::pieces, text) {
        for piece in pairs.flat_map(|p| p.into_inner()) {
            if !matches!(piece.as_rule(), Rule::piece | Rule::stray) {
                continue;
            }
            let start = piece.as_span().start();
            match HatpParser::parse(Rule::lone, piece.as_str()) {
                Ok(pairs) => {
                    let items = build::Builder::new(file, start, &mut problems).items(pairs);
                    out.items.extend(items);
                }
                Err(error) => problems.push(expected(&error, start, text, &layout, &place)),
            }
        }
    }
    if !problems.has_errors() {
        // Every piece is well; the blocks around them are not.
        problems.push(expected(&whole, 0, text, &layout, &place));
    }
    (out, problems.sorted())
}

/// Returns the call that `text` is, `MoveObjs(PR2, [RED_CUBE])`; `offset` is where it starts in `file` [bytes].
pub fn parse_call(file: FileId, offset: usize, text: &str) -> (Option<ast::Call>, Problems) {
    let place = Place {
        file,
        offset,
        end: "the end",
    };
    let mut problems = Problems::default();
    let layout = layout(text);
    if let Some(problem) = unreadable(&layout, &place) {
        problems.push(problem);
        return (None, problems);
    }
    match HatpParser::parse(Rule::goal_call, text) {
        Ok(pairs) => {
            let call = build::Builder::new(file, offset, &mut problems).goal_call(pairs);
            (call, problems)
        }
        Err(error) => {
            problems.push(expected(&error, 0, text, &layout, &place));
            (None, problems)
        }
    }
}

/// Where a text lies.
struct Place {
    file: FileId,
    /// Of the text in its file [bytes].
    offset: usize,
    /// What a message calls the text's end.
    end: &'static str,
}

impl Place {
    fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.file, self.offset + start, self.offset + end)
    }
}

/// Says what keeps the grammar from being tried at all.
fn unreadable(layout: &Layout, place: &Place) -> Option<Problem> {
    if let Some((start, end)) = layout.too_deep {
        let message = format!("brackets nest deeper than {MAX_DEPTH}");
        let problem = Problem::error("hatp::too-deep", message, place.span(start, end), "one too many");
        return Some(problem.help("name parts of it with `let`, a function or a method of their own"));
    }
    if let Some(start) = layout.open_comment {
        let span = place.span(start, start + 2);
        return Some(
            Problem::error("hatp::syntax", "a comment is not closed", span, "opened here").help("end it with `*/`"),
        );
    }
    if let Some(start) = layout.open_string {
        let span = place.span(start, start + 1);
        return Some(
            Problem::error("hatp::syntax", "a string is not closed", span, "opened here")
                .help("end it with `\"` on the same line"),
        );
    }
    None
}

/// Turns pest's error about a part of `text` that starts at `start` into a problem.
fn expected(error: &Error<Rule>, start: usize, text: &str, layout: &Layout, place: &Place) -> Problem {
    let at = start
        + match error.location {
            InputLocation::Pos(at) => at,
            InputLocation::Span((at, _)) => at,
        };
    let rules: &[Rule] = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => positives,
        ErrorVariant::CustomError { .. } => &[],
    };
    let mut words: Vec<&'static str> = Vec::new();
    for word in rules.iter().filter_map(|r| word(*r)) {
        if !words.contains(&word) {
            words.push(word);
        }
    }
    let (before, next) = layout.around(at);
    let found = next.and_then(|(s, e)| text.get(s..e));
    let new_line = match (before, next) {
        (Some(b), Some(n)) => text.get(b.1..n.0).is_some_and(|gap| gap.contains('\n')),
        _ => true,
    };
    let has = |w: &str| words.contains(&w);
    // A mark that ends something is missed where the text before it ends, not where the next word stands.
    let opens_block = found.is_some_and(|f| OPENERS.contains(&f));
    let missing = if has("`;`") && (new_line || opens_block || found == Some("}")) {
        Some("`;`")
    } else if has("`}`") && (new_line || opens_block) {
        Some("`}`")
    } else {
        None
    };
    if let Some(mark) = missing {
        words = vec![mark];
    } else if words.len() > 1 {
        // What may always follow a name or a value says little.
        words.retain(|w| *w != "`.`");
    }
    let ends_before = missing.is_some() || ["`;`", "`)`", "`,`", "`]`"].iter().any(|m| words.contains(m));
    let span = match (before, next) {
        (Some((_, end)), _) if ends_before => place.span(end, end),
        (_, Some((s, e))) => place.span(s, e),
        (Some((_, end)), None) => place.span(end, end),
        (None, None) => place.span(0, 0),
    };
    let list = listed(&words);
    let message = match found {
        Some(found) => format!("expected {list}, found `{}`", shortened(found)),
        None => format!("expected {list}, found {}", place.end),
    };
    let mut problem = Problem::error("hatp::syntax", message, span, format!("expected {list}"));
    if next.is_none() {
        if let Some((s, e)) = layout.unclosed.last() {
            problem = problem.note(place.span(*s, *e), "this is not closed");
        }
    }
    problem
}

/// Words that begin a block: where one stands, the block before it should have ended.
const OPENERS: [&str; 20] = [
    "action",
    "operator",
    "method",
    "task",
    "function",
    "HTN",
    "factdatabase",
    "factDatabase",
    "define",
    "preconditions",
    "effects",
    "subtasks",
    "goal",
    "empty",
    "cost",
    "duration",
    "projects",
    "constraints",
    "alternatives",
    "{",
];

/// Returns `a`, `a or b`, `a, b or c`.
fn listed(words: &[&str]) -> String {
    match words {
        [] => "something else".into(),
        [only] => (*only).into(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// Returns at most 30 characters of a token.
fn shortened(token: &str) -> String {
    let mut short: String = token.chars().take(30).collect();
    if short.len() < token.len() {
        short.push_str("...");
    }
    short
}
