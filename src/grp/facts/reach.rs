//! isReachable: an arm of the agent, all else as it is, has a configuration without collision at the object.
//!
//! Inverse kinematics is tried from the arm's own configuration and from random ones. Which configurations are tried follows from the agent's
//! configuration and from where the object is relative to it: never from what is in the way, which only refuses some of them. So a new
//! obstacle can only make the fact false, and one that goes can only make it true; [`Reach`] says which ones matter.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::super::arm_space::{ArmSpace, Clearance};
use super::super::candidates::can_hold;
use super::super::key::Key;
use super::super::prepared::{Owner, Prepared, PreparedArm};
use super::{has_in_hand, is_full};
use crate::geom::collide::ray;
use crate::geom::{Pose, Vec3, ik};
use crate::world::{Grasp, Gripper, Scene, State};

/// How near a bare hand's tool point must come to the object's surface [m]. The validator allows twice as much: it has an
/// inverse kinematics of its own, and a stretched arm is where two of them differ.
const TOUCH: f64 = 0.005;

/// Budget of one inverse kinematics call.
const IK: ik::Settings = ik::Settings {
    max_iterations: 60,
    restarts: 30,
    position_tolerance: 1e-4,
    rotation_tolerance: 1e-3,
};

/// The random tries of a first round over all grasps: mostly one of them is easy.
const FIRST_RESTARTS: u32 = 3;

/// How far the frame of the last moving link may be from where a solution has it [m]: the tolerances above, at the end of a long hand.
const SLACK: f64 = 2e-3;

/// What one arm can do about an object.
#[derive(Debug, Clone)]
pub(super) enum Reach {
    /// It has a configuration without collision.
    Free {
        /// Of the agent's bodies, those that the arm moves: positions among the agent's parts, and X_WS.
        bodies: Vec<(usize, Pose)>,
        /// The grasp's position; `None` for a bare hand.
        grasp: Option<usize>,
    },
    /// It has none, for each grasp (the only one of a bare hand) why.
    Blocked(Vec<Obstacle>),
}

/// Why an arm does not come to a grasp.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Obstacle {
    /// The gripper does not open so wide.
    Wide,
    /// The arm is too short, by so much at least [m].
    Far(f64),
    /// The hand, at the grasp, hits it.
    Hand(Owner, Owner),
    /// No configuration was found; the best try was so far off [m].
    Unsolved(f64),
    /// The configurations that were found hit these.
    Arm(Vec<(Owner, Owner)>),
}

/// Says whether an arm of the agent, its base and its other joints as they are, has a collision-free configuration at the object:
/// a robot's gripper, open, at one of the object's grasps; a human's palm at the surface, where the way from the arm's first joint to the centre enters it.
/// What an agent holds itself is not reachable to it.
pub(in crate::grp) fn is_reachable(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    object: usize,
    agent: usize,
    seed: u64,
) -> bool {
    !has_in_hand(state, agent, object)
        && (0..scene.agents[agent].arms.len()).any(|arm| {
            // A full hand cannot take another object.
            !is_full(state, agent, arm)
                && matches!(
                    reach(scene, prepared, state, object, agent, arm, seed),
                    Reach::Free { .. }
                )
        })
}

/// Returns whether the arm, whose hand is empty, comes to the object, and what that rests on.
pub(super) fn reach(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    object: usize,
    agent: usize,
    arm: usize,
    seed: u64,
) -> Reach {
    let stream = Key::new(seed)
        .text("isReachable")
        .number(object as u64)
        .number(agent as u64);
    let (body, at) = (&scene.agents[agent], &state.agents[agent]);
    let X_WL = body.tree.link_poses(&at.X_WB, &at.q);
    let limb = Limb {
        scene,
        prepared,
        state,
        object,
        agent,
        arm,
        stream,
        p_WShoulder: X_WL[prepared.agents[agent].arms[arm].shoulder_link].translation.vector,
        X_KW: X_WL[body.arms[arm].base_link].inverse(),
    };
    match body.gripper_to_reach_with(arm) {
        Some(gripper) => limb.gripper_reaches(gripper),
        None => limb.hand_reaches(),
    }
}

