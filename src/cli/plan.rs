//! `sgap plan DOMAIN [WORLD]`.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};

use super::export;
use super::output::{Failure, Verbosity, check_place, deliver, note, say, verbosity};
use super::problems::Form;
use super::progress::Progress;
use super::repair::RepairOptions;
use super::trace;
use super::{Inputs, Ready, code};
use sgap::engine::{self, Aim, Branching, Cuts, Ending, Kept, Observer, Strategy};
use sgap::grp;
use sgap::hddl;
use sgap::plan::Plan;
use sgap::planner::{self, Answer, News};
use sgap::report::{json, text};

/// What to search, and how long.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    pub inputs: Inputs,
    #[command(flatten)]
    pub search: SearchOptions,
    #[command(flatten)]
    repair: RepairOptions,
    /// Write the whole plan with its trajectories as JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Write to this file instead of the standard output
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Write all that the search does to this file, as JSON lines; `sgap trace FILE` reads it
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    trace: Option<PathBuf>,
    /// Write times into the trace, too: then no two runs write the same bytes
    #[arg(long, requires = "trace", help_heading = "Output")]
    trace_times: bool,
}

/// The search's settings, for every command that plans.
#[derive(Debug, Args)]
pub(super) struct SearchOptions {
    /// Geometric alternatives tried per action, the first included; or `adaptive`: more for actions whose alternatives lead
    /// further
    #[arg(long, value_name = "N", default_value = "3", value_parser = branching, help_heading = "Search")]
    branching: Branching,
    /// In which order choices are tried; all but `depth-first` begin again until nothing is left out
    #[arg(long, value_enum, default_value_t = Order::DepthFirst, help_heading = "Search")]
    strategy: Order,
    /// Go on to the cheapest plan; each better one is announced as it comes
    #[arg(long, help_heading = "Search")]
    best: bool,
    /// Find up to N plans, no two of the same sequence of actions; the standard error says why there are fewer
    #[arg(long, value_name = "N", conflicts_with = "best", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Search")]
    all: Option<u32>,
    /// Let unordered subtasks mix step by step, instead of doing each as one block; `--interleave=false` wins over the
    /// domain's settings
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true, help_heading = "Search")]
    interleave: Option<bool>,
    /// Try even what repeats itself or is known to fail; for comparison
    #[arg(long, help_heading = "Search")]
    no_cuts: bool,
    /// Seed of every random choice: same input, same seed, same plan
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Search")]
    seed: u64,
    /// Placements tried per geometric action
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Limits")]
    placements: u32,
    /// Tasks taken up before the search gives up
    #[arg(long, value_name = "N", default_value_t = 10_000_000, help_heading = "Limits")]
    max_expansions: u64,
    /// Tasks taken up by the search that is made again where tasks came back to themselves; 0: none is made [default: 10
    /// times as many as before and at least 10000, with 2 times as many geometric actions and at least 100]
    #[arg(long, value_name = "N", help_heading = "Limits")]
    max_fall_back: Option<u64>,
    /// Methods inside methods before a branch gives up
    #[arg(long, value_name = "N", default_value_t = 100_000, help_heading = "Limits")]
    max_depth: usize,
    /// Seconds before the search ends with the best plan so far
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true, help_heading = "Limits")]
    timeout: Option<Duration>,
    /// Print counts and times of the search to the standard error
    #[arg(long, help_heading = "Output")]
    stats: bool,
}

/// In which order choices are tried.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Order {
    /// The order of the files, to the end
    DepthFirst,
    /// First what takes another option than the first at few choices
    LimitedDiscrepancy,
    /// Again and again, in orders drawn from the seed
    Restarts,
}

impl Order {
    fn with(self, seed: u64) -> Strategy {
        match self {
            Order::DepthFirst => Strategy::DepthFirst,
            Order::LimitedDiscrepancy => Strategy::LimitedDiscrepancy,
            Order::Restarts => Strategy::Restarts { seed },
        }
    }
}

