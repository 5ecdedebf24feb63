//! Where an agent's base can stand and go: the requests `enoughRoom` and `pathExists` (thesis 4.4.1).
//!
//! The agent goes as it is: its joints, and what it holds, stay as they are. Real shapes against everything else; a cylinder
//! about the whole agent answers first where there is room for it. Paths are searched on a grid (A*: Hart, Nilsson, Raphael
//! 1968, doi:10.1109/TSSC.1968.300136) over places [`STEP`] apart and eight headings. Not here: human comfort along the
//! path, arms that draw in before they go, steps and slopes.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::f64::consts::{FRAC_PI_4, PI};

use nalgebra::RealField;

use super::facts;
use super::free_place::wide;
use super::prepared::{Owner, Placed, Prepared, link_poses, overlap, place_all};
use crate::geom::collide::{Solid, distance};
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{BaseKind, EntityRef, Scene, State};

/// Distance of neighbouring places of the grid [m]; headings are 45 degrees apart.
pub(super) const STEP: f64 = 0.1;
/// Checks along a move from one place to the next: 2.5 cm; along a turn: 2.8 degrees.
const CHECKS_ALONG: u32 = 4;
const CHECKS_TURNING: u32 = 16;
/// Places and headings looked at before a search gives up.
const MAX_NODES: u32 = 20_000;
const MAX_STANDS: usize = 4_000;
/// HEURISTIC: arms seldom reach farther than the first share of the sum of their links, and mostly as far as the second: a stand is
/// asked for within the one, and the search goes for the other.
const REACHES: f64 = 0.6;
const COMFORTABLE: f64 = 0.4;
/// Stands are tried once for each eighth of the directions around the entity and each of these distances [m].
const BAND: f64 = 0.15;
/// Stands at which the arm's inverse kinematics is asked before a search gives up.
const MAX_TRIES: usize = 10;
/// An agent reaches what is before it: within this of its heading [rad].
const AHEAD: f64 = 1.5 * FRAC_PI_4;
/// What is near [m]: about the border between personal and social distance (Hall 1966), less the body.
pub(super) const NEAR: f64 = 1.0;
/// Overlap that is a touch [m]; worlds may start with as much.
const TOUCH: f64 = 0.001;
/// How much more the way that is left counts than the way that was gone: any path will do, not the shortest (weighted A*: Pohl
/// 1970, doi:10.1016/0004-3702(70)90007-X).
const GREED: f64 = 3.0;
/// Half of the longest move [m].
const SPARE: f64 = STEP * std::f64::consts::FRAC_1_SQRT_2;
/// What lengths may be off by [m].
const ROUNDING: f64 = 1e-9;
/// Cost of a turn by 45 degrees, in metres.
const TURN: f64 = 0.05;

/// The question at hand: who goes, and among what.
pub(super) struct Bases<'a> {
    scene: &'a Scene,
    prepared: &'a Prepared,
    state: &'a State,
    agent: usize,
    seed: u64,
    /// The agent's bodies and those of what it holds, largest first: X_BS.
    own: Vec<(Solid, Pose)>,
    /// A cylinder about them all, upright on the base frame, and its middle's height [m].
    around: Solid,
    radius: f64,
    middle: f64,
    others: Vec<Placed<'a>>,
    /// Those of `others` that are at the agent's height: their position there, and a box around them on the floor.
    in_the_way: Vec<(usize, Footprint)>,
}

/// A rectangle on the floor, its sides along x and y: middle and half sides [m].
#[derive(Debug, Clone, Copy)]
struct Footprint {
    middle: [f64; 2],
    half: [f64; 2],
}

impl Footprint {
    /// Says whether some point of it is within `reach` [m] of (x, y).
    fn is_within(&self, reach: f64, x: f64, y: f64) -> bool {
        let dx = ((x - self.middle[0]).abs() - self.half[0]).max(0.0);
        let dy = ((y - self.middle[1]).abs() - self.half[1]).max(0.0);
        dx * dx + dy * dy <= reach * reach
    }
}

