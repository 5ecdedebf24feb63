//! The errors of a text after its first: pest stops there, so smaller and smaller parts are read alone.
//!
//! The text is cut where items begin (rule `pieces`). A faulty item whose brackets are in order is cut into its clauses,
//! those into their statements. Each smallest faulty part has one error; what follows from it has none.

use std::ops::Range;

use pest::Parser as _;
use pest::error::Error;

use super::build::Builder;
use super::expected::{expected, group, location, misspelt_item};
use super::{HatpParser, Place, Rule, is_mended};
use crate::diag::Problems;
use crate::syntax::ast::{Item, Unread};
use crate::syntax::keywords::Group;

/// Returns the items without errors and what the others may declare, and adds their errors; `whole` is what pest said of all.
pub(super) fn items(whole: &Error<Rule>, place: &Place<'_>, problems: &mut Problems) -> (Vec<Item>, Unread) {
    let mut items = Vec::new();
    let mut unread = Unread::default();
    let pieces = HatpParser::parse(Rule::pieces, &place.compact.text);
    for piece in pieces.into_iter().flatten().flat_map(|p| p.into_inner()) {
        if !matches!(piece.as_rule(), Rule::piece | Rule::stray) {
            continue;
        }
        let start = piece.as_span().start();
        let error = match HatpParser::parse(Rule::lone, piece.as_str()) {
            Ok(pairs) => {
                let n_before = problems.0.len();
                items.extend(Builder::new(place, start, problems).items(pairs));
                unread.anything |= !problems.0.iter().skip(n_before).all(is_mended);
                continue;
            }
            Err(error) => error,
        };
        let token = |at| place.compact.starts.partition_point(|s| *s < at);
        let n_before = problems.0.len();
        // Items behind one whose first word is misspelt are in its piece.
        for chunk in item_chunks(token(start)..token(piece.as_span().end()), place) {
            let from = place.compact.starts[chunk.start];
            let is_item = group(text(chunk.start, place)) == Some(Group::Declaration);
            // After an error, what begins with another word may have lost the block that it stood in.
            let is_sure = is_item || problems.0.len() == n_before;
            match HatpParser::parse(Rule::lone, part_text(&chunk, place)) {
                Ok(pairs) if is_sure => {
                    let n_before = problems.0.len();
                    items.extend(Builder::new(place, from, problems).items(pairs));
                    unread.anything |= !problems.0.iter().skip(n_before).all(is_mended);
                }
                Err(own) if is_sure => {
                    unread.extend(&declared_in(&chunk, place));
                    errors(&own, from, chunk, place, problems);
                }
                Err(own) => {
                    unread.anything = true;
                    problems.0.extend(misspelt_item(&own, from, place));
                }
                Ok(_) => unread.anything = true,
            }
        }
        if problems.0.len() == n_before {
            unread.anything = true;
            problems.push(expected(&error, start, place));
        }
    }
    if !problems.has_errors() {
        // Every piece is well; the blocks around them are not.
        problems.push(expected(whole, 0, place));
    }
    (items, unread)
}

/// Returns what a faulty part, a range of tokens, may declare.
fn declared_in(part: &Range<usize>, place: &Place<'_>) -> Unread {
    let mut unread = Unread::default();
    let open = part.clone().find(|i| text(*i, place) == "{");
    // Otherwise it may have swallowed what comes after it.
    let is_one = open.and_then(|open| partner(open, part.end, place)).is_some();
    match text(part.start, place) {
        "action" | "operator" | "method" | "task" if is_one => unread.tasks = true,
        "function" | "fact" | "request" | "geometric" if is_one => unread.functions = true,
        "settings" | "social" if is_one => {}
        "define" if is_one && text(part.start + 1, place) == "entityAttributes" => {
            unread.attributes_of.push(text(part.start + 2, place).to_owned());
        }
        _ => unread.anything = true,
    }
    unread
}

/// Cuts a piece into items and openings of blocks.
fn item_chunks(piece: Range<usize>, place: &Place<'_>) -> Vec<Range<usize>> {
    let opens_block =
        |i: usize| text(i + 1, place) == "{" && matches!(text(i, place), "HTN" | "factdatabase" | "factDatabase");
    let mut out = Vec::new();
    let (mut start, mut i) = (piece.start, piece.start);
    while i < piece.end {
        let mark = text(i, place);
        if matches!(mark, "{" | "(" | "[") && !(i == start + 1 && opens_block(start)) {
            let Some(close) = partner(i, piece.end, place) else {
                break;
            };
            i = close;
        }
        i += 1;
        // What does not begin with a word goes on with what came before.
        let next = if i < piece.end { text(i, place) } else { "" };
        let is_word = next.starts_with(|c: char| c.is_ascii_alphabetic());
        if matches!(mark, ";" | "{" | "}") && (is_word || next.is_empty()) {
            out.push(start..i);
            start = i;
        }
    }
    if start < piece.end {
        out.push(start..piece.end);
    }
    out
}

/// Adds the errors of a part, a range of tokens, of which pest said `error`; `start` is where it starts [bytes].
fn errors(error: &Error<Rule>, start: usize, part: Range<usize>, place: &Place<'_>, problems: &mut Problems) {
    let at = location(error, start);
    let n_before = problems.0.len();
    if let Some((rule, body)) = body(part, place) {
        let begin = place.compact.starts[body.start];
        let of_blocks = matches!(rule, Rule::lone_clause | Rule::lone_part | Rule::lone_block);
        for chunk in chunks(rule, body, place) {
            let from = place.compact.starts[chunk.start];
            let has_block = chunk.clone().any(|i| text(i, place) == "{");
            let first = text(chunk.start, place);
            let fits = match rule {
                Rule::lone_part => !matches!(first, "preconditions" | "subtasks"),
                _ => first != "{",
            };
            if of_blocks && !(has_block && fits) && problems.0.len() > n_before {
                // What stands between blocks lost its own to the error before.
                continue;
            }
            let Err(own) = HatpParser::parse(rule, part_text(&chunk, place)) else {
                continue;
            };
            // The same error seen from outside knows better what may follow.
            if location(&own, from) == at {
                errors(error, start, chunk.clone(), place, problems);
            } else {
                errors(&own, from, chunk.clone(), place, problems);
            }
            // A clause among statements, or nothing before a `;`: a brace is missing, and what follows is out of place.
            if !of_blocks
                && (first == ";" || text(chunk.start + 1, place) == "{" && group(first) == Some(Group::Clause))
            {
                break;
            }
        }
        if at >= begin && problems.0.len() > n_before {
            return;
        }
    }
    problems.push(expected(error, start, place));
}

/// Returns what pest sees of a part.
fn part_text<'t>(part: &Range<usize>, place: &'t Place<'_>) -> &'t str {
    let compact = &place.compact;
    let end = compact.starts.get(part.end).copied().unwrap_or(compact.text.len());
    compact.text[compact.starts[part.start]..end].trim_end()
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
        "social" => Rule::lone_rule,
        "geometric" => Rule::lone_geometric_part,
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
