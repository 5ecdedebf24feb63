//! Trees of rigid links: forward kinematics, serial chains and their geometric Jacobians.
//!
//! Poses are products of transforms from the root outwards; a Jacobian's column is the twist that a unit joint velocity gives to the
//! tool (Siciliano et al., Robotics, Springer 2009, section 3.1, doi:10.1007/978-1-84628-642-1).
//! Does not know dynamics, shapes or limits (they are carried in [`Dof`] for those who plan). Nothing is cached:
//! whoever asks often keeps the link poses and calls [`Tree::update_links`].
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

pub mod batch;
mod hinge;
mod lanes;
pub(super) mod trig;

use nalgebra::Matrix6xX;

use self::hinge::{Hinge, Rigid, product};
use super::ik::closed_form::ClosedForm;
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
    /// [rad/s^3] or [m/s^3].
    pub max_jerk: f64,
}

impl Joint {
    /// Returns the joint's value [rad] or [m] in the configuration `q` of its tree; 0 when fixed.
    pub fn value(&self, q: &[f64]) -> f64 {
        match self.drive {
            Some(Drive { dof, scale, offset }) => q.get(dof).copied().unwrap_or(0.0) * scale + offset,
            None => 0.0,
        }
    }

    /// Returns the pose of the child link in the parent link's frame when the joint has value `v`.
    pub fn pose_at(&self, v: f64) -> Pose {
        Hinge::new(self).at(v).into()
    }
}

impl Tree {
    /// Returns the length of a configuration `q`.
    pub fn n_dofs(&self) -> usize {
        self.dofs.len()
    }

    /// Returns the pose of every link in the world, by link index. A `q` that is too short counts as zeros at its end.
    pub fn link_poses(&self, X_WB: &Pose, q: &[f64]) -> Vec<Pose> {
        let mut X_WL = Vec::new();
        self.link_poses_into(X_WB, q, &mut X_WL);
        X_WL
    }

    /// Like [`Tree::link_poses`], into a vector that is used again.
    pub fn link_poses_into(&self, X_WB: &Pose, q: &[f64], X_WL: &mut Vec<Pose>) {
        X_WL.resize(self.joints.len() + 1, *X_WB);
        // Along a chain the parent is the link before: it stays in registers.
        let mut last = Rigid::from(X_WB);
        if let Some(X) = X_WL.first_mut() {
            *X = *X_WB;
        }
        for (j, joint) in self.joints.iter().enumerate() {
            if joint.parent != j {
                // INVARIANT of `Tree`: the parent comes before the child.
                last = Rigid::from(X_WL.get(joint.parent).unwrap_or(X_WB));
            }
            last = product(&last, &Hinge::new(joint).at(joint.value(q)));
            if let Some(X) = X_WL.get_mut(j + 1) {
                *X = last.into();
            }
        }
    }

    /// Returns, ascending, the links whose pose in the base frame depends on any of `dofs` (indices into `Tree::dofs`).
    pub fn links_moved_by(&self, dofs: &[usize]) -> Vec<usize> {
        let mut is_moved = vec![false; self.joints.len() + 1];
        for (j, joint) in self.joints.iter().enumerate() {
            let own = joint.drive.is_some_and(|d| dofs.contains(&d.dof));
            is_moved[j + 1] = own || is_moved.get(joint.parent).copied().unwrap_or(false);
        }
        (0..is_moved.len()).filter(|&l| is_moved[l]).collect()
    }

    /// Recomputes the world poses of `links` (ascending) in place; the parents that are not listed stand as they are in `X_WL`.
    ///
    /// The root has no joint: it is skipped, as is an index that the tree or `X_WL` does not have.
    pub fn update_links(&self, links: &[usize], q: &[f64], X_WL: &mut [Pose]) {
        for &link in links {
            let Some(joint) = link.checked_sub(1).and_then(|j| self.joints.get(j)) else {
                continue;
            };
            let Some(X_WP) = X_WL.get(joint.parent).copied() else {
                continue;
            };
            if let Some(X) = X_WL.get_mut(link) {
                *X = product(&Rigid::from(&X_WP), &Hinge::new(joint).at(joint.value(q))).into();
            }
        }
    }
}

