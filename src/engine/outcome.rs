//! What to search for, and what comes of it: data only.

use std::borrow::Cow;

use super::changes::changes_of;
use super::reasoner::GasRef;
use crate::ir::{ActionId, Decomposition, Domain, MethodId, SlotId, TaskId, Value};
use crate::plan::WhyNot;

/// What to look for, and how.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    pub aim: Aim,
    /// Geometric alternatives tried per projected action, the first included, unless the action says otherwise
    /// (thesis 4.3.4: branching factor).
    pub branching: Branching,
    pub strategy: Strategy,
    /// Subtasks with no order between them may mix step by step; else each is done as one block.
    pub interleave: bool,
    pub cuts: Cuts,
    pub budget: Budget,
    /// Tasks that the fall-back may take up (see `rounds`), inside the budget; 0: there is none. `None`: ten times those of
    /// the search before it, and 10,000 at least; and of geometric actions computed twice as many, and 100 at least.
    pub fall_back: Option<u64>,
}

/// How many geometric alternatives of an action are tried, the first included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branching {
    Fixed(u32),
    /// A number for each action's name, which grows where alternatives have paid (see `branching`).
    Adaptive,
}

/// In which order branches are tried. All end with the same verdict where they come to their end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// The order of the files, to the end.
    DepthFirst,
    /// First the branches that take the first option nearly everywhere (see `rounds`).
    LimitedDiscrepancy,
    /// Begins again and again, with orders drawn anew from this seed.
    Restarts { seed: u64 },
}

/// Which plans are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    First,
    /// The cheapest.
    Best,
    /// Up to that many, no two of which are the same sequence of actions.
    All(u32),
}

/// Whether branches are left that repeat themselves or what failed before (see `memo` and `cycle`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cuts {
    Off,
    /// Failures are remembered once a search has shown that it needs it: a plan that comes straight away costs nothing.
    On,
    /// Failures are remembered from the start.
    Always,
}

/// Ends of a search; counts, so that the same input ends at the same place on every machine.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Tasks taken up (decomposed, applied or refused). As many choices may be taken back, so that choices which lead to
    /// no task come to an end too.
    pub expansions: u64,
    /// Methods inside methods.
    pub depth: usize,
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// As many plans as asked for were found.
    FirstPlan,
    /// Every choice was tried; with a plan: it is the best one.
    Exhausted,
    /// Every choice was tried, but some were cut short: there may be (better) plans.
    ExhaustedTruncated(Truncated),
    /// The budget of expansions was spent.
    BudgetSpent,
    /// The user or the clock ended it.
    Interrupted,
}

/// What was cut short.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Truncated {
    /// Projected actions whose alternatives ended at the branching factor.
    pub alternatives: u64,
    /// Geometric actions that gave up with choices left.
    pub geometry: u64,
    /// Branches deeper than the limit.
    pub depth: u64,
    /// Branches that came back to a task of their own, with the same arguments in the same state and with more to do
    /// after it: only a plan that repeats itself can be missed.
    pub cycles: u64,
}

/// Counts of a search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    pub expansions: u64,
    /// Geometric actions computed, first solutions and alternatives, feasible or not (thesis Table 4.3: actions computed).
    pub projections: u64,
    /// Alternatives asked for (thesis Table 4.3).
    pub alternatives: u64,
    pub backtracks: u64,
    /// Branches left because the same state with the same tasks to do is known to fail, or is on its own path.
    pub repeated: u64,
    /// Branches left because a task that is still to be done can't be done any more.
    pub dead_ends: u64,
    /// How often the choices inside a task were dropped, since they had no part in a failure after it.
    pub jumps: u64,
    /// Searches begun: one, unless a strategy or the fall-back begins again.
    pub rounds: u64,
    /// In the fall-back, how often a task was let come back to itself; 0 if it was not needed.
    pub returns: u32,
    /// What ended the fall-back without a plan and before its last word.
    pub fall_back: FallBackEnd,
    pub plans: u64,
}

impl Statistics {
    /// Adds what a search before this one has done.
    pub fn add(&mut self, before: &Statistics) {
        self.expansions += before.expansions;
        self.projections += before.projections;
        self.alternatives += before.alternatives;
        self.backtracks += before.backtracks;
        self.repeated += before.repeated;
        self.dead_ends += before.dead_ends;
        self.jumps += before.jumps;
        self.rounds += before.rounds;
        self.plans += before.plans;
    }
}

/// What a fall-back without a plan has used up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FallBackEnd {
    /// Nothing: there was none, or it came to its end.
    #[default]
    None,
    /// So many tasks taken up by itself, or choices taken back.
    Expansions(u64),
    /// So many geometric actions computed by itself.
    Projections(u64),
    /// The budget of the whole search.
    Budget,
}

