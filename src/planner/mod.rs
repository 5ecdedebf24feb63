//! The door of the crate: a domain and a world to plans, or to why there is none.
//!
//! Joins `load`, the reasoner, `engine` and the plan document for every program that plans, `sgap plan` included. Decides
//! nothing of its own: what is searched is in [`Options`], how it went in [`Answer`]. No clock: whoever wants an end in time
//! sets the stop flag.

mod disk;
mod keep;
mod options;

use std::fmt;
use std::sync::Arc;

pub use disk::Disk;
pub use keep::keep;
pub use options::{News, Options};

use crate::diag::render::render;
use crate::diag::{Problem, Problems};
use crate::engine::{self, Ending, Granted, Hooks, Observer, Reasoner, Statistics};
use crate::grp::{self, Grp};
use crate::ir::{Domain, Goal};
use crate::load::{self, Input, Paths};
use crate::plan::{Plan, WhyNot};
use crate::source::{Files, Sources};
use crate::world::World;

/// How a search went, and what it found.
#[derive(Debug)]
pub struct Answer {
    /// The first plan or the best one; with [`engine::Aim::All`], all in the order found. Empty if there is none.
    pub plans: Vec<Plan>,
    pub ending: Ending,
    /// With [`Options::keep`], the first kept action that can't be done, whatever the tasks are; `why_not` has its reason.
    pub impossible: Option<usize>,
    /// No plan costs less.
    pub least_cost: f64,
    pub statistics: Statistics,
    /// What geometry has computed; `None` if it was granted, or answered by a reasoner of the caller's.
    pub geometry: Option<grp::Counts>,
    /// What ended the branches of the search; `report::text::no_plan` puts it into words.
    pub why_not: WhyNot,
}

impl Answer {
    /// Returns the first plan, or the best one.
    pub fn plan(&self) -> Option<&Plan> {
        self.plans.first()
    }
}

/// What is wrong with the texts, so that nothing could be planned. As text it is what `sgap plan` prints.
#[derive(Debug)]
pub struct Rejected {
    pub problems: Problems,
    /// All that was read; places of the problems point into it.
    pub sources: Sources,
}

impl fmt::Display for Rejected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&render(&self.problems, &self.sources, false))
    }
}

impl std::error::Error for Rejected {}

/// Reads a domain and perhaps a world, and plans the task.
///
/// Without a world geometry is granted, unless [`Options::reasoner`] answers for it. Warnings are not told.
///
/// # Errors
///
/// All problems of the texts at once.
pub fn plan(paths: &Paths<'_>, files: &dyn Files, options: Options<'_>) -> Result<Answer, Rejected> {
    let mut sources = Sources::default();
    let (input, mut problems) = match options.reasoner {
        Some(_) => load::load_to_ask(paths, &mut sources, files),
        None => load::load_paths(paths, &mut sources, files),
    };
    let rejected = |problems: Problems, sources| Rejected {
        problems: problems.sorted(),
        sources,
    };
    let Some(Input {
        domain,
        world,
        goal,
        names,
        ..
    }) = input
    else {
        return Err(rejected(problems, sources));
    };
    let Some(goal) = goal else {
        problems.push(no_task(paths));
        return Err(rejected(problems, sources));
    };
    // The second file of an HDDL pair is no world.
    let world = paths.world.filter(|_| names.is_none()).map(|_| &world);
    search(&domain, world, &goal, options).map_err(|problem| {
        problems.push(*problem);
        rejected(problems, sources)
    })
}

