//! Names and types of a domain: all problems, not the first; and, when there are none, the compiled domain.
//!
//! One walk checks an expression and writes it in ids, since both need the same knowledge of it. What is built in comes
//! from `domains/prelude.hatp`. Does not evaluate anything but constants, and knows no geometry: what the world file
//! declares comes in as [`Given`].
//!
//! Thesis 4.3.2 and 4.3.3. An action without `cost` costs what geometry says if it projects, else 1; one without
//! `duration` lasts as long as its motions, else no time.

mod attributes;
mod beliefs;
mod expr;
mod facts;
mod functions;
mod geometrics;
mod goal;
mod initial;
mod kinds;
mod lints;
mod methods;
mod names;
mod order;
mod problems;
mod remedy;
mod settings;
mod social;
mod tasks;
mod test;
mod words;

pub use goal::parse_goal;

use crate::diag::{Problem, Problems};
use crate::ir;
use crate::source::{FileId, Span};
use crate::syntax::{self, ast};

/// The prelude's text: the built-ins with their meaning and units.
pub const PRELUDE_TEXT: &str = include_str!("../../domains/prelude.hatp");

/// Stands for the prelude in spans. INVARIANT: no problem points there, since no `Sources` has the file.
const PRELUDE: FileId = FileId(u32::MAX);

/// What the world file declares, for the checker.
#[derive(Debug, Clone, Default)]
pub struct Given {
    /// In the order of the file.
    pub entities: Vec<GivenEntity>,
    /// `Type.attribute` or `attribute`, and the fact that it is read from.
    pub shared: Vec<(String, String, Span)>,
    /// Initial values; they replace the domain's.
    pub values: Vec<GivenValue>,
    /// Names of the tasks to plan, if any; whether there are such tasks is not checked here.
    pub tasks: Vec<String>,
}

/// An agent or object of the world.
#[derive(Debug, Clone)]
pub struct GivenEntity {
    pub name: String,
    /// Its type in the domain. Without one an agent is an `Agent`, and anything else is an entity only if the domain
    /// declares it.
    pub ty: Option<String>,
    pub is_agent: bool,
    pub span: Span,
}

/// `RED_CUBE.painted = true` of the world file.
#[derive(Debug, Clone)]
pub struct GivenValue {
    pub entity: String,
    pub attribute: String,
    pub values: Vec<GivenLiteral>,
    /// Whether the file wrote an array.
    pub is_list: bool,
    /// Whether it is left out where the domain declares no such attribute.
    pub is_implied: bool,
    pub span: Span,
}

/// A constant of the world file; a text is an entity's name or a string, as the attribute's type says.
#[derive(Debug, Clone, PartialEq)]
pub enum GivenLiteral {
    Bool(bool),
    Number(f64),
    Text(String),
}

/// Checks the files together, with the world's declarations, and compiles them. The last file is the one that the user named.
///
/// `None` if there are errors, or a file is read in part. Problems are sorted by place.
pub fn compile(files: &[ast::File], given: &Given) -> (Option<ir::Domain>, Problems) {
    let mut problems = Problems::default();
    let (prelude, faults) = syntax::parse(PRELUDE, PRELUDE_TEXT);
    debug_assert!(faults.0.is_empty(), "the prelude parses");
    let items: Vec<&ast::Item> = prelude
        .items
        .iter()
        .chain(files.iter().flat_map(|f| &f.items))
        .collect();
    for item in &items {
        problems.0.extend(unsupported(item));
    }
    let mut names = names::Names::collect(&items, given, &mut problems);
    let unread = files.iter().flat_map(|f| &f.unread.attributes_of);
    names.leave_open(unread);
    names.share_given(given, &mut problems);
    let functions = functions::compile(&items, &mut names, &mut problems);
    facts::compile(&items, &mut names, &functions, &mut problems);
    geometrics::compile(&items, &mut names, &mut problems);
    settings::fill(&items, &mut names, &mut problems);
    social::fill(&items, &mut names, &functions, &mut problems);
    beliefs::compile(&items, &mut names, &functions, &mut problems);
    initial::fill(&items, given, &mut names, &functions, &mut problems);
    for item in &items {
        match item {
            ast::Item::Action(action) => {
                let action = tasks::action(action, &mut names, &functions, &mut problems);
                names.domain.actions.push(action);
            }
            ast::Item::Method(method) => {
                let method = methods::method(method, &mut names, &functions, &mut problems);
                names.domain.methods.push(method);
            }
            _ => {}
        }
    }
    let is_whole = files.iter().all(|f| f.unread.is_empty());
    if is_whole && !problems.has_errors() {
        let mut linted = lints::Linted::new(&items, &names.domain, &names.attribute_spans);
        linted.has_world = !given.entities.is_empty() || !given.tasks.is_empty();
        linted.tasks = &given.tasks;
        linted.main = files.last().map(|file| file.span.file);
        problems.extend(lints::run(&linted));
    }
    let problems = problems.sorted();
    let domain = (is_whole && !problems.has_errors()).then_some(names.domain);
    (domain, problems)
}

