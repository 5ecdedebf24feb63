//! The front end on a long domain. `cargo bench --bench language`.
//!
//! The domain is `domains/ramification.hatp` with its actions and methods again and again under other names, 10,000 lines
//! in all.

use divan::Bencher;
use divan::counter::BytesCount;
use sgap::check::{self, Given};
use sgap::source::FileId;
use sgap::syntax;

fn main() {
    divan::main();
}

const DOMAIN: &str = include_str!("../domains/ramification.hatp");

/// Lines of the long domain.
const N_LINES: usize = 10_000;

/// Returns the domain with copies of its tasks, each copy under names of its own.
fn long_domain() -> String {
    let (database, tasks) = DOMAIN.split_once("HTN {\n").expect("the domain has tasks");
    let tasks = tasks.trim_end().trim_end_matches('}');
    let mut text = format!("{database}HTN {{\n");
    let mut n_lines = text.lines().count();
    for copy in 0.. {
        if n_lines >= N_LINES {
            break;
        }
        let mut renamed = tasks.to_owned();
        // The longest name first: none is a part of another that is still to come.
        for name in ["MoveObjs", "MoveObj", "MoveRest", "TestGoal", "PlaceR", "Pick"] {
            renamed = renamed.replace(&format!("{name}("), &format!("{name}{copy}("));
        }
        n_lines += renamed.lines().count();
        text.push_str(&renamed);
    }
    text.push_str("}\n");
    text
}

#[divan::bench]
fn parse(bencher: Bencher<'_, '_>) {
    let text = long_domain();
    bencher
        .counter(BytesCount::of_str(&text))
        .bench(|| syntax::parse(FileId(0), &text));
}

/// Text to the compiled domain: what `sgap check` does after reading the file.
#[divan::bench]
fn parse_check_lower(bencher: Bencher<'_, '_>) {
    let text = long_domain();
    bencher.counter(BytesCount::of_str(&text)).bench(|| {
        let (ast, problems) = syntax::parse(FileId(0), &text);
        assert!(problems.0.is_empty(), "{problems:?}");
        let (domain, problems) = check::compile(&[ast], &Given::default());
        assert!(!problems.has_errors(), "{problems:?}");
        domain
    });
}
