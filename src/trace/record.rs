//! The lines of a trace.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// What the first line says that the file is.
pub const FORMAT: &str = "sgap-trace";
/// Of the form; a reader reads its own version alone.
pub const VERSION: u32 = 1;

/// The first line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    pub format: String,
    pub version: u32,
    /// Files as the user named them.
    pub domain: String,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub world: Option<String>,
    /// `MoveObj(PR2, CUP, SHELF)`.
    pub task: String,
    pub seed: u64,
}

/// Every other line. Tasks have numbers that are never used again (`id`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "e", rename_all = "kebab-case")]
pub enum Record<'a> {
    /// A task is taken up below the task `in`.
    Task {
        id: u64,
        #[serde(rename = "in", skip_serializing_if = "Option::is_none", default)]
        parent: Option<u64>,
        depth: u32,
        task: Cow<'a, str>,
    },
    /// The goal of the method holds already.
    Goal { id: u64 },
    /// A decomposition whose precondition holds; numbers from 0.
    Try { id: u64, decomposition: u32 },
    /// A SELECT has given a variable its value.
    Bind {
        id: u64,
        var: Cow<'a, str>,
        value: Cow<'a, str>,
    },
    /// Geometry is asked: for the first solution of `call`, or for another one after `after`.
    Ask {
        id: u64,
        #[serde(skip_serializing_if = "Option::is_none", default)]
        call: Option<Cow<'a, str>>,
        #[serde(skip_serializing_if = "Option::is_none", default)]
        after: Option<u32>,
    },
    /// An action is applied; `actions` are done then.
    Act {
        id: u64,
        cost: f64,
        #[serde(skip_serializing_if = "Option::is_none", default)]
        gas: Option<u32>,
        #[serde(skip_serializing_if = "Option::is_none", default)]
        alternative: Option<u32>,
        actions: usize,
    },
    /// A reason, before its first use; numbers are never used for another.
    Reason {
        n: u64,
        kind: Cow<'a, str>,
        /// As the domain has it.
        rule: Cow<'a, str>,
        /// With the arguments and values met.
        text: Cow<'a, str>,
    },
    /// A branch ends at this task.
    Refuse {
        id: u64,
        why: u64,
        #[serde(skip_serializing_if = "Option::is_none", default)]
        geometry: Option<Candidates<'a>>,
    },
    /// A branch ends: the same state with the same tasks to do is known to fail, or is on its own path.
    Repeat { id: u64 },
    /// A choice is taken back. Tasks from `from` on are undone; `actions` are left.
    Back {
        id: u64,
        choice: Cow<'a, str>,
        from: u64,
        actions: usize,
    },
    /// A plan is found.
    Plan { n: u64, cost: f64, actions: usize },
    /// The time since the start [us], for all lines up to the next one.
    Time { us: u64 },
    /// The last line.
    End {
        ending: Cow<'a, str>,
        expansions: u64,
        backtracks: u64,
        repeated: u64,
        projections: u64,
        alternatives: u64,
        plans: u64,
    },
}

/// What stopped the candidates of a geometric action.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Candidates<'a> {
    pub tried: u32,
    /// Whether there were no others.
    pub exhausted: bool,
    pub causes: Vec<(Cow<'a, str>, u32)>,
}
