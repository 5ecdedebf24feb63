//! A reasoner of one's own: things stand on a line, and robots reach as far as their arms go.
//!
//! `cargo run --example own_reasoner` plans with it. The engine asks four things: can this be done (`project`), can it be done
//! in another way (`find_alternative`), what is true now (`fact`, `request`), and to go back (`save`, `restore`).
#![expect(clippy::print_stdout, reason = "an example prints")]

use std::collections::BTreeMap;
use std::sync::Arc;

use sgap::engine::{Call, GasNum, GasRef, Mark, Projection, Reasoner, Request};
use sgap::ir::{AttributeId, Domain, EntityId, EntitySet, Value};
use sgap::plan::{ActionRefusal, Cause, CauseCount};
use sgap::report::text;
use sgap::{Answer, Options, Paths, Rejected, Texts, plan};

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
    HeldBy(String),
}

/// How everything stands, by the names of the domain's entities.
type State = BTreeMap<String, Where>;

/// A solution: what it changes.
#[derive(Debug, Clone)]
struct Solution {
    thing: String,
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
    reach: BTreeMap<&'static str, (i64, i64)>,
    /// The states from the start to now. A mark is how many there were, so that going back is cutting off.
    states: Vec<State>,
    started: Vec<Started>,
}

impl Line {
    fn now(&self) -> &State {
        // There is always the start.
        &self.states[self.states.len() - 1]
    }

    fn reaches(&self, robot: &str, position: i64) -> bool {
        self.reach
            .get(robot)
            .is_some_and(|(from, to)| (*from..=*to).contains(&position))
    }

    fn solutions(&self, name: &str, args: &[String]) -> Vec<Solution> {
        let state = self.now();
        let [robot, thing, ..] = args else { return Vec::new() };
        match (name, state.get(thing)) {
            ("pick", Some(Where::At(x))) if self.reaches(robot, *x) => vec![Solution {
                thing: thing.clone(),
                then: Where::HeldBy(robot.clone()),
            }],
            ("place", Some(Where::HeldBy(holder))) if holder == robot => {
                // Every tenth centimetre that is free; the farthest to the right first.
                let free = |x: &i64| state.values().all(|w| *w != Where::At(*x));
                let places = (0..=20).rev().map(|i| 10 * i);
                let reached = places.filter(|x| self.reaches(robot, *x)).filter(free);
                let put = |x| Solution {
                    thing: thing.clone(),
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
        let args: Vec<String> = call.args.iter().map(|arg| domain.show(arg)).collect();
        self.started.push(Started {
            call: format!("{}({})", call.name, args.join(", ")),
            solutions: self.solutions(call.name, &args),
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
        let name = domain.entities[entity.index()].name.as_str();
        let id = |name: &str| domain.entity(name);
        match domain.attributes[attribute.index()].fact.as_deref() {
            Some("isReachable") => {
                let robots = self.reach.keys().filter(|robot| match self.now().get(name) {
                    Some(Where::At(x)) => self.reaches(robot, *x),
                    _ => false,
                });
                Value::Set(Arc::new(robots.filter_map(|r| id(r)).collect::<EntitySet>()))
            }
            _ => {
                let held = self.now().iter().find(|(_, w)| **w == Where::HeldBy(name.into()));
                held.and_then(|(thing, _)| id(thing)).map_or(Value::Null, Value::Entity)
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

/// Plans the task with robots that reach so far; returns how it went, and whether the line stands as at the start.
fn solve(left: (i64, i64), right: (i64, i64)) -> Result<(Answer, bool), Rejected> {
    let files = Texts::new([("line.hatp", DOMAIN)]);
    let paths = Paths {
        domain: "line.hatp",
        task: Some("BringAll()"),
        ..Paths::default()
    };
    let start: State = BTreeMap::from([("CUP".into(), Where::At(0)), ("BOWL".into(), Where::At(50))]);
    let mut line = Line {
        reach: BTreeMap::from([("LEFT", left), ("RIGHT", right)]),
        states: vec![start.clone()],
        started: Vec::new(),
    };
    let answer = plan(&paths, &files, Options::default().branching(4).reasoner(&mut line))?;
    Ok((answer, line.states == [start]))
}

fn main() -> Result<(), Rejected> {
    let (answer, _) = solve((0, 110), (90, 200))?;
    match answer.plan() {
        Some(plan) => print!("{}", text::plan(plan)),
        None => print!("{}", text::no_plan(answer.ending, &answer.statistics, &answer.why_not)),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_brought_to_where_the_other_robot_reaches() -> Result<(), Rejected> {
        let (answer, is_as_before) = solve((0, 110), (90, 200))?;
        let actions: Vec<String> = answer.plans[0].actions.iter().map(|a| a.name.to_string()).collect();
        assert_eq!(actions, ["Pick", "Place", "Pick", "Place"]);
        assert!(is_as_before, "all is undone after the search");
        assert_eq!(answer.statistics.alternatives, 0);
        Ok(())
    }

    /// The first places are out of the other robot's reach: further solutions are asked for in the state before.
    #[test]
    fn other_solutions_are_tried() -> Result<(), Rejected> {
        let (answer, _) = solve((0, 110), (70, 90))?;
        assert!(
            answer.plan().is_some() && answer.statistics.alternatives > 0,
            "{answer:?}"
        );
        Ok(())
    }

    #[test]
    fn without_a_common_place_there_is_no_plan() -> Result<(), Rejected> {
        let (answer, is_as_before) = solve((0, 110), (120, 200))?;
        assert!(answer.plan().is_none() && is_as_before);
        let reasons = text::reasons(&answer.why_not);
        assert!(reasons.contains("Bring"), "{reasons}");
        Ok(())
    }
}
