//! The task to plan, as the world file or the command line writes it: `MoveObjs(PR2, [RED_CUBE], TABLE)`, or a task network
//! with an order, `Get(A, CUP); Get(B, BOX); Sit(A) > 1, 2`.
//!
//! A network becomes a method of the domain with one decomposition of constants, so that search and validator know one
//! task to plan, as ever (HTN planning starts from an initial task network: Erol, Hendler, Nau, AAAI 1994). Variables are
//! not in it: a method of the domain can have them.

use super::expr::{Scope, Walk};
use super::functions::Functions;
use super::kinds::Kind;
use super::methods::{constant, typed};
use super::names::{Names, Signature};
use super::problems;
use crate::diag::{Label, Problems};
use crate::ir::{self, Domain, Expr};
use crate::source::{FileId, Span};
use crate::syntax::{
    self,
    ast::{self, Name},
};

/// Returns the task that `text` names with its arguments; `offset` is where `text` starts in `file` [bytes]. A task network
/// is added to the domain as a method: [`Domain::network`].
///
/// `None` if and only if there are errors.
pub fn parse_goal(text: &str, file: FileId, offset: usize, domain: &mut Domain) -> (Option<ir::Goal>, Problems) {
    let (tasks, mut problems) = syntax::parse_network(file, offset, text);
    let Some(mut tasks) = tasks else {
        return (None, problems);
    };
    let mut names = names_of(domain);
    let functions = Functions::default();
    let mut walk = Walk {
        names: &mut names,
        functions: &functions,
        problems: &mut problems,
        scope: Scope::default(),
        wanted: "number",
    };
    // Tasks without a label are numbered.
    for (i, task) in tasks.iter_mut().enumerate() {
        let span = task.call.name.span;
        task.label.get_or_insert_with(|| Name {
            text: (i + 1).to_string(),
            span,
        });
    }
    let goals: Vec<Option<ir::Goal>> = tasks.iter().map(|t| walk.ground(&t.call, domain)).collect();
    let mut goals: Vec<ir::Goal> = goals.into_iter().flatten().collect();
    // Where a task is wrong, the order is looked at all the same: one answer for all that is wrong.
    let mut subtasks: Vec<ir::Subtask> = goals.iter().map(subtask).collect();
    let help = "a label is the number and `:` before a task; a task without one has its place in the row, from 1";
    walk.order(&tasks.iter().collect::<Vec<_>>(), &mut subtasks, help);
    if problems.has_errors() {
        return (None, problems.sorted());
    }
    for subtask in &mut subtasks {
        subtask.after.sort_unstable();
    }
    let goal = match goals.len() {
        1 => goals.pop(),
        _ => Some(network(&goals, subtasks, domain)),
    };
    (goal, problems.sorted())
}

/// Adds the network to the domain, named by its text: every task by its place in the row.
fn network(goals: &[ir::Goal], subtasks: Vec<ir::Subtask>, domain: &mut Domain) -> ir::Goal {
    let show = |(goal, subtask): (&ir::Goal, &ir::Subtask)| {
        let after: Vec<String> = subtask.after.iter().map(|i| (i + 1).to_string()).collect();
        let mark = if after.is_empty() { "" } else { " > " };
        format!("{}{mark}{}", domain.show_task(goal.task, &goal.args), after.join(", "))
    };
    let id = ir::MethodId(domain.methods.len() as u32);
    let name = goals.iter().zip(&subtasks).map(show).collect::<Vec<_>>().join("; ");
    domain.network = Some(id);
    domain.methods.push(ir::Method {
        name,
        params: Vec::new(),
        goal: None,
        decompositions: vec![ir::Decomposition {
            preconditions: ir::Test::always(),
            binders: Vec::new(),
            subtasks,
        }],
        n_vars: 0,
    });
    ir::Goal {
        task: ir::TaskId::Method(id),
        args: Vec::new(),
    }
}

fn subtask(goal: &ir::Goal) -> ir::Subtask {
    ir::Subtask {
        task: goal.task,
        args: goal.args.iter().cloned().map(Expr::Const).collect(),
        after: Vec::new(),
    }
}

impl Walk<'_> {
    /// Returns the task that is called, whose arguments must be constants; `None` if there are errors.
    fn ground(&mut self, call: &ast::Call, domain: &Domain) -> Option<ir::Goal> {
        let Some(task) = domain.task(&call.name.text) else {
            let candidates = self.names.tasks.keys().map(String::as_str);
            let name = &call.name;
            let problem = problems::unknown("hatp::unknown-task", "task", &name.text, name.span, candidates);
            self.problems.push(problem);
            // The arguments are looked at, too: one answer for all that is wrong.
            for arg in &call.args {
                self.single(arg);
            }
            return None;
        };
        let n_before = self.problems.0.len();
        let params: Vec<(String, Kind)> = domain
            .task_params(task)
            .iter()
            .map(|p| (p.name.clone(), Kind::of(p.base, p.is_set)))
            .collect();
        // The declaration's place is not kept in a compiled domain; the help line shows its parameters.
        let args = self.arguments("task", call, &params, Span::new(super::PRELUDE, 0, 0));
        // What is wrong inside an argument is said already; that it is no constant then follows.
        let is_wrong = |problems: &Problems, span: Span| {
            let inside = |l: &Label| span.start <= l.span.start && l.span.end <= span.end;
            let mut own = problems.0.iter().skip(n_before);
            own.any(|p| p.primary.as_ref().is_some_and(inside))
        };
        let args: Option<Vec<ir::Value>> = args
            .iter()
            .zip(&call.args)
            .map(|(arg, at)| match is_wrong(self.problems, at.span) {
                true => None,
                false => constant(arg, at.span, self.problems),
            })
            .collect();
        for (arg, at) in args.iter().flatten().zip(&call.args) {
            // Ids of strings belong to the domain; one that is not there would name nothing.
            let is_foreign = matches!(arg, ir::Value::String(s) if s.index() >= domain.strings.len());
            if is_foreign && !is_wrong(self.problems, at.span) {
                let message = "this string occurs nowhere in the domain";
                let help = "no test can tell it from any other; use one that the domain writes";
                let problem = problems::not_constant(at.span, message, help);
                self.problems.push(problem);
            }
        }
        let params = domain.task_params(task).iter();
        let args = args?.into_iter().zip(params).map(|(v, p)| typed(v, p.base)).collect();
        Some(ir::Goal { task, args })
    }
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
