//! Keeps the plans that a search finds.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use super::changes::changes;
use super::hash::Print;
use super::objective;
use super::observe::Event;
use super::outcome::{Aim, Found, News, Statistics};
use super::search::{COST_TOLERANCE, Search};
use crate::ir::SlotId;

/// Plans found so far.
#[derive(Debug, Default)]
pub(super) struct Recorder {
    /// In the order found; with [`Aim::Best`] the best one alone.
    plans: Vec<Found>,
    /// Fingerprints of the sequences of actions.
    sequences: FxHashSet<u128>,
}

impl Recorder {
    /// Returns the least cost of a plan found.
    pub fn best_cost(&self) -> Option<f64> {
        self.plans.iter().map(|p| p.cost).reduce(f64::min)
    }

    /// Returns the first (or best) plan and the others.
    pub fn finish(self) -> (Option<Found>, Vec<Found>) {
        let mut plans = self.plans.into_iter();
        (plans.next(), plans.collect())
    }
}

impl Search<'_> {
    /// Says whether a plan of that cost is better than the best one.
    fn is_better(&self, cost: f64) -> bool {
        self.recorder
            .best_cost()
            .is_none_or(|best| cost < best - COST_TOLERANCE)
    }

    /// Keeps the plan at hand; says whether there are enough now. With [`Aim::All`], a sequence of actions that was found
    /// before is no other plan.
    pub fn record(&mut self, on_plan: &mut dyn FnMut(&Found, &Statistics)) -> bool {
        self.n_derivations += 1;
        if let Aim::All(_) = self.settings.aim {
            let steps = self.steps.iter().map(|s| s.node);
            let sequence = steps.fold(Print::default(), |print, node| self.print_of_task(print, node));
            if !self.recorder.sequences.insert(sequence.key()) {
                return false;
            }
        }
        if let Some(objective) = &self.objective
            && objective.is_exact()
            && !self.is_better(objective.cost(self.cost))
        {
            return false;
        }
        let (domain, reasoner) = (self.context.domain, &mut *self.context.reasoner);
        // What an action without geometry says of a shared attribute, the next projection overrides: that is a write too,
        // even where the value happens to stay.
        let mut overruled = BTreeSet::new();
        if !self.shared.is_empty() {
            for step in self
                .steps
                .iter()
                .filter(|s| self.charges[s.charge as usize].gas.is_none())
            {
                let writes = &self.slots[step.slots[1] as usize..step.slots[2] as usize];
                let said = writes.iter().filter(|s| self.shared.binary_search(s).is_ok());
                overruled.extend(said.copied());
            }
        }
        // The first plan ends the search: nothing has to be kept for another.
        let is_last = self.settings.aim == Aim::First;
        let (steps, charges, tree, slots) = if is_last {
            let (steps, charges) = (std::mem::take(&mut self.steps), std::mem::take(&mut self.charges));
            (
                steps,
                charges,
                std::mem::take(&mut self.tree),
                std::mem::take(&mut self.slots),
            )
        } else {
            (
                self.steps.clone(),
                self.charges.clone(),
                self.tree.clone(),
                self.slots.clone(),
            )
        };
        let mut found = Found {
            steps,
            charges,
            tree,
            cost: self.cost,
            amounts: Vec::new(),
            interleaved: self.settings.interleave,
            slots,
            overruled: overruled.into_iter().collect::<Vec<SlotId>>(),
            news: News::Written(Vec::new()),
        };
        found.news = if self.shared.is_empty() {
            let news = if is_last {
                std::mem::take(&mut self.news)
            } else {
                self.news.clone()
            };
            News::Written(news)
        } else {
            News::Changed(changes(domain, self.shared, &found, reasoner))
        };
        if domain.has_objective() {
            found.amounts = objective::of_plan(&found, domain, self.shared, reasoner);
            found.cost = objective::total(domain, &found.amounts);
            if let Some(objective) = &self.objective {
                debug_assert!(
                    !objective.is_exact() || (objective.cost(self.cost) - found.cost).abs() < 1e-6,
                    "what is counted on the way is what is counted at the end"
                );
                if !self.is_better(found.cost) {
                    return false;
                }
            }
        }
        self.statistics.plans += 1;
        let (number, cost, n_actions) = (self.statistics.plans, found.cost, found.steps.len());
        self.tell(|_| Event::Found {
            number,
            cost,
            n_actions,
        });
        on_plan(&found, &self.statistics);
        if self.settings.aim == Aim::Best {
            self.recorder.plans.clear();
        }
        self.recorder.plans.push(found);
        match self.settings.aim {
            Aim::First => true,
            Aim::Best => false,
            Aim::All(n) => self.recorder.plans.len() >= n as usize,
        }
    }
}
