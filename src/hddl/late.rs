//! Variables that are bound when the subtask that needs them comes, and not before.
//!
//! HDDL gives all variables of a method their values when the method is chosen. A variable that one later subtask alone
//! mentions, and whose own conditions no action can change, may as well get its value when that subtask is reached: the same
//! values pass, and what earlier subtasks decide is known by then instead of guessed. Where the subtask asks for something that
//! an earlier one may make true, it is put into a task of its own, which binds the variable; `ipc` leaves that task out again.
//!
//! Only where all networks of the pair are totally ordered: else anything may come in between, and when a task of its own is
//! taken up says nothing.

use super::ast::{Formula, Network, Scope, Step, Term, VarId};
use super::bodies::{Body, Known};
use super::formulas::{free, read, renamed};

/// A subtask with a task of its own around it.
#[derive(Debug)]
pub(super) struct Late {
    /// Its position in the network.
    pub step: usize,
    /// The variables of the method that the task is given.
    pub args: Vec<VarId>,
    /// The task: its parameters are those variables, in their order.
    pub body: Body,
}

/// Returns the subtasks of a method whose variables can wait, over its own literals.
pub(super) fn late(body: &Body, known: &Known, is_dynamic: &[bool]) -> Vec<Late> {
    let Some(chain) = body.network.chain() else {
        return Vec::new();
    };
    let uses = |step: &Step, v: VarId| step.args.contains(&Term::Var(v));
    let mut found = Vec::new();
    for (at, step) in chain.iter().enumerate().skip(1) {
        let own = &body.network.steps[*step];
        let before: Vec<_> = chain[..at].iter().map(|s| &body.network.steps[*s]).collect();
        let others = || (0..body.network.steps.len()).filter(|s| s != step);
        let is_elsewhere = |v: VarId| others().any(|s| uses(&body.network.steps[s], v));
        let about = |v: VarId| body.literals.iter().filter(move |f| free(f).contains(&v));
        let can_wait = |v: VarId| about(v).all(|f| read(f).iter().all(|p| !is_dynamic[*p]));
        let mut vars: Vec<VarId> = body.vars.clone();
        vars.retain(|v| uses(own, *v) && !is_elsewhere(*v) && can_wait(*v));
        // What they are compared with must be bound by then: a parameter, or what another subtask mentions as well.
        loop {
            let is_known = |v: &VarId| *v < body.n_params || vars.contains(v) || is_elsewhere(*v);
            let n = vars.len();
            let stay: Vec<VarId> = vars
                .iter()
                .copied()
                .filter(|v| about(*v).all(|f| free(f).iter().all(is_known)))
                .collect();
            vars = stay;
            if vars.len() == n {
                break;
            }
        }
        let is_decided_before = |v: &VarId| known.is_decided_before(own, *v, &before);
        if vars.iter().any(is_decided_before) {
            found.push(task(body, *step, &vars, known));
        }
    }
    found
}

/// Makes the task around a step that binds `vars`.
fn task(body: &Body, step: usize, vars: &[VarId], known: &Known) -> Late {
    let own = &body.network.steps[step];
    let literals: Vec<&Formula> = body
        .literals
        .iter()
        .filter(|f| free(f).iter().any(|v| vars.contains(v)))
        .collect();
    let in_step = own.args.iter().filter_map(|t| match t {
        Term::Var(v) => Some(*v),
        Term::Object(_) => None,
    });
    let mut args: Vec<VarId> = in_step.chain(literals.iter().flat_map(|f| free(f))).collect();
    args.retain(|v| !vars.contains(v));
    args.sort_unstable();
    args.dedup();
    // Parameters first, then what is bound, then what quantifiers bind.
    let mut order: Vec<VarId> = args.iter().chain(vars).copied().collect();
    let rest: Vec<VarId> = (0..body.scope.0.len()).filter(|v| !order.contains(v)).collect();
    order.extend(rest);
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, old)| place[*old] = new);
    let term = |v: VarId| Term::Var(place[v]);
    let network = Network {
        steps: vec![Step {
            task: own.task,
            args: own
                .args
                .iter()
                .map(|t| match t {
                    Term::Var(v) => term(*v),
                    Term::Object(_) => *t,
                })
                .collect(),
        }],
        after: vec![Vec::new()],
        constraints: Formula::default(),
    };
    let mut all: Vec<Formula> = literals.into_iter().map(|f| renamed(f, &term)).collect();
    for literal in known.pulled(&network) {
        if !all.contains(&literal) {
            all.push(literal);
        }
    }
    let scope = Scope(order.iter().map(|v| body.scope.0[*v].clone()).collect());
    let n_params = args.len();
    Late {
        step,
        args,
        body: Body {
            scope,
            n_params,
            vars: (n_params..n_params + vars.len()).collect(),
            literals: all,
            network,
            late: Vec::new(),
        },
    }
}
