//! Takes up tasks: evaluates the arguments of subtasks, decomposes methods, binds variables.

use super::explain::show_test;
use super::observe::Event;
use super::outcome::{NONE, Node};
use super::prepare::Join;
use super::refusals::Kind;
use super::search::{Choice, Flow, Point, Search};
use crate::ir::{Binder, Domain, Expr, MethodId, SelectOrder, TaskId, Test, TypeId, Value, Var, show_expr};
use crate::plan::Refusal;

impl<'a> Search<'a> {
    /// Takes a subtask off the agenda and reaches its task.
    pub fn start_subtask(&mut self, cell: u32, subtask: u32) -> Flow {
        let domain = self.context.domain;
        let parent = self.agenda.cell(cell).node;
        self.agenda.begin(self.prepared, cell, subtask, self.guard());
        let Node {
            task,
            frame,
            decomposition,
            depth,
            ..
        } = self.tree.nodes[parent as usize];
        let Some(decomposition) = decomposition_of(domain, task, decomposition) else {
            return Flow::Back;
        };
        let todo = &decomposition.subtasks[subtask as usize];
        let start = self.tree.values.len();
        for (position, arg) in todo.args.iter().enumerate() {
            match self.context.value(arg, &mut self.tree.values[frame as usize..]) {
                Some(Value::Null) | None => {
                    self.tree.values.truncate(start);
                    let task = domain.task_name(todo.task);
                    let print = [u64::from(cell_kind(todo.task)), position as u64];
                    return self.refuse_in(parent, Kind::NullArgument, parent, &print, |search| {
                        search.null_argument(parent, task.to_owned(), position, arg)
                    });
                }
                Some(value) => self.tree.values.push(value),
            }
        }
        let node = self.tree.nodes.len() as u32;
        self.tree.nodes.push(Node {
            task: todo.task,
            frame: start as u32,
            parent,
            subtask,
            decomposition: NONE,
            depth: depth + 1,
            at: self.steps.len() as u32,
            head: self.agenda.head,
            streak: 0,
            anchor: NONE,
            returns: 0,
        });
        self.rest -= self.bounds.task(todo.task);
        self.reach(node)
    }

    /// Takes up the task of a tree node: applies an action, or decomposes a method whose goal does not hold yet.
    pub fn reach(&mut self, node: u32) -> Flow {
        if self.is_spent(self.statistics.expansions) {
            self.budget_spent = true;
            return Flow::Back;
        }
        self.statistics.expansions += 1;
        self.tell_taken_up(node);
        self.context.reads.clear();
        let Node { task, frame, depth, .. } = self.tree.nodes[node as usize];
        match task {
            TaskId::Action(action) => self.try_action(node, action),
            TaskId::Method(id) => {
                self.note_streak(node);
                if depth as usize > self.settings.budget.depth {
                    return self.refuse_depth(node);
                }
                let method = &self.context.domain.methods[id.index()];
                let n_args = self.tree.values.len();
                self.tree
                    .values
                    .resize(frame as usize + method.n_vars.max(method.params.len()), Value::Null);
                if let Some(goal) = &method.goal
                    && self.context.holds(goal, &mut self.tree.values[frame as usize..])
                {
                    self.tree.values.truncate(n_args);
                    self.tell(|_| Event::GoalHeld { node });
                    let guard = self.guard();
                    self.agenda.finish(self.prepared, node, guard);
                    return Flow::Forward;
                }
                if let Some(flow) = self.refuse_cycle(node) {
                    return flow;
                }
                let point = self.point();
                if !self.is_new(&point, Some(node), node, depth) {
                    return Flow::Back;
                }
                self.decompose(point, node, 0)
            }
        }
    }

