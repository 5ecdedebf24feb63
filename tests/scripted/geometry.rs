//! Projections, alternatives and shared attributes.

use sgap::engine::{Branching, Ending, Settings, Truncated};

use crate::reasoner::{Scripted, solution};
use crate::run::{BEST, FIRST, Run, run};

/// A domain with attributes read from geometry, and actions that are projected.
fn shared(tasks: &str) -> String {
    format!(
        "factdatabase {{
           define entityType Object;
           define entityType Place;
           define entityAttributes Agent {{ dynamic atom Object holds = fact hasInHand; dynamic atom number count; }}
           define entityAttributes Object {{
             dynamic atom Place at = fact isOn;
             dynamic set Agent users = fact isReachable;
             dynamic set Agent seen;
             dynamic atom bool done;
           }}
           R = new Agent; H = new Agent; CUP = new Object; BOX = new Object; TABLE = new Place; SHELF = new Place;
         }}
         HTN {{
           action Take(Agent A, Object O) {{ projects {{ pick(A, O) }}; effects {{ A.holds = O; O.at = NULL; }} }}
           action Put(Agent A, Object O, Place P) {{ projects {{ place(A, O, P) }}; effects {{ A.holds = NULL; O.at = P; }} }}
           action Never(Agent A) {{ preconditions {{ A.count == 99; }} }}
           {tasks}
         }}"
    )
}

const FACTS: [&str; 3] = ["hasInHand", "isOn", "isReachable"];

fn plan(tasks: &str, reasoner: Scripted, settings: &Settings) -> Run {
    run(&shared(tasks), "Go(R)", reasoner, settings)
}

/// A cup with five places on the shelf.
fn five_places() -> Scripted {
    let solutions = (0..5).map(|i| solution(f64::from(i), 1.0, "CUP.at = SHELF")).collect();
    Scripted::new("CUP.at = TABLE", &FACTS).with("place(R, CUP, SHELF)", solutions)
}

const PUT_AND_FAIL: &str = "method Go(Agent A) { { subtasks { 1: Put(A, CUP, SHELF); 2: Never(A) > 1; }; } }";

/// The first solution counts: a branching factor of three asks for two more.
#[test]
fn as_many_solutions_are_asked_for_as_the_branching_factor_says() {
    for branching in 1..=4 {
        let run = plan(
            PUT_AND_FAIL,
            five_places(),
            &Settings {
                branching: Branching::Fixed(branching),
                ..FIRST
            },
        );
        let mut expected = vec!["project place(R, CUP, SHELF)".to_owned()];
        expected.extend((1..branching).map(|i| format!("alternative {i} place(R, CUP, SHELF)")));
        assert_eq!(run.reasoner.asked, expected);
        let cut = Truncated {
            alternatives: 1,
            ..Truncated::default()
        };
        assert_eq!(run.outcome.ending, Ending::ExhaustedTruncated(cut));
        let statistics = run.outcome.statistics;
        assert_eq!(
            (statistics.projections, statistics.alternatives),
            (u64::from(branching), u64::from(branching - 1))
        );
    }
}

/// When geometry says that there are no more, nothing was cut short.
#[test]
fn a_search_that_has_seen_all_alternatives_is_exhausted() {
    let run = plan(
        PUT_AND_FAIL,
        five_places(),
        &Settings {
            branching: Branching::Fixed(9),
            ..FIRST
        },
    );
    assert_eq!(run.reasoner.asked.len(), 6);
    assert!(run.is_exhausted());
    assert_eq!(
        run.reasons(),
        [
            "5 x Never(R): R.count == 99 is false (R.count is NULL)",
            "1 x place(R, CUP, SHELF): no further solution"
        ]
    );
}

#[test]
fn geometry_that_gives_up_cuts_the_search_short() {
    let mut reasoner = five_places();
    reasoner.gives_up = vec!["place(R, CUP, SHELF)".into()];
    let run = plan(
        PUT_AND_FAIL,
        reasoner,
        &Settings {
            branching: Branching::Fixed(9),
            ..FIRST
        },
    );
    let cut = Truncated {
        geometry: 1,
        ..Truncated::default()
    };
    assert_eq!(run.outcome.ending, Ending::ExhaustedTruncated(cut));
}

#[test]
fn an_action_may_set_its_own_number_of_alternatives() {
    let tasks = "action Place(Agent A) { projects { place(A, CUP, SHELF) }; alternatives { 2 }; }
         method Go(Agent A) { { subtasks { 1: Place(A); 2: Never(A) > 1; }; } }";
    for branching in [1, 4] {
        let run = plan(
            tasks,
            five_places(),
            &Settings {
                branching: Branching::Fixed(branching),
                ..FIRST
            },
        );
        assert_eq!(
            run.reasoner.asked,
            ["project place(R, CUP, SHELF)", "alternative 1 place(R, CUP, SHELF)"]
        );
    }
}

