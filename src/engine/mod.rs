//! The HTN search: decompositions, bindings, orders and geometric alternatives, depth first, with undo.
//!
//! Thesis 4.3.1 to 4.3.4, Algorithms 8 to 12; where we differ is said in `search`.
//!
//! **Invariant:** the engine asks a [`Reasoner`] and never sees a coordinate.

mod changes;
mod eval;
mod explain;
mod ground;
mod links;
mod outcome;
mod reasoner;
mod search;
mod sets;
mod state;

pub use links::document;
pub use outcome::{Budget, Ending, Found, Outcome, Settings, Statistics, Step, Tree, TreeNode, Truncated};
pub use reasoner::{Call, Formula, GasNum, GasRef, Granted, Mark, Projection, Reasoner, Request, Term};
pub use search::solve;
