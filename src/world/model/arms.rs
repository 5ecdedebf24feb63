//! `[arms.NAME]` of a model file: a chain of joints, the tool frame, the hand.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::{degrees_help, find_dof, find_link};
use crate::diag::{Problem, Problems};
use crate::geom::Pose;
use crate::geom::kinematics::{JointKind, Tree};
use crate::world::srdf::{EndEffector, Srdf};
use crate::world::table::Table;
use crate::world::{Arm, Gripper, pose, problems};

/// No hand opens wider [m].
const WIDEST: f64 = 1.0;

/// Reads `[arms.NAME]`, two at most.
pub(super) fn read(root: &Table<'_>, tree: &Tree, srdf: &Srdf, problems: &mut Problems) -> Vec<Arm> {
    let tables = root.named_tables("arms", "arm", problems);
    let mut arms = Vec::new();
    let n = tables.len();
    for (name, table) in &tables {
        arms.extend(arm(name.text, table, tree, srdf, problems));
    }
    if n > 2
        && let Some((name, _)) = tables.get(2)
    {
        problems.push(problems::bad_value(
            format!("{n} arms, where at most two are supported"),
            name.span,
            "the third arm",
            "keep two arms",
        ));
    }
    arms
}

/// Returns the two links between which the arm is: those that the table names, or the ends of its group; it ends where its hand is fixed.
fn ends(
    table: &Table<'_>,
    tree: &Tree,
    srdf: &Srdf,
    hand: Option<&EndEffector>,
    problems: &mut Problems,
) -> (Option<usize>, Option<usize>) {
    let group = table.text("group", problems);
    let ends = group.and_then(|group| {
        let found = srdf.chains.get(group.text).copied();
        if found.is_none() {
            let known = srdf.chains.keys().map(String::as_str);
            let problem = if srdf.groups.iter().any(|g| g == group.text) {
                let message = format!("group `{}` of {} is no chain of joints", group.text, table.place);
                Problem::error("world::unknown-group", message, group.span, "")
                    .help("give `base_link` and `tip_link` instead")
            } else {
                problems::unknown_name(
                    "world::unknown-group",
                    "group",
                    group.text,
                    &table.place,
                    known,
                    group.span,
                )
            };
            problems.push(problem);
        }
        found
    });
    let mut link = |key: &str, example: &str, other: Option<usize>| {
        let name = if group.is_some() || (key == "tip_link" && table.has("end_effector")) {
            table.text(key, problems)
        } else {
            table.needed_text(key, example, problems)
        };
        match name {
            Some(name) => find_link(tree, name, &table.place, problems),
            None => other,
        }
    };
    let base = link("base_link", "base_link = \"torso\"", ends.map(|e| e.0));
    let tip = link(
        "tip_link",
        "tip_link = \"hand\"",
        hand.map(|h| h.parent_link).or(ends.map(|e| e.1)),
    );
    (base, tip)
}

/// Returns the hand that the table names.
fn end_effector<'s>(table: &Table<'_>, srdf: &'s Srdf, problems: &mut Problems) -> Option<&'s EndEffector> {
    let name = table.text("end_effector", problems)?;
    let found = srdf.end_effectors.get(name.text);
    if found.is_none() {
        let mut problem = problems::unknown_name(
            "world::unknown-end-effector",
            "end effector",
            name.text,
            &table.place,
            srdf.end_effectors.keys().map(String::as_str),
            name.span,
        );
        if srdf.end_effectors.is_empty() {
            problem = problem.help("the robot's SRDF has none: give `tip_link` and `hand_links` instead");
        }
        problems.push(problem);
    }
    found
}

fn arm(name: &str, table: &Table<'_>, tree: &Tree, srdf: &Srdf, problems: &mut Problems) -> Option<Arm> {
    table.only(
        &[
            "group",
            "base_link",
            "tip_link",
            "end_effector",
            "tool",
            "gripper",
            "hand_links",
        ],
        problems,
    );
    let hand = end_effector(table, srdf, problems);
    let (base_link, tip_link) = ends(table, tree, srdf, hand, problems);
    let tool = table.table("tool", &format!("`tool` of {}", table.place), problems);
    let X_LT = tool.map_or_else(Pose::identity, |t| {
        t.only(&pose::KEYS, problems);
        pose::read_in_frame(&t, problems)
    });
    let gripper = table
        .table("gripper", &format!("`gripper` of {}", table.place), problems)
        .and_then(|t| gripper(&t, tree, problems));
    let listed = table.array("hand_links", problems);
    let (base_link, tip_link) = (base_link?, tip_link?);
    let hand_links = match listed {
        Some(names) => names
            .iter()
            .filter_map(|v| {
                let name = v.text("an entry of `hand_links`", problems)?;
                find_link(tree, name, &table.place, problems)
            })
            .collect(),
        None => match hand {
            Some(hand) if !hand.links.is_empty() => hand.links.clone(),
            Some(_) | None => descendants(tree, tip_link),
        },
    };
    let Some(dofs) = chain(tree, base_link, tip_link) else {
        problems.push(
            Problem::error(
                "world::no-chain",
                format!(
                    "{} can't reach from `{}` to `{}`",
                    table.place, tree.links[base_link], tree.links[tip_link]
                ),
                table
                    .get("tip_link")
                    .or(table.get("group"))
                    .map_or(table.span, |t| t.span),
                "does not hang on the base link",
            )
            .help("`tip_link` must be a descendant of `base_link`, with a movable joint between them"),
        );
        return None;
    };
    Some(Arm {
        name: name.to_string(),
        base_link,
        tip_link,
        X_LT,
        dofs,
        gripper,
        hand_links,
    })
}

