//! `sgap check DOMAIN [WORLD]`.

use clap::Args;

use super::Inputs;
use super::output::{Failure, say};

/// What to check.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    inputs: Inputs,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let checked = options.inputs.check()?;
    let (actions, methods) = (checked.actions.len(), checked.methods.len());
    say(&format!(
        "no errors: {actions} actions, {methods} methods, {} entities, {} attributes\n",
        checked.entities.len(),
        checked.attributes.len()
    ));
    Ok(())
}
