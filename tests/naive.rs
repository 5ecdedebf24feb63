//! The search against a planner that is nothing but the definition: the same plans, the same best cost, the same verdict.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "naive/domains.rs"]
mod domains;
#[path = "naive/planner.rs"]
mod planner;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/reasoner.rs"]
mod reasoner;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/run.rs"]
mod run;

use std::collections::BTreeMap;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sgap::engine::{Aim, Budget, Cuts, Ending, Settings, Truncated};

use planner::{Limits, plans};
use reasoner::Scripted;
use run::{FIRST, Run, second_opinion};

const BUDGET: Budget = Budget {
    expansions: 2_000_000,
    depth: 60,
};

const TASK: &str = "Do0(R, CUP, 1, [CUP, BOX])";

/// Every way to search.
const WAYS: [(Cuts, sgap::engine::Strategy); 7] = [
    (Cuts::Off, sgap::engine::Strategy::DepthFirst),
    (Cuts::On, sgap::engine::Strategy::DepthFirst),
    (Cuts::Always, sgap::engine::Strategy::DepthFirst),
    (Cuts::Off, sgap::engine::Strategy::LimitedDiscrepancy),
    (Cuts::Always, sgap::engine::Strategy::LimitedDiscrepancy),
    (Cuts::Off, sgap::engine::Strategy::Restarts { seed: 7 }),
    (Cuts::Always, sgap::engine::Strategy::Restarts { seed: 7 }),
];

fn choices() -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(any::<u16>(), 90..420)
}

/// How many cases a property gets here; `SGAP_CASES` asks for more.
fn config() -> Config {
    let asked = std::env::var("SGAP_CASES").ok().and_then(|n| n.parse().ok());
    Config {
        cases: asked.unwrap_or(300),
        failure_persistence: None,
        max_global_rejects: 1_000_000,
        ..Config::default()
    }
}

fn search(text: &str, task: &str, settings: Settings) -> Run {
    run::run(text, task, Scripted::new("", &[]), &settings)
}

