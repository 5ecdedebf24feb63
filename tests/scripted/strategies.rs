//! Searches that begin again: the fall-back after unsafe cuts, limited discrepancy, restarts.

use sgap::engine::{Aim, Budget, Cuts, Ending, FallBackEnd, Settings, Statistics, Strategy};

use crate::domain::{every_object, text};
use crate::reasoner::Scripted;
use crate::run::{BEST, FIRST, Run, run, second_opinion};

const STRATEGIES: [Strategy; 3] = [
    Strategy::DepthFirst,
    Strategy::LimitedDiscrepancy,
    Strategy::Restarts { seed: 3 },
];

/// Plans `Go(R)` in every order of branches; each plan must be accepted by the validator.
fn in_every_order(tasks: &str, settings: &Settings) -> [Run; 3] {
    STRATEGIES.map(|strategy| {
        let run = run(
            &text(tasks),
            "Go(R)",
            Scripted::new("", &[]),
            &Settings { strategy, ..*settings },
        );
        if run.outcome.found.is_some() {
            second_opinion(&run, &run.document()).unwrap();
        }
        run
    })
}

/// Counts up by a left recursion, and wants a number of rounds that only the recursion gives.
fn counted(wanted: u32, more: &str) -> String {
    format!(
        "action Is(Agent A) {{ preconditions {{ A.count == {wanted}; }} }}
         method Go(Agent A) {{ {{ subtasks {{ 1: Set(A, 0); 2: More(A) > 1; 3: Is(A) > 2; }}; }} }}
         {more}"
    )
}

const DIRECT: &str =
    "method More(Agent A) { { subtasks { 1: More(A); 2: Count(A) > 1; }; } { subtasks { 1: Count(A); }; } }";
const MUTUAL: &str =
    "method More(Agent A) { { subtasks { 1: Even(A); 2: Count(A) > 1; }; } { subtasks { 1: Count(A); }; } }
     method Even(Agent A) { { subtasks { 1: More(A); 2: Count(A) > 1; }; } { subtasks { 1: More(A); }; } }";
const SELECTED: &str = "method More(Agent A) { { subtasks { O = SELECT(Object, {}); 1: One(A, O); 2: Count(A) > 1; }; } { subtasks { }; } }
     method One(Agent A, Object O) { { subtasks { 1: More(A); }; } }";

/// However often the recursion is needed: once, twice, or five times.
#[test]
fn a_left_recursion_is_followed_as_often_as_it_is_needed() {
    for more in [DIRECT, MUTUAL, SELECTED] {
        for wanted in [1, 2, 3, 5] {
            for run in in_every_order(&counted(wanted, more), &FIRST) {
                assert!(run.outcome.found.is_some(), "{wanted}: {:?} {more}", run.outcome.ending);
                assert_eq!(run.plan().matches("Count").count(), wanted as usize);
            }
        }
    }
}

/// Where no number of rounds will do, the budget ends it, and what was cut is said as before.
#[test]
fn a_left_recursion_without_a_plan_ends() {
    let budget = Budget {
        expansions: 5_000,
        depth: 200,
    };
    for more in [DIRECT, MUTUAL, SELECTED] {
        let tasks = counted(4, more).replace("A.count == 4", "A.count == -1");
        for run in in_every_order(&tasks, &Settings { budget, ..FIRST }) {
            let Ending::ExhaustedTruncated(cut) = run.outcome.ending else {
                panic!("{:?}", run.outcome.ending)
            };
            assert!(cut.cycles > 0 && cut.depth == 0, "{cut:?}");
            assert!(run.outcome.statistics.returns > 1);
            assert!(run.outcome.statistics.expansions <= budget.expansions);
        }
    }
}

