//! What to search for, and what comes of it: data only.

use super::reasoner::GasRef;
use crate::ir::{ActionId, Domain, SlotId, TaskId, Value};
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
    /// Searches begun: one, unless a strategy or the fall-back begins again.
    pub rounds: u64,
    /// In the fall-back, how often a task was let come back to itself; 0 if it was not needed.
    pub returns: u32,
    /// What ended the fall-back without a plan and before its last word.
    pub fall_back: FallBackEnd,
    pub plans: u64,
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

/// An action of a found plan.
#[derive(Debug, Clone)]
pub struct Step {
    pub action: ActionId,
    /// Its leaf in the decomposition tree.
    pub node: u32,
    pub gas: Option<GasRef>,
    /// Cost and duration [s] of its projection; zeros without one.
    pub geometric: (f64, f64),
    pub cost: f64,
    /// (least, most) [s]; a projected action lasts at least as long as its trajectories.
    pub duration: (f64, f64),
    /// Where its reads, then its writes begin in the list of slots, and where they end.
    pub(super) slots: [u32; 3],
}

/// No node.
pub(super) const NONE: u32 = u32::MAX;

/// The decomposition tree in the order in which tasks were taken up: node 0 is the task asked for, a node stands before its
/// children. Without interleaving all of a subtree stands before the next sibling.
#[derive(Debug, Clone, Default)]
pub struct Tree {
    pub(super) nodes: Vec<Node>,
    /// The frames of all nodes: arguments, then variables.
    pub(super) values: Vec<Value>,
}

/// A task instance.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub task: TaskId,
    /// Where its frame begins.
    pub frame: u32,
    /// [`NONE`] for the root.
    pub parent: u32,
    /// Position in the parent's decomposition.
    pub subtask: u32,
    /// The decomposition applied; [`NONE`] for an action, and where the goal held.
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

impl Tree {
    /// Returns a node's arguments.
    pub(super) fn args(&self, domain: &Domain, node: u32) -> &[Value] {
        let Node { task, frame, .. } = &self.nodes[node as usize];
        let from = *frame as usize;
        &self.values[from..from + domain.task_params(*task).len()]
    }

    /// Returns `Pick(PR2, RED_CUBE)`.
    pub(super) fn show(&self, domain: &Domain, node: u32) -> String {
        domain.show_task(self.nodes[node as usize].task, self.args(domain, node))
    }
}

/// A plan as the engine knows it.
#[derive(Debug, Clone)]
pub struct Found {
    pub steps: Vec<Step>,
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
    /// What each step changed, one after the other, and where each one's end.
    pub(super) changes: Vec<(SlotId, Value)>,
    pub(super) change_ends: Vec<usize>,
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

    /// Returns the slots that a step's effects wrote. Those of [`Found::changes`] come on top.
    pub fn writes(&self, step: &Step) -> &[SlotId] {
        &self.slots[step.slots[1] as usize..step.slots[2] as usize]
    }

    /// Returns the slots whose value a step changed, shared ones included, with the new value.
    pub fn changes(&self, step: usize) -> &[(SlotId, Value)] {
        let from = if step == 0 { 0 } else { self.change_ends[step - 1] };
        &self.changes[from..self.change_ends[step]]
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
