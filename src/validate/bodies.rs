//! Where every body is, and which two overlap: every pair, one by one, behind nothing but a test of bounding spheres.
//!
//! No broad phase, no cache and no shared scene with the planner; only the exact pair queries of `geom::collide` are common.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use crate::geom::{
    Pose, Vec3,
    collide::{self, Solid},
};
use crate::world::{Scene, State};

/// Whose body it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owner {
    Link { agent: usize, link: usize },
    Object(usize),
}

/// A solid somewhere in the world.
pub(super) struct Placed<'a> {
    pub(super) owner: Owner,
    pub(super) solid: &'a Solid,
    pub(super) X_WS: Pose,
}

/// Two bodies that overlap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    pub(super) a: Owner,
    pub(super) b: Owner,
    /// [m]
    pub(super) depth: f64,
}

/// A hand and the object that it may touch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touching {
    pub(super) agent: usize,
    pub(super) arm: usize,
    pub(super) object: usize,
}

/// All solids of a scene.
pub(super) struct Bodies<'w> {
    pub(super) scene: &'w Scene,
    /// By agent, by `Agent::bodies`.
    agents: Vec<Vec<Solid>>,
    /// By object, by `Object::parts`.
    objects: Vec<Vec<Solid>>,
}

impl<'w> Bodies<'w> {
    pub(super) fn new(scene: &'w Scene) -> Self {
        let agents = scene.agents.iter();
        let objects = scene.objects.iter();
        Bodies {
            scene,
            agents: agents
                .map(|a| a.bodies.iter().map(|b| Solid::new(&b.shape)).collect())
                .collect(),
            objects: objects
                .map(|o| o.parts.iter().map(|p| Solid::new(&p.shape)).collect())
                .collect(),
        }
    }

    /// Returns the body's name, `PR2/l_forearm` or `TABLE`.
    pub(super) fn name(&self, owner: Owner) -> String {
        match owner {
            Owner::Link { agent, link } => {
                let agent = &self.scene.agents[agent];
                format!("{}/{}", agent.id, agent.tree.links[link])
            }
            Owner::Object(o) => self.scene.objects[o].id.clone(),
        }
    }

    /// Returns the poses of an agent's links in the world.
    pub(super) fn links(&self, state: &State, agent: usize) -> Vec<Pose> {
        let at = &state.agents[agent];
        self.scene.agents[agent].tree.link_poses(&at.X_WB, &at.q)
    }

    /// Returns the pose of the arm's tool in the world.
    pub(super) fn tool(&self, state: &State, agent: usize, arm: usize) -> Pose {
        let arm = &self.scene.agents[agent].arms[arm];
        self.links(state, agent)[arm.tip_link] * arm.X_LT
    }

    /// Moves the objects that the agent holds to where its tools are.
    pub(super) fn carry(&self, state: &mut State, agent: usize) {
        let X_WL = self.links(state, agent);
        for object in &mut state.objects {
            if let Some(held) = object.held.as_ref().filter(|h| h.agent == agent) {
                let arm = &self.scene.agents[agent].arms[held.arm];
                object.X_WO = X_WL[arm.tip_link] * arm.X_LT * held.X_TO;
            }
        }
    }

