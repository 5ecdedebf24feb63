//! The joint space of one arm in a world state: which of its configurations are free.
//!
//! Only what the arm moves is recomputed for each configuration: its links, its fingers, what it holds.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::prepared::{Owner, Placed, Prepared, link_poses, overlap, place_all};
use crate::geom::Pose;
use crate::geom::collide::Solid;
use crate::geom::kinematics::Dof;
use crate::geom::motion::Space;
use crate::world::{Scene, State};

/// How close bodies may come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clearance {
    /// Free motions and where they end: a margin to everything.
    Margin,
    /// Contact motions: the hand may come to the object that is handled, a held object may slide along its support.
    Contact,
}

/// A moving body: a link of the arm, or a part of the held object.
struct Moving<'a> {
    owner: Owner,
    /// Link whose pose carries it.
    link: usize,
    /// Against the rest of the world, and against the agent itself.
    solid: &'a Solid,
    self_solid: &'a Solid,
    exact: &'a Solid,
    /// Pose of its shape in that link's frame.
    X_LS: Pose,
    /// Indices of obstacles that it already comes near to at the start: for these the exact shape is tested.
    near_at_start: Vec<usize>,
    is_hand: bool,
}

/// Checks configurations of one arm against everything.
pub(super) struct ArmSpace<'a> {
    pub scene: &'a Scene,
    prepared: &'a Prepared,
    agent: usize,
    arm: usize,
    /// Full configuration of the agent; the arm's entries are overwritten by each check.
    q: Vec<f64>,
    X_WL: Vec<Pose>,
    moving: Vec<Moving<'a>>,
    obstacles: Vec<Placed<'a>>,
    /// Pairs of `moving` that may collide with each other.
    inner_pairs: Vec<(usize, usize)>,
    /// Obstacle by obstacle, whether the moving bodies have to avoid it, by (moving, obstacle).
    pairs: Vec<(usize, usize)>,
    /// The object that the hand may touch.
    handled: Option<usize>,
    /// The last collision found.
    pub hit: Option<(Owner, Owner)>,
    /// Configurations checked.
    pub checks: u64,
}

impl<'a> ArmSpace<'a> {
    /// Prepares the checks of `arm` in `state`; with [`Clearance::Contact`] the hand may touch `handled`.
    pub(super) fn new(
        scene: &'a Scene,
        prepared: &'a Prepared,
        state: &State,
        agent: usize,
        arm: usize,
        handled: Option<usize>,
        clearance: Clearance,
    ) -> Self {
        let (body, ready) = (&scene.agents[agent], &prepared.agents[agent]);
        let moved = &ready.arms[arm].moved;
        let held: Vec<usize> = (0..state.objects.len())
            .filter(|o| {
                state.objects[*o]
                    .held
                    .as_ref()
                    .is_some_and(|h| h.agent == agent && h.arm == arm)
            })
            .collect();
        let X_WL_all = link_poses(scene, state);
        let is_moving = |owner: Owner| match owner {
            Owner::Link { agent: a, link } => a == agent && moved.contains(&link),
            Owner::Object(o) => held.contains(&o),
        };
        let obstacles = place_all(prepared, state, &X_WL_all, &is_moving);
        let mut moving = Vec::new();
        for part in ready.parts.iter().filter(|p| moved.contains(&p.link)) {
            let margin = clearance == Clearance::Margin;
            moving.push(Moving {
                owner: Owner::Link { agent, link: part.link },
                link: part.link,
                solid: if margin { &part.padded } else { &part.exact },
                self_solid: &part.self_padded,
                exact: &part.exact,
                X_LS: part.X_FS,
                near_at_start: Vec::new(),
                is_hand: body.arms[arm].hand_links.contains(&part.link),
            });
        }
        for object in &held {
            let Some(held) = &state.objects[*object].held else {
                continue;
            };
            let X_LO = body.arms[arm].X_LT * held.X_TO;
            for part in &prepared.objects[*object] {
                let margin = clearance == Clearance::Margin;
                moving.push(Moving {
                    owner: Owner::Object(*object),
                    link: body.arms[arm].tip_link,
                    solid: if margin { &part.padded } else { &part.resting },
                    self_solid: &part.self_padded,
                    exact: &part.resting,
                    X_LS: X_LO * part.X_FS,
                    near_at_start: Vec::new(),
                    is_hand: false,
                });
            }
        }
        let mut space = ArmSpace {
            scene,
            prepared,
            agent,
            arm,
            q: state.agents[agent].q.clone(),
            X_WL: X_WL_all[agent].clone(),
            moving,
            obstacles,
            inner_pairs: Vec::new(),
            pairs: Vec::new(),
            handled: if clearance == Clearance::Contact { handled } else { None },
            hit: None,
            checks: 0,
        };
        space.choose_pairs();
        space.tolerate_start();
        space
    }

