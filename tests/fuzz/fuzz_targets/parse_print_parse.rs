//! What can be read can be formatted; that changes neither what it says nor, the second time, anything at all.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sgap::source::FileId;
use sgap::syntax;

/// What a file says, without places.
fn content(ast: &syntax::ast::File) -> String {
    let text = format!("{ast:?}");
    let mut parts = text.split("Span {");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |out, part| out + part.split_once('}').map_or("", |(_, rest)| rest))
}

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let (ast, problems) = syntax::parse(FileId(0), text);
    let Ok(formatted) = syntax::format(FileId(0), text) else {
        assert!(problems.has_errors());
        return;
    };
    let (again, problems) = syntax::parse(FileId(0), &formatted);
    assert!(!problems.has_errors(), "{problems:?}");
    assert_eq!(content(&ast), content(&again));
    assert_eq!(syntax::format(FileId(0), &formatted).as_ref(), Ok(&formatted));
});
