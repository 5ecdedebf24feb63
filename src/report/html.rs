//! A world, or a plan in its world, as one HTML page: the scene in 3D with a time slider.
//!
//! The page needs no network: three.js, the scene and the plan are inside it, and its content security policy forbids
//! every load. The scene is written as JSON (`SceneDocument` below) and the plan as its document; the world at a time is
//! computed in the page (`page/kinematics.js`, `page/timeline.js`), so that the file stays small.
//!
//! Not here: no check that the plan fits the world (`validate` does that; the page only names what it can't find), no
//! visual meshes: a mesh is shown as the hulls that stand for it.

use serde::Serialize;

use super::base64::base64;
use crate::geom::{
    kinematics::{Drive, JointKind, Tree},
    shape::Shape,
};
use crate::plan::{Plan, PoseDocument};
use crate::world::{Agent, AgentKind, Object, Scene, State};

const TEMPLATE: &str = include_str!("page/template.html");
const STYLE: &str = include_str!("page/style.css");
/// In this order; they share one scope.
const SCRIPTS: [&str; 8] = [
    include_str!("page/kinematics.js"),
    include_str!("page/timeline.js"),
    include_str!("page/scene3d.js"),
    include_str!("page/stage.js"),
    include_str!("page/streams.js"),
    include_str!("page/tree.js"),
    include_str!("page/details.js"),
    include_str!("page/page.js"),
];
/// three.js, bundled and gzipped; `docs/view.md` tells how it is made.
const THREE: &[u8] = include_bytes!("page/three.min.js.gz");
/// The MIT licence asks to be in every copy, so it is in every page.
const THREE_LICENSE: &str = include_str!("page/THREE-LICENSE");

/// Returns the page that shows the scene from `start` on, moved by the plan if there is one.
///
/// `title` is plain text: the heading and the tab's name. The same arguments give the same bytes.
pub fn page(scene: &Scene, start: &State, plan: Option<&Plan>, title: &str) -> String {
    let title = escape_html(title);
    let plan = json(&plan);
    // Where there is nothing to draw, half a megabyte less.
    let is_flat = scene.agents.is_empty() && scene.objects.is_empty();
    let three = if is_flat { String::new() } else { base64(THREE) };
    let scene = json(&scene_document(scene, start));
    let script = SCRIPTS.concat();
    fill(TEMPLATE, |name| match name {
        "title" => &title,
        "style" => STYLE,
        "scene" => &scene,
        "plan" => &plan,
        "three" => &three,
        "license" => THREE_LICENSE,
        "script" => &script,
        _ => unreachable!("the template has no other places"),
    })
}

/// Returns the template with each `{{name}}` replaced; what is put in is not searched for further places.
fn fill<'a>(template: &str, value: impl Fn(&str) -> &'a str) -> String {
    let mut pieces = template.split("{{");
    let mut out = String::from(pieces.next().unwrap_or_default());
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or((piece, ""));
        out.push_str(value(name));
        out.push_str(rest);
    }
    out
}

/// Returns the value as JSON that can stand inside a `<script>` element.
fn json<T: Serialize>(value: &T) -> String {
    match serde_json::to_string(value) {
        // `<` occurs only inside of strings there; without it, nothing can close the element or open a comment.
        Ok(text) => text.replace('<', "\\u003c"),
        Err(error) => unreachable!("report: documents have only text keys: {error}"),
    }
}

fn escape_html(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// What the page needs of a scene and its start. Metres, radians; colours red, green, blue, alpha in [0, 1].
#[derive(Serialize)]
struct SceneDocument<'a> {
    agents: Vec<AgentDocument<'a>>,
    objects: Vec<ObjectDocument<'a>>,
    start: StartDocument<'a>,
}

#[derive(Serialize)]
struct AgentDocument<'a> {
    id: &'a str,
    /// `robot` or `human`.
    kind: &'static str,
    /// Names; `joints[j]` moves link `j + 1`.
    links: &'a [String],
    joints: Vec<JointDocument<'a>>,
    /// Names of the degrees of freedom, in the order of `q`.
    dofs: Vec<&'a str>,
    bodies: Vec<BodyDocument>,
    arms: Vec<ArmDocument<'a>>,
}

#[derive(Serialize)]
struct JointDocument<'a> {
    name: &'a str,
    /// `fixed`, `revolute` or `prismatic`.
    kind: &'static str,
    parent: usize,
    /// Pose of the joint frame in the parent link's frame.
    pose: PoseDocument,
    axis: [f64; 3],
    drive: Option<DriveDocument>,
}

/// The joint's value is `q[dof] * scale + offset`.
#[derive(Serialize)]
struct DriveDocument {
    dof: usize,
    scale: f64,
    offset: f64,
}

#[derive(Serialize)]
struct BodyDocument {
    link: usize,
    shape: ShapeDocument,
    /// In the link frame.
    pose: PoseDocument,
    color: [f32; 4],
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum ShapeDocument {
    Box {
        half: [f64; 3],
    },
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    Sphere {
        radius: f64,
    },
    Capsule {
        radius: f64,
        half_length: f64,
    },
    /// Corners in the shape's frame, and the triangles of its faces, counter-clockwise as seen from outside.
    Hull {
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
    },
}

#[derive(Serialize)]
struct ArmDocument<'a> {
    name: &'a str,
    /// The tip link, and the tool frame's pose in its frame.
    link: usize,
    tool: PoseDocument,
}

