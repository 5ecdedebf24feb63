//! One test for each file dropped in a folder below `tests/suite`; the snapshot lands beside its input.
//!
//! `ok` has no problems and `bad` has one, judged before any snapshot is compared. Write snapshots with
//! `INSTA_UPDATE=always cargo test --test suite`, and read them.
//!
//! A `plan` case is a TOML file: `domain`, `expect` ("plan" or "no plan") and optionally `world`, `task`, `seed`, `branching`,
//! `best`, `plan` (the actions: `["Pick(PR2, CUP)"]`), `actions` (their number), `cost`, `at_least_alternatives`. Without a
//! `world` the symbols alone are planned. Every plan found is accepted by the validator before its snapshot is compared.
//!
//! A `check` case may begin with lines that stand for a world file:
//! `//# entity CUP Object`, `//# agent PR2 [TYPE]`, `//# shared Object.isOn isOn`, `//# value CUP.weight 0.3`
//! (words apart from the first two are an array after `[`), and `//# goal Pick(PR2, CUP)`; `//# warn never-read` asks for a
//! warning that is off by default.

mod planning;

use std::fmt::Write;
use std::path::Path;

use planning::Case;
use sgap::check::{self, Given, GivenEntity, GivenLiteral, GivenValue};
use sgap::diag::levels::{Level, Levels, warnings_called};
use sgap::diag::{Problems, render};
use sgap::engine::Ending;
use sgap::load::{Paths, check_domain};
use sgap::report::text;
use sgap::source::{FileId, Sources, Span};
use sgap::{ir, syntax};

type Outcome = datatest_stable::Result<()>;

/// Compares `text` with the snapshot beside `path`.
fn snapshot(path: &Path, text: &str) -> Outcome {
    let folder = std::path::absolute(path.parent().ok_or("a case lies in a folder")?)?;
    let name = path.file_stem().and_then(|n| n.to_str()).ok_or("a case has a name")?;
    insta::with_settings!(
        { snapshot_path => folder, prepend_module_to_snapshot => false, omit_expression => true },
        { insta::assert_snapshot!(name, text) }
    );
    Ok(())
}

/// Reads a case under its bare file name, so that no snapshot depends on where the project lies.
fn read(path: &Path) -> datatest_stable::Result<(Sources, FileId, String)> {
    let text = std::fs::read_to_string(path)?;
    let name = path.file_name().and_then(|n| n.to_str()).ok_or("a case has a name")?;
    let mut sources = Sources::default();
    let file = sources.add(name, text.clone());
    Ok((sources, file, text))
}

fn show(problems: &Problems, sources: &Sources) -> String {
    render::render(problems, sources, false)
}

/// What the file says, without places.
fn content(ast: &syntax::ast::File) -> String {
    let text = format!("{ast:?}");
    let mut parts = text.split("Span {");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |out, part| {
        // A span has a file of its own, in one more pair of parentheses.
        out + part.split_once('}').map_or("", |(_, rest)| rest)
    })
}

/// Formatting changes neither what a file says nor its comments, and nothing the second time.
fn parse_ok(path: &Path) -> Outcome {
    let (sources, file, text) = read(path)?;
    let (ast, problems) = syntax::parse(file, &text);
    assert!(problems.0.is_empty(), "{}", show(&problems, &sources));
    let formatted = syntax::format(file, &text).expect("a file without errors");
    let (again, problems) = syntax::parse(file, &formatted);
    assert!(
        problems.0.is_empty(),
        "formatted text parses: {problems:?}\n{formatted}"
    );
    assert_eq!(content(&ast), content(&again), "the same content\n{formatted}");
    assert_eq!(
        syntax::format(file, &formatted).expect("no errors"),
        formatted,
        "stable"
    );
    snapshot(path, &formatted)
}

fn parse_bad(path: &Path) -> Outcome {
    let (sources, file, text) = read(path)?;
    let (_, problems) = syntax::parse(file, &text);
    assert!(problems.has_errors(), "no problem found");
    snapshot(path, &show(&problems, &sources))
}

fn check_ok(path: &Path) -> Outcome {
    let (sources, file, text) = read(path)?;
    let (domain, problems) = compile(file, &text, &sources);
    assert!(problems.0.is_empty(), "{}", show(&problems, &sources));
    snapshot(path, &ir::dump(&domain.ok_or("no problem, so a domain")?))
}

