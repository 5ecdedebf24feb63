//! All wording of what can be wrong with HDDL.

use super::tree::MAX_DEPTH;
use crate::diag::Problem;
pub(super) use crate::diag::Problems;
use crate::diag::suggest::did_you_mean;
use crate::source::Span;

pub(super) fn too_deep(span: Span) -> Problem {
    let message = format!("brackets nest deeper than {MAX_DEPTH}");
    Problem::error("hddl::too-large", message, span, "one bracket too deep")
}

/// A formula that would nest too deep in HATP.
pub(super) fn deep_formula(span: Span) -> Problem {
    let message = "this formula nests too deep";
    let help = "join quantifiers and conjunctions that stand in one another";
    Problem::error("hddl::too-large", message, span, "").help(help)
}

pub(super) fn unclosed(span: Span, next: Option<Span>) -> Problem {
    let problem = Problem::error("hddl::syntax", "a bracket is never closed", span, "opened here");
    match next {
        Some(next) => problem.note(next, "it should have been closed before this"),
        None => problem.help("add `)` where its list ends"),
    }
}

pub(super) fn unopened(span: Span) -> Problem {
    Problem::error(
        "hddl::syntax",
        "a bracket is closed that is not open",
        span,
        "one too many",
    )
    .help("remove it")
}

/// Something else was to stand there: `wanted` says what.
pub(super) fn expected(wanted: &str, span: Span) -> Problem {
    Problem::error("hddl::syntax", format!("expected {wanted}"), span, "found this")
}

/// A part that must be there is not.
pub(super) fn missing(what: &str, of: &str, span: Span) -> Problem {
    Problem::error("hddl::syntax", format!("{of} has no {what}"), span, "")
}

pub(super) fn glued(word: &str, span: Span) -> Problem {
    let message = format!("`{word}` is one word");
    let help = format!("write a blank behind the `-`: `- {}`", word.trim_start_matches('-'));
    Problem::error("hddl::syntax", message, span, "a type was expected").help(help)
}

/// A word that begins no part of what `of` names.
pub(super) fn unknown_part<'a>(word: &str, of: &str, span: Span, known: impl IntoIterator<Item = &'a str>) -> Problem {
    let message = format!("{of} has no part `{word}`");
    Problem::error("hddl::syntax", message, span, "").maybe_help(did_you_mean(word, known))
}

/// Something of PDDL or HDDL that is correct and that we can't plan with; `what` stands before "not supported".
pub(super) fn not_supported(what: &str, span: Span, help: &str) -> Problem {
    Problem::error("hddl::not-supported", format!("{what} not supported"), span, "").help(help)
}

fn unknown<'a>(
    code: &'static str,
    what: &str,
    name: &str,
    span: Span,
    known: impl IntoIterator<Item = &'a str>,
) -> Problem {
    Problem::error(code, format!("unknown {what} `{name}`"), span, "not declared").maybe_help(did_you_mean(name, known))
}

pub(super) fn unknown_type<'a>(name: &str, span: Span, known: impl IntoIterator<Item = &'a str>) -> Problem {
    unknown("hddl::unknown-type", "type", name, span, known)
}

pub(super) fn unknown_predicate<'a>(name: &str, span: Span, known: impl IntoIterator<Item = &'a str>) -> Problem {
    unknown("hddl::unknown-predicate", "predicate", name, span, known)
}

pub(super) fn unknown_task<'a>(name: &str, span: Span, known: impl IntoIterator<Item = &'a str>) -> Problem {
    unknown("hddl::unknown-task", "task", name, span, known)
}

/// `what` is a variable, an object, a function or a label.
pub(super) fn unknown_name<'a>(
    what: &str,
    name: &str,
    span: Span,
    known: impl IntoIterator<Item = &'a str>,
) -> Problem {
    unknown("hddl::unknown-name", what, name, span, known)
}

pub(super) fn duplicate(what: &str, name: &str, span: Span, first: Span) -> Problem {
    let message = format!("{what} `{name}` is declared twice");
    Problem::error("hddl::duplicate-name", message, span, "declared again").note(first, "declared here first")
}

pub(super) fn twice(what: &str, span: Span) -> Problem {
    Problem::error("hddl::duplicate-name", format!("a second {what}"), span, "").help("join the two")
}

pub(super) fn wrong_count(name: &str, wanted: usize, found: usize, span: Span) -> Problem {
    let arguments = if wanted == 1 { "argument" } else { "arguments" };
    let message = format!("`{name}` takes {wanted} {arguments}, not {found}");
    Problem::error("hddl::wrong-count", message, span, "")
}

/// `found` and `wanted` are types in words.
pub(super) fn wrong_type(term: &str, found: &str, of: &str, wanted: &str, span: Span) -> Problem {
    let message = format!("`{term}` is a `{found}`, and `{of}` wants a `{wanted}`");
    Problem::error("hddl::wrong-type", message, span, "")
}

pub(super) fn type_cycle(name: &str, span: Span) -> Problem {
    let message = format!("type `{name}` is, through others, its own supertype");
    Problem::error("hddl::type-cycle", message, span, "")
}

pub(super) fn type_depth(span: Span) -> Problem {
    let message = "a type has more than 30 supertypes above one another";
    Problem::error("hddl::too-large", message, span, "")
}

/// A relation of three things or more takes one value for each choice of all but the last.
pub(super) fn too_many_values(name: &str, limit: usize, span: Span) -> Problem {
    let message = format!("`{name}` and the predicates before it are about more than {limit} choices of objects");
    Problem::error("hddl::too-large", message, span, "").help("give it narrower types, or declare fewer objects")
}

/// `what` there is too much of.
pub(super) fn too_large(what: &str, span: Span) -> Problem {
    Problem::error("hddl::too-large", format!("{what} are too many"), span, "")
        .help("leave out what the task does not need")
}

pub(super) fn order_cycle(span: Span) -> Problem {
    let message = "subtasks wait for each other in a circle";
    Problem::error("hddl::order-cycle", message, span, "").help("remove one of these orderings")
}

pub(super) fn no_task(span: Span) -> Problem {
    let message = "the problem has no initial task network";
    let help = "add `(:htn :ordered-subtasks (and ...))`: a goal alone is a problem for a classical planner";
    Problem::error("hddl::no-task", message, span, "").help(help)
}

pub(super) fn wrong_domain(found: &str, wanted: &str, span: Span, declared: Span) -> Problem {
    let message = format!("the problem is one of domain `{found}`, and the domain is called `{wanted}`");
    Problem::warning("hddl::wrong-domain", message, span, "").note(declared, "called so here")
}

/// A problem file stands where a domain is wanted, or the other way round.
pub(super) fn swapped(wanted: &str, span: Span) -> Problem {
    let message = format!("a {wanted} is wanted in this file");
    let help = "the domain comes before the problem: `DOMAIN.hddl PROBLEM.hddl`";
    Problem::error("hddl::syntax", message, span, "").help(help)
}
