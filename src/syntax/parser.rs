//! Text to AST by the grammar of `grammar/hatp.pest`, and syntax errors in the language's own words.
//!
//! Never fails: what can't be read is left out and reported. pest stops at the first error; [`recover`] finds the others.
//! Knows no names and no types.

mod belief;
mod build;
mod expected;
mod geometric;
mod parts;
mod recover;
mod rules;

use pest::Parser as _;

use super::ast;
use super::layout::{Compact, Layout, MAX_DEPTH, MAX_TOKENS, layout};
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
        unread: ast::Unread::default(),
        span: Span::new(file, 0, text.len()),
    };
    let mut problems = Problems::default();
    let layout = layout(text);
    let place = match Place::new(file, 0, "the end of the file", text, &layout) {
        Ok(place) => place,
        Err(problem) => {
            problems.push(*problem);
            out.unread.anything = true;
            return (out, problems);
        }
    };
    match HatpParser::parse(Rule::file, &place.compact.text) {
        Ok(pairs) => {
            out.items = build::Builder::new(&place, 0, &mut problems).items(pairs);
            out.unread.anything = !problems.0.iter().all(is_mended);
            (out, problems)
        }
        Err(error) => {
            (out.items, out.unread) = recover::items(&error, &place, &mut problems);
            (out, problems.sorted())
        }
    }
}

/// Returns the tasks that `text` is, `Get(A, X); Sit(A) > 1`, one or more; `offset` is where it starts in `file` [bytes].
pub fn parse_network(file: FileId, offset: usize, text: &str) -> (Option<Vec<ast::Subtask>>, Problems) {
    let mut problems = Problems::default();
    let layout = layout(text);
    let place = match Place::new(file, offset, "the end", text, &layout) {
        Ok(place) => place,
        Err(problem) => {
            problems.push(*problem);
            return (None, problems);
        }
    };
    match HatpParser::parse(Rule::network, &place.compact.text) {
        Ok(pairs) => {
            let tasks = build::Builder::new(&place, 0, &mut problems).network(pairs);
            (Some(tasks), problems)
        }
        Err(error) => {
            problems.push(expected::expected(&error, 0, &place));
            (None, problems)
        }
    }
}

/// Says whether what was read is what must have been meant, all of it.
fn is_mended(problem: &Problem) -> bool {
    ["hatp::assign-in-test", "hatp::compare-in-effect", "hatp::null-spelling"].contains(&problem.code)
}

/// A text, where it lies, and what the grammar sees of it.
struct Place<'t> {
    file: FileId,
    /// Of the text in its file [bytes].
    offset: usize,
    /// What a message calls the text's end.
    end: &'static str,
    text: &'t str,
    layout: &'t Layout,
    compact: Compact,
}

impl<'t> Place<'t> {
    /// Returns what keeps the grammar from being tried at all, if anything.
    fn new(
        file: FileId,
        offset: usize,
        end: &'static str,
        text: &'t str,
        layout: &'t Layout,
    ) -> Result<Self, Box<Problem>> {
        let span = |start, end| Span::new(file, offset + start, offset + end);
        if let Some(problem) = unreadable(layout, span) {
            return Err(Box::new(problem));
        }
        Ok(Place {
            file,
            offset,
            end,
            text,
            layout,
            compact: layout.compact(text),
        })
    }

    /// Returns the span of `start..end` of the text.
    fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.file, self.offset + start, self.offset + end)
    }

    /// Returns the span of `start..end` of what the grammar sees.
    fn span_of(&self, start: usize, end: usize) -> Span {
        self.span(self.compact.origin(start), self.compact.origin_of_end(end))
    }
}

