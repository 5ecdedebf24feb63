//! Properties of the whole: whatever plan comes out of a search, the validator has nothing against it.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "props/domains.rs"]
mod domains;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/reasoner.rs"]
mod reasoner;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/run.rs"]
mod run;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sgap::engine::{Budget, Settings};

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
    #![proptest_config(Config { cases: 1500, failure_persistence: None, ..Config::default() })]

    #[test]
    fn every_plan_is_valid(choices in choices()) {
        let text = domains::domain(&choices);
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
        let text = domains::domain(&choices);
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

/// The properties above say something: many of the domains have plans, of several actions, and many have none.
#[test]
fn random_domains_are_not_all_alike() {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let (mut found, mut long, mut cut, n) = (0, 0, 0, 300);
    for _ in 0..n {
        let choices = choices().new_tree(&mut runner).unwrap().current();
        let run = plan(&domains::domain(&choices), &BEST);
        match &run.outcome.found {
            Some(plan) => {
                found += 1;
                long += i32::from(plan.steps.len() >= 3);
            }
            None => cut += i32::from(!run.is_exhausted()),
        }
    }
    let counts = format!("{found} plans, {long} of three actions or more, {cut} searches cut short, of {n}");
    assert!(found > n / 4 && found < n * 9 / 10 && long > n / 20, "{counts}");
}