/// Returns the degrees of freedom from the base link to the tip link; `None` without a way or without any.
fn chain(tree: &Tree, base: usize, tip: usize) -> Option<Vec<usize>> {
    let mut dofs = Vec::new();
    let mut link = tip;
    while link != base {
        let joint = tree.joints.get(link.checked_sub(1)?)?;
        if joint.kind != JointKind::Fixed {
            dofs.extend(joint.drive.map(|d| d.dof));
        }
        link = joint.parent;
    }
    dofs.reverse();
    (!dofs.is_empty()).then_some(dofs)
}

/// Returns the link and all that hangs on it.
fn descendants(tree: &Tree, link: usize) -> Vec<usize> {
    let mut found = vec![link];
    for (j, joint) in tree.joints.iter().enumerate() {
        if found.contains(&joint.parent) {
            found.push(j + 1);
        }
    }
    found
}

fn gripper(table: &Table<'_>, tree: &Tree, problems: &mut Problems) -> Option<Gripper> {
    table.only(&["joints", "gap_open", "gap_closed"], problems);
    if !table.has("joints") {
        problems.push(problems::missing_key(
            "joints",
            &table.place,
            "joints = { finger_joint = { open = 0.04, closed = 0.0 } }",
            table.span,
        ));
    }
    let joints = table.table("joints", &format!("`joints` of {}", table.place), problems);
    let gap_open = table.needed_number("gap_open", "gap_open = 0.08", problems);
    let gap_closed = table.number("gap_closed", problems).map_or(0.0, |(g, _)| g);
    let joints = joints?;
    let (mut dofs, mut open, mut closed) = (Vec::new(), Vec::new(), Vec::new());
    for (name, value) in joints.entries() {
        let place = format!("`{}` of {}", name.text, joints.place);
        let dof = find_dof(tree, name, &joints.place, problems);
        let Some(ends) = value.table(name.span, &place, problems) else {
            continue;
        };
        ends.only(&["open", "closed"], problems);
        let o = ends.needed_number("open", "open = 0.04", problems);
        let c = ends.needed_number("closed", "closed = 0.0", problems);
        if let (Some(dof), Some((o, o_span)), Some((c, c_span))) = (dof, o, c) {
            for (value, span) in [(o, o_span), (c, c_span)] {
                let limits = &tree.dofs[dof];
                if value < limits.lower || value > limits.upper {
                    problems.push(
                        Problem::error(
                            "world::joint-limit",
                            format!(
                                "{place} is {value}, outside its limits {} to {}",
                                limits.lower, limits.upper
                            ),
                            span,
                            "beyond a joint limit",
                        )
                        .help(degrees_help(value, limits.lower, limits.upper)),
                    );
                }
            }
            dofs.push(dof);
            open.push(o);
            closed.push(c);
        }
    }
    let (gap_open, span) = gap_open?;
    if gap_open > WIDEST {
        let message = format!("{} opens to {gap_open} m", table.place);
        let help = format!("lengths are in metres: {gap_open} mm are {}", gap_open / 1000.0);
        problems.push(problems::bad_size(message, span, help));
        return None;
    }
    if gap_open <= gap_closed || gap_closed < 0.0 {
        problems.push(problems::bad_value(
            format!("{} opens to {gap_open} m and closes to {gap_closed} m", table.place),
            span,
            "",
            "`gap_open` is the larger one; neither is negative",
        ));
        return None;
    }
    // `joints = {}`: the fingers move in the world, though not in the URDF.
    (!dofs.is_empty() || joints.entries().next().is_none()).then_some(Gripper {
        dofs,
        open,
        closed,
        gap_open,
        gap_closed,
    })
}
