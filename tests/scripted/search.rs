//! Decompositions, goals, SELECT, `let`, orders, and how a search ends.

use std::sync::atomic::{AtomicBool, Ordering};

use sgap::engine::{self, Aim, Branching, Budget, Ending, Settings, Truncated};
use sgap::plan::Node;

use crate::domain::{every_object, text};
use crate::reasoner::Scripted;
use crate::run::{BEST, FIRST, compile, goal, run, symbolic};

/// Plans `Go(R)` where every `Look` is granted once, without alternatives; returns what was looked at, in order.
fn looked(methods: &str) -> String {
    let settings = Settings {
        branching: Branching::Fixed(1),
        ..FIRST
    };
    run(&text(methods), "Go(R)", every_object(), &settings).tried()
}

#[test]
fn all_decompositions_are_tried_in_file_order() {
    let run = run(
        &text(
            "method Go(Agent A) {
               { subtasks { 1: Look(A, PEN); 2: Never(A) > 1; }; }
               { preconditions { A.count == 7; }; subtasks { 1: Look(A, CAN); }; }
               { subtasks { 1: Look(A, CUP); 2: Never(A) > 1; }; }
               { subtasks { 1: Look(A, BOX); }; }
               { subtasks { 1: Look(A, CAN); }; } }",
        ),
        "Go(R)",
        every_object(),
        &Settings {
            branching: Branching::Fixed(1),
            ..FIRST
        },
    );
    assert_eq!(run.tried(), "PEN CUP BOX");
    assert_eq!(run.plan(), "Look(R,BOX)");
    assert_eq!(run.outcome.ending, Ending::FirstPlan);
}

#[test]
fn a_goal_that_holds_leaves_nothing_to_do() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks { 1: Mark(A, CUP); 2: Have(A, CUP) > 1; 3: Have(A, BOX) > 2; }; } }
             method Have(Agent A, Object O) { goal { O.done == true; } { subtasks { 1: Mark(A, O); }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Mark(R,CUP) Mark(R,BOX)");
    let how = |node: &Node| (node.arguments.join(" "), node.parent, node.decomposition, node.action);
    let nodes = run.document().decomposition;
    assert_eq!(
        nodes.iter().map(how).collect::<Vec<_>>(),
        [
            ("R".into(), None, Some(0), None),
            ("R CUP".into(), Some(0), None, Some(0)),
            ("R CUP".into(), Some(0), None, None),
            ("R BOX".into(), Some(0), Some(0), None),
            ("R BOX".into(), Some(3), None, Some(1)),
        ]
    );
}

#[test]
fn a_goal_is_tested_in_the_state_in_which_its_task_is_reached() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks { 1: Have(A, CUP); 2: Unmark(A, CUP) > 1; 3: Have(A, CUP) > 2; }; } }
             method Have(Agent A, Object O) { goal { O.done == true; } { subtasks { 1: Mark(A, O); }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Mark(R,CUP) Unmark(R,CUP) Mark(R,CUP)");
}

#[test]
fn a_task_asked_for_whose_goal_holds_is_an_empty_plan() {
    let run = symbolic(
        &text("method Go(Agent A) { goal { A.count == NULL; } { subtasks { 1: Count(A); }; } }"),
        "Go(R)",
    );
    assert_eq!((run.plan(), run.outcome.ending), (String::new(), Ending::FirstPlan));
    let document = run.document();
    assert_eq!(
        (document.actions.len(), document.cost, document.makespan),
        (0, 0.0, 0.0)
    );
}

#[test]
fn an_action_may_be_asked_for_by_itself() {
    let run = symbolic(&text(""), "Mark(R, CUP)");
    assert_eq!(run.plan(), "Mark(R,CUP)");
    assert_eq!(run.document().decomposition[0].action, Some(0));
}

#[test]
fn select_tries_entities_in_declaration_order() {
    let methods =
        "method Go(Agent A) { { subtasks { O = SELECT(Object, {O != BOX;}); 1: Look(A, O); 2: Never(A) > 1; }; } }";
    assert_eq!(looked(methods), "CUP PEN CAN");
}

/// Weights are CUP 2, BOX 1, PEN 2, CAN unset: ties stay in declaration order, and what has no number comes last.
#[test]
fn selectordered_sorts_by_its_number() {
    let sorted = |direction: &str| {
        looked(&format!(
            "method Go(Agent A) {{ {{ subtasks {{
               O = SELECTORDERED(Object, {{}}, O.weight, {direction}); 1: Look(A, O); 2: Never(A) > 1; }}; }} }}"
        ))
    };
    assert_eq!(sorted("<"), "BOX CUP PEN CAN");
    assert_eq!(sorted(">"), "CUP PEN BOX CAN");
}

