//! The command line: arguments in, text out, exit code. The only place with a clock, a file system and a terminal.

mod check;
mod disk;
mod facts;
mod fmt;
mod output;
mod plan;
mod progress;
mod validate;
mod view;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use disk::Disk;
use output::{Failure, say};
use sgap::diag::{Problem, Problems};
use sgap::load::{Input, load};
use sgap::source::Sources;

/// Exit codes, documented in `docs/exit-codes.md`.
pub(crate) mod code {
    /// The input has problems.
    pub(crate) const PROBLEMS: u8 = 1;
    /// No plan exists: every choice was tried.
    pub(crate) const NO_PLAN: u8 = 10;
    /// No plan found, and choices were cut short (branching factor, placements, depth).
    pub(crate) const NO_PLAN_TRUNCATED: u8 = 11;
    /// No plan found before the budget or the time was spent, or the user interrupted.
    pub(crate) const NO_PLAN_BUDGET: u8 = 12;
    /// `validate` refuses the plan.
    pub(crate) const PLAN_INVALID: u8 = 20;
    /// A fault of ours.
    pub(crate) const BUG: u8 = 70;
}

const AFTER_HELP: &str = "Example:
  sgap plan domains/three_objects.hatp worlds/three_objects.toml

Exit codes: 0 done; 1 problems in the input; 2 wrong usage; 10 no plan exists; \
11 no plan found, choices were cut short; 12 no plan before the budget was spent; 20 validate refuses the plan; 70 a bug of sgap";

/// Plans what robots and humans do in a scene: a HATP domain says what tasks mean, geometry says whether they can be done here.
#[derive(Debug, Parser)]
#[command(version, after_help = AFTER_HELP, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Find a plan for the world's task
    #[command(after_help = "Examples:
  sgap plan domains/three_objects.hatp worlds/three_objects.toml
  sgap plan domains/three_objects.hatp worlds/three_objects.toml --json -o plan.json
  sgap plan domains/three_objects.hatp worlds/three_objects.toml --best --branching 2")]
    Plan(plan::Options),
    /// Check a plan again from nothing: every test, effect, trajectory, collision and fact
    #[command(after_help = "Example:
  sgap validate domains/three_objects.hatp worlds/three_objects.toml plan.json")]
    Validate(validate::Options),
    /// Look for mistakes in a domain, alone or together with a world
    #[command(after_help = "Examples:
  sgap check domains/three_objects.hatp
  sgap check domains/three_objects.hatp worlds/three_objects.toml")]
    Check(check::Options),
    /// Write domain files in the one layout: comments, words and grouping stay
    #[command(after_help = "Examples:
  sgap fmt domains/three_objects.hatp
  sgap fmt --check domains/three_objects.hatp domains/ramification.hatp
  sgap fmt - < domains/three_objects.hatp")]
    Fmt(fmt::Options),
    /// Print every geometric fact of a world's start state
    #[command(after_help = "Example:
  sgap facts worlds/three_objects.toml")]
    Facts(facts::Options),
    /// Write a page that shows the plan in 3D
    #[command(after_help = "Example:
  sgap view domains/three_objects.hatp worlds/three_objects.toml -o page.html")]
    View(view::Options),
}

/// A domain and a world.
#[derive(Debug, Args)]
struct Inputs {
    /// Domain file (.hatp)
    domain: PathBuf,
    /// World file (.toml)
    world: PathBuf,
    /// Task instead of the world file's: 'MoveObjs(PR2, [CUP], SHELF, TABLE, BOB)'
    #[arg(long, value_name = "TASK")]
    task: Option<String>,
}

impl Inputs {
    /// Loads both; prints problems and warnings to the standard error.
    fn load(&self) -> Result<Input, Failure> {
        let mut sources = Sources::default();
        let (domain, world) = (self.domain.to_string_lossy(), self.world.to_string_lossy());
        let (input, problems) = load(&domain, &world, self.task.as_deref(), &mut sources, &Disk);
        report(problems, &sources, input)
    }

    /// Loads both and the task; a world without one is an error that says how to name it.
    fn load_with_goal(&self) -> Result<(sgap::ir::Domain, sgap::world::World, sgap::ir::Goal), Failure> {
        let Input { domain, world, goal } = self.load()?;
        match goal {
            Some(goal) => Ok((domain, world, goal)),
            None => {
                let message = format!("`{}` names no task", self.world.display());
                let help = "add `task = \"Task(ARGUMENTS)\"` at its top, or give `--task 'Task(ARGUMENTS)'`";
                let problem = Problem::unplaced("world::no-task", message).help(help);
                report(Problems(vec![problem]), &Sources::default(), None)
            }
        }
    }
}

/// Prints the problems; ends with exit code 1 if there is no value.
fn report<T>(problems: Problems, sources: &Sources, value: Option<T>) -> Result<T, Failure> {
    let problems = problems.sorted();
    if !problems.0.is_empty() {
        say(&sgap::diag::render::render(
            &problems,
            sources,
            output::stderr_has_colors(),
        ));
    }
    value.ok_or(Failure::Code(code::PROBLEMS))
}

/// Prints why geometry can't be asked about a world.
fn no_geometry(why: impl std::fmt::Display) -> Failure {
    let problems = Problems(vec![Problem::unplaced("world::no-geometry", why.to_string())]);
    let _ = report(problems, &Sources::default(), None::<()>);
    Failure::Code(code::PROBLEMS)
}

/// Runs the program and returns its exit code.
pub(crate) fn run() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        Command::Plan(options) => plan::run(options),
        Command::Validate(options) => validate::run(options),
        Command::Check(options) => check::run(options),
        Command::Fmt(options) => fmt::run(options),
        Command::Facts(options) => facts::run(options),
        Command::View(options) => view::run(options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Code(code)) => ExitCode::from(code),
        Err(Failure::Output(why)) => {
            let problems = Problems(vec![Problem::unplaced("output::unwritable", why)]);
            let _ = report(problems, &Sources::default(), None::<()>);
            ExitCode::from(code::PROBLEMS)
        }
    }
}