/// An arm and the object that it shall come to.
struct Limb<'a> {
    scene: &'a Scene,
    prepared: &'a Prepared,
    state: &'a State,
    object: usize,
    agent: usize,
    arm: usize,
    stream: Key,
    p_WShoulder: Vec3,
    /// K is the frame of the arm's base link.
    X_KW: Pose,
}

impl Limb<'_> {
    fn ready(&self) -> &PreparedArm {
        &self.prepared.agents[self.agent].arms[self.arm]
    }

    /// Returns the random restarts of one arm at one grasp: the same for each and in every world state, whatever others needed
    /// before. So the fact changes only where something in the way has moved.
    fn tries(&self) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(self.stream.0)
    }

    /// Returns the bodies that the arm moves when it is at `q` (chain order) and its other joints are as in `state`.
    fn bodies(&self, state: &State, q: &[f64]) -> Vec<(usize, Pose)> {
        let (body, ready) = (&self.scene.agents[self.agent], self.ready());
        let mut all = state.agents[self.agent].q.clone();
        for (dof, value) in ready.chain.dof_indices().iter().zip(q) {
            all[*dof] = *value;
        }
        let X_WL = body.tree.link_poses(&state.agents[self.agent].X_WB, &all);
        let parts = self.prepared.agents[self.agent].parts.iter().enumerate();
        parts
            .filter(|(_, p)| ready.moved.contains(&p.link))
            .map(|(i, p)| (i, X_WL[p.link] * p.X_FS))
            .collect()
    }

    /// Returns by how much the arm is too short for its tool at `X_WT` [m], if that is sure: neither the tool nor the frame of the last
    /// link that the arm moves can be farther from the shoulder than the links between them are long.
    fn too_short(&self, X_WT: &Pose, X_TLast: &Pose, last_reach: f64) -> Option<f64> {
        let tool = (X_WT.translation.vector - self.p_WShoulder).norm() - self.ready().reach;
        let last = ((X_WT * X_TLast).translation.vector - self.p_WShoulder).norm() - last_reach - SLACK;
        let lacking = tool.max(last);
        (lacking > 0.0).then_some(lacking)
    }

    /// Returns the pose of the last link that the arm's joints move, in the tool's frame, and how far its frame can be from the shoulder [m].
    fn last_link(&self) -> (Pose, f64) {
        let (body, ready) = (&self.scene.agents[self.agent], self.ready());
        let arm = &body.arms[self.arm];
        let mut X_LastTip = Pose::identity();
        let mut link = arm.tip_link;
        // Up to the first joint that moves; what it moves is the last link.
        while link != arm.base_link && link > 0 && body.tree.joints[link - 1].drive.is_none() {
            let joint = &body.tree.joints[link - 1];
            X_LastTip = joint.X_PJ * X_LastTip;
            link = joint.parent;
        }
        ((X_LastTip * arm.X_LT).inverse(), ready.link_reach[link])
    }

    fn gripper_reaches(&self, gripper: &Gripper) -> Reach {
        let grasps: &[Grasp] = &self.scene.objects[self.object].grasps;
        let X_WO = &self.state.objects[self.object].X_WO;
        let (X_TLast, last_reach) = self.last_link();
        let mut why: Vec<Obstacle> = Vec::with_capacity(grasps.len());
        for grasp in grasps {
            why.push(if can_hold(gripper, grasp) {
                let lacking = self.too_short(&(X_WO * grasp.X_OT), &X_TLast, last_reach);
                lacking.map_or(Obstacle::Unsolved(f64::INFINITY), Obstacle::Far)
            } else {
                Obstacle::Wide
            });
        }
        let is_open = |w: &Obstacle| matches!(w, Obstacle::Unsolved(_));
        if !why.iter().any(is_open) {
            return Reach::Blocked(why);
        }
        let mut open = self.state.clone();
        for (dof, value) in gripper.dofs.iter().zip(&gripper.open) {
            open.agents[self.agent].q[*dof] = *value;
        }
        let mut space = self.space(&open);
        for (grasp, why) in grasps.iter().zip(&mut why).filter(|(_, w)| is_open(w)) {
            if !space.hand_is_free(&(X_WO * grasp.X_OT))
                && let Some((a, b)) = space.hit()
            {
                *why = Obstacle::Hand(a, b);
            }
        }
        let seed = space.start();
        for restarts in [FIRST_RESTARTS, IK.restarts] {
            for (i, grasp) in grasps.iter().enumerate() {
                if !matches!(why[i], Obstacle::Unsolved(_) | Obstacle::Arm(_)) {
                    continue;
                }
                let target = ik::Target::Pose(self.X_KW * X_WO * grasp.X_OT);
                match self.solve(&mut space, &target, &seed, ik::Settings { restarts, ..IK }) {
                    Ok(q) => {
                        return Reach::Free {
                            bodies: self.bodies(&open, &q),
                            grasp: Some(i),
                        };
                    }
                    Err(obstacle) => why[i] = obstacle,
                }
            }
        }
        Reach::Blocked(why)
    }

    fn hand_reaches(&self) -> Reach {
        let X_WO = &self.state.objects[self.object].X_WO;
        let towards = X_WO.translation.vector - self.p_WShoulder;
        let far = towards.norm();
        if far < 1e-9 {
            return Reach::Blocked(vec![Obstacle::Unsolved(0.0)]);
        }
        // Where the way from the shoulder to the centre enters the object.
        let direction = towards / far;
        let entry = self.prepared.objects[self.object]
            .iter()
            .filter_map(|part| ray(&part.exact, &(X_WO * part.X_FS), &self.p_WShoulder, &direction, far))
            .fold(far, f64::min);
        if entry - TOUCH > self.ready().reach {
            return Reach::Blocked(vec![Obstacle::Far(entry - TOUCH - self.ready().reach)]);
        }
        let p_KT = self.X_KW * nalgebra::Point3::from(self.p_WShoulder + direction * entry);
        let settings = ik::Settings {
            position_tolerance: TOUCH,
            ..IK
        };
        let mut space = self.space(self.state);
        let seed = space.start();
        match self.solve(&mut space, &ik::Target::Point(p_KT.coords), &seed, settings) {
            Ok(q) => Reach::Free {
                bodies: self.bodies(self.state, &q),
                grasp: None,
            },
            Err(obstacle) => Reach::Blocked(vec![obstacle]),
        }
    }

    fn space<'s>(&'s self, state: &State) -> ArmSpace<'s> {
        let object = Some(self.object);
        ArmSpace::new(
            self.scene,
            self.prepared,
            state,
            self.agent,
            self.arm,
            object,
            Clearance::Contact,
        )
    }

    /// Returns a free configuration, or what the configurations that were found hit.
    fn solve(
        &self,
        space: &mut ArmSpace<'_>,
        target: &ik::Target,
        seed: &[f64],
        settings: ik::Settings,
    ) -> Result<Vec<f64>, Obstacle> {
        let mut hits = Vec::new();
        let solved = ik::solve(
            &self.ready().chain,
            target,
            seed,
            &settings,
            &mut self.tries(),
            &mut |q| {
                let is_free = space.check(q);
                if !is_free && let Some(hit) = space.hit().filter(|hit| !hits.contains(hit)) {
                    hits.push(hit);
                }
                is_free
            },
        );
        solved.map_err(|no_ik| {
            if hits.is_empty() {
                Obstacle::Unsolved(no_ik.position_error)
            } else {
                Obstacle::Arm(hits)
            }
        })
    }
}
