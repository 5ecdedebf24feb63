//! A method that calls itself with the same arguments, and nothing before the call changes what it tests: it never ends.
//!
//! Only direct calls are looked at. What geometry decides counts as changed by every action that projects.

use std::collections::BTreeSet;

use super::Linted;
use super::read::Read;
use super::unreached_task::reach;
use crate::diag::{Problem, Problems};
use crate::ir::{Binder, Decomposition, Domain, Expr, Method, MethodId, TaskId};
use crate::syntax::ast::{self, Step};

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    for (i, (written, method)) in linted.methods.iter().enumerate() {
        let itself = TaskId::Method(MethodId(i as u32));
        for (written, way) in written.decompositions.iter().zip(&method.decompositions) {
            let steps = written.steps.iter().filter_map(|step| match step {
                Step::Subtask(subtask) => Some(subtask),
                Step::Select(_) | Step::Let(_) => None,
            });
            for (j, (step, subtask)) in steps.zip(&way.subtasks).enumerate() {
                let mut args = subtask.args.iter().enumerate();
                let is_same = args.all(|(k, arg)| matches!(arg, Expr::Var(v) if v.index() == k));
                if subtask.task == itself && is_same && !may_end(linted.domain, method, way, j) {
                    problems.push(endless(&method.name, step));
                }
            }
        }
    }
}

/// Says whether something before the call at `at` may change what the method or this decomposition tests.
fn may_end(domain: &Domain, method: &Method, way: &Decomposition, at: usize) -> bool {
    let mut tested = Read::default();
    method.goal.iter().for_each(|goal| tested.test(goal));
    tested.test(&way.preconditions);
    for binder in &way.binders {
        if let Binder::Select { filter, .. } = binder {
            tested.test(filter);
        }
    }
    let is_after = |j: usize| super::contradicts_goal::before(way, j).contains(&at);
    let others = way
        .subtasks
        .iter()
        .enumerate()
        .filter(|(j, _)| *j != at && !is_after(*j));
    let mut changed = BTreeSet::new();
    let mut moves = false;
    for task in reach(domain, others.map(|(_, s)| s.task).collect()) {
        let TaskId::Action(action) = task else { continue };
        if let Some(action) = domain.actions.get(action.index()) {
            Read::default().effects(&action.effects, &mut changed);
            moves |= action.projects.is_some();
        }
    }
    let is_shared = |a: &crate::ir::AttributeId| domain.attributes.get(a.index()).is_some_and(|a| a.fact.is_some());
    !tested.attributes.is_disjoint(&changed)
        || moves && (tested.asks_geometry || tested.attributes.iter().any(is_shared))
}

fn endless(method: &str, step: &ast::Subtask) -> Problem {
    let message = format!("method `{method}` calls itself, and nothing that it tests has changed");
    let problem = Problem::warning("hatp::endless-recursion", message, step.span, "the same again");
    problem.help("test in `goal` or `preconditions` what a subtask before this one changes, or give it other arguments")
}
