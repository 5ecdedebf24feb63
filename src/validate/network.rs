//! Reads the text of what was planned back, and holds it against the goal: one task, or a task network.
//!
//! The network's text is `Get(A, X); Get(B, Y); Sit(A) > 1, 2`: tasks are counted from 1, and `> 1, 2` says after which a
//! task comes. Written apart from the parser, so that both must agree. Knows no labels: documents have none.

use super::fault::{Checked, Kind};
use super::notation::{split, task_text};
use crate::ir::{Domain, Expr, Goal, Subtask, TaskId};

/// A task of the text, and the places (from 0) of those that it comes after, in order.
type Ordered = (Goal, Vec<usize>);

/// Says whether `text` is the task, or the task network, that `goal` is.
pub(super) fn is_goal(domain: &Domain, text: &str, goal: &Goal) -> Checked<bool> {
    let parts = split(text, ';');
    let n = parts.len();
    let tasks = parts.iter().map(|part| ordered(domain, part, n));
    let tasks = tasks.collect::<Checked<Vec<Ordered>>>()?;
    let network = domain.network.filter(|id| goal.task == TaskId::Method(*id));
    let Some(method) = network.and_then(|id| domain.methods.get(id.index())) else {
        return Ok(matches!(tasks.as_slice(), [(task, after)] if task == goal && after.is_empty()));
    };
    let same = |(subtask, (task, after)): (&Subtask, &Ordered)| {
        let mut wanted = subtask.after.clone();
        wanted.sort_unstable();
        let args = task.args.iter().cloned().map(Expr::Const);
        subtask.task == task.task && args.eq(subtask.args.iter().cloned()) && wanted == *after
    };
    Ok(match method.decompositions.as_slice() {
        [only] => only.subtasks.len() == n && only.subtasks.iter().zip(&tasks).all(same),
        _ => false,
    })
}

/// Returns the task that a part, `Sit(A) > 1, 2`, names, and after which of `n` tasks it comes.
fn ordered(domain: &Domain, part: &str, n: usize) -> Checked<Ordered> {
    let (task, marks) = match split(part, '>').as_slice() {
        [task] => (task.clone(), Vec::new()),
        [task, marks] => (task.clone(), split(marks, ',')),
        // Nothing, or marks after marks: no task has such a name.
        _ => (part.to_owned(), Vec::new()),
    };
    let mut after = Vec::with_capacity(marks.len());
    for mark in &marks {
        let place = mark.parse().ok().filter(|k: &usize| (1..=n).contains(k));
        let place = place.ok_or_else(|| Kind::Argument {
            text: part.to_owned(),
            expected: format!("a task that comes after some of the tasks 1 to {n}"),
        })?;
        after.push(place - 1);
    }
    after.sort_unstable();
    after.dedup();
    Ok((task_text(domain, &task)?, after))
}
