//! Depth-first search for plans with an explicit stack of choice points.
//!
//! After thesis Algorithms 8 to 12 (SHOP's total order: Nau et al., IJCAI 1999), with their open points decided:
//! - goals and SELECTs, absent from the algorithms, are tested when a method is reached and when it is decomposed;
//! - unordered subtasks are blocks: one is expanded to its actions before its sibling starts, every order is tried
//!   (instead of locking tasks, Algorithm 9);
//! - arguments of a subtask are evaluated when the subtask is reached;
//! - a projected action is a choice point over its geometric alternatives, up to the branching factor (Algorithm 12, lines 27-32).
//!
//! Nothing is copied at a choice point: what grew since is cut off, what changed is undone by the state's trail.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

use super::changes::changes;
use super::eval::{Context, defined_fact, frame};
use super::explain::failed_literal;
use super::ground;
use super::outcome::{Ending, Found, Outcome, Settings, Statistics, Step, Tree, TreeNode, Truncated};
use super::reasoner::{Call, GasNum, GasRef, Mark, Projection, Reasoner};
use super::state::{State, TrailMark};
use crate::ir::{ActionId, Binder, Domain, Goal, MethodId, SelectOrder, SlotId, TaskId, Value};
use crate::plan::{Refusal, WhyNot};

/// A decomposition at work: the method's frame and which subtasks it has.
#[derive(Debug)]
struct Instance {
    method: MethodId,
    decomposition: usize,
    frame: Vec<Value>,
    node: usize,
    depth: usize,
}

/// An entry of the agenda: an instance with the subtasks done so far; below it, what comes after the instance.
#[derive(Debug)]
struct Cell {
    parent: Option<usize>,
    instance: usize,
    done: Vec<bool>,
}

/// Lengths and marks to go back to.
#[derive(Debug, Clone, Copy)]
struct Point {
    trail: TrailMark,
    world: Mark,
    head: Option<usize>,
    cells: usize,
    instances: usize,
    nodes: usize,
    steps: usize,
    cost: f64,
}

#[derive(Debug)]
enum Choice {
    /// Decompositions of the method at a tree node, from `next` on.
    Decomposition { node: usize, depth: usize, next: usize },
    /// Values of a SELECT of an instance.
    Binding {
        instance: usize,
        binder: usize,
        candidates: Vec<Value>,
        next: usize,
    },
    /// Which of the ready subtasks of a cell comes first.
    Order {
        cell: usize,
        ready: Vec<usize>,
        next: usize,
    },
    /// Further geometric solutions of an action.
    Alternative {
        node: usize,
        gas: GasNum,
        tried: u32,
        limit: u32,
    },
}

/// Whether the search goes on forward or has to take back a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flow {
    Forward,
    Back,
}

/// Searches for a plan of `goal`; `stop` ends the search from outside; `on_plan` hears of each (better) plan as it comes.
///
/// The reasoner is left in the world state of the start.
pub fn solve(
    domain: &Domain,
    goal: &Goal,
    reasoner: &mut dyn Reasoner,
    settings: &Settings,
    stop: &AtomicBool,
    on_plan: &mut dyn FnMut(&Found, &Statistics),
) -> Outcome {
    let shared: Vec<SlotId> = (0..domain.slots.len())
        .map(|i| SlotId(i as u32))
        .filter(|s| {
            let place = domain.slots[s.index()];
            let attribute = &domain.attributes[place.attribute.index()];
            attribute.fact.as_deref().is_some_and(|fact| {
                if defined_fact(domain, fact).is_some() {
                    reasoner.has_world()
                } else {
                    reasoner.knows(domain, fact, place.entity)
                }
            })
        })
        .collect();
    let mut state = State::new(domain, &shared);
    let start_world = reasoner.save();
    let mut search = Search {
        context: Context::new(domain, &mut state, reasoner),
        settings,
        shared: &shared,
        cells: Vec::new(),
        instances: Vec::new(),
        nodes: Vec::new(),
        steps: Vec::new(),
        choices: Vec::new(),
        head: None,
        cost: 0.0,
        best: None,
        statistics: Statistics::default(),
        truncated: Truncated::default(),
        why_not: WhyNot::default(),
        budget_spent: false,
    };
    let ending = search.run(goal, stop, on_plan);
    let Search {
        best,
        statistics,
        why_not,
        context,
        ..
    } = search;
    context.reasoner.restore(start_world);
    Outcome {
        found: best,
        ending,
        statistics,
        why_not,
    }
}

