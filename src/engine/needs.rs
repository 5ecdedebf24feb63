//! What must hold for a task to be possible at all, worked out once from the domain.
//!
//! An action needs its precondition. A method needs its goal, or all that one of its decompositions needs: the precondition,
//! and of each subtask what it needs, unless something that may come before it inside the decomposition may change what
//! is looked at (preconditions "pulled up": cf. Magnaguagno, Meneguzzi and de Silva, *HyperTensioN*, IPC 2020). What depends on a
//! variable that a SELECT binds is left out, as is what nests too deep or gets too long: a need that is left out is met.
//!
//! It holds for the arguments as they are when the task is reached: an argument of a subtask is put in as an expression, and
//! what that expression looks at counts as looked at.

use super::effects::{Attributes, Changes, looked_at};
use crate::ir::{Action, Binder, Decomposition, Domain, Expr, Method, Subtask, TaskId, Test, Var};

/// What a task needs.
#[derive(Debug, Clone)]
pub(super) enum Need {
    /// With what it looks at.
    Literal(Test, Attributes),
    All(Vec<Need>),
    Any(Vec<Need>),
}

impl Need {
    const NOTHING: Need = Need::All(Vec::new());

    fn is_nothing(&self) -> bool {
        matches!(self, Need::All(parts) if parts.is_empty())
    }

    fn all(parts: impl IntoIterator<Item = Need>) -> Need {
        let mut left: Vec<Need> = parts.into_iter().filter(|p| !p.is_nothing()).collect();
        if left.len() == 1 {
            left.remove(0)
        } else {
            Need::All(left)
        }
    }

    fn any(mut parts: Vec<Need>) -> Need {
        if parts.iter().any(Need::is_nothing) {
            return Need::NOTHING;
        }
        if parts.len() == 1 {
            parts.remove(0)
        } else {
            Need::Any(parts)
        }
    }

    fn n_literals(&self) -> usize {
        match self {
            Need::Literal(..) => 1,
            Need::All(parts) | Need::Any(parts) => parts.iter().map(Need::n_literals).sum(),
        }
    }

    /// Returns all that it looks at.
    pub fn looks_at(&self) -> Attributes {
        match self {
            Need::Literal(_, looks_at) => *looks_at,
            Need::All(parts) | Need::Any(parts) => parts.iter().fold(0, |all, p| all | p.looks_at()),
        }
    }
}

/// HEURISTIC: how far down preconditions are pulled up from, and literals of one need.
const ROUNDS: usize = 4;
const MOST_LITERALS: usize = 24;

/// What a decomposition's subtasks need, in its frame.
#[derive(Debug)]
pub(super) struct Waiting {
    /// By subtask; `None` where nothing is needed.
    pub needs: Vec<Option<Need>>,
    /// What each may change.
    pub changes: Vec<Attributes>,
    /// The subtasks that wait for each, as bits.
    pub later: Vec<u64>,
    /// Frame size with the quantified variables of all needs.
    pub n_vars: usize,
}

/// Returns the needs of each decomposition's subtasks, in the order of the methods; those of one with more than 64 are
/// left out.
pub(super) fn waiting(domain: &Domain, changes: &Changes) -> Vec<Waiting> {
    let actions: Vec<Need> = domain.actions.iter().map(|a| of_action(domain, a)).collect();
    let mut methods = vec![Need::NOTHING; domain.methods.len()];
    for _ in 0..ROUNDS {
        let of = |m| of_method(domain, changes, &actions, &methods, m);
        methods = domain.methods.iter().map(of).collect();
    }
    let mut all = Vec::new();
    for method in &domain.methods {
        for decomposition in &method.decompositions {
            let frame = method.n_vars.max(method.params.len());
            let mut moving = Moving {
                map: (0..frame).map(|i| Some(Expr::Var(Var(i as u32)))).collect(),
                next: frame as u32,
            };
            let needs = decomposition.subtasks.iter().map(|s| {
                let need = moving.of_subtask(domain, s, &actions, &methods);
                Some(need).filter(|n| !n.is_nothing() && decomposition.subtasks.len() <= 64)
            });
            let needs = needs.collect();
            all.push(Waiting {
                needs,
                changes: decomposition.subtasks.iter().map(|s| changes.of(s.task)).collect(),
                later: later(decomposition),
                n_vars: moving.next as usize,
            });
        }
    }
    all
}

