//! Facts at their edges.

use sgap::engine::Reasoner;
use sgap::geom::{Pose, Vec3, pose_xyz_rpy};

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// Height of the cube's centre when it stands on [`TABLE`] [m].
const ON_TABLE: f64 = 0.75 + 0.03;

#[test]
fn an_object_is_on_what_its_bottom_lies_on() {
    let mut case = Case::of(&[TABLE, CUBE]);
    let turned = |x: f64, yaw: f64| pose_xyz_rpy([x, 0.0, ON_TABLE], [0.0, 0.0, yaw]);
    let tilted = |roll: f64| pose_xyz_rpy([0.75, 0.0, ON_TABLE], [roll, 0.0, 0.0]);
    let quarter = std::f64::consts::FRAC_PI_2;
    // The face ends at 0.75 + 0.2 m; half of the cube is 0.03 m, half of its diagonal 0.0424 m.
    for (X_WO, expected, why) in [
        (turned(0.75, 0.3), true, "in the middle"),
        (turned(0.92, 0.0), true, "flush with the edge"),
        (turned(0.9205, 0.0), true, "within the tolerance of an overhang"),
        (turned(0.922, 0.0), false, "beyond it"),
        (turned(0.58, 0.0), true, "flush with the other edge"),
        (turned(0.578, 0.0), false, "beyond that one"),
        (turned(0.92, quarter / 2.0), false, "a corner sticks out"),
        (turned(0.907, quarter / 2.0), true, "no corner sticks out"),
        (at(0.75, 0.0, ON_TABLE + 0.0045), true, "a small gap"),
        (at(0.75, 0.0, ON_TABLE + 0.0055), false, "in the air"),
        (at(0.75, 0.0, ON_TABLE - 0.0045), true, "a small overlap"),
        (at(0.75, 0.0, ON_TABLE - 0.0055), false, "sunk in"),
        (at(0.75, 0.0, 0.03), false, "on the floor below"),
        (tilted(0.01), true, "level but for a hair"),
        (tilted(0.1), false, "leaning"),
        (tilted(quarter), true, "on its side"),
        (tilted(2.0 * quarter), true, "upside down"),
    ] {
        *case.X_WO("CUBE") = X_WO;
        assert_eq!(case.holds(case.on("CUBE", "TABLE")), expected, "{why}");
        assert!(!case.holds(case.on("TABLE", "CUBE")), "{why}");
        assert!(!case.holds(case.on("CUBE", "CUBE")), "{why}");
    }
}

