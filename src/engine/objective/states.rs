//! Undesirable states: how often each begins to hold.
//!
//! A rule with parameters is a state of its own for every choice of entities. The start brings about none: what holds there
//! is no action's doing.

use crate::engine::eval::Context;
use crate::ir::{EntityId, Expr, RuleKind, SlotId, Test, TypeId, Value};

/// What holds in the state at hand.
#[derive(Debug)]
pub(super) struct States<'d> {
    rules: Vec<Rule<'d>>,
    /// By choice, the rules' choices one after the other.
    holds: Vec<bool>,
    /// Choices whose state has begun or ceased to hold.
    flipped: Vec<u32>,
    /// For each step, where its flips begin.
    steps: Vec<u32>,
}

#[derive(Debug)]
struct Rule<'d> {
    /// Its number among all social rules.
    number: u32,
    params: &'d [TypeId],
    n_vars: usize,
    test: &'d Test,
    /// The attributes that the test reads, and whether one of them is shared.
    reads: Vec<bool>,
    is_shared: bool,
    /// Its first choice in `holds`.
    first: usize,
}

impl<'d> States<'d> {
    /// Returns what holds at the start.
    pub fn new(context: &mut Context<'d>) -> Self {
        let domain = context.domain;
        let mut rules = Vec::new();
        let mut n_choices = 0;
        for (number, rule) in domain.social.iter().enumerate() {
            let RuleKind::State { params, n_vars, test } = &rule.kind else {
                continue;
            };
            let mut reads = vec![false; domain.attributes.len()];
            test.any(&mut |expr| {
                if let Expr::Attribute { attribute, .. } = expr {
                    reads[attribute.index()] = true;
                }
                false
            });
            let mut attributes = domain.attributes.iter().zip(&reads);
            rules.push(Rule {
                number: number as u32,
                params,
                n_vars: *n_vars,
                test,
                is_shared: attributes.any(|(a, read)| *read && a.fact.is_some()),
                reads,
                first: n_choices,
            });
            let sizes = params.iter().map(|ty| domain.types[ty.index()].entities.len());
            n_choices += sizes.product::<usize>();
        }
        let mut states = States {
            rules,
            holds: vec![false; n_choices],
            flipped: Vec::new(),
            steps: Vec::new(),
        };
        for rule in 0..states.rules.len() {
            states.look(context, rule, &mut Vec::new());
        }
        states.flipped.clear();
        states
    }

    /// Looks at the state after a step; adds to `counted` the rules whose state begins to hold, once for each choice.
    pub fn push(&mut self, context: &mut Context<'_>, writes: &[SlotId], is_projected: bool, counted: &mut Vec<u32>) {
        self.steps.push(self.flipped.len() as u32);
        for rule in 0..self.rules.len() {
            let Rule { reads, is_shared, .. } = &self.rules[rule];
            let is_read = |slot: &SlotId| reads[context.domain.slots[slot.index()].attribute.index()];
            if is_projected && *is_shared || writes.iter().any(is_read) {
                self.look(context, rule, counted);
            }
        }
    }

    /// Takes back the last step.
    pub fn pop(&mut self) {
        let from = self.steps.pop().unwrap_or_default() as usize;
        for choice in self.flipped.drain(from..) {
            self.holds[choice as usize] ^= true;
        }
    }

    fn look(&mut self, context: &mut Context<'_>, rule: usize, counted: &mut Vec<u32>) {
        let domain = context.domain;
        let Rule {
            number,
            params,
            n_vars,
            test,
            first,
            ..
        } = self.rules[rule];
        let entities: Vec<&[EntityId]> = params
            .iter()
            .map(|ty| domain.types[ty.index()].entities.as_slice())
            .collect();
        if entities.iter().any(|e| e.is_empty()) {
            return;
        }
        let n_reads = context.reads.len();
        let mut frame = vec![Value::Null; n_vars.max(params.len())];
        let mut at = vec![0; params.len()];
        let mut choice = first;
        loop {
            for (value, (entities, at)) in frame.iter_mut().zip(entities.iter().zip(&at)) {
                *value = Value::Entity(entities[*at]);
            }
            let holds = context.holds(test, &mut frame);
            if holds != self.holds[choice] {
                self.holds[choice] = holds;
                self.flipped.push(choice as u32);
                if holds {
                    counted.push(number);
                }
            }
            choice += 1;
            // The next choice: the last parameter counts fastest.
            let Some(next) = (0..at.len()).rev().find(|i| at[*i] + 1 < entities[*i].len()) else {
                break;
            };
            at[next] += 1;
            at[next + 1..].fill(0);
        }
        // Nobody waits for what a rule reads.
        context.reads.truncate(n_reads);
    }
}
