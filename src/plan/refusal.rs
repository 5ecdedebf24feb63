//! Why a branch of the search failed: typed, with numbers; the report turns it into sentences.
//!
//! A refusal is not a problem of the user's text (`diag::Problem`): the domain and the world are fine, this branch is not.

use indexmap::IndexMap;
use std::fmt;

/// Why one branch failed.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// A literal of a precondition was false.
    Precondition {
        /// The task with its arguments: `Pick(PR2, RED_CUBE)`.
        task: String,
        /// The literal as the language writes it.
        literal: String,
        /// The values it met: `RED_CUBE.isReachable is []`.
        met: String,
    },
    /// No entity passed a SELECT.
    NoBinding {
        task: String,
        variable: String,
        candidates: usize,
    },
    /// A subtask's argument was NULL when it was reached.
    NullArgument { task: String, position: usize },
    /// A cost or a duration was negative or not a number.
    BadNumber {
        task: String,
        what: &'static str,
        value: f64,
    },
    /// The least duration is above the most.
    DurationOrder { task: String, least: f64, most: f64 },
    /// Geometry found no (further) solution.
    Geometry(ActionRefusal),
    /// The plan would cost at least as much as the best one known.
    TooCostly { cost: f64, bound: f64 },
    /// A method came back to itself deeper than the limit.
    TooDeep { task: String, depth: usize },
}

/// Why a geometric action has no further solution.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionRefusal {
    /// `pick(PR2, RED_CUBE)`.
    pub call: String,
    /// Solutions already given for this call in this world state; 0 means that it is not feasible at all.
    pub found_before: u32,
    /// Whether every choice was tried; else the budget of candidates ended it.
    pub exhausted: bool,
    /// Candidates tried in all.
    pub tried: u32,
    /// What stopped them, most frequent first.
    pub causes: Vec<CauseCount>,
}

/// How many candidates failed for one cause.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseCount {
    /// The sub-action that failed; empty for a condition of the whole action.
    pub sub_action: String,
    pub cause: Cause,
    pub count: u32,
}

/// What stopped a candidate of a geometric action.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The arguments do not allow the action at all: a sentence says why.
    NotApplicable(String),
    /// The arm has no configuration with the tool there.
    OutOfReach { arm: String },
    /// Two bodies overlap in the end state.
    Collision { a: String, b: String },
    /// The tool can't follow the straight line.
    NoStraightMotion { arm: String },
    /// The motion planner found no path within its samples.
    NoPath { arm: String, samples: u32 },
    /// A required fact does not hold in the end state: `isReachable(RED_CUBE, BOB)`.
    Fact(String),
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::NotApplicable(why) => write!(f, "{why}"),
            Cause::OutOfReach { arm } => write!(f, "out of reach of the {arm} arm"),
            Cause::Collision { a, b } => write!(f, "{a} against {b}"),
            Cause::NoStraightMotion { arm } => write!(f, "no straight motion of the {arm} arm"),
            Cause::NoPath { arm, samples } => write!(f, "no path for the {arm} arm within {samples} samples"),
            Cause::Fact(fact) => write!(f, "{fact} would not hold"),
        }
    }
}

impl fmt::Display for ActionRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let further = if self.found_before > 0 {
            "no further solution"
        } else {
            "no solution"
        };
        write!(f, "{}: {further}", self.call)?;
        if self.tried > 0 {
            let end = if self.exhausted { "all" } else { "the budget's" };
            write!(f, " ({end} {} candidates tried)", self.tried)?;
        }
        for (i, c) in self.causes.iter().take(4).enumerate() {
            write!(f, "{} ", if i == 0 { ":" } else { "," })?;
            if self.tried > 0 {
                write!(f, "{} ", c.count)?;
            }
            if !c.sub_action.is_empty() {
                write!(f, "{}: ", c.sub_action)?;
            }
            write!(f, "{}", c.cause)?;
        }
        Ok(())
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Precondition { task, literal, met } if met.is_empty() => write!(f, "{task}: {literal} is false"),
            Refusal::Precondition { task, literal, met } => write!(f, "{task}: {literal} is false ({met})"),
            Refusal::NoBinding {
                task,
                variable,
                candidates,
            } => {
                write!(f, "{task}: none of {candidates} entities can be {variable}")
            }
            Refusal::NullArgument { task, position } => write!(f, "{task}: argument {} is NULL", position + 1),
            Refusal::BadNumber { task, what, value } => {
                write!(f, "{task}: its {what} is {value}, which is not a number >= 0")
            }
            Refusal::DurationOrder { task, least, most } => {
                write!(f, "{task}: its least duration {least} is above its most {most}")
            }
            Refusal::Geometry(refusal) => write!(f, "{refusal}"),
            Refusal::TooCostly { cost, bound } => {
                write!(f, "a cost of {cost:.4} is not below the best plan's {bound:.4}")
            }
            Refusal::TooDeep { task, depth } => write!(f, "{task}: more than {depth} methods deep"),
        }
    }
}

/// The failures of a whole search, grouped, and the deepest point reached.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WhyNot {
    /// The longest sequence of actions that a branch reached: `Pick(PR2, RED_CUBE)`.
    pub deepest: Vec<String>,
    /// Refusal (as a sentence) to the number of branches that it ended; in the order met.
    counts: IndexMap<String, u64>,
    /// Refusals not kept because there were too many different ones.
    pub not_kept: u64,
}

/// Different refusals kept; a search with more has its reasons on top long before.
const MAX_REASONS: usize = 2000;

impl WhyNot {
    /// Counts a refusal.
    pub fn add(&mut self, refusal: &Refusal) {
        let text = refusal.to_string();
        if let Some(n) = self.counts.get_mut(&text) {
            *n += 1;
        } else if self.counts.len() < MAX_REASONS {
            self.counts.insert(text, 1);
        } else {
            self.not_kept += 1;
        }
    }

    /// Returns the reasons with their counts, most frequent first; ties in the order met.
    pub fn reasons(&self) -> Vec<(&str, u64)> {
        let mut all: Vec<(&str, u64)> = self.counts.iter().map(|(k, n)| (k.as_str(), *n)).collect();
        all.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        all
    }
}
