//! The parts of a pair without the words and marks that are always the same.

use pest::iterators::{Pair, Pairs};

use super::Rule;

/// The parts of a pair that carry meaning.
pub(super) struct Parts<'i> {
    pairs: Pairs<'i, Rule>,
    /// Already taken from `pairs`.
    next: Option<Pair<'i, Rule>>,
}

impl<'i> Parts<'i> {
    /// Returns the next part, which the grammar promises.
    pub(super) fn want(&mut self) -> Pair<'i, Rule> {
        match self.next() {
            Some(pair) => pair,
            None => unreachable!("builder: the grammar promises one more part"),
        }
    }

    /// Says whether no part is left.
    pub(super) fn is_last(&mut self) -> bool {
        self.next = self.next();
        self.next.is_none()
    }

    /// Returns the next part if it is of that rule.
    pub(super) fn take_if(&mut self, rule: Rule) -> Option<Pair<'i, Rule>> {
        self.next = self.next();
        self.next.take_if(|p| p.as_rule() == rule)
    }
}

impl<'i> Iterator for Parts<'i> {
    type Item = Pair<'i, Rule>;
    fn next(&mut self) -> Option<Self::Item> {
        let next = self.next.take();
        next.or_else(|| self.pairs.find(|p| !is_fixed(p.as_rule())))
    }
}

/// Splits a pair; brackets, separators and words that only introduce are left out.
pub(super) fn parts(pair: Pair<'_, Rule>) -> Parts<'_> {
    Parts {
        pairs: pair.into_inner(),
        next: None,
    }
}

/// Says whether the rule's text is always the same and says nothing that the rule around it does not say.
fn is_fixed(rule: Rule) -> bool {
    matches!(
        rule,
        Rule::lbrace
            | Rule::rbrace
            | Rule::lparen
            | Rule::rparen
            | Rule::lbracket
            | Rule::rbracket
            | Rule::semi
            | Rule::comma
            | Rule::colon
            | Rule::dot
            | Rule::minus
            | Rule::EOI
            | Rule::kw_factdatabase
            | Rule::kw_htn
            | Rule::kw_time_part
            | Rule::kw_import
            | Rule::kw_define
            | Rule::kw_entity_type
            | Rule::kw_entity_attributes
            | Rule::kw_fact
            | Rule::kw_per
            | Rule::kw_agent
            | Rule::kw_request
            | Rule::kw_settings
            | Rule::kw_social
            | Rule::kw_undesirable
            | Rule::kw_state
            | Rule::kw_sequence
            | Rule::kw_effort
            | Rule::kw_balance
            | Rule::kw_wasted
            | Rule::kw_time
            | Rule::kw_intricate
            | Rule::kw_links
            | Rule::kw_of
            | Rule::kw_among
            | Rule::kw_weight
            | Rule::kw_new
            | Rule::kw_action
            | Rule::kw_method
            | Rule::kw_preconditions
            | Rule::kw_projects
            | Rule::kw_constraints
            | Rule::kw_alternatives
            | Rule::kw_effects
            | Rule::kw_cost
            | Rule::kw_duration
            | Rule::kw_goal
            | Rule::kw_subtasks
            | Rule::kw_let
            | Rule::kw_after
            | Rule::kw_function
            | Rule::kw_geometric
            | Rule::kw_exists
            | Rule::kw_in
            | Rule::kw_when
            | Rule::kw_moving
            | Rule::kw_with
            | Rule::kw_until
            | Rule::kw_then
            | Rule::kw_and
            | Rule::kw_or
            | Rule::kw_not
            | Rule::kw_forall
            | Rule::kw_exist
            | Rule::kw_if
            | Rule::kw_else
            | Rule::order_mark
    )
}
