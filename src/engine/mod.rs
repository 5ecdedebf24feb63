//! The HTN search: decompositions, bindings, orders and geometric alternatives, depth first, with undo.
//!
//! Thesis 4.3.1 to 4.3.4, Algorithms 8 to 12; where we differ is said in `search`.
//!
//! **Invariant:** the engine asks a [`Reasoner`] and never sees a coordinate.

mod act;
mod agenda;
mod backjump;
mod beliefs;
mod bound;
mod branching;
mod changes;
mod cycle;
mod document;
mod effects;
mod eval;
mod explain;
mod fold;
mod ground;
mod hash;
mod kept;
mod links;
mod look_ahead;
mod memo;
mod names;
mod needs;
mod objective;
mod observe;
mod order;
mod outcome;
mod prepare;
mod reasoner;
mod record;
mod reduction;
mod refusals;
mod rounds;
mod search;
mod sets;
mod shuffle;
mod state;
mod take_up;

pub use document::{document, schedule};
pub use kept::Kept;
pub use observe::{Event, Observer};
pub use outcome::{
    Aim, Branching, Budget, Changed, Charge, Cuts, Ending, FallBackEnd, Found, Outcome, Settings, Statistics, Step,
    Strategy, Truncated,
};
pub use reasoner::{Call, Formula, GasNum, GasRef, Granted, Mark, Projection, Reasoner, Request, Term};
pub use search::{Hooks, repair, solve};
