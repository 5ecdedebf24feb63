//! A task that nothing reaches.
//!
//! Planning starts at the task that is named, or at any method that no other method calls: a domain may serve many worlds.
//! Told is what none of these reaches: an action that no method calls, methods that only call each other. A domain whose methods call
//! nothing starts at its actions. Tasks of imported files are for others, too, and are not told.

use std::collections::BTreeSet;

use super::Linted;
use crate::diag::{Problem, Problems};
use crate::ir::{Domain, MethodId, TaskId};
use crate::syntax::ast::Name;

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    let domain = linted.domain;
    let ids = (0..domain.methods.len()).map(|i| MethodId(i as u32));
    if ids.clone().all(|id| calls(domain, id).next().is_none()) {
        return;
    }
    let of_others = |id: MethodId| calls(domain, id).filter(move |task| *task != TaskId::Method(id));
    let called: BTreeSet<TaskId> = ids.clone().flat_map(of_others).collect();
    let mut roots: Vec<TaskId> = ids.map(TaskId::Method).filter(|task| !called.contains(task)).collect();
    roots.extend(linted.tasks.iter().filter_map(|name| domain.task(name)));
    if roots.is_empty() {
        // Every method is called by another: the domain does not say where it starts.
        return;
    }
    let reached = reach(domain, roots);
    let (actions, methods) = (&linted.actions, &linted.methods);
    let actions = actions.iter().map(|(written, _)| ("action", &written.name));
    let methods = methods.iter().map(|(written, _)| ("method", &written.name));
    for (what, name) in actions.chain(methods) {
        let is_own = linted.main.is_none_or(|main| name.span.file == main);
        if is_own && domain.task(&name.text).is_some_and(|task| !reached.contains(&task)) {
            problems.push(unreached(what, name));
        }
    }
}

/// Returns the tasks that are among `roots` or below them.
pub(super) fn reach(domain: &Domain, roots: Vec<TaskId>) -> BTreeSet<TaskId> {
    let mut open = roots;
    let mut reached = BTreeSet::new();
    while let Some(task) = open.pop() {
        if reached.insert(task)
            && let TaskId::Method(method) = task
        {
            open.extend(calls(domain, method));
        }
    }
    reached
}

fn calls(domain: &Domain, method: MethodId) -> impl Iterator<Item = TaskId> + '_ {
    let method = domain.methods.get(method.index());
    let decompositions = method.into_iter().flat_map(|m| &m.decompositions);
    decompositions.flat_map(|d| &d.subtasks).map(|s| s.task)
}

fn unreached(what: &str, name: &Name) -> Problem {
    let message = format!("nothing reaches {what} `{}`", name.text);
    let (label, help) = if what == "action" {
        ("no method calls it", "call it in a method's `subtasks`, or remove it")
    } else {
        (
            "only called from itself or from what nothing reaches",
            "call it in a method's `subtasks`, name it as the task to plan, or remove it",
        )
    };
    Problem::warning("hatp::unreached-task", message, name.span, label).help(help)
}
