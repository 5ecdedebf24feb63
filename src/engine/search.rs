//! Depth-first search for plans with an explicit stack of choice points.
//!
//! After thesis Algorithms 8 to 12 (SHOP's total order: Nau et al., IJCAI 1999), with their open points decided:
//! - goals and SELECTs, absent from the algorithms, are tested when a method is reached and when it is decomposed;
//! - unordered subtasks are blocks: one is expanded to its actions before its sibling starts, every order is tried
//!   (instead of locking tasks, Algorithm 9); or, interleaved, any task that is ready may be next at every step;
//! - arguments of a subtask are evaluated when the subtask is reached;
//! - a projected action is a choice point over its geometric alternatives, up to the branching factor (Algorithm 12, lines 27-32).
//!
//! Nothing is copied at a choice point: what grew since is cut off, what changed is undone by the state's trail. Tasks are
//! taken up in `take_up`, actions applied in `act`; what is left out is decided in `cycle`, `memo` and `bound`.

use std::sync::atomic::{AtomicBool, Ordering};

use super::agenda::{Agenda, AgendaMark};
use super::bound::{self, Bounds};
use super::eval::{Context, defined_fact};
use super::kept::Kept;
use super::memo::Memo;
use super::objective::{Objective, Sight};
use super::observe::{Event, Observer};
use super::outcome::{Aim, Ending, Found, NONE, Node, Outcome, Settings, Statistics, Step, Tree, Truncated};
use super::prepare::Prepared;
use super::reasoner::{GasNum, Mark, Reasoner};
use super::record::Recorder;
use super::refusals::{Kind, Reasons};
use super::state::{State, TrailMark};
use crate::ir::{Domain, Goal, SlotId, Value};
use crate::plan::Refusal;

/// Lengths and marks to go back to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub trail: TrailMark,
    pub world: Mark,
    agenda: AgendaMark,
    nodes: u32,
    values: u32,
    steps: u32,
    slots: u32,
    news: u32,
    cost: f64,
    /// The least cost of what is still to be done.
    rest: u64,
}

#[derive(Debug)]
pub(super) enum Choice {
    /// Decompositions of the method at a tree node, from `next` on.
    Decomposition { node: u32, next: u32 },
    /// Values of a SELECT of a node: entities of its type from position `next` on, which is one that passes.
    Binding { node: u32, binder: u32, next: u32 },
    /// Values of a SELECT in an order of its own, the last one first.
    Sorted { node: u32, binder: u32, left: Vec<Value> },
    /// Which of the ready subtasks comes next, from this one on.
    Order { cell: u32, subtask: u32 },
    /// Further geometric solutions of an action.
    Alternative {
        node: u32,
        gas: GasNum,
        tried: u32,
        limit: u32,
    },
    /// No choice: below it, all that was tried from a state with tasks to do (`memo`).
    Watch,
}

/// Whether the search goes on forward or has to take back a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Flow {
    Forward,
    Back,
}

/// Who hears of a search, and who may end it.
pub struct Hooks<'h> {
    /// Ends the search from outside.
    pub stop: &'h AtomicBool,
    /// Hears of each (better) plan as it comes.
    pub on_plan: &'h mut dyn FnMut(&Found, &Statistics),
    /// Hears of all that the search does.
    pub observer: Option<&'h mut dyn Observer>,
}

impl std::fmt::Debug for Hooks<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let has_observer = self.observer.is_some();
        f.debug_struct("Hooks")
            .field("observer", &has_observer)
            .finish_non_exhaustive()
    }
}

/// Searches for plans of `goal`, whatever they begin with: see [`repair`].
pub fn solve(
    domain: &Domain,
    goal: &Goal,
    reasoner: &mut dyn Reasoner,
    settings: &Settings,
    stop: &AtomicBool,
    on_plan: &mut dyn FnMut(&Found, &Statistics),
) -> Outcome {
    let hooks = Hooks {
        stop,
        on_plan,
        observer: None,
    };
    repair(domain, goal, &[], reasoner, settings, hooks)
}

