//! Which actions come before which, by links.
//!
//! The actions are put into chains, each of which follows its predecessor; of each chain an action knows the last one that
//! is before it (Jagadish, ACM TODS 1990, doi:10.1145/99935.99944). A plan of few streams has few chains.

/// What is before what.
pub(super) struct Precedence<'a> {
    before: &'a [Vec<usize>],
    /// Each action's chain, and its place there.
    places: Vec<(usize, u32)>,
    n_chains: usize,
    /// For each action, how many of each chain are before it; empty when that would be too many numbers.
    counts: Vec<u32>,
}

/// Numbers kept at most: 512 MB.
const MOST: usize = 1 << 27;

/// Sorts pairs (before, after) by the latter. All indices are below `n`.
pub(super) fn by_later(n: usize, pairs: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut sorted = vec![Vec::new(); n];
    for (before, after) in pairs {
        sorted[*after].push(*before);
    }
    sorted
}

impl<'a> Precedence<'a> {
    /// INVARIANT: what is right before an action has a smaller index.
    pub(super) fn new(before: &'a [Vec<usize>]) -> Self {
        let mut places: Vec<(usize, u32)> = Vec::with_capacity(before.len());
        let mut lengths: Vec<u32> = Vec::new();
        for right_before in before {
            // A chain goes on behind its last action only.
            let mut ends = right_before.iter().map(|b| places[*b]);
            let chain = ends.find(|(chain, place)| place + 1 == lengths[*chain]);
            let chain = chain.map_or(lengths.len(), |(chain, _)| chain);
            if chain == lengths.len() {
                lengths.push(0);
            }
            places.push((chain, lengths[chain]));
            lengths[chain] += 1;
        }
        let n_chains = lengths.len();
        let mut counts = Vec::new();
        if before.len().saturating_mul(n_chains) <= MOST {
            counts.resize(before.len() * n_chains, 0);
            for (x, right_before) in before.iter().enumerate() {
                let (known, own) = counts.split_at_mut(x * n_chains);
                for b in right_before {
                    let (chain, place) = places[*b];
                    let row = &known[b * n_chains..(b + 1) * n_chains];
                    own.iter_mut().zip(row).for_each(|(own, of)| *own = (*own).max(*of));
                    own[chain] = own[chain].max(place + 1);
                }
            }
        }
        Precedence {
            before,
            places,
            n_chains,
            counts,
        }
    }

    /// Returns what is right before an action.
    pub(super) fn right_before(&self, x: usize) -> &[usize] {
        &self.before[x]
    }

    /// Says whether `first` must be over before `second` starts.
    pub(super) fn has(&self, first: usize, second: usize) -> bool {
        let (chain, place) = self.places[first];
        if let Some(count) = self.counts.get(second * self.n_chains + chain) {
            return *count > place;
        }
        let mut seen = vec![false; second.saturating_sub(first)];
        let mut left = vec![second];
        while let Some(x) = left.pop() {
            for b in self.before[x].iter().filter(|b| **b >= first) {
                if *b == first {
                    return true;
                }
                if !std::mem::replace(&mut seen[b - first], true) {
                    left.push(*b);
                }
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// With and without the table of counts, it is the transitive closure.
        #[test]
        fn it_is_the_transitive_closure(pairs in prop::collection::vec((0_usize..12, 0_usize..12), 0..40)) {
            let pairs: Vec<(usize, usize)> = pairs.into_iter().filter(|(b, a)| b < a).collect();
            let sorted = by_later(12, &pairs);
            let mut closure = [[false; 12]; 12];
            for after in 0..12 {
                for before in &sorted[after] {
                    closure[after][*before] = true;
                    let earlier = closure[*before];
                    for (reached, also) in closure[after].iter_mut().zip(earlier) {
                        *reached |= also;
                    }
                }
            }
            let mut precedence = Precedence::new(&sorted);
            for counts in [precedence.counts.clone(), Vec::new()] {
                precedence.counts = counts;
                for (after, row) in closure.iter().enumerate() {
                    for (before, expected) in row.iter().enumerate() {
                        prop_assert_eq!(precedence.has(before, after), *expected);
                    }
                }
            }
        }
    }
}
