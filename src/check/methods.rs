//! Methods: goal, decompositions, SELECT and `let`, subtasks and their order (thesis 4.3.2.2).

use std::sync::Arc;

use indexmap::IndexMap;

use super::expr::{Bound, Scope, Walk};
use super::functions::Functions;
use super::kinds::Kind;
use super::names::Names;
use super::problems;
use super::tasks::{kinds_of, params};
use crate::diag::{Problem, Problems};
use crate::ir::{self, Base, Binder, Expr, SelectOrder, Var};
use crate::source::Span;
use crate::syntax::ast::{self, Name, SelectKind, Step};

/// Compiles a method.
pub(super) fn method(
    method: &ast::Method,
    names: &mut Names,
    functions: &Functions,
    problems: &mut Problems,
) -> ir::Method {
    let kinds = kinds_of(&method.params, names);
    let mut walk = Walk {
        names,
        functions,
        problems,
        scope: Scope::of_params(&method.params, &kinds),
        wanted: "number",
    };
    let mut goal = None;
    for (i, (tests, span)) in method.goals.iter().enumerate() {
        if let Some((_, first)) = method.goals.first().filter(|_| i > 0) {
            let problem = problems::repeated_block("goal", &method.name.text, *span, *first);
            walk.problems.push(problem);
        }
        // `empty{};` is left over where a file has nothing to say: a goal that always holds would make the method useless.
        if !tests.is_empty() {
            goal = Some(walk.tests(tests));
        }
    }
    let decompositions = method.decompositions.iter().map(|d| walk.decomposition(d)).collect();
    ir::Method {
        name: method.name.text.clone(),
        params: params(&method.params, &kinds),
        goal,
        decompositions,
        n_vars: walk.scope.n_vars as usize,
    }
}

impl Walk<'_> {
    fn decomposition(&mut self, decomposition: &ast::Decomposition) -> ir::Decomposition {
        let n_params = self.scope.bound.len();
        let names = |step: &Step| match step {
            Step::Select(select) => Some(select.name.clone()),
            Step::Let(binding) => Some(binding.name.clone()),
            Step::Subtask(_) => None,
        };
        self.scope.later = decomposition.steps.iter().filter_map(names).collect();
        let mut next_var = n_params as u32;
        self.scope.next_quantified = next_var + self.scope.later.len() as u32;
        self.scope.n_vars = self.scope.n_vars.max(self.scope.next_quantified);

        let preconditions = self.tests(&decomposition.preconditions);
        let (mut binders, mut subtasks) = (Vec::new(), Vec::new());
        for step in &decomposition.steps {
            match step {
                Step::Select(select) => {
                    binders.extend(self.select(select, Var(next_var)));
                    next_var += 1;
                }
                Step::Let(binding) => {
                    let (value, kind) = self.single(&binding.value);
                    if kind == Kind::Null {
                        let problem = self.mismatch(binding.value.span, "a value", kind);
                        self.problems.push(problem);
                    }
                    self.bind(&binding.name, Var(next_var), kind);
                    binders.push(Binder::Let {
                        var: Var(next_var),
                        var_name: binding.name.text.clone(),
                        value,
                    });
                    next_var += 1;
                }
                Step::Subtask(subtask) => subtasks.extend(self.subtask(subtask)),
            }
        }
        self.scope.bound.truncate(n_params);
        self.scope.later.clear();
        self.scope.next_quantified = n_params as u32;
        let steps = decomposition.steps.iter().filter_map(|step| match step {
            Step::Subtask(subtask) => Some(subtask),
            Step::Select(_) | Step::Let(_) => None,
        });
        let help = "a label is the number and `:` before a subtask of this block";
        self.order(&steps.collect::<Vec<_>>(), &mut subtasks, help);
        ir::Decomposition {
            preconditions,
            binders,
            subtasks,
        }
    }

    fn bind(&mut self, name: &Name, var: Var, kind: Kind) {
        let kind = self.unless_shadowing(name, kind);
        let later = self.scope.later.iter().position(|l| l.span == name.span);
        if let Some(i) = later {
            self.scope.later.remove(i);
        }
        self.scope.bound.push(Bound {
            name: name.clone(),
            var,
            kind,
        });
    }

    fn select(&mut self, select: &ast::Select, var: Var) -> Option<Binder> {
        let ty = self.names.type_named(&select.ty, self.problems);
        self.bind(&select.name, var, ty.map_or(Kind::Unknown, Kind::Entity));
        let filter = self.tests(&select.filter);
        let key = select
            .key
            .as_ref()
            .map(|(key, descending)| (self.number(key), *descending));
        let order = match (select.kind, key) {
            (SelectKind::Select, None) => SelectOrder::Declared,
            (SelectKind::Once, None) => SelectOrder::Once,
            (SelectKind::Ordered, Some((key, descending))) => SelectOrder::Sorted { key, descending },
            (SelectKind::Ordered, None) => {
                let message = "SELECTORDERED needs a number to sort by, and a direction";
                let problem = Problem::error(
                    "hatp::wrong-count",
                    message,
                    select.kind_span,
                    "2 arguments or more missing",
                );
                self.problems.push(
                    problem.help("write `SELECTORDERED(Type, { filter }, key, <)`; `<` takes the smallest first"),
                );
                return None;
            }
            (SelectKind::Select | SelectKind::Once, Some(_)) => {
                let message = "only SELECTORDERED takes a key and a direction";
                let problem = Problem::error(
                    "hatp::wrong-count",
                    message,
                    select.kind_span,
                    "takes a type and a filter",
                );
                self.problems
                    .push(problem.help("write `SELECTORDERED`, or remove key and direction"));
                return None;
            }
        };
        Some(Binder::Select {
            var,
            var_name: select.name.text.clone(),
            ty: ty?,
            filter,
            order,
        })
    }

    /// Returns the subtask, not yet ordered.
    fn subtask(&mut self, subtask: &ast::Subtask) -> Option<ir::Subtask> {
        let name = &subtask.call.name;
        let Some((task, signature)) = self.names.tasks.get(&name.text).cloned() else {
            for arg in &subtask.call.args {
                self.single(arg);
            }
            let candidates = self.names.tasks.keys().map(String::as_str);
            let problem = problems::unknown("hatp::unknown-task", "task", &name.text, name.span, candidates);
            self.problems.push(problem);
            return None;
        };
        let args = self.arguments("task", &subtask.call, &signature.params, signature.span);
        Some(ir::Subtask {
            task,
            args,
            after: Vec::new(),
        })
    }

    /// Resolves labels and order marks, and refuses an order that goes round; `help` says what a label is.
    pub(super) fn order(&mut self, steps: &[&ast::Subtask], subtasks: &mut [ir::Subtask], help: &str) {
        let mut labels: IndexMap<&str, (usize, Span)> = IndexMap::new();
        for (i, step) in steps.iter().enumerate() {
            let Some(label) = &step.label else { continue };
            if let Some((_, first)) = labels.get(label.text.as_str()) {
                self.problems
                    .push(problems::duplicate("label", &label.text, label.span, Some(*first)));
            } else {
                labels.insert(&label.text, (i, label.span));
            }
        }
        let mut after: Vec<Vec<usize>> = Vec::new();
        for step in steps {
            let mut before = Vec::new();
            for label in &step.after {
                match labels.get(label.text.as_str()) {
                    Some((i, _)) if !before.contains(i) => before.push(*i),
                    Some(_) => {}
                    None => {
                        let known = labels.keys().copied();
                        let mut problem =
                            problems::unknown("hatp::unknown-label", "label", &label.text, label.span, known);
                        if problem.help.is_none() {
                            problem = problem.help(help);
                        }
                        self.problems.push(problem);
                    }
                }
            }
            after.push(before);
        }
        for circle in super::order::sort(&after).circles {
            let of = |i: &usize| {
                let step = steps.get(*i)?;
                let label = step.label.as_ref().map_or("?", |l| l.text.as_str());
                Some((label.to_owned(), step.span))
            };
            let circle: Vec<(String, Span)> = circle.iter().filter_map(of).collect();
            self.problems.0.extend(problems::order_cycle(&circle));
        }
        // When a subtask was faulty the positions do not match, and nothing of this is used.
        if subtasks.len() == after.len() {
            for (subtask, after) in subtasks.iter_mut().zip(after) {
                subtask.after = after;
            }
        }
    }
}

