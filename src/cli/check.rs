//! `sgap check DOMAIN [WORLD]`.

use clap::Args;

use super::Inputs;
use super::output::{Failure, note};

/// What to check.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    inputs: Inputs,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let checked = options.inputs.check()?;
    let parts = [
        counted(checked.actions.len(), "action", "actions"),
        counted(checked.methods.len(), "method", "methods"),
        counted(checked.entities.len(), "entity", "entities"),
        counted(checked.attributes.len(), "attribute", "attributes"),
    ];
    note(&format!("no errors: {}\n", parts.join(", ")));
    Ok(())
}

/// Says how many there are.
fn counted(n: usize, one: &str, more: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { more })
}
