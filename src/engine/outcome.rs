//! What to search for, and what comes of it: data only.

use super::reasoner::GasRef;
use crate::ir::{ActionId, SlotId, TaskId, Value};
use crate::plan::WhyNot;

/// What to look for.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Geometric alternatives tried per projected action, the first included, unless the action says otherwise
    /// (thesis 4.3.4: branching factor).
    pub branching: u32,
    /// Go on for the cheapest plan instead of stopping at the first.
    pub best: bool,
    pub budget: Budget,
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
    /// The first plan was asked for and found.
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
    pub plans: u64,
}

/// An action of a found plan.
#[derive(Debug, Clone)]
pub struct Step {
    pub action: ActionId,
    pub args: Vec<Value>,
    pub gas: Option<GasRef>,
    /// Cost and duration [s] of its projection; zeros without one.
    pub geometric: (f64, f64),
    pub cost: f64,
    /// (least, most) [s]; a projected action lasts at least as long as its trajectories.
    pub duration: (f64, f64),
    /// Slots that its precondition, the arguments of its projection, effects, cost and duration read.
    pub reads: Vec<SlotId>,
    /// Slots that its effects wrote; for a projected one also the shared ones that some other action's effects wrote.
    /// Shared attributes that geometry changed come on top in [`Found::changes`].
    pub writes: Vec<SlotId>,
    /// Its leaf in the decomposition tree.
    pub node: usize,
}

/// The decomposition tree in the order of execution: node 0 is the task asked for, a node stands before its children, and
/// all of a subtree before the next sibling.
#[derive(Debug, Clone, Default)]
pub struct Tree(pub Vec<TreeNode>);

/// A task instance.
#[derive(Debug, Clone)]
pub struct TreeNode {
    pub task: TaskId,
    pub args: Vec<Value>,
    pub parent: Option<usize>,
    /// Position in the parent's decomposition.
    pub subtask: usize,
    /// The decomposition applied; `None` for an action, and where the goal held.
    pub decomposition: Option<usize>,
}

/// A plan as the engine knows it.
#[derive(Debug, Clone)]
pub struct Found {
    pub steps: Vec<Step>,
    pub tree: Tree,
    pub cost: f64,
    /// Per step: the slots whose value changed, shared ones included, with the new value.
    pub changes: Vec<Vec<(SlotId, Value)>>,
}

/// The result of a search: the best plan found, how the search ended, and why branches failed.
#[derive(Debug)]
pub struct Outcome {
    pub found: Option<Found>,
    pub ending: Ending,
    pub statistics: Statistics,
    pub why_not: WhyNot,
}
