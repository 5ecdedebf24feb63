//! `sgap facts WORLD [QUESTION ..]`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::output::{Failure, print, say};
use super::{code, fail, load_world, problems::ProblemOptions, read_plan};
use sgap::diag::{Problem, suggest};
use sgap::grp::{FACTS, Grp, REQUESTS, Settings};
use sgap::ir::Value;
use sgap::world::{EntityRef, World};

/// Which world, when, and which facts.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// World file (.toml)
    world: PathBuf,
    /// Ask these alone and say why they hold or don't: 'isReachable(CUP, PR2)', 'distance(CUP, TABLE)'
    #[arg(value_name = "QUESTION")]
    questions: Vec<String>,
    /// Ask after this plan, as `sgap plan --json` writes it, instead of at the start
    #[arg(long, value_name = "PLAN")]
    after: Option<PathBuf>,
    /// Ask after the first N actions of the plan
    #[arg(long, value_name = "N", requires = "after")]
    actions: Option<usize>,
    /// Print only the facts that the plan has changed
    #[arg(long, requires = "after", conflicts_with_all = ["all", "questions"])]
    changed: bool,
    /// Seed of the inverse kinematics' restarts
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Print the facts that do not hold, too
    #[arg(long, conflicts_with = "questions")]
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
    let before = if options.changed { grp.all_facts() } else { Vec::new() };
    if let Some(path) = &options.after {
        follow(&mut grp, path, options.actions)?;
    }
    if !options.questions.is_empty() {
        return answer(options, &world, &grp);
    }
    let facts: Vec<_> = grp
        .all_facts()
        .into_iter()
        .enumerate()
        .filter(|(i, now)| match before.get(*i) {
            Some(before) => before.3 != now.3,
            None => now.3 || options.all,
        })
        .map(|(_, fact)| fact)
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

/// Goes on to the world after the first actions of a plan, or all.
fn follow(grp: &mut Grp<'_>, path: &Path, actions: Option<usize>) -> Result<(), Failure> {
    let plan = read_plan(path)?;
    let (has, path) = (plan.actions.len(), path.display());
    let n = actions.unwrap_or(has);
    if n > has {
        let message = format!("`--actions {n}`: the plan `{path}` has {has}");
        let problem = Problem::unplaced("plan::too-short", message);
        return Err(fail(problem.help(format!("`--actions` goes from 0 to {has}"))));
    }
    for action in &plan.actions[..n] {
        let Some(geometry) = &action.geometry else { continue };
        grp.follow(geometry).map_err(|why| {
            let (index, name) = (action.index, &action.name);
            say(&format!(
                "the plan `{path}` is none of this world: action {index}, {name}: {why}\n"
            ));
            Failure::Code(code::PLAN_INVALID)
        })?;
    }
    Ok(())
}

/// Answers single questions, each with the reason.
fn answer(options: &Options, world: &World, grp: &Grp<'_>) -> Result<(), Failure> {
    let mut rows = Vec::new();
    let mut text = String::new();
    for question in &options.questions {
        let wrong = |why: String| {
            say(&format!("error: `{question}`: {why}\n"));
            Failure::Code(code::WRONG_USAGE)
        };
        let (name, entities) = read(question, world).map_err(wrong)?;
        let ids: Vec<&str> = entities.iter().map(|e| world.scene.id(*e)).collect();
        let Some((value, why)) = grp.explain(name, &entities) else {
            return Err(wrong("this makes no sense for these entities".into()));
        };
        let shown = format!("{name}({})", ids.join(", "));
        let because = if why.is_empty() {
            String::new()
        } else {
            format!(": {why}")
        };
        let json = match value {
            Value::Bool(holds) => {
                let not = if holds { "" } else { "not " };
                text += &format!("{not}{shown}{because}\n");
                serde_json::json!({"fact": name, "arguments": ids, "holds": holds, "why": why})
            }
            Value::Number(number) => {
                text += &format!("{shown} = {number:.4}{because}\n");
                serde_json::json!({"fact": name, "arguments": ids, "value": number, "why": why})
            }
            Value::Null | Value::String(_) | Value::Entity(_) | Value::Set(_) | Value::Scalars(_) | Value::Unknown => {
                continue;
            }
        };
        rows.push(json);
    }
    if options.json {
        return print(&format!("{:#}\n", serde_json::Value::Array(rows)));
    }
    print(&text)
}

/// Reads `isReachable(CUP, PR2)`.
fn read<'q>(question: &'q str, world: &World) -> Result<(&'q str, Vec<EntityRef>), String> {
    let form = || "write it like `isReachable(CUP, PR2)`".to_owned();
    let (name, rest) = question.trim().split_once('(').ok_or_else(form)?;
    let arguments = rest.trim_end().strip_suffix(')').ok_or_else(form)?;
    let name = name.trim();
    let known = || FACTS.iter().chain(&REQUESTS).copied();
    let mean = |nearest: Option<&str>| nearest.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
    if !known().any(|k| k == name) {
        return Err(format!(
            "there is no fact or request `{name}`{}",
            mean(suggest::nearest(name, known()))
        ));
    }
    let scene = &world.scene;
    let ids = || {
        let things = scene.objects.iter().map(|o| o.id.as_str());
        let agents = scene.agents.iter().map(|a| a.id.as_str());
        agents.chain(things).chain(scene.virtuals.iter().map(|v| v.id.as_str()))
    };
    let mut entities = Vec::new();
    for id in arguments.split(',').map(str::trim) {
        let entity = scene.find(id);
        entities.push(
            entity.ok_or_else(|| format!("there is no `{id}` in the world{}", mean(suggest::nearest(id, ids()))))?,
        );
    }
    Ok((name, entities))
}
