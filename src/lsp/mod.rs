//! The language server: what an editor asks about a domain, answered over the Language Server Protocol 3.17
//! (<https://microsoft.github.io/language-server-protocol/>).
//!
//! Diagnostics while typing, hover, definition, references, highlights, rename, completion, outline, formatting, quick fixes. A document is looked at with
//! what it imports and without a world file, so names that only a world would declare are no errors here (see `diagnostics`).
//! Does not plan, and writes no file. The only user of the `lsp` crates.
//!
//! Bounded: a document larger than 8 MB is not looked into, the parser refuses too many tokens and too deep brackets, and each
//! change costs one reading of the file, whatever was typed meanwhile.

mod analysis;
mod comment;
mod completion;
mod diagnostics;
mod document;
mod editor;
mod fixes;
mod formatting;
mod hover;
mod index;
mod keywords;
mod mend;
mod navigate;
mod outline;
mod place;
mod position;
mod rename;
mod server;
mod wire;

use crate::source::Files;

/// Serves one editor on the standard input and output until it says `exit` or goes away.
///
/// `files` are for imports. `Ok(true)` if it said `shutdown` before, as the protocol asks. The error says why the connection broke.
pub fn serve_stdio(files: &dyn Files) -> Result<bool, String> {
    let connected = wire::connect(std::io::stdin(), std::io::stdout());
    let (connection, wire) = connected.map_err(|e| format!("no threads to talk with: {e}"))?;
    let ended_well = server::serve(&connection, files);
    // The writer's thread ends when nobody can send any more.
    drop(connection);
    wire.close()?;
    Ok(ended_well)
}
