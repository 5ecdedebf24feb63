//! A robot of two joints and a hand, a table, a box, and a plan that picks the box and places it elsewhere.

use indexmap::IndexMap;
use sgap::{
    geom::{
        Pose, Vec3,
        kinematics::{Dof, Drive, Joint, JointKind, Tree},
        pose_xyz_rpy,
        shape::Shape,
    },
    plan::{Action, AttachmentChange, Changes, Geometry, Motion, Node, Plan, SubAction, Trajectory, VERSION},
    world::{Agent, AgentKind, AgentState, Arm, Body, Gripper, Object, ObjectState, Part, Scene, State},
};

const SHOULDER_HEIGHT: f64 = 0.4;
const UPPER_ARM: f64 = 0.3;
const TOOL: f64 = 0.28;

/// Indices of links.
pub const FOREARM: usize = 2;
pub const RIGHT_FINGER: usize = 4;

fn at(x: f64, y: f64, z: f64) -> Pose {
    pose_xyz_rpy([x, y, z], [0.0; 3])
}

/// Returns X_WL of every link, as our own forward kinematics has it.
pub fn link_poses(shoulder: f64, elbow: f64, finger: f64) -> Vec<Pose> {
    arm_tree().link_poses(&base_pose(), &[shoulder, elbow, finger])
}

/// Returns X_WT.
fn tool_pose(shoulder: f64, elbow: f64) -> Pose {
    link_poses(shoulder, elbow, 0.0)[FOREARM] * at(TOOL, 0.0, 0.0)
}

/// Returns X_WB: not the identity, so that a forgotten base shows.
fn base_pose() -> Pose {
    pose_xyz_rpy([0.1, -0.2, 0.0], [0.0, 0.0, 0.3])
}

/// Returns the pose of the box, standing upright where the hand holds it at this configuration.
pub fn box_pose(shoulder: f64, elbow: f64) -> Pose {
    let X_WT = tool_pose(shoulder, elbow);
    Pose::from_parts(
        X_WT.translation,
        nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, 0.3 + shoulder),
    )
}

/// Returns where the plan leaves the box: a little lower than the hand had it, so that letting go shows.
pub fn placed_box() -> Pose {
    at(0.0, 0.0, -0.002) * box_pose(0.8, 0.6)
}

fn joint(name: &str, kind: JointKind, parent: usize, X_PJ: Pose, axis: Vec3, drive: Option<(usize, f64)>) -> Joint {
    let drive = drive.map(|(dof, scale)| Drive {
        dof,
        scale,
        offset: 0.0,
    });
    Joint {
        name: name.into(),
        kind,
        parent,
        X_PJ,
        axis,
        drive,
    }
}

fn arm_tree() -> Tree {
    let dof = |name: &str, lower: f64, upper: f64| Dof {
        name: name.into(),
        lower,
        upper,
        max_velocity: 1.0,
        max_acceleration: 1.0,
        max_jerk: 10.0,
    };
    Tree {
        links: ["base", "upper_arm", "forearm", "left_finger", "right_finger"]
            .map(String::from)
            .into(),
        joints: vec![
            joint(
                "shoulder",
                JointKind::Revolute,
                0,
                at(0.0, 0.0, SHOULDER_HEIGHT),
                Vec3::z(),
                Some((0, 1.0)),
            ),
            joint(
                "elbow",
                JointKind::Revolute,
                1,
                at(UPPER_ARM, 0.0, 0.0),
                Vec3::y(),
                Some((1, 1.0)),
            ),
            joint(
                "finger",
                JointKind::Prismatic,
                2,
                at(TOOL, 0.0, 0.0),
                Vec3::y(),
                Some((2, 1.0)),
            ),
            // Mirrors the other finger.
            joint(
                "mirror",
                JointKind::Prismatic,
                2,
                at(TOOL, 0.0, 0.0),
                Vec3::y(),
                Some((2, -1.0)),
            ),
        ],
        dofs: vec![
            dof("shoulder", -3.0, 3.0),
            dof("elbow", -2.0, 2.0),
            dof("finger", 0.0, 0.04),
        ],
    }
}

fn arm() -> Agent {
    let body = |link: usize, half: [f64; 3], X_LS: Pose, color: [f32; 4]| Body {
        link,
        shape: Shape::Box { half: half.into() },
        X_LS,
        color,
    };
    let (grey, white, dark) = ([0.35, 0.37, 0.4, 1.0], [0.9, 0.9, 0.88, 1.0], [0.2, 0.2, 0.22, 1.0]);
    let finger = |link: usize, side: f64| body(link, [0.03, 0.005, 0.012], at(0.0, 0.005 * side, 0.0), dark);
    let post = Body {
        link: 0,
        shape: Shape::Cylinder {
            radius: 0.06,
            half_length: 0.19,
        },
        X_LS: at(0.0, 0.0, 0.19),
        color: grey,
    };
    let elbow = Body {
        link: 2,
        shape: Shape::Capsule {
            radius: 0.035,
            half_length: 0.03,
        },
        X_LS: pose_xyz_rpy([0.0; 3], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]),
        color: grey,
    };
    Agent {
        id: "ARM".into(),
        kind: AgentKind::Robot,
        ty: None,
        tree: arm_tree(),
        bodies: vec![
            post,
            body(1, [0.15, 0.03, 0.02], at(0.13, 0.0, 0.0), white),
            elbow,
            body(2, [0.1, 0.025, 0.02], at(0.12, 0.0, 0.0), white),
            body(2, [0.012, 0.055, 0.015], at(0.235, 0.0, 0.0), grey),
            finger(3, 1.0),
            finger(4, -1.0),
        ],
        may_touch: Default::default(),
        arms: vec![Arm {
            name: "only".into(),
            base_link: 0,
            tip_link: 2,
            X_LT: at(TOOL, 0.0, 0.0),
            dofs: vec![0, 1],
            gripper: Some(Gripper {
                dofs: vec![2],
                open: vec![0.04],
                closed: vec![0.0],
                gap_open: 0.08,
                gap_closed: 0.0,
            }),
            hand_links: vec![2, 3, 4],
        }],
        camera: None,
        postures: IndexMap::new(),
        manner: Default::default(),
        base: sgap::world::BaseKind::Fixed,
        base_limits: Default::default(),
    }
}