/// Returns, for each subtask, those that wait for it; of more than 64 nothing is said.
fn later(decomposition: &Decomposition) -> Vec<u64> {
    let n = decomposition.subtasks.len();
    let mut later = vec![0u64; n];
    if n > 64 {
        return later;
    }
    // Orders have no cycle: after as many rounds as there are subtasks nothing is new.
    for _ in 0..n {
        for (i, subtask) in decomposition.subtasks.iter().enumerate() {
            for before in &subtask.after {
                later[*before] |= later[i] | 1 << i;
            }
        }
    }
    later
}

fn literals(test: &Test) -> &[Test] {
    match test {
        Test::And(parts) => parts,
        other => std::slice::from_ref(other),
    }
}

fn of_action(domain: &Domain, action: &Action) -> Need {
    let mut moving = Moving::of_params(action.params.len());
    Need::all(moving.of_test(domain, &action.preconditions))
}

fn of_method(domain: &Domain, changes: &Changes, actions: &[Need], methods: &[Need], method: &Method) -> Need {
    let mut moving = Moving::of_params(method.params.len());
    let mut ways = Vec::new();
    if let Some(goal) = &method.goal {
        ways.push(Need::all(moving.of_test(domain, goal)));
    }
    for decomposition in &method.decompositions {
        moving.forget(method.params.len());
        for binder in &decomposition.binders {
            // A path of one step from what is never NULL has a value, be it NULL; of a longer one NULL is made, and tests
            // tell the two apart.
            if let Binder::Let { var, value, .. } = binder
                && is_sure(value, method.params.len())
            {
                let value = moving.expr(value);
                moving.set(*var, value);
            }
        }
        let mut needs = moving.of_test(domain, &decomposition.preconditions);
        let later = later(decomposition);
        for (j, subtask) in decomposition.subtasks.iter().enumerate() {
            if decomposition.subtasks.len() > 64 {
                break;
            }
            let before = (0..decomposition.subtasks.len()).filter(|i| *i != j && later[j] >> i & 1 == 0);
            let before = before.fold(0, |all, i| all | changes.of(decomposition.subtasks[i].task));
            let need = moving.of_subtask(domain, subtask, actions, methods);
            needs.push(unchanged(need, before));
        }
        ways.push(Need::all(needs));
    }
    let need = Need::any(ways);
    if need.n_literals() > MOST_LITERALS {
        return Need::NOTHING;
    }
    need
}

fn is_sure(value: &Expr, n_params: usize) -> bool {
    match value {
        Expr::Const(_) => true,
        Expr::Var(var) => var.index() < n_params,
        Expr::Attribute { base, args, .. } => {
            let is_plain = |e: &Expr| match e {
                Expr::Const(_) => true,
                Expr::Var(var) => var.index() < n_params,
                _ => false,
            };
            is_plain(base) && args.is_empty()
        }
        _ => false,
    }
}

/// Leaves out what may be changed.
fn unchanged(need: Need, changed: Attributes) -> Need {
    match need {
        Need::Literal(_, looks_at) if looks_at & changed != 0 => Need::NOTHING,
        Need::Literal(..) => need,
        Need::All(parts) => Need::all(parts.into_iter().map(|p| unchanged(p, changed))),
        Need::Any(parts) => Need::any(parts.into_iter().map(|p| unchanged(p, changed)).collect()),
    }
}

/// Moves tests from one frame to another.
struct Moving {
    /// What stands for each variable; nothing for one that is not known.
    map: Vec<Option<Expr>>,
    /// The next variable of the new frame that is free for a quantifier.
    next: u32,
}

impl Moving {
    fn of_params(n: usize) -> Self {
        Moving {
            map: (0..n).map(|i| Some(Expr::Var(Var(i as u32)))).collect(),
            next: n as u32,
        }
    }

    /// Forgets all variables but the first `n`.
    fn forget(&mut self, n: usize) {
        self.map.truncate(n);
    }

    fn set(&mut self, var: Var, value: Option<Expr>) {
        if self.map.len() <= var.index() {
            self.map.resize(var.index() + 1, None);
        }
        self.map[var.index()] = value;
    }

    fn of_test(&mut self, domain: &Domain, test: &Test) -> Vec<Need> {
        let moved = literals(test).iter().filter_map(|t| self.test(t));
        let literal = |test: Test| {
            let looks_at = looked_at(domain, &test);
            Need::Literal(test, looks_at)
        };
        moved.map(literal).collect()
    }

