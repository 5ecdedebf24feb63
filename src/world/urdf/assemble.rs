//! A URDF as `urdf-rs` read it to a tree with shapes: parents before children, mimic joints bound to their leaders.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use indexmap::IndexMap;
use nalgebra::Translation3;
use urdf_rs::{Geometry, JointType, Link};

use super::look::{self, JointPlace, Places};
use super::{Robot, Solids};
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::{Dof, Drive, Joint, JointKind, Tree};
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3, pose_xyz_rpy};
use crate::source::Span;
use crate::world::mesh::Wanted;
use crate::world::{Body, pose, problems};

/// A joint as read, and where it stands.
struct Read<'a> {
    joint: &'a urdf_rs::Joint,
    place: &'a JointPlace,
    kind: JointKind,
}

impl Read<'_> {
    fn parent(&self) -> &str {
        &self.joint.parent.link
    }

    fn child(&self) -> &str {
        &self.joint.child.link
    }
}

/// Returns the robot; what is wrong with the graph of links and joints becomes a problem.
pub fn assemble(
    read: &urdf_rs::Robot,
    places: &Places,
    solids: &mut Solids<'_, '_>,
    problems: &mut Problems,
) -> Option<Robot> {
    let Some(joints) = joints(read, places) else {
        let message = "two readers of XML find different names in this file";
        problems.push(
            Problem::error("urdf::unreadable", message, places.robot, "")
                .help("names without tabs, line breaks and character references are read alike"),
        );
        return None;
    };
    let order = order(&places.links, &joints, problems)?;
    let mut tree = Tree {
        links: vec![order.root.clone()],
        ..Tree::default()
    };
    let mut index: IndexMap<&str, usize> = IndexMap::new();
    index.insert(&order.root, 0);
    // INVARIANT: `order.joints` lists a joint after the joint that moves its parent.
    for &j in &order.joints {
        index.insert(joints[j].child(), tree.links.len());
        tree.links.push(joints[j].child().to_string());
    }
    let drives = drives(&joints, &order.joints, &mut tree.dofs, problems);
    for &j in &order.joints {
        let Read { joint, kind, .. } = &joints[j];
        let axis = match kind {
            JointKind::Fixed => Vec3::x(),
            // The look has refused an axis without length.
            JointKind::Revolute | JointKind::Prismatic => unit(joint.axis.xyz.0).unwrap_or(Vec3::x()),
        };
        tree.joints.push(Joint {
            name: joint.name.clone(),
            kind: *kind,
            parent: index.get(joint.parent.link.as_str()).copied()?,
            X_PJ: pose_of(&joint.origin),
            axis,
            drive: drives.get(&j).copied(),
        });
    }
    let mut bodies = Vec::new();
    // INVARIANT: the look lists the meshes of the same links in the same order.
    let mut meshes = places.meshes.iter();
    for link in &read.links {
        let &index = index.get(link.name.as_str())?;
        let color = color(link, &read.materials);
        for (geometry, origin) in counting(link) {
            let X_LM = pose_of(origin);
            let shapes = match primitive(geometry) {
                Some(shape) => vec![(shape, Vec3::zeros())],
                None => mesh(link, geometry, *meshes.next()?, solids, problems),
            };
            bodies.extend(shapes.into_iter().map(|(shape, p_MS)| Body {
                link: index,
                shape,
                X_LS: X_LM * Translation3::from(p_MS),
                color,
            }));
        }
    }
    Some(Robot { tree, bodies })
}

/// Joins each joint to its place; `None` if the two readings of the text differ in a name or a number of elements.
fn joints<'a>(read: &'a urdf_rs::Robot, places: &'a Places) -> Option<Vec<Read<'a>>> {
    let links = read.links.iter().map(|l| &l.name);
    if !links.eq(places.links.keys()) || read.joints.len() != places.joints.len() {
        return None;
    }
    let pairs = read.joints.iter().zip(&places.joints);
    pairs
        .map(|(joint, place)| {
            let alike =
                joint.name == place.name && joint.parent.link == place.parent && joint.child.link == place.child;
            let kind = match joint.joint_type {
                JointType::Fixed => JointKind::Fixed,
                JointType::Revolute | JointType::Continuous => JointKind::Revolute,
                JointType::Prismatic => JointKind::Prismatic,
                JointType::Floating | JointType::Planar => JointKind::Fixed,
                // The look has refused it.
                JointType::Spherical => return None,
            };
            alike.then_some(Read { joint, place, kind })
        })
        .collect()
}

