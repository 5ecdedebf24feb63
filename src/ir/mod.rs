//! What the engine runs: ids instead of names, nothing optional left.

mod domain;
pub mod lower;

pub use domain::*;
