//! Geometric requests (thesis 4.4.1) and facts (thesis 3.2.4): questions about a world state, and their answers.
//!
//! Pure: the same question about the same state has the same answer, whatever was asked before. What each one means is in
//! `docs/decisions/011-what-geometric-requests-mean.md`.

use super::bases::Bases;
use super::prepared::Prepared;
use super::{facts, free_place, relations};
use crate::world::{EntityRef, Scene, State};

/// Names of the requests that are no facts.
pub const REQUESTS: [&str; 6] = [
    "virtualPlace",
    "canReach",
    "canSee",
    "enoughRoom",
    "pathExists",
    "distance",
];

/// A fact about a pair of entities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fact {
    /// Object on object.
    IsOn {
        a: usize,
        b: usize,
    },
    /// Object in object.
    IsIn {
        a: usize,
        b: usize,
    },
    IsNextTo {
        a: EntityRef,
        b: EntityRef,
    },
    /// The volume of `a` exceeds that of `b`.
    IsBigger {
        a: EntityRef,
        b: EntityRef,
    },
    HasInHand {
        agent: usize,
        object: usize,
    },
    IsReachable {
        object: usize,
        agent: usize,
    },
    IsVisible {
        object: usize,
        agent: usize,
    },
}

/// A question about a world state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Question {
    Fact(Fact),
    VirtualPlace {
        thing: EntityRef,
        on: usize,
    },
    EnoughRoom {
        agent: usize,
        near: EntityRef,
        entity: EntityRef,
    },
    PathExists {
        agent: usize,
        entity: EntityRef,
    },
    Distance {
        a: EntityRef,
        b: EntityRef,
    },
}

/// An answer; a length is in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Answer {
    Truth(bool),
    Length(f64),
}

impl Fact {
    /// Returns the fact of that name about two entities, or `None` when it makes no sense for them.
    pub(super) fn of(name: &str, first: EntityRef, second: EntityRef) -> Option<Fact> {
        use EntityRef::{Agent, Object, Virtual};
        let fact = match (name, first, second) {
            ("isOn", Object(a), Object(b)) => Fact::IsOn { a, b },
            ("isIn", Object(a), Object(b)) => Fact::IsIn { a, b },
            ("isNextTo", Virtual(_), _) | ("isNextTo", _, Virtual(_)) => return None,
            ("isNextTo", a, b) if a != b => Fact::IsNextTo { a, b },
            ("isBigger", a, b) => Fact::IsBigger { a, b },
            ("isSmaller", a, b) => Fact::IsBigger { a: b, b: a },
            ("hasInHand", Agent(agent), Object(object)) => Fact::HasInHand { agent, object },
            ("isReachable", Object(object), Agent(agent)) => Fact::IsReachable { object, agent },
            ("isVisible", Object(object), Agent(agent)) => Fact::IsVisible { object, agent },
            _ => return None,
        };
        Some(fact)
    }
}

impl Question {
    /// Returns the request or fact of that name about the entities, or `None` when it makes no sense for them.
    pub(super) fn of(name: &str, args: &[EntityRef]) -> Option<Question> {
        use EntityRef::{Agent, Object, Virtual};
        let question = match (name, args) {
            ("virtualPlace", [thing @ (Object(_) | Virtual(_)), Object(on)]) => {
                Question::VirtualPlace { thing: *thing, on: *on }
            }
            ("canReach", [Agent(agent), Object(object)]) => Question::Fact(Fact::IsReachable {
                object: *object,
                agent: *agent,
            }),
            ("canSee", [Agent(agent), Object(object)]) => Question::Fact(Fact::IsVisible {
                object: *object,
                agent: *agent,
            }),
            ("enoughRoom" | "pathExists" | "distance", args) if args.iter().any(|a| matches!(a, Virtual(_))) => {
                return None;
            }
            ("enoughRoom", [a @ Agent(agent), near, entity]) if near != a && entity != a => Question::EnoughRoom {
                agent: *agent,
                near: *near,
                entity: *entity,
            },
            ("pathExists", [a @ Agent(agent), entity]) if entity != a => Question::PathExists {
                agent: *agent,
                entity: *entity,
            },
            ("distance", [a, b]) => Question::Distance { a: *a, b: *b },
            (_, [first, second]) => Question::Fact(Fact::of(name, *first, *second)?),
            _ => return None,
        };
        Some(question)
    }

