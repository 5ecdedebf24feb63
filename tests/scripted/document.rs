//! The plan document: links with their reasons, streams, times and the tree, against numbers worked out by hand.

use sgap::plan::{LinkReason, Node, Plan};

use crate::domain::text;
use crate::reasoner::{Scripted, solution};
use crate::run::{FIRST, run, symbolic};

fn document(tasks: &str) -> Plan {
    symbolic(&text(tasks), "Go(R)").document()
}

/// Returns `0 -> 1 CUP.done` for each link; `!` marks a threat.
fn links(plan: &Plan) -> Vec<String> {
    let reason = |reason: &LinkReason| match reason {
        LinkReason::Attribute(name) => name.to_string(),
        LinkReason::Order => "order".into(),
        LinkReason::Threat(name) => format!("!{name}"),
        LinkReason::Motion => "motion".into(),
    };
    let show = |link: &sgap::plan::Link| {
        let reasons: Vec<String> = link.reasons.iter().map(reason).collect();
        format!("{} -> {} {}", link.before, link.after, reasons.join(" "))
    };
    plan.links.iter().map(show).collect()
}

fn times(plan: &Plan) -> Vec<(f64, f64)> {
    plan.actions.iter().map(|a| (a.start, a.end)).collect()
}

/// 0 sets what 1 and 2 need; 1 and 2 are parallel; 3 needs what 2 sets, and overwrites what 1 reads. 0 -> 3 follows.
const DIAMOND: &str = "
  action Give(Agent A, Agent B) { effects { CUP.done = true; } duration { (2, 5) }; }
  action Use(Agent A) { preconditions { CUP.done; } effects { A.count = 1; } duration { (3, 3) }; }
  action Paint(Agent A) { preconditions { CUP.done; } effects { BOX.done = true; } duration { (1, 4) }; cost { 2 }; }
  action Spoil(Agent A) { preconditions { BOX.done; } effects { CUP.done = NULL; } duration { (1, 1) }; cost { 0.5 }; }
  method Go(Agent A) { { subtasks { 1: Give(A, H); 2: Use(A) > 1; 3: Rest(A) > 1; }; } }
  method Rest(Agent A) { { subtasks { 1: Paint(H); 2: Spoil(H) > 1; }; } }
";

#[test]
fn links_are_a_transitive_reduction_with_reasons() {
    let plan = document(DIAMOND);
    assert_eq!(
        links(&plan),
        [
            "0 -> 1 CUP.done order",
            "0 -> 2 CUP.done order",
            "1 -> 3 !CUP.done",
            "2 -> 3 BOX.done !CUP.done order",
        ]
    );
}

#[test]
fn starts_are_the_longest_paths() {
    let plan = document(DIAMOND);
    // Use and Paint begin when Give is over; Spoil waits for Use, which is the longer.
    assert_eq!(times(&plan), [(0.0, 2.0), (2.0, 5.0), (2.0, 3.0), (5.0, 6.0)]);
    assert_eq!((plan.makespan, plan.cost), (6.0, 4.5));
}

#[test]
fn a_joint_action_is_in_the_stream_of_each_that_takes_part() {
    let plan = document(DIAMOND);
    assert_eq!(plan.actions[0].agents, ["R", "H"]);
    let streams: Vec<(&str, &[usize])> = plan.streams.iter().map(|(k, v)| (k.as_str(), v.as_slice())).collect();
    assert_eq!(streams, [("R", &[0, 1][..]), ("H", &[0, 2, 3][..])]);
}

#[test]
fn an_agent_named_twice_takes_part_once() {
    let plan = document(
        "action Meet(Agent A, Agent B) { duration { (1, 1) }; } method Go(Agent A) { { subtasks { 1: Meet(A, A); 2: Meet(H, A); }; } }",
    );
    assert_eq!(plan.actions[0].agents, ["R"]);
    assert_eq!(plan.actions[1].agents, ["H", "R"]);
    assert_eq!(plan.streams["R"], [0, 1]);
    // No link: only R's own time keeps them apart.
    assert!(plan.links.is_empty());
    assert_eq!(times(&plan), [(0.0, 1.0), (1.0, 2.0)]);
}

#[test]
fn independent_actions_of_two_agents_are_parallel() {
    let plan = document(
        "action Wait(Agent A, number T) { duration { (T, T) }; }
         method Go(Agent A) { { subtasks { 1: Wait(A, 3); 2: Wait(H, 1); 3: Wait(H, 1) > 2; 4: Wait(A, 1) > 3; }; } }",
    );
    assert_eq!(links(&plan), ["1 -> 2 order", "2 -> 3 order"]);
    assert_eq!(times(&plan), [(0.0, 3.0), (0.0, 1.0), (1.0, 2.0), (3.0, 4.0)]);
}

