//! What can't be done says why.

use sgap::engine::{Call, Formula, Reasoner};
use sgap::ir::Value;
use sgap::plan::{ActionRefusal, Cause};

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

const TRAY: &str = r#"
[objects.TRAY]
type = "Support"
box = [0.20, 0.20, 0.05]
on = "TABLE"
at = [0, 0.15]
grasps = [{ name = "rim", xyz = [-0.1, 0, 0], rpy = [0, 1.5707963267948966, 0], width = 0.05 }]
"#;

/// Returns the only reason of a refusal for which nothing was tried.
fn reason(refusal: &ActionRefusal) -> &str {
    assert_eq!((refusal.tried, refusal.found_before, refusal.exhausted), (0, 0, true));
    match refusal.causes.as_slice() {
        [only] if only.count == 1 && only.sub_action.is_empty() => match &only.cause {
            Cause::NotApplicable(why) => why,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

fn refused(case: &Case, name: &str, args: &[&str]) -> String {
    reason(&case.project(&mut case.grp(0), name, args).unwrap_err()).to_owned()
}

#[test]
fn calls_that_make_no_sense() {
    let case = Case::of(&[ROBOT, HUMAN, TABLE, CUBE]);
    let unknown = case.project(&mut case.grp(0), "juggle", &["PR2", "CUBE"]).unwrap_err();
    assert_eq!(reason(&unknown), "there is no geometric action `juggle`");
    assert_eq!(unknown.call, "juggle(PR2, CUBE)");
    assert_eq!(refused(&case, "pick", &["PR2"]), "`pick` takes 2 arguments, not 1");
    assert_eq!(
        refused(&case, "place", &["PR2", "CUBE"]),
        "`place` takes 3 arguments, not 2"
    );
    assert_eq!(refused(&case, "pick", &["CUBE", "CUBE"]), "CUBE is not an agent");
    assert_eq!(refused(&case, "pick", &["PR2", "BOB"]), "BOB is not an object");
    assert_eq!(
        refused(&case, "placeReachable", &["PR2", "CUBE", "TABLE", "TABLE"]),
        "TABLE is not an agent"
    );
    let args = [Value::Entity(case.domain.entity("PR2").unwrap()), Value::Null];
    let call = Call {
        name: "pick",
        args: &args,
        given: &[],
        constraints: &Formula::TRUE,
    };
    let null = case.grp(0).project(&case.domain, &call).unwrap_err();
    assert_eq!(reason(&null), "NULL is not an entity");
}

#[test]
fn things_that_can_not_be_taken() {
    let wide = "[objects.CHEST]\ntype = \"Object\"\nbox = [0.3, 0.3, 0.3]\nxyz = [0, 3, 0.15]\n";
    let mut case = Case::of(&[ROBOT, HUMAN, TABLE, CUBE, wide]);
    assert_eq!(refused(&case, "pick", &["PR2", "TABLE"]), "TABLE can't be moved");
    assert_eq!(refused(&case, "pick", &["PR2", "CHEST"]), "CHEST has no grasp");
    assert_eq!(refused(&case, "pick", &["BOB", "CUBE"]), "BOB has no gripper");
    case.give("CUBE", "BOB", 0);
    assert_eq!(refused(&case, "pick", &["PR2", "CUBE"]), "CUBE is held by BOB");
    assert_eq!(
        refused(&case, "place", &["PR2", "CUBE", "TABLE"]),
        "CUBE is not in a hand of PR2"
    );
}

#[test]
fn hands_that_can_not_take() {
    let no_hand = "PR2 has no free hand whose fingers can hold CUBE";
    let given = |width: f64| format!("{CUBE}grasps = [{{ name = \"g\", width = {width} }}]\n");
    let case = Case::of(&[ROBOT, TABLE, &given(0.09)]);
    assert_eq!(refused(&case, "pick", &["PR2", "CUBE"]), no_hand);
    let others = "[objects.A]\ntype = \"Object\"\nbox = [0.04, 0.04, 0.04]\nxyz = [0, 5, 1]\n\
                  [objects.B]\ntype = \"Object\"\nbox = [0.04, 0.04, 0.04]\nxyz = [0, 6, 1]\n";
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, others]);
    case.give("A", "PR2", 0);
    case.give("B", "PR2", 1);
    assert_eq!(refused(&case, "pick", &["PR2", "CUBE"]), no_hand);
}

#[test]
fn fingers_that_do_not_close_far_enough() {
    let model = std::fs::read_to_string("worlds/models/pr2.toml").unwrap();
    let model = model.replace("\"pr2.urdf\"", "\"models/pr2.urdf\"");
    let gap = |gap: &str| model.replace("gap_closed = 0", &format!("gap_closed = {gap}"));
    // The cube is 0.06 m wide.
    let case = Case::with_model(&gap("0.05"), &[TABLE, CUBE]);
    assert!(case.holds(case.reachable("CUBE", "PR2")));
    assert!(case.project(&mut case.grp(0), "pick", &["PR2", "CUBE"]).is_ok());
    let case = Case::with_model(&gap("0.07"), &[TABLE, CUBE]);
    assert!(!case.holds(case.reachable("CUBE", "PR2")));
    assert_eq!(
        refused(&case, "pick", &["PR2", "CUBE"]),
        "PR2 has no free hand whose fingers can hold CUBE"
    );
}

#[test]
fn a_bare_hand_can_not_let_go() {
    let mut case = Case::of(&[HUMAN, TABLE, CUBE]);
    case.give("CUBE", "BOB", 0);
    assert_eq!(refused(&case, "place", &["BOB", "CUBE", "TABLE"]), "BOB has no gripper");
}

#[test]
fn things_that_can_not_be_put_there() {
    let others = "[objects.BALL]\ntype = \"Object\"\nsphere = { radius = 0.03 }\nxyz = [0, 3, 0.03]\n\
                  [objects.PEG]\ntype = \"Support\"\nmovable = false\nbox = [0.03, 0.03, 0.3]\nxyz = [0, 4, 0.15]\n";
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, others]);
    case.give("CUBE", "PR2", 0);
    assert_eq!(
        refused(&case, "place", &["PR2", "CUBE", "BALL"]),
        "BALL has no face to put things on"
    );
    assert_eq!(
        refused(&case, "place", &["PR2", "CUBE", "PEG"]),
        "CUBE does not fit on PEG in any orientation"
    );
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, others]);
    case.give("BALL", "PR2", 0);
    assert_eq!(
        refused(&case, "place", &["PR2", "BALL", "TABLE"]),
        "BALL can't stand by itself"
    );
}

