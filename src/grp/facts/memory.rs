//! What was asked about world states, kept together with what the answers rest on: after something has moved only those answers are
//! worked out again that could have changed (`docs/decisions/035-what-an-answer-rests-on.md`).
//!
//! An answer belongs to the places of the entities it is about, and to:
//! - nothing else ([`Rest::Entities`]): isNextTo, distance;
//! - a room that nothing may have come into since ([`Rest::Clear`]): a fact that holds, isVisible by the hull of the eye and the object, isReachable by
//!   the arm as it comes to the object. What was there already, or goes, does not matter: it can only make the fact truer;
//! - bodies that may not have moved ([`Rest::Blocked`]): a fact that does not hold, since they are in the way. What else comes does
//!   not matter;
//! - everything within some balls ([`Rest::Near`]): virtualPlace, whose search has a budget and no such monotony;
//! - the whole world ([`Rest::World`]).
//!
//! **Invariant:** with the memory and without it every answer is the same.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::super::free_place;
use super::super::prepared::{Owner, Prepared, overlap};
use super::super::relations;
use super::super::requests::{self, Answer, Fact, Question};
use super::layout::{Items, Layout, States};
use super::reach::{self, Obstacle, Reach};
use super::sight::{self, Eye, Surface};
use super::{has_in_hand, is_full};
use crate::geom::sight::Cone;
use crate::geom::{Pose, Vec3};
use crate::world::{EntityRef, Scene, State};

/// Answers remembered before the memory begins again.
const MOST: usize = 500_000;
/// Answers to one question about the same places, among different surroundings.
const MOST_OF_ONE: usize = 8;
/// Boxes about two bodies that are farther apart than this beyond [`relations::NEXT_TO`] settle isNextTo [m].
const CLEARLY: f64 = 1e-5;

/// A question, or one arm's part of it, and the versions of the places that it is about.
type Key = (Question, usize, u32, u32);

/// Answers and what they rest on.
#[derive(Debug)]
pub(in crate::grp) struct Memory {
    items: Items,
    /// By object.
    surfaces: Vec<Surface>,
    kept: FxHashMap<Key, Vec<Kept>>,
    n_kept: usize,
}

/// An answer, where everything was when it was found, and what it rests on.
#[derive(Debug)]
struct Kept {
    answer: Option<Answer>,
    layout: Arc<Layout>,
    rest: Rest,
}

/// What an answer rests on besides the places of what it is about.
#[derive(Debug)]
enum Rest {
    Entities,
    /// What has moved is not in there now.
    Clear(Room),
    /// None of these items has moved.
    Blocked(Vec<usize>),
    /// What has moved was not in one of these balls (centre, radius [m]) and is not; agents don't count.
    Near(Vec<(Vec3, f64)>),
    World,
}

/// A part of space.
#[derive(Debug)]
enum Room {
    Cone(Cone),
    /// An agent's bodies, padded: positions among its parts, and X_WS.
    Bodies(usize, Vec<(usize, Pose)>),
}

/// The world at hand.
struct At<'a> {
    scene: &'a Scene,
    prepared: &'a Prepared,
    state: &'a State,
    layout: &'a Arc<Layout>,
    seed: u64,
}

impl Memory {
    pub(in crate::grp) fn new(scene: &Scene, prepared: &Prepared) -> Memory {
        Memory {
            items: Items::new(scene, prepared),
            surfaces: scene.objects.iter().map(Surface::of).collect(),
            kept: FxHashMap::default(),
            n_kept: 0,
        }
    }

