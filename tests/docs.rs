//! The documentation is true: its examples compile or fail as they say, its grammar is the grammar, its commands print
//! what it shows, and its links lead somewhere.
//!
//! Reads README.md and all pages below `docs`, except the error pages, which `tests/suite.rs` judges. A fenced block says by
//! its first line what it is:
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

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use blocks::{Block, blocks};
use sgap::check::{self, Given};
use sgap::diag::{Problems, Severity, render};
use sgap::source::Sources;
use sgap::syntax;

/// Warnings that speak of a whole domain, which an example is not.
const OF_WHOLE_DOMAINS: [&str; 3] = ["hatp::unreached-task", "hatp::never-read", "hatp::never-set"];

/// Parameters that an example may use without declaring them.
const PARAMETERS: &str = "Agent A, Agent B, Object O, Cup C, Place P, Table T, set Object Os, number x";

/// Returns README.md and the pages below `docs`, sorted, without the error pages.
fn pages() -> Vec<PathBuf> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && path != Path::new("docs/errors") {
                walk(&path, out);
            } else if path.extension().is_some_and(|e| e == "md") {
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

/// Returns the block as a whole file.
fn whole(block: &Block<'_>, context: &str) -> String {
    let text = block.text;
    let part = |before: &str, after: &str| format!("{before}\n{text}\n{after}\n{context}");
    match block.kind {
        "" => part("", ""),
        "context" | "whole" => text.to_owned(),
        "facts" => part("factdatabase {", "}"),
        "tests" => part(&format!("action Example({PARAMETERS}) {{ preconditions {{"), "} }"),
        "effects" => part(&format!("action Example({PARAMETERS}) {{ effects {{"), "} }"),
        "clauses" => part(&format!("action Example({PARAMETERS}) {{"), "}"),
        "decompositions" => part(&format!("method Example({PARAMETERS}) {{"), "}"),
        "subtasks" => part(&format!("method Example({PARAMETERS}) {{ {{ subtasks {{"), "} } }"),
        other => panic!("a block of HATP has no kind `{other}`"),
    }
}

/// Returns what is wrong with a file, also as text.
fn problems_of(text: &str) -> (Problems, String) {
    let mut sources = Sources::default();
    let file = sources.add("example.hatp", text.to_owned());
    let (ast, mut problems) = syntax::parse(file, text);
    problems.extend(check::compile(&[ast], &Given::default()).1);
    let shown = render::render(&problems, &sources, false);
    (problems, shown)
}

/// Returns what is wrong with a task to plan in the context.
fn problems_of_goal(task: &str, context: &str) -> (Problems, String) {
    let mut sources = Sources::default();
    let file = sources.add("context.hatp", context.to_owned());
    let (ast, _) = syntax::parse(file, context);
    let domain = check::compile(&[ast], &Given::default())
        .0
        .expect("the context compiles");
    let file = sources.add("--task", task.to_owned());
    let (_, problems) = check::parse_goal(task.trim_end(), file, 0, &domain);
    let shown = render::render(&problems, &sources, false);
    (problems, shown)
}

/// Says how a block differs from what it announces.
fn judge(block: &Block<'_>, context: &str) -> Result<(), String> {
    let (problems, shown) = match block.kind {
        "goal" => problems_of_goal(block.text, context),
        _ => problems_of(&whole(block, context)),
    };
    let codes = |severity: Severity| -> BTreeSet<&str> {
        let found = problems.0.iter().filter(|p| p.severity == severity).map(|p| p.code);
        found.filter(|code| !OF_WHOLE_DOMAINS.contains(code)).collect()
    };
    let wanted = |key: &str| block.values(key).collect::<BTreeSet<&str>>();
    let (errors, warnings) = (codes(Severity::Error), codes(Severity::Warning));
    if errors == wanted("error") && warnings == wanted("warning") {
        return Ok(());
    }
    Err(format!(
        "announced {:?}, found\n{shown}",
        [wanted("error"), wanted("warning")]
    ))
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

#[test]
fn the_grammar_shown_is_the_grammar() {
    let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let grammar = one_line(&read(Path::new("grammar/hatp.pest")));
    for page in pages() {
        let text = read(&page);
        for block in blocks(&text).iter().filter(|b| b.language == "pest") {
            // A rule begins in the first column.
            let mut rules: Vec<String> = Vec::new();
            for line in block.text.lines().filter(|l| !l.trim().is_empty()) {
                match rules.last_mut() {
                    Some(rule) if line.starts_with(' ') => *rule += line,
                    _ => rules.push(line.to_owned()),
                }
            }
            for rule in rules {
                assert!(
                    grammar.contains(&one_line(&rule)),
                    "{}:{}: not in grammar/hatp.pest: {rule}",
                    page.display(),
                    block.line
                );
            }
        }
    }
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
