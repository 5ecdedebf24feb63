//! An inverse kinematics of our own, for the fact `isReachable` alone.
//!
//! Damped least squares (Wampler 1986, doi:10.1109/TSMC.1986.289285) from seeds of a Halton sequence, joints at a limit left
//! out of the step. Slow beside the planner's; it shares no line with it, forward kinematics of the chain included.
//! A search that fails proves nothing: the caller weighs it.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::{Matrix6, Matrix6xX, Vector6};

use super::{
    Settings,
    bodies::{Bodies, Owner, Placed, Touching, held_by},
};
use crate::geom::{
    Pose, Vec3, collide,
    kinematics::{JointKind, Tree},
};
use crate::world::{Arm, Gripper, State};

/// Iterations of one descent.
const ITERATIONS: usize = 100;
/// Damping, and the longest step of a joint [rad or m].
const DAMPING: f64 = 0.03;
const LONGEST: f64 = 0.4;
/// When a grasp counts as reached ([m], [rad]), and a point [m].
const AT_POSE: (f64, f64) = (0.001, 0.01);
const AT_POINT: f64 = 0.01;
/// How far from a configuration that collides another one is looked for [rad or m].
const NEAR: f64 = 0.5;
/// Restarts that every target gets, however many there are.
const LEAST_RESTARTS: usize = 4;

/// Where the tool should be.
#[derive(Debug, Clone, Copy)]
enum Target {
    Pose(Pose),
    Point(Vec3),
}

/// What a search has seen.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Search {
    /// Whether any target is within the arm's length at all.
    pub(super) possible: bool,
    /// Whether a configuration without collision was found.
    pub(super) found: bool,
    pub(super) restarts: usize,
    /// How many restarts ended in a configuration that keeps clear of everything by the margin.
    pub(super) clear: usize,
}

/// When a search ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Until {
    /// A configuration is found, or `Settings::reach_restarts` are spent.
    Found,
    /// `Settings::contradiction_restarts` are spent.
    Spent,
}

/// Searches for a configuration of one of the agent's arms at the object; base and all other joints stay.
///
/// A robot's gripper: the tool at a grasp of the object that is not wider than the open gripper. A bare or a human hand: the tool's origin at
/// the point where the segment from the shoulder to the object's origin enters the object. A hand that holds something
/// can't take another object.
pub(super) fn search(
    bodies: &Bodies<'_>,
    state: &State,
    agent: usize,
    object: usize,
    settings: &Settings,
    until: Until,
) -> Search {
    let X_WL = bodies.links(state, agent);
    let mut targets = Vec::new();
    let is_full = |arm: usize| (0..state.objects.len()).any(|o| held_by(state, o, agent) == Some(arm));
    let arms = bodies.scene.agents[agent].arms.iter().enumerate();
    for (index, arm) in arms.filter(|(i, _)| !is_full(*i)) {
        if let Some(chain) = Chain::new(&bodies.scene.agents[agent].tree, arm, &X_WL) {
            let gripper = bodies.scene.agents[agent].gripper_to_reach_with(index);
            let goals = chain.targets(bodies, state, object, gripper);
            let near = goals.into_iter().filter(|t| chain.could_reach(t));
            targets.extend(near.map(|t| (index, chain.clone(), t)));
        }
    }
    let mut search = Search {
        possible: !targets.is_empty(),
        ..Search::default()
    };
    let budget = match until {
        Until::Found => settings.reach_restarts.max(LEAST_RESTARTS * targets.len()),
        Until::Spent => settings.contradiction_restarts,
    };
    if targets.is_empty() {
        return search;
    }
    // By target, the last configuration that reaches it but collides.
    let mut blocked: Vec<Option<Vec<f64>>> = vec![None; targets.len()];
    for restart in 0..budget {
        let at = restart % targets.len();
        let (arm, chain, target) = &targets[at];
        let round = restart / targets.len();
        // HEURISTIC: what is free is often near to what only just collides; every other round looks there.
        let seed = match &blocked[at] {
            Some(q) if until == Until::Found && round % 2 == 1 => chain.near(q, round),
            _ => chain.seed(&state.agents[agent].q, round),
        };
        search.restarts += 1;
        let Some(q) = chain.descend(seed, target) else {
            continue;
        };
        let margin = stance(bodies, state, agent, *arm, object, &q, settings);
        if margin.is_none() {
            blocked[at] = Some(q);
        }
        search.found |= margin.is_some();
        search.clear += usize::from(margin == Some(true));
        if search.found && until == Until::Found {
            break;
        }
    }
    search
}

