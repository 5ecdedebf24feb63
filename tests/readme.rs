//! The README tells the truth: two commands, and the plan that the first one prints.
#![expect(clippy::unwrap_used, reason = "a test says by a panic what is wrong")]

use assert_cmd::Command;

fn readme() -> String {
    std::fs::read_to_string("README.md").unwrap()
}

fn commands(readme: &str) -> Vec<&str> {
    readme
        .lines()
        .filter_map(|l| l.strip_prefix("    "))
        .filter(|l| l.starts_with("cargo "))
        .collect()
}

#[test]
fn there_are_two_commands() {
    let readme = readme();
    let [plan, tests] = commands(&readme)[..] else {
        panic!("two commands: {:?}", commands(&readme))
    };
    assert!(plan.starts_with("cargo run --release -- plan "), "{plan}");
    assert!(tests.starts_with("cargo test"), "{tests}");
}

#[test]
fn the_plan_shown_is_the_plan_printed() {
    let readme = readme();
    let plan = commands(&readme)[0];
    let arguments = plan.split_once(" -- ").unwrap().1.split_whitespace();
    let shown = readme
        .split("```text\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .unwrap();
    Command::cargo_bin("sgap")
        .unwrap()
        .args(arguments)
        .assert()
        .success()
        .stdout(shown.to_owned());
}

#[test]
fn every_file_that_it_points_to_is_there() {
    for link in readme().split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        assert!(std::path::Path::new(link).exists(), "{link}");
    }
}
