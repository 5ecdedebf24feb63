//! Actions that go (thesis 3.3.2.4, formula 3.6): the arms to their posture for going, then the base to where it reaches an entity.
//!
//! Stands are a bounded, well-spread sample of the floor around the entity, shifted by the seed. One search over the floor, by what people mind
//! (`geom::navigation::comfort`), meets them in the order of the cost of the way there; the first from which the entity is reached is the solution, and
//! an alternative is the next one: never one given before. The way is free for the true shapes, arms and what is held included.
//!
//! *Reached* is: a movable object by inverse kinematics with collisions (`isReachable`); furniture and agents by the length of the arms, of those that
//! hold something where some do. Not here: moving people, the torso and the head (they stay as they are), two agents that go at the same time.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use indexmap::IndexMap;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::bases::Bases;
use super::body_space::BodySpace;
use super::candidates::halton;
use super::constraints::{self, Constraints, Which};
use super::cost::LENGTH_WEIGHT;
use super::description::{Asked, asked};
use super::facts;
use super::ground::{Ground, People};
use super::key::Key;
use super::motion::{self, NoMotion, Timed};
use super::requests::{self, Answer, Question};
use super::solve::{Counts, Room, count};
use super::{Gas, Grp, Work};
use crate::engine::{Call, GasNum};
use crate::geom::motion::length;
use crate::geom::navigation::comfort::Cost;
use crate::geom::navigation::grid::Grid;
use crate::geom::navigation::search::{Arrival, Goal, NoPath, Settings, search};
use crate::geom::navigation::{BasePose, Floor, Place, apart, direction, path, timing, wrapped};
use crate::geom::{Pose, Vec3};
use crate::ir::geometric::{Geometric, Space};
use crate::ir::{Domain, ParamId, Value};
use crate::plan::{self, ActionRefusal, Cause, CauseCount, Geometry, Motion, SubAction, Trajectory};
use crate::world::{AgentKind, EntityRef, Scene, State};

/// Side of a cell of the floor [m].
const CELL: f64 = 0.05;
/// Places and headings looked at before a search gives up.
const MAX_NODES: usize = 300_000;
/// Points drawn for each stand that is wanted at most.
const DRAWS: u32 = 4;
/// Direct ways tried to make a path shorter.
const JOINTS: usize = 200;
/// HEURISTIC: arms seldom reach farther than this share of the sum of their links; a stand is to be of use.
const REACHES: f64 = 0.7;
/// A stand's heading is met by one of the lattice's within half of its steps [rad].
const HALF_TURN: f64 = std::f64::consts::FRAC_PI_8 + 1e-9;
/// Spacing of the samples of a way's cost [m].
const SAMPLES: f64 = 0.02;
/// The posture of an agent that goes.
const POSTURE: &str = "navigation";
/// A base whose vertical is off by more than this, by its cosine, stands on no floor.
const UPRIGHT: f64 = 0.9999;

impl Grp<'_> {
    /// Returns the number of an action that goes, in the current world state, started now if it was not before.
    ///
    /// # Errors
    ///
    /// A sentence: what is wrong with its arguments.
    pub(super) fn start_journey(
        &mut self,
        domain: &Domain,
        call: &Call<'_>,
        action: &Arc<Geometric>,
    ) -> Result<GasNum, String> {
        let (agent, target) = goer(self.scene, domain, action, call.args)?;
        let state = self.states.last().cloned().ok_or("there is no world state")?;
        let number = match target {
            EntityRef::Agent(a) => (1 << 32) + a as u64,
            EntityRef::Object(o) | EntityRef::Virtual(o) => o as u64,
        };
        let key = Key::new(self.seed)
            .text(&action.name)
            .number(agent as u64)
            .number(number)
            .state(&state);
        let constraints = Constraints::new(self.scene, domain, call.constraints);
        // The same action with other constraints is another search; its stands are the same ones.
        let searched = if constraints.is_empty() {
            key
        } else {
            key.text(&format!("{:?}", call.constraints))
        };
        if let Some(gas) = self.by_key.get(&searched) {
            return Ok(*gas);
        }
        let gas = GasNum(self.gases.len() as u32);
        let entities: Vec<EntityRef> = call
            .args
            .iter()
            .filter_map(|value| constraints::entity(self.scene, domain, value))
            .collect();
        if entities.len() != call.args.len() {
            return Err("not every argument is an entity of the world file".into());
        }
        let of_facts = action.sub_actions.iter().flat_map(|s| &s.facts);
        let facts = of_facts
            .map(|fact| asked(self.scene, domain, fact, &entities))
            .collect();
        let wanted = (constraints, facts);
        let journey = Journey::new(self.scene, Arc::clone(action), (agent, target), wanted, state, key);
        self.gases.push(Gas {
            work: Work::Going(Box::new(journey)),
            solved: Vec::new(),
        });
        self.by_key.insert(searched, gas);
        Ok(gas)
    }
}

