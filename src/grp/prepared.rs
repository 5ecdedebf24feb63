//! Shapes and chains of a scene, made ready once for fast yes/no tests.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::sync::Arc;

use crate::geom::checker::{Body, Rig};
use crate::geom::collide::{Solid, touch};
use crate::geom::cover::Form;
use crate::geom::kinematics::{Chain, Dof, Joint, JointKind};
use crate::geom::{Pose, Vec3};
use crate::world::{Agent, Arm, Scene, State};

/// Clearance that free motions keep from everything but the agent itself [m]. Checks of a path are spaced; between two
/// of them no body sinks in by more than this.
pub(super) const MARGIN: f64 = 0.005;
/// Clearance between the links of one agent [m].
pub(super) const SELF_MARGIN: f64 = 0.002;

/// A convex body fixed to a link or to an object.
#[derive(Debug)]
pub(super) struct Part {
    /// The link, for an agent's body.
    pub link: usize,
    pub exact: Solid,
    /// Grown by [`MARGIN`].
    pub padded: Solid,
    /// Grown by [`SELF_MARGIN`].
    pub self_padded: Solid,
    /// The exact shape with its cover.
    pub form: Arc<Form>,
    /// An object's, shrunk a little: what rests on its support touches it without hitting it. A link's as it is.
    pub resting: Arc<Form>,
    /// Pose of the shape in the link's or object's frame.
    pub X_FS: Pose,
}

/// An arm's chain and what it can do at most.
#[derive(Debug)]
pub(super) struct PreparedArm {
    pub chain: Chain,
    /// Longest distance from the arm's first joint to its tool point [m]; never below the truth.
    pub reach: f64,
    /// Link whose frame sits at the arm's first joint: the shoulder.
    pub shoulder_link: usize,
    /// By link: how far its frame can be from the shoulder [m]; of use for the links in `moved`.
    pub link_reach: Vec<f64>,
    /// Links that the arm's joints and fingers move, ascending.
    pub moved: Vec<usize>,
    /// The arm, its hand and fingers with their bodies.
    pub rig: Arc<Rig>,
}

/// An agent's bodies and arms.
#[derive(Debug)]
pub(super) struct PreparedAgent {
    pub parts: Vec<Part>,
    /// By position in `Agent::arms`.
    pub arms: Vec<PreparedArm>,
}

/// Everything that never changes, made ready.
#[derive(Debug)]
pub(super) struct Prepared {
    pub agents: Vec<PreparedAgent>,
    pub objects: Vec<Vec<Part>>,
}

/// How much a resting object is shrunk [m]; the validator tolerates 1 mm.
const RESTING: f64 = -0.0005;

impl Prepared {
    /// Makes the scene ready. An arm whose tip does not descend from its base is left out of the result's `arms`
    /// by an error naming it.
    pub(super) fn new(scene: &Scene) -> Result<Prepared, String> {
        let part = |link, shape: &_, X_FS: &Pose| {
            let form = Arc::new(Form::new(Solid::new(shape)));
            Part {
                link,
                exact: Solid::new(shape),
                padded: Solid::padded(shape, MARGIN),
                self_padded: Solid::padded(shape, SELF_MARGIN),
                resting: Arc::clone(&form),
                form,
                X_FS: *X_FS,
            }
        };
        let resting = |shape: &_, X_FS: &Pose| Part {
            resting: Arc::new(Form::new(Solid::padded(shape, RESTING))),
            ..part(0, shape, X_FS)
        };
        let mut agents = Vec::with_capacity(scene.agents.len());
        for agent in &scene.agents {
            let parts: Vec<Part> = agent.bodies.iter().map(|b| part(b.link, &b.shape, &b.X_LS)).collect();
            let mut arms = Vec::with_capacity(agent.arms.len());
            for arm in &agent.arms {
                let Some(chain) = Chain::new(&agent.tree, arm.base_link, arm.tip_link, &arm.X_LT) else {
                    return Err(format!("the {} arm of {} is no serial chain", arm.name, agent.id));
                };
                let fingers: &[usize] = arm.gripper.as_ref().map_or(&[], |g| &g.dofs);
                let moved = agent.tree.links_moved_by(&[&arm.dofs, fingers].concat());
                let bodies = parts.iter().filter(|p| moved.contains(&p.link)).map(|p| Body {
                    link: p.link,
                    X_LS: p.X_FS,
                    form: Arc::clone(&p.form),
                });
                let rig = Rig::new(&agent.tree, chain.dof_indices(), fingers, bodies.collect());
                let shoulder_link = shoulder_link(agent, arm);
                let reach = farthest(agent, shoulder_link, arm.tip_link) + arm.X_LT.translation.vector.norm();
                let link_reach = (0..agent.tree.links.len())
                    .map(|l| farthest(agent, shoulder_link, l))
                    .collect();
                arms.push(PreparedArm {
                    chain,
                    reach,
                    shoulder_link,
                    link_reach,
                    moved,
                    rig: Arc::new(rig),
                });
            }
            agents.push(PreparedAgent { parts, arms });
        }
        let objects = scene
            .objects
            .iter()
            .map(|o| o.parts.iter().map(|p| resting(&p.shape, &p.X_OS)).collect())
            .collect();
        Ok(Prepared { agents, objects })
    }
}

