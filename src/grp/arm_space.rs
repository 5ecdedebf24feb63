//! The joint space of one arm in a world state: which of its configurations are free.
//!
//! Says who has to keep away from whom and by how much; [`Checker`] does the rest.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::sync::Arc;

use super::prepared::{MARGIN, Owner, Part, Prepared, SELF_MARGIN, link_poses, place_all};
use crate::geom::Pose;
use crate::geom::checker::{Body, Checker, Item, Obstacle};
use crate::geom::collide::within;
use crate::geom::cover::Form;
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

/// What a moving body is: a link of the arm, or a part of the held object, which is there twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Link,
    /// As it is: keeps its margin.
    Held,
    /// Shrunk a little: may rest on something.
    Resting,
}

/// Who a moving body is.
#[derive(Debug, Clone, Copy)]
struct Mover {
    owner: Owner,
    kind: Kind,
    is_hand: bool,
    /// How far from the shoulder it can come [m].
    sweep: f64,
}

/// A body of the hand, or of what it holds, seen from the tip.
#[derive(Debug)]
struct InHand {
    owner: Owner,
    is_hand: bool,
    link: usize,
    X_LS: Pose,
    form: Arc<Form>,
    sweep: f64,
}

/// What was hit last.
#[derive(Debug)]
enum Last {
    Nothing,
    /// At one of these configurations.
    At(Vec<f64>),
    By(Owner, Owner),
}

/// Checks configurations of one arm against everything.
pub(super) struct ArmSpace<'a> {
    pub scene: &'a Scene,
    prepared: &'a Prepared,
    agent: usize,
    arm: usize,
    /// Full configuration of the agent.
    q: Vec<f64>,
    X_WL: Vec<Pose>,
    checker: Checker,
    /// By item of the checker.
    movers: Vec<Mover>,
    others: Vec<Other>,
    in_hand: Vec<InHand>,
    /// The object that the hand may touch.
    handled: Option<usize>,
    last: Last,
    /// Configurations checked.
    pub checks: u64,
}

