//! The least that a task can cost, from the domain alone: never above the truth.
//!
//! Of an action: the least value of its cost expression over all states and all arguments of the types that its parameters
//! have, by interval arithmetic; of an action among the subtasks of a decomposition, over the arguments that it is given
//! there, constants or values of other types. A cost is never below 0. Of a method: 0 if it has a goal, which may hold; else
//! the least sum over its decompositions. The least solution of these equations is approached from below, so that every round
//! gives a bound. Sums are kept in whole units of 2^-20, rounded down, so that adding and taking away leaves no trace of
//! rounding.

use super::fold::Fixed;
use crate::ir::{
    Action, ArithmeticOp, Base, Binder, Decomposition, Domain, EntityId, Expr, Method, MethodId, Param, Subtask,
    TaskId, TypeId, Value,
};

/// The least cost of each task.
#[derive(Debug)]
pub(super) struct Bounds {
    actions: Vec<u64>,
    methods: Vec<u64>,
    /// By method and decomposition.
    decompositions: Vec<Vec<OfDecomposition>>,
}

/// The least cost of each subtask of a decomposition, and of all.
#[derive(Debug)]
struct OfDecomposition {
    subtasks: Vec<u64>,
    sum: u64,
}

/// What is known of a variable's values.
#[derive(Debug, Clone, Copy)]
enum Known<'d> {
    Nothing,
    /// They are entities of that type.
    Type(TypeId),
    Is(&'d Value),
}

/// What is known of all variables of a frame.
type Frame<'d> = Vec<Known<'d>>;

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
        let mut bounds = Bounds {
            actions: Vec::new(),
            methods: vec![0; domain.methods.len()],
            decompositions: Vec::new(),
        };
        let action = |a: &Action| least(domain, fixed, a, &of_params(&a.params));
        bounds.actions = domain.actions.iter().map(action).collect();
        // Of actions among subtasks: what they cost there.
        let of_subtask = |frame: &Frame<'_>, subtask: &Subtask| match subtask.task {
            TaskId::Action(a) => {
                let action = &domain.actions[a.index()];
                let args = of_params(&action.params);
                let args = args.into_iter().zip(&subtask.args);
                let args: Frame<'_> = args.map(|(param, arg)| given(param, arg, frame)).collect();
                Some(least(domain, fixed, action, &args))
            }
            TaskId::Method(_) => None,
        };
        let of_method = |m: &Method| -> Vec<Vec<Option<u64>>> {
            let of = |d: &Decomposition| {
                let frame = of_decomposition(m, d);
                d.subtasks.iter().map(|s| of_subtask(&frame, s)).collect()
            };
            m.decompositions.iter().map(of).collect()
        };
        let of_actions: Vec<_> = domain.methods.iter().map(of_method).collect();
        for _ in 0..ROUNDS {
            bounds.decompositions = bounds.all(domain, &of_actions);
            let method = |(m, of): (&Method, &Vec<OfDecomposition>)| match m.goal {
                Some(_) => 0,
                None => of.iter().map(|d| d.sum).min().unwrap_or(0).min(MOST),
            };
            let next: Vec<u64> = domain.methods.iter().zip(&bounds.decompositions).map(method).collect();
            if next == bounds.methods {
                return bounds;
            }
            bounds.methods = next;
        }
        bounds.decompositions = bounds.all(domain, &of_actions);
        bounds
    }

    /// Returns what all decompositions cost at least, by what methods do.
    fn all(&self, domain: &Domain, of_actions: &[Vec<Vec<Option<u64>>>]) -> Vec<Vec<OfDecomposition>> {
        let of = |(d, known): (&Decomposition, &Vec<Option<u64>>)| {
            let subtasks = d.subtasks.iter().zip(known);
            let subtasks: Vec<u64> = subtasks.map(|(s, known)| known.unwrap_or(self.task(s.task))).collect();
            OfDecomposition {
                sum: subtasks.iter().sum(),
                subtasks,
            }
        };
        let methods = domain.methods.iter().zip(of_actions);
        methods
            .map(|(m, known)| m.decompositions.iter().zip(known).map(of).collect())
            .collect()
    }

    /// Returns the least cost of all subtasks of a method's decomposition.
    #[inline]
    pub fn of(&self, method: MethodId, decomposition: usize) -> u64 {
        self.decompositions[method.index()][decomposition].sum
    }

    /// Returns the least cost of a subtask of a method's decomposition.
    #[inline]
    pub fn subtask(&self, method: MethodId, decomposition: usize, subtask: usize) -> u64 {
        self.decompositions[method.index()][decomposition].subtasks[subtask]
    }

    /// Returns the least cost of a task.
    pub fn task(&self, task: TaskId) -> u64 {
        match task {
            TaskId::Action(a) => self.actions[a.index()],
            TaskId::Method(m) => self.methods[m.index()],
        }
    }
}