fn branching(text: &str) -> Result<Branching, String> {
    match (text, text.parse()) {
        ("adaptive", _) => Ok(Branching::Adaptive),
        (_, Ok(n)) if n > 0 => Ok(Branching::Fixed(n)),
        _ => Err("write a number from 1 on, or `adaptive`".into()),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s: &f64| (0.0..=LONGEST).contains(s));
    let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    duration.ok_or_else(|| format!("write a number of seconds from 0 to {LONGEST}"))
}

/// A year; nobody waits longer [s].
const LONGEST: f64 = 31_536_000.0;

impl SearchOptions {
    /// Returns what the library is asked for.
    fn settings<'a>(&self) -> sgap::Options<'a> {
        let mut options = sgap::Options::default()
            .seed(self.seed)
            .placements(self.placements)
            .max_expansions(self.max_expansions)
            .max_depth(self.max_depth);
        options.search.branching = self.branching;
        options.search.fall_back = self.max_fall_back;
        options.search.strategy = self.strategy.with(self.seed);
        options.search.aim = match self.all {
            Some(n) => Aim::All(n),
            None if self.best => Aim::Best,
            None => Aim::First,
        };
        options.search.cuts = if self.no_cuts { Cuts::Off } else { Cuts::On };
        options.interleave = self.interleave;
        options
    }
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if let Some(path) = &options.output {
        check_place(path)?;
    }
    let ready = options.inputs.load_with_goal()?;
    let as_ipc = options.inputs.problems.format == Form::Ipc;
    if as_ipc && (options.json || ready.names.is_none()) {
        say("error: `--format ipc` is for a pair of HDDL files, and not together with `--json`\n");
        return Err(Failure::Code(code::WRONG_USAGE));
    }
    let form = options.inputs.problems.format.export();
    if form.is_some() && (options.json || options.search.all.is_some()) {
        say("error: this `--format` writes one plan: not together with `--json` or `--all`\n");
        return Err(Failure::Code(code::WRONG_USAGE));
    }
    let kept = options.repair.kept(&ready)?;
    let mut sink = match &options.trace {
        Some(path) => {
            let task = ready.domain.show_task(ready.goal.task, &ready.goal.args);
            let seed = options.search.seed;
            Some(trace::open(path, &options.inputs, task, seed, options.trace_times)?)
        }
        None => None,
    };
    let observer = sink.as_mut().map(|s| &mut s.writer as &mut dyn Observer);
    // The table shows no decomposition.
    let decomposition = options.json || as_ipc || form.is_some();
    let repair = Some((&options.repair, kept.as_slice()));
    let plans = search_all(&ready, &options.search, repair, observer, decomposition);
    let is_traced = sink.map_or(Ok(()), trace::Sink::finish);
    let plans = match plans {
        Ok(plans) => plans,
        Err(failure) => return is_traced.and(Err(failure)),
    };
    if let Some(names) = ready.names.as_ref().filter(|_| as_ipc) {
        let texts: Option<Vec<String>> = plans.iter().map(|plan| hddl::ipc(plan, names)).collect();
        let not_whole = || Failure::Output("can't write another task than the problem's as `--format ipc`".into());
        let text = texts.ok_or_else(not_whole)?.join("\n");
        deliver(options.output.as_deref(), &mut |out| out.write_all(text.as_bytes()))?;
        return is_traced;
    }
    if let Some(form) = form {
        let text = export::text(form, &ready.world, plans.first(), &options.inputs.title())?;
        deliver(options.output.as_deref(), &mut |out| out.write_all(text.as_bytes()))?;
        return is_traced;
    }
    let delivered = deliver(options.output.as_deref(), &mut |out| match (
        options.json,
        options.search.all,
        plans.first(),
    ) {
        (true, None, Some(plan)) => json::write_to(plan, out),
        (true, ..) => json::write_all_to(&plans, out),
        (false, ..) => plans.iter().enumerate().try_for_each(|(i, plan)| {
            if i > 0 {
                writeln!(out)?;
            }
            text::write_plan(plan, out)
        }),
    });
    // The program ends: to free a long plan piece by piece would take as long as to write it.
    std::mem::forget(plans);
    delivered?;
    is_traced
}

/// Plans; without a plan says why on the standard error and fails with its exit code. Of several plans, returns the first.
pub(super) fn search(ready: &Ready, options: &SearchOptions) -> Result<Plan, Failure> {
    let plan = search_all(ready, options, None, None, true)?.into_iter().next();
    plan.ok_or(Failure::Code(code::NO_PLAN))
}