fn check_bad(path: &Path) -> Outcome {
    let (sources, file, text) = read(path)?;
    let (_, problems) = compile(file, &text, &sources);
    assert!(!problems.0.is_empty(), "no problem found");
    snapshot(path, &show(&problems, &sources))
}

/// Reads and checks a domain of several files, as the program does.
fn load_domain(path: &Path) -> datatest_stable::Result<(Option<ir::Domain>, String, bool)> {
    let mut sources = Sources::default();
    let name = path.to_str().ok_or("a case has a name")?.replace('\\', "/");
    let paths = sgap::load::Paths {
        domain: &name,
        ..Default::default()
    };
    let (domain, problems) = sgap::load::check_domain(&paths, &mut sources, &planning::Disk);
    Ok((
        domain,
        show(&problems.clone().sorted(), &sources),
        problems.0.is_empty(),
    ))
}

fn load_ok(path: &Path) -> Outcome {
    let (domain, shown, is_right) = load_domain(path)?;
    assert!(is_right, "{shown}");
    snapshot(path, &ir::dump(&domain.ok_or("no problem, so a domain")?))
}

fn load_bad(path: &Path) -> Outcome {
    let (_, shown, is_right) = load_domain(path)?;
    assert!(!is_right, "no problem found");
    snapshot(path, &shown)
}

/// Compiles the case with the world that its first lines describe.
fn compile(file: FileId, text: &str, sources: &Sources) -> (Option<ir::Domain>, Problems) {
    let (ast, mut problems) = syntax::parse(file, text);
    assert!(
        !problems.0.iter().any(|p| p.code == "hatp::syntax"),
        "a check case parses: {problems:?}"
    );
    let (given, goal, levels) = header(file, text);
    let (mut domain, faults) = check::compile(&[ast], &given);
    problems.extend(faults);
    if let (Some(domain), Some((goal, at))) = (&mut domain, goal) {
        let (goal, faults) = check::parse_goal(&goal, file, at, domain);
        assert_eq!(goal.is_none(), faults.has_errors());
        problems.extend(faults);
    }
    (domain, levels.apply(problems, sources))
}

/// Returns the world of the `//#` lines, the goal with its place, and which warnings are asked for.
fn header(file: FileId, text: &str) -> (Given, Option<(String, usize)>, Levels) {
    let mut given = Given::default();
    let mut levels = Levels::default();
    let mut goal = None;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let Some(rest) = line.trim_end().strip_prefix("//# ") else {
            continue;
        };
        let (kind, rest) = rest.split_once(' ').expect("a header line has two words or more");
        let begin = start + 5 + kind.len();
        let span = Span::new(file, begin, begin + rest.len());
        let words: Vec<&str> = rest.split([' ', ',', '[', ']']).filter(|w| !w.is_empty()).collect();
        match kind {
            "entity" | "agent" => given.entities.push(GivenEntity {
                name: words[0].into(),
                ty: words.get(1).map(|w| (*w).into()),
                is_agent: kind == "agent",
                span,
            }),
            "shared" => given.shared.push((words[0].into(), words[1].into(), span)),
            "value" => {
                let (entity, attribute) = words[0].split_once('.').expect("ENTITY.attribute");
                given.values.push(GivenValue {
                    entity: entity.into(),
                    attribute: attribute.into(),
                    values: words[1..].iter().map(|w| literal(w)).collect(),
                    is_list: rest.contains('['),
                    is_implied: false,
                    span,
                });
            }
            "goal" => {
                let tasks = syntax::parse_network(file, begin, rest).0.unwrap_or_default();
                given.tasks = tasks.into_iter().map(|t| t.call.name.text).collect();
                goal = Some((rest.to_owned(), begin));
            }
            "warn" => levels.of.extend(
                warnings_called(rest)
                    .expect("a warning")
                    .into_iter()
                    .map(|code| (code, Level::Warn)),
            ),
            other => panic!("unknown header `{other}`"),
        }
    }
    (given, goal, levels)
}

fn literal(word: &str) -> GivenLiteral {
    match (word, word.parse()) {
        ("true" | "false", _) => GivenLiteral::Bool(word == "true"),
        (_, Ok(x)) => GivenLiteral::Number(x),
        _ => GivenLiteral::Text(word.into()),
    }
}

