//! The floor that one agent goes on in a world state: where its true shapes are free, and what a metre costs near people.
//!
//! The agent goes as it is: its joints, and what it holds, stay as they are relative to its base. A cylinder about the whole agent answers first.
//! Clearance is [`MARGIN`], or as much of it as the start has: who stands closer to something may still leave.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use nalgebra::RealField;

use super::bases::Bases;
use super::prepared::{MARGIN, Owner, link_poses, overlap};
use crate::geom::collide::{Solid, distance, ray};
use crate::geom::navigation::comfort::{Cost, Human, Weights};
use crate::geom::navigation::{BasePose, Floor, Place};
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::world::{AgentKind, Scene, State};

/// The clearance that is kept at least, but from what the agent touches at the start [m].
const LEAST_MARGIN: f64 = 0.0005;
/// Lengths of solids that can't be shrunk away [m].
const ROUNDING: f64 = 1e-9;

/// The people around an agent, and what they mind.
#[derive(Debug, Clone)]
pub(super) struct People {
    pub humans: Vec<Human>,
    /// Who each of them is.
    agents: Vec<usize>,
    /// Where their eyes are.
    eyes: Vec<Vec3>,
    weights: Weights,
}

impl People {
    /// Returns the humans that a robot has to mind; nobody, where a human goes himself.
    pub(super) fn around(scene: &Scene, state: &State, agent: usize) -> People {
        let mut people = People {
            humans: Vec::new(),
            agents: Vec::new(),
            eyes: Vec::new(),
            weights: scene.human_aware,
        };
        if scene.agents[agent].kind == AgentKind::Human {
            return people;
        }
        let X_WL = link_poses(scene, state);
        for (a, body) in scene.agents.iter().enumerate() {
            if body.kind != AgentKind::Human {
                continue;
            }
            let X_WC = match &body.camera {
                Some(camera) => X_WL[a][camera.link] * camera.X_LC,
                None => state.agents[a].X_WB,
            };
            let (eye, ahead) = (X_WC.translation.vector, X_WC.rotation * Vec3::x());
            people.humans.push(Human {
                place: [eye.x, eye.y],
                gaze: RealField::atan2(ahead.y, ahead.x),
                is_sitting: body.manner.is_sitting,
            });
            people.agents.push(a);
            people.eyes.push(eye);
        }
        people
    }

    /// Returns nobody, and a cost of 1 for each metre.
    pub(super) fn nobody() -> People {
        People {
            humans: Vec::new(),
            agents: Vec::new(),
            eyes: Vec::new(),
            weights: Weights {
                length: 1.0,
                ..Weights::default()
            },
        }
    }
}

/// The agent's floor.
pub(super) struct Ground<'a> {
    bases: &'a Bases<'a>,
    people: People,
    margin: f64,
    /// The agent's bodies, grown by the margin.
    grown: Vec<Solid>,
    /// Bodies of the agent and others that touch at the start: these are tested a little shrunk.
    touching: Vec<(usize, usize)>,
    /// A cylinder about the agent, and the same grown by some distance.
    cylinder: Shape,
    around: Option<(f64, Solid)>,
    /// The last overlap found.
    pub hit: Option<(Owner, Owner)>,
    /// Poses looked at.
    pub checks: u64,
}

