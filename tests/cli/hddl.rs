//! HDDL on the command line: pairs in the place of a domain and a world.

use super::Lab;

const DOMAIN: &str = include_str!("../../domains/transport.hddl");
const PROBLEM: &str = include_str!("../../domains/transport_1.hddl");

fn lab() -> Lab {
    let lab = Lab::new();
    lab.write("d.hddl", DOMAIN);
    lab.write("p.hddl", PROBLEM);
    lab
}

#[test]
fn a_pair_is_planned_validated_checked_and_imported() {
    let lab = lab();
    let text = lab.ends(0, &["plan", "d.hddl", "p.hddl"]);
    assert!(text.out.contains("plan of Problem()") && text.out.contains("drive(truck_1, harbour, mill)"));
    assert_eq!(text.err, "", "nothing asks geometry, so nothing is granted");
    let ipc = lab.ends(0, &["plan", "d.hddl", "p.hddl", "--format", "ipc"]).out;
    assert!(
        ipc.starts_with("==>\n3 drive truck-1 harbour mill\n") && ipc.ends_with("<==\n"),
        "{ipc}"
    );
    let two = lab
        .ends(0, &["plan", "d.hddl", "p.hddl", "--format=ipc", "--all=2"])
        .out;
    assert_eq!(two.matches("<==\n").count(), 2);
    lab.ends(0, &["check", "d.hddl", "p.hddl"]).says(&["3 actions"]);
    lab.ends(0, &["plan", "d.hddl", "p.hddl", "--json", "-o", "plan.json"]);
    lab.ends(0, &["validate", "d.hddl", "p.hddl", "plan.json"]);
    let plan = std::fs::read_to_string(lab.path("plan.json")).unwrap();
    lab.write("bad.json", plan.replacen("\"mill\"", "\"farm\"", 1));
    lab.ends(20, &["validate", "d.hddl", "p.hddl", "bad.json"]);
    lab.ends(0, &["import", "d.hddl", "p.hddl", "-o", "t.hatp"])
        .says(&["sgap plan t.hatp --task 'Problem()'"]);
    lab.ends(0, &["fmt", "--check", "t.hatp"]);
    let again = lab.ends(0, &["plan", "t.hatp", "--task", "Problem()"]);
    assert_eq!(again.out, text.out);
    lab.ends(0, &["validate", "t.hatp", "plan.json", "--task", "Problem()"]);
    let one = lab.ends(0, &["plan", "d.hddl", "p.hddl", "--task", "get_to(truck_2, mill)"]);
    assert!(one.out.contains("1 action"), "{}", one.out);
}

#[test]
fn half_a_pair_is_told_what_is_missing() {
    let lab = lab();
    for (arguments, says) in [
        (["plan", "d.hddl", "--seed=1"], "its problem is not named"),
        (["plan", "d.hddl", "cup.toml"], "`cup.toml` is no problem in HDDL"),
        (["plan", "cup.hatp", "p.hddl"], "`cup.hatp` is none"),
        (["check", "d.hddl", "--with=cup.hatp"], "takes no further files"),
        (
            ["import", "d.hddl", "no.hddl"],
            "can't read `no.hddl`: there is no such file",
        ),
        (["import", "p.hddl", "d.hddl"], "the domain comes before the problem"),
    ] {
        lab.ends(1, &arguments).says(&[says]);
    }
    lab.write("q.hddl", PROBLEM.replace("(at truck-1 harbour)", "(at truck-1 harbor)"));
    let told = lab.ends(1, &["plan", "d.hddl", "q.hddl", "--format=concise"]);
    told.says(&["q.hddl:", "hddl::unknown-name", "did you mean `harbour`?"]);
}

#[test]
fn the_plan_format_is_for_pairs_and_for_plan() {
    let lab = lab();
    lab.ends(2, &["plan", "cup.hatp", "cup.toml", "--format", "ipc"])
        .says(&["HDDL"]);
    lab.ends(2, &["plan", "d.hddl", "p.hddl", "--format", "ipc", "--json"]);
    lab.ends(2, &["check", "d.hddl", "p.hddl", "--format", "ipc"])
        .says(&["sgap plan"]);
    let other = [
        "plan",
        "d.hddl",
        "p.hddl",
        "--task",
        "get_to(truck_2, mill)",
        "--format",
        "ipc",
    ];
    lab.ends(1, &other).says(&["another task"]);
}