/// Compares everything that can be asked for with what the naive planner has found.
fn compare(domain: &planner::Domain, interleave: bool, work: usize) -> Result<(), TestCaseError> {
    let text = domains::text(domain);
    let naive = plans(
        domain,
        1,
        &Limits {
            interleave,
            depth: 50,
            work,
        },
    );
    prop_assume!(!naive.is_cut);
    let cheapest = naive.plans.values().min().copied();
    for (cuts, strategy) in WAYS {
        let settings = Settings {
            interleave,
            cuts,
            strategy,
            budget: BUDGET,
            ..FIRST
        };
        let task = TASK;
        let all = search(
            &text,
            task,
            Settings {
                aim: Aim::All(100_000),
                ..settings
            },
        );
        prop_assert_eq!(all.outcome.ending, Ending::Exhausted, "{:?}\n{}", cuts, text);
        let found: BTreeMap<String, i64> = all
            .announced
            .iter()
            .map(|(plan, cost)| (plan.clone(), *cost as i64))
            .collect();
        prop_assert_eq!(found.len(), all.announced.len(), "a plan came twice\n{}", text);
        prop_assert_eq!(&naive.plans, &found, "{:?}\n{}", cuts, text);
        let best = search(
            &text,
            task,
            Settings {
                aim: Aim::Best,
                ..settings
            },
        );
        prop_assert_eq!(best.outcome.ending, Ending::Exhausted, "{}", text);
        prop_assert_eq!(
            best.outcome.found.as_ref().map(|f| f.cost as i64),
            cheapest,
            "{:?}\n{}",
            cuts,
            text
        );
        let first = search(&text, task, settings);
        match &first.outcome.found {
            Some(_) => prop_assert!(naive.plans.contains_key(&first.announced[0].0), "{}", text),
            None => prop_assert!(naive.plans.is_empty() && first.is_exhausted(), "{}", text),
        }
        for run in [&first, &best] {
            if run.outcome.found.is_some()
                && let Err(fault) = second_opinion(run, &run.document())
            {
                return Err(TestCaseError::fail(format!("{fault}\n{text}")));
            }
        }
        // A search cut short promises no more than the truth.
        for expansions in [3, 10, 40] {
            let budget = Budget { expansions, ..BUDGET };
            let short = search(
                &text,
                task,
                Settings {
                    aim: Aim::Best,
                    budget,
                    ..settings
                },
            );
            let least = short.outcome.least_cost;
            prop_assert!(
                cheapest.is_none_or(|c| least <= c as f64 + 1e-9),
                "{} {:?}\n{}",
                least,
                cheapest,
                text
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config())]

    /// Where recursion is bounded by an argument, everything can be compared.
    #[test]
    fn the_same_plans(choices in choices(), interleave in any::<bool>()) {
        compare(&domains::domain(&choices, false), interleave, 3_000)?;
    }

    /// What is jumped over had no part in the failure.
    #[test]
    fn the_same_plans_where_tasks_are_independent(choices in choices()) {
        compare(&domains::row(&choices), false, 5_000)?;
    }

    /// Where tasks come back to themselves, what is found by the definition in a bounded depth is there; a search that
    /// says that it has tried everything has nothing worse.
    #[test]
    fn circles_hide_nothing(choices in choices(), interleave in any::<bool>()) {
        let domain = domains::domain(&choices, true);
        let text = domains::text(&domain);
        let naive = plans(&domain, 1, &Limits { interleave, depth: 5, work: 3_000 });
        let cheapest = naive.plans.values().min().copied();
        for (cuts, strategy) in WAYS {
            let budget = Budget { expansions: 2_000, depth: 60 };
            let settings = Settings { interleave, cuts, strategy, budget, ..FIRST };
            for aim in [Aim::First, Aim::Best] {
                let run = search(&text, "Do0(R, CUP, 1, [CUP, BOX])", Settings { aim, ..settings });
                if run.outcome.found.is_some() && let Err(fault) = second_opinion(&run, &run.document()) {
                    return Err(TestCaseError::fail(format!("{fault}\n{text}")));
                }
                let cost = run.outcome.found.as_ref().map(|f| f.cost);
                match run.outcome.ending {
                    Ending::Exhausted if aim == Aim::Best || cost.is_none() => {
                        prop_assert!(cheapest.is_none() || cost.is_some_and(|c| c <= cheapest.unwrap() as f64 + 1e-9),
                            "{:?} {:?} {:?} {:?}\n{}", cuts, aim, cost, naive.plans, text);
                    }
                    Ending::ExhaustedTruncated(Truncated { geometry: 0, alternatives: 0, .. }) => {}
                    Ending::Exhausted | Ending::FirstPlan | Ending::BudgetSpent => {}
                    ending => prop_assert!(false, "{:?}\n{}", ending, text),
                }
                let least = run.outcome.least_cost;
                prop_assert!(aim != Aim::Best || cheapest.is_none_or(|c| least <= c as f64 + 1e-9), "{} {:?}\n{}", least, cheapest, text);
            }
        }
    }
}

/// Whatever order the links allow is as good as the plan's own; no link is implied by others; starts are the longest paths.
fn links_and_starts(
    domain: &planner::Domain,
    plan: &sgap::plan::Plan,
    pick: &mut dyn FnMut(usize) -> usize,
) -> Result<(), String> {
    let n = plan.actions.len();
    let links: Vec<(usize, usize)> = plan.links.iter().map(|l| (l.before, l.after)).collect();
    let mut before = vec![vec![false; n]; n];
    for step in 0..n {
        for (b, _) in links.iter().filter(|(_, a)| *a == step) {
            before[step][*b] = true;
            let above = before[*b].clone();
            before[step]
                .iter_mut()
                .zip(above)
                .for_each(|(known, more)| *known |= more);
        }
    }
    for (b, a) in &links {
        if links.iter().any(|(c, after)| after == a && c != b && before[*c][*b]) {
            return Err(format!("link {b} to {a} is implied"));
        }
    }
    for (step, action) in plan.actions.iter().enumerate() {
        let linked = links.iter().filter(|(_, a)| *a == step).map(|(b, _)| *b);
        let same_agent = |b: &usize| plan.actions[*b].agents.iter().any(|a| action.agents.contains(a));
        let latest = linked
            .chain((0..step).filter(same_agent))
            .map(|b| plan.actions[b].end)
            .fold(0.0, f64::max);
        if (action.start - latest).abs() > 1e-9 || (action.end - action.start - action.duration[0]).abs() > 1e-9 {
            return Err(format!("action {step} starts at {} and not {latest}", action.start));
        }
    }
    let place = |of: &[&str], name: &str| of.iter().position(|o| *o == name).unwrap();
    let steps: Vec<(usize, usize, usize)> = plan
        .actions
        .iter()
        .map(|a| {
            let number = a.name.trim_start_matches("Act").parse().unwrap();
            (
                number,
                place(&planner::AGENTS, &a.arguments[0]),
                place(&planner::OBJECTS, &a.arguments[1]),
            )
        })
        .collect();
    let end = planner::execute(domain, &steps).ok_or("the plan can't be executed")?;
    for _ in 0..3 {
        let mut left: Vec<usize> = (0..n).collect();
        let mut order = Vec::new();
        while !left.is_empty() {
            let free: Vec<usize> = left
                .iter()
                .copied()
                .filter(|s| left.iter().all(|b| !before[*s][*b]))
                .collect();
            let next = free[pick(free.len())];
            left.retain(|s| *s != next);
            order.push(next);
        }
        let mixed: Vec<_> = order.iter().map(|s| steps[*s]).collect();
        if planner::execute(domain, &mixed).as_ref() != Some(&end) {
            return Err(format!(
                "links {links:?} allow the order {order:?}, which does something else"
            ));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn links_keep_what_matters(choices in choices(), interleave in any::<bool>()) {
        let domain = domains::domain(&choices, true);
        let text = domains::text(&domain);
        let budget = Budget { expansions: 5_000, depth: 10 };
        let settings = Settings { interleave, budget, aim: Aim::All(20), ..FIRST };
        let run = search(&text, "Do0(R, CUP, 1, [CUP, BOX])", settings);
        let mut next = choices.iter().cycle();
        let mut pick = |n: usize| next.next().map_or(0, |c| usize::from(*c) % n);
        for i in 0..run.n_plans() {
            let plan = run.document_of(i);
            if let Err(fault) = links_and_starts(&domain, &plan, &mut pick) {
                return Err(TestCaseError::fail(format!("{}: {fault}\n{text}", run.announced[i].0)));
            }
        }
    }
}

/// The comparisons say something: many domains have plans, several of them, of several actions; many have none.
#[test]
fn the_domains_are_worth_comparing() {
    let mut runner = TestRunner::new_with_rng(Config::default(), TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let [mut whole, mut none, mut several, mut long, mut priced, mut jumped] = [0; 6];
    for _ in 0..300 {
        let choices = choices().new_tree(&mut runner).unwrap().current();
        let limits = Limits {
            interleave: true,
            depth: 50,
            work: 3_000,
        };
        let naive = plans(&domains::domain(&choices, false), 1, &limits);
        whole += usize::from(!naive.is_cut);
        none += usize::from(naive.plans.is_empty());
        several += usize::from(naive.plans.len() > 2);
        long += usize::from(naive.plans.keys().any(|p| p.split(' ').count() > 3));
        let (least, most) = (naive.plans.values().min(), naive.plans.values().max());
        priced += usize::from(least != most);
        let settings = Settings {
            aim: Aim::All(100_000),
            cuts: Cuts::Always,
            budget: BUDGET,
            ..FIRST
        };
        let row = search(&domains::text(&domains::row(&choices)), TASK, settings);
        jumped += usize::from(row.outcome.statistics.jumps > 0);
    }
    let counts = [whole, none, several, long, priced, jumped];
    let least = [200, 60, 40, 15, 30, 15];
    assert!(counts.iter().zip(least).all(|(n, least)| *n >= least), "{counts:?}");
}
