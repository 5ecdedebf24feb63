//! The words of the language and what each means, for hover and completion.
//!
//! A test holds the list against the grammar's `kw_*` rules.

/// A word, how it is written, and what it means.
#[derive(Debug, Clone, Copy)]
pub(super) struct Keyword {
    pub word: &'static str,
    pub form: &'static str,
    pub meaning: &'static str,
}

/// Returns what is known of a word.
pub(super) fn keyword(word: &str) -> Option<&'static Keyword> {
    KEYWORDS.iter().find(|k| k.word == word)
}

const fn k(word: &'static str, form: &'static str, meaning: &'static str) -> Keyword {
    Keyword { word, form, meaning }
}

/// Every word of the language; values and basic types at the end.
pub(super) const KEYWORDS: &[Keyword] = &[
    k(
        "factdatabase",
        "factdatabase { }",
        "Types, attributes, entities and their initial values.",
    ),
    k("factDatabase", "factDatabase { }", "The same as `factdatabase`."),
    k("HTN", "HTN { }", "Actions and methods."),
    k(
        "timePart",
        "timePart { }",
        "Of older files: accepted and ignored. Durations stand in each action.",
    ),
    k(
        "import",
        "import \"file.hatp\";",
        "Takes in the declarations of another file.",
    ),
    k(
        "define",
        "define entityType Cup : Object;",
        "Declares a type of entities, or the attributes of one.",
    ),
    k(
        "entityType",
        "define entityType Cup : Object;",
        "A type of entities; behind `:` its supertype. `Agent` is always there.",
    ),
    k(
        "entityAttributes",
        "define entityAttributes Object { }",
        "What is said about each entity of a type and of its subtypes.",
    ),
    k(
        "static",
        "static atom string type;",
        "An attribute that never changes: no effect may set it.",
    ),
    k(
        "dynamic",
        "dynamic atom Table isOn;",
        "An attribute that effects or geometry may change.",
    ),
    k(
        "atom",
        "dynamic atom Table isOn;",
        "An attribute with one value; unset it is `NULL`.",
    ),
    k(
        "set",
        "dynamic set Agent isReachable;",
        "An attribute or a parameter that holds a set of entities.",
    ),
    k(
        "fact",
        "dynamic set Agent isReachable = fact isReachable;",
        "A relation that geometry computes. An attribute that is read from one is shared: what geometry says wins over effects.",
    ),
    k(
        "request",
        "request number distance(any A, any B);",
        "A question about the world as it is.",
    ),
    k("settings", "settings { interleave = true; }", "Options of this domain."),
    k("new", "CUP = new Object;", "Declares an entity with its type."),
    k(
        "action",
        "action Pick(Agent A, Object O) { }",
        "A task that can be executed. The first parameter is the agent that acts.",
    ),
    k(
        "operator",
        "operator Pick(Agent A, Object O) { }",
        "The same as `action`.",
    ),
    k(
        "method",
        "method Get(Agent A, Object O) { goal { }; { preconditions { }; subtasks { }; } }",
        "A task that is decomposed into others: exactly one of its decompositions is applied.",
    ),
    k("task", "task Get(Agent A, Object O) { }", "The same as `method`."),
    k(
        "preconditions",
        "preconditions { A.hasInHand == NULL; };",
        "Tests that must hold now; one after another means and.",
    ),
    k(
        "projects",
        "projects { pick(A, O) };",
        "The geometric action that does it. Without it the action is purely symbolic.",
    ),
    k(
        "constraints",
        "constraints { isReachable(O, AT); };",
        "What must hold in the world after the geometric action.",
    ),
    k(
        "alternatives",
        "alternatives { 3 };",
        "How many geometric alternatives of this action the search may try.",
    ),
    k(
        "effects",
        "effects { A.hasInHand = O; };",
        "What changes, in order; each reads the state as already changed.",
    ),
    k(
        "cost",
        "cost { 1 + 0.5 * O.weight };",
        "A number of 0 or more. Without it: what geometry computed, or 1.",
    ),
    k(
        "duration",
        "duration { (1, 3) };",
        "Least and most seconds. Without it: the time of the motions, or none.",
    ),
    k(
        "goal",
        "goal { A.hasInHand == O; };",
        "Where it holds when the method is reached, nothing is to be done.",
    ),
    k("empty", "empty { A.hasInHand == O; };", "The same as `goal`."),
    k(
        "subtasks",
        "subtasks { 1: Get(B, O); 2: Give(B, O, A) > 1; };",
        "The tasks of a decomposition, with choices and order. Without an order between two, every order is tried.",
    ),
    k(
        "SELECT",
        "B = SELECT(Agent, {B >> O.isReachable;});",
        "A choice point over all entities of a type that pass the filter, in the order of their declaration.",
    ),
    k(
        "SELECTORDERED",
        "B = SELECTORDERED(Agent, {B != A;}, B.load, <);",
        "As `SELECT`, sorted by a number: `<` takes the smallest first, `>` the greatest.",
    ),
    k(
        "SELECTONCE",
        "B = SELECTONCE(Agent, {B != A;});",
        "Takes the first entity that passes, and never comes back.",
    ),
    k(
        "let",
        "let X = O.isOn;",
        "Names a value, without making a choice point.",
    ),
    k(
        "after",
        "2: Give(B, O, A) after 1;",
        "This subtask starts when that one is over; also written `> 1`.",
    ),
    k(
        "function",
        "function number costFn(number c) { c }",
        "A value that is computed from its parameters.",
    ),
    k(
        "geometric",
        "geometric pick(Agent A, any O);",
        "A geometric action, for `projects`.",
    ),
    k(
        "OR",
        "OR{ A.x == 1; }{ A.y == 2; };",
        "Holds if one of the blocks does.",
    ),
    k("NOT", "NOT{ A.x == 1; };", "Holds if the tests do not."),
    k(
        "FORALL",
        "FORALL(Agent B, {B != A;}, {B.free == true;});",
        "For every entity of the type that passes the guard; in `effects` the second block is effects.",
    ),
    k(
        "EXIST",
        "EXIST(Agent B, {B != A;}, {B.free == true;});",
        "For some entity of the type that passes the guard; the second block may be left out.",
    ),
    k(
        "IF",
        "IF{ A.x == 1; }{ A.y = 2; }ELSE{ A.y = 3; }",
        "Effects that happen only where the tests hold.",
    ),
    k(
        "ELSE",
        "IF{ A.x == 1; }{ A.y = 2; }ELSE{ A.y = 3; }",
        "Effects that happen where the tests of `IF` do not hold.",
    ),
    k(
        "NULL",
        "A.hasInHand == NULL;",
        "No value. A path through it makes a test false.",
    ),
    k("true", "A.free == true;", "The bool that holds."),
    k("false", "A.free == false;", "The bool that does not hold."),
    k("size", "size(O.isReachable) >= 2;", "The number of entities in a set."),
    k("number", "dynamic atom number weight;", "A number."),
    k("int", "dynamic atom int weight;", "The same as `number`."),
    k("float", "dynamic atom float weight;", "The same as `number`."),
    k("bool", "dynamic atom bool painted;", "`true` or `false`."),
    k("string", "static atom string type;", "A text in quotes."),
    k(
        "any",
        "fact isOn(any A, any B);",
        "Of the prelude: an entity of any type.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of the `kw_*` rules.
    fn words_of_the_grammar() -> Vec<String> {
        let grammar = include_str!("../../grammar/hatp.pest");
        let rules = grammar.lines().filter(|line| line.starts_with("kw_"));
        let words = rules.flat_map(|rule| rule.split('"').skip(1).step_by(2).map(str::to_owned));
        words.collect()
    }

    #[test]
    fn every_keyword_of_the_grammar_is_explained() {
        let words = words_of_the_grammar();
        assert!(words.len() > 40, "{words:?}");
        for word in words {
            assert!(keyword(&word).is_some(), "`{word}` is not explained");
        }
    }

    #[test]
    fn a_form_shows_its_word() {
        for keyword in KEYWORDS {
            assert!(keyword.form.contains(keyword.word), "{keyword:?}");
            assert!(keyword.meaning.ends_with('.'), "{keyword:?}");
        }
    }
}