/// Returns where the shoulders of the agent's empty hands are in the world, and how far these can reach at most [m].
pub(super) fn shoulders(bodies: &Bodies<'_>, state: &State, agent: usize) -> Vec<(Vec3, f64)> {
    let X_WL = bodies.links(state, agent);
    let is_full = |arm: usize| (0..state.objects.len()).any(|o| held_by(state, o, agent) == Some(arm));
    let arms = bodies.scene.agents[agent].arms.iter().enumerate();
    arms.filter(|(i, _)| !is_full(*i))
        .filter_map(|(_, arm)| {
            let chain = Chain::new(&bodies.scene.agents[agent].tree, arm, &X_WL)?;
            Some((chain.shoulder(), chain.length()))
        })
        .collect()
}

/// Says of a configuration whether it keeps clear by the margin; `None` when it collides.
fn stance(
    bodies: &Bodies<'_>,
    state: &State,
    agent: usize,
    arm: usize,
    object: usize,
    q: &[f64],
    settings: &Settings,
) -> Option<bool> {
    let shape = &bodies.scene.agents[agent];
    let mut state = state.clone();
    state.agents[agent].q = q.to_vec();
    let mut dofs = shape.arms[arm].dofs.clone();
    if let Some(gripper) = &shape.arms[arm].gripper {
        for (dof, open) in gripper.dofs.iter().zip(&gripper.open) {
            state.agents[agent].q[*dof] = *open;
        }
        dofs.extend(&gripper.dofs);
    }
    let moves = moved_links(&shape.tree, &dofs);
    let is_moving = |p: &Placed<'_>| matches!(p.owner, Owner::Link { link, .. } if moves[link]);
    let (moving, mut standing): (Vec<Placed<'_>>, Vec<Placed<'_>>) =
        bodies.agent(&state, agent).into_iter().partition(is_moving);
    for other in (0..state.agents.len()).filter(|a| *a != agent) {
        standing.extend(bodies.agent(&state, other));
    }
    for o in 0..state.objects.len() {
        standing.extend(bodies.object(&state, o));
    }
    let touching = Some(Touching { agent, arm, object });
    let mut pairs = 0;
    if let Some(_contact) = bodies.contact(&state, &moving, &standing, touching, settings.tolerance, &mut pairs) {
        return None;
    }
    let clear = moving.iter().enumerate().all(|(i, a)| {
        let others = moving[i + 1..].iter().chain(&standing);
        others
            .filter(|b| !bodies.may_touch(&state, a.owner, b.owner, touching))
            .all(|b| {
                let apart = (a.X_WS.translation.vector - b.X_WS.translation.vector).norm();
                apart > a.solid.radius() + b.solid.radius() + settings.reach_margin
                    || collide::distance(a.solid, &a.X_WS, b.solid, &b.X_WS) >= settings.reach_margin
            })
    });
    Some(clear)
}

/// Says of each link whether one of the dofs moves it.
fn moved_links(tree: &Tree, dofs: &[usize]) -> Vec<bool> {
    let mut moved = vec![false; tree.joints.len() + 1];
    for (j, joint) in tree.joints.iter().enumerate() {
        let driven = joint.drive.is_some_and(|d| dofs.contains(&d.dof));
        moved[j + 1] = driven || moved[joint.parent];
    }
    moved
}

/// The joints of an arm, from its base link on.
#[derive(Clone)]
struct Chain<'a> {
    tree: &'a Tree,
    arm: &'a Arm,
    joints: Vec<usize>,
    /// Pose of the base link, K.
    X_WK: Pose,
}

impl<'a> Chain<'a> {
    /// Returns the chain; `None` when the tip does not hang on the base.
    fn new(tree: &'a Tree, arm: &'a Arm, X_WL: &[Pose]) -> Option<Self> {
        let mut joints = Vec::new();
        let mut link = arm.tip_link;
        while link != arm.base_link {
            let joint = link.checked_sub(1)?;
            joints.push(joint);
            link = tree.joints[joint].parent;
        }
        joints.reverse();
        Some(Chain {
            tree,
            arm,
            joints,
            X_WK: X_WL[arm.base_link],
        })
    }