    /// Answers a question about the current state; `None` where there is no answer. `computed` counts what was not remembered and is more
    /// than a look at two places.
    pub(in crate::grp) fn ask(
        &mut self,
        scene: &Scene,
        prepared: &Prepared,
        states: &mut States,
        seed: u64,
        question: Question,
        computed: &mut u64,
    ) -> Option<Answer> {
        // What costs less than to remember it.
        if let Question::Fact(Fact::IsOn { .. } | Fact::IsIn { .. } | Fact::IsBigger { .. } | Fact::HasInHand { .. }) =
            question
        {
            return requests::answer(scene, prepared, states.last()?, seed, question);
        }
        let layout = states.layout(scene, prepared, &mut self.items)?;
        let at = At {
            scene,
            prepared,
            state: states.last()?,
            layout: &layout,
            seed,
        };
        match question {
            Question::Fact(fact) => self.fact(&at, fact, computed).map(Answer::Truth),
            Question::Distance { a, b } => {
                let (a, b) = (a.min(b), a.max(b));
                let about = (self.version(&at, a), self.version(&at, b));
                self.recall(
                    &at,
                    (Question::Distance { a, b }, 0, about.0, about.1),
                    computed,
                    |_| {
                        let apart = relations::apart(scene, prepared, at.state, a, b);
                        (apart.map(Answer::Length), Rest::Entities)
                    },
                )
            }
            Question::VirtualPlace { on, .. } => {
                let about = self.version(&at, EntityRef::Object(on));
                self.recall(&at, (question, 0, about, 0), computed, |_| {
                    let answer = requests::answer(scene, prepared, at.state, seed, question);
                    let balls = match question {
                        Question::VirtualPlace { thing, on } => free_place::looked_at(scene, at.state, thing, on),
                        _ => Vec::new(),
                    };
                    (answer, Rest::Near(balls))
                })
            }
            Question::EnoughRoom { .. } | Question::PathExists { .. } => {
                self.recall(&at, (question, 0, 0, 0), computed, |_| {
                    (requests::answer(scene, prepared, at.state, seed, question), Rest::World)
                })
            }
        }
    }

    fn fact(&mut self, at: &At<'_>, fact: Fact, computed: &mut u64) -> Option<bool> {
        let truth = match fact {
            Fact::IsOn { .. } | Fact::IsIn { .. } | Fact::IsBigger { .. } | Fact::HasInHand { .. } => {
                requests::holds(at.scene, at.prepared, at.state, at.seed, fact)
            }
            Fact::IsNextTo { a, b } => {
                let (a, b) = (a.min(b), a.max(b));
                let limit = relations::NEXT_TO + relations::ROUNDING;
                if at.layout.at_least_apart(a, b) > limit + CLEARLY {
                    return Some(false);
                }
                let about = (self.version(at, a), self.version(at, b));
                let apart = self.recall(at, (Question::Distance { a, b }, 0, about.0, about.1), computed, |_| {
                    let apart = relations::apart(at.scene, at.prepared, at.state, a, b);
                    (apart.map(Answer::Length), Rest::Entities)
                });
                matches!(apart, Some(Answer::Length(d)) if d <= limit)
            }
            Fact::IsReachable { object, agent } => self.is_reachable(at, object, agent, computed),
            Fact::IsVisible { object, agent } => self.is_visible(at, object, agent, computed),
        };
        Some(truth)
    }

    fn is_reachable(&mut self, at: &At<'_>, object: usize, agent: usize, computed: &mut u64) -> bool {
        if has_in_hand(at.state, agent, object) {
            return false;
        }
        let question = Question::Fact(Fact::IsReachable { object, agent });
        let about = (
            self.version(at, EntityRef::Object(object)),
            self.version(at, EntityRef::Agent(agent)),
        );
        (0..at.scene.agents[agent].arms.len()).any(|arm| {
            if is_full(at.state, agent, arm) {
                return false;
            }
            let known = self.recall(at, (question, arm, about.0, about.1), computed, |items| {
                let found = reach::reach(at.scene, at.prepared, at.state, object, agent, arm, at.seed);
                match found {
                    Reach::Free { bodies, .. } => (Some(Answer::Truth(true)), Rest::Clear(Room::Bodies(agent, bodies))),
                    Reach::Blocked(why) => (
                        Some(Answer::Truth(false)),
                        Rest::Blocked(blockers(items, &why, object, agent)),
                    ),
                }
            });
            known == Some(Answer::Truth(true))
        })
    }

    fn is_visible(&mut self, at: &At<'_>, object: usize, agent: usize, computed: &mut u64) -> bool {
        let Some(camera) = &at.scene.agents[agent].camera else {
            return false;
        };
        let X_WC = at.layout.X_WL[agent][camera.link] * camera.X_LC;
        let own = Owner::Link {
            agent,
            link: camera.link,
        };
        // A camera on a link without bodies has no version of its own.
        let eyes = match self.items.of(own) {
            Some(item) => at.layout.versions[item],
            None => self.version(at, EntityRef::Agent(agent)),
        };
        let about = self.version(at, EntityRef::Object(object));
        let surface = std::mem::take(&mut self.surfaces[object]);
        let known = self.recall(
            at,
            (Question::Fact(Fact::IsVisible { object, agent }), 0, about, eyes),
            computed,
            |items| {
                let others = items.all.iter().enumerate().filter(|(_, i)| match i.owner {
                    Owner::Object(o) => o != object,
                    link @ Owner::Link { .. } => link != own,
                });
                let others = others.flat_map(|(item, _)| {
                    let bodies = items.bodies(at.prepared, item);
                    bodies.map(move |(part, body)| (item, &part.exact, at.layout.placed[body]))
                });
                let X_WO = &at.state.objects[object].X_WO;
                let view = sight::look(&Eye { camera, X_WC }, &surface, X_WO, others, false);
                let rest = if view.is_visible {
                    Rest::Clear(Room::Cone(view.cone))
                } else {
                    Rest::Blocked(view.hidden_by.iter().map(|(item, _)| *item).collect())
                };
                (Some(Answer::Truth(view.is_visible)), rest)
            },
        );
        self.surfaces[object] = surface;
        known == Some(Answer::Truth(true))
    }

