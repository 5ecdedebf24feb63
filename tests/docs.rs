//! The documentation is true: its examples compile or fail as they say, its grammar is the whole grammar, its commands
//! print what it shows, and its links lead somewhere.
//!
//! Reads README.md and all pages below `docs`, except the error pages, which `tests/suite.rs` judges, and builtins.md, which
//! `sgap doc` writes. A fenced block says by its first line what it is:
//!
//! | first line | what the block is |
//! |---|---|
//! | `hatp` | items of a file, together with the declarations of `docs/reference/README.md` |
//! | `hatp context` | those declarations |
//! | `hatp whole` | a file of its own |
//! | `hatp facts`, `tests`, `effects`, `clauses`, `decompositions`, `subtasks` | what stands in braces of that kind |
//! | `hatp goal` | a task to plan, as `--task` takes it |
//! | .. `error=CODE` `warning=CODE` | has errors or warnings of these codes, and of no others |
//! | .. `file=NAME` | a file of the page's folder; with `add=BLOCK` it goes before that block's closing brace, with `replace=WORD:NAME` it takes the place of that item |
//! | `toml file=NAME` | as above |
//! | `console` | commands after `$ `, run in the page's folder, and what they print |
//! | `pest` | rules of `grammar/hatp.pest` |
//!
//! `UPDATE_DOCS=1 cargo test --test docs` writes what commands print into the pages; read it.
#![expect(clippy::unwrap_used, reason = "a test says by a panic what is wrong")]

#[path = "docs/blocks.rs"]
mod blocks;
#[path = "docs/console.rs"]
mod console;
#[path = "docs/summary.rs"]
mod summary;

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use blocks::{Block, blocks};
use sgap::check::{self, Given};
use sgap::diag::levels::Levels;
use sgap::diag::{Problems, Severity, render};
use sgap::source::Sources;
use sgap::syntax;

/// Warnings that speak of a whole domain or method, which an example is not, or that are off by default.
const OF_WHOLE_DOMAINS: [&str; 5] = [
    "hatp::unreached-task",
    "hatp::unused-parameter",
    "hatp::never-read",
    "hatp::never-set",
    "hatp::select-follows",
];

/// Parameters that an example may use without declaring them.
const PARAMETERS: &str = "Agent A, Agent B, Object O, Cup C, Place P, Table T, set Object Os, number x";

/// Returns README.md and the pages below `docs`, sorted, without those that others judge.
fn pages() -> Vec<PathBuf> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && path != Path::new("docs/errors") {
                walk(&path, out);
            } else if path.extension().is_some_and(|e| e == "md") && path != Path::new("docs/builtins.md") {
                out.push(path);
            }
        }
    }
    let mut out = vec![PathBuf::from("README.md")];
    walk(Path::new("docs"), &mut out);
    out.sort();
    out
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Returns the declarations that examples share.
fn context() -> String {
    let page = read(Path::new("docs/reference/README.md"));
    let all = blocks(&page);
    let mut found = all.iter().filter(|b| b.language == "hatp" && b.has("context"));
    let first = found.next().expect("docs/reference/README.md has the context");
    assert!(found.next().is_none(), "one context");
    first.text.to_owned()
}

/// Returns the block as a whole file, and where in it the block stands [bytes].
fn whole(block: &Block<'_>, context: &str) -> (String, Range<usize>) {
    let (before, after) = match block.kind {
        "" => (String::new(), ""),
        "context" | "whole" => return (block.text.to_owned(), 0..block.text.len()),
        "facts" => ("factdatabase {".into(), "}"),
        "tests" => (format!("action Example({PARAMETERS}) {{ preconditions {{"), "} }"),
        "effects" => (format!("action Example({PARAMETERS}) {{ effects {{"), "} }"),
        "clauses" => (format!("action Example({PARAMETERS}) {{"), "}"),
        "decompositions" => (format!("method Example({PARAMETERS}) {{"), "}"),
        "subtasks" => (format!("method Example({PARAMETERS}) {{ {{ subtasks {{"), "} } }"),
        other => panic!("a block of HATP has no kind `{other}`"),
    };
    let start = before.len() + 1;
    let text = format!("{before}\n{}\n{after}\n{context}", block.text);
    (text, start..start + block.text.len())
}

/// Returns what is wrong with a file, at the levels of the command line.
fn problems_of(text: &str, sources: &mut Sources) -> Problems {
    let file = sources.add("example.hatp", text.to_owned());
    let (ast, mut problems) = syntax::parse(file, text);
    problems.extend(check::compile(&[ast], &Given::default()).1);
    Levels::default().apply(problems, sources)
}