/// The middle one has nothing to do; the last one still comes after the first.
#[test]
fn order_goes_through_a_subtask_that_needs_no_action() {
    let plan = document(
        "action Wait(Agent A) { duration { (1, 1) }; }
         method Nothing(Agent A) { goal { A.count == NULL; } { subtasks { 1: Wait(A); }; } }
         method Go(Agent A) { { subtasks { 1: Wait(A); 2: Nothing(A) > 1; 3: Wait(H) > 2; }; } }",
    );
    assert_eq!(links(&plan), ["0 -> 1 order"]);
    assert_eq!(times(&plan), [(0.0, 1.0), (1.0, 2.0)]);
}

/// A chain of subtrees of several steps: all of one comes before all of the next, and what links already say is not said
/// again. `Wait(H)` of each `Pair` is free within it.
#[test]
fn all_of_a_subtask_comes_before_all_of_the_next() {
    let plan = document(
        "action Wait(Agent A) { duration { (1, 1) }; }
         method Pair(Agent A) { { subtasks { 1: Wait(A); 2: Wait(H); }; } }
         method Nothing(Agent A) { goal { A.count == NULL; } { subtasks { 1: Wait(A); }; } }
         method Inner(Agent A) { { subtasks { 1: Pair(A); 2: Nothing(A) > 1; 3: Pair(A) > 2; }; } }
         method Go(Agent A) { { subtasks { 1: Wait(H); 2: Inner(A); 3: Wait(H) > 2; 4: Wait(A) > 1; }; } }",
    );
    // The free Wait(H) is done first and only comes before the last one.
    assert_eq!(
        links(&plan),
        [
            "0 -> 6 order",
            "1 -> 3 order",
            "1 -> 4 order",
            "2 -> 3 order",
            "2 -> 4 order",
            "3 -> 5 order",
            "4 -> 5 order",
        ]
    );
}

/// Two that write the same attribute, one that reads between: each pair is kept apart.
#[test]
fn actions_that_write_the_same_attribute_are_ordered() {
    let plan = document(
        "action Put(Agent A, Place P) { effects { CUP.at = P; } } action See(Agent A, Place P) { preconditions { CUP.at == P; } }
         method Go(Agent A) { { subtasks { 1: Put(A, SHELF); 2: Watch(A) > 1; 3: Put(H, FLOOR); }; } }
         method Watch(Agent A) { { subtasks { 1: See(H, SHELF); }; } }",
    );
    let plan_of = |plan: &Plan| {
        plan.actions
            .iter()
            .map(|a| a.name.clone())
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(plan_of(&plan), "Put See Put");
    assert_eq!(links(&plan), ["0 -> 1 CUP.at order", "1 -> 2 !CUP.at"]);
    let plan = document(
        "action Put(Agent A, Place P) { effects { CUP.at = P; } }
         method Go(Agent A) { { subtasks { 1: Put(A, SHELF); 2: Put(H, FLOOR); }; } }",
    );
    assert_eq!(links(&plan), ["0 -> 1 !CUP.at"]);
}

const FACTS: &str = "factdatabase {
    define entityType Object;
    define entityAttributes Agent { dynamic atom Object target; }
    define entityAttributes Object { dynamic set Agent users = fact isReachable; }
    R = new Agent; H = new Agent; CUP = new Object; BOX = new Object;
  }
  HTN { action Take(Agent A, Object O) { projects { pick(A, O) }; }";

fn projected(tasks: &str) -> Plan {
    let reasoner = Scripted::new("BOX.users = H", &["isReachable"])
        .with("pick(R, CUP)", vec![solution(1.0, 2.0, "CUP.users = R H")])
        .with("pick(R, BOX)", vec![solution(1.0, 3.0, "")])
        .with("pick(H, BOX)", vec![solution(1.0, 3.0, "BOX.users =")]);
    run(&format!("{FACTS} {tasks} }}"), "Go(R)", reasoner, &FIRST).document()
}

#[test]
fn motions_stand_in_one_line() {
    let plan = projected("method Go(Agent A) { { subtasks { 1: Take(A, CUP); 2: Take(H, BOX); }; } }");
    assert_eq!(links(&plan), ["0 -> 1 motion"]);
    assert_eq!(times(&plan), [(0.0, 2.0), (2.0, 5.0)]);
    assert_eq!(plan.actions[0].changes.get("CUP.users").map(|v| &**v), Some("[R, H]"));
    assert_eq!(plan.actions[1].changes.get("BOX.users").map(|v| &**v), Some("[]"));
}

/// What geometry changed is a link as much as what effects say.
#[test]
fn shared_attributes_make_links() {
    let plan = projected(
        "action Check(Agent A, Object O) { preconditions { A >> O.users; } }
         method Go(Agent A) { { subtasks { 1: Check(H, BOX); 2: Take(A, CUP) > 1; 3: Check(H, CUP) > 1; 4: Take(H, BOX) > 3; }; } }",
    );
    let names: Vec<&str> = plan.actions.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["Check", "Take", "Check", "Take"]);
    assert_eq!(links(&plan), ["0 -> 1 order", "1 -> 2 CUP.users", "2 -> 3 order"]);
}

