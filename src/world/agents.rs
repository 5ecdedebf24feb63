//! `[robots.ID]` and `[humans.ID]`: a model, a base pose, a start configuration; what a human is like is `manner`'s.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use indexmap::IndexMap;

use super::model::{self, Model};
use super::table::{Name, Table};
use super::{Agent, AgentKind, AgentState, BaseKind, InitialValue, Manner, manner, pose, problems};
use crate::diag::{Problem, Problems};
use crate::geom::{Pose, pose_xyz_rpy};
use crate::source::{Files, Sources, Span};

/// The agents of a world file, how they stand, and where their names are.
#[derive(Debug, Default)]
pub struct Agents {
    pub agents: Vec<Agent>,
    pub states: Vec<AgentState>,
    pub spans: Vec<Span>,
    /// Ids of all of the file, also of those that a problem tells of.
    pub written: Vec<String>,
    /// What their tables say in symbols.
    pub values: Vec<InitialValue>,
}

/// The keys of robots and humans alike.
const KEYS: [&str; 5] = ["model", "type", "base", "posture", "joints"];

/// Reads both tables; every model file is read once.
pub fn read(root: &Table<'_>, path: &str, sources: &mut Sources, files: &dyn Files, problems: &mut Problems) -> Agents {
    let mut models: IndexMap<String, Option<Model>> = IndexMap::new();
    let mut all = Agents::default();
    for (key, kind, word) in [
        ("robots", AgentKind::Robot, "robot"),
        ("humans", AgentKind::Human, "human"),
    ] {
        for (name, table) in root.named_tables(key, word, problems) {
            let known = match kind {
                AgentKind::Robot => KEYS.to_vec(),
                AgentKind::Human => [&KEYS[..], &manner::KEYS[..]].concat(),
            };
            table.only(&known, problems);
            all.written.push(name.text.to_string());
            let example = format!("model = \"models/{}.toml\"", if word == "robot" { "pr2" } else { word });
            let model_name = table.needed_text("model", &example, problems);
            let ty = table.text("type", problems).map(|t| t.text.to_string());
            let X_WB = base(&table, problems);
            let Some(model_name) = model_name else { continue };
            let model = load_model(path, model_name, &mut models, sources, files, problems);
            let Some(model) = model else { continue };
            if model.arms.is_empty() {
                problems.push(no_arm(word, name, model_name));
            }
            let (manner, values) = match kind {
                AgentKind::Robot => (Manner::default(), Vec::new()),
                AgentKind::Human => manner::read(name.text, &table, &model.arms, problems),
            };
            all.values.extend(values);
            let q = configuration(&table, &model, manner.is_sitting, problems);
            all.agents.push(Agent {
                id: name.text.to_string(),
                kind,
                ty,
                tree: model.tree,
                bodies: model.bodies,
                may_touch: model.may_touch,
                arms: model.arms,
                camera: model.camera,
                postures: model.postures,
                base: if manner.is_sitting { BaseKind::Fixed } else { model.base },
                base_limits: model.base_limits,
                manner,
            });
            all.states.push(AgentState { X_WB, q });
            all.spans.push(name.span);
        }
    }
    all
}

fn no_arm(word: &str, name: Name<'_>, model: Name<'_>) -> Problem {
    Problem::error(
        "world::no-arm",
        format!("{word} `{}` has no arm", name.text),
        name.span,
        "nothing to pick or reach with",
    )
    .note(model.span, "its model")
    .help(format!(
        "add a table `[arms.right]` with `base_link`, `tip_link` and `tool` to `{}`",
        model.text
    ))
}

fn load_model(
    world_path: &str,
    name: Name<'_>,
    models: &mut IndexMap<String, Option<Model>>,
    sources: &mut Sources,
    files: &dyn Files,
    problems: &mut Problems,
) -> Option<Model> {
    let path = model::beside(world_path, name.text);
    if let Some(known) = models.get(&path) {
        return known.clone();
    }
    let (model, mut found) = model::read(&path, sources, files);
    for problem in &mut found.0 {
        if problem.primary.is_none() {
            // A file that can't be read is best shown where it is named.
            problem.primary = Some(crate::diag::Label {
                span: name.span,
                text: String::new(),
            });
            problem.help = Some("the path is relative to this file's folder".to_string());
        }
    }
    problems.extend(found);
    models.insert(path, model.clone());
    model
}

/// Returns the pose of the base: `x`, `y`, `yaw` on the floor, or `xyz` with `rpy` or `yaw`; the origin when absent.
fn base(table: &Table<'_>, problems: &mut Problems) -> Pose {
    let Some(base) = table.table("base", &format!("`base` of {}", table.place), problems) else {
        return Pose::identity();
    };
    base.only(&["x", "y", "xyz", "rpy", "yaw"], problems);
    let mut planar = [0.0; 2];
    for (slot, key) in planar.iter_mut().zip(["x", "y"]) {
        let Some((value, span)) = base.number(key, problems) else {
            continue;
        };
        if value.abs() > pose::FARTHEST {
            let message = format!("{} is placed {} m away", table.place, value.abs());
            let help = format!("lengths are in metres: {} mm are {}", value.abs(), value.abs() / 1000.0);
            problems.push(problems::bad_size(message, span, help));
        }
        if base.has("xyz") {
            problems.push(problems::bad_value(
                format!("{} has both `xyz` and `{key}`", base.place),
                span,
                "",
                format!("keep `xyz`, or `{key}` on the floor"),
            ));
        }
        *slot = value;
    }
    pose_xyz_rpy([planar[0], planar[1], 0.0], [0.0; 3]) * pose::read(&base, problems)
}

/// Returns the start configuration: the posture named, else `sitting` of who sits, else `rest`, else the value nearest to zero;
/// then single joints.
fn configuration(table: &Table<'_>, model: &Model, is_sitting: bool, problems: &mut Problems) -> Vec<f64> {
    let usual = if is_sitting { "sitting" } else { "rest" };
    if is_sitting
        && !table.has("posture")
        && !model.postures.contains_key(usual)
        && let Some(value) = table.get("sitting")
    {
        let message = format!("{} sits, and its model has no posture `sitting`", table.place);
        let help = "add a table `[postures.sitting]` to the model file, or name a `posture` in which it sits";
        problems.push(Problem::error("world::unknown-posture", message, value.span, "").help(help));
    }
    let rest = model.postures.get(usual);
    let mut q = rest.cloned().unwrap_or_else(|| model::neutral(&model.tree));
    if let Some(name) = table.text("posture", problems) {
        match model.postures.get(name.text) {
            Some(posture) => q.clone_from(posture),
            None => problems.push(problems::unknown_name(
                "world::unknown-posture",
                "posture",
                name.text,
                &table.place,
                model.postures.keys().map(String::as_str),
                name.span,
            )),
        }
    }
    if let Some(joints) = table.table("joints", &format!("`joints` of {}", table.place), problems) {
        model::set_joints(&joints, &model.tree, &mut q, problems);
    }
    q
}
