//! Where an agent's base can stand and go: the requests `enoughRoom` and `pathExists` (thesis 4.4.1).
//!
//! The agent goes as it is: its joints, and what it holds, stay as they are. Real shapes against everything else. Paths are those of
//! `geom::navigation`, on places [`STEP`] apart, any one that leads there. Not here: human comfort along the path and arms that draw in before
//! they go (`navigate`), steps and slopes.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;

use nalgebra::RealField;

use super::facts;
use super::free_place::wide;
use super::ground::{Ground, People};
use super::prepared::{MARGIN, Owner, Placed, Prepared, link_poses, overlap, place_all};
use crate::geom::collide::{Solid, distance};
use crate::geom::navigation::grid::Grid;
use crate::geom::navigation::search::{Arrival, Goal, Settings, search};
use crate::geom::navigation::{Place, direction};
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{BaseKind, EntityRef, Scene, State};

/// Distance of neighbouring places of the grid [m]; headings are 45 degrees apart.
pub(super) const STEP: f64 = 0.1;
/// Places and headings looked at before a search gives up.
const MAX_NODES: usize = 20_000;
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
/// What lengths may be off by [m].
const ROUNDING: f64 = 1e-9;
/// A body of the agent, or of what it holds.
pub(super) struct Own {
    pub owner: Owner,
    pub shape: Shape,
    pub exact: Solid,
    /// By [`TOUCH`], and by [`MARGIN`].
    pub shrunk: Solid,
    pub grown: Solid,
    pub X_BS: Pose,
}

