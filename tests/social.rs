//! The best plan under social rules and cost formulas against all plans there are, on random domains.
//!
//! What each plan costs is confirmed by the validator, which counts the rules over the finished plan with code of its own.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "props/domains.rs"]
mod domains;
#[path = "scripted/reasoner.rs"]
mod reasoner;
#[expect(dead_code, reason = "what only the scripted tests need")]
#[path = "scripted/run.rs"]
mod run;

use std::collections::BTreeMap;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sgap::engine::{Aim, Budget, Cuts, Ending, Settings};
use sgap::plan::CostPart;

use domains::Kind;
use reasoner::Scripted;
use run::{FIRST, Run, second_opinion};

const BUDGET: Budget = Budget {
    expansions: 5_000,
    depth: 6,
};

const RULES: [&str; 16] = [
    "undesirable state held weight 2 { R.holds != BOX; }",
    "undesirable state used(Object O, Agent A) weight 1 { A >> O.users; }",
    "undesirable state both(Agent A) weight 0.5 { A.holds != NULL; NOT { EXIST(Object O, {O.done == true;}); }; }",
    "undesirable sequence again(Object O) weight 1 { Act0(_, O); Act0(_, O) immediate; }",
    "undesirable sequence turns(Agent A, Agent B, Object O) weight 1.5 { Act1(A, O); Act0(B, O); }",
    "undesirable sequence three(Object O, Agent A) weight 2 { Act0(_, O); Act1(_, O); Act1(A, _) immediate; }",
    "undesirable sequence joint(Agent A) weight 3 { Act2(_, _, A); Act0(A, _); }",
    "undesirable sequence once weight 0.25 { Act2(R, CUP, _); }",
    "effort balance weight 1;",
    "effort balance much weight 2.5;",
    "effort balance long of duration weight 0.3;",
    "wasted time weight 0.5;",
    "wasted time of_r among R weight 1;",
    "intricate links weight 1;",
    "intricate links own among H, R weight 1;",
    "wasted time never weight 0;",
];

const FORMULAS: [&str; 6] = [
    "",
    "",
    "settings { cost = makespan; }",
    "settings { cost = sum + 0.5 * makespan; }",
    "settings { cost = 0.1 * sum + makespan; }",
    "settings { cost = 2 * sum; }",
];

/// Returns a random domain with some rules.
fn domain(choices: &[u16], rules: &[u16], kind: Kind) -> String {
    let mut left = rules.iter().map(|c| usize::from(*c));
    let formula = FORMULAS[left.next().unwrap_or(0) % FORMULAS.len()];
    let mut is_there = || left.next().is_some_and(|c| c % 2 == 1);
    let rules: Vec<&str> = RULES.into_iter().filter(|_| is_there()).collect();
    let rules = if rules.is_empty() && formula.is_empty() {
        RULES[0].to_owned()
    } else {
        rules.join("\n  ")
    };
    let text = domains::domain(choices, kind);
    format!("{text}{formula}\nsocial {{\n  {rules}\n}}\n")
}

fn choices() -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(any::<u16>(), 40..220)
}

fn rules() -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(any::<u16>(), 17)
}

fn search(text: &str, reasoner: Scripted, settings: &Settings) -> Run {
    run::run(text, "Do0(R, CUP)", reasoner, settings)
}

/// The costs of all plans; each is one that the validator confirms.
fn costs(run: &Run) -> Vec<f64> {
    (0..run.n_plans())
        .map(|i| {
            let document = run.document_of(i);
            if let Err(fault) = second_opinion(run, &document) {
                let text = serde_json::to_string_pretty(&document).unwrap();
                panic!("{fault}\n{text}");
            }
            document.cost
        })
        .collect()
}

