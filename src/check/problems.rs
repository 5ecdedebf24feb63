//! Every error of this room, one constructor for each kind; warnings are worded in [`super::lints`], those of a walk here.

use super::functions::TooLarge;
use crate::diag::Problem;
use crate::diag::suggest::{did_you_mean, nearest};
use crate::source::Span;
use crate::syntax::ast::{Name, PathStep};

use super::PRELUDE;

/// Adds a place, unless it is in the prelude, which is no file of the user's.
pub(super) fn noted(problem: Problem, span: Option<Span>, text: &str) -> Problem {
    match span {
        Some(span) if span.file != PRELUDE => problem.note(span, text),
        _ => problem,
    }
}

/// Names listed where none is near.
const MOST_LISTED: usize = 8;

/// `what` is `type`, `task`, `label` ...; its code is `hatp::unknown-<what>`.
pub(super) fn unknown<'a>(
    code: &'static str,
    what: &str,
    name: &str,
    span: Span,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Problem {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let help = did_you_mean(name, candidates.iter().copied()).or_else(|| match candidates.len() {
        1..=MOST_LISTED if what != "variable or entity" => Some(format!("there are `{}`", candidates.join("`, `"))),
        _ => None,
    });
    Problem::error(code, format!("unknown {what} `{name}`"), span, "not declared").maybe_help(help)
}

/// A type of entities is wanted, and this is a type of values.
pub(super) fn no_entities(name: &Name) -> Problem {
    let message = format!("`{}` is no type of entities", name.text);
    Problem::error("hatp::unknown-type", message, name.span, "nothing to go through")
        .help("FORALL, EXIST and SELECT go through the entities of a type, and only these have attributes")
}

/// `name` is the type that the world file gives to `entity`, at the entity's place.
pub(super) fn unknown_type_of<'a>(entity: &str, name: &Name, candidates: impl IntoIterator<Item = &'a str>) -> Problem {
    let mut problem = unknown("hatp::unknown-type", "type", &name.text, name.span, candidates);
    problem.message = format!("unknown type `{}` of `{entity}`", name.text);
    if let Some(label) = &mut problem.primary {
        label.text = "its `type` is not declared in the domain".into();
    }
    problem
}

pub(super) fn unknown_attribute<'a>(
    owner: &str,
    name: &str,
    span: Span,
    candidates: impl IntoIterator<Item = (&'a str, Span)>,
    below: Option<&str>,
) -> Problem {
    let candidates: Vec<(&str, Span)> = candidates.into_iter().collect();
    let near = nearest(name, candidates.iter().map(|c| c.0));
    let message = format!("`{owner}` has no attribute `{name}`");
    let problem = Problem::error("hatp::unknown-attribute", message, span, "no such attribute");
    if let Some(below) = below {
        return problem.help(format!(
            "`{below}` has it, and not every `{owner}` is a `{below}`: declare this as `{below}` where it comes from"
        ));
    }
    match near {
        Some(near) => {
            let declared = candidates.iter().find(|c| c.0 == near).map(|c| c.1);
            noted(problem, declared, "declared here").help(format!("did you mean `{near}`?"))
        }
        None => problem.help(format!(
            "declare it in `define entityAttributes {owner} {{ ... }}`, as `dynamic atom bool {name};` or another type"
        )),
    }
}

pub(super) fn unknown_function(name: &Name, near: Option<&str>, definition: &str) -> Problem {
    let message = format!("unknown function `{}`", name.text);
    let problem = Problem::error("hatp::unknown-function", message, name.span, "not defined");
    problem.help(match near {
        Some(near) => format!("did you mean `{near}`? or define it: `{definition}`"),
        None => format!("define it in the domain, or in `NAME.functions.hatp` beside it: `{definition}`"),
    })
}

pub(super) fn duplicate(what: &str, name: &str, span: Span, first: Option<Span>) -> Problem {
    let in_prelude = first.is_some_and(|s| s.file == PRELUDE);
    let message = if in_prelude {
        format!("{what} `{name}` is built in")
    } else {
        format!("{what} `{name}` is declared twice")
    };
    let problem = Problem::error("hatp::duplicate-name", message, span, "declared again");
    noted(problem, first, "first declared here").help("give one of them another name, or remove it")
}

pub(super) fn repeated_block(what: &str, of: &str, span: Span, first: Span) -> Problem {
    let message = format!("`{what}` comes twice in `{of}`");
    let problem = Problem::error("hatp::duplicate-name", message, span, "a second one");
    problem.note(first, "the first one").help("join the two blocks")
}

