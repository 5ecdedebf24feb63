//! Each method over the parameters of its task, and what its subtasks will ask for.
//!
//! HATP has one list of parameters for all decompositions of a method, so a method of HDDL is told in the names of its
//! task; a parameter that is narrower than the task's becomes a variable that is equal to it.
//!
//! What an action will ask when its turn comes, and nothing before it can make true, must hold at once: such literals are
//! *pulled up* into the method, where they prune before a variable is bound rather than after. They say nothing that the
//! actions do not say themselves, so no plan is lost and none is wrong.

use std::collections::BTreeSet;

use super::ast::{Formula, Kinds, Network, OBJECT, Pair, PredicateId, Scope, Step, TaskRef, Term, VarId, Variable};
use super::formulas::{conjuncts, free, is_literal, read, renamed};
use super::late::{Late, late};

/// A method, told over its task's parameters.
#[derive(Debug)]
pub(super) struct Body {
    /// The task's parameters first.
    pub scope: Scope,
    pub n_params: usize,
    /// Variables that stand for an object when the method is chosen; the others belong to quantifiers.
    pub vars: Vec<VarId>,
    /// What must hold.
    pub literals: Vec<Formula>,
    pub network: Network,
    /// Subtasks that bind variables of their own when their turn comes.
    pub late: Vec<Late>,
}

impl Body {
    /// Returns what a subtask is given: of one with a task of its own, what that is given.
    pub fn args(&self, step: usize) -> Vec<Term> {
        match self.late.iter().find(|l| l.step == step) {
            Some(late) => late.args.iter().map(|v| Term::Var(*v)).collect(),
            None => self.network.steps[step].args.clone(),
        }
    }
}

/// All methods of a pair.
#[derive(Debug)]
pub(super) struct Bodies {
    /// As [`Pair::methods`].
    pub methods: Vec<Body>,
    pub start: Body,
    /// Whether some network leaves an order open: then anything may happen between two subtasks.
    pub interleaves: bool,
    /// Whether some action changes the predicate.
    pub is_dynamic: Vec<bool>,
}

/// Rounds in which what a task asks for is handed up to those that begin with it. HEURISTIC: deeper chains of methods with
/// one and the same parameter are rare, and every round is sound.
const ROUNDS: usize = 6;

pub(super) fn bodies(pair: &Pair) -> Bodies {
    let mut methods: Vec<Body> = Vec::new();
    for method in &pair.methods {
        let task = &pair.tasks[method.task];
        let formulas = [&method.precondition, &method.network.constraints];
        methods.push(body(
            pair,
            &task.params,
            &method.task_args,
            (&method.scope, method.n_params),
            &formulas,
            &method.network,
        ));
    }
    let n_start = pair.start_scope.0.len();
    let n_start = n_start - quantified(&pair.start.constraints).len();
    let mut start = body(
        pair,
        &Scope::default(),
        &[],
        (&pair.start_scope, n_start),
        &[&pair.start.constraints],
        &pair.start,
    );
    let mut is_dynamic = vec![false; pair.predicates.len()];
    let changed = pair.actions.iter().flat_map(|a| &a.effects);
    changed.for_each(|e| is_dynamic[e.predicate] = true);
    let interleaves = methods.iter().chain([&start]).any(|m| m.network.chain().is_none());
    let mut known = Known::new(pair, &methods, interleaves);
    for _ in 0..ROUNDS {
        let pulled: Vec<Vec<Formula>> = methods.iter().map(|m| known.pulled(&m.network)).collect();
        let before = known.of_task.clone();
        known.hand_up(pair, &methods, &pulled);
        if known.of_task == before {
            break;
        }
    }
    if !interleaves {
        for body in methods.iter_mut().chain([&mut start]) {
            body.late = late(body, &known, &is_dynamic);
        }
    }
    // Where nothing is chosen there is nothing to prune.
    let start_to_bind = (!start.vars.is_empty()).then_some(&mut start);
    for method in methods.iter_mut().chain(start_to_bind) {
        for literal in known.pulled(&method.network) {
            if !method.literals.contains(&literal) {
                method.literals.push(literal);
            }
        }
    }
    Bodies {
        methods,
        start,
        interleaves,
        is_dynamic,
    }
}

fn quantified(formula: &Formula) -> Vec<VarId> {
    let mut found = Vec::new();
    super::formulas::visit(formula, &mut |part| {
        if let Formula::Forall(vars, _) | Formula::Exists(vars, _) = part {
            found.extend_from_slice(vars);
        }
    });
    found
}

