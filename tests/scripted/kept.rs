//! Repair: the first actions of an earlier plan are kept.

use indexmap::IndexMap;
use sgap::engine::{Aim, Cuts, Ending, Kept, Settings};
use sgap::ir::{Domain, TaskId};
use sgap::plan::{Action, Changes, Geometry};

use crate::reasoner::{Scripted, solution};
use crate::run::{FIRST, Run, compile, goal, repair, second_opinion};

const CONTEXT: &str = "
factdatabase {
  define entityType Object;
  define entityType Place;
  define entityAttributes Agent { dynamic atom bool on; dynamic atom number n; }
  define entityAttributes Object { dynamic atom Place at; }
  R = new Agent; CUP = new Object; BOX = new Object; TABLE = new Place; SHELF = new Place;
}
action Put(Agent A, Object O, Place P) { projects { place(A, O, P) }; effects { O.at = P; }; }
action Mark(Agent A, Object O, Place P) { preconditions { O.at != P; }; effects { O.at = P; }; }
action On(Agent A) { preconditions { A.on != true; }; effects { A.on = true; }; }
action Off(Agent A) { preconditions { A.on == true; }; effects { A.on = false; }; }
";

/// Returns a kept action, written `Put(R, CUP, SHELF)`, with the motions of the script's solution `alternative`, if any.
fn keep(domain: &mut Domain, text: &str, alternative: Option<u32>) -> Kept {
    let ground = goal(domain, text);
    let TaskId::Action(action) = ground.task else {
        panic!("{text} is no action");
    };
    let arguments: Vec<String> = ground.args.iter().map(|v| domain.show(v)).collect();
    let geometry = alternative.map(|alternative| Geometry {
        action: "place".into(),
        gas: 0,
        alternative,
        agent: arguments[0].clone(),
        arm: String::new(),
        object: arguments[1].clone(),
        grasp: String::new(),
        stand: None,
        placement: None,
        cost_parts: IndexMap::new(),
        sub_actions: Vec::new(),
    });
    let written = Action {
        index: 0,
        name: domain.actions[action.index()].name.as_str().into(),
        arguments: arguments.into_iter().map(Into::into).collect(),
        agents: Vec::new(),
        cost: 0.0,
        duration: [0.0; 2],
        start: 0.0,
        end: 0.0,
        geometry: geometry.map(Box::new),
        changes: Changes::default(),
    };
    Kept {
        action,
        args: ground.args,
        written,
    }
}

/// Plans `task` with the actions kept, which have no motions unless a number says which.
fn run(tasks: &str, task: &str, kept: &[(&str, Option<u32>)], reasoner: Scripted, settings: &Settings) -> Run {
    let mut domain = compile(&format!("{CONTEXT}{tasks}"));
    let kept: Vec<Kept> = kept.iter().map(|(text, n)| keep(&mut domain, text, *n)).collect();
    let goal = goal(&mut domain, task);
    repair(domain, goal, &kept, reasoner, settings)
}

/// As [`run`], without motions; the validator accepts the plan.
fn symbolic(tasks: &str, task: &str, kept: &[&str]) -> Run {
    let kept: Vec<_> = kept.iter().map(|text| (*text, None)).collect();
    let run = run(tasks, task, &kept, Scripted::new("", &[]), &FIRST);
    if run.outcome.found.is_some() {
        second_opinion(&run, &run.document()).unwrap();
    }
    run
}

/// A cup and a box, each with three places on the shelf and on the table.
fn places() -> Scripted {
    let three = |cost: f64| (0..3).map(|i| solution(cost + f64::from(i), 1.0, "")).collect();
    Scripted::new("", &[])
        .with("place(R, CUP, SHELF)", three(10.0))
        .with("place(R, BOX, TABLE)", three(20.0))
}

const BOTH: &str = "method Go(Agent A) {
  { subtasks { 1: Put(A, CUP, SHELF); 2: Put(A, BOX, SHELF) > 1; }; }
  { subtasks { 1: Put(A, CUP, SHELF); 2: Put(A, BOX, TABLE) > 1; }; }
}";

/// The box does not fit on the shelf: it goes to the table, and the cup stays where the earlier plan has put it.
#[test]
fn what_comes_after_is_tried_differently_and_what_is_kept_is_not() {
    let run = run(BOTH, "Go(R)", &[("Put(R, CUP, SHELF)", Some(2))], places(), &FIRST);
    assert_eq!(run.plan(), "Put(R,CUP,SHELF) Put(R,BOX,TABLE)");
    // Once to see that it can be done at all, and once in each decomposition.
    let expected = [
        "adopt 2 place(R, CUP, SHELF)",
        "adopt 2 place(R, CUP, SHELF)",
        "project place(R, BOX, SHELF)",
        "adopt 2 place(R, CUP, SHELF)",
        "project place(R, BOX, TABLE)",
    ];
    assert_eq!(run.reasoner.asked, expected);
    let found = run.outcome.found.unwrap();
    let charge = found.charge(&found.steps[0]);
    assert_eq!(charge.geometric, (12.0, 1.0), "the third solution");
}

/// A kept action has no alternatives, those after it have.
#[test]
fn only_what_is_not_kept_is_asked_for_alternatives() {
    let tasks = "action Never(Agent A) { preconditions { A.n == 1; } }
      method Go(Agent A) { { subtasks { 1: Put(A, CUP, SHELF); 2: Put(A, BOX, TABLE) > 1; 3: Never(A) > 2; }; } }";
    let run = run(tasks, "Go(R)", &[("Put(R, CUP, SHELF)", Some(0))], places(), &FIRST);
    assert!(matches!(run.outcome.ending, Ending::ExhaustedTruncated(cut) if cut.alternatives == 1));
    let asked = |what: &str| run.reasoner.asked.iter().filter(|a| a.starts_with(what)).count();
    assert_eq!((asked("adopt"), asked("project"), asked("alternative")), (2, 1, 2));
}

