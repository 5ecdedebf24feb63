//! The validator says yes to a right plan, and no to each damaged one for its own reason.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "validate/damage.rs"]
mod damage;
#[path = "validate/domain.rs"]
mod domain;
#[path = "validate/motions.rs"]
mod motions;
#[path = "validate/plan.rs"]
mod plan;
#[path = "validate/social.rs"]
mod social;
#[path = "validate/surroundings.rs"]
mod surroundings;
#[path = "validate/world.rs"]
mod world;

use sgap::plan::Plan;
use sgap::validate::{Fault, Kind, Settings, Verdict, replay};

/// Surfaces of cubes are seen by a third at most from one side: the threshold is lower than usual. Sliding arms need few restarts.
fn settings() -> Settings {
    Settings {
        reach_restarts: 100,
        visible_share: 0.15,
        visible_margin: 0.05,
        ..Settings::STANDARD
    }
}

fn check(plan: &Plan) -> Result<Verdict, Fault> {
    replay(plan, &domain::domain(), &domain::goal(), &world::world(), &settings())
}

#[test]
fn a_right_plan_is_valid() {
    let verdict = check(&plan::plan(&plan::Recipe::right()))
        .map_err(|f| f.to_string())
        .unwrap();
    assert_eq!(
        (
            verdict.actions,
            verdict.tasks,
            verdict.trajectories,
            verdict.attachments
        ),
        (4, 7, 8, 2)
    );
    // About 0.5 + 0.1 + 0.6 + 0.3 m and rad of motion at 0.01 each, and at least one per sample.
    assert!(verdict.configurations > 200, "{verdict}");
    assert!(verdict.pairs > 20 * verdict.configurations, "{verdict}");
}

#[test]
fn a_right_plan_survives_being_written_and_read() {
    let text = serde_json::to_string(&plan::plan(&plan::Recipe::right())).unwrap();
    let read: Plan = serde_json::from_str(&text).unwrap();
    check(&read).map_err(|f| f.to_string()).unwrap();
}

#[test]
fn the_same_plan_gets_the_same_verdict() {
    let plan = plan::plan(&plan::Recipe::right());
    assert_eq!(check(&plan), check(&plan));
}

/// What the plan needs and the world gives is confirmed; what is too near to call is taken either way.
#[test]
fn a_right_plan_with_requests_is_accepted() {
    use sgap::ir::{Test, Var};
    let plan = plan::plan(&plan::Recipe::right());
    let mut domain = domain::domain();
    let holds = |domain: &mut sgap::ir::Domain, name: &str, args: &[Var]| {
        Test::Holds(surroundings::request(domain, name, args))
    };
    let (agent, object, table, other) = (Var(0), Var(1), Var(2), Var(3));
    let pick = [
        holds(&mut domain, "canReach", &[agent, object]),
        holds(&mut domain, "pathExists", &[agent, object]),
    ];
    domain.actions[0].preconditions = Test::And(pick.to_vec());
    let place = [
        holds(&mut domain, "isOn", &[object, table]),
        holds(&mut domain, "isReachable", &[object, other]),
        holds(&mut domain, "virtualPlace", &[object, table]),
        holds(&mut domain, "isNextTo", &[object, table]),
        Test::Not(Box::new(holds(&mut domain, "isIn", &[object, table]))),
        Test::Not(Box::new(holds(&mut domain, "isBigger", &[object, table]))),
        // It stands on the table: whether 0 is less than 0 and a millionth is up to rounding.
        surroundings::nearer(&mut domain, object, table, 1e-7),
        Test::Not(Box::new(surroundings::nearer(&mut domain, object, table, 1e-7))),
    ];
    domain.actions[1].constraints = Test::And(place.to_vec());
    // Before it is put down it is in the hand: it goes along, and is nothing to stand near.
    let near_held = holds(&mut domain, "enoughRoom", &[agent, object, table]);
    domain.actions[1].preconditions = Test::And(vec![
        domain.actions[1].preconditions.clone(),
        Test::Not(Box::new(near_held)),
    ]);
    replay(
        &plan,
        &domain,
        &domain::goal(),
        &world::world(),
        &sgap::validate::Settings::STANDARD,
    )
    .unwrap_or_else(|fault| panic!("{fault}"));
}