pub(super) fn wrong_type(span: Span, wanted: &str, found: &str) -> Problem {
    let message = format!("expected {wanted}, found {found}");
    Problem::error("hatp::wrong-type", message, span, format!("this is {found}"))
}

pub(super) fn wrong_count(what: &str, name: &Name, wanted: &[String], found: usize, declared: Span) -> Problem {
    let n = wanted.len();
    let plural = if n == 1 { "argument" } else { "arguments" };
    let message = format!("{what} `{}` takes {n} {plural}, found {found}", name.text);
    let label = format!("{n} {plural} wanted");
    let problem = Problem::error("hatp::wrong-count", message, name.span, label);
    noted(problem, Some(declared), "declared here").help(format!("write `{}({})`", name.text, wanted.join(", ")))
}

/// `wanted` are the types that the attribute asks for.
pub(super) fn wrong_attribute_arguments(step: &PathStep, wanted: &[String], declared: Option<Span>) -> Problem {
    let (name, found) = (&step.name.text, step.args.len());
    let (message, label, help) = match wanted.len() {
        0 => (
            format!("attribute `{name}` takes no arguments, found {found}"),
            "no arguments wanted".to_owned(),
            format!("write `{name}`"),
        ),
        n => {
            let plural = if n == 1 { "argument" } else { "arguments" };
            (
                format!("attribute `{name}` takes {n} {plural}, found {found}"),
                format!("{n} {plural} wanted"),
                format!("write `{name}({})`", wanted.join(", ")),
            )
        }
    };
    noted(
        Problem::error("hatp::wrong-count", message, step.span, label),
        declared,
        "declared here",
    )
    .help(help)
}

/// `B.believes(...)` as a part of something.
pub(super) fn belief_apart(name: &Name) -> Problem {
    let message = "a belief is a test or an effect, and stands alone";
    Problem::error("hatp::not-per-agent", message, name.span, "this is a part of something")
        .help("write `B.believes(A.attribute == value);`")
}

/// `what` is what has no view of its own.
pub(super) fn not_per_agent(what: &str, span: Span, declared: Option<Span>, name: Option<&str>) -> Problem {
    let label = "the same for all agents";
    let problem = Problem::error("hatp::not-per-agent", what, span, label);
    let declaration = name.map_or("dynamic atom Table isOn per agent;".into(), |name| {
        format!("... {name} per agent;")
    });
    noted(problem, declared, "declared here").help(format!("declare the attribute so: `{declaration}`"))
}

pub(super) fn static_assigned(owner: &str, name: &Name, declared: Span) -> Problem {
    let message = format!("`{owner}.{}` is static and can't change", name.text);
    Problem::error("hatp::static-assigned", message, name.span, "set here")
        .note(declared, "declared static here")
        .help("declare it `dynamic`, or set it in `factdatabase` only")
}

pub(super) fn unbound(name: &Name, bound: Span) -> Problem {
    let message = format!("`{}` is used before it has a value", name.text);
    Problem::error("hatp::unbound-variable", message, name.span, "used here")
        .note(bound, "gets its value here")
        .help("move the line that gives it a value up")
}

/// `circle` holds the labels of subtasks that wait for one another, each with its place: the first for the second and so on,
/// the last for the first.
pub(super) fn order_cycle(circle: &[(String, Span)]) -> Option<Problem> {
    let (first, place) = circle.first()?;
    let labels: Vec<&str> = circle.iter().chain(circle.first()).map(|(l, _)| l.as_str()).collect();
    let message = format!("the order of the subtasks goes round: {}", labels.join(" after "));
    let waits = |i: usize| {
        let next = circle.get(i + 1).map_or(first, |(label, _)| label);
        match circle.len() {
            1 => "waits for itself".to_owned(),
            _ => format!("waits for `{next}`"),
        }
    };
    let mut problem = Problem::error("hatp::order-cycle", message, *place, waits(0));
    for (i, (_, span)) in circle.iter().enumerate().skip(1) {
        problem = problem.note(*span, waits(i));
    }
    Some(problem.help("remove one of the order marks"))
}

pub(super) fn negative_cost(value: f64, span: Span) -> Problem {
    let message = format!("the cost is {value}, and must be 0 or more");
    Problem::error("hatp::negative-cost", message, span, "")
        .help("the search cuts off what costs more than the best plan")
}

/// `weight` is `None` where it is no constant number.
pub(super) fn bad_weight(weight: Option<f64>, span: Span) -> Problem {
    let message = match weight {
        Some(weight) => format!("the weight is {weight}, and must be 0 or more"),
        None => "a weight must be a constant number".to_owned(),
    };
    Problem::error("hatp::bad-weight", message, span, "")
        .help("what a rule counts makes a plan worse: write `weight 2`, or `0.5 * makespan`")
}

