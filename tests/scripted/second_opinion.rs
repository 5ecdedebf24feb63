//! What the language leaves to be decided, search and validator decide alike. (`tests/props.rs` looks for more.)

use sgap::engine::{Budget, Settings};
use sgap::plan::Plan;
use sgap::report::json;

use crate::domain::text;
use crate::reasoner::Scripted;
use crate::run::{FIRST, Run, run, second_opinion, symbolic};

/// Plans `Go(R)`; the plan must be valid.
fn agreed(tasks: &str) -> (Run, Plan) {
    let run = symbolic(&text(tasks), "Go(R)");
    let plan = run.document();
    second_opinion(&run, &plan).map_err(|f| f.to_string()).unwrap();
    (run, plan)
}

/// The box follows the cup to where it is then, not to where it was when the task was decomposed.
#[test]
fn arguments_are_those_of_the_moment_at_which_the_subtask_is_reached() {
    let (run, mut plan) =
        agreed("method Go(Agent A) { { subtasks { 1: Move(A, CUP, SHELF); 2: Move(A, BOX, CUP.at) > 1; }; } }");
    assert_eq!(plan.actions[1].arguments, ["R", "BOX", "SHELF"]);
    plan.actions[1].arguments[2] = "TABLE".into();
    plan.actions[1].changes.insert("BOX.at".into(), "TABLE".into());
    plan.decomposition[2].arguments[2] = "TABLE".into();
    // The link said that the box needs to know where the cup is put; nothing else is wrong.
    assert_eq!(second_opinion(&run, &plan).unwrap_err().code(), "subtasks");
}

/// Variables are those of the moment at which the task was decomposed.
#[test]
fn variables_are_those_of_the_moment_of_the_decomposition() {
    let (run, mut plan) = agreed(
        "method Go(Agent A) { { subtasks { P = SELECT(Place, {CUP.at == P;}); 1: Move(A, CUP, SHELF); 2: Move(A, BOX, P) > 1; }; } }",
    );
    assert_eq!(plan.actions[1].arguments, ["R", "BOX", "TABLE"]);
    plan.actions[1].arguments[2] = "SHELF".into();
    plan.actions[1].changes.insert("BOX.at".into(), "SHELF".into());
    plan.decomposition[2].arguments[2] = "SHELF".into();
    assert_eq!(second_opinion(&run, &plan).unwrap_err().code(), "subtasks");
}

#[test]
fn effects_with_a_value_through_null_change_nothing() {
    let (_, plan) = agreed(
        "action Lose(Agent A) { effects { CUP.at = A.holds.at; CUP.weight = A.count + 1; BOX.users = BOX.users + A.helper; PEN.users = [A, A.helper]; } }
         method Go(Agent A) { { subtasks { 1: Lose(A); }; } }",
    );
    assert!(plan.actions[0].changes.is_empty());
}

/// Each level nests one task deeper. The document is a list, so writing, reading and judging it takes no stack.
#[test]
fn a_recursion_of_thousands_of_levels_is_written_read_and_valid() {
    const LEVELS: usize = 3_000;
    let tasks = format!(
        "method Go(Agent A) {{ {{ subtasks {{ 1: Set(A, 0); 2: UpTo(A, {LEVELS}) > 1; }}; }} }}
         method UpTo(Agent A, number N) {{ goal {{ A.count == N; }} {{ subtasks {{ 1: Count(A); 2: UpTo(A, N) > 1; }}; }} }}"
    );
    let settings = Settings {
        budget: Budget {
            expansions: 4 * LEVELS as u64,
            depth: LEVELS + 10,
        },
        ..FIRST
    };
    let run = run(&text(&tasks), "Go(R)", Scripted::new("", &[]), &settings);
    let plan = run.document();
    // `Go` and `Set`; on each level `UpTo` and `Count`; the last `UpTo`, whose goal holds.
    assert_eq!(
        (plan.actions.len(), plan.decomposition.len()),
        (LEVELS + 1, 2 * LEVELS + 3)
    );
    assert_eq!(plan.links.len(), LEVELS, "a chain");
    let text = json::write(&plan).unwrap();
    let mut read = json::read(&text).unwrap();
    assert_eq!(read, plan);
    let verdict = second_opinion(&run, &read).map_err(|f| f.to_string()).unwrap();
    assert_eq!(verdict.tasks, plan.decomposition.len());
    // The last leaf is looked at as much as the first.
    let leaf = read.decomposition.iter().rposition(|n| n.task == "Count").unwrap();
    read.decomposition[leaf].arguments[0] = "H".into();
    let fault = second_opinion(&run, &read).unwrap_err();
    assert_eq!(fault.code(), "leaf-mismatch");
    assert_eq!(fault.place.tasks.len(), LEVELS + 2);
}

#[test]
fn order_through_a_subtask_without_actions() {
    agreed(
        "method Nothing(Agent A) { goal { A.count == NULL; } { subtasks { 1: Mark(A, CUP); }; } }
         method Go(Agent A) { { subtasks { 1: Mark(A, BOX); 2: Nothing(A) > 1; 3: Mark(H, PEN) > 2; }; } }",
    );
}
