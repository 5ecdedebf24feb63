//! Properties of the whole: whatever plan comes out of a search, the validator has nothing against it.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "props/domains.rs"]
mod domains;
#[path = "scripted/reasoner.rs"]
mod reasoner;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/run.rs"]
mod run;
#[path = "props/text.rs"]
mod text;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sgap::engine::{Aim, Budget, Cuts, Ending, Settings};

use domains::Kind;
use reasoner::Scripted;
use run::{BEST, FIRST, Run, second_opinion};

const SMALL: Budget = Budget {
    expansions: 300,
    depth: 6,
};

fn choices() -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(any::<u16>(), 40..220)
}

fn plan(text: &str, settings: &Settings) -> Run {
    let settings = Settings {
        budget: SMALL,
        ..*settings
    };
    run::run(text, "Do0(R, CUP)", Scripted::new("", &[]), &settings)
}

proptest! {
    #![proptest_config(Config { cases: 500, failure_persistence: None, ..Config::default() })]

    #[test]
    fn every_plan_is_valid(choices in choices()) {
        let text = domains::domain(&choices, Kind::Symbolic);
        let mixed = Settings { interleave: true, ..FIRST };
        for settings in [FIRST, BEST, mixed] {
            let run = plan(&text, &settings);
            if run.outcome.found.is_some() && let Err(fault) = second_opinion(&run, &run.document()) {
                let plan = serde_json::to_string_pretty(&run.document()).unwrap();
                return Err(TestCaseError::fail(format!("{fault}\n{plan}\n{text}")));
            }
            let costs: Vec<f64> = run.announced.iter().map(|(_, cost)| *cost).collect();
            prop_assert!(costs.windows(2).all(|w| w[1] < w[0]), "{costs:?}\n{text}");
        }
    }

    #[test]
    fn the_same_input_gives_the_same_bytes(choices in choices()) {
        let text = domains::domain(&choices, Kind::Symbolic);
        let [one, other] = [plan(&text, &BEST), plan(&text, &BEST)];
        prop_assert_eq!(one.outcome.ending, other.outcome.ending);
        prop_assert_eq!(one.outcome.statistics, other.outcome.statistics);
        prop_assert_eq!(&one.outcome.why_not, &other.outcome.why_not);
        if one.outcome.found.is_some() {
            let bytes = |run: &Run| serde_json::to_string(&run.document()).unwrap();
            prop_assert_eq!(bytes(&one), bytes(&other));
        }
    }
}

/// Returns all plans that there are, sorted, or `None` where a search was cut short.
fn all(text: &str, settings: &Settings) -> (Option<Vec<String>>, Ending) {
    let budget = Budget {
        expansions: 20_000,
        ..SMALL
    };
    let settings = Settings {
        aim: Aim::All(1_000),
        budget,
        ..*settings
    };
    let run = run::run(text, "Do0(R, CUP)", Scripted::new("", &[]), &settings);
    for i in 0..run.n_plans() {
        if let Err(fault) = second_opinion(&run, &run.document_of(i)) {
            panic!("{fault}\n{}\n{text}", run.announced[i].0);
        }
    }
    let mut plans: Vec<String> = run.announced.iter().map(|(plan, _)| plan.clone()).collect();
    plans.sort();
    (run.is_exhausted().then_some(plans), run.outcome.ending)
}

proptest! {
    #![proptest_config(Config { cases: 300, failure_persistence: None, ..Config::default() })]

    /// What is left out as a circle or a failure known is nothing new: the plans are those of the search that tries all.
    #[test]
    fn cuts_lose_no_plan(choices in choices(), interleave in any::<bool>()) {
        let text = domains::domain(&choices, Kind::Symbolic);
        let settings = Settings { interleave, ..FIRST };
        let (plain, _) = all(&text, &Settings { cuts: Cuts::Off, ..settings });
        for cuts in [Cuts::On, Cuts::Always] {
            let (cut, ending) = all(&text, &Settings { cuts, ..settings });
            if let Some(plain) = &plain {
                prop_assert_eq!(Some(plain), cut.as_ref(), "{:?} {:?}\n{}", cuts, ending, text);
            }
        }
    }

    /// The cheapest of all plans is the best one, and no bound is above it.
    #[test]
    fn the_best_plan_is_the_cheapest(choices in choices(), interleave in any::<bool>()) {
        let text = domains::domain(&choices, Kind::Symbolic);
        let budget = Budget { expansions: 20_000, ..SMALL };
        let settings = Settings { interleave, budget, aim: Aim::All(1_000), cuts: Cuts::Off, ..FIRST };
        let every = run::run(&text, "Do0(R, CUP)", Scripted::new("", &[]), &settings);
        prop_assume!(every.is_exhausted());
        let costs = every.announced.iter().map(|(_, cost)| *cost);
        let cheapest = costs.fold(f64::INFINITY, f64::min);
        for cuts in [Cuts::Off, Cuts::On, Cuts::Always] {
            let best = run::run(&text, "Do0(R, CUP)", Scripted::new("", &[]), &Settings { cuts, aim: Aim::Best, ..settings });
            let cost = best.outcome.found.as_ref().map_or(f64::INFINITY, |f| f.cost);
            prop_assert!(cost == cheapest || (cost - cheapest).abs() < 1e-6, "{} {}\n{}", cost, cheapest, text);
            prop_assert!(best.outcome.least_cost <= cost + 1e-6);
        }
    }
}

