//! Going: stands, alternatives, what goes along, refusals.

use sgap::engine::Reasoner;
use sgap::plan::{Geometry, Motion};

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

/// Far from the robot, to its left.
const FAR: &str = r#"
[objects.BENCH]
type = "Support"
movable = false
box = [0.5, 0.5, 0.7]
xyz = [-1.5, 2.5, 0.35]

[objects.CAN]
type = "Object"
box = [0.05, 0.05, 0.12]
on = "BENCH"
"#;

fn base(geometry: &Geometry) -> [f64; 3] {
    let stand = geometry.stand.unwrap();
    let last = geometry.sub_actions.last().unwrap();
    assert_eq!(last.motion, Motion::Base);
    assert_eq!(last.trajectory.joints, ["x", "y", "yaw"]);
    let row = last.trajectory.positions.last().unwrap();
    assert_eq!([row[0], row[1]], [stand.x, stand.y]);
    [stand.x, stand.y, stand.yaw]
}

#[test]
fn it_goes_to_where_it_reaches_the_object_and_takes_it() {
    let case = Case::of(&[ROBOT, TABLE, CUBE, FAR]);
    let mut grp = case.grp(0);
    assert!(!grp.holds(case.reachable("CAN", "PR2")));
    let gone = case.project(&mut grp, "navigateTo", &["PR2", "CAN"]).unwrap();
    assert!(grp.holds(case.reachable("CAN", "PR2")));
    let geometry = grp.geometry(gone.gas).unwrap();
    let [x, y, _] = base(&geometry);
    assert!((x + 1.5).hypot(y - 2.5) < 1.3, "({x}, {y}) is near (-1.5, 2.5)");
    assert!((geometry.cost_parts.values().sum::<f64>() - gone.cost).abs() < 1e-9);
    let taken = case.project(&mut grp, "pick", &["PR2", "CAN"]).unwrap();
    // What it holds goes along, to where it came from.
    case.project(&mut grp, "navigateTo", &["PR2", "TABLE"]).unwrap();
    assert!(grp.holds(case.in_hand("PR2", "CAN")));
    case.project(&mut grp, "place", &["PR2", "CAN", "TABLE"]).unwrap();
    assert!(grp.holds(case.on("CAN", "TABLE")));
    assert!(taken.cost > 0.0);
}

#[test]
fn alternatives_end_elsewhere_each_time() {
    let case = Case::of(&[ROBOT, TABLE, FAR]);
    let mut grp = case.grp(0);
    let start = grp.save();
    let first = case.project(&mut grp, "navigateTo", &["PR2", "BENCH"]).unwrap();
    let mut ends = vec![base(&grp.geometry(first.gas).unwrap())];
    for k in 1..6 {
        grp.restore(start);
        let next = grp.find_alternative(first.gas.gas, k).unwrap();
        let end = base(&grp.geometry(next.gas).unwrap());
        assert!(!ends.contains(&end), "{end:?} comes twice");
        ends.push(end);
    }
    // Another run of the same gives the same.
    let mut again = case.grp(0);
    let same = case.project(&mut again, "navigateTo", &["PR2", "BENCH"]).unwrap();
    assert_eq!(base(&again.geometry(same.gas).unwrap()), ends[0]);
}

#[test]
fn who_minds_makes_it_dearer_and_the_parts_say_so() {
    let cost = |human: &str| {
        let case = Case::of(&[ROBOT, TABLE, FAR, human]);
        let mut grp = case.grp(0);
        let gone = case.project(&mut grp, "navigateTo", &["PR2", "BENCH"]).unwrap();
        grp.geometry(gone.gas).unwrap().cost_parts
    };
    let alone = cost("");
    assert_eq!(alone.get("distance"), None);
    let far = cost(&HUMAN.replace("x = 1.25, y = 0", "x = 9, y = -9"));
    assert_eq!(far["distance"], 0.0);
    let near = cost(&HUMAN.replace("x = 1.25, y = 0", "x = -1.5, y = 0.6"));
    assert!(near["distance"] > 0.5, "{near:?}");
    assert!((alone["length"] - far["length"]).abs() < 1e-9);
}

#[test]
fn a_refusal_says_why() {
    let refusal = |case: &Case, args: &[&str]| {
        let refusal = case.project(&mut case.grp(0), "navigateTo", args).unwrap_err();
        let causes = refusal.causes.iter().map(|c| format!("{c} x{}", c.count));
        (refusal.to_string(), causes.collect::<Vec<_>>().join("; "))
    };
    // Walls all around the bench, higher than the robot.
    let walls = (0..4).map(|k| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_2).sin_cos();
        let (x, y) = (-1.5 + 1.8 * cos, 2.5 + 1.8 * sin);
        let sides = if k % 2 == 0 { [0.1, 3.7, 2.0] } else { [3.7, 0.1, 2.0] };
        format!("[objects.WALL_{k}]\ntype = \"Support\"\nmovable = false\nbox = {sides:?}\nxyz = [{x}, {y}, 1.0]\n")
    });
    let closed = Case::of(&[ROBOT, FAR, &walls.collect::<String>()]);
    let (_, causes) = refusal(&closed, &["PR2", "BENCH"]);
    assert!(causes.contains("no way for the base"), "{causes}");
    let case = Case::of(&[ROBOT, TABLE, CUBE, HUMAN]);
    let (text, _) = refusal(&case, &["PR2", "PR2"]);
    assert!(text.contains("is there already"), "{text}");
    let model = std::fs::read_to_string("worlds/models/pr2.toml").unwrap();
    let fixed = model
        .replace("base = \"planar\"", "base = \"fixed\"")
        .replace("pr2.urdf", "models/pr2.urdf");
    let fixed = Case::with_model(&fixed, &[TABLE, CUBE]);
    let (text, _) = refusal(&fixed, &["PR2", "CUBE"]);
    assert!(text.contains("the base of PR2 does not go on the floor"), "{text}");
}

#[test]
fn a_differential_base_moves_along_its_heading_alone() {
    let model = std::fs::read_to_string("worlds/models/pr2.toml").unwrap();
    let model = model
        .replace("base = \"planar\"", "base = \"differential\"")
        .replace("pr2.urdf", "models/pr2.urdf");
    let case = Case::with_model(&model, &[TABLE, FAR]);
    let mut grp = case.grp(0);
    let gone = case.project(&mut grp, "navigateTo", &["PR2", "BENCH"]).unwrap();
    let geometry = grp.geometry(gone.gas).unwrap();
    let rows = &geometry.sub_actions.last().unwrap().trajectory.positions;
    for pair in rows.windows(2) {
        let [dx, dy, turn] = [0, 1, 2].map(|i| pair[1][i] - pair[0][i]);
        let sideways = pair[1][2].cos() * dy - pair[1][2].sin() * dx;
        assert!(
            sideways.abs() < 1e-9 && (dx.hypot(dy) < 1e-9 || turn.abs() < 1e-9),
            "{pair:?}"
        );
    }
}

#[test]
fn a_human_goes_as_well() {
    let case = Case::of(&[TABLE, HUMAN, FAR]);
    let mut grp = case.grp(0);
    let gone = case.project(&mut grp, "navigateTo", &["BOB", "CAN"]).unwrap();
    assert!(grp.holds(case.reachable("CAN", "BOB")));
    assert_eq!(grp.geometry(gone.gas).unwrap().cost_parts.get("distance"), None);
}