/// Returns who goes and where to.
///
/// # Errors
///
/// A sentence: what is wrong with the arguments.
pub(super) fn goer(
    scene: &Scene,
    domain: &Domain,
    action: &Geometric,
    args: &[Value],
) -> Result<(usize, EntityRef), String> {
    if args.len() != action.params.len() {
        let (n, m) = (action.params.len(), args.len());
        return Err(format!("`{}` takes {n} arguments, not {m}", action.name));
    }
    let (agent, entity) = action.goes().ok_or_else(|| format!("`{}` goes nowhere", action.name))?;
    let of = |at: ParamId| {
        let value = &args[at.index()];
        constraints::entity(scene, domain, value)
            .ok_or_else(|| format!("{} is not in the world file", domain.show(value)))
    };
    match (of(agent)?, of(entity)?) {
        (EntityRef::Agent(agent), entity) => Ok((agent, entity)),
        (EntityRef::Object(_) | EntityRef::Virtual(_), _) => {
            Err(format!("{} is not an agent", domain.show(&args[agent.index()])))
        }
    }
}

/// One sub-action, done.
#[derive(Debug, Clone)]
pub(super) struct Leg {
    pub name: String,
    pub motion: Motion,
    /// Names of the trajectory's columns.
    pub joints: Vec<String>,
    pub timed: Timed,
    pub end: State,
}

/// A solution: an agent has gone somewhere.
#[derive(Debug, Clone)]
pub(super) struct Gone {
    pub legs: Vec<Leg>,
    pub stand: BasePose,
    /// Of the cost, by name.
    pub parts: IndexMap<String, f64>,
}

impl Gone {
    /// Returns the world state that it leads to.
    pub(super) fn end(&self) -> Option<&State> {
        self.legs.last().map(|leg| &leg.end)
    }

    /// Returns how long it takes [s].
    pub(super) fn duration(&self) -> f64 {
        self.legs.iter().filter_map(|leg| leg.timed.times.last()).sum()
    }
}

/// A place to stand, and what became of it.
#[derive(Debug, Clone, Copy)]
struct Stand {
    pose: BasePose,
    is_waiting: bool,
    /// Whether it was found that the entity is reached from there.
    suits: bool,
}

/// An action that goes, at work.
#[derive(Debug)]
pub(super) struct Journey {
    pub action: Arc<Geometric>,
    pub agent: usize,
    pub target: EntityRef,
    constraints: Constraints,
    /// What must hold when it is there.
    facts: Vec<Asked>,
    start: State,
    key: Key,
    /// With the arms drawn in, once that was tried.
    drawn: Option<Vec<Leg>>,
    stands: BTreeMap<[i32; 2], Stand>,
    is_over: bool,
    tried: u32,
    found: u32,
    causes: Vec<CauseCount>,
}

