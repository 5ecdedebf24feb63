//! pest's errors as problems in the language's own words: what was expected, what was found, what may have been meant.

use pest::error::{Error, ErrorVariant, InputLocation};

use super::{Place, Rule};
use crate::diag::Problem;
use crate::diag::suggest::nearest;
use crate::syntax::keywords::{Group, Keyword, keywords};
use crate::syntax::layout::Token;
use crate::syntax::words::{ANY_CLAUSE, word};

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
    let mut words = listed_rules(rules(error), place);
    let (before, next) = layout.around(at);
    let text_of = |token: Option<Token>| token.and_then(|(s, e)| text.get(s..e));
    if let Some(problem) = next.and_then(|token| other_character(token, place)) {
        return problem;
    }
    if let Some(problem) = before.and_then(|word| misspelt_name(&words, word, next, place)) {
        return problem;
    }
    let found = text_of(next);
    let new_line = match (before, next) {
        (Some(b), Some(n)) => text.get(b.1..n.0).is_some_and(|gap| gap.contains('\n')),
        _ => true,
    };
    let has = |w: &str| words.contains(&w);
    // A mark that ends something is missed where the text before it ends, not where the next word stands.
    let begins_item = found.is_none_or(|f| group(f) == Some(Group::Declaration));
    let begins_clause = found.is_some_and(|f| group(f) == Some(Group::Clause) || matches!(f, "{" | ";"));
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
    let is_bare_pair = found == Some(",") && next.is_some_and(|comma| in_duration(comma, place));
    let help = match is_bare_pair {
        true => Some("a pair stands in parentheses: `duration { (3, 5) }`".to_owned()),
        false => found.and_then(|f| foreign(f).map(str::to_owned)),
    };
    let is_keyword = |w: &&&str| w.strip_prefix('`').is_some_and(|w| w.starts_with(char::is_alphabetic));
    let found_is = || {
        let after = next.and_then(|(_, end)| layout.around(end).1);
        found.and_then(|w| misspelt(w, text_of(after) == Some("{")))
    };
    // Where a mark is expected, a keyword before it may have passed for a name.
    let before_is = || {
        let near = text_of(before).and_then(|w| misspelt(w, false))?;
        (missing.is_none() || text_of(before).is_some_and(|w| near.eq_ignore_ascii_case(w))).then_some(near)
    };
    let quantifier = || before.and_then(|before| misspelt_quantifier(before, next, place));
    let near = if before.is_some_and(|token| in_geometric(token, place)) {
        // Its words are none elsewhere, and those of elsewhere none here.
        let listed = words.iter().map(|w| w.trim_matches('`'));
        found.and_then(|w| nearest(w, listed.filter(|w| w.starts_with(char::is_alphabetic))))
    } else if words.iter().any(|w| is_keyword(&w)) {
        // Where any clause may stand they are not all named.
        let has = |w: &str| words.contains(&w);
        let fits =
            |near: &&'static str| has(&format!("`{near}`")) || group(near) == Some(Group::Clause) && has(ANY_CLAUSE);
        found_is().filter(fits).or_else(before_is)
    } else {
        before_is().or_else(quantifier).or_else(found_is)
    };
    let near = near.map(|near| format!("did you mean `{near}`?"));
    let other = || instead(&words, before.unwrap_or_default(), found?, place).map(str::to_owned);
    problem = problem.maybe_help(help.or(near).or_else(other));
    if let (None, Some((s, e))) = (next, layout.unclosed.last()) {
        problem = problem.note(place.span(*s, *e), "this is not closed");
    }
    problem
}

/// Returns the error of an item if a misspelt first word is all that is wrong with it, as far as pest can tell.
pub(super) fn misspelt_item(error: &Error<Rule>, start: usize, place: &Place<'_>) -> Option<Problem> {
    let at = place.compact.origin(location(error, start));
    let (before, next) = place.layout.around(at);
    misspelt_name(&listed_rules(rules(error), place), before?, next, place)
}

fn rules(error: &Error<Rule>) -> &[Rule] {
    match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => positives,
        ErrorVariant::CustomError { .. } => &[],
    }
}

