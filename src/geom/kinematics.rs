//! Trees of rigid links: forward kinematics and Jacobians.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::{Pose, Vec3};

/// A robot's or human's links and joints. Link 0 is the root, whose frame is the base frame B.
///
/// INVARIANT: a joint's parent link has a smaller index than its child link; joint `j` moves link `j + 1`.
#[derive(Debug, Clone, Default)]
pub struct Tree {
    /// Link names, root first.
    pub links: Vec<String>,
    /// `joints[j]` has link `j + 1` as its child.
    pub joints: Vec<Joint>,
    /// The independent degrees of freedom; a configuration `q` has one entry for each, in this order.
    pub dofs: Vec<Dof>,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    Fixed,
    /// About `axis` [rad]; also `continuous`, whose limits are then infinite.
    Revolute,
    /// Along `axis` [m].
    Prismatic,
}

/// A joint between a parent link P and its child link.
#[derive(Debug, Clone)]
pub struct Joint {
    pub name: String,
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Pose of the joint frame J in the parent link's frame.
    pub X_PJ: Pose,
    /// Unit axis, measured in J.
    pub axis: Vec3,
    /// Where its value comes from; `None` for a fixed joint.
    pub drive: Option<Drive>,
}

/// A joint's value is `q[dof] * scale + offset`; a `mimic` joint shares its leader's dof.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    pub dof: usize,
    pub scale: f64,
    pub offset: f64,
}

/// A degree of freedom and its limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Dof {
    /// Name of the joint that leads it.
    pub name: String,
    /// [rad] or [m]; infinite for a continuous joint.
    pub lower: f64,
    pub upper: f64,
    /// [rad/s] or [m/s].
    pub max_velocity: f64,
    /// [rad/s^2] or [m/s^2].
    pub max_acceleration: f64,
}