/// The world is taken back before an alternative is asked for (the reasoner insists), and the next action starts from it.
#[test]
fn alternatives_of_two_actions_are_tried_like_an_odometer() {
    let reasoner = Scripted::new("", &FACTS)
        .with(
            "pick(R, CUP)",
            vec![solution(0.0, 0.0, "R.holds = CUP"), solution(0.0, 0.0, "R.holds = CUP")],
        )
        .with(
            "place(R, CUP, SHELF)",
            vec![solution(0.0, 0.0, "R.holds ="), solution(0.0, 0.0, "R.holds =")],
        );
    let tasks = "method Go(Agent A) { { subtasks { 1: Take(A, CUP); 2: Put(A, CUP, SHELF) > 1; 3: Never(A) > 2; }; } }";
    let run = plan(
        tasks,
        reasoner,
        &Settings {
            branching: Branching::Fixed(2),
            ..FIRST
        },
    );
    assert_eq!(
        run.reasoner.asked,
        [
            "project pick(R, CUP)",
            "project place(R, CUP, SHELF)",
            "alternative 1 place(R, CUP, SHELF)",
            "alternative 1 pick(R, CUP)",
            "project place(R, CUP, SHELF)",
            "alternative 1 place(R, CUP, SHELF)",
        ]
    );
}

#[test]
fn an_infeasible_action_ends_its_branch() {
    let tasks = "method Go(Agent A) { { subtasks { 1: Take(A, CUP); }; } { subtasks { 1: Take(A, BOX); }; } }";
    let reasoner = Scripted::new("", &FACTS).with("pick(R, BOX)", vec![solution(0.0, 0.0, "R.holds = BOX")]);
    let run = plan(tasks, reasoner, &FIRST);
    assert_eq!(run.plan(), "Take(R,BOX)");
    assert_eq!(run.reasons(), ["1 x pick(R, CUP): no solution"]);
}

#[test]
fn a_projection_with_an_argument_without_a_value_fails() {
    let tasks =
        "action Pass(Agent A) { projects { pick(A, A.holds) }; } method Go(Agent A) { { subtasks { 1: Pass(A); }; } }";
    let run = plan(tasks, Scripted::new("", &FACTS), &FIRST);
    assert_eq!(run.reasons(), ["1 x Pass(R): its argument 2, R.holds, is NULL"]);
    assert!(run.reasoner.asked.is_empty());
}

