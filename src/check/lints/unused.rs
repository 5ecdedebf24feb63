//! Variables and parameters that nothing speaks of. A name that begins with `_` is meant to be unused.
//!
//! Parameters of actions stand in the plan and those of functions may be asked for by a caller; only a method's are told.

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
    for decomposition in &method.decompositions {
        in_tests(&decomposition.preconditions, problems);
        for (i, step) in decomposition.steps.iter().enumerate() {
            let (name, help) = match step {
                Step::Select(select) => {
                    in_tests(&select.filter, problems);
                    let help = "each entity that passes gives the same plan again; to ask whether one exists \
                                write `EXIST` in the preconditions";
                    (&select.name, help)
                }
                Step::Let(binding) => (&binding.name, "remove the line"),
                Step::Subtask(_) => continue,
            };
            // A filter that only speaks of its own variable makes no use of it.
            let others = decomposition.steps.iter().skip(i + 1);
            if !says(name, |f| others.for_each(|step| names_of_step(step, f))) {
                problems.push(variable(name, help));
            }
        }
    }
    // A method that says nothing yet is not finished.
    let is_empty = |d: &ast::Decomposition| d.preconditions.is_empty() && d.steps.is_empty();
    if method.decompositions.iter().all(is_empty) {
        return;
    }
    for param in &method.params {
        let is_used = says(&param.name, |f| {
            method.goals.iter().for_each(|(tests, _)| names_of_tests(tests, f));
            for decomposition in &method.decompositions {
                names_of_tests(&decomposition.preconditions, f);
                decomposition.steps.iter().for_each(|step| names_of_step(step, f));
            }
        });
        if !is_used && !param.name.text.starts_with('_') {
            let name = &param.name;
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
fn says(name: &Name, walk: impl FnOnce(&mut dyn FnMut(&Name))) -> bool {
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
        if !is_said && !(guard.is_empty() && body.is_empty()) {
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
