//! Geometric requests on small worlds where the answer follows from the numbers.

use sgap::engine::Reasoner;
use sgap::ir::Value;

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

/// 0.2 m in square: there is room for two beside each other across the small table (0.4 m), and four along it (0.8 m).
const VOLUME: &str = "[virtual.VOLUME]\ntype = \"Object\"\nbox = [0.2, 0.2, 0.3]\nstable = [{ name = \"upright\" }]\n";

fn block(id: &str, sides: [f64; 3], at: [f64; 2]) -> String {
    format!("[objects.{id}]\ntype = \"Object\"\nbox = {sides:?}\non = \"TABLE\"\nat = {at:?}\n")
}

#[test]
fn a_virtual_object_fits_where_there_is_room() {
    let fits = |blocks: &[String], volume: &str| {
        let mut pieces: Vec<&str> = blocks.iter().map(String::as_str).collect();
        pieces.extend([TABLE, volume]);
        Case::of(&pieces).says("virtualPlace", &["VOLUME", "TABLE"])
    };
    assert_eq!(fits(&[], VOLUME), Some(true), "an empty table");
    // A wall across the table at y = 0.1: 0.29 m are left on its one side, 0.49 m on the other.
    let wall = |y: f64| block("WALL", [0.4, 0.02, 0.2], [0.0, y]);
    assert_eq!(fits(&[wall(0.1)], VOLUME), Some(true));
    let two = |gap: f64| {
        let (a, b) = (
            block("A", [0.4, 0.3, 0.1], [0.0, -0.25]),
            block("B", [0.4, 0.48 - gap, 0.1], [0.0, 0.4 - (0.48 - gap) / 2.0]),
        );
        // A ends at y = -0.1; B leaves `gap - 0.08 + 0.1` m between them.
        (vec![a, b], gap + 0.02)
    };
    for (gap, expected) in [(0.19, true), (0.17, false)] {
        let (blocks, room) = two(gap);
        assert_eq!(fits(&blocks, VOLUME), Some(expected), "{room:.3} m between two blocks");
    }
    let long = VOLUME.replace("0.2, 0.2", "0.39, 0.79");
    assert_eq!(fits(&[], &long), Some(true), "nearly the whole table");
    let longer = VOLUME.replace("0.2, 0.2", "0.41, 0.79");
    assert_eq!(fits(&[], &longer), Some(false), "wider than the table");
}

#[test]
fn only_things_are_in_the_way_and_the_virtual_object_is_in_nobody_s() {
    // The arm of the robot reaches over the table; a thing in its hand does as well.
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, VOLUME]);
    assert_eq!(case.says("virtualPlace", &["VOLUME", "TABLE"]), Some(true));
    let whole = VOLUME.replace("0.2, 0.2", "0.39, 0.79");
    let full = Case::of(&[ROBOT, TABLE, CUBE, &whole]);
    assert_eq!(
        full.says("virtualPlace", &["VOLUME", "TABLE"]),
        Some(false),
        "the cube is in the way"
    );
    // A real object is not in its own way.
    assert_eq!(case.says("virtualPlace", &["CUBE", "TABLE"]), Some(true));
    assert_eq!(
        case.says("virtualPlace", &["CUBE", "CUBE"]),
        Some(false),
        "nothing stands on itself"
    );
    case.give("CUBE", "PR2", 0);
    let mut held = full;
    held.give("CUBE", "PR2", 0);
    assert_eq!(
        held.says("virtualPlace", &["VOLUME", "TABLE"]),
        Some(true),
        "what is held is in nobody's way"
    );
    let mut grp = case.grp(0);
    let facts = grp.all_facts();
    assert!(!facts.is_empty());
    let ids: Vec<&str> = facts
        .iter()
        .flat_map(|f| [f.1, f.2])
        .map(|e| case.world.scene.id(e))
        .collect();
    assert!(!ids.contains(&"VOLUME"), "no facts about what is nowhere");
    // Nor has it a place that could be asked for.
    assert_eq!(case.says("isOn", &["VOLUME", "TABLE"]), None);
    assert_eq!(case.ask(&mut grp, "distance", &["VOLUME", "TABLE"]), None);
    assert_eq!(case.says("canSee", &["PR2", "VOLUME"]), None);
}

#[test]
fn requests_about_agents_are_the_facts_the_other_way_round() {
    for pieces in [
        [ROBOT, HUMAN, TABLE, CUBE],
        [ROBOT, &HUMAN.replace("1.25", "4"), TABLE, CUBE],
    ] {
        let case = Case::of(&pieces);
        for agent in ["PR2", "BOB"] {
            assert_eq!(
                case.says("canReach", &[agent, "CUBE"]),
                Some(case.holds(case.reachable("CUBE", agent)))
            );
            assert_eq!(
                case.says("canSee", &[agent, "CUBE"]),
                Some(case.holds(case.visible("CUBE", agent)))
            );
            assert_eq!(
                case.says("canReach", &[agent, "CUBE"]),
                case.says("isReachable", &["CUBE", agent])
            );
        }
    }
    let far = Case::of(&[ROBOT, &HUMAN.replace("1.25", "4"), TABLE, CUBE]);
    assert_eq!(far.says("canReach", &["BOB", "CUBE"]), Some(false));
    assert_eq!(far.says("canReach", &["PR2", "CUBE"]), Some(true));
    assert_eq!(far.says("canReach", &["CUBE", "PR2"]), None, "a cube has no hands");
    assert_eq!(far.says("canReach", &["PR2"]), None);
    assert_eq!(far.says("isUpon", &["CUBE", "TABLE"]), None);
}