proptest! {
    #![proptest_config(Config { cases: 300, failure_persistence: None, ..Config::default() })]

    /// With geometry, too: what was cut short is not remembered as a failure.
    #[test]
    fn cuts_lose_no_plan_with_geometry(domain in choices(), geometry in choices()) {
        let text = domains::domain(&domain, Kind::Geometric);
        let budget = Budget { expansions: 20_000, ..SMALL };
        let plans = |cuts| {
            let settings = Settings { aim: Aim::All(1_000), branching: sgap::engine::Branching::Fixed(2), cuts, budget, ..FIRST };
            let run = run::run(&text, "Do0(R, CUP)", domains::reasoner(&geometry), &settings);
            let mut plans: Vec<String> = run.announced.iter().map(|(plan, _)| plan.clone()).collect();
            plans.sort();
            let is_whole = match run.outcome.ending {
                Ending::Exhausted => true,
                Ending::ExhaustedTruncated(cut) => cut.depth == 0,
                Ending::FirstPlan | Ending::BudgetSpent | Ending::Interrupted => false,
            };
            (plans, is_whole)
        };
        let (plain, is_whole) = plans(Cuts::Off);
        if is_whole {
            prop_assert_eq!(&plain, &plans(Cuts::On).0, "{}", text);
            prop_assert_eq!(&plain, &plans(Cuts::Always).0, "{}", text);
        }
    }
}

/// Plans a domain with geometry. Whatever happens, the world is left as it was found, and every rule of the reasoner kept:
/// `run::solve` and the reasoner insist.
fn plan_with_geometry(domain: &[u16], geometry: &[u16], kind: Kind) -> (Run, String) {
    let settings = Settings { budget: SMALL, ..BEST };
    let text = domains::domain(domain, kind);
    let run = run::run(&text, "Do0(R, CUP)", domains::reasoner(geometry), &settings);
    (run, text)
}

proptest! {
    #![proptest_config(Config { cases: 500, failure_persistence: None, ..Config::default() })]

    /// When a shared attribute is read makes no difference: it is that of the world state at hand.
    #[test]
    fn reading_facts_early_or_late_gives_the_same_plan(domain in choices(), geometry in choices()) {
        let (lazy, text) = plan_with_geometry(&domain, &geometry, Kind::Geometric);
        let (eager, _) = plan_with_geometry(&domain, &geometry, Kind::Eager);
        prop_assert_eq!(&lazy.reasoner.asked, &eager.reasoner.asked, "{}", text);
        prop_assert_eq!(&lazy.announced, &eager.announced, "{}", text);
        prop_assert_eq!(lazy.outcome.ending, eager.outcome.ending, "{}", text);
        if let (Some(found), Some(other)) = (&lazy.outcome.found, &eager.outcome.found) {
            prop_assert_eq!(found.changed(&lazy.domain), other.changed(&eager.domain), "{}", text);
        }
    }
}

/// The properties above say something: many of the domains have plans, of several actions, and many have none.
#[test]
fn random_domains_are_not_all_alike() {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let (mut found, mut long, mut cut, mut moved, n) = (0, 0, 0, 0, 300);
    for _ in 0..n {
        let choices = choices().new_tree(&mut runner).unwrap().current();
        let run = plan(&domains::domain(&choices, Kind::Symbolic), &BEST);
        match &run.outcome.found {
            Some(plan) => {
                found += 1;
                long += i32::from(plan.steps.len() >= 3);
            }
            None => cut += i32::from(!run.is_exhausted()),
        }
        let (run, _) = plan_with_geometry(&choices, &choices, Kind::Geometric);
        moved += i32::from(run.reasoner.asked.iter().any(|a| a.starts_with("alternative")));
    }
    let counts = format!(
        "{found} plans, {long} of three actions or more, {cut} searches cut short, {moved} with alternatives, of {n}"
    );
    assert!(
        found > n / 5 && found < n * 9 / 10 && long > n / 20 && moved > n / 10,
        "{counts}"
    );
}