/// Returns a constant or reports why the expression is none.
pub(super) fn constant(expr: &Expr, span: Span, problems: &mut Problems) -> Option<ir::Value> {
    let value = match expr {
        Expr::List(elements) => elements.iter().map(scalar).collect::<Option<Vec<_>>>().map(set_of),
        other => scalar(other),
    };
    if value.is_none() {
        let help = "write a number, a string, `true`, `false`, `NULL`, an entity or a list";
        let message = "expected a constant, found something that can change";
        problems.push(problems::not_constant(span, message, help));
    }
    value
}

fn scalar(expr: &Expr) -> Option<ir::Value> {
    match expr {
        Expr::Const(value) => Some(value.clone()),
        other => super::functions::constant_number(other)
            .filter(|x| x.is_finite())
            .map(ir::Value::Number),
    }
}

/// Returns the set with these members, which are of one kind.
pub(super) fn set_of(members: Vec<ir::Value>) -> ir::Value {
    if matches!(members.first(), Some(ir::Value::Entity(_)) | None) {
        let entities = members.iter().filter_map(|m| match m {
            ir::Value::Entity(e) => Some(*e),
            _ => None,
        });
        return ir::Value::Set(Arc::new(entities.collect()));
    }
    let mut set = ir::ScalarSet::default();
    members.into_iter().for_each(|m| set.insert(m));
    ir::Value::Scalars(Arc::new(set))
}

/// Returns the value; an empty set as one of what it is meant to hold.
pub(super) fn typed(set: ir::Value, base: Base) -> ir::Value {
    match (&set, base) {
        (ir::Value::Set(members), Base::Number | Base::Bool | Base::String) if members.is_empty() => {
            ir::Value::Scalars(Default::default())
        }
        _ => set,
    }
}