/// Returns the least that an action costs where so much is known of its arguments.
fn least<'d>(domain: &Domain, fixed: &Fixed, action: &'d Action, args: &Frame<'d>) -> u64 {
    let least = range(domain, fixed, &action.cost, args).0.max(0.0) * UNITS;
    (least.floor() as u64).min(MOST)
}

fn of_params<'d>(params: &[Param]) -> Frame<'d> {
    let of = |param: &Param| match param.base {
        Base::Entity(ty) if !param.is_set => Known::Type(ty),
        Base::Entity(_) | Base::Number | Base::Bool | Base::String => Known::Nothing,
    };
    params.iter().map(of).collect()
}

/// Returns what is known of a method's variables where one of its decompositions is applied.
fn of_decomposition<'d>(method: &Method, decomposition: &Decomposition) -> Frame<'d> {
    let mut frame = of_params(&method.params);
    frame.resize(method.n_vars.max(frame.len()), Known::Nothing);
    for binder in &decomposition.binders {
        if let Binder::Select { var, ty, .. } = binder {
            frame[var.index()] = Known::Type(*ty);
        }
    }
    frame
}

/// Returns what is known of a parameter that is given this argument.
fn given<'d>(param: Known<'d>, arg: &'d Expr, frame: &Frame<'d>) -> Known<'d> {
    match arg {
        Expr::Const(value) => Known::Is(value),
        Expr::Var(var) => match frame.get(var.index()) {
            Some(known @ (Known::Type(_) | Known::Is(_))) => *known,
            Some(Known::Nothing) | None => param,
        },
        _ => param,
    }
}

const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn known<'d>(expr: &'d Expr, args: &Frame<'d>) -> Known<'d> {
    match expr {
        Expr::Var(var) => args.get(var.index()).copied().unwrap_or(Known::Nothing),
        Expr::Const(value) => Known::Is(value),
        _ => Known::Nothing,
    }
}

/// Returns an interval that holds every number which the expression can have.
fn range<'d>(domain: &Domain, fixed: &Fixed, expr: &'d Expr, args: &Frame<'d>) -> (f64, f64) {
    match expr {
        Expr::Const(Value::Number(x)) => (*x, *x),
        Expr::Var(_) => match known(expr, args) {
            Known::Is(Value::Number(x)) => (*x, *x),
            Known::Is(_) | Known::Type(_) | Known::Nothing => ANY,
        },
        Expr::Attribute { base, attribute, .. } if fixed.has(*attribute) => {
            let base = known(base, args);
            // Whose value it may be.
            let is_one = |e: EntityId| match base {
                Known::Is(Value::Entity(one)) => e == *one,
                Known::Type(ty) => domain.is_subtype(domain.entities[e.index()].ty, ty),
                Known::Is(_) | Known::Nothing => true,
            };
            let slots = domain.slots_of(*attribute);
            let slots = slots.filter(|slot| is_one(domain.slots[slot.index()].entity));
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
            let (lo, hi) = range(domain, fixed, inner, args);
            (-hi, -lo)
        }
        Expr::Arithmetic { op, left, right } => {
            let (a, b) = (range(domain, fixed, left, args), range(domain, fixed, right, args));
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
        | Expr::Attribute { .. }
        | Expr::List(_)
        | Expr::SetWith { .. }
        | Expr::SetWithout { .. }
        | Expr::Request { .. }
        | Expr::Fact { .. } => ANY,
    }
}
