//! Compiles a small domain, plans with a scripted reasoner, and keeps everything that was said.

use std::sync::atomic::AtomicBool;

use sgap::check::{self, Given};
use sgap::diag::render::render;
use sgap::engine::{self, Aim, Branching, Budget, Cuts, Ending, Found, Hooks, Kept, Outcome, Settings, Strategy};
use sgap::ir::{Domain, Goal};
use sgap::plan::Plan;
use sgap::source::Sources;
use sgap::syntax;
use sgap::validate::{self, Fault, Verdict};
use sgap::world::World;

use crate::reasoner::Scripted;

/// First plan, three alternatives, and no budget that a small domain could reach.
pub const FIRST: Settings = Settings {
    branching: Branching::Fixed(3),
    strategy: Strategy::DepthFirst,
    aim: Aim::First,
    interleave: false,
    cuts: Cuts::On,
    budget: Budget {
        expansions: 10_000,
        depth: 50,
    },
    fall_back: None,
};

/// As [`FIRST`], for the best plan.
pub const BEST: Settings = Settings {
    aim: Aim::Best,
    ..FIRST
};

/// What a search gave.
#[derive(Debug)]
pub struct Run {
    pub domain: Domain,
    pub goal: Goal,
    pub outcome: Outcome,
    /// The plans announced, with their costs.
    pub announced: Vec<(String, f64)>,
    pub reasoner: Scripted,
}

/// Compiles a domain that must be right.
pub fn compile(text: &str) -> Domain {
    let mut sources = Sources::default();
    let file = sources.add("test.hatp", text);
    let (ast, mut problems) = syntax::parse(file, text);
    let (domain, found) = check::compile(&[ast], &Given::default());
    problems.extend(found);
    assert!(!problems.has_errors(), "{}", render(&problems, &sources, false));
    domain.unwrap()
}

/// Reads a task that must be right.
pub fn goal(domain: &mut Domain, task: &str) -> Goal {
    let mut sources = Sources::default();
    let file = sources.add("task", task);
    let (goal, problems) = check::parse_goal(task, file, 0, domain);
    assert!(!problems.has_errors(), "{}", render(&problems, &sources, false));
    goal.unwrap()
}

/// Plans `task` with what the reasoner says.
pub fn run(text: &str, task: &str, reasoner: Scripted, settings: &Settings) -> Run {
    let mut domain = compile(text);
    let goal = goal(&mut domain, task);
    solve(domain, goal, reasoner, settings)
}

/// Plans a goal of a compiled domain.
pub fn solve(domain: Domain, goal: Goal, reasoner: Scripted, settings: &Settings) -> Run {
    repair(domain, goal, &[], reasoner, settings)
}

/// Plans a goal with what is kept first.
pub fn repair(domain: Domain, goal: Goal, kept: &[Kept], mut reasoner: Scripted, settings: &Settings) -> Run {
    let mut announced = Vec::new();
    let outcome = engine::repair(
        &domain,
        &goal,
        kept,
        &mut reasoner,
        settings,
        Hooks {
            stop: &AtomicBool::new(false),
            on_plan: &mut |found, _| announced.push((actions(&domain, found).join(" "), found.cost)),
            observer: None,
        },
    );
    assert!(reasoner.is_at_start(), "the world is left as it was found");
    Run {
        domain,
        goal,
        outcome,
        announced,
        reasoner,
    }
}

/// Plans `task` without geometry.
pub fn symbolic(text: &str, task: &str) -> Run {
    run(text, task, Scripted::new("", &[]), &FIRST)
}

/// Asks the validator about a plan of a domain without geometry.
pub fn second_opinion(run: &Run, plan: &Plan) -> Result<Verdict, Fault> {
    validate::replay(
        plan,
        &run.domain,
        &run.goal,
        &World::empty(),
        &validate::Settings::STANDARD,
    )
}

fn actions(domain: &Domain, found: &Found) -> Vec<String> {
    let show = |step: &engine::Step| {
        let args: Vec<String> = found.args(domain, step).iter().map(|v| domain.show(v)).collect();
        format!("{}({})", domain.actions[step.action.index()].name, args.join(","))
    };
    found.steps.iter().map(show).collect()
}

impl Run {
    /// Returns the plan's actions, `Pick(R,CUP) Place(R,CUP)`, or how the search ended without one.
    pub fn plan(&self) -> String {
        match &self.outcome.found {
            Some(found) => actions(&self.domain, found).join(" "),
            None => format!("{:?}", self.outcome.ending),
        }
    }

    /// Returns the plan document, without geometry.
    pub fn document(&self) -> Plan {
        self.document_of(0)
    }

    /// Returns the document of plan number `i`.
    pub fn document_of(&self, i: usize) -> Plan {
        let found = match i {
            0 => self.outcome.found.as_ref().unwrap(),
            i => &self.outcome.others[i - 1],
        };
        engine::document(found, &self.domain, &self.goal, 0, &|_| None)
    }

    /// Returns the number of plans kept.
    pub fn n_plans(&self) -> usize {
        self.outcome.found.iter().count() + self.outcome.others.len()
    }

    /// Returns why branches failed, as `count x reason` lines.
    pub fn reasons(&self) -> Vec<String> {
        let reasons = self.outcome.why_not.reasons();
        reasons
            .iter()
            .map(|(reason, why)| format!("{} x {reason}", why.n_branches))
            .collect()
    }

    /// Returns what was projected, in the order asked: `CUP BOX` for calls of `pick(R, CUP)` and `pick(R, BOX)`.
    pub fn tried(&self) -> String {
        let last = |s: &String| {
            s.trim_end_matches(')')
                .rsplit([' ', '('])
                .next()
                .unwrap_or("")
                .to_owned()
        };
        let tried: Vec<String> = self.reasoner.asked.iter().map(last).collect();
        tried.join(" ")
    }

    /// Says whether every choice was tried and none was cut short.
    pub fn is_exhausted(&self) -> bool {
        self.outcome.ending == Ending::Exhausted
    }
}