/// As [`search`], with all plans that were asked for, one at least; each begins with what is kept. `observer` hears of all
/// that the search does. `decomposition` says whether the plans have to tell theirs.
fn search_all(
    ready: &Ready,
    options: &SearchOptions,
    repair: Option<(&RepairOptions, &[Kept])>,
    observer: Option<&mut dyn Observer>,
    decomposition: bool,
) -> Result<Vec<Plan>, Failure> {
    #[expect(clippy::disallowed_methods, reason = "the time that `--stats` prints")]
    let begin = Instant::now();
    let stop = Arc::new(AtomicBool::new(false));
    stop_on_interrupt(&stop);
    let timed_out = Arc::new(AtomicBool::new(false));
    if let Some(limit) = options.timeout {
        let (stop, timed_out) = (Arc::clone(&stop), Arc::clone(&timed_out));
        let end = move || {
            timed_out.store(true, Ordering::Relaxed);
            stop.store(true, Ordering::Relaxed);
        };
        if limit.is_zero() {
            end();
        } else {
            std::thread::spawn(move || {
                std::thread::sleep(limit);
                end();
            });
        }
    }
    let progress = Progress::new("planning; Ctrl-C ends it with the best plan so far");
    let mut on_plan = |news: &News<'_>| {
        if options.best {
            let (n, cost) = (news.found.steps.len(), news.found.cost);
            progress.say(&format!(
                "plan {}: {n} actions, cost {cost:.4}\n",
                news.statistics.plans
            ));
        }
    };
    let kept = repair.map_or(&[] as &[Kept], |(_, kept)| kept);
    let mut settings = options.settings().keep(kept).stop(stop).on_plan(&mut on_plan);
    settings.decomposition = decomposition;
    let is_traced = observer.is_some();
    settings.observer = observer.map(|o| o as &mut dyn Observer);
    let world = ready.has_world.then_some(&ready.world);
    let answer = planner::search(&ready.domain, world, &ready.goal, settings);
    drop(progress);
    let answer = answer.map_err(|problem| super::fail(*problem))?;
    if options.stats || verbosity() == Verbosity::Verbose {
        say(&statistics(
            &answer.statistics,
            answer.geometry.as_ref(),
            begin.elapsed(),
        ));
    }
    let timed_out = timed_out.load(Ordering::Relaxed);
    if let (Some(index), Some((repair, _))) = (answer.impossible, repair) {
        return Err(repair.impossible(index, &answer.why_not));
    }
    let Some(plan) = answer.plan() else {
        let interleaves = options.interleave.unwrap_or(ready.domain.settings.interleave);
        say(&no_plan(&answer, options, timed_out, interleaves));
        if !is_traced && answer.statistics.expansions > 1 {
            note(TRACE_HINT);
        }
        return Err(Failure::Code(match answer.ending {
            Ending::FirstPlan | Ending::Exhausted => code::NO_PLAN,
            Ending::ExhaustedTruncated(_) => code::NO_PLAN_TRUNCATED,
            Ending::BudgetSpent | Ending::Interrupted => code::NO_PLAN_BUDGET,
        }));
    };
    if options.best {
        let ended = how_it_ended(answer.ending, options, timed_out);
        let gap = gap(answer.ending, plan.cost, answer.least_cost);
        note(&format!("best plan{ended}{gap}\n"));
    }
    if let Some(wanted) = options.all {
        note(&how_many(&answer, wanted, options, timed_out));
    }
    Ok(answer.plans)
}

const TRACE_HINT: &str = "\n--trace FILE writes the whole search; `sgap trace FILE` shows where it failed\n";

/// Returns why there is no plan.
fn no_plan(answer: &Answer, options: &SearchOptions, timed_out: bool, interleaves: bool) -> String {
    let limit = match (answer.ending, options.timeout) {
        (Ending::BudgetSpent, _) => Some(format!("within --max-expansions {}", options.max_expansions)),
        (Ending::Interrupted, Some(limit)) if timed_out => Some(in_time(limit)),
        _ => None,
    };
    match limit {
        Some(limit) => {
            let remedy = match interleaves {
                true => "try more, or `--interleave=false`: one unordered subtask after the other",
                false => "try more",
            };
            format!("no plan found {limit} ({remedy})\n{}", text::reasons(&answer.why_not))
        }
        None => text::no_plan(answer.ending, &answer.statistics, &answer.why_not),
    }
}

