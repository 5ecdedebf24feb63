//! The plan document: what `--json` writes and `validate` reads. Documented in `docs/json.md`.
//!
//! Names of entities, joints and links are those of the domain, world and URDF files. Seconds, metres, radians.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::text::{Changes, Text};

/// Version of the document's form; raised when a reader of the old one would misread the new one.
pub const VERSION: u32 = 1;

/// Returns the schema of a plan document (JSON Schema, draft 2020-12), as JSON.
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Plan).to_value();
    schema["title"] = "sgap plan".into();
    schema["properties"]["format"] = serde_json::json!({ "const": "sgap-plan" });
    schema["properties"]["version"] = serde_json::json!({ "const": VERSION });
    schema
}

/// A plan with its schedule and motions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Always `sgap-plan`.
    pub format: String,
    pub version: u32,
    /// The task as planned: `MoveObjs(PR2, [RED_CUBE, GREY_BOOK])`.
    pub task: String,
    pub seed: u64,
    /// Sum of the actions' costs, or of `cost_parts`.
    pub cost: f64,
    /// What the cost consists of, where a domain has social rules or a cost formula: the sum of the actions' costs and the
    /// makespan, then each rule in the order of the domain.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub cost_parts: Vec<CostPart>,
    /// When the last action ends [s].
    pub makespan: f64,
    /// Whether unordered subtasks were allowed to mix step by step; else each is one block.
    #[serde(skip_serializing_if = "is_false", default)]
    pub interleaved: bool,
    /// In an order in which they can be done one by one.
    pub actions: Vec<Action>,
    /// Per agent, the indices of the actions it takes part in, in order.
    pub streams: IndexMap<String, Vec<usize>>,
    /// What must be over before what (transitive reduction).
    pub links: Vec<Link>,
    /// How the task was decomposed: a tree, its nodes in the order in which they were taken up. The root, the task itself, is
    /// node 0; a node stands before its children, and, unless interleaved, all of a subtree before the next sibling.
    pub decomposition: Vec<Node>,
}

fn is_false(x: &bool) -> bool {
    !x
}

/// A part of a plan's cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CostPart {
    /// `sum`, `makespan`, or the social rule's name.
    pub name: String,
    /// `sum`, `makespan`, `undesirable state`, `effort balance` ...
    pub kind: String,
    /// What was counted: events, links, seconds, or cost.
    pub amount: f64,
    /// What one of it costs.
    pub weight: f64,
    /// Weight times amount.
    pub cost: f64,
}

/// One action.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Action {
    /// Position in [`Plan::actions`].
    pub index: usize,
    pub name: Text,
    /// As the language writes them: `PR2`, `3`, `"red"`, `[A, B]`.
    pub arguments: Vec<Text>,
    /// Who takes part; the first acts.
    pub agents: Vec<Text>,
    pub cost: f64,
    /// (least, most) [s].
    pub duration: [f64; 2],
    /// Earliest start and the end after the least duration [s].
    pub start: f64,
    pub end: f64,
    /// `None` for a purely symbolic action.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub geometry: Option<Box<Geometry>>,
    /// Attributes that this action changed, `RED_CUBE.isOn` to the new value as the language writes it; effects and shared attributes.
    pub changes: Changes,
}

/// The geometric action solution (thesis 3.2.3): choices and motions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Name of the geometric action: `pick`, `place`, `navigateTo`.
    pub action: String,
    /// Identifies the geometric action in this run (thesis: gasNum).
    pub gas: u32,
    /// 0 for the first solution (thesis: gasAltNum).
    pub alternative: u32,
    pub agent: String,
    /// Name of the arm; empty where none handles anything.
    #[serde(skip_serializing_if = "String::is_empty", default)]
    pub arm: String,
    /// The object that is handled, or the entity that the agent goes to.
    pub object: String,
    /// Name of the grasp that holds it; empty where nothing is handled.
    #[serde(skip_serializing_if = "String::is_empty", default)]
    pub grasp: String,
    /// Where the base goes, for actions that do.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub stand: Option<Stand>,
    /// Where it is put down, for actions that do.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub placement: Option<Placement>,
    /// The geometric cost's parts by name; their sum is what `GetGRPCost()` gives.
    pub cost_parts: IndexMap<String, f64>,
    pub sub_actions: Vec<SubAction>,
}

