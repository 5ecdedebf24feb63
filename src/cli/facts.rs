//! `sgap facts WORLD`.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::output::{Failure, print};
use super::{load_world, problems::ProblemOptions};
use sgap::grp::{Grp, Settings};

/// Which world.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// World file (.toml)
    world: PathBuf,
    /// Seed of the inverse kinematics' restarts
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Print the facts that do not hold, too
    #[arg(long)]
    all: bool,
    /// Print an array of JSON objects
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    problems: ProblemOptions,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let world = load_world(&options.world, &options.problems)?;
    let settings = Settings {
        placements: 0,
        ik_restarts: 0,
        motion_samples: 0,
    };
    let stop = Arc::new(AtomicBool::new(false));
    let mut grp = Grp::new(&world, settings, options.seed, stop).map_err(super::no_geometry)?;
    let facts: Vec<_> = grp
        .all_facts()
        .into_iter()
        .filter(|(.., holds)| *holds || options.all)
        .collect();
    if options.json {
        let rows: Vec<serde_json::Value> = facts
            .iter()
            .map(|(name, a, b, holds)| {
                serde_json::json!({"fact": name, "arguments": [world.scene.id(*a), world.scene.id(*b)], "holds": holds})
            })
            .collect();
        return print(&format!("{:#}\n", serde_json::Value::Array(rows)));
    }
    let mut text = String::new();
    for (name, a, b, holds) in facts {
        let not = if holds { "" } else { "not " };
        text.push_str(&format!("{not}{name}({}, {})\n", world.scene.id(a), world.scene.id(b)));
    }
    print(&text)
}