/// A zero is a zero: `-0` is not less, and a number divided by zero is none.
#[test]
fn selectordered_sees_no_difference_between_zeros_and_no_number_in_a_division_by_zero() {
    let sorted = |key: &str, direction: &str| {
        looked(&format!(
            "method Go(Agent A) {{ {{ subtasks {{
               O = SELECTORDERED(Object, {{O.weight != NULL;}}, {key}, {direction}); 1: Look(A, O); 2: Never(A) > 1; }}; }} }}"
        ))
    };
    // 0, -0, 0.
    assert_eq!(sorted("0 * (O.weight - 1.5)", "<"), "CUP BOX PEN");
    // None, -1, none.
    assert_eq!(sorted("1 / (O.weight - 2)", ">"), "BOX CUP PEN");
}

#[test]
fn selectonce_never_comes_back() {
    let methods =
        "method Go(Agent A) { { subtasks { O = SELECTONCE(Object, {O != CUP;}); 1: Look(A, O); 2: Never(A) > 1; }; } }";
    assert_eq!(looked(methods), "BOX");
}

#[test]
fn later_filters_see_earlier_variables_and_are_evaluated_again_for_each() {
    let methods = "method Go(Agent A) { { subtasks {
        O = SELECT(Object, {O.weight == 2;});
        P = SELECT(Object, {P.weight == O.weight; P != O;});
        1: Look(A, O); 2: Look(A, P) > 1; 3: Never(A) > 2; }; } }";
    assert_eq!(looked(methods), "CUP PEN PEN CUP");
}

/// A literal of a later filter is tested as soon as all that it mentions is bound: the values that pass, and their order, are
/// the same, but nobody binds what can't help. No entity is then looked at for `P` and `Q`: `O` alone takes back a choice.
#[test]
fn a_literal_about_earlier_variables_is_tested_when_they_are_bound() {
    let methods = "method Go(Agent A) { { subtasks {
        O = SELECT(Object, {});
        P = SELECT(Object, {});
        Q = SELECT(Object, {O.weight == 2; Q == P;});
        1: Mark(A, O); 2: Mark(A, Q) > 1; }; } }";
    let run = symbolic(&text(methods), "Go(R)");
    assert_eq!(run.plan(), "Mark(R,CUP) Mark(R,CUP)");
    let methods = methods.replace("O.weight == 2", "O.weight == 99");
    let run = symbolic(&text(&methods), "Go(R)");
    assert!(run.is_exhausted());
    let reasons = run.outcome.why_not.reasons();
    let (words, reason) = &reasons[0];
    assert!(words.contains("Q") && words.contains("99"), "{words}");
    let n_objects = run
        .domain
        .types
        .iter()
        .find(|t| t.name == "Object")
        .unwrap()
        .entities
        .len() as u64;
    assert_eq!(reason.n_branches, n_objects, "{words}");
}

#[test]
fn a_variable_of_one_select_is_not_disturbed_by_a_quantifier_of_another() {
    let methods = "method Go(Agent A) { { subtasks {
        O = SELECT(Object, {O.weight == 2;});
        P = SELECT(Object, {EXIST(Object Q, {Q != P;}, {Q == O;}); FORALL(Object Q, {Q == P;}, {Q != O;});});
        1: Look(A, O); 2: Look(A, P) > 1; 3: Never(A) > 2; }; } }";
    assert_eq!(looked(methods), "CUP BOX CUP PEN CUP CAN PEN CUP PEN BOX PEN CAN");
}

#[test]
fn let_names_a_value_and_makes_no_choice() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks {
               O = SELECT(Object, {O.at != NULL;}); let P = O.at; let Q = P.near;
               1: Move(A, O, Q); }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Move(R,CUP,SHELF)");
    assert_eq!(run.outcome.statistics.backtracks, 0);
}