/// The fall-back has a share of its own, said by the first search or by the user, inside the whole budget.
#[test]
fn the_fall_back_ends_long_before_the_budget() {
    let budget = Budget {
        expansions: 1_000_000,
        depth: 200,
    };
    let settings = Settings { budget, ..FIRST };
    let none = counted(4, DIRECT).replace("A.count == 4", "A.count == -1");
    let ended = |fall_back: Option<u64>, expansions: u64| {
        let budget = Budget { expansions, ..budget };
        let settings = Settings {
            budget,
            fall_back,
            ..FIRST
        };
        let run = run(&text(&none), "Go(R)", Scripted::new("", &[]), &settings);
        assert!(matches!(run.outcome.ending, Ending::ExhaustedTruncated(_)));
        let Statistics {
            expansions, returns, ..
        } = run.outcome.statistics;
        (run.outcome.statistics.fall_back, expansions, returns)
    };
    let (end, first, returns) = ended(Some(0), 1_000_000);
    assert_eq!((end, returns), (FallBackEnd::None, 0));
    for (said, wanted) in [(None, 10_000), (Some(50), 50)] {
        let (end, expansions, returns) = ended(said, 1_000_000);
        assert_eq!(end, FallBackEnd::Expansions(wanted));
        assert!(returns > 1 && expansions > first && expansions <= first + wanted);
    }
    assert_eq!(ended(None, 5_000).0, FallBackEnd::Budget);
    // With more, a plan is found that is not there with less; and then the share is no limit any more.
    let far = |fall_back, aim| {
        let settings = Settings {
            fall_back,
            aim,
            ..settings
        };
        run(&text(&counted(9, DIRECT)), "Go(R)", Scripted::new("", &[]), &settings).outcome
    };
    assert!(far(Some(20), Aim::First).found.is_none());
    assert!(far(Some(2_000), Aim::First).found.is_some());
    let needed = far(None, Aim::First).statistics.expansions - first;
    let best = far(Some(needed), Aim::Best);
    assert!(
        best.found.is_some() && best.ending != Ending::BudgetSpent,
        "{:?}",
        best.ending
    );
}

/// Geometric actions have a share of their own, since each takes its time.
#[test]
fn the_fall_back_computes_few_geometric_actions() {
    let more = DIRECT.replace("Count(A) > 1; }; } {", "Look(A, CUP) > 1; 3: Count(A) > 2; }; } {");
    let tasks = counted(4, &more).replace("A.count == 4", "A.count == -1");
    let budget = Budget {
        expansions: 1_000_000,
        depth: 200,
    };
    let settings = Settings { budget, ..FIRST };
    let looked = |fall_back| {
        let settings = Settings { fall_back, ..settings };
        run(&text(&tasks), "Go(R)", every_object(), &settings)
            .outcome
            .statistics
    };
    let few = looked(None);
    assert_eq!(few.fall_back, FallBackEnd::Projections(100));
    assert!(few.projections >= 100 && few.projections <= 100 + looked(Some(0)).projections);
    assert_eq!(looked(Some(5_000)).fall_back, FallBackEnd::Expansions(5_000));
}

/// A goal ends the recursion from above: with it nothing is done where something is done without.
#[test]
fn a_goal_inside_a_left_recursion() {
    let more = DIRECT.replacen("{ {", "{ goal { A.count >= 3; } {", 1);
    for run in in_every_order(&counted(3, &more), &FIRST) {
        assert_eq!(run.plan(), "Set(R,0) Count(R) Count(R) Count(R) Is(R)");
    }
}

/// With a plan, or without cuts, nothing is searched again.
#[test]
fn the_fall_back_is_for_searches_without_a_plan() {
    let rounds = |settings: &Settings| {
        let run = run(&text(&counted(1, DIRECT)), "Go(R)", Scripted::new("", &[]), settings);
        let Statistics { rounds, returns, .. } = run.outcome.statistics;
        (run.outcome.found.is_some(), rounds, returns)
    };
    assert_eq!(rounds(&FIRST), (true, 1, 0));
    assert_eq!(rounds(&BEST), (true, 1, 0));
    let off = Settings {
        cuts: Cuts::Off,
        ..FIRST
    };
    assert_eq!(rounds(&off), (true, 1, 0));
}