/// A domain in HDDL and, behind a line `;;; problem`, a problem.
fn import(text: &str) -> (Sources, bool, Problems) {
    let (domain, problem) = text.split_once(";;; problem\n").unwrap_or((text, ""));
    let mut sources = Sources::default();
    let files = [("domain.hddl", domain), ("problem.hddl", problem)].map(|(path, text)| sources.add(path, text));
    let (imported, problems) = sgap::hddl::import(files[0], files[1], &sources);
    (sources, imported.is_some(), problems)
}

fn hddl_bad(path: &Path) -> Outcome {
    let (sources, is_imported, problems) = import(&std::fs::read_to_string(path)?);
    assert!(!problems.0.is_empty() && is_imported != problems.has_errors());
    snapshot(path, &show(&problems, &sources))
}

/// What the examples of HDDL's error pages leave out.
const HDDL_CONTEXT: [(&str, &str); 6] = [
    (":types", "truck place"),
    (":predicates", "(at ?t - truck ?p - place) (road ?a ?b - place)"),
    (":domain", "transport"),
    (":objects", "t1 - truck a b - place"),
    (":init", "(at t1 a)"),
    (":htn", ":ordered-subtasks (go t1 b)"),
];

/// The wrong example of an error page of HDDL has its problem alone; the right one has none.
fn hddl_page(path: &Path) -> Outcome {
    let text = std::fs::read_to_string(path)?;
    let name = path.file_stem().and_then(|n| n.to_str()).ok_or("a page has a name")?;
    let code = name.replacen('-', "::", 1);
    for block in text.split("```hddl").skip(1) {
        let (kind, rest) = block.split_once('\n').ok_or("a block has lines")?;
        let example = rest.split("```").next().unwrap_or_default();
        let begins = |section: &str| example.lines().any(|l| l.starts_with(&format!("({section} ")));
        let is_of_problem = |line: &&str| {
            [":domain", ":objects", ":init", ":htn", ":goal"]
                .iter()
                .any(|s| line.starts_with(&format!("({s} ")))
        };
        let (of_problem, of_domain): (Vec<&str>, Vec<&str>) = example.lines().partition(is_of_problem);
        let given: Vec<String> = HDDL_CONTEXT
            .iter()
            .map(
                |(section, text)| match begins(section) || code == "hddl::no-task" && *section == ":htn" {
                    true => String::new(),
                    false => format!("({section} {text})"),
                },
            )
            .collect();
        let all = format!(
            "(define (domain transport) {} {}
               (:task go :parameters (?t - truck ?p - place))
               (:action drive :parameters (?t - truck ?a ?b - place) :precondition (at ?t ?a)
                 :effect (and (not (at ?t ?a)) (at ?t ?b)))
               {})\n;;; problem\n(define (problem p) {} {})",
            given[0],
            given[1],
            of_domain.join("\n"),
            given[2..].join(" "),
            of_problem.join("\n"),
        );
        let (sources, _, problems) = import(&all);
        let shown = show(&problems, &sources);
        let is_alone = !problems.0.is_empty() && problems.0.iter().all(|p| p.code == code);
        assert_eq!(is_alone, kind == ",wrong", "{code}\n{all}\n{shown}");
        assert!(is_alone || problems.0.is_empty(), "{shown}");
    }
    Ok(())
}

/// Every code that a room's source names has its page, and a case whose snapshot shows it.
fn documented(path: &Path) -> Outcome {
    let text = std::fs::read_to_string(path)?;
    let mut cases = String::new();
    for folder in ["tests/suite/parse/bad", "tests/suite/check/bad", "tests/suite/hddl/bad"] {
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?.path();
            if entry.extension().is_some_and(|e| e == "snap") {
                cases += &std::fs::read_to_string(entry)?;
            }
        }
    }
    for code in text
        .split('"')
        .filter(|part| (part.starts_with("hatp::") || part.starts_with("hddl::")) && !part.contains(['<', ' ']))
    {
        // Codes of the renderer's own tests.
        if code == "hatp::x" {
            continue;
        }
        let page = format!("docs/errors/{}.md", code.replace("::", "-"));
        assert!(Path::new(&page).exists(), "`{code}` has no page {page}");
        let shown = cases.lines().any(|line| line == code);
        assert!(shown, "`{code}` has no case below tests/suite");
    }
    Ok(())
}

