//! Properties of any text at all: the front end answers, points into the text, and keeps its promises about good files.

use proptest::prelude::*;
use sgap::check::{self, Given};
use sgap::diag::{Problems, render};
use sgap::source::{FileId, Sources};
use sgap::syntax;

const DOMAINS: [&str; 4] = [
    include_str!("../../domains/three_objects.hatp"),
    include_str!("../../domains/prelude.hatp"),
    include_str!("../suite/parse/ok/whole_language.hatp"),
    include_str!("../suite/parse/ok/comments.hatp"),
];

/// Returns the words, marks, comments and gaps of a text, roughly: enough to damage it in a likely way.
fn parts(text: &str) -> Vec<&str> {
    let kind = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' => 0,
        c if c.is_whitespace() => 1,
        _ => 2,
    };
    let mut parts = Vec::new();
    let mut start = 0;
    let mut before = None;
    for (at, c) in text.char_indices() {
        if at > start && (before != Some(kind(c)) || kind(c) == 2) {
            parts.push(&text[start..at]);
            start = at;
        }
        before = Some(kind(c));
    }
    parts.push(&text[start..]);
    parts
}

/// A slip of the pen.
#[derive(Debug, Clone)]
enum Slip {
    Delete(prop::sample::Index),
    Double(prop::sample::Index),
    Swap(prop::sample::Index),
    Insert(prop::sample::Index, String),
}

fn slip() -> impl Strategy<Value = Slip> {
    let index = any::<prop::sample::Index>;
    let inserted = prop_oneof![
        "[{}()\\[\\];,.:=<>!+*/\"-]{1,3}",
        "\\PC{1,3}",
        Just("\0".to_owned()),
        Just("\u{feff}".to_owned()),
        Just("/*".to_owned()),
    ];
    prop_oneof![
        index().prop_map(Slip::Delete),
        index().prop_map(Slip::Double),
        index().prop_map(Slip::Swap),
        (index(), inserted).prop_map(|(at, text)| Slip::Insert(at, text)),
    ]
}

/// A domain that somebody wrote in haste.
fn damaged() -> impl Strategy<Value = String> {
    (0..DOMAINS.len(), prop::collection::vec(slip(), 1..4)).prop_map(|(domain, slips)| {
        let mut parts: Vec<String> = parts(DOMAINS[domain]).into_iter().map(str::to_owned).collect();
        for slip in slips {
            let n = parts.len();
            match slip {
                Slip::Delete(at) => drop(parts.remove(at.index(n))),
                Slip::Double(at) => parts.insert(at.index(n), parts[at.index(n)].clone()),
                Slip::Swap(at) => parts.swap(at.index(n), (at.index(n) + 2) % n),
                Slip::Insert(at, text) => parts.insert(at.index(n), text),
            }
        }
        parts.concat()
    })
}

/// The whole front end on a text: parse, format, check, and what they promise.
pub(super) fn assert_answers(text: &str) -> Result<(), TestCaseError> {
    let mut sources = Sources::default();
    let file = sources.add("domain.hatp", text);
    let (ast, problems) = syntax::parse(file, text);
    assert_placed(&problems, text)?;
    prop_assert!(problems.0.len() < 1000);
    match syntax::format(file, text) {
        Ok(formatted) => {
            prop_assert!(!problems.has_errors());
            prop_assert_eq!(without_places(&syntax::parse(file, &formatted).0), without_places(&ast));
            prop_assert_eq!(syntax::format(file, &formatted).ok(), Some(formatted));
        }
        Err(errors) => prop_assert_eq!(&errors, &problems),
    }
    let is_whole = ast.unread.is_empty();
    prop_assert!(is_whole || problems.has_errors());
    let (domain, found) = check::compile(&[ast], &Given::default());
    assert_placed(&found, text)?;
    // A domain exactly if all is read and nothing is wrong.
    prop_assert_eq!(domain.is_some(), is_whole && !found.has_errors());
    prop_assert!(!render::render_concise(&found, &sources).contains('\0'));
    Ok(())
}

fn assert_placed(problems: &Problems, text: &str) -> Result<(), TestCaseError> {
    for problem in &problems.0 {
        for label in problem.primary.iter().chain(&problem.notes) {
            // Built-in declarations have a file of their own.
            prop_assert!(
                label.span.file != FileId(0) || text.get(label.span.range()).is_some(),
                "{problem:?}"
            );
        }
    }
    Ok(())
}

