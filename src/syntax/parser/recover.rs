//! The errors of a text after its first: pest stops there, so smaller and smaller parts are read alone.
//!
//! The text is cut where items begin (rule `pieces`). A faulty item whose brackets are in order is cut into its clauses,
//! those into their statements. Each smallest faulty part has one error; what follows from it has none.

use std::ops::Range;

use pest::Parser as _;
use pest::error::Error;

use super::build::Builder;
use super::expected::{expected, location};
use super::{HatpParser, Place, Rule};
use crate::diag::Problems;
use crate::syntax::ast::Item;

/// Returns the items without errors, and adds the errors of the others; `whole` is what pest said of all.
pub(super) fn items(whole: &Error<Rule>, place: &Place<'_>, problems: &mut Problems) -> Vec<Item> {
    let mut items = Vec::new();
    let pieces = HatpParser::parse(Rule::pieces, &place.compact.text);
    for piece in pieces.into_iter().flatten().flat_map(|p| p.into_inner()) {
        if !matches!(piece.as_rule(), Rule::piece | Rule::stray) {
            continue;
        }
        let start = piece.as_span().start();
        match HatpParser::parse(Rule::lone, piece.as_str()) {
            Ok(pairs) => items.extend(Builder::new(place, start, problems).items(pairs)),
            Err(error) => {
                let starts = &place.compact.starts;
                let token = |at| starts.partition_point(|s| *s < at);
                let part = token(start)..token(piece.as_span().end());
                errors(&error, start, part, place, problems);
            }
        }
    }
    if !problems.has_errors() {
        // Every piece is well; the blocks around them are not.
        problems.push(expected(whole, 0, place));
    }
    items
}

/// Adds the errors of a part, a range of tokens, of which pest said `error`; `start` is where it starts [bytes].
fn errors(error: &Error<Rule>, start: usize, part: Range<usize>, place: &Place<'_>, problems: &mut Problems) {
    let at = location(error, start);
    let n_before = problems.0.len();
    if let Some((rule, body)) = body(part, place) {
        let begin = place.compact.starts[body.start];
        for chunk in chunks(rule, body, place) {
            let from = place.compact.starts[chunk.start];
            let end = end_of(chunk.end - 1, place);
            let Err(own) = HatpParser::parse(rule, &place.compact.text[from..end]) else {
                continue;
            };
            // The same error seen from outside knows better what may follow.
            if location(&own, from) == at {
                errors(error, start, chunk, place, problems);
            } else {
                errors(&own, from, chunk, place, problems);
            }
        }
        if at >= begin && problems.0.len() > n_before {
            return;
        }
    }
    problems.push(expected(error, start, place));
}

/// Returns where a token ends [bytes of what pest sees].
fn end_of(token: usize, place: &Place<'_>) -> usize {
    let (start, end) = place.layout.tokens[token];
    place.compact.starts[token] + (end - start)
}

fn text<'t>(token: usize, place: &'t Place<'_>) -> &'t str {
    place.layout.tokens.get(token).map_or("", |t| &place.text[t.0..t.1])
}

/// Returns the tokens between the braces of an item or a clause, and the rule for what stands there; `None` if its brackets
/// are not in order, or it is nothing that could be cut.
fn body(part: Range<usize>, place: &Place<'_>) -> Option<(Rule, Range<usize>)> {
    let rule = match text(part.start, place) {
        "action" | "operator" => Rule::lone_clause,
        "method" | "task" => Rule::lone_part,
        "define" => Rule::lone_attribute,
        "settings" => Rule::lone_setting,
        "preconditions" | "constraints" | "goal" | "empty" | "fact" => Rule::lone_test,
        "effects" => Rule::lone_effect,
        "subtasks" => Rule::lone_step,
        "{" => Rule::lone_block,
        _ => return None,
    };
    let open = part.clone().find(|i| text(*i, place) == "{")?;
    let close = partner(open, part.end, place)?;
    (open + 1 < close).then_some((rule, open + 1..close))
}

/// Returns the closing bracket of an opening one, if all brackets between them are in order.
fn partner(open: usize, end: usize, place: &Place<'_>) -> Option<usize> {
    let mut closing = Vec::new();
    for i in open..end {
        match text(i, place) {
            "{" => closing.push("}"),
            "(" => closing.push(")"),
            "[" => closing.push("]"),
            mark @ ("}" | ")" | "]") => {
                if closing.pop() != Some(mark) {
                    return None;
                }
                if closing.is_empty() {
                    return Some(i);
                }
            }
            _ => {}
        }
    }
    None
}

/// Cuts what stands in braces, all brackets in order, into statements: each ends with its `;` or its block.
fn chunks(rule: Rule, body: Range<usize>, place: &Place<'_>) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let (mut start, mut i) = (body.start, body.start);
    while i < body.end {
        let mark = text(i, place);
        if matches!(mark, "{" | "(" | "[") {
            i = partner(i, body.end, place).unwrap_or(i);
        }
        i += 1;
        let next = if i < body.end { text(i, place) } else { "" };
        // Only decompositions begin with a brace; any other goes on with what came before, were it misspelt.
        let goes_on = next == ";" || next == "{" && rule != Rule::lone_part || next.eq_ignore_ascii_case("else");
        let is_end = mark == ";" || mark == "{" && !goes_on;
        if is_end {
            out.push(start..i);
            start = i;
        }
    }
    if start < body.end {
        out.push(start..body.end);
    }
    out
}