    fn version(&self, at: &At<'_>, entity: EntityRef) -> u32 {
        at.layout.version(&self.items, entity)
    }

    /// Returns the answer that is remembered, if it still stands, or the one that `find` has.
    fn recall(
        &mut self,
        at: &At<'_>,
        key: Key,
        computed: &mut u64,
        find: impl FnOnce(&Items) -> (Option<Answer>, Rest),
    ) -> Option<Answer> {
        if let Some(all) = self.kept.get(&key)
            && let Some(kept) = all.iter().rev().find(|k| stands(&self.items, at, k))
        {
            return kept.answer;
        }
        *computed += 1;
        let (answer, rest) = find(&self.items);
        if self.n_kept >= MOST {
            self.kept.clear();
            self.n_kept = 0;
        }
        let all = self.kept.entry(key).or_default();
        if all.len() >= MOST_OF_ONE {
            all.remove(0);
            self.n_kept -= 1;
        }
        self.n_kept += 1;
        all.push(Kept {
            answer,
            layout: Arc::clone(at.layout),
            rest,
        });
        answer
    }
}

/// Says whether an answer is true of the world at hand as well.
fn stands(items: &Items, at: &At<'_>, kept: &Kept) -> bool {
    if Arc::ptr_eq(&kept.layout, at.layout) {
        return true;
    }
    let (then, now) = (&kept.layout.versions, &at.layout.versions);
    let moved = || (0..items.all.len()).filter(|i| then[*i] != now[*i]);
    match &kept.rest {
        Rest::Entities => true,
        Rest::Clear(room) => moved().all(|item| {
            let mut bodies = items.bodies(at.prepared, item);
            !bodies.any(|(part, body)| {
                let X_WS = &at.layout.placed[body];
                match room {
                    Room::Cone(cone) => cone.may_touch(&X_WS.translation.vector, part.exact.radius()),
                    Room::Bodies(agent, own) => own.iter().any(|(i, X_WOwn)| {
                        overlap(&at.prepared.agents[*agent].parts[*i].padded, X_WOwn, &part.exact, X_WS)
                    }),
                }
            })
        }),
        Rest::Blocked(by) => by.iter().all(|item| then[*item] == now[*item]),
        Rest::Near(balls) => moved()
            .filter(|item| matches!(items.all[*item].owner, Owner::Object(_)))
            .all(|item| {
                let touches = |layout: &Layout| {
                    let mut bodies = items.bodies(at.prepared, item);
                    bodies.any(|(part, body)| {
                        let p = layout.placed[body].translation.vector;
                        let touches =
                            |(centre, radius): &(Vec3, f64)| (p - centre).norm() <= radius + part.exact.radius();
                        balls.iter().any(touches)
                    })
                };
                !touches(&kept.layout) && !touches(at.layout)
            }),
        Rest::World => then == now,
    }
}

/// Returns the items in an arm's way, but for the agent itself and the object: those are what the question is about.
fn blockers(items: &Items, why: &[Obstacle], object: usize, agent: usize) -> Vec<usize> {
    let mut all = Vec::new();
    let mut add = |owner: Owner| {
        let is_about = match owner {
            Owner::Link { agent: a, .. } => a == agent,
            Owner::Object(o) => o == object,
        };
        if let Some(item) = items.of(owner).filter(|item| !is_about && !all.contains(item)) {
            all.push(item);
        }
    };
    for obstacle in why {
        match obstacle {
            Obstacle::Hand(_, b) => add(*b),
            Obstacle::Arm(hits) => hits.iter().for_each(|(_, b)| add(*b)),
            Obstacle::Wide | Obstacle::Far(_) | Obstacle::Unsolved(_) => {}
        }
    }
    all
}
