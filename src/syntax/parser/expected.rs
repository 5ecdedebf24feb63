//! pest's errors as problems in the language's own words: what was expected, what was found, what may have been meant.

use pest::error::{Error, ErrorVariant, InputLocation};

use super::{Place, Rule};
use crate::diag::Problem;
use crate::diag::suggest::nearest;
use crate::syntax::words::word;

/// Returns where the error is in a text of which pest saw the part that starts at `start` [bytes of what pest sees].
pub(super) fn location(error: &Error<Rule>, start: usize) -> usize {
    start
        + match error.location {
            InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
        }
}

/// Turns pest's error about the part that starts at `start` [bytes of what pest sees] into a problem.
pub(super) fn expected(error: &Error<Rule>, start: usize, place: &Place<'_>) -> Problem {
    let (text, layout) = (place.text, place.layout);
    let at = place.compact.origin(location(error, start));
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
    if words.contains(&"a value") {
        words.retain(|w| !["a string", "a name", "`(`", "`[`"].contains(w));
    }
    words.sort_by_key(|w| *w == "an operator");
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
