//! Runs the planner for tests: files to a plan that `validate` has accepted, or to the reasons why there is none.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use sgap::diag::render;
use sgap::engine::{self, Aim, Branching, Budget, Cuts, Outcome};
use sgap::grp::{self, Grp};
use sgap::ir::{Domain, Goal};
use sgap::load::{Input, Paths, load_paths};
use sgap::plan::Plan;
use sgap::report::json;
use sgap::source::{Files, Sources};
use sgap::validate::{self, Fault, Verdict};
use sgap::world::World;

/// The file system.
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        std::fs::read_to_string(path).map_err(|e| e.to_string())
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.filter_map(|e| e.file_name().into_string().ok()).collect()
    }
}

/// What to plan, and how; paths are relative to the project.
#[derive(Debug, Clone, Copy)]
pub struct Case<'a> {
    pub domain: &'a str,
    /// `None` plans on the symbols alone.
    pub world: Option<&'a str>,
    pub task: Option<&'a str>,
    pub seed: u64,
    pub branching: u32,
    pub best: bool,
    pub expansions: u64,
}

impl<'a> Case<'a> {
    /// The command line's defaults.
    pub fn new(domain: &'a str, world: &'a str) -> Self {
        Case {
            world: Some(world),
            ..Case::symbolic(domain)
        }
    }

    /// As [`Case::new`], without a world.
    pub fn symbolic(domain: &'a str) -> Self {
        Case {
            domain,
            world: None,
            task: None,
            seed: 0,
            branching: 3,
            best: false,
            expansions: 100_000,
        }
    }
}

/// A planned case: the input, how the search went, and the plan as a reader of its JSON sees it.
pub struct Planned {
    pub domain: Domain,
    pub world: World,
    pub goal: Goal,
    pub outcome: Outcome,
    pub plan: Option<Plan>,
    /// The bytes that `--json` writes.
    pub json: String,
}

impl Planned {
    /// Returns the validator's opinion of a plan for this input.
    pub fn validate(&self, plan: &Plan) -> Result<Verdict, Fault> {
        validate::replay(
            plan,
            &self.domain,
            &self.goal,
            &self.world,
            &validate::Settings::STANDARD,
        )
    }
}

/// Loads and plans; a plan that is found has gone through JSON and back and is accepted by the validator.
pub fn plan(case: &Case<'_>) -> Planned {
    let mut sources = Sources::default();
    let paths = Paths {
        domain: case.domain,
        with: &[],
        world: case.world,
        task: case.task,
    };
    let (input, problems) = load_paths(&paths, &mut sources, &Disk);
    let Some(Input {
        domain,
        world,
        goal: Some(goal),
        ..
    }) = input
    else {
        panic!("{case:?}\n{}", render::render(&problems, &sources, false));
    };
    let stop = Arc::new(AtomicBool::new(false));
    let geometry = grp::Settings {
        placements: 200,
        ik_restarts: 8,
        motion_samples: 3000,
    };
    let mut grp = case
        .world
        .map(|_| Grp::new(&world, geometry, case.seed, Arc::clone(&stop)).expect("the world's arms are chains"));
    let mut granted = engine::Granted::default();
    let reasoner: &mut dyn engine::Reasoner = match &mut grp {
        Some(grp) => grp,
        None => &mut granted,
    };
    let settings = engine::Settings {
        branching: Branching::Fixed(case.branching),
        strategy: engine::Strategy::DepthFirst,
        aim: if case.best { Aim::Best } else { Aim::First },
        interleave: domain.settings.interleave,
        cuts: Cuts::On,
        budget: Budget {
            expansions: case.expansions,
            depth: 10_000,
        },
        fall_back: None,
    };
    let outcome = engine::solve(&domain, &goal, reasoner, &settings, &stop, &mut |_, _| {});
    let written = outcome.found.as_ref().map(|found| {
        let document = engine::document(found, &domain, &goal, case.seed, &|gas| grp.as_ref()?.geometry(gas));
        json::write(&document).expect("a plan is JSON")
    });
    let json = written.unwrap_or_default();
    let plan = (!json.is_empty()).then(|| json::read(&json).expect("what is written can be read"));
    let planned = Planned {
        domain,
        world,
        goal,
        outcome,
        plan,
        json,
    };
    if let Some(plan) = &planned.plan
        && let Err(fault) = planned.validate(plan)
    {
        panic!("{case:?}\nthe validator refuses the plan: {fault}");
    }
    planned
}