pub(super) fn part_of_cost(name: &str, span: Span) -> Problem {
    let message = format!("social rule `{name}` has the name of a part of every plan's cost");
    Problem::error("hatp::duplicate-name", message, span, "declared again").help("give it another name")
}

pub(super) fn empty_sequence(span: Span) -> Problem {
    let message = "an undesirable sequence without an action";
    Problem::error("hatp::bad-sequence", message, span, "no action of it is named")
        .help("write the actions in their order: `Put(A, O, T); Pick(A, O) immediate;`")
}

pub(super) fn immediate_first(span: Span) -> Problem {
    let message = "the first action of a sequence comes after no other";
    Problem::error("hatp::bad-sequence", message, span, "`immediate` after what?").help("remove `immediate`")
}

pub(super) fn not_an_action(name: &Name, declared: Span) -> Problem {
    let message = format!("`{}` is a method, and a sequence is one of actions", name.text);
    noted(
        Problem::error("hatp::bad-sequence", message, name.span, "no action"),
        Some(declared),
        "declared here",
    )
    .help("name the actions that it leads to")
}

pub(super) fn too_many_choices(found: usize, limit: usize, span: Span) -> Problem {
    let message = format!("the parameters of this rule have {found} choices, more than {limit}");
    Problem::error("hatp::too-large", message, span, "tested in every state")
        .help("use fewer parameters, or `EXIST` for some of them")
}

pub(super) fn bad_duration(least: f64, most: f64, span: Span) -> Problem {
    let message = format!("the duration ({least}, {most}) is no (least, most) of seconds");
    Problem::error("hatp::bad-duration", message, span, "").help("write 0 or more first, and then at least as much")
}

pub(super) fn not_supported(message: impl Into<String>, span: Span, help: impl Into<String>) -> Problem {
    Problem::error("hatp::not-supported", message, span, "not there yet").help(help)
}

pub(super) fn time_part(span: Span) -> Problem {
    let message = "`timePart` is ignored";
    Problem::warning("hatp::time-part", message, span, "has no effect")
        .help("remove it; durations stand in each action")
}

pub(super) fn overruled(entity: &str, attribute: &str, span: Span) -> Problem {
    let message = format!("`{entity}.{attribute}` is read from geometry, and this value is not used");
    Problem::warning("hatp::overruled", message, span, "has no effect")
        .help("remove the line; where things stand is in the world file")
}

pub(super) fn not_projected(action: &Name, span: Span) -> Problem {
    let message = format!("action `{}` has constraints and projects nothing", action.text);
    Problem::error(
        "hatp::not-projected",
        message,
        span,
        "there is no world that the action leads to",
    )
    .note(action.span, "this action")
    .help("add `projects { ... }`, or write them into `preconditions`")
}

pub(super) fn state_in_fact(fact: &Name, culprit: &str, span: Span) -> Problem {
    let message = format!("fact `{}` reads `{culprit}`, which actions change", fact.text);
    Problem::error("hatp::state-in-fact", message, span, "a fact is about the world alone")
        .help("declare the attribute `static`, or test it where the fact is asked")
}

pub(super) fn recursive_fact(name: &Name) -> Problem {
    let message = format!("fact `{}` asks itself", name.text);
    Problem::error("hatp::recursive-function", message, name.span, "needs its own answer")
        .help("recursion belongs in methods")
}

pub(super) fn recursive(name: &Name) -> Problem {
    let message = format!("function `{}` calls itself", name.text);
    Problem::error("hatp::recursive-function", message, name.span, "needs its own value")
        .help("functions are written out where they are called; recursion belongs in methods")
}

pub(super) fn endless_geometric(name: &Name) -> Problem {
    let message = format!("geometric action `{}` takes over itself", name.text);
    Problem::error("hatp::recursive-function", message, name.span, "would never end")
        .help("an action is written out where another one takes it over; recursion belongs in methods")
}

pub(super) fn geometric_without_body(name: &Name) -> Problem {
    let message = format!("nothing says how geometric action `{}` is done", name.text);
    not_supported(
        message,
        name.span,
        "write its choices and sub-actions in braces: `{ exists hand in arms(A); ... }`",
    )
}

/// What is wrong with a sub-action although every word of it is known.
pub(super) fn bad_sub_action(
    message: String,
    span: Span,
    label: impl Into<String>,
    help: impl Into<String>,
) -> Problem {
    Problem::error("hatp::bad-sub-action", message, span, label).help(help)
}