/// Searches for plans of `goal` that begin with the `kept` actions.
///
/// The reasoner is left in the world state of the start.
pub fn repair(
    domain: &Domain,
    goal: &Goal,
    kept: &[Kept],
    reasoner: &mut dyn Reasoner,
    settings: &Settings,
    hooks: Hooks<'_>,
) -> Outcome {
    let Hooks {
        stop,
        on_plan,
        observer,
    } = hooks;
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
    let mut context = Context::new(domain, &mut state, reasoner);
    let objective = (settings.aim == Aim::Best && domain.has_objective()).then(|| {
        let sight = match shared.is_empty() {
            true => Sight::Whole,
            false => Sight::WithoutShared,
        };
        Box::new(Objective::new(&mut context, sight))
    });
    let mut search = Search {
        context,
        settings,
        kept,
        shared: &shared,
        prepared: &Prepared::new(domain),
        bounds: &Bounds::new(domain),
        agenda: Agenda::new(settings.interleave),
        tree: Tree::default(),
        steps: Vec::new(),
        slots: Vec::new(),
        news: Vec::new(),
        choices: Vec::new(),
        cost: 0.0,
        rest: 0,
        objective,
        memo: Memo::default(),
        recorder: Recorder::default(),
        n_derivations: 0,
        statistics: Statistics::default(),
        truncated: Truncated::default(),
        reasons: Reasons::default(),
        budget_spent: false,
        written: Vec::new(),
        observer: observer.map(|o| o as &mut dyn Observer),
    };
    let impossible = search.first_impossible();
    let ending = match impossible {
        Some(_) => Ending::Exhausted,
        None => search.run(goal, stop, on_plan),
    };
    search.tell(|search| Event::Ended {
        ending,
        statistics: &search.statistics,
    });
    let least_cost = search.least_cost(goal, ending);
    let Search {
        recorder,
        statistics,
        reasons,
        context,
        ..
    } = search;
    context.reasoner.restore(start_world);
    let (found, others) = recorder.finish();
    Outcome {
        found,
        others,
        impossible,
        least_cost,
        ending,
        statistics,
        why_not: reasons.finish(domain),
    }
}

/// A search under way.
pub(super) struct Search<'a> {
    pub context: Context<'a>,
    pub settings: &'a Settings,
    /// What a plan has to begin with.
    pub kept: &'a [Kept],
    pub shared: &'a [SlotId],
    pub prepared: &'a Prepared,
    pub bounds: &'a Bounds,
    pub agenda: Agenda,
    pub tree: Tree,
    pub steps: Vec<Step>,
    /// What the steps read and write.
    pub slots: Vec<SlotId>,
    /// What the steps have written, with the values that it had after each; nothing where attributes are shared with geometry.
    pub news: Vec<(SlotId, Value)>,
    pub choices: Vec<(Point, Choice)>,
    pub cost: f64,
    pub rest: u64,
    /// The plan's whole cost, where it is not the sum of its actions' costs and the best plan is wanted.
    pub objective: Option<Box<Objective<'a>>>,
    pub memo: Memo,
    pub recorder: Recorder,
    /// Plans found, those included that are the same as another.
    pub n_derivations: u64,
    pub statistics: Statistics,
    pub truncated: Truncated,
    pub reasons: Reasons,
    /// Whether a task could not be taken up for want of budget.
    pub budget_spent: bool,
    /// Room for written slots.
    pub written: Vec<SlotId>,
    pub observer: Option<&'a mut dyn Observer>,
}

