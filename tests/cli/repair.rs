//! Task networks on the command line, and plans that begin with an earlier one.

use std::path::Path;

use super::{Lab, PLAN, plan};

const LAMPS: &str = "
factdatabase {
  define entityType Lamp;
  define entityAttributes Lamp { dynamic atom bool on; }
  ANN = new Agent; BOB = new Agent; DESK = new Lamp; HALL = new Lamp;
}
action Switch(Agent A, Lamp L) { preconditions { L.on != true; }; effects { L.on = true; }; duration { (1, 2) }; }
action See(Agent A, Lamp L) { preconditions { L.on == true; }; }
method Light(Agent A) { { subtasks { 1: Switch(A, DESK); 2: Switch(A, HALL); }; } }
";

/// A folder with the lamps and a plan of `Light(ANN)`: the desk, then the hall.
fn lamps() -> Lab {
    let lab = Lab::new();
    lab.write("lamps.hatp", LAMPS);
    lab.ends(0, &lit(&["--json", "-o", "plan.json"]));
    lab
}

fn lit<'a>(options: &[&'a str]) -> Vec<&'a str> {
    [&["plan", "lamps.hatp", "--task", "Light(ANN)"], options].concat()
}

fn read(lab: &Lab, name: &str) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(lab.path(name)).unwrap()).unwrap()
}

#[test]
fn a_task_network_is_planned_shown_and_validated() {
    let lab = lamps();
    let task = "hall: Switch(ANN, HALL); See(ANN, DESK) > lit; lit: Switch(BOB, DESK);";
    let shown = "Switch(ANN, HALL); See(ANN, DESK) > 3; Switch(BOB, DESK)";
    let said = lab.ends(0, &["plan", "lamps.hatp", "--task", task]);
    assert!(
        said.out.starts_with(&format!("plan of {shown}\n3 actions")),
        "{}",
        said.out
    );
    lab.ends(0, &["plan", "lamps.hatp", "--task", task, "--json", "-o", "net.json"]);
    let document = read(&lab, "net.json");
    assert_eq!(document["task"], shown);
    assert_eq!(document["decomposition"][0]["task"], shown);
    lab.ends(0, &["validate", "lamps.hatp", "net.json", "--task", task]);
    lab.ends(0, &["validate", "lamps.hatp", "net.json", "--task", shown]);
    // The same tasks in another order are another goal.
    for other in ["Light(ANN)", "Switch(ANN, HALL); See(ANN, DESK); Switch(BOB, DESK)"] {
        let said = lab.ends(20, &["validate", "lamps.hatp", "net.json", "--task", other]);
        said.says(&[&format!("task: the plan is for `{shown}`, the goal is `{other}`")]);
    }
    // A document that tells another order, or a plan that does not keep it.
    let text = std::fs::read_to_string(lab.path("net.json")).unwrap();
    let damaged = text.replacen("See(ANN, DESK) > 3", "See(ANN, DESK) > 1", 1);
    lab.write("damaged.json", damaged);
    lab.ends(20, &["validate", "lamps.hatp", "damaged.json", "--task", task])
        .says(&["task: the plan is for"]);
    lab.write(
        "damaged.json",
        text.replacen("See(ANN, DESK) > 3", "See(ANN, DESK) > 4", 1),
    );
    lab.ends(20, &["validate", "lamps.hatp", "damaged.json", "--task", task])
        .says(&["argument: `See(ANN, DESK) > 4` is not a task that comes after some of the tasks 1 to 3"]);
    let late = "Switch(ANN, HALL) > 3; See(ANN, DESK) > 3; Switch(BOB, DESK)";
    lab.write("damaged.json", text.replace(shown, late));
    lab.ends(20, &["validate", "lamps.hatp", "damaged.json", "--task", late])
        .says(&["subtasks: no choice of the variables of decomposition 0"]);
    lab.ends(0, &["view", "lamps.hatp", "--task", task, "-o", "page.html"]);
    assert!(
        std::fs::read_to_string(lab.path("page.html"))
            .unwrap()
            .contains("See(ANN, DESK) > 3")
    );
}

#[test]
fn the_first_actions_of_a_plan_are_kept() {
    let lab = lamps();
    let text = std::fs::read_to_string(lab.path("plan.json")).unwrap();
    for n in ["0", "1", "2"] {
        let said = lab.ends(0, &lit(&["--from", "plan.json", "--after", n, "--json"]));
        assert_eq!(said.out, text, "{n}");
    }
    // Another task, into which the first action fits: the rest is another one.
    let task = "Switch(BOB, HALL); Switch(ANN, DESK); See(ANN, HALL) > 1";
    let other = [
        "plan",
        "lamps.hatp",
        "--task",
        task,
        "--from",
        "plan.json",
        "--after",
        "1",
    ];
    let said = lab.ends(0, &[&other[..], &["--json", "-o", "new.json"]].concat());
    assert_eq!(said.err, "");
    let (old, new) = (read(&lab, "plan.json"), read(&lab, "new.json"));
    assert_eq!(new["actions"][0], old["actions"][0]);
    assert_eq!(new["actions"][1]["arguments"][0], "BOB");
    lab.ends(0, &["validate", "lamps.hatp", "new.json", "--task", task]);
    // One into which it does not.
    let said = lab.ends(
        10,
        &[
            "plan",
            "lamps.hatp",
            "--task",
            "Light(BOB)",
            "--from",
            "plan.json",
            "--after",
            "1",
        ],
    );
    said.says(&["Switch(BOB, DESK) is not the next kept action, 0 Switch(ANN, DESK)"]);
}