/// Returns the words for the rules, each once.
fn listed_rules(rules: &[Rule], place: &Place<'_>) -> Vec<&'static str> {
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
    words
}

/// Returns the error of a character that the language does not use, together with the name that it stands in.
fn other_character((start, end): Token, place: &Place<'_>) -> Option<Problem> {
    let c = place.text.get(start..end)?.chars().next()?;
    if c.is_ascii() && !c.is_ascii_control() {
        return None;
    }
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let from = place.text[..start].trim_end_matches(is_part).len();
    let n_more = place.text[end..]
        .find(|c| !is_part(c))
        .unwrap_or(place.text.len() - end);
    let shown = if c.is_alphanumeric() {
        format!("`{c}`")
    } else {
        format!("`{}` (U+{:04X})", c.escape_debug(), u32::from(c))
    };
    let message = format!("{shown} is no character of the language");
    let span = if is_part(c) {
        place.span(from, end + n_more)
    } else {
        place.span(start, end)
    };
    let problem = Problem::error("hatp::syntax", message, span, "");
    Some(problem.help(
        "names are of the letters `a` to `z` and `A` to `Z`, digits and `_`; strings and comments may have any others",
    ))
}

/// Returns the error of a misspelt keyword: it passes for a name, but the word is wrong and not what follows it.
fn misspelt_name(words: &[&str], word: Token, next: Option<Token>, place: &Place<'_>) -> Option<Problem> {
    let text_of = |token: Token| place.text.get(token.0..token.1);
    let only_a_name = words.contains(&"`=`") && words.iter().all(|w| NAME_MARKS.contains(w));
    let begins = match place.layout.around(word.0).0 {
        Some(before) => matches!(text_of(before), Some("{" | "}" | ";")),
        None => true,
    };
    if !only_a_name || !begins {
        return None;
    }
    let found = text_of(word)?;
    let near = misspelt(found, next.and_then(text_of) == Some("{"))?;
    let message = format!("expected `{near}`, found `{}`", shortened(found));
    let problem = Problem::error(
        "hatp::syntax",
        message,
        place.span(word.0, word.1),
        format!("expected `{near}`"),
    );
    Some(problem.help(format!("did you mean `{near}`?")))
}

/// What may follow a name that begins a statement.
const NAME_MARKS: [&str; 6] = ["`=`", "`.`", "`(`", "`:`", "`<<=`", "`=>>`"];

/// Says where a token may stand, if it is a keyword.
pub(super) fn group(token: &str) -> Option<Group> {
    keywords().iter().find(|k| k.word == token).map(|k| k.group)
}

/// Returns true if the innermost open brace before the token is that of a `duration`.
fn in_duration(token: Token, place: &Place<'_>) -> bool {
    let tokens = &place.layout.tokens;
    let n_before = tokens.partition_point(|t| t.0 < token.0);
    let text_of = |i: usize| tokens.get(i).and_then(|(s, e)| place.text.get(*s..*e));
    let open = (0..n_before)
        .rev()
        .find(|i| matches!(text_of(*i), Some("{" | "}" | ";")));
    open.is_some_and(|i| text_of(i) == Some("{") && i > 0 && text_of(i - 1) == Some("duration"))
}

/// Returns true if the innermost open brace before the token is that of a geometric action.
fn in_geometric(token: Token, place: &Place<'_>) -> bool {
    let tokens = &place.layout.tokens;
    let n_before = tokens.partition_point(|t| t.0 < token.0);
    let text_of = |i: usize| tokens.get(i).and_then(|(s, e)| place.text.get(*s..*e));
    let open = (0..n_before).rev().find(|i| matches!(text_of(*i), Some("{" | "}")));
    let Some(open) = open.filter(|i| text_of(*i) == Some("{")) else {
        return false;
    };
    // `geometric NAME ( .. ) {`: parameters have no brackets of their own.
    let params = (0..open).rev().find(|i| text_of(*i) == Some("("));
    params.is_some_and(|i| i > 1 && text_of(i - 2) == Some("geometric"))
}

/// Returns how to say what other languages say with this mark.
fn foreign(found: &str) -> Option<&'static str> {
    match found {
        "&" => Some("tests simply follow one another; each ends with `;`"),
        "|" => Some("write `OR { ... } { ... }`"),
        "!" => Some("write `NOT { ... };`"),
        _ => None,
    }
}

