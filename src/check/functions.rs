//! Functions of the domain: compiled once, then written out where they are called. Recursion is an error.

use indexmap::{IndexMap, IndexSet};

use super::expr::{Scope, Walk};
use super::kinds::Kind;
use super::names::Names;
use super::{PRELUDE, problems};
use crate::diag::Problems;
use crate::ir::{self, Expr};
use crate::syntax::ast::{self, ExprKind, Item};

/// Largest expression after writing out [nodes], and its depth. HEURISTIC: both are far above real domains; without
/// them thirty functions, each calling the one before twice, would fill the memory.
const MAX_NODES: usize = 10_000;
const MAX_DEPTH: usize = 400;

/// All that functions are written out to in one domain [nodes]. HEURISTIC: far above real domains; without it every one
/// of a thousand calls might grow to the largest expression.
const MAX_NODES_OF_DOMAIN: usize = 1_000_000;

/// What an expression computes.
#[derive(Debug, Clone)]
pub(super) enum Value {
    One(Expr),
    /// (least, most) [s]
    Pair(Expr, Expr),
}

/// Bodies by name, in terms of their parameters as `Var(0)`, `Var(1)` ...; a faulty function has none.
pub(super) type Functions = IndexMap<String, Value>;

/// Compiles all functions, those that are called first.
pub(super) fn compile(items: &[&Item], names: &mut Names, problems: &mut Problems) -> Functions {
    let mut declared: IndexMap<&str, &ast::Function> = IndexMap::new();
    for item in items {
        if let Item::Function(f) = item {
            declared.entry(&f.name.text).or_insert(f);
        }
    }
    let calls = |f: &&ast::Function| {
        let mut called = IndexSet::new();
        if let Some(body) = &f.body {
            collect_calls(body, &mut called);
        }
        called.iter().filter_map(|c| declared.get_index_of(c)).collect()
    };
    let after: Vec<Vec<usize>> = declared.values().map(calls).collect();
    let sorted = super::order::sort(&after);
    let mut out = Functions::new();
    let called = |i: usize| after.get(i).into_iter().flatten();
    for i in sorted.order {
        let Some((name, function)) = declared.get_index(i) else {
            continue;
        };
        let value = body(function, names, &out, problems);
        // One that calls a faulty function has no value either: with half of it the next fault would only be hidden.
        let is_whole = called(i).all(|c| declared.get_index(*c).is_some_and(|(c, _)| out.contains_key(*c)));
        if let Some(value) = value.filter(|_| is_whole) {
            out.insert((*name).to_owned(), value);
        }
    }
    for (_, function) in sorted.circles.iter().flatten().filter_map(|i| declared.get_index(*i)) {
        problems.push(problems::recursive(&function.name));
    }
    out
}

/// Adds the names of all functions that `expr` calls.
fn collect_calls<'a>(expr: &'a ast::Expr, out: &mut IndexSet<&'a str>) {
    match &expr.kind {
        ExprKind::Number(_) | ExprKind::String(_) | ExprKind::Bool(_) | ExprKind::Null => {}
        ExprKind::Path(path) => {
            let args = path.steps.iter().flat_map(|s| &s.args);
            args.for_each(|a| collect_calls(a, out));
        }
        ExprKind::Call(call) => {
            out.insert(&call.name.text);
            call.args.iter().for_each(|a| collect_calls(a, out));
        }
        ExprKind::List(elements) => elements.iter().for_each(|e| collect_calls(e, out)),
        ExprKind::Negate(inner) => collect_calls(inner, out),
        ExprKind::Pair(left, right) | ExprKind::Arithmetic { left, right, .. } => {
            collect_calls(left, out);
            collect_calls(right, out);
        }
    }
}

fn body(function: &ast::Function, names: &mut Names, functions: &Functions, problems: &mut Problems) -> Option<Value> {
    let name = function.name.text.as_str();
    let Some(expr) = &function.body else {
        // What the prelude declares without a body is computed by the planner.
        return match name {
            _ if function.span.file != PRELUDE => None,
            "size" => Some(Value::One(Expr::Size(Box::new(Expr::Var(ir::Var(0)))))),
            "GetGRPCost" => Some(Value::One(Expr::GeometricCost)),
            "GetGRPDuration" => Some(Value::Pair(Expr::GeometricDuration, Expr::GeometricDuration)),
            _ => None,
        };
    };
    let (signature, result) = names.functions.get(name).cloned()?;
    let n_before = problems.0.len();
    let mut walk = Walk {
        names,
        functions,
        problems,
        scope: Scope::of_params(&function.params, &signature.params),
        wanted: if result == Kind::Duration { "duration" } else { "number" },
    };
    let (value, kind) = walk.value(expr);
    if !kind.fits(result, &walk.names.domain) {
        let wanted = walk.words(result);
        let problem = walk.mismatch(expr.span, &wanted, kind);
        walk.problems.push(problem);
    }
    (problems.0.len() == n_before).then_some(value)
}