impl Journey {
    pub(super) fn new(
        scene: &Scene,
        action: Arc<Geometric>,
        (agent, target): (usize, EntityRef),
        (constraints, facts): (Constraints, Vec<Asked>),
        start: State,
        key: Key,
    ) -> Journey {
        let mut journey = Journey {
            action,
            agent,
            target,
            constraints,
            facts,
            start,
            key,
            drawn: None,
            stands: BTreeMap::new(),
            is_over: false,
            tried: 0,
            found: 0,
            causes: Vec::new(),
        };
        if let Some(text) = journey.constraints.broken(Which::Decided, &mut |_| None) {
            journey.stop(Cause::Constraint(text));
        } else if let Some(why) = journey.is_impossible(scene) {
            journey.stop(Cause::NotApplicable(why));
        }
        journey
    }

    fn stop(&mut self, cause: Cause) {
        self.count("", cause);
        self.is_over = true;
    }

    fn is_impossible(&self, scene: &Scene) -> Option<String> {
        let body = &scene.agents[self.agent];
        if body.base.drive().is_none() {
            return Some(format!("the base of {} does not go on the floor", body.id));
        }
        if (self.start.agents[self.agent].X_WB.rotation * Vec3::z()).z < UPRIGHT {
            return Some(format!("{} does not stand upright", body.id));
        }
        if body.manner.is_sitting {
            return Some(format!("{} sits", body.id));
        }
        match self.target {
            EntityRef::Agent(a) if a == self.agent => return Some(format!("{} is there already", body.id)),
            EntityRef::Virtual(v) => return Some(format!("{} is nowhere", scene.virtuals[v].id)),
            EntityRef::Object(o) if facts::has_in_hand(&self.start, self.agent, o) => {
                return Some(format!("{} has {} in its hand", body.id, scene.objects[o].id));
            }
            EntityRef::Agent(_) | EntityRef::Object(_) => {}
        }
        // What stands on a held thing would not move with it.
        let held = (0..scene.objects.len()).filter(|o| facts::has_in_hand(&self.start, self.agent, *o));
        for tray in held {
            let on = (0..scene.objects.len()).find(|o| facts::is_on(scene, &self.start, *o, tray));
            if let Some(on) = on {
                let (on, tray) = (&scene.objects[on].id, &scene.objects[tray].id);
                return Some(format!("{on} stands on {tray}, which {} holds", body.id));
            }
        }
        None
    }

    /// Returns the next solution, never one given before; `None` when there is none, or somebody stopped the search.
    pub(super) fn next_solution(&mut self, room: &Room<'_>, counts: &mut Counts) -> Option<Gone> {
        if self.is_over || room.stop.load(Ordering::Relaxed) {
            return None;
        }
        let is_first = self.drawn.is_none();
        let legs = match self.drawn.take() {
            Some(legs) => legs,
            None => match self.draw_in(room, counts) {
                Ok(legs) => legs,
                Err((name, cause)) => {
                    self.count(&name, cause);
                    self.is_over = true;
                    return None;
                }
            },
        };
        self.drawn = Some(legs.clone());
        let from = legs.last().map_or_else(|| self.start.clone(), |leg| leg.end.clone());
        let bases = Bases::new(room.scene, room.prepared, &from, self.agent, room.seed);
        let mut ground = Ground::new(&bases, People::around(room.scene, &from, self.agent));
        let grid = bases.grid(CELL);
        let name = self.way_name();
        if is_first {
            self.sample(room, &bases, &mut ground, &grid);
        }
        let gone = self.go(room, counts, &bases, &mut ground, &grid);
        counts.configurations_checked += ground.checks;
        match gone {
            Some((pose, timed, cost)) => {
                self.found += 1;
                let mut legs = legs;
                let end = moved(room.scene, &from, self.agent, &bases.at(pose[0], pose[1], pose[2]));
                legs.push(Leg {
                    name,
                    motion: Motion::Base,
                    joints: ["x", "y", "yaw"].map(str::to_owned).to_vec(),
                    timed,
                    end,
                });
                let parts = self.parts(room.scene, &legs, &cost);
                Some(Gone {
                    legs,
                    stand: [pose[0], pose[1], wrapped(pose[2])],
                    parts,
                })
            }
            None => {
                self.is_over = true;
                None
            }
        }
    }

