//! Branches left because a task to come can't be done, and alternatives that are asked for where they pay.

use sgap::engine::{Aim, Branching, Cuts, Ending, Settings};

use crate::domain::text;
use crate::reasoner::{Scripted, solution};
use crate::run::{FIRST, Run, run};

fn with(tasks: &str, cuts: Cuts, interleave: bool) -> Run {
    let settings = Settings {
        cuts,
        interleave,
        ..FIRST
    };
    run(&text(tasks), "Go(R)", Scripted::new("", &[]), &settings)
}

/// What is taken in hand first is needed at the end, and nothing between changes it.
const HOLD_AND_PLAY: &str = "action Is(Agent A, Object O) { preconditions { A.holds == O; } }
     action Hold(Agent A, Object O) { effects { A.holds = O; } }
     method Go(Agent A) { { subtasks { O = SELECT(Object, {}); 1: Hold(A, O); 2: Play(A, 4) > 1; 3: End(A) > 2; }; } }
     method End(Agent A) { { subtasks { 1: Is(A, CAN); }; } { preconditions { A.count == 7; }; subtasks { 1: Is(A, PEN); }; } }
     method Play(Agent A, number N) { goal { N == 0; }
       { subtasks { O = SELECT(Object, {}); 1: Mark(A, O); 2: Unmark(A, O) > 1; 3: Play(A, N - 1) > 2; }; } }";

#[test]
fn a_task_that_can_no_longer_be_done_ends_the_branch_at_once() {
    let (off, ahead) = (
        with(HOLD_AND_PLAY, Cuts::Off, false),
        with(HOLD_AND_PLAY, Cuts::Always, false),
    );
    assert_eq!(off.plan(), ahead.plan());
    assert!(ahead.plan().starts_with("Hold(R,CAN)"));
    let expansions = |run: &Run| run.outcome.statistics.expansions;
    assert!(
        expansions(&off) > 2_000 && expansions(&ahead) < 40,
        "{} {}",
        expansions(&off),
        expansions(&ahead)
    );
    assert_eq!(ahead.outcome.statistics.dead_ends, 3);
    assert_eq!(
        ahead.reasons()[0],
        "3 x End(R) can't be done any more: R.count == 7 is false (R.count is NULL)"
    );
}

/// A task between that may change what is needed keeps the branch; so does any unordered one, and any other when steps mix.
#[test]
fn what_may_still_change_is_waited_for() {
    let helped = HOLD_AND_PLAY.replace("1: Mark(A, O);", "1: Hold(A, O);");
    let off = with(&helped, Cuts::Off, false);
    assert_eq!(with(&helped, Cuts::Always, false).plan(), off.plan());
    let any_order = "action Is(Agent A) { preconditions { A.count == 1; } }
         method Go(Agent A) { { subtasks { 1: Is(A); 2: Two(A); }; } }
         method Two(Agent A) { { subtasks { 1: Set(A, 1); 2: Set(A, 2) > 1; }; } }";
    assert!(with(any_order, Cuts::Always, false).is_exhausted());
    assert_eq!(with(any_order, Cuts::Always, true).plan(), "Set(R,1) Is(R) Set(R,2)");
}

/// A goal makes a task possible, whatever its decompositions need; so does a goal that may come true before.
#[test]
fn a_goal_counts() {
    let tasks = |first: &str| {
        format!(
            "method Go(Agent A) {{ {{ subtasks {{ 1: {first}; 2: Get(A, CUP) > 1; }}; }} }}
             method Get(Agent A, Object O) {{ goal {{ O.done == true; }} {{ subtasks {{ 1: Never(A); }}; }} }}"
        )
    };
    assert_eq!(with(&tasks("Mark(A, CUP)"), Cuts::Always, false).plan(), "Mark(R,CUP)");
    assert!(with(&tasks("Mark(A, BOX)"), Cuts::Always, false).is_exhausted());
}

/// A `let` through NULL is NULL, where the path has no value at all: a need may not mix them up.
#[test]
fn a_path_through_null_is_no_need() {
    let tasks = "method Go(Agent A) { { subtasks { 1: Count(A); 2: Far(A, CAN) > 1; }; } }
         method Far(Agent A, Object O) { { subtasks { let P = O.at.near; 1: If(A, O) ; }; } }
         action If(Agent A, Object O) { preconditions { O.at.near != TABLE; } }";
    let run = with(tasks, Cuts::Always, false);
    assert_eq!(run.plan(), "Count(R) If(R,CAN)");
}

/// A cup with six places; the first `n` are reachable by nobody, the next by R, and those after by both.
fn places(n: usize) -> Scripted {
    let users = |i: usize| match i {
        i if i < n => "CUP.users =",
        i if i == n => "CUP.users = R",
        _ => "CUP.users = R H",
    };
    let solutions = (0..6).map(|i| solution(0.0, 0.0, users(i))).collect();
    Scripted::new("", &["isReachable"]).with("place(R, CUP, TABLE)", solutions)
}

fn adaptive(n: usize, aim: Aim) -> Run {
    let tasks = "action Put(Agent A, Object O, Place P) { projects { place(A, O, P) }; }
         action Use(Agent A, Object O) { preconditions { A >> O.users; } }
         method Go(Agent A) { { subtasks { 1: Put(A, CUP, TABLE); 2: Use(R, CUP) > 1; 3: Use(H, CUP) > 2; }; } }";
    let text = text(tasks).replace(
        "dynamic set Agent users;",
        "dynamic set Agent users = fact isReachable;",
    );
    let text = text.replace("BOX.users <<= H;", "");
    let settings = Settings {
        branching: Branching::Adaptive,
        aim,
        ..FIRST
    };
    run(&text, "Go(R)", places(n), &settings)
}

/// The second place leads further than the first: so a third one is tried, with which all is well.
#[test]
fn alternatives_that_pay_are_followed_by_more() {
    let run = adaptive(1, Aim::First);
    assert_eq!(run.plan(), "Put(R,CUP,TABLE) Use(R,CUP) Use(H,CUP)");
    assert_eq!(run.outcome.statistics.projections, 3);
    // The plan that the third place led to is further still; a fourth gets no further, and is the last.
    let all = adaptive(1, Aim::All(100));
    assert_eq!(all.outcome.statistics.projections, 4);
}

/// One alternative that leads nowhere further is all that is tried, and the search says so.
#[test]
fn alternatives_that_do_not_pay_are_not_followed() {
    let run = adaptive(2, Aim::First);
    assert_eq!(run.outcome.statistics.projections, 2);
    let Ending::ExhaustedTruncated(cut) = run.outcome.ending else {
        panic!("{:?}", run.outcome.ending)
    };
    assert_eq!(cut.alternatives, 1);
}
