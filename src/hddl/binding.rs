//! In which order a method's variables are bound, and where each of its literals is tested.
//!
//! HDDL leaves the order open. Here the variable comes first for which the fewest objects are expected, judged by the facts
//! of the start; every literal is tested as soon as its variables are bound. A variable that no subtask mentions is not
//! bound but asked for (`EXIST`): it would only find the same plan once more.

use indexmap::IndexSet;

use super::ast::{Formula, Pair, PredicateId, Scope, Term, VarId};
use super::bodies::Body;
use super::formulas::free;

/// A method's tests and bindings, in their order.
#[derive(Debug, Default)]
pub(super) struct Bindings {
    /// About the parameters alone.
    pub preconditions: Vec<Formula>,
    pub selects: Vec<Select>,
}

#[derive(Debug)]
pub(super) struct Select {
    pub var: VarId,
    pub filter: Vec<Formula>,
}

/// How many facts there are at the start.
#[derive(Debug)]
pub(super) struct Counts {
    of_type: Vec<usize>,
    of_predicate: Vec<usize>,
    /// How many objects stand at each position of a predicate.
    at: Vec<Vec<usize>>,
}

impl Counts {
    pub fn new(pair: &Pair) -> Self {
        let mut at: Vec<Vec<IndexSet<usize>>> = Vec::new();
        for predicate in &pair.predicates {
            at.push(vec![IndexSet::new(); predicate.params.len()]);
        }
        let mut of_predicate = vec![0; pair.predicates.len()];
        for fact in &pair.facts {
            of_predicate[fact.predicate] += 1;
            for (position, object) in fact.args.iter().enumerate() {
                at[fact.predicate][position].insert(*object);
            }
        }
        let at = at.into_iter().map(|p| p.iter().map(IndexSet::len).collect()).collect();
        let mut of_type = vec![0; pair.types.len()];
        for object in &pair.objects {
            pair.lineage(object.ty).for_each(|t| of_type[t] += 1);
        }
        Counts {
            of_type,
            of_predicate,
            at,
        }
    }

    fn of_scope(&self, pair: &Pair, scope: &Scope, var: VarId) -> f64 {
        let kinds = scope.0[var].kinds.0.iter();
        let n: usize = kinds.map(|t| self.of_type[*t]).sum();
        n.min(pair.objects.len()) as f64
    }

    /// Returns how many objects are expected at a position of a predicate, where those of some others are known.
    fn expected(&self, predicate: PredicateId, position: usize, known: &[usize]) -> f64 {
        let n = self.of_predicate[predicate] as f64;
        let at = &self.at[predicate];
        let combinations: f64 = known.iter().map(|p| at[*p].max(1) as f64).product();
        (n / combinations).min(at[position] as f64).max(1.0)
    }
}

/// How many times fewer objects an intermediate variable must promise than any that a subtask needs, to be bound before it.
const WORTH_A_CHOICE: f64 = 4.0;

/// Orders the variables of a method.
pub(super) fn bindings(pair: &Pair, body: &Body, is_dynamic: &[bool], counts: &Counts) -> Bindings {
    let needed: Vec<VarId> = {
        let args = (0..body.network.steps.len()).flat_map(|step| body.args(step));
        args.filter_map(|t| match t {
            Term::Var(v) => Some(v),
            Term::Object(_) => None,
        })
        .collect()
    };
    let mut order = Order {
        pair,
        body,
        is_dynamic,
        counts,
        bound: (0..body.n_params).collect(),
        left: body.literals.iter().map(|f| (f.clone(), free(f))).collect(),
    };
    let mut found = Bindings {
        preconditions: order.decided(None),
        selects: Vec::new(),
    };
    let mut unbound = body.vars.clone();
    while let Some(var) = order.next(&unbound, &needed) {
        unbound.retain(|v| *v != var);
        order.bound.push(var);
        let filter = order.decided(Some(var));
        found.selects.push(Select { var, filter });
    }
    order.ask_for(&unbound, &mut found);
    found
}

struct Order<'a> {
    pair: &'a Pair,
    body: &'a Body,
    is_dynamic: &'a [bool],
    counts: &'a Counts,
    bound: Vec<VarId>,
    /// Literals that are not tested yet, with their variables.
    left: Vec<(Formula, Vec<VarId>)>,
}

