//! Text to AST by the grammar of `grammar/hatp.pest`, and syntax errors in the language's own words.
//!
//! Never fails: what can't be read is left out and reported. pest stops at the first error, so after one the text is cut
//! where items begin (rule `pieces`) and each piece is read alone; every faulty item then has its own error.
//! Knows no names and no types.

mod build;
mod parts;

use pest::Parser as _;
use pest::error::{Error, ErrorVariant, InputLocation};

use super::ast;
use super::layout::{Layout, MAX_DEPTH, MAX_TOKENS, layout};
use super::words::word;
use crate::diag::suggest::nearest;
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
        let problem = Problem::error("hatp::too-large", message, place.span(start, end), "one too many");
        return Some(problem.help("name parts of it with `let`, a function or a method of their own"));
    }
    if layout.tokens.len() > MAX_TOKENS {
        let (start, end) = layout.tokens.get(MAX_TOKENS).copied().unwrap_or_default();
        let message = format!("more than {MAX_TOKENS} words and marks in one file");
        let problem = Problem::error("hatp::too-large", message, place.span(start, end), "one too many");
        return Some(problem.help("divide it into several files"));
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
    let of_place = |w| if w == "the end of the file" { place.end } else { w };
    for word in rules.iter().filter_map(|r| word(*r)).map(of_place) {
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
    let begins_item = found.is_none_or(|f| ITEM_WORDS.contains(&f));
    let begins_clause = found.is_some_and(|f| CLAUSE_WORDS.contains(&f));
    let in_clause = ["a test", "an effect", "a subtask", "an operator"]
        .iter()
        .any(|w| has(w));
    let missing = if has("`;`") && (new_line || begins_item || begins_clause || found == Some("}")) {
        Some("`;`")
    } else if has("`}`") && (begins_item || begins_clause && in_clause) {
        Some("`}`")
    } else {
        None
    };
    if let Some(mark) = missing {
        words = vec![mark];
    } else if words.len() > 1 {
        // What may always follow a name or a value says little.
        let after_value = has("an operator");
        words.retain(|w| *w != "`.`" && !(after_value && *w == "`(`"));
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
    let label = if words.len() > 3 {
        "not expected here".into()
    } else {
        format!("expected {list}")
    };
    let mut problem = Problem::error("hatp::syntax", message, span, label);
    let word_before = before.and_then(|(s, e)| text.get(s..e));
    let help = found.and_then(|f| foreign(f).map(str::to_owned));
    // Where a mark is expected, a keyword before it may have passed for a name.
    let is_keyword = |w: &&&str| w.strip_prefix('`').is_some_and(|w| w.starts_with(char::is_alphabetic));
    let before_is = || word_before.and_then(|w| misspelt(w, missing.is_some()));
    let found_is = || found.and_then(|w| misspelt(w, missing.is_some()));
    let near = if words.iter().any(|w| is_keyword(&w)) {
        found_is()
            .filter(|near| words.contains(&format!("`{near}`").as_str()))
            .or_else(before_is)
    } else {
        before_is().or_else(found_is)
    };
    problem = problem.maybe_help(help.or_else(|| near.map(|near| format!("did you mean `{near}`?"))));
    if let (None, Some((s, e))) = (next, layout.unclosed.last()) {
        problem = problem.note(place.span(*s, *e), "this is not closed");
    }
    problem
}

/// Words that begin an item: where one stands, every block before it should have ended.
const ITEM_WORDS: [&str; 9] = [
    "action",
    "operator",
    "method",
    "task",
    "function",
    "HTN",
    "factdatabase",
    "factDatabase",
    "define",
];

/// What begins a clause or a decomposition, or may follow one.
const CLAUSE_WORDS: [&str; 12] = [
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
    ";",
];

/// The other words that a slip of the pen may have meant.
const OTHER_WORDS: [&str; 15] = [
    "entityType",
    "entityAttributes",
    "static",
    "dynamic",
    "atom",
    "SELECT",
    "SELECTORDERED",
    "SELECTONCE",
    "FORALL",
    "EXIST",
    "OR",
    "NOT",
    "IF",
    "ELSE",
    "after",
];

/// Returns how to say what other languages say with this mark.
fn foreign(found: &str) -> Option<&'static str> {
    match found {
        "&" => Some("tests simply follow one another; each ends with `;`"),
        "|" => Some("write `OR { ... } { ... }`"),
        "!" => Some("write `NOT { ... };`"),
        _ => None,
    }
}

/// Returns the keyword that the word was meant to be: nearly one, or, if `strict`, one in other capitals.
fn misspelt(found: &str, strict: bool) -> Option<&'static str> {
    let is_word = found.len() > 1 && found.chars().all(|c| c.is_ascii_alphabetic());
    let keywords: Vec<&'static str> = [ITEM_WORDS.as_slice(), &CLAUSE_WORDS, &OTHER_WORDS].concat();
    if !is_word || keywords.contains(&found) {
        return None;
    }
    let near = nearest(found, keywords.iter().copied())?;
    let same_letters = near.eq_ignore_ascii_case(found);
    (same_letters || !strict && found.len() > 3).then_some(near)
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FILE: FileId = FileId(0);
    const DOMAIN: &str = include_str!("../../domains/three_objects.hatp");

    /// Says where the first error is.
    fn error_at(text: &str) -> Option<usize> {
        let (_, problems) = parse(FILE, text);
        problems.0.first()?.primary.as_ref().map(|l| l.span.start as usize)
    }

    /// Returns the domain without the mark at `at`, and the end of the token before it.
    fn without(at: (usize, usize), layout: &Layout) -> (String, usize) {
        let text = format!("{}{}", &DOMAIN[..at.0], &DOMAIN[at.1..]);
        (text, layout.around(at.0).0.map_or(0, |t| t.1))
    }

    #[test]
    fn a_deleted_semicolon_is_missed_at_the_end_of_the_token_before() {
        let layout = layout(DOMAIN);
        let mut n_missed = 0;
        for pair in layout.tokens.windows(2) {
            let [before, mark] = [pair[0], pair[1]];
            if &DOMAIN[mark.0..mark.1] != ";" {
                continue;
            }
            let (text, end) = without(mark, &layout);
            if &DOMAIN[before.0..before.1] == "}" {
                assert_eq!(error_at(&text), None, "a `;` after a brace is optional");
            } else {
                assert_eq!(error_at(&text), Some(end), "{}", &text[end.saturating_sub(40)..end]);
                n_missed += 1;
            }
        }
        assert!(n_missed > 20, "{n_missed}");
    }

    #[test]
    fn a_deleted_brace_is_missed_where_a_token_ends_and_not_before_it_stood() {
        let layout = layout(DOMAIN);
        for mark in layout.tokens.iter().copied().filter(|t| &DOMAIN[t.0..t.1] == "}") {
            let (text, end) = without(mark, &layout);
            let at = error_at(&text).expect("an error");
            assert!(at >= end, "{at} {end}");
            let (_, problems) = parse(FILE, &text);
            assert_eq!(problems.0.len(), 1, "{problems:?}");
            assert!(problems.0[0].message.contains("`}`"), "{problems:?}");
        }
    }

    #[test]
    fn ten_megabytes_of_brackets_are_answered() {
        for text in [
            "(".repeat(10_000_000),
            "{}".repeat(5_000_000),
            "action A(".repeat(1_000_000),
        ] {
            let (_, problems) = parse(FILE, &text);
            assert!(problems.0.iter().any(|p| p.code == "hatp::too-large"));
        }
    }

    #[test]
    fn every_rule_that_can_be_expected_has_a_word() {
        // Names of rules have an underscore or are glued words; words for users are in backticks or plain English.
        for rule in Rule::all_rules() {
            if let Some(word) = word(*rule) {
                assert!(!word.contains('_'), "{rule:?}: {word}");
            }
        }
    }

    /// Words and marks of the language in any order, and some that are not of it.
    fn soup() -> impl Strategy<Value = String> {
        let words = DOMAIN.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let marks = "{ } ( ) [ ] ; , . : = == != <<= =>> !>> >> >= <= < > + - * / \" /* */ // é \u{FEFF} 1 2.5 1e9 \"a\" OR \
                     NOT IF ELSE FORALL EXIST SELECT SELECTORDERED let after NULL null true function fact geometric import";
        let all = words
            .into_iter()
            .chain(marks.split_whitespace().map(str::to_owned))
            .collect::<Vec<_>>();
        prop::collection::vec(
            (prop::sample::select(all), prop::sample::select(vec![" ", "\n", ""])),
            0..80,
        )
        .prop_map(|parts| parts.into_iter().map(|(word, gap)| word + gap).collect())
    }

    proptest! {
        #[test]
        fn any_soup_is_answered_with_spans_inside_of_it(text in soup()) {
            let (_, problems) = parse(FILE, &text);
            for problem in &problems.0 {
                for label in problem.primary.iter().chain(&problem.notes) {
                    prop_assert!(label.span.start <= label.span.end && label.span.end as usize <= text.len());
                    prop_assert!(text.get(label.span.range()).is_some());
                }
            }
            let (_, _) = parse_call(FILE, 3, &text);
        }

        #[test]
        fn any_text_is_answered(text in "\\PC*") {
            let (_, _) = parse(FILE, &text);
        }
    }
}
