//! `settings { interleave = true; }`: what a domain says of how it wants to be planned.

use super::names::Names;
use super::{problems, social};
use crate::diag::Problems;
use crate::source::Span;
use crate::syntax::ast::{ExprKind, Item};

/// All settings that there are.
const KNOWN: [&str; 2] = ["interleave", "cost"];

/// Fills `names.domain.settings`.
pub(super) fn fill(items: &[&Item], names: &mut Names, problems: &mut Problems) {
    let mut seen: Vec<(&str, Span)> = Vec::new();
    let blocks = items.iter().filter_map(|item| match item {
        Item::Settings(block) => Some(block),
        _ => None,
    });
    for setting in blocks.flat_map(|block| &block.settings) {
        let name = &setting.name;
        if !KNOWN.contains(&name.text.as_str()) {
            let code = "hatp::unknown-setting";
            problems.push(problems::unknown(code, "setting", &name.text, name.span, KNOWN));
            continue;
        }
        if let Some((_, first)) = seen.iter().find(|(n, _)| *n == name.text) {
            problems.push(problems::duplicate("setting", &name.text, name.span, Some(*first)));
            continue;
        }
        seen.push((&name.text, name.span));
        if name.text == "cost" {
            names.domain.settings.cost = social::formula(&setting.value, problems);
            continue;
        }
        match setting.value.kind {
            ExprKind::Bool(on) => names.domain.settings.interleave = on,
            _ => {
                let problem = problems::wrong_type(setting.value.span, "`true` or `false`", "something else");
                problems.push(problem.help(format!("write `{} = true;`", name.text)));
            }
        }
    }
}
