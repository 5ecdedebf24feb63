//! The things and the simple actions that most tests share.

use crate::reasoner::{Scripted, solution};

const DATABASE: &str = "
factdatabase {
  define entityType Object;
  define entityType Place;
  define entityAttributes Agent {
    dynamic atom Object holds;
    dynamic atom Agent helper;
    dynamic atom number count;
  }
  define entityAttributes Object {
    dynamic atom Place at;
    dynamic atom bool done;
    dynamic atom number weight;
    dynamic set Agent users;
  }
  define entityAttributes Place { dynamic atom Place near; }
  R = new Agent; H = new Agent;
  CUP = new Object; BOX = new Object; PEN = new Object; CAN = new Object;
  TABLE = new Place; SHELF = new Place; FLOOR = new Place;
  CUP.at = TABLE; TABLE.near = SHELF; BOX.users <<= H;
  CUP.weight = 2; BOX.weight = 1; PEN.weight = 2;
}
";

const ACTIONS: &str = "
  action Look(Agent A, Object O) { projects { pick(A, O) }; cost { 0 }; duration { (0, 0) }; }
  action Never(Agent A) { preconditions { A.count == 99; } }
  action Mark(Agent A, Object O) { effects { O.done = true; } }
  action Unmark(Agent A, Object O) { effects { O.done = NULL; } }
  action Move(Agent A, Object O, Place P) { effects { O.at = P; } }
  action Set(Agent A, number N) { effects { A.count = N; } }
  action Count(Agent A) { effects { A.count = A.count + 1; } }
";

/// Returns a domain with two agents, four objects and three places, simple actions, and `tasks`.
pub fn text(tasks: &str) -> String {
    format!("{DATABASE} HTN {{ {ACTIONS} {tasks} }}")
}

/// Returns a reasoner for which every `Look(R, object)` has one solution, which changes nothing.
pub fn every_object() -> Scripted {
    let objects = ["CUP", "BOX", "PEN", "CAN"];
    objects.iter().fold(Scripted::new("", &[]), |reasoner, object| {
        reasoner.with(&format!("pick(R, {object})"), vec![solution(0.0, 0.0, "")])
    })
}
