//! The program as a user meets it: exit codes, what is printed where, and which files are written.
#![expect(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "tests may unwrap; how long an answer takes is measured"
)]

#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/comfort.rs"]
mod comfort;
#[path = "cli/facts.rs"]
mod facts;
#[path = "cli/fmt.rs"]
mod fmt;
#[path = "cli/hddl.rs"]
mod hddl;
#[path = "cli/help.rs"]
mod help;
#[path = "cli/problems.rs"]
mod problems;
#[path = "cli/repair.rs"]
mod repair;
#[path = "cli/search.rs"]
mod search;
#[path = "cli/symbolic.rs"]
mod symbolic;
#[path = "cli/trace.rs"]
mod trace;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tempfile::TempDir;

const DOMAIN: &str = include_str!("cli/cup.hatp");
const WORLD: &str = include_str!("cli/cup.toml");

/// A folder of its own with a domain, a world and the models that it names.
struct Lab(TempDir);

/// What the program said.
struct Said {
    code: i32,
    out: String,
    err: String,
    took: Duration,
}

impl Lab {
    fn new() -> Self {
        let lab = Lab(tempfile::tempdir().unwrap());
        lab.write("cup.hatp", DOMAIN);
        lab.write("cup.toml", WORLD);
        std::fs::create_dir(lab.path("models")).unwrap();
        for name in ["pr2.toml", "pr2.urdf", "human.toml", "human.urdf"] {
            std::fs::copy(Path::new("worlds/models").join(name), lab.path("models").join(name)).unwrap();
        }
        lab
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Writes the world with one piece of its text exchanged.
    fn world_with(&self, name: &str, old: &str, new: &str) {
        assert!(WORLD.contains(old), "{old}");
        self.write(name, WORLD.replace(old, new));
    }

    /// Runs the program in the folder; it never panics.
    fn run(&self, arguments: &[&str]) -> Said {
        let begin = Instant::now();
        let mut command = assert_cmd::Command::cargo_bin("sgap").unwrap();
        let output = command.current_dir(self.0.path()).args(arguments).output().unwrap();
        let said = Said {
            code: output.status.code().unwrap(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
            took: begin.elapsed(),
        };
        assert_ne!(said.code, 70, "{arguments:?}: {}", said.err);
        assert!(!said.err.contains("panicked"), "{arguments:?}: {}", said.err);
        assert!(!said.err.contains('\u{1b}'), "colours only on a terminal: {}", said.err);
        said
    }

    /// Runs a command that must end with this code.
    fn ends(&self, code: i32, arguments: &[&str]) -> Said {
        let said = self.run(arguments);
        assert_eq!(said.code, code, "{arguments:?}: {}{}", said.out, said.err);
        said
    }
}

impl Said {
    /// The message has all these parts.
    fn says(&self, parts: &[&str]) -> &Self {
        for part in parts {
            assert!(self.err.contains(part), "no `{part}` in: {}", self.err);
        }
        self
    }
}

const PLAN: [&str; 3] = ["plan", "cup.hatp", "cup.toml"];

fn plan<'a>(options: &[&'a str]) -> Vec<&'a str> {
    PLAN.iter().chain(options).copied().collect()
}

#[test]
fn a_plan_is_text_json_and_page_the_same_each_time() {
    let lab = Lab::new();
    let text = lab.ends(0, &PLAN);
    assert_eq!(text.err, "");
    assert!(
        text.out.starts_with("plan of Bring(CUP, TRAY)\n2 actions, cost "),
        "{}",
        text.out
    );
    assert_eq!(text.out, lab.ends(0, &PLAN).out);
    let json = lab.ends(0, &plan(&["--json", "--seed", "7"])).out;
    assert_eq!(json, lab.ends(0, &plan(&["--json", "--seed", "7"])).out);
    for page in ["a.html", "b.html"] {
        lab.ends(0, &["view", "cup.hatp", "cup.toml", "-o", page]);
    }
    let [a, b] = ["a.html", "b.html"].map(|page| std::fs::read_to_string(lab.path(page)).unwrap());
    assert!(a == b && a.starts_with("<!doctype html>"), "{:.60}", a);
}

