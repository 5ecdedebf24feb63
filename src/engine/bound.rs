//! The least that a task can cost, from the domain alone: never above the truth.
//!
//! Of an action: the least value of its cost expression over all arguments and states, by interval arithmetic; a cost is
//! never below 0. Of a method: 0 if it has a goal, which may hold; else the least sum over its decompositions. The least
//! solution of these equations is approached from below, so that every round gives a bound. Sums are kept in whole
//! units of 2^-20, rounded down, so that adding and taking away leaves no trace of rounding.

use super::fold::Fixed;
use crate::ir::{ArithmeticOp, Domain, Expr, MethodId, TaskId, Value};

/// The least cost of each task.
#[derive(Debug)]
pub(super) struct Bounds {
    actions: Vec<u64>,
    methods: Vec<u64>,
    /// The sum of each decomposition's subtasks.
    sums: Vec<Vec<u64>>,
}

const UNITS: f64 = 1_048_576.0;
/// HEURISTIC: rounds of the fixpoint; a chain of methods needs one for each.
const ROUNDS: usize = 64;
/// No task counts for more, so that sums of millions stay whole numbers.
const MOST: u64 = 1 << 40;

/// Returns the cost that a sum of bounds stands for.
pub(super) fn cost(units: u64) -> f64 {
    units as f64 / UNITS
}

impl Bounds {
    pub fn new(domain: &Domain, fixed: &Fixed) -> Self {
        let action = |a: &crate::ir::Action| {
            let least = range(domain, fixed, &a.cost).0.max(0.0) * UNITS;
            (least.floor() as u64).min(MOST)
        };
        let mut bounds = Bounds {
            actions: domain.actions.iter().map(action).collect(),
            methods: vec![0; domain.methods.len()],
            sums: Vec::new(),
        };
        for _ in 0..ROUNDS {
            let next: Vec<u64> = domain.methods.iter().map(|m| bounds.method(m)).collect();
            if next == bounds.methods {
                break;
            }
            bounds.methods = next;
        }
        let sums = |m: &crate::ir::Method| m.decompositions.iter().map(|d| bounds.sum(d)).collect();
        bounds.sums = domain.methods.iter().map(sums).collect();
        bounds
    }

    fn method(&self, method: &crate::ir::Method) -> u64 {
        if method.goal.is_some() {
            return 0;
        }
        let sums = method.decompositions.iter().map(|d| self.sum(d));
        sums.min().unwrap_or(0).min(MOST)
    }

    fn sum(&self, decomposition: &crate::ir::Decomposition) -> u64 {
        decomposition.subtasks.iter().map(|s| self.task(s.task)).sum()
    }

    /// Returns the least cost of all subtasks of a method's decomposition.
    #[inline]
    pub fn of(&self, method: MethodId, decomposition: usize) -> u64 {
        self.sums[method.index()][decomposition]
    }

    /// Returns the least cost of a task.
    pub fn task(&self, task: TaskId) -> u64 {
        match task {
            TaskId::Action(a) => self.actions[a.index()],
            TaskId::Method(m) => self.methods[m.index()],
        }
    }
}

const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Returns an interval that holds every number which the expression can have.
fn range(domain: &Domain, fixed: &Fixed, expr: &Expr) -> (f64, f64) {
    match expr {
        Expr::Const(Value::Number(x)) => (*x, *x),
        Expr::Attribute { attribute, .. } if fixed.has(*attribute) => {
            let slots = domain.slots_of(*attribute);
            let numbers = slots.filter_map(|slot| match domain.initial[slot.index()] {
                Value::Number(x) => Some(x),
                _ => None,
            });
            let all = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
            // Nobody has a number: the cost has no value, and the action is refused.
            if all.0 > all.1 { ANY } else { all }
        }
        Expr::Size(_) | Expr::GeometricCost | Expr::GeometricDuration => (0.0, f64::INFINITY),
        Expr::Negate(inner) => {
            let (lo, hi) = range(domain, fixed, inner);
            (-hi, -lo)
        }
        Expr::Arithmetic { op, left, right } => {
            let (a, b) = (range(domain, fixed, left), range(domain, fixed, right));
            let result = match op {
                ArithmeticOp::Add => (a.0 + b.0, a.1 + b.1),
                ArithmeticOp::Subtract => (a.0 - b.1, a.1 - b.0),
                ArithmeticOp::Multiply => {
                    let products = [a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1];
                    // 0 times infinity is no number: then anything may come out.
                    if products.iter().any(|p| p.is_nan()) {
                        if a.0 >= 0.0 && b.0 >= 0.0 {
                            (0.0, f64::INFINITY)
                        } else {
                            ANY
                        }
                    } else {
                        let fold = |f: fn(f64, f64) -> f64| products.iter().copied().reduce(f).unwrap_or(f64::NAN);
                        (fold(f64::min), fold(f64::max))
                    }
                }
                ArithmeticOp::Divide => ANY,
            };
            if result.0.is_nan() || result.1.is_nan() {
                ANY
            } else {
                result
            }
        }
        Expr::Const(_)
        | Expr::Var(_)
        | Expr::Attribute { .. }
        | Expr::List(_)
        | Expr::SetWith { .. }
        | Expr::SetWithout { .. }
        | Expr::Request { .. }
        | Expr::Fact { .. } => ANY,
    }
}
