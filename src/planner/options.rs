//! What to search for and how, each with the default of `sgap plan`.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::engine::{self, Aim, Branching, Budget, Cuts, Found, Kept, Observer, Reasoner, Statistics, Strategy};
use crate::grp;
use crate::ir::Domain;

/// What to search for and how. Set the fields, or chain the methods that set them.
pub struct Options<'a> {
    /// Its `interleave` counts for nothing: see [`Options::interleave`].
    pub search: engine::Settings,
    /// `None` does as the domain's settings say.
    pub interleave: Option<bool>,
    pub geometry: grp::Settings,
    /// Of every random choice: same input, same seed, same plan.
    pub seed: u64,
    /// Ends the search when somebody sets it, with the best plan so far.
    pub stop: Arc<AtomicBool>,
    /// What a plan has to begin with: see [`keep`](super::keep).
    pub kept: &'a [Kept],
    /// Answers for geometry instead of this crate's.
    pub reasoner: Option<&'a mut dyn Reasoner>,
    /// Whether the documents say how the task was decomposed; else their decomposition is empty.
    pub decomposition: bool,
    /// Hears of every (better) plan when it is found.
    pub on_plan: Option<&'a mut dyn FnMut(&News<'_>)>,
    /// Hears of all that the search does.
    pub observer: Option<&'a mut dyn Observer>,
}

/// A plan that was found just now. The document comes at the end of the search, with the motions.
#[derive(Debug)]
pub struct News<'a> {
    pub domain: &'a Domain,
    pub found: &'a Found,
    pub statistics: &'a Statistics,
}

impl News<'_> {
    /// Returns the actions with their arguments: `Pick(PR2, CUP)`.
    pub fn actions(&self) -> Vec<String> {
        let show = |step| {
            let args = self.found.args(self.domain, step).iter();
            args.map(|v| self.domain.show(v)).collect::<Vec<_>>().join(", ")
        };
        let steps = self.found.steps.iter();
        steps
            .map(|step| format!("{}({})", self.domain.actions[step.action.index()].name, show(step)))
            .collect()
    }
}

/// HEURISTIC budgets of geometry that no user needs to know.
const IK_RESTARTS: u32 = 8;
const MOTION_SAMPLES: u32 = 3000;

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            search: engine::Settings {
                aim: Aim::First,
                branching: Branching::Fixed(3),
                strategy: Strategy::DepthFirst,
                interleave: false,
                cuts: Cuts::On,
                budget: Budget {
                    expansions: 10_000_000,
                    depth: 100_000,
                },
                fall_back: None,
            },
            interleave: None,
            geometry: grp::Settings {
                placements: 200,
                ik_restarts: IK_RESTARTS,
                motion_samples: MOTION_SAMPLES,
            },
            seed: 0,
            stop: Arc::new(AtomicBool::new(false)),
            kept: &[],
            reasoner: None,
            decomposition: true,
            on_plan: None,
            observer: None,
        }
    }
}

impl<'a> Options<'a> {
    /// Goes on to the cheapest plan.
    pub fn best(mut self) -> Self {
        self.search.aim = Aim::Best;
        self
    }

    /// Finds up to `n` plans, no two of the same sequence of actions.
    pub fn all(mut self, n: u32) -> Self {
        self.search.aim = Aim::All(n);
        self
    }

    /// Tries up to `n` geometric solutions per action, the first included.
    pub fn branching(mut self, n: u32) -> Self {
        self.search.branching = Branching::Fixed(n);
        self
    }

    /// Lets unordered subtasks mix step by step, or not, whatever the domain says.
    pub fn interleave(mut self, on: bool) -> Self {
        self.interleave = Some(on);
        self
    }

    /// Draws other random numbers.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Ends the search after that many tasks were taken up.
    pub fn max_expansions(mut self, n: u64) -> Self {
        self.search.budget.expansions = n;
        self
    }

    /// Ends the search that is made again without unsafe cuts after it has taken up that many tasks; with 0 there is none.
    pub fn max_fall_back(mut self, n: u64) -> Self {
        self.search.fall_back = Some(n);
        self
    }

    /// Leaves branches with more methods inside methods.
    pub fn max_depth(mut self, n: usize) -> Self {
        self.search.budget.depth = n;
        self
    }

    /// Tries up to `n` placements per geometric action.
    pub fn placements(mut self, n: u32) -> Self {
        self.geometry.placements = n;
        self
    }

    /// Begins every plan with these actions of an earlier one.
    pub fn keep(mut self, kept: &'a [Kept]) -> Self {
        self.kept = kept;
        self
    }

    /// Ends the search when `stop` is set, from another thread or from a listener.
    pub fn stop(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stop = stop;
        self
    }

    /// Asks `reasoner` instead of this crate's geometry.
    pub fn reasoner(mut self, reasoner: &'a mut dyn Reasoner) -> Self {
        self.reasoner = Some(reasoner);
        self
    }

    /// Tells `hear` of every (better) plan when it is found.
    pub fn on_plan(mut self, hear: &'a mut dyn FnMut(&News<'_>)) -> Self {
        self.on_plan = Some(hear);
        self
    }

    /// Tells `observer` all that the search does, such as a [`crate::trace::Writer`].
    pub fn observer(mut self, observer: &'a mut dyn Observer) -> Self {
        self.observer = Some(observer);
        self
    }
}

impl fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("search", &self.search)
            .field("interleave", &self.interleave)
            .field("geometry", &self.geometry)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}
