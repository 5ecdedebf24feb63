//! Social rules: pest's pairs to AST nodes.

use pest::iterators::Pair;

use super::Rule as Grammar;
use super::build::Builder;
use super::parts::parts;
use crate::syntax::ast::*;

impl Builder<'_> {
    /// Returns a rule of `social { }`.
    pub(super) fn rule(&mut self, pair: Pair<'_, Grammar>) -> Rule {
        let span = self.span(&pair);
        let rule = pair.as_rule();
        let mut p = parts(pair);
        let is_undesirable = matches!(rule, Grammar::undesirable_state | Grammar::undesirable_sequence);
        let name = if is_undesirable {
            Some(self.name(p.want()))
        } else {
            p.take_if(Grammar::rule_name).map(|n| self.name(parts(n).want()))
        };
        let params = p.take_if(Grammar::params).map_or_else(Vec::new, |all| self.params(all));
        let effort = p
            .take_if(Grammar::effort_of)
            .map_or(Effort::Cost, |of| match of.as_str() {
                text if text.ends_with("duration") => Effort::Duration,
                _ => Effort::Cost,
            });
        let among = p
            .take_if(Grammar::among)
            .map_or_else(Vec::new, |all| parts(all).map(|n| self.name(n)).collect());
        let weight = self.expr(parts(p.want()).want());
        let kind = match rule {
            Grammar::undesirable_state => RuleKind::State(self.tests(p.want())),
            Grammar::undesirable_sequence => RuleKind::Sequence(p.map(|step| self.pattern(step)).collect()),
            Grammar::effort_balance => RuleKind::EffortBalance(effort),
            Grammar::wasted_time => RuleKind::WastedTime,
            Grammar::intricate_links => RuleKind::IntricateLinks,
            other => unreachable!("builder: {other:?} is no social rule"),
        };
        Rule {
            name,
            params,
            kind,
            among,
            weight,
            span,
        }
    }

    fn pattern(&mut self, pair: Pair<'_, Grammar>) -> Pattern {
        let span = self.span(&pair);
        let mut p = parts(pair);
        Pattern {
            call: self.call(p.want()),
            is_immediate: p.take_if(Grammar::kw_immediate).is_some(),
            span,
        }
    }
}
