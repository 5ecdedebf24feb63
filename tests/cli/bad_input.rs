//! Bad input ends at once with a located message and exit code 1, and nothing is written.

use std::time::Duration;

use super::{DOMAIN, Lab, Said, WORLD};

/// Time in which anything is answered, on a busy machine too. HEURISTIC: ten times what 10 MB take.
const AT_ONCE: Duration = Duration::from_secs(10);

/// Size of the files of brackets [bytes].
const HUGE: usize = 10_000_000;

/// Runs a command that must refuse its input with these words, and write nothing.
fn refuses(lab: &Lab, arguments: &[&str], parts: &[&str]) -> Said {
    let mut all = arguments.to_vec();
    if arguments[0] == "plan" {
        all.extend(["-o", "out.json"]);
    }
    lab.write("out.json", "old");
    let said = lab.ends(1, &all);
    said.says(parts);
    assert_eq!(said.out, "");
    assert_eq!(std::fs::read(lab.path("out.json")).unwrap(), b"old", "{arguments:?}");
    assert!(said.took < AT_ONCE, "{arguments:?} took {:?}", said.took);
    assert!(said.err.len() < 20_000, "{arguments:?}: {} bytes", said.err.len());
    said
}

#[test]
fn files_that_are_no_text() {
    let lab = Lab::new();
    std::fs::create_dir(lab.path("folder")).unwrap();
    lab.write("empty", "");
    lab.write("binary", [0x7f, b'E', b'L', b'F', 2, 1, 1, 0, 0xff]);
    lab.write("latin", b"// caf\xe9\n");
    for (name, why) in [
        ("folder", "it is a directory"),
        ("missing", "there is no such file"),
        ("binary", "it is not text: byte 4 is a control character"),
        ("latin", "it is not text: byte 6 is not UTF-8"),
    ] {
        let why = |what: &str| format!("can't read {what}`{name}`: {why}");
        refuses(&lab, &["plan", name, "cup.toml"], &["hatp::unreadable", &why("")]);
        let world = why("the world file ");
        refuses(&lab, &["plan", "cup.hatp", name], &["world::unreadable-file", &world]);
        refuses(&lab, &["facts", name], &[&world]);
        let plan = why("the plan ");
        refuses(
            &lab,
            &["validate", "cup.hatp", "cup.toml", name],
            &["plan::unreadable", &plan],
        );
        // Both at once.
        refuses(&lab, &["plan", name, name], &[&why(""), &world]);
    }
    refuses(
        &lab,
        &["plan", "empty", "cup.toml"],
        &["hatp::empty", "`empty` declares nothing"],
    );
    refuses(&lab, &["check", "empty"], &["`empty` declares nothing"]);
    refuses(&lab, &["plan", "cup.hatp", "empty"], &["`empty` names no task"]);
    refuses(
        &lab,
        &["validate", "cup.hatp", "cup.toml", "empty"],
        &["`empty`: it is empty"],
    );
}

#[test]
fn ten_megabytes_of_brackets() {
    let lab = Lab::new();
    let half = HUGE / 2;
    for (text, in_domain, in_world, in_plan) in [
        ("[".repeat(HUGE), "huge:1:65]", "huge:1:2]", "line 1 column 10000000"),
        ("[]".repeat(half), "huge:1:400001]", "huge:1:2]", "line 1 column 3"),
        (
            "(".repeat(half) + &")".repeat(half),
            "huge:1:65]",
            "huge:1:",
            "line 1 column 1",
        ),
        ("{\n".repeat(half), "huge:65:1]", "huge:1:1]", "line 2 column 1"),
        (
            "a = ".to_owned() + &"[".repeat(HUGE),
            "huge:1:69]",
            "huge:1:",
            "line 1 column 1",
        ),
    ] {
        lab.write("huge", text);
        refuses(&lab, &["plan", "huge", "cup.toml"], &["hatp::too-large", in_domain]);
        refuses(&lab, &["plan", "cup.hatp", "huge"], &["world::not-toml", in_world]);
        refuses(
            &lab,
            &["validate", "cup.hatp", "cup.toml", "huge"],
            &["`huge`: not JSON: ", in_plan],
        );
    }
}

#[test]
fn a_world_with_what_is_not_there() {
    let lab = Lab::new();
    let state = format!("{WORLD}\n[state]\nCUPP.isOn = \"TRAY\"\n");
    lab.write("entity.toml", state);
    let parts = [
        "hatp::unknown-name",
        "unknown entity `CUPP`",
        "entity.toml:26:",
        "did you mean `CUP`?",
    ];
    refuses(&lab, &["plan", "cup.hatp", "entity.toml"], &parts);
    lab.world_with("type.toml", "type = \"Thing\"", "type = \"Ting\"");
    let parts = [
        "hatp::unknown-type",
        "unknown type `Ting` of `CUP`",
        "type.toml:19:",
        "did you mean `Thing`?",
    ];
    refuses(&lab, &["plan", "cup.hatp", "type.toml"], &parts);
    lab.world_with("below.toml", "on = \"SHELF\"\nat = [0,", "on = \"SHEFL\"\nat = [0,");
    let parts = [
        "world::unknown-object",
        "unknown object `SHEFL`",
        "did you mean `SHELF`?",
    ];
    refuses(&lab, &["plan", "cup.hatp", "below.toml"], &parts);

    let urdf = std::fs::read_to_string(lab.path("models/pr2.urdf")).unwrap();
    let joint = "name=\"torso_lift_joint\"";
    assert!(urdf.contains(joint));
    lab.write("models/pr2.urdf", urdf.replace(joint, "name=\"torso_lft_joint\""));
    let parts = [
        "world::unknown-joint",
        "unknown joint `torso_lift_joint`",
        "models/pr2.toml:",
        "did you mean `torso_lft_joint`?",
    ];
    refuses(&lab, &["plan", "cup.hatp", "cup.toml"], &parts);
}

