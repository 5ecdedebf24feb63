//! A geometric action of the language with its arguments: what the solver looks at (thesis 3.2.3 and 3.3.2).
//!
//! The action itself is data (`ir::geometric`); this finds out what its choices are for. `check` has seen to it that there
//! is one arm, one object and one placement at most.

use std::sync::Arc;

use super::constraints::entity;
use super::requests::Question;
use crate::engine::Call;
use crate::ir::geometric::{Choice, ChoiceSet, Condition, FactOf, Geometric, Place, Role, Target};
use crate::ir::{ChoiceId, Domain, Value};
use crate::world::{EntityRef, Scene};

/// An action with its arguments.
#[derive(Debug, Clone)]
pub(super) struct Description {
    pub action: Arc<Geometric>,
    /// By parameter.
    pub entities: Vec<EntityRef>,
    /// The agent whose arm moves.
    pub agent: usize,
    /// The object that is handled.
    pub object: usize,
    /// Whether a grasp is to be chosen; else the object is in the hand already.
    pub takes: bool,
    pub placing: Option<Placing>,
    pub given: Given,
    /// By sub-action: what must hold when it starts, and when it is over.
    pub before: Vec<Vec<Asked>>,
    pub after: Vec<Vec<Asked>>,
}

/// Choices that the domain makes itself; `None` is left to the solver.
#[derive(Debug, Clone, Default)]
pub(super) struct Given {
    pub arm: Option<String>,
    pub grasp: Option<String>,
    pub face: Option<String>,
    pub stable: Option<String>,
    /// On the face [m].
    pub xy: Option<[f64; 2]>,
    /// [rad]
    pub yaw: Option<f64>,
    /// As the domain writes them: ` with hand = "right"`.
    pub text: String,
}

/// Where and when the object is put down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placing {
    /// The sub-action that ends there.
    pub sub_action: usize,
    /// Object that carries it.
    pub on: usize,
    /// In the middle of a face alone.
    pub is_centred: bool,
}

/// A fact that is asked for.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    /// As messages show it.
    pub text: String,
    /// `None` where it makes no sense for its arguments, so that it never holds.
    pub question: Option<Question>,
}

impl Description {
    /// Gives an action its arguments.
    ///
    /// # Errors
    ///
    /// A sentence: what is wrong with them.
    pub(super) fn new(
        scene: &Scene,
        domain: &Domain,
        action: &Arc<Geometric>,
        call: &Call<'_>,
    ) -> Result<Description, String> {
        let (args, values) = call.args.split_at(call.args.len().saturating_sub(call.given.len()));
        if args.len() != action.params.len() {
            let (n, m) = (action.params.len(), args.len());
            return Err(format!("`{}` takes {n} arguments, not {m}", action.name));
        }
        let mut entities = Vec::with_capacity(args.len());
        for (param, value) in action.params.iter().zip(args) {
            let found = match value {
                Value::Entity(e) => entity(scene, domain, value)
                    .ok_or_else(|| format!("{} is not in the world file", domain.entities[e.index()].name))?,
                _ => return Err(format!("{} is not an entity", domain.show(value))),
            };
            match (param.role, found) {
                (Role::Agent, EntityRef::Object(_)) => return Err(format!("{} is not an agent", domain.show(value))),
                (Role::Thing, EntityRef::Agent(_)) => return Err(format!("{} is not an object", domain.show(value))),
                (_, EntityRef::Virtual(_)) => {
                    return Err(format!("{} is a virtual object: it is nowhere", domain.show(value)));
                }
                (Role::Agent, EntityRef::Agent(_)) | (Role::Thing, EntityRef::Object(_)) | (Role::Entity, _) => {}
            }
            entities.push(found);
        }
        let agent = action.choices.iter().find_map(|c| match c.from {
            ChoiceSet::Arms(agent) => Some(entities[agent.index()]),
            _ => None,
        });
        let object = object(action).map(|o| entities[o.index()]);
        let (Some(EntityRef::Agent(agent)), Some(EntityRef::Object(object))) = (agent, object) else {
            return Err(format!("`{}` needs an agent and an object", action.name));
        };
        let placing = action.sub_actions.iter().enumerate().find_map(|(i, s)| match s.until {
            Target::Placement { place, above: 0.0 } => Some((i, place)),
            _ => None,
        });
        let asked = |fact: &FactOf| asked(scene, domain, fact, &entities);
        let conditions = |s: &crate::ir::geometric::SubAction| {
            let facts = s.when.iter().filter_map(|c| match c {
                Condition::Fact(fact) => Some(asked(fact)),
                Condition::Free(_) | Condition::Holds(..) => None,
            });
            facts.collect()
        };
        Ok(Description {
            agent,
            object,
            takes: action.choices.iter().any(|c| matches!(c.from, ChoiceSet::Grasps(_))),
            given: given(domain, action, call.given, values),
            placing: placing.and_then(|(sub_action, place)| placed(action, &entities, sub_action, place)),
            before: action.sub_actions.iter().map(conditions).collect(),
            after: action
                .sub_actions
                .iter()
                .map(|s| s.facts.iter().map(asked).collect())
                .collect(),
            action: Arc::clone(action),
            entities,
        })
    }

