//! Geometric requests and facts as questions, answered a second time: what may be, and what certainly is.
//!
//! Where a question is one of existence, the planner and this room search with budgets of their own, and near a threshold they
//! may differ. So an answer has two sides: a test that a plan needs is refused only if it can't be as the plan needs it.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::{
    Settings, bases,
    bodies::Bodies,
    facts::{self, Status},
    places,
};
use crate::ir::{Domain, Value};
use crate::world::{EntityRef, State};

/// How far two computations of a distance may differ [m].
pub(super) const ROUNDING: f64 = 1e-6;

/// Name and arguments.
type Question = (String, Vec<EntityRef>);

/// An answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Answer {
    /// Whether it may hold; whether it certainly does.
    Truth { may: bool, must: bool },
    /// [m], within [`ROUNDING`].
    Length(f64),
}

/// A world state to ask, with what was asked of it.
pub(super) struct Asked<'a> {
    bodies: &'a Bodies<'a>,
    state: State,
    settings: &'a Settings,
    known: RefCell<BTreeMap<Question, Option<Answer>>>,
}

impl<'a> Asked<'a> {
    pub(super) fn new(bodies: &'a Bodies<'a>, state: State, settings: &'a Settings) -> Self {
        Asked {
            bodies,
            state,
            settings,
            known: RefCell::default(),
        }
    }

    /// Answers a request about entities; `None` where it makes no sense for them.
    pub(super) fn ask(&self, domain: &Domain, name: &str, args: &[Value]) -> Option<Answer> {
        let entities: Option<Vec<EntityRef>> = args
            .iter()
            .map(|a| match a {
                Value::Entity(e) => self.bodies.scene.find(&domain.entities[e.index()].name),
                _ => None,
            })
            .collect();
        let key = (name.to_owned(), entities?);
        if let Some(known) = self.known.borrow().get(&key) {
            return *known;
        }
        let answer = self.answer(name, &key.1);
        self.known.borrow_mut().insert(key, answer);
        answer
    }

    fn answer(&self, name: &str, args: &[EntityRef]) -> Option<Answer> {
        use EntityRef::{Agent, Object, Virtual};
        let (bodies, state) = (self.bodies, &self.state);
        let truth = |(may, must): (bool, bool)| Some(Answer::Truth { may: may || must, must });
        match (name, args) {
            ("virtualPlace", [thing @ (Object(_) | Virtual(_)), Object(on)]) => {
                truth(places::fits(bodies, state, *thing, *on))
            }
            ("virtualPlace", _) => None,
            ("canReach", [agent @ Agent(_), object @ Object(_)]) => self.fact("isReachable", *object, *agent),
            ("canSee", [agent @ Agent(_), object @ Object(_)]) => self.fact("isVisible", *object, *agent),
            ("canReach" | "canSee", _) => None,
            ("enoughRoom" | "pathExists" | "distance", args) if args.iter().any(|a| matches!(a, Virtual(_))) => None,
            ("enoughRoom", [a @ Agent(agent), near, entity]) if a != near && a != entity => {
                truth(bases::room(bodies, state, *agent, *near, *entity))
            }
            ("pathExists", [a @ Agent(agent), entity]) if a != entity => {
                let here = match entity {
                    Object(o) if bodies.scene.objects[*o].movable => self.fact("isReachable", *entity, *a),
                    _ => None,
                };
                let (may, must) = match here {
                    Some(Answer::Truth { may, must }) => (may, must),
                    Some(Answer::Length(_)) | None => (false, false),
                };
                let may = may || bases::path(bodies, state, *agent, *entity, self.settings);
                truth((may, must))
            }
            ("enoughRoom" | "pathExists", _) => None,
            ("distance", [a, b]) => facts::apart(bodies, state, *a, *b).map(Answer::Length),
            (fact, [first, second]) => self.fact(fact, *first, *second),
            _ => None,
        }
    }

    fn fact(&self, name: &str, first: EntityRef, second: EntityRef) -> Option<Answer> {
        let status = |claim: bool| {
            facts::status(
                self.bodies,
                &self.state,
                name,
                first,
                second,
                Some(claim),
                self.settings,
            )
        };
        use EntityRef::{Agent, Object, Virtual};
        let makes_sense = match (name, first, second) {
            ("isBigger" | "isSmaller", _, _) => true,
            (_, Virtual(_), _) | (_, _, Virtual(_)) => false,
            ("isNextTo", a, b) => a != b,
            ("isOn" | "isIn", Object(_), Object(_)) => true,
            ("hasInHand", Agent(_), Object(_)) => true,
            ("isReachable" | "isVisible", Object(_), Agent(_)) => true,
            _ => false,
        };
        if !makes_sense {
            return None;
        }
        // What is claimed must be found; what is denied must not be found easily.
        let may = status(true)? != Status::Fails;
        let must = may && status(false)? == Status::Holds;
        Some(Answer::Truth { may, must })
    }
}
