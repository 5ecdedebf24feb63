//! Tests with what never changes worked out once.
//!
//! An attribute that no effect writes, no geometry feeds and nobody believes keeps its first value in all of a search: it is *fixed*. A
//! literal over fixed attributes alone is a constant as soon as its variables are bound. It is evaluated when it is met first
//! with some entities, and looked up from then on: one cell where it has no free variable, one for each entity or pair of
//! entities else. Literals with more variables, or among too many entities, are evaluated as they are written.
//!
//! A FORALL that is tested again and again (mostly a goal) begins with the entity that it failed at last.
//!
//! Does not change which literal fails first: a conjunction keeps its parts and their order, so that reasons are the same.

use std::cell::Cell;

use super::effects::{WORLD, looked_at};
use super::eval::{Context, looks_at_all};
use super::prepare::mentioned;
use crate::ir::{Attribute, AttributeId, Domain, Effect, Expr, Test, Value, Var};

/// Which attributes are fixed.
#[derive(Debug)]
pub(super) struct Fixed(Vec<bool>);

impl Fixed {
    pub fn new(domain: &Domain) -> Fixed {
        // What agents believe of it may be something else.
        let is_plain = |a: &Attribute| a.fact.is_none() && a.believer.is_none();
        let mut fixed = Fixed(domain.attributes.iter().map(is_plain).collect());
        domain.actions.iter().for_each(|a| fixed.writes(&a.effects));
        fixed
    }

    fn writes(&mut self, effects: &[Effect]) {
        for effect in effects {
            match effect {
                Effect::Assign { attribute, .. } | Effect::Add { attribute, .. } | Effect::Remove { attribute, .. } => {
                    self.0[attribute.index()] = false;
                }
                Effect::Forall { effects, .. } => self.writes(effects),
                Effect::If { then, otherwise, .. } => {
                    self.writes(then);
                    self.writes(otherwise);
                }
            }
        }
    }

    /// Says whether an attribute keeps its first value.
    #[inline]
    pub fn has(&self, attribute: AttributeId) -> bool {
        self.0[attribute.index()]
    }

    /// Says whether a test looks at fixed attributes alone.
    fn decide(&self, test: &Test) -> bool {
        let changes = |e: &Expr| match e {
            Expr::Attribute { attribute, .. } => !self.has(*attribute),
            Expr::Request { .. } | Expr::Fact { .. } | Expr::GeometricCost | Expr::GeometricDuration => true,
            Expr::Const(_)
            | Expr::Var(_)
            | Expr::Size(_)
            | Expr::List(_)
            | Expr::Arithmetic { .. }
            | Expr::Negate(_)
            | Expr::SetWith { .. }
            | Expr::SetWithout { .. } => false,
        };
        !test.any(&mut |expr| expr.any(&mut |e| changes(e)))
    }
}

/// HEURISTIC: cells of one literal, and of all of a domain.
const MOST_CELLS: usize = 1 << 16;
const MOST_OF_ALL: usize = 1 << 22;

/// Makes folded tests, within a budget of cells.
#[derive(Debug)]
pub(super) struct Folder<'d> {
    domain: &'d Domain,
    pub fixed: &'d Fixed,
    n_entities: usize,
    n_cells: usize,
}

/// A conjunction, part by part.
#[derive(Debug)]
pub(super) struct Folded(Box<[Part]>);