    fn way_name(&self) -> String {
        let way = self
            .action
            .sub_actions
            .iter()
            .find(|s| matches!(s.space, Space::Base(_)));
        way.map_or_else(String::new, |s| s.name.clone())
    }

    /// Brings the arms into the posture for going; the fingers, the torso and the head stay as they are.
    fn draw_in(&mut self, room: &Room<'_>, counts: &mut Counts) -> Result<Vec<Leg>, (String, Cause)> {
        let (scene, agent) = (room.scene, self.agent);
        let body = &scene.agents[agent];
        let mut legs: Vec<Leg> = Vec::new();
        let draws = self
            .action
            .sub_actions
            .iter()
            .filter(|s| matches!(s.space, Space::Body(_)));
        for sub_action in draws {
            let from = legs.last().map_or(&self.start, |leg| &leg.end).clone();
            // An agent without such a posture goes as it is.
            let Some(posture) = body.postures.get(POSTURE) else {
                continue;
            };
            let q = &from.agents[agent].q;
            let mut dofs: Vec<usize> = body.arms.iter().flat_map(|arm| arm.dofs.iter().copied()).collect();
            dofs.sort_unstable();
            dofs.dedup();
            dofs.retain(|d| (q[*d] - posture[*d]).abs() > 1e-9);
            if dofs.is_empty() {
                continue;
            }
            let goal: Vec<f64> = dofs.iter().map(|d| posture[*d]).collect();
            let mut space = BodySpace::new(scene, room.prepared, &from, agent, &dofs);
            let start = space.start();
            let mut rng = ChaCha8Rng::seed_from_u64(self.key.text("draw in").0);
            counts.motion_plans += 1;
            let timed = motion::free_of(&mut space, &start, &goal, room.settings.motion_samples, &mut rng);
            counts.configurations_checked += space.checks;
            let timed = timed.map_err(|no| {
                let hit = space.hit_names();
                let cause = match (no, hit) {
                    (NoMotion::Blocked(_), Some((a, b))) => Cause::Collision { a, b },
                    (NoMotion::OutOfSamples(samples), _) => Cause::NoPosture {
                        posture: POSTURE.to_owned(),
                        samples,
                    },
                    (NoMotion::Blocked(_), None) => Cause::NotApplicable("the arms can't move".into()),
                };
                (sub_action.name.clone(), cause)
            })?;
            let mut end = from.clone();
            for (dof, value) in dofs.iter().zip(&goal) {
                end.agents[agent].q[*dof] = *value;
            }
            let X_WB = end.agents[agent].X_WB;
            legs.push(Leg {
                name: sub_action.name.clone(),
                motion: Motion::Posture,
                joints: dofs.iter().map(|d| body.tree.dofs[*d].name.clone()).collect(),
                timed,
                end: moved(scene, &end, agent, &X_WB),
            });
        }
        Ok(legs)
    }

