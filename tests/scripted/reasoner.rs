//! A reasoner whose answers are written down: exact by definition, with every question kept and every rule of the trait
//! checked.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use sgap::engine::{Call, GasNum, GasRef, Mark, Projection, Reasoner, Request};
use sgap::ir::{AttributeId, Domain, EntityId, EntitySet, Value};
use sgap::plan::{ActionRefusal, Geometry};

/// Members of each fact by the attribute that reads it: `CUP.isReachable` to `[R, H]`.
pub type World = BTreeMap<String, Vec<String>>;

/// One solution of a geometric action.
#[derive(Debug, Clone)]
pub struct Solution {
    pub cost: f64,
    pub duration: f64,
    /// Facts that are different afterwards.
    pub changes: World,
}

/// Returns a solution; `changes` is written `CUP.isOn = TABLE, CUP.isReachable = R H, R.holds =`.
pub fn solution(cost: f64, duration: f64, changes: &str) -> Solution {
    Solution {
        cost,
        duration,
        changes: world(changes),
    }
}

/// Returns the facts written `CUP.isOn = TABLE, CUP.isReachable = R H, R.holds =`.
pub fn world(text: &str) -> World {
    let facts = text.split(',').filter_map(|fact| fact.split_once('='));
    facts
        .map(|(name, members)| {
            let members = members.split_whitespace().map(String::from).collect();
            (name.trim().to_owned(), members)
        })
        .collect()
}

/// A geometric action that was started.
#[derive(Debug)]
struct Gas {
    call: String,
    /// Number of the world state that it was started in, and that state.
    state: u64,
    world: World,
}

/// What the script says, and what was asked.
#[derive(Debug, Default)]
pub struct Scripted {
    /// Solutions by call, `pick(R, CUP)`, in their order; a call that is not here has none.
    pub answers: BTreeMap<String, Vec<Solution>>,
    /// Calls that give up with choices left when their solutions are used up.
    pub gives_up: Vec<String>,
    /// Facts that it answers.
    pub knows: Vec<&'static str>,
    /// Every question but those for facts: `project pick(R, CUP)`, `alternative 1 pick(R, CUP)`.
    pub asked: Vec<String>,
    /// Every fact that was computed, with the number of the world state: `2 CUP.isOn`.
    pub facts: Vec<String>,
    /// World states with their numbers, the current one last; a number names one state and is never used again.
    states: Vec<(u64, World)>,
    next_state: u64,
    gases: Vec<Gas>,
    /// Marks that may still be gone back to, with the number of states there were.
    marks: Vec<(usize, usize)>,
    next_mark: usize,
}

impl Scripted {
    /// Returns a reasoner that starts in `start` and answers facts of these names.
    pub fn new(start: &str, knows: &[&'static str]) -> Self {
        Scripted {
            states: vec![(0, world(start))],
            next_state: 1,
            knows: knows.to_vec(),
            ..Scripted::default()
        }
    }

    /// Adds the solutions of a call.
    pub fn with(mut self, call: &str, solutions: Vec<Solution>) -> Self {
        self.answers.insert(call.to_owned(), solutions);
        self
    }

    /// Says whether the world is the one at the start, and nothing else is left.
    pub fn is_at_start(&self) -> bool {
        self.states.len() == 1 && self.states[0].0 == 0
    }

    fn push(&mut self, world: World) {
        self.states.push((self.next_state, world));
        self.next_state += 1;
    }

    fn current(&self) -> &(u64, World) {
        self.states.last().unwrap()
    }

    fn solve(&mut self, gas: GasNum, alternative: u32) -> Result<Projection, ActionRefusal> {
        let call = self.gases[gas.0 as usize].call.clone();
        let Some(solution) = self
            .answers
            .get(&call)
            .and_then(|s| s.get(alternative as usize))
            .cloned()
        else {
            return Err(ActionRefusal {
                exhausted: !self.gives_up.contains(&call),
                call,
                found_before: alternative,
                tried: 0,
                causes: Vec::new(),
            });
        };
        let mut world = self.current().1.clone();
        world.extend(solution.changes);
        self.push(world);
        Ok(Projection {
            gas: GasRef { gas, alternative },
            cost: solution.cost,
            duration: solution.duration,
        })
    }
}

impl Reasoner for Scripted {
    fn project(&mut self, domain: &Domain, call: &Call<'_>) -> Result<Projection, ActionRefusal> {
        let args: Vec<String> = call.args.iter().map(|a| domain.show(a)).collect();
        let call = format!("{}({})", call.name, args.join(", "));
        self.asked.push(format!("project {call}"));
        let (state, world) = self.current().clone();
        let gas = GasNum(u32::try_from(self.gases.len()).unwrap());
        self.gases.push(Gas { call, state, world });
        self.solve(gas, 0)
    }

