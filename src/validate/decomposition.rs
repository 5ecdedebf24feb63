//! Checks that the tree is a decomposition of the goal task that yields the plan's actions, in order.
//!
//! The document does not say which entities the variables of a decomposition (SELECT, `let`) stood for, so they are
//! searched for: some choice that passes the filters must give the subtasks that are there. Children stand in the order
//! of execution and each is one block (no interleaving). A subtask's arguments are read in the state in which it is
//! reached, its variables in the one in which its task was decomposed.

use super::{
    Settings,
    evaluate::View,
    fault::{Checked, Fault, Kind},
    notation,
};
use crate::ir::{Binder, Decomposition, Domain, Goal, SelectOrder, TaskId, Value};
use crate::plan::Node;

/// A tree deeper than this is refused, so that the walk never exhausts the stack.
const MAX_DEPTH: usize = 1000;

/// What the walk needs to know.
pub(super) struct Replayed<'a> {
    pub(super) domain: &'a Domain,
    /// State before each action, and the last one.
    pub(super) states: &'a [Vec<Value>],
    /// The plan's actions.
    pub(super) actions: &'a [Goal],
    pub(super) settings: &'a Settings,
}

/// A child as it is in the tree.
struct Child {
    goal: Goal,
    /// How many actions were done when it was reached.
    at: usize,
}

/// Checks the tree and returns its number of nodes.
pub(super) fn check(replayed: &Replayed<'_>, root: &Node, goal: &Goal) -> Checked<usize> {
    let domain = replayed.domain;
    let found = notation::task(domain, &root.task, &root.arguments)?;
    if found != *goal {
        return Err(Kind::Task {
            expected: notation::show_task(domain, goal.task, &goal.args),
            found: notation::show_task(domain, found.task, &found.args),
        }
        .into());
    }
    let (mut done, mut nodes) = (0, 0);
    walk(replayed, root, &found, &mut done, &mut nodes, 0)?;
    if done != replayed.actions.len() {
        return Err(Kind::Leaves {
            expected: done,
            found: "missing".to_owned(),
        }
        .into());
    }
    Ok(nodes)
}

fn walk(
    replayed: &Replayed<'_>,
    node: &Node,
    goal: &Goal,
    done: &mut usize,
    nodes: &mut usize,
    depth: usize,
) -> Checked<()> {
    *nodes += 1;
    let text = notation::show_task(replayed.domain, goal.task, &goal.args);
    let inner = match goal.task {
        TaskId::Action(_) => leaf(replayed, node, goal, done),
        TaskId::Method(_) if depth >= MAX_DEPTH => Err(Kind::NodeShape {
            what: "the tree is too deep",
        }
        .into()),
        TaskId::Method(_) => compound(replayed, node, goal, done, nodes, depth),
    };
    inner.map_err(|f| f.under_task(&text))
}

fn shape(what: &'static str) -> Fault {
    Kind::NodeShape { what }.into()
}

fn leaf(replayed: &Replayed<'_>, node: &Node, goal: &Goal, done: &mut usize) -> Checked<()> {
    if node.decomposition.is_some() || !node.children.is_empty() {
        return Err(shape("an action has neither decomposition nor children"));
    }
    let index = node.action.ok_or_else(|| shape("an action needs its index"))?;
    let action = replayed
        .actions
        .get(index)
        .filter(|_| index == *done)
        .ok_or_else(|| Kind::Leaves {
            expected: *done,
            found: format!("action {index}"),
        })?;
    if action != goal {
        return Err(Kind::LeafMismatch {
            leaf: notation::show_task(replayed.domain, goal.task, &goal.args),
            action: notation::show_task(replayed.domain, action.task, &action.args),
        }
        .into());
    }
    *done += 1;
    Ok(())
}

