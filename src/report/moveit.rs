//! A world as a ROS 2 message `moveit_msgs/PlanningScene` in YAML: what MoveIt's scene has around one robot, and that robot's joints.
//!
//! MoveIt knows one robot, by its own URDF: here the first of the world. Everything else becomes collision objects: furniture, things,
//! humans and other robots as they stand at the start; what the robot holds is attached to it. Poses are in the frame of the robot's
//! root link, which is MoveIt's planning frame unless its SRDF says otherwise. What is 0 in a message by default is left out, and so is
//! the operation: 0 adds.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::yaml::quoted;
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{AgentKind, Scene, State};

/// `shape_msgs/SolidPrimitive`.
const BOX: u8 = 1;
const SPHERE: u8 = 2;
const CYLINDER: u8 = 3;

/// Returns the message of the world in a state; `None` without a robot.
pub fn write(scene: &Scene, state: &State, name: &str) -> Option<String> {
    let robot = scene.agents.iter().position(|a| a.kind == AgentKind::Robot)?;
    let (body, at) = (&scene.agents[robot], &state.agents[robot]);
    let frame = body.tree.links.first().map_or("", String::as_str);
    let X_RW = at.X_WB.inverse();
    let mut out = format!("# the world around {}\nname: {}\n", body.id, quoted(name));
    let names: Vec<String> = body.tree.dofs.iter().map(|d| quoted(&d.name)).collect();
    let values: Vec<String> = at.q.iter().map(|v| number(*v)).collect();
    out += "robot_state:\n  joint_state:\n";
    out += &format!(
        "    name: [{}]\n    position: [{}]\n",
        names.join(", "),
        values.join(", ")
    );
    let is_held = |o: usize| state.objects[o].held.as_ref().filter(|h| h.agent == robot);
    let attached: Vec<usize> = (0..scene.objects.len()).filter(|o| is_held(*o).is_some()).collect();
    if !attached.is_empty() {
        out += "  attached_collision_objects:\n";
    }
    for object in attached {
        let Some(held) = is_held(object) else { continue };
        let arm = &body.arms[held.arm];
        let link = &body.tree.links[arm.tip_link];
        let touch: Vec<String> = arm.hand_links.iter().map(|l| quoted(&body.tree.links[*l])).collect();
        out += &format!("  - link_name: {}\n    object:\n", quoted(link));
        let parts = scene.objects[object].parts.iter().map(|p| (&p.shape, p.X_OS));
        let X_LO = arm.X_LT * held.X_TO;
        collision_object(&mut out, "      ", link, &scene.objects[object].id, &X_LO, parts);
        out += &format!("    touch_links: [{}]\n", touch.join(", "));
    }
    let mut others = String::new();
    for (object, thing) in scene.objects.iter().enumerate().filter(|(o, _)| is_held(*o).is_none()) {
        let parts = thing.parts.iter().map(|p| (&p.shape, p.X_OS));
        let X_RO = X_RW * state.objects[object].X_WO;
        item(&mut others, frame, &thing.id, &X_RO, parts);
    }
    for (agent, other) in scene.agents.iter().enumerate().filter(|(a, _)| *a != robot) {
        let at = &state.agents[agent];
        let X_BL = other.tree.link_poses(&Pose::identity(), &at.q);
        let parts = other.bodies.iter().map(|b| (&b.shape, X_BL[b.link] * b.X_LS));
        item(&mut others, frame, &other.id, &(X_RW * at.X_WB), parts);
    }
    out += if others.is_empty() {
        "world:\n  collision_objects: []\n"
    } else {
        "world:\n  collision_objects:\n"
    };
    Some(out + &others)
}

/// A collision object as a member of a list.
fn item<'a>(out: &mut String, frame: &str, id: &str, X: &Pose, parts: impl Iterator<Item = (&'a Shape, Pose)>) {
    *out += "  -\n";
    collision_object(out, "    ", frame, id, X, parts);
}

/// `moveit_msgs/CollisionObject`: `X` is its pose in `frame`, that of each part is in the object's frame.
fn collision_object<'a>(
    out: &mut String,
    pad: &str,
    frame: &str,
    id: &str,
    X: &Pose,
    parts: impl Iterator<Item = (&'a Shape, Pose)>,
) {
    *out += &format!(
        "{pad}header: {{frame_id: {}}}\n{pad}id: {}\n",
        quoted(frame),
        quoted(id)
    );
    *out += &format!("{pad}pose: {}\n", pose(X));
    let (mut primitives, mut primitive_poses) = (Vec::new(), Vec::new());
    let (mut meshes, mut mesh_poses) = (Vec::new(), Vec::new());
    for (shape, X_OS) in parts {
        let mut add = |kind: u8, sizes: &[f64], X: Pose| {
            let sizes: Vec<String> = sizes.iter().map(|s| number(*s)).collect();
            primitives.push(format!("{{type: {kind}, dimensions: [{}]}}", sizes.join(", ")));
            primitive_poses.push(pose(&X));
        };
        match shape {
            Shape::Box { half } => add(BOX, &[2.0 * half.x, 2.0 * half.y, 2.0 * half.z], X_OS),
            Shape::Sphere { radius } => add(SPHERE, &[*radius], X_OS),
            Shape::Cylinder { radius, half_length } => add(CYLINDER, &[2.0 * half_length, *radius], X_OS),
            // There is no capsule: a cylinder and its two ends.
            Shape::Capsule { radius, half_length } => {
                add(CYLINDER, &[2.0 * half_length, *radius], X_OS);
                for end in [-half_length, *half_length] {
                    add(SPHERE, &[*radius], X_OS * Pose::translation(0.0, 0.0, end));
                }
            }
            Shape::Hull(hull) => {
                let corners: Vec<String> = hull.vertices.iter().map(point).collect();
                let triangles = hull.faces.iter().flat_map(|f| f.triangles());
                let triangles: Vec<String> = triangles
                    .map(|[a, b, c]| format!("{{vertex_indices: [{a}, {b}, {c}]}}"))
                    .collect();
                meshes.push(format!(
                    "{{triangles: [{}], vertices: [{}]}}",
                    triangles.join(", "),
                    corners.join(", ")
                ));
                mesh_poses.push(pose(&X_OS));
            }
        }
    }
    for (name, values) in [
        ("primitives", primitives),
        ("primitive_poses", primitive_poses),
        ("meshes", meshes),
        ("mesh_poses", mesh_poses),
    ] {
        if !values.is_empty() {
            *out += &format!("{pad}{name}:\n");
            for value in values {
                *out += &format!("{pad}- {value}\n");
            }
        }
    }
}

/// `geometry_msgs/Pose`.
fn pose(X: &Pose) -> String {
    let r = X.rotation.coords;
    let (x, y, z, w) = (number(r.x), number(r.y), number(r.z), number(r.w));
    format!(
        "{{position: {}, orientation: {{x: {x}, y: {y}, z: {z}, w: {w}}}}}",
        point(&X.translation.vector)
    )
}

/// `geometry_msgs/Point`.
fn point(p: &Vec3) -> String {
    format!("{{x: {}, y: {}, z: {}}}", number(p.x), number(p.y), number(p.z))
}

/// Nine digits, as in plans; a message has no integers where it wants fractions, and no negative zeros.
fn number(v: f64) -> String {
    let rounded = (v * 1e9).round() / 1e9 + 0.0;
    format!("{rounded:?}")
}
