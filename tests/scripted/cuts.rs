//! Branches that are left: circles, what failed before, what was found before, what costs too much.

use sgap::engine::{Aim, Budget, Cuts, Ending, Settings, Statistics, Truncated};

use crate::domain::text;
use crate::reasoner::Scripted;
use crate::run::{BEST, FIRST, Run, run, symbolic};

fn with(tasks: &str, settings: &Settings) -> Run {
    run(&text(tasks), "Go(R)", Scripted::new("", &[]), settings)
}

/// What is left out loses nothing: the search has ended, and not for want of depth.
#[test]
fn a_task_that_ends_with_itself_is_no_new_search() {
    let run = symbolic(
        &text("method Go(Agent A) { { subtasks { 1: Go(A); }; } { subtasks { 1: Never(A); }; } }"),
        "Go(R)",
    );
    assert!(run.is_exhausted());
    assert_eq!(
        run.reasons(),
        [
            "1 x Go(R) comes back to itself in the same state",
            "1 x Never(R): R.count == 99 is false (R.count is NULL)"
        ]
    );
}

/// Roads between three places, and the task to be somewhere, which begins with being next to it.
const ROADS: &str = "
     action Drive(Agent A, Place F, Place T) { preconditions { A.holds == CUP; CUP.at == F; } effects { CUP.at = T; } }
     action Take(Agent A) { effects { A.holds = CUP; } }
     method Be(Agent A, Place T) { goal { CUP.at == T; }
       { subtasks { F = SELECT(Place, {F.near == T;}); 1: Be(A, F); 2: Drive(A, F, T) > 1; }; } }
     method Go(Agent A) { { subtasks { 1: Make(A); 2: Take(A) > 1; 3: Be(A, FLOOR) > 2; }; } }
     action Make(Agent A) { effects { TABLE.near = SHELF; SHELF.near = TABLE; FLOOR.near = SHELF; SHELF.near = ROAD; } }";

/// Left recursion: to be on the shelf one must have been on the table, and the other way round.
#[test]
fn left_recursion_ends() {
    let roads = ROADS
        .replace(
            "SHELF.near = TABLE; FLOOR.near = SHELF; SHELF.near = ROAD;",
            "SHELF.near = TABLE;",
        )
        .replace("Be(A, FLOOR)", "Be(A, SHELF)");
    let run = symbolic(&text(&roads), "Go(R)");
    assert_eq!(run.plan(), "Make(R) Take(R) Drive(R,TABLE,SHELF)");
    // Nothing leads to the floor: a circle is all there is.
    let roads = roads.replace("CUP.at == F; }", "CUP.at == FLOOR; }");
    let run = symbolic(
        &text(&roads.replace("goal { CUP.at == T; }", "goal { CUP.at == FLOOR; }")),
        "Go(R)",
    );
    assert_eq!(
        run.outcome.ending,
        Ending::ExhaustedTruncated(Truncated {
            cycles: 1,
            ..Truncated::default()
        })
    );
    assert_eq!(
        run.reasons(),
        ["1 x Be(R, SHELF) comes back to itself in the same state: Be(R, SHELF) > Be(R, TABLE) > Be(R, SHELF)"]
    );
}

/// `b c` is lost to the cut; the search is made again and finds it. Without cuts the depth limit ends what goes wrong.
#[test]
fn a_plan_lost_to_a_cut_is_found_by_the_fall_back() {
    let tasks = "action Twice(Agent A) { preconditions { A.count == 2; } }
         method Go(Agent A) { { subtasks { 1: Set(A, 0); 2: More(A) > 1; 3: Twice(A) > 2; }; } }
         method More(Agent A) { { subtasks { 1: More(A); 2: Count(A) > 1; }; } { subtasks { 1: Count(A); }; } }";
    let cut = with(tasks, &FIRST);
    assert_eq!(cut.plan(), "Set(R,0) Count(R) Count(R) Twice(R)");
    let Statistics { rounds, returns, .. } = cut.outcome.statistics;
    assert_eq!((rounds, returns), (2, 1));
    let whole = with(
        tasks,
        &Settings {
            cuts: Cuts::Off,
            ..FIRST
        },
    );
    assert_eq!(whole.plan(), "Set(R,0) Count(R) Count(R) Twice(R)");
}