    /// Applies the first decomposition from `next` on whose precondition holds; leaves a choice point for the rest.
    pub fn decompose(&mut self, point: Point, node: u32, next: u32) -> Flow {
        let Node { task, frame, .. } = self.tree.nodes[node as usize];
        let TaskId::Method(id) = task else { return Flow::Back };
        let method = &self.context.domain.methods[id.index()];
        if self.random.is_some() {
            return self.decompose_drawn(point, node);
        }
        for (index, decomposition) in method.decompositions.iter().enumerate().skip(next as usize) {
            if !self.passes(&decomposition.preconditions, node, frame as usize, index as u64) {
                continue;
            }
            if index + 1 < method.decompositions.len() {
                let next = index as u32 + 1;
                self.choices.push((point, Choice::Decomposition { node, next }));
            }
            self.tree.nodes[node as usize].decomposition = index as u32;
            self.tell(|_| Event::Decomposed {
                node,
                decomposition: index as u32,
            });
            return self.bind_from(node, id, index, 0);
        }
        Flow::Back
    }

    /// Runs the binders of a decomposition from `binder` on; when all are done, puts it on the agenda.
    pub fn bind_from(&mut self, node: u32, method: MethodId, index: usize, binder: usize) -> Flow {
        let domain = self.context.domain;
        let decomposition = &domain.methods[method.index()].decompositions[index];
        let frame = self.tree.nodes[node as usize].frame as usize;
        let prepared = self.prepared.order(self.prepared.number(method, index));
        for (number, b) in decomposition.binders.iter().enumerate().skip(binder) {
            for early in &prepared.early[number] {
                if !self.context.holds(&early.test, &mut self.tree.values[frame..]) {
                    return self.refuse_binding(node, early.binder);
                }
            }
            match b {
                Binder::Let { var, value, .. } => {
                    // A path through NULL names NULL; tests on it then fail like the path itself.
                    let value = self.context.value(value, &mut self.tree.values[frame..]);
                    self.tree.values[frame + var.index()] = value.unwrap_or(Value::Null);
                }
                Binder::Select { order, .. } => {
                    let number = number as u32;
                    let found = match order {
                        SelectOrder::Sorted { .. } => self.bind_sorted(node, number),
                        SelectOrder::Declared if self.random.is_some() => self.bind_drawn(node, number),
                        SelectOrder::Declared | SelectOrder::Once => {
                            let next = self.passing(node, number, 0);
                            next.map(|next| {
                                let point = self.point();
                                self.bind_next(point, node, number, next)
                            })
                        }
                    };
                    return found.unwrap_or_else(|| self.refuse_binding(node, number));
                }
            }
        }
        self.rest += self.bounds.sum(decomposition);
        if let Some(flow) = self.too_costly() {
            return flow;
        }
        if decomposition.subtasks.is_empty() {
            let guard = self.guard();
            self.agenda.finish(self.prepared, node, guard);
        } else {
            let number = self.prepared.number(method, index);
            self.agenda.open(self.prepared, node, number);
        }
        Flow::Forward
    }

    fn refuse_binding(&mut self, node: u32, binder: u32) -> Flow {
        let domain = self.context.domain;
        let Some(Binder::Select {
            var,
            var_name,
            ty,
            filter,
            ..
        }) = self.binder(node, binder)
        else {
            return Flow::Back;
        };
        let Node {
            decomposition: which,
            frame,
            ..
        } = self.tree.nodes[node as usize];
        let more = [u64::from(which), u64::from(binder)];
        self.refuse_asking(Kind::NoBinding, node, &more, |search| Refusal::NoBinding {
            task: search.show(node),
            variable: var_name.clone(),
            candidates: domain.types[ty.index()].entities.len(),
            filter: search.show_filter(filter, *var, var_name, *ty, frame as usize),
            rule: {
                let names = search.names(node, Some(which as usize));
                show_test(domain, filter, &|v| {
                    let known = names.iter().rev().find(|(var, _)| *var == v);
                    known.map_or_else(String::new, |(_, name)| name.clone())
                })
            },
        })
    }

    /// Returns a filter in words; of several parts each with how many entities pass it alone.
    fn show_filter(&mut self, filter: &Test, var: Var, var_name: &str, ty: TypeId, frame: usize) -> String {
        let domain = self.context.domain;
        let parts = match filter {
            Test::And(parts) => parts.as_slice(),
            other => std::slice::from_ref(other),
        };
        let entities = &domain.types[ty.index()].entities;
        let shown = parts.iter().map(|part| {
            let text = show_test(domain, part, &|v| match v == var {
                true => var_name.to_owned(),
                false => domain.show(&self.tree.values[frame + v.index()]),
            });
            if parts.len() == 1 {
                return text;
            }
            let values = &mut self.tree.values[frame..];
            let passing = entities.iter().filter(|e| {
                values[var.index()] = Value::Entity(**e);
                self.context.holds(part, values)
            });
            match passing.count() {
                0 => format!("{text} (none)"),
                n => format!("{text} ({n} of them)"),
            }
        });
        shown.collect::<Vec<_>>().join("; ")
    }

