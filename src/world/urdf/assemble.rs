//! Links and joints as written to a tree: parents before children, mimic joints bound to their leaders.

use indexmap::IndexMap;

use super::{RawBody, RawJoint, Robot};
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::{Dof, Drive, Joint, JointKind, Tree};
use crate::source::Span;
use crate::world::{Body, problems};

/// Returns the robot; what is wrong with the graph of links and joints becomes a problem.
pub fn assemble(
    links: &IndexMap<String, Span>,
    joints: Vec<RawJoint>,
    bodies: Vec<RawBody>,
    problems: &mut Problems,
) -> Option<Robot> {
    let order = order(links, &joints, problems)?;
    let mut tree = Tree {
        links: vec![order.root.clone()],
        ..Tree::default()
    };
    let mut index: IndexMap<&str, usize> = IndexMap::new();
    index.insert(&order.root, 0);
    // INVARIANT: `order.joints` lists a joint after the joint that moves its parent.
    for &j in &order.joints {
        index.insert(&joints[j].child, tree.links.len());
        tree.links.push(joints[j].child.clone());
    }
    let drives = drives(&joints, &order.joints, &mut tree.dofs, problems);
    for &j in &order.joints {
        let raw = &joints[j];
        tree.joints.push(Joint {
            name: raw.name.clone(),
            kind: raw.kind,
            parent: index.get(raw.parent.as_str()).copied()?,
            X_PJ: raw.X_PJ,
            axis: raw.axis,
            drive: drives.get(&j).copied(),
        });
    }
    let bodies = bodies
        .into_iter()
        .filter_map(|raw| {
            Some(Body {
                link: index.get(raw.link.as_str()).copied()?,
                shape: raw.shape,
                X_LS: raw.X_LS,
                color: raw.color,
            })
        })
        .collect();
    Some(Robot { tree, bodies })
}

/// The root link, and the joints (by index) from the root on.
struct Order {
    root: String,
    joints: Vec<usize>,
}

fn order(links: &IndexMap<String, Span>, joints: &[RawJoint], problems: &mut Problems) -> Option<Order> {
    let mut moved_by: IndexMap<&str, &RawJoint> = IndexMap::new();
    let mut ok = true;
    for joint in joints {
        if let Some(first) = moved_by.insert(&joint.child, joint) {
            ok = false;
            let message = format!(
                "link `{}` is the child of two joints, `{}` and `{}`",
                joint.child, first.name, joint.name
            );
            problems.push(
                Problem::error("urdf::two-parents", message, joint.child_span, "again here")
                    .note(first.child_span, "first here")
                    .help("a robot is a tree: a link hangs on one joint"),
            );
        }
    }
    let roots: Vec<(&String, &Span)> = links
        .iter()
        .filter(|(name, _)| !moved_by.contains_key(name.as_str()))
        .collect();
    if let [first, second, ..] = roots.as_slice() {
        ok = false;
        let names: Vec<&str> = roots.iter().map(|(n, _)| n.as_str()).collect();
        problems.push(
            Problem::error(
                "urdf::two-roots",
                format!("{} links hang on no joint: `{}`", names.len(), names.join("`, `")),
                *second.1,
                "hangs on nothing",
            )
            .note(*first.1, "this, too")
            .help(format!(
                "one link is the root; fix the others to it, as in `<joint name=\"{}_joint\" type=\"fixed\">`",
                second.0
            )),
        );
    }
    let mut below: IndexMap<&str, Vec<usize>> = IndexMap::new();
    for (j, joint) in joints.iter().enumerate() {
        below.entry(&joint.parent).or_default().push(j);
    }
    // Depth first in the order of the file, so that the joints of an arm are neighbours.
    let mut reached: Vec<usize> = Vec::new();
    let mut visited: IndexMap<&str, ()> = IndexMap::new();
    let mut stack: Vec<&str> = roots.iter().rev().map(|(n, _)| n.as_str()).collect();
    let mut via: IndexMap<&str, usize> = IndexMap::new();
    while let Some(link) = stack.pop() {
        if visited.insert(link, ()).is_some() {
            continue;
        }
        reached.extend(via.get(link));
        for &j in below.get(link).into_iter().flatten().rev() {
            via.insert(&joints[j].child, j);
            stack.push(&joints[j].child);
        }
    }
    let circle = joints.iter().find(|j| !visited.contains_key(j.child.as_str()));
    if let Some(joint) = circle {
        problems.push(
            Problem::error(
                "urdf::cycle",
                format!("link `{}` hangs on itself", joint.child),
                joint.child_span,
                "part of a circle of joints",
            )
            .help("a robot is a tree: cut the circle at one joint"),
        );
        return None;
    }
    let root = roots.first()?.0.clone();
    ok.then_some(Order { root, joints: reached })
}

/// Fills `dofs` with the joints that lead, and returns by joint index where each moving joint's value comes from.
fn drives(
    joints: &[RawJoint],
    order: &[usize],
    dofs: &mut Vec<Dof>,
    problems: &mut Problems,
) -> IndexMap<usize, Drive> {
    let by_name: IndexMap<&str, usize> = joints.iter().enumerate().map(|(j, r)| (r.name.as_str(), j)).collect();
    let mut drives = IndexMap::new();
    for &j in order {
        let raw = &joints[j];
        if raw.kind == JointKind::Fixed || raw.mimic.is_some() {
            continue;
        }
        let dof = dofs.len();
        dofs.push(Dof {
            name: raw.name.clone(),
            lower: raw.lower,
            upper: raw.upper,
            max_velocity: raw.velocity,
            max_acceleration: f64::INFINITY,
        });
        drives.insert(
            j,
            Drive {
                dof,
                scale: 1.0,
                offset: 0.0,
            },
        );
    }
    for &j in order {
        if joints[j].kind != JointKind::Fixed
            && joints[j].mimic.is_some()
            && let Some(drive) = follow(joints, j, &by_name, &drives, problems)
        {
            drives.insert(j, drive);
        }
    }
    drives
}

/// Follows a mimic joint to the joint that leads it, through other mimic joints.
///
/// The follower's own limits are not applied: vendors' files give limits there that its leader breaks.
fn follow(
    joints: &[RawJoint],
    start: usize,
    by_name: &IndexMap<&str, usize>,
    leaders: &IndexMap<usize, Drive>,
    problems: &mut Problems,
) -> Option<Drive> {
    let (mut scale, mut offset, mut at) = (1.0, 0.0, start);
    for _ in 0..joints.len() {
        let Some(mimic) = &joints[at].mimic else { break };
        let Some(&leader) = by_name.get(mimic.leader.as_str()) else {
            let place = format!("`<mimic>` of joint `{}`", joints[at].name);
            let known = by_name.keys().copied();
            problems.push(problems::unknown_name(
                "urdf::unknown-joint",
                "joint",
                &mimic.leader,
                &place,
                known,
                mimic.span,
            ));
            return None;
        };
        offset += scale * mimic.offset;
        scale *= mimic.scale;
        at = leader;
    }
    match leaders.get(&at) {
        Some(drive) if joints[at].mimic.is_none() => Some(Drive {
            dof: drive.dof,
            scale,
            offset,
        }),
        _ => {
            let message = format!("joint `{}` mimics nothing that moves on its own", joints[start].name);
            problems.push(
                Problem::error("urdf::mimic-without-leader", message, joints[start].span, "")
                    .help("a leader is a revolute, continuous or prismatic joint without `<mimic>`"),
            );
            None
        }
    }
}