#[test]
fn nothing_is_put_on_itself() {
    let mut case = Case::of(&[ROBOT, TABLE, TRAY]);
    case.give("TRAY", "PR2", 0);
    assert_eq!(
        refused(&case, "place", &["PR2", "TRAY", "TRAY"]),
        "TRAY can't be put on itself"
    );
}

#[test]
fn nothing_is_put_on_what_is_in_a_hand() {
    let mut case = Case::of(&[ROBOT, HUMAN, TABLE, CUBE, TRAY]);
    case.give("CUBE", "PR2", 0);
    case.give("TRAY", "BOB", 0);
    assert_eq!(refused(&case, "place", &["PR2", "CUBE", "TRAY"]), "TRAY is held by BOB");
}

#[test]
fn nothing_is_put_on_a_face_that_is_not_level() {
    let lying = TRAY.replace("at =", "stands = \"+x\"\nat =");
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, &lying]);
    case.give("CUBE", "PR2", 0);
    assert_eq!(
        refused(&case, "place", &["PR2", "CUBE", "TRAY"]),
        "TRAY has no level face to put things on"
    );
}

#[test]
fn what_carries_something_is_not_taken_from_under_it() {
    let cube = CUBE.replace("\"TABLE\"", "\"TRAY\"").replace("at = [-0.1, -0.2]", "");
    let near = TRAY.replace("at = [0, 0.15]", "at = [-0.05, 0.15]");
    let free = Case::of(&[ROBOT, TABLE, &near]);
    assert!(free.project(&mut free.grp(0), "pick", &["PR2", "TRAY"]).is_ok());
    let case = Case::of(&[ROBOT, TABLE, &near, &cube]);
    let refusal = case.project(&mut case.grp(0), "pick", &["PR2", "TRAY"]).unwrap_err();
    assert!(refusal.exhausted && refusal.tried > 0);
    let hit = Cause::Collision {
        a: "TRAY".into(),
        b: "CUBE".into(),
    };
    assert!(
        refusal
            .causes
            .iter()
            .any(|c| c.sub_action == "disengage" && c.cause == hit),
        "{refusal:?}"
    );
}

#[test]
fn a_promise_that_can_not_be_kept_is_named() {
    let far = HUMAN.replace("1.25", "3");
    let case = Case::of(&[ROBOT, &far, TABLE, CUBE]);
    let mut grp = case.grp(0);
    case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let refusal = case
        .project(&mut grp, "placeR", &["PR2", "CUBE", "TABLE", "BOB"])
        .unwrap_err();
    let fact = Cause::Fact("isReachable(CUBE, BOB)".into());
    assert!(
        refusal
            .causes
            .iter()
            .any(|c| c.sub_action == "place" && c.cause == fact),
        "{refusal:?}"
    );
    assert!(!refusal.exhausted && refusal.tried > 0 && refusal.found_before == 0);
}
