//! Alternatives: never the same end twice, always the same under the same number, and an end that is said.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sgap::engine::{GasRef, Reasoner};
use sgap::grp::Grp;
use sgap::plan::{ActionRefusal, Geometry};

use crate::case::{CUBE, Case, ROBOT, TABLE};

/// What the end of a projection differs in from another end of the same action: where the arm is, how or where the object is.
fn end(geometry: &Geometry) -> String {
    let rows: Vec<_> = geometry
        .sub_actions
        .iter()
        .map(|s| (&s.trajectory.joints, s.trajectory.positions.last(), &s.change))
        .collect();
    format!("{} {:?}", geometry.arm, &rows[rows.len() - 2..])
}

/// Asks for alternatives until there is none.
fn exhaust(grp: &mut Grp<'_>, first: GasRef) -> (Vec<Geometry>, ActionRefusal) {
    let mut all = vec![grp.geometry(first).unwrap()];
    let mark = grp.save();
    loop {
        match grp.find_alternative(first.gas, all.len() as u32) {
            Ok(projection) => {
                assert_eq!(projection.gas.gas, first.gas);
                assert_eq!(projection.gas.alternative as usize, all.len());
                all.push(grp.geometry(projection.gas).unwrap());
                grp.restore(mark);
            }
            Err(refusal) => return (all, refusal),
        }
    }
}

fn assert_all_differ(all: &[Geometry]) {
    let mut ends: Vec<String> = all.iter().map(end).collect();
    ends.sort();
    ends.dedup();
    assert_eq!(ends.len(), all.len(), "no end is reached twice");
}

#[test]
fn a_pick_ends_with_its_grasps() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = case.grp(0);
    let start = grp.save();
    let first = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    grp.restore(start);
    let (all, refusal) = exhaust(&mut grp, first.gas);
    assert!(all.len() > 1, "a cube can be taken in several ways");
    assert_all_differ(&all);
    let mut choices: Vec<_> = all.iter().map(|g| (&g.arm, &g.grasp)).collect();
    choices.sort();
    choices.dedup();
    assert_eq!(choices.len(), all.len(), "each takes it by another grasp or hand");

    assert_eq!(refusal.call, "pick(PR2, CUBE)");
    assert!(refusal.exhausted);
    assert_eq!(refusal.found_before as usize, all.len());
    let grasps = &case.world.scene.objects[case.object("CUBE")].grasps;
    assert_eq!(refusal.tried as usize, 2 * grasps.len(), "with two arms");
    let failed: u32 = refusal.causes.iter().map(|c| c.count).sum();
    assert_eq!(failed + refusal.found_before, refusal.tried);
    assert!(refusal.causes.windows(2).all(|w| w[0].count >= w[1].count));
    assert_eq!(refusal.to_string(), "pick(PR2, CUBE): no further solution");

    // Asked again, it says the same, and the solutions found are still there under their numbers.
    assert_eq!(grp.find_alternative(first.gas.gas, all.len() as u32), Err(refusal));
    for (alternative, known) in all.iter().enumerate().rev() {
        let again = grp.find_alternative(first.gas.gas, alternative as u32).unwrap();
        assert_eq!(&grp.geometry(again.gas).unwrap(), known);
    }
}

#[test]
fn grasps_given_twice_are_one() {
    let grasp = "{ name = \"NAME\", xyz = [0, 0, 0], rpy = [0, 1.5707963267948966, 0], width = 0.06 }";
    let twice = format!(
        "{CUBE}grasps = [{}, {}]\n",
        grasp.replace("NAME", "down"),
        grasp.replace("NAME", "down again")
    );
    let case = Case::of(&[ROBOT, TABLE, &twice]);
    let mut grp = case.grp(0);
    let start = grp.save();
    let first = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    grp.restore(start);
    let (all, _) = exhaust(&mut grp, first.gas);
    assert_all_differ(&all);
}

#[test]
fn placements_differ_and_are_not_all_there_are() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = case.grp(0);
    case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let mark = grp.save();
    let first = case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).unwrap();
    grp.restore(mark);
    let (all, refusal) = exhaust(&mut grp, first.gas);
    assert!(all.len() > 5, "{}", all.len());
    assert_all_differ(&all);
    // Two hundred points of a face do not prove that there is no other.
    assert!(!refusal.exhausted);
    assert!(refusal.tried <= 200);
    assert_eq!(refusal.found_before as usize, all.len());
    let failed: u32 = refusal.causes.iter().map(|c| c.count).sum();
    assert_eq!(failed + refusal.found_before, refusal.tried);
}

#[test]
fn the_seed_decides() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let run = |seed: u64| {
        let mut grp = case.grp(seed);
        let pick = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
        let place = case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).unwrap();
        (grp.geometry(pick.gas).unwrap(), grp.geometry(place.gas).unwrap())
    };
    let (one, again, other) = (run(1), run(1), run(2));
    assert_eq!(one, again);
    assert_eq!(one.0.grasp, other.0.grasp, "grasps are tried by promise, not by chance");
    assert_ne!(one.1.placement, other.1.placement);
}

#[test]
fn a_stopped_search_does_not_claim_to_have_tried_all() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let stop = Arc::new(AtomicBool::new(true));
    let mut grp = case.grp_with(0, Arc::clone(&stop));
    let refusal = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap_err();
    assert!(!refusal.exhausted);
    assert_eq!((refusal.tried, refusal.found_before), (0, 0));
    // It goes on where it was stopped.
    stop.store(false, Ordering::Relaxed);
    assert!(case.project(&mut grp, "pick", &["PR2", "CUBE"]).is_ok());
}
