//! HATP text to AST and back; knows no names, no types.
//!
//! `grammar/hatp.pest` is the language; `parser` is the only user of pest.

pub mod ast;
mod format;
mod keywords;
pub mod layout;
mod parser;
mod words;

pub use format::format;
pub use keywords::{Group, Keyword, keywords};
pub use parser::{parse, parse_network};
