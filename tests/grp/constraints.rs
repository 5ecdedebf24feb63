//! Constraints: what must hold in the world that an action leads to.

use sgap::engine::{Call, Formula, Projection, Reasoner, Term};
use sgap::grp::Grp;
use sgap::ir::{Base, CompareOp, Request, RequestId, Value};
use sgap::plan::{ActionRefusal, Cause};

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

const NAMES: [(&str, Base); 4] = [
    ("isReachable", Base::Bool),
    ("isVisible", Base::Bool),
    ("distance", Base::Number),
    ("isBigger", Base::Bool),
];

/// A world, with the requests that constraints are made of.
fn case(pieces: &[&str]) -> Case {
    let mut case = Case::of(pieces);
    case.domain.requests = NAMES
        .iter()
        .map(|(name, result)| Request {
            name: (*name).to_owned(),
            result: *result,
        })
        .collect();
    case
}

fn request(name: &str) -> RequestId {
    let position = NAMES.iter().position(|(n, _)| *n == name).unwrap();
    RequestId(u32::try_from(position).unwrap())
}

fn holds(case: &Case, name: &str, args: &[&str]) -> Formula {
    Formula::Holds {
        request: request(name),
        args: args.iter().map(|a| case.value(a)).collect(),
    }
}

fn nearer(case: &Case, a: &str, b: &str, than: f64) -> Formula {
    Formula::Compare {
        op: CompareOp::Less,
        left: Term::Request {
            request: request("distance"),
            args: vec![case.value(a), case.value(b)],
        },
        right: Term::Value(Value::Number(than)),
    }
}

fn place(case: &Case, grp: &mut Grp<'_>, constraints: &Formula) -> Result<Projection, ActionRefusal> {
    let args = ["PR2", "CUBE", "TABLE"].map(|a| case.value(a));
    let name = "place";
    grp.project(
        &case.domain,
        &Call {
            name,
            args: &args,
            given: &[],
            constraints,
        },
    )
}

const OTHER: &str = "[objects.OTHER]\ntype = \"Object\"\nbox = [0.06, 0.06, 0.06]\non = \"TABLE\"\nat = [-0.1, 0.2]\n";

#[test]
fn what_is_asked_for_holds_afterwards_in_every_alternative() {
    let case = case(&[ROBOT, HUMAN, TABLE, CUBE, OTHER]);
    let mut grp = case.grp(0);
    case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let held = grp.save();
    let free = place(&case, &mut grp, &Formula::TRUE).unwrap();
    grp.restore(held);
    let wanted = Formula::And(vec![
        nearer(&case, "CUBE", "OTHER", 0.12),
        holds(&case, "isReachable", &["CUBE", "BOB"]),
        holds(&case, "isReachable", &["OTHER", "BOB"]),
    ]);
    let first = place(&case, &mut grp, &wanted).unwrap();
    assert_ne!(first.gas.gas, free.gas.gas, "another search, remembered by itself");
    for alternative in 0..3 {
        if alternative > 0 {
            grp.restore(held);
            grp.find_alternative(first.gas.gas, alternative).unwrap();
        }
        let Some(Value::Number(apart)) = case.ask(&mut grp, "distance", &["CUBE", "OTHER"]) else {
            panic!("no distance");
        };
        assert!(apart < 0.12, "{apart} m");
        for object in ["CUBE", "OTHER"] {
            assert_eq!(
                case.ask(&mut grp, "isReachable", &[object, "BOB"]),
                Some(Value::Bool(true))
            );
        }
    }
    grp.restore(held);
    assert_eq!(
        place(&case, &mut grp, &wanted).unwrap(),
        first,
        "asked again, the same one"
    );
    grp.restore(held);
    assert_eq!(place(&case, &mut grp, &Formula::TRUE).unwrap(), free);
}

#[test]
fn what_can_not_hold_is_named_and_counted() {
    let far = HUMAN.replace("1.25", "3");
    let case = case(&[ROBOT, &far, TABLE, CUBE, OTHER]);
    let mut grp = case.grp(0);
    case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let held = grp.save();
    let plans = grp.counts().motion_plans;
    // Cheap, and known once the placement is: no inverse kinematics for it.
    let near = nearer(&case, "CUBE", "OTHER", 0.0);
    let calls = grp.counts().ik_calls;
    let refusal = place(&case, &mut grp, &near).unwrap_err();
    assert_eq!(grp.counts().ik_calls, calls, "no arm was asked");
    let count = |refusal: &ActionRefusal, text: &str| {
        let cause = Cause::Constraint(text.to_owned());
        refusal
            .causes
            .iter()
            .filter(|c| c.cause == cause)
            .map(|c| c.count)
            .sum::<u32>()
    };
    let near = count(&refusal, "distance(CUBE, OTHER) < 0");
    let other: u32 = refusal.causes.iter().map(|c| c.count).sum();
    assert!(near > 0 && !refusal.exhausted, "{refusal:?}");
    assert_eq!(other, refusal.tried, "each candidate has one cause");
    // Of two that can't hold, the cheap one is the cause; what asks an arm waits for the end states, but not for motions.
    let both = Formula::And(vec![
        holds(&case, "isReachable", &["CUBE", "BOB"]),
        holds(&case, "isBigger", &["CUBE", "TABLE"]),
    ]);
    grp.restore(held);
    let refusal = place(&case, &mut grp, &both).unwrap_err();
    assert!(count(&refusal, "isBigger(CUBE, TABLE)") > 0, "{refusal:?}");
    assert_eq!(count(&refusal, "isReachable(CUBE, BOB)"), 0, "{refusal:?}");
    grp.restore(held);
    let reach = holds(&case, "isReachable", &["CUBE", "BOB"]);
    let refusal = place(&case, &mut grp, &reach).unwrap_err();
    assert!(count(&refusal, "isReachable(CUBE, BOB)") > 0, "{refusal:?}");
    assert_eq!(grp.counts().motion_plans, plans, "no motion was planned for it");
    // What the symbols have decided already needs no candidate.
    grp.restore(held);
    let refusal = place(&case, &mut grp, &Formula::Or(vec![])).unwrap_err();
    assert!(refusal.tried == 0 && refusal.exhausted, "{refusal:?}");
    assert_eq!(count(&refusal, "false"), 1);
    // And the other connectives.
    grp.restore(held);
    let either = Formula::Or(vec![reach.clone(), Formula::Not(Box::new(reach))]);
    assert!(place(&case, &mut grp, &either).is_ok());
}

#[test]
fn a_pick_may_have_constraints_too() {
    let case = case(&[ROBOT, HUMAN, TABLE, CUBE, OTHER]);
    let args = ["PR2", "CUBE"].map(|a| case.value(a));
    let pick = |constraints: &Formula| {
        let name = "pick";
        case.grp(0).project(
            &case.domain,
            &Call {
                name,
                args: &args,
                given: &[],
                constraints,
            },
        )
    };
    assert!(pick(&holds(&case, "isVisible", &["OTHER", "BOB"])).is_ok());
    let refusal = pick(&nearer(&case, "CUBE", "OTHER", 0.05)).unwrap_err();
    let cause = Cause::Constraint("distance(CUBE, OTHER) < 0.05".to_owned());
    assert!(
        refusal
            .causes
            .iter()
            .any(|c| c.cause == cause && c.sub_action == "disengage"),
        "{refusal:?}"
    );
    assert!(refusal.exhausted, "every grasp was tried");
}