/// What the examples of the error pages use without declaring it.
const CONTEXT: &str = "
factdatabase {
  define entityType Object;
  define entityType Cup : Object;
  define entityType Table;
  define entityAttributes Agent { static atom string type; dynamic atom Object hasInHand; }
  define entityAttributes Object { dynamic atom Table isOn; dynamic set Agent isReachable; dynamic atom number weight; }
  PR2 = new Agent; CUP = new Cup; TABLE = new Table;
}
action Pick(Agent A, Object O) { }
action Give(Agent A, Object O, Agent B) { }
";

/// The wrong example of an error page has the problem that the page tells of; the right one has none at all.
fn page(path: &Path) -> Outcome {
    let text = std::fs::read_to_string(path)?;
    let name = path.file_stem().and_then(|n| n.to_str()).ok_or("a page has a name")?;
    let code = name.replacen('-', "::", 1);
    assert!(text.starts_with(&format!("# {code}\n")), "the title is the code");
    // A warning that is off is asked for by its page.
    let asked = warnings_called(&code).unwrap_or_default();
    let levels = Levels {
        of: asked.into_iter().map(|code| (code, Level::Warn)).collect(),
        deny_all: false,
    };
    let problems_of = |example: &str| {
        let mut sources = Sources::default();
        let all = format!("{example}\n{CONTEXT}");
        let file = sources.add("example.hatp", all.clone());
        let (ast, mut problems) = syntax::parse(file, &all);
        problems.extend(check::compile(&[ast], &Given::default()).1);
        let mut problems = levels.apply(problems, &sources);
        // What the example leaves unused of its context is not its fault.
        let is_of_example = |span: Span| span.range().start < example.len();
        problems
            .0
            .retain(|p| p.primary.as_ref().is_none_or(|l| is_of_example(l.span)));
        (show(&problems, &sources), problems)
    };
    let mut n_right = 0;
    for block in text.split("```hatp").skip(1) {
        let (kind, rest) = block.split_once('\n').ok_or("a block has lines")?;
        let example = rest.split("```").next().unwrap_or_default();
        let (shown, problems) = problems_of(example);
        if kind == ",wrong" {
            assert!(
                problems.0.iter().any(|p| p.code == code),
                "no {code} in\n{example}\n{shown}"
            );
        } else {
            n_right += 1;
            assert!(problems.0.is_empty(), "{shown}");
        }
    }
    assert_eq!(n_right, 1, "a page has one right example");
    Ok(())
}

/// The domains that come with the program are formatted, and compile, without a world as far as they name no entity of one.
fn domains(path: &Path) -> Outcome {
    let (mut sources, file, text) = read(path)?;
    let (_, mut problems) = syntax::parse(file, &text);
    // What others import need not be whole.
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
    if name != "prelude.hatp" && !name.ends_with("_common.hatp") {
        // With the files that belong to it.
        let paths = Paths {
            domain: path.to_str().ok_or("a path is text")?,
            with: &[],
            world: None,
            task: None,
        };
        sources = Sources::default();
        problems = check_domain(&paths, &mut sources, &planning::Disk).1;
    }
    let problems = Levels::default().apply(problems, &sources);
    assert!(problems.0.is_empty(), "{}", show(&problems, &sources));
    assert_eq!(syntax::format(file, &text).expect("no errors"), text, "run `sgap fmt`");
    Ok(())
}

/// What a plan case says: input, settings, and what must come out whatever the snapshot says.
struct Expected {
    table: toml::Table,
}

impl Expected {
    fn text(&self, key: &str) -> Option<&str> {
        self.table.get(key).and_then(toml::Value::as_str)
    }

    fn number(&self, key: &str) -> Option<u64> {
        self.table
            .get(key)
            .and_then(toml::Value::as_integer)
            .and_then(|n| u64::try_from(n).ok())
    }
}

const PLAN_KEYS: [&str; 11] = [
    "domain",
    "world",
    "task",
    "seed",
    "branching",
    "best",
    "expect",
    "plan",
    "actions",
    "cost",
    "at_least_alternatives",
];