    fn shoulder(&self) -> Vec3 {
        let first = self
            .joints
            .iter()
            .map(|j| &self.tree.joints[*j])
            .find(|j| j.drive.is_some());
        let X_KJ = first.map_or_else(Pose::identity, |_| {
            let mut X = Pose::identity();
            for joint in self.joints.iter().map(|j| &self.tree.joints[*j]) {
                X *= joint.X_PJ;
                if joint.drive.is_some() {
                    break;
                }
            }
            X
        });
        (self.X_WK * X_KJ).translation.vector
    }

    fn targets(&self, bodies: &Bodies<'_>, state: &State, object: usize, gripper: Option<&Gripper>) -> Vec<Target> {
        let thing = &bodies.scene.objects[object];
        let X_WO = state.objects[object].X_WO;
        if let Some(gripper) = gripper {
            let fitting = thing.grasps.iter().filter(|g| g.width <= gripper.gap_open);
            return fitting.map(|g| Target::Pose(X_WO * g.X_OT)).collect();
        }
        let centre = X_WO.translation.vector;
        let shoulder = self.shoulder();
        let length = (centre - shoulder).norm();
        if length < 1e-9 {
            return Vec::new();
        }
        let direction = (centre - shoulder) / length;
        let entry = Bodies::ray(&bodies.object(state, object), &shoulder, &direction, length, &|_| true);
        // The origin may lie outside of the object's parts: then the segment ends there.
        vec![Target::Point(shoulder + direction * entry.unwrap_or(length))]
    }

    /// Says whether the target is not farther from the shoulder than the stretched arm is long.
    fn could_reach(&self, target: &Target) -> bool {
        let goal = match target {
            Target::Pose(X_WT) => X_WT.translation.vector,
            Target::Point(p) => *p,
        };
        (goal - self.shoulder()).norm() <= self.length() + AT_POINT
    }

    /// Returns how far the tool can be from the shoulder at most [m].
    fn length(&self) -> f64 {
        let joints = self.joints.iter().map(|j| &self.tree.joints[*j]);
        let mut length = self.arm.X_LT.translation.vector.norm();
        let mut after_shoulder = false;
        for joint in joints {
            if after_shoulder {
                length += joint.X_PJ.translation.vector.norm();
            }
            if let (JointKind::Prismatic, Some(drive)) = (joint.kind, joint.drive) {
                let dof = &self.tree.dofs[drive.dof];
                length += (dof.lower * drive.scale + drive.offset)
                    .abs()
                    .max((dof.upper * drive.scale + drive.offset).abs());
            }
            after_shoulder |= joint.drive.is_some();
        }
        length
    }

    /// Returns the `index`-th seed: where the arm is, the middle of its limits, then a Halton sequence.
    fn seed(&self, q: &[f64], index: usize) -> Vec<f64> {
        const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
        let mut q = q.to_vec();
        for (i, dof) in self.arm.dofs.iter().enumerate() {
            let limits = &self.tree.dofs[*dof];
            let lower = limits.lower.max(-std::f64::consts::PI);
            let upper = limits.upper.min(std::f64::consts::PI);
            // Bases beyond the list repeat, shifted: good enough for arms of more than twelve joints.
            let t = if index == 1 {
                0.5
            } else {
                halton(index + i / PRIMES.len(), PRIMES[i % PRIMES.len()])
            };
            if index > 0 && lower < upper {
                q[*dof] = lower + t * (upper - lower);
            }
        }
        q
    }

    /// Returns a configuration within [`NEAR`] of another.
    fn near(&self, q: &[f64], index: usize) -> Vec<f64> {
        let spread = self.seed(q, index.max(2));
        let mut near = q.to_vec();
        for dof in &self.arm.dofs {
            let limits = &self.tree.dofs[*dof];
            let step = (spread[*dof] - q[*dof]).clamp(-NEAR, NEAR);
            near[*dof] = (q[*dof] + step).max(limits.lower).min(limits.upper);
        }
        near
    }

