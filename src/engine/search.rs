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

use rand_chacha::ChaCha8Rng;

use super::agenda::{Agenda, AgendaMark};
use super::backjump::Reads;
use super::bound::{self, Bounds};
use super::branching::{Factors, Reached};
use super::effects::{Attributes, Changes};
use super::eval::{Context, defined_fact};
use super::fold::Fixed;
use super::kept::Kept;
use super::look_ahead::{LookAhead, Looks};
use super::memo::Memo;
use super::objective::{Objective, Sight};
use super::observe::{Event, Observer};
use super::outcome::{Aim, Charge, Ending, Found, NONE, Outcome, Place, Settings, Statistics, Step, Tree, Truncated};
use super::prepare::Prepared;
use super::reasoner::{GasNum, Mark, Reasoner};
use super::record::Recorder;
use super::refusals::{Kind, Reasons};
use super::rounds::{Ended, Round, Rounds};
use super::shuffle::stream;
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
    inners: u32,
    values: u32,
    steps: u32,
    charges: u32,
    slots: u32,
    news: u32,
    cost: f64,
    /// The least cost of what is still to be done.
    rest: u64,
    /// How many choices of the branch have taken another option than their first.
    discrepancies: u32,
    /// What has been read since the mark or watch below it (`backjump`).
    pub read: Attributes,
}

impl Point {
    pub fn n_nodes(&self) -> u32 {
        self.nodes
    }
}

#[derive(Debug)]
pub(super) enum Choice {
    /// Decompositions of the method at a tree node, from `next` on.
    Decomposition { node: u32, next: u32 },
    /// Values of a SELECT of a node: entities of its type from position `next` on, which is one that passes.
    Binding { node: u32, binder: u32, next: u32 },
    /// Decompositions of a method, the last one first.
    Decompositions { node: u32, left: Vec<u32> },
    /// Values of a SELECT in an order of its own, the last one first.
    Sorted { node: u32, binder: u32, left: Vec<Value> },
    /// Which of the ready subtasks comes next, from this one on.
    Order { cell: u32, subtask: u32 },
    /// Which of these ready subtasks comes next, each with its cell, the last one first.
    Orders { left: Vec<(u32, u32)> },
    /// Further geometric solutions of an action.
    Alternative {
        node: u32,
        gas: GasNum,
        tried: u32,
        limit: u32,
        reached: Reached,
    },
    /// No choice: above it, all that was tried from a state with tasks to do (`memo`).
    Watch,
    /// No choice: above it, all that was tried after this node's task was done (`backjump`).
    Done { node: u32 },
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
        mut observer,
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
    let fixed = Fixed::new(domain);
    let (prepared, bounds) = (Prepared::new(domain, &fixed), Bounds::new(domain, &fixed));
    let look_ahead = LookAhead::new(domain, Changes::new(domain));
    let start_world = reasoner.save();
    let mut rounds = Rounds::new(settings);
    let mut carried = Carried::default();
    let mut impossible = None;
    // What the searches before the fall-back say is what a user can make use of.
    let mut first_reasons = None;
    loop {
        let round = rounds.round;
        carried.statistics.rounds = rounds.number();
        carried.statistics.returns = round.returns;
        if round.is_fall_back() {
            first_reasons.get_or_insert_with(|| std::mem::take(&mut carried.reasons));
            // The failures known were met with tasks not let come back.
            carried.memo = Memo::default();
            carried.cycles = 0;
        }
        let mut state = State::new(domain, &shared);
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
            prepared: &prepared,
            bounds: &bounds,
            look_ahead: &look_ahead,
            looks: Looks::default(),
            factors: Factors::new(domain.actions.len()),
            agenda: Agenda::new(settings.interleave),
            tree: Tree::default(),
            steps: Vec::new(),
            charges: Vec::new(),
            slots: Vec::new(),
            news: Vec::new(),
            choices: Vec::new(),
            cost: 0.0,
            rest: 0,
            discrepancies: 0,
            left_out: 0,
            objective,
            round,
            random: stream(round.shuffle),
            memo: carried.memo,
            reads: Reads::default(),
            recorder: carried.recorder,
            n_derivations: carried.n_derivations,
            begin: carried.statistics.backtracks,
            statistics: carried.statistics,
            truncated: Truncated {
                cycles: carried.cycles,
                ..Truncated::default()
            },
            reasons: carried.reasons,
            budget_spent: false,
            written: Vec::new(),
            observer: observer.as_deref_mut().map(|o| o as &mut dyn Observer),
        };
        search.begin_reads();
        if rounds.number() > 1 {
            search.tell(|_| Event::WentBack {
                node: 0,
                choice: "round",
                kept: 0,
                n_actions: 0,
            });
        }
        if rounds.number() == 1 {
            impossible = search.first_impossible();
        }
        let ended = match impossible {
            Some(_) => Some(Ending::Exhausted),
            None => search.run(goal, stop, on_plan),
        };
        let ended = Ended {
            ending: ended,
            left_out: search.left_out,
            has_plan: search.recorder.best_cost().is_some(),
            statistics: search.statistics,
        };
        let ending = rounds.next(ended);
        search.statistics.fall_back = rounds.fall_back_end;
        if let Some(ending) = ending {
            search.tell(|search| Event::Ended {
                ending,
                statistics: &search.statistics,
            });
        }
        let least_cost = ending.map(|ending| search.least_cost(goal, ending));
        search.context.reasoner.restore(start_world);
        search.forget_open();
        carried = Carried {
            memo: search.memo,
            recorder: search.recorder,
            n_derivations: search.n_derivations,
            statistics: search.statistics,
            reasons: search.reasons,
            cycles: search.truncated.cycles,
        };
        if let (Some(ending), Some(least_cost)) = (ending, least_cost) {
            let (found, others) = carried.recorder.finish();
            let reasons = first_reasons.filter(|_| found.is_none()).unwrap_or(carried.reasons);
            return Outcome {
                found,
                others,
                impossible,
                least_cost,
                ending,
                statistics: carried.statistics,
                why_not: reasons.finish(domain),
            };
        }
        carried.reasons.shortened(0);
    }
}

