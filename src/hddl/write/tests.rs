//! Conditions as tests.

use super::super::ast::{Formula, Kinds, OBJECT, Scope, Term, VarId};
use super::super::formulas::{conjuncts, free};
use super::Writer;

/// Writes tests over the variables of one scope, each on its line.
pub(super) struct Tests<'a, 'p> {
    writer: &'a Writer<'p>,
    scope: &'a Scope,
    vars: &'a [String],
    /// Predicates that are read as they were before the action.
    before: &'a [usize],
    pub out: String,
}

impl<'a, 'p> Tests<'a, 'p> {
    pub fn new(writer: &'a Writer<'p>, scope: &'a Scope, vars: &'a [String]) -> Self {
        Tests {
            writer,
            scope,
            vars,
            before: &[],
            out: String::new(),
        }
    }

    pub fn before(self, before: &'a [usize]) -> Self {
        Tests { before, ..self }
    }

    fn line(&mut self, text: &str) {
        self.out.push_str(text);
        self.out.push('\n');
    }

    // The depth is that of the text's lists, which has a cap.
    pub fn test(&mut self, formula: &Formula) {
        match formula {
            Formula::And(all) => all.iter().for_each(|f| self.test(f)),
            Formula::Or(all) => match &all[..] {
                [] => self.line("false;"),
                [one] => self.test(one),
                all => {
                    self.out.push_str("OR ");
                    all.iter().for_each(|f| self.block(f));
                    self.line("");
                }
            },
            Formula::Not(inner) => match &**inner {
                Formula::Atom(predicate, args) => self.atom(*predicate, args, false),
                Formula::Equal(one, other) => self.equal(*one, *other, false),
                Formula::Not(inner) => self.test(inner),
                inner => {
                    self.out.push_str("NOT ");
                    self.block(inner);
                    self.line("");
                }
            },
            Formula::Imply(one, other) => {
                self.out.push_str("OR { ");
                self.test(&Formula::Not(one.clone()));
                self.out.push_str("} ");
                self.block(other);
                self.line("");
            }
            Formula::Forall(vars, body) => self.forall(vars, body),
            Formula::Exists(vars, body) => {
                let mut left: Vec<&Formula> = conjuncts(body);
                self.exists(vars, &mut left);
            }
            Formula::Atom(predicate, args) => self.atom(*predicate, args, true),
            Formula::Equal(one, other) => self.equal(*one, *other, true),
            Formula::Is(term, kinds) => self.is(*term, kinds),
        }
    }

    fn block(&mut self, formula: &Formula) {
        self.out.push_str("{ ");
        self.test(formula);
        self.out.push_str("} ");
    }

    fn term(&self, term: Term) -> &'a str {
        self.writer.term(term, self.vars)
    }

    fn atom(&mut self, predicate: usize, args: &[Term], holds: bool) {
        let name = match self.before.contains(&predicate) {
            true => &self.writer.before_attributes[&predicate],
            false => &self.writer.predicates[predicate],
        };
        let args: Vec<&str> = args.iter().map(|t| self.term(*t)).collect();
        let text = match &args[..] {
            [] | [_] => {
                let op = if holds { "==" } else { "!=" };
                format!("{} {op} true;", self.writer.attribute(name, &args))
            }
            [owner @ .., value] => {
                let op = if holds { ">>" } else { "!>>" };
                format!("{value} {op} {};", self.writer.attribute(name, owner))
            }
        };
        self.line(&text);
    }

    fn equal(&mut self, one: Term, other: Term, holds: bool) {
        let pair = self.writer.pair;
        let [a, b] = [one, other].map(|t| pair.joined(&pair.kinds_of(t, self.scope)));
        let may_be = pair.is_subtype(a, b) || pair.is_subtype(b, a);
        let op = if holds { "==" } else { "!=" };
        match (may_be, holds) {
            (true, _) => self.line(&format!("{} {op} {};", self.term(one), self.term(other))),
            (false, true) => self.line("false;"),
            (false, false) => {}
        }
    }

    fn is(&mut self, term: Term, kinds: &Kinds) {
        let writer = self.writer;
        // Nothing is no object.
        if kinds.0.contains(&OBJECT) {
            return;
        }
        let tests = kinds.0.iter().map(|ty| {
            let name = &writer.is_attributes[ty];
            format!("{}.{name} == true;", writer.term(term, self.vars))
        });
        let tests: Vec<String> = tests.collect();
        match &tests[..] {
            [one] => self.line(one),
            all => self.line(&format!("OR {{ {} }}", all.join(" } { "))),
        }
    }

    fn type_of(&self, var: VarId) -> &'a str {
        let kinds = &self.scope.0[var].kinds;
        &self.writer.types[self.writer.pair.joined(kinds)]
    }

    /// Writes the type of a variable that has several.
    fn guard(&mut self, var: VarId) {
        let scope = self.scope;
        let kinds = &scope.0[var].kinds;
        if kinds.0.len() > 1 {
            self.is(Term::Var(var), kinds);
        }
    }

    /// Each test stands at the first variable that makes it complete.
    fn exists(&mut self, vars: &[VarId], left: &mut Vec<&Formula>) {
        let Some((var, rest)) = vars.split_first() else {
            for formula in std::mem::take(left) {
                self.test(formula);
            }
            return;
        };
        let (ty, name) = (self.type_of(*var), &self.vars[*var]);
        self.out.push_str(&format!("EXIST({ty} {name}, {{ "));
        self.guard(*var);
        let (now, mut later): (Vec<&Formula>, Vec<&Formula>) =
            left.iter().partition(|f| !rest.iter().any(|v| free(f).contains(v)));
        for formula in now {
            self.test(formula);
        }
        if !rest.is_empty() {
            self.exists(rest, &mut later);
        }
        left.clear();
        self.line("});");
    }

    fn forall(&mut self, vars: &[VarId], body: &Formula) {
        let (guards, body) = match body {
            Formula::Imply(one, other) => (conjuncts(one), &**other),
            other => (Vec::new(), other),
        };
        self.for_each(vars, guards, body);
    }

    fn for_each(&mut self, vars: &[VarId], guards: Vec<&Formula>, body: &Formula) {
        let Some((var, rest)) = vars.split_first() else {
            self.test(body);
            return;
        };
        let (ty, name) = (self.type_of(*var), &self.vars[*var]);
        self.out.push_str(&format!("FORALL({ty} {name}, {{ "));
        self.guard(*var);
        let (now, later): (Vec<&Formula>, Vec<&Formula>) = guards
            .into_iter()
            .partition(|f| !rest.iter().any(|v| free(f).contains(v)));
        for formula in now {
            self.test(formula);
        }
        self.out.push_str("}, { ");
        self.for_each(rest, later, body);
        self.line("});");
    }
}
