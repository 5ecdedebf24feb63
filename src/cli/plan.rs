//! `sgap plan DOMAIN [WORLD]`.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Args;

use super::output::{Failure, check_place, deliver, say};
use super::progress::Progress;
use super::{Inputs, Ready, code};
use sgap::engine::{self, Aim, Budget, Cuts, Ending};
use sgap::grp::{self, Grp};
use sgap::plan::Plan;
use sgap::report::{json, text};

/// What to search, and how long.
#[derive(Debug, Args)]
pub(super) struct Options {
    #[command(flatten)]
    pub inputs: Inputs,
    #[command(flatten)]
    pub search: SearchOptions,
    /// Write the whole plan with its trajectories as JSON
    #[arg(long)]
    json: bool,
    /// Write to this file instead of the standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The search's settings, for every command that plans.
#[derive(Debug, Args)]
pub(super) struct SearchOptions {
    /// Geometric alternatives tried per action, the first included
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    branching: u32,
    /// Go on to the cheapest plan; each better one is announced as it comes
    #[arg(long)]
    best: bool,
    /// Find up to N plans, no two of the same sequence of actions; the standard error says why there are fewer
    #[arg(long, value_name = "N", conflicts_with = "best", value_parser = clap::value_parser!(u32).range(1..))]
    all: Option<u32>,
    /// Let unordered subtasks mix step by step, instead of doing each as one block; `--interleave=false` wins over the
    /// domain's settings
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true)]
    interleave: Option<bool>,
    /// Try even what repeats itself or is known to fail; for comparison
    #[arg(long)]
    no_cuts: bool,
    /// Seed of every random choice: same input, same seed, same plan
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Placements tried per geometric action
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    placements: u32,
    /// Tasks taken up before the search gives up
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    max_expansions: u64,
    /// Methods inside methods before a branch gives up
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    max_depth: usize,
    /// Seconds before the search ends with the best plan so far
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    timeout: Option<Duration>,
    /// Print counts and times of the search to the standard error
    #[arg(long)]
    stats: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s: &f64| (0.0..=LONGEST).contains(s));
    let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    duration.ok_or_else(|| format!("write a number of seconds from 0 to {LONGEST}"))
}

/// A year; nobody waits longer [s].
const LONGEST: f64 = 31_536_000.0;

/// HEURISTIC budgets of geometry that no user needs to know.
const IK_RESTARTS: u32 = 8;
const MOTION_SAMPLES: u32 = 3000;

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if let Some(path) = &options.output {
        check_place(path)?;
    }
    let ready = options.inputs.load_with_goal()?;
    let plans = search_all(&ready, &options.search)?;
    deliver(
        options.output.as_deref(),
        &mut |out| match (options.json, options.search.all, plans.first()) {
            (true, None, Some(plan)) => json::write_to(plan, out),
            (true, ..) => json::write_all_to(&plans, out),
            (false, ..) => plans.iter().enumerate().try_for_each(|(i, plan)| {
                if i > 0 {
                    writeln!(out)?;
                }
                text::write_plan(plan, out)
            }),
        },
    )
}

/// Plans; without a plan says why on the standard error and fails with its exit code. Of several plans, returns the first.
pub(super) fn search(ready: &Ready, options: &SearchOptions) -> Result<Plan, Failure> {
    let plan = search_all(ready, options)?.into_iter().next();
    plan.ok_or(Failure::Code(code::NO_PLAN))
}

