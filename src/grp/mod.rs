//! The geometric reasoner and planner: answers the engine with geometry on a world (thesis chapter 3).
//!
//! **Invariant:** no action has code of its own: `description` says what it is, one solver runs them all.

mod adopt;
mod arm_space;
mod attempt;
mod bases;
mod body_space;
mod candidates;
mod constraints;
mod cost;
mod description;
mod facts;
mod free_place;
mod ground;
mod key;
mod motion;
mod navigate;
mod prepared;
mod relations;
mod requests;
mod solve;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use crate::ir::geometric::APPROACH;
pub use crate::world::FACTS;
pub use relations::NEXT_TO;
pub use requests::{Fact, REQUESTS};
pub use solve::{Counts, Settings};

use crate::engine::{Call, GasNum, GasRef, Mark, Projection, Reasoner, Request};
use crate::ir::geometric::{Change, Geometric, Space};
use crate::ir::{AttributeId, Domain, EntityId, EntitySet, Value};
use crate::plan::{ActionRefusal, AttachmentChange, Geometry, Motion, Placement, SubAction, Trajectory};
use crate::world::{EntityRef, Scene, State, World};
use adopt::Adopted;
use constraints::Constraints;
use description::Description;
use facts::{Memory, States};
use key::Key;
use navigate::{Gone, Journey};
use prepared::Prepared;
use requests::{Answer, Question};
use solve::{Room, Search, Solution};

/// A solved geometric action.
#[derive(Debug)]
struct Solved {
    solution: Outcome,
    cost: f64,
    duration: f64,
}

/// A geometric action at work: of a hand, or of a base.
#[derive(Debug)]
enum Work {
    Handling(Box<Search>),
    Going(Box<Journey>),
}

/// What either of them found.
#[derive(Debug)]
enum Outcome {
    Handled(Solution),
    Gone(Gone),
}

impl Outcome {
    /// Returns the world state that it leads to.
    fn end(&self) -> Option<&State> {
        match self {
            Outcome::Handled(solution) => solution.end(),
            Outcome::Gone(gone) => gone.end(),
        }
    }
}

/// A geometric action with the solutions found so far.
#[derive(Debug)]
struct Gas {
    work: Work,
    solved: Vec<Solved>,
}

/// The reasoner with geometry. Remembers every action it has started, by world state and arguments, with its solutions.
#[derive(Debug)]
pub struct Grp<'a> {
    scene: &'a Scene,
    prepared: Prepared,
    settings: Settings,
    seed: u64,
    stop: Arc<AtomicBool>,
    /// World states, the current one last.
    states: States,
    gases: Vec<Gas>,
    /// Actions of an earlier plan.
    adopted: Vec<Adopted>,
    by_key: BTreeMap<Key, GasNum>,
    memory: Memory,
    /// All facts that can hold in some world state.
    possible: Arc<Vec<(&'static str, EntityRef, EntityRef, Fact)>>,
    counts: Counts,
}

impl<'a> Grp<'a> {
    /// Makes a reasoner on a world; `stop` ends long computations from outside.
    ///
    /// # Errors
    ///
    /// A sentence, when an arm of the scene is no serial chain.
    pub fn new(world: &'a World, settings: Settings, seed: u64, stop: Arc<AtomicBool>) -> Result<Self, String> {
        let prepared = Prepared::new(&world.scene)?;
        Ok(Grp {
            scene: &world.scene,
            memory: Memory::new(&world.scene, &prepared),
            possible: Arc::new(Self::possible_facts(&world.scene)),
            prepared,
            settings,
            seed,
            stop,
            states: States::new(world.start.clone()),
            gases: Vec::new(),
            adopted: Vec::new(),
            by_key: BTreeMap::new(),
            counts: Counts::default(),
        })
    }

    /// Returns what was computed so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Says whether a fact holds in the current world state.
    pub fn holds(&mut self, fact: Fact) -> bool {
        self.ask(Question::Fact(fact)) == Some(Answer::Truth(true))
    }

    /// Answers a question about the current world state. Answers are remembered with what they rest on.
    fn ask(&mut self, question: Question) -> Option<Answer> {
        let computed = match question {
            Question::Fact(_) => &mut self.counts.facts,
            _ => &mut self.counts.requests,
        };
        let (scene, prepared, states) = (self.scene, &self.prepared, &mut self.states);
        self.memory.ask(scene, prepared, states, self.seed, question, computed)
    }