    /// Lists the pairs that must not overlap.
    fn choose_pairs(&mut self) {
        let may_touch = &self.scene.agents[self.agent].may_touch;
        let allowed = |a: &Moving<'_>, b: Owner, b_is_hand: bool| match (a.owner, b) {
            (Owner::Link { link: l, .. }, Owner::Link { agent, link: m }) => {
                agent == self.agent && (l == m || may_touch.contains(&(l.min(m), l.max(m))))
            }
            // The holder's hand touches what it holds; the hand may come to what it is going to take.
            (Owner::Object(_), Owner::Link { agent, .. }) => agent == self.agent && b_is_hand,
            (Owner::Link { .. }, Owner::Object(o)) => a.is_hand && self.handled == Some(o),
            (Owner::Object(o), Owner::Object(p)) => o == p,
        };
        let arm = &self.prepared.agents[self.agent].arms[self.arm];
        // What the arm moves stays within a sphere about the shoulder.
        let p_WShoulder = self.X_WL[arm.shoulder_link].translation.vector;
        for (i, a) in self.moving.iter().enumerate() {
            let sweep =
                arm.link_reach[a.link] + a.X_LS.translation.vector.norm() + a.solid.radius().max(a.self_solid.radius());
            for (j, b) in self.moving.iter().enumerate().skip(i + 1) {
                let held_in_hand = matches!(b.owner, Owner::Object(_)) && a.is_hand;
                if !held_in_hand && !allowed(a, b.owner, b.is_hand) {
                    self.inner_pairs.push((i, j));
                }
            }
            for (j, b) in self.obstacles.iter().enumerate() {
                let apart = (b.X_WS.translation.vector - p_WShoulder).norm() - b.solid.radius();
                if apart <= sweep && !allowed(a, b.owner, false) {
                    self.pairs.push((i, j));
                }
            }
        }
    }

    /// Where a body is within the margin already at the start, the motion may leave: the exact shape is tested there.
    fn tolerate_start(&mut self) {
        for (i, j) in &self.pairs {
            let a = &self.moving[*i];
            let X_WA = self.X_WL[a.link] * a.X_LS;
            if overlap(a.solid, &X_WA, self.obstacles[*j].solid, &self.obstacles[*j].X_WS) {
                self.moving[*i].near_at_start.push(*j);
            }
        }
    }

    /// Returns the arm's configuration in the state that the space was made for.
    pub(super) fn start(&self) -> Vec<f64> {
        self.prepared.agents[self.agent].arms[self.arm]
            .chain
            .dof_indices()
            .iter()
            .map(|d| self.q[*d])
            .collect()
    }

    /// Sets other joints of the agent (fingers).
    pub(super) fn set_dofs(&mut self, dofs: &[usize], values: &[f64]) {
        for (dof, value) in dofs.iter().zip(values) {
            self.q[*dof] = *value;
        }
    }

    /// Says whether the arm is free at `q` (chain order); else remembers what hit what in `hit`.
    pub(super) fn check(&mut self, q: &[f64]) -> bool {
        self.checks += 1;
        let arm = &self.prepared.agents[self.agent].arms[self.arm];
        for (dof, value) in arm.chain.dof_indices().iter().zip(q) {
            self.q[*dof] = *value;
        }
        self.scene.agents[self.agent]
            .tree
            .update_links(&arm.moved, &self.q, &mut self.X_WL);
        self.hit = self.first_hit();
        self.hit.is_none()
    }

    fn first_hit(&self) -> Option<(Owner, Owner)> {
        let placed: Vec<Pose> = self.moving.iter().map(|m| self.X_WL[m.link] * m.X_LS).collect();
        for (i, j) in &self.pairs {
            let (a, b) = (&self.moving[*i], &self.obstacles[*j]);
            let own = matches!(b.owner, Owner::Link { agent, .. } if agent == self.agent);
            let solid = if a.near_at_start.contains(j) {
                a.exact
            } else if own {
                a.self_solid
            } else {
                a.solid
            };
            if overlap(solid, &placed[*i], b.solid, &b.X_WS) {
                return Some((a.owner, b.owner));
            }
        }
        for (i, j) in &self.inner_pairs {
            let (a, b) = (&self.moving[*i], &self.moving[*j]);
            if overlap(a.self_solid, &placed[*i], b.exact, &placed[*j]) {
                return Some((a.owner, b.owner));
            }
        }
        None
    }

    /// Says whether the hand alone, with its tool at `X_WT` and its fingers as they are, is free; a cheap test before any
    /// inverse kinematics. What the hand holds goes with it.
    pub(super) fn hand_is_free(&mut self, X_WT: &Pose) -> bool {
        let arm = &self.scene.agents[self.agent].arms[self.arm];
        // Links of the hand keep their places relative to the tip while only the arm's joints differ.
        let X_WTip = X_WT * arm.X_LT.inverse();
        let X_TipW = self.X_WL[arm.tip_link].inverse();
        for (i, j) in &self.pairs {
            let (a, b) = (&self.moving[*i], &self.obstacles[*j]);
            let own = matches!(b.owner, Owner::Link { agent, .. } if agent == self.agent);
            if own || !(a.is_hand || matches!(a.owner, Owner::Object(_))) {
                continue;
            }
            let X_WA = X_WTip * (X_TipW * self.X_WL[a.link] * a.X_LS);
            if overlap(a.exact, &X_WA, b.solid, &b.X_WS) {
                self.hit = Some((a.owner, b.owner));
                return false;
            }
        }
        true
    }

    /// Returns the names of the last collision's bodies.
    pub(super) fn hit_names(&self) -> Option<(String, String)> {
        self.hit.map(|(a, b)| (a.name(self.scene), b.name(self.scene)))
    }
}

impl Space for ArmSpace<'_> {
    fn dofs(&self) -> &[Dof] {
        self.prepared.agents[self.agent].arms[self.arm].chain.dofs()
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        self.check(q)
    }
}
