//! The body of a geometric action, and choices that a call makes already.

use pest::iterators::Pair;

use super::Rule;
use super::build::Builder;
use super::parts::{Parts, parts};
use crate::syntax::ast::*;

impl Builder<'_> {
    pub(super) fn geometric_part(&mut self, pair: Pair<'_, Rule>) -> GeometricPart {
        match pair.as_rule() {
            Rule::choices => GeometricPart::Choices(parts(pair).map(|c| self.choice(c)).collect()),
            Rule::sub_action => GeometricPart::SubAction(self.sub_action(pair)),
            Rule::in_the_end => GeometricPart::InTheEnd(self.calls(parts(pair).want())),
            Rule::geometric_call => GeometricPart::Call(self.geometric_call(&mut parts(pair))),
            other => unreachable!("builder: {other:?} is no part of a geometric action"),
        }
    }

    fn choice(&mut self, pair: Pair<'_, Rule>) -> Choice {
        let span = self.span(&pair);
        let mut p = parts(pair);
        Choice {
            name: self.name(p.want()),
            from: self.call(p.want()),
            span,
        }
    }

    fn sub_action(&mut self, pair: Pair<'_, Rule>) -> SubAction {
        let span = self.span(&pair);
        let mut p = parts(pair);
        let name = self.name(p.want());
        let when = p.take_if(Rule::when).map_or_else(Vec::new, |when| self.calls(when));
        let mut moving = parts(p.want());
        SubAction {
            name,
            when,
            moving: self.call(moving.want()),
            is_straight: moving.take_if(Rule::kw_straight).is_some(),
            carrying: moving.next().map(|with| self.name(parts(with).want())),
            until: p.take_if(Rule::until).map_or_else(Vec::new, |until| self.calls(until)),
            change: p.next().map(|change| self.call(parts(change).want())),
            span,
        }
    }

    fn calls(&mut self, pair: Pair<'_, Rule>) -> Vec<Call> {
        parts(pair).map(|call| self.call(call)).collect()
    }

    /// Reads a call and what is given behind it.
    pub(super) fn geometric_call(&mut self, p: &mut Parts<'_>) -> GeometricCall {
        let call = self.call(p.want());
        let given = p.next().map_or_else(Vec::new, |given| {
            parts(given).map(|binding| self.binding(binding)).collect()
        });
        GeometricCall { call, given }
    }

    fn binding(&mut self, pair: Pair<'_, Rule>) -> Binding {
        let span = self.span(&pair);
        let mut p = parts(pair);
        let name = self.name(p.want());
        p.take_if(Rule::assign);
        Binding {
            name,
            value: self.expr(p.want()),
            span,
        }
    }
}
