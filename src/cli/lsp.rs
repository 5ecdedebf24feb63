//! `sgap lsp`.

use clap::Args;
use sgap::Disk;

use super::code;
use super::output::{Failure, say};

/// How to talk.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Talk over the standard input and output; the only way, and what some editors add by themselves
    #[arg(long)]
    stdio: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    // There is no other way.
    let Options { stdio: _ } = options;
    match sgap::lsp::serve_stdio(&Disk) {
        Ok(true) => Ok(()),
        // The protocol: an `exit` without `shutdown` is no good end, and neither is an editor that went away.
        Ok(false) => Err(Failure::Code(code::PROBLEMS)),
        Err(why) => {
            say(&format!("the connection to the editor broke: {why}\n"));
            Err(Failure::Code(code::PROBLEMS))
        }
    }
}