fn compound(
    replayed: &Replayed<'_>,
    node: &Node,
    goal: &Goal,
    done: &mut usize,
    nodes: &mut usize,
    depth: usize,
) -> Checked<()> {
    let domain = replayed.domain;
    let TaskId::Method(method) = goal.task else {
        return Err(shape("a compound task is needed"));
    };
    let method = &domain.methods[method.index()];
    if node.action.is_some() {
        return Err(shape("a compound task is no action"));
    }
    let start = *done;
    let view = View::new(domain, &replayed.states[start]);
    let mut frame = goal.args.clone();
    frame.resize(method.n_vars.max(goal.args.len()), Value::Null);
    let reached = method.goal.as_ref().map(|test| view.failing(test, &mut frame));
    let Some(index) = node.decomposition else {
        return match reached {
            _ if !node.children.is_empty() => Err(shape("children but no decomposition")),
            None => Err(shape("the task has no goal that could hold")),
            Some(Some(test)) => Err(Kind::GoalNotHeld { test }.into()),
            Some(None) => Ok(()),
        };
    };
    if reached == Some(None) {
        return Err(Kind::GoalHeldAlready {}.into());
    }
    let decomposition = method.decompositions.get(index).ok_or(Kind::NoSuchDecomposition {
        index,
        count: method.decompositions.len(),
    })?;
    if let Some(test) = view.failing(&decomposition.preconditions, &mut frame) {
        return Err(Kind::DecompositionPrecondition { index, test }.into());
    }
    let mut children = Vec::with_capacity(node.children.len());
    for child in &node.children {
        let goal = notation::task(domain, &child.task, &child.arguments)?;
        let at = *done;
        walk(replayed, child, &goal, done, nodes, depth + 1)?;
        children.push(Child { goal, at });
    }
    let mut search = Matching {
        replayed,
        decomposition,
        children: &children,
        start,
        tried: 0,
    };
    if search.bind(0, &mut frame) {
        return Ok(());
    }
    if search.tried >= replayed.settings.max_bindings {
        return Err(Kind::SubtasksUndecided {
            index,
            budget: replayed.settings.max_bindings,
        }
        .into());
    }
    let texts: Vec<String> = children
        .iter()
        .map(|c| notation::show_task(domain, c.goal.task, &c.goal.args))
        .collect();
    Err(Kind::Subtasks {
        index,
        children: format!("[{}]", texts.join(", ")),
    }
    .into())
}

/// Search for values of a decomposition's variables that explain its children.
struct Matching<'a> {
    replayed: &'a Replayed<'a>,
    decomposition: &'a Decomposition,
    children: &'a [Child],
    /// How many actions were done when the task was decomposed.
    start: usize,
    tried: usize,
}

impl Matching<'_> {
    fn view(&self, at: usize) -> View<'_> {
        View::new(self.replayed.domain, &self.replayed.states[at])
    }

    /// Binds from binder `i` on; says whether some choice fits.
    fn bind(&mut self, i: usize, frame: &mut Vec<Value>) -> bool {
        if self.tried >= self.replayed.settings.max_bindings {
            return false;
        }
        match self.decomposition.binders.get(i) {
            None => {
                self.tried += 1;
                let mut used = vec![false; self.decomposition.subtasks.len()];
                used.len() == self.children.len() && self.place(0, &mut used, frame)
            }
            Some(Binder::Let { var, value, .. }) => {
                let value = self.view(self.start).value(value, frame).unwrap_or_default();
                frame[var.index()] = value;
                self.bind(i + 1, frame)
            }
            Some(Binder::Select {
                var, ty, filter, order, ..
            }) => {
                let entities = self.replayed.domain.types[ty.index()].entities.clone();
                for e in entities {
                    frame[var.index()] = Value::Entity(e);
                    if !self.view(self.start).holds(filter, frame) {
                        continue;
                    }
                    if self.bind(i + 1, frame) {
                        return true;
                    }
                    if matches!(order, SelectOrder::Once) {
                        return false;
                    }
                }
                false
            }
        }
    }

    /// Gives child `c` and those after it a subtask each; says whether that can be done.
    fn place(&mut self, c: usize, used: &mut [bool], frame: &[Value]) -> bool {
        let Some(child) = self.children.get(c) else {
            return true;
        };
        for (j, subtask) in self.decomposition.subtasks.iter().enumerate() {
            let ready = subtask.after.iter().all(|k| used.get(*k).copied().unwrap_or(false));
            if used[j] || !ready || subtask.task != child.goal.task {
                continue;
            }
            let view = self.view(child.at);
            let values = subtask.args.iter().map(|a| view.value(a, frame).unwrap_or_default());
            if !values.eq(child.goal.args.iter().cloned()) {
                continue;
            }
            used[j] = true;
            if self.place(c + 1, used, frame) {
                return true;
            }
            used[j] = false;
        }
        false
    }
}
