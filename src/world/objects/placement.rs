//! Where objects are at the start: at a pose in the world, on a support or in a container of another object, or in a hand ([`hand`]).
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

mod hand;

use super::Written;
use crate::diag::{Problem, Problems};
use crate::geom::{Pose, pose_xyz_rpy};
use crate::world::agents::Agents;
use crate::world::table::{Name, Table};
use crate::world::{Held, Object, ObjectState, Stable, Support, pose, problems};
use hand::in_hand_of;

/// An overhang this small is none [m].
const EDGE: f64 = 1e-6;

/// Returns how every object stands, in their order; `None` for those that a problem tells of. Closes the hands that hold one.
///
/// `ids` are those of all objects of the file: of one that is not among `written`, a problem tells already.
pub fn place(
    written: &[Written<'_>],
    ids: &[&str],
    agents: &mut Agents,
    problems: &mut Problems,
) -> Vec<Option<ObjectState>> {
    let mut states: Vec<Option<ObjectState>> = vec![None; written.len()];
    // Objects whose ground is not placed yet: (object, index of the object below or around, its name in the file).
    let mut waiting: Vec<(usize, usize, Name<'_>)> = Vec::new();
    for (o, object) in written.iter().enumerate() {
        match ground(object, written, ids, problems) {
            Ground::Pose(X_WO) => states[o] = Some(ObjectState { X_WO, held: None }),
            Ground::On(below, name) => waiting.push((o, below, name)),
            Ground::InHandOf(name) => {
                let taken: Vec<Held> = states.iter().flatten().filter_map(|s| s.held.clone()).collect();
                states[o] = in_hand_of(object, name, &taken, agents, problems);
            }
            Ground::Wrong => {}
        }
    }
    for _ in 0..written.len() {
        waiting.retain(|&(o, below, name)| {
            let Some(X_WB) = states[below].as_ref().map(|s| s.X_WO) else {
                return true;
            };
            let (table, object) = (&written[o].table, &written[o].object);
            let X_BO = if table.has("in") {
                inside(table, object, &written[below].object, name, problems)
            } else {
                on(table, object, &written[below].object, name, problems)
            };
            states[o] = X_BO.map(|X_BO| ObjectState {
                X_WO: X_WB * X_BO,
                held: None,
            });
            false
        });
    }
    for &(o, _, name) in &waiting {
        if stands_on_itself(o, &waiting) {
            problems.push(
                Problem::error(
                    "world::on-cycle",
                    format!("object `{}` stands on itself", written[o].name.text),
                    name.span,
                    "part of a circle of `on` and `in`",
                )
                .help("give one object of the circle a pose with `xyz`"),
            );
        }
    }
    states
}

fn stands_on_itself(start: usize, waiting: &[(usize, usize, Name<'_>)]) -> bool {
    let mut at = start;
    for _ in 0..waiting.len() {
        match waiting.iter().find(|(o, _, _)| *o == at) {
            Some((_, below, _)) => at = *below,
            None => return false,
        }
        if at == start {
            return true;
        }
    }
    false
}

enum Ground<'a> {
    Pose(Pose),
    /// On or in the object of that index.
    On(usize, Name<'a>),
    /// The name of an agent.
    InHandOf(Name<'a>),
    Wrong,
}

/// The keys that say on, in or with what an object is, and those that only go with each of them.
const GROUNDS: [(&str, &[&str]); 3] = [
    ("on", &["support", "at", "stands"]),
    ("in", &["container", "at", "stands"]),
    ("in_hand_of", &["arm", "grasp"]),
];

fn ground<'a>(object: &Written<'a>, written: &[Written<'a>], ids: &[&str], problems: &mut Problems) -> Ground<'a> {
    let table = &object.table;
    let given: Vec<&str> = GROUNDS
        .iter()
        .map(|(key, _)| *key)
        .filter(|key| table.has(key))
        .collect();
    details_fit(table, &given, problems);
    if given.len() > 1
        && let Some(second) = table.get(given[1])
    {
        let message = format!("{} has both `{}` and `{}`", table.place, given[0], given[1]);
        problems.push(problems::bad_value(message, second.span, "", "keep one of them"));
        return Ground::Wrong;
    }
    let Some(&key) = given.first() else {
        if !table.has("xyz") {
            problems.push(
                Problem::error(
                    "world::no-place",
                    format!("{} is nowhere", table.place),
                    table.span,
                    "no place here",
                )
                .help("add `xyz = [x, y, z]`, or `on = \"TABLE\"` with `at = [x, y]`"),
            );
            return Ground::Wrong;
        }
        return Ground::Pose(pose::read(table, problems));
    };
    let Some(name) = table.text(key, problems) else {
        return Ground::Wrong;
    };
    if key == "in_hand_of" {
        return Ground::InHandOf(name);
    }
    match written.iter().position(|w| w.name.text == name.text) {
        Some(below) => Ground::On(below, name),
        None if ids.contains(&name.text) => Ground::Wrong,
        None => {
            let known = ids.iter().copied();
            let place = format!("`{key}` of {}", table.place);
            let code = "world::unknown-object";
            problems.push(problems::unknown_name(
                code, "object", name.text, &place, known, name.span,
            ));
            Ground::Wrong
        }
    }
}

/// Complains about keys that say more of a ground than the one that is given, and about a pose beside a ground.
fn details_fit(table: &Table<'_>, given: &[&str], problems: &mut Problems) {
    let fits = |key: &str| GROUNDS.iter().any(|(g, with)| given.contains(g) && with.contains(&key));
    for key in ["support", "container", "at", "stands", "arm", "grasp"] {
        let Some(value) = table.get(key).filter(|_| !fits(key)) else {
            continue;
        };
        let wants: Vec<&str> = GROUNDS
            .iter()
            .filter(|(_, with)| with.contains(&key))
            .map(|(g, _)| *g)
            .collect();
        let wants = wants.join("` or `");
        let message = format!("{} has `{key}` without `{wants}`", table.place);
        let help = match key {
            "arm" | "grasp" => "add `in_hand_of = \"PR2\"`, or remove it",
            "container" => "add `in = \"BOX\"`, or place it with `xyz`",
            _ => "add `on = \"TABLE\"`, or place it with `xyz`",
        };
        problems.push(problems::bad_value(message, value.span, "", help));
    }
    let Some(ground) = given.first() else { return };
    let poses: &[&str] = if *ground == "in_hand_of" {
        &pose::KEYS
    } else {
        &["xyz", "rpy"]
    };
    for key in poses {
        if let Some(value) = table.get(key) {
            let help = match *ground {
                "in_hand_of" => {
                    "the hand says where it is: keep `in_hand_of` with `arm` and `grasp`, or the pose alone"
                }
                _ => "keep the one with `at`, `yaw` and `stands`, or the pose alone",
            };
            let message = format!("{} has both `{ground}` and `{key}`", table.place);
            problems.push(problems::bad_value(message, value.span, "", help));
        }
    }
}

/// Returns the pose of the object in the frame of the one below it.
fn on(table: &Table<'_>, object: &Object, below: &Object, name: Name<'_>, problems: &mut Problems) -> Option<Pose> {
    let support = which_support(table, below, name, problems)?;
    let stable = which_stable(table, object, problems)?;
    let face = Face {
        half: support.half,
        name: &support.name,
    };
    let X_FQ = at(table, stable, &face, below, name, problems)?;
    Some(support.X_OF * X_FQ * stable.X_QO)
}

/// Returns the pose of the object in the frame of the one that it is in, standing on the bottom of a container.
fn inside(
    table: &Table<'_>,
    object: &Object,
    around: &Object,
    name: Name<'_>,
    problems: &mut Problems,
) -> Option<Pose> {
    let Some(first) = around.containers.first() else {
        let message = format!("`{}` has no hollow in which something could be", around.id);
        let help = format!(
            "add `containers = [{{ name = \"inside\", xyz = [..], size = [..] }}]` to `{}`, or use `on` or `xyz`",
            around.id
        );
        problems.push(Problem::error("world::no-container", message, name.span, "").help(help));
        return None;
    };
    let container = match table.text("container", problems) {
        None => first,
        Some(wanted) => match around.containers.iter().find(|c| c.name == wanted.text) {
            Some(found) => found,
            None => {
                let known = around.containers.iter().map(|c| c.name.as_str());
                let (place, code) = (format!("`{}`", around.id), "world::unknown-container");
                problems.push(problems::unknown_name(
                    code,
                    "container",
                    wanted.text,
                    &place,
                    known,
                    wanted.span,
                ));
                return None;
            }
        },
    };
    let stable = which_stable(table, object, problems)?;
    let [x, y, z] = container.half;
    let face = Face {
        half: [x, y],
        name: &container.name,
    };
    let X_FQ = at(table, stable, &face, around, name, problems)?;
    let X_CF = Pose::translation(0.0, 0.0, -z);
    Some(container.X_OC * X_CF * X_FQ * stable.X_QO)
}

/// A rectangle to stand on, about its middle.
struct Face<'a> {
    half: [f64; 2],
    name: &'a str,
}

/// Returns the placement that `at` and `yaw` say, if the object stands on the face with all of its bottom.
fn at(
    table: &Table<'_>,
    stable: &Stable,
    face: &Face<'_>,
    below: &Object,
    name: Name<'_>,
    problems: &mut Problems,
) -> Option<Pose> {
    let (at, span) = table.vector::<2>("at", problems).unwrap_or(([0.0, 0.0], name.span));
    let yaw = pose::yaw(table, problems);
    let X_FQ = pose_xyz_rpy([at[0], at[1], 0.0], [0.0, 0.0, yaw]);
    let overhang = stable
        .footprint
        .iter()
        .map(|p| X_FQ * nalgebra::Point3::new(p[0], p[1], 0.0))
        .map(|p| (p.x.abs() - face.half[0]).max(p.y.abs() - face.half[1]))
        .fold(0.0, f64::max);
    if overhang > EDGE {
        let half = face.half;
        let side = |axis: usize| {
            let along = stable.footprint.iter().map(|p| p[axis]);
            along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
        };
        let fits = side(0).max(side(1)) <= 10.0 * half[0].max(half[1]);
        problems.push(
            Problem::error(
                "world::off-support",
                format!(
                    "{} hangs {overhang:.3} m over the edge of `{}` of `{}`",
                    table.place, face.name, below.id
                ),
                span,
                "placed here",
            )
            .help(format!(
                "the face reaches from {:.3} to {:.3} along x and from {:.3} to {:.3} along y of `{}`{}",
                -half[0],
                half[0],
                -half[1],
                half[1],
                below.id,
                if fits {
                    ""
                } else {
                    "; the object is larger: lengths are in metres"
                }
            )),
        );
        return None;
    }
    Some(X_FQ)
}

fn which_support<'o>(
    table: &Table<'_>,
    below: &'o Object,
    name: Name<'_>,
    problems: &mut Problems,
) -> Option<&'o Support> {
    let Some(first) = below.supports.first() else {
        problems.push(
            Problem::error(
                "world::no-support",
                format!("`{}` has no level face to stand on", below.id),
                name.span,
                "",
            )
            .help(format!(
                "add `supports = [{{ name = \"top\", xyz = [..], size = [..] }}]` to `{}`, or use `xyz`",
                below.id
            )),
        );
        return None;
    };
    let Some(wanted) = table.text("support", problems) else {
        return Some(first);
    };
    let found = below.supports.iter().find(|s| s.name == wanted.text);
    if found.is_none() {
        let known = below.supports.iter().map(|s| s.name.as_str());
        let (place, code) = (format!("`{}`", below.id), "world::unknown-support");
        problems.push(problems::unknown_name(
            code,
            "support",
            wanted.text,
            &place,
            known,
            wanted.span,
        ));
    }
    found
}

fn which_stable<'o>(table: &Table<'_>, object: &'o Object, problems: &mut Problems) -> Option<&'o Stable> {
    let Some(first) = object.stable.first() else {
        problems.push(
            Problem::error(
                "world::not-stable",
                format!("{} has no orientation in which it stands", table.place),
                table.span,
                "would tip or roll",
            )
            .help("place it with `xyz`, or give it `stable = [{ name = \"..\", rpy = [..] }]`"),
        );
        return None;
    };
    let Some(wanted) = table.text("stands", problems) else {
        return Some(first);
    };
    let found = object.stable.iter().find(|s| s.name == wanted.text);
    if found.is_none() {
        let known = object.stable.iter().map(|s| s.name.as_str());
        let code = "world::unknown-orientation";
        problems.push(problems::unknown_name(
            code,
            "orientation",
            wanted.text,
            &table.place,
            known,
            wanted.span,
        ));
    }
    found
}