/// A table 3 m ahead, out of the reach of a robot at the origin.
fn far_table() -> String {
    TABLE.replace("0.75, 0, 0.375", "3.75, 0, 0.375")
}

/// Walls 2 m high about the robot, with a gap of that width ahead.
fn room(gap: f64) -> String {
    let wall = |id: &str, sides: [f64; 2], at: [f64; 2]| {
        let ([a, b], [x, y]) = (sides, at);
        format!("[objects.{id}]\ntype = \"Object\"\nmovable = false\nbox = [{a}, {b}, 2]\nxyz = [{x}, {y}, 1]\n")
    };
    let half = (4.0 - gap) / 2.0;
    [
        wall("LEFT", [0.1, half], [1.6, gap / 2.0 + half / 2.0]),
        wall("RIGHT", [0.1, half], [1.6, -gap / 2.0 - half / 2.0]),
        wall("NORTH", [3.2, 0.1], [0.0, 2.05]),
        wall("SOUTH", [3.2, 0.1], [0.0, -2.05]),
        wall("BACK", [0.1, 4.0], [-1.65, 0.0]),
    ]
    .concat()
}

#[test]
fn a_path_goes_around_and_through_what_is_wide_enough() {
    let path = |pieces: &[&str]| Case::of(pieces).says("pathExists", &["PR2", "CUBE"]);
    let (table, narrow, wide, closed) = (far_table(), room(0.5), room(1.2), room(0.0));
    assert_eq!(path(&[ROBOT, TABLE, CUBE]), Some(true), "it is there already");
    assert_eq!(path(&[ROBOT, &table, CUBE]), Some(true), "over an empty floor");
    assert_eq!(
        path(&[ROBOT, &table, CUBE, &wide]),
        Some(true),
        "through a door of 1.2 m"
    );
    // The base is 0.67 m wide.
    assert_eq!(
        path(&[ROBOT, &table, CUBE, &narrow]),
        Some(false),
        "through a door of 0.5 m"
    );
    let closed = closed.replace("[objects.BACK]", "[objects.REAR]");
    assert_eq!(
        path(&[ROBOT, &table, CUBE, &closed]),
        Some(false),
        "out of a closed room"
    );
    // A human, whose hands are bare, goes to things and to others.
    let away = HUMAN.replace("1.25", "-3");
    let case = Case::of(&[ROBOT, &away, &table, CUBE]);
    assert_eq!(case.says("pathExists", &["BOB", "CUBE"]), Some(true));
    assert_eq!(case.says("pathExists", &["PR2", "BOB"]), Some(true));
    assert_eq!(case.says("pathExists", &["PR2", "PR2"]), None);
    // A thing far above the floor can't be reached from anywhere.
    let high = CUBE.replace("on = \"TABLE\"\nat = [-0.1, -0.2]", "xyz = [3, 0, 3]");
    assert_eq!(path(&[ROBOT, &table, &high]), Some(false));
}

#[test]
fn who_stands_fixed_goes_nowhere() {
    let model = std::fs::read_to_string("worlds/models/pr2.toml").unwrap();
    let model = model
        .replace("\"pr2.urdf\"", "\"models/pr2.urdf\"")
        .replace("base = \"planar\"", "base = \"fixed\"");
    let table = far_table();
    let case = Case::with_model(&model, &[&table, CUBE]);
    assert_eq!(case.says("pathExists", &["PR2", "CUBE"]), Some(false));
    assert_eq!(case.says("enoughRoom", &["PR2", "TABLE", "CUBE"]), Some(false));
    let case = Case::with_model(&model, &[TABLE, CUBE]);
    assert_eq!(case.says("pathExists", &["PR2", "CUBE"]), Some(true));
    assert_eq!(case.says("enoughRoom", &["PR2", "TABLE", "CUBE"]), Some(true));
}

#[test]
fn there_is_room_to_stand_or_not() {
    let room = |pieces: &[&str]| Case::of(pieces).says("enoughRoom", &["PR2", "BOB", "CUBE"]);
    // A human at the cube: the robot finds a place beside him.
    let (table, near) = (far_table(), HUMAN.replace("1.25", "4.25"));
    assert_eq!(room(&[ROBOT, &near, &table, CUBE]), Some(true));
    // He is 3 m from everything: no place is near him and has the cube at arm's length.
    let away = HUMAN.replace("1.25", "9");
    assert_eq!(room(&[ROBOT, &away, &table, CUBE]), Some(false));
    // Blocks beside him, behind him and before the table: no place is left where the base fits.
    let cage = "[objects.ONE]\ntype = \"Object\"\nmovable = false\nbox = [5, 2, 2]\nxyz = [4.3, 1.5, 1]\n\
                [objects.TWO]\ntype = \"Object\"\nmovable = false\nbox = [5, 2, 2]\nxyz = [4.3, -1.5, 1]\n\
                [objects.REAR]\ntype = \"Object\"\nmovable = false\nbox = [2, 1, 2]\nxyz = [5.6, 0, 1]\n\
                [objects.FRONT]\ntype = \"Object\"\nmovable = false\nbox = [1.5, 1, 2]\nxyz = [2.6, 0, 1]\n";
    assert_eq!(room(&[ROBOT, &near, &table, CUBE, cage]), Some(false));
}

