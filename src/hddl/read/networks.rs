//! Methods, and task networks with their order.

use indexmap::IndexMap;

use super::super::ast::{Formula, Kinds, Method, Network, Scope, Step, TaskRef, Term};
use super::super::problems;
use super::super::tree::Tree;
use super::formulas::Visible;
use super::{Clause, Reader, key};
use crate::source::Span;

const CLAUSES: &[&str] = &[
    ":parameters",
    ":task",
    ":precondition",
    ":ordered-subtasks",
    ":ordered-tasks",
    ":subtasks",
    ":tasks",
    ":ordering",
    ":constraints",
];

impl Reader<'_> {
    pub(super) fn read_method(&mut self, rest: &[Tree<'_>], span: Span) {
        let Some(name) = self.named(rest, "the method", span) else {
            return;
        };
        let clauses = self.clauses(&rest[1..], "a method", CLAUSES, &[":effect", ":duration"]);
        let of = |part: &str| clauses.iter().find(|(p, ..)| *p == part).map(|(.., value)| *value);
        let (mut scope, mut visible) = (Scope::default(), Vec::new());
        if let Some(params) = of(":parameters").and_then(Tree::list) {
            self.variables(params, &mut scope, &mut visible);
        }
        let n_params = scope.0.len();
        let Some(task) = of(":task") else {
            let what = "`:task`";
            self.problems
                .push(problems::missing(what, &format!("method `{}`", name.text), name.span));
            return;
        };
        let head = self.step(task, &scope, &visible);
        let precondition = of(":precondition").map(|tree| self.formula(tree, &mut scope, &mut visible));
        let network = self.network(&clauses, &mut scope, &mut visible);
        match head {
            Some(Step {
                task: TaskRef::Task(task),
                args,
            }) => self.pair.methods.push(Method {
                name,
                task,
                task_args: args,
                scope,
                n_params,
                precondition: precondition.unwrap_or_default(),
                network,
            }),
            Some(Step {
                task: TaskRef::Action(_),
                ..
            }) => self
                .problems
                .push(problems::expected("a task that is no action", task.span)),
            None => {}
        }
    }

    /// Reads `(go ?x home)`.
    fn step(&mut self, tree: &Tree<'_>, scope: &Scope, visible: &Visible) -> Option<Step> {
        let Some((head, rest)) = tree.headed() else {
            self.problems
                .push(problems::expected("a task such as `(go ?x ?y)`", tree.span));
            return None;
        };
        let name = head.word()?;
        let Some(task) = self.tasks.get(&key(name)).copied() else {
            let actions = self.pair.actions.iter().map(|a| a.name.text.as_str());
            let known = self.pair.tasks.iter().map(|t| t.name.text.as_str()).chain(actions);
            self.problems.push(problems::unknown_task(name, head.span, known));
            rest.iter().for_each(|t| {
                self.term(t, scope, visible);
            });
            return None;
        };
        let wanted: Vec<Kinds> = self.params_of(task).iter().map(|v| v.kinds.clone()).collect();
        let args: Vec<Term> = self.args(name, head, rest, &wanted, scope, visible)?;
        Some(Step { task, args })
    }

    /// Reads subtasks, their order and their constraints.
    pub(super) fn network(&mut self, clauses: &[Clause<'_, '_>], scope: &mut Scope, visible: &mut Visible) -> Network {
        let mut network = Network::default();
        let mut labels: IndexMap<String, (usize, Span)> = IndexMap::new();
        let mut is_ordered = false;
        let mut first: Option<Span> = None;
        for (part, place, value) in clauses {
            let ordered = [":ordered-subtasks", ":ordered-tasks"].contains(part);
            if !ordered && ![":subtasks", ":tasks"].contains(part) {
                continue;
            }
            if first.replace(*place).is_some() {
                self.problems.push(problems::twice("list of subtasks", *place));
                continue;
            }
            is_ordered = ordered;
            let steps = match value.headed() {
                Some((head, steps)) if head.is("and") => steps,
                Some(_) => std::slice::from_ref(*value),
                None => value.list().unwrap_or_default(),
            };
            for step in steps {
                let labelled = match step.list() {
                    Some([label, task]) if label.word().is_some() && task.list().is_some() => Some((label, task)),
                    _ => None,
                };
                let read = self.step(labelled.map_or(step, |(_, task)| task), scope, visible);
                if let Some((label, _)) = labelled {
                    let word = label.word().unwrap_or_default();
                    // A step that is wrong keeps its label: what refers to it is right.
                    let at = if read.is_some() {
                        network.steps.len()
                    } else {
                        usize::MAX
                    };
                    if let Some((_, first)) = labels.insert(key(word), (at, label.span)) {
                        self.problems
                            .push(problems::duplicate("label", word, label.span, first));
                    }
                }
                network.steps.extend(read);
            }
        }
        let n = network.steps.len();
        network.after = match is_ordered {
            true => (0..n).map(|step| step.checked_sub(1).into_iter().collect()).collect(),
            false => vec![Vec::new(); n],
        };
        for (part, place, value) in clauses {
            if *part == ":ordering" {
                self.ordering(value, *place, &labels, &mut network);
            } else if *part == ":constraints" {
                let constraints = self.formula(value, scope, visible);
                network.constraints = match std::mem::take(&mut network.constraints) {
                    Formula::And(all) if all.is_empty() => constraints,
                    other => Formula::And(vec![other, constraints]),
                };
            }
        }
        network
    }

    /// Reads `(and (< a b) ...)`.
    fn ordering(
        &mut self,
        tree: &Tree<'_>,
        place: Span,
        labels: &IndexMap<String, (usize, Span)>,
        network: &mut Network,
    ) {
        let pairs = match tree.headed() {
            Some((head, pairs)) if head.is("and") => pairs,
            Some(_) => std::slice::from_ref(tree),
            None => tree.list().unwrap_or_default(),
        };
        for pair in pairs {
            let ends = match pair.headed() {
                Some((head, [one, other])) if head.is("<") => Some((one, other)),
                _ => None,
            };
            let Some((before, after)) = ends else {
                self.problems
                    .push(problems::expected("an order such as `(< a b)`", pair.span));
                continue;
            };
            let ends = [before, after].map(|label| {
                let word = label.word().unwrap_or_default();
                let found = labels.get(&key(word));
                if found.is_none() {
                    let known = labels.keys().map(String::as_str);
                    self.problems
                        .push(problems::unknown_name("label", word, label.span, known));
                }
                found.map(|(at, _)| *at)
            });
            if let [Some(before), Some(after)] = ends
                && before < network.steps.len()
                && after < network.steps.len()
                && !network.after[after].contains(&before)
            {
                network.after[after].push(before);
            }
        }
        if network.order().0.len() < network.steps.len() {
            self.problems.push(problems::order_cycle(place));
            network.after.iter_mut().for_each(Vec::clear);
        }
    }
}
