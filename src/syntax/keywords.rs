//! The words of the language, each with a line about it: for completion, hover and highlighting.

/// Where a word is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// Begins an item of a file.
    Declaration,
    /// Within the declaration of a type, an attribute or an entity.
    Database,
    /// Begins a part of an action or a method.
    Clause,
    Test,
    Effect,
    /// Within `subtasks { }`.
    Step,
    /// Within `social { }`.
    Social,
    /// Within a geometric action.
    Geometric,
    Constant,
    /// The type of a value; an entity type is a name, apart from `Agent`.
    Type,
}

/// A word that has a meaning of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keyword {
    pub word: &'static str,
    pub group: Group,
    /// One sentence, in Markdown.
    pub doc: &'static str,
}

/// Returns every word with a meaning of its own, by group; old spellings stand behind the new ones.
pub fn keywords() -> &'static [Keyword] {
    KEYWORDS
}

const fn keyword(group: Group, word: &'static str, doc: &'static str) -> Keyword {
    Keyword { word, group, doc }
}

use Group::*;

const KEYWORDS: &[Keyword] = &[
    keyword(
        Declaration,
        "factdatabase",
        "Holds types, attributes, entities and initial values: `factdatabase { ... }`.",
    ),
    keyword(Declaration, "factDatabase", "The same as `factdatabase`."),
    keyword(Declaration, "HTN", "Holds actions and methods: `HTN { ... }`."),
    keyword(
        Declaration,
        "define",
        "Declares an entity type or the attributes of one: `define entityType Cup : Object;`.",
    ),
    keyword(
        Declaration,
        "action",
        "What an agent can do at once: `action Pick(Agent A, Object O) { ... }`.",
    ),
    keyword(Declaration, "operator", "The old word for `action`."),
    keyword(
        Declaration,
        "method",
        "How a task falls into smaller ones: `method Get(Agent A, Object O) { goal { ... }; { ... } }`.",
    ),
    keyword(Declaration, "task", "The old word for `method`."),
    keyword(
        Declaration,
        "function",
        "A number or a duration computed from its arguments: `function number f(number x) { x * 2 }`.",
    ),
    keyword(
        Declaration,
        "fact",
        "A relation that geometry computes, or one defined by tests: `fact isClose(any A, any B) { ... }`.",
    ),
    keyword(
        Declaration,
        "geometric",
        "A geometric action, for `projects`: `geometric lift(Agent A, any O) { exists hand in arms(A); ... }`.",
    ),
    keyword(
        Declaration,
        "request",
        "A question about the world as it is: `request number distance(any A, any B);`.",
    ),
    keyword(
        Declaration,
        "settings",
        "How this domain is planned: `settings { interleave = true; }`.",
    ),
    keyword(
        Declaration,
        "social",
        "What a plan costs beyond its actions: `social { wasted time weight 0.5; }`.",
    ),
    keyword(
        Declaration,
        "import",
        "Reads the declarations of another file: `import \"more.hatp\";`.",
    ),
    keyword(Declaration, "timePart", "Read and ignored: old files have it."),
    keyword(
        Database,
        "entityType",
        "Declares a type of entities: `define entityType Cup : Object;`.",
    ),
    keyword(
        Database,
        "entityAttributes",
        "Declares what entities of a type have: `define entityAttributes Cup { ... }`.",
    ),
    keyword(Database, "static", "An attribute that never changes."),
    keyword(Database, "dynamic", "An attribute that actions change, or geometry."),
    keyword(Database, "atom", "An attribute with one value, or `NULL`."),
    keyword(
        Database,
        "set",
        "An attribute or a parameter with any number of entities.",
    ),
    keyword(
        Database,
        "per",
        "Each agent has a belief of its own: `dynamic atom Table isOn per agent;`.",
    ),
    keyword(Database, "agent", "See `per`: `dynamic atom Table isOn per agent;`."),
    keyword(Database, "new", "Declares an entity: `CUP = new Object;`."),
    keyword(
        Clause,
        "preconditions",
        "What must hold before an action, or for a decomposition to apply.",
    ),
    keyword(
        Clause,
        "projects",
        "The geometric action that must succeed: `projects { pick(A, O) };`.",
    ),
    keyword(
        Clause,
        "constraints",
        "What must hold in the world after the geometric action.",
    ),
    keyword(
        Clause,
        "alternatives",
        "How many geometric solutions of this action are tried.",
    ),
    keyword(Clause, "effects", "What is true after the action."),
    keyword(Clause, "cost", "What the action costs, zero or more: `cost { 1 };`."),
    keyword(
        Clause,
        "duration",
        "How long the action takes, least and most, in seconds: `duration { (1, 3) };`.",
    ),
    keyword(
        Clause,
        "goal",
        "If it holds when the method is reached, there is nothing to do.",
    ),
    keyword(Clause, "empty", "The old word for `goal`."),
    keyword(
        Clause,
        "subtasks",
        "What a decomposition consists of: choices and smaller tasks, with their order.",
    ),
    keyword(Test, "OR", "One of several blocks holds: `OR { ... } { ... };`."),
    keyword(Test, "NOT", "The tests do not all hold: `NOT { ... };`."),
    keyword(
        Test,
        "FORALL",
        "Holds, or is done, for every entity that passes: `FORALL(Agent B, {guard}, {body});`.",
    ),
    keyword(
        Test,
        "EXIST",
        "Holds for one entity at least: `EXIST(Agent B, {tests});`.",
    ),
    keyword(Effect, "IF", "Effects under a condition: `IF { tests } { effects }`."),
    keyword(Effect, "ELSE", "Effects when the tests of `IF` do not hold."),
    keyword(
        Step,
        "SELECT",
        "A choice among all entities that pass, in the order of their declaration: `B = SELECT(Agent, {B != A;});`.",
    ),
    keyword(
        Step,
        "SELECTORDERED",
        "A choice that begins with the least (`<`) or the greatest (`>`): `SELECTORDERED(Object, {tests}, key, <)`.",
    ),
    keyword(Step, "SELECTONCE", "The first entity that passes, without a choice."),
    keyword(Step, "let", "Names a value without a choice: `let S = O.isOn;`."),
    keyword(
        Step,
        "after",
        "The subtasks that come before this one: `3: Go(A, L) after 1, 2;`. The same as `>1, >2`.",
    ),
    keyword(
        Social,
        "undesirable",
        "Begins a rule: `undesirable state NAME weight 5 { tests }`, `undesirable sequence NAME weight 2 { actions }`.",
    ),
    keyword(Social, "state", "A rule that counts how often its tests begin to hold."),
    keyword(
        Social,
        "sequence",
        "A rule that counts the actions which end a sequence: `Place(A, O, T); Pick(B, O) immediate;`.",
    ),
    keyword(
        Social,
        "immediate",
        "No action of those who take part comes in between: `Pick(B, O) immediate;`.",
    ),
    keyword(
        Social,
        "effort",
        "A rule on the difference between who does most and who does least: `effort balance weight 1;`.",
    ),
    keyword(
        Social,
        "balance",
        "See `effort`: `effort balance of duration weight 1;`.",
    ),
    keyword(
        Social,
        "wasted",
        "A rule on the seconds that agents wait between their actions: `wasted time weight 0.5;`.",
    ),
    keyword(Social, "time", "See `wasted`: `wasted time weight 0.5;`."),
    keyword(
        Social,
        "intricate",
        "A rule on how often agents wait for one another: `intricate links weight 1;`.",
    ),
    keyword(Social, "links", "See `intricate`: `intricate links weight 1;`."),
    keyword(
        Social,
        "of",
        "What is counted as effort: `effort balance of cost weight 1;`, or `of duration`.",
    ),
    keyword(
        Social,
        "among",
        "The agents, or types of agents, that a rule is about: `wasted time among BOB, Human weight 1;`.",
    ),
    keyword(
        Social,
        "weight",
        "What one of what a rule counts adds to the plan's cost.",
    ),
    keyword(
        Geometric,
        "exists",
        "What the solver has to choose: `exists hand in arms(A), grasp in grasps(O);`.",
    ),
    keyword(Geometric, "in", "See `exists`: `exists hand in arms(A);`."),
    keyword(
        Geometric,
        "when",
        "What must hold before a sub-action: `when free(hand) and isOn(O, S)`.",
    ),
    keyword(
        Geometric,
        "moving",
        "What may move in a sub-action: `moving arm(hand)`, `moving gripper(hand)`.",
    ),
    keyword(
        Geometric,
        "straight",
        "The tool follows a line: `moving arm(hand) straight`.",
    ),
    keyword(
        Geometric,
        "with",
        "What is in the hand meanwhile, `moving arm(hand) with O`; or a choice made already, `with hand = hand`.",
    ),
    keyword(
        Geometric,
        "until",
        "Where a sub-action ends, and what holds then: `until up(hand, 0.1) and isVisible(O, B)`.",
    ),
    keyword(
        Geometric,
        "then",
        "What changes hands after a sub-action: `then attach(O, hand)`.",
    ),
    keyword(Geometric, "and", "Both hold: `when free(hand) and isOn(O, S)`."),
    keyword(Constant, "NULL", "No value."),
    keyword(Constant, "true", "The value of a `bool` that holds."),
    keyword(Constant, "false", "The value of a `bool` that does not hold."),
    keyword(Type, "Agent", "Robots and humans; every domain has this entity type."),
    keyword(
        Type,
        "any",
        "An entity of any type, for parameters of facts, requests and geometric actions.",
    ),
    keyword(Type, "number", "A number, with a fraction or without."),
    keyword(Type, "int", "The same as `number`."),
    keyword(Type, "float", "The same as `number`."),
    keyword(Type, "bool", "`true` or `false`."),
    keyword(Type, "string", "A text in double quotes."),
    keyword(
        Type,
        "duration",
        "A pair of seconds, least and most: what a function for `duration { }` gives.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    const GRAMMAR: &str = include_str!("../../grammar/hatp.pest");

    /// Returns the words of all rules whose name passes.
    fn words(passes: impl Fn(&str) -> bool) -> Vec<&'static str> {
        let rules = GRAMMAR.lines().filter_map(|line| line.split_once('='));
        let bodies = rules.filter(|(name, _)| passes(name.trim())).map(|(_, body)| body);
        let mut words: Vec<&str> = bodies.flat_map(|body| body.split('"').skip(1).step_by(2)).collect();
        words.sort_unstable();
        words
    }

    fn known(passes: impl Fn(Group) -> bool) -> Vec<&'static str> {
        let mut words: Vec<&str> = keywords().iter().filter(|k| passes(k.group)).map(|k| k.word).collect();
        words.sort_unstable();
        words
    }

    #[test]
    fn they_are_the_words_of_the_grammar() {
        let in_grammar = words(|rule| rule.starts_with("kw_"));
        assert!(in_grammar.len() > 30);
        assert_eq!(known(|g| !matches!(g, Constant | Type)), in_grammar);
        assert_eq!(
            known(|g| g == Constant),
            words(|rule| rule == "boolean" || rule == "null")
        );
    }

    #[test]
    fn each_has_its_sentence_and_stands_with_its_group() {
        for k in keywords() {
            assert!(
                k.doc.ends_with('.') && k.doc.len() < 120 && !k.doc.contains('\n'),
                "{k:?}"
            );
        }
        assert!(keywords().is_sorted_by_key(|k| k.group));
    }
}