#[test]
fn what_can_not_be_kept_is_told_and_nothing_is_written() {
    let lab = lamps();
    let refuses = |code: i32, arguments: &[&str], parts: &[&str]| {
        lab.write("out.json", "old");
        let said = lab.ends(code, &[arguments, &["-o", "out.json"]].concat());
        said.says(parts);
        assert_eq!(said.out, "");
        assert_eq!(std::fs::read(lab.path("out.json")).unwrap(), b"old");
    };
    let from = |name: &'static str, n: &'static str| lit(&["--from", name, "--after", n]);
    refuses(
        1,
        &from("plan.json", "3"),
        &[
            "plan::too-short",
            "`--after 3`: the plan `plan.json` has 2 actions",
            "from 0 to 2",
        ],
    );
    refuses(2, &lit(&["--from", "plan.json"]), &["--after <N>"]);
    refuses(2, &lit(&["--after", "1"]), &["--from <PLAN>"]);
    refuses(
        1,
        &from("missing.json", "1"),
        &["plan::unreadable", "there is no such file"],
    );
    let text = std::fs::read_to_string(lab.path("plan.json")).unwrap();
    lab.write("half.json", &text[..text.len() / 2]);
    refuses(1, &from("half.json", "1"), &["plan::unreadable"]);
    lab.write("other.json", text.replace("Switch", "Paint"));
    let first = "can't keep the first 1 action of `other.json`: action 0 `Paint(ANN, DESK)`, ";
    refuses(
        20,
        &from("other.json", "1"),
        &[first, "unknown-name: there is no task `Paint`"],
    );
    lab.write("other.json", text.replace("DESK", "ANN"));
    refuses(
        20,
        &from("other.json", "1"),
        &["argument: `ANN` is not an entity of type `Lamp`"],
    );
    // The domain has changed under the plan.
    lab.write("lamps.hatp", LAMPS.replace("L.on != true;", "L.on == false;"));
    let why = "can't keep the first 2 actions of `plan.json`: action 0, Switch(ANN, DESK): DESK.on == false is false (DESK.on is NULL)";
    refuses(20, &from("plan.json", "2"), &[why]);
}

/// The motions are those of the earlier plan, wherever the cup goes afterwards.
#[test]
fn motions_are_kept_and_must_fit_into_the_world() {
    let lab = Lab::new();
    lab.ends(0, &plan(&["--json", "-o", "plan.json"]));
    let repair = ["--from", "plan.json", "--after", "1"];
    lab.ends(
        0,
        &[&PLAN[..], &repair, &["--seed", "5", "--json", "-o", "new.json"]].concat(),
    );
    let (old, new) = (read(&lab, "plan.json"), read(&lab, "new.json"));
    assert_eq!(new["seed"], 5);
    assert_eq!(new["actions"][0].to_string(), old["actions"][0].to_string());
    assert_ne!(new["actions"][1]["geometry"], old["actions"][1]["geometry"]);
    assert_ne!(
        new["actions"][1]["geometry"]["gas"],
        old["actions"][0]["geometry"]["gas"]
    );
    lab.ends(0, &["validate", "cup.hatp", "cup.toml", "new.json"]);
    // The cup stands elsewhere, or there is no world to move in.
    lab.world_with("moved.toml", "at = [-0.1, -0.2]", "at = [-0.1, -0.18]");
    lab.write("out.json", "old");
    let moved = ["plan", "cup.hatp", "moved.toml", "--json", "-o", "out.json"];
    lab.ends(20, &[&moved[..], &repair].concat())
        .says(&["can't keep the first 1 action of `plan.json`: action 0 `Take(PR2, CUP)`, sub-action "]);
    let other_hand = std::fs::read_to_string(lab.path("plan.json")).unwrap();
    lab.write(
        "plan.json",
        other_hand.replace("\"action\": \"pick\"", "\"action\": \"place\""),
    );
    lab.ends(20, &[&moved[..], &repair].concat())
        .says(&["geometry-mismatch"]);
    assert_eq!(std::fs::read(lab.path("out.json")).unwrap(), b"old");
}

/// Three things are to be brought: the first one is brought as before, the rest is planned with other random numbers.
#[test]
fn three_objects_are_repaired_after_two_actions() {
    let lab = Lab::new();
    let [domain, world] = ["domains/three_objects.hatp", "worlds/three_objects.toml"].map(|path| {
        std::path::absolute(Path::new(path))
            .unwrap()
            .to_str()
            .unwrap()
            .to_owned()
    });
    lab.ends(0, &["plan", &domain, &world, "--json", "-o", "plan.json"]);
    let repair = [
        "--from",
        "plan.json",
        "--after",
        "2",
        "--seed",
        "3",
        "--json",
        "-o",
        "new.json",
    ];
    lab.ends(0, &[&["plan", domain.as_str(), &world], &repair[..]].concat());
    let (old, new) = (read(&lab, "plan.json"), read(&lab, "new.json"));
    for i in 0..2 {
        assert_eq!(
            new["actions"][i].to_string(),
            old["actions"][i].to_string(),
            "action {i}"
        );
    }
    assert_ne!(new["actions"][2]["geometry"], old["actions"][2]["geometry"]);
    lab.ends(0, &["validate", &domain, &world, "new.json"]);
}
