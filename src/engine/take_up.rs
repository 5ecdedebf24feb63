//! Takes up tasks: evaluates the arguments of subtasks, decomposes methods, binds variables.

use super::explain::show_test;
use super::observe::Event;
use super::outcome::Place;
use super::prepare::{Join, Rest};
use super::refusals::Kind;
use super::search::{Choice, Flow, Point, Search};
use crate::ir::{Binder, EntityId, Expr, MethodId, SelectOrder, TaskId, Test, TypeId, Value, Var, show_expr};
use crate::plan::Refusal;

impl<'a> Search<'a> {
    /// Takes a subtask off the agenda and reaches its task.
    pub fn start_subtask(&mut self, cell: u32, subtask: u32) -> Flow {
        let domain = self.context.domain;
        let parent = self.agenda.cell(cell).node;
        self.agenda.begin(self.prepared, cell, subtask, self.guard());
        let Some(decomposition) = self.tree.decomposition_in(domain, parent) else {
            return Flow::Back;
        };
        let frame = self.tree.nodes[parent as usize].frame;
        let todo = &decomposition.subtasks[subtask as usize];
        let start = self.tree.values.len();
        for (position, arg) in todo.args.iter().enumerate() {
            // Most arguments are variables: nothing has to be looked up.
            let value = match arg {
                Expr::Var(var) => Some(self.tree.values[frame as usize + var.index()].clone()),
                arg => self.context.value(arg, &mut self.tree.values[frame as usize..]),
            };
            match value {
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
        let place = Place {
            frame: start as u32,
            parent,
            subtask,
        };
        let at = self.steps.len() as u32;
        let node = self.tree.push(todo.task, place, at, self.agenda.head);
        if let TaskId::Method(of) = self.tree.task(parent) {
            let which = self.tree.decomposition(parent) as usize;
            self.rest -= self.bounds.subtask(of, which, subtask as usize);
        }
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
        self.note_reads();
        self.context.reads.clear();
        match self.tree.task(node) {
            TaskId::Action(action) => self.try_action(node, action),
            TaskId::Method(id) => {
                self.note_streak(node);
                let frame = self.tree.nodes[node as usize].frame;
                let depth = self.tree.inner(node).map_or(0, |inner| inner.depth);
                if depth as usize > self.settings.budget.depth {
                    return self.refuse_depth(node);
                }
                let method = &self.context.domain.methods[id.index()];
                let n_args = self.tree.values.len();
                for _ in method.params.len()..method.n_vars {
                    self.tree.values.push(Value::Null);
                }
                if let (Some(goal), Some(folded)) = (&method.goal, self.prepared.goal(id))
                    && self
                        .context
                        .holds_folded(folded, goal, &mut self.tree.values[frame as usize..])
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
                if !self.is_new(Some(node), depth) {
                    return Flow::Back;
                }
                self.decompose(None, node, 0)
            }
        }
    }

    pub fn set_decomposition(&mut self, node: u32, index: u32) {
        if let Some(inner) = self.tree.inner_mut(node) {
            inner.decomposition = index;
        }
    }

    /// Applies the first decomposition from `next` on whose precondition holds; leaves a choice point for the rest: the one
    /// that was gone back to, or one of now.
    pub fn decompose(&mut self, point: Option<Point>, node: u32, next: u32) -> Flow {
        let TaskId::Method(id) = self.tree.task(node) else {
            return Flow::Back;
        };
        let frame = self.tree.nodes[node as usize].frame;
        let (method, prepared) = (&self.context.domain.methods[id.index()], self.prepared);
        if self.random.is_some() {
            let point = point.unwrap_or_else(|| self.point());
            return self.decompose_drawn(point, node);
        }
        for (index, decomposition) in method.decompositions.iter().enumerate().skip(next as usize) {
            let folded = &prepared.order(prepared.number(id, index)).preconditions;
            let test = (&decomposition.preconditions, folded);
            if !self.passes(test, node, frame as usize, index as u64) {
                continue;
            }
            if index + 1 < method.decompositions.len() {
                let next = index as u32 + 1;
                let point = point.unwrap_or_else(|| self.point());
                self.choices.push((point, Choice::Decomposition { node, next }));
            }
            self.set_decomposition(node, index as u32);
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
                let Rest { test, folded } = &early.test;
                if !self.context.holds_folded(folded, test, &mut self.tree.values[frame..]) {
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
                    let is_drawn = self.random.is_some();
                    let found = match order {
                        SelectOrder::Sorted { .. } => self.bind_sorted(node, number as u32),
                        SelectOrder::Declared if is_drawn => self.bind_drawn(node, number as u32),
                        SelectOrder::Declared | SelectOrder::Once => {
                            let of = Select {
                                binder: b,
                                join: &prepared.joins[number],
                                frame,
                            };
                            if let Some(at) = self.passing_of(of, 0) {
                                let next = match order {
                                    SelectOrder::Once => None,
                                    SelectOrder::Declared | SelectOrder::Sorted { .. } => self.passing_of(of, at + 1),
                                };
                                if let Some(next) = next {
                                    let (point, binder) = (self.point(), number as u32);
                                    self.choices.push((point, Choice::Binding { node, binder, next }));
                                }
                                self.set_bound(node, of, at);
                                continue;
                            }
                            None
                        }
                    };
                    return found.unwrap_or_else(|| self.refuse_binding(node, number as u32));
                }
            }
        }
        self.rest += self.bounds.of(method, index);
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
        let frame = self.tree.nodes[node as usize].frame;
        let which = self.tree.decomposition(node);
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
        let frame = self.tree.nodes[node as usize].frame;
        let decomposition = self.tree.decomposition(node);
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
        let decomposition = self.tree.decomposition_in(self.context.domain, node)?;
        decomposition.binders.get(binder as usize)
    }

    /// Returns the position of the first entity from `from` on that passes a SELECT's filter.
    pub fn passing(&mut self, node: u32, binder: u32, from: u32) -> Option<u32> {
        let of = self.select(node, binder)?;
        self.passing_of(of, from)
    }

    fn select(&self, node: u32, binder: u32) -> Option<Select<'a>> {
        let TaskId::Method(method) = self.tree.task(node) else {
            return None;
        };
        let prepared = self.prepared;
        let number = prepared.number(method, self.tree.decomposition(node) as usize);
        Some(Select {
            binder: self.binder(node, binder)?,
            join: &prepared.order(number).joins[binder as usize],
            frame: self.tree.nodes[node as usize].frame as usize,
        })
    }