/// A plan that the reasoner can't take over is no plan to begin with.
#[test]
fn motions_that_are_not_there_are_refused() {
    let run = run(BOTH, "Go(R)", &[("Put(R, CUP, SHELF)", None)], places(), &FIRST);
    assert_eq!(run.outcome.impossible, Some(0));
    assert_eq!(run.reasons(), ["1 x place(R, CUP, SHELF): no solution: no motions"]);
}

const MARKS: &str = "method Go(Agent A) { { subtasks { 1: Mark(A, CUP, SHELF); 2: Mark(A, BOX, SHELF); }; } }
method Either(Agent A) { { subtasks { 1: Mark(A, CUP, SHELF); }; } { subtasks { 1: Mark(A, CUP, TABLE); 2: Mark(A, BOX, TABLE) > 1; }; } }";

#[test]
fn from_nothing_to_the_whole_plan() {
    let kept = ["Mark(R, BOX, SHELF)", "Mark(R, CUP, SHELF)"];
    let plans = [
        "Mark(R,CUP,SHELF) Mark(R,BOX,SHELF)",
        "Mark(R,BOX,SHELF) Mark(R,CUP,SHELF)",
    ];
    assert_eq!(symbolic(MARKS, "Go(R)", &[]).plan(), plans[0]);
    assert_eq!(
        symbolic(MARKS, "Go(R)", &kept[..1]).plan(),
        plans[1],
        "the order that fits"
    );
    assert_eq!(symbolic(MARKS, "Go(R)", &kept).plan(), plans[1]);
    let other = symbolic(MARKS, "Either(R)", &["Mark(R, CUP, TABLE)"]);
    assert_eq!(
        other.plan(),
        "Mark(R,CUP,TABLE) Mark(R,BOX,TABLE)",
        "the decomposition that fits"
    );
}

#[test]
fn a_prefix_that_fits_no_decomposition_is_told() {
    let run = symbolic(MARKS, "Go(R)", &["Mark(R, CUP, SHELF)", "Mark(R, BOX, TABLE)"]);
    assert!(run.is_exhausted());
    let expected = [
        "1 x Mark(R, BOX, SHELF) is not the next kept action, 1 Mark(R, BOX, TABLE)",
        "1 x Mark(R, BOX, SHELF) is not the next kept action, 0 Mark(R, CUP, SHELF)",
    ];
    assert_eq!(run.reasons(), expected);
    // More is kept than the task has.
    let run = symbolic(MARKS, "Either(R)", &["Mark(R, CUP, SHELF)", "On(R)"]);
    let expected = [
        "1 x nothing is left to do before the kept action 1 On(R)",
        "1 x Mark(R, CUP, TABLE) is not the next kept action, 0 Mark(R, CUP, SHELF)",
    ];
    assert_eq!(run.reasons(), expected);
}

#[test]
fn a_kept_action_that_can_not_be_done_is_named() {
    let run = symbolic(MARKS, "Go(R)", &["Mark(R, CUP, SHELF)", "Mark(R, CUP, SHELF)"]);
    assert_eq!((run.outcome.impossible, run.plan()), (Some(1), "Exhausted".to_owned()));
    let expected = ["1 x Mark(R, CUP, SHELF): CUP.at != SHELF is false (CUP.at is SHELF)"];
    assert_eq!(run.reasons(), expected);
}

/// Interleaved, what is kept may mix two methods.
#[test]
fn kept_actions_of_two_methods_mix_when_interleaved() {
    let tasks = "method Two(Agent A, Place P) { { subtasks { 1: Mark(A, CUP, P); 2: Mark(A, BOX, P) > 1; }; } }
      method Go(Agent A) { { subtasks { 1: Two(A, SHELF); 2: Two(A, TABLE); }; } }";
    let kept = ["Mark(R, CUP, SHELF)", "Mark(R, CUP, TABLE)"];
    assert!(
        symbolic(tasks, "Go(R)", &kept).is_exhausted(),
        "in blocks they don't mix"
    );
    let kept = kept.map(|text| (text, None));
    let interleaved = Settings {
        interleave: true,
        ..FIRST
    };
    let run = run(tasks, "Go(R)", &kept, Scripted::new("", &[]), &interleaved);
    assert!(
        run.plan()
            .starts_with("Mark(R,CUP,SHELF) Mark(R,CUP,TABLE) Mark(R,BOX,"),
        "{}",
        run.plan()
    );
    second_opinion(&run, &run.document()).unwrap();
}

/// After `On Off` the state is the one at the start, and the same is to be done; but another action is due.
#[test]
fn the_memory_tells_how_much_of_the_kept_is_done() {
    let tasks = "method Blink(Agent A) {
      { subtasks { 1: On(A); 2: Off(A) > 1; 3: Blink(A) > 2; }; }
      { }
    }";
    let kept = ["On(R)", "Off(R)", "On(R)", "Off(R)"].map(|text| (text, None));
    for (cuts, aim) in [(Cuts::Always, Aim::First), (Cuts::Always, Aim::Best)] {
        let settings = Settings { cuts, aim, ..FIRST };
        let run = run(tasks, "Blink(R)", &kept, Scripted::new("", &[]), &settings);
        assert_eq!(run.plan(), "On(R) Off(R) On(R) Off(R)");
    }
}