/// An action of a found plan. Small, since a search writes one for every action that it tries.
#[derive(Debug, Clone)]
pub struct Step {
    pub action: ActionId,
    /// Its leaf in the decomposition tree.
    pub node: u32,
    /// Where its [`Charge`] is; steps that cost the same share one.
    pub(super) charge: u32,
    /// Where its reads, then its writes begin in the list of slots, and where they end.
    pub(super) slots: [u32; 3],
}

/// What an action costs and how long it lasts, and what geometry has found for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Charge {
    pub gas: Option<GasRef>,
    /// Cost and duration [s] of its projection; zeros without one.
    pub geometric: (f64, f64),
    pub cost: f64,
    /// (least, most) [s]; a projected action lasts at least as long as its trajectories.
    pub duration: (f64, f64),
}

/// No node.
pub(super) const NONE: u32 = u32::MAX;

/// The decomposition tree in the order in which tasks were taken up: node 0 is the task asked for, a node stands before its
/// children. Without interleaving all of a subtree stands before the next sibling.
#[derive(Debug, Clone, Default)]
pub struct Tree {
    pub(super) nodes: Vec<Node>,
    /// What else is known of methods, in the order of their nodes.
    pub(super) inners: Vec<Inner>,
    /// The frames of all nodes: arguments, then variables.
    pub(super) values: Vec<Value>,
}

/// A task instance.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// An action's id, or a method's with the highest bit set.
    task: u32,
    /// Where its frame begins.
    pub frame: u32,
    /// [`NONE`] for the root.
    pub parent: u32,
    /// Position in the parent's decomposition.
    pub subtask: u32,
    /// Where its [`Inner`] is; [`NONE`] for an action.
    inner: u32,
}

const METHOD: u32 = 1 << 31;

/// Where a task instance stands in the tree.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Where its frame begins.
    pub frame: u32,
    /// [`NONE`] for the root.
    pub parent: u32,
    /// Position in the parent's decomposition.
    pub subtask: u32,
}

/// What is known of a method's instance.
#[derive(Debug, Clone)]
pub(super) struct Inner {
    /// The decomposition applied; [`NONE`] where there is none yet, and where the goal held.
    pub decomposition: u32,
    /// Methods above it.
    pub depth: u32,
    /// How many actions were done when it was taken up.
    pub at: u32,
    /// The first cell of the agenda when it was taken up.
    pub head: u32,
    /// How many of the nodes right above it were taken up since the last action, and an older one to compare with.
    pub streak: u32,
    pub anchor: u32,
    /// How many of those are tasks that came back to themselves and were let.
    pub returns: u32,
}

impl Node {
    #[inline]
    pub fn task(&self) -> TaskId {
        match self.task & METHOD {
            0 => TaskId::Action(ActionId(self.task)),
            _ => TaskId::Method(MethodId(self.task & !METHOD)),
        }
    }
}

impl Tree {
    /// Adds the node of a task instance that is taken up after `at` actions, with `head` first on the agenda; returns its
    /// number.
    #[inline]
    pub(super) fn push(&mut self, task: TaskId, place: Place, at: u32, head: u32) -> u32 {
        let number = self.nodes.len() as u32;
        let Place { frame, parent, subtask } = place;
        let (task, inner) = match task {
            TaskId::Action(a) => (a.0, NONE),
            TaskId::Method(m) => {
                let depth = match parent {
                    NONE => 0,
                    parent => self.depth(parent) + 1,
                };
                self.inners.push(Inner {
                    decomposition: NONE,
                    depth,
                    at,
                    head,
                    streak: 0,
                    anchor: NONE,
                    returns: 0,
                });
                (m.0 | METHOD, self.inners.len() as u32 - 1)
            }
        };
        self.nodes.push(Node {
            task,
            frame,
            parent,
            subtask,
            inner,
        });
        number
    }

    #[inline]
    pub(super) fn task(&self, node: u32) -> TaskId {
        self.nodes[node as usize].task()
    }

    /// Returns how many methods are above a node.
    pub(super) fn depth(&self, node: u32) -> u32 {
        let node = &self.nodes[node as usize];
        let inner = |at: u32| self.inners.get(at as usize);
        match (inner(node.inner), self.nodes.get(node.parent as usize)) {
            (Some(own), _) => own.depth,
            (None, Some(parent)) => inner(parent.inner).map_or(0, |above| above.depth + 1),
            (None, None) => 0,
        }
    }

    /// Returns what is known of a method's node; `None` for an action.
    #[inline]
    pub(super) fn inner(&self, node: u32) -> Option<&Inner> {
        self.inners.get(self.nodes[node as usize].inner as usize)
    }