/// A circle with actions in it that come back to the same state: the memory of what is on the way ends it.
#[test]
fn a_circle_of_actions_ends() {
    let tasks = "method Go(Agent A) { { subtasks { 1: Mark(A, CUP); 2: Unmark(A, CUP) > 1; 3: Go(A) > 2; }; } }";
    for cuts in [Cuts::On, Cuts::Always] {
        let budget = Budget {
            expansions: 100_000,
            depth: 20_000,
        };
        let run = with(tasks, &Settings { cuts, budget, ..FIRST });
        assert!(run.is_exhausted(), "{:?}", run.outcome.ending);
        assert!(run.outcome.statistics.expansions < 20_000);
    }
}

/// Tasks in a row, each with a choice among twenty things, and a last one that no look ahead can judge: which of the tasks it
/// depends on decides how much is tried.
#[test]
fn choices_without_a_part_in_a_failure_are_dropped() {
    let tried = |test: &str, cuts| {
        let things: String = (0..20).map(|i| format!("C{i} = new Object; ")).collect();
        let text = format!(
            "factdatabase {{ define entityType Object;
               define entityAttributes Agent {{ dynamic atom Object a; dynamic atom Object b; dynamic atom Object c; }}
               R = new Agent; {things} }}
             HTN {{
               action First(Agent A, Object O) {{ effects {{ A.a = O; }} }}
               action Second(Agent A, Object O) {{ effects {{ A.b = O; }} }}
               action Third(Agent A, Object O) {{ effects {{ A.c = O; }} }}
               method DoFirst(Agent A) {{ {{ subtasks {{ O = SELECT(Object, {{}}); 1: First(A, O); }}; }} }}
               method DoSecond(Agent A) {{ {{ subtasks {{ O = SELECT(Object, {{O != C0;}}); 1: Second(A, O); }}; }} }}
               method DoThird(Agent A) {{ {{ subtasks {{ O = SELECT(Object, {{{test}}}); 1: Third(A, O); }}; }} }}
               method Go(Agent A) {{ {{ subtasks {{ 1: DoFirst(A); 2: DoSecond(A) > 1; 3: DoThird(A) > 2; }}; }} }}
             }}"
        );
        let run = run(&text, "Go(R)", Scripted::new("", &[]), &Settings { cuts, ..FIRST });
        let Statistics { expansions, jumps, .. } = run.outcome.statistics;
        (run.is_exhausted(), expansions, jumps)
    };
    // Go, DoFirst, 20 times First and DoSecond, and each time 19 times Second and DoThird.
    for test in ["O == A.c;", "O == A.a; A.b == C0;", "A.b == C0;"] {
        assert_eq!(tried(test, Cuts::Off), (true, 802, 0));
    }
    // Nobody has a part in it.
    assert_eq!(tried("O == A.c;", Cuts::Always), (true, 6, 2));
    // The second has, the first has not.
    assert_eq!(tried("A.b == C0;", Cuts::Always), (true, 42, 1));
    // The first has, the second has not.
    assert_eq!(tried("A.a == NULL;", Cuts::Always), (true, 82, 20));
    // Both have: the plan is the last but some.
    let (is_exhausted, ..) = tried("A.a == C19; A.b == C7;", Cuts::Always);
    assert!(!is_exhausted);
}