impl Search<'_> {
    fn run(&mut self, goal: &Goal, stop: &AtomicBool, on_plan: &mut dyn FnMut(&Found, &Statistics)) -> Ending {
        self.tree.values.extend(goal.args.iter().cloned());
        self.tree.nodes.push(Node {
            task: goal.task,
            frame: 0,
            parent: NONE,
            subtask: 0,
            decomposition: NONE,
            depth: 0,
            at: 0,
            head: NONE,
            streak: 0,
            anchor: NONE,
        });
        let mut flow = self.reach(0);
        loop {
            if flow == Flow::Forward && self.agenda.head == NONE {
                if self.refuse_short().is_none() && self.record(on_plan) {
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
                    Some((_, Choice::Watch)) => {
                        self.end_watch();
                        Flow::Back
                    }
                    Some((point, choice)) => {
                        if self.statistics.backtracks >= self.settings.budget.expansions {
                            self.choices.push((point, choice));
                            return Ending::BudgetSpent;
                        }
                        self.statistics.backtracks += 1;
                        self.go_back(&point);
                        self.tell_went_back(&choice);
                        // A better plan may have been found since this choice was made.
                        match self.too_costly() {
                            Some(flow) => flow,
                            None => self.retry(point, choice),
                        }
                    }
                    None if self.truncated == Truncated::default() => return Ending::Exhausted,
                    None => return Ending::ExhaustedTruncated(self.truncated),
                },
            };
        }
    }

    fn note_deepest(&mut self) {
        self.reasons.note_deepest(self.context.domain, &self.steps, &self.tree);
    }

    /// Takes up the next task of the agenda.
    fn advance(&mut self) -> Flow {
        if self.choices.is_empty() {
            // INVARIANT: only choices keep marks over a task's end, so nobody can come back.
            self.context.state.keep();
        }
        let ready = |cell, subtask| self.agenda.ready(self.prepared, cell, subtask);
        // INVARIANT: the order has no cycle (checked), so a cell has a subtask that is ready.
        let Some((cell, subtask)) = ready(self.agenda.head, 0) else {
            return Flow::Back;
        };
        match ready(cell, subtask + 1) {
            None => self.start_subtask(cell, subtask),
            Some((next_cell, next)) => {
                let point = self.point();
                if !self.is_new(&point, None, point.nodes, 0) {
                    return Flow::Back;
                }
                let choice = Choice::Order {
                    cell: next_cell,
                    subtask: next,
                };
                self.choices.push((point, choice));
                self.start_subtask(cell, subtask)
            }
        }
    }

    /// Cells below this one belong to a choice point.
    pub fn guard(&self) -> u32 {
        self.choices.last().map_or(0, |(point, _)| point.agenda.n_cells())
    }

    pub fn point(&mut self) -> Point {
        Point {
            trail: self.context.state.mark(),
            world: self.context.reasoner.save(),
            agenda: self.agenda.mark(),
            nodes: self.tree.nodes.len() as u32,
            values: self.tree.values.len() as u32,
            steps: self.steps.len() as u32,
            slots: self.slots.len() as u32,
            news: self.news.len() as u32,
            cost: self.cost,
            rest: self.rest,
        }
    }

    pub fn go_back(&mut self, point: &Point) {
        self.context.reads.clear();
        self.context.state.restore(point.trail);
        self.context.reasoner.restore(point.world);
        self.agenda.restore(point.agenda, point.nodes as usize);
        self.tree.nodes.truncate(point.nodes as usize);
        self.tree.values.truncate(point.values as usize);
        self.steps.truncate(point.steps as usize);
        self.reasons.shortened(point.steps as usize);
        self.slots.truncate(point.slots as usize);
        self.news.truncate(point.news as usize);
        self.cost = point.cost;
        self.rest = point.rest;
        if let Some(objective) = &mut self.objective {
            objective.restore(point.steps, point.nodes);
        }
    }

    /// Takes the next option of a choice point that was gone back to; the choice stays on the stack while it has more.
    fn retry(&mut self, point: Point, choice: Choice) -> Flow {
        match choice {
            Choice::Decomposition { node, next } => self.decompose(point, node, next),
            Choice::Binding { node, binder, next } => self.bind_next(point, node, binder, next),
            Choice::Sorted { node, binder, mut left } => {
                let Some(value) = left.pop() else { return Flow::Back };
                if !left.is_empty() {
                    self.choices.push((point, Choice::Sorted { node, binder, left }));
                }
                self.bind(node, binder, value)
            }
            Choice::Order { cell, subtask } => {
                if let Some((cell, subtask)) = self.agenda.ready(self.prepared, cell, subtask + 1) {
                    self.choices.push((point, Choice::Order { cell, subtask }));
                }
                self.start_subtask(cell, subtask)
            }
            Choice::Alternative {
                node,
                gas,
                tried,
                limit,
            } => self.try_alternative(point, node, gas, tried, limit),
            Choice::Watch => Flow::Back,
        }
    }

    /// Leaves the branch if no plan that begins with it can be better than the best one.
    pub fn too_costly(&mut self) -> Option<Flow> {
        if self.settings.aim != Aim::Best {
            return None;
        }
        let bound = self.recorder.best_cost()?;
        let (cost, rest) = match &self.objective {
            None => (self.cost, bound::cost(self.rest)),
            Some(objective) => objective.bound(self.cost, bound::cost(self.rest)),
        };
        if cost + rest < bound - COST_TOLERANCE {
            return None;
        }
        // The same words whatever the task is.
        let numbers = [cost, rest, bound].map(f64::to_bits);
        Some(self.refuse(Kind::TooCostly, NONE, &numbers, |_| Refusal::TooCostly {
            cost,
            rest,
            bound,
        }))
    }

    /// Returns what no plan can cost less than.
    fn least_cost(&self, goal: &Goal, ending: Ending) -> f64 {
        let bound_at = |steps: u32, cost: f64, rest: u64| match &self.objective {
            None => cost + bound::cost(rest),
            Some(objective) => objective.bound_at(steps, cost, bound::cost(rest)),
        };
        let least = bound_at(0, 0.0, self.bounds.task(goal.task));
        let best = self.recorder.best_cost().unwrap_or(f64::INFINITY);
        let left = self
            .choices
            .iter()
            .map(|(point, _)| bound_at(point.steps, point.cost, point.rest));
        let now = [bound_at(self.steps.len() as u32, self.cost, self.rest)];
        match ending {
            Ending::Exhausted => best,
            // What was cut short may cost anything above the least.
            _ if self.truncated != Truncated::default() => least.min(best),
            Ending::ExhaustedTruncated(_) => least.min(best),
            Ending::FirstPlan | Ending::BudgetSpent | Ending::Interrupted => {
                left.chain(now).fold(best, f64::min).max(least).min(best)
            }
        }
    }
}

/// Plans whose costs differ by less are equally good.
pub(super) const COST_TOLERANCE: f64 = 1e-9;