/// Returns what is wrong with a task to plan in the context.
fn problems_of_goal(task: &str, context: &str, sources: &mut Sources) -> Problems {
    let file = sources.add("context.hatp", context.to_owned());
    let (ast, _) = syntax::parse(file, context);
    let mut domain = check::compile(&[ast], &Given::default())
        .0
        .expect("the context compiles");
    let file = sources.add("--task", task.to_owned());
    check::parse_goal(task.trim_end(), file, 0, &mut domain).1
}

/// Says how a block differs from what it announces.
fn judge(block: &Block<'_>, context: &str) -> Result<(), String> {
    let mut sources = Sources::default();
    let (mut problems, place) = match block.kind {
        "goal" => (problems_of_goal(block.text, context, &mut sources), 0..block.text.len()),
        _ => {
            let (text, place) = whole(block, context);
            (problems_of(&text, &mut sources), place)
        }
    };
    // Warnings about what stands around the example are not its fault.
    problems.0.retain(|p| {
        let is_inside = p.primary.as_ref().is_none_or(|l| place.contains(&l.span.range().start));
        p.severity == Severity::Error || is_inside && !OF_WHOLE_DOMAINS.contains(&p.code)
    });
    let codes = |severity: Severity| -> BTreeSet<&str> {
        let found = problems.0.iter().filter(|p| p.severity == severity);
        found.map(|p| p.code).collect()
    };
    let wanted = |key: &str| block.values(key).collect::<BTreeSet<&str>>();
    if codes(Severity::Error) == wanted("error") && codes(Severity::Warning) == wanted("warning") {
        return Ok(());
    }
    let shown = render::render(&problems, &sources, false);
    let announced = [wanted("error"), wanted("warning")];
    Err(format!("announced {announced:?}, found\n{shown}"))
}

#[test]
fn every_example_compiles_or_fails_as_it_says() {
    let context = context();
    let (mut faults, mut n) = (Vec::new(), 0);
    for page in pages() {
        let text = read(&page);
        // Files that a page builds up are run by its commands.
        let examples = blocks(&text)
            .into_iter()
            .filter(|b| b.language == "hatp" && b.value("file").is_none());
        for block in examples {
            n += 1;
            if let Err(fault) = judge(&block, &context) {
                faults.push(format!("{}:{}: {fault}", page.display(), block.line));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(n > 0, "there are examples");
}

/// Returns the rules that pages show, each with its place. A rule begins in the first column.
fn rules_shown() -> Vec<(String, String)> {
    let mut out: Vec<(String, String)> = Vec::new();
    for page in pages() {
        let text = read(&page);
        for block in blocks(&text).iter().filter(|b| b.language == "pest") {
            let first = out.len();
            for line in block.text.lines().filter(|l| !l.trim().is_empty()) {
                if line.starts_with(' ') && out.len() > first {
                    out.last_mut().unwrap().1 += line;
                } else {
                    out.push((format!("{}:{}", page.display(), block.line), line.to_owned()));
                }
            }
        }
    }
    out
}

#[test]
fn the_grammar_shown_is_the_grammar() {
    let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let grammar = one_line(&read(Path::new("grammar/hatp.pest")));
    let mut faults = rules_shown();
    faults.retain(|(_, rule)| !grammar.contains(&one_line(rule)));
    assert!(faults.is_empty(), "not in grammar/hatp.pest: {faults:#?}");
}

#[test]
fn every_rule_of_the_language_has_a_chapter() {
    let grammar = read(Path::new("grammar/hatp.pest"));
    // What comes after are words and marks.
    let (language, _) = grammar.split_once("// ---- The task to plan").unwrap();
    let name = |rule: &str| rule.split_whitespace().next().unwrap_or_default().to_owned();
    let shown: BTreeSet<String> = rules_shown().iter().map(|(_, rule)| name(rule)).collect();
    let rules = language
        .lines()
        .filter(|l| l.starts_with(|c: char| c.is_ascii_lowercase()));
    // Rules for slips of the pen are for messages.
    let missing: Vec<String> = rules
        .map(name)
        .filter(|rule| !rule.starts_with("compat_") && !shown.contains(rule))
        .collect();
    assert!(missing.is_empty(), "no chapter of docs/reference shows {missing:?}");
}

#[test]
fn every_command_prints_what_is_shown() {
    let mut faults = Vec::new();
    for page in pages() {
        faults.extend(console::run(&page, &read(&page)));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}

#[test]
fn every_link_leads_to_a_file() {
    for page in pages() {
        let text = read(&page);
        let outside_blocks: String = text.split("```").step_by(2).collect();
        for target in outside_blocks
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split_once(')'))
        {
            let path = target.0.split('#').next().unwrap_or_default();
            if path.is_empty() || path.contains("://") {
                continue;
            }
            let file = page.parent().unwrap().join(path);
            assert!(file.exists(), "{}: no {path}", page.display());
        }
    }
}