    /// Answers a fact or request by name about the current world state, and says why, with names and numbers; `None` where it makes
    /// no sense for these entities. What it says is worked out anew.
    pub fn explain(&self, name: &str, entities: &[EntityRef]) -> Option<(Value, String)> {
        let question = Question::of(name, entities)?;
        let state = self.states.last()?;
        let answer = requests::answer(self.scene, &self.prepared, state, self.seed, question)?;
        let why = facts::why(self.scene, &self.prepared, state, self.seed, question);
        Some((Value::from(answer), why))
    }

    /// Makes a world state the current one, as it was observed: nothing was done to come there. What was asked about others is
    /// not asked again where nothing that matters has moved.
    pub fn observe(&mut self, state: State) {
        self.states.push(state);
    }

    /// Returns every fact of the current world state that can hold, with its truth: name, first and second entity.
    pub fn all_facts(&mut self) -> Vec<(&'static str, EntityRef, EntityRef, bool)> {
        let possible = Arc::clone(&self.possible);
        let asked = possible.iter();
        asked
            .map(|(name, a, b, fact)| (*name, *a, *b, self.holds(*fact)))
            .collect()
    }

    /// Returns the facts of a scene that can hold in some world state.
    fn possible_facts(scene: &Scene) -> Vec<(&'static str, EntityRef, EntityRef, Fact)> {
        let agents = (0..scene.agents.len()).map(EntityRef::Agent);
        let entities: Vec<EntityRef> = agents.chain((0..scene.objects.len()).map(EntityRef::Object)).collect();
        let mut all = Vec::new();
        for name in FACTS {
            for first in &entities {
                for second in entities.iter().filter(|second| *second != first) {
                    if let Some(fact) = Fact::of(name, *first, *second)
                        && is_about_things(scene, fact)
                    {
                        all.push((name, *first, *second, fact));
                    }
                }
            }
        }
        all
    }

    fn description(&self, domain: &Domain, call: &Call<'_>) -> Result<Description, String> {
        Description::new(self.scene, domain, geometric(domain, call)?, call)
    }

    /// Returns the number of the action in the current world state, started now if it was not before.
    fn start(&mut self, domain: &Domain, call: &Call<'_>) -> Result<GasNum, ActionRefusal> {
        let refuse = |why: String| {
            let args: Vec<String> = call.args.iter().map(|a| domain.show(a)).collect();
            ActionRefusal::not_applicable(format!("{}({})", call.name, args.join(", ")), why)
        };
        let action = geometric(domain, call).map_err(refuse)?;
        if action.goes().is_some() {
            return self.start_journey(domain, call, action).map_err(refuse);
        }
        let description = self.description(domain, call).map_err(refuse)?;
        let state = self
            .states
            .last()
            .cloned()
            .ok_or_else(|| refuse("there is no world state".into()))?;
        let mut key = Key::new(self.seed).text(&description.action.name);
        // As many as most actions have: a shorter list is filled up.
        for at in 0..description.entities.len().max(4) {
            key = key.number(description.number_of(at));
        }
        if !description.given.text.is_empty() {
            key = key.text(&description.given.text);
        }
        let key = key.state(&state);
        let constraints = Constraints::new(self.scene, domain, call.constraints);
        // The same action with other constraints is another search; its candidates are the same ones.
        let searched = if constraints.is_empty() {
            key
        } else {
            key.text(&format!("{:?}", call.constraints))
        };
        if let Some(gas) = self.by_key.get(&searched) {
            return Ok(*gas);
        }
        let gas = GasNum(self.gases.len() as u32);
        let (scene, prepared, settings) = (self.scene, &self.prepared, self.settings);
        let room = Room {
            scene,
            prepared,
            settings,
            seed: self.seed,
            stop: &self.stop,
        };
        let search = Search::new(&room, description, constraints, state, key);
        self.gases.push(Gas {
            work: Work::Handling(Box::new(search)),
            solved: Vec::new(),
        });
        self.by_key.insert(searched, gas);
        Ok(gas)
    }