impl Order<'_> {
    /// Takes out the literals whose variables are bound, those first that may find a variable without a look at all objects.
    fn decided(&mut self, var: Option<VarId>) -> Vec<Formula> {
        let (mut now, later): (Vec<_>, Vec<_>) = std::mem::take(&mut self.left)
            .into_iter()
            .partition(|(_, free)| free.iter().all(|v| self.bound.contains(v)));
        self.left = later;
        let rank = |formula: &Formula| match formula {
            Formula::Equal(..) => 0,
            // A set in which the variable is looked up comes before a set of the variable.
            Formula::Atom(_, terms) if terms.len() > 1 && terms.last() == var.map(Term::Var).as_ref() => 1,
            Formula::Atom(..) => 2,
            Formula::Is(..) => 3,
            Formula::Not(_) => 4,
            Formula::And(_) | Formula::Or(_) | Formula::Imply(..) | Formula::Forall(..) | Formula::Exists(..) => 5,
        };
        now.sort_by_key(|(formula, _)| rank(formula));
        now.into_iter().map(|(formula, _)| formula).collect()
    }

    /// Returns the variable to bind next; `None` when all that subtasks need are bound.
    fn next(&self, unbound: &[VarId], needed: &[VarId]) -> Option<VarId> {
        let best = |is_needed: bool| {
            let of = unbound.iter().filter(|v| needed.contains(v) == is_needed);
            let mut best: Option<(f64, VarId)> = None;
            for var in of {
                let n = self.expected(*var);
                if best.is_none_or(|(least, _)| n < least) {
                    best = Some((n, *var));
                }
            }
            best
        };
        let (n, var) = best(true)?;
        // What leads to a needed variable may be worth a choice of its own.
        let leads = |v: VarId| {
            let with = |(_, free): &&(Formula, Vec<VarId>)| free.contains(&v);
            let others = self.left.iter().filter(with).flat_map(|(_, free)| free);
            others.into_iter().any(|o| *o != v && unbound.contains(o))
        };
        match best(false) {
            Some((fewer, other)) if fewer * WORTH_A_CHOICE < n && leads(other) => Some(other),
            _ => Some(var),
        }
    }

    /// Returns how many objects are expected to pass for a variable.
    fn expected(&self, var: VarId) -> f64 {
        let all = self.counts.of_scope(self.pair, &self.body.scope, var);
        let known = |term: &Term| match term {
            Term::Var(v) => self.bound.contains(v),
            Term::Object(_) => true,
        };
        let is_var = |term: &Term| *term == Term::Var(var);
        let of = |formula: &Formula| match formula {
            Formula::Equal(one, other) => match (is_var(one), is_var(other)) {
                (true, false) if known(other) => 1.0,
                (false, true) if known(one) => 1.0,
                _ => all,
            },
            Formula::Atom(predicate, terms) => {
                let Some(position) = terms.iter().position(is_var) else {
                    return all;
                };
                let others: Vec<usize> = (0..terms.len()).filter(|p| known(&terms[*p])).collect();
                // The start says little of what changes.
                if self.is_dynamic[*predicate] && self.counts.of_predicate[*predicate] == 0 {
                    return if others.is_empty() { all / 2.0 } else { 2.0 };
                }
                self.counts.expected(*predicate, position, &others)
            }
            Formula::And(_)
            | Formula::Or(_)
            | Formula::Not(_)
            | Formula::Imply(..)
            | Formula::Forall(..)
            | Formula::Exists(..)
            | Formula::Is(..) => all,
        };
        let with = self.left.iter().filter(|(_, free)| free.contains(&var));
        with.map(|(formula, _)| of(formula)).fold(all, f64::min)
    }

    /// Asks for variables that no subtask needs, as soon as what they are compared with is bound.
    fn ask_for(&mut self, unbound: &[VarId], found: &mut Bindings) {
        let mut waiting: Vec<VarId> = unbound.to_vec();
        while let Some(first) = waiting.first().copied() {
            // Those that are compared with one another are asked for together.
            let mut group = vec![first];
            loop {
                let touches = |free: &[VarId]| free.iter().any(|v| group.contains(v));
                let new = self
                    .left
                    .iter()
                    .filter(|(_, free)| touches(free))
                    .flat_map(|(_, free)| free);
                let new = new.copied().find(|v| waiting.contains(v) && !group.contains(v));
                match new {
                    Some(new) => group.push(new),
                    None => break,
                }
            }
            waiting.retain(|v| !group.contains(v));
            let (of_group, others): (Vec<_>, Vec<_>) = std::mem::take(&mut self.left)
                .into_iter()
                .partition(|(_, free)| free.iter().any(|v| group.contains(v)));
            self.left = of_group;
            let n_bound = self.bound.len();
            let mut order = Vec::new();
            while let Some(var) = self.next(&group, &group) {
                group.retain(|v| *v != var);
                self.bound.push(var);
                order.push(var);
            }
            self.bound.truncate(n_bound);
            let all = std::mem::replace(&mut self.left, others);
            let there_is_one = |v: &VarId| self.counts.of_scope(self.pair, &self.body.scope, *v) > 0.0;
            if all.is_empty() && order.iter().all(there_is_one) {
                continue;
            }
            let outside: Vec<VarId> = all.iter().flat_map(|(_, free)| free).copied().collect();
            let formulas = all.into_iter().map(|(formula, _)| formula).collect();
            let asked = Formula::Exists(order.clone(), Box::new(Formula::And(formulas)));
            let last = found
                .selects
                .iter_mut()
                .rev()
                .find(|s| outside.contains(&s.var) && !order.contains(&s.var));
            match last {
                Some(select) => select.filter.push(asked),
                None => found.preconditions.push(asked),
            }
        }
    }
}
