//! Checks that the tree is a decomposition of the goal task that yields the plan's actions, in order.
//!
//! The document does not say which entities the variables of a decomposition (SELECT, `let`) stood for, so they are
//! searched for: some choice that passes the filters must give the subtasks that are there. Nodes stand in the order in which
//! they were taken up, a task's before its subtasks', and each subtask is one block, unless the plan says that it is
//! interleaved: then a task may be taken up at any time when all that it comes after is over. A subtask's arguments are read
//! in the state in which it is reached, its variables in the one in which its task was decomposed.
//!
//! Where the domain orders subtasks, the links must say so: see [`Ordered`].
//!
//! One pass over the nodes; the tasks at work (in blocks: from the root down to the node at hand) are on a stack of its own,
//! so a tree may be as deep as it likes.

use std::rc::Rc;

use super::{
    Settings,
    evaluate::View,
    fault::{Checked, Fault, Kind},
    history::History,
    notation,
    ordered::Ordered,
    requests::Asked,
};
use crate::ir::{Binder, Decomposition, Domain, Goal, SelectOrder, TaskId, Value};
use crate::plan::Node;

/// What the walk needs to know.
pub(super) struct Replayed<'a> {
    pub(super) domain: &'a Domain,
    /// State before each action, and the last one.
    pub(super) states: &'a History,
    /// The world before each action, and the last one.
    pub(super) worlds: &'a [Rc<Asked<'a>>],
    /// The plan's actions.
    pub(super) actions: &'a [Goal],
    /// Whether unordered subtasks may mix.
    pub(super) interleaved: bool,
    /// What is right before each action by the links; `None` if they go nowhere, which is a fault of its own.
    pub(super) links: Option<&'a [Vec<usize>]>,
    pub(super) settings: &'a Settings,
}

impl Replayed<'_> {
    /// Returns the state after so many actions.
    fn view(&self, at: usize) -> View<'_> {
        View::past(self.domain, (self.states, at), Some(&self.worlds[at]))
    }
}

/// A child as it is in the tree.
struct Child {
    goal: Goal,
    /// How many actions were done when it was reached.
    at: usize,
    node: usize,
    /// The last node at or below it.
    end: usize,
}

/// A task whose subtasks are being looked at.
struct Open<'a> {
    /// Its node's index, and that of its parent.
    node: usize,
    parent: Option<usize>,
    goal: Goal,
    /// Which decomposition of its method was applied.
    index: usize,
    decomposition: &'a Decomposition,
    /// Its arguments, and room for its variables.
    frame: Vec<Value>,
    /// How many actions were done when it was decomposed.
    start: usize,
    children: Vec<Child>,
}

/// Checks the tree; returns the fault of the first subtasks whose order no links say.
pub(super) fn check(replayed: &Replayed<'_>, nodes: &[Node], goal: &Goal) -> Checked<Option<Fault>> {
    let root = nodes.first().ok_or_else(|| shape("the tree has no nodes"))?;
    let domain = replayed.domain;
    let found = notation::task(domain, &root.task, &root.arguments)?;
    if found != *goal {
        return Err(Kind::Task {
            expected: notation::show_task(domain, goal.task, &goal.args),
            found: notation::show_task(domain, found.task, &found.args),
        }
        .into());
    }
    let mut walk = Walk {
        replayed,
        path: Vec::new(),
        under: None,
        done: 0,
        ends: ends(nodes),
        ordered: replayed.links.map(|links| Ordered::new(nodes, links)),
        unordered: None,
    };
    walk.nodes(nodes).map_err(|fault| walk.on_path(fault))?;
    if walk.done != replayed.actions.len() {
        return Err(Kind::Leaves {
            expected: walk.done,
            found: "missing".to_owned(),
        }
        .into());
    }
    Ok(walk.unordered)
}

fn shape(what: &'static str) -> Fault {
    Kind::NodeShape { what }.into()
}

/// Where the pass over the nodes is.
struct Walk<'a> {
    replayed: &'a Replayed<'a>,
    /// The tasks at work, the root first; each is a subtask of the one before it.
    path: Vec<Open<'a>>,
    /// Which of them the pass is at: the parent of the node at hand.
    under: Option<usize>,
    /// How many actions are done.
    done: usize,
    /// Of each node, the last one at or below it.
    ends: Vec<usize>,
    ordered: Option<Ordered<'a>>,
    /// The first fault that it has found.
    unordered: Option<Fault>,
}

/// Returns for each node the last one at or below it.
fn ends(nodes: &[Node]) -> Vec<usize> {
    let mut ends: Vec<usize> = (0..nodes.len()).collect();
    for (i, node) in nodes.iter().enumerate().rev() {
        // A parent that does not stand before is a fault of its own, found in the pass.
        if let Some(parent) = node.parent.filter(|p| *p < i) {
            ends[parent] = ends[parent].max(ends[i]);
        }
    }
    ends
}