/// What goes from one round to the next.
#[derive(Debug, Default)]
struct Carried {
    memo: Memo,
    recorder: Recorder,
    n_derivations: u64,
    statistics: Statistics,
    reasons: Reasons,
    /// Cuts of tasks that came back to themselves: where a failure is remembered, they are not met again.
    cycles: u64,
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
    pub look_ahead: &'a LookAhead,
    pub looks: Looks,
    pub factors: Factors,
    pub agenda: Agenda,
    pub tree: Tree,
    pub steps: Vec<Step>,
    /// What the steps cost; a step shares one with a step before it.
    pub charges: Vec<Charge>,
    /// What the steps read of what may change, and write.
    pub slots: Vec<SlotId>,
    /// The values that the steps have written; nothing where attributes are shared with geometry.
    pub news: Vec<Value>,
    pub choices: Vec<(Point, Choice)>,
    pub cost: f64,
    pub rest: u64,
    discrepancies: u32,
    /// Choices left because a branch had taken as many other options as the round allows.
    pub left_out: u64,
    pub round: Round,
    /// Where orders are drawn from, in a round that draws them.
    pub random: Option<ChaCha8Rng>,
    /// The plan's whole cost, where it is not the sum of its actions' costs and the best plan is wanted.
    pub objective: Option<Box<Objective<'a>>>,
    pub memo: Memo,
    pub reads: Reads,
    pub recorder: Recorder,
    /// Plans found, those included that are the same as another.
    pub n_derivations: u64,
    /// The choices taken back before this round.
    begin: u64,
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
    /// Searches until the round ends; `None` says that its choices taken back are used up.
    fn run(&mut self, goal: &Goal, stop: &AtomicBool, on_plan: &mut dyn FnMut(&Found, &Statistics)) -> Option<Ending> {
        self.tree.values.extend(goal.args.iter().cloned());
        let root = Place {
            frame: 0,
            parent: NONE,
            subtask: 0,
        };
        self.tree.push(goal.task, root, 0, NONE);
        // An earlier round may have found a plan than which none is cheaper.
        let mut flow = match self.too_costly() {
            Some(flow) => flow,
            None => self.reach(0),
        };
        loop {
            if flow == Flow::Forward && self.agenda.head == NONE {
                if self.refuse_short().is_none() && self.record(on_plan) {
                    return Some(Ending::FirstPlan);
                }
                self.reads.path();
                flow = Flow::Back;
            }
            if flow == Flow::Back {
                self.note_deepest();
                self.factors.note(self.steps.len());
            }
            if stop.load(Ordering::Relaxed) {
                self.note_deepest();
                return Some(Ending::Interrupted);
            }
            if self.budget_spent {
                self.note_deepest();
                return Some(Ending::BudgetSpent);
            }
            flow = match flow {
                Flow::Forward => self.advance(),
                Flow::Back => match self.choices.pop() {
                    Some((point, Choice::Watch)) => {
                        self.end_watch(point.read);
                        Flow::Back
                    }
                    Some((point, Choice::Done { node })) => {
                        self.end_done(node, point.read);
                        Flow::Back
                    }
                    Some((point, _)) if point.discrepancies >= self.round.discrepancies => {
                        self.left_out += 1;
                        self.reads.path();
                        Flow::Back
                    }
                    Some((point, choice)) => {
                        if self.statistics.backtracks - self.begin >= self.round.backtracks {
                            return None;
                        }
                        if self.is_spent(self.statistics.backtracks) {
                            self.choices.push((point, choice));
                            return Some(Ending::BudgetSpent);
                        }
                        self.statistics.backtracks += 1;
                        self.go_back(&point);
                        self.discrepancies = point.discrepancies + 1;
                        self.tell_went_back(&choice);
                        // A better plan may have been found since this choice was made.
                        match self.too_costly() {
                            Some(flow) => flow,
                            None => self.retry(point, choice),
                        }
                    }
                    None if self.truncated == Truncated::default() => return Some(Ending::Exhausted),
                    None => return Some(Ending::ExhaustedTruncated(self.truncated)),
                },
            };
        }
    }

