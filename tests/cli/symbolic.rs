//! A domain without a world, and domains of several files.

use super::Lab;

const SWITCHES: &str = r#"
factdatabase {
  define entityType Lamp;
  define entityAttributes Lamp { dynamic atom bool on; }
  ANN = new Agent; DESK = new Lamp; HALL = new Lamp;
}
HTN {
  operator Switch(Agent A, Lamp L) { preconditions { L.on != true; }; effects { L.on = true; }; cost { switchFn(A) }; }
  task Light(Agent A) { { subtasks { 1: Switch(A, DESK); 2: Switch(A, HALL)>1; }; } }
}
"#;

#[test]
fn fewer_plans_than_asked_for_have_their_reason() {
    let lab = Lab::new();
    lab.write("lamps.hatp", SWITCHES.replace("switchFn(A)", "2").replace(">1", ""));
    let plans = |n: &str| lab.ends(0, &["plan", "lamps.hatp", "--task", "Light(ANN)", "--all", n]);
    assert_eq!(plans("2").err, "");
    assert_eq!(plans("3").err, "2 plans of the 3 asked for: every choice was tried\n");
}

#[test]
fn a_domain_is_planned_and_validated_without_a_world() {
    let lab = Lab::new();
    lab.write("lamps.hatp", SWITCHES.replace("switchFn(A)", "2"));
    let task = ["--task", "Light(ANN)"];
    let said = lab.ends(0, &["plan", "lamps.hatp", task[0], task[1]]);
    assert!(
        said.out.starts_with("plan of Light(ANN)\n2 actions, cost 4.0000"),
        "{}",
        said.out
    );
    assert_eq!(said.err, "", "nothing projects, so nothing is granted");
    lab.ends(
        0,
        &["plan", "lamps.hatp", task[0], task[1], "--json", "-o", "plan.json"],
    );
    let said = lab.ends(0, &["validate", "lamps.hatp", "plan.json", task[0], task[1]]);
    assert!(said.out.starts_with("valid: 2 actions"), "{}", said.out);
    let plan = std::fs::read_to_string(lab.path("plan.json")).unwrap();
    lab.write("wrong.json", plan.replace("HALL", "DESK"));
    lab.ends(20, &["validate", "lamps.hatp", "wrong.json", task[0], task[1]]);
    lab.ends(0, &["check", "lamps.hatp", task[0], task[1]]);
    lab.ends(1, &["check", "lamps.hatp", task[0], "Lihgt(ANN)"])
        .says(&["did you mean `Light`?"]);
}

#[test]
fn without_a_world_the_task_has_one_place() {
    let lab = Lab::new();
    lab.write("lamps.hatp", SWITCHES.replace("switchFn(A)", "2"));
    for command in ["plan", "view"] {
        let said = lab.ends(1, &[command, "lamps.hatp"]);
        said.says(&[
            "world::no-task",
            "`lamps.hatp` names no task",
            "give `--task 'Task(ARGUMENTS)'`",
        ]);
    }
    lab.ends(1, &["plan", "cup.toml"])
        .says(&["`cup.toml` is a world file, and a domain is wanted first"]);
}

#[test]
fn geometry_without_a_world_is_granted_and_said_so() {
    let lab = Lab::new();
    lab.write(
        "cup.dom",
        super::DOMAIN.replace("A >> O.isReachable;", "") + "factdatabase { PR2 = new Agent; CUP = new Thing; }",
    );
    let said = lab.ends(0, &["plan", "cup.dom", "--task", "Take(PR2, CUP)"]);
    said.says(&["note: without a world file all that asks geometry is taken as granted"]);
}

#[test]
fn functions_stand_beside_the_domain_or_are_named() {
    let lab = Lab::new();
    lab.write("lamps.dom", SWITCHES);
    let plan = ["plan", "lamps.dom", "--task", "Light(ANN)"];
    lab.ends(1, &plan).says(&[
        "unknown function `switchFn`",
        "`function number",
        "switchFn(Agent a1) { 1 }`",
    ]);
    lab.write("costs.hatp", "function number switchFn(Agent A) { 3 }");
    let with = [&plan[..], &["--with", "costs.hatp"]].concat();
    assert!(lab.ends(0, &with).out.contains("cost 6.0000"));
    lab.ends(0, &["check", "lamps.dom", "--with", "costs.hatp"]);
    lab.ends(1, &["check", "lamps.dom", "--with", "none.hatp"])
        .says(&["can't read `none.hatp`"]);
    lab.write("lamps.functions.hatp", "function number switchFn(Agent A) { 5 }");
    assert!(lab.ends(0, &plan).out.contains("cost 10.0000"));
    // Two definitions are one too many.
    lab.ends(1, &with).says(&["function `switchFn` is declared twice"]);
}