/// As [`search`], with all plans that were asked for: one at least.
fn search_all(ready: &Ready, options: &SearchOptions) -> Result<Vec<Plan>, Failure> {
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
    let Ready {
        domain, world, goal, ..
    } = ready;
    let settings = engine::Settings {
        branching: options.branching,
        aim: match options.all {
            Some(n) => Aim::All(n),
            None if options.best => Aim::Best,
            None => Aim::First,
        },
        interleave: options.interleave.unwrap_or(domain.settings.interleave),
        cuts: if options.no_cuts { Cuts::Off } else { Cuts::On },
        budget: Budget {
            expansions: options.max_expansions,
            depth: options.max_depth,
        },
    };
    let geometry = grp::Settings {
        placements: options.placements,
        ik_restarts: IK_RESTARTS,
        motion_samples: MOTION_SAMPLES,
    };
    let mut grp = match ready.has_world {
        true => Some(Grp::new(world, geometry, options.seed, Arc::clone(&stop)).map_err(super::no_geometry)?),
        false => None,
    };
    let mut granted = engine::Granted::default();
    let reasoner: &mut dyn engine::Reasoner = match &mut grp {
        Some(grp) => grp,
        None => &mut granted,
    };
    let progress = Progress::new("planning; Ctrl-C ends it with the best plan so far");
    let outcome = engine::solve(domain, goal, reasoner, &settings, &stop, &mut |found, statistics| {
        if options.best {
            let (n, cost) = (found.steps.len(), found.cost);
            progress.say(&format!("plan {}: {n} actions, cost {cost:.4}\n", statistics.plans));
        }
    });
    drop(progress);
    if options.stats {
        let counts = grp.as_ref().map(Grp::counts);
        say(&statistics(&outcome.statistics, counts.as_ref(), begin.elapsed()));
    }
    match outcome.found {
        Some(found) => {
            let timed_out = timed_out.load(Ordering::Relaxed);
            if options.best {
                let ended = how_it_ended(outcome.ending, options, timed_out);
                let gap = gap(outcome.ending, found.cost, outcome.least_cost);
                say(&format!("best plan{ended}{gap}\n"));
            }
            if let Some(wanted) = options.all {
                let n = 1 + outcome.others.len();
                say(&how_many(
                    n,
                    wanted,
                    outcome.ending,
                    &outcome.statistics,
                    options,
                    timed_out,
                ));
            }
            let geometry = |gas| grp.as_ref().and_then(|grp| grp.geometry(gas));
            let document = |found| engine::document(found, domain, goal, options.seed, &geometry);
            Ok(std::iter::once(&found).chain(&outcome.others).map(document).collect())
        }
        None => {
            let limit = match (outcome.ending, options.timeout) {
                (Ending::BudgetSpent, _) => Some(format!("within --max-expansions {}", options.max_expansions)),
                (Ending::Interrupted, Some(limit)) if timed_out.load(Ordering::Relaxed) => Some(in_time(limit)),
                _ => None,
            };
            say(&match limit {
                Some(limit) => format!("no plan found {limit} (try more)\n{}", text::reasons(&outcome.why_not)),
                None => text::no_plan(outcome.ending, &outcome.statistics, &outcome.why_not),
            });
            Err(Failure::Code(match outcome.ending {
                Ending::FirstPlan | Ending::Exhausted => code::NO_PLAN,
                Ending::ExhaustedTruncated(_) => code::NO_PLAN_TRUNCATED,
                Ending::BudgetSpent | Ending::Interrupted => code::NO_PLAN_BUDGET,
            }))
        }
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
fn how_many(
    n: usize,
    wanted: u32,
    ending: Ending,
    counts: &engine::Statistics,
    options: &SearchOptions,
    timed_out: bool,
) -> String {
    let why = match ending {
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
        "search      {:.3} s, {} expansions, {} backtracks, {} repeated, {} plans\n",
        time.as_secs_f64(),
        engine.expansions,
        engine.backtracks,
        engine.repeated,
        engine.plans,
    );
    if let Some(geometry) = geometry {
        text += &format!(
            "projection  {} actions computed, {} alternatives, {} candidates\n\
             geometry    {} inverse kinematics calls, {} motion plans, {} configurations checked, {} facts\n",
            engine.projections,
            engine.alternatives,
            geometry.candidates,
            geometry.ik_calls,
            geometry.motion_plans,
            geometry.configurations_checked,
            geometry.facts,
        );
    }
    text
}
