//! The house keeps its own rules: which room uses which, which file uses which crate, how long files get, and an error page for every code.
//!
//! Reads the sources as text. The arrows are those of `docs/architecture.md`, as narrow as they truly are.
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// All of a room, for [`EDGES`].
const ALL: &[&str] = &[];

/// A room that may be used, and the items that may be used of it, or [`ALL`].
type Edge = (&'static str, &'static [&'static str]);

/// What each room may use.
const EDGES: &[(&str, &[Edge])] = &[
    ("source", &[]),
    ("diag", &[("source", ALL)]),
    ("syntax", &[("source", ALL), ("diag", ALL)]),
    ("ir", &[]),
    ("check", &[("source", ALL), ("diag", ALL), ("syntax", ALL), ("ir", ALL)]),
    ("doc", &[("source", ALL), ("syntax", ALL), ("check", &["PRELUDE_TEXT"])]),
    ("geom", &[]),
    (
        "lsp",
        &[
            ("source", ALL),
            ("diag", ALL),
            ("syntax", ALL),
            ("check", ALL),
            ("ir", ALL),
            ("load", &["domain_files"]),
        ],
    ),
    ("world", &[("source", ALL), ("diag", ALL), ("geom", ALL)]),
    ("plan", &[("geom", &["Pose"])]),
    (
        "hddl",
        &[
            ("source", ALL),
            ("diag", ALL),
            ("syntax", &["keywords", "layout"]),
            ("plan", &["Node", "Plan"]),
        ],
    ),
    ("engine", &[("ir", ALL), ("plan", ALL)]),
    (
        "trace",
        &[
            ("engine", &["Ending", "Event", "Observer"]),
            ("ir", &["Domain", "Value"]),
            ("plan", &["Refusal"]),
        ],
    ),
    (
        "grp",
        &[
            (
                "engine",
                &[
                    "Call",
                    "Formula",
                    "GasNum",
                    "GasRef",
                    "Mark",
                    "Projection",
                    "Reasoner",
                    "Request",
                    "Term",
                ],
            ),
            ("ir", ALL),
            ("plan", ALL),
            ("geom", ALL),
            ("world", ALL),
        ],
    ),
    (
        "validate",
        &[
            ("ir", ALL),
            ("plan", ALL),
            (
                "geom",
                &["Pose", "Vec3", "pose_xyz_rpy", "kinematics", "collide", "shape"],
            ),
            ("world", ALL),
        ],
    ),
    (
        "report",
        &[
            ("engine", &["Ending", "FallBackEnd", "Statistics", "Truncated"]),
            ("plan", ALL),
            ("trace", &["Failure", "Group", "Summary", "TaskCounts"]),
            ("geom", &["Pose", "Vec3", "kinematics", "shape"]),
            ("world", ALL),
        ],
    ),
    (
        "planner",
        &[
            ("source", ALL),
            ("diag", ALL),
            ("ir", ALL),
            ("world", &["World"]),
            ("plan", ALL),
            ("load", ALL),
            ("engine", ALL),
            ("grp", ALL),
            ("validate", ALL),
        ],
    ),
    (
        "load",
        &[
            ("source", ALL),
            ("diag", ALL),
            ("syntax", ALL),
            ("check", ALL),
            ("hddl", ALL),
            ("ir", ALL),
            ("world", ALL),
        ],
    ),
];

/// Crates that one place alone uses, and the beginning of that place's path; of several places, with `|` between them.
const CRATES: &[(&str, &str)] = &[
    ("pest", "src/syntax/parser"),
    ("pest_derive", "src/syntax/parser"),
    ("strsim", "src/diag/suggest.rs"),
    ("miette", "src/diag/render"),
    ("parry3d_f64", "src/geom/collide"),
    ("toml", "src/world/"),
    ("urdf_rs", "src/world/urdf"),
    ("roxmltree", "src/world/"),
    ("clap", "src/cli/"),
    ("ctrlc", "src/cli/"),
    ("tempfile", "src/cli/|src/planner/disk.rs"),
    ("lsp_server", "src/lsp/"),
    ("lsp_types", "src/lsp/"),
];

/// No file of `src` has more lines.
const LONGEST: usize = 800;

/// A Rust file of `src`: its path, and its code without comments and without the tests at its end.
struct Source {
    path: String,
    text: String,
    code: String,
}

fn files(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::from(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "nothing in {folder}");
    found
}

fn sources() -> Vec<Source> {
    let rust = files("src")
        .into_iter()
        .filter(|p| p.extension().is_some_and(|e| e == "rs"));
    rust.map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        let path = path.to_str().unwrap().replace('\\', "/");
        let code: Vec<&str> = text
            .lines()
            .map(|line| if line.trim_start().starts_with("//") { "" } else { line })
            .collect();
        let code = code.join("\n");
        // Tests may use more than the room; they are the last item of their file.
        let code = match code.split_once("\n#[cfg(test)]\nmod tests {") {
            Some((before, tests)) => {
                let after = tests.split_once("\n}").map(|(_, after)| after.trim());
                assert_eq!(after, Some(""), "{path}: the tests are not the last item");
                before.to_string()
            }
            None => code,
        };
        Source { path, text, code }
    })
    .collect()
}

