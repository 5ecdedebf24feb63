//! The checker answers whatever the parser could read, and compiles exactly what has no error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sgap::check::{self, Given};
use sgap::ir;
use sgap::source::FileId;
use sgap::syntax;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let (ast, _) = syntax::parse(FileId(0), text);
    let is_whole = ast.unread.is_empty();
    let (domain, problems) = check::compile(&[ast], &Given::default());
    assert_eq!(domain.is_some(), is_whole && !problems.has_errors());
    if let Some(domain) = domain {
        let _ = ir::dump(&domain);
    }
});
