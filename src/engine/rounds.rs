//! Searches that begin again: the order of branches, and the fall-back for cuts that may lose plans.
//!
//! One search after the other, a *round* each; what is counted, what is known to fail and the plans found go from one to the
//! next. All strategies are complete: their limits are raised until a round has left out nothing.
//! - Limited discrepancy (Harvey and Ginsberg, IJCAI 1995): a round takes another option than the first one at so many
//!   choices of a branch at most: none, 1, 2, 4, ... Any other option counts as one. Each round does again what the ones
//!   before did; to leave that out (Korf, AAAI 1996) the depth of the tree must be known, and that of a task network is not.
//!   Doubling keeps what is done twice small.
//! - Restarts (Gomes, Selman and Kautz, AAAI 1998): a round ends after so many choices taken back, by the sequence of Luby,
//!   Sinclair and Zuckerman (1993, doi:10.1016/0020-0190(93)90029-9); the first has the order of the files, the others
//!   draw theirs (`shuffle`).
//! - The fall-back: where a search has ended without a plan and has left branches that came back to their own task (`cycle`),
//!   depth first again, with tasks let come back to themselves up to 1, 2, 3, ... times between two actions. A plan
//!   that repeats a task so often is found in that round at the latest, if the budget lasts. A round that is not cut by this
//!   limit has the last word. All of them together may take up some times as many tasks as the search before: where
//!   there is no plan, they would go round in circles until the whole budget is spent.

use super::outcome::{Cuts, Ending, FallBackEnd, Settings, Statistics, Strategy, Truncated};

/// What one round may do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Round {
    /// How often a task may come back to itself between two actions.
    pub returns: u32,
    /// How many choices of a branch may take another option than their first.
    pub discrepancies: u32,
    /// Choices taken back before it ends.
    pub backtracks: u64,
    /// The seed of its orders, if they are drawn.
    pub shuffle: Option<u64>,
    /// The counts at which a fall-back without a plan ends.
    pub until: Until,
}

/// Counts of a search, from its very beginning on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Until {
    expansions: u64,
    backtracks: u64,
    projections: u64,
}

impl Until {
    const NEVER: Until = Until {
        expansions: u64::MAX,
        backtracks: u64::MAX,
        projections: u64::MAX,
    };

    pub fn is_reached(&self, done: &Statistics) -> bool {
        done.expansions >= self.expansions || done.backtracks >= self.backtracks || done.projections >= self.projections
    }
}

impl Round {
    /// Everything, in the order of the files.
    const WHOLE: Round = Round {
        returns: 0,
        discrepancies: u32::MAX,
        backtracks: u64::MAX,
        shuffle: None,
        until: Until::NEVER,
    };

    /// Says whether what was known to fail before may be less than a fact now.
    pub fn is_fall_back(&self) -> bool {
        self.returns > 0
    }
}

/// How a round ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ended {
    /// `None`: its choices taken back were used up.
    pub ending: Option<Ending>,
    /// Choices left because of the limit of discrepancies.
    pub left_out: u64,
    pub has_plan: bool,
    /// What was done in all.
    pub statistics: Statistics,
}

/// The rounds of a search.
#[derive(Debug)]
pub(super) struct Rounds {
    strategy: Strategy,
    cuts: Cuts,
    number: u64,
    pub round: Round,
    /// What the searches before the fall-back have cut short.
    before: Truncated,
    /// Tasks that the fall-back may take up, if somebody has said so.
    fall_back: Option<u64>,
    budget: u64,
    /// What ended the fall-back.
    pub fall_back_end: FallBackEnd,
    /// What the fall-back was given: tasks taken up, and geometric actions computed.
    given: (u64, u64),
}

/// HEURISTIC: the fall-back may take up so many times the tasks of the search before it, and at least so many.
const SHARE: (u64, u64) = (10, 10_000);
/// HEURISTIC: the same of geometric actions computed, each of which may take as long as a hundred thousand tasks.
const SHARE_OF_GEOMETRY: (u64, u64) = (2, 100);

/// HEURISTIC: choices taken back in the shortest round of [`Strategy::Restarts`].
const SHORTEST: u64 = 100;