/// The argument of a projection is something that the action needs.
#[test]
fn what_a_projection_is_called_with_makes_links() {
    let plan = projected(
        "action Aim(Agent A, Agent B, Object O) { effects { B.target = O; } duration { (5, 5) }; }
         action TakeIt(Agent A) { projects { pick(A, A.target) }; }
         method Go(Agent A) { { subtasks { 1: Aim(H, H, CUP); 2: Aim(H, H, BOX); 3: TakeIt(H) > 2; }; }
           { subtasks { 1: Aim(H, A, BOX); 2: Rest(A); }; } }
         method Rest(Agent A) { { subtasks { 1: TakeIt(A); }; } }",
    );
    assert_eq!(plan.actions[0].name, "Aim");
    assert!(
        links(&plan).iter().any(|l| l.ends_with("H.target order")),
        "{:?}",
        links(&plan)
    );
}

/// Geometry overrides what a symbolic action said of a shared attribute: their order matters either way.
#[test]
fn symbolic_actions_that_set_shared_attributes_are_ordered_with_motions() {
    let plan = projected(
        "action Say(Agent A) { effects { BOX.users = [R]; } }
         method Go(Agent A) { { subtasks { 1: Take(A, CUP); 2: Say(H); }; } }",
    );
    assert_eq!(links(&plan), ["0 -> 1 !BOX.users"]);
    let plan = projected(
        "action Say(Agent A) { effects { BOX.users = [H]; } }
         method Go(Agent A) { { subtasks { 2: Say(H); 1: Take(A, CUP); }; } }",
    );
    assert_eq!(links(&plan), ["0 -> 1 !BOX.users"]);
}

#[test]
fn the_tree_tells_how_the_task_was_decomposed() {
    let plan = document(
        "method Go(Agent A) { { preconditions { A.count == 1; } subtasks { 1: Mark(A, PEN); }; }
           { subtasks { 2: Twice(A, BOX) > 1; 1: Twice(A, CUP); }; } }
         method Twice(Agent A, Object O) { { subtasks { 1: Unmark(A, O); 2: Mark(A, O) > 1; }; } }",
    );
    let show = |node: &Node| {
        let how = match (node.decomposition, node.action) {
            (Some(d), None) => format!("/{d}"),
            (None, Some(a)) => format!("#{a}"),
            other => format!("{other:?}"),
        };
        let parent = node.parent.map(|p| format!("{p} > ")).unwrap_or_default();
        format!("{parent}{}({}){how}", node.task, node.arguments.join(","))
    };
    assert_eq!(
        plan.decomposition.iter().map(show).collect::<Vec<_>>(),
        [
            "Go(R)/1",
            "0 > Twice(R,CUP)/0",
            "1 > Unmark(R,CUP)#0",
            "1 > Mark(R,CUP)#1",
            "0 > Twice(R,BOX)/0",
            "4 > Unmark(R,BOX)#2",
            "4 > Mark(R,BOX)#3",
        ]
    );
    assert_eq!((plan.task.as_str(), plan.format.as_str()), ("Go(R)", "sgap-plan"));
}

/// Only what is different afterwards: an effect that sets what was already so is no change.
#[test]
fn changes_are_what_is_different() {
    let plan = document(
        "action Put(Agent A) { effects { CUP.at = TABLE; BOX.at = SHELF; BOX.at = FLOOR; CUP.users <<= A; CUP.users =>> A; R.count = 2 / 4; } }
         method Go(Agent A) { { subtasks { 1: Put(A); }; } }",
    );
    let changes: Vec<(&str, &str)> = plan.actions[0]
        .changes
        .iter()
        .map(|(k, v)| (k.as_str(), v.as_str()))
        .collect();
    assert_eq!(changes, [("R.count", "0.5"), ("BOX.at", "FLOOR")]);
}

#[test]
fn the_deepest_branch_is_told_when_there_is_no_plan() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks { 1: Mark(A, CUP); 2: Mark(A, BOX) > 1; 3: Never(A) > 2; }; } { subtasks { 1: Mark(A, PEN); 2: Never(H) > 1; }; }
               { preconditions { A.holds == CUP; H.holds == BOX; } subtasks { 1: Mark(A, CUP); }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.outcome.why_not.deepest, ["Mark(R, CUP)", "Mark(R, BOX)"]);
    assert_eq!(
        run.reasons(),
        [
            "1 x Never(R): R.count == 99 is false (R.count is NULL)",
            "1 x Never(H): H.count == 99 is false (H.count is NULL)",
            "1 x Go(R): R.holds == CUP is false (R.holds is NULL)",
        ]
    );
}