impl<'a> Ground<'a> {
    pub(super) fn new(bases: &'a Bases<'a>, people: People) -> Ground<'a> {
        let mut ground = Ground {
            bases,
            people,
            margin: MARGIN,
            grown: Vec::new(),
            touching: Vec::new(),
            cylinder: bases.cylinder(),
            around: None,
            hit: None,
            checks: 0,
        };
        let here = bases.here();
        let near = bases.near(&here, MARGIN);
        for (k, own) in bases.own.iter().enumerate() {
            let X_WS = here * own.X_BS;
            for i in &near {
                let other = &bases.others[*i];
                // Far away, most of them.
                if !overlap(&own.grown, &X_WS, other.solid, &other.X_WS) {
                    continue;
                }
                let apart = distance(&own.exact, &X_WS, other.solid, &other.X_WS);
                if apart < 2.0 * LEAST_MARGIN {
                    ground.touching.push((k, *i));
                } else {
                    ground.margin = ground.margin.min(0.5 * apart);
                }
            }
        }
        ground.grown = if ground.margin < MARGIN {
            bases
                .own
                .iter()
                .map(|own| Solid::padded(&own.shape, ground.margin))
                .collect()
        } else {
            bases.own.iter().map(|own| own.grown.clone()).collect()
        };
        ground
    }

    /// Returns what a metre costs at a place, by criterion.
    pub(super) fn criteria(&self, place: Place) -> Cost {
        let mut is_hidden = |h: usize, place: Place| self.is_hidden(h, place);
        self.people.weights.at(&self.people.humans, place, &mut is_hidden)
    }

    /// Says whether nothing of the agent's middle and top, with its base there, is in the human's line of sight.
    fn is_hidden(&self, human: usize, [x, y]: Place) -> bool {
        let (eye, who) = (self.people.eyes[human], self.people.agents[human]);
        let (low, high) = self.bases.heights();
        let z = self.bases.here().translation.z;
        let points = [0.5 * (low + high), high - 0.1 * (high - low)];
        points.into_iter().all(|height| {
            let way = Vec3::new(x, y, z + height) - eye;
            let far = way.norm();
            let direction = way / far.max(ROUNDING);
            self.bases.others.iter().any(|b| {
                let is_own = matches!(b.owner, Owner::Link { agent, .. } if agent == who);
                !is_own && ray(b.solid, &b.X_WS, &eye, &direction, far).is_some()
            })
        })
    }

    /// Returns the names of the last overlap's bodies.
    pub(super) fn hit_names(&self) -> Option<(String, String)> {
        let scene = self.bases.scene;
        self.hit.map(|(a, b)| (a.name(scene), b.name(scene)))
    }
}

impl Floor for Ground<'_> {
    fn is_roomy(&mut self, [x, y]: Place, spare: f64) -> bool {
        let spare = spare + self.margin;
        let X_WB = self.bases.at(x, y, 0.0);
        let near = self.bases.near(&X_WB, spare);
        if near.is_empty() {
            return true;
        }
        let around = match &self.around {
            Some((known, solid)) if *known == spare => solid,
            _ => &self.around.insert((spare, Solid::padded(&self.cylinder, spare))).1,
        };
        let X_WS = X_WB * Pose::translation(0.0, 0.0, self.bases.middle());
        let others = near.iter().map(|i| &self.bases.others[*i]);
        !others.into_iter().any(|b| overlap(around, &X_WS, b.solid, &b.X_WS))
    }

    fn is_free(&mut self, pose: &BasePose) -> bool {
        self.checks += 1;
        let X_WB = self.bases.at(pose[0], pose[1], pose[2]);
        let near = self.bases.near(&X_WB, self.margin);
        if near.is_empty() {
            return true;
        }
        for (k, own) in self.bases.own.iter().enumerate() {
            let X_WS = X_WB * own.X_BS;
            for i in &near {
                let other = &self.bases.others[*i];
                if !self.bases.may_meet(*i, &self.grown[k], &X_WS) {
                    continue;
                }
                let touches = !self.touching.is_empty() && self.touching.contains(&(k, *i));
                let solid = if touches { &own.shrunk } else { &self.grown[k] };
                if overlap(solid, &X_WS, other.solid, &other.X_WS) {
                    self.hit = Some((own.owner, other.owner));
                    return false;
                }
            }
        }
        true
    }

    fn margin(&self) -> f64 {
        self.margin
    }

    fn cost(&mut self, place: Place) -> f64 {
        self.criteria(place).total()
    }

    fn least_cost(&self) -> f64 {
        self.people.weights.length
    }

    fn radius(&self) -> f64 {
        self.bases.radius
    }
}