/// Says what an item asks for that is not there.
fn unsupported(item: &ast::Item) -> Option<Problem> {
    let builtin = |span: Span| span.file == PRELUDE;
    match item {
        ast::Item::TimePart(span) => Some(problems::time_part(*span)),
        ast::Item::Request(r) if !builtin(r.span) => {
            let message = "a domain can't define requests";
            let help = "use those of the prelude, or a `fact` with a body";
            Some(problems::not_supported(message, r.name.span, help))
        }
        ast::Item::Fact(f) if f.body.is_none() && !builtin(f.span) => {
            let message = format!(
                "fact `{}` has no meaning, and geometry knows none of that name",
                f.name.text
            );
            let help = "write its tests in braces: `{ distance(A, B) < 0.5; }`";
            Some(problems::not_supported(message, f.name.span, help))
        }
        ast::Item::Function(f) if f.body.is_none() && !builtin(f.span) => {
            let message = format!(
                "function `{}` has no body, and a domain can't call programs",
                f.name.text
            );
            let help = "write its value in braces: `{ 1 }`";
            Some(problems::not_supported(message, f.name.span, help))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::render::render;
    use crate::source::Sources;
    use proptest::prelude::*;

    const DOMAIN: &str = include_str!("../../domains/ramification.hatp");

    #[test]
    fn the_prelude_has_no_problems_of_its_own() {
        let (_, problems) = syntax::parse(PRELUDE, PRELUDE_TEXT);
        assert_eq!(problems, Problems::default());
        assert_eq!(compile(&[], &Given::default()).1, Problems::default());
    }

    /// A domain in which some words stand where others stood: it mostly parses, and is mostly wrong.
    fn shuffled() -> impl Strategy<Value = String> {
        let words: Vec<&str> = DOMAIN
            .split_inclusive([' ', '\n', '(', ')', '{', '}', ';', '.', ','])
            .collect();
        let n = words.len();
        prop::collection::vec((0..n, 0..n), 0..6).prop_map(move |swaps| {
            let mut words = words.clone();
            for (a, b) in swaps {
                words[a] = words[b];
            }
            words.concat()
        })
    }

    proptest! {
        #[test]
        fn whatever_parses_is_checked_without_a_panic(text in shuffled()) {
            let mut sources = Sources::default();
            let file = sources.add("a.hatp", text.clone());
            let (ast, mut problems) = syntax::parse(file, &text);
            let is_whole = ast.unread.is_empty();
            let (domain, faults) = compile(&[ast], &Given::default());
            prop_assert_eq!(domain.is_none(), faults.has_errors() || !is_whole);
            problems.extend(faults);
            // No problem points into the prelude: `render` would have no such file.
            render(&problems, &sources, false);
            if let Some(mut domain) = domain {
                ir::dump(&domain);
                parse_goal(&text, file, 0, &mut domain);
            }
        }
    }
}
