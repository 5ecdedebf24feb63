//! The task to plan, as the world file or the command line writes it: `MoveObjs(PR2, [RED_CUBE], TABLE)`.

use super::expr::{Scope, Walk};
use super::functions::Functions;
use super::kinds::Kind;
use super::methods::{constant, typed};
use super::names::{Names, Signature};
use super::problems;
use crate::diag::{Label, Problems};
use crate::ir::{self, Domain};
use crate::source::{FileId, Span};
use crate::syntax;

/// Returns the task that `text` names with its arguments; `offset` is where `text` starts in `file` [bytes].
///
/// `None` if and only if there are errors.
pub fn parse_goal(text: &str, file: FileId, offset: usize, domain: &Domain) -> (Option<ir::Goal>, Problems) {
    let (call, mut problems) = syntax::parse_call(file, offset, text);
    let Some(call) = call else { return (None, problems) };
    let mut names = names_of(domain);
    let task = domain.task(&call.name.text);
    if task.is_none() {
        let name = &call.name;
        let candidates = names.tasks.keys().map(String::as_str);
        problems.push(problems::unknown(
            "hatp::unknown-task",
            "task",
            &name.text,
            name.span,
            candidates,
        ));
    }
    let functions = Functions::default();
    let mut walk = Walk {
        names: &mut names,
        functions: &functions,
        problems: &mut problems,
        scope: Scope::default(),
        wanted: "number",
    };
    let Some(task) = task else {
        // The arguments are looked at, too: one answer for all that is wrong.
        for arg in &call.args {
            walk.single(arg);
        }
        return (None, problems.sorted());
    };
    let params: Vec<(String, Kind)> = domain
        .task_params(task)
        .iter()
        .map(|p| (p.name.clone(), Kind::of(p.base, p.is_set)))
        .collect();
    // The declaration's place is not kept in a compiled domain; the help line shows its parameters.
    let args = walk.arguments("task", &call, &params, Span::new(super::PRELUDE, 0, 0));
    let args = args.iter().zip(&call.args);
    // What is wrong inside an argument is said already; that it is no constant then follows.
    let is_wrong = |problems: &Problems, span: Span| {
        let inside = |l: &Label| span.start <= l.span.start && l.span.end <= span.end;
        problems.0.iter().any(|p| p.primary.as_ref().is_some_and(inside))
    };
    let args: Option<Vec<ir::Value>> = args
        .map(|(arg, at)| match is_wrong(&problems, at.span) {
            true => None,
            false => constant(arg, at.span, &mut problems),
        })
        .collect();
    for (arg, at) in args.iter().flatten().zip(&call.args) {
        // Ids of strings belong to the domain; one that is not there would name nothing.
        if !is_wrong(&problems, at.span) && matches!(arg, ir::Value::String(s) if s.index() >= domain.strings.len()) {
            let message = "this string occurs nowhere in the domain";
            let help = "no test can tell it from any other; use one that the domain writes";
            problems.push(problems::not_constant(at.span, message, help));
        }
    }
    let params = domain.task_params(task).iter();
    let args = args.map(|args| args.into_iter().zip(params).map(|(v, p)| typed(v, p.base)).collect());
    let goal = args.map(|args| ir::Goal { task, args });
    let goal = goal.filter(|_| !problems.has_errors());
    (goal, problems.sorted())
}

/// Returns the names that a goal may use.
fn names_of(domain: &Domain) -> Names {
    let mut names = Names::default();
    for (i, ty) in domain.types.iter().enumerate() {
        names.types.insert(ty.name.clone(), (ir::TypeId(i as u32), None));
    }
    for (i, entity) in domain.entities.iter().enumerate() {
        names
            .entities
            .insert(entity.name.clone(), (ir::EntityId(i as u32), None));
    }
    let tasks = domain
        .methods
        .iter()
        .map(|m| &m.name)
        .chain(domain.actions.iter().map(|a| &a.name));
    for name in tasks {
        if let Some(task) = domain.task(name) {
            let signature = Signature {
                params: Vec::new(),
                span: Span::new(super::PRELUDE, 0, 0),
            };
            names.tasks.insert(name.clone(), (task, signature));
        }
    }
    names.set_domain(domain);
    names
}