struct Search<'a> {
    context: Context<'a>,
    settings: &'a Settings,
    shared: &'a [SlotId],
    cells: Vec<Cell>,
    instances: Vec<Instance>,
    nodes: Vec<TreeNode>,
    steps: Vec<Step>,
    choices: Vec<(Point, Choice)>,
    head: Option<usize>,
    cost: f64,
    best: Option<Found>,
    statistics: Statistics,
    truncated: Truncated,
    why_not: WhyNot,
    /// Whether a task could not be taken up for want of budget.
    budget_spent: bool,
}

impl Search<'_> {
    fn run(&mut self, goal: &Goal, stop: &AtomicBool, on_plan: &mut dyn FnMut(&Found, &Statistics)) -> Ending {
        self.nodes.push(TreeNode {
            task: goal.task,
            args: goal.args.clone(),
            parent: None,
            subtask: 0,
            decomposition: None,
        });
        let mut flow = self.reach(0, 0);
        loop {
            if flow == Flow::Forward && self.head.is_none() {
                self.record(on_plan);
                if !self.settings.best {
                    return Ending::FirstPlan;
                }
                flow = Flow::Back;
            }
            if flow == Flow::Back {
                self.note_deepest();
            }
            if stop.load(Ordering::Relaxed) {
                self.note_deepest();
                return Ending::Interrupted;
            }
            if self.budget_spent {
                self.note_deepest();
                return Ending::BudgetSpent;
            }
            flow = match flow {
                Flow::Forward => self.advance(),
                Flow::Back => match self.choices.pop() {
                    Some((point, choice)) => {
                        if self.statistics.backtracks >= self.settings.budget.expansions {
                            return Ending::BudgetSpent;
                        }
                        self.statistics.backtracks += 1;
                        // A better plan may have been found since this choice was made.
                        match self.too_costly(point.cost) {
                            Some(refusal) => self.refuse(refusal),
                            None => self.retry(point, choice),
                        }
                    }
                    None if self.truncated == Truncated::default() => return Ending::Exhausted,
                    None => return Ending::ExhaustedTruncated(self.truncated),
                },
            };
        }
    }

    /// Remembers the branch at hand if none was longer. Called where a branch ends: on the way forward it would be written
    /// down anew for every action.
    fn note_deepest(&mut self) {
        if self.steps.len() > self.why_not.deepest.len() {
            self.why_not.deepest = self.steps.iter().map(|s| self.show_node(s.node)).collect();
        }
    }

    /// Takes up the next task of the agenda.
    fn advance(&mut self) -> Flow {
        let Some(cell) = self.head else { return Flow::Forward };
        let Cell { parent, instance, done } = &self.cells[cell];
        let Instance {
            method, decomposition, ..
        } = &self.instances[*instance];
        let subtasks = &self.context.domain.methods[method.index()].decompositions[*decomposition].subtasks;
        let ready: Vec<usize> = (0..subtasks.len())
            .filter(|i| !done[*i] && subtasks[*i].after.iter().all(|a| done[*a]))
            .collect();
        match ready.len() {
            // INVARIANT: the order has no cycle (checked), so nothing ready means all done.
            0 => {
                self.head = *parent;
                Flow::Forward
            }
            1 => self.start_subtask(cell, ready[0]),
            _ => {
                let (point, choice) = (self.point(), Choice::Order { cell, ready, next: 0 });
                self.retry(point, choice)
            }
        }
    }

    fn point(&mut self) -> Point {
        Point {
            trail: self.context.state.mark(),
            world: self.context.reasoner.save(),
            head: self.head,
            cells: self.cells.len(),
            instances: self.instances.len(),
            nodes: self.nodes.len(),
            steps: self.steps.len(),
            cost: self.cost,
        }
    }

    fn go_back(&mut self, point: &Point) {
        self.context.reads.clear();
        self.context.state.restore(point.trail);
        self.context.reasoner.restore(point.world);
        self.head = point.head;
        self.cells.truncate(point.cells);
        self.instances.truncate(point.instances);
        self.nodes.truncate(point.nodes);
        self.steps.truncate(point.steps);
        self.cost = point.cost;
    }

    /// Goes back to a choice point and takes its next option; the choice stays on the stack while it has more.
    fn retry(&mut self, point: Point, choice: Choice) -> Flow {
        self.go_back(&point);
        match choice {
            Choice::Decomposition { node, depth, next } => self.decompose(point, node, depth, next),
            Choice::Binding {
                instance,
                binder,
                candidates,
                next,
            } => {
                let value = candidates[next].clone();
                if next + 1 < candidates.len() {
                    self.choices.push((
                        point,
                        Choice::Binding {
                            instance,
                            binder,
                            candidates,
                            next: next + 1,
                        },
                    ));
                }
                self.bind(instance, binder, value)
            }
            Choice::Order { cell, ready, next } => {
                let subtask = ready[next];
                if next + 1 < ready.len() {
                    self.choices.push((
                        point,
                        Choice::Order {
                            cell,
                            ready,
                            next: next + 1,
                        },
                    ));
                }
                self.start_subtask(cell, subtask)
            }
            Choice::Alternative {
                node,
                gas,
                tried,
                limit,
            } => {
                self.statistics.projections += 1;
                self.statistics.alternatives += 1;
                self.read_before(node);
                match self.context.reasoner.find_alternative(gas, tried) {
                    Ok(projection) => {
                        self.push_alternatives(point, node, projection, limit);
                        self.apply_action(node, Some((point, projection)))
                    }
                    Err(refusal) => {
                        self.truncated.geometry += u64::from(!refusal.exhausted);
                        self.refuse(Refusal::Geometry(refusal))
                    }
                }
            }
        }
    }

    /// Notes what an action's precondition, the arguments of its projection and its constraints read, in the world state
    /// before the action.
    fn read_before(&mut self, node: usize) {
        let TaskId::Action(id) = self.nodes[node].task else {
            return;
        };
        let action = &self.context.domain.actions[id.index()];
        let mut frame = frame(&self.nodes[node].args, action.n_vars);
        self.context.reads.clear();
        self.context.holds(&action.preconditions, &mut frame);
        if let Some(projection) = &action.projects {
            for arg in &projection.args {
                self.context.value(arg, &mut frame);
            }
            ground::formula(&mut self.context, &action.constraints, &mut frame);
        }
    }

    fn push_alternatives(&mut self, point: Point, node: usize, projection: Projection, limit: u32) {
        let GasRef { gas, alternative } = projection.gas;
        let tried = alternative + 1;
        if tried < limit {
            self.choices.push((
                point,
                Choice::Alternative {
                    node,
                    gas,
                    tried,
                    limit,
                },
            ));
        } else {
            // HEURISTIC: counted as cut short even if geometry has no further solution: only asking would tell.
            self.truncated.alternatives += 1;
        }
    }

    fn refuse(&mut self, refusal: Refusal) -> Flow {
        self.why_not.add(&refusal);
        Flow::Back
    }

    /// Marks a subtask of the cell as taken up and reaches its task.
    fn start_subtask(&mut self, cell: usize, subtask: usize) -> Flow {
        let domain = self.context.domain;
        let Cell { parent, instance, done } = &self.cells[cell];
        let (parent, instance) = (*parent, *instance);
        let mut done = done.clone();
        done[subtask] = true;
        self.cells.push(Cell { parent, instance, done });
        self.head = Some(self.cells.len() - 1);
        let Instance {
            method,
            decomposition,
            frame,
            node,
            depth,
        } = &mut self.instances[instance];
        let todo = &domain.methods[method.index()].decompositions[*decomposition].subtasks[subtask];
        let mut args = Vec::with_capacity(todo.args.len());
        for (position, arg) in todo.args.iter().enumerate() {
            match self.context.value(arg, frame) {
                Some(value) if value != Value::Null => args.push(value),
                _ => {
                    let task = domain.task_name(todo.task).to_owned();
                    return self.refuse(Refusal::NullArgument { task, position });
                }
            }
        }
        let (parent, depth) = (Some(*node), *depth + 1);
        self.nodes.push(TreeNode {
            task: todo.task,
            args,
            parent,
            subtask,
            decomposition: None,
        });
        self.reach(self.nodes.len() - 1, depth)
    }

    /// Takes up the task of a tree node: applies an action, or decomposes a method whose goal does not hold yet.
    fn reach(&mut self, node: usize, depth: usize) -> Flow {
        if self.statistics.expansions >= self.settings.budget.expansions {
            self.budget_spent = true;
            return Flow::Back;
        }
        self.statistics.expansions += 1;
        self.context.reads.clear();
        let domain = self.context.domain;
        match self.nodes[node].task {
            TaskId::Action(action) => self.try_action(node, action),
            TaskId::Method(method) => {
                if depth > self.settings.budget.depth {
                    self.truncated.depth += 1;
                    return self.refuse(Refusal::TooDeep {
                        task: self.show_node(node),
                        depth: self.settings.budget.depth,
                    });
                }
                let method = &domain.methods[method.index()];
                if let Some(goal) = &method.goal {
                    let mut frame = frame(&self.nodes[node].args, method.n_vars);
                    if self.context.holds(goal, &mut frame) {
                        self.nodes[node].decomposition = None;
                        return Flow::Forward;
                    }
                }
                let point = self.point();
                self.decompose(point, node, depth, 0)
            }
        }
    }

    /// Applies the first decomposition from `next` on whose precondition holds; leaves a choice point for the rest.
    fn decompose(&mut self, point: Point, node: usize, depth: usize, next: usize) -> Flow {
        let domain = self.context.domain;
        let TaskId::Method(id) = self.nodes[node].task else {
            return Flow::Back;
        };
        let method = &domain.methods[id.index()];
        for (index, decomposition) in method.decompositions.iter().enumerate().skip(next) {
            let mut frame = frame(&self.nodes[node].args, method.n_vars);
            if !self.context.holds(&decomposition.preconditions, &mut frame) {
                let (literal, met) = failed_literal(&mut self.context, &decomposition.preconditions, &mut frame);
                let task = self.show_node(node);
                self.why_not.add(&Refusal::Precondition { task, literal, met });
                continue;
            }
            if index + 1 < method.decompositions.len() {
                self.choices.push((
                    point,
                    Choice::Decomposition {
                        node,
                        depth,
                        next: index + 1,
                    },
                ));
            }
            self.nodes[node].decomposition = Some(index);
            self.instances.push(Instance {
                method: id,
                decomposition: index,
                frame,
                node,
                depth,
            });
            return self.bind_from(self.instances.len() - 1, 0);
        }
        Flow::Back
    }

    /// Runs the binders of an instance from `binder` on; when all are done, puts it on the agenda.
    fn bind_from(&mut self, instance: usize, binder: usize) -> Flow {
        let domain = self.context.domain;
        let Instance {
            method,
            decomposition,
            frame,
            node,
            ..
        } = &mut self.instances[instance];
        let decomposition = &domain.methods[method.index()].decompositions[*decomposition];
        let node = *node;
        for (index, b) in decomposition.binders.iter().enumerate().skip(binder) {
            match b {
                Binder::Let { var, value, .. } => {
                    // A path through NULL names NULL; tests on it then fail like the path itself.
                    frame[var.index()] = self.context.value(value, frame).unwrap_or(Value::Null);
                }
                Binder::Select {
                    var,
                    var_name,
                    ty,
                    filter,
                    order,
                } => {
                    let all = &domain.types[ty.index()].entities;
                    let mut candidates = Vec::new();
                    for e in all {
                        frame[var.index()] = Value::Entity(*e);
                        if self.context.holds(filter, frame) {
                            let key = match order {
                                SelectOrder::Sorted { key, .. } => self.context.number(key, frame),
                                SelectOrder::Declared | SelectOrder::Once => None,
                            };
                            candidates.push((key, Value::Entity(*e)));
                            if matches!(order, SelectOrder::Once) {
                                break;
                            }
                        }
                    }
                    if let SelectOrder::Sorted { descending, .. } = order {
                        // Stable: ties stay in declaration order; entities without a number come last.
                        candidates.sort_by(|(a, _), (b, _)| match (a, b) {
                            // INVARIANT: a number that an expression gives is finite; `total_cmp` would tell -0 from 0.
                            (Some(a), Some(b)) => {
                                let order = a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
                                if *descending { order.reverse() } else { order }
                            }
                            (a, b) => a.is_none().cmp(&b.is_none()),
                        });
                    }
                    if candidates.is_empty() {
                        let refusal = Refusal::NoBinding {
                            task: self.show_node(node),
                            variable: var_name.clone(),
                            candidates: all.len(),
                        };
                        return self.refuse(refusal);
                    }
                    let candidates = candidates.into_iter().map(|(_, v)| v).collect();
                    let (point, choice) = (
                        self.point(),
                        Choice::Binding {
                            instance,
                            binder: index,
                            candidates,
                            next: 0,
                        },
                    );
                    return self.retry(point, choice);
                }
            }
        }
        self.cells.push(Cell {
            parent: self.head,
            instance,
            done: vec![false; decomposition.subtasks.len()],
        });
        self.head = Some(self.cells.len() - 1);
        Flow::Forward
    }

    fn bind(&mut self, instance: usize, binder: usize, value: Value) -> Flow {
        let Instance {
            method,
            decomposition,
            frame,
            ..
        } = &mut self.instances[instance];
        let decomposition = &self.context.domain.methods[method.index()].decompositions[*decomposition];
        if let Binder::Select { var, .. } = &decomposition.binders[binder] {
            frame[var.index()] = value;
        }
        self.bind_from(instance, binder + 1)
    }

    /// Tests an action's precondition, projects it, and applies it.
    fn try_action(&mut self, node: usize, id: ActionId) -> Flow {
        let domain = self.context.domain;
        let action = &domain.actions[id.index()];
        let mut frame = frame(&self.nodes[node].args, action.n_vars);
        if !self.context.holds(&action.preconditions, &mut frame) {
            let (literal, met) = failed_literal(&mut self.context, &action.preconditions, &mut frame);
            let task = self.show_node(node);
            return self.refuse(Refusal::Precondition { task, literal, met });
        }
        let Some(projection) = &action.projects else {
            return self.apply_action(node, None);
        };
        let mut args = Vec::with_capacity(projection.args.len());
        for (position, arg) in projection.args.iter().enumerate() {
            match self.context.value(arg, &mut frame) {
                Some(value) if value != Value::Null => args.push(value),
                _ => {
                    return self.refuse(Refusal::NullArgument {
                        task: self.show_node(node),
                        position,
                    });
                }
            }
        }
        let constraints = ground::formula(&mut self.context, &action.constraints, &mut frame);
        let point = self.point();
        self.statistics.projections += 1;
        match self.context.reasoner.project(
            domain,
            &Call {
                name: &projection.name,
                args: &args,
                constraints: &constraints,
            },
        ) {
            Ok(solution) => {
                let limit = action.alternatives.unwrap_or(self.settings.branching);
                self.push_alternatives(point, node, solution, limit);
                self.apply_action(node, Some((point, solution)))
            }
            Err(refusal) => {
                self.truncated.geometry += u64::from(!refusal.exhausted);
                self.refuse(Refusal::Geometry(refusal))
            }
        }
    }

    /// Applies the effects; after a projection all shared attributes are read anew from geometry (thesis 4.3.5).
    /// `projected` is the point before the projection, and what it gave.
    fn apply_action(&mut self, node: usize, projected: Option<(Point, Projection)>) -> Flow {
        let domain = self.context.domain;
        let TaskId::Action(id) = self.nodes[node].task else {
            return Flow::Back;
        };
        let action = &domain.actions[id.index()];
        let args = self.nodes[node].args.clone();
        let geometric = projected.map_or((0.0, 0.0), |(_, p)| (p.cost, p.duration));
        if projected.is_none() {
            self.read_before(node);
        }
        let n_reads = self.context.reads.len();
        let (numbers, writes) = loop {
            let mut frame = frame(&args, action.n_vars);
            self.context.reads.truncate(n_reads);
            (self.context.projection, self.context.is_late) = (geometric, projected.is_some());
            let numbers =
                [&action.cost, &action.duration.0, &action.duration.1].map(|e| self.context.number(e, &mut frame));
            let mut writes = Vec::new();
            self.context.apply(&action.effects, &mut frame, &mut writes);
            (self.context.projection, self.context.is_late) = ((0.0, 0.0), false);
            let missed = std::mem::take(&mut self.context.missed);
            match projected {
                // All this looks at the world state before the projection, and what it looks at may depend on what the
                // projection gave. INVARIANT: every round knows an answer more, so there is a last one.
                Some((point, projection)) if !missed.is_empty() => {
                    self.context.state.restore(point.trail);
                    self.context.reasoner.restore(point.world);
                    self.context.catch_up(missed);
                    self.context.reasoner.replay(projection.gas);
                }
                _ => break (numbers, writes),
            }
        };
        self.context.answers.clear();
        let (cost, least, most) = match numbers {
            [Some(c), Some(l), Some(m)] if c >= 0.0 && l >= 0.0 && m >= l => (c, l, m),
            [c, l, m] => {
                let task = self.show_node(node);
                let bad = |x: &Option<f64>| x.is_none_or(|x| x < 0.0);
                let (what, value) = match (l, m) {
                    _ if bad(&c) => ("cost", c),
                    _ if bad(&l) => ("least duration", l),
                    (Some(least), Some(most)) if most >= 0.0 => {
                        return self.refuse(Refusal::DurationOrder { task, least, most });
                    }
                    _ => ("most duration", m),
                };
                return self.refuse(Refusal::BadNumber {
                    task,
                    what,
                    value: value.unwrap_or(f64::NAN),
                });
            }
        };
        let (mut reads, mut writes) = (std::mem::take(&mut self.context.reads), writes);
        for list in [&mut reads, &mut writes] {
            list.sort();
            list.dedup();
        }
        if projected.is_some() {
            for slot in self.shared {
                self.context.state.forget(*slot);
            }
        }
        self.cost += cost;
        let duration = (least.max(geometric.1), most.max(geometric.1));
        self.steps.push(Step {
            action: id,
            args,
            gas: projected.map(|(_, p)| p.gas),
            geometric,
            cost,
            duration,
            reads,
            writes,
            node,
        });
        match self.too_costly(self.cost) {
            Some(refusal) => self.refuse(refusal),
            None => Flow::Forward,
        }
    }

    /// Says why a plan that begins with this cost can't be better than the best one, if so.
    fn too_costly(&self, cost: f64) -> Option<Refusal> {
        // HEURISTIC: what is still to be done is bounded below by 0.
        let bound = self.best.as_ref()?.cost;
        (cost >= bound - COST_TOLERANCE).then_some(Refusal::TooCostly { cost, bound })
    }

    fn show_node(&self, node: usize) -> String {
        let TreeNode { task, args, .. } = &self.nodes[node];
        let args: Vec<String> = args.iter().map(|v| self.context.domain.show(v)).collect();
        format!("{}({})", self.context.domain.task_name(*task), args.join(", "))
    }

    /// Keeps the plan at hand, with what each step changed, as the best one.
    fn record(&mut self, on_plan: &mut dyn FnMut(&Found, &Statistics)) {
        let domain = self.context.domain;
        self.statistics.plans += 1;
        let mut steps = self.steps.clone();
        // What an action without geometry says of a shared attribute, the next projection overrides: that is a write too,
        // even where the value happens to stay.
        let said = steps.iter().filter(|s| s.gas.is_none()).flat_map(|s| &s.writes);
        let said: BTreeSet<SlotId> = said.copied().filter(|s| self.shared.binary_search(s).is_ok()).collect();
        for step in steps.iter_mut().filter(|s| s.gas.is_some()) {
            step.writes.extend(&said);
            step.writes.sort();
            step.writes.dedup();
        }
        let found = Found {
            steps,
            tree: Tree(self.nodes.clone()),
            cost: self.cost,
            changes: changes(domain, self.shared, &self.steps, self.context.reasoner),
        };
        on_plan(&found, &self.statistics);
        self.best = Some(found);
    }
}

/// Plans whose costs differ by less are equally good.
const COST_TOLERANCE: f64 = 1e-9;