    fn passing_of(&mut self, of: Select<'a>, from: u32) -> Option<u32> {
        let Select { binder, join, frame } = of;
        let Binder::Select { var, ty, filter, .. } = binder else {
            return None;
        };
        let var = var.index();
        let entities = &self.context.domain.types[ty.index()].entities;
        let passes = |search: &mut Self, rest: &Rest, at: usize| {
            search.tree.values[frame + var] = Value::Entity(entities[at]);
            let values = &mut search.tree.values[frame..];
            search.context.holds_folded(&rest.folded, &rest.test, values)
        };
        let passes_whole = |search: &mut Self, at: usize| {
            search.tree.values[frame + var] = Value::Entity(entities[at]);
            search.context.holds(filter, &mut search.tree.values[frame..])
        };
        let from = from as usize;
        let found = match join {
            // There is one at most, and it has been seen.
            Join::Is { .. } if from > 0 => None,
            Join::Is { value, rest } => {
                // Where there is no such value, no entity is it.
                let Some(Value::Entity(e)) = self.context.value(value, &mut self.tree.values[frame..]) else {
                    return None;
                };
                let at = place_of(entities, e)?;
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
                    _ => (from..entities.len()).find(|at| passes_whole(self, *at)),
                }
            }
            Join::Member { set, rest } => {
                let members = match self.context.value(set, &mut self.tree.values[frame..]) {
                    Some(Value::Set(members)) => members,
                    _ => return None,
                };
                let first = *entities.get(from)?;
                let mut places = members.iter_from(first).filter_map(|e| place_of(entities, e));
                places.find(|at| passes(self, rest, *at))
            }
            Join::None { rest } => (from..entities.len()).find(|at| passes(self, rest, *at)),
        };
        found.map(|at| at as u32)
    }

    /// Binds a SELECT's variable to the entity at a position; leaves a choice point if another one passes.
    pub fn bind_next(&mut self, point: Point, node: u32, binder: u32, at: u32) -> Flow {
        let (Some(of), TaskId::Method(method)) = (self.select(node, binder), self.tree.task(node)) else {
            return Flow::Back;
        };
        if let Some(next) = self.passing_of(of, at + 1) {
            self.choices.push((point, Choice::Binding { node, binder, next }));
        }
        self.set_bound(node, of, at);
        let decomposition = self.tree.decomposition(node);
        self.bind_from(node, method, decomposition as usize, binder as usize + 1)
    }

    /// Gives a SELECT's variable the entity at a position.
    fn set_bound(&mut self, node: u32, of: Select<'a>, at: u32) {
        let Binder::Select { var, var_name, ty, .. } = of.binder else {
            return;
        };
        let place = of.frame + var.index();
        self.tree.values[place] = Value::Entity(self.context.domain.types[ty.index()].entities[at as usize]);
        self.tell(|search| Event::Bound {
            node,
            variable: var_name,
            value: &search.tree.values[place],
        });
    }

    /// Binds a SELECTORDERED's variable to the first of its entities; `None` if there is none.
    fn bind_sorted(&mut self, node: u32, binder: u32) -> Option<Flow> {
        let domain = self.context.domain;
        let frame = self.tree.nodes[node as usize].frame;
        let Some(Binder::Select { var, ty, order, .. }) = self.binder(node, binder) else {
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
        let frame = self.tree.nodes[node as usize].frame;
        if let Some(Binder::Select { var, var_name, .. }) = self.binder(node, binder) {
            let at = frame as usize + var.index();
            self.tree.values[at] = value;
            self.tell(|search| Event::Bound {
                node,
                variable: var_name,
                value: &search.tree.values[at],
            });
        }
        let TaskId::Method(method) = self.tree.task(node) else {
            return Flow::Back;
        };
        let decomposition = self.tree.decomposition(node);
        self.bind_from(node, method, decomposition as usize, binder as usize + 1)
    }
}

/// A SELECT at its turn.
#[derive(Clone, Copy)]
struct Select<'a> {
    binder: &'a Binder,
    join: &'a Join,
    frame: usize,
}

/// Returns where an entity stands among those of a type, which are in order and mostly one behind the other.
fn place_of(entities: &[EntityId], e: EntityId) -> Option<usize> {
    let near = e.index().checked_sub(entities.first()?.index())?;
    match entities.get(near) {
        Some(other) if *other == e => Some(near),
        _ => entities.binary_search(&e).ok(),
    }
}

impl<'a> Search<'a> {
    /// Returns the task of a node's subtask, and its arguments.
    pub fn subtask_of(&self, node: u32, subtask: usize) -> (TaskId, &'a [crate::ir::Expr]) {
        let of = self.tree.decomposition_in(self.context.domain, node);
        let subtask = of.and_then(|d| d.subtasks.get(subtask));
        subtask.map_or((self.tree.task(node), &[]), |s| (s.task, s.args.as_slice()))
    }
}

/// Returns a number that tells tasks apart.
fn cell_kind(task: TaskId) -> u32 {
    match task {
        TaskId::Action(a) => a.0 << 1,
        TaskId::Method(m) => m.0 << 1 | 1,
    }
}
