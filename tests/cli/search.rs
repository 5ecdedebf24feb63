//! How far a search goes, how it is ended, and what it says then.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use super::{Lab, Said};

const LAMPS: &str = "
factdatabase {
  define entityType Lamp;
  define entityAttributes Lamp { dynamic atom bool on; static atom number price; }
  define entityAttributes Agent { dynamic atom number code; dynamic atom number left; }
  ANN = new Agent; BOB = new Agent; ANN.code = 1; ANN.left = 50;
  DESK = new Lamp; HALL = new Lamp; DESK.price = 3; HALL.price = 2;
}
HTN {
  action Switch(Agent A, Lamp L) { preconditions { L.on != true; } effects { L.on = true; } cost { L.price } duration { (1, 1) } }
  action Off(Agent A, Lamp L) { preconditions { L.on == true; } effects { L.on = false; } cost { L.price } duration { (1, 1) } }
  action Step(Agent A) { effects { A.code = A.code + 1; } }
  method One(Agent A) { { subtasks { L = SELECT(Lamp, {L.on != true;}); 1: Switch(A, L); }; } }
  method Both(Agent A, Agent B) { { subtasks { 1: Blink(A, DESK); 2: Blink(B, HALL); }; } }
  method Blink(Agent A, Lamp L) { { subtasks { 1: Switch(A, L); 2: Off(A, L) > 1; }; } }
  method Ever(Agent A) { { subtasks { 1: Step(A); 2: Ever(A) > 1; }; } }
  method Ping(Agent A) { { subtasks { 1: Pong(A); 2: Step(A) > 1; }; } }
  method Pong(Agent A) { { subtasks { 1: Ping(A); 2: Step(A) > 1; }; } }
  action Note(Agent A, number N) { effects { A.code = 2 * A.code + N; A.left = A.left - 1; } cost { 0 } }
  action Pay(Agent A) { cost { 4 + A.code - A.code } }
  method Long(Agent A) {
    { preconditions { A.left == 0; } subtasks { 1: Pay(A); }; }
    { preconditions { A.left > 0; } subtasks { 1: Note(A, 0); 2: Long(A) > 1; }; }
    { preconditions { A.left > 0; } subtasks { 1: Note(A, 1); 2: Long(A) > 1; }; } }
}";

fn lab() -> Lab {
    let lab = Lab::new();
    lab.write("lamps.hatp", LAMPS);
    lab
}

/// Plans without the warnings that such a domain deserves.
fn arguments<'a>(task: &'a str, options: &[&'a str]) -> Vec<&'a str> {
    let quiet = [
        "--allow",
        "endless-recursion",
        "--allow",
        "unreached-task",
        "--allow",
        "unused-variable",
    ];
    [&["plan", "lamps.hatp", "--task", task][..], &quiet, options].concat()
}

fn plan(code: i32, task: &str, options: &[&str]) -> Said {
    lab().ends(code, &arguments(task, options))
}

#[test]
fn all_plans_are_given_and_fewer_than_asked_for_are_explained() {
    let said = plan(0, "One(ANN)", &["--all", "2"]);
    assert_eq!(
        (said.out.matches("plan of One(ANN)").count(), said.err.as_str()),
        (2, "")
    );
    let said = plan(0, "One(ANN)", &["--all", "9"]);
    assert_eq!(said.err, "2 plans of the 9 asked for: every choice was tried\n");
    let said = plan(0, "One(ANN)", &["--all", "9", "--max-expansions", "2"]);
    assert_eq!(
        said.err,
        "1 plan of the 9 asked for: not more within --max-expansions 2\n"
    );
    let said = plan(0, "Both(ANN, BOB)", &["--all", "9", "--json"]);
    let plans: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(plans.as_array().unwrap().len(), 2);
    let said = plan(0, "Both(ANN, BOB)", &["--all", "9", "--json", "--interleave"]);
    let plans: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(plans.as_array().unwrap().len(), 6);
    let said = plan(0, "One(ANN)", &["--all", "1", "--json"]);
    assert!(said.out.starts_with('['), "a list whatever the number: {}", said.out);
    plan(2, "One(ANN)", &["--all", "0"]);
    plan(2, "One(ANN)", &["--all", "2", "--best"]);
}

#[test]
fn the_best_plan_says_how_good_it_is() {
    let said = plan(0, "One(ANN)", &["--best"]);
    assert_eq!(
        said.err,
        "plan 1: 1 actions, cost 3.0000\nplan 2: 1 actions, cost 2.0000\nbest plan: every choice was tried\n"
    );
    plan(0, "One(ANN)", &["--best", "--max-expansions", "2"])
        .says(&["best plan within --max-expansions 2; no plan costs less than 2.0000 (gap 33.3 %)"]);
}

#[test]
fn no_room_at_all_is_said() {
    plan(12, "One(ANN)", &["--timeout", "0"]).says(&["no plan found within --timeout 0 s"]);
    plan(12, "One(ANN)", &["--best", "--max-expansions", "0"]).says(&["within --max-expansions 0"]);
    plan(0, "One(ANN)", &["--max-depth", "0"]);
    plan(11, "Both(ANN, BOB)", &["--max-depth", "0"])
        .says(&["2 branches were too deep", "Both(ANN, BOB) > Blink(ANN, DESK)"]);
}

#[test]
fn a_recursion_without_end_is_named_in_a_few_lines() {
    let said = plan(11, "Ever(ANN)", &[]);
    said.says(&["more than 100000 methods deep", "Ever(ANN) > Ever(ANN)", "more ..."]);
    assert!(said.err.lines().count() < 40, "{}", said.err);
    plan(11, "Ping(ANN)", &[]).says(&["Ping(ANN) > Pong(ANN) > Ping(ANN)", "--no-cuts"]);
    plan(11, "Ping(ANN)", &["--no-cuts"]).says(&["too deep", "Pong(ANN) > Ping(ANN) > Pong(ANN)"]);
}

/// Nobody reads the standard error: the plan comes nevertheless.
#[test]
fn a_reader_of_messages_that_goes_away_is_no_error() {
    let lab = lab();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("sgap"));
    command
        .current_dir(lab.0.path())
        .args(arguments("One(ANN)", &["--best"]));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.starts_with(b"plan of One(ANN)"));
}

/// The first Ctrl-C ends the search, and the best plan so far is what comes out.
#[cfg(unix)]
#[test]
fn an_interrupted_search_gives_its_best_plan() {
    let lab = lab();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("sgap"));
    let endless = ["--best", "--max-expansions", "1000000000", "--timeout", "60"];
    command.current_dir(lab.0.path()).args(arguments("Long(ANN)", &endless));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    assert_eq!(said.next().unwrap().unwrap(), "plan 1: 51 actions, cost 4.0000");
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    let last = said.map_while(Result::ok).last().unwrap();
    assert_eq!(last, "best plan before the search was interrupted");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.starts_with(b"plan of Long(ANN)\n51 actions"));
}
