//! The command line: arguments in, text out, exit code. The only place with a clock, a file system and a terminal.

mod check;
mod doc;
mod explain;
mod export;
mod facts;
mod fmt;
mod import;
mod lsp;
mod new;
mod output;
mod picture;
mod plan;
mod problems;
mod progress;
mod repair;
mod reproduce;
mod trace;
mod validate;
mod view;
mod watch;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use output::{Failure, Verbosity, note, say};
use problems::{Form, ProblemOptions, To};
use sgap::diag::levels::Levels;
use sgap::diag::suggest::did_you_mean;
use sgap::diag::{Problem, Problems};
use sgap::hddl::Names;
use sgap::ir;
use sgap::load::{Input, Paths, check_domain, load_paths};
use sgap::plan::Plan;
use sgap::planner::{self, Disk};
use sgap::report::json;
use sgap::source::Sources;
use sgap::world::World;

/// Exit codes, documented in `docs/exit-codes.md`.
pub(crate) mod code {
    /// The input has problems.
    pub(crate) const PROBLEMS: u8 = 1;
    /// The arguments do not fit together; clap has the same code.
    pub(crate) const WRONG_USAGE: u8 = 2;
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
    /// Say nothing but the answer and what is wrong
    #[arg(short, long, global = true, help_heading = "Output")]
    quiet: bool,
    /// Say more: counts and times of a search, as `--stats` does
    #[arg(short, long, global = true, conflicts_with = "quiet", help_heading = "Output")]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Find a plan for the world's task
    #[command(after_help = "Examples:
  sgap plan domains/three_objects.hatp worlds/three_objects.toml
  sgap plan domains/three_objects.hatp worlds/three_objects.toml --json -o plan.json
  sgap plan domains/three_objects.hatp worlds/three_objects.toml --best --branching 2
  sgap plan domains/clear_table.hatp --task 'ClearTable(TABLE)' --all 3
  sgap plan domains/transport.hddl domains/transport_1.hddl --format ipc
  sgap plan domains/clear_table.hatp --task 'ClearTable(TABLE); Wipe(PR2, TABLE) > 1'
  sgap plan domains/three_objects.hatp worlds/three_objects.toml --from plan.json --after 2 --seed 3")]
    Plan(plan::Options),
    /// Check a plan again from nothing: every test, effect, trajectory, collision and fact
    #[command(after_help = "Examples:
  sgap validate domains/three_objects.hatp worlds/three_objects.toml plan.json
  sgap validate domains/clear_table.hatp plan.json --task 'ClearTable(TABLE)'")]
    Validate(validate::Options),
    /// Say what a search did: a tree of its tasks with counts, and what ended its branches
    #[command(after_help = "Examples:
  sgap plan domains/clear_table.hatp --task 'ClearTable(TABLE)' --trace search.jsonl
  sgap trace search.jsonl
  sgap trace search.jsonl --task 'ClearTable' --failures")]
    Trace(trace::Options),
    /// Look for mistakes in a domain, alone or together with a world
    #[command(after_help = "Examples:
  sgap check domains/three_objects.hatp
  sgap check domains/three_objects.hatp worlds/three_objects.toml
  sgap check domains/clear_table.hatp --task 'ClearTable(TABLE)'")]
    Check(check::Options),
    /// Tell what a problem means, with a wrong example and a right one
    #[command(after_help = "Examples:
  sgap explain hatp::unknown-task
  sgap explain unused-variable
  sgap explain --list")]
    Explain(explain::Options),
    /// List what the language has built in, or what a domain declares, with its comments
    #[command(after_help = "Examples:
  sgap doc
  sgap doc pick
  sgap doc domains/three_objects.hatp
  sgap doc domains/three_objects.hatp MoveObj")]
    Doc(doc::Options),
    /// Write domain files in the one layout: comments, words and grouping stay
    #[command(after_help = "Examples:
  sgap fmt domains/three_objects.hatp
  sgap fmt --check domains/three_objects.hatp domains/ramification.hatp
  sgap fmt - < domains/three_objects.hatp")]
    Fmt(fmt::Options),
    /// Tell a domain and a problem of HDDL in HATP
    ///
    /// `sgap plan` takes the pair as well, without this step.
    #[command(after_help = "Examples:
  sgap import domains/transport.hddl domains/transport_1.hddl -o transport.hatp
  sgap plan transport.hatp --task 'Problem()'")]
    Import(import::Options),
    /// Print every geometric fact of a world, at the start or after a plan; or answer single questions and say why
    #[command(after_help = "Examples:
  sgap facts worlds/three_objects.toml
  sgap facts worlds/three_objects.toml --all --json
  sgap facts worlds/three_objects.toml 'isReachable(RED_CUBE, BOB)' 'distance(RED_CUBE, TABLE)'
  sgap plan domains/three_objects.hatp worlds/three_objects.toml --json -o plan.json
  sgap facts worlds/three_objects.toml --after plan.json --actions 2 --changed")]
    Facts(facts::Options),
    /// Write a page that shows a plan, or a world alone, in 3D
    ///
    /// With a domain it plans first; with a plan it shows that one; with a world alone, how everything stands at the start.
    #[command(override_usage = "sgap view [OPTIONS] <DOMAIN> [WORLD]\n       \
                                sgap view [OPTIONS] <WORLD> [PLAN]\n       \
                                sgap view [OPTIONS] <PLAN>")]
    #[command(after_help = "Examples:
  sgap view domains/three_objects.hatp worlds/three_objects.toml -o page.html
  sgap view domains/clear_table.hatp --task 'ClearTable(TABLE)'
  sgap view worlds/three_objects.toml
  sgap view worlds/three_objects.toml plan.json")]
    View(view::Options),
    /// Run the experiments of Gharbi's thesis and print its figures beside ours
    #[command(after_help = "Examples:
  sgap reproduce --runs 3
  sgap reproduce 4.3")]
    Reproduce(reproduce::Options),
    /// Plan again whenever one of the files is saved; Ctrl-C ends it
    #[command(after_help = "Takes what `sgap plan` takes:
  sgap watch domains/three_objects.hatp worlds/three_objects.toml")]
    Watch(plan::Options),
    /// Make a folder with a small domain, a world and a test that run
    #[command(after_help = "Examples:
  sgap new kitchen
  sgap plan kitchen/kitchen.hatp kitchen/kitchen.toml")]
    New(new::Options),
    /// Print the JSON schema of plan documents
    #[command(after_help = "Examples:
  sgap schema > sgap-plan.schema.json")]
    Schema,
    /// Print what a shell needs to complete this program's commands and options
    #[command(after_help = "Examples:
  sgap completions bash > ~/.local/share/bash-completion/completions/sgap
  sgap completions zsh > ~/.zfunc/_sgap
  sgap completions fish > ~/.config/fish/completions/sgap.fish")]
    Completions {
        /// Whose
        shell: clap_complete::Shell,
    },
    /// Print the manual page of this program, or of one of its commands
    #[command(after_help = "Examples:
  sgap man > sgap.1
  sgap man plan > sgap-plan.1")]
    Man {
        /// Command, such as `plan`
        command: Option<String>,
    },
    /// Answer an editor over the Language Server Protocol, on the standard input and output
    #[command(after_help = "An editor starts it: see docs/editors.md.")]
    Lsp(lsp::Options),
}

