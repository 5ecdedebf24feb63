//! Pairs of HDDL files: each is imported, planned, validated, and its plan in the competition's format judged by a reader of
//! its own; and files that are damaged in every place are told what is wrong with them, or imported without a fault.
//!
//! A problem `NAME_X.hddl` belongs to the domain `NAME.hddl` beside it. A line `; expect no plan` says that there is none,
//! `; cost 7` what the plan costs, `; actions 3` how many there are.
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]

#[path = "hddl/judge.rs"]
mod judge;
#[expect(dead_code, reason = "other tests use all of it")]
mod planning;

use std::path::Path;

use planning::Case;
use sgap::check::{self, Given};
use sgap::diag::levels::Levels;
use sgap::diag::render;
use sgap::hddl;
use sgap::load::import_pair;
use sgap::source::Sources;
use sgap::syntax;

type Outcome = datatest_stable::Result<()>;

/// Returns the paths of the domain and the problem.
fn pair(problem: &Path) -> (String, String) {
    let name = problem.file_stem().unwrap().to_str().unwrap();
    let domain = problem.with_file_name(format!("{}.hddl", name.rsplit_once('_').unwrap().0));
    let text = |path: &Path| path.to_str().unwrap().replace('\\', "/");
    (text(&domain), text(problem))
}

/// Returns what the problem's comments say of a plan.
fn said<'a>(problem: &'a str, what: &str) -> Option<&'a str> {
    problem.lines().find_map(|l| l.strip_prefix("; ")?.strip_prefix(what))
}

fn planned(path: &Path) -> Outcome {
    let (domain, problem) = pair(path);
    let mut sources = Sources::default();
    let (imported, problems) = import_pair(&domain, &problem, &mut sources, &planning::Disk);
    let imported = imported.unwrap_or_else(|| panic!("{}", render::render(&problems, &sources, false)));
    assert!(problems.0.is_empty(), "{}", render::render(&problems, &sources, false));
    let hatp = formatted_and_right(&imported.hatp);
    let planned = planning::plan(&Case {
        world: Some(&problem),
        expansions: 1_000_000,
        ..Case::symbolic(&domain)
    });
    let [domain, problem] = [domain, problem].map(|p| std::fs::read_to_string(p).unwrap());
    let Some(plan) = &planned.plan else {
        assert!(said(&problem, "expect no plan").is_some(), "no plan");
        return Ok(());
    };
    assert!(said(&problem, "expect no plan").is_none(), "a plan");
    let text = hddl::ipc(plan, &imported.names).unwrap();
    let pair = judge::Pair::read(&domain, &problem);
    let judged = judge::judge(&pair, &text).unwrap_or_else(|why| panic!("{why}\n{text}\n{hatp}"));
    assert_eq!(judged.actions, plan.actions.len());
    if let Some(cost) = said(&problem, "cost ") {
        assert_eq!(judged.cost, cost.parse::<f64>()?);
        assert_eq!(plan.cost, judged.cost, "the planner's idea of the cost");
    }
    if let Some(n) = said(&problem, "actions ") {
        assert_eq!(judged.actions, n.parse::<usize>()?, "{text}");
    }
    refuses_damaged_plans(&pair, &text);
    // The large ones would only be long, and `domains` is no place for snapshots.
    if hatp.lines().count() < 180 && !path.starts_with("domains") {
        let folder = std::path::absolute(path.parent().unwrap())?;
        let name = path.file_stem().unwrap().to_str().unwrap();
        insta::with_settings!(
            { snapshot_path => folder, prepend_module_to_snapshot => false, omit_expression => true },
            { insta::assert_snapshot!(name, format!("{hatp}\n{text}")) }
        );
    }
    Ok(())
}