pub(super) fn unused_choice(name: &Name) -> Problem {
    let message = format!("choice `{}` is never used", name.text);
    Problem::warning("hatp::unused-variable", message, name.span, "chosen here")
        .help("every value of it gives the same motions again; remove it")
}

/// `known` are the parameters and choices.
pub(super) fn unknown_in_geometric(name: &Name, known: Vec<String>) -> Problem {
    let known = known.iter().map(String::as_str);
    unknown(
        "hatp::unknown-name",
        "parameter or choice",
        &name.text,
        name.span,
        known,
    )
}

/// `what` is where the word stands; the last of the arguments may be left out.
pub(super) fn wrong_words_count(what: &str, name: &Name, wanted: &[String], least: usize, found: usize) -> Problem {
    let n = wanted.len();
    let count = if least == n {
        n.to_string()
    } else {
        format!("{least} or {n}")
    };
    let plural = if n == 1 { "argument" } else { "arguments" };
    let message = format!("{what} `{}` takes {count} {plural}, found {found}", name.text);
    Problem::error(
        "hatp::wrong-count",
        message,
        name.span,
        format!("{count} {plural} wanted"),
    )
    .help(format!("write `{}({})`", name.text, wanted.join(", ")))
}

pub(super) fn too_large(why: TooLarge, span: Span) -> Option<Problem> {
    let message = match why {
        TooLarge::Expression => "this expression is too large when its functions are written out",
        TooLarge::Domain => "the domain is too large when its functions are written out",
        TooLarge::DomainBefore => return None,
    };
    let problem = Problem::error("hatp::too-large", message, span, "");
    Some(problem.help("call fewer functions within functions"))
}

pub(super) fn too_many_slots(n_attributes: usize, n_entities: usize, span: Span) -> Problem {
    let message = format!("{n_attributes} attributes and {n_entities} entities are too many together");
    Problem::error("hatp::too-large", message, span, "").help("declare only the entities that the task needs")
}

pub(super) fn too_many_argument_slots(name: &Name, limit: usize) -> Problem {
    let message = format!(
        "`{}` and the attributes before it have more than {limit} values: one for each choice of entity and arguments",
        name.text
    );
    Problem::error("hatp::too-large", message, name.span, "").help("give it narrower types, or declare fewer entities")
}

pub(super) fn too_many_supertypes(name: &Name, limit: usize) -> Problem {
    let message = format!(
        "type `{}` has more than {limit} supertypes above one another",
        name.text
    );
    Problem::error("hatp::too-large", message, name.span, "").help("remove levels between the types")
}

pub(super) fn too_many_facts(name: &Name, limit: usize) -> Problem {
    let message = format!(
        "fact `{}` asks facts that ask others, more than {limit} deep",
        name.text
    );
    Problem::error("hatp::too-large", message, name.span, "")
        .help("write the tests of some facts into those that ask them")
}

pub(super) fn fact_too_large(name: &Name, limit: usize) -> Problem {
    let message = format!("to answer fact `{}`, more than {limit} facts would be asked", name.text);
    Problem::error("hatp::too-large", message, name.span, "")
        .help("ask each fact once, and write small ones into those that ask them")
}

pub(super) fn type_cycle(name: &Name) -> Problem {
    let message = format!("type `{}` is its own supertype", name.text);
    Problem::error("hatp::type-cycle", message, name.span, "").help("remove one `:` of the circle")
}

pub(super) fn type_conflict(entity: &str, one: &str, other: &str, span: Span, first: Option<Span>) -> Problem {
    let message = format!("`{entity}` is declared as `{one}` and as `{other}`");
    let problem = Problem::error("hatp::type-conflict", message, span, format!("`{other}` here"));
    noted(problem, first, &format!("`{one}` here")).help("give it the same type in both files, or leave it out of one")
}

pub(super) fn not_an_agent(entity: &str, ty: &str, span: Span) -> Problem {
    let message = format!("`{entity}` is a robot or a human of the world, and `{ty}` is no kind of `Agent`");
    let help = format!("use type `Agent`, or declare `define entityType {ty} : Agent;`");
    Problem::error("hatp::type-conflict", message, span, "").help(help)
}

pub(super) fn wrong_fact(message: String, span: Span, help: impl Into<String>) -> Problem {
    Problem::error("hatp::wrong-fact", message, span, "does not fit").help(help)
}

pub(super) fn not_constant(span: Span, message: impl Into<String>, help: impl Into<String>) -> Problem {
    Problem::error("hatp::not-constant", message, span, "").help(help)
}
