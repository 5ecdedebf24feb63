//! What a plan document says of a projection: sub-actions, their order, their ends, what changes hands, cost and duration.

use std::collections::BTreeMap;

use sgap::engine::Projection;
use sgap::geom::Pose;
use sgap::grp::{APPROACH, Grp};
use sgap::plan::{AttachmentChange, Geometry, Motion};

use crate::case::{CUBE, Case, HUMAN, ROBOT, TABLE};

/// Formulas 3.3, 3.4 and 3.8.
const PICK: [(&str, Motion); 4] = [
    ("approach", Motion::Free),
    ("engage", Motion::Straight),
    ("grasp", Motion::Gripper),
    ("disengage", Motion::Straight),
];
const PLACE: [(&str, Motion); 4] = [
    ("approach", Motion::Free),
    ("place", Motion::Straight),
    ("release", Motion::Gripper),
    ("retract", Motion::Straight),
];

/// Inverse kinematics stops this near [m], [rad]; twice that, because both the end and its reference have it.
const SAME_PLACE: f64 = 2e-4;
const SAME_ANGLE: f64 = 4e-4;

fn assert_same(a: &Pose, b: &Pose, what: &str) {
    let off = a.inverse() * b;
    assert!(off.translation.vector.norm() < SAME_PLACE, "{what}: {off}");
    assert!(off.rotation.angle() < SAME_ANGLE, "{what}: {off}");
}

fn names(geometry: &Geometry) -> Vec<(&str, Motion)> {
    geometry
        .sub_actions
        .iter()
        .map(|s| (s.name.as_str(), s.motion))
        .collect()
}

/// Follows a document's trajectories from `q`, by joint name, and returns X_WT at the end of each sub-action.
fn follow(case: &Case, geometry: &Geometry, q: &mut [f64]) -> BTreeMap<String, Pose> {
    let agent = case.agent(&geometry.agent);
    let body = &case.world.scene.agents[agent];
    let arm = body.arms.iter().position(|a| a.name == geometry.arm).unwrap();
    let mut tools = BTreeMap::new();
    for sub in &geometry.sub_actions {
        let t = &sub.trajectory;
        assert_eq!(t.times.len(), t.positions.len());
        assert_eq!(t.times[0], 0.0);
        assert!(t.times.windows(2).all(|w| w[0] < w[1]), "{}: {:?}", sub.name, t.times);
        let dofs: Vec<usize> = t
            .joints
            .iter()
            .map(|name| body.tree.dofs.iter().position(|d| d.name == *name).unwrap())
            .collect();
        let expected = match sub.motion {
            Motion::Gripper => &body.arms[arm].gripper.as_ref().unwrap().dofs,
            Motion::Free | Motion::Straight => &body.arms[arm].dofs,
            Motion::Posture | Motion::Base => panic!("an arm's action: {}", sub.name),
        };
        assert_eq!(&dofs, expected, "{}", sub.name);
        let now: Vec<f64> = dofs.iter().map(|d| q[*d]).collect();
        assert_eq!(t.positions[0], now, "{} starts where the one before ends", sub.name);
        for (dof, value) in dofs.iter().zip(t.positions.last().unwrap()) {
            q[*dof] = *value;
        }
        tools.insert(sub.name.clone(), case.tool(agent, arm, q));
    }
    tools
}

/// Checks what every document owes to its projection.
fn check_sums(grp: &Grp<'_>, projection: &Projection) {
    let geometry = grp.geometry(projection.gas).unwrap();
    assert_eq!(geometry.gas, projection.gas.gas.0);
    assert_eq!(geometry.alternative, projection.gas.alternative);
    let cost: f64 = geometry.cost_parts.values().sum();
    assert!(cost > 0.0 && (cost - projection.cost).abs() < 1e-12);
    assert!(geometry.cost_parts.values().all(|c| *c >= 0.0));
    let duration: f64 = geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
    assert!(duration > 0.0 && (duration - projection.duration).abs() < 1e-9);
}

