//! Files that are written from others are as they would be written now.
//!
//! `INSTA_UPDATE=always cargo test --test reference` writes them: the index of the error pages, the table that makes the
//! pages part of the program, and the reference of the built-ins. After a new page run it twice: the index is written
//! from the table that the program was built with.
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]

use std::path::Path;

use sgap::diag::levels::{Level, Levels, warnings_called};
use sgap::diag::pages::{self, PAGES, Page};
use sgap::diag::{Problem, Problems, Severity};
use sgap::source::{Sources, Span};

/// Compares a file with what it should hold, or writes it.
fn holds(path: &str, wanted: &str) {
    let found = std::fs::read_to_string(path).unwrap_or_default();
    if found != wanted && std::env::var("INSTA_UPDATE").is_ok_and(|v| v == "always") {
        std::fs::write(path, wanted).unwrap();
        return;
    }
    assert!(
        found == wanted,
        "{path} is out of date: run `INSTA_UPDATE=always cargo test --test reference`"
    );
}

/// Returns the names of the pages in docs/errors, sorted.
fn page_files() -> Vec<String> {
    let entries = std::fs::read_dir("docs/errors").unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter_map(|name| name.strip_suffix(".md").map(str::to_owned))
        .filter(|name| name != "README")
        .collect();
    names.sort();
    assert!(!names.is_empty());
    names
}

#[test]
fn every_page_is_part_of_the_program() {
    const TABLE: &str = "src/diag/pages.rs";
    let text = std::fs::read_to_string(TABLE).unwrap();
    let (before, _) = text.split_once("\npages! {\n").unwrap();
    let lines: String = page_files().iter().map(|name| format!("    \"{name}\"\n")).collect();
    holds(TABLE, &format!("{before}\npages! {{\n{lines}}}\n"));
}

#[test]
fn the_index_lists_every_page() {
    holds("docs/errors/README.md", &pages::index());
}

#[test]
fn the_builtins_are_those_of_the_prelude() {
    let text = format!("{}{}", sgap::doc::TITLE, sgap::doc::markdown(&sgap::doc::builtins()));
    holds("docs/builtins.md", &text);
}

#[test]
fn a_page_is_found_by_its_code_and_by_its_short_name() {
    for page in PAGES {
        assert!(Path::new(&format!("docs/errors/{}.md", page.name)).exists());
        let code = page.code();
        assert!(page.text.starts_with(&format!("# {code}\n")), "{code}");
        assert!(page.summary().ends_with('.'), "{code}: {}", page.summary());
        let (_, short) = code.split_once("::").unwrap();
        assert!(pages::called(short).any(|p| p.name == page.name));
        assert_eq!(pages::called(&code).count(), 1);
    }
    assert_eq!(
        pages::nearest_code("unused-varible").as_deref(),
        Some("unused-variable")
    );
    assert_eq!(
        pages::nearest_code("hatp::unknown-tsk").as_deref(),
        Some("hatp::unknown-task")
    );
}

/// A page says `Warning` if and only if the sources give its code as a warning.
#[test]
fn warnings_are_those_whose_page_says_so() {
    let mut sources = String::new();
    let mut folders = vec![Path::new("src").to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                sources += &std::fs::read_to_string(path).unwrap();
            }
        }
    }
    let given = |page: &Page| {
        let code = format!("\"{}\"", page.code());
        sources.match_indices("Problem::warning(").any(|(at, _)| {
            let rest = sources[at..].trim_start_matches("Problem::warning(").trim_start();
            rest.starts_with(&code)
        })
    };
    for page in PAGES {
        assert_eq!(page.warning().is_some(), given(page), "{}", page.name);
    }
}

/// What is off is off until it is asked for.
#[test]
fn a_warning_that_is_off_is_given_when_asked_for() {
    let mut sources = Sources::default();
    let file = sources.add("a.hatp", "x");
    let problems = || {
        Problems(vec![Problem::warning(
            "hatp::never-read",
            "x",
            Span::new(file, 0, 1),
            "",
        )])
    };
    assert!(Levels::default().apply(problems(), &sources).0.is_empty());
    let denied = Levels {
        of: Vec::new(),
        deny_all: true,
    };
    assert!(denied.apply(problems(), &sources).0.is_empty());
    let asked = Levels {
        of: warnings_called("never-read")
            .unwrap()
            .into_iter()
            .map(|code| (code, Level::Warn))
            .collect(),
        deny_all: true,
    };
    let left = asked.apply(problems(), &sources);
    assert_eq!(left.0.first().map(|p| p.severity), Some(Severity::Warning));
}
