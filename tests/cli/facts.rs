//! `sgap facts`: single questions with their reasons, and the world after a plan.

use super::{Lab, plan};

#[test]
fn single_questions_are_answered_with_the_reason() {
    let lab = Lab::new();
    let said = lab.ends(
        0,
        &[
            "facts",
            "cup.toml",
            "isOn(CUP, SHELF)",
            "hasInHand(PR2, CUP)",
            "distance(CUP, SHELF)",
        ],
    );
    let lines: Vec<&str> = said.out.lines().collect();
    assert_eq!(lines.len(), 3, "{}", said.out);
    assert!(lines[0].contains("isOn(CUP, SHELF): its bottom"), "{}", lines[0]);
    assert_eq!(lines[1], "not hasInHand(PR2, CUP): nobody holds it");
    assert!(lines[2].starts_with("distance(CUP, SHELF) = "), "{}", lines[2]);
}

#[test]
fn what_is_no_question_is_told() {
    let lab = Lab::new();
    for (question, says) in [
        ("isOn", "write it like `isReachable(CUP, PR2)`"),
        ("isReachabel(CUP, PR2)", "did you mean `isReachable`?"),
        ("isOn(CPU, SHELF)", "did you mean `CUP`?"),
        ("hasInHand(CUP, PR2)", "makes no sense"),
    ] {
        lab.ends(2, &["facts", "cup.toml", question]).says(&[says]);
    }
}

#[test]
fn a_plan_changes_facts() {
    let lab = Lab::new();
    lab.ends(0, &plan(&["--json", "-o", "plan.json"]));
    let start = lab.ends(0, &["facts", "cup.toml"]).out;
    let none = lab
        .ends(0, &["facts", "cup.toml", "--after", "plan.json", "--actions", "0"])
        .out;
    assert_eq!(start, none);
    let first = [
        "facts",
        "cup.toml",
        "--after",
        "plan.json",
        "--actions",
        "1",
        "--changed",
    ];
    let changed = lab.ends(0, &first).out;
    assert!(
        changed.contains("\nhasInHand(PR2, CUP)\n") || changed.starts_with("hasInHand(PR2, CUP)\n"),
        "{changed}"
    );
    lab.ends(1, &["facts", "cup.toml", "--after", "plan.json", "--actions", "99"])
        .says(&["plan::too-short"]);
}