/// Returns the byte places right after each whole `word` of `code`.
fn after_word<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = &'a str> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
    code.match_indices(word).filter_map(move |(at, _)| {
        let rest = &code[at + word.len()..];
        let whole = !code[..at].ends_with(is_part) && !rest.starts_with(is_part);
        whole.then_some(rest)
    })
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    &text[..end.unwrap_or(text.len())]
}

/// Returns the first names of what follows a path: of `::a::b` it is `a`, of `::{self, a::{b, c}, d as e}` `self`, `a` and `d`.
fn names(rest: &str) -> Vec<&str> {
    let Some(rest) = rest.strip_prefix("::") else {
        return vec!["self"];
    };
    let Some(list) = rest.strip_prefix('{') else {
        return vec![word(rest)];
    };
    let mut found = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                found.push(word(list[start..at].trim()));
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    found.retain(|name| !name.is_empty());
    found
}

/// Returns the room of a file of the library; `None` for the program's files and `lib.rs`.
fn room(path: &str) -> Option<&str> {
    let room = word(path.strip_prefix("src/")?);
    (!["lib", "main", "cli"].contains(&room)).then_some(room)
}

/// Returns how many modules lie between a file and the root of the crate: 1 for a room itself.
fn depth(path: &str) -> usize {
    let inner = path.trim_start_matches("src/").trim_end_matches(".rs");
    inner.trim_end_matches("/mod").split('/').count()
}

/// Returns what a file of a room uses that it may not.
fn forbidden(path: &str, code: &str) -> Vec<String> {
    let Some(from) = room(path) else { return Vec::new() };
    let Some((_, edges)) = EDGES.iter().find(|(name, _)| *name == from) else {
        return vec![format!("{path}: the room `{from}` has no line in EDGES")];
    };
    let mut wrong = Vec::new();
    for rest in after_word(code, "crate") {
        for to in names(rest) {
            if to == from {
                continue;
            }
            let Some((_, items)) = edges.iter().find(|(name, _)| *name == to) else {
                wrong.push(format!("{path}: `{from}` uses `{to}`"));
                continue;
            };
            let rest = rest.strip_prefix("::").and_then(|r| r.strip_prefix(to));
            // A room with listed items is not imported whole, so that every use names the item.
            let used = rest.map_or(vec!["self"], names);
            for item in used {
                if !items.is_empty() && !items.contains(&item) {
                    wrong.push(format!("{path}: `{from}` uses `{to}::{item}`"));
                }
            }
        }
    }
    let up = vec!["super"; depth(path)].join("::");
    if code.contains(&up) {
        wrong.push(format!("{path}: `{up}` leaves the room"));
    }
    if after_word(code, "sgap").any(|rest| rest.starts_with("::")) {
        wrong.push(format!("{path}: `sgap::` within the library"));
    }
    wrong
}

#[test]
fn rooms_use_what_they_may() {
    let found: Vec<String> = sources().iter().flat_map(|s| forbidden(&s.path, &s.code)).collect();
    assert!(found.is_empty(), "{found:#?}");
}