/// Tells a method over its task's parameters.
fn body(
    pair: &Pair,
    params: &Scope,
    task_args: &[Term],
    (own, n_own): (&Scope, usize),
    formulas: &[&Formula],
    network: &Network,
) -> Body {
    let mut scope = params.clone();
    let mut literals: Vec<Formula> = Vec::new();
    let mut place: Vec<Option<VarId>> = vec![None; own.0.len()];
    for (param, arg) in task_args.iter().enumerate() {
        if let Term::Var(v) = arg
            && place[*v].is_none()
            && pair.is_within(&params.0[param].kinds, &own.0[*v].kinds)
        {
            place[*v] = Some(param);
        }
    }
    let mut vars = Vec::new();
    let place: Vec<VarId> = place
        .into_iter()
        .enumerate()
        .map(|(v, known)| {
            known.unwrap_or_else(|| {
                scope.0.push(own.0[v].clone());
                if v < n_own {
                    vars.push(scope.0.len() - 1);
                }
                scope.0.len() - 1
            })
        })
        .collect();
    let term = |v: VarId| Term::Var(place[v]);
    for (param, arg) in task_args.iter().enumerate() {
        let arg = match arg {
            Term::Var(v) => term(*v),
            Term::Object(_) => *arg,
        };
        if arg != Term::Var(param) {
            literals.push(Formula::Equal(arg, Term::Var(param)));
        }
    }
    for formula in formulas {
        literals.extend(conjuncts(formula).into_iter().map(|f| renamed(f, &term)));
    }
    let mut body = Body {
        n_params: params.0.len(),
        scope,
        vars,
        literals,
        network: Network {
            steps: Vec::new(),
            after: network.after.clone(),
            constraints: Formula::default(),
        },
        late: Vec::new(),
    };
    for step in &network.steps {
        let args = step.args.iter().map(|t| match t {
            Term::Var(v) => term(*v),
            Term::Object(_) => *t,
        });
        let wanted = params_of(pair, step.task);
        let args = args
            .zip(wanted)
            .map(|(arg, wanted)| narrowed(pair, &mut body, arg, &wanted.kinds));
        let args = args.collect();
        body.network.steps.push(Step { task: step.task, args });
    }
    let one_of = |v: VarId, body: &Body| {
        let kinds = &body.scope.0[v].kinds;
        (kinds.0.len() > 1).then(|| Formula::Is(Term::Var(v), kinds.clone()))
    };
    let named: Vec<VarId> = (0..body.n_params).chain(body.vars.iter().copied()).collect();
    let tests: Vec<Formula> = named.into_iter().filter_map(|v| one_of(v, &body)).collect();
    body.literals.extend(tests);
    let mut seen: Vec<Formula> = Vec::new();
    body.literals.retain(|literal| {
        let is_new = !seen.contains(literal);
        if is_new {
            seen.push(literal.clone());
        }
        is_new
    });
    body
}

fn params_of(pair: &Pair, task: TaskRef) -> &[Variable] {
    match task {
        TaskRef::Action(a) => &pair.actions[a].scope.0[..pair.actions[a].n_params],
        TaskRef::Task(t) => &pair.tasks[t].params.0,
    }
}

/// Returns the argument as one of the types that a subtask wants: a variable of the method becomes narrower, a parameter of
/// the task gets a variable that is equal to it.
fn narrowed(pair: &Pair, body: &mut Body, arg: Term, wanted: &Kinds) -> Term {
    let Term::Var(v) = arg else { return arg };
    let has = &body.scope.0[v].kinds;
    if pair.is_within(has, wanted) {
        return arg;
    }
    let one = has
        .0
        .iter()
        .filter(|t| wanted.0.iter().any(|w| pair.is_subtype(**t, *w)));
    let other = wanted
        .0
        .iter()
        .filter(|w| has.0.iter().any(|t| pair.is_subtype(**w, *t)));
    let mut kinds: Vec<usize> = one.chain(other).copied().collect();
    kinds.sort_unstable();
    kinds.dedup();
    if kinds.is_empty() {
        kinds.push(OBJECT);
    }
    let kinds = Kinds(kinds);
    if v >= body.n_params {
        body.scope.0[v].kinds = kinds;
        return arg;
    }
    let same = |new: &&VarId| {
        body.scope.0[**new].kinds == kinds && body.literals.contains(&Formula::Equal(Term::Var(**new), arg))
    };
    if let Some(new) = body.vars.iter().find(same) {
        return Term::Var(*new);
    }
    let new = body.scope.0.len();
    let name = body.scope.0[v].name.clone();
    body.scope.0.push(Variable { name, kinds });
    body.vars.push(new);
    body.literals.push(Formula::Equal(Term::Var(new), arg));
    Term::Var(new)
}