/// Returns the unit vector along `xyz`, if that has a length.
pub fn unit(xyz: [f64; 3]) -> Option<Vec3> {
    Vec3::from(xyz).try_normalize(1e-9)
}

fn pose_of(origin: &urdf_rs::Pose) -> Pose {
    pose_xyz_rpy(origin.xyz.0, origin.rpy.0)
}

/// Returns the shapes that count: the collision shapes, or the visual ones of a link without any.
fn counting(link: &Link) -> Vec<(&Geometry, &urdf_rs::Pose)> {
    if link.collision.is_empty() {
        link.visual.iter().map(|v| (&v.geometry, &v.origin)).collect()
    } else {
        link.collision.iter().map(|c| (&c.geometry, &c.origin)).collect()
    }
}

/// Returns the hulls of a mesh, each with its origin in the mesh's frame.
///
/// A mesh that is there to be seen only, of a link without collision shapes, is a warning when it can't be read.
fn mesh(
    link: &Link,
    geometry: &Geometry,
    span: Span,
    solids: &mut Solids<'_, '_>,
    problems: &mut Problems,
) -> Vec<(Shape, Vec3)> {
    let Geometry::Mesh { filename, scale } = geometry else {
        return Vec::new();
    };
    let wanted = Wanted {
        name: filename,
        scale: scale.map_or([1.0; 3], |s| s.0),
        in_parts: (solids.in_parts)(&link.name),
    };
    let no_mesh = match solids.meshes.shapes(solids.path, &wanted) {
        Ok(shapes) => return shapes,
        Err(no_mesh) => no_mesh,
    };
    let problem = problems::no_mesh(&wanted, &no_mesh, span);
    problems.push(if link.collision.is_empty() {
        let message = format!("link `{}` has no shape: {}", link.name, problem.message);
        Problem::warning("urdf::no-shape", message, span, "").maybe_help(problem.help)
    } else {
        problem
    });
    Vec::new()
}

/// Returns the shape; `None` for a mesh.
fn primitive(geometry: &Geometry) -> Option<Shape> {
    match *geometry {
        Geometry::Box { size } => Some(Shape::Box {
            half: Vec3::from(size.0) / 2.0,
        }),
        Geometry::Cylinder { radius, length } => Some(Shape::Cylinder {
            radius,
            half_length: length / 2.0,
        }),
        Geometry::Capsule { radius, length } => Some(Shape::Capsule {
            radius,
            half_length: length / 2.0,
        }),
        Geometry::Sphere { radius } => Some(Shape::Sphere { radius }),
        Geometry::Mesh { .. } => None,
    }
}

/// Returns the colour of a link's first visual material: its own, or that of the robot's material of that name.
fn color(link: &Link, materials: &[urdf_rs::Material]) -> [f32; 4] {
    let rgba = link.visual.iter().find_map(|v| v.material.as_ref()).and_then(|own| {
        let named = || materials.iter().rev().find(|m| m.name == own.name && m.color.is_some());
        own.color.as_ref().or_else(|| named()?.color.as_ref())
    });
    rgba.map_or(pose::GREY, |c| c.rgba.0.map(|x| x.clamp(0.0, 1.0) as f32))
}

/// The root link, and the joints (by index) from the root on.
struct Order {
    root: String,
    joints: Vec<usize>,
}