    /// Returns the bodies of an object.
    pub(super) fn object(&self, state: &State, object: usize) -> Vec<Placed<'_>> {
        let X_WO = state.objects[object].X_WO;
        let parts = self.scene.objects[object].parts.iter().zip(&self.objects[object]);
        parts
            .map(|(p, solid)| Placed {
                owner: Owner::Object(object),
                solid,
                X_WS: X_WO * p.X_OS,
            })
            .collect()
    }

    /// Returns the bodies of an agent, without what it holds.
    pub(super) fn agent(&self, state: &State, agent: usize) -> Vec<Placed<'_>> {
        let X_WL = self.links(state, agent);
        let bodies = self.scene.agents[agent].bodies.iter().zip(&self.agents[agent]);
        bodies
            .map(|(b, solid)| Placed {
                owner: Owner::Link { agent, link: b.link },
                solid,
                X_WS: X_WL[b.link] * b.X_LS,
            })
            .collect()
    }

    /// Returns the agent's bodies and those of what it holds.
    pub(super) fn moving(&self, state: &State, agent: usize) -> Vec<Placed<'_>> {
        let mut all = self.agent(state, agent);
        for o in 0..state.objects.len() {
            if held_by(state, o, agent).is_some() {
                all.extend(self.object(state, o));
            }
        }
        all
    }

    /// Returns the bodies of everything else.
    pub(super) fn standing(&self, state: &State, agent: usize) -> Vec<Placed<'_>> {
        let mut all = Vec::new();
        for other in (0..state.agents.len()).filter(|a| *a != agent) {
            all.extend(self.agent(state, other));
        }
        for o in 0..state.objects.len() {
            if held_by(state, o, agent).is_none() {
                all.extend(self.object(state, o));
            }
        }
        all
    }

    /// Says whether two bodies may overlap: one body's parts, neighbouring links, a hand and what it holds or takes.
    pub(super) fn may_touch(&self, state: &State, a: Owner, b: Owner, touching: Option<Touching>) -> bool {
        match (a, b) {
            (Owner::Link { agent, link }, Owner::Link { agent: other, link: l }) if agent == other => {
                link == l || self.scene.agents[agent].may_touch.contains(&(link.min(l), link.max(l)))
            }
            (Owner::Object(a), Owner::Object(b)) => a == b,
            (Owner::Link { agent, link }, Owner::Object(o)) | (Owner::Object(o), Owner::Link { agent, link }) => {
                let hand = |arm: usize| self.scene.agents[agent].arms[arm].hand_links.contains(&link);
                let held = held_by(state, o, agent).is_some_and(hand);
                held || touching.is_some_and(|t| t.agent == agent && t.object == o && hand(t.arm))
            }
            (Owner::Link { .. }, Owner::Link { .. }) => false,
        }
    }

    /// Returns the deepest overlap of more than `tolerance` [m] among the moving bodies and between them and the standing
    /// ones; adds the number of pairs looked at to `pairs`.
    pub(super) fn contact(
        &self,
        state: &State,
        moving: &[Placed<'_>],
        standing: &[Placed<'_>],
        touching: Option<Touching>,
        tolerance: f64,
        pairs: &mut u64,
    ) -> Option<Contact> {
        let mut deepest: Option<Contact> = None;
        for (i, a) in moving.iter().enumerate() {
            for b in moving[i + 1..].iter().chain(standing) {
                *pairs += 1;
                if apart(a, b) || self.may_touch(state, a.owner, b.owner, touching) {
                    continue;
                }
                if let Some(depth) = collide::penetration(a.solid, &a.X_WS, b.solid, &b.X_WS)
                    && depth > tolerance
                    && deepest.is_none_or(|c| c.depth < depth)
                {
                    deepest = Some(Contact {
                        a: a.owner,
                        b: b.owner,
                        depth,
                    });
                }
            }
        }
        deepest
    }

    /// Returns the distance along the ray to the first body that `blocks`, if nearer than `max` [m].
    pub(super) fn ray(
        placed: &[Placed<'_>],
        p_WR: &Vec3,
        direction: &Vec3,
        max: f64,
        blocks: &dyn Fn(Owner) -> bool,
    ) -> Option<f64> {
        let hits = placed.iter().filter(|p| blocks(p.owner));
        hits.filter_map(|p| collide::ray(p.solid, &p.X_WS, p_WR, direction, max))
            .min_by(f64::total_cmp)
    }
}

/// Says whether the bounding spheres are apart.
fn apart(a: &Placed<'_>, b: &Placed<'_>) -> bool {
    let between = a.X_WS.translation.vector - b.X_WS.translation.vector;
    let reach = a.solid.radius() + b.solid.radius();
    between.norm_squared() > reach * reach
}

/// Returns the arm with which the agent holds the object.
pub(super) fn held_by(state: &State, object: usize, agent: usize) -> Option<usize> {
    let held = state.objects[object].held.as_ref()?;
    (held.agent == agent).then_some(held.arm)
}
