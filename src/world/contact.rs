//! Who touches whom, and how deep: every pair of bodies, for the check of a start state and for messages.
//!
//! Brute force over all pairs: right, not fast. Planning has its own checks.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::{EntityRef, Scene, State};
use crate::geom::collide::{Solid, penetration};
use crate::geom::{Pose, Vec3};

/// A body of an entity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BodyRef {
    pub entity: EntityRef,
    /// Name of the link, or `part 2` of an object with several parts; empty for an object with one.
    pub part: String,
}

/// Two bodies that overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    pub a: BodyRef,
    pub b: BodyRef,
    /// How far one must move for them not to overlap [m].
    pub depth: f64,
}

/// A body in the world.
struct Placed {
    entity: EntityRef,
    /// Link or part.
    index: usize,
    solid: Solid,
    X_WS: Pose,
}

/// Returns the overlaps deeper than `margin` [m]: agents and objects against each other, and each agent's links against its
/// others. Links that may touch, a held object and its holder's hand, and two fixed objects are left out.
///
/// In the order of the scene; for a pair of entities' parts, the deepest overlap alone.
pub fn contacts(scene: &Scene, state: &State, margin: f64) -> Vec<Contact> {
    let placed = place(scene, state);
    let mut found: Vec<Contact> = Vec::new();
    for (i, a) in placed.iter().enumerate() {
        for b in &placed[i + 1..] {
            if near(a, b)
                && !excused(scene, state, a, b)
                && let Some(depth) = penetration(&a.solid, &a.X_WS, &b.solid, &b.X_WS)
                && depth > margin
            {
                let (a, b) = (body_ref(scene, a), body_ref(scene, b));
                match found.iter_mut().find(|c| c.a == a && c.b == b) {
                    Some(known) => known.depth = known.depth.max(depth),
                    None => found.push(Contact { a, b, depth }),
                }
            }
        }
    }
    found
}

fn place(scene: &Scene, state: &State) -> Vec<Placed> {
    let mut placed = Vec::new();
    for (a, (agent, stands)) in scene.agents.iter().zip(&state.agents).enumerate() {
        let X_WL = agent.tree.link_poses(&stands.X_WB, &stands.q);
        placed.extend(agent.bodies.iter().map(|body| Placed {
            entity: EntityRef::Agent(a),
            index: body.link,
            solid: Solid::new(&body.shape),
            X_WS: X_WL[body.link] * body.X_LS,
        }));
    }
    for (o, (object, stands)) in scene.objects.iter().zip(&state.objects).enumerate() {
        placed.extend(object.parts.iter().enumerate().map(|(index, part)| Placed {
            entity: EntityRef::Object(o),
            index,
            solid: Solid::new(&part.shape),
            X_WS: stands.X_WO * part.X_OS,
        }));
    }
    placed
}

fn near(a: &Placed, b: &Placed) -> bool {
    let p_AB: Vec3 = b.X_WS.translation.vector - a.X_WS.translation.vector;
    p_AB.norm() <= a.solid.radius() + b.solid.radius()
}

/// Says whether a contact of these two is no collision.
fn excused(scene: &Scene, state: &State, a: &Placed, b: &Placed) -> bool {
    match (a.entity, b.entity) {
        (EntityRef::Agent(x), EntityRef::Agent(y)) if x == y => {
            let pair = (a.index.min(b.index), a.index.max(b.index));
            a.index == b.index || scene.agents[x].may_touch.contains(&pair)
        }
        (EntityRef::Object(x), EntityRef::Object(y)) => {
            x == y || !(scene.objects[x].movable || scene.objects[y].movable)
        }
        (EntityRef::Agent(agent), EntityRef::Object(object)) => {
            let held = state.objects[object].held.as_ref().filter(|h| h.agent == agent);
            let hand = held.and_then(|h| scene.agents[agent].arms.get(h.arm));
            hand.is_some_and(|arm| arm.hand_links.contains(&a.index))
        }
        // INVARIANT: `place` lists agents before objects, and no virtual object.
        (EntityRef::Object(_), EntityRef::Agent(_))
        | (EntityRef::Agent(_), EntityRef::Agent(_))
        | (EntityRef::Virtual(_), _)
        | (_, EntityRef::Virtual(_)) => false,
    }
}

fn body_ref(scene: &Scene, placed: &Placed) -> BodyRef {
    let part = match placed.entity {
        EntityRef::Agent(a) => scene.agents[a].tree.links[placed.index].clone(),
        EntityRef::Object(o) if scene.objects[o].parts.len() > 1 => format!("part {}", placed.index + 1),
        EntityRef::Object(_) | EntityRef::Virtual(_) => String::new(),
    };
    BodyRef {
        entity: placed.entity,
        part,
    }
}