/// The question at hand: who goes, and among what.
pub(super) struct Bases<'a> {
    pub scene: &'a Scene,
    prepared: &'a Prepared,
    pub state: &'a State,
    pub agent: usize,
    seed: u64,
    /// The agent's bodies and those of what it holds, largest first.
    pub own: Vec<Own>,
    /// How far they reach from the base's axis, and from where to where above its floor [m].
    pub radius: f64,
    low: f64,
    high: f64,
    pub others: Vec<Placed<'a>>,
    /// Those of `others` that are at the agent's height: their position there, and a box around them on the floor.
    in_the_way: Vec<(usize, Footprint)>,
    /// By position in `others`.
    footprints: Vec<Footprint>,
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
        let mut shapes: Vec<(Owner, &Shape, Pose)> = Vec::new();
        for body in &scene.agents[agent].bodies {
            let owner = Owner::Link { agent, link: body.link };
            shapes.push((owner, &body.shape, X_BW * X_WL[agent][body.link] * body.X_LS));
        }
        for (o, object) in scene.objects.iter().enumerate().filter(|(o, _)| holds(*o)) {
            let parts = object.parts.iter();
            shapes.extend(parts.map(|p| (Owner::Object(o), &p.shape, X_BW * state.objects[o].X_WO * p.X_OS)));
        }
        let (mut radius, mut low, mut high) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
        let mut own = Vec::with_capacity(shapes.len());
        for (owner, shape, X_BS) in shapes {
            radius = radius.max(wide(shape, &X_BS));
            let exact = Solid::new(shape);
            let (z, half) = (X_BS.translation.z, exact.half_extent(&X_BS).z);
            (low, high) = (low.min(z - half), high.max(z + half));
            own.push(Own {
                owner,
                shape: shape.clone(),
                shrunk: Solid::padded(shape, -TOUCH),
                grown: Solid::padded(shape, MARGIN),
                exact,
                X_BS,
            });
        }
        own.sort_by(|a, b| b.exact.radius().total_cmp(&a.exact.radius()));
        let others = place_all(prepared, state, &X_WL, &|owner| match owner {
            Owner::Link { agent: a, .. } => a == agent,
            Owner::Object(o) => holds(o),
        });
        let z = state.agents[agent].X_WB.translation.z;
        let (mut footprints, mut in_the_way) = (Vec::with_capacity(others.len()), Vec::new());
        for (i, b) in others.iter().enumerate() {
            let (p, half) = (b.X_WS.translation.vector, b.solid.half_extent(&b.X_WS));
            let footprint = Footprint {
                middle: [p.x, p.y],
                half: [half.x, half.y],
            };
            footprints.push(footprint);
            if p.z - half.z <= z + high + MARGIN && p.z + half.z >= z + low - MARGIN {
                in_the_way.push((i, footprint));
            }
        }
        Bases {
            scene,
            prepared,
            state,
            agent,
            seed,
            own,
            radius,
            low,
            high,
            others,
            in_the_way,
            footprints,
        }
    }

    /// Returns X_WB as it is.
    pub(super) fn here(&self) -> Pose {
        self.state.agents[self.agent].X_WB
    }

    /// Returns from where to where above its floor the agent reaches [m].
    pub(super) fn heights(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// Returns the height of its middle above its floor [m].
    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Returns an upright cylinder about it, whose middle is at that height on the base's axis.
    pub(super) fn cylinder(&self) -> Shape {
        Shape::Cylinder {
            radius: self.radius,
            half_length: (0.5 * (self.high - self.low)).max(0.0),
        }
    }

    /// Returns the positions of what can touch the agent with its base at `X_WB`, or come as near to it as `spare` [m].
    pub(super) fn near(&self, X_WB: &Pose, spare: f64) -> Vec<usize> {
        let (x, y) = (X_WB.translation.x, X_WB.translation.y);
        let reach = self.radius + spare + ROUNDING;
        let near = self.in_the_way.iter().filter(|(_, f)| f.is_within(reach, x, y));
        near.map(|(i, _)| *i).collect()
    }

    /// Says whether a solid there can touch one of the others, by a box around that on the floor.
    pub(super) fn may_meet(&self, other: usize, solid: &Solid, X_WS: &Pose) -> bool {
        let (x, y) = (X_WS.translation.x, X_WS.translation.y);
        self.footprints[other].is_within(solid.radius() + ROUNDING, x, y)
    }

    /// Says whether the agent's shapes are free there, but for a touch.
    fn is_free(&self, X_WB: &Pose) -> bool {
        let near = self.near(X_WB, 0.0);
        near.is_empty()
            || self.own.iter().all(|own| {
                let X_WS = X_WB * own.X_BS;
                !near.iter().any(|i| {
                    let b = &self.others[*i];
                    self.may_meet(*i, &own.shrunk, &X_WS) && overlap(&own.shrunk, &X_WS, b.solid, &b.X_WS)
                })
            })
    }

    /// Returns the corners of the floor that is worth going on: a lap around everything.
    pub(super) fn corners(&self) -> [Place; 2] {
        let here = self.here().translation;
        let (mut low, mut high) = ([here.x, here.y], [here.x, here.y]);
        for (_, f) in &self.in_the_way {
            for axis in 0..2 {
                low[axis] = low[axis].min(f.middle[axis] - f.half[axis]);
                high[axis] = high[axis].max(f.middle[axis] + f.half[axis]);
            }
        }
        let lap = 2.0 * self.radius + 0.5;
        [low.map(|x| x - lap), high.map(|x| x + lap)]
    }

    /// Returns the grid on which the base goes, with cells of that side [m].
    pub(super) fn grid(&self, cell: f64) -> Grid {
        let [low, high] = self.corners();
        let here = self.here();
        let ahead = here.rotation * Vec3::x();
        let origin = [
            here.translation.x,
            here.translation.y,
            RealField::atan2(ahead.y, ahead.x),
        ];
        let corners = [low, high, [low[0], high[1]], [high[0], low[1]]];
        Grid::new(origin, cell, &corners)
    }

    /// Returns the pose of a base at (x, y) on its floor with that heading.
    pub(super) fn at(&self, x: f64, y: f64, yaw: f64) -> Pose {
        Pose::new(
            Vec3::new(x, y, self.state.agents[self.agent].X_WB.translation.z),
            Vec3::z() * yaw,
        )
    }

    pub(super) fn bodies(&self, entity: EntityRef) -> Vec<&Placed<'a>> {
        let is_own = |owner: Owner| match (owner, entity) {
            (Owner::Link { agent, .. }, EntityRef::Agent(a)) => agent == a,
            (Owner::Object(object), EntityRef::Object(o)) => object == o,
            (Owner::Link { .. } | Owner::Object(_), _) => false,
        };
        self.others.iter().filter(|b| is_own(b.owner)).collect()
    }

    /// Returns the frame origin of an entity [m].
    pub(super) fn place(&self, entity: EntityRef) -> Option<Vec3> {
        match entity {
            EntityRef::Agent(a) => Some(self.state.agents[a].X_WB.translation.vector),
            EntityRef::Object(o) => Some(self.state.objects[o].X_WO.translation.vector),
            EntityRef::Virtual(_) => None,
        }
    }

    /// Returns the shoulders of an agent with what its arms can reach at most, both [m]; hands that are full left out.
    pub(super) fn shoulders(&self, agent: usize) -> Vec<(Vec3, f64)> {
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

    /// Returns the shoulders of the agent's arms that hold something, as [`Bases::shoulders`] does for the others.
    pub(super) fn full_shoulders(&self) -> Vec<(Vec3, f64)> {
        let at = &self.state.agents[self.agent];
        let X_WL = self.scene.agents[self.agent].tree.link_poses(&at.X_WB, &at.q);
        let held = self.state.objects.iter().filter_map(|o| o.held.as_ref());
        held.filter(|h| h.agent == self.agent)
            .map(|h| &self.prepared.agents[self.agent].arms[h.arm])
            .map(|arm| (X_WL[arm.shoulder_link].translation.vector, arm.reach))
            .collect()
    }

    /// Says whether an empty hand could come to the entity with the base at `X_WB`, by lengths alone; two agents, whether their
    /// hands could meet.
    pub(super) fn is_in_arms_length(&self, X_WB: &Pose, shoulders: &[(Vec3, f64)], entity: EntityRef) -> bool {
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
    pub(super) fn has(&self, entity: EntityRef) -> bool {
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
    pub(super) fn is_at_height(&self, shoulders: &[(Vec3, f64)], entity: EntityRef) -> bool {
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
        let Some(drive) = self.scene.agents[self.agent].base.drive() else {
            return false;
        };
        let comfortable = COMFORTABLE * shoulders.iter().map(|s| s.1).fold(0.0, f64::max);
        let mut goal = Reach {
            bases: self,
            shoulders,
            entity,
            goal: [goal.x, goal.y],
            comfortable,
            tried: BTreeSet::new(),
        };
        let settings = Settings {
            drive,
            max_nodes: MAX_NODES,
            greed: GREED,
        };
        let mut ground = Ground::new(self, People::nobody());
        search(&self.grid(STEP), &mut ground, &mut goal, settings).is_ok()
    }
}

/// Any place from which the agent reaches the entity.
struct Reach<'a, 'b> {
    bases: &'b Bases<'a>,
    shoulders: &'b [(Vec3, f64)],
    entity: EntityRef,
    goal: Place,
    /// So near is near enough to begin to ask [m].
    comfortable: f64,
    tried: BTreeSet<(i32, i32)>,
}

impl Goal for Reach<'_, '_> {
    fn metres_left(&self, place: Place) -> f64 {
        (crate::geom::navigation::apart(place, self.goal) - self.comfortable).max(0.0)
    }

    fn accepts(&mut self, at: &Arrival) -> Option<f64> {
        let heading = at.heading.unwrap_or_else(|| direction(at.place, self.goal));
        let X_WB = self.bases.at(at.place[0], at.place[1], heading);
        let reaches = self
            .bases
            .reaches_from(&X_WB, self.shoulders, self.entity, &mut self.tried);
        reaches.then_some(heading)
    }

    fn is_over(&self) -> bool {
        self.tried.len() >= MAX_TRIES
    }
}
