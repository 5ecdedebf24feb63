//! `[robots.ID]` and `[humans.ID]`: a model, a base pose, a start configuration.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use indexmap::IndexMap;

use super::model::{self, Model};
use super::table::{Name, Table};
use super::{Agent, AgentKind, AgentState, pose, problems};
use crate::diag::{Problem, Problems};
use crate::geom::{Pose, pose_xyz_rpy};
use crate::source::{Files, Sources, Span};

/// The agents of a world file, how they stand, and where their names are.
#[derive(Debug, Default)]
pub struct Agents {
    pub agents: Vec<Agent>,
    pub states: Vec<AgentState>,
    pub spans: Vec<Span>,
}

/// Reads both tables; every model file is read once.
pub fn read(root: &Table<'_>, path: &str, sources: &mut Sources, files: &dyn Files, problems: &mut Problems) -> Agents {
    let mut models: IndexMap<String, Option<Model>> = IndexMap::new();
    let mut all = Agents::default();
    for (key, kind, word) in [
        ("robots", AgentKind::Robot, "robot"),
        ("humans", AgentKind::Human, "human"),
    ] {
        for (name, table) in root.named_tables(key, word, problems) {
            let keys = ["model", "type", "base", "posture", "joints", "sitting"];
            let n = if kind == AgentKind::Human {
                keys.len()
            } else {
                keys.len() - 1
            };
            table.only(&keys[..n], problems);
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
            let q = configuration(&table, &model, problems);
            let is_sitting = kind == AgentKind::Human && is_sitting(&table, problems);
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
                base: model.base,
                base_limits: model.base_limits,
                is_sitting,
            });
            all.states.push(AgentState { X_WB, q });
            all.spans.push(name.span);
        }
    }
    all
}

/// Returns what `sitting` says; else whether the posture does.
fn is_sitting(table: &Table<'_>, problems: &mut Problems) -> bool {
    let posture = table.get("posture");
    let by_posture = posture.is_some_and(|p| {
        p.text("posture", &mut Problems::default())
            .is_some_and(|n| n.text == "sitting")
    });
    table.truth("sitting", problems).unwrap_or(by_posture)
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
            problems.push(problems::bad_size(message, span, "lengths are in metres"));
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

/// Returns the start configuration: the posture named, else `rest`, else the value nearest to zero; then single joints.
fn configuration(table: &Table<'_>, model: &Model, problems: &mut Problems) -> Vec<f64> {
    let rest = model.postures.get("rest");
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