    /// A document says which of the script's solutions it has.
    fn adopt(
        &mut self,
        domain: &Domain,
        call: &Call<'_>,
        known: Option<&Geometry>,
    ) -> Result<Projection, ActionRefusal> {
        let args: Vec<String> = call.args.iter().map(|a| domain.show(a)).collect();
        let call = format!("{}({})", call.name, args.join(", "));
        let Some(known) = known else {
            return Err(ActionRefusal::not_applicable(call, "no motions".into()));
        };
        self.asked.push(format!("adopt {} {call}", known.alternative));
        let (state, world) = self.current().clone();
        let gas = GasNum(u32::try_from(self.gases.len()).unwrap());
        self.gases.push(Gas { call, state, world });
        self.solve(gas, known.alternative)
    }

    fn request(&mut self, _: &Domain, _: &Request<'_>) -> Option<Value> {
        None
    }

    fn find_alternative(&mut self, gas: GasNum, tried: u32) -> Result<Projection, ActionRefusal> {
        let Gas { call, state, .. } = &self.gases[gas.0 as usize];
        self.asked.push(format!("alternative {tried} {call}"));
        assert_eq!(
            *state,
            self.current().0,
            "{call}: an alternative is asked for in another world state"
        );
        self.solve(gas, tried)
    }

    fn knows(&self, _: &Domain, fact: &str, _: EntityId) -> bool {
        self.knows.contains(&fact)
    }

    fn fact(&mut self, domain: &Domain, attribute: AttributeId, entity: EntityId) -> Value {
        let attribute = &domain.attributes[attribute.index()];
        let name = format!("{}.{}", domain.entities[entity.index()].name, attribute.name);
        let (state, world) = self.states.last().unwrap();
        self.facts.push(format!("{state} {name}"));
        let members = world.get(&name).map_or(&[][..], Vec::as_slice);
        let mut members = members.iter().map(|m| domain.entity(m).unwrap());
        if attribute.is_set {
            Value::Set(Arc::new(members.collect::<EntitySet>()))
        } else {
            members.next().map_or(Value::Null, Value::Entity)
        }
    }

    /// What it answers depends on the facts of the world state alone.
    fn state_key(&mut self) -> Option<u128> {
        let mut hasher = DefaultHasher::new();
        self.current().1.hash(&mut hasher);
        Some(u128::from(hasher.finish()))
    }

    fn save(&mut self) -> Mark {
        let mark = self.next_mark;
        self.next_mark += 1;
        self.marks.push((mark, self.states.len()));
        Mark(mark)
    }

    fn restore(&mut self, mark: Mark) {
        let position = self.marks.iter().position(|m| m.0 == mark.0);
        let position = position.expect("restores go only to marks that exist and were not forgotten");
        let (_, states) = self.marks[position];
        assert!(states <= self.states.len(), "a mark outlived its world state");
        self.marks.truncate(position + 1);
        self.states.truncate(states);
    }

    fn rewind(&mut self) {
        let start = self.states[0].1.clone();
        self.push(start);
    }

    fn replay(&mut self, gas: GasRef) {
        let Gas { call, world, .. } = &self.gases[gas.gas.0 as usize];
        assert_eq!(
            *world,
            self.current().1,
            "{call}: a solution is replayed in another world state"
        );
        let solution = &self.answers[call][gas.alternative as usize];
        let mut next = world.clone();
        next.extend(solution.changes.clone());
        self.push(next);
    }
}
