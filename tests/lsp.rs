//! `sgap lsp` as an editor meets it: a scripted client talks to the real program over its standard input and output.
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]

#[path = "lsp/client.rs"]
mod client;
#[path = "lsp/editors.rs"]
mod editors;
#[path = "lsp/files.rs"]
mod files;
#[path = "lsp/names.rs"]
mod names;
#[path = "lsp/protocol.rs"]
mod protocol;
#[path = "lsp/typing.rs"]
mod typing;

/// The domain of the README.
const THREE_OBJECTS: &str = include_str!("../domains/three_objects.hatp");

/// A small domain with every kind of name, and characters of one, two and four bytes before them.
const SMALL: &str = include_str!("lsp/small.hatp");