/// Returns the link that the arm's first moving joint moves.
fn shoulder_link(agent: &Agent, arm: &Arm) -> usize {
    let mut shoulder = arm.tip_link;
    let mut link = arm.tip_link;
    while link != arm.base_link && link > 0 {
        let joint = &agent.tree.joints[link - 1];
        if joint.drive.is_some() {
            shoulder = link;
        }
        link = joint.parent;
    }
    shoulder
}

/// Returns how far a link's frame can be at most from where the shoulder link's frame is now [m]: the sum of the joints' offsets
/// between them, and of all that sliding joints can slide.
fn farthest(agent: &Agent, shoulder: usize, mut link: usize) -> f64 {
    let slides = |joint: &Joint, length: fn(&Dof) -> f64| match joint.drive {
        Some(drive) if joint.kind == JointKind::Prismatic => {
            length(&agent.tree.dofs[drive.dof]) * drive.scale.abs() + drive.offset.abs()
        }
        _ => 0.0,
    };
    // The shoulder's own joint moves it from where it is now, every other joint moves its link from where it would be at 0.
    let own = shoulder.checked_sub(1).map(|j| &agent.tree.joints[j]);
    let mut far = own.map_or(0.0, |joint| slides(joint, |dof| dof.upper - dof.lower));
    while link != shoulder && link > 0 {
        let joint = &agent.tree.joints[link - 1];
        far += joint.X_PJ.translation.vector.norm() + slides(joint, |dof| dof.lower.abs().max(dof.upper.abs()));
        link = joint.parent;
    }
    far
}

/// A body at its place in the world.
#[derive(Debug)]
pub(super) struct Placed<'a> {
    pub solid: &'a Solid,
    /// The same with its cover.
    pub form: &'a Arc<Form>,
    pub X_WS: Pose,
    /// Who it is, for messages.
    pub owner: Owner,
}

/// Whose body it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owner {
    Link { agent: usize, link: usize },
    Object(usize),
}

impl Owner {
    /// Returns `PR2.r_gripper` or `TABLE`.
    pub(super) fn name(self, scene: &Scene) -> String {
        match self {
            Owner::Link { agent, link } => {
                let agent = &scene.agents[agent];
                format!("{}.{}", agent.id, agent.tree.links[link])
            }
            Owner::Object(object) => scene.objects[object].id.clone(),
        }
    }
}

/// Says whether bodies at these places overlap; spheres about their origins first.
pub(super) fn overlap(a: &Solid, X_WA: &Pose, b: &Solid, X_WB: &Pose) -> bool {
    let reach = a.radius() + b.radius();
    let between: Vec3 = X_WA.translation.vector - X_WB.translation.vector;
    between.norm_squared() <= reach * reach && touch(a, X_WA, b, X_WB)
}

/// Returns all link poses of every agent.
pub(super) fn link_poses(scene: &Scene, state: &State) -> Vec<Vec<Pose>> {
    scene
        .agents
        .iter()
        .zip(&state.agents)
        .map(|(a, s)| a.tree.link_poses(&s.X_WB, &s.q))
        .collect()
}

/// Returns every body but those of `without`, exact, at its place.
pub(super) fn place_all<'a>(
    prepared: &'a Prepared,
    state: &State,
    X_WL: &[Vec<Pose>],
    without: &dyn Fn(Owner) -> bool,
) -> Vec<Placed<'a>> {
    let mut all = Vec::new();
    for (agent, parts) in prepared.agents.iter().enumerate() {
        for part in &parts.parts {
            let owner = Owner::Link { agent, link: part.link };
            if !without(owner) {
                all.push(Placed {
                    solid: &part.exact,
                    form: &part.form,
                    X_WS: X_WL[agent][part.link] * part.X_FS,
                    owner,
                });
            }
        }
    }
    for (object, parts) in prepared.objects.iter().enumerate() {
        let owner = Owner::Object(object);
        if !without(owner) {
            let X_WO = state.objects[object].X_WO;
            all.extend(parts.iter().map(|p| Placed {
                solid: &p.exact,
                form: &p.form,
                X_WS: X_WO * p.X_FS,
                owner,
            }));
        }
    }
    all
}
