//! The cheapest plan: what is announced, what is cut off, and which costs are refused.

use sgap::engine::{Aim, Ending, Settings};

use crate::domain::text;
use crate::reasoner::Scripted;
use crate::run::{BEST, FIRST, Run, run, symbolic};

/// Plans `Go(R)` for the best; `Pay(R, N)` costs N.
fn best(methods: &str) -> Run {
    let pay = "action Pay(Agent A, number N) { effects { A.count = N; } cost { N } }";
    run(
        &text(&format!("{pay} {methods}")),
        "Go(R)",
        Scripted::new("", &[]),
        &BEST,
    )
}

fn costs(run: &Run) -> Vec<f64> {
    run.announced.iter().map(|(_, cost)| *cost).collect()
}

#[test]
fn each_better_plan_is_announced_once() {
    let run = best(
        "method Go(Agent A) { { subtasks { 1: Pay(A, 5); }; } { subtasks { 1: Pay(A, 7); }; } { subtasks { 1: Pay(A, 3); }; }
           { subtasks { 1: Pay(A, 3); }; } { subtasks { 1: Pay(A, 1); 2: Pay(A, 1) > 1; }; } { subtasks { 1: Pay(A, 2); }; } }",
    );
    assert_eq!(costs(&run), [5.0, 3.0, 2.0]);
    assert_eq!(run.plan(), "Pay(R,1) Pay(R,1)");
    assert!(run.is_exhausted());
    assert_eq!(run.outcome.statistics.plans, 3);
    assert_eq!(
        run.reasons(),
        [
            "1 x a cost of 0.0000 and at least 7.0000 to come are not below the best plan's 5.0000",
            "1 x a cost of 0.0000 and at least 3.0000 to come are not below the best plan's 3.0000",
            "1 x a cost of 0.0000 and at least 2.0000 to come are not below the best plan's 2.0000"
        ]
    );
}

/// After the last action there may still be choices that need none: they give no better plan.
#[test]
fn a_plan_is_not_announced_again_for_choices_that_cost_nothing() {
    let run = best(
        "method Go(Agent A) { { subtasks { 1: Pay(A, 5); 2: Rest(A) > 1; }; } }
         method Rest(Agent A) { { subtasks { }; } { subtasks { }; } { subtasks { O = SELECT(Object, {}); 1: Same(A, O); }; } }
         method Same(Agent A, Object O) { goal { O != NULL; } { subtasks { 1: Mark(A, O); }; } }",
    );
    assert_eq!(costs(&run), [5.0]);
}

#[test]
fn an_empty_plan_is_announced_once() {
    let run = best("method Go(Agent A) { { subtasks { }; } { subtasks { }; } }");
    assert_eq!(run.announced, [(String::new(), 0.0)]);
}

/// A branch is left as soon as it is known to cost as much as the best plan: of constants that is before its first action.
#[test]
fn dear_branches_are_cut_off_early() {
    let run = best(
        "method Go(Agent A) { { subtasks { 1: Pay(A, 2); }; }
           { subtasks { 1: Pay(A, 1); 2: Pay(A, 1) > 1; 3: Pay(A, 1) > 2; 4: Pay(A, 1) > 3; }; } }",
    );
    // The method, one action of the first decomposition, none of the second.
    assert_eq!(run.outcome.statistics.expansions, 2);
    assert_eq!(costs(&run), [2.0]);
}

/// A choice made before the best plan was known, at a point that already costs as much, is not tried.
#[test]
fn choices_of_branches_that_have_become_too_dear_are_dropped() {
    let run = best(
        "method Go(Agent A) { { subtasks { 1: Pay(A, 2); 2: Free(A) > 1; }; } }
         method Free(Agent A) { { subtasks { O = SELECT(Object, {}); 1: Pay(A, 0); }; } }",
    );
    assert_eq!(run.outcome.statistics.expansions, 4);
    assert_eq!(run.outcome.statistics.plans, 1);
}

