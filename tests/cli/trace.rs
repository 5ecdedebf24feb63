//! `sgap plan --trace FILE` and `sgap trace FILE`.

use std::io::Read;
use std::process::{Command, Stdio};

use super::Lab;

const CUPS: &str = "
factdatabase {
  define entityType Cup;
  define entityAttributes Cup { dynamic set Agent isReachable; dynamic atom bool away; }
  ANN = new Agent; BOB = new Agent;
  C1 = new Cup; C2 = new Cup; C3 = new Cup; C1.isReachable <<= BOB;
}
HTN {
  action Take(Agent A, Cup C) { preconditions { A >> C.isReachable; }; effects { C.away = true; } }
  method Any(Agent A) { { subtasks { C = SELECT(Cup, {C.away != true;}); 1: Take(A, C); }; } }
}";

fn lab() -> Lab {
    let lab = Lab::new();
    lab.write("cups.hatp", CUPS);
    lab
}

const PLAN: [&str; 6] = ["plan", "cups.hatp", "--task", "Any(ANN)", "--trace", "search.jsonl"];

#[test]
fn a_search_without_a_plan_is_explained_by_its_trace() {
    let lab = lab();
    lab.ends(10, &PLAN[..4]).says(&["--trace FILE writes the whole search"]);
    let said = lab.ends(10, &PLAN);
    said.says(&[
        "3 x Take: A >> C.isReachable is false",
        "Take(ANN, C1) (C1.isReachable is [BOB])",
    ]);
    assert!(!said.err.contains("--trace FILE"), "{}", said.err);
    let text = lab.ends(0, &["trace", "search.jsonl"]).out;
    for line in [
        "trace of Any(ANN)",
        "Any(ANN)                                                     1       -       2        -",
        "  Take(ANN, *)                                               3       3       -        -",
        "      3 x A >> C.isReachable is false",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}\n{text}");
    }
    let json = lab.ends(0, &["trace", "search.jsonl", "--json"]).out;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["failures"][0]["count"], 3);
    let one = lab.ends(0, &["trace", "search.jsonl", "--task", "Take(ANN, C1)"]).out;
    assert!(one.contains("C1.isReachable is [BOB]") && !one.contains("C2"), "{one}");
    let top = lab.ends(0, &["trace", "search.jsonl", "--depth", "0"]).out;
    assert!(top.contains("1 group of tasks is below"), "{top}");
}

#[test]
fn what_ended_no_branch_of_the_task_wanted_is_left_out() {
    let lab = lab();
    lab.ends(10, &PLAN);
    let none = lab.ends(0, &["trace", "search.jsonl", "--task", "Give"]).out;
    assert!(none.contains("no such task was taken up"), "{none}");
    assert!(
        !none.contains(" 0 x ") && !none.contains("what ended branches"),
        "{none}"
    );
}

#[test]
fn times_are_written_when_asked_for_and_nothing_else_changes() {
    let lab = lab();
    let bytes = || std::fs::read_to_string(lab.path("search.jsonl")).unwrap();
    lab.ends(10, &PLAN);
    let without = bytes();
    lab.ends(10, &PLAN);
    assert_eq!(bytes(), without);
    lab.ends(10, &[&PLAN[..], &["--trace-times"]].concat());
    let rest: Vec<String> = bytes()
        .lines()
        .filter(|l| !l.contains("\"us\""))
        .map(str::to_owned)
        .collect();
    assert_eq!(rest, without.lines().collect::<Vec<_>>());
    assert!(lab.ends(0, &["trace", "search.jsonl"]).out.contains("time [ms]"));
    lab.ends(2, &[&PLAN[..4], &["--trace-times"]].concat());
}

#[test]
fn what_is_no_trace_is_refused_with_its_line() {
    let lab = lab();
    lab.ends(10, &PLAN);
    let text = std::fs::read_to_string(lab.path("search.jsonl")).unwrap();
    lab.write("broken.jsonl", text.replacen("\"e\":\"bind\"", "\"e\":\"band\"", 1));
    lab.ends(1, &["trace", "broken.jsonl"])
        .says(&["trace::unreadable", "line 4: is no event of a trace"]);
    lab.ends(1, &["trace", "cups.hatp"])
        .says(&["line 1: is not the first line of a trace"]);
    lab.ends(1, &["trace", "nothing.jsonl"])
        .says(&["there is no such file"]);
    lab.ends(1, &["trace", "."]).says(&["it is a directory"]);
    lab.ends(
        1,
        &["plan", "cups.hatp", "--task", "Any(ANN)", "--trace", "no/where.jsonl"],
    )
    .says(&["output::unwritable", "there is no directory `no`"]);
}

/// The disk is full: the search goes on, and the error comes at its end.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let full = ["plan", "cups.hatp", "--task", "Any(BOB)", "--trace", "/dev/full"];
    let said = lab().ends(1, &full);
    said.says(&["output::unwritable", "can't write the trace `/dev/full`"]);
    assert!(said.out.contains("Take(BOB, C1)"), "the plan was found: {}", said.out);
}

#[test]
fn a_reader_of_a_trace_that_goes_away_is_no_error() {
    let lab = lab();
    lab.ends(10, &PLAN);
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("sgap"))
        .current_dir(lab.0.path())
        .args(["trace", "search.jsonl"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""));
}