    /// Returns the tool's pose and, by joint that moves, its dof and the tool's velocity per unit of it.
    fn forward(&self, q: &[f64]) -> (Pose, Vec<(usize, Vector6<f64>)>) {
        let mut X = self.X_WK;
        let mut axes = Vec::with_capacity(self.joints.len());
        for joint in self.joints.iter().map(|j| &self.tree.joints[*j]) {
            X *= joint.X_PJ;
            let Some(drive) = joint.drive else {
                continue;
            };
            let value = q[drive.dof] * drive.scale + drive.offset;
            let axis = X.rotation * joint.axis;
            axes.push((drive, joint.kind, axis, X.translation.vector));
            match joint.kind {
                JointKind::Fixed => {}
                JointKind::Revolute => {
                    let axis = nalgebra::Unit::new_normalize(joint.axis);
                    X.rotation *= nalgebra::UnitQuaternion::from_axis_angle(&axis, value);
                }
                JointKind::Prismatic => X.translation.vector += axis * value,
            }
        }
        let X_WT = X * self.arm.X_LT;
        let p = X_WT.translation.vector;
        let columns = axes.into_iter().map(|(drive, kind, axis, origin)| {
            let (v, w) = match kind {
                JointKind::Fixed => (Vec3::zeros(), Vec3::zeros()),
                JointKind::Revolute => (axis.cross(&(p - origin)), axis),
                JointKind::Prismatic => (axis, Vec3::zeros()),
            };
            let column = Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z);
            (drive.dof, column * drive.scale)
        });
        (X_WT, columns.collect())
    }

    /// Descends from a seed; returns the full configuration at the target.
    fn descend(&self, mut q: Vec<f64>, target: &Target) -> Option<Vec<f64>> {
        for _ in 0..ITERATIONS {
            let (X_WT, columns) = self.forward(&q);
            let error = match target {
                Target::Pose(X) => {
                    let v = X.translation.vector - X_WT.translation.vector;
                    let w = (X.rotation * X_WT.rotation.inverse()).scaled_axis();
                    if v.norm() <= AT_POSE.0 && w.norm() <= AT_POSE.1 {
                        return Some(q);
                    }
                    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
                }
                Target::Point(p) => {
                    let v = p - X_WT.translation.vector;
                    // A solver that stops at the very tolerance is right, too.
                    if v.norm() <= AT_POINT + 1e-6 {
                        return Some(q);
                    }
                    Vector6::new(v.x, v.y, v.z, 0.0, 0.0, 0.0)
                }
            };
            let mut J = Matrix6xX::zeros(self.arm.dofs.len());
            for (dof, mut column) in columns {
                if let Target::Point(_) = target {
                    column.fixed_rows_mut::<3>(3).fill(0.0);
                }
                if let Some(i) = self.arm.dofs.iter().position(|d| *d == dof) {
                    let mut sum = J.column_mut(i);
                    sum += column;
                }
            }
            self.step(&mut q, J, &error)?;
        }
        None
    }

    /// Takes one damped step; joints that would leave their limits are left out of a second solution.
    fn step(&self, q: &mut [f64], mut J: Matrix6xX<f64>, error: &Vector6<f64>) -> Option<()> {
        for pass in 0..2 {
            let A = &J * J.transpose() + Matrix6::identity() * (DAMPING * DAMPING);
            let dq = J.transpose() * A.cholesky()?.solve(error);
            let scale = (LONGEST / dq.amax().max(LONGEST)).min(1.0);
            let mut stuck = false;
            if pass == 0 {
                for (i, dof) in self.arm.dofs.iter().enumerate() {
                    let limits = &self.tree.dofs[*dof];
                    let next = q[*dof] + scale * dq[i];
                    if next < limits.lower || next > limits.upper {
                        J.column_mut(i).fill(0.0);
                        stuck = true;
                    }
                }
            }
            if !stuck {
                for (i, dof) in self.arm.dofs.iter().enumerate() {
                    let limits = &self.tree.dofs[*dof];
                    q[*dof] = (q[*dof] + scale * dq[i]).max(limits.lower).min(limits.upper);
                }
                return Some(());
            }
        }
        None
    }
}