#[test]
fn an_object_is_on_the_one_directly_below_it() {
    let slab = "[objects.SLAB]\ntype = \"Support\"\nbox = [0.2, 0.2, 0.05]\non = \"TABLE\"\n";
    let cube = "[objects.CUBE]\ntype = \"Object\"\nbox = [0.06, 0.06, 0.06]\non = \"SLAB\"\n";
    let mut case = Case::of(&[TABLE, slab, cube]);
    assert!(case.holds(case.on("CUBE", "SLAB")));
    assert!(case.holds(case.on("SLAB", "TABLE")));
    assert!(!case.holds(case.on("CUBE", "TABLE")));
    // Lying on its side, the slab keeps its only face, which is no longer level (docs/worlds.md).
    *case.X_WO("SLAB") = pose_xyz_rpy([0.75, 0.0, 0.75 + 0.1], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
    *case.X_WO("CUBE") = at(0.75, 0.0, 0.75 + 0.2 + 0.03);
    assert!(case.holds(case.on("SLAB", "TABLE")));
    assert!(!case.holds(case.on("CUBE", "SLAB")));
}

#[test]
fn a_ball_and_a_held_object_stand_on_nothing() {
    let ball = "[objects.BALL]\ntype = \"Object\"\nsphere = { radius = 0.03 }\nxyz = [0.75, 0, 0.78]\n";
    let mut case = Case::of(&[ROBOT, TABLE, CUBE, ball]);
    assert!(!case.holds(case.on("BALL", "TABLE")), "it would roll");
    assert!(case.holds(case.on("CUBE", "TABLE")));
    assert!(!case.holds(case.in_hand("PR2", "CUBE")));
    case.give("CUBE", "PR2", 0);
    assert!(!case.holds(case.on("CUBE", "TABLE")));
    assert!(case.holds(case.in_hand("PR2", "CUBE")));
}

#[test]
fn picking_changes_what_is_in_the_hand() {
    let case = Case::of(&[ROBOT, HUMAN, TABLE, CUBE]);
    let mut grp = case.grp(0);
    assert_eq!(case.attribute(&mut grp, "PR2", "hasInHand"), "NULL");
    assert_eq!(case.attribute(&mut grp, "CUBE", "isOn"), "TABLE");
    case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    assert_eq!(case.attribute(&mut grp, "PR2", "hasInHand"), "CUBE");
    assert_eq!(case.attribute(&mut grp, "BOB", "hasInHand"), "NULL");
    assert_eq!(case.attribute(&mut grp, "CUBE", "isOn"), "NULL");
    // Who holds it can't take it.
    assert!(!grp.holds(case.reachable("CUBE", "PR2")));
}

#[test]
fn eyes_see_what_nothing_hides() {
    let wall = "[objects.WALL]\ntype = \"Object\"\nmovable = false\nbox = [0.02, 3, 3]\nxyz = [1.5, 0, 1.5]\n";
    let cube = |x: f64, z: f64| {
        let xyz = format!("xyz = [{x}, 0, {z}]\n");
        "[objects.CUBE]\ntype = \"Object\"\nbox = [0.1, 0.1, 0.1]\n".to_owned() + &xyz
    };
    let seen = |pieces: &[&str]| {
        let case = Case::of(pieces);
        case.holds(case.visible("CUBE", "PR2"))
    };
    assert!(seen(&[ROBOT, &cube(2.0, 0.5)]), "nothing in between");
    assert!(!seen(&[ROBOT, &cube(2.0, 0.5), wall]), "behind a wall");
    assert!(seen(&[ROBOT, &cube(1.2, 0.5), wall]), "before the wall");
    // The camera looks 0.6 rad down and its field is 1.29 rad high: its upper edge is 0.045 rad above the horizon.
    assert!(!seen(&[ROBOT, &cube(-2.0, 0.5)]), "behind its back");
    assert!(!seen(&[ROBOT, &cube(2.0, 2.5)]), "above its field of view");
    // It sees 6 m far.
    assert!(seen(&[ROBOT, &cube(5.0, 0.5)]), "within its range");
    assert!(!seen(&[ROBOT, &cube(7.0, 0.5)]), "beyond its range");
}

#[test]
fn furniture_is_seen_too_and_by_each_from_where_it_stands() {
    let case = Case::of(&[ROBOT, HUMAN, TABLE, CUBE]);
    assert!(case.holds(case.visible("TABLE", "PR2")));
    assert!(case.holds(case.visible("CUBE", "BOB")));
    let away = HUMAN.replace("3.141592653589793", "0");
    let case = Case::of(&[ROBOT, &away, TABLE, CUBE]);
    assert!(!case.holds(case.visible("CUBE", "BOB")), "he looks the other way");
}

#[test]
fn hands_reach_what_is_near_and_free() {
    let reached = |agent: &str, pieces: &[&str]| {
        let case = Case::of(pieces);
        case.holds(case.reachable("CUBE", agent))
    };
    // Between the robot's hands and the table, the whole width of the table and higher than the arms.
    let wall = "[objects.WALL]\ntype = \"Object\"\nmovable = false\nbox = [0.02, 3, 2.5]\nxyz = [0.53, 0, 1.25]\n";
    let human_wall = wall.replace("0.53", "0.97");
    assert!(reached("PR2", &[ROBOT, TABLE, CUBE]));
    assert!(!reached("PR2", &[ROBOT, TABLE, CUBE, wall]), "behind a wall");
    let far_table = TABLE.replace("xyz = [0.75", "xyz = [1.75");
    assert!(!reached("PR2", &[ROBOT, &far_table, CUBE]), "far away");
    assert!(reached("BOB", &[HUMAN, TABLE, CUBE]), "with a bare hand");
    assert!(!reached("BOB", &[HUMAN, TABLE, CUBE, &human_wall]), "behind a wall");
    let far_table = TABLE.replace("xyz = [0.75", "xyz = [-0.75");
    assert!(!reached("BOB", &[HUMAN, &far_table, CUBE]), "far away");
}

#[test]
fn a_full_hand_takes_nothing() {
    let others = "[objects.A]\ntype = \"Object\"\nbox = [0.04, 0.04, 0.04]\nxyz = [0, 5, 1]\n\
                  [objects.B]\ntype = \"Object\"\nbox = [0.04, 0.04, 0.04]\nxyz = [0, 6, 1]\n";
    // On the middle line, on the agent's own side of the table.
    for (agent, x) in [("PR2", "-0.1"), ("BOB", "0.1")] {
        let middle = CUBE.replace("[-0.1, -0.2]", &format!("[{x}, 0]"));
        let agent_alone = if agent == "PR2" { ROBOT } else { HUMAN };
        let mut case = Case::of(&[agent_alone, TABLE, &middle, others]);
        assert!(case.holds(case.reachable("CUBE", agent)), "{agent}");
        case.give("A", agent, 0);
        assert!(case.holds(case.reachable("CUBE", agent)), "{agent} has another hand");
        case.give("B", agent, 1);
        assert!(!case.holds(case.reachable("CUBE", agent)), "{agent} has no free hand");
    }
}

#[test]
fn answers_do_not_depend_on_what_was_asked_before() {
    for world in ["worlds/three_objects.toml", "worlds/ramification.toml"] {
        let case = Case::shipped(world);
        let mut grp = case.grp(0);
        let all = grp.all_facts();
        assert!(all.iter().any(|f| f.3) && all.iter().any(|f| !f.3));
        assert_eq!(grp.all_facts(), all, "asked again");
        let (n_agents, n_objects) = (case.world.scene.agents.len(), case.world.scene.objects.len());
        let mut backwards = case.grp(0);
        let mut checked = 0;
        for agent in (0..n_agents).rev() {
            for object in (0..n_objects).rev().filter(|o| case.world.scene.objects[*o].movable) {
                use sgap::grp::Fact::{IsReachable, IsVisible};
                for fact in [IsVisible { object, agent }, IsReachable { object, agent }] {
                    let expected = grp.holds(fact);
                    assert_eq!(backwards.holds(fact), expected, "{fact:?} asked in another order");
                    assert_eq!(case.grp(0).holds(fact), expected, "{fact:?} asked alone");
                    checked += 1;
                }
            }
        }
        assert_eq!(checked, 2 * 2 * 3);
    }
}

#[test]
fn facts_do_not_depend_on_where_the_world_is() {
    let case = Case::shipped("worlds/three_objects.toml");
    let all = case.grp(0).all_facts();
    for (x, y, yaw) in [(3.0, -2.0, 0.7), (-11.0, 4.0, 2.9)] {
        let X_VW = Pose::new(Vec3::new(x, y, 0.0), Vec3::z() * yaw);
        let mut moved = Case::shipped("worlds/three_objects.toml");
        for agent in &mut moved.world.start.agents {
            agent.X_WB = X_VW * agent.X_WB;
        }
        for object in &mut moved.world.start.objects {
            object.X_WO = X_VW * object.X_WO;
        }
        assert_eq!(moved.grp(0).all_facts(), all);
    }
}

#[test]
fn facts_answer_for_entities_of_the_world_only() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let grp = case.grp(0);
    let cube = case.domain.entity("CUBE").unwrap();
    for fact in sgap::grp::FACTS {
        assert!(grp.knows(&case.domain, fact, cube));
    }
    assert!(!grp.knows(&case.domain, "isHappy", cube));
}

#[test]
fn an_agent_reaches_what_one_of_its_hands_reaches() {
    let thing = "[objects.A]\ntype = \"Object\"\nbox = [0.04, 0.04, 0.04]\nxyz = [0, 5, 1]\n";
    let (mut reached, mut missed) = (0, 0);
    for (agent, alone) in [("PR2", ROBOT), ("BOB", HUMAN)] {
        for place in 0..60 {
            let (x, y) = (
                0.037 * f64::from(place % 10) - 0.167,
                0.13 * f64::from(place / 10) - 0.33,
            );
            let cube = CUBE.replace("[-0.1, -0.2]", &format!("[{x}, {y}]"));
            let with_full = |arm: Option<usize>| {
                let mut case = Case::of(&[alone, TABLE, &cube, thing]);
                if let Some(arm) = arm {
                    case.give("A", agent, arm);
                }
                case.holds(case.reachable("CUBE", agent))
            };
            let either = with_full(Some(0)) || with_full(Some(1));
            assert_eq!(with_full(None), either, "{agent} and a cube at {x}, {y}");
            *(if either { &mut reached } else { &mut missed }) += 1;
        }
    }
    assert!(reached > 20 && missed > 20, "{reached} reached, {missed} not");
}