/// Plans what is loaded already. Without a world geometry is granted, unless [`Options::reasoner`] answers for it.
///
/// # Errors
///
/// Geometry can't be asked about this world.
pub fn search(
    domain: &Domain,
    world: Option<&World>,
    goal: &Goal,
    options: Options<'_>,
) -> Result<Answer, Box<Problem>> {
    let mut granted = Granted::default();
    let mut grp = match (&options.reasoner, world) {
        (None, Some(world)) => {
            let grp = Grp::new(world, options.geometry, options.seed, Arc::clone(&options.stop));
            Some(grp.map_err(|why| Problem::unplaced("world::no-geometry", why))?)
        }
        _ => None,
    };
    // What asks geometry is not asked twice.
    let is_symbolic = options.reasoner.is_none() && grp.is_none();
    let reasoner: &mut dyn Reasoner = match (options.reasoner, &mut grp) {
        (Some(own), _) => own,
        (None, Some(grp)) => grp,
        (None, None) => &mut granted,
    };
    let settings = engine::Settings {
        interleave: options.interleave.unwrap_or(domain.settings.interleave),
        ..options.search
    };
    let mut on_plan = options.on_plan;
    let hooks = Hooks {
        stop: &options.stop,
        on_plan: &mut |found, statistics| {
            if let Some(hear) = &mut on_plan {
                hear(&News {
                    domain,
                    found,
                    statistics,
                });
            }
        },
        observer: options.observer.map(|o| o as &mut dyn Observer),
    };
    let blocks_first = is_symbolic
        && options.interleave.is_none()
        && settings.interleave
        && settings.aim == engine::Aim::First
        && options.kept.is_empty()
        && hooks.observer.is_none();
    let outcome = if blocks_first {
        in_blocks_first(domain, goal, reasoner, &settings, hooks)
    } else {
        engine::repair(domain, goal, options.kept, reasoner, &settings, hooks)
    };
    let geometry = |gas| grp.as_ref().and_then(|grp| grp.geometry(gas));
    let document = |found| {
        let document = if options.decomposition {
            engine::document
        } else {
            engine::schedule
        };
        let mut plan = document(found, domain, goal, options.seed, &geometry);
        keep::as_written(&mut plan, options.kept);
        plan
    };
    Ok(Answer {
        plans: outcome.found.iter().chain(&outcome.others).map(document).collect(),
        ending: outcome.ending,
        impossible: outcome.impossible,
        least_cost: outcome.least_cost,
        statistics: outcome.statistics,
        geometry: grp.as_ref().map(Grp::counts),
        why_not: outcome.why_not,
    })
}

/// HEURISTIC: the part of the budget with which unordered subtasks are done one after the other first.
const IN_BLOCKS: u64 = 10;

/// Searches with each unordered subtask as one block for a part of the budget, and with all mixtures of their steps after
/// that. A plan in blocks is one of the mixtures, so nothing is lost; and mixtures of many subtasks are too many to be tried.
fn in_blocks_first(
    domain: &Domain,
    goal: &Goal,
    reasoner: &mut dyn Reasoner,
    settings: &engine::Settings,
    hooks: Hooks<'_>,
) -> engine::Outcome {
    let Hooks {
        stop,
        on_plan,
        observer,
    } = hooks;
    let budget = settings.budget;
    let part = |expansions| engine::Budget { expansions, ..budget };
    let in_blocks = engine::Settings {
        interleave: false,
        budget: part(budget.expansions / IN_BLOCKS),
        fall_back: Some(0),
        ..*settings
    };
    let quiet = Hooks {
        stop,
        on_plan,
        observer: None,
    };
    let mut first = engine::repair(domain, goal, &[], reasoner, &in_blocks, quiet);
    if let Some(found) = &mut first.found {
        found.interleaved = true;
    }
    if first.found.is_some() || first.ending == Ending::Interrupted {
        return first;
    }
    let done = first.statistics.expansions.max(first.statistics.backtracks);
    let mixed = engine::Settings {
        budget: part(budget.expansions.saturating_sub(done)),
        ..*settings
    };
    let hooks = Hooks {
        stop,
        on_plan,
        observer,
    };
    let mut outcome = engine::repair(domain, goal, &[], reasoner, &mixed, hooks);
    outcome.statistics.add(&first.statistics);
    outcome
}

/// Returns the problem that neither the world nor the caller names a task.
pub fn no_task(paths: &Paths<'_>) -> Problem {
    let (path, help) = match paths.world {
        Some(world) => (
            world,
            "add `task = \"Task(ARGUMENTS)\"` at its top, or give `--task 'Task(ARGUMENTS)'`",
        ),
        None => (
            paths.domain,
            "give `--task 'Task(ARGUMENTS)'`, or a world file with `task = \"Task(ARGUMENTS)\"`",
        ),
    };
    Problem::unplaced("world::no-task", format!("`{path}` names no task")).help(help)
}