#[test]
fn a_world_that_can_not_be() {
    let lab = Lab::new();
    lab.world_with(
        "inside.toml",
        "on = \"SHELF\"\nat = [-0.1, -0.2]",
        "xyz = [0.65, -0.2, 0.69]",
    );
    let parts = [
        "world::start-in-collision",
        "`CUP` starts in collision: it is 60.0 mm deep in `SHELF`",
        "inside.toml:",
    ];
    refuses(&lab, &["plan", "cup.hatp", "inside.toml"], &parts);

    lab.write(
        "models/stump.urdf",
        "<robot name=\"stump\"><link name=\"base\"/></robot>\n",
    );
    lab.write("models/stump.toml", "urdf = \"stump.urdf\"\n");
    lab.write(
        "no_arms.toml",
        format!("{WORLD}\n[humans.BOB]\nmodel = \"models/stump.toml\"\nbase = {{ x = 3 }}\n"),
    );
    let parts = [
        "world::no-arm",
        "human `BOB` has no arm",
        "no_arms.toml:25:",
        "[arms.right]",
    ];
    refuses(&lab, &["plan", "cup.hatp", "no_arms.toml"], &parts);
}

#[test]
fn a_task_that_does_not_exist() {
    let lab = Lab::new();
    lab.world_with("task.toml", "Bring(CUP, TRAY)", "Brng(CUPP, TRAY)");
    let parts = [
        "unknown task `Brng`",
        "task.toml:1:9",
        "did you mean `Bring`?",
        "`CUPP`",
        "task.toml:1:14",
        "did you mean `CUP`?",
    ];
    refuses(&lab, &["plan", "cup.hatp", "task.toml"], &parts);
    for (task, parts) in [
        (
            "Fly(CUP)",
            ["unknown task `Fly`", "[--task:1:1]", "there are `Bring`, `Take`, `Put`"],
        ),
        (
            "Bring(CUP)",
            [
                "`Bring` takes 2 arguments, found 1",
                "[--task:1:1]",
                "write `Bring(O, S)`",
            ],
        ),
        (
            "Bring(\"CUP\", TRAY)",
            ["found a string", "[--task:1:7]", "write `CUP` without quotes"],
        ),
        (
            "Bring(CUP, PR2)",
            ["expected an entity of type `Furniture`", "[--task:1:12]", "`Agent`"],
        ),
        ("Bring(CUP, TRAY", ["expected `)`", "found the end", "[--task:1:16]"]),
        (
            "",
            ["expected a task with its arguments", "found the end", "[--task:1:1]"],
        ),
    ] {
        refuses(&lab, &["plan", "cup.hatp", "cup.toml", "--task", task], &parts);
    }
}

#[test]
fn all_mistakes_of_both_files_come_at_once() {
    let lab = Lab::new();
    let domain = DOMAIN
        .replace("1: Take(A, O)", "1: Tke(A, O)")
        .replace("pick(A, O)", "pick(A)");
    lab.write(
        "bad.hatp",
        domain + "method Idle() { { preconditions { CUP.isOn == TRAY; }; subtasks { }; } }\n",
    );
    lab.world_with("bad.toml", "radius = 0.03", "raduis = 0.03");
    let parts = [
        "did you mean `radius`?",
        "did you mean `Take`?",
        "`pick` takes 2 arguments, found 1",
    ];
    let said = refuses(&lab, &["plan", "bad.hatp", "bad.toml"], &parts);
    // What the world declares is not missed only because the world is broken.
    assert!(!said.err.contains("unknown variable or entity"), "{}", said.err);
    // Nor are names of a broken line.
    lab.write(
        "line.hatp",
        DOMAIN
            .replace("action Take", "acton Take")
            .replace("pick(A, O)", "pick(A)")
            .replace("O.isOn = S;", "S = O;"),
    );
    let said = refuses(
        &lab,
        &["check", "line.hatp"],
        &["did you mean `action`?", "expected an attribute"],
    );
    assert!(!said.err.contains("unknown task"), "{}", said.err);
}

#[test]
fn the_files_in_the_wrong_order() {
    let lab = Lab::new();
    let parts = ["`cup.toml` is a world file", "`cup.hatp cup.toml`"];
    refuses(&lab, &["plan", "cup.toml", "cup.hatp"], &parts);
}
