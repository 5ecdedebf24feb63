//! In, next to, bigger, how far apart: at their edges, with numbers from the worlds.

use sgap::geom::pose_xyz_rpy;

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

/// 0.3 x 0.3 x 0.2 m inside, open at the top, its floor 0.02 m thick, on the ground far from everything.
const BIN: &str = r#"
[objects.BIN]
type = "Support"
movable = false
xyz = [3, 3, 0]
parts = [
    { box = [0.34, 0.34, 0.02], xyz = [0, 0, 0.01] },
    { box = [0.02, 0.34, 0.20], xyz = [0.16, 0, 0.12] },
    { box = [0.02, 0.34, 0.20], xyz = [-0.16, 0, 0.12] },
    { box = [0.30, 0.02, 0.20], xyz = [0, 0.16, 0.12] },
    { box = [0.30, 0.02, 0.20], xyz = [0, -0.16, 0.12] },
]
containers = [{ name = "inside", size = [0.30, 0.30, 0.20], xyz = [0, 0, 0.12] }]
"#;

#[test]
fn an_object_is_in_what_holds_all_of_it() {
    let rod = "[objects.ROD]\ntype = \"Object\"\ncylinder = { radius = 0.02, length = 0.24 }\nxyz = [0, 5, 1]\n";
    let mut case = Case::of(&[TABLE, CUBE, BIN, rod]);
    // The container reaches from z = 0.02 to 0.22 m, and 0.15 m from its middle; half of the cube is 0.03 m.
    for (x, z, yaw, expected, why) in [
        (0.0, 0.05, 0.0, true, "on its floor"),
        (0.12, 0.05, 0.0, true, "at its wall"),
        (0.1205, 0.05, 0.0, true, "within the tolerance"),
        (0.122, 0.05, 0.0, false, "in its wall"),
        (0.12, 0.05, 0.7, false, "with a corner in its wall"),
        (0.0, 0.19, 0.0, true, "flush with its rim"),
        (0.0, 0.20, 0.0, false, "above its rim"),
        (0.5, 0.05, 0.0, false, "beside it"),
    ] {
        *case.X_WO("CUBE") = pose_xyz_rpy([3.0 + x, 3.0, z], [0.0, 0.0, yaw]);
        assert_eq!(case.says("isIn", &["CUBE", "BIN"]), Some(expected), "{why}");
    }
    // 0.24 m long: too long to stand in 0.20 m; lying along the diagonal it is not.
    for (rpy, expected, why) in [
        ([0.0, 0.0, 0.0], false, "upright"),
        ([std::f64::consts::FRAC_PI_2, 0.0, 0.0], true, "lying"),
        ([0.9, 0.0, 0.0], true, "leaning"),
    ] {
        *case.X_WO("ROD") = pose_xyz_rpy([3.0, 3.0, 0.12], rpy);
        assert_eq!(case.says("isIn", &["ROD", "BIN"]), Some(expected), "{why}");
    }
    assert_eq!(
        case.says("isIn", &["CUBE", "TABLE"]),
        Some(false),
        "a table has no inside"
    );
    assert_eq!(case.says("isIn", &["BIN", "BIN"]), Some(false));
}

#[test]
fn what_is_ten_centimetres_away_is_next_to_it() {
    let other = "[objects.OTHER]\ntype = \"Object\"\nbox = [0.1, 0.1, 0.1]\nxyz = [0, 5, 1]\n";
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, other]);
    *case.X_WO("CUBE") = pose_xyz_rpy([3.0, 0.0, 1.0], [0.0; 3]);
    for (gap, expected) in [(0.0, true), (0.0999, true), (0.1001, false), (1.0, false)] {
        *case.X_WO("OTHER") = pose_xyz_rpy([3.0 + 0.03 + 0.05 + gap, 0.0, 1.0], [0.0; 3]);
        assert_eq!(case.says("isNextTo", &["CUBE", "OTHER"]), Some(expected), "{gap} m");
        assert_eq!(
            case.says("isNextTo", &["OTHER", "CUBE"]),
            Some(expected),
            "{gap} m, the other way round"
        );
        let Some(sgap::ir::Value::Number(distance)) = case.ask(&mut case.grp(0), "distance", &["CUBE", "OTHER"]) else {
            panic!("no distance");
        };
        assert!((distance - gap).abs() < 1e-9, "{distance} is not {gap}");
    }
    assert_eq!(case.says("isNextTo", &["CUBE", "CUBE"]), None);
    assert_eq!(case.says("isNextTo", &["CUBE", "PR2"]), Some(false));
}

#[test]
fn the_larger_volume_is_bigger() {
    let others = "[objects.TALL]\ntype = \"Object\"\nbox = [0.02, 0.02, 0.6]\nxyz = [0, 5, 1]\n\
                  [objects.SAME]\ntype = \"Object\"\nbox = [0.03, 0.06, 0.12]\nxyz = [0, 6, 1]\n\
                  [virtual.VOLUME]\ntype = \"Object\"\nbox = [0.3, 0.3, 0.3]\n";
    let case = Case::of(&[HUMAN, TABLE, CUBE, others]);
    // 0.216 l against 0.24 l: the tall one is thinner, and bigger.
    for (a, b, bigger, smaller) in [
        ("TALL", "CUBE", true, false),
        ("CUBE", "TALL", false, true),
        ("CUBE", "SAME", false, false),
        ("CUBE", "CUBE", false, false),
        ("BOB", "TABLE", false, true),
        ("VOLUME", "CUBE", true, false),
    ] {
        assert_eq!(case.says("isBigger", &[a, b]), Some(bigger), "{a} > {b}");
        assert_eq!(case.says("isSmaller", &[a, b]), Some(smaller), "{a} < {b}");
    }
}
