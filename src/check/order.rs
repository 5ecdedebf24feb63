//! Puts things that wait for each other in order, and finds those that wait in a circle.
//!
//! Kahn's algorithm (Communications of the ACM 5, 1962, doi:10.1145/368996.369025); of those that are ready at the same
//! time the first comes first.

/// What [`sort`] finds.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Sorted {
    /// Positions, each after all that it waits for; without those in or behind a circle.
    pub order: Vec<usize>,
    /// Circles: each position waits for the next one, the last for the first. Every group of positions that wait for
    /// each other shows one at least.
    pub circles: Vec<Vec<usize>>,
}

/// Sorts the positions of `after`, where `after[i]` has those that `i` waits for.
pub(super) fn sort(after: &[Vec<usize>]) -> Sorted {
    let n = after.len();
    let mut n_awaited: Vec<usize> = after.iter().map(Vec::len).collect();
    let mut behind: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (i, before) in after.iter().enumerate() {
        for b in before {
            if let Some(list) = behind.get_mut(*b) {
                list.push(i);
            }
        }
    }
    let mut order: Vec<usize> = (0..n).filter(|i| n_awaited.get(*i) == Some(&0)).collect();
    let mut next = 0;
    while let Some(i) = order.get(next).copied() {
        next += 1;
        for waiting in behind.get(i).into_iter().flatten() {
            if let Some(count) = n_awaited.get_mut(*waiting) {
                *count -= 1;
                if *count == 0 {
                    order.push(*waiting);
                }
            }
        }
    }
    let is_stuck = |i: usize| n_awaited.get(i).is_some_and(|count| *count > 0);
    let mut circles = Vec::new();
    // Walks along "waits for"; `seen[i]` is the walk that came by.
    let mut seen: Vec<Option<usize>> = vec![None; n];
    for start in (0..n).filter(|i| is_stuck(*i)) {
        let mut path = Vec::new();
        let mut at = Some(start);
        while let Some(i) = at {
            match seen.get_mut(i) {
                Some(mark @ None) => *mark = Some(start),
                Some(Some(walk)) if *walk == start => {
                    let first = path.iter().position(|p| *p == i).unwrap_or(0);
                    circles.push(path.split_off(first));
                    break;
                }
                _ => break,
            }
            path.push(i);
            at = after.get(i).and_then(|a| a.iter().copied().find(|b| is_stuck(*b)));
        }
    }
    Sorted { order, circles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_sorted_and_a_circle_is_found() {
        let sorted = sort(&[vec![1], vec![2], vec![], vec![4], vec![3, 0], vec![3]]);
        assert_eq!(sorted.order, [2, 1, 0]);
        assert_eq!(sorted.circles, [vec![3, 4]]);
        assert_eq!(sort(&[vec![0]]).circles, [vec![0]]);
    }
}