impl<'a> Bases<'a> {
    pub(super) fn new(scene: &'a Scene, prepared: &'a Prepared, state: &'a State, agent: usize, seed: u64) -> Self {
        let X_WL = link_poses(scene, state);
        let X_BW = state.agents[agent].X_WB.inverse();
        let holds = |o: usize| state.objects[o].held.as_ref().is_some_and(|h| h.agent == agent);
        let mut shapes: Vec<(&Shape, Pose)> = Vec::new();
        for body in &scene.agents[agent].bodies {
            shapes.push((&body.shape, X_BW * X_WL[agent][body.link] * body.X_LS));
        }
        for (o, object) in scene.objects.iter().enumerate().filter(|(o, _)| holds(*o)) {
            let parts = object.parts.iter();
            shapes.extend(parts.map(|p| (&p.shape, X_BW * state.objects[o].X_WO * p.X_OS)));
        }
        let (mut radius, mut low, mut high) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
        for (shape, X_BS) in &shapes {
            let (p, r) = (X_BS.translation.vector, shape.bounding_radius());
            radius = radius.max(wide(shape, X_BS));
            (low, high) = (low.min(p.z - r), high.max(p.z + r));
        }
        let mut own: Vec<(Solid, Pose)> = shapes.iter().map(|(s, X)| (Solid::padded(s, -TOUCH), *X)).collect();
        own.sort_by(|a, b| b.0.radius().total_cmp(&a.0.radius()));
        let half_length = ((high - low) / 2.0).max(0.0);
        let around = Shape::Cylinder { radius, half_length };
        let others = place_all(prepared, state, &X_WL, &|owner| match owner {
            Owner::Link { agent: a, .. } => a == agent,
            Owner::Object(o) => holds(o),
        });
        let z = state.agents[agent].X_WB.translation.z;
        let in_the_way = others.iter().enumerate().filter_map(|(i, b)| {
            let (p, half) = (b.X_WS.translation.vector, b.solid.half_extent(&b.X_WS));
            let is_level = p.z - half.z <= z + high + ROUNDING && p.z + half.z >= z + low - ROUNDING;
            is_level.then_some((
                i,
                Footprint {
                    middle: [p.x, p.y],
                    half: [half.x, half.y],
                },
            ))
        });
        let in_the_way = in_the_way.collect();
        Bases {
            scene,
            prepared,
            state,
            agent,
            seed,
            own,
            // Half of the longest move, so that what is free at both ends is free on the way.
            around: Solid::padded(&around, SPARE),
            radius,
            middle: (high + low) / 2.0,
            others,
            in_the_way,
        }
    }

    /// Returns what can touch the agent with its base at `X_WB`, or come as near to it as `spare` [m].
    fn near(&self, X_WB: &Pose, spare: f64) -> impl Iterator<Item = &(usize, Footprint)> {
        let (x, y) = (X_WB.translation.x, X_WB.translation.y);
        let reach = self.radius + spare + ROUNDING;
        self.in_the_way.iter().filter(move |(_, f)| f.is_within(reach, x, y))
    }

    /// Says whether the cylinder about the agent is free there, with half a step to spare.
    fn is_roomy(&self, X_WB: &Pose) -> bool {
        let X_WS = X_WB * Pose::translation(0.0, 0.0, self.middle);
        !self
            .near(X_WB, SPARE)
            .map(|(i, _)| &self.others[*i])
            .any(|b| overlap(&self.around, &X_WS, b.solid, &b.X_WS))
    }

    /// Says whether the agent's shapes are free there.
    fn is_free(&self, X_WB: &Pose) -> bool {
        let near: Vec<&(usize, Footprint)> = self.near(X_WB, 0.0).collect();
        near.is_empty()
            || self.own.iter().all(|(solid, X_BS)| {
                let X_WS = X_WB * X_BS;
                let (x, y, reach) = (X_WS.translation.x, X_WS.translation.y, solid.radius() + ROUNDING);
                !near.iter().any(|(i, footprint)| {
                    let b = &self.others[*i];
                    footprint.is_within(reach, x, y) && overlap(solid, &X_WS, b.solid, &b.X_WS)
                })
            })
    }

    /// Returns the pose of a base at (x, y) on its floor with that heading.
    fn at(&self, x: f64, y: f64, yaw: f64) -> Pose {
        Pose::new(
            Vec3::new(x, y, self.state.agents[self.agent].X_WB.translation.z),
            Vec3::z() * yaw,
        )
    }

