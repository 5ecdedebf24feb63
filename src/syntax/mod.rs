//! HATP text to AST and back; knows no names, no types.
//!
//! `grammar/hatp.pest` is the language; `parser` is the only user of pest.

pub mod ast;
mod docs;
pub mod layout;
mod parser;
mod print;
mod words;

pub use docs::doc_of;
pub use parser::{parse, parse_call};
pub use print::print;
