//! A reasoner of one's own: things stand on a line, and robots reach as far as their arms go.
//!
//! `cargo run --example own_reasoner` plans with it. The engine asks four things: can this be done (`project`), can it be done
//! in another way (`find_alternative`), what is true now (`fact`, `request`), and to go back (`save`, `restore`).

use std::collections::BTreeMap;
use std::sync::Arc;

use sgap::engine::{Call, GasNum, GasRef, Mark, Projection, Reasoner, Request};
use sgap::ir::{AttributeId, Domain, EntityId, EntitySet, Value};
use sgap::plan::{ActionRefusal, Cause, CauseCount};
use sgap::{Options, Paths, Texts, plan};

/// Two robots hand a cup along a line. `isReachable` and `hasInHand` are read from the reasoner.
const DOMAIN: &str = "
factdatabase {
  define entityType Object;
  define entityType Place;
  define entityAttributes Agent { dynamic atom Object hasInHand = fact hasInHand; }
  define entityAttributes Object { dynamic set Agent isReachable = fact isReachable; static atom Agent goesTo; }
  LEFT = new Agent; RIGHT = new Agent;
  CUP = new Object; BOWL = new Object; LINE = new Place;
  CUP.goesTo = RIGHT; BOWL.goesTo = RIGHT;
}
HTN {
  action Pick(Agent A, Object O) {
    preconditions { A.hasInHand == NULL; A >> O.isReachable; };
    projects { pick(A, O); }
  }
  action Place(Agent A, Object O, Place P) {
    preconditions { A.hasInHand == O; };
    projects { place(A, O, P); }
  }
  method Bring(Object O) {
    goal { O.goesTo >> O.isReachable; }
    { subtasks { A = SELECT(Agent, {A >> O.isReachable;}); 1: Pick(A, O); 2: Place(A, O, LINE) > 1; 3: Bring(O) > 2; }; }
  }
  method BringAll() { { subtasks { 1: Bring(CUP); 2: Bring(BOWL) > 1; }; } }
}";

/// Positions are whole centimetres; two things never stand at one position.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Where {
    At(i64),
    HeldBy(EntityId),
}

/// How everything stands.
type State = BTreeMap<EntityId, Where>;

/// A solution: what it changes.
#[derive(Debug, Clone)]
struct Solution {
    thing: EntityId,
    then: Where,
}

/// A geometric action that was started: all its solutions, best first. A real reasoner would compute one at a time.
#[derive(Debug)]
struct Started {
    call: String,
    solutions: Vec<Solution>,
}

/// A line with robots.
#[derive(Debug)]
struct Line {
    /// From where to where each robot reaches [cm].
    reach: BTreeMap<EntityId, (i64, i64)>,
    /// The states from the start to now. A mark is how many there were, so that going back is cutting off.
    states: Vec<State>,
    started: Vec<Started>,
}

impl Line {
    fn now(&self) -> &State {
        // There is always the start.
        &self.states[self.states.len() - 1]
    }

    fn reaches(&self, robot: EntityId, position: i64) -> bool {
        self.reach
            .get(&robot)
            .is_some_and(|(from, to)| (*from..=*to).contains(&position))
    }