/// The movable joints between a base link, whose frame is K, and a tool frame T on a tip link; fixed joints are folded in.
///
/// A dof that drives several joints of the chain (`mimic`) is one entry of `q`, and its column of the Jacobian is the sum.
#[derive(Debug, Clone)]
pub struct Chain {
    joints: Vec<ChainJoint>,
    hinges: Vec<Hinge>,
    /// Pose of the tool in the frame after the last movable joint.
    X_NT: Pose,
    dofs: Vec<Dof>,
    dof_indices: Vec<usize>,
    /// For each dof, see [`Chain::turns_by`].
    turns: Vec<Option<f64>>,
    closed_form: Option<ClosedForm>,
}

/// See [`Chain::turns_by`].
fn turns(joints: &[ChainJoint], column: usize) -> Option<f64> {
    let mut driven = joints.iter().filter(|j| j.column == column);
    match (driven.next(), driven.next()) {
        (Some(j), None) if j.kind == JointKind::Revolute && j.scale != 0.0 => Some(j.scale),
        _ => None,
    }
}

/// A movable joint; its hinge has its frame J in the frame N after the movable joint before it (K for the first).
#[derive(Debug, Clone)]
struct ChainJoint {
    kind: JointKind,
    axis: Vec3,
    /// Position in the chain's own `q`.
    column: usize,
    scale: f64,
    offset: f64,
}

/// A column of a geometric Jacobian: linear velocity [m/s], then angular [rad/s], per unit of joint velocity.
pub type Twist = nalgebra::Vector6<f64>;

impl Chain {
    /// Returns the chain from `base_link` to the tool at `X_LT` on `tip_link`; `None` when the tip does not descend from the base,
    /// or when the tree has no such links. A chain without movable joints is a chain: its tool stands still.
    pub fn new(tree: &Tree, base_link: usize, tip_link: usize, X_LT: &Pose) -> Option<Chain> {
        let mut way = Vec::new();
        let mut link = tip_link;
        while link != base_link {
            // Parents have smaller indices, hence this ends.
            let joint = link
                .checked_sub(1)
                .and_then(|j| tree.joints.get(j))
                .filter(|j| j.parent < link)?;
            way.push(joint);
            link = joint.parent;
        }
        if base_link > tree.joints.len() {
            return None;
        }
        let mut chain = Chain {
            joints: Vec::new(),
            hinges: Vec::new(),
            X_NT: Pose::identity(),
            dofs: Vec::new(),
            dof_indices: Vec::new(),
            turns: Vec::new(),
            closed_form: None,
        };
        for joint in way.into_iter().rev() {
            let X_NJ = chain.X_NT * joint.X_PJ;
            let (Some(drive), false) = (joint.drive, joint.kind == JointKind::Fixed) else {
                chain.X_NT = X_NJ;
                continue;
            };
            let column = match chain.dof_indices.iter().position(|&d| d == drive.dof) {
                Some(column) => column,
                None => {
                    chain.dofs.push(tree.dofs.get(drive.dof)?.clone());
                    chain.dof_indices.push(drive.dof);
                    chain.dof_indices.len() - 1
                }
            };
            let Drive { scale, offset, .. } = drive;
            chain.hinges.push(Hinge::of(&X_NJ, joint.kind, &joint.axis));
            chain.joints.push(ChainJoint {
                kind: joint.kind,
                axis: joint.axis,
                column,
                scale,
                offset,
            });
            chain.X_NT = Pose::identity();
        }
        chain.X_NT *= X_LT;
        chain.turns = (0..chain.dofs.len()).map(|i| turns(&chain.joints, i)).collect();
        chain.closed_form = ClosedForm::recognise(&chain);
        Some(chain)
    }

    /// Returns the degrees of freedom, in chain order.
    pub fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    /// Returns their indices into `Tree::dofs`.
    pub fn dof_indices(&self) -> &[usize] {
        &self.dof_indices
    }