/// The name is bound when the method is decomposed: what happens to the attribute later does not change it.
#[test]
fn let_keeps_the_value_of_the_moment() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks { let P = CUP.at;
               1: Move(A, CUP, SHELF); 2: Move(A, BOX, P) > 1; 3: Move(A, PEN, CUP.at) > 2; }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Move(R,CUP,SHELF) Move(R,BOX,TABLE) Move(R,PEN,SHELF)");
}

#[test]
fn arguments_are_evaluated_when_the_subtask_is_reached() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks {
               1: Move(A, CUP, CUP.at.near); 2: Twice(A, CUP.at) > 1; }; } }
             method Twice(Agent A, Place P) { { subtasks { 1: Move(A, BOX, P); 2: Move(A, CUP, FLOOR) > 1;
               3: Move(A, PEN, P) > 2; 4: Move(A, CAN, CUP.at) > 3; }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(
        run.plan(),
        "Move(R,CUP,SHELF) Move(R,BOX,SHELF) Move(R,CUP,FLOOR) Move(R,PEN,SHELF) Move(R,CAN,FLOOR)"
    );
}

#[test]
fn a_subtask_without_a_value_for_an_argument_fails() {
    let run = symbolic(
        &text("method Go(Agent A) { { subtasks { 1: Mark(A, A.holds); }; } { subtasks { 1: Mark(A, CUP); }; } }"),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Mark(R,CUP)");
    assert_eq!(run.reasons(), ["1 x Mark: its argument 2, R.holds, is NULL"]);
}

/// Two subtasks of two actions each and one of one: three blocks, six orders, and never one block inside another.
#[test]
fn unordered_subtasks_are_blocks_in_every_order() {
    let methods = "method Go(Agent A) { { subtasks { 1: Pair(A, CUP, BOX); 2: Look(A, PEN); 3: Look(A, CAN); 4: Never(A) > 1, > 2, > 3; }; } }
         method Pair(Agent A, Object O, Object P) { { subtasks { 1: Look(A, O); 2: Look(A, P) > 1; }; } }";
    let tried = looked(methods);
    let asked: Vec<&str> = tried.split(' ').collect();
    // Depth first over the tree of orders: what an order shares with the one before is not asked again.
    let expected = "CUP BOX PEN CAN | CAN PEN | PEN CUP BOX CAN | CAN CUP BOX | CAN CUP BOX PEN | PEN CUP BOX";
    assert_eq!(asked, expected.replace("| ", "").split(' ').collect::<Vec<_>>());
}

#[test]
fn a_subtask_waits_for_all_that_it_comes_after() {
    let methods = "method Go(Agent A) { { subtasks { 1: Look(A, CUP) > 2; 2: Look(A, BOX) > 3; 3: Look(A, PEN); 4: Look(A, CAN) > 1; }; } }";
    assert_eq!(looked(methods), "PEN BOX CUP CAN");
}

#[test]
fn what_a_branch_has_changed_is_undone() {
    let run = symbolic(
        &text(
            "method Go(Agent A) {
               { subtasks { 1: Mess(A); 2: Never(A) > 1; }; }
               { subtasks { 1: Clean(A); }; } }
             action Mess(Agent A) { effects {
               A.holds = CUP; CUP.at = SHELF; CUP.users <<= A; BOX.users =>> H; A.count = 5;
               FORALL(Object O, {}, {O.done = true;}); } }
             action Clean(Agent A) { preconditions {
               A.holds == NULL; CUP.at == TABLE; size(CUP.users) == 0; H >> BOX.users; A.count == NULL;
               FORALL(Object O, {}, {O.done != true;}); } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Clean(R)");
}

#[test]
fn a_search_without_a_plan_is_exhausted() {
    let run = symbolic(
        &text("method Go(Agent A) { { subtasks { O = SELECT(Object, {}); 1: Mark(A, O); 2: Never(A) > 1; }; } }"),
        "Go(R)",
    );
    assert!(run.is_exhausted());
    assert!(run.outcome.found.is_none());
    assert_eq!(run.outcome.statistics.expansions, 1 + 4 * 2);
}

#[test]
fn a_recursion_without_an_end_stops_at_the_depth_limit() {
    let run = run(
        &text(
            "method Go(Agent A) { { subtasks { 1: Set(A, 0); 2: Up(A) > 1; }; } }
             method Up(Agent A) { { subtasks { 1: Count(A); 2: Further(A, CUP) > 1; }; } }
             method Further(Agent A, Object O) { { subtasks { 1: Up(A); }; } }",
        ),
        "Go(R)",
        Scripted::new("", &[]),
        &Settings {
            budget: Budget {
                depth: 6,
                ..FIRST.budget
            },
            ..FIRST
        },
    );
    let cut = Truncated {
        depth: 1,
        ..Truncated::default()
    };
    assert_eq!(run.outcome.ending, Ending::ExhaustedTruncated(cut));
    assert_eq!(
        run.reasons(),
        ["1 x Up goes on below itself, more than 6 methods deep: Up(R) > Further(R, CUP) > Up(R)"]
    );
}

#[test]
fn a_recursion_whose_goal_comes_true_ends() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks { 1: Set(A, 0); 2: Up(A) > 1; }; } }
             method Up(Agent A) { goal { A.count >= 3; } { subtasks { 1: Count(A); 2: Up(A) > 1; }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Set(R,0) Count(R) Count(R) Count(R)");
}

fn ending_within(expansions: u64) -> (Ending, u64, bool) {
    let run = run(
        &text("method Go(Agent A) { { subtasks { 1: Mark(A, CUP); 2: Mark(A, BOX) > 1; }; } }"),
        "Go(R)",
        Scripted::new("", &[]),
        &Settings {
            aim: Aim::Best,
            budget: Budget {
                expansions,
                ..FIRST.budget
            },
            ..FIRST
        },
    );
    let outcome = run.outcome;
    (outcome.ending, outcome.statistics.expansions, outcome.found.is_some())
}

/// The method and two actions: a budget of three is just enough.
#[test]
fn the_budget_is_the_number_of_tasks_taken_up() {
    assert_eq!(ending_within(2), (Ending::BudgetSpent, 2, false));
    assert_eq!(ending_within(3), (Ending::Exhausted, 3, true));
    assert_eq!(ending_within(0), (Ending::BudgetSpent, 0, false));
}

/// Eight variables of four values and a last one that has none: no task is ever taken up, and there are 65536 choices.
#[test]
fn choices_without_tasks_spend_the_budget_too() {
    let selects: String = (0..8).map(|i| format!("V{i} = SELECT(Object, {{}});\n")).collect();
    let uses: String = (0..8).map(|i| format!("V{i} == W; ")).collect();
    let run = run(
        &text(&format!(
            "method Go(Agent A) {{ {{ subtasks {{ {selects} W = SELECT(Object, {{ NOT{{ {uses} }}; W.weight == 7; }}); 1: Mark(A, W); }}; }} }}"
        )),
        "Go(R)",
        Scripted::new("", &[]),
        &Settings {
            budget: Budget {
                expansions: 500,
                ..FIRST.budget
            },
            ..FIRST
        },
    );
    assert_eq!(run.outcome.ending, Ending::BudgetSpent);
    assert_eq!(run.outcome.statistics.backtracks, 500);
}

/// Plans for the best with a flag that `on_plan` raises; says how it ended and what it kept.
fn interrupted(raise_before: bool) -> (Ending, bool) {
    let mut domain = compile(&text(
        "method Go(Agent A) { { subtasks { 1: Mark(A, CUP); 2: Mark(A, BOX) > 1; }; } { subtasks { 1: Mark(A, CUP); }; } }",
    ));
    let goal = goal(&mut domain, "Go(R)");
    let stop = AtomicBool::new(raise_before);
    let mut reasoner = Scripted::new("", &[]);
    let outcome = engine::solve(&domain, &goal, &mut reasoner, &BEST, &stop, &mut |_, _| {
        stop.store(true, Ordering::Relaxed)
    });
    (outcome.ending, outcome.found.is_some())
}

#[test]
fn an_interrupt_ends_the_search_with_the_best_plan_so_far() {
    assert_eq!(interrupted(false), (Ending::Interrupted, true));
    assert_eq!(interrupted(true), (Ending::Interrupted, false));
}
