//! The stack of world states: marks, rewinding and replaying.

use sgap::engine::Reasoner;

use crate::case::{CUBE, Case, ROBOT, TABLE};

#[test]
fn restoring_goes_back_and_remembers_the_solution() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let held = case.in_hand("PR2", "CUBE");
    let mut grp = case.grp(0);
    let start = grp.save();
    let first = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    assert!(grp.holds(held));
    let picked = grp.save();
    let placed = case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).unwrap();
    assert!(!grp.holds(held));
    assert_ne!(first.gas.gas, placed.gas.gas);
    let counts = grp.counts();

    grp.restore(picked);
    assert!(grp.holds(held));
    assert_eq!(case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]), Ok(placed));
    grp.restore(start);
    assert!(!grp.holds(held));
    assert_eq!(case.project(&mut grp, "pick", &["PR2", "CUBE"]), Ok(first));
    assert!(grp.holds(held));
    assert_eq!(grp.counts(), counts, "nothing was computed twice");
}

#[test]
fn another_state_is_another_action() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = case.grp(0);
    let first = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).unwrap();
    let again = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    assert_ne!(first.gas.gas, again.gas.gas);
    assert_eq!(again.gas.alternative, 0);
}

#[test]
fn a_rewound_history_can_be_replayed_and_left_again() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let held = case.in_hand("PR2", "CUBE");
    let mut grp = case.grp(0);
    let before = grp.all_facts();
    let pick = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let after_pick = grp.all_facts();
    let place = case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).unwrap();
    let after_place = grp.all_facts();
    let end = grp.save();

    grp.rewind();
    assert_eq!(grp.all_facts(), before);
    grp.replay(pick.gas);
    assert_eq!(grp.all_facts(), after_pick);
    assert!(grp.holds(held));
    grp.replay(place.gas);
    assert_eq!(grp.all_facts(), after_place);
    grp.rewind();
    grp.restore(end);
    assert_eq!(grp.all_facts(), after_place);
}

#[test]
fn a_refused_action_changes_nothing() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = case.grp(0);
    let (mark, facts) = (grp.save(), grp.all_facts());
    assert!(case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).is_err());
    assert_eq!((grp.save(), grp.all_facts()), (mark, facts));
}
