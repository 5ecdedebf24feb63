//! Properties of the whole: whatever plan comes out of a search, the validator has nothing against it.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "props/domains.rs"]
mod domains;
#[path = "scripted/reasoner.rs"]
mod reasoner;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/run.rs"]
mod run;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sgap::engine::{Budget, Settings};

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
        for settings in [FIRST, BEST] {
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
        if let (Some(lazy), Some(eager)) = (&lazy.outcome.found, &eager.outcome.found) {
            for step in 0..lazy.steps.len() {
                prop_assert_eq!(lazy.changes(step), eager.changes(step), "{}", text);
            }
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
        found > n / 4 && found < n * 9 / 10 && long > n / 20 && moved > n / 10,
        "{counts}"
    );
}