fn object(id: &str, half: [f64; 3], movable: bool, color: [f32; 4]) -> Object {
    let shape = Shape::Box { half: half.into() };
    Object {
        id: id.into(),
        ty: None,
        parts: vec![Part {
            shape,
            X_OS: Pose::identity(),
        }],
        movable,
        supports: vec![],
        stable: vec![],
        grasps: vec![],
        containers: vec![],
        mass: 0.1,
        color,
    }
}

/// Returns the scene and its start: the box stands where the hand is at (0, 0.6).
pub fn small_world() -> (Scene, State) {
    let box_at_start = box_pose(0.0, 0.6);
    let mut scene = Scene::default();
    scene.agents.push(arm());
    scene
        .objects
        .push(object("TABLE", [0.3, 0.4, 0.1], false, [0.72, 0.55, 0.38, 1.0]));
    scene
        .objects
        .push(object("BOX", [0.02, 0.02, 0.02], true, [0.85, 0.15, 0.12, 1.0]));
    let stands = |X_WO: Pose| ObjectState { X_WO, held: None };
    let table_z = box_at_start.translation.z - 0.02 - 0.1;
    let state = State {
        agents: vec![AgentState {
            X_WB: base_pose(),
            q: vec![0.0, 0.0, 0.04],
        }],
        objects: vec![stands(base_pose() * at(0.55, 0.25, table_z)), stands(box_at_start)],
    };
    (scene, state)
}

fn sub_action(name: &str, joints: &[&str], times: &[f64], positions: &[&[f64]]) -> SubAction {
    SubAction {
        name: name.into(),
        motion: Motion::Free,
        trajectory: Trajectory {
            joints: joints.iter().map(|j| (*j).into()).collect(),
            times: times.into(),
            positions: positions.iter().map(|row| row.to_vec()).collect(),
        },
        change: None,
    }
}

fn action(index: usize, name: &str, arguments: &[&str], start: f64, sub_actions: Vec<SubAction>) -> Action {
    let duration: f64 = sub_actions.iter().map(|s| s.trajectory.duration()).sum();
    Action {
        index,
        name: name.into(),
        arguments: arguments.iter().map(|a| (*a).into()).collect(),
        agents: vec!["ARM".into()],
        cost: 1.0,
        duration: [duration, duration],
        start,
        end: start + duration,
        geometry: Some(Box::new(Geometry {
            action: name.to_lowercase(),
            gas: index as u32,
            alternative: 0,
            agent: "ARM".into(),
            arm: "only".into(),
            object: "BOX".into(),
            grasp: "side".into(),
            stand: None,
            placement: None,
            cost_parts: IndexMap::new(),
            sub_actions,
        })),
        changes: Changes::default(),
    }
}

/// Returns a plan of two actions: the box is taken at 1.5 s, and let go of, turned by 0.8 rad about the arm, at 4 s.
pub fn pick_and_place() -> Plan {
    let arm = ["shoulder", "elbow"];
    let mut grasp = sub_action("grasp", &["finger"], &[0.0, 0.5], &[&[0.04], &[0.02]]);
    grasp.change = Some(AttachmentChange::Attach {
        object: "BOX".into(),
        object_in_tool: (tool_pose(0.0, 0.6).inverse() * box_pose(0.0, 0.6)).into(),
    });
    let pick = vec![
        sub_action("approach", &arm, &[0.0, 1.0], &[&[0.0, 0.0], &[0.0, 0.6]]),
        grasp,
    ];

    let carry = sub_action(
        "approach",
        &arm,
        &[0.0, 0.5, 1.0, 1.5],
        &[&[0.0, 0.6], &[0.2, 0.3], &[0.6, 0.3], &[0.8, 0.6]],
    );
    // A change comes when its own sub-action is over; the fingers then open in the next.
    let mut place = sub_action("place", &arm, &[0.0], &[&[0.8, 0.6]]);
    place.change = Some(AttachmentChange::Detach {
        object: "BOX".into(),
        object_in_world: placed_box().into(),
    });
    let release = sub_action("release", &["finger"], &[0.0, 0.5], &[&[0.02], &[0.04]]);
    let actions = vec![
        action(0, "Pick", &["ARM", "BOX"], 0.0, pick),
        action(1, "Place", &["ARM", "BOX", "TABLE"], 2.5, vec![carry, place, release]),
    ];
    let node = |task: &str, parent: Option<usize>, action: Option<usize>| Node {
        task: task.into(),
        arguments: vec!["ARM".into(), "BOX".into()],
        parent,
        decomposition: parent.is_none().then_some(0),
        action,
    };
    Plan {
        format: "sgap-plan".into(),
        version: VERSION,
        task: "Move(ARM, BOX)".into(),
        seed: 1,
        cost: 2.0,
        cost_parts: vec![],
        makespan: 4.5,
        interleaved: false,
        actions,
        streams: IndexMap::from([("ARM".into(), vec![0, 1])]),
        links: vec![],
        decomposition: vec![
            node("Move", None, None),
            node("Pick", Some(0), Some(0)),
            node("Place", Some(0), Some(1)),
        ],
    }
}