    /// Returns a number that tells an argument from others at its position; 0 where there is none.
    pub(super) fn number_of(&self, at: usize) -> u64 {
        let may_be_either = self.action.params.get(at).is_some_and(|p| p.role == Role::Entity);
        match self.entities.get(at) {
            None => 0,
            Some(EntityRef::Agent(i)) if may_be_either => (1 << 32) + *i as u64,
            Some(EntityRef::Agent(i) | EntityRef::Object(i) | EntityRef::Virtual(i)) => *i as u64 + 1,
        }
    }

    /// Returns the name of the sub-action that puts the object down, for what is said of the whole placement.
    pub(super) fn placing_name(&self) -> &str {
        let at = self.placing.and_then(|p| self.action.sub_actions.get(p.sub_action));
        at.map_or("", |s| s.name.as_str())
    }

    /// Returns the call as messages show it.
    pub(super) fn call(&self, scene: &Scene) -> String {
        let names: Vec<&str> = self.entities.iter().map(|e| name(scene, *e)).collect();
        format!("{}({}){}", self.action.name, names.join(", "), self.given.text)
    }
}

/// Returns the parameter that is handled: taken, carried or put down.
fn object(action: &Geometric) -> Option<crate::ir::ParamId> {
    let grasped = action.choices.iter().find_map(|c| match c.from {
        ChoiceSet::Grasps(object) => Some(object),
        _ => None,
    });
    let mut when = action.sub_actions.iter().flat_map(|s| &s.when);
    grasped.or_else(|| {
        when.find_map(|c| match c {
            Condition::Holds(_, object) => Some(*object),
            Condition::Free(_) | Condition::Fact(_) => None,
        })
    })
}

/// Returns the choices that the call makes. A point comes as two values, x and y.
fn given(domain: &Domain, action: &Geometric, choices: &[ChoiceId], values: &[Value]) -> Given {
    let mut given = Given::default();
    let mut text: Vec<String> = Vec::new();
    for (i, (choice, value)) in choices.iter().zip(values).enumerate() {
        let Some(Choice { name, from }) = action.choices.get(choice.index()) else {
            continue;
        };
        let is_second = i > 0 && choices[i - 1] == *choice;
        let shown = domain.show(value);
        match text.last_mut() {
            Some(last) if is_second => *last = format!("{name} = ({}, {shown})", domain.show(&values[i - 1])),
            _ => text.push(format!("{name} = {shown}")),
        }
        let number = || if let Value::Number(x) = value { Some(*x) } else { None };
        let word = || match value {
            Value::String(s) => domain.strings.get(s.index()).cloned(),
            _ => None,
        };
        match from {
            ChoiceSet::Arms(_) => given.arm = word(),
            ChoiceSet::Grasps(_) => given.grasp = word(),
            ChoiceSet::Supports(_) => given.face = word(),
            ChoiceSet::Stable(_) => given.stable = word(),
            ChoiceSet::Points(_) => {
                let x = given.xy.map_or(number(), |[x, _]| Some(x));
                given.xy = x.map(|x| [x, if is_second { number().unwrap_or(0.0) } else { 0.0 }]);
            }
            ChoiceSet::Angles => given.yaw = number(),
            ChoiceSet::Centre(_) | ChoiceSet::Stands { .. } => {}
        }
    }
    if !text.is_empty() {
        given.text = format!(" with {}", text.join(", "));
    }
    given
}

fn placed(action: &Geometric, entities: &[EntityRef], sub_action: usize, place: Place) -> Option<Placing> {
    let ChoiceSet::Supports(on) = action.choices[place.face.index()].from else {
        return None;
    };
    let EntityRef::Object(on) = entities[on.index()] else {
        return None;
    };
    Some(Placing {
        sub_action,
        on,
        is_centred: matches!(action.choices[place.point.index()].from, ChoiceSet::Centre(_)),
    })
}

pub(super) fn asked(scene: &Scene, domain: &Domain, fact: &FactOf, entities: &[EntityRef]) -> Asked {
    let args: Vec<EntityRef> = fact.args.iter().map(|p| entities[p.index()]).collect();
    let request = &domain.requests[fact.request.index()].name;
    let names: Vec<&str> = args.iter().map(|e| name(scene, *e)).collect();
    Asked {
        text: format!("{request}({})", names.join(", ")),
        question: Question::of(request, &args),
    }
}

fn name(scene: &Scene, entity: EntityRef) -> &str {
    match entity {
        EntityRef::Agent(a) => &scene.agents[a].id,
        EntityRef::Object(o) => &scene.objects[o].id,
        EntityRef::Virtual(v) => &scene.virtuals[v].id,
    }
}