/// Why a call is not written out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TooLarge {
    Expression,
    /// This call is the one with which all of them together have become too large.
    Domain,
    /// An earlier one was.
    DomainBefore,
}

/// Returns the body with `args` for its parameters; `n_nodes` counts what has been written out in the domain.
pub(super) fn written_out(template: &Value, args: &[Expr], n_nodes: &mut usize) -> Result<Value, TooLarge> {
    if *n_nodes > MAX_NODES_OF_DOMAIN {
        return Err(TooLarge::DomainBefore);
    }
    let sizes: Vec<(usize, usize)> = args.iter().map(measure).collect();
    let mut one = |expr: &Expr| {
        let (nodes, depth) = measure_with(expr, &sizes);
        if nodes > MAX_NODES || depth > MAX_DEPTH {
            return Err(TooLarge::Expression);
        }
        *n_nodes += nodes;
        if *n_nodes > MAX_NODES_OF_DOMAIN {
            return Err(TooLarge::Domain);
        }
        Ok(substitute(expr, args))
    };
    Ok(match template {
        Value::One(expr) => Value::One(one(expr)?),
        Value::Pair(least, most) => Value::Pair(one(least)?, one(most)?),
    })
}

fn measure(expr: &Expr) -> (usize, usize) {
    measure_with(expr, &[])
}

/// Returns nodes and depth of `expr` as if each `Var(i)` had the size `sizes[i]`.
fn measure_with(expr: &Expr, sizes: &[(usize, usize)]) -> (usize, usize) {
    let mut out = (1, 1);
    if let Expr::Var(var) = expr {
        return sizes.get(var.index()).copied().unwrap_or(out);
    }
    expr.each_child(&mut |child| {
        let (nodes, depth) = measure_with(child, sizes);
        out.0 = usize::saturating_add(out.0, nodes);
        out.1 = out.1.max(depth + 1);
    });
    out
}

fn substitute(expr: &Expr, args: &[Expr]) -> Expr {
    let boxed = |e: &Expr| Box::new(substitute(e, args));
    let all = |es: &[Expr]| es.iter().map(|e| substitute(e, args)).collect::<Vec<_>>();
    match expr {
        Expr::Var(var) => args.get(var.index()).unwrap_or(expr).clone(),
        Expr::Const(_) | Expr::GeometricCost | Expr::GeometricDuration => expr.clone(),
        Expr::Attribute { base, attribute, args } => Expr::Attribute {
            base: boxed(base),
            attribute: *attribute,
            args: all(args).into(),
        },
        Expr::Size(set) => Expr::Size(boxed(set)),
        Expr::Negate(inner) => Expr::Negate(boxed(inner)),
        Expr::List(elements) => Expr::List(all(elements)),
        Expr::Request { request, args } => Expr::Request {
            request: *request,
            args: all(args),
        },
        Expr::Fact { fact, args } => Expr::Fact {
            fact: *fact,
            args: all(args),
        },
        Expr::Arithmetic { op, left, right } => Expr::Arithmetic {
            op: *op,
            left: boxed(left),
            right: boxed(right),
        },
        Expr::SetWith { set, element } => Expr::SetWith {
            set: boxed(set),
            element: boxed(element),
        },
        Expr::SetWithout { set, element } => Expr::SetWithout {
            set: boxed(set),
            element: boxed(element),
        },
    }
}

/// Returns the number that an expression of constants has.
pub(super) fn constant_number(expr: &Expr) -> Option<f64> {
    match expr {
        Expr::Const(ir::Value::Number(x)) => Some(*x),
        Expr::Negate(inner) => constant_number(inner).map(|x| -x),
        Expr::Arithmetic { op, left, right } => {
            let (l, r) = (constant_number(left)?, constant_number(right)?);
            Some(match op {
                ir::ArithmeticOp::Add => l + r,
                ir::ArithmeticOp::Subtract => l - r,
                ir::ArithmeticOp::Multiply => l * r,
                ir::ArithmeticOp::Divide => l / r,
            })
        }
        _ => None,
    }
}
