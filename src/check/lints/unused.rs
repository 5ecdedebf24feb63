//! Variables and parameters that nothing speaks of. A name that begins with `_` is meant to be unused.
//!
//! Parameters of actions stand in the plan and those of functions may be asked for by a caller; only a method's are told.

use std::collections::BTreeSet;

use super::Linted;
use super::walk::{names_of_effects, names_of_step, names_of_tests, quantified_in_tests};
use crate::diag::{Problem, Problems};
use crate::syntax::ast::{self, Clause, Effect, Item, Name, Step, Test};

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    for item in linted.items {
        match item {
            Item::Method(method) => of_method(method, problems),
            Item::Action(action) => {
                for clause in &action.clauses {
                    match clause {
                        Clause::Preconditions(tests, _) | Clause::Constraints(tests, _) => in_tests(tests, problems),
                        Clause::Effects(effects, _) => in_effects(effects, problems),
                        _ => {}
                    }
                }
            }
            Item::Fact(fact) => in_tests(fact.body.as_deref().unwrap_or_default(), problems),
            _ => {}
        }
    }
}

fn of_method(method: &ast::Method, problems: &mut Problems) {
    for (tests, _) in &method.goals {
        in_tests(tests, problems);
    }
    let mut said: BTreeSet<String> = BTreeSet::new();
    for (tests, _) in &method.goals {
        names_of_tests(tests, &mut |name| _ = said.insert(name.text.clone()));
    }
    for decomposition in &method.decompositions {
        in_tests(&decomposition.preconditions, problems);
        names_of_tests(&decomposition.preconditions, &mut |name| {
            _ = said.insert(name.text.clone())
        });
        // What the lines below speak of, from the last one up: a filter that only speaks of its own variable makes no use of it.
        let mut below: BTreeSet<&str> = BTreeSet::new();
        for step in decomposition.steps.iter().rev() {
            let bound = match step {
                Step::Select(select) => {
                    in_tests(&select.filter, problems);
                    let help = "each entity that passes gives the same plan again; to ask whether one exists \
                                write `EXIST` in the preconditions";
                    Some((&select.name, help))
                }
                Step::Let(binding) => Some((&binding.name, "remove the line")),
                Step::Subtask(_) => None,
            };
            if let Some((name, help)) = bound.filter(|(name, _)| !below.contains(name.text.as_str())) {
                problems.push(variable(name, help));
            }
            names_of_step(step, &mut |name| _ = below.insert(&name.text));
        }
        said.extend(below.into_iter().map(str::to_owned));
    }
    // A method that says nothing yet is not finished.
    let is_empty = |d: &ast::Decomposition| d.preconditions.is_empty() && d.steps.is_empty();
    if method.decompositions.iter().all(is_empty) {
        return;
    }
    for param in &method.params {
        let name = &param.name;
        if !said.contains(&name.text) && !name.text.starts_with('_') {
            let message = format!(
                "parameter `{}` of method `{}` is never used",
                name.text, method.name.text
            );
            let problem = Problem::warning("hatp::unused-parameter", message, name.span, "nothing speaks of it");
            let help = format!("remove it, or call it `_{}` if it must stay", name.text);
            problems.push(problem.help(help));
        }
    }
}

/// Says whether the walk meets the name.
fn says<'a>(name: &Name, walk: impl FnOnce(&mut dyn FnMut(&'a Name))) -> bool {
    let mut is_said = false;
    walk(&mut |n| is_said |= n.text == name.text);
    is_said
}

fn in_tests(tests: &[Test], problems: &mut Problems) {
    quantified_in_tests(tests, &mut |var, guard, body| {
        let is_said = says(var, |f| {
            names_of_tests(guard, f);
            names_of_tests(body, f);
        });
        // `EXIST(Agent B, {})` asks whether there is one.
        let is_bare = guard.is_empty() && body.is_empty();
        if !is_said && !is_bare {
            problems.push(variable(
                var,
                "what is tested is the same for each entity; test it without `FORALL` or `EXIST`",
            ));
        }
    });
}

fn in_effects(effects: &[Effect], problems: &mut Problems) {
    for effect in effects {
        match effect {
            Effect::Assign(_) => {}
            Effect::Forall {
                var, guard, effects, ..
            } => {
                let is_said = says(var, |f| {
                    names_of_tests(guard, f);
                    names_of_effects(effects, f);
                });
                if !is_said {
                    problems.push(variable(
                        var,
                        "the effects are the same for each entity; write them without `FORALL`",
                    ));
                }
                in_tests(guard, problems);
                in_effects(effects, problems);
            }
            Effect::If {
                test, then, otherwise, ..
            } => {
                in_tests(test, problems);
                in_effects(then, problems);
                in_effects(otherwise, problems);
            }
        }
    }
}

fn variable(name: &Name, help: &str) -> Problem {
    let message = format!("`{}` is never used", name.text);
    Problem::warning("hatp::unused-variable", message, name.span, "bound here").help(help)
}