/// Ten objects to choose from in each of twenty steps; only the last choice of the first step leads on.
const EARLY: &str = "action Is(Agent A, Object O) { preconditions { A.holds == O; } effects { A.count = 1; } }
     action Hold(Agent A, Object O) { effects { A.holds = O; } }
     method Go(Agent A) { { subtasks { O = SELECT(Object, {}); 1: Hold(A, O); 2: Play(A, 8) > 1; 3: Is(A, BOX) > 2; }; } }
     method Play(Agent A, number N) { goal { N == 0; }
       { subtasks { O = SELECT(Object, {}); 1: Mark(A, O); 2: Unmark(A, O) > 1; 3: Play(A, N - 1) > 2; }; } }";

/// A mistake at the top is undone at once where depth first has to try all that is below it.
#[test]
fn a_mistake_at_the_top_is_found_with_few_discrepancies() {
    let off = Settings {
        cuts: Cuts::Off,
        ..FIRST
    };
    let [depth, limited, restarts] = in_every_order(EARLY, &off);
    assert!(limited.outcome.found.is_some() && restarts.outcome.found.is_some());
    assert!(limited.outcome.statistics.rounds > 1 && restarts.outcome.statistics.rounds > 1);
    let expansions = |run: &Run| run.outcome.statistics.expansions;
    assert!(
        expansions(&limited) * 4 < expansions(&depth),
        "{}",
        expansions(&limited)
    );
    assert!(
        expansions(&restarts) * 4 < expansions(&depth),
        "{}",
        expansions(&restarts)
    );
}

/// The same seed draws the same orders; another one may give another plan, and every plan is one of all plans.
#[test]
fn orders_belong_to_the_seed() {
    // Something has to fail for an order to be drawn at all.
    let tasks = EARLY.replace("Is(A, BOX)", "Never(A)");
    let of = |seed| {
        let settings = Settings {
            cuts: Cuts::Off,
            strategy: Strategy::Restarts { seed },
            ..FIRST
        };
        let run = run(&text(EARLY), "Go(R)", Scripted::new("", &[]), &settings);
        run.plan()
    };
    assert_eq!(of(1), of(1));
    assert!((2..12).any(|seed| of(seed) != of(1)));
    let settings = Settings {
        cuts: Cuts::Always,
        ..FIRST
    };
    for run in in_every_order(&tasks, &settings) {
        assert!(run.is_exhausted(), "{:?}", run.outcome.ending);
    }
}

/// All plans, none twice, and the best one, whatever the order.
#[test]
fn every_order_finds_all_plans() {
    let tasks = "action Pay(Agent A, number N) { effects { A.count = N; } cost { N } }
         method Go(Agent A) { { subtasks { 1: Pay(A, 3); 2: Pay(A, 2); 3: One(A); }; } { subtasks { 1: One(A); 2: One(A); 3: One(A); }; } }
         method One(Agent A) { { subtasks { 1: Pay(A, 5); }; } { subtasks { O = SELECT(Object, {}); 1: Mark(A, O); 2: Pay(A, 1) > 1; }; } }";
    let all = in_every_order(
        tasks,
        &Settings {
            aim: Aim::All(100_000),
            ..FIRST
        },
    );
    let plans = all.map(|run| {
        assert!(run.is_exhausted());
        let mut plans: Vec<String> = run.announced.into_iter().map(|(plan, _)| plan).collect();
        plans.sort();
        plans
    });
    assert!(plans[0].len() > 10);
    assert_eq!(plans[0], plans[1]);
    assert_eq!(plans[0], plans[2]);
    for run in in_every_order(tasks, &BEST) {
        assert!(run.is_exhausted());
        assert_eq!(run.outcome.found.map(|f| f.cost), Some(6.0));
    }
}
