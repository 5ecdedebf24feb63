//! An action that nobody does.

use super::Linted;
use crate::diag::{Problem, Problems};

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    for (written, action) in &linted.actions {
        if action.agents.is_empty() {
            let name = &written.name;
            let message = format!("no parameter of action `{}` is an agent", name.text);
            let problem = Problem::warning("hatp::no-agent", message, name.span, "nobody does it");
            problems.push(problem.help("make the first parameter the agent that acts: `Agent A`"));
        }
    }
}