/// What stands in the way of the arm.
#[derive(Debug, Clone, Copy)]
struct Other {
    owner: Owner,
    /// How near it is to the shoulder [m].
    apart: f64,
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
        let (body, ready) = (&scene.agents[agent], &prepared.agents[agent].arms[arm]);
        let handled = if clearance == Clearance::Contact { handled } else { None };
        let mut X_WL_all = link_poses(scene, state);
        let p_WShoulder = X_WL_all[agent][ready.shoulder_link].translation.vector;
        let is_hand = |link: usize| body.arms[arm].hand_links.contains(&link);
        // What the arm moves stays within a sphere about the shoulder.
        let sweep = |link: usize, X_LS: &Pose, form: &Form| {
            ready.link_reach[link] + X_LS.translation.vector.norm() + form.solid().radius() + MARGIN
        };
        let mut movers = Vec::new();
        let mut in_hand = Vec::new();
        for part in ready.rig.bodies() {
            let owner = Owner::Link { agent, link: part.link };
            let (is_hand, sweep) = (is_hand(part.link), sweep(part.link, &part.X_LS, &part.form));
            movers.push(Mover {
                owner,
                kind: Kind::Link,
                is_hand,
                sweep,
            });
            if is_hand {
                in_hand.push(InHand {
                    owner,
                    is_hand,
                    link: part.link,
                    X_LS: part.X_LS,
                    form: Arc::clone(&part.form),
                    sweep,
                });
            }
        }
        let mut carried = Vec::new();
        let tip_link = body.arms[arm].tip_link;
        for (object, part, X_LO) in held_parts(scene, prepared, state, agent, arm) {
            let X_LS = X_LO * part.X_FS;
            let sweep = sweep(tip_link, &X_LS, &part.form);
            for (kind, form) in [(Kind::Held, &part.form), (Kind::Resting, &part.resting)] {
                carried.push(Body {
                    link: tip_link,
                    X_LS,
                    form: Arc::clone(form),
                });
                movers.push(Mover {
                    owner: Owner::Object(object),
                    kind,
                    is_hand: false,
                    sweep,
                });
            }
            in_hand.push(InHand {
                owner: Owner::Object(object),
                is_hand: false,
                link: tip_link,
                X_LS,
                form: Arc::clone(&part.resting),
                sweep,
            });
        }
        let is_moving = |owner: Owner| match owner {
            Owner::Link { agent: a, link } => a == agent && ready.rig.moves(link),
            Owner::Object(o) => movers.iter().any(|m| m.owner == Owner::Object(o)),
        };
        let farthest = movers.iter().map(|m| m.sweep).fold(0.0, f64::max);
        let (mut others, mut obstacles) = (Vec::new(), Vec::new());
        for placed in place_all(prepared, state, &X_WL_all, &is_moving) {
            let apart = (placed.X_WS.translation.vector - p_WShoulder).norm() - placed.solid.radius();
            if apart <= farthest {
                others.push(Other {
                    owner: placed.owner,
                    apart,
                });
                obstacles.push(Obstacle {
                    X_WS: placed.X_WS,
                    form: Arc::clone(placed.form),
                });
            }
        }
        let may_touch = &body.may_touch;
        let margin = |a: Item, b: Item| {
            let Item::Body(a) = a else { return None };
            let a = &movers[a];
            match b {
                Item::Body(b) => own_margin(a, &movers[b], may_touch),
                Item::Obstacle(b) => other_margin(a, &others[b], agent, may_touch, handled, clearance),
            }
        };
        let X_WL = X_WL_all.swap_remove(agent);
        let q = state.agents[agent].q.clone();
        let mut checker = Checker::new(&ready.rig, &X_WL, &q, &carried, &obstacles, &margin);
        // Where a body is within the margin already at the start, the motion may leave: the exact shape is tested there.
        let start: Vec<f64> = ready.chain.dof_indices().iter().map(|d| q[*d]).collect();
        let near = if clearance == Clearance::Margin { MARGIN } else { 0.0 };
        for (a, b) in checker.near(&start, near) {
            let (Item::Body(i), Item::Obstacle(j)) = (a, b) else {
                continue;
            };
            match movers[i].kind {
                Kind::Link => checker.set_margin(a, b, Some(0.0)),
                Kind::Resting => {}
                Kind::Held => {
                    let resting = &carried[i - ready.rig.bodies().len() + 1];
                    let X_WS = X_WL[resting.link] * resting.X_LS;
                    let other = &obstacles[j];
                    if clearance == Clearance::Margin
                        || within(resting.form.solid(), &X_WS, other.form.solid(), &other.X_WS, 0.0)
                    {
                        checker.set_margin(a, b, None);
                        checker.set_margin(Item::Body(i + 1), b, Some(0.0));
                    }
                }
            }
        }
        ArmSpace {
            scene,
            prepared,
            agent,
            arm,
            q,
            X_WL,
            checker,
            movers,
            others,
            in_hand,
            handled,
            last: Last::Nothing,
            checks: 0,
        }
    }

    /// Returns the arm's configuration in the state that the space was made for.
    pub(super) fn start(&self) -> Vec<f64> {
        let dofs = self.prepared.agents[self.agent].arms[self.arm].chain.dof_indices();
        dofs.iter().map(|d| self.q[*d]).collect()
    }

    /// Sets other joints of the agent (fingers).
    pub(super) fn set_dofs(&mut self, dofs: &[usize], values: &[f64]) {
        for (dof, value) in dofs.iter().zip(values) {
            self.q[*dof] = *value;
            self.checker.set_rest(*dof, *value);
        }
        let arm = &self.prepared.agents[self.agent].arms[self.arm];
        let tree = &self.scene.agents[self.agent].tree;
        tree.update_links(&arm.moved, &self.q, &mut self.X_WL);
    }

    /// Says whether the arm is free at `q` (chain order).
    pub(super) fn check(&mut self, q: &[f64]) -> bool {
        self.checks += 1;
        let free = self.checker.is_free(q);
        self.last = if free { Last::Nothing } else { Last::At(q.to_vec()) };
        free
    }

    /// Says whether the hand alone, with its tool at `X_WT` and its fingers as they are, is free; a cheap test before any
    /// inverse kinematics. What the hand holds goes with it.
    pub(super) fn hand_is_free(&mut self, X_WT: &Pose) -> bool {
        let arm = &self.scene.agents[self.agent].arms[self.arm];
        // Links of the hand keep their places relative to the tip while only the arm's joints differ.
        let X_WTip = X_WT * arm.X_LT.inverse();
        let X_TipW = self.X_WL[arm.tip_link].inverse();
        for body in &self.in_hand {
            let X_WS = X_WTip * (X_TipW * self.X_WL[body.link] * body.X_LS);
            let counts = |item: Item| match item {
                Item::Body(_) => false,
                Item::Obstacle(j) => {
                    let other = &self.others[j];
                    let own = matches!(other.owner, Owner::Link { agent, .. } if agent == self.agent);
                    let may = body.is_hand && self.handled.map(Owner::Object) == Some(other.owner);
                    !own && !may && other.apart <= body.sweep
                }
            };
            if let Some(Item::Obstacle(j)) = self.checker.touched(&body.form, &X_WS, &counts) {
                self.last = Last::By(body.owner, self.others[j].owner);
                return false;
            }
        }
        true
    }

    /// Returns the names of the last collision's bodies.
    pub(super) fn hit_names(&self) -> Option<(String, String)> {
        let (a, b) = self.hit()?;
        Some((a.name(self.scene), b.name(self.scene)))
    }

    /// Returns the bodies of the last collision.
    pub(super) fn hit(&self) -> Option<(Owner, Owner)> {
        let owner = |item: Item| match item {
            Item::Body(i) => self.movers[i].owner,
            Item::Obstacle(j) => self.others[j].owner,
        };
        match &self.last {
            Last::Nothing => None,
            Last::By(a, b) => Some((*a, *b)),
            Last::At(qs) => {
                let mut each = qs.chunks(self.dofs().len().max(1));
                let (a, b) = each.find_map(|q| self.checker.first_hit(q))?;
                Some((owner(a), owner(b)))
            }
        }
    }
}

