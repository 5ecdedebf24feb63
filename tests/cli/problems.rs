//! In which forms problems are printed, which warnings are given, and what is said about a code or a name.

use super::Lab;

/// A domain with one warning.
const FALL: &str = "factdatabase { define entityType Object; }\naction Fall(Object O) { }\n";

#[test]
fn problems_have_three_forms() {
    let lab = Lab::new();
    lab.write("fall.hatp", FALL);
    let said = lab.ends(0, &["check", "fall.hatp", "--format", "concise"]);
    assert_eq!(
        said.out,
        "fall.hatp:2:8: warning[hatp::no-agent]: no parameter of action `Fall` is an agent \
         (make the first parameter the agent that acts: `Agent A`)\n"
    );
    assert!(said.err.starts_with("no errors"), "{}", said.err);

    let said = lab.ends(0, &["check", "fall.hatp", "--format", "json"]);
    let problem: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(problem["code"], "hatp::no-agent");
    assert_eq!(problem["severity"], "warning");
    assert_eq!((&problem["line"], &problem["column"]), (&2.into(), &8.into()));
    assert_eq!(problem["bytes"], serde_json::json!([50, 54]));
    assert_eq!(problem["end"], serde_json::json!({"line": 2, "column": 12}));

    let said = lab.ends(0, &["check", "fall.hatp"]);
    assert!(
        said.out.is_empty() && said.err.contains("action Fall(Object O)"),
        "{}",
        said.err
    );

    // A plan has the standard output for itself.
    lab.write("broken.hatp", FALL.replace("Object O", "Objct O"));
    let said = lab.ends(1, &["plan", "broken.hatp", "cup.toml", "--format", "concise"]);
    assert!(said.out.is_empty(), "{}", said.out);
    let codes = said
        .err
        .lines()
        .filter(|l| l.starts_with("broken.hatp:2:13: error[hatp::unknown-type]"))
        .count();
    assert_eq!(codes, 1, "{}", said.err);
}

#[test]
fn warnings_are_denied_and_allowed() {
    let lab = Lab::new();
    lab.write("fall.hatp", FALL);
    for deny in ["warnings", "no-agent", "hatp::no-agent"] {
        let said = lab.ends(1, &["check", "fall.hatp", "--deny", deny, "--format", "concise"]);
        assert!(
            said.out.starts_with("fall.hatp:2:8: error[hatp::no-agent]"),
            "{}",
            said.out
        );
        assert!(said.err.is_empty(), "{}", said.err);
    }
    lab.ends(0, &["check", "fall.hatp", "--deny", "unused-variable"]);
    let said = lab.ends(0, &["check", "fall.hatp", "--deny", "warnings", "--allow", "no-agent"]);
    assert!(!said.err.contains("hatp::"), "{}", said.err);
    lab.write("quiet.hatp", FALL.replace("{ }\n", "{ } // sgap: allow(no-agent)\n"));
    lab.ends(0, &["check", "quiet.hatp", "--deny", "warnings"]);

    lab.write(
        "read.hatp",
        format!("{FALL}factdatabase {{ define entityAttributes Object {{ dynamic atom bool old; }} }}"),
    );
    let said = lab.ends(0, &["check", "read.hatp", "--format", "concise"]);
    assert_eq!(said.out.lines().count(), 1, "{}", said.out);
    let said = lab.ends(
        0,
        &["check", "read.hatp", "--format", "concise", "--warn", "never-read"],
    );
    assert!(said.out.contains("warning[hatp::never-read]"), "{}", said.out);

    let domain = format!("{}\naction Fall(Cup O) {{ }}\n", super::DOMAIN);
    lab.write("cup_and_fall.hatp", domain);
    let said = lab.ends(1, &["plan", "cup_and_fall.hatp", "cup.toml", "--deny", "warnings"]);
    assert!(
        said.out.is_empty(),
        "a denied warning ends before the search: {}",
        said.out
    );

    for (name, help) in [
        ("unused-varible", "did you mean `unused-variable`"),
        ("unknown-task", "it is an error"),
    ] {
        let said = lab.ends(2, &["check", "fall.hatp", "--deny", name]);
        assert!(said.err.contains(help), "{}", said.err);
    }
}

#[test]
fn codes_are_explained() {
    let lab = Lab::new();
    let page = include_str!("../../docs/errors/hatp-unknown-setting.md").trim_end();
    for name in ["hatp::unknown-setting", "unknown-setting"] {
        assert_eq!(lab.ends(0, &["explain", name]).out.trim_end(), page);
    }
    // Two rooms know of facts that are not there.
    let both = lab.ends(0, &["explain", "unknown-fact"]).out;
    assert!(
        both.contains("# hatp::unknown-fact") && both.contains("# world::unknown-fact"),
        "{both}"
    );
    let said = lab.ends(1, &["explain", "unknown-tsk"]);
    assert_eq!(
        said.err,
        "error: no problem has the code `unknown-tsk`\nhelp: did you mean `unknown-task`?\n"
    );
    lab.ends(2, &["explain"]);
    let list = lab.ends(0, &["explain", "--list"]).out;
    assert!(
        list.lines().count() > 80 && list.contains("\nurdf::not-xml  "),
        "{list}"
    );
}

#[test]
fn built_ins_and_domains_are_documented() {
    let lab = Lab::new();
    assert_eq!(lab.ends(0, &["doc"]).out, include_str!("../../docs/builtins.md"));
    let said = lab.ends(0, &["doc", "GetGRPCost"]);
    assert_eq!(
        said.out,
        "## Functions\n\n### GetGRPCost\n\n```text\nfunction number GetGRPCost()\n```\n\n\
         The cost that geometry computed for this action; 0 where nothing is projected.\n"
    );
    lab.write("doc.hatp", "/// Falls down,\n/// and stays there.\naction Fall(Agent A) { }\nmethod FallOver(Agent A) { { subtasks { 1: Fall(A); } } }\n");
    assert_eq!(
        lab.ends(0, &["doc", "doc.hatp"]).out,
        "# doc.hatp\n\n## Actions\n\n### Fall\n\n```text\naction Fall(Agent A)\n```\n\nFalls down,\nand stays there.\n\n\
         ## Methods\n\n### FallOver\n\n```text\nmethod FallOver(Agent A)\n```\n"
    );
    assert!(
        lab.ends(0, &["doc", "doc.hatp", "Fall"])
            .out
            .contains("and stays there.")
    );
    let said = lab.ends(1, &["doc", "doc.hatp", "Fal"]);
    assert_eq!(said.err, "error: nothing is called `Fal`\nhelp: did you mean `Fall`?\n");
    let json: serde_json::Value = serde_json::from_str(&lab.ends(0, &["doc", "pick", "--json"]).out).unwrap();
    assert_eq!(json[0]["kind"], "geometric action");
    lab.ends(1, &["doc", "none.hatp"]);
    lab.ends(2, &["doc", "a.hatp", "b.hatp"]);
    lab.ends(2, &["doc", "a", "b"]);
}