    /// Returns whether whole turns of dof `i` leave the tool where it is: it has no limits and only drives revolute joints, one to one.
    pub fn is_continuous(&self, i: usize) -> bool {
        let endless = self
            .dofs
            .get(i)
            .is_some_and(|d| d.lower == f64::NEG_INFINITY && d.upper == f64::INFINITY);
        let one_to_one = |j: &ChainJoint| j.kind == JointKind::Revolute && j.scale.abs() == 1.0;
        endless && self.joints.iter().filter(|j| j.column == i).all(one_to_one)
    }

    /// Returns the angle by which dof `i` turns its joint per unit; `None` when it slides a joint or drives several.
    pub fn turns_by(&self, i: usize) -> Option<f64> {
        self.turns.get(i).copied().flatten()
    }

    /// Returns how its inverse kinematics is solved in closed form, where it is.
    pub fn closed_form(&self) -> Option<&ClosedForm> {
        self.closed_form.as_ref()
    }

    /// Returns `X_KT`, the pose of the tool in the base link's frame; `q` in chain order.
    pub fn tool_pose(&self, q: &[f64]) -> Pose {
        let mut X_KN = Rigid::from(&Pose::identity());
        for (joint, hinge) in self.joints.iter().zip(&self.hinges) {
            X_KN = product(&X_KN, &hinge.at(joint.value(q)));
        }
        product(&X_KN, &Rigid::from(&self.X_NT)).into()
    }

    /// Returns `X_KT` and the geometric Jacobian `J_KT`: a column for each dof; rows are the linear velocity of T's origin,
    /// then the angular velocity of T, both measured and expressed in K.
    pub fn jacobian(&self, q: &[f64]) -> (Pose, Matrix6xX<f64>) {
        let mut columns = Vec::new();
        let X_KT = self.jacobian_into(q, &mut columns);
        (
            X_KT,
            Matrix6xX::from_fn(columns.len(), |row, column| columns[column][row]),
        )
    }

    /// Like [`Chain::jacobian`], into a vector of columns that is used again.
    pub fn jacobian_into(&self, q: &[f64], columns: &mut Vec<Twist>) -> Pose {
        columns.clear();
        columns.resize(self.dofs.len(), Twist::zeros());
        if self.joints.len() <= MAX_ON_STACK {
            let mut axes = [(Vec3::zeros(), Vec3::zeros()); MAX_ON_STACK];
            self.jacobian_with(q, &mut axes, columns)
        } else {
            let mut axes = vec![(Vec3::zeros(), Vec3::zeros()); self.joints.len()];
            self.jacobian_with(q, &mut axes, columns)
        }
    }

    /// `axes` has room for each joint's origin and axis in K.
    fn jacobian_with(&self, q: &[f64], axes: &mut [(Vec3, Vec3)], columns: &mut [Twist]) -> Pose {
        let mut last = Rigid::from(&Pose::identity());
        for ((joint, hinge), axis) in self.joints.iter().zip(&self.hinges).zip(axes.iter_mut()) {
            last = product(&last, &hinge.at(joint.value(q)));
            let X_KN = Pose::from(last);
            // The joint's own motion leaves its axis where it is, so the frame after it will do. The origin of J lies on the axis of
            // a revolute joint; a sliding joint's column does not look at it.
            *axis = (X_KN.translation.vector, X_KN.rotation * joint.axis);
        }
        let X_KT = Pose::from(product(&last, &Rigid::from(&self.X_NT)));
        for (joint, (p_KJ, axis_K)) in self.joints.iter().zip(axes.iter()) {
            let (v, w) = match joint.kind {
                JointKind::Revolute => (axis_K.cross(&(X_KT.translation.vector - p_KJ)), *axis_K),
                JointKind::Prismatic => (*axis_K, Vec3::zeros()),
                JointKind::Fixed => continue,
            };
            columns[joint.column] += joint.scale * Twist::new(v.x, v.y, v.z, w.x, w.y, w.z);
        }
        X_KT
    }
}

/// Chains up to this length need no allocation for a Jacobian.
const MAX_ON_STACK: usize = 16;

impl ChainJoint {
    #[inline]
    fn value(&self, q: &[f64]) -> f64 {
        q.get(self.column).copied().unwrap_or(0.0) * self.scale + self.offset
    }
}