/// The judge sees what it is to forbid, however it is written.
#[test]
fn forbidden_edges_are_seen() {
    for (path, code) in [
        ("src/geom/ik.rs", "use crate::world::State;"),
        ("src/engine/search.rs", "use crate::{\n    ir,\n    geom::Pose,\n};"),
        ("src/grp/mod.rs", "use crate::engine::{Reasoner, solve};"),
        ("src/grp/mod.rs", "use crate::engine;"),
        ("src/validate/reach.rs", "let x = crate::geom::ik::solve();"),
        ("src/ir/domain.rs", "use super::super::world;"),
        ("src/world/mod.rs", "use super::ir;"),
        ("src/world/urdf/look.rs", "use super::super::super::ir;"),
        ("src/plan/mod.rs", "use sgap::engine;"),
        ("src/newroom/mod.rs", ""),
    ] {
        assert!(!forbidden(path, code).is_empty(), "{path}: {code}");
    }
    for (path, code) in [
        (
            "src/grp/mod.rs",
            "use crate::engine::{\n    Mark,\n    Reasoner as R,\n};",
        ),
        (
            "src/world/urdf/look.rs",
            "use super::super::problems; use crate::{diag::{Problem, Problems}, source};",
        ),
        ("src/cli/plan.rs", "use sgap::engine;"),
    ] {
        assert_eq!(forbidden(path, code), Vec::<String>::new());
    }
}

#[test]
fn a_crate_is_used_in_its_place_alone() {
    let mut used = BTreeSet::new();
    for source in sources() {
        for (name, place) in CRATES {
            if after_word(&source.code, name).any(|rest| rest.starts_with("::")) {
                used.insert(*name);
                assert!(
                    place.split('|').any(|place| source.path.starts_with(place)),
                    "{}: `{name}` belongs to {place}",
                    source.path
                );
            }
        }
    }
    let listed: BTreeSet<&str> = CRATES.iter().map(|(name, _)| *name).collect();
    assert_eq!(used, listed, "a crate of the list is not used");
}

#[test]
fn files_are_short_and_finished() {
    for source in sources() {
        let n = source.text.lines().count();
        assert!(n <= LONGEST, "{} has {n} lines: split it", source.path);
        for stub in ["todo!", "unimplemented!"] {
            assert!(!source.code.contains(stub), "{}: {stub}", source.path);
        }
    }
}

/// The problem codes in the sources, each with a file that says it.
fn codes() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for source in sources() {
        for text in source.code.split('"') {
            let Some((room, name)) = text.split_once("::") else {
                continue;
            };
            let is_name =
                !name.is_empty() && !name.ends_with('-') && name.chars().all(|c| c.is_ascii_lowercase() || c == '-');
            let rooms = [
                "hatp", "hddl", "world", "urdf", "srdf", "mesh", "plan", "output", "trace",
            ];
            if rooms.contains(&room) && is_name {
                found.insert(text.to_string(), source.path.clone());
            }
        }
    }
    found
}

#[test]
fn every_code_has_its_page_and_every_page_its_code() {
    let codes = codes();
    let page = |code: &str| format!("docs/errors/{}.md", code.replace("::", "-"));
    for (code, path) in &codes {
        let page = page(code);
        let text = std::fs::read_to_string(&page).unwrap_or_default();
        assert!(
            text.starts_with(&format!("# {code}\n")),
            "{path}: `{code}` has no page {page}"
        );
        let n_examples = text.matches("\n```").count() / 2;
        assert!(
            text.contains("\nRight:") && n_examples > 0,
            "{page} shows no right example"
        );
    }
    let known: BTreeSet<String> = codes.keys().map(|code| page(code)).collect();
    for path in files("docs/errors") {
        let path = path.to_str().unwrap().replace('\\', "/");
        if path.ends_with("/README.md") {
            continue;
        }
        assert!(known.contains(&path), "{path}: no source has this code");
    }
}

/// No file knows the machine on which it was written.
#[test]
fn no_file_names_a_folder_of_a_machine() {
    let words = ["work", "tmp", "root", "home"].map(|folder| format!("/{folder}/"));
    let mut paths = ["src", "docs", "tests", "domains", "worlds", "grammar", "benches"]
        .map(files)
        .concat();
    paths.push(PathBuf::from("Cargo.toml"));
    paths.retain(|path| path != Path::new("tests/tidy.rs"));
    for path in paths {
        // Pictures and packed scripts are no text.
        let Ok(text) = std::fs::read_to_string(&path) else {
            continue;
        };
        for word in &words {
            assert!(!text.contains(word), "{} names `{word}`", path.display());
        }
    }
}