/// Returns the parts of what the arm holds, with the pose of their object in the tip link's frame.
fn held_parts<'a>(
    scene: &Scene,
    prepared: &'a Prepared,
    state: &State,
    agent: usize,
    arm: usize,
) -> Vec<(usize, &'a Part, Pose)> {
    let X_LT = scene.agents[agent].arms[arm].X_LT;
    let mut parts = Vec::new();
    for (object, stands) in state.objects.iter().enumerate() {
        if let Some(held) = stands.held.as_ref().filter(|h| h.agent == agent && h.arm == arm) {
            let X_LO = X_LT * held.X_TO;
            parts.extend(prepared.objects[object].iter().map(|part| (object, part, X_LO)));
        }
    }
    parts
}

/// How far two moving bodies have to keep apart; the first is padded, the second may rest.
fn own_margin(a: &Mover, b: &Mover, may_touch: &std::collections::BTreeSet<(usize, usize)>) -> Option<f64> {
    let kinds = a.kind != Kind::Resting && b.kind != Kind::Held;
    let apart = match (a.owner, b.owner) {
        (Owner::Link { link: l, .. }, Owner::Link { link: m, .. }) => {
            l != m && !may_touch.contains(&(l.min(m), l.max(m)))
        }
        // The hand touches what it holds.
        (Owner::Link { .. }, Owner::Object(_)) => !a.is_hand,
        (Owner::Object(_), Owner::Link { .. }) => !b.is_hand,
        (Owner::Object(o), Owner::Object(p)) => o != p,
    };
    (kinds && apart).then_some(SELF_MARGIN)
}

/// How far a moving body has to keep away from one that stands.
fn other_margin(
    a: &Mover,
    b: &Other,
    agent: usize,
    may_touch: &std::collections::BTreeSet<(usize, usize)>,
    handled: Option<usize>,
    clearance: Clearance,
) -> Option<f64> {
    if b.apart > a.sweep {
        return None;
    }
    let own = matches!(b.owner, Owner::Link { agent: of, .. } if of == agent);
    let may = match (a.owner, b.owner) {
        (Owner::Link { link: l, .. }, Owner::Link { link: m, .. }) => {
            own && (l == m || may_touch.contains(&(l.min(m), l.max(m))))
        }
        // The hand may come to what it is going to take.
        (Owner::Link { .. }, Owner::Object(o)) => a.is_hand && handled == Some(o),
        (Owner::Object(_), Owner::Link { .. } | Owner::Object(_)) => false,
    };
    if may {
        return None;
    }
    match (a.kind, clearance) {
        (Kind::Link | Kind::Held, _) if own => Some(SELF_MARGIN),
        (Kind::Link | Kind::Held, Clearance::Margin) => Some(MARGIN),
        (Kind::Link, Clearance::Contact) => Some(0.0),
        (Kind::Resting, Clearance::Contact) if !own => Some(0.0),
        (Kind::Held, Clearance::Contact) | (Kind::Resting, _) => None,
    }
}

impl Space for ArmSpace<'_> {
    fn dofs(&self) -> &[Dof] {
        self.prepared.agents[self.agent].arms[self.arm].chain.dofs()
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        self.check(q)
    }

    fn all_free(&mut self, qs: &[f64]) -> bool {
        self.checks += (qs.len() / self.dofs().len().max(1)) as u64;
        let free = self.checker.all_free(qs);
        self.last = if free { Last::Nothing } else { Last::At(qs.to_vec()) };
        free
    }
}