    /// Draws the stands around the entity: cells from which it is in arm's length, and where the agent is free.
    fn sample(&mut self, room: &Room<'_>, bases: &Bases<'_>, ground: &mut Ground<'_>, grid: &Grid) {
        let Some(p_WE) = bases.place(self.target) else { return };
        let shoulders = arms_to_reach(bases);
        let bodies = bases.bodies(self.target);
        let (mut low, mut high) = ([p_WE.x, p_WE.y], [p_WE.x, p_WE.y]);
        for b in &bodies {
            let (p, half) = (b.X_WS.translation.vector, b.solid.half_extent(&b.X_WS));
            for axis in 0..2 {
                low[axis] = low[axis].min(p[axis] - half[axis]);
                high[axis] = high[axis].max(p[axis] + half[axis]);
            }
        }
        let other = match self.target {
            EntityRef::Agent(a) => bases.shoulders(a).iter().map(|s| s.1).fold(0.0, f64::max) * REACHES,
            EntityRef::Object(_) | EntityRef::Virtual(_) => 0.0,
        };
        // A shoulder lies within the agent's radius of its base.
        let reach = shoulders.iter().map(|s| s.1).fold(0.0, f64::max) + other + bases.radius;
        let mut rng = ChaCha8Rng::seed_from_u64(self.key.text("stands").0);
        let shift: [f64; 2] = [rng.random(), rng.random()];
        let limit = room.settings.placements as usize;
        for k in 1..=room.settings.placements.saturating_mul(DRAWS) {
            if self.stands.len() >= limit {
                break;
            }
            let unit = |base: usize, i: usize| (halton(k as usize, base) + shift[i]).fract();
            let drawn: Place =
                std::array::from_fn(|i| low[i] - reach + unit([2, 3][i], i) * (high[i] - low[i] + 2.0 * reach));
            let cell = grid.around(drawn);
            if grid.index(cell).is_none() || self.stands.contains_key(&cell) {
                continue;
            }
            let place = grid.place(cell);
            // Furniture is faced where it is nearest, all else at its middle.
            let facing = match self.target {
                EntityRef::Object(o) if !room.scene.objects[o].movable => {
                    std::array::from_fn(|i| place[i].clamp(low[i], high[i]))
                }
                EntityRef::Object(_) | EntityRef::Agent(_) | EntityRef::Virtual(_) => [p_WE.x, p_WE.y],
            };
            if apart(place, facing) < CELL {
                continue;
            }
            let pose = [place[0], place[1], direction(place, facing)];
            if !bases.is_in_arms_length(&bases.at(pose[0], pose[1], pose[2]), &shoulders, self.target) {
                continue;
            }
            self.tried += 1;
            if ground.is_free(&pose) {
                self.stands.insert(
                    cell,
                    Stand {
                        pose,
                        is_waiting: true,
                        suits: false,
                    },
                );
            } else if let Some((a, b)) = ground.hit_names() {
                self.count(&self.way_name(), Cause::Collision { a, b });
            }
        }
    }

    /// Goes to the stand with the cheapest way from which the entity is reached: the pose at the end, the motion, the cost.
    fn go(
        &mut self,
        room: &Room<'_>,
        counts: &mut Counts,
        bases: &Bases<'_>,
        ground: &mut Ground<'_>,
        grid: &Grid,
    ) -> Option<(BasePose, Timed, Cost)> {
        let body = &room.scene.agents[self.agent];
        let drive = body.base.drive()?;
        let waiting: Vec<Place> = self
            .stands
            .values()
            .filter(|s| s.is_waiting)
            .map(|s| [s.pose[0], s.pose[1]])
            .collect();
        let middle = middle(&waiting)?;
        let spread = waiting.iter().map(|p| apart(*p, middle)).fold(0.0, f64::max);
        counts.motion_plans += 1;
        let mut goal = Stands {
            journey: self,
            room,
            counts,
            bases,
            middle,
            spread,
            left: waiting.len(),
            last: None,
        };
        let settings = Settings {
            drive,
            max_nodes: MAX_NODES,
            greed: 1.0,
        };
        match search(grid, ground, &mut goal, settings) {
            Ok(found) => {
                let ways = path::shortened(ground, &found.ways, drive, JOINTS);
                let timed = timing::time(ground, &ways, drive, &body.base_limits);
                let last = timed.positions.last()?;
                let pose = [*last.first()?, *last.get(1)?, *last.get(2)?];
                let cost = along(ground, &timed);
                Some((pose, timed, cost))
            }
            Err(no) => {
                let (NoPath::Exhausted { looked } | NoPath::Budget { looked }) = no;
                let left = self.stands.values().filter(|s| s.is_waiting).count();
                for _ in 0..left {
                    self.count(&self.way_name(), Cause::NoWay { looked });
                }
                for stand in self.stands.values_mut() {
                    stand.is_waiting = false;
                }
                None
            }
        }
    }