/// A place on the floor where an agent stands: of its base in the world [m], [rad].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stand {
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
}

/// A place on a support.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Entity that carries it.
    pub on: String,
    /// Name of the support face.
    pub support: String,
    /// Name of the stable orientation.
    pub stable: String,
    /// Position on the face, in its frame [m].
    pub x: f64,
    pub y: f64,
    /// About the face's normal [rad].
    pub yaw: f64,
    /// Pose of the object in the world once it stands.
    pub pose: PoseDocument,
}

/// A pose: position [m] and unit quaternion (x, y, z, w).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseDocument {
    pub position: [f64; 3],
    pub quaternion: [f64; 4],
}

impl From<crate::geom::Pose> for PoseDocument {
    fn from(pose: crate::geom::Pose) -> Self {
        let (t, r) = (pose.translation.vector, pose.rotation.coords);
        PoseDocument {
            position: [t.x, t.y, t.z],
            quaternion: [r.x, r.y, r.z, r.w],
        }
    }
}

impl PoseDocument {
    /// Returns the pose; the quaternion is normalised.
    pub fn pose(&self) -> crate::geom::Pose {
        let [x, y, z, w] = self.quaternion;
        let r = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let [px, py, pz] = self.position;
        crate::geom::Pose::from_parts(nalgebra::Translation3::new(px, py, pz), r)
    }
}

/// The motion of one sub-action (thesis: GSAS).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SubAction {
    /// `approach`, `engage`, `grasp`, `disengage`, `place`, `release`, `retract`.
    pub name: String,
    /// How it moves.
    pub motion: Motion,
    pub trajectory: Trajectory,
    /// What the hand takes or lets go of when the motion is over.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub change: Option<AttachmentChange>,
}

/// How a sub-action moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Anywhere in the joint space.
    Free,
    /// The tool on a straight line with a constant orientation.
    Straight,
    /// Fingers alone.
    Gripper,
    /// The arms to their posture for going.
    Posture,
    /// The base on the floor: the trajectory's joints are `x`, `y` [m] and `yaw` [rad] of the base in the world.
    Base,
}

/// Timed configurations of some joints; linear in between; the first time is 0 and counts from the end of the
/// sub-action before (the first one's from the action's start).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trajectory {
    pub joints: Vec<String>,
    /// [s]
    pub times: Vec<f64>,
    /// One row for each time, one column for each joint.
    pub positions: Vec<Vec<f64>>,
}

impl Trajectory {
    /// Returns its length in time [s].
    pub fn duration(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }
}

/// The hand takes or lets go of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AttachmentChange {
    Attach {
        object: String,
        /// Pose of the object in the tool frame from then on.
        object_in_tool: PoseDocument,
    },
    Detach {
        object: String,
        /// Pose of the object in the world from then on.
        object_in_world: PoseDocument,
    },
}

/// `before` must be over when `after` starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Link {
    pub before: usize,
    pub after: usize,
    pub reasons: Vec<LinkReason>,
}

/// Why one action comes before another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LinkReason {
    /// `after` needs an attribute that `before` set: `PR2.hasInHand`.
    Attribute(Text),
    /// The domain orders their subtasks.
    Order,
    /// `before` reads what `after` overwrites.
    Threat(Text),
    /// Motions are planned one after the other: `after` starts in the world that `before` leaves.
    Motion,
}

/// A task in the decomposition tree. The tree is a list, so that no reader has to follow a recursive method down.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Node {
    pub task: Text,
    pub arguments: Vec<Text>,
    /// The index of the node that has this one as a subtask; `None` for the root alone.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub parent: Option<usize>,
    /// Which decomposition of the method was applied, from 0; `None` for an action, and where the method's goal held.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub decomposition: Option<usize>,
    /// The action's index in the plan.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub action: Option<usize>,
}
