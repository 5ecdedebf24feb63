//! What the engine runs: ids instead of names, nothing optional left.

mod domain;
mod dump;

pub use domain::*;
pub use dump::dump;
