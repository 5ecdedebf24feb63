//! Forward kinematics of eight configurations at a time, as structures of arrays.
//!
//! Every lane takes the steps of [`Tree::link_poses_into`] in the same order: the poses are the same to the last bit. The loops over
//! the lanes have no branches, so that the compiler makes vector instructions of them; nothing is written for one processor.
//! Does not know limits; a lane that is not needed is filled with any configuration.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use super::hinge::{Hinge, Rigid, product};
use super::lanes::Eight;
use super::{Drive, Tree};
use crate::geom::Pose;

/// Eight numbers, one for each configuration.
pub type X8 = [f64; 8];

/// Eight poses of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct PoseX8 {
    /// Translations: x, y, z [m].
    pub p: [X8; 3],
    /// Unit quaternions: x, y, z, w.
    pub q: [X8; 4],
}

impl PoseX8 {
    /// Returns eight times the same pose.
    pub fn splat(X: &Pose) -> PoseX8 {
        let (p, q) = (&X.translation.vector, &X.rotation.coords);
        PoseX8 {
            p: [[p.x; 8], [p.y; 8], [p.z; 8]],
            q: [[q.x; 8], [q.y; 8], [q.z; 8], [q.w; 8]],
        }
    }

    /// Returns the pose of one lane, 0 to 7.
    pub fn lane(&self, l: usize) -> Pose {
        let (p, q) = (&self.p, &self.q);
        Pose::from_parts(
            Translation3::new(p[0][l], p[1][l], p[2][l]),
            UnitQuaternion::new_unchecked(Quaternion::new(q[3][l], q[0][l], q[1][l], q[2][l])),
        )
    }

    /// Returns the rotation matrices, row by row: for many points of one frame they are cheaper than quaternions.
    #[expect(clippy::needless_range_loop, reason = "a lane of each of nine rows")]
    #[inline]
    pub fn rotations(&self) -> [[X8; 3]; 3] {
        let mut m = [[[0.0; 8]; 3]; 3];
        for l in 0..8 {
            let [x, y, z, w] = [self.q[0][l], self.q[1][l], self.q[2][l], self.q[3][l]];
            let (x2, y2, z2) = (x + x, y + y, z + z);
            let (xx, yy, zz) = (x * x2, y * y2, z * z2);
            let (xy, xz, yz) = (x * y2, x * z2, y * z2);
            let (wx, wy, wz) = (w * x2, w * y2, w * z2);
            m[0][0][l] = 1.0 - (yy + zz);
            m[0][1][l] = xy - wz;
            m[0][2][l] = xz + wy;
            m[1][0][l] = xy + wz;
            m[1][1][l] = 1.0 - (xx + zz);
            m[1][2][l] = yz - wx;
            m[2][0][l] = xz - wy;
            m[2][1][l] = yz + wx;
            m[2][2][l] = 1.0 - (xx + yy);
        }
        m
    }
}

/// Which links are to be placed, eight configurations at a time, and by which joints: made once, used often.
#[derive(Debug, Clone)]
pub struct Batch {
    steps: Vec<Step>,
    links: Vec<usize>,
    /// For each of `links`, the step that places it.
    placed_by: Vec<usize>,
}

/// One joint.
#[derive(Debug, Clone)]
struct Step {
    parent: Parent,
    hinge: Hinge,
    drive: Option<Drive>,
}

#[derive(Debug, Clone, Copy)]
enum Parent {
    /// A link that stands.
    Still(usize),
    /// What an earlier step places.
    Step(usize),
}

impl Batch {
    /// Makes the door for those of `wanted` links that `dofs` (indices into `Tree::dofs`) move; their moving parents are placed
    /// with them. Wanted links that stand, or that the tree does not have, are left out: [`Batch::links`] says which are there.
    pub fn new(tree: &Tree, dofs: &[usize], wanted: &[usize]) -> Batch {
        let mut needed = vec![false; tree.joints.len() + 1];
        let moved = tree.links_moved_by(dofs);
        let links: Vec<usize> = wanted.iter().copied().filter(|l| moved.contains(l)).collect();
        for l in &links {
            needed[*l] = true;
        }
        for l in moved.iter().rev().filter(|l| **l > 0) {
            if needed[*l] {
                needed[tree.joints[l - 1].parent] = true;
            }
        }
        // Ascending, hence parents first.
        let stepped: Vec<usize> = moved.into_iter().filter(|l| *l > 0 && needed[*l]).collect();
        let step_of = |link: usize| stepped.iter().position(|l| *l == link);
        let step = |l: &usize| {
            let joint = &tree.joints[l - 1];
            Step {
                parent: step_of(joint.parent).map_or(Parent::Still(joint.parent), Parent::Step),
                hinge: Hinge::new(joint),
                drive: joint.drive,
            }
        };
        Batch {
            steps: stepped.iter().map(step).collect(),
            placed_by: links.iter().filter_map(|l| step_of(*l)).collect(),
            links,
        }
    }

    /// Returns the links that are placed, in the order in which they were wanted.
    pub fn links(&self) -> &[usize] {
        &self.links
    }

    /// Computes the poses of [`Batch::links`] in the world, in that order, into `poses`.
    ///
    /// `q[i]` has the eight values of `Tree::dofs[i]`; a `q` that is too short counts as zeros at its end. `X_WL`, by link index,
    /// says where the links stand that the dofs of this batch do not move; the others in it are not looked at, and what it does
    /// not have counts as the identity. `scratch` is memory that is used again.
    pub fn link_poses(&self, q: &[X8], X_WL: &[Pose], scratch: &mut Vec<PoseX8>, poses: &mut Vec<PoseX8>) {
        scratch.clear();
        scratch.reserve(self.steps.len());
        for step in &self.steps {
            let mut values = [0.0; 8];
            if let Some(d) = step.drive {
                values = q.get(d.dof).copied().unwrap_or([0.0; 8]);
                for v in &mut values {
                    *v = *v * d.scale + d.offset;
                }
            }
            let X_PC = step.hinge.at_x8(&values);
            let still;
            let X_WP = match step.parent {
                Parent::Step(s) => &scratch[s],
                Parent::Still(l) => {
                    still = PoseX8::splat(&X_WL.get(l).copied().unwrap_or_else(Pose::identity));
                    &still
                }
            };
            let (p, q) = (&X_WP.p, &X_WP.q);
            let X_WP = Rigid {
                p: [Eight(p[0]), Eight(p[1]), Eight(p[2])],
                q: [Eight(q[0]), Eight(q[1]), Eight(q[2]), Eight(q[3])],
            };
            let Rigid { p, q } = product(&X_WP, &X_PC);
            scratch.push(PoseX8 {
                p: [p[0].0, p[1].0, p[2].0],
                q: [q[0].0, q[1].0, q[2].0, q[3].0],
            });
        }
        poses.clear();
        poses.extend(self.placed_by.iter().map(|s| scratch[*s]));
    }
}