/// Returns the `index`-th number of the Halton sequence of that base, in (0, 1).
fn halton(index: usize, base: usize) -> f64 {
    let (mut fraction, mut x, mut i) = (1.0, 0.0, index.max(1));
    while i > 0 {
        fraction /= base as f64;
        x += fraction * (i % base) as f64;
        i /= base;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::kinematics::{Dof, Drive, Joint};

    /// Seven revolute joints about z, y, x in turn, with limits, as arms have them; the last two share a point.
    fn arm() -> (Tree, Arm) {
        let mut tree = Tree {
            links: vec!["base".to_owned()],
            ..Tree::default()
        };
        let axes = [
            Vec3::z(),
            Vec3::y(),
            Vec3::x(),
            Vec3::y(),
            Vec3::x(),
            Vec3::y(),
            Vec3::x(),
        ];
        let lengths = [0.1, 0.1, 0.0, 0.4, 0.0, 0.32, 0.0];
        for (i, (axis, length)) in axes.into_iter().zip(lengths).enumerate() {
            tree.links.push(format!("link{i}"));
            tree.joints.push(Joint {
                name: format!("joint{i}"),
                kind: JointKind::Revolute,
                parent: i,
                X_PJ: Pose::translation(length, 0.0, 0.02),
                axis,
                drive: Some(Drive {
                    dof: i,
                    scale: 1.0,
                    offset: 0.0,
                }),
            });
            tree.dofs.push(Dof {
                name: format!("joint{i}"),
                lower: -1.8 - 0.1 * i as f64,
                upper: 2.0,
                max_velocity: 1.0,
                max_acceleration: 1.0,
                max_jerk: 10.0,
            });
        }
        let arm = Arm {
            name: "right".to_owned(),
            base_link: 0,
            tip_link: 7,
            X_LT: Pose::translation(0.15, 0.0, 0.0),
            dofs: (0..7).collect(),
            gripper: None,
            hand_links: vec![7],
        };
        (tree, arm)
    }

    fn chain<'a>(tree: &'a Tree, arm: &'a Arm, X_WB: &Pose) -> Chain<'a> {
        let X_WL = tree.link_poses(X_WB, &[0.0; 7]);
        Chain::new(tree, arm, &X_WL).expect("the tip hangs on the base")
    }

    #[test]
    fn forward_kinematics_agree_with_those_of_the_tree() {
        let (tree, arm) = arm();
        let X_WB = crate::geom::pose_xyz_rpy([1.0, 2.0, 0.5], [0.1, -0.2, 0.7]);
        let chain = chain(&tree, &arm, &X_WB);
        for i in 2..60 {
            let q = chain.seed(&[0.0; 7], i);
            let expected = tree.link_poses(&X_WB, &q)[7] * arm.X_LT;
            let (X_WT, columns) = chain.forward(&q);
            assert!((expected.to_matrix() - X_WT.to_matrix()).amax() < 1e-12);
            for (dof, column) in columns {
                let mut moved = q.clone();
                moved[dof] += 1e-6;
                let (X_WM, _) = chain.forward(&moved);
                let v = (X_WM.translation.vector - X_WT.translation.vector) / 1e-6;
                let w = (X_WM.rotation * X_WT.rotation.inverse()).scaled_axis() / 1e-6;
                let difference = column - Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z);
                assert!(difference.norm() < 1e-5, "dof {dof}: off by {difference}");
            }
        }
    }

    #[test]
    fn what_the_arm_reaches_is_found() {
        let (tree, arm) = arm();
        let chain = chain(&tree, &arm, &Pose::identity());
        let mut most = 0;
        for i in 0..60 {
            let (X_WT, _) = chain.forward(&chain.seed(&[0.0; 7], 1000 + 7 * i));
            let target = Target::Pose(X_WT);
            assert!(chain.could_reach(&target));
            let found = (0..100).find_map(|r| {
                let q = chain.descend(chain.seed(&[0.0; 7], r), &target)?;
                let inside = tree.dofs.iter().zip(&q).all(|(d, q)| d.lower <= *q && *q <= d.upper);
                assert!(inside, "outside of the limits");
                Some(r)
            });
            most = most.max(found.expect("a pose that the arm has is found within 100 restarts"));
        }
        assert!(most < 50, "{most} restarts needed: the budget of 100 is too near");
    }

    #[test]
    fn what_is_too_far_is_said_to_be() {
        let (tree, arm) = arm();
        let chain = chain(&tree, &arm, &Pose::identity());
        assert!(!chain.could_reach(&Target::Point(Vec3::new(1.4, 0.0, 0.0))));
        assert!(chain.could_reach(&Target::Point(Vec3::new(1.0, 0.0, 0.0))));
    }
}
