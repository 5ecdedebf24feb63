//! What makes the program pleasant: a first folder, completions, manual pages, quiet and verbose, planning on every save, forms of other tools.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use super::{Lab, plan};

#[test]
fn a_new_folder_runs_as_it_is() {
    let lab = Lab::new();
    lab.ends(0, &["new", "kitchen"])
        .says(&["sgap plan kitchen/kitchen.hatp kitchen/kitchen.toml"]);
    let test = Command::new("sh")
        .arg(lab.path("kitchen/test.sh"))
        .env("SGAP", assert_cmd::cargo::cargo_bin("sgap"))
        .output()
        .unwrap();
    assert!(test.status.success(), "{}", String::from_utf8_lossy(&test.stderr));
    assert!(lab.path("kitchen/plan.json").exists());
    // It is not made twice, and not where its name could not be an item's.
    lab.ends(1, &["new", "kitchen"]).says(&["it is there already"]);
    lab.ends(1, &["new", "my kitchen"]).says(&["letters, digits"]);
}

#[test]
fn completions_know_the_commands() {
    let lab = Lab::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = lab.ends(0, &["completions", shell]).out;
        assert!(
            script.contains("validate") && script.contains("max-expansions"),
            "{shell}"
        );
    }
    lab.ends(2, &["completions", "csh"]).says(&["bash, elvish, fish"]);
}

#[test]
fn manual_pages_are_there_for_all() {
    let lab = Lab::new();
    let page = lab.ends(0, &["man"]).out;
    assert!(page.contains(".TH sgap 1") && page.contains("Exit codes"), "{page}");
    let page = lab.ends(0, &["man", "plan"]).out;
    assert!(
        page.contains(".TH sgap\\-plan 1") || page.contains(".TH sgap-plan 1"),
        "{page}"
    );
    assert!(page.contains("branching"), "{page}");
    lab.ends(2, &["man", "plam"]).says(&["did you mean `plan`?"]);
}

#[test]
fn the_schema_kept_in_the_docs_is_the_one_printed() {
    let printed = Lab::new().ends(0, &["schema"]).out;
    let kept = std::path::Path::new("docs/plan.schema.json");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(kept, &printed).unwrap();
    }
    assert_eq!(
        std::fs::read_to_string(kept).unwrap(),
        printed,
        "UPDATE_DOCS=1 writes it anew"
    );
}

#[test]
fn quiet_says_nothing_and_verbose_says_more() {
    let lab = Lab::new();
    assert_ne!(lab.ends(0, &plan(&["--best"])).err, "");
    assert_eq!(lab.ends(0, &plan(&["--best", "--quiet"])).err, "");
    assert_eq!(lab.ends(0, &["-q", "check", "cup.hatp"]).err, "");
    lab.ends(0, &plan(&["-v"]))
        .says(&["expansions", "inverse kinematics calls"]);
    // Problems are said all the same.
    lab.ends(1, &["-q", "check", "cup.hatb"]).says(&["cup.hatb"]);
    lab.ends(2, &plan(&["-q", "-v"]));
}

#[test]
fn watch_plans_again_when_a_file_is_saved() {
    let lab = Lab::new();
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("sgap"))
        .args(["watch", "cup.hatp", "cup.toml"])
        .current_dir(lab.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut plans = BufReader::new(child.stdout.take().unwrap())
        .lines()
        .map_while(Result::ok)
        .filter(|line| line.starts_with("plan of "));
    assert_eq!(plans.next().as_deref(), Some("plan of Bring(CUP, TRAY)"));
    lab.world_with("cup.toml", "task = ", "# saved\ntask = ");
    assert_eq!(plans.next().as_deref(), Some("plan of Bring(CUP, TRAY)"));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn each_form_of_other_tools_is_written() {
    let lab = Lab::new();
    lab.ends(0, &plan(&["--json", "-o", "plan.json"]));
    for (form, word) in [
        ("gltf", "\"animations\""),
        ("csv", "time,action,task"),
        ("ros", "joint_names"),
        ("moveit", "collision_objects"),
        ("dot", "digraph"),
    ] {
        let planned = lab.ends(0, &plan(&["--format", form])).out;
        assert!(planned.contains(word), "{form}");
        let viewed = lab.ends(0, &["view", "cup.hatp", "cup.toml", "--format", form]).out;
        assert_eq!(planned, viewed, "{form}");
        // Rounded in the document.
        assert!(
            lab.ends(0, &["view", "cup.toml", "plan.json", "--format", form])
                .out
                .contains(word)
        );
        lab.ends(2, &["check", "cup.hatp", "--format", form])
            .says(&["only `sgap plan` and `sgap view`"]);
        lab.ends(2, &plan(&["--format", form, "--json"]));
    }
    lab.ends(2, &["view", "cup.toml", "--format", "csv"])
        .says(&["name a domain, or a plan"]);
    let svg = [
        "view",
        "cup.toml",
        "plan.json",
        "--svg",
        "plan.svg",
        "-o",
        "page.html",
        "--no-open",
    ];
    lab.ends(0, &svg).says(&["plan.svg written", "page.html written"]);
    assert!(
        std::fs::read_to_string(lab.path("plan.svg"))
            .unwrap()
            .starts_with("<svg ")
    );
    lab.ends(2, &["view", "cup.toml", "--at", "1"]).says(&["--png"]);
}
