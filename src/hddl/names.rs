//! From names of HDDL to names of HATP and back.
//!
//! What is no letter, digit or `_` becomes `_`; a name that is then a word of the language, or taken, gets a number. The
//! way back is a table, so that a plan can be told in the names of the files.

use indexmap::{IndexMap, IndexSet};

use crate::syntax::keywords;

/// Gives each name once.
#[derive(Debug, Default)]
pub(super) struct Namer {
    used: IndexSet<String>,
}

impl Namer {
    /// Returns a name that is free here and that `taken` does not know.
    pub fn fresh(&mut self, hddl: &str, taken: &dyn Fn(&str) -> bool) -> String {
        let plain = identifier(hddl);
        let is_free = |name: &str, used: &IndexSet<String>| !used.contains(name) && !taken(name) && !is_word(name);
        let mut name = plain.clone();
        let mut n = 2;
        while !is_free(&name, &self.used) {
            name = format!("{plain}_{n}");
            n += 1;
        }
        self.used.insert(name.clone());
        name
    }

    /// Says whether a name was given.
    pub fn has(&self, name: &str) -> bool {
        self.used.contains(name)
    }
}

/// Returns the name with `_` for what HATP has not in names.
pub(super) fn plain(hddl: &str) -> String {
    let letters = hddl.trim_start_matches('?').chars();
    letters
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect()
}

/// Returns the name as an identifier.
fn identifier(hddl: &str) -> String {
    let plain = plain(hddl);
    match plain.chars().next() {
        Some(c) if c.is_ascii_alphabetic() || c == '_' => plain,
        _ => format!("n{plain}"),
    }
}

/// Says whether the language has a meaning of its own for the name.
fn is_word(name: &str) -> bool {
    name == "null" || name == "Null" || keywords().iter().any(|k| k.word == name)
}

/// What the names of an imported pair are in its files, by their names in HATP.
#[derive(Debug, Clone, Default)]
pub struct Names {
    pub(super) objects: IndexMap<String, String>,
    pub(super) actions: IndexMap<String, String>,
    pub(super) tasks: IndexMap<String, TaskName>,
    /// The methods that stand for the problem and for its goal: no part of the files.
    pub(super) problem: String,
    /// Methods around a subtask (`late`): no part of the files either.
    pub(super) late: IndexSet<String>,
    pub(super) goal: Option<String>,
    /// Tasks of the initial network, in the order of the file.
    pub(super) start: Vec<String>,
}

#[derive(Debug, Clone)]
pub(super) struct TaskName {
    pub name: String,
    /// One for each decomposition.
    pub methods: Vec<MethodName>,
}

#[derive(Debug, Clone)]
pub(super) struct MethodName {
    pub name: String,
    /// Its subtasks in HATP, in the order of the file.
    pub subtasks: Vec<String>,
}

impl Names {
    /// Returns the task that stands for the problem, as `--task` takes it.
    pub fn task(&self) -> String {
        format!("{}()", self.problem)
    }
}