/// The first Ctrl-C ends the search with the best plan so far, the second one the program.
fn stop_on_interrupt(stop: &Arc<AtomicBool>) {
    let stop = Arc::clone(stop);
    // Without a handler Ctrl-C ends the program at once, which is all that is lost when there can't be one.
    let _ = ctrlc::set_handler(move || {
        if stop.swap(true, Ordering::Relaxed) {
            #[expect(clippy::exit, reason = "the user insists")]
            std::process::exit(i32::from(code::NO_PLAN_BUDGET));
        }
    });
}

fn in_time(limit: Duration) -> String {
    format!("within --timeout {} s", limit.as_secs_f64())
}

/// Returns how a search for the best plan ended: what follows "best plan".
fn how_it_ended(ending: Ending, options: &SearchOptions, timed_out: bool) -> String {
    match ending {
        Ending::FirstPlan => String::new(),
        Ending::Exhausted => ": every choice was tried".into(),
        Ending::ExhaustedTruncated(cut) => format!(" within the limits: {}", text::truncated(cut)),
        Ending::BudgetSpent => format!(" within --max-expansions {}", options.max_expansions),
        Ending::Interrupted => match options.timeout {
            Some(limit) if timed_out => format!(" {}", in_time(limit)),
            _ => " before the search was interrupted".into(),
        },
    }
}

/// Says why there are fewer plans than were asked for; nothing if there are as many.
fn how_many(answer: &Answer, wanted: u32, options: &SearchOptions, timed_out: bool) -> String {
    let (n, counts) = (answer.plans.len(), &answer.statistics);
    let why = match answer.ending {
        Ending::FirstPlan => return String::new(),
        Ending::Exhausted if counts.repeated > 0 => "every choice was tried but what goes round in a circle".into(),
        Ending::Exhausted => "every choice was tried".into(),
        Ending::ExhaustedTruncated(cut) => text::truncated(cut),
        Ending::BudgetSpent => format!("not more within --max-expansions {}", options.max_expansions),
        Ending::Interrupted => match options.timeout {
            Some(limit) if timed_out => format!("not more {}", in_time(limit)),
            _ => "the search was interrupted".into(),
        },
    };
    let plans = if n == 1 { "plan" } else { "plans" };
    format!("{n} {plans} of the {wanted} asked for: {why}\n")
}

/// Says how far below the best plan another one could be.
fn gap(ending: Ending, cost: f64, least: f64) -> String {
    match ending {
        Ending::Exhausted => String::new(),
        // That no cost is below 0 is known without a search.
        _ if cost > 0.0 && least <= 0.0 => String::new(),
        _ if cost > 0.0 => {
            let percent = 100.0 * (cost - least) / cost;
            format!("; no plan costs less than {least:.4} (gap {percent:.1} %)")
        }
        _ => "; no plan costs less".to_owned(),
    }
}

fn statistics(engine: &engine::Statistics, geometry: Option<&grp::Counts>, time: Duration) -> String {
    let mut text = format!(
        "search      {:.3} s, {} expansions, {} backtracks, {} repeated, {} dead ends, {} plans\n",
        time.as_secs_f64(),
        engine.expansions,
        engine.backtracks,
        engine.repeated,
        engine.dead_ends,
        engine.plans,
    );
    if engine.rounds > 1 {
        text += &format!("rounds      {}{}\n", engine.rounds, text::fall_back(engine));
    }
    if let Some(geometry) = geometry {
        text += &format!(
            "projection  {} actions computed, {} alternatives, {} candidates\n\
             geometry    {} inverse kinematics calls, {} motion plans, {} configurations checked, {} facts, {} requests\n",
            engine.projections,
            engine.alternatives,
            geometry.candidates,
            geometry.ik_calls,
            geometry.motion_plans,
            geometry.configurations_checked,
            geometry.facts,
            geometry.requests,
        );
    }
    text
}