#[test]
fn the_first_plan_is_enough_unless_the_best_is_asked_for() {
    let pay = "action Pay(Agent A, number N) { cost { N } }
         method Go(Agent A) { { subtasks { 1: Pay(A, 5); }; } { subtasks { 1: Pay(A, 3); }; } }";
    let run = run(&text(pay), "Go(R)", Scripted::new("", &[]), &FIRST);
    assert_eq!(
        (run.plan().as_str(), run.outcome.ending),
        ("Pay(R,5)", Ending::FirstPlan)
    );
    assert_eq!(costs(&run), [5.0]);
}

#[test]
fn a_cost_below_zero_or_without_a_value_is_refused() {
    let run = best(
        "action Half(Agent A) { cost { 1 / A.count } }
         method Go(Agent A) { { subtasks { 1: Pay(A, 1 - 3); }; } { subtasks { 1: Half(A); }; } { subtasks { 1: Pay(A, 0); 2: Half(A) > 1; }; }
           { subtasks { 1: Pay(A, 2); 2: Half(A) > 1; }; } }",
    );
    assert_eq!(run.plan(), "Pay(R,2) Half(R)");
    assert_eq!(costs(&run), [2.5]);
    assert_eq!(
        run.reasons(),
        [
            "2 x Half(R): its cost has no value: something in it is NULL, or not finite",
            "1 x Pay(R, -2): its cost is -2, and must be 0 or more"
        ]
    );
}

#[test]
fn a_wrong_duration_is_refused() {
    let run = symbolic(
        &text(
            "action Wait(Agent A, number L, number M) { duration { (L, M) } }
             method Go(Agent A) { { subtasks { 1: Wait(A, 0 - 1, 2); }; } { subtasks { 1: Wait(A, 3, 2); }; }
               { subtasks { 1: Wait(A, 1, 1 / 0); }; } { subtasks { 1: Wait(A, 0, 0 - 1); }; } { subtasks { 1: Wait(A, 1, 2); }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Wait(R,1,2)");
    assert_eq!(
        run.reasons(),
        [
            "1 x Wait(R, -1, 2): its least duration is -1, and must be 0 or more",
            "1 x Wait(R, 3, 2): its least duration 3 is above its most 2",
            "1 x Wait: its argument 3, (1 / 0), is NULL",
            "1 x Wait(R, 0, -1): its most duration is -1, and must be 0 or more"
        ]
    );
}

/// What a refused action did is undone like anything else.
#[test]
fn effects_of_a_refused_action_are_undone() {
    let run = symbolic(
        &text(
            "action Owe(Agent A) { effects { A.count = 7; } cost { 0 - CUP.weight } }
             action Even(Agent A) { preconditions { A.count == NULL; } }
             method Go(Agent A) { { subtasks { 1: Owe(A); }; } { subtasks { 1: Even(A); }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Even(R)");
}

/// The best plan of four jobs in any order where each pays for what was done before: by hand, heaviest first.
#[test]
fn the_best_order_is_found() {
    let methods = "action Carry(Agent A, Object O) { preconditions { O.weight != NULL; } effects { O.done = true; A.count = A.count + 1; }
             cost { A.count * O.weight } }
         method Go(Agent A) { { subtasks { 1: Set(A, 1); 2: Carry(A, BOX) > 1; 3: Carry(A, CUP) > 1; 4: Carry(A, PEN) > 1; }; } }";
    let run = run(
        &text(methods),
        "Go(R)",
        Scripted::new("", &[]),
        &Settings {
            aim: Aim::Best,
            ..FIRST
        },
    );
    // `Set` costs 1; 1 * 2 + 2 * 2 + 3 * 1 = 9, against 1 * 1 + 2 * 2 + 3 * 2 = 11 in the order of the file.
    assert_eq!(run.plan(), "Set(R,1) Carry(R,CUP) Carry(R,PEN) Carry(R,BOX)");
    assert_eq!(costs(&run), [12.0, 11.0, 10.0]);
    assert!(run.is_exhausted());
}
