//! The transitive reduction of a plan's order, in one pass.
//!
//! What comes before a step is kept as the last step of each chain of the order, after Jagadish's chain covers (ACM TODS 15,
//! 1990, doi:10.1145/99935.99944), and a floor below which all steps come before it: in a plan whose actions follow one
//! another there is nothing but the floor. Costs as much as there are links times chains that run side by side.

use super::outcome::NONE;

/// Steps that come before some step.
#[derive(Debug, Clone, Default)]
struct Before {
    /// All steps below this one.
    floor: u32,
    /// Of other chains the last step, by chain.
    above: Vec<(u32, u32)>,
}

/// A reduction under way: steps are given in their order.
#[derive(Debug, Default)]
pub(super) struct Reduction {
    before: Vec<Before>,
    chain: Vec<u32>,
    /// The step before it in its chain, or [`NONE`].
    previous: Vec<u32>,
    /// The last step of each chain.
    ends: Vec<u32>,
}

impl Reduction {
    /// Takes the next step, which comes after all of `candidates`; returns those that no chain of others implies, the last
    /// one first.
    pub fn add(&mut self, candidates: &mut Vec<u32>) -> Vec<u32> {
        let step = self.before.len() as u32;
        candidates.sort_unstable_by(|a, b| b.cmp(a));
        candidates.dedup();
        let mut known = Before::default();
        let mut links = Vec::new();
        for before in candidates.iter().copied() {
            // Latest first: an earlier one that comes before a later one is implied.
            if self.contains(&known, before) {
                continue;
            }
            links.push(before);
            self.extend(&mut known, before);
        }
        while known.floor < step && self.contains(&known, known.floor) {
            known.floor += 1;
        }
        known.above.retain(|(_, last)| *last >= known.floor);
        let is_end = |b: &&u32| self.ends[self.chain[**b as usize] as usize] == **b;
        let (chain, previous) = match links.iter().find(is_end) {
            Some(before) => (self.chain[*before as usize], *before),
            None => {
                self.ends.push(step);
                (self.ends.len() as u32 - 1, NONE)
            }
        };
        self.previous.push(previous);
        self.ends[chain as usize] = step;
        self.chain.push(chain);
        self.before.push(known);
        links
    }

    /// Takes back the last step.
    pub fn pop(&mut self) {
        self.before.pop();
        match (self.chain.pop(), self.previous.pop()) {
            (Some(chain), Some(previous)) if previous != NONE => self.ends[chain as usize] = previous,
            // INVARIANT: it was the first of its chain, and no chain has begun since.
            (Some(_), _) => self.ends.truncate(self.ends.len() - 1),
            (None, _) => {}
        }
    }

    fn contains(&self, known: &Before, step: u32) -> bool {
        if step < known.floor {
            return true;
        }
        let chain = self.chain[step as usize];
        let found = known.above.binary_search_by_key(&chain, |(c, _)| *c);
        found.is_ok_and(|i| known.above[i].1 >= step)
    }

    /// Adds a step and all that comes before it.
    fn extend(&self, known: &mut Before, step: u32) {
        let more = &self.before[step as usize];
        known.floor = known.floor.max(more.floor);
        if more.floor == step {
            known.floor = known.floor.max(step + 1);
            return;
        }
        let own = (self.chain[step as usize], step);
        for (chain, last) in more.above.iter().chain([&own]) {
            match known.above.binary_search_by_key(chain, |(c, _)| *c) {
                Ok(i) => known.above[i].1 = known.above[i].1.max(*last),
                Err(i) => known.above.insert(i, (*chain, *last)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The links are those that the definition asks for, by a table of all pairs.
        #[test]
        fn what_is_left_is_the_transitive_reduction(
            steps in prop::collection::vec(prop::collection::vec(any::<u32>(), 0..4), 1..40)
        ) {
            let mut reduction = Reduction::default();
            let mut table: Vec<Vec<bool>> = Vec::new();
            for (i, wanted) in steps.iter().enumerate() {
                // What is taken back leaves no trace.
                for other in wanted.iter().filter(|_| i > 0) {
                    reduction.add(&mut vec![other % i as u32]);
                    reduction.add(&mut vec![i as u32]);
                }
                for _ in wanted.iter().filter(|_| i > 0) {
                    reduction.pop();
                    reduction.pop();
                }
                let mut candidates: Vec<u32> = if i == 0 { Vec::new() } else { wanted.iter().map(|w| w % i as u32).collect() };
                let direct = candidates.clone();
                let links = reduction.add(&mut candidates);
                let implied = |b: u32| direct.iter().any(|o| *o != b && table[*o as usize][b as usize]);
                let mut expected: Vec<u32> = direct.iter().copied().filter(|b| !implied(*b)).collect();
                expected.sort_unstable_by(|a, b| b.cmp(a));
                expected.dedup();
                prop_assert_eq!(links, expected);
                let row = (0..steps.len()).map(|b| direct.iter().any(|d| *d as usize == b || table[*d as usize][b]));
                table.push(row.collect());
            }
        }
    }
}