proptest! {
    #![proptest_config(Config { cases: 100, failure_persistence: None, ..Config::default() })]

    #[test]
    fn no_plan_costs_less_than_the_best(choices in choices(), rules in rules(), interleave in any::<bool>()) {
        let text = domain(&choices, &rules, Kind::Symbolic);
        let every = Settings { interleave, budget: BUDGET, aim: Aim::All(300), cuts: Cuts::Off, ..FIRST };
        let run = search(&text, Scripted::new("", &[]), &every);
        prop_assume!(run.is_exhausted());
        let cheapest = costs(&run).into_iter().fold(f64::INFINITY, f64::min);
        for cuts in [Cuts::Off, Cuts::On, Cuts::Always] {
            let best = search(&text, Scripted::new("", &[]), &Settings { cuts, aim: Aim::Best, ..every });
            let cost = costs(&best).first().copied().unwrap_or(f64::INFINITY);
            if best.is_exhausted() {
                // The same actions in another tree may be ordered in a better way: `Aim::All` lists one tree of them.
                prop_assert!(cost <= cheapest + 1e-6, "{cost} {cheapest} {cuts:?}\n{text}");
            } else {
                prop_assert!(cuts != Cuts::Off, "{:?}\n{text}", best.outcome.ending);
            }
            prop_assert!(best.outcome.least_cost <= cost.min(cheapest) + 1e-6, "{}\n{text}", best.outcome.least_cost);
            let announced: Vec<f64> = best.announced.iter().map(|(_, cost)| *cost).collect();
            prop_assert!(announced.windows(2).all(|w| w[1] < w[0]), "{announced:?}\n{text}");
        }
        // A search that is cut short promises no more than the truth.
        for expansions in [3, 10, 40] {
            let budget = Budget { expansions, ..BUDGET };
            let short = search(&text, Scripted::new("", &[]), &Settings { aim: Aim::Best, budget, ..every });
            prop_assert!(short.outcome.least_cost <= cheapest + 1e-6, "{} {cheapest}\n{text}", short.outcome.least_cost);
        }
    }

    /// With shared attributes, less is known on the way; what is best stays the same.
    #[test]
    fn no_plan_costs_less_with_geometry(choices in choices(), answers in choices(), rules in rules()) {
        let text = domain(&choices, &rules, Kind::Geometric);
        let every = Settings { branching: sgap::engine::Branching::Fixed(2), budget: BUDGET, aim: Aim::All(300), cuts: Cuts::Off, ..FIRST };
        let run = search(&text, domains::reasoner(&answers), &every);
        let is_whole = match run.outcome.ending {
            Ending::Exhausted => true,
            Ending::ExhaustedTruncated(cut) => cut.depth == 0 && cut.cycles == 0,
            Ending::FirstPlan | Ending::BudgetSpent | Ending::Interrupted => false,
        };
        prop_assume!(is_whole);
        let all = run.announced.iter().map(|(_, cost)| *cost);
        let cheapest = all.fold(f64::INFINITY, f64::min);
        let best = search(&text, domains::reasoner(&answers), &Settings { aim: Aim::Best, ..every });
        let cost = best.outcome.found.as_ref().map_or(f64::INFINITY, |f| f.cost);
        prop_assert!(cost <= cheapest + 1e-6, "{cost} {cheapest}\n{text}");
        prop_assert!(best.outcome.least_cost <= cost + 1e-6);
    }
}

/// The properties above say something: every kind of rule counts something somewhere, and rules change which plan is best.
#[test]
fn rules_matter() {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let mut counted: BTreeMap<String, u32> = BTreeMap::new();
    let mut changed = 0;
    for _ in 0..600 {
        let choices = choices().new_tree(&mut runner).unwrap().current();
        let rules = rules().new_tree(&mut runner).unwrap().current();
        let settings = Settings {
            budget: BUDGET,
            aim: Aim::Best,
            ..FIRST
        };
        let run = search(
            &domain(&choices, &rules, Kind::Symbolic),
            Scripted::new("", &[]),
            &settings,
        );
        if run.outcome.found.is_none() {
            continue;
        }
        // The best plans avoid what rules count; others do not.
        let all = Settings {
            aim: Aim::All(10),
            ..settings
        };
        let all = search(&domain(&choices, &rules, Kind::Symbolic), Scripted::new("", &[]), &all);
        for plan in (0..all.n_plans()).map(|i| all.document_of(i)) {
            for part in plan.cost_parts.iter().filter(|p| p.amount > 0.0) {
                *counted.entry(part.name.clone()).or_default() += 1;
            }
        }
        let plain = search(
            &domains::domain(&choices, Kind::Symbolic),
            Scripted::new("", &[]),
            &settings,
        );
        changed += u32::from(plain.plan() != run.plan());
    }
    let names = RULES.iter().map(|rule| {
        let words: Vec<&str> = rule.split([' ', '(']).collect();
        let is_named = words[0] == "undesirable" || !["weight", "of", "among"].contains(&words[2]);
        if is_named {
            words[2].to_owned()
        } else {
            words[..2].join(" ")
        }
    });
    let silent: Vec<String> = names.filter(|name| !counted.contains_key(name)).collect();
    assert!(silent.is_empty() && changed > 10, "{silent:?} {changed} {counted:?}");
}

const TABLE: &str = include_str!("suite/plan/language/social.hatp");

/// Every number of every part is counted again by whoever validates.
#[test]
fn no_number_of_a_part_can_be_changed() {
    let rules = "settings { cost = sum + makespan; }
        social {
          undesirable state glass_first weight 1 { GLASS.isOn == TABLE; PLATE.isOn != TABLE; }
          undesirable sequence turns(Agent A, Agent B) weight 1 { Take(A, _, _); Take(B, _, _) immediate; }
          undesirable sequence later weight 1 { Take(_, PLATE, _); Put(_, SPOON, _); }
          effort balance weight 0.3;
          effort balance long of duration weight 0.2;
          wasted time weight 0.1;
          intricate links weight 1;
        }";
    let settings = Settings {
        aim: Aim::Best,
        ..FIRST
    };
    let text = format!("{TABLE}{rules}");
    let run = run::run(&text, "SetTable(TABLE)", Scripted::new("", &[]), &settings);
    let right = run.document();
    second_opinion(&run, &right).unwrap();
    assert_eq!(right.cost_parts.len(), 9);
    for part in 0..right.cost_parts.len() {
        let changes: [fn(&mut CostPart); 3] = [|p| p.amount += 1.0, |p| p.weight += 1.0, |p| p.cost += 1.0];
        for change in changes {
            let mut plan = right.clone();
            change(&mut plan.cost_parts[part]);
            let fault = second_opinion(&run, &plan).unwrap_err();
            assert_eq!(fault.code(), "cost-part");
            assert!(fault.to_string().contains(&right.cost_parts[part].name), "{fault}");
        }
    }
}