    fn bodies(&self, entity: EntityRef) -> Vec<&Placed<'a>> {
        let is_own = |owner: Owner| match (owner, entity) {
            (Owner::Link { agent, .. }, EntityRef::Agent(a)) => agent == a,
            (Owner::Object(object), EntityRef::Object(o)) => object == o,
            (Owner::Link { .. } | Owner::Object(_), _) => false,
        };
        self.others.iter().filter(|b| is_own(b.owner)).collect()
    }

    /// Returns the frame origin of an entity [m].
    fn place(&self, entity: EntityRef) -> Option<Vec3> {
        match entity {
            EntityRef::Agent(a) => Some(self.state.agents[a].X_WB.translation.vector),
            EntityRef::Object(o) => Some(self.state.objects[o].X_WO.translation.vector),
            EntityRef::Virtual(_) => None,
        }
    }

    /// Returns the shoulders of an agent with what its arms can reach at most, both [m]; hands that are full left out.
    fn shoulders(&self, agent: usize) -> Vec<(Vec3, f64)> {
        let at = &self.state.agents[agent];
        let X_WL = self.scene.agents[agent].tree.link_poses(&at.X_WB, &at.q);
        let is_full = |arm: usize| {
            let mut held = self.state.objects.iter().filter_map(|o| o.held.as_ref());
            held.any(|h| h.agent == agent && h.arm == arm)
        };
        let arms = self.prepared.agents[agent].arms.iter().enumerate();
        arms.filter(|(arm, _)| !is_full(*arm))
            .map(|(_, arm)| (X_WL[arm.shoulder_link].translation.vector, arm.reach))
            .collect()
    }

    /// Says whether an empty hand could come to the entity with the base at `X_WB`, by lengths alone; two agents, whether their
    /// hands could meet.
    fn is_in_arms_length(&self, X_WB: &Pose, shoulders: &[(Vec3, f64)], entity: EntityRef) -> bool {
        let moved = X_WB * self.state.agents[self.agent].X_WB.inverse();
        let own = shoulders
            .iter()
            .map(|(p, reach)| ((moved * nalgebra::Point3::from(*p)).coords, *reach));
        match entity {
            EntityRef::Virtual(_) => false,
            EntityRef::Agent(other) => {
                let others = self.shoulders(other);
                own.into_iter()
                    .any(|(p, reach)| others.iter().any(|(q, far)| (p - q).norm() <= reach + far))
            }
            EntityRef::Object(_) => {
                let (bodies, point) = (self.bodies(entity), Solid::new(&Shape::Sphere { radius: 0.0 }));
                own.into_iter().any(|(p, reach)| {
                    let X_WP = Pose::translation(p.x, p.y, p.z);
                    bodies.iter().any(|b| {
                        (b.X_WS.translation.vector - p).norm() - b.solid.radius() <= reach
                            && distance(&point, &X_WP, b.solid, &b.X_WS) <= reach
                    })
                })
            }
        }
    }

    /// Says whether the agent has the entity already: it holds it.
    fn has(&self, entity: EntityRef) -> bool {
        matches!(entity, EntityRef::Object(o) if facts::has_in_hand(self.state, self.agent, o))
    }

    /// Says whether there is room for the agent near `near`, with `entity` at arm's length: a pose on the floor where its shapes are
    /// free, its axis within [`NEAR`] of `near`, and it faces `entity` or is turned from it by 45 degrees. `None` for what has no place.
    pub(super) fn enough_room(&self, near: EntityRef, entity: EntityRef) -> Option<bool> {
        let (p_near, p_entity) = (self.place(near)?, self.place(entity)?);
        let shoulders = self.shoulders(self.agent);
        let axis = Solid::new(&Shape::Cylinder {
            radius: 1e-3,
            half_length: 1.0,
        });
        let landmarks = self.bodies(near);
        let is_near = |X_WB: &Pose| {
            let X_WS = X_WB * Pose::translation(0.0, 0.0, 1.0);
            landmarks
                .iter()
                .any(|b| distance(&axis, &X_WS, b.solid, &b.X_WS) <= NEAR)
        };
        let suits = |X_WB: &Pose| {
            (self.has(entity) || self.is_in_arms_length(X_WB, &shoulders, entity))
                && is_near(X_WB)
                && self.is_free(X_WB)
        };
        if self.scene.agents[self.agent].base == BaseKind::Fixed {
            return Some(suits(&self.state.agents[self.agent].X_WB));
        }
        let span = landmarks
            .iter()
            .map(|b| (b.X_WS.translation.vector - p_near).norm() + b.solid.radius());
        let n = ((span.fold(0.0, f64::max) + NEAR) / STEP).ceil().min(60.0) as i32;
        // Of the world's lattice, so that an answer changes only where something has moved.
        let (x0, y0) = ((p_near.x / STEP).round(), (p_near.y / STEP).round());
        let mut places: Vec<(f64, f64, f64)> = (-n..=n)
            .flat_map(|i| (-n..=n).map(move |j| ((x0 + f64::from(i)) * STEP, (y0 + f64::from(j)) * STEP)))
            .map(|(x, y)| ((Vec3::new(x, y, p_entity.z) - p_entity).norm(), x, y))
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2)));
        let mut looked = 0;
        for (_, x, y) in places {
            let facing = RealField::atan2(p_entity.y - y, p_entity.x - x);
            if !is_near(&self.at(x, y, facing)) {
                continue;
            }
            looked += 1;
            if looked > MAX_STANDS {
                break;
            }
            if [0.0, -FRAC_PI_4, FRAC_PI_4]
                .iter()
                .any(|turn| suits(&self.at(x, y, facing + turn)))
            {
                return Some(true);
            }
        }
        Some(false)
    }

    /// Says whether the agent can reach the entity with its base at `X_WB`: an object that can be taken by inverse kinematics,
    /// others by the length of its arms. `tried` are the directions and distances from which it could not.
    fn reaches_from(
        &self,
        X_WB: &Pose,
        shoulders: &[(Vec3, f64)],
        entity: EntityRef,
        tried: &mut BTreeSet<(i32, i32)>,
    ) -> bool {
        let Some(p_WE) = self.place(entity) else { return false };
        let p_BE = X_WB.inverse() * nalgebra::Point3::from(p_WE);
        if RealField::atan2(p_BE.y, p_BE.x).abs() > AHEAD || !self.is_in_arms_length(X_WB, shoulders, entity) {
            return false;
        }
        let EntityRef::Object(object) = entity else { return true };
        if !self.scene.objects[object].movable {
            return true;
        }
        let reach = shoulders.iter().map(|s| s.1).fold(0.0, f64::max);
        let p_EB = X_WB.translation.vector - p_WE;
        let far = p_EB.xy().norm();
        let direction = (RealField::atan2(p_EB.y, p_EB.x) / FRAC_PI_4).round() as i32;
        if far > REACHES * reach
            || tried.len() >= MAX_TRIES
            || !tried.insert((direction.rem_euclid(8), (far / BAND) as i32))
        {
            return false;
        }
        let mut there = self.state.clone();
        let moved = X_WB * self.state.agents[self.agent].X_WB.inverse();
        there.agents[self.agent].X_WB = *X_WB;
        for held in &mut there.objects {
            if held.held.as_ref().is_some_and(|h| h.agent == self.agent) {
                held.X_WO = moved * held.X_WO;
            }
        }
        facts::is_reachable(self.scene, self.prepared, &there, object, self.agent, self.seed)
    }

    /// Says whether the base can go from where it is to a pose from which the agent reaches the entity. `None` for what has no place.
    pub(super) fn path_exists(&self, entity: EntityRef) -> Option<bool> {
        let goal = self.place(entity)?;
        if self.has(entity) {
            return Some(true);
        }
        let shoulders = self.shoulders(self.agent);
        let here = self.state.agents[self.agent].X_WB;
        let already = match entity {
            EntityRef::Object(object) if self.scene.objects[object].movable => {
                facts::is_reachable(self.scene, self.prepared, self.state, object, self.agent, self.seed)
            }
            EntityRef::Object(_) | EntityRef::Agent(_) => self.is_in_arms_length(&here, &shoulders, entity),
            EntityRef::Virtual(_) => false,
        };
        if already || self.scene.agents[self.agent].base == BaseKind::Fixed {
            return Some(already);
        }
        Some(self.is_at_height(&shoulders, entity) && self.search(goal, &shoulders, entity))
    }

    /// Says whether the entity is no farther above or below a shoulder than the arm is long: wherever the base goes, that stays.
    fn is_at_height(&self, shoulders: &[(Vec3, f64)], entity: EntityRef) -> bool {
        let spans: Vec<(f64, f64)> = match entity {
            EntityRef::Agent(other) => self.shoulders(other).iter().map(|(q, far)| (q.z, *far)).collect(),
            EntityRef::Object(_) | EntityRef::Virtual(_) => {
                let bodies = self.bodies(entity).into_iter();
                bodies
                    .map(|b| (b.X_WS.translation.z, b.solid.half_extent(&b.X_WS).z))
                    .collect()
            }
        };
        let is_level =
            |(p, reach): &(Vec3, f64)| spans.iter().any(|(z, far)| (p.z - z).abs() <= reach + far + ROUNDING);
        shoulders.iter().any(is_level)
    }

    fn search(&self, goal: Vec3, shoulders: &[(Vec3, f64)], entity: EntityRef) -> bool {
        type Node = (i32, i32, i32);
        const TURNS: i32 = 8;
        let here = self.state.agents[self.agent].X_WB;
        let origin = here.translation.vector;
        let ahead = here.rotation * Vec3::x();
        let yaw = RealField::atan2(ahead.y, ahead.x);
        let pose = |n: Node, part: (f64, f64, f64)| {
            let x = origin.x + (f64::from(n.0) + part.0) * STEP;
            let y = origin.y + (f64::from(n.1) + part.1) * STEP;
            self.at(x, y, yaw + (f64::from(n.2) + part.2) * 2.0 * PI / f64::from(TURNS))
        };
        // Beyond a lap around everything there is nothing to find.
        let spread = self.others.iter().map(|b| {
            let p = b.X_WS.translation.vector - origin;
            p.x.abs().max(p.y.abs()) + b.solid.radius()
        });
        let border = ((spread.fold(0.0, f64::max) + 2.0 * self.radius) / STEP).ceil() as i32 + 2;
        let reach = COMFORTABLE * shoulders.iter().map(|s| s.1).fold(0.0, f64::max);
        let estimate = |n: Node| {
            let p_BE = pose(n, (0.0, 0.0, 0.0)).inverse() * nalgebra::Point3::from(goal);
            let off = RealField::atan2(p_BE.y, p_BE.x).abs() / FRAC_PI_4;
            GREED * ((p_BE.coords.xy().norm() - reach).max(0.0) + TURN * off)
        };
        // Micrometres, so that equal costs are equal and the order is total.
        let rank = |cost: f64| (cost * 1e6).round() as i64;
        let mut roomy: BTreeMap<(i32, i32), bool> = BTreeMap::new();
        let mut is_roomy = |n: Node| {
            let known = roomy.entry((n.0, n.1));
            *known.or_insert_with(|| self.is_roomy(&pose((n.0, n.1, 0), (0.0, 0.0, 0.0))))
        };
        // Up to ten moves end at a place: it is looked at once.
        let mut free: BTreeMap<Node, bool> = BTreeMap::new();
        let mut is_free_at = |n: Node| *free.entry(n).or_insert_with(|| self.is_free(&pose(n, (0.0, 0.0, 0.0))));
        let start: Node = (0, 0, 0);
        let mut best: BTreeMap<Node, f64> = BTreeMap::from([(start, 0.0)]);
        let mut closed: BTreeSet<Node> = BTreeSet::new();
        let mut open = BinaryHeap::from([Reverse((rank(estimate(start)), start))]);
        let (mut looked, mut tried) = (0, BTreeSet::new());
        while let Some(Reverse((_, node))) = open.pop() {
            if !closed.insert(node) {
                continue;
            }
            looked += 1;
            if looked > MAX_NODES {
                return false;
            }
            if self.reaches_from(&pose(node, (0.0, 0.0, 0.0)), shoulders, entity, &mut tried) {
                return true;
            }
            // No stand will be tried any more.
            if tried.len() >= MAX_TRIES {
                return false;
            }
            let cost = best.get(&node).copied().unwrap_or(f64::INFINITY);
            let moves = [
                (1, 0, 0),
                (-1, 0, 0),
                (0, 1, 0),
                (0, -1, 0),
                (1, 1, 0),
                (1, -1, 0),
                (-1, 1, 0),
                (-1, -1, 0),
                (0, 0, 1),
                (0, 0, -1),
            ];
            for (dx, dy, turn) in moves {
                let next = (node.0 + dx, node.1 + dy, (node.2 + turn).rem_euclid(TURNS));
                if closed.contains(&next) || next.0.abs() > border || next.1.abs() > border {
                    continue;
                }
                let length = STEP * f64::from(dx * dx + dy * dy).sqrt() + TURN * f64::from(turn.abs());
                if best.get(&next).is_some_and(|known| *known <= cost + length) {
                    continue;
                }
                let checks = if turn == 0 { CHECKS_ALONG } else { CHECKS_TURNING };
                let is_free = (is_roomy(node) && is_roomy(next))
                    || (is_free_at(next)
                        && (1..checks).all(|k| {
                            let t = f64::from(k) / f64::from(checks);
                            self.is_free(&pose(node, (t * f64::from(dx), t * f64::from(dy), t * f64::from(turn))))
                        }));
                if is_free {
                    best.insert(next, cost + length);
                    open.push(Reverse((rank(cost + length + estimate(next)), next)));
                }
            }
        }
        false
    }
}
