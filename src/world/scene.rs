//! What is there ([`Scene`], never changes) and how it stands ([`State`], small and cheap to copy).
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use indexmap::IndexMap;
use std::collections::BTreeSet;

use crate::geom::navigation::{Drive, comfort::Weights, timing::Limits};
use crate::geom::{Pose, kinematics::Tree, shape::Shape};

/// A world file, loaded.
#[derive(Debug, Clone)]
pub struct World {
    pub scene: Scene,
    pub start: State,
    /// The task as written, `MoveObjs(PR2, [RED_CUBE])`, with its place in the world file for messages.
    pub task: Option<(String, crate::source::Span)>,
    /// `[facts]`: attribute `Type.attribute` (or just `attribute`) to the fact it is read from, for files of LAAS that can't say it.
    pub shared: Vec<(String, String, crate::source::Span)>,
    /// `[state]`: initial symbolic values: entity, attribute, value.
    pub values: Vec<InitialValue>,
    /// Where each entity is declared: agents first, then objects, then virtual ones, in the order of the scene.
    pub spans: Vec<crate::source::Span>,
}

impl World {
    /// Returns the world with nothing in it: what a plan of symbols alone is judged in.
    pub fn empty() -> Self {
        World {
            scene: Scene::default(),
            start: State {
                agents: Vec::new(),
                objects: Vec::new(),
            },
            task: None,
            shared: Vec::new(),
            values: Vec::new(),
            spans: Vec::new(),
        }
    }
}

/// `RED_CUBE.painted = true` of the world file's `[state]`.
#[derive(Debug, Clone)]
pub struct InitialValue {
    pub entity: String,
    pub attribute: String,
    /// One element for an atom, any number for a set.
    pub values: Vec<Literal>,
    /// Whether the file wrote an array.
    pub is_list: bool,
    /// Whether another key than `[state]` says it, `mobility` of a human: left out where the domain declares no such attribute.
    pub is_implied: bool,
    pub span: crate::source::Span,
}

/// A constant of a world file; a text is an entity's name or a string, as the attribute's type says.
#[derive(Debug, Clone, PartialEq)]
pub enum Literal {
    Bool(bool),
    Number(f64),
    Text(String),
}

/// Everything that does not change: trees, shapes, grasps.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Robots and humans, in the order of the file.
    pub agents: Vec<Agent>,
    /// In the order of the file.
    pub objects: Vec<Object>,
    /// In the order of the file. They are nowhere: nothing touches, sees or draws them.
    pub virtuals: Vec<VirtualObject>,
    /// What people mind about a robot that passes: `[human_aware]`.
    pub human_aware: Weights,
}

/// What an id of a world file names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EntityRef {
    Agent(usize),
    Object(usize),
    Virtual(usize),
}

impl Scene {
    /// Returns the agent, object or virtual object of that id.
    pub fn find(&self, id: &str) -> Option<EntityRef> {
        let agent = self.agents.iter().position(|a| a.id == id).map(EntityRef::Agent);
        agent
            .or_else(|| self.objects.iter().position(|o| o.id == id).map(EntityRef::Object))
            .or_else(|| self.virtuals.iter().position(|v| v.id == id).map(EntityRef::Virtual))
    }