fn order(links: &IndexMap<String, Span>, joints: &[Read<'_>], problems: &mut Problems) -> Option<Order> {
    let mut moved_by: IndexMap<&str, &Read<'_>> = IndexMap::new();
    let mut ok = true;
    for joint in joints {
        if let Some(first) = moved_by.insert(joint.child(), joint) {
            ok = false;
            let message = format!(
                "link `{}` is the child of two joints, `{}` and `{}`",
                joint.child(),
                first.joint.name,
                joint.joint.name
            );
            problems.push(
                Problem::error("urdf::two-parents", message, joint.place.child_span, "again here")
                    .note(first.place.child_span, "first here")
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
        below.entry(joint.parent()).or_default().push(j);
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
            via.insert(joints[j].child(), j);
            stack.push(joints[j].child());
        }
    }
    let circle = joints.iter().find(|j| !visited.contains_key(j.child()));
    if let Some(joint) = circle {
        problems.push(
            Problem::error(
                "urdf::cycle",
                format!("link `{}` hangs on itself", joint.child()),
                joint.place.child_span,
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
    joints: &[Read<'_>],
    order: &[usize],
    dofs: &mut Vec<Dof>,
    problems: &mut Problems,
) -> IndexMap<usize, Drive> {
    let by_name: IndexMap<&str, usize> = joints
        .iter()
        .enumerate()
        .map(|(j, r)| (r.joint.name.as_str(), j))
        .collect();
    let mut drives = IndexMap::new();
    for &j in order {
        let raw = &joints[j];
        if raw.kind == JointKind::Fixed || raw.joint.mimic.is_some() {
            continue;
        }
        let (lower, upper) = limits(raw, problems);
        let dof = dofs.len();
        dofs.push(Dof {
            name: raw.joint.name.clone(),
            lower,
            upper,
            max_velocity: if raw.joint.limit.velocity > 0.0 {
                raw.joint.limit.velocity
            } else {
                look::SLOW
            },
            max_acceleration: f64::INFINITY,
            max_jerk: f64::INFINITY,
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
            && joints[j].joint.mimic.is_some()
            && let Some(drive) = follow(joints, j, &by_name, &drives, problems)
        {
            drives.insert(j, drive);
        }
    }
    drives
}

/// Returns the lower and upper limit of a joint that leads.
fn limits(read: &Read<'_>, problems: &mut Problems) -> (f64, f64) {
    let Read { joint, place, kind } = read;
    if joint.joint_type == JointType::Continuous {
        return (f64::NEG_INFINITY, f64::INFINITY);
    }
    let (lower, upper) = (joint.limit.lower, joint.limit.upper);
    if lower > upper {
        problems.push(look::upside_down(&joint.name, lower, upper, place.limit));
    }
    // Since version 1.2 a limit that is not given is infinite; a revolute joint is continuous then.
    if *kind == JointKind::Prismatic && !(lower.is_finite() && upper.is_finite()) {
        let message = format!("joint `{}` slides without end", joint.name);
        problems.push(
            Problem::error("urdf::bad-limit", message, place.limit, "")
                .help("give both `lower` and `upper`: since version 1.2 of URDF a limit that is absent is infinite"),
        );
    }
    (lower, upper)
}

/// Follows a mimic joint to the joint that leads it, through other mimic joints.
///
/// The follower's own limits are not applied: vendors' files give limits there that its leader breaks.
fn follow(
    joints: &[Read<'_>],
    start: usize,
    by_name: &IndexMap<&str, usize>,
    leaders: &IndexMap<usize, Drive>,
    problems: &mut Problems,
) -> Option<Drive> {
    let (mut scale, mut offset, mut at) = (1.0, 0.0, start);
    for _ in 0..joints.len() {
        let Some(mimic) = &joints[at].joint.mimic else { break };
        let Some(&leader) = by_name.get(mimic.joint.as_str()) else {
            let place = format!("`<mimic>` of joint `{}`", joints[at].joint.name);
            let known = by_name.keys().copied();
            problems.push(problems::unknown_name(
                "urdf::unknown-joint",
                "joint",
                &mimic.joint,
                &place,
                known,
                joints[at].place.leader,
            ));
            return None;
        };
        offset += scale * mimic.offset.unwrap_or(0.0);
        scale *= mimic.multiplier.unwrap_or(1.0);
        at = leader;
    }
    match leaders.get(&at) {
        Some(drive) if joints[at].joint.mimic.is_none() => Some(Drive {
            dof: drive.dof,
            scale,
            offset,
        }),
        _ => {
            let message = format!(
                "joint `{}` mimics nothing that moves on its own",
                joints[start].joint.name
            );
            problems.push(
                Problem::error("urdf::mimic-without-leader", message, joints[start].place.head, "")
                    .help("a leader is a revolute, continuous or prismatic joint without `<mimic>`"),
            );
            None
        }
    }
}