    /// Says whether the entity is reached from there and the domain's constraints hold; else counts why not.
    fn suits(&mut self, room: &Room<'_>, counts: &mut Counts, bases: &Bases<'_>, pose: &BasePose) -> bool {
        let (scene, prepared) = (room.scene, room.prepared);
        let there = moved(scene, bases.state, self.agent, &bases.at(pose[0], pose[1], pose[2]));
        counts.candidates += 1;
        if let EntityRef::Object(object) = self.target
            && scene.objects[object].movable
        {
            counts.facts += 1;
            if !facts::is_reachable(scene, prepared, &there, object, self.agent, room.seed) {
                let fact = format!(
                    "isReachable({}, {})",
                    scene.objects[object].id, scene.agents[self.agent].id
                );
                self.count(&self.way_name(), Cause::Fact(fact));
                return false;
            }
        }
        let mut ask = |question: Question| {
            match question {
                Question::Fact(_) => counts.facts += 1,
                _ => counts.requests += 1,
            }
            requests::answer(scene, prepared, &there, room.seed, question)
        };
        let missing = self.facts.iter().find(|fact| {
            let holds = fact.question.and_then(&mut ask) == Some(Answer::Truth(true));
            !holds
        });
        if let Some(missing) = missing {
            let fact = Cause::Fact(missing.text.clone());
            self.count(&self.way_name(), fact);
            return false;
        }
        match self.constraints.broken(Which::All, &mut ask) {
            Some(text) => {
                self.count(&self.way_name(), Cause::Constraint(text));
                false
            }
            None => true,
        }
    }

    /// Returns the parts of the cost: of the way by what people mind, of the arms by how far their joints move.
    fn parts(&self, scene: &Scene, legs: &[Leg], cost: &Cost) -> IndexMap<String, f64> {
        let mut parts = IndexMap::new();
        parts.insert("length".to_owned(), cost.length);
        let is_minded = scene.agents[self.agent].kind == AgentKind::Robot
            && scene.agents.iter().any(|a| a.kind == AgentKind::Human);
        if is_minded {
            parts.insert("distance".to_owned(), cost.distance);
            parts.insert("visibility".to_owned(), cost.visibility);
            parts.insert("hidden".to_owned(), cost.hidden);
        }
        let drawn = legs.iter().filter(|leg| leg.motion == Motion::Posture);
        let moved: f64 = drawn
            .flat_map(|leg| leg.timed.positions.windows(2).map(|w| length(&w[0], &w[1])))
            .sum();
        if moved > 0.0 {
            parts.insert("effort".to_owned(), LENGTH_WEIGHT * moved);
        }
        parts
    }

    fn count(&mut self, sub_action: &str, cause: Cause) {
        count(&mut self.causes, sub_action, cause);
    }

    /// Returns the choices and motions of a solution, for the plan document.
    pub(super) fn document(&self, scene: &Scene, gone: &Gone, (gas, alternative): (u32, u32)) -> Geometry {
        let sub_actions = gone.legs.iter().map(|leg| SubAction {
            name: leg.name.clone(),
            motion: leg.motion,
            trajectory: Trajectory {
                joints: leg.joints.clone(),
                times: leg.timed.times.clone(),
                positions: leg.timed.positions.clone(),
            },
            change: None,
        });
        let [x, y, yaw] = gone.stand;
        Geometry {
            action: self.action.name.clone(),
            gas,
            alternative,
            agent: scene.agents[self.agent].id.clone(),
            arm: String::new(),
            object: scene.id(self.target).to_owned(),
            grasp: String::new(),
            stand: Some(plan::Stand { x, y, yaw }),
            placement: None,
            cost_parts: gone.parts.clone(),
            sub_actions: sub_actions.collect(),
        }
    }

    /// Returns why there is no further solution.
    pub(super) fn refusal(&self, room: &Room<'_>) -> ActionRefusal {
        let mut causes = self.causes.clone();
        causes.sort_by_key(|c| std::cmp::Reverse(c.count));
        let (agent, target) = (&room.scene.agents[self.agent].id, room.scene.id(self.target));
        ActionRefusal {
            call: format!("{}({agent}, {target})", self.action.name),
            found_before: self.found,
            // Stands are a sample of the floor: all of them tried does not prove that there is none.
            exhausted: self.tried == 0 && self.is_over,
            tried: self.tried,
            causes,
        }
    }
}