/// What tasks ask for and what they may change.
pub(super) struct Known {
    /// Over the parameters.
    of_action: Vec<Vec<Formula>>,
    of_task: Vec<Vec<Formula>>,
    action_changes: Vec<BTreeSet<Change>>,
    task_changes: Vec<BTreeSet<Change>>,
    interleaves: bool,
}

/// A predicate that is made true, or false.
type Change = (PredicateId, bool);

/// Says whether a change may make a literal true.
fn may_be_made_true(literal: &Formula, changes: &BTreeSet<Change>) -> bool {
    let to = !matches!(literal, Formula::Not(_));
    read(literal).iter().any(|p| changes.contains(&(*p, to)))
}

impl Known {
    fn new(pair: &Pair, methods: &[Body], interleaves: bool) -> Self {
        let mut known = Known {
            of_action: Vec::new(),
            of_task: vec![Vec::new(); pair.tasks.len()],
            action_changes: Vec::new(),
            task_changes: vec![BTreeSet::new(); pair.tasks.len()],
            interleaves,
        };
        for action in &pair.actions {
            let literals = conjuncts(&action.precondition).into_iter().filter(|f| is_literal(f));
            known.of_action.push(literals.cloned().collect());
            let changed = action.effects.iter().map(|e| (e.predicate, e.adds));
            known.action_changes.push(changed.collect());
        }
        // What a task may change, until nothing is added.
        loop {
            let mut has_grown = false;
            for (method, body) in pair.methods.iter().zip(methods) {
                let changed: BTreeSet<Change> = body
                    .network
                    .steps
                    .iter()
                    .flat_map(|s| known.changes(s.task).iter().copied())
                    .collect();
                let of = &mut known.task_changes[method.task];
                let n = of.len();
                of.extend(changed);
                has_grown |= of.len() > n;
            }
            if !has_grown {
                return known;
            }
        }
    }

    fn changes(&self, task: TaskRef) -> &BTreeSet<Change> {
        match task {
            TaskRef::Action(a) => &self.action_changes[a],
            TaskRef::Task(t) => &self.task_changes[t],
        }
    }

    /// Says whether a step asks for something of a variable that a step before it may make true.
    pub fn is_decided_before(&self, step: &Step, var: VarId, before: &[&Step]) -> bool {
        let asked = self.asked(step.task).iter().map(|f| renamed(f, &|v| step.args[v]));
        let about = asked.filter(|f| free(f).contains(&var));
        let mut decided = about.filter(|f| before.iter().any(|b| may_be_made_true(f, self.changes(b.task))));
        decided.next().is_some()
    }

    fn asked(&self, task: TaskRef) -> &[Formula] {
        match task {
            TaskRef::Action(a) => &self.of_action[a],
            TaskRef::Task(t) => &self.of_task[t],
        }
    }

    /// Returns what a network asks for at its very beginning, each once.
    pub fn pulled(&self, network: &Network) -> Vec<Formula> {
        let chain = if self.interleaves { None } else { network.chain() };
        let mut changed: BTreeSet<Change> = match chain {
            Some(_) => BTreeSet::new(),
            // Then only what no action makes true is sure: what is false by then stays so.
            None => self.action_changes.iter().flatten().copied().collect(),
        };
        let order = chain.unwrap_or_else(|| (0..network.steps.len()).collect());
        let mut found: Vec<Formula> = Vec::new();
        for at in order {
            let step = &network.steps[at];
            for literal in self.asked(step.task) {
                if may_be_made_true(literal, &changed) {
                    continue;
                }
                let literal = renamed(literal, &|v| step.args[v]);
                if !found.contains(&literal) {
                    found.push(literal);
                }
            }
            changed.extend(self.changes(step.task));
        }
        found
    }

    /// Finds what all methods of a task ask for, over its parameters.
    fn hand_up(&mut self, pair: &Pair, methods: &[Body], pulled: &[Vec<Formula>]) {
        let mut of_task: Vec<Option<Vec<Formula>>> = vec![None; pair.tasks.len()];
        for ((method, body), pulled) in pair.methods.iter().zip(methods).zip(pulled) {
            let own = body.literals.iter().filter(|f| is_literal(f));
            let all: Vec<&Formula> = own.chain(pulled).collect();
            let of = &mut of_task[method.task];
            match of {
                Some(known) => known.retain(|f| all.contains(&f)),
                None => {
                    let over_params = all.into_iter().filter(|f| free(f).iter().all(|v| *v < body.n_params));
                    *of = Some(over_params.cloned().collect());
                }
            }
        }
        self.of_task = of_task.into_iter().map(Option::unwrap_or_default).collect();
    }
}
