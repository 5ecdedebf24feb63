//! Unordered subtasks that mix step by step.

use sgap::engine::{Aim, Cuts, Settings};
use sgap::report::json;

use crate::domain::text;
use crate::reasoner::Scripted;
use crate::run::{FIRST, Run, run, second_opinion};

const MIXED: Settings = Settings {
    interleave: true,
    ..FIRST
};

/// Plans `Go(R)`; every plan must be valid, also as it is written and read again.
fn plans(tasks: &str, settings: &Settings) -> (Run, Vec<String>) {
    let run = run(&text(tasks), "Go(R)", Scripted::new("", &[]), settings);
    for i in 0..run.n_plans() {
        let plan = json::read(&json::write(&run.document_of(i)).unwrap()).unwrap();
        second_opinion(&run, &plan).map_err(|f| f.to_string()).unwrap();
    }
    let plans = run.announced.iter().map(|(plan, _)| plan.clone()).collect();
    (run, plans)
}

const PAIRS: &str = "method Go(Agent A) { { subtasks { 1: Pair(A, CUP, BOX); 2: Pair(A, PEN, CAN); }; } }
     method Pair(Agent A, Object O, Object P) { { subtasks { 1: Mark(A, O); 2: Mark(A, P) > 1; }; } }";

/// Each pair keeps its own order: there are six ways to mix two and two, two of them in blocks.
#[test]
fn blocks_mix_at_every_step() {
    let all = Settings {
        aim: Aim::All(100),
        ..MIXED
    };
    for cuts in [Cuts::Off, Cuts::On, Cuts::Always] {
        let (run, plans) = plans(PAIRS, &Settings { cuts, ..all });
        let short = |p: &String| p.replace("Mark(R,", "").replace(')', "");
        let mut found: Vec<String> = plans.iter().map(short).collect();
        found.sort();
        let expected = [
            "CUP BOX PEN CAN",
            "CUP PEN BOX CAN",
            "CUP PEN CAN BOX",
            "PEN CAN CUP BOX",
            "PEN CUP BOX CAN",
            "PEN CUP CAN BOX",
        ];
        assert_eq!(found, expected, "{cuts:?}");
        assert!(run.is_exhausted());
    }
    let (_, in_blocks) = plans(
        PAIRS,
        &Settings {
            interleave: false,
            ..all
        },
    );
    assert_eq!(in_blocks.len(), 2);
}

/// The first plan is that of the blocks, where they have one.
#[test]
fn the_first_plan_is_in_blocks_where_that_is_possible() {
    let (run, _) = plans(PAIRS, &MIXED);
    assert_eq!(run.plan(), "Mark(R,CUP) Mark(R,BOX) Mark(R,PEN) Mark(R,CAN)");
}

/// Each helps the other half way: no order of blocks has a plan.
const NEEDS_EACH_OTHER: &str = "
     action Start(Agent A, Object O) { effects { O.done = true; } }
     action Stop(Agent A, Object O, Object P) { preconditions { P.done == true; } effects { O.weight = 9; } }
     method Go(Agent A) { { subtasks { 1: Job(A, CUP, BOX); 2: Job(A, BOX, CUP); 3: End(A) > 1, > 2; }; } }
     method Job(Agent A, Object O, Object P) { { subtasks { 1: Start(A, O); 2: Stop(A, O, P) > 1; }; } }
     action End(Agent A) { preconditions { CUP.weight == 9; BOX.weight == 9; } }";

#[test]
fn a_plan_that_only_mixing_finds() {
    let (run, _) = plans(NEEDS_EACH_OTHER, &FIRST);
    assert!(run.is_exhausted() && run.outcome.found.is_none());
    let (run, _) = plans(NEEDS_EACH_OTHER, &MIXED);
    assert_eq!(
        run.plan(),
        "Start(R,CUP) Start(R,BOX) Stop(R,BOX,CUP) Stop(R,CUP,BOX) End(R)"
    );
}

/// A domain may ask for it by itself; what follows a subtask waits for all of it.
#[test]
fn what_comes_after_a_subtask_waits_for_all_below_it() {
    let tasks = "method Go(Agent A) { { subtasks { 1: Pair(A, CUP, BOX); 2: Mark(A, PEN) > 1; 3: Mark(A, CAN); }; } }
         method Pair(Agent A, Object O, Object P) { { subtasks { 1: Inner(A, O); 2: Mark(A, P); }; } }
         method Inner(Agent A, Object O) { goal { O.done == true; } { subtasks { 1: Mark(A, O); }; } }";
    let (_, plans) = plans(
        tasks,
        &Settings {
            aim: Aim::All(100),
            ..MIXED
        },
    );
    // CAN is free: four places in each of the two orders of CUP and BOX, before PEN.
    assert_eq!(plans.len(), 8);
    for plan in plans {
        let at = |o: &str| plan.find(o).unwrap();
        assert!(at("PEN") > at("CUP") && at("PEN") > at("BOX"), "{plan}");
    }
}

/// More than 64 subtasks, whose bits lie elsewhere.
#[test]
fn many_unordered_subtasks() {
    let many: String = (0..70).map(|i| format!("{i}: Count(A); ")).collect();
    let all: String = (0..70).map(|i| format!("> {i}")).collect::<Vec<_>>().join(", ");
    let tasks = format!(
        "action Full(Agent A) {{ preconditions {{ A.count == 70; }} }}
         method Go(Agent A) {{ {{ subtasks {{ 1: Set(A, 0); 2: Many(A) > 1; }}; }} }}
         method Many(Agent A) {{ {{ subtasks {{ {many} 70: Full(A) {all}; }}; }} }}"
    );
    for settings in [FIRST, MIXED] {
        let (run, _) = plans(&tasks, &settings);
        assert_eq!(run.outcome.found.as_ref().unwrap().steps.len(), 72);
        assert_eq!(run.outcome.statistics.backtracks, 0);
    }
}

/// A plan that mixes says so; without that it is none.
#[test]
fn a_mixed_plan_that_claims_to_be_in_blocks_is_refused() {
    let (run, _) = plans(NEEDS_EACH_OTHER, &MIXED);
    let mut plan = run.document();
    plan.interleaved = false;
    assert_eq!(second_opinion(&run, &plan).unwrap_err().code(), "subtasks");
}

/// The validator sees when a task was taken up before what it comes after was over.
#[test]
fn a_task_that_was_taken_up_too_early_is_refused() {
    let (run, _) = plans(
        "method Go(Agent A) { { subtasks { 1: Mark(A, CUP); 2: Mark(A, CUP); 3: Mark(A, BOX) > 1; }; } }",
        &MIXED,
    );
    let mut plan = run.document();
    assert_eq!(run.plan(), "Mark(R,CUP) Mark(R,CUP) Mark(R,BOX)");
    // BOX first: nothing that it could come after is over.
    plan.actions.swap(0, 2);
    plan.decomposition.swap(1, 3);
    for (i, action) in plan.actions.iter_mut().enumerate() {
        action.index = i;
        plan.decomposition[i + 1].action = Some(i);
    }
    let changes = std::mem::take(&mut plan.actions[2].changes);
    plan.actions[1].changes = changes;
    assert_eq!(second_opinion(&run, &plan).unwrap_err().code(), "subtasks");
}