/// Returns what to write for what other languages allow, or another place of this one; `last` stands before `found`.
fn instead(words: &[&str], last: Token, found: &str, place: &Place<'_>) -> Option<&'static str> {
    let has = |w: &str| words.contains(&w);
    let before = place.text.get(last.0..last.1)?;
    let is_number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit());
    match found {
        "." if is_number(before) || has("a value") => Some("a point stands between digits: `0.5`, `1.0`"),
        "+" | "-" | "*" | "/" if has("`=`") => Some("write out the new value: `A.n = A.n + 1;`"),
        "preconditions" | "subtasks" if has("`goal`") => {
            Some("a decomposition stands in braces of its own: `{ preconditions { ... } subtasks { ... } }`")
        }
        "==" | "!=" | "<" | ">" | "<=" | ">=" if has("`)`") && !is_in_call(last, place) => {
            Some("a comparison stands in no parentheses, and ends with `;`")
        }
        "define" if has("`factdatabase`") => Some("types and attributes are declared in `factdatabase { ... }`"),
        _ if before == "import" => Some("the path stands in quotes: `import \"file.hatp\";`"),
        _ if before == "=" && has("`SELECT`") => Some("a value is named with `let`: `let X = A.attribute;`"),
        _ => None,
    }
}

/// Says whether the innermost bracket around the end of a token holds the arguments of a call.
fn is_in_call(last: Token, place: &Place<'_>) -> bool {
    let tokens = &place.layout.tokens;
    let text_of = |token: &Token| place.text.get(token.0..token.1).unwrap_or_default();
    let mut n_closed = 0;
    let n = tokens.partition_point(|t| t.0 <= last.0);
    for (i, token) in tokens.iter().enumerate().take(n).skip(1).rev() {
        match text_of(token) {
            ")" => n_closed += 1,
            "(" if n_closed > 0 => n_closed -= 1,
            "(" => {
                let name = tokens.get(i - 1).map(text_of).unwrap_or_default();
                return name.starts_with(|c: char| c.is_ascii_alphabetic());
            }
            _ => {}
        }
    }
    false
}

/// Returns the quantifier that was meant before `(T x`: any other word there is a call, with values in its parentheses.
fn misspelt_quantifier(ty: Token, variable: Option<Token>, place: &Place<'_>) -> Option<&'static str> {
    let text_of = |token: Token| place.text.get(token.0..token.1);
    let before = |token: Token| place.layout.around(token.0).0;
    let is_word = |text: &str| text.starts_with(|c: char| c.is_ascii_alphabetic());
    let bracket = before(ty)?;
    let is_declaration = is_word(text_of(ty)?) && is_word(text_of(variable?)?) && text_of(bracket)? == "(";
    let near = misspelt(text_of(before(bracket)?)?, false)?;
    (is_declaration && ["FORALL", "EXIST"].contains(&near)).then_some(near)
}

/// Returns the keyword that the word was meant to be; before a brace, three letters are enough to tell.
fn misspelt(found: &str, before_brace: bool) -> Option<&'static str> {
    let is_word = found.len() > 1 && found.chars().all(|c| c.is_ascii_alphabetic() || c == '_');
    // No keyword is half as long; comparing takes the product of both lengths.
    if !is_word || found.len() > 32 || group(found).is_some() {
        return None;
    }
    let is_keyword = |k: &&Keyword| {
        !matches!(
            k.group,
            Group::Constant | Group::Type | Group::Social | Group::Geometric
        )
    };
    let near = nearest(found, keywords().iter().filter(is_keyword).map(|k| k.word))?;
    let same_letters = near.eq_ignore_ascii_case(found);
    (same_letters || found.len() > if before_brace { 2 } else { 3 }).then_some(near)
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