/// Says what keeps the grammar from being tried at all.
fn unreadable(layout: &Layout, span: impl Fn(usize, usize) -> Span) -> Option<Problem> {
    if let Some((start, end)) = layout.too_deep {
        let message = format!("brackets nest deeper than {MAX_DEPTH}");
        let problem = Problem::error("hatp::too-large", message, span(start, end), "one too many");
        return Some(problem.help("name parts of it with `let`, a function or a method of their own"));
    }
    if layout.tokens.len() > MAX_TOKENS {
        let (start, end) = layout.tokens.get(MAX_TOKENS).copied().unwrap_or_default();
        let message = format!("more than {MAX_TOKENS} words and marks in one file");
        let problem = Problem::error("hatp::too-large", message, span(start, end), "one too many");
        return Some(problem.help("divide it into several files"));
    }
    if let Some(start) = layout.open_comment {
        let span = span(start, start + 2);
        return Some(
            Problem::error("hatp::syntax", "a comment is not closed", span, "opened here").help("end it with `*/`"),
        );
    }
    if let Some(start) = layout.open_string {
        let span = span(start, start + 1);
        return Some(
            Problem::error("hatp::syntax", "a string is not closed", span, "opened here")
                .help("end it with `\"` on the same line"),
        );
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::words::word;
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
    fn a_deleted_parenthesis_is_missed_at_the_end_of_the_token_before() {
        let layout = layout(DOMAIN);
        let mut n_missed = 0;
        for mark in layout.tokens.iter().copied().filter(|t| &DOMAIN[t.0..t.1] == ")") {
            let (text, end) = without(mark, &layout);
            let (_, problems) = parse(FILE, &text);
            assert_eq!(problems.0.len(), 1, "{problems:?}");
            // `f(a + b` could go on after `b`; nothing else could follow.
            assert_eq!(error_at(&text), Some(end), "{problems:?}");
            assert!(problems.0[0].message.contains("`)`"), "{problems:?}");
            n_missed += 1;
        }
        assert!(n_missed > 10, "{n_missed}");
    }

    /// Names of rules that no user should see: those that are no English words.
    fn internal_names() -> Vec<String> {
        let names = Rule::all_rules().iter().map(|r| format!("{r:?}"));
        let is_internal =
            |n: &String| n.contains('_') || ["negated", "operand", "soup", "EOI", "rbrace"].contains(&n.as_str());
        names.filter(is_internal).collect()
    }

    #[test]
    fn no_message_names_a_rule() {
        let names = internal_names();
        assert!(names.len() > 60);
        let layout = layout(DOMAIN);
        for token in &layout.tokens {
            for other in ["", "x", ";", "}", "NULL", "é"] {
                let text = format!("{}{other}{}", &DOMAIN[..token.0], &DOMAIN[token.1..]);
                for problem in parse(FILE, &text).1.0 {
                    let labels = problem.primary.iter().map(|l| &l.text);
                    for shown in labels.chain([&problem.message]).chain(&problem.help) {
                        assert!(!names.iter().any(|n| shown.contains(n.as_str())), "{shown}");
                        assert!(!shown.contains("something else"), "{shown} for `{other}` at {token:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn one_wrong_token_is_one_error_or_two() {
        // A forgotten `;` may join two statements, a wrong bracket may end a block; no more follows from one slip.
        let layout = layout(DOMAIN);
        for token in &layout.tokens {
            for other in ["", ";", "5"] {
                let text = format!("{}{other}{}", &DOMAIN[..token.0], &DOMAIN[token.1..]);
                let (_, problems) = parse(FILE, &text);
                let n_errors = problems.0.len();
                assert!(
                    n_errors <= 2,
                    "`{other}` for `{}`: {problems:#?}",
                    &DOMAIN[token.0..token.1]
                );
            }
        }
    }

    #[test]
    fn every_rule_has_a_word_without_its_own_name() {
        let names = internal_names();
        for word in Rule::all_rules().iter().filter_map(|r| word(*r)) {
            assert!(!names.iter().any(|n| word.contains(n.as_str())), "{word}");
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
            let (_, _) = parse_network(FILE, 3, &text);
        }

        #[test]
        fn any_text_is_answered(text in "\\PC*") {
            let (_, _) = parse(FILE, &text);
        }
    }
}