    /// Returns what a subtask needs, with its arguments put in.
    fn of_subtask(&mut self, domain: &Domain, subtask: &Subtask, actions: &[Need], methods: &[Need]) -> Need {
        let need = match subtask.task {
            TaskId::Action(a) => &actions[a.index()],
            TaskId::Method(m) => &methods[m.index()],
        };
        let mut inner = Moving {
            map: subtask.args.iter().map(|a| self.expr(a)).collect(),
            next: self.next,
        };
        let need = inner.need(domain, need);
        self.next = inner.next;
        need
    }

    fn need(&mut self, domain: &Domain, need: &Need) -> Need {
        match need {
            Need::Literal(test, _) => match self.test(test) {
                Some(test) => {
                    let looks_at = looked_at(domain, &test);
                    Need::Literal(test, looks_at)
                }
                None => Need::NOTHING,
            },
            Need::All(parts) => Need::all(parts.iter().map(|p| self.need(domain, p)).collect::<Vec<_>>()),
            Need::Any(parts) => Need::any(parts.iter().map(|p| self.need(domain, p)).collect()),
        }
    }

    fn tests(&mut self, tests: &[Test]) -> Option<Vec<Test>> {
        tests.iter().map(|t| self.test(t)).collect()
    }

    fn quantified(&mut self, var: Var, guard: &Test, body: &Test) -> Option<(Var, Box<Test>, Box<Test>)> {
        let new = Var(self.next);
        self.next += 1;
        let old = self.map.get(var.index()).cloned().flatten();
        self.set(var, Some(Expr::Var(new)));
        let moved = self.test(guard).zip(self.test(body));
        self.set(var, old);
        moved.map(|(guard, body)| (new, Box::new(guard), Box::new(body)))
    }

    fn test(&mut self, test: &Test) -> Option<Test> {
        Some(match test {
            Test::And(parts) => Test::And(self.tests(parts)?),
            Test::Or(parts) => Test::Or(self.tests(parts)?),
            Test::Not(inner) => Test::Not(Box::new(self.test(inner)?)),
            Test::Compare { op, left, right } => Test::Compare {
                op: *op,
                left: self.expr(left)?,
                right: self.expr(right)?,
            },
            Test::Member { element, set } => Test::Member {
                element: self.expr(element)?,
                set: self.expr(set)?,
            },
            Test::Forall { var, ty, guard, body } => {
                let (var, guard, body) = self.quantified(*var, guard, body)?;
                let ty = *ty;
                Test::Forall { var, ty, guard, body }
            }
            Test::Exist { var, ty, guard, body } => {
                let (var, guard, body) = self.quantified(*var, guard, body)?;
                let ty = *ty;
                Test::Exist { var, ty, guard, body }
            }
            Test::Holds(expr) => Test::Holds(self.expr(expr)?),
        })
    }

    fn exprs(&self, exprs: &[Expr]) -> Option<Vec<Expr>> {
        exprs.iter().map(|e| self.expr(e)).collect()
    }

    fn expr(&self, expr: &Expr) -> Option<Expr> {
        let boxed = |e: &Expr| self.expr(e).map(Box::new);
        Some(match expr {
            Expr::Const(_) | Expr::GeometricCost | Expr::GeometricDuration => expr.clone(),
            Expr::Var(var) => self.map.get(var.index())?.clone()?,
            Expr::Attribute { base, attribute, args } => Expr::Attribute {
                base: boxed(base)?,
                attribute: *attribute,
                args: self.exprs(args)?.into(),
            },
            Expr::Size(inner) => Expr::Size(boxed(inner)?),
            Expr::List(parts) => Expr::List(self.exprs(parts)?),
            Expr::Arithmetic { op, left, right } => Expr::Arithmetic {
                op: *op,
                left: boxed(left)?,
                right: boxed(right)?,
            },
            Expr::Negate(inner) => Expr::Negate(boxed(inner)?),
            Expr::SetWith { set, element } => Expr::SetWith {
                set: boxed(set)?,
                element: boxed(element)?,
            },
            Expr::SetWithout { set, element } => Expr::SetWithout {
                set: boxed(set)?,
                element: boxed(element)?,
            },
            Expr::Request { request, args } => Expr::Request {
                request: *request,
                args: self.exprs(args)?,
            },
            Expr::Fact { fact, args } => Expr::Fact {
                fact: *fact,
                args: self.exprs(args)?,
            },
        })
    }
}