    /// Says whether the answer follows from where the things are and who holds them, whatever the agents' joints are.
    pub(super) fn is_about_things(self) -> bool {
        let is_thing = |e: EntityRef| !matches!(e, EntityRef::Agent(_));
        match self {
            Question::Fact(fact) => match fact {
                Fact::IsOn { .. } | Fact::IsIn { .. } | Fact::IsBigger { .. } | Fact::HasInHand { .. } => true,
                Fact::IsNextTo { a, b } => is_thing(a) && is_thing(b),
                Fact::IsReachable { .. } | Fact::IsVisible { .. } => false,
            },
            Question::VirtualPlace { .. } => true,
            Question::EnoughRoom { .. } | Question::PathExists { .. } => false,
            Question::Distance { a, b } => is_thing(a) && is_thing(b),
        }
    }

    /// Returns about how much work it is, for asking the cheap ones first.
    pub(super) fn effort(self) -> u32 {
        match self {
            Question::Fact(fact) => match fact {
                Fact::HasInHand { .. } | Fact::IsBigger { .. } => 0,
                Fact::IsOn { .. } | Fact::IsIn { .. } => 1,
                Fact::IsNextTo { .. } => 2,
                Fact::IsVisible { .. } => 3,
                Fact::IsReachable { .. } => 5,
            },
            Question::Distance { .. } => 2,
            Question::VirtualPlace { .. } => 4,
            Question::EnoughRoom { .. } => 6,
            Question::PathExists { .. } => 7,
        }
    }
}

/// Answers a question about a state; `None` where there is no answer.
pub(super) fn answer(
    scene: &Scene,
    prepared: &Prepared,
    state: &State,
    seed: u64,
    question: Question,
) -> Option<Answer> {
    let truth = match question {
        Question::Fact(fact) => holds(scene, prepared, state, seed, fact),
        Question::VirtualPlace { thing, on } => free_place::find(scene, prepared, state, thing, on).is_some(),
        Question::EnoughRoom { agent, near, entity } => {
            Bases::new(scene, prepared, state, agent, seed).enough_room(near, entity)?
        }
        Question::PathExists { agent, entity } => {
            Bases::new(scene, prepared, state, agent, seed).path_exists(entity)?
        }
        Question::Distance { a, b } => {
            return relations::apart(scene, prepared, state, a.min(b), a.max(b)).map(Answer::Length);
        }
    };
    Some(Answer::Truth(truth))
}

/// Says whether a fact holds in a state.
pub(super) fn holds(scene: &Scene, prepared: &Prepared, state: &State, seed: u64, fact: Fact) -> bool {
    match fact {
        Fact::IsOn { a, b } => facts::is_on(scene, state, a, b),
        Fact::IsIn { a, b } => relations::is_in(scene, state, a, b),
        // The one before the other as the world file has them: the answer does not depend on who is asked about first.
        Fact::IsNextTo { a, b } => relations::apart(scene, prepared, state, a.min(b), a.max(b))
            .is_some_and(|d| d <= relations::NEXT_TO + relations::ROUNDING),
        Fact::IsBigger { a, b } => relations::is_bigger(scene, a, b),
        Fact::HasInHand { agent, object } => facts::has_in_hand(state, agent, object),
        Fact::IsReachable { object, agent } => facts::is_reachable(scene, prepared, state, object, agent, seed),
        Fact::IsVisible { object, agent } => facts::is_visible(scene, prepared, state, object, agent),
    }
}