/// Ten jobs in any order, and then nothing will do: a set of jobs done is searched once, not in each of its orders.
#[test]
fn a_failure_is_not_searched_again() {
    let jobs: String = (1..=10).map(|i| format!("{i}: Count(A); ")).collect();
    let all = (1..=10).map(|i| format!("> {i}")).collect::<Vec<_>>().join(", ");
    let tasks = format!(
        "method Go(Agent A) {{ {{ subtasks {{ 1: Set(A, 0); 2: Jobs(A) > 1; }}; }} }}
         method Jobs(Agent A) {{ {{ subtasks {{ {jobs} 11: Never(A) {all}; }}; }} }}"
    );
    let run = with(
        &tasks,
        &Settings {
            cuts: Cuts::Always,
            ..FIRST
        },
    );
    assert!(run.is_exhausted());
    // 2 to the power of 10 sets, of five more jobs each on average.
    assert!(
        run.outcome.statistics.expansions < 6_000,
        "{:?}",
        run.outcome.statistics
    );
    assert!(run.outcome.statistics.repeated > 1_000);
}

/// Two ways to the same sequence of actions.
#[test]
fn a_plan_is_given_once() {
    let tasks = "method Go(Agent A) { { subtasks { 1: Mark(A, CUP); }; } { subtasks { 1: Inner(A); }; } { subtasks { 1: Mark(A, BOX); }; } }
         method Inner(Agent A) { { subtasks { O = SELECT(Object, {}); 1: Mark(A, CUP); }; } }";
    let costs = |n| {
        let run = with(
            tasks,
            &Settings {
                aim: Aim::All(n),
                ..FIRST
            },
        );
        let plans: Vec<String> = run.announced.iter().map(|(plan, _)| plan.clone()).collect();
        (plans.join(" "), run.outcome.ending, run.outcome.others.len())
    };
    assert_eq!(costs(10), ("Mark(R,CUP) Mark(R,BOX)".into(), Ending::Exhausted, 1));
    assert_eq!(costs(2), ("Mark(R,CUP) Mark(R,BOX)".into(), Ending::FirstPlan, 1));
    assert_eq!(costs(1), ("Mark(R,CUP)".into(), Ending::FirstPlan, 0));
}

const PAY: &str = "action Pay(Agent A, number N) { effects { A.count = N; } cost { N } }
     action Dear(Agent A) { cost { 5 + CUP.weight - CUP.weight } } action Five(Agent A) { cost { 5 } }";

/// What is still to be done costs seven at least: no action of the second way is looked at.
#[test]
fn what_is_to_come_counts() {
    let tasks = format!(
        "{PAY} method Go(Agent A) {{ {{ subtasks {{ 1: Pay(A, 6); }}; }}
           {{ subtasks {{ 1: Pay(A, 2); 2: Five(A) > 1; 3: Pay(A, 0) > 2; }}; }} }}"
    );
    let run = with(&tasks, &BEST);
    assert_eq!(run.plan(), "Pay(R,6)");
    // Go, Pay(6).
    assert_eq!(run.outcome.statistics.expansions, 2);
    assert_eq!(
        run.reasons(),
        ["1 x a cost of 0.0000 and at least 7.0000 to come are not below the best plan's 6.0000"]
    );
}

/// A search that is cut short says what no plan can cost less than.
#[test]
fn the_least_cost_is_given() {
    let tasks = format!(
        "{PAY} method Go(Agent A) {{ {{ subtasks {{ 1: Pay(A, 30); 2: Rest(A) > 1; }}; }} {{ subtasks {{ 1: Pay(A, 1); 2: Rest(A) > 1; }}; }} }}
         method Rest(Agent A) {{ {{ subtasks {{ 1: Five(A); 2: Five(A); }}; }} {{ subtasks {{ 1: Five(A); 2: Five(A); 3: Five(A); }}; }} }}"
    );
    let least = |expansions| {
        let budget = Budget {
            expansions,
            ..FIRST.budget
        };
        let run = with(&tasks, &Settings { budget, ..BEST });
        (run.outcome.found.map(|f| f.cost), run.outcome.least_cost)
    };
    // Go, Pay, Rest, Five, Five; then the second way, which costs one, and five twice at least.
    assert_eq!(least(5), (Some(40.0), 11.0));
    assert_eq!(least(1000), (Some(11.0), 11.0));
}
