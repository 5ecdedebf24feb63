//! Where objects stand at the start: at a pose in the world, or on a support of another object.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::Written;
use crate::diag::{Problem, Problems};
use crate::geom::{Pose, pose_xyz_rpy};
use crate::world::table::{Name, Table};
use crate::world::{Object, Stable, Support, pose, problems};

/// An overhang this small is none [m].
const EDGE: f64 = 1e-6;

/// Returns the pose `X_WO` of every object, in their order; `None` for those that a problem tells of.
pub fn place(written: &[Written<'_>], problems: &mut Problems) -> Vec<Option<Pose>> {
    let mut poses: Vec<Option<Pose>> = vec![None; written.len()];
    // Objects whose support is not placed yet: (object, index of the object below, its name in the file).
    let mut waiting: Vec<(usize, usize, Name<'_>)> = Vec::new();
    for (o, object) in written.iter().enumerate() {
        match ground(object, written, problems) {
            Ground::Pose(X_WO) => poses[o] = Some(X_WO),
            Ground::On(below, name) => waiting.push((o, below, name)),
            Ground::Wrong => {}
        }
    }
    for _ in 0..written.len() {
        waiting.retain(|&(o, below, name)| {
            let Some(X_WB) = poses[below] else { return true };
            let X_BO = on(
                &written[o].table,
                &written[o].object,
                &written[below].object,
                name,
                problems,
            );
            poses[o] = X_BO.map(|X_BO| X_WB * X_BO);
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
                    "part of a circle of `on`",
                )
                .help("give one object of the circle a pose with `xyz`"),
            );
        }
    }
    poses
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
    On(usize, Name<'a>),
    Wrong,
}

fn ground<'a>(object: &Written<'a>, written: &[Written<'a>], problems: &mut Problems) -> Ground<'a> {
    let table = &object.table;
    let Some(name) = table.text("on", problems) else {
        for key in ["support", "at", "stands"] {
            if let Some(value) = table.get(key).filter(|_| !table.has("on")) {
                problems.push(problems::bad_value(
                    format!("{} has `{key}` without `on`", table.place),
                    value.span,
                    "",
                    "add `on = \"TABLE\"`, or place it with `xyz`",
                ));
            }
        }
        if !table.has("on") && !table.has("xyz") {
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
    for key in ["xyz", "rpy"] {
        if let Some(value) = table.get(key) {
            problems.push(problems::bad_value(
                format!("{} has both `on` and `{key}`", table.place),
                value.span,
                "",
                "keep `on` with `at`, `yaw` and `stands`, or the pose alone",
            ));
        }
    }
    match written.iter().position(|w| w.name.text == name.text) {
        Some(below) => Ground::On(below, name),
        None => {
            let known = written.iter().map(|w| w.name.text);
            let place = format!("`on` of {}", table.place);
            let code = "world::unknown-object";
            problems.push(problems::unknown_name(
                code, "object", name.text, &place, known, name.span,
            ));
            Ground::Wrong
        }
    }
}

/// Returns the pose of the object in the frame of the one below it.
fn on(table: &Table<'_>, object: &Object, below: &Object, name: Name<'_>, problems: &mut Problems) -> Option<Pose> {
    let support = which_support(table, below, name, problems)?;
    let stable = which_stable(table, object, problems)?;
    let (at, span) = table.vector::<2>("at", problems).unwrap_or(([0.0, 0.0], name.span));
    let yaw = table.number("yaw", problems).map_or(0.0, |(y, _)| y);
    let X_FQ = pose_xyz_rpy([at[0], at[1], 0.0], [0.0, 0.0, yaw]);
    let overhang = stable
        .footprint
        .iter()
        .map(|p| X_FQ * nalgebra::Point3::new(p[0], p[1], 0.0))
        .map(|p| (p.x.abs() - support.half[0]).max(p.y.abs() - support.half[1]))
        .fold(0.0, f64::max);
    if overhang > EDGE {
        let half = support.half;
        problems.push(
            Problem::error(
                "world::off-support",
                format!(
                    "{} hangs {overhang:.3} m over the edge of `{}` of `{}`",
                    table.place, support.name, below.id
                ),
                span,
                "placed here",
            )
            .help(format!(
                "the face reaches from {:.3} to {:.3} along x and from {:.3} to {:.3} along y of `{}`",
                -half[0], half[0], -half[1], half[1], below.id
            )),
        );
        return None;
    }
    Some(support.X_OF * X_FQ * stable.X_QO)
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