    /// Applies solution number `alternative` of an action, computed now unless it was before.
    fn solution(&mut self, gas: GasNum, alternative: u32) -> Result<Projection, ActionRefusal> {
        let (scene, prepared, settings) = (self.scene, &self.prepared, self.settings);
        let room = Room {
            scene,
            prepared,
            settings,
            seed: self.seed,
            stop: &self.stop,
        };
        let Some(entry) = self.gases.get_mut(gas.0 as usize) else {
            let why = "an action of an earlier plan has no alternatives";
            return Err(ActionRefusal::not_applicable(String::new(), why.to_owned()));
        };
        while entry.solved.len() <= alternative as usize {
            let (solution, parts, duration) = match &mut entry.work {
                Work::Handling(search) => {
                    let Some(solution) = search.next_solution(&room, &mut self.counts) else {
                        return Err(search.refusal(&room));
                    };
                    let parts = cost::parts(scene, prepared, &solution, search.description.agent);
                    let duration = solution.stages.iter().filter_map(|(_, t)| t.times.last()).sum();
                    (Outcome::Handled(solution), parts, duration)
                }
                Work::Going(journey) => {
                    let Some(gone) = journey.next_solution(&room, &mut self.counts) else {
                        return Err(journey.refusal(&room));
                    };
                    let (parts, duration) = (gone.parts.clone(), gone.duration());
                    (Outcome::Gone(gone), parts, duration)
                }
            };
            let cost = parts.values().sum();
            entry.solved.push(Solved {
                solution,
                cost,
                duration,
            });
        }
        let solved = &entry.solved[alternative as usize];
        if let Some(end) = solved.solution.end() {
            self.states.push(end.clone());
        }
        Ok(Projection {
            gas: GasRef { gas, alternative },
            cost: solved.cost,
            duration: solved.duration,
        })
    }

    /// Returns the choices and motions of a projection, for the plan document.
    pub fn geometry(&self, gas: GasRef) -> Option<Geometry> {
        if let Some(adopted) = self.adopted.get(adopt::position(gas.gas)) {
            return Some(adopted.geometry().clone());
        }
        let entry = self.gases.get(gas.gas.0 as usize)?;
        let number = gas.gas.0.saturating_add(self.first_number());
        let (search, solution) = match (&entry.work, &entry.solved.get(gas.alternative as usize)?.solution) {
            (Work::Handling(search), Outcome::Handled(solution)) => (search, solution),
            (Work::Going(journey), Outcome::Gone(gone)) => {
                return Some(journey.document(self.scene, gone, (number, gas.alternative)));
            }
            (Work::Handling(_), Outcome::Gone(_)) | (Work::Going(_), Outcome::Handled(_)) => return None,
        };
        let Description {
            agent,
            object,
            ref action,
            ..
        } = search.description;
        let body = &self.scene.agents[agent];
        let arm = &body.arms[solution.candidate.arm];
        let thing = &self.scene.objects[object];
        let sub_actions = solution
            .stages
            .iter()
            .map(|(stage, timed)| {
                let chain = &self.prepared.agents[agent].arms[solution.candidate.arm].chain;
                let sub_action = &action.sub_actions[stage.sub_action];
                let dofs: Vec<usize> = match sub_action.space {
                    Space::Gripper(_) => arm.gripper.iter().flat_map(|g| g.dofs.iter().copied()).collect(),
                    Space::Arm(_) | Space::ArmStraight(_) => chain.dof_indices().to_vec(),
                    Space::Body(_) | Space::Base(_) => Vec::new(),
                };
                let after = &stage.end.objects[object];
                SubAction {
                    name: sub_action.name.clone(),
                    motion: match sub_action.space {
                        Space::Arm(_) => Motion::Free,
                        Space::Body(_) => Motion::Posture,
                        Space::Base(_) => Motion::Base,
                        Space::ArmStraight(_) => Motion::Straight,
                        Space::Gripper(_) => Motion::Gripper,
                    },
                    trajectory: Trajectory {
                        joints: dofs.iter().map(|d| body.tree.dofs[*d].name.clone()).collect(),
                        times: timed.times.clone(),
                        positions: timed.positions.clone(),
                    },
                    change: sub_action.change.map(|change| match (change, &after.held) {
                        (Change::Attach(_), Some(held)) => AttachmentChange::Attach {
                            object: thing.id.clone(),
                            object_in_tool: held.X_TO.into(),
                        },
                        (Change::Attach(_) | Change::Detach(_), _) => AttachmentChange::Detach {
                            object: thing.id.clone(),
                            object_in_world: after.X_WO.into(),
                        },
                    }),
                }
            })
            .collect();
        let placement = solution.candidate.placement.as_ref().map(|p| Placement {
            on: self.scene.objects[p.on].id.clone(),
            support: self.scene.objects[p.on].supports[p.support].name.clone(),
            stable: thing.stable[p.stable].name.clone(),
            x: p.x,
            y: p.y,
            yaw: p.yaw,
            pose: p.X_WO.into(),
        });
        Some(Geometry {
            action: action.name.clone(),
            gas: number,
            alternative: gas.alternative,
            agent: body.id.clone(),
            arm: arm.name.clone(),
            object: thing.id.clone(),
            grasp: solution.candidate.grasp.clone(),
            stand: None,
            placement,
            cost_parts: cost::parts(self.scene, &self.prepared, solution, agent),
            sub_actions,
        })
    }
}