/// Says whether a word is built of two capitalized words or more, as Rust's types are.
fn is_camel(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_uppercase())
        && word.chars().filter(char::is_ascii_uppercase).count() > 1
        && word.chars().any(|c| c.is_ascii_lowercase())
}

/// The types that the sources declare, as far as no user could have a name like theirs: `ExprKind`, not `Task`.
fn types() -> BTreeSet<String> {
    let mut found: BTreeSet<String> = [
        "HashMap", "BTreeMap", "PathBuf", "Vec", "usize", "isize", "f64", "u32", "i64", "u64",
    ]
    .map(str::to_owned)
    .into();
    for source in sources() {
        for keyword in ["struct", "enum", "trait"] {
            let names = after_word(&source.code, keyword).map(|rest| word(rest.trim_start()));
            found.extend(names.filter(|name| is_camel(name)).map(str::to_owned));
        }
    }
    found
}

/// The grammar's names of rules that are no words of the language: `kw_goal`, `compat_null`.
fn rules() -> BTreeSet<String> {
    let grammar = std::fs::read_to_string("grammar/hatp.pest").unwrap();
    let names = grammar
        .lines()
        .filter_map(|line| line.split_once(" = "))
        .map(|(name, _)| name);
    let of_rule = |name: &&str| name.contains('_') && !name.contains(' ');
    names.filter(of_rule).map(str::to_owned).collect()
}

/// A message as a report shows it: its headline, and its help line, each without its line ends.
fn messages(report: &str) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    let mut in_head = false;
    let mut in_help = false;
    for line in report.lines() {
        let head = line.strip_prefix("  × ").or_else(|| line.strip_prefix("  ⚠ "));
        if let Some(head) = head {
            found.push((head.into(), String::new()));
            (in_head, in_help) = (true, false);
        } else if let (true, Some(more), Some(last)) = (in_head, line.strip_prefix("  │ "), found.last_mut()) {
            last.0 = format!("{} {}", last.0, more.trim());
        } else if let (Some(help), Some(last)) = (line.strip_prefix("  help: "), found.last_mut()) {
            last.1 = help.into();
            (in_head, in_help) = (false, true);
        } else if let (true, true, Some(last)) = (in_help, line.starts_with("        "), found.last_mut()) {
            last.1 = format!("{} {}", last.1, line.trim());
        } else {
            (in_head, in_help) = (false, false);
        }
    }
    found
}

/// Every message that a case shows is worded for its reader: lower case, no final period, and nothing of our own insides.
#[test]
fn messages_are_worded_for_users() {
    let (types, rules) = (types(), rules());
    assert!(
        types.contains("ExprKind") && rules.iter().any(|r| r.starts_with("kw_")),
        "{types:?} {rules:?}"
    );
    let mut n = 0;
    for path in files("tests/suite") {
        if path.extension().is_none_or(|e| e != "snap") || !path.components().any(|c| c.as_os_str() == "bad") {
            continue;
        }
        let shown = path.display();
        for (head, help) in messages(&std::fs::read_to_string(&path).unwrap()) {
            n += 1;
            let first = head.chars().next();
            // A headline may begin with a name of the user's or with a word of the language as it is.
            let begins =
                first.is_some_and(|c| !c.is_uppercase()) || head.starts_with("SELECT") || head.starts_with("URDF");
            assert!(begins, "{shown}: begins with a capital: {head}");
            for text in [&head, &help] {
                assert!(
                    !text.ends_with('.') || text.ends_with("..."),
                    "{shown}: ends with a period: {text}"
                );
                let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                let ours: Vec<&str> = words.filter(|w| types.contains(*w) || rules.contains(*w)).collect();
                assert!(ours.is_empty(), "{shown}: {ours:?} is no word of the user's: {text}");
                assert_eq!(text.matches('`').count() % 2, 0, "{shown}: a backtick is open: {text}");
            }
            // It stands alone: what is wrong with what, not a pointer to the lines below.
            for pointer in ["here", "this line", "below", "above:"] {
                let ends = head.ends_with(&format!(" {pointer}"));
                assert!(
                    !ends || head.contains('`') || head.len() > 20,
                    "{shown}: says nothing alone: {head}"
                );
            }
        }
    }
    assert!(n > 100, "{n} messages");
}
