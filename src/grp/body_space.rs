//! The joint space of several joints of one agent at once, arms among them, in a world state: which of its configurations are free.
//!
//! For motions of the whole upper body; of one arm, `arm_space` knows more. What the joints move has a margin to everything else;
//! what is held goes with its hand.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::prepared::{Owner, Part, Placed, Prepared, link_poses, overlap, place_all};
use crate::geom::Pose;
use crate::geom::collide::Solid;
use crate::geom::kinematics::Dof;
use crate::geom::motion::Space;
use crate::world::{Scene, State};

/// A moving body: on a link, or in a hand.
struct Moving<'a> {
    owner: Owner,
    /// Link whose pose carries it, and its shape's pose in that link's frame.
    link: usize,
    X_LS: Pose,
    part: &'a Part,
    /// The arm that holds it.
    held_by: Option<usize>,
}

/// Checks configurations of some joints against everything.
pub(super) struct BodySpace<'a> {
    scene: &'a Scene,
    agent: usize,
    dofs: Vec<usize>,
    limits: Vec<Dof>,
    moved: Vec<usize>,
    q: Vec<f64>,
    X_WL: Vec<Pose>,
    moving: Vec<Moving<'a>>,
    obstacles: Vec<Placed<'a>>,
    /// A moving body as it is tested, and the obstacle.
    pairs: Vec<(usize, &'a Solid, usize)>,
    inner_pairs: Vec<(usize, usize)>,
    /// The last collision found.
    hit: Option<(Owner, Owner)>,
    /// Configurations checked.
    pub checks: u64,
}

impl<'a> BodySpace<'a> {
    /// Prepares the checks of the joints `dofs` of an agent in `state`.
    pub(super) fn new(scene: &'a Scene, prepared: &'a Prepared, state: &State, agent: usize, dofs: &[usize]) -> Self {
        let (body, ready) = (&scene.agents[agent], &prepared.agents[agent]);
        let moved = body.tree.links_moved_by(dofs);
        let held_along = |o: usize| {
            let held = state.objects[o].held.as_ref().filter(|h| h.agent == agent)?;
            moved.contains(&body.arms[held.arm].tip_link).then_some(held)
        };
        let X_WL = link_poses(scene, state);
        let obstacles = place_all(prepared, state, &X_WL, &|owner| match owner {
            Owner::Link { agent: a, link } => a == agent && moved.contains(&link),
            Owner::Object(o) => held_along(o).is_some(),
        });
        let mut moving: Vec<Moving<'a>> = Vec::new();
        for part in ready.parts.iter().filter(|p| moved.contains(&p.link)) {
            moving.push(Moving {
                owner: Owner::Link { agent, link: part.link },
                link: part.link,
                X_LS: part.X_FS,
                part,
                held_by: None,
            });
        }
        for (o, parts) in prepared.objects.iter().enumerate() {
            let Some(held) = held_along(o) else { continue };
            let arm = &body.arms[held.arm];
            moving.extend(parts.iter().map(|part| Moving {
                owner: Owner::Object(o),
                link: arm.tip_link,
                X_LS: arm.X_LT * held.X_TO * part.X_FS,
                part,
                held_by: Some(held.arm),
            }));
        }
        let mut space = BodySpace {
            scene,
            agent,
            limits: dofs.iter().map(|d| body.tree.dofs[*d].clone()).collect(),
            dofs: dofs.to_vec(),
            q: state.agents[agent].q.clone(),
            X_WL: X_WL[agent].clone(),
            moved,
            moving,
            obstacles,
            pairs: Vec::new(),
            inner_pairs: Vec::new(),
            hit: None,
            checks: 0,
        };
        space.choose_pairs();
        space
    }

    /// Says whether two bodies may overlap: of one link or neighbours, of one object, a hand and what it holds.
    fn may_touch(&self, a: &Moving<'_>, b: Owner, b_held_by: Option<usize>) -> bool {
        let body = &self.scene.agents[self.agent];
        let is_hand =
            |arm: Option<usize>, link: usize| arm.is_some_and(|arm| body.arms[arm].hand_links.contains(&link));
        match (a.owner, b) {
            (Owner::Link { link: l, .. }, Owner::Link { agent, link: m }) => {
                agent == self.agent && (l == m || body.may_touch.contains(&(l.min(m), l.max(m))))
            }
            (Owner::Object(_), Owner::Link { agent, link }) => agent == self.agent && is_hand(a.held_by, link),
            (Owner::Link { link, .. }, Owner::Object(_)) => is_hand(b_held_by, link),
            (Owner::Object(o), Owner::Object(p)) => o == p,
        }
    }

    /// Lists the pairs that must not overlap; what is near at the start already is tested as it is.
    fn choose_pairs(&mut self) {
        let (mut pairs, mut inner) = (Vec::new(), Vec::new());
        for (i, a) in self.moving.iter().enumerate() {
            let X_WA = self.X_WL[a.link] * a.X_LS;
            for (j, b) in self.obstacles.iter().enumerate() {
                if self.may_touch(a, b.owner, None) {
                    continue;
                }
                let is_own = matches!(b.owner, Owner::Link { agent, .. } if agent == self.agent);
                let wide = if is_own { &a.part.self_padded } else { &a.part.padded };
                let is_near = overlap(wide, &X_WA, b.solid, &b.X_WS);
                pairs.push((i, if is_near { a.part.resting.solid() } else { wide }, j));
            }
            for (j, b) in self.moving.iter().enumerate().skip(i + 1) {
                let X_WB = self.X_WL[b.link] * b.X_LS;
                let touches = overlap(&a.part.self_padded, &X_WA, &b.part.exact, &X_WB);
                if !touches && !self.may_touch(a, b.owner, b.held_by) && !self.may_touch(b, a.owner, a.held_by) {
                    inner.push((i, j));
                }
            }
        }
        (self.pairs, self.inner_pairs) = (pairs, inner);
    }

    /// Returns the configuration in the state that the space was made for.
    pub(super) fn start(&self) -> Vec<f64> {
        self.dofs.iter().map(|d| self.q[*d]).collect()
    }

    fn first_hit(&self) -> Option<(Owner, Owner)> {
        let placed: Vec<Pose> = self.moving.iter().map(|m| self.X_WL[m.link] * m.X_LS).collect();
        let outer = self.pairs.iter().find(|(i, solid, j)| {
            let b = &self.obstacles[*j];
            overlap(solid, &placed[*i], b.solid, &b.X_WS)
        });
        if let Some((i, _, j)) = outer {
            return Some((self.moving[*i].owner, self.obstacles[*j].owner));
        }
        let inner = self.inner_pairs.iter().find(|(i, j)| {
            let (a, b) = (self.moving[*i].part, self.moving[*j].part);
            overlap(&a.self_padded, &placed[*i], &b.exact, &placed[*j])
        });
        inner.map(|(i, j)| (self.moving[*i].owner, self.moving[*j].owner))
    }

    /// Returns the names of the last collision's bodies.
    pub(super) fn hit_names(&self) -> Option<(String, String)> {
        self.hit.map(|(a, b)| (a.name(self.scene), b.name(self.scene)))
    }
}

impl Space for BodySpace<'_> {
    fn dofs(&self) -> &[Dof] {
        &self.limits
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        self.checks += 1;
        for (dof, value) in self.dofs.iter().zip(q) {
            self.q[*dof] = *value;
        }
        let tree = &self.scene.agents[self.agent].tree;
        // The root link is its base: no joint moves it, so all links can be updated in order.
        tree.update_links(&self.moved, &self.q, &mut self.X_WL);
        self.hit = self.first_hit();
        self.hit.is_none()
    }
}