/// An imported text is formatted, and has neither errors nor warnings.
fn formatted_and_right(hatp: &str) -> String {
    let mut sources = Sources::default();
    let file = sources.add("imported.hatp", hatp);
    let text = syntax::format(file, hatp).unwrap_or_else(|p| panic!("{}\n{hatp}", render::render(&p, &sources, false)));
    let mut sources = Sources::default();
    let file = sources.add("imported.hatp", text.clone());
    let (ast, mut problems) = syntax::parse(file, &text);
    problems.extend(check::compile(&[ast], &Given::default()).1);
    let problems = Levels::default().apply(problems, &sources);
    assert!(
        problems.0.is_empty(),
        "{}\n{text}",
        render::render(&problems, &sources, false)
    );
    text
}

/// The judge can say no: without one of its lines a plan is none.
fn refuses_damaged_plans(pair: &judge::Pair, text: &str) {
    let lines: Vec<&str> = text.lines().collect();
    for at in 1..lines.len().min(40) - 1 {
        if lines[at].starts_with("root") {
            continue;
        }
        let mut without = lines.clone();
        without.remove(at);
        let damaged = without.join("\n") + "\n";
        assert!(judge::judge(pair, &damaged).is_err(), "without line {at}:\n{damaged}");
    }
}

/// Words that stand where they should not.
const WORDS: [&str; 8] = ["(", ")", "?x", "-", ":init", "and", "not", "object"];

/// Whatever is left out or put in, the import ends, and what it accepts is right.
fn damaged(path: &Path) -> Outcome {
    let (domain, problem) = pair(path);
    let texts = [&domain, &problem].map(|p| std::fs::read_to_string(p).unwrap());
    for (which, text) in texts.iter().enumerate() {
        let tokens = tokens(text);
        // As many places as take a second or two.
        let step = (tokens.len() / 60).max(1);
        for (n, (start, end)) in tokens.iter().copied().enumerate().step_by(step) {
            let word = WORDS[(n / step) % WORDS.len()];
            let (head, tail) = (&text[..start], &text[end..]);
            let other = tokens[(n * 7 + 3) % tokens.len()];
            let other = &text[other.0..other.1];
            for damaged in [
                head.to_owned(),
                format!("{head}{tail}"),
                format!("{head} {word} {tail}"),
                format!("{head} {other} {tail}"),
                format!("{head} {word} {}", &text[start..]),
            ] {
                let mut texts = texts.clone();
                texts[which] = damaged;
                import_text(&texts);
            }
        }
    }
    Ok(())
}

fn tokens(text: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices() {
        let is_mark = matches!(c, '(' | ')');
        if (is_mark || c.is_whitespace())
            && let Some(start) = start.take()
        {
            found.push((start, at));
        }
        if is_mark {
            found.push((at, at + 1));
        } else if !c.is_whitespace() && start.is_none() {
            start = Some(at);
        }
    }
    found
}

fn import_text(texts: &[String; 2]) {
    let mut sources = Sources::default();
    let domain = sources.add("domain.hddl", texts[0].clone());
    let problem = sources.add("problem.hddl", texts[1].clone());
    let (imported, problems) = hddl::import(domain, problem, &sources);
    assert_eq!(imported.is_none(), problems.has_errors(), "{problems:?}");
    for label in problems.0.iter().filter_map(|p| p.primary.as_ref()) {
        let text = &sources.get(label.span.file).text;
        assert!(text.get(label.span.range()).is_some(), "{label:?}");
    }
    let Some(imported) = imported else { return };
    let mut sources = Sources::default();
    let file = sources.add("imported.hatp", imported.hatp.clone());
    let (ast, mut problems) = syntax::parse(file, &imported.hatp);
    problems.extend(check::compile(&[ast], &Given::default()).1);
    let problems = Levels::default().apply(problems, &sources);
    assert!(
        problems.0.is_empty(),
        "{}\n{}\n{}\n{}",
        render::render(&problems, &sources, false),
        texts[0],
        texts[1],
        imported.hatp
    );
}

datatest_stable::harness! {
    { test = planned, root = "tests/hddl", pattern = r"_[^/]*\.hddl$" },
    { test = planned, root = "domains", pattern = r"_[^/]*\.hddl$" },
    { test = damaged, root = "tests/hddl", pattern = r"_1\.hddl$" },
    { test = damaged, root = "domains", pattern = r"_1\.hddl$" },
}