impl<'a> Walk<'a> {
    /// Returns the fault as one under the tasks at work.
    fn on_path(&self, fault: Fault) -> Fault {
        let mut fault = fault;
        let mut at = self.under.and_then(|i| self.path.get(i));
        while let Some(open) = at {
            fault = fault.under_task(&notation::show_task(
                self.replayed.domain,
                open.goal.task,
                &open.goal.args,
            ));
            let above = self.path.binary_search_by_key(&open.parent, |o| Some(o.node));
            at = above.ok().and_then(|i| self.path.get(i));
        }
        fault
    }

    /// Looks at all nodes, in order. A fault is one under the path as it is then.
    fn nodes(&mut self, nodes: &[Node]) -> Checked<()> {
        let domain = self.replayed.domain;
        for (i, node) in nodes.iter().enumerate() {
            let parent = self.parent(i, node)?;
            self.under = parent;
            let goal = notation::task(domain, &node.task, &node.arguments)?;
            if let Some(parent) = parent.and_then(|p| self.path.get_mut(p)) {
                parent.children.push(Child {
                    goal: goal.clone(),
                    at: self.done,
                    node: i,
                    end: self.ends[i],
                });
            }
            let has_children = self.ends[i] > i;
            let text = || notation::show_task(domain, goal.task, &goal.args);
            match goal.task {
                TaskId::Action(_) => self
                    .leaf(node, &goal, has_children)
                    .map_err(|fault| fault.under_task(&text()))?,
                TaskId::Method(_) => {
                    let open = self
                        .compound(i, node, &goal, has_children)
                        .map_err(|fault| fault.under_task(&text()))?;
                    self.path.extend(open);
                }
            }
        }
        self.under = self.path.len().checked_sub(1);
        while let Some(open) = self.path.last_mut() {
            close(self.replayed, open, self.ordered.as_mut(), &mut self.unordered)?;
            self.path.pop();
            self.under = self.path.len().checked_sub(1);
        }
        Ok(())
    }

    /// Returns where the parent of node `i` is among the tasks at work. In blocks, all below it ends.
    fn parent(&mut self, i: usize, node: &Node) -> Checked<Option<usize>> {
        self.under = self.path.len().checked_sub(1);
        let wrong = |what| Err(shape(what).under_task(&format!("{}({})", node.task, node.arguments.join(", "))));
        match node.parent {
            None if i == 0 => return Ok(None),
            Some(_) if i == 0 => return wrong("the first node is the root, which has no parent"),
            None => return wrong("only the first node has no parent"),
            // The path goes down the list.
            Some(parent) if self.path.binary_search_by_key(&parent, |open| open.node).is_err() => {
                return wrong("its parent is not at work: nodes stand in the order of execution");
            }
            Some(_) => {}
        }
        if self.replayed.interleaved {
            let at = self.path.binary_search_by_key(&node.parent, |open| Some(open.node));
            return Ok(at.ok());
        }
        while let Some(open) = self.path.last_mut().filter(|open| node.parent != Some(open.node)) {
            close(self.replayed, open, self.ordered.as_mut(), &mut self.unordered)?;
            self.path.pop();
            self.under = self.path.len().checked_sub(1);
        }
        Ok(self.under)
    }

    fn leaf(&mut self, node: &Node, goal: &Goal, has_children: bool) -> Checked<()> {
        if node.decomposition.is_some() || has_children {
            return Err(shape("an action has neither decomposition nor children"));
        }
        let index = node.action.ok_or_else(|| shape("an action needs its index"))?;
        let action = self
            .replayed
            .actions
            .get(index)
            .filter(|_| index == self.done)
            .ok_or_else(|| Kind::Leaves {
                expected: self.done,
                found: format!("action {index}"),
            })?;
        if action != goal {
            return Err(Kind::LeafMismatch {
                leaf: notation::show_task(self.replayed.domain, goal.task, &goal.args),
                action: notation::show_task(self.replayed.domain, action.task, &action.args),
            }
            .into());
        }
        self.done += 1;
        Ok(())
    }