    fn solutions(&self, name: &str, args: &[EntityId]) -> Vec<Solution> {
        let (robot, thing) = (args[0], args[1]);
        let state = self.now();
        match (name, &state[&thing]) {
            ("pick", Where::At(x)) if self.reaches(robot, *x) => vec![Solution {
                thing,
                then: Where::HeldBy(robot),
            }],
            ("place", Where::HeldBy(holder)) if *holder == robot => {
                // Every tenth centimetre that is free; the farthest to the right first.
                let free = |x: &i64| state.values().all(|w| *w != Where::At(*x));
                let places = (0..=20).rev().map(|i| 10 * i);
                let reached = places.filter(|x| self.reaches(robot, *x)).filter(free);
                let put = |x| Solution {
                    thing,
                    then: Where::At(x),
                };
                reached.map(put).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Applies solution `alternative` of an action, or says that there is none.
    fn apply(&mut self, gas: GasNum, alternative: u32) -> Result<Projection, ActionRefusal> {
        let Started { call, solutions } = &self.started[gas.0 as usize];
        let Some(Solution { thing, then }) = solutions.get(alternative as usize).cloned() else {
            let cause = Cause::NotApplicable("the arm does not reach so far".into());
            let count = CauseCount {
                sub_action: String::new(),
                cause,
                count: 1,
            };
            return Err(ActionRefusal {
                call: call.clone(),
                found_before: alternative,
                exhausted: true,
                tried: 0,
                causes: if alternative == 0 { vec![count] } else { Vec::new() },
            });
        };
        let mut next = self.now().clone();
        next.insert(thing, then);
        self.states.push(next);
        Ok(Projection {
            gas: GasRef { gas, alternative },
            cost: 1.0,
            duration: 2.0,
        })
    }
}

impl Reasoner for Line {
    fn project(&mut self, domain: &Domain, call: &Call<'_>) -> Result<Projection, ActionRefusal> {
        let entities: Vec<EntityId> = call
            .args
            .iter()
            .filter_map(|arg| match arg {
                Value::Entity(e) => Some(*e),
                _ => None,
            })
            .collect();
        let shown: Vec<String> = call.args.iter().map(|arg| domain.show(arg)).collect();
        self.started.push(Started {
            call: format!("{}({})", call.name, shown.join(", ")),
            solutions: self.solutions(call.name, &entities),
        });
        self.apply(GasNum(self.started.len() as u32 - 1), 0)
    }

    fn find_alternative(&mut self, gas: GasNum, tried: u32) -> Result<Projection, ActionRefusal> {
        self.apply(gas, tried)
    }

    fn knows(&self, _: &Domain, fact: &str, _: EntityId) -> bool {
        ["hasInHand", "isReachable"].contains(&fact)
    }

    fn fact(&mut self, domain: &Domain, attribute: AttributeId, entity: EntityId) -> Value {
        match domain.attributes[attribute.index()].fact.as_deref() {
            Some("isReachable") => {
                let robots = self.reach.keys().filter(|robot| match self.now().get(&entity) {
                    Some(Where::At(x)) => self.reaches(**robot, *x),
                    _ => false,
                });
                Value::Set(Arc::new(robots.copied().collect::<EntitySet>()))
            }
            _ => {
                let held = self.now().iter().find(|(_, w)| **w == Where::HeldBy(entity));
                held.map_or(Value::Null, |(thing, _)| Value::Entity(*thing))
            }
        }
    }

    fn request(&mut self, _: &Domain, _: &Request<'_>) -> Option<Value> {
        None
    }

    fn save(&mut self) -> Mark {
        Mark(self.states.len())
    }

    fn restore(&mut self, mark: Mark) {
        self.states.truncate(mark.0);
    }

    fn rewind(&mut self) {
        let start = self.states[0].clone();
        self.states.push(start);
    }

    fn replay(&mut self, gas: GasRef) {
        // It was found in this very state, so it is there, and can be applied.
        let _ = self.apply(gas.gas, gas.alternative);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files = Texts::new([("line.hatp", DOMAIN)]);
    let paths = Paths {
        domain: "line.hatp",
        task: Some("BringAll()"),
        ..Paths::default()
    };
    // The reasoner needs the ids of the domain's entities, which the order of declarations gives.
    let entity = |i| EntityId(i);
    let (left, right, cup, bowl) = (entity(0), entity(1), entity(2), entity(3));
    let mut line = Line {
        reach: BTreeMap::from([(left, (0, 110)), (right, (90, 200))]),
        states: vec![BTreeMap::from([(cup, Where::At(0)), (bowl, Where::At(50))])],
        started: Vec::new(),
    };
    let mut hear = |news: &sgap::News<'_>| println!("found: {}", news.actions().join(", "));
    let options = Options::default().best().reasoner(&mut line).on_plan(&mut hear);
    let answer = plan(&paths, &files, options)?;
    match answer.plan() {
        Some(plan) => print!("{}", sgap::report::text::plan(plan)),
        None => print!(
            "{}",
            sgap::report::text::no_plan(answer.ending, &answer.statistics, &answer.why_not)
        ),
    }
    Ok(())
}
