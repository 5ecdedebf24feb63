//! What was found and why the rest failed: data only, by names, so that a plan can be read without its domain.

mod document;
mod refusal;
mod text;

pub use document::*;
pub use refusal::*;
pub use text::{Changes, Text};