/// The stands that are left, met in the order of the cost of their ways.
struct Stands<'a, 'b, 'c> {
    journey: &'b mut Journey,
    room: &'b Room<'a>,
    counts: &'b mut Counts,
    bases: &'b Bases<'c>,
    /// Around those that are left at the beginning.
    middle: Place,
    spread: f64,
    left: usize,
    /// The last one accepted.
    last: Option<[i32; 2]>,
}

impl Goal for Stands<'_, '_, '_> {
    fn metres_left(&self, place: Place) -> f64 {
        (apart(place, self.middle) - self.spread).max(0.0)
    }

    fn accepts(&mut self, at: &Arrival) -> Option<f64> {
        let stand = self.journey.stands.get(&at.cell).filter(|s| s.is_waiting).copied()?;
        if at.heading.is_some_and(|h| wrapped(h - stand.pose[2]).abs() > HALF_TURN) {
            return None;
        }
        let suits = stand.suits || self.journey.suits(self.room, self.counts, self.bases, &stand.pose);
        self.left -= 1;
        self.last = suits.then_some(at.cell);
        if let Some(stand) = self.journey.stands.get_mut(&at.cell) {
            (stand.is_waiting, stand.suits) = (false, suits);
        }
        suits.then_some(stand.pose[2])
    }

    fn take_back(&mut self) {
        if let Some(stand) = self.last.take().and_then(|cell| self.journey.stands.get_mut(&cell)) {
            stand.is_waiting = true;
            self.left += 1;
        }
    }

    fn is_over(&self) -> bool {
        self.left == 0 || self.room.stop.load(Ordering::Relaxed)
    }
}

/// Returns the middle of some places; `None` of none.
fn middle(places: &[Place]) -> Option<Place> {
    let n = places.len() as f64;
    let sum = |i: usize| places.iter().map(|p| p[i]).sum::<f64>();
    (!places.is_empty()).then(|| [sum(0) / n, sum(1) / n])
}

/// Returns the shoulders that are to reach, with how far they do at most: of the arms that hold something, where some do.
fn arms_to_reach(bases: &Bases<'_>) -> Vec<(Vec3, f64)> {
    let full = bases.full_shoulders();
    let arms = if full.is_empty() {
        bases.shoulders(bases.agent)
    } else {
        full
    };
    arms.into_iter().map(|(p, reach)| (p, REACHES * reach)).collect()
}

/// Returns the state with the agent's base elsewhere, and all that it holds with its hands.
pub(super) fn moved(scene: &Scene, state: &State, agent: usize, X_WB: &Pose) -> State {
    let mut there = state.clone();
    there.agents[agent].X_WB = *X_WB;
    let body = &scene.agents[agent];
    let X_WL = body.tree.link_poses(X_WB, &there.agents[agent].q);
    for object in &mut there.objects {
        if let Some(held) = object.held.as_ref().filter(|h| h.agent == agent) {
            let arm = &body.arms[held.arm];
            object.X_WO = X_WL[arm.tip_link] * arm.X_LT * held.X_TO;
        }
    }
    there
}

/// Returns the cost along a motion, by criterion.
fn along(ground: &Ground<'_>, timed: &Timed) -> Cost {
    let mut cost = Cost::default();
    for pair in timed.positions.windows(2) {
        let (a, b) = ([pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]]);
        let metres = apart(a, b);
        let n = (metres / SAMPLES).ceil().clamp(1.0, 10_000.0) as usize;
        if metres == 0.0 {
            continue;
        }
        for k in 0..n {
            let t = (k as f64 + 0.5) / n as f64;
            let place = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
            cost.add(&ground.criteria(place), metres / n as f64);
        }
    }
    cost
}