#[test]
fn pick_and_place_are_the_formulas() {
    for world in ["worlds/three_objects.toml", "worlds/ramification.toml"] {
        let case = Case::shipped(world);
        let mut grp = case.grp(0);
        let pick = case.project(&mut grp, "pick", &["PR2", "RED_CUBE"]).unwrap();
        let put = case
            .project(&mut grp, "placeReachable", &["PR2", "RED_CUBE", "TABLE", "BOB"])
            .unwrap();
        check_sums(&grp, &pick);
        check_sums(&grp, &put);
        let (pick, put) = (grp.geometry(pick.gas).unwrap(), grp.geometry(put.gas).unwrap());
        assert_eq!((pick.action.as_str(), put.action.as_str()), ("pick", "placeReachable"));
        assert_eq!(names(&pick), PICK);
        assert_eq!(names(&put), PLACE);
        assert_eq!(pick.arm, put.arm);
        assert_eq!(pick.grasp, put.grasp, "it is put down as it is held");
        assert!(pick.placement.is_none());

        // Where each sub-action ends.
        let object = case.object("RED_CUBE");
        let X_WO = case.world.start.objects[object].X_WO;
        let grasps = &case.world.scene.objects[object].grasps;
        let X_OT = grasps.iter().find(|g| g.name == pick.grasp).unwrap().X_OT;
        let (back, up) = (
            Pose::translation(-APPROACH, 0.0, 0.0),
            Pose::translation(0.0, 0.0, APPROACH),
        );
        let mut q = case.world.start.agents[case.agent("PR2")].q.clone();
        let tools = follow(&case, &pick, &mut q);
        assert_same(&tools["approach"], &(X_WO * X_OT * back), "approach");
        assert_same(&tools["engage"], &(X_WO * X_OT), "engage");
        assert_eq!(tools["grasp"], tools["engage"]);
        assert_same(&tools["disengage"], &(up * X_WO * X_OT), "disengage");
        let tools = follow(&case, &put, &mut q);
        let placement = put.placement.as_ref().unwrap();
        let X_WO = placement.pose.pose();
        assert_same(&tools["approach"], &(up * X_WO * X_OT), "approach of the placement");
        assert_same(&tools["place"], &(X_WO * X_OT), "place");
        assert_eq!(tools["release"], tools["place"]);
        assert_same(&tools["retract"], &(X_WO * X_OT * back), "retract");

        assert_eq!((placement.on.as_str(), placement.support.as_str()), ("TABLE", "top"));
        assert!(grp.holds(case.on("RED_CUBE", "TABLE")));
        assert!(
            grp.holds(case.reachable("RED_CUBE", "BOB")),
            "that is what the action promises"
        );
    }
}

#[test]
fn an_object_changes_hands_once() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = case.grp(0);
    let pick = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let place = case.project(&mut grp, "place", &["PR2", "CUBE", "TABLE"]).unwrap();
    let (pick, place) = (grp.geometry(pick.gas).unwrap(), grp.geometry(place.gas).unwrap());
    for (geometry, at) in [(&pick, "grasp"), (&place, "release")] {
        for sub in &geometry.sub_actions {
            assert_eq!(sub.change.is_some(), sub.name == at, "{}", sub.name);
        }
    }
    let mut q = case.world.start.agents[0].q.clone();
    let tools = follow(&case, &pick, &mut q);
    let Some(AttachmentChange::Attach { object, object_in_tool }) = &pick.sub_actions[2].change else {
        panic!("{:?}", pick.sub_actions[2].change)
    };
    assert_eq!(object, "CUBE");
    // It is held as it lay: taking it does not move it.
    let X_WO = case.world.start.objects[case.object("CUBE")].X_WO;
    let off = (tools["grasp"] * object_in_tool.pose()).inverse() * X_WO;
    assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle() < 1e-7);
    let Some(AttachmentChange::Detach {
        object,
        object_in_world,
    }) = &place.sub_actions[2].change
    else {
        panic!("{:?}", place.sub_actions[2].change)
    };
    assert_eq!(object, "CUBE");
    assert_eq!(*object_in_world, place.placement.as_ref().unwrap().pose);
}

#[test]
fn closed_fingers_open_first() {
    let case = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = case.grp(0);
    let pick = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    assert_eq!(names(&grp.geometry(pick.gas).unwrap()), PICK, "they are open in `rest`");

    let closed = ROBOT.to_owned() + "joints = { l_gripper_l_finger_joint = 0, r_gripper_l_finger_joint = 0 }\n";
    let case = Case::of(&[&closed, TABLE, CUBE]);
    let mut grp = case.grp(0);
    let pick = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    check_sums(&grp, &pick);
    let geometry = grp.geometry(pick.gas).unwrap();
    assert_eq!(names(&geometry)[0], ("open", Motion::Gripper));
    assert_eq!(names(&geometry)[1..], PICK);
    let mut q = case.world.start.agents[0].q.clone();
    follow(&case, &geometry, &mut q);
    // The model's open fingers are 0.086 m apart, each 0.043 m from the middle.
    let open = &geometry.sub_actions[0].trajectory;
    assert_eq!((open.positions[0][0], open.positions.last().unwrap()[0]), (0.0, 0.043));
    let grasp = &geometry.sub_actions[3].trajectory.positions;
    assert_eq!(grasp[0][0], 0.043);
    assert!(
        (grasp.last().unwrap()[0] - 0.03).abs() < 1e-12,
        "the cube is 0.06 m wide"
    );
}

#[test]
fn nearness_to_a_human_costs() {
    let alone = Case::of(&[ROBOT, TABLE, CUBE]);
    let mut grp = alone.grp(0);
    let pick = alone.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
    let parts = grp.geometry(pick.gas).unwrap().cost_parts;
    assert_eq!(parts.keys().collect::<Vec<_>>(), ["length"]);
    let watched = |x: f64| {
        let human = HUMAN.replace("1.25", &x.to_string());
        let case = Case::of(&[ROBOT, &human, TABLE, CUBE]);
        let mut grp = case.grp(0);
        let pick = case.project(&mut grp, "pick", &["PR2", "CUBE"]).unwrap();
        check_sums(&grp, &pick);
        grp.geometry(pick.gas).unwrap().cost_parts["proximity"]
    };
    let (near, far) = (watched(1.25), watched(4.0));
    assert!(near > far && far > 0.0, "{near} near, {far} far");
}