/// Plans twice with the same bytes; what is expected holds; the snapshot is the plan, or why there is none.
fn plan(path: &Path) -> Outcome {
    let expected = Expected {
        table: std::fs::read_to_string(path)?.parse()?,
    };
    if let Some(key) = expected.table.keys().find(|k| !PLAN_KEYS.contains(&k.as_str())) {
        panic!("a plan case has no key `{key}`");
    }
    let domain = expected.text("domain").ok_or("a case names its domain")?;
    let defaults = match expected.text("world") {
        Some(world) => Case::new(domain, world),
        None => Case::symbolic(domain),
    };
    let case = Case {
        task: expected.text("task"),
        seed: expected.number("seed").unwrap_or(defaults.seed),
        branching: expected
            .number("branching")
            .map_or(Ok(defaults.branching), u32::try_from)?,
        best: expected
            .table
            .get("best")
            .and_then(toml::Value::as_bool)
            .unwrap_or(defaults.best),
        ..defaults
    };
    let (planned, again) = (planning::plan(&case), planning::plan(&case));
    assert_eq!(planned.json, again.json, "same input, same seed, same bytes");
    let outcome = &planned.outcome;
    let mut shown = String::new();
    match (expected.text("expect"), &planned.plan) {
        (Some("plan"), Some(plan)) => {
            if let Some(actions) = expected.table.get("plan").and_then(toml::Value::as_array) {
                let wanted: Vec<&str> = actions.iter().filter_map(toml::Value::as_str).collect();
                let found = plan.actions.iter();
                let found: Vec<String> = found
                    .map(|a| format!("{}({})", a.name, a.arguments.join(", ")))
                    .collect();
                assert_eq!(found, wanted, "the actions");
            }
            if let Some(cost) = expected.table.get("cost") {
                let cost = cost.as_float().or_else(|| cost.as_integer().map(|c| c as f64));
                assert!(
                    (plan.cost - cost.ok_or("a cost is a number")?).abs() < 1e-9,
                    "cost {}",
                    plan.cost
                );
            }
            if let Some(n) = expected.number("actions") {
                assert_eq!(plan.actions.len() as u64, n, "actions");
            }
            shown.push_str(&text::plan(plan));
            shown.push_str("\nlinks\n");
            for link in &plan.links {
                writeln!(
                    shown,
                    "  {} -> {}  {}",
                    link.before,
                    link.after,
                    serde_json::to_string(&link.reasons)?
                )?;
            }
            shown.push_str("\nchanges\n");
            for action in &plan.actions {
                for (slot, value) in action.changes.iter() {
                    writeln!(shown, "  {}  {slot} = {value}", action.index)?;
                }
            }
        }
        (Some("no plan"), None) => {
            assert!(!matches!(outcome.ending, Ending::FirstPlan), "an ending without a plan");
            shown.push_str(&text::no_plan(outcome.ending, &outcome.statistics, &outcome.why_not));
        }
        (expect, plan) => panic!("expected {expect:?}, found a plan: {}", plan.is_some()),
    }
    if let Some(n) = expected.number("at_least_alternatives") {
        assert!(
            outcome.statistics.alternatives >= n,
            "{} alternatives",
            outcome.statistics.alternatives
        );
    }
    let counts = &outcome.statistics;
    writeln!(
        shown,
        "\nsearch\n  {} expansions, {} backtracks, {} actions computed, {} alternatives",
        counts.expansions, counts.backtracks, counts.projections, counts.alternatives
    )?;
    snapshot(path, &shown)
}

datatest_stable::harness! {
    { test = parse_ok, root = "tests/suite/parse/ok", pattern = r"\.hatp$" },
    { test = parse_bad, root = "tests/suite/parse/bad", pattern = r"\.hatp$" },
    { test = check_ok, root = "tests/suite/check/ok", pattern = r"\.hatp$" },
    { test = check_bad, root = "tests/suite/check/bad", pattern = r"\.hatp$" },
    { test = load_ok, root = "tests/suite/load/ok", pattern = r"^[^/]*\.hatp$" },
    { test = load_bad, root = "tests/suite/load/bad", pattern = r"^[^/]*\.hatp$" },
    { test = documented, root = "src/syntax", pattern = r"\.rs$" },
    { test = documented, root = "src/check", pattern = r"\.rs$" },
    { test = page, root = "docs/errors", pattern = r"hatp-[^/]*\.md$" },
    { test = hddl_bad, root = "tests/suite/hddl/bad", pattern = r"\.hddl$" },
    { test = documented, root = "src/hddl", pattern = r"\.rs$" },
    { test = hddl_page, root = "docs/errors", pattern = r"hddl-[^/]*\.md$" },
    { test = domains, root = "domains", pattern = r"\.hatp$" },
    { test = plan, root = "tests/suite/plan", pattern = r"\.toml$" },
}
