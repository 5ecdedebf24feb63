//! What a plan costs where that is not the sum of its actions' costs: counted action by action, and taken back.
//!
//! The formula of `settings { cost = ...; }` and the social rules (Alili, Warnier, Ali and Alami 2009; decision 18). Each
//! step adds what it brings; going back takes off the last steps, each of which knows what it has changed: nothing is
//! copied at a choice point. A domain without rules has no [`Objective`] at all.
//!
//! For a bound (decision 19), what can only grow counts as it stands: makespan, undesirable states and sequences, wasted
//! time, links. Effort balance can shrink, but not by more than the actions to come cost. Where attributes are shared with
//! geometry, which action a later one waits for is known at the end only: then links and wasted time count nothing before,
//! and the makespan is that of the links that are certain.

mod schedule;
mod sequences;
mod states;

use super::document::agents_of;
use super::eval::Context;
use super::outcome::{Charge, Found, Step, Tree};
use super::reasoner::Reasoner;
use super::state::State;
use crate::ir::{Domain, Effort, EntityId, RuleKind, SlotId};
use schedule::Schedule;
use sequences::Sequences;
use states::States;

/// The parts of a plan's cost: the sum of the actions' costs, the makespan, then what each rule counts.
pub(super) type Amounts = Vec<f64>;

/// How much of a plan is known to be as it will be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sight {
    /// All that each step reads and writes.
    Whole,
    /// Not which shared attributes a projection has changed.
    WithoutShared,
}

/// The cost of the plan at hand.
#[derive(Debug)]
pub(super) struct Objective<'d> {
    domain: &'d Domain,
    sight: Sight,
    schedule: Schedule,
    states: States<'d>,
    sequences: Sequences<'d>,
    /// Effort by agent: cost and duration [s].
    effort: Vec<[f64; 2]>,
    efforts_before: Vec<(EntityId, [f64; 2])>,
    /// Events of states and sequences, by rule.
    counts: Vec<u64>,
    /// Rules that have counted one more.
    counted: Vec<u32>,
    records: Vec<Record>,
}

/// Where a step's own begins, and what is certain after it.
#[derive(Debug, Clone, Copy)]
struct Record {
    efforts_before: u32,
    counted: u32,
    /// The cost that can only grow, but for the sum.
    grown: f64,
}

/// What a step touches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touched<'s> {
    pub reads: &'s [SlotId],
    pub writes: &'s [SlotId],
}

impl<'d> Objective<'d> {
    /// Returns the cost of the plan without actions; the context's state is that of the start.
    pub fn new(context: &mut Context<'d>, sight: Sight) -> Self {
        let domain = context.domain;
        Objective {
            domain,
            sight,
            schedule: Schedule::new(domain),
            states: States::new(context),
            sequences: Sequences::new(domain),
            effort: vec![[0.0; 2]; domain.entities.len()],
            efforts_before: Vec::new(),
            counts: vec![0; domain.social.len()],
            counted: Vec::new(),
            records: Vec::new(),
        }
    }

    /// Adds a step; the context's state is the one after it, and `tree` has its node.
    pub fn push(
        &mut self,
        context: &mut Context<'_>,
        tree: &Tree,
        (step, charge): (&Step, &Charge),
        touched: Touched<'_>,
    ) {
        let args = tree.args(self.domain, step.node);
        let agents = agents_of(self.domain, step.action, args);
        let record = Record {
            efforts_before: self.efforts_before.len() as u32,
            counted: self.counted.len() as u32,
            grown: 0.0,
        };
        for agent in &agents {
            let effort = &mut self.effort[agent.index()];
            self.efforts_before.push((*agent, *effort));
            effort[0] += charge.cost;
            effort[1] += charge.duration.0;
        }
        let n_counted = self.counted.len();
        self.states
            .push(context, touched.writes, charge.gas.is_some(), &mut self.counted);
        self.sequences.push(step.action, args, &agents, &mut self.counted);
        for rule in &self.counted[n_counted..] {
            self.counts[*rule as usize] += 1;
        }
        self.schedule.push(self.domain, tree, (step, charge), &agents, touched);
        self.records.push(record);
        let grown = self.grown();
        if let Some(record) = self.records.last_mut() {
            record.grown = grown;
        }
    }

    /// Takes off all but the first `steps` steps, and all but the first `nodes` nodes of the tree.
    pub fn restore(&mut self, steps: u32, nodes: u32) {
        while self.records.len() > steps as usize {
            let Some(record) = self.records.pop() else { break };
            while self.efforts_before.len() > record.efforts_before as usize {
                if let Some((agent, before)) = self.efforts_before.pop() {
                    self.effort[agent.index()] = before;
                }
            }
            for rule in self.counted.drain(record.counted as usize..) {
                self.counts[rule as usize] -= 1;
            }
            self.states.pop();
            self.sequences.pop();
            self.schedule.pop();
        }
        self.schedule.forget_nodes(nodes as usize);
    }

    /// Says whether it is already what the finished plan will be found to cost.
    pub fn is_exact(&self) -> bool {
        self.sight == Sight::Whole
    }

    /// Returns the cost of the plan at hand; `sum` is that of the actions' costs.
    pub fn cost(&self, sum: f64) -> f64 {
        total(self.domain, &self.amounts(sum))
    }