fn without_places(ast: &syntax::ast::File) -> String {
    let text = format!("{ast:?}");
    let mut parts = text.split("Span {");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |out, part| {
        out + part.split_once('}').map_or("", |(_, rest)| rest)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_domain_is_answered(text in damaged()) {
        assert_answers(&text)?;
    }

    #[test]
    fn any_text_is_answered(text in "\\PC*") {
        assert_answers(&text)?;
    }
}

/// Says how the front end answers a text, and that it does not hang: a machine at work on other things may be ten times
/// as slow as one at rest, a debug build five times as slow as that.
fn answer(text: &str) -> Vec<&'static str> {
    #[expect(
        clippy::disallowed_methods,
        reason = "a text that is not answered in time hangs an editor"
    )]
    let start = std::time::Instant::now();
    let (ast, mut problems) = syntax::parse(FileId(0), text);
    if !problems.has_errors() {
        problems.extend(check::compile(&[ast], &Given::default()).1);
    }
    let most = if cfg!(debug_assertions) { 100.0 } else { 20.0 };
    let took = start.elapsed().as_secs_f64();
    assert!(took < most, "{took} s");
    let mut codes: Vec<&str> = problems.0.iter().map(|p| p.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

#[test]
fn brackets_without_end_are_too_deep() {
    for bracket in ["(", "[", "{", "action A(", "HTN {", "method M() {{"] {
        assert_eq!(answer(&bracket.repeat(100_000)), ["hatp::too-large"], "{bracket}");
    }
    let nested = format!(
        "function number f() {{ {}1{} }}",
        "(".repeat(100_000),
        ")".repeat(100_000)
    );
    assert_eq!(answer(&nested), ["hatp::too-large"]);
    // Side by side they are wrong, not deep.
    for brackets in ["()", "{}", ")", "}", "]", "};"] {
        assert_eq!(answer(&brackets.repeat(100_000)), ["hatp::syntax"], "{brackets}");
    }
    assert_eq!(answer(&"(".repeat(10_000_000)), ["hatp::too-large"]);
    assert_eq!(answer(&"{}".repeat(5_000_000)), ["hatp::too-large"]);
}

#[test]
fn long_texts_are_read_or_refused() {
    let comments = "/**/ ".repeat(1_000_000);
    assert_eq!(
        answer(&format!("factdatabase {{ {comments} define entityType Cup; }}")),
        [""; 0]
    );
    assert_eq!(
        syntax::format(FileId(0), &format!("{comments}\nsettings {{ }}")).map(|t| t.lines().count()),
        Ok(2)
    );
    let name = "x".repeat(5_000_000);
    assert_eq!(
        answer(&format!("factdatabase {{ define entityType {name}; }}")),
        [""; 0]
    );
    assert_eq!(
        answer(&format!("factdatabase {{ define entityType {name} }}")),
        ["hatp::syntax"]
    );
    let string = format!("factdatabase {{ CUP = new Agent; CUP.type = \"{name}\"; }}");
    assert!(!answer(&string).contains(&"hatp::syntax"));
    let database = |items: String| format!("factdatabase {{\n{items}}}");
    let items = database((0..60_000).map(|i| format!("E{i} = new Agent;\n")).collect());
    assert_eq!(answer(&items), [""; 0]);
    // One more mistake than anybody reads.
    let wrong = database((0..60_000).map(|i| format!("E{i} = new ;\n")).collect());
    assert_eq!(answer(&wrong), ["hatp::syntax"]);
    let items = database((0..100_000).map(|i| format!("E{i} = new Agent;\n")).collect());
    assert_eq!(answer(&items), ["hatp::too-large"]);
}

#[test]
fn long_chains_of_declarations_are_answered() {
    const N: usize = 4000;
    let types: String = (1..N)
        .map(|i| format!("define entityType T{i} : T{};\n", i - 1))
        .collect();
    let codes = answer(&format!("factdatabase {{ define entityType T0;\n{types} }}"));
    assert!(codes.iter().all(|c| *c == "hatp::too-large"), "{codes:?}");
    let codes = answer(&format!(
        "factdatabase {{ define entityType T0 : T{};\n{types} }}",
        N - 1
    ));
    assert!(
        !codes.is_empty()
            && codes
                .iter()
                .all(|c| ["hatp::too-large", "hatp::type-cycle"].contains(c)),
        "{codes:?}"
    );
    let methods: String = (0..N)
        .map(|i| format!("method M{i}(Agent A) {{ {{ subtasks {{ M{}(A); }} }} }}\n", i + 1))
        .collect();
    assert_eq!(answer(&format!("{methods} method M{N}(Agent A) {{ {{ }} }}")), [""; 0]);
}

#[test]
fn old_and_odd_files_are_text() {
    let domain = DOMAINS[0];
    let same = |text: &str| {
        let (ast, problems) = syntax::parse(FileId(0), text);
        assert_eq!(problems, Problems::default());
        assert_eq!(
            without_places(&ast),
            without_places(&syntax::parse(FileId(0), domain).0)
        );
        assert_eq!(syntax::format(FileId(0), text).as_deref(), Ok(domain));
    };
    same(&domain.replace('\n', "\r\n"));
    same(&format!("\u{feff}{domain}"));
    same(&format!("{domain}\u{1a}"));
    same(&format!(
        "\u{c}{}",
        domain.replace("  action Pick", "\u{b}\taction Pick")
    ));
    for text in [
        "action A\0(Agent X) { }",
        "\0",
        "action A(Agent X) { } \u{7f}",
        "define entityType Größe;",
    ] {
        assert_eq!(answer(text), ["hatp::syntax"], "{text:?}");
    }
    for text in ["/* \0 é \u{1f916} */ // \u{202e}", "timePart { \u{1f916} é }"] {
        assert!(!answer(text).contains(&"hatp::syntax"), "{text:?}");
    }
    for text in [
        "/*",
        "\"",
        "action A(Agent X) { } /* ",
        "action A(Agent X) { preconditions { X.a == \"b",
        "\"\\",
        "\"\\\"",
    ] {
        assert_eq!(answer(text), ["hatp::syntax"], "{text:?}");
    }
}