    /// Returns the refusal of a task whose argument is NULL; `node` has the variables.
    pub fn null_argument(&self, node: u32, task: String, position: usize, arg: &Expr) -> Refusal {
        let Node {
            frame, decomposition, ..
        } = self.tree.nodes[node as usize];
        let domain = self.context.domain;
        let value = |v: Var| domain.show(&self.tree.values[frame as usize + v.index()]);
        let names = self.names(node, Some(decomposition as usize));
        let name = |v: Var| {
            let known = names.iter().rev().find(|(var, _)| *var == v);
            known.map_or_else(|| value(v), |(_, name)| name.clone())
        };
        Refusal::NullArgument {
            task,
            position,
            argument: show_expr(domain, arg, &value),
            rule: show_expr(domain, arg, &name),
        }
    }

    pub fn binder(&self, node: u32, binder: u32) -> Option<&'a Binder> {
        let Node {
            task, decomposition, ..
        } = self.tree.nodes[node as usize];
        decomposition_of(self.context.domain, task, decomposition)?
            .binders
            .get(binder as usize)
    }

    /// Returns the position of the first entity from `from` on that passes a SELECT's filter.
    pub fn passing(&mut self, node: u32, binder: u32, from: u32) -> Option<u32> {
        let domain = self.context.domain;
        let Node {
            task,
            decomposition,
            frame,
            ..
        } = self.tree.nodes[node as usize];
        let TaskId::Method(method) = task else { return None };
        let of_node = decomposition_of(domain, task, decomposition)?;
        let Some(Binder::Select { var, ty, filter, .. }) = of_node.binders.get(binder as usize) else {
            return None;
        };
        let (frame, var) = (frame as usize, var.index());
        let entities = &domain.types[ty.index()].entities;
        let number = self.prepared.number(method, decomposition as usize);
        let passes = |search: &mut Self, filter: &Test, at: usize| {
            search.tree.values[frame + var] = Value::Entity(entities[at]);
            search.context.holds(filter, &mut search.tree.values[frame..])
        };
        let from = from as usize;
        let found = match &self.prepared.order(number).joins[binder as usize] {
            // There is one at most, and it has been seen.
            Join::Is { .. } if from > 0 => None,
            Join::Is { value, rest } => {
                // Where there is no such value, no entity is it.
                let Some(Value::Entity(e)) = self.context.value(value, &mut self.tree.values[frame..]) else {
                    return None;
                };
                let at = entities.binary_search(&e).ok()?;
                passes(self, rest, at).then_some(at)
            }
            Join::Has { value, rest, places } => {
                match self.context.value(value, &mut self.tree.values[frame..])? {
                    Value::Entity(e) => {
                        let places = &places[e.index()];
                        let first = places.partition_point(|at| (*at as usize) < from);
                        let mut places = places[first..].iter().map(|at| *at as usize);
                        places.find(|at| passes(self, rest, *at))
                    }
                    // NULL: those without a value are not listed, and no set has it as a member.
                    _ => (from..entities.len()).find(|at| passes(self, filter, *at)),
                }
            }
            Join::Member { set, rest } => {
                let members = match self.context.value(set, &mut self.tree.values[frame..]) {
                    Some(Value::Set(members)) => members,
                    _ => return None,
                };
                let first = *entities.get(from)?;
                let mut places = members.iter_from(first).filter_map(|e| entities.binary_search(&e).ok());
                places.find(|at| passes(self, rest, *at))
            }
            Join::None { rest } => (from..entities.len()).find(|at| passes(self, rest, *at)),
        };
        found.map(|at| at as u32)
    }

    /// Binds a SELECT's variable to the entity at a position; leaves a choice point if another one passes.
    pub fn bind_next(&mut self, point: Point, node: u32, binder: u32, at: u32) -> Flow {
        let domain = self.context.domain;
        let Some(Binder::Select { ty, order, .. }) = self.binder(node, binder) else {
            return Flow::Back;
        };
        let value = Value::Entity(domain.types[ty.index()].entities[at as usize]);
        if !matches!(order, SelectOrder::Once)
            && let Some(next) = self.passing(node, binder, at + 1)
        {
            self.choices.push((point, Choice::Binding { node, binder, next }));
        }
        self.bind(node, binder, value)
    }

    /// Binds a SELECTORDERED's variable to the first of its entities; `None` if there is none.
    fn bind_sorted(&mut self, node: u32, binder: u32) -> Option<Flow> {
        let domain = self.context.domain;
        let Node {
            task,
            decomposition,
            frame,
            ..
        } = self.tree.nodes[node as usize];
        let of_node = decomposition_of(domain, task, decomposition)?;
        let Some(Binder::Select { var, ty, order, .. }) = of_node.binders.get(binder as usize) else {
            return None;
        };
        let SelectOrder::Sorted { key, descending } = order else {
            return None;
        };
        let entities = &domain.types[ty.index()].entities;
        let mut passing = Vec::new();
        let mut next = self.passing(node, binder, 0);
        while let Some(at) = next {
            let frame = &mut self.tree.values[frame as usize..];
            frame[var.index()] = Value::Entity(entities[at as usize]);
            passing.push((self.context.number(key, frame), at));
            next = self.passing(node, binder, at + 1);
        }
        self.draw(&mut passing);
        // Stable: ties stay in declaration order; entities without a number come last.
        passing.sort_by(|(a, _), (b, _)| match (a, b) {
            // INVARIANT: a number that an expression gives is finite; `total_cmp` would tell -0 from 0.
            (Some(a), Some(b)) => {
                let order = a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
                if *descending { order.reverse() } else { order }
            }
            (a, b) => a.is_none().cmp(&b.is_none()),
        });
        let value = |(_, at): &(Option<f64>, u32)| Value::Entity(entities[*at as usize]);
        let mut left: Vec<Value> = passing.iter().rev().map(value).collect();
        let first = left.pop()?;
        if !left.is_empty() {
            let point = self.point();
            self.choices.push((point, Choice::Sorted { node, binder, left }));
        }
        Some(self.bind(node, binder, first))
    }

    /// Gives a SELECT's variable its value and goes on with the next binder.
    pub fn bind(&mut self, node: u32, binder: u32, value: Value) -> Flow {
        let Node {
            task,
            decomposition,
            frame,
            ..
        } = self.tree.nodes[node as usize];
        if let Some(Binder::Select { var, var_name, .. }) = self.binder(node, binder) {
            let at = frame as usize + var.index();
            self.tree.values[at] = value;
            self.tell(|search| Event::Bound {
                node,
                variable: var_name,
                value: &search.tree.values[at],
            });
        }
        let TaskId::Method(method) = task else {
            return Flow::Back;
        };
        self.bind_from(node, method, decomposition as usize, binder as usize + 1)
    }
}

impl<'a> Search<'a> {
    /// Returns the task of a node's subtask, and its arguments.
    pub fn subtask_of(&self, node: u32, subtask: usize) -> (TaskId, &'a [crate::ir::Expr]) {
        let Node {
            task, decomposition, ..
        } = self.tree.nodes[node as usize];
        let of = decomposition_of(self.context.domain, task, decomposition);
        let subtask = of.and_then(|d| d.subtasks.get(subtask));
        subtask.map_or((task, &[]), |s| (s.task, s.args.as_slice()))
    }
}

fn decomposition_of(domain: &Domain, task: TaskId, index: u32) -> Option<&crate::ir::Decomposition> {
    match task {
        TaskId::Method(m) => domain.methods[m.index()].decompositions.get(index as usize),
        TaskId::Action(_) => None,
    }
}

/// Returns a number that tells tasks apart.
fn cell_kind(task: TaskId) -> u32 {
    match task {
        TaskId::Action(a) => a.0 << 1,
        TaskId::Method(m) => m.0 << 1 | 1,
    }
}