/// Furniture is not picked up, does not stand on things and is not compared: no facts about that, unless somebody asks.
fn is_about_things(scene: &Scene, fact: Fact) -> bool {
    let movable = |o: usize| scene.objects[o].movable;
    let is_thing = |e: EntityRef| matches!(e, EntityRef::Object(o) if movable(o));
    match fact {
        Fact::IsOn { a, b } => movable(a) && !scene.objects[b].supports.is_empty(),
        Fact::IsIn { a, b } => movable(a) && !scene.objects[b].containers.is_empty(),
        Fact::IsNextTo { a, b } => is_thing(a) || is_thing(b),
        Fact::IsBigger { a, b } => is_thing(a) && is_thing(b),
        Fact::HasInHand { object, .. } | Fact::IsReachable { object, .. } => movable(object),
        Fact::IsVisible { .. } => true,
    }
}

/// Returns the geometric action that a call names.
fn geometric<'d>(domain: &'d Domain, call: &Call<'_>) -> Result<&'d Arc<Geometric>, String> {
    domain
        .geometric(call.name)
        .ok_or_else(|| format!("there is no geometric action `{}`", call.name))
}

impl Reasoner for Grp<'_> {
    fn project(&mut self, domain: &Domain, call: &Call<'_>) -> Result<Projection, ActionRefusal> {
        let gas = self.start(domain, call)?;
        self.solution(gas, 0)
    }

    fn request(&mut self, domain: &Domain, request: &Request<'_>) -> Option<Value> {
        let entities = request.args.iter().map(|a| constraints::entity(self.scene, domain, a));
        let entities: Option<Vec<EntityRef>> = entities.collect();
        self.ask(Question::of(request.name, &entities?)?).map(Value::from)
    }

    fn adopt(
        &mut self,
        domain: &Domain,
        call: &Call<'_>,
        known: Option<&Geometry>,
    ) -> Result<Projection, ActionRefusal> {
        self.adopt_known(domain, call, known)
    }

    fn find_alternative(&mut self, gas: GasNum, tried: u32) -> Result<Projection, ActionRefusal> {
        self.solution(gas, tried)
    }

    fn knows(&self, domain: &Domain, fact: &str, entity: EntityId) -> bool {
        FACTS.contains(&fact) && self.scene.find(&domain.entities[entity.index()].name).is_some()
    }

    fn fact(&mut self, domain: &Domain, attribute: AttributeId, entity: EntityId) -> Value {
        let description = &domain.attributes[attribute.index()];
        let empty = if description.is_set {
            Value::Set(Arc::new(EntitySet::default()))
        } else {
            Value::Null
        };
        let Some(name) = description.fact.as_deref() else {
            return empty;
        };
        let Some(first) = self.scene.find(&domain.entities[entity.index()].name) else {
            return empty;
        };
        let crate::ir::Base::Entity(ty) = description.base else {
            return empty;
        };
        let mut members = EntitySet::default();
        for other in &domain.types[ty.index()].entities {
            let Some(second) = self.scene.find(&domain.entities[other.index()].name) else {
                continue;
            };
            if first == second {
                continue;
            }
            if let Some(fact) = Fact::of(name, first, second)
                && is_about_things(self.scene, fact)
                && self.holds(fact)
            {
                if !description.is_set {
                    return Value::Entity(*other);
                }
                members.insert(*other);
            }
        }
        if description.is_set {
            Value::Set(Arc::new(members))
        } else {
            Value::Null
        }
    }

    fn state_key(&mut self) -> Option<u128> {
        let state = self.states.last()?;
        Some(u128::from(Key::new(self.seed).state(state).0))
    }

    fn save(&mut self) -> Mark {
        Mark(self.states.len())
    }

    fn restore(&mut self, mark: Mark) {
        // INVARIANT: the start state is never forgotten.
        self.states.truncate(mark.0.max(1));
    }

    fn rewind(&mut self) {
        self.states.push(self.states[0].clone());
    }

    fn replay(&mut self, gas: GasRef) {
        if let Some(adopted) = self.adopted.get(adopt::position(gas.gas)) {
            self.states.push(adopted.end().clone());
            return;
        }
        let solved = self
            .gases
            .get(gas.gas.0 as usize)
            .and_then(|g| g.solved.get(gas.alternative as usize));
        if let Some(end) = solved.and_then(|s| s.solution.end()) {
            self.states.push(end.clone());
        }
    }
}