#[test]
fn a_page_shows_a_world_alone_or_a_plan_from_a_file() {
    let lab = Lab::new();
    lab.ends(0, &plan(&["--json", "-o", "plan.json"]));
    let page = |arguments: &[&str]| {
        lab.ends(0, &[&["view", "-o", "p.html"], arguments].concat());
        std::fs::read_to_string(lab.path("p.html")).unwrap()
    };
    assert!(page(&["cup.toml"]).contains("id=\"plan-data\">null<"));
    let planned = page(&["cup.hatp", "cup.toml", "--no-open"]);
    let read = page(&["cup.toml", "plan.json"]);
    // A plan from a file has its numbers rounded.
    let actions = |page: &str| {
        let rest = page.split_once("id=\"plan-data\">").unwrap().1;
        let plan: sgap::plan::Plan = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
        plan.actions
            .into_iter()
            .map(|a| (a.name, a.arguments))
            .collect::<Vec<_>>()
    };
    assert_eq!(actions(&planned), actions(&read));
    lab.ends(2, &["view", "plan.json"])
        .says(&["its world must be named, too"]);
    lab.ends(1, &["view", "cup.toml", "cup.json"])
        .says(&["plan::unreadable", "can't read the plan `cup.json`"]);
}

#[test]
fn a_plan_as_json_is_valid_until_it_is_changed() {
    let lab = Lab::new();
    let json = lab.ends(0, &plan(&["--json"])).out;
    let document: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(document["format"], "sgap-plan");
    lab.ends(0, &plan(&["--json", "-o", "plan.json"]));
    assert_eq!(std::fs::read_to_string(lab.path("plan.json")).unwrap(), json);
    let valid = lab.ends(0, &["validate", "cup.hatp", "cup.toml", "plan.json"]);
    assert!(valid.out.starts_with("valid: "), "{}", valid.out);

    let mut changed = document;
    changed["cost"] = serde_json::json!(0.0);
    lab.write("plan.json", changed.to_string());
    let said = lab.ends(20, &["validate", "cup.hatp", "cup.toml", "plan.json"]);
    said.says(&["invalid: ", "cost"]);
    // The same plan does not fit another world.
    lab.write("plan.json", &json);
    lab.world_with("moved.toml", "at = [-0.1, -0.2]", "at = [-0.1, -0.1]");
    lab.ends(20, &["validate", "cup.hatp", "moved.toml", "plan.json"]);
}

#[test]
fn the_command_line_task_wins() {
    let lab = Lab::new();
    let said = lab.ends(0, &plan(&["--task", "Take(PR2, CUP)"]));
    assert!(
        said.out.starts_with("plan of Take(PR2, CUP)\n1 action, "),
        "{}",
        said.out
    );
    lab.world_with("none.toml", "task = \"Bring(CUP, TRAY)\"", "");
    lab.ends(0, &["plan", "cup.hatp", "none.toml", "--task", "Take(PR2, CUP)"]);
    let said = lab.ends(1, &["plan", "cup.hatp", "none.toml"]);
    said.says(&["world::no-task", "`none.toml` names no task", "--task"]);
}

#[test]
fn without_a_plan_the_code_tells_how_far_the_search_came() {
    let lab = Lab::new();
    lab.world_with("far.toml", "xyz = [0.75, 0, 0.35]", "xyz = [3, 0, 0.35]");
    let said = lab.ends(10, &["plan", "cup.hatp", "far.toml", "-o", "out.txt"]);
    said.says(&["no plan exists", "CUP.isReachable is []"]);
    // Geometry itself says no, too.
    lab.write("blind.hatp", DOMAIN.replace(" A >> O.isReachable;", ""));
    let said = lab.ends(10, &["plan", "blind.hatp", "far.toml", "-o", "out.txt"]);
    said.says(&[
        "pick(PR2, CUP): no solution among all ",
        "out of reach of the right arm",
    ]);

    let full = format!("{WORLD}\n[objects.BOX]\nmovable = false\nbox = [0.28, 0.28, 0.2]\nxyz = [0.75, 0.2, 0.83]\n");
    lab.write("full.toml", full);
    let said = lab.ends(11, &["plan", "cup.hatp", "full.toml", "-o", "out.txt"]);
    said.says(&["no plan found: ", "--branching", "--placements", "  Take(PR2, CUP)"]);
    said.says(&[
        "place(PR2, CUP, TRAY): no solution among ",
        "place: CUP collides with BOX",
    ]);
    assert!(said.err.lines().count() < 20, "{}", said.err);

    let said = lab.ends(12, &plan(&["--max-expansions", "1", "-o", "out.txt"]));
    said.says(&["no plan found within --max-expansions 1 (try more)"]);
    let said = lab.ends(12, &plan(&["--timeout", "0", "-o", "out.txt"]));
    said.says(&["no plan found within --timeout 0 s (try more)"]);
    let timed_out = lab.run(&["plan", "blind.hatp", "far.toml", "--timeout", "0.0001"]);
    assert!([10, 12].contains(&timed_out.code), "{}", timed_out.code);

    assert!(!lab.path("out.txt").exists(), "nothing is written");
    lab.ends(0, &plan(&["--branching", "1"]));
}

