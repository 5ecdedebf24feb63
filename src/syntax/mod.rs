//! HATP text to AST; knows no names, no types.
//!
//! `grammar/hatp.pest` is the language; `parser` is the only user of pest.

pub mod ast;
mod layout;
mod parser;
mod words;

pub use parser::{parse, parse_call};
