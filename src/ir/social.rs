//! What a plan costs beyond the sum of its actions' costs: the cost formula and the social rules.
//!
//! After Alili, Warnier, Ali and Alami (2009, "Planning and plan-execution for human-robot cooperative task achievement"):
//! undesirable states and sequences, effort balance, wasted time, intricate links. Their text form is lost; ours, and what
//! exactly is counted, is decision 18.

use super::{ActionId, Domain, EntityId, Expr, Test, TypeId, Value};

/// How the actions' costs and the plan's length in time make its cost; social rules come on top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostFormula {
    /// Factor of the sum of the actions' costs.
    pub sum: f64,
    /// Factor of the makespan, per second.
    pub makespan: f64,
}

impl Default for CostFormula {
    fn default() -> Self {
        CostFormula {
            sum: 1.0,
            makespan: 0.0,
        }
    }
}

/// A social rule: adds `weight` for each of what it counts.
#[derive(Debug, Clone)]
pub struct SocialRule {
    pub name: String,
    /// At least 0, finite.
    pub weight: f64,
    pub kind: RuleKind,
}

/// What a social rule counts.
#[derive(Debug, Clone)]
pub enum RuleKind {
    /// How often the test begins to hold: after an action, and not before it.
    State {
        /// The types of the parameters, which come first in the frame; each choice of entities is counted on its own.
        params: Vec<TypeId>,
        n_vars: usize,
        /// Asks no request.
        test: Test,
    },
    /// The actions that end a sequence of actions.
    Sequence {
        vars: Vec<super::Param>,
        patterns: Vec<Pattern>,
    },
    /// The difference between the agent with the most effort and the one with the least.
    EffortBalance { effort: Effort, agents: Vec<EntityId> },
    /// Seconds that agents wait between their first and their last action.
    WastedTime { agents: Vec<EntityId> },
    /// Links from an action to one of others.
    IntricateLinks { agents: Vec<EntityId> },
}

/// What counts as an agent's effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// The costs of the actions in which it takes part.
    Cost,
    /// Their least durations [s].
    Duration,
}

/// An action of a sequence.
#[derive(Debug, Clone)]
pub struct Pattern {
    pub action: ActionId,
    pub args: Vec<PatternArg>,
    /// No action in between has an agent of this one or of the one before.
    pub is_immediate: bool,
}

/// What an argument must be.
#[derive(Debug, Clone, PartialEq)]
pub enum PatternArg {
    Any,
    /// The same everywhere in the sequence: an index of the rule's variables.
    Var(usize),
    Is(Value),
}

impl RuleKind {
    /// Returns what messages and plan documents call the kind.
    pub fn word(&self) -> &'static str {
        match self {
            RuleKind::State { .. } => "undesirable state",
            RuleKind::Sequence { .. } => "undesirable sequence",
            RuleKind::EffortBalance { .. } => "effort balance",
            RuleKind::WastedTime { .. } => "wasted time",
            RuleKind::IntricateLinks { .. } => "intricate links",
        }
    }
}

/// Returns a constant's value, a list of constants included; `None` for anything else.
pub fn constant(expr: &Expr) -> Option<Value> {
    match expr {
        Expr::Const(value) => Some(value.clone()),
        Expr::List(all) => {
            let members: Option<super::EntitySet> = all
                .iter()
                .map(|e| match e {
                    Expr::Const(Value::Entity(e)) => Some(*e),
                    _ => None,
                })
                .collect();
            members.map(|set| Value::Set(std::sync::Arc::new(set)))
        }
        _ => None,
    }
}

impl Domain {
    /// Says whether a plan's cost is more than the sum of its actions' costs.
    pub fn has_objective(&self) -> bool {
        !self.social.is_empty() || self.settings.cost != CostFormula::default()
    }
}