    /// Returns its id.
    pub fn id(&self, entity: EntityRef) -> &str {
        match entity {
            EntityRef::Agent(a) => &self.agents[a].id,
            EntityRef::Object(o) => &self.objects[o].id,
            EntityRef::Virtual(v) => &self.virtuals[v].id,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AgentKind {
    Robot,
    Human,
}

/// A robot or a human.
#[derive(Debug, Clone)]
pub struct Agent {
    pub id: String,
    pub kind: AgentKind,
    /// Type of the entity in the domain, if the file gives one; else `Agent`.
    pub ty: Option<String>,
    pub tree: Tree,
    /// Collision shapes of every link.
    pub bodies: Vec<Body>,
    /// Pairs of links (smaller index first) that may touch: neighbours, and those that sampling found always in contact.
    pub may_touch: BTreeSet<(usize, usize)>,
    /// One or two.
    pub arms: Vec<Arm>,
    /// A robot's camera or a human's eyes.
    pub camera: Option<Camera>,
    /// Named configurations, full `q` of the tree.
    pub postures: IndexMap<String, Vec<f64>>,
    /// Whether it can go elsewhere; who sits can't.
    pub base: BaseKind,
    /// How fast its base can go, and how soon.
    pub base_limits: Limits,
    /// What a human is like; robots have the default.
    pub manner: Manner,
}

impl Agent {
    /// Returns the gripper whose grasps decide what the arm can reach; `None` where a hand comes to the surface alone, as humans reach.
    pub fn gripper_to_reach_with(&self, arm: usize) -> Option<&Gripper> {
        match self.kind {
            AgentKind::Robot => self.arms.get(arm)?.gripper.as_ref(),
            AgentKind::Human => None,
        }
    }
}

/// What the world file says of a human besides shape and place (thesis 2.3.4.1, 2.4.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Manner {
    /// How much of the effort of a handover the human shares, from 0 (none) to 1 (as much as the robot).
    pub mobility: f64,
    /// How free the human is to take part, from 0 (not at all) to 1.
    pub availability: f64,
    /// Position in `Agent::arms` of the arm that the human prefers, if the file says.
    pub handedness: Option<usize>,
    /// Whether the human sits: the base stays where it is.
    pub is_sitting: bool,
}

impl Default for Manner {
    fn default() -> Self {
        Manner {
            mobility: 0.5,
            availability: 1.0,
            handedness: None,
            is_sitting: false,
        }
    }
}

/// How an agent's base moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BaseKind {
    /// Not at all.
    #[default]
    Fixed,
    /// On the floor, in every direction, turning on the spot or on the way.
    Planar,
    /// On the floor along its heading, forward or backward, turning on the spot.
    Differential,
    /// In the air: x, y, z and yaw. Nothing plans flights: it acts from where it hovers.
    Flying,
}

impl BaseKind {
    /// Returns how it moves; `None` where it does not.
    pub fn drive(self) -> Option<Drive> {
        match self {
            BaseKind::Fixed | BaseKind::Flying => None,
            BaseKind::Planar => Some(Drive::Holonomic),
            BaseKind::Differential => Some(Drive::Differential),
        }
    }
}

/// A shape fixed to a link L of an agent.
#[derive(Debug, Clone)]
pub struct Body {
    pub link: usize,
    pub shape: Shape,
    /// Pose of the shape frame S in the link frame.
    pub X_LS: Pose,
    /// Red, green, blue, alpha in [0, 1], for pictures.
    pub color: [f32; 4],
}

/// A serial chain of joints that ends in a hand.
#[derive(Debug, Clone)]
pub struct Arm {
    /// `left`, `right`.
    pub name: String,
    /// Links at its two ends; the chain is the joints between them.
    pub base_link: usize,
    pub tip_link: usize,
    /// Pose of the tool frame T (thesis: wrist manipulation joint) in the tip link's frame:
    /// x is the direction in which the hand approaches, y the direction in which the fingers close.
    pub X_LT: Pose,
    /// Indices into `Tree::dofs` of the joints between base and tip, in order.
    pub dofs: Vec<usize>,
    /// `None` for a bare hand (a human's).
    pub gripper: Option<Gripper>,
    /// Links of the hand: from the tip on. They may touch an object that is being grasped.
    pub hand_links: Vec<usize>,
}

/// Fingers that open and close.
#[derive(Debug, Clone)]
pub struct Gripper {
    /// Indices into `Tree::dofs`.
    pub dofs: Vec<usize>,
    /// Values of `dofs` when open and when closed on nothing.
    pub open: Vec<f64>,
    pub closed: Vec<f64>,
    /// Gap between the fingers at `open` and at `closed` [m]; the values in between follow linearly.
    pub gap_open: f64,
    pub gap_closed: f64,
}

impl Gripper {
    /// Returns the values of `dofs` at which the gap between the fingers is `gap` [m], clamped to what it can do.
    pub fn at_gap(&self, gap: f64) -> Vec<f64> {
        let t = ((gap - self.gap_closed) / (self.gap_open - self.gap_closed)).clamp(0.0, 1.0);
        self.open
            .iter()
            .zip(&self.closed)
            .map(|(o, c)| c + t * (o - c))
            .collect()
    }
}

/// A field of view: a pyramid about the x axis of the camera frame C.
#[derive(Debug, Clone)]
pub struct Camera {
    pub link: usize,
    /// Pose of the camera frame in the link's frame; x looks ahead, z is up.
    pub X_LC: Pose,
    /// Full angles [rad].
    pub horizontal: f64,
    pub vertical: f64,
    /// Farthest distance seen [m].
    pub range: f64,
}

/// Furniture or a thing to be handled.
#[derive(Debug, Clone)]
pub struct Object {
    pub id: String,
    /// Type of the entity in the domain, if the file gives one.
    pub ty: Option<String>,
    /// Convex parts, each with its pose in the object frame O.
    pub parts: Vec<Part>,
    pub movable: bool,
    pub supports: Vec<Support>,
    pub stable: Vec<Stable>,
    pub grasps: Vec<Grasp>,
    /// Where other things can be inside of it.
    pub containers: Vec<Container>,
    /// [kg]
    pub mass: f64,
    pub color: [f32; 4],
}

/// A hollow of an object: a box in which things can be.
#[derive(Debug, Clone)]
pub struct Container {
    pub name: String,
    /// Pose of the box's frame in the object frame: origin at its centre.
    pub X_OC: Pose,
    /// Half of its sides along the axes of C [m].
    pub half: [f64; 3],
}

/// A shape to ask with, "would something like this fit there?" (thesis 4.4.1): it has no place in the world.
#[derive(Debug, Clone)]
pub struct VirtualObject {
    pub id: String,
    /// Type of the entity in the domain, if the file gives one.
    pub ty: Option<String>,
    /// Convex parts, each with its pose in the object frame O.
    pub parts: Vec<Part>,
    pub stable: Vec<Stable>,
}

/// A convex part of an object.
#[derive(Debug, Clone)]
pub struct Part {
    pub shape: Shape,
    /// Pose of the shape frame in the object frame.
    pub X_OS: Pose,
}

/// A flat rectangle on which things can be placed.
#[derive(Debug, Clone)]
pub struct Support {
    pub name: String,
    /// Pose of the support frame F in the object frame: origin at the rectangle's centre, z is its outward normal.
    pub X_OF: Pose,
    /// Half of its sides along x and y of F [m].
    pub half: [f64; 2],
}

/// An orientation in which the object stands on a horizontal face (thesis 3.3.1, stable configurations).
#[derive(Debug, Clone)]
pub struct Stable {
    pub name: String,
    /// Pose of the object frame O in the placement frame Q: Q's origin lies on the support under the object's centre, z up, yaw 0.
    pub X_QO: Pose,
    /// Bottom polygon in Q (x, y) [m], convex, counter-clockwise.
    pub footprint: Vec<[f64; 2]>,
}

/// A way to hold the object (thesis 3.3.1): where the tool is when the fingers close.
#[derive(Debug, Clone)]
pub struct Grasp {
    pub name: String,
    /// Pose of the tool frame T in the object frame; the hand comes along T's x axis.
    pub X_OT: Pose,
    /// Width between the fingers when they hold it [m].
    pub width: f64,
}

/// How everything stands. Small: saved and restored by value.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    pub agents: Vec<AgentState>,
    pub objects: Vec<ObjectState>,
}

/// An agent's base pose and configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentState {
    /// Pose of the root link's frame in the world.
    pub X_WB: Pose,
    /// By `Tree::dofs`.
    pub q: Vec<f64>,
}

/// An object's pose, and who holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectState {
    pub X_WO: Pose,
    pub held: Option<Held>,
}

/// An attachment (thesis 3.3.1): the object moves with the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    pub agent: usize,
    pub arm: usize,
    /// Pose of the object in the tool frame.
    pub X_TO: Pose,
}
