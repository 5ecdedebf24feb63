//! Effects.
//!
//! PDDL reads every condition in the state before the action, takes away what is deleted and then adds what is added: an atom
//! that is deleted and added holds. HATP's effects run in order and read what the ones before them have left. So deletions
//! are written first, and where a condition reads what the action changes, it reads a copy that is made before.

use std::fmt::Write;

use super::super::ast::{Action, Effect, Formula, Pair, Term};
use super::super::formulas::{conjuncts, free, read, visit};
use super::super::names::Namer;
use super::Writer;
use super::tests::Tests;

/// Returns the predicates that conditions of an action's effects read, and that the action changes.
fn late(action: &Action) -> Vec<usize> {
    let conditions = action.effects.iter().flat_map(|e| read(&e.condition));
    let mut late: Vec<usize> = conditions
        .filter(|p| action.effects.iter().any(|e| e.predicate == *p))
        .collect();
    late.sort_unstable();
    late.dedup();
    late
}

/// Returns the predicates that need a copy.
pub(super) fn read_late(pair: &Pair) -> Vec<usize> {
    let mut found: Vec<usize> = pair.actions.iter().flat_map(late).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// The first and the second half of what is written: a deletion never undoes an addition.
fn passes(action: &Action) -> Vec<Vec<&Effect>> {
    let of = |adds: bool| action.effects.iter().filter(move |e| e.adds == adds);
    let is_both = of(true).any(|e| of(false).any(|other| other.predicate == e.predicate));
    match is_both {
        true => vec![of(false).collect(), of(true).collect()],
        false => vec![action.effects.iter().collect()],
    }
}

impl Writer<'_> {
    pub(super) fn effects(&self, action: &Action, vars: &[String]) -> String {
        let late = late(action);
        let mut out = String::new();
        for predicate in &late {
            self.copy(action, *predicate, vars, true, &mut out);
        }
        for pass in passes(action) {
            let mut rest = &pass[..];
            while let Some(first) = rest.first() {
                let is_same = |e: &&Effect| e.forall == first.forall && e.condition == first.condition;
                let n = rest.iter().take_while(|e| is_same(e)).count();
                let (group, later) = rest.split_at(n);
                rest = later;
                self.group(action, group, vars, &late, &mut out);
            }
        }
        for predicate in &late {
            self.copy(action, *predicate, vars, false, &mut out);
        }
        out
    }

    /// Writes effects that have the same condition.
    fn group(&self, action: &Action, group: &[&Effect], vars: &[String], late: &[usize], out: &mut String) {
        let Some(first) = group.first() else { return };
        let tests = |formula: &Formula| {
            let mut tests = Tests::new(self, &action.scope, vars).before(late);
            tests.test(formula);
            tests.out.replace('\n', " ")
        };
        let mut left = conjuncts(&first.condition);
        for (at, var) in first.forall.iter().enumerate() {
            let kinds = &action.scope.0[*var].kinds;
            let mut guard = match kinds.0.len() {
                1 => String::new(),
                _ => tests(&Formula::Is(Term::Var(*var), kinds.clone())),
            };
            // Each test stands at the first variable that makes it complete.
            let later = &first.forall[at + 1..];
            let (now, rest): (Vec<&Formula>, Vec<&Formula>) =
                left.iter().partition(|f| !later.iter().any(|v| free(f).contains(v)));
            left = rest;
            now.into_iter().for_each(|f| guard += &tests(f));
            let ty = &self.types[self.pair.joined(kinds)];
            let _ = write!(out, "FORALL({ty} {}, {{{}}}, {{", vars[*var], guard.trim_end());
        }
        let n_open = first.forall.len();
        let is_open = n_open == 0 && !left.is_empty();
        if is_open {
            let _ = write!(out, "IF {{ {}}} {{ ", tests(&first.condition));
        }
        for effect in group {
            let args: Vec<&str> = effect.args.iter().map(|t| self.term(*t, vars)).collect();
            let name = &self.predicates[effect.predicate];
            let text = match (&args[..], effect.adds) {
                ([] | [_], true) => format!("{} = true;", self.attribute(name, &args)),
                ([] | [_], false) => format!("{} = NULL;", self.attribute(name, &args)),
                ([owner @ .., value], true) => format!("{} <<= {value};", self.attribute(name, owner)),
                ([owner @ .., value], false) => format!("{} =>> {value};", self.attribute(name, owner)),
            };
            out.push_str(&text);
            if n_open == 0 && !is_open {
                out.push('\n');
            }
        }
        out.push_str(&"});".repeat(n_open));
        if is_open {
            out.push('}');
        }
        if n_open > 0 || is_open {
            out.push('\n');
        }
    }

    /// Copies a predicate before the effects, or empties the copy behind them: two states that differ in it alone are the same.
    fn copy(&self, action: &Action, predicate: usize, vars: &[String], is_before: bool, out: &mut String) {
        let positions = &self.positions[predicate];
        let n_keys = match positions.len() {
            0 | 1 => positions.len(),
            n => n - 1,
        };
        // Where all that is read belongs to the action's own arguments, theirs is enough.
        let mut keys: Vec<&[Term]> = Vec::new();
        for effect in &action.effects {
            visit(&effect.condition, &mut |part| {
                if let Formula::Atom(of, args) = part
                    && *of == predicate
                    && !keys.contains(&&args[..n_keys])
                {
                    keys.push(&args[..n_keys]);
                }
            });
        }
        let is_param = |t: &Term| match t {
            Term::Var(v) => *v < action.n_params,
            Term::Object(_) => true,
        };
        if keys.iter().all(|key| key.iter().all(is_param)) {
            for key in keys {
                let key: Vec<&str> = key.iter().map(|t| self.term(*t, vars)).collect();
                let _ = writeln!(out, "{}", self.copied(predicate, &key, is_before));
            }
            return;
        }
        // No entity is hidden by the name of a key.
        let taken = |name: &str| self.entity_names.has(name);
        let mut namer = Namer::default();
        let keys: Vec<String> = (0..n_keys).map(|_| namer.fresh("key", &taken)).collect();
        for (key, ty) in keys.iter().zip(positions) {
            let _ = write!(out, "FORALL({} {key}, {{}}, {{", self.types[*ty]);
        }
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let text = self.copied(predicate, &keys, is_before);
        let _ = writeln!(out, "{text}{}", "});".repeat(keys.len()));
    }

    fn copied(&self, predicate: usize, keys: &[&str], is_before: bool) -> String {
        let copy = self.attribute(&self.before_attributes[&predicate], keys);
        let value = match (is_before, self.positions[predicate].len()) {
            (true, _) => self.attribute(&self.predicates[predicate], keys),
            (false, 0 | 1) => "NULL".to_owned(),
            (false, _) => "[]".to_owned(),
        };
        format!("{copy} = {value};")
    }
}
