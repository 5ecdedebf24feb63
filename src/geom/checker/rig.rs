//! The moving part of a kinematic tree, made ready for many configurations: joints whose axis is z, bodies by joint.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::sync::Arc;

use nalgebra::{Rotation3, Translation3, UnitQuaternion};

use super::lanes::{Fixed, Lanes, Poses, sin_cos};
use crate::geom::cover::Form;
use crate::geom::kinematics::{JointKind, Tree};
use crate::geom::{Pose, Vec3};

/// A convex body that a link carries.
#[derive(Debug, Clone)]
pub struct Body {
    /// Index of the link that carries it.
    pub link: usize,
    /// Pose of its shape in that link's frame.
    pub X_LS: Pose,
    pub form: Arc<Form>,
}

/// What some joints of a tree move. Made once, used for every state of the world.
#[derive(Debug)]
pub struct Rig {
    pub(super) joints: Vec<RigJoint>,
    /// By link: the joint that moves it last, and its pose in the frame N after that joint.
    pub(super) links: Vec<Option<(usize, Pose)>>,
    pub(super) bodies: Vec<Body>,
    /// The dofs in the order of a checked configuration.
    pub(super) dofs: Vec<usize>,
}

/// A joint that turns about z or slides along it.
#[derive(Debug, Clone)]
pub(super) struct RigJoint {
    pub parent: Parent,
    /// Pose of the joint frame in the frame after the parent joint, or in the parent link's.
    pub X_PJ: Pose,
    pub slides: bool,
    pub source: Source,
    pub scale: f64,
    pub offset: f64,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Parent {
    Joint(usize),
    /// A link that stands still.
    Link(usize),
}

/// Where the value of a joint comes from.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source {
    /// The checked configuration.
    Column(usize),
    /// The rest of the tree's configuration, by dof.
    Rest(usize),
}

impl Rig {
    /// Prepares what `dofs` (indices into `Tree::dofs`, in the order in which configurations will list them) move, and what `others`
    /// move, which change now and then (fingers). `bodies` may be all of the robot's: those on links that do not move
    /// become obstacles.
    pub fn new(tree: &Tree, dofs: &[usize], others: &[usize], bodies: Vec<Body>) -> Rig {
        let mut joints: Vec<RigJoint> = Vec::new();
        let mut links: Vec<Option<(usize, Pose)>> = vec![None];
        for joint in &tree.joints {
            let before = links.get(joint.parent).copied().flatten();
            let moves = |dof: usize| before.is_some() || dofs.contains(&dof) || others.contains(&dof);
            let drive = joint.drive.filter(|d| joint.kind != JointKind::Fixed && moves(d.dof));
            let Some(drive) = drive else {
                links.push(before.map(|(j, X_NP)| (j, X_NP * joint.X_PJ)));
                continue;
            };
            let X_JA = along_z(&joint.axis);
            let (parent, X_PJ) = match before {
                Some((j, X_NP)) => (Parent::Joint(j), X_NP * joint.X_PJ * X_JA),
                None => (Parent::Link(joint.parent), joint.X_PJ * X_JA),
            };
            let column = dofs.iter().position(|d| *d == drive.dof);
            joints.push(RigJoint {
                parent,
                X_PJ,
                slides: joint.kind == JointKind::Prismatic,
                source: column.map_or(Source::Rest(drive.dof), Source::Column),
                scale: drive.scale,
                offset: drive.offset,
            });
            links.push(Some((joints.len() - 1, X_JA.inverse())));
        }
        Rig {
            joints,
            links,
            bodies,
            dofs: dofs.to_vec(),
        }
    }

    /// Returns the bodies, in the order in which they were given.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the dofs of a checked configuration, in its order.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// Says whether a link moves.
    pub fn moves(&self, link: usize) -> bool {
        self.links.get(link).is_some_and(Option::is_some)
    }
}

/// A frame whose z axis is the unit vector `axis`.
fn along_z(axis: &Vec3) -> Pose {
    if *axis == Vec3::z() {
        return Pose::identity();
    }
    let mut aside = Vec3::zeros();
    aside[axis.abs().imin()] = 1.0;
    let x = aside.cross(axis).normalize();
    let R = Rotation3::from_basis_unchecked(&[x, axis.cross(&x), *axis]);
    Pose::from_parts(Translation3::identity(), UnitQuaternion::from_rotation_matrix(&R))
}

/// A joint of a rig that stands somewhere.
#[derive(Debug, Clone)]
pub(super) struct PlacedJoint {
    /// `None`: its transform is in the world.
    pub parent: Option<usize>,
    pub X: Fixed,
    pub slides: bool,
    pub source: Source,
    pub scale: f64,
    pub offset: f64,
}

impl PlacedJoint {
    pub(super) fn new(joint: &RigJoint, X_WL: &[Pose]) -> PlacedJoint {
        let (parent, X) = match joint.parent {
            Parent::Joint(j) => (Some(j), joint.X_PJ),
            Parent::Link(link) => (None, X_WL.get(link).copied().unwrap_or_default() * joint.X_PJ),
        };
        PlacedJoint {
            parent,
            X: Fixed::new(&X),
            slides: joint.slides,
            source: joint.source,
            scale: joint.scale,
            offset: joint.offset,
        }
    }
}

/// Computes the poses after each joint, in the world; `q` by column, `rest` by dof.
#[inline(always)]
pub(super) fn place<const N: usize>(joints: &[PlacedJoint], q: &[Lanes<N>], rest: &[f64], X_WN: &mut Vec<Poses<N>>) {
    X_WN.resize(joints.len(), Poses::all(&Fixed::new(&Pose::identity())));
    for (k, joint) in joints.iter().enumerate() {
        let value = match joint.source {
            Source::Column(i) => q.get(i).copied().unwrap_or(Lanes::all(0.0)),
            Source::Rest(dof) => Lanes::all(rest.get(dof).copied().unwrap_or(0.0)),
        };
        let value = value * joint.scale + joint.offset;
        // INVARIANT of `Tree`: the parent comes before the child.
        let (before, from) = X_WN.split_at_mut(k);
        let Some(X) = from.first_mut() else { continue };
        match joint.parent.and_then(|p| before.get(p)) {
            Some(parent) => X.set(parent, &joint.X),
            None => *X = Poses::all(&joint.X),
        }
        if joint.slides {
            X.slide(&value);
        } else {
            let (sin, cos) = sin_cos(value);
            X.turn(&sin, &cos);
        }
    }
}
