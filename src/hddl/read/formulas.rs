//! Preconditions, goals and effects.

use super::super::ast::{Cost, Effect, Formula, Kinds, Scope, Term, VarId};
use super::super::problems;
use super::super::tree::Tree;
use super::{Reader, key};

/// Variables with their names in small letters; of two with one name the later one is seen.
pub(super) type Visible = Vec<(String, VarId)>;

/// Brackets that a formula may open in HATP, which has 64 and needs some around it.
const MAX_BRACKETS: usize = 48;

/// Words that compare numbers.
const COMPARISONS: &[&str] = &["<", ">", "<=", ">="];

/// Parts of formulas that other planners know.
const NOT_SUPPORTED: &[&str] = &[
    "preference",
    "at-start",
    "over-all",
    "at-end",
    "always",
    "sometime",
    "within",
];

/// Effects on numbers other than a growing total cost.
const NUMERIC_EFFECTS: &[&str] = &["assign", "decrease", "scale-up", "scale-down"];

impl Reader<'_> {
    /// Reads a condition; what is wrong counts as what always holds.
    pub(super) fn formula(&mut self, tree: &Tree<'_>, scope: &mut Scope, visible: &mut Visible) -> Formula {
        let read = self.condition(tree, scope, visible);
        if brackets(&read) > MAX_BRACKETS {
            self.problems.push(problems::deep_formula(tree.span));
            return Formula::default();
        }
        read
    }

    // The depth is that of the lists, which has a cap.
    fn condition(&mut self, tree: &Tree<'_>, scope: &mut Scope, visible: &mut Visible) -> Formula {
        let Some(parts) = tree.list() else {
            self.problems
                .push(problems::expected("a condition such as `(at ?x ?y)`", tree.span));
            return Formula::default();
        };
        let Some((head, rest)) = tree.headed() else {
            if !parts.is_empty() {
                self.problems
                    .push(problems::expected("a predicate, `and`, `or`, `not` ...", tree.span));
            }
            return Formula::default();
        };
        let word = head.word().map(key).unwrap_or_default();
        match (word.as_str(), rest) {
            ("and", _) => Formula::And(rest.iter().map(|t| self.condition(t, scope, visible)).collect()),
            ("or", _) => Formula::Or(rest.iter().map(|t| self.condition(t, scope, visible)).collect()),
            ("not", [inner]) => Formula::Not(Box::new(self.condition(inner, scope, visible))),
            ("imply", [one, other]) => Formula::Imply(
                Box::new(self.condition(one, scope, visible)),
                Box::new(self.condition(other, scope, visible)),
            ),
            ("forall" | "exists", [vars, body]) => {
                let n_visible = visible.len();
                let vars = self.quantified(vars, scope, visible);
                let body = Box::new(self.condition(body, scope, visible));
                visible.truncate(n_visible);
                match word.as_str() {
                    "forall" => Formula::Forall(vars, body),
                    _ => Formula::Exists(vars, body),
                }
            }
            ("not" | "imply" | "forall" | "exists", _) => {
                let n = if word == "not" { 1 } else { 2 };
                self.problems
                    .push(problems::wrong_count(&word, n, rest.len(), head.span));
                Formula::default()
            }
            ("=", [one, other]) if one.word().is_some() && other.word().is_some() => {
                match (self.term(one, scope, visible), self.term(other, scope, visible)) {
                    (Some(one), Some(other)) => Formula::Equal(one, other),
                    _ => Formula::default(),
                }
            }
            ("=", [_, _]) => self.no_numbers(tree),
            ("=", _) => {
                self.problems.push(problems::wrong_count("=", 2, rest.len(), head.span));
                Formula::default()
            }
            (word, _) if COMPARISONS.contains(&word) => self.no_numbers(tree),
            (word, _) if NOT_SUPPORTED.contains(&word) && !self.predicates.contains_key(word) => {
                let what = format!("`{word}` is");
                self.problems
                    .push(problems::not_supported(&what, head.span, "write it as a precondition"));
                Formula::default()
            }
            ("sortof", [var, rest @ ..]) if !self.predicates.contains_key("sortof") => {
                let term = self.term(var, scope, visible);
                let ty = rest.iter().find(|t| !t.is("-"));
                let kinds = self.kinds(ty);
                term.map_or_else(Formula::default, |term| Formula::Is(term, kinds))
            }
            _ => self.atom(tree, scope, visible).unwrap_or_default(),
        }
    }

    fn no_numbers(&mut self, tree: &Tree<'_>) -> Formula {
        let help = "numbers count as costs alone";
        self.problems
            .push(problems::not_supported("a test of numbers is", tree.span, help));
        Formula::default()
    }

    fn quantified(&mut self, tree: &Tree<'_>, scope: &mut Scope, visible: &mut Visible) -> Vec<VarId> {
        match tree.list() {
            Some(parts) => self.variables(parts, scope, visible),
            None => {
                self.problems.push(problems::expected(
                    "a list of variables such as `(?x - thing)`",
                    tree.span,
                ));
                Vec::new()
            }
        }
    }

    /// Reads `(p a ?b)`.
    pub(super) fn atom(&mut self, tree: &Tree<'_>, scope: &Scope, visible: &Visible) -> Option<Formula> {
        let (head, rest) = tree.headed()?;
        let name = head.word()?;
        let Some(predicate) = self.predicates.get(&key(name)).copied() else {
            let known = self.pair.predicates.iter().map(|p| p.name.text.as_str());
            self.problems.push(problems::unknown_predicate(name, head.span, known));
            // Its arguments are looked at all the same.
            rest.iter().for_each(|t| {
                self.term(t, scope, visible);
            });
            return None;
        };
        let wanted = self.pair.predicates[predicate].params.clone();
        let args = self.args(name, head, rest, &wanted, scope, visible)?;
        Some(Formula::Atom(predicate, args))
    }

    /// Reads as many arguments as there are types.
    pub(super) fn args(
        &mut self,
        of: &str,
        head: &Tree<'_>,
        rest: &[Tree<'_>],
        wanted: &[Kinds],
        scope: &Scope,
        visible: &Visible,
    ) -> Option<Vec<Term>> {
        let terms: Vec<Option<Term>> = rest.iter().map(|t| self.term(t, scope, visible)).collect();
        if terms.len() != wanted.len() {
            self.problems
                .push(problems::wrong_count(of, wanted.len(), terms.len(), head.span));
            return None;
        }
        let terms: Option<Vec<Term>> = terms.into_iter().collect();
        let terms = terms?;
        for ((term, tree), wanted) in terms.iter().zip(rest).zip(wanted) {
            self.fits(*term, scope, tree, wanted, of);
        }
        Some(terms)
    }

    /// Reads a variable or an object.
    pub(super) fn term(&mut self, tree: &Tree<'_>, scope: &Scope, visible: &Visible) -> Option<Term> {
        let Some(word) = tree.word() else {
            self.problems
                .push(problems::expected("a variable or an object", tree.span));
            return None;
        };
        let name = key(word);
        if word.starts_with('?') {
            let found = visible.iter().rev().find(|(n, _)| *n == name);
            if found.is_none() {
                let known = visible.iter().map(|(_, v)| scope.0[*v].name.text.as_str());
                self.problems
                    .push(problems::unknown_name("variable", word, tree.span, known));
            }
            return found.map(|(_, v)| Term::Var(*v));
        }
        let found = self.objects.get(&name).copied();
        if found.is_none() {
            let known = self.pair.objects.iter().map(|o| o.name.text.as_str());
            let problem = problems::unknown_name("object", word, tree.span, known);
            let forgotten = visible.iter().any(|(n, _)| n.strip_prefix('?') == Some(&name));
            self.problems.push(match forgotten {
                true => problem.help(format!("did you mean `?{word}`?")),
                false => problem,
            });
        }
        found.map(Term::Object)
    }

    /// Reads the effects of an action.
    pub(super) fn effects(
        &mut self,
        tree: &Tree<'_>,
        scope: &mut Scope,
        visible: &mut Visible,
    ) -> (Vec<Effect>, Vec<Cost>) {
        let mut read = Effects::default();
        self.effect(tree, scope, visible, &mut read);
        (read.effects, read.costs)
    }

    // The depth is that of the lists, which has a cap.
    fn effect(&mut self, tree: &Tree<'_>, scope: &mut Scope, visible: &mut Visible, read: &mut Effects) {
        let Some((head, rest)) = tree.headed() else {
            if tree.list().is_none_or(|l| !l.is_empty()) {
                self.problems
                    .push(problems::expected("an effect such as `(at ?x ?y)`", tree.span));
            }
            return;
        };
        let word = head.word().map(key).unwrap_or_default();
        match (word.as_str(), rest) {
            ("and", _) => rest.iter().for_each(|t| self.effect(t, scope, visible, read)),
            ("not", [inner]) => self.effect_literal(inner, false, scope, visible, read),
            ("when", [condition, inner]) => {
                let condition = self.formula(condition, scope, visible);
                read.conditions.push(condition);
                self.effect(inner, scope, visible, read);
                read.conditions.pop();
            }
            ("forall", [vars, inner]) => {
                let (n_visible, n_vars) = (visible.len(), read.forall.len());
                let vars = self.quantified(vars, scope, visible);
                read.forall.extend(vars);
                if 2 * read.forall.len() > MAX_BRACKETS / 2 {
                    self.problems.push(problems::deep_formula(tree.span));
                } else {
                    self.effect(inner, scope, visible, read);
                }
                read.forall.truncate(n_vars);
                visible.truncate(n_visible);
            }
            ("not" | "when" | "forall", _) => {
                let n = if word == "not" { 1 } else { 2 };
                self.problems
                    .push(problems::wrong_count(&word, n, rest.len(), head.span));
            }
            ("increase", [what, amount]) => {
                let is_total = what
                    .headed()
                    .is_some_and(|(f, args)| f.is("total-cost") && args.is_empty());
                if !is_total || !read.conditions.is_empty() || !read.forall.is_empty() {
                    let help = "only `(increase (total-cost) ...)` is, and not below `when` or `forall`";
                    self.problems
                        .push(problems::not_supported("this effect on numbers is", tree.span, help));
                } else {
                    read.costs.extend(self.cost(amount, scope, visible));
                }
            }
            (word, _) if NUMERIC_EFFECTS.contains(&word) && !self.predicates.contains_key(word) => {
                let help = "only `(increase (total-cost) ...)` is";
                let what = format!("`{word}` is");
                self.problems.push(problems::not_supported(&what, head.span, help));
            }
            ("or" | "exists" | "imply" | "oneof", _) if !self.predicates.contains_key(&word) => {
                let help = "an effect is a predicate, `not`, `and`, `forall` or `when`";
                let what = format!("`{word}` in an effect is");
                self.problems.push(problems::not_supported(&what, head.span, help));
            }
            _ => self.effect_literal(tree, true, scope, visible, read),
        }
    }

    fn effect_literal(&mut self, tree: &Tree<'_>, adds: bool, scope: &Scope, visible: &Visible, read: &mut Effects) {
        if tree.headed().is_none() {
            self.problems
                .push(problems::expected("an effect such as `(at ?x ?y)`", tree.span));
        }
        if let Some(Formula::Atom(predicate, args)) = self.atom(tree, scope, visible) {
            read.effects.push(Effect {
                forall: read.forall.clone(),
                condition: match &read.conditions[..] {
                    [one] => one.clone(),
                    all => Formula::And(all.to_vec()),
                },
                adds,
                predicate,
                args,
            });
        }
    }

    /// Reads what is added to the total cost: a number, or a function.
    fn cost(&mut self, tree: &Tree<'_>, scope: &Scope, visible: &Visible) -> Option<Cost> {
        if let Some(word) = tree.word() {
            let number = number(word);
            if number.is_none_or(|x| x < 0.0) {
                self.problems.push(problems::expected("a number, 0 or more", tree.span));
            }
            return number.map(Cost::Number);
        }
        let (head, rest) = tree.headed()?;
        let name = head.word()?;
        if ["+", "-", "*", "/"].contains(&name) {
            let help = "write one `increase` for each part";
            self.problems
                .push(problems::not_supported("arithmetic in a cost is", tree.span, help));
            return None;
        }
        let (function, args) = self.function(name, head, rest, scope, visible)?;
        Some(Cost::Function(function, args))
    }

    /// Reads a function with its arguments.
    pub(super) fn function(
        &mut self,
        name: &str,
        head: &Tree<'_>,
        rest: &[Tree<'_>],
        scope: &Scope,
        visible: &Visible,
    ) -> Option<(usize, Vec<Term>)> {
        let Some(function) = self.functions.get(&key(name)).copied() else {
            let known = self.pair.functions.iter().map(|f| f.name.text.as_str());
            self.problems
                .push(problems::unknown_name("function", name, head.span, known));
            return None;
        };
        let wanted = self.pair.functions[function].params.clone();
        let args = self.args(name, head, rest, &wanted, scope, visible)?;
        Some((function, args))
    }
}

/// What was read of an action's effects, and below which conditions and variables the reader is.
#[derive(Default)]
struct Effects {
    effects: Vec<Effect>,
    costs: Vec<Cost>,
    forall: Vec<VarId>,
    conditions: Vec<Formula>,
}

/// Reads a finite number.
pub(super) fn number(word: &str) -> Option<f64> {
    let begins = word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'));
    word.parse().ok().filter(|x: &f64| begins && x.is_finite())
}

/// Returns how many brackets stand in one another when the formula is written in HATP.
fn brackets(formula: &Formula) -> usize {
    let most = |all: &[Formula]| all.iter().map(brackets).max().unwrap_or(0);
    match formula {
        Formula::And(all) => most(all),
        Formula::Or(all) => 1 + most(all),
        Formula::Not(inner) => 1 + brackets(inner),
        Formula::Imply(one, other) => 2 + brackets(one).max(brackets(other)),
        Formula::Forall(vars, inner) | Formula::Exists(vars, inner) => 2 * vars.len() + 1 + brackets(inner),
        Formula::Atom(..) => 1,
        Formula::Equal(..) => 0,
        Formula::Is(..) => 1,
    }
}