#[test]
fn a_centimetre_decides_however_the_table_is_turned() {
    for yaw in [0.0, 0.4, 1.1] {
        let table = TABLE.replace("xyz = [0.75, 0, 0.375]", &format!("xyz = [5, 1, 0.375]\nyaw = {yaw}"));
        let fits = |gap: f64, volume: &str| {
            let side = 0.4 - gap / 2.0;
            let (a, b) = (
                block("A", [0.4, side, 0.1], [0.0, side / 2.0 - 0.4]),
                block("B", [0.4, side, 0.1], [0.0, 0.4 - side / 2.0]),
            );
            Case::of(&[&a, &b, &table, volume]).says("virtualPlace", &["VOLUME", "TABLE"])
        };
        let disc = VOLUME.replace("box = [0.2, 0.2, 0.3]", "cylinder = { radius = 0.1, length = 0.3 }");
        for volume in [VOLUME, &disc] {
            assert_eq!(
                fits(0.21, volume),
                Some(true),
                "{yaw}: a centimetre wider than {volume}"
            );
            assert_eq!(
                fits(0.19, volume),
                Some(false),
                "{yaw}: a centimetre narrower than {volume}"
            );
        }
    }
}

#[test]
fn only_what_is_at_its_height_is_in_the_way_of_a_path() {
    let (table, door) = (far_table(), room(1.2));
    let path = |z: f64| {
        let beam =
            format!("[objects.BEAM]\ntype = \"Object\"\nmovable = false\nbox = [0.1, 1.1, 0.1]\nxyz = [1.6, 0, {z}]\n");
        Case::of(&[ROBOT, &table, CUBE, &door, &beam]).says("pathExists", &["PR2", "CUBE"])
    };
    assert_eq!(path(3.0), Some(true), "above its head");
    assert_eq!(path(0.6), Some(false), "before its chest");
}

#[test]
fn there_is_no_place_near_what_the_agent_holds_itself() {
    let mut case = Case::of(&[ROBOT, TABLE, CUBE]);
    assert_eq!(case.says("enoughRoom", &["PR2", "CUBE", "TABLE"]), Some(true));
    case.give("CUBE", "PR2", 0);
    assert_eq!(case.says("enoughRoom", &["PR2", "CUBE", "TABLE"]), Some(false));
    assert_eq!(
        case.says("enoughRoom", &["PR2", "TABLE", "CUBE"]),
        Some(true),
        "it has that with it"
    );
    assert_eq!(case.says("pathExists", &["PR2", "CUBE"]), Some(true));
}

#[test]
fn answers_do_not_depend_on_what_was_asked_before() {
    let case = Case::of(&[ROBOT, HUMAN, TABLE, CUBE, VOLUME]);
    let questions: [(&str, &[&str]); 7] = [
        ("virtualPlace", &["VOLUME", "TABLE"]),
        ("canReach", &["BOB", "CUBE"]),
        ("enoughRoom", &["PR2", "BOB", "CUBE"]),
        ("pathExists", &["BOB", "CUBE"]),
        ("distance", &["PR2", "BOB"]),
        ("isNextTo", &["CUBE", "TABLE"]),
        ("isVisible", &["CUBE", "PR2"]),
    ];
    let mut grp = case.grp(0);
    let forwards: Vec<Option<Value>> = questions.iter().map(|(n, a)| case.ask(&mut grp, n, a)).collect();
    let mut other = case.grp(0);
    for ((name, args), expected) in questions.iter().zip(&forwards).rev() {
        assert_eq!(case.ask(&mut other, name, args), *expected, "{name}");
        assert_eq!(case.ask(&mut other, name, args), *expected, "{name}, asked again");
        assert_eq!(
            case.ask(&mut case.grp(1), name, args),
            *expected,
            "{name}, with another seed"
        );
    }
    // They are about the state of now: once the cube is in the hand, another answer.
    assert_eq!(case.ask(&mut grp, "isOn", &["CUBE", "TABLE"]), Some(Value::Bool(true)));
    let mark = grp.save();
    case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    assert_eq!(case.ask(&mut grp, "isOn", &["CUBE", "TABLE"]), Some(Value::Bool(false)));
    assert_eq!(
        case.ask(&mut grp, "canReach", &["PR2", "CUBE"]),
        Some(Value::Bool(false))
    );
    grp.restore(mark);
    assert_eq!(case.ask(&mut grp, "isOn", &["CUBE", "TABLE"]), Some(Value::Bool(true)));
}