#[derive(Debug)]
enum Part {
    AsWritten,
    /// A FORALL over all of a type, with the position of the entity that it failed at last: it begins there, since it mostly
    /// fails again there or not far behind.
    Forall(Cell<usize>),
    Constant(Cell<Known>),
    OfOne(Var, Box<[Cell<Known>]>),
    /// By the first entity, then the second.
    OfTwo([Var; 2], usize, Box<[Cell<Known>]>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    NotYet,
    False,
    True,
}

/// The parts of a conjunction.
pub(super) fn literals(test: &Test) -> &[Test] {
    match test {
        Test::And(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    }
}

impl<'d> Folder<'d> {
    pub fn new(domain: &'d Domain, fixed: &'d Fixed) -> Self {
        Folder {
            domain,
            fixed,
            n_entities: domain.entities.len(),
            n_cells: 0,
        }
    }

    /// Says whether a test asks geometry.
    fn asks(&self, test: &Test) -> bool {
        looked_at(self.domain, test) & WORLD != 0
    }

    pub fn fold(&mut self, test: &Test) -> Folded {
        Folded(literals(test).iter().map(|part| self.part(part)).collect())
    }

    fn part(&mut self, literal: &Test) -> Part {
        if !self.fixed.decide(literal) {
            // What asks geometry is asked in the order in which it is written.
            return match literal {
                Test::Forall { var, guard, .. } if looks_at_all(guard, *var) && !self.asks(literal) => {
                    Part::Forall(Cell::new(0))
                }
                _ => Part::AsWritten,
            };
        }
        let mut vars = Vec::new();
        free(literal, &mut vars);
        let n = match vars.len() {
            0 => 1,
            1 => self.n_entities,
            2 => self.n_entities * self.n_entities,
            _ => return Part::AsWritten,
        };
        if n > MOST_CELLS || self.n_cells + n > MOST_OF_ALL {
            return Part::AsWritten;
        }
        self.n_cells += n;
        let cells = || vec![Cell::new(Known::NotYet); n].into_boxed_slice();
        match vars.as_slice() {
            [] => Part::Constant(Cell::new(Known::NotYet)),
            [var] => Part::OfOne(*var, cells()),
            [one, other, ..] => Part::OfTwo([*one, *other], self.n_entities, cells()),
        }
    }
}

/// Lists the variables of a test that no quantifier in it binds, each once.
fn free(test: &Test, vars: &mut Vec<Var>) {
    let mut add = |expr: &Expr| {
        mentioned(expr, &mut |var| {
            if !vars.contains(&var) {
                vars.push(var);
            }
        });
    };
    match test {
        Test::And(parts) | Test::Or(parts) => parts.iter().for_each(|part| free(part, vars)),
        Test::Not(inner) => free(inner, vars),
        Test::Compare { left, right, .. } => {
            add(left);
            add(right);
        }
        Test::Member { element, set } => {
            add(element);
            add(set);
        }
        Test::Forall { var, guard, body, .. } | Test::Exist { var, guard, body, .. } => {
            let mut inside = Vec::new();
            free(guard, &mut inside);
            free(body, &mut inside);
            vars.extend(inside.into_iter().filter(|v| v != var));
            vars.sort_unstable();
            vars.dedup();
        }
        Test::Holds(expr) => add(expr),
    }
}

impl Context<'_> {
    /// Says whether part `i` of a folded test holds; `literal` is that part as it is written.
    #[inline]
    pub fn holds_part(&mut self, folded: &Folded, i: usize, literal: &Test, frame: &mut [Value]) -> bool {
        let entity = |var: &Var| match &frame[var.index()] {
            Value::Entity(e) => Some(e.index()),
            _ => None,
        };
        let cell = match &folded.0[i] {
            Part::AsWritten | Part::Forall(_) => None,
            Part::Constant(cell) => Some(cell),
            Part::OfOne(var, cells) => entity(var).and_then(|e| cells.get(e)),
            Part::OfTwo([one, other], n, cells) => match (entity(one), entity(other)) {
                (Some(one), Some(other)) => cells.get(one * n + other),
                _ => None,
            },
        };
        match cell.map(Cell::get) {
            Some(Known::True) => true,
            Some(Known::False) => false,
            Some(Known::NotYet) | None => {
                let holds = self.holds(literal, frame);
                if let Some(cell) = cell {
                    cell.set(if holds { Known::True } else { Known::False });
                }
                holds
            }
        }
    }

    /// Says whether a folded test holds; `test` is the same as it is written. Where it is false, it may be so for another
    /// entity than the first one: for tests whose failure needs no words.
    #[inline]
    pub fn holds_folded(&mut self, folded: &Folded, test: &Test, frame: &mut [Value]) -> bool {
        let mut parts = literals(test).iter().enumerate();
        parts.all(|(i, part)| match (&folded.0[i], part) {
            (Part::Forall(last), Test::Forall { var, ty, guard, body }) => {
                let entities = &self.domain.types[ty.index()].entities;
                let (before, from) = entities.split_at(last.get().min(entities.len()));
                let fails = from.iter().chain(before).position(|e| {
                    frame[var.index()] = Value::Entity(*e);
                    self.holds(guard, frame) && !self.holds(body, frame)
                });
                if let Some(at) = fails {
                    last.set((before.len() + at) % entities.len());
                }
                fails.is_none()
            }
            _ => self.holds_part(folded, i, part, frame),
        })
    }
}
