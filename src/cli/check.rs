//! `sgap check DOMAIN [WORLD]`.

use std::path::PathBuf;

use clap::Args;

use super::disk::Disk;
use super::output::{Failure, say};
use super::report;
use sgap::load::{check_domain, load};
use sgap::source::Sources;

/// What to check.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Domain file (.hatp)
    domain: PathBuf,
    /// World file (.toml): its entities, values and task are checked against the domain
    world: Option<PathBuf>,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let mut sources = Sources::default();
    let domain = options.domain.to_string_lossy();
    let (checked, problems) = match &options.world {
        Some(world) => {
            let (input, problems) = load(&domain, &world.to_string_lossy(), None, &mut sources, &Disk);
            (input.map(|i| i.domain), problems)
        }
        None => check_domain(&domain, &mut sources, &Disk),
    };
    let checked = report(problems, &sources, checked)?;
    let (actions, methods) = (checked.actions.len(), checked.methods.len());
    say(&format!(
        "no errors: {actions} actions, {methods} methods, {} entities, {} attributes\n",
        checked.entities.len(),
        checked.attributes.len()
    ));
    Ok(())
}