    #[inline]
    pub(super) fn inner_mut(&mut self, node: u32) -> Option<&mut Inner> {
        self.inners.get_mut(self.nodes[node as usize].inner as usize)
    }

    /// Returns the number of the decomposition applied to a node, or [`NONE`].
    #[inline]
    pub(super) fn decomposition(&self, node: u32) -> u32 {
        self.inner(node).map_or(NONE, |inner| inner.decomposition)
    }

    /// Returns the decomposition applied to a node, if there is one.
    #[inline]
    pub(super) fn decomposition_in<'d>(&self, domain: &'d Domain, node: u32) -> Option<&'d Decomposition> {
        match self.task(node) {
            TaskId::Method(m) => {
                let applied = self.decomposition(node) as usize;
                domain.methods[m.index()].decompositions.get(applied)
            }
            TaskId::Action(_) => None,
        }
    }

    /// Returns a node's arguments.
    #[inline]
    pub(super) fn args(&self, domain: &Domain, node: u32) -> &[Value] {
        let node = &self.nodes[node as usize];
        let from = node.frame as usize;
        &self.values[from..from + domain.task_params(node.task()).len()]
    }

    /// Returns `Pick(PR2, RED_CUBE)`.
    pub(super) fn show(&self, domain: &Domain, node: u32) -> String {
        domain.show_task(self.task(node), self.args(domain, node))
    }
}

/// A plan as the engine knows it.
#[derive(Debug, Clone)]
pub struct Found {
    pub steps: Vec<Step>,
    pub(super) charges: Vec<Charge>,
    pub tree: Tree,
    pub cost: f64,
    /// The parts of its cost where that is not the sum of the actions' costs: that sum, the makespan, what each rule counts.
    pub(super) amounts: Vec<f64>,
    /// Whether unordered subtasks were allowed to mix.
    pub interleaved: bool,
    /// What each step reads and writes, one after the other.
    pub(super) slots: Vec<SlotId>,
    /// Shared attributes that actions without geometry have written: every projection writes them, too.
    pub(super) overruled: Vec<SlotId>,
    pub(super) news: News,
}

/// What a plan's steps have done to the state.
#[derive(Debug, Clone)]
pub(super) enum News {
    /// Where no attribute is shared with geometry: the values of all that the steps have written, in order.
    Written(Vec<Value>),
    Changed(Changed),
}

/// What each step of a plan changed, shared attributes included.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Changed {
    pub(super) slots: Vec<SlotId>,
    pub(super) values: Vec<Value>,
    /// Where each step's end.
    pub(super) ends: Vec<u32>,
}

impl Changed {
    /// Returns the slots whose value a step changed, with the new value.
    pub fn by(&self, step: usize) -> impl Iterator<Item = (SlotId, &Value)> {
        let from = if step == 0 { 0 } else { self.ends[step - 1] as usize };
        let to = self.ends[step] as usize;
        self.slots[from..to].iter().copied().zip(&self.values[from..to])
    }
}

impl Found {
    /// Returns the arguments of a step.
    pub fn args(&self, domain: &Domain, step: &Step) -> &[Value] {
        self.tree.args(domain, step.node)
    }

    /// Returns the slots that a step's precondition, the arguments of its projection, constraints, effects, cost and
    /// duration read.
    pub fn reads(&self, step: &Step) -> &[SlotId] {
        &self.slots[step.slots[0] as usize..step.slots[1] as usize]
    }

    /// Returns the slots that a step's effects wrote. Those of [`Found::changed`] come on top.
    pub fn writes(&self, step: &Step) -> &[SlotId] {
        &self.slots[step.slots[1] as usize..step.slots[2] as usize]
    }

    /// Returns what a step costs, how long it lasts, and what geometry has found for it.
    pub fn charge(&self, step: &Step) -> &Charge {
        &self.charges[step.charge as usize]
    }

    /// Returns what the steps changed. It is put together for whoever asks: a search that goes on has no use for it.
    pub fn changed(&self, domain: &Domain) -> Cow<'_, Changed> {
        match &self.news {
            News::Written(values) => Cow::Owned(changes_of(domain, &self.steps, &self.slots, values)),
            News::Changed(changed) => Cow::Borrowed(changed),
        }
    }
}

/// The result of a search: what was found, how the search ended, and why branches failed.
#[derive(Debug)]
pub struct Outcome {
    /// The first plan, or the best one.
    pub found: Option<Found>,
    /// With [`Aim::All`], the plans after the first, in the order found.
    pub others: Vec<Found>,
    /// With kept actions, the first of them that can't be done, whatever the tasks are: nothing was searched, and `why_not`
    /// says why it can't.
    pub impossible: Option<usize>,
    /// No plan costs less.
    pub least_cost: f64,
    pub ending: Ending,
    pub statistics: Statistics,
    pub why_not: WhyNot,
}