/// Each damaged plan is refused with its own code, at its place, with the names in the sentence.
fn refused(damages: Vec<damage::Damage>) {
    let mut wrong = Vec::new();
    for damage in damages {
        let what = damage.what;
        let fault = match replay(
            &damage.plan,
            &damage.domain,
            &domain::goal(),
            &damage.world,
            &damage.settings,
        ) {
            Ok(verdict) => {
                wrong.push(format!("{what}: accepted, {verdict}"));
                continue;
            }
            Err(fault) => fault,
        };
        let action = fault.place.action.as_ref().map(|a| a.0);
        let sub_action = fault.place.sub_action.as_ref().map(|s| s.1.as_str());
        let is_timed = fault.place.time.is_some() || damage.sub_action.is_none();
        let has_words = damage.words.iter().all(|w| fault.to_string().contains(w));
        if (fault.code(), action, sub_action) != (damage.code, damage.action, damage.sub_action)
            || !is_timed
            || !has_words
        {
            wrong.push(format!(
                "{what}: {} {:?} expected, but: {fault}",
                damage.code, damage.words
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn damaged_documents_are_refused() {
    refused(damage::documents());
}

#[test]
fn damaged_symbols_are_refused() {
    refused(damage::symbols());
}

#[test]
fn damaged_motions_are_refused() {
    refused(motions::motions());
}

#[test]
fn damaged_grips_are_refused() {
    refused(motions::grips());
}

#[test]
fn damaged_trees_are_refused() {
    refused(damage::trees());
}

#[test]
fn damaged_schedules_are_refused() {
    refused(damage::schedules());
}

#[test]
fn right_plans_in_other_surroundings_are_refused() {
    refused(surroundings::surroundings());
}

#[test]
fn damaged_costs_are_refused() {
    let right = social::right_costs();
    replay(&right.plan, &right.domain, &domain::goal(), &right.world, &settings())
        .map_err(|f| f.to_string())
        .unwrap();
    refused(social::costs());
}

/// No code without a plan that is refused for it.
#[test]
fn every_code_has_a_damaged_plan() {
    let groups = [
        damage::documents(),
        damage::symbols(),
        motions::motions(),
        motions::grips(),
        damage::trees(),
        damage::schedules(),
        social::costs(),
        surroundings::surroundings(),
    ];
    // These two want a way over a floor, and a description: tests/damaged_plans.rs has them.
    let elsewhere = ["drive", "target-missed"];
    let codes: Vec<&str> = groups.iter().flatten().map(|d| d.code).chain(elsewhere).collect();
    let missing: Vec<&&str> = Kind::CODES.iter().filter(|c| !codes.contains(c)).collect();
    assert!(missing.is_empty(), "no damaged plan for {missing:?}");
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/validate.md")).unwrap();
    let missing: Vec<&&str> = Kind::CODES
        .iter()
        .filter(|c| !page.contains(&format!("`{c}`")))
        .collect();
    assert!(missing.is_empty(), "not in docs/validate.md: {missing:?}");
}

/// The same damage as above, with its time: the sample at which the joint jumps, counted from the plan's start.
#[test]
fn a_fault_has_the_time_at_which_it_happens() {
    let mut plan = plan::plan(&plan::Recipe::right());
    let start = 0.25;
    plan.actions[plan::PICK].start = start;
    let trajectory = &mut plan.actions[plan::PICK].geometry.as_mut().unwrap().sub_actions[1].trajectory;
    trajectory.positions[10][0] += 0.1;
    let within = trajectory.times[10];
    let before = plan.actions[plan::PICK].geometry.as_ref().unwrap().sub_actions[0]
        .trajectory
        .duration();
    let fault = check(&plan).unwrap_err();
    assert_eq!(fault.code(), "speed");
    assert!(
        (fault.place.time.unwrap() - (start + before + within)).abs() < 1e-12,
        "{fault}"
    );
}

/// The validator is a second opinion only while it uses nothing of what it judges.
#[test]
fn nothing_of_the_planner_is_used() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/validate");
    let mut n_files = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        n_files += 1;
        for room in ["engine", "grp", "report", "check", "syntax", "motion", "ik"] {
            let forbidden = [
                format!("crate::{room}"),
                format!("geom::{room}"),
                format!("sgap::{room}"),
            ];
            for name in &forbidden {
                assert!(!text.contains(name.as_str()), "{} uses {name}", path.display());
            }
        }
        // `use crate::geom::{...}` may list what is common, and nothing else.
        for list in text.split("crate::geom::{").skip(1) {
            let list = &list[..list.find("};").unwrap_or(list.len())];
            for name in ["motion", "ik::", "ik,", "Chain"] {
                assert!(!list.contains(name), "{} uses geom::{name}", path.display());
            }
        }
    }
    assert!(n_files > 10, "only {n_files} files found");
}