    /// Returns what rule number `rule` has counted so far.
    fn amount(&self, rule: usize) -> f64 {
        match &self.domain.social[rule].kind {
            RuleKind::State { .. } | RuleKind::Sequence { .. } => self.counts[rule] as f64,
            RuleKind::EffortBalance { effort, agents } => self.imbalance(*effort, agents),
            RuleKind::WastedTime { agents } => agents.iter().map(|a| self.schedule.wasted(*a)).sum(),
            RuleKind::IntricateLinks { .. } => self.schedule.n_links(rule) as f64,
        }
    }

    fn imbalance(&self, effort: Effort, agents: &[EntityId]) -> f64 {
        let which = match effort {
            Effort::Cost => 0,
            Effort::Duration => 1,
        };
        let efforts = agents.iter().map(|a| self.effort[a.index()][which]);
        let (least, most) = efforts.fold((f64::INFINITY, 0.0_f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
        if least.is_finite() { most - least } else { 0.0 }
    }

    /// Returns the parts of the plan's cost; `sum` is that of the actions' costs.
    pub fn amounts(&self, sum: f64) -> Amounts {
        let own = [sum, self.schedule.makespan()];
        let rules = (0..self.domain.social.len()).map(|rule| self.amount(rule));
        own.into_iter().chain(rules).collect()
    }

    /// Returns what is certain of the cost beyond the sum of costs, and can only grow.
    fn grown(&self) -> f64 {
        let is_certain = |kind: &RuleKind| match kind {
            RuleKind::State { .. } | RuleKind::Sequence { .. } => true,
            RuleKind::WastedTime { .. } | RuleKind::IntricateLinks { .. } => self.sight == Sight::Whole,
            RuleKind::EffortBalance { .. } => false,
        };
        let rules = self.domain.social.iter().enumerate();
        let of_rules = rules
            .filter(|(_, rule)| is_certain(&rule.kind))
            .map(|(i, rule)| rule.weight * self.amount(i));
        self.domain.settings.cost.makespan * self.schedule.makespan() + of_rules.sum::<f64>()
    }

    /// Returns what the plan at hand has cost so far, as far as that can't shrink, and the least that is added by actions
    /// which cost `rest` or more together; `sum` is that of the actions' costs so far.
    pub fn bound(&self, sum: f64, rest: f64) -> (f64, f64) {
        let factor = self.domain.settings.cost.sum;
        let so_far = factor * sum + self.records.last().map_or(0.0, |r| r.grown);
        // An action of cost x makes the difference smaller by x at most, and costs `factor` times x. So of a difference d
        // there is left, or has been paid: the lesser of weight and factor, times d; once `rest` is spent, times d - rest.
        let left = |rule: &crate::ir::SocialRule| match &rule.kind {
            RuleKind::EffortBalance {
                effort: Effort::Cost,
                agents,
            } => rule.weight.min(factor) * (self.imbalance(Effort::Cost, agents) - rest).max(0.0),
            RuleKind::EffortBalance { .. }
            | RuleKind::State { .. }
            | RuleKind::Sequence { .. }
            | RuleKind::WastedTime { .. }
            | RuleKind::IntricateLinks { .. } => 0.0,
        };
        // The same action may make several differences smaller: only one is counted.
        let left = self.domain.social.iter().map(left).fold(0.0, f64::max);
        (so_far, factor * rest + left)
    }

    /// Returns what no plan can cost less than that begins with the first `steps` steps, whose actions cost `sum`, and goes on
    /// with others that cost `rest`.
    pub fn bound_at(&self, steps: u32, sum: f64, rest: f64) -> f64 {
        let grown = match steps.checked_sub(1) {
            Some(last) => self.records.get(last as usize).map_or(0.0, |r| r.grown),
            None => 0.0,
        };
        self.domain.settings.cost.sum * (sum + rest) + grown
    }
}

/// Returns the cost that the parts make.
pub(super) fn total(domain: &Domain, amounts: &Amounts) -> f64 {
    let formula = domain.settings.cost;
    let factors = [formula.sum, formula.makespan].into_iter();
    let factors = factors.chain(domain.social.iter().map(|rule| rule.weight));
    factors.zip(amounts).map(|(factor, amount)| factor * amount).sum()
}

/// Returns the parts of a finished plan's cost, what each projection has changed included. The reasoner is left in the world
/// state that it is in.
pub(super) fn of_plan(found: &Found, domain: &Domain, shared: &[SlotId], reasoner: &mut dyn Reasoner) -> Amounts {
    let world = reasoner.save();
    reasoner.rewind();
    let mut state = State::new(domain, shared);
    let mut context = Context::new(domain, &mut state, reasoner);
    let mut objective = Objective::new(&mut context, Sight::Whole);
    let mut writes: Vec<SlotId> = Vec::new();
    let mut sum = 0.0;
    let changed = found.changed(domain);
    for (index, step) in found.steps.iter().enumerate() {
        writes.clear();
        writes.extend_from_slice(found.writes(step));
        for (slot, value) in changed.by(index) {
            context.state.set(slot, value.clone());
            writes.push(slot);
        }
        let charge = found.charge(step);
        if charge.gas.is_some() {
            writes.extend_from_slice(&found.overruled);
        }
        writes.sort_unstable();
        writes.dedup();
        let touched = Touched {
            reads: found.reads(step),
            writes: &writes,
        };
        objective.push(&mut context, &found.tree, (step, charge), touched);
        sum += charge.cost;
    }
    let amounts = objective.amounts(sum);
    reasoner.restore(world);
    amounts
}