    /// Says whether as much was done as the budget allows, or a fall-back without a plan has used up its share.
    pub fn is_spent(&self, done: u64) -> bool {
        done >= self.settings.budget.expansions
            || self.round.until.is_reached(&self.statistics) && self.recorder.best_cost().is_none()
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
        self.mark_done();
        if let Some(flow) = self.refuse_dead_end() {
            return flow;
        }
        if let Some((cell, subtask)) = self.agenda.only_ready(self.prepared) {
            return self.start_subtask(cell, subtask);
        }
        let ready = |cell, subtask| self.agenda.ready(self.prepared, cell, subtask);
        // INVARIANT: the order has no cycle (checked), so a cell has a subtask that is ready.
        let Some((cell, subtask)) = ready(self.agenda.head, 0) else {
            return Flow::Back;
        };
        match ready(cell, subtask + 1) {
            None => self.start_subtask(cell, subtask),
            Some((next_cell, next)) => {
                if !self.is_new(None, 0) {
                    return Flow::Back;
                }
                let point = self.point();
                if self.random.is_some() {
                    let left = self.orders_drawn(cell, subtask);
                    return self.start_next(point, left);
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
            inners: self.tree.inners.len() as u32,
            values: self.tree.values.len() as u32,
            steps: self.steps.len() as u32,
            charges: self.charges.len() as u32,
            slots: self.slots.len() as u32,
            news: self.news.len() as u32,
            cost: self.cost,
            rest: self.rest,
            discrepancies: self.discrepancies,
            read: self.reads.since,
        }
    }

    pub fn go_back(&mut self, point: &Point) {
        self.note_reads();
        self.context.reads.clear();
        self.context.state.restore(point.trail);
        self.context.reasoner.restore(point.world);
        self.agenda.restore(point.agenda, point.nodes as usize);
        self.tree.nodes.truncate(point.nodes as usize);
        self.tree.inners.truncate(point.inners as usize);
        self.tree.values.truncate(point.values as usize);
        self.steps.truncate(point.steps as usize);
        self.charges.truncate(point.charges as usize);
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
            Choice::Decomposition { node, next } => self.decompose(Some(point), node, next),
            Choice::Binding { node, binder, next } => self.bind_next(point, node, binder, next),
            Choice::Decompositions { node, left } => self.decompose_next(point, node, left),
            Choice::Orders { left } => self.start_next(point, left),
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
                reached,
            } => match self.next_alternative(node, tried, reached) {
                Ok(best) => self.try_alternative(point, node, gas, tried, limit, best),
                Err(flow) => flow,
            },
            Choice::Watch | Choice::Done { .. } => Flow::Back,
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
            // What was left out may cost anything above the least, too.
            _ if self.left_out > 0 => least.min(best),
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