#[derive(Serialize)]
struct ObjectDocument<'a> {
    id: &'a str,
    movable: bool,
    color: [f32; 4],
    parts: Vec<PartDocument>,
}

#[derive(Serialize)]
struct PartDocument {
    shape: ShapeDocument,
    /// In the object frame.
    pose: PoseDocument,
}

#[derive(Serialize)]
struct StartDocument<'a> {
    agents: Vec<AgentStartDocument<'a>>,
    objects: Vec<ObjectStartDocument>,
}

#[derive(Serialize)]
struct AgentStartDocument<'a> {
    /// Pose of the root link in the world.
    base: PoseDocument,
    q: &'a [f64],
}

#[derive(Serialize)]
struct ObjectStartDocument {
    /// In the world.
    pose: PoseDocument,
    held: Option<HeldDocument>,
}

#[derive(Serialize)]
struct HeldDocument {
    agent: usize,
    arm: usize,
    object_in_tool: PoseDocument,
}

fn scene_document<'a>(scene: &'a Scene, start: &'a State) -> SceneDocument<'a> {
    SceneDocument {
        agents: scene.agents.iter().map(agent_document).collect(),
        objects: scene.objects.iter().map(object_document).collect(),
        start: start_document(start),
    }
}

fn agent_document(agent: &Agent) -> AgentDocument<'_> {
    let bodies = agent.bodies.iter().map(|body| BodyDocument {
        link: body.link,
        shape: shape_document(&body.shape),
        pose: body.X_LS.into(),
        color: body.color,
    });
    let arms = agent.arms.iter().map(|arm| ArmDocument {
        name: &arm.name,
        link: arm.tip_link,
        tool: arm.X_LT.into(),
    });
    AgentDocument {
        id: &agent.id,
        kind: match agent.kind {
            AgentKind::Robot => "robot",
            AgentKind::Human => "human",
        },
        links: &agent.tree.links,
        joints: joint_documents(&agent.tree),
        dofs: agent.tree.dofs.iter().map(|dof| dof.name.as_str()).collect(),
        bodies: bodies.collect(),
        arms: arms.collect(),
    }
}

fn joint_documents(tree: &Tree) -> Vec<JointDocument<'_>> {
    tree.joints
        .iter()
        .map(|joint| JointDocument {
            name: &joint.name,
            kind: match joint.kind {
                JointKind::Fixed => "fixed",
                JointKind::Revolute => "revolute",
                JointKind::Prismatic => "prismatic",
            },
            parent: joint.parent,
            pose: joint.X_PJ.into(),
            axis: joint.axis.into(),
            drive: joint
                .drive
                .map(|Drive { dof, scale, offset }| DriveDocument { dof, scale, offset }),
        })
        .collect()
}

fn shape_document(shape: &Shape) -> ShapeDocument {
    match *shape {
        Shape::Hull(ref hull) => ShapeDocument::Hull {
            vertices: hull
                .vertices
                .iter()
                .map(|v| (*v).into())
                .map(|v: [f64; 3]| v.map(rounded))
                .collect(),
            triangles: hull.faces.iter().flat_map(|f| f.triangles()).collect(),
        },
        Shape::Box { half } => ShapeDocument::Box { half: half.into() },
        Shape::Cylinder { radius, half_length } => ShapeDocument::Cylinder { radius, half_length },
        Shape::Sphere { radius } => ShapeDocument::Sphere { radius },
        Shape::Capsule { radius, half_length } => ShapeDocument::Capsule { radius, half_length },
    }
}

/// To a hundredth of a millimetre: a page is for eyes.
fn rounded(length: f64) -> f64 {
    (length * 1e5).round() / 1e5
}

fn object_document(object: &Object) -> ObjectDocument<'_> {
    let parts = object.parts.iter().map(|part| PartDocument {
        shape: shape_document(&part.shape),
        pose: part.X_OS.into(),
    });
    ObjectDocument {
        id: &object.id,
        movable: object.movable,
        color: object.color,
        parts: parts.collect(),
    }
}

fn start_document(start: &State) -> StartDocument<'_> {
    let agents = start.agents.iter().map(|agent| AgentStartDocument {
        base: agent.X_WB.into(),
        q: &agent.q,
    });
    let objects = start.objects.iter().map(|object| ObjectStartDocument {
        pose: object.X_WO.into(),
        held: object.held.as_ref().map(|held| HeldDocument {
            agent: held.agent,
            arm: held.arm,
            object_in_tool: held.X_TO.into(),
        }),
    });
    StartDocument {
        agents: agents.collect(),
        objects: objects.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::{escape_html, fill, json};

    #[test]
    fn what_is_put_in_is_not_searched_again() {
        let filled = fill("a {{x}} b {{y}}.", |name| if name == "x" { "{{y}}" } else { "Y" });
        assert_eq!(filled, "a {{y}} b Y.");
    }

    #[test]
    fn text_cannot_leave_its_place() {
        assert_eq!(json(&"</script><!--"), r#""\u003c/script>\u003c!--""#);
        assert_eq!(escape_html("<b> & \"c\""), "&lt;b&gt; &amp; &quot;c&quot;");
    }
}