/// A domain, and a world if geometry is to be asked.
#[derive(Debug, Args)]
struct Inputs {
    /// Domain file (.hatp, .dom, .hddl)
    domain: PathBuf,
    /// World file (.toml); without one the symbols alone are planned. Behind a domain in HDDL, its problem (.hddl)
    world: Option<PathBuf>,
    /// Another file of the domain, such as the functions that it leaves outside; may be given several times
    #[arg(long, value_name = "FILE")]
    with: Vec<PathBuf>,
    /// Task instead of the world file's: 'MoveObjs(PR2, [CUP], SHELF, TABLE, BOB)'; or several with their order:
    /// 'Get(A, CUP); Get(B, BOX); Sit(A) > 1, 2'
    #[arg(long, value_name = "TASK")]
    task: Option<String>,
    #[command(flatten)]
    problems: ProblemOptions,
}

impl Inputs {
    /// Reads what is named with `read`; prints problems and warnings.
    fn read<T>(
        &self,
        to: To,
        read: impl FnOnce(&Paths<'_>, &mut Sources, &Disk) -> (Option<T>, Problems),
    ) -> Result<T, Failure> {
        let mut sources = Sources::default();
        let domain = self.domain.to_string_lossy();
        let world = self.world.as_ref().map(|w| w.to_string_lossy());
        let with: Vec<_> = self.with.iter().map(|w| w.to_string_lossy()).collect();
        let with: Vec<&str> = with.iter().map(AsRef::as_ref).collect();
        let paths = Paths {
            domain: &domain,
            with: &with,
            world: world.as_deref(),
            task: self.task.as_deref(),
        };
        let (value, problems) = read(&paths, &mut sources, &Disk);
        self.problems.report(problems, &sources, value, to)
    }

    /// Returns the names of the files, each once, for headings.
    fn title(&self) -> String {
        let name = |path: &Path| {
            path.file_stem()
                .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
        };
        let first = name(&self.domain);
        match self.world.as_deref().map(name) {
            Some(second) if second != first => format!("{first}, {second}"),
            _ => first,
        }
    }

    fn load(&self) -> Result<Input, Failure> {
        self.load_to(To::Error)
    }

    fn load_to(&self, to: To) -> Result<Input, Failure> {
        self.read(to, |paths, sources, files| load_paths(paths, sources, files))
    }

    /// Checks what is named; a domain alone keeps its geometry.
    fn check(&self) -> Result<ir::Domain, Failure> {
        if self.world.is_none() && self.task.is_none() {
            return self.read(To::Output, |paths, sources, files| check_domain(paths, sources, files));
        }
        self.load_to(To::Output).map(|input| input.domain)
    }

    /// Loads what is named with the task; that none is named is an error that says how to.
    fn load_with_goal(&self) -> Result<Ready, Failure> {
        let input = self.load()?;
        let Some(goal) = input.goal else {
            let (domain, world) = (
                self.domain.to_string_lossy(),
                self.world.as_ref().map(|w| w.to_string_lossy()),
            );
            let paths = Paths {
                domain: &domain,
                world: world.as_deref(),
                ..Paths::default()
            };
            let problem = planner::no_task(&paths);
            let problems = Problems(vec![problem]);
            return self.problems.report(problems, &Sources::default(), None, To::Error);
        };
        if input.is_granted {
            note("note: without a world file all that asks geometry is taken as granted\n");
        }
        Ok(Ready {
            domain: input.domain,
            world: input.world,
            has_world: self.world.is_some() && input.names.is_none(),
            goal,
            names: input.names,
        })
    }
}

/// Loads a world alone.
fn load_world(path: &Path, options: &ProblemOptions) -> Result<World, Failure> {
    let mut sources = Sources::default();
    let (world, problems) = sgap::world::load(&path.to_string_lossy(), &mut sources, &Disk);
    options.report(problems, &sources, world, To::Error)
}

/// Reads a plan as `sgap plan --json` writes it.
fn read_plan(path: &Path) -> Result<Plan, Failure> {
    let path = path.to_string_lossy();
    Disk::read_plan(&path)
        .and_then(|text| json::read(&text))
        .or_else(|why| {
            let problem = Problem::unplaced("plan::unreadable", format!("can't read the plan `{path}`: {why}"));
            report(Problems(vec![problem]), &Sources::default(), None)
        })
}

/// All that a search or a replay needs.
struct Ready {
    domain: ir::Domain,
    /// Empty without a world file.
    world: World,
    has_world: bool,
    goal: ir::Goal,
    /// Of a pair of HDDL files.
    names: Option<Names>,
}

/// Prints the problems; ends with exit code 1 if there is no value.
fn report<T>(problems: Problems, sources: &Sources, value: Option<T>) -> Result<T, Failure> {
    let problems = Levels::default().apply(problems, sources);
    if !problems.0.is_empty() {
        say(&sgap::diag::render::render(
            &problems,
            sources,
            output::stderr_has_colors(),
        ));
    }
    value.ok_or(Failure::Code(code::PROBLEMS))
}

/// Prints a problem without a place and fails.
fn fail(problem: Problem) -> Failure {
    let _ = report(Problems(vec![problem]), &Sources::default(), None::<()>);
    Failure::Code(code::PROBLEMS)
}

/// Prints why geometry can't be asked about a world.
fn no_geometry(why: impl std::fmt::Display) -> Failure {
    fail(Problem::unplaced("world::no-geometry", why.to_string()))
}

fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "sgap", &mut script);
    output::deliver(None, &mut |out| out.write_all(&script))
}