#[test]
fn wrong_usage_is_told_from_wrong_input() {
    let lab = Lab::new();
    for arguments in [
        vec!["plan"],
        vec!["plna", "cup.hatp", "cup.toml"],
        plan(&["--branching", "0"]),
        plan(&["--timeout", "-1"]),
        plan(&["--timeout", "nan"]),
        plan(&["--timeout", "1e300"]),
        plan(&["--placements", "0"]),
        plan(&["--sed", "1"]),
    ] {
        let said = lab.ends(2, &arguments);
        said.says(&["error: "]);
        assert_eq!(said.out, "");
    }
    lab.ends(2, &plan(&["--timeout", "-1"]))
        .says(&["a number of seconds from 0"]);
}

#[test]
fn every_command_helps_with_an_example() {
    let lab = Lab::new();
    for command in ["plan", "validate", "check", "facts", "view"] {
        let help = lab.ends(0, &[command, "--help"]).out;
        assert!(help.contains(&format!("  sgap {command} ")), "{help}");
    }
    let help = lab.ends(0, &["--help"]).out;
    assert!(help.contains("  sgap plan ") && help.contains("Exit codes:"), "{help}");
}

#[test]
fn facts_are_lines_or_json() {
    let lab = Lab::new();
    let text = lab.ends(0, &["facts", "cup.toml"]).out;
    assert!(text.lines().any(|l| l == "isOn(CUP, SHELF)"), "{text}");
    assert!(text.lines().any(|l| l == "isReachable(CUP, PR2)"), "{text}");
    assert!(!text.contains("not "), "{text}");
    let all = lab.ends(0, &["facts", "cup.toml", "--all"]).out;
    assert!(all.lines().any(|l| l == "not isOn(CUP, TRAY)"), "{all}");
    let json = lab.ends(0, &["facts", "cup.toml", "--json"]).out;
    let rows: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    assert_eq!(rows.len(), text.lines().count());
    let row = serde_json::json!({"fact": "isOn", "arguments": ["CUP", "SHELF"], "holds": true});
    assert!(rows.contains(&row), "{json}");
}

#[test]
fn check_looks_at_a_domain_alone_or_with_its_world() {
    let lab = Lab::new();
    lab.ends(0, &["check", "cup.hatp"])
        .says(&["no errors: 2 actions, 1 method, 0 entities"]);
    lab.ends(0, &["check", "cup.hatp", "cup.toml"]).says(&["4 entities"]);
    lab.world_with("no_cup.toml", "TRAY)\"", "TRAI)\"");
    let said = lab.ends(1, &["check", "cup.hatp", "no_cup.toml"]);
    said.says(&["hatp::unknown-name", "no_cup.toml:1:20", "did you mean `TRAY`?"]);
    for arguments in [&["facts", "cup.hatp"] as &[&str], &["check", "cup.hatp", "cup.hatp"]] {
        lab.ends(1, arguments)
            .says(&["`cup.hatp` is a domain, and a world file is wanted"]);
    }
}

#[test]
fn what_was_in_a_file_stays_until_all_of_the_new_is_there() {
    let lab = Lab::new();
    lab.write("out.json", "old");
    lab.write("broken.hatp", DOMAIN.replace("action Take", "acton Take"));
    lab.ends(1, &["plan", "broken.hatp", "cup.toml", "-o", "out.json"]);
    lab.ends(12, &plan(&["--max-expansions", "1", "-o", "out.json"]));
    lab.ends(
        12,
        &[
            "view",
            "cup.hatp",
            "cup.toml",
            "--max-expansions",
            "1",
            "-o",
            "out.json",
        ],
    );
    assert_eq!(std::fs::read_to_string(lab.path("out.json")).unwrap(), "old");
    let before = std::fs::read_dir(lab.0.path()).unwrap().count();
    lab.ends(0, &plan(&["--json", "-o", "out.json"]));
    assert!(std::fs::read_to_string(lab.path("out.json")).unwrap().ends_with("}\n"));
    assert_eq!(
        std::fs::read_dir(lab.0.path()).unwrap().count(),
        before,
        "nothing else is left"
    );

    for (place, why) in [
        ("nowhere/out.json", "there is no directory `nowhere`"),
        ("models", "it is a directory"),
        ("cup.toml/out.json", "`cup.toml` is not a directory"),
    ] {
        let said = lab.ends(1, &plan(&["-o", place]));
        said.says(&["output::unwritable", &format!("can't write `{place}`: {why}")]);
        assert_eq!(said.out, "");
        lab.ends(1, &["view", "cup.hatp", "cup.toml", "-o", place]).says(&[why]);
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let lab = Lab::new();
    let program = assert_cmd::cargo::cargo_bin("sgap");
    let mut child = std::process::Command::new(program)
        .current_dir(lab.0.path())
        .args(plan(&["--json"]))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