    /// Returns the task at work, or `None` if its goal held and there is nothing to do.
    fn compound(&self, i: usize, node: &Node, goal: &Goal, has_children: bool) -> Checked<Option<Open<'a>>> {
        let domain = self.replayed.domain;
        let TaskId::Method(method) = goal.task else {
            return Err(shape("a compound task is needed"));
        };
        let method = &domain.methods[method.index()];
        if node.action.is_some() {
            return Err(shape("a compound task is no action"));
        }
        let view = self.replayed.view(self.done);
        let mut frame = goal.args.clone();
        frame.resize(method.n_vars.max(goal.args.len()), Value::Null);
        let reached = method.goal.as_ref().map(|test| view.failing(test, &mut frame));
        let Some(index) = node.decomposition else {
            return match reached {
                _ if has_children => Err(shape("children but no decomposition")),
                None => Err(shape("the task has no goal that could hold")),
                Some(Some(test)) => Err(Kind::GoalNotHeld { test }.into()),
                Some(None) => Ok(None),
            };
        };
        if let Some(test) = &method.goal
            && view.strict().holds(test, &mut frame)
        {
            return Err(Kind::GoalHeldAlready {}.into());
        }
        let decomposition = method.decompositions.get(index).ok_or(Kind::NoSuchDecomposition {
            index,
            count: method.decompositions.len(),
        })?;
        if let Some(test) = view.failing(&decomposition.preconditions, &mut frame) {
            return Err(Kind::DecompositionPrecondition { index, test }.into());
        }
        Ok(Some(Open {
            node: i,
            parent: node.parent,
            goal: goal.clone(),
            index,
            decomposition,
            frame,
            start: self.done,
            children: Vec::new(),
        }))
    }
}

/// Checks that some choice of a task's variables gives the subtasks that it has, in an order that the links say.
fn close(
    replayed: &Replayed<'_>,
    open: &mut Open<'_>,
    ordered: Option<&mut Ordered<'_>>,
    unordered: &mut Option<Fault>,
) -> Checked<()> {
    let mut search = Matching {
        replayed,
        decomposition: open.decomposition,
        children: &open.children,
        start: open.start,
        tried: 0,
        linked: None,
        found: Vec::new(),
    };
    let index = open.index;
    if search.bind(0, &mut open.frame) {
        let Some(ordered) = ordered else { return Ok(()) };
        if let Some((before, after)) = ordered.unordered(open.decomposition, &search.found) {
            // Of two equal subtasks, the links may say which one is which.
            let mut other = Matching {
                tried: 0,
                linked: Some(&*ordered),
                found: Vec::new(),
                ..search
            };
            match other.bind(0, &mut open.frame) {
                true => search.found = other.found,
                false => {
                    unordered.get_or_insert_with(|| Kind::OrderMissing { before, after }.into());
                }
            }
        }
        ordered.close(open.node, open.decomposition, &search.found);
        return Ok(());
    }
    if search.tried >= replayed.settings.max_bindings {
        return Err(Kind::SubtasksUndecided {
            index,
            budget: replayed.settings.max_bindings,
        }
        .into());
    }
    let texts: Vec<String> = open
        .children
        .iter()
        .map(|c| notation::show_task(replayed.domain, c.goal.task, &c.goal.args))
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
    /// Where the links must say the order of the subtasks.
    linked: Option<&'a Ordered<'a>>,
    /// The node of each subtask.
    found: Vec<Option<usize>>,
}

impl Matching<'_> {
    fn view(&self, at: usize) -> View<'_> {
        self.replayed.view(at)
    }

    /// Binds from binder `i` on; says whether some choice fits.
    fn bind(&mut self, i: usize, frame: &mut Vec<Value>) -> bool {
        if self.tried >= self.replayed.settings.max_bindings {
            return false;
        }
        match self.decomposition.binders.get(i) {
            None => {
                self.tried += 1;
                let mut used = vec![None; self.decomposition.subtasks.len()];
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
                let domain = self.replayed.domain;
                for e in &domain.types[ty.index()].entities {
                    frame[var.index()] = Value::Entity(*e);
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
    /// `used` has the child that each subtask is given to.
    fn place(&mut self, c: usize, used: &mut [Option<usize>], frame: &[Value]) -> bool {
        let Some(child) = self.children.get(c) else {
            self.found = used.iter().map(|c| c.map(|c| self.children[c].node)).collect();
            let Some(linked) = self.linked else { return true };
            self.tried += 1;
            return linked.unordered(self.decomposition, &self.found).is_none();
        };
        for (j, subtask) in self.decomposition.subtasks.iter().enumerate() {
            if self.linked.is_some() && self.tried >= self.replayed.settings.max_bindings {
                return false;
            }
            let end = |k: &usize| used.get(*k).copied().flatten().map(|c| self.children[c].end);
            let is_over = |k: &usize| end(k).is_some_and(|end| end < child.node);
            if used[j].is_some() || !subtask.after.iter().all(is_over) || subtask.task != child.goal.task {
                continue;
            }
            let view = self.view(child.at);
            let values = subtask.args.iter().map(|a| view.value(a, frame).unwrap_or_default());
            if !values.eq(child.goal.args.iter().cloned()) {
                continue;
            }
            used[j] = Some(c);
            if self.place(c + 1, used, frame) {
                return true;
            }
            used[j] = None;
        }
        false
    }
}