/// Effects say SHELF and R; geometry says TABLE and H.
#[test]
fn geometry_wins_over_effects() {
    let reasoner = Scripted::new("", &FACTS).with(
        "place(R, CUP, SHELF)",
        vec![solution(0.0, 0.0, "CUP.at = TABLE, CUP.users = H")],
    );
    let tasks = "action Try(Agent A) { projects { place(A, CUP, SHELF) }; effects { CUP.at = SHELF; CUP.users <<= A; CUP.done = true; } }
         action Test(Agent A) { preconditions { CUP.at == TABLE; CUP.users == [H]; CUP.done == true; } }
         method Go(Agent A) { { subtasks { 1: Try(A); 2: Test(A) > 1; }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    assert_eq!(run.plan(), "Try(R) Test(R)");
    let changes = &run.document().actions[0].changes;
    let changes: Vec<(&str, &str)> = changes.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
    assert_eq!(
        changes,
        [("CUP.at", "TABLE"), ("CUP.users", "[H]"), ("CUP.done", "true")]
    );
}

/// An action without a projection moves nothing: what its effects say of a shared attribute stands until the next one.
#[test]
fn effects_of_symbolic_actions_stand_until_the_next_projection() {
    let reasoner = Scripted::new("CUP.at = TABLE", &FACTS).with("pick(R, BOX)", vec![solution(0.0, 0.0, "")]);
    let tasks = "action Say(Agent A) { effects { CUP.at = SHELF; CUP.users <<= H; } }
         action Said(Agent A) { preconditions { CUP.at == SHELF; H >> CUP.users; } }
         action Unsaid(Agent A) { preconditions { CUP.at == TABLE; H !>> CUP.users; } }
         method Go(Agent A) { { subtasks { 1: Say(A); 2: Said(A) > 1; 3: Take(A, BOX) > 2; 4: Unsaid(A) > 3; }; } }";
    assert_eq!(
        plan(tasks, reasoner, &FIRST).plan(),
        "Say(R) Said(R) Take(R,BOX) Unsaid(R)"
    );
}

/// An attribute whose fact nobody answers is a plain one.
#[test]
fn an_unknown_fact_leaves_a_plain_attribute() {
    let reasoner =
        Scripted::new("", &["isReachable"]).with("place(R, CUP, SHELF)", vec![solution(0.0, 0.0, "CUP.at = TABLE")]);
    let tasks = "action Test(Agent A) { preconditions { CUP.at == SHELF; } }
         method Go(Agent A) { { subtasks { 1: Put(A, CUP, SHELF); 2: Test(A) > 1; }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    assert_eq!(run.plan(), "Put(R,CUP,SHELF) Test(R)");
}

/// Whatever was read in a branch, and when, the world state that it is read in is the one that counts.
#[test]
fn a_shared_attribute_is_the_one_of_the_current_world_state_also_after_backtracking() {
    let reasoner = Scripted::new("CUP.at = TABLE", &FACTS)
        .with(
            "pick(R, CUP)",
            vec![solution(0.0, 0.0, "CUP.at ="), solution(0.0, 0.0, "CUP.at = SHELF")],
        )
        .with("pick(R, BOX)", vec![solution(0.0, 0.0, "")]);
    let tasks = "action On(Agent A, Place P) { preconditions { CUP.at == P; } }
         action Nowhere(Agent A) { preconditions { CUP.at == NULL; } }
         method Go(Agent A) {
           { subtasks { 1: Take(A, CUP); 2: Nowhere(A) > 1; 3: On(A, SHELF) > 2; }; }
           { subtasks { 1: On(A, TABLE); 2: Take(A, CUP) > 1; 3: On(A, SHELF) > 2; 4: Take(A, BOX) > 3; 5: On(A, SHELF) > 4; 6: Never(A) > 5; }; }
           { subtasks { 1: On(A, TABLE); }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    assert_eq!(run.plan(), "On(R,TABLE)");
    assert_eq!(
        run.reasons(),
        [
            "2 x On(R, SHELF): CUP.at == SHELF is false (CUP.at is NULL)",
            "2 x pick(R, CUP): no further solution",
            "1 x Nowhere(R): CUP.at == NULL is false (CUP.at is SHELF)",
            "1 x Never(R): R.count == 99 is false (R.count is NULL)",
            "1 x pick(R, BOX): no further solution",
        ]
    );
}

/// Effects, cost and duration look at the state before the action; the geometric cost is there already.
#[test]
fn effects_and_cost_read_the_state_before_the_action() {
    let reasoner = Scripted::new("CUP.at = TABLE, CUP.users = R H", &FACTS).with(
        "pick(R, CUP)",
        vec![solution(2.5, 4.0, "CUP.at =, CUP.users =, R.holds = CUP")],
    );
    let tasks = "action Grab(Agent A) { projects { pick(A, CUP) };
           effects { IF{ CUP.at == TABLE; }{ A.count = size(CUP.users) + 10 * GetGRPCost(); }; CUP.done = true; }
           cost { GetGRPCost() + size(CUP.users) }; duration { (size(CUP.users), 1 + GetGRPCost()) }; }
         method Go(Agent A) { { subtasks { 1: Grab(A); }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    let found = run.outcome.found.as_ref().unwrap();
    let charge = found.charge(&found.steps[0]);
    assert_eq!(charge.cost, 4.5);
    // It lasts at least as long as its motions.
    assert_eq!(charge.duration, (4.0, 4.0));
    let changes = &run.document().actions[0].changes;
    assert_eq!(changes.get("R.count").map(|v| v.as_str()), Some("27"));
}

/// Which shared attributes are looked at may depend on what the projection gave: they are read in the world before it all
/// the same, and going back finds them as they were.
#[test]
fn what_depends_on_the_projection_reads_the_state_before_it_too() {
    let reasoner = Scripted::new("CUP.at = TABLE", &FACTS).with(
        "pick(R, CUP)",
        vec![
            solution(1.0, 0.0, "CUP.at =, BOX.at = TABLE"),
            solution(9.0, 0.0, "CUP.at =, BOX.at = TABLE"),
        ],
    );
    let tasks = "action Grab(Agent A) { projects { pick(A, CUP) };
           effects { IF{ GetGRPCost() > 5; }{ IF{ CUP.at == TABLE; BOX.at == NULL; }{ A.count = 7; }; }; } }
         action Test(Agent A) { preconditions { A.count == 7; CUP.at == NULL; BOX.at == TABLE; } }
         action Before(Agent A) { preconditions { CUP.at == TABLE; BOX.at == NULL; A.count == NULL; } }
         method Go(Agent A) {
           { subtasks { 1: Grab(A); 2: Test(A) > 1; 3: Never(A) > 2; }; }
           { subtasks { 1: Before(A); 2: Grab(A) > 1; 3: Test(A) > 2; }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    assert_eq!(run.plan(), "Before(R) Grab(R) Test(R)");
    assert_eq!(
        run.document().actions[1].changes.get("R.count").map(|v| &**v),
        Some("7")
    );
}

/// Geometric cost is that of the action at hand, and of no other: a precondition sees none.
#[test]
fn the_geometric_cost_of_one_action_is_not_seen_by_the_next() {
    let reasoner = Scripted::new("", &FACTS).with("pick(R, CUP)", vec![solution(3.0, 2.0, "")]);
    let tasks = "action Free(Agent A) { preconditions { GetGRPCost() == 0; } cost { 1 + GetGRPCost() }; }
         method Go(Agent A) { { subtasks { 1: Take(A, CUP); 2: Free(A) > 1; 3: Wrap(A) > 2; }; } }
         method Wrap(Agent A) { { preconditions { GetGRPCost() == 0; } subtasks { 1: Free(A); }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    assert_eq!(run.plan(), "Take(R,CUP) Free(R) Free(R)");
    assert_eq!(run.outcome.found.as_ref().unwrap().cost, 5.0);
}

/// The ramification problem (thesis 4.3.5): the second place blocks the first object; only a test at the end tells. The
/// search comes back into the alternatives, of the last action first.
#[test]
fn a_ramification_brings_the_search_back_into_earlier_alternatives() {
    let both =
        "method Go(Agent A) { { subtasks { 1: Put(A, CUP, SHELF); 2: Put(A, BOX, SHELF) > 1; 3: Test(A) > 2; }; } }
         action Test(Agent A) { preconditions { FORALL(Object O, {}, {H >> O.users;}); } }";
    let reasoner = Scripted::new("", &FACTS)
        .with(
            "place(R, CUP, SHELF)",
            vec![
                solution(0.0, 0.0, "CUP.users = H"),
                solution(0.0, 0.0, "CUP.users = H R"),
            ],
        )
        .with(
            "place(R, BOX, SHELF)",
            vec![
                solution(0.0, 0.0, "CUP.users =, BOX.users = H"),
                solution(0.0, 0.0, "BOX.users = H"),
            ],
        );
    let run = plan(
        both,
        reasoner,
        &Settings {
            branching: Branching::Fixed(2),
            ..FIRST
        },
    );
    let found = run.outcome.found.as_ref().unwrap();
    let alternatives: Vec<u32> = found
        .steps
        .iter()
        .filter_map(|s| found.charge(s).gas.map(|g| g.alternative))
        .collect();
    assert_eq!(alternatives, [0, 1]);
    assert_eq!(
        run.reasons(),
        ["1 x Test(R): H >> CUP.users is false (CUP.users is [])"]
    );
    // Nothing that the effects say, but what became of things: the shelf's second place leaves the cup in reach.
    assert_eq!(run.document().actions[1].changes.get("CUP.users"), None);
}

/// A fact is computed when somebody asks for it, once per world state, and not before.
#[test]
fn facts_are_read_on_demand() {
    let reasoner = Scripted::new("", &FACTS).with("pick(R, CUP)", vec![solution(0.0, 0.0, "R.holds = CUP")]);
    let tasks = "action Test(Agent A, Object O) { preconditions { A.holds == O; A.holds != NULL; } }
         method Go(Agent A) { { preconditions { A.holds == NULL; } subtasks { 1: Take(A, CUP); 2: Test(A, CUP) > 1; 3: Test(A, CUP) > 2; 4: Never(A) > 3; }; } }";
    let run = plan(tasks, reasoner, &FIRST);
    assert!(run.is_exhausted());
    assert_eq!(run.reasoner.facts, ["0 R.holds", "1 R.holds"]);
}

/// Alternatives of an action that is dear at first may be cheap.
#[test]
fn the_best_plan_pays_what_geometry_says() {
    let run = plan(
        "method Go(Agent A) { { subtasks { 1: Put(A, CUP, SHELF); }; } }",
        Scripted::new("", &FACTS).with(
            "place(R, CUP, SHELF)",
            vec![
                solution(5.0, 1.0, ""),
                solution(3.0, 2.0, ""),
                solution(4.0, 1.0, ""),
                solution(1.0, 1.0, ""),
            ],
        ),
        &BEST,
    );
    assert_eq!(
        run.announced,
        [("Put(R,CUP,SHELF)".into(), 5.0), ("Put(R,CUP,SHELF)".into(), 3.0)]
    );
    let found = run.outcome.found.as_ref().unwrap();
    let charge = found.charge(&found.steps[0]);
    assert_eq!(
        (charge.gas.map(|g| g.alternative), charge.duration),
        (Some(1), (2.0, 2.0))
    );
    let cut = Truncated {
        alternatives: 1,
        ..Truncated::default()
    };
    assert_eq!(run.outcome.ending, Ending::ExhaustedTruncated(cut));
}
