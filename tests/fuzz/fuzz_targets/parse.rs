//! Any bytes are answered, and every problem points into the text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sgap::source::FileId;
use sgap::syntax;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let (_, problems) = syntax::parse(FileId(0), text);
    for problem in &problems.0 {
        for label in problem.primary.iter().chain(&problem.notes) {
            assert!(text.get(label.span.range()).is_some(), "{problem:?}");
        }
    }
    let _ = syntax::parse_network(FileId(0), 0, text);
});
