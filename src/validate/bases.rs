//! Where a base can stand and go, by brute force: every place of a lattice, every pair of bodies, everything flooded.
//!
//! A claim is confirmed with a slack that covers the lattice; a denial is contradicted only where there is plainly room. Whether
//! a path is denied rightly is not judged beyond what is reachable already: `docs/validate.md`.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::f64::consts::{FRAC_PI_4, PI};

use nalgebra::RealField;

use super::{
    Settings,
    bodies::{Bodies, Placed},
    reach::{self, Until},
};
use crate::geom::{Pose, Vec3, collide, collide::Solid, shape::Shape};
use crate::world::{BaseKind, EntityRef, State};

/// Lattice for standing [m], and the overlap and the lengths that are forgiven for it.
const LATTICE: f64 = 0.05;
const SLACK: f64 = 0.05;
/// How far what is clearly free keeps from everything [m].
const CLEAR: f64 = 0.03;
/// Distance from its axis within which an agent stands near something [m].
const NEAR: f64 = 1.0;
/// Steps of a path [m]; headings are 45 degrees apart; overlap that is none [m].
const STEP: f64 = 0.1;
const TURNS: i32 = 8;
const TOUCH: f64 = 0.002;
/// Moves, and budgets: places flooded, places stood at, restarts of the inverse kinematics at each of these.
const MOVES: [(i32, i32, i32); 10] = [
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
const MAX_FLOODED: usize = 60_000;
const MAX_STANDS: usize = 40;
const RESTARTS: usize = 60;

/// The agent, and everything that is not it nor in its hands.
struct Bases<'a> {
    bodies: &'a Bodies<'a>,
    state: &'a State,
    agent: usize,
    own: Vec<(&'a Solid, Pose)>,
    others: Vec<Placed<'a>>,
    shoulders: Vec<(Vec3, f64)>,
}

impl<'a> Bases<'a> {
    fn new(bodies: &'a Bodies<'a>, state: &'a State, agent: usize) -> Self {
        let X_BW = state.agents[agent].X_WB.inverse();
        let own = bodies
            .moving(state, agent)
            .into_iter()
            .map(|p| (p.solid, X_BW * p.X_WS));
        Bases {
            bodies,
            state,
            agent,
            own: own.collect(),
            others: bodies.standing(state, agent),
            shoulders: reach::shoulders(bodies, state, agent),
        }
    }

    fn at(&self, x: f64, y: f64, yaw: f64) -> Pose {
        Pose::new(
            Vec3::new(x, y, self.state.agents[self.agent].X_WB.translation.z),
            Vec3::z() * yaw,
        )
    }

    /// Says whether no overlap at a pose is deeper than `most` [m].
    fn is_free(&self, X_WB: &Pose, most: f64) -> bool {
        self.own.iter().all(|(solid, X_BS)| {
            let X_WS = X_WB * X_BS;
            self.others.iter().all(|o| {
                let apart = (X_WS.translation.vector - o.X_WS.translation.vector).norm();
                apart > solid.radius() + o.solid.radius()
                    || collide::penetration(solid, &X_WS, o.solid, &o.X_WS).is_none_or(|depth| depth <= most)
            })
        })
    }

    /// Says whether everything is at least `margin` [m] away.
    fn is_clear(&self, X_WB: &Pose, margin: f64) -> bool {
        self.own.iter().all(|(solid, X_BS)| {
            let X_WS = X_WB * X_BS;
            self.others.iter().all(|o| {
                let apart = (X_WS.translation.vector - o.X_WS.translation.vector).norm();
                apart > solid.radius() + o.solid.radius() + margin
                    || collide::distance(solid, &X_WS, o.solid, &o.X_WS) >= margin
            })
        })
    }

    fn bodies_of(&self, entity: EntityRef) -> Vec<Placed<'_>> {
        match entity {
            EntityRef::Agent(a) => self.bodies.agent(self.state, a),
            EntityRef::Object(o) => self.bodies.object(self.state, o),
            EntityRef::Virtual(_) => Vec::new(),
        }
    }

    fn place(&self, entity: EntityRef) -> Option<Vec3> {
        match entity {
            EntityRef::Agent(a) => Some(self.state.agents[a].X_WB.translation.vector),
            EntityRef::Object(o) => Some(self.state.objects[o].X_WO.translation.vector),
            EntityRef::Virtual(_) => None,
        }
    }

    fn has(&self, entity: EntityRef) -> bool {
        let EntityRef::Object(o) = entity else { return false };
        self.state.objects[o]
            .held
            .as_ref()
            .is_some_and(|h| h.agent == self.agent)
    }

    /// Returns by how much the arms are longer than they need to be for the entity, base at `X_WB` [m].
    fn spare_length(&self, X_WB: &Pose, entity: EntityRef) -> f64 {
        let moved = X_WB * self.state.agents[self.agent].X_WB.inverse();
        let own = self
            .shoulders
            .iter()
            .map(|(p, length)| ((moved * nalgebra::Point3::from(*p)).coords, *length));
        let point = Solid::new(&Shape::Sphere { radius: 0.0 });
        let spare = own.map(|(p, length)| match entity {
            EntityRef::Agent(other) => reach::shoulders(self.bodies, self.state, other)
                .into_iter()
                .map(|(q, far)| length + far - (p - q).norm())
                .fold(f64::NEG_INFINITY, f64::max),
            EntityRef::Object(_) | EntityRef::Virtual(_) => self
                .bodies_of(entity)
                .iter()
                .map(|b| length - collide::distance(&point, &Pose::translation(p.x, p.y, p.z), b.solid, &b.X_WS))
                .fold(f64::NEG_INFINITY, f64::max),
        });
        spare.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Says whether an arm reaches the object with the base at `X_WB`, by an inverse kinematics of our own.
    fn reaches_from(&self, X_WB: &Pose, entity: EntityRef, settings: &Settings) -> bool {
        let EntityRef::Object(object) = entity else {
            return false;
        };
        let mut there = self.state.clone();
        there.agents[self.agent].X_WB = *X_WB;
        self.bodies.carry(&mut there, self.agent);
        let settings = Settings {
            reach_restarts: RESTARTS,
            ..settings.clone()
        };
        reach::search(self.bodies, &there, self.agent, object, &settings, Until::Found).found
    }

    /// Returns how far the base's axis is from the entity [m].
    fn distance_to_axis(&self, X_WB: &Pose, entity: &[Placed<'_>]) -> f64 {
        let axis = Solid::new(&Shape::Capsule {
            radius: 0.0,
            half_length: 1.0,
        });
        let X_WS = X_WB * Pose::translation(0.0, 0.0, 1.0);
        let all = entity.iter().map(|b| collide::distance(&axis, &X_WS, b.solid, &b.X_WS));
        all.fold(f64::INFINITY, f64::min)
    }
}

/// Says whether a hand of the agent, empty or not, could come to the entity from where it stands, by lengths alone; two agents,
/// whether their hands could meet.
pub(super) fn is_in_arms_length(bodies: &Bodies<'_>, state: &State, agent: usize, entity: EntityRef) -> bool {
    let mut empty = state.clone();
    for object in &mut empty.objects {
        object.held = None;
    }
    let bases = Bases::new(bodies, &empty, agent);
    bases.spare_length(&state.agents[agent].X_WB, entity) >= 0.0
}

/// Says whether there may be room for the agent near `near` with `entity` at arm's length, and whether there plainly is.
pub(super) fn room(
    bodies: &Bodies<'_>,
    state: &State,
    agent: usize,
    near: EntityRef,
    entity: EntityRef,
) -> (bool, bool) {
    let bases = Bases::new(bodies, state, agent);
    let (Some(p_near), Some(p_entity)) = (bases.place(near), bases.place(entity)) else {
        return (false, false);
    };
    // What it holds goes with it wherever it stands: that is no place to stand near.
    if bases.has(near) {
        return (false, false);
    }
    let landmark = bases.bodies_of(near);
    // Whether it suits with that slack; a negative one asks for room to spare.
    let suits = |X_WB: &Pose, slack: f64| {
        bases.distance_to_axis(X_WB, &landmark) <= NEAR + slack
            && (bases.has(entity) || bases.spare_length(X_WB, entity) >= -slack)
            && if slack >= 0.0 {
                bases.is_free(X_WB, slack.max(TOUCH))
            } else {
                bases.is_clear(X_WB, CLEAR)
            }
    };
    if bodies.scene.agents[agent].base == BaseKind::Fixed {
        let here = &state.agents[agent].X_WB;
        return (suits(here, 0.001), suits(here, -0.001));
    }
    let span = landmark
        .iter()
        .map(|b| (b.X_WS.translation.vector - p_near).norm() + b.solid.radius());
    let n = ((span.fold(0.0, f64::max) + NEAR + SLACK) / LATTICE).ceil() as i32;
    let place = |i: i32, j: i32| (p_near.x + f64::from(i) * LATTICE, p_near.y + f64::from(j) * LATTICE);
    let facing = |x: f64, y: f64| RealField::atan2(p_entity.y - y, p_entity.x - x);
    let mut may = false;
    let mut clear: BTreeSet<(i32, i32)> = BTreeSet::new();
    for (i, j) in (-n..=n).flat_map(|i| (-n..=n).map(move |j| (i, j))) {
        let (x, y) = place(i, j);
        let ahead = bases.at(x, y, facing(x, y));
        if bases.distance_to_axis(&ahead, &landmark) > NEAR + SLACK {
            continue;
        }
        may = may
            || [0.0, -FRAC_PI_4, FRAC_PI_4]
                .iter()
                .any(|turn| suits(&bases.at(x, y, facing(x, y) + turn), SLACK));
        if may && suits(&ahead, -SLACK) {
            clear.insert((i, j));
            // Three by three places hold one of the planner's, wherever its lattice lies.
            let block = (-1..=1).flat_map(|a| (-1..=1).map(move |b| (a, b)));
            let is_full = |c: (i32, i32)| block.clone().all(|(a, b)| clear.contains(&(c.0 + a, c.1 + b)));
            if block.clone().any(|(a, b)| is_full((i + a, j + b))) {
                return (true, true);
            }
        }
    }
    (may, false)
}

/// Says whether the agent may be able to go to where it reaches the entity. What it reaches where it stands is the caller's affair.
pub(super) fn path(bodies: &Bodies<'_>, state: &State, agent: usize, entity: EntityRef, settings: &Settings) -> bool {
    let bases = Bases::new(bodies, state, agent);
    let Some(goal) = bases.place(entity) else { return false };
    if bases.has(entity) {
        return true;
    }
    let here = state.agents[agent].X_WB;
    let is_taken = matches!(entity, EntityRef::Object(o) if bodies.scene.objects[o].movable);
    if !is_taken && bases.spare_length(&here, entity) >= -SLACK {
        return true;
    }
    if bodies.scene.agents[agent].base == BaseKind::Fixed {
        return false;
    }
    let ahead = here.rotation * Vec3::x();
    let yaw = RealField::atan2(ahead.y, ahead.x);
    let origin = here.translation.vector;
    let pose = |(i, j, h): (i32, i32, i32), (a, b, c): (f64, f64, f64)| {
        let turn = 2.0 * PI / f64::from(TURNS);
        bases.at(
            origin.x + (f64::from(i) + a) * STEP,
            origin.y + (f64::from(j) + b) * STEP,
            yaw + (f64::from(h) + c) * turn,
        )
    };
    let spread = bases.others.iter().map(|b| {
        let p = b.X_WS.translation.vector - origin;
        p.x.abs().max(p.y.abs()) + b.solid.radius()
    });
    let border = ((spread.fold(0.0, f64::max) + 2.0) / STEP).ceil() as i32;
    // Nearest to the goal first, so that what can be confirmed is confirmed soon; all of it, if need be.
    let far = |n: (i32, i32, i32)| (pose(n, (0.0, 0.0, 0.0)).translation.vector - goal).xy().norm();
    let rank = |n: (i32, i32, i32)| (far(n) * 1e6).round() as i64;
    let start = (0, 0, 0);
    let mut flooded = BTreeSet::from([start]);
    let mut open = BinaryHeap::from([Reverse((rank(start), start))]);
    let (mut tried, mut directions) = (0, BTreeSet::new());
    while let Some(Reverse((_, node))) = open.pop() {
        let X_WB = pose(node, (0.0, 0.0, 0.0));
        let p_BE = X_WB.inverse() * nalgebra::Point3::from(goal);
        let is_ahead = RealField::atan2(p_BE.y, p_BE.x).abs() <= 0.5 * PI;
        if is_ahead && bases.spare_length(&X_WB, entity) >= 0.0 {
            if !is_taken {
                return true;
            }
            // One stand for each direction, distance and heading that differ by much.
            let p_EB = X_WB.translation.vector - goal;
            let direction = (RealField::atan2(p_EB.y, p_EB.x) / FRAC_PI_4).round() as i32;
            if directions.insert((direction, (far(node) / 0.1) as i32, node.2)) {
                tried += 1;
                if tried <= MAX_STANDS && bases.reaches_from(&X_WB, entity, settings) {
                    return true;
                }
            }
        }
        if flooded.len() > MAX_FLOODED {
            break;
        }
        for (a, b, c) in MOVES {
            let next = (node.0 + a, node.1 + b, (node.2 + c).rem_euclid(TURNS));
            if next.0.abs() > border || next.1.abs() > border || flooded.contains(&next) {
                continue;
            }
            let checks = if c == 0 { 4 } else { 16 };
            let is_free = (1..=checks).all(|k| {
                let t = f64::from(k) / f64::from(checks);
                bases.is_free(
                    &pose(node, (t * f64::from(a), t * f64::from(b), t * f64::from(c))),
                    TOUCH,
                )
            });
            if is_free {
                flooded.insert(next);
                open.push(Reverse((rank(next), next)));
            }
        }
    }
    false
}
