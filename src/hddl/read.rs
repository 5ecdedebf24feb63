//! From lists of words to a domain and a problem whose names are resolved. All problems are found, not the first.

mod actions;
mod formulas;
mod networks;
mod problem;
mod types;

use indexmap::IndexMap;

use super::ast::{Kinds, Name, OBJECT, Pair, Scope, Task, TaskRef, Term, Type, Variable};
use super::problems::{self, Problems};
use super::tree::Tree;
use crate::source::{FileId, Span};

/// What is declared so far, by its name in small letters.
struct Reader<'p> {
    pair: Pair,
    problems: &'p mut Problems,
    types: IndexMap<String, usize>,
    objects: IndexMap<String, usize>,
    predicates: IndexMap<String, usize>,
    functions: IndexMap<String, usize>,
    /// Actions and tasks.
    tasks: IndexMap<String, TaskRef>,
}

/// A part of a `(define ...)`: its keyword, what follows, and its place.
type Section<'a, 't> = (&'a Tree<'t>, &'a [Tree<'t>], Span);

/// Reads both files; `None` if there is nothing to go on with.
pub(super) fn read(
    (domain_file, domain): (FileId, &[Tree<'_>]),
    (problem_file, problem): (FileId, &[Tree<'_>]),
    problems: &mut Problems,
) -> Option<Pair> {
    let domain = definition(domain, "domain", domain_file, problems);
    let problem = definition(problem, "problem", problem_file, problems);
    let ((domain_name, domain), (problem_name, problem)) = (domain?, problem?);
    let mut reader = Reader {
        pair: Pair::default(),
        problems,
        types: IndexMap::new(),
        objects: IndexMap::new(),
        predicates: IndexMap::new(),
        functions: IndexMap::new(),
        tasks: IndexMap::new(),
    };
    reader.pair.domain = domain_name.text.clone();
    reader.pair.problem = problem_name.text.clone();
    reader.declarations(&domain);
    // The objects come before the bodies of actions and methods, which may name them.
    reader.objects(&problem);
    reader.bodies(&domain);
    reader.problem(&problem, &domain_name, problem_name.span);
    Some(reader.pair)
}

/// Returns the name and the sections of `(define (KIND name) ...)`.
fn definition<'a, 't>(
    trees: &'a [Tree<'t>],
    kind: &str,
    file: FileId,
    problems: &mut Problems,
) -> Option<(Name, Vec<Section<'a, 't>>)> {
    let form = format!("`(define ({kind} NAME) ...)`");
    let Some((first, more)) = trees.split_first() else {
        problems.push(problems::expected(&form, Span::new(file, 0, 0)));
        return None;
    };
    for tree in more {
        problems.push(problems::expected("nothing behind the definition", tree.span));
    }
    let parts = match first.headed() {
        Some((head, parts)) if head.is("define") => parts,
        _ => {
            problems.push(problems::expected(&form, first.span));
            return None;
        }
    };
    let Some((title, sections)) = parts.split_first() else {
        problems.push(problems::expected(&form, first.span));
        return None;
    };
    let other = if kind == "domain" { "problem" } else { "domain" };
    let name = match title.headed() {
        Some((head, [name])) if head.is(kind) && name.word().is_some() => name,
        Some((head, _)) if head.is(other) => {
            problems.push(problems::swapped(kind, title.span));
            return None;
        }
        _ => {
            problems.push(problems::expected(&format!("`({kind} NAME)`"), title.span));
            return None;
        }
    };
    let mut found = Vec::new();
    for section in sections {
        match section.headed() {
            Some((head, rest)) => found.push((head, rest, section.span)),
            None => problems.push(problems::expected("a section such as `(:types ...)`", section.span)),
        }
    }
    Some((name_of(name), found))
}

/// Returns a word as a name; an empty one for a list.
fn name_of(tree: &Tree<'_>) -> Name {
    Name {
        text: tree.word().unwrap_or_default().to_owned(),
        span: tree.span,
    }
}

/// Returns the form in which names are compared.
fn key(name: &str) -> String {
    name.to_ascii_lowercase()
}

/// A keyword, where it stands, and what stands behind it.
type Clause<'a, 't> = (&'a str, Span, &'a Tree<'t>);

/// The sections of a domain.
const DOMAIN_SECTIONS: &[&str] = &[
    ":requirements",
    ":types",
    ":constants",
    ":predicates",
    ":functions",
    ":task",
    ":action",
    ":method",
];

/// What follows "`:x` is", by section.
const NOT_SUPPORTED: &[(&str, &str)] = &[
    (":durative-action", "write an action without time"),
    (":derived", "write the condition where it is tested"),
    (":axiom", "write the condition where it is tested"),
    (":constraints", "test the conditions in the actions"),
    (":process", "write an action without time"),
    (":event", "write an action without time"),
];

impl Reader<'_> {
    /// Reads what the bodies of actions and methods refer to, in the order in which one refers to the other.
    fn declarations(&mut self, sections: &[Section<'_, '_>]) {
        self.pair.types.push(Type {
            name: Name {
                text: "object".into(),
                span: Span::new(FileId(0), 0, 0),
            },
            parent: None,
        });
        self.types.insert("object".into(), OBJECT);
        let mut seen: Vec<&str> = Vec::new();
        for (head, _, span) in sections {
            let word = head.word().unwrap_or_default();
            let known = DOMAIN_SECTIONS.iter().find(|s| head.is(s));
            match known {
                Some(section) => {
                    let once = ![":task", ":action", ":method"].contains(section);
                    if once && seen.contains(section) {
                        self.problems.push(problems::twice(&format!("`{section}`"), *span));
                    }
                    seen.push(section);
                }
                None => match NOT_SUPPORTED.iter().find(|(s, _)| head.is(s)) {
                    Some((section, help)) => {
                        let problem = problems::not_supported(&format!("`{section}` is"), head.span, help);
                        self.problems.push(problem);
                    }
                    None => {
                        let known = DOMAIN_SECTIONS.iter().copied();
                        self.problems
                            .push(problems::unknown_part(word, "a domain", head.span, known));
                    }
                },
            }
        }
        // A name is declared before it is used, wherever its section stands.
        for section in [":types", ":constants", ":predicates", ":functions", ":task", ":action"] {
            for (_, rest, span) in sections.iter().filter(|(head, ..)| head.is(section)) {
                match section {
                    ":types" => self.read_types(rest),
                    ":constants" => self.read_objects(rest),
                    ":predicates" => self.read_predicates(rest),
                    ":functions" => self.read_functions(rest),
                    ":task" => self.read_task(rest, *span),
                    _ => self.read_header(rest, *span),
                }
            }
        }
    }

    /// Reads actions and methods.
    fn bodies(&mut self, sections: &[Section<'_, '_>]) {
        let mut next_action = 0;
        for (head, rest, span) in sections {
            if head.is(":action") {
                self.read_action(rest, &mut next_action);
            } else if head.is(":method") {
                self.read_method(rest, *span);
            }
        }
    }

    /// Splits `:keyword value` pairs; what is not known is said.
    fn clauses<'a, 't>(
        &mut self,
        parts: &'a [Tree<'t>],
        of: &str,
        known: &[&'a str],
        unsupported: &[&str],
    ) -> Vec<Clause<'a, 't>> {
        let mut found: Vec<Clause<'a, 't>> = Vec::new();
        let mut rest = parts;
        while let Some((head, more)) = rest.split_first() {
            rest = more;
            let Some(word) = head.word().filter(|w| w.starts_with(':')) else {
                self.problems.push(problems::expected(
                    &format!("a part of {of} such as `{}`", known[0]),
                    head.span,
                ));
                continue;
            };
            if let Some((_, after)) = more.split_first().filter(|(value, _)| value.list().is_some()) {
                rest = after;
            }
            if let Some(part) = unsupported.iter().find(|u| head.is(u)) {
                let problem =
                    problems::not_supported(&format!("`{part}` is"), head.span, "write an action without time");
                self.problems.push(problem);
                continue;
            }
            let Some(part) = known.iter().find(|k| head.is(k)) else {
                self.problems
                    .push(problems::unknown_part(word, of, head.span, known.iter().copied()));
                continue;
            };
            let Some(value) = more.first().filter(|value| value.list().is_some()) else {
                self.problems
                    .push(problems::expected(&format!("a list behind `{part}`"), head.span));
                continue;
            };
            if found.iter().any(|(other, ..)| other == part) {
                self.problems.push(problems::twice(&format!("`{part}`"), head.span));
            }
            found.push((part, head.span, value));
        }
        found
    }

    /// Reads `(t ?a - x ?b - y)`: a name with its parameters.
    fn signature(&mut self, name: &Tree<'_>, params: &[Tree<'_>]) -> (Name, Scope) {
        let mut scope = Scope::default();
        self.variables(params, &mut scope, &mut Vec::new());
        (name_of(name), scope)
    }

    /// Declares a task or an action; says if the name is taken.
    fn declare_task(&mut self, name: &Name, task: TaskRef) {
        if let Some(first) = self.tasks.get(&key(&name.text)) {
            let first = match first {
                TaskRef::Action(a) => self.pair.actions[*a].name.span,
                TaskRef::Task(t) => self.pair.tasks[*t].name.span,
            };
            self.problems
                .push(problems::duplicate("task", &name.text, name.span, first));
        } else {
            self.tasks.insert(key(&name.text), task);
        }
    }

    fn read_task(&mut self, rest: &[Tree<'_>], span: Span) {
        let Some((name, rest)) = rest.split_first().filter(|(name, _)| name.word().is_some()) else {
            self.problems.push(problems::missing("name", "the task", span));
            return;
        };
        let clauses = self.clauses(rest, "a task", &[":parameters", ":precondition", ":effect"], &[]);
        let params = clauses.iter().find(|(part, ..)| *part == ":parameters");
        for (part, place, value) in &clauses {
            if *part != ":parameters" && value.list().is_some_and(|l| !l.is_empty()) {
                let what = format!("`{part}` of a task is");
                self.problems
                    .push(problems::not_supported(&what, *place, "test it in the task's methods"));
            }
        }
        let params = params.and_then(|(.., value)| value.list()).unwrap_or_default();
        let (name, params) = self.signature(name, params);
        self.declare_task(&name, TaskRef::Task(self.pair.tasks.len()));
        self.pair.tasks.push(Task { name, params });
    }

    /// Returns the parameters of an action or a task.
    fn params_of(&self, task: TaskRef) -> &[Variable] {
        match task {
            TaskRef::Action(a) => &self.pair.actions[a].scope.0[..self.pair.actions[a].n_params],
            TaskRef::Task(t) => &self.pair.tasks[t].params.0,
        }
    }

    /// Says if an argument can't be of the type that is wanted: an object is or is not; a variable may be narrowed.
    fn fits(&mut self, term: Term, scope: &Scope, tree: &Tree<'_>, wanted: &Kinds, of: &str) {
        let found = self.pair.kinds_of(term, scope);
        let fits = match term {
            Term::Object(_) => self.pair.is_within(&found, wanted),
            Term::Var(_) => self.pair.overlap(&found, wanted),
        };
        if !fits {
            let (found, wanted) = (self.kinds_text(&found), self.kinds_text(wanted));
            let term = tree.word().unwrap_or_default();
            self.problems
                .push(problems::wrong_type(term, &found, of, &wanted, tree.span));
        }
    }

    fn kinds_text(&self, kinds: &Kinds) -> String {
        let names: Vec<&str> = kinds.0.iter().map(|t| self.pair.types[*t].name.text.as_str()).collect();
        match names[..] {
            [one] => one.to_owned(),
            _ => format!("(either {})", names.join(" ")),
        }
    }
}
