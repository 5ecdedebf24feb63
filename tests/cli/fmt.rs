//! `sgap fmt`: what is written, what is only said, and what is left alone.

use super::Lab;

const UNTIDY: &str = "HTN{action Wait(Agent A){cost{1};// nothing\n}}";
const TIDY: &str = "HTN {\n  action Wait(Agent A) {\n    cost { 1 };  // nothing\n  }\n}\n";

fn text(lab: &Lab, name: &str) -> String {
    std::fs::read_to_string(lab.path(name)).unwrap()
}

#[test]
fn a_file_is_formatted_once() {
    let lab = Lab::new();
    lab.write("a.hatp", UNTIDY);
    lab.ends(0, &["fmt", "a.hatp", "cup.hatp"]).says(&["formatted a.hatp"]);
    assert_eq!(text(&lab, "a.hatp"), TIDY);
    let again = lab.ends(0, &["fmt", "a.hatp"]);
    assert_eq!(again.err, "");
    lab.ends(0, &["fmt", "--check", "a.hatp", "cup.hatp"]);
}

#[test]
fn check_says_what_would_change_and_changes_nothing() {
    let lab = Lab::new();
    lab.write("a.hatp", UNTIDY);
    let said = lab.ends(1, &["fmt", "--check", "cup.hatp", "a.hatp"]);
    said.says(&["`a.hatp` is not formatted", "from line 1", "- HTN{action", "+ HTN {"]);
    assert!(!said.err.contains("cup.hatp"), "{}", said.err);
    assert_eq!(text(&lab, "a.hatp"), UNTIDY);
}

#[test]
fn a_file_with_errors_is_reported_and_not_touched() {
    let lab = Lab::new();
    let wrong = "action  A(Agent A) { cost { } }";
    lab.write("wrong.hatp", wrong);
    lab.write("bytes.hatp", b"action A(Agent A) { } // \xff");
    lab.write("a.hatp", UNTIDY);
    let said = lab.ends(1, &["fmt", "wrong.hatp", "bytes.hatp", "missing.hatp", "a.hatp"]);
    said.says(&[
        "wrong.hatp:1:",
        "expected a value",
        "not UTF-8",
        "no such file",
        "formatted a.hatp",
    ]);
    assert_eq!(text(&lab, "wrong.hatp"), wrong);
    assert_eq!(text(&lab, "a.hatp"), TIDY, "the others are still formatted");
}

#[test]
fn the_standard_input_goes_to_the_standard_output() {
    let sgap = || assert_cmd::Command::cargo_bin("sgap").unwrap();
    sgap()
        .args(["fmt", "-"])
        .write_stdin(UNTIDY)
        .assert()
        .success()
        .stdout(TIDY)
        .stderr("");
    sgap()
        .args(["fmt", "--check", "-"])
        .write_stdin(UNTIDY)
        .assert()
        .code(1)
        .stdout("");
    sgap()
        .args(["fmt", "-"])
        .write_stdin("action")
        .assert()
        .code(1)
        .stdout("");
    sgap()
        .args(["fmt", "-"])
        .write_stdin(&b"\xff"[..])
        .assert()
        .code(1)
        .stdout("");
}

#[test]
fn an_endless_line_is_shown_in_part() {
    let lab = Lab::new();
    lab.write("a.hatp", format!("{UNTIDY}//{}\u{202e}", "-".repeat(100_000)));
    let said = lab.ends(1, &["fmt", "--check", "a.hatp"]);
    said.says(&["- HTN{action", "…", "\\u{202e}"]);
    assert!(said.err.len() < 2_000, "{}", said.err);
}
