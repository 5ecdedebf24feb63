//! What the engine runs: ids instead of names, nothing optional left.

mod domain;
mod dump;
pub mod geometric;
mod granted;
mod show;
mod social;
mod value;
mod walk;

pub use domain::*;
pub use dump::dump;
pub use granted::{asks_geometry, without_geometry};
pub use show::show_expr;
pub use social::*;
pub use value::{EntitySet, ScalarSet, Value};