impl Rounds {
    pub fn new(settings: &Settings) -> Self {
        let mut rounds = Rounds {
            strategy: settings.strategy,
            cuts: settings.cuts,
            number: 1,
            round: Round::WHOLE,
            before: Truncated::default(),
            fall_back: settings.fall_back,
            budget: settings.budget.expansions,
            fall_back_end: FallBackEnd::None,
            given: (0, 0),
        };
        rounds.round = rounds.of_strategy();
        rounds
    }

    fn of_strategy(&self) -> Round {
        match self.strategy {
            Strategy::DepthFirst => Round::WHOLE,
            Strategy::LimitedDiscrepancy => Round {
                discrepancies: match self.number {
                    1 => 0,
                    n if n < 32 => 1 << (n - 2),
                    _ => u32::MAX,
                },
                ..Round::WHOLE
            },
            Strategy::Restarts { seed } => Round {
                backtracks: SHORTEST.saturating_mul(luby(self.number)),
                // Another stream for each round; the first one has none.
                shuffle: (self.number > 1).then(|| seed ^ self.number.wrapping_mul(0x9e37_79b9_7f4a_7c15)),
                ..Round::WHOLE
            },
        }
    }

    /// Returns how the whole search has ended, or `None` if there is another round.
    pub fn next(&mut self, ended: Ended) -> Option<Ending> {
        let is_whole = ended.left_out == 0;
        match ended.ending {
            None => {}
            Some(Ending::Exhausted | Ending::ExhaustedTruncated(_)) if !is_whole => {}
            Some(ending @ Ending::ExhaustedTruncated(cut)) => {
                if ended.has_plan || self.cuts == Cuts::Off {
                    return Some(ending);
                }
                if cut.cycles == 0 {
                    return Some(match self.round.is_fall_back() {
                        true => Ending::ExhaustedTruncated(self.before),
                        false => ending,
                    });
                }
                if !self.round.is_fall_back() {
                    self.before = cut;
                    let done = ended.statistics;
                    let share = |done: u64, (times, least)| done.saturating_mul(times).max(least);
                    self.given = match self.fall_back {
                        Some(0) => return Some(ending),
                        Some(n) => (n, u64::MAX),
                        None => (
                            share(done.expansions, SHARE),
                            share(done.projections, SHARE_OF_GEOMETRY),
                        ),
                    };
                    self.round.until = Until {
                        expansions: done.expansions.saturating_add(self.given.0),
                        backtracks: done.backtracks.saturating_add(self.given.0),
                        projections: done.projections.saturating_add(self.given.1),
                    };
                }
                self.number += 1;
                let Round { returns, until, .. } = self.round;
                self.round = Round {
                    returns: returns.saturating_add(1 + returns / 4),
                    until,
                    ..Round::WHOLE
                };
                return None;
            }
            // The fall-back has shown no more than what was said before it.
            Some(Ending::BudgetSpent) if self.round.is_fall_back() && !ended.has_plan => {
                let done = ended.statistics;
                self.fall_back_end = if done.expansions.max(done.backtracks) >= self.budget {
                    FallBackEnd::Budget
                } else if done.projections >= self.round.until.projections {
                    FallBackEnd::Projections(self.given.1)
                } else {
                    FallBackEnd::Expansions(self.given.0)
                };
                return Some(Ending::ExhaustedTruncated(self.before));
            }
            Some(ending) => return Some(ending),
        }
        self.number += 1;
        self.round = self.of_strategy();
        None
    }

    /// Returns the number of rounds begun.
    pub fn number(&self) -> u64 {
        self.number
    }
}

/// Returns member `i`, from 1 on, of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, ...
fn luby(i: u64) -> u64 {
    let mut i = i.max(1);
    loop {
        // The power of two above it.
        let bits = u64::BITS - i.leading_zeros();
        let whole = 1u64.checked_shl(bits).map_or(u64::MAX, |power| power - 1);
        if i == whole {
            return 1 << (bits - 1);
        }
        i -= (1 << (bits - 1)) - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_of_luby() {
        let first: Vec<u64> = (1..=15).map(luby).collect();
        assert_eq!(first, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
        assert_eq!(luby(u64::MAX), 1 << 63);
    }
}