/// Prints the manual page of a command, or of the program.
fn manual(name: Option<&str>) -> Result<(), Failure> {
    let mut all = Cli::command().disable_help_subcommand(true);
    // Fills in what subcommands have from the program: the version, options for all.
    all.build();
    let command = match name {
        None => all,
        Some(name) => {
            let names: Vec<String> = all.get_subcommands().map(|c| c.get_name().to_owned()).collect();
            let Some(command) = all.find_subcommand(name) else {
                let help = did_you_mean(name, names.iter().map(String::as_str));
                let help = help.unwrap_or_else(|| format!("there are {}", names.join(", ")));
                say(&format!("error: there is no command `{name}`\nhelp: {help}\n"));
                return Err(Failure::Code(code::WRONG_USAGE));
            };
            // As its file is called, sgap-plan.1.
            command
                .clone()
                .name(format!("sgap-{name}"))
                .display_name(format!("sgap-{name}"))
        }
    };
    let mut page = Vec::new();
    let written = clap_mangen::Man::new(command).render(&mut page);
    written.map_err(|e| Failure::Output(e.to_string()))?;
    output::deliver(None, &mut |out| out.write_all(&page))
}

/// Runs the program and returns its exit code.
pub(crate) fn run() -> ExitCode {
    let matches = Cli::command().get_matches();
    if let Some((name, options)) = matches.subcommand()
        && let Ok(Some(form)) = options.try_get_one::<Form>("format")
        && let Some(message) = form.refused_by(name)
    {
        Cli::command().error(ErrorKind::ArgumentConflict, message).exit();
    }
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    output::set_verbosity(match (cli.quiet, cli.verbose) {
        (true, _) => Verbosity::Quiet,
        (false, true) => Verbosity::Verbose,
        (false, false) => Verbosity::Normal,
    });
    let result = match &cli.command {
        Command::Plan(options) => plan::run(options),
        Command::Validate(options) => validate::run(options),
        Command::Trace(options) => trace::run(options),
        Command::Check(options) => check::run(options),
        Command::Explain(options) => explain::run(options),
        Command::Doc(options) => doc::run(options),
        Command::Fmt(options) => fmt::run(options),
        Command::Import(options) => import::run(options),
        Command::Facts(options) => facts::run(options),
        Command::View(options) => view::run(options),
        Command::Reproduce(options) => reproduce::run(options),
        Command::Watch(options) => watch::run(options),
        Command::New(options) => new::run(options),
        Command::Schema => output::print(&format!("{:#}\n", sgap::plan::schema())),
        Command::Completions { shell } => completions(*shell),
        Command::Man { command } => manual(command.as_deref()),
        Command::Lsp(options) => lsp::run(options),
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
