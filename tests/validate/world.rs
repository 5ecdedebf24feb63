//! A gantry with a gripper, a human with a sliding arm, a table, two cubes: everything can be computed by hand.

use std::collections::BTreeSet;

use indexmap::IndexMap;
use sgap::geom::kinematics::{Dof, Drive, Joint, JointKind, Tree};
use sgap::geom::shape::Shape;
use sgap::geom::{Pose, Vec3, pose_xyz_rpy};
use sgap::world::*;

/// Height of the gantry's base frame, of the table's top, and half of a cube's side [m].
pub const BASE: f64 = 1.5;
pub const TOP: f64 = 0.5;
pub const HALF: f64 = 0.03;
/// From the wrist down to the tool [m].
pub const TOOL: f64 = 0.1;

/// Places of the cubes at the start.
pub const RED: [f64; 2] = [-0.3, 0.0];
pub const BLUE: [f64; 2] = [0.3, 0.0];

/// Gantry joints at the start: x, y, z, yaw, finger.
pub const HOME: [f64; 5] = [0.0, 0.0, -0.4, 0.0, 0.05];

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

fn joint(name: &str, kind: JointKind, parent: usize, x_pj: Pose, axis: Vec3, dof: usize, scale: f64) -> Joint {
    Joint {
        name: name.into(),
        kind,
        parent,
        X_PJ: x_pj,
        axis,
        drive: Some(Drive {
            dof,
            scale,
            offset: 0.0,
        }),
    }
}

fn dof(name: &str, lower: f64, upper: f64, max_velocity: f64, max_acceleration: f64) -> Dof {
    Dof {
        name: name.into(),
        lower,
        upper,
        max_velocity,
        max_acceleration,
        max_jerk: 100.0 * max_acceleration,
    }
}

fn boxed(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box {
        half: Vec3::new(x, y, z),
    }
}

fn body(link: usize, shape: Shape, x_ls: Pose) -> Body {
    Body {
        link,
        shape,
        X_LS: x_ls,
        color: [0.5, 0.5, 0.5, 1.0],
    }
}

/// Tool frame: x down, y along the fingers.
pub fn down() -> Pose {
    pose_xyz_rpy([0.0; 3], [0.0, std::f64::consts::FRAC_PI_2, 0.0])
}

fn gantry() -> Agent {
    use JointKind::{Prismatic, Revolute};
    let links = [
        "base",
        "x_link",
        "y_link",
        "mast",
        "wrist",
        "finger_left",
        "finger_right",
    ];
    let finger = 0.005;
    Agent {
        id: "GANTRY".into(),
        kind: AgentKind::Robot,
        ty: None,
        tree: Tree {
            links: links.map(String::from).to_vec(),
            joints: vec![
                joint("x", Prismatic, 0, Pose::identity(), Vec3::x(), 0, 1.0),
                joint("y", Prismatic, 1, Pose::identity(), Vec3::y(), 1, 1.0),
                joint("z", Prismatic, 2, Pose::identity(), Vec3::z(), 2, 1.0),
                joint("yaw", Revolute, 3, Pose::identity(), Vec3::z(), 3, 1.0),
                joint("finger", Prismatic, 4, at(0.0, finger, -0.08), Vec3::y(), 4, 1.0),
                joint(
                    "finger_mimic",
                    Prismatic,
                    4,
                    at(0.0, -finger, -0.08),
                    Vec3::y(),
                    4,
                    -1.0,
                ),
            ],
            dofs: vec![
                dof("x", -0.7, 0.7, 1.0, 4.0),
                dof("y", -0.5, 0.5, 1.0, 4.0),
                dof("z", -1.0, 0.0, 1.0, 4.0),
                dof("yaw", -3.0, 3.0, 2.0, 8.0),
                dof("finger", 0.0, 0.05, 0.2, 2.0),
            ],
        },
        bodies: vec![
            body(3, boxed(0.02, 0.02, 0.2), at(0.0, 0.0, 0.2)),
            body(4, boxed(0.05, 0.05, 0.02), at(0.0, 0.0, -0.02)),
            body(5, boxed(0.01, finger, 0.03), Pose::identity()),
            body(6, boxed(0.01, finger, 0.03), Pose::identity()),
        ],
        may_touch: BTreeSet::from([(3, 4), (4, 5), (4, 6)]),
        arms: vec![Arm {
            name: "main".into(),
            base_link: 0,
            tip_link: 4,
            X_LT: at(0.0, 0.0, -TOOL) * down(),
            dofs: vec![0, 1, 2, 3],
            gripper: Some(Gripper {
                dofs: vec![4],
                open: vec![0.05],
                closed: vec![0.0],
                gap_open: 0.1,
                gap_closed: 0.0,
            }),
            hand_links: vec![4, 5, 6],
        }],
        camera: None,
        postures: IndexMap::new(),
        base: sgap::world::BaseKind::Fixed,
        base_limits: Default::default(),
        manner: Default::default(),
    }
}

/// Stands behind the table; its hand slides, to the right half of the table only.
fn human() -> Agent {
    use JointKind::Prismatic;
    Agent {
        id: "HUMAN".into(),
        kind: AgentKind::Human,
        ty: None,
        tree: Tree {
            links: ["trunk", "shoulder", "elbow", "palm"].map(String::from).to_vec(),
            joints: vec![
                joint("hx", Prismatic, 0, Pose::identity(), Vec3::x(), 0, 1.0),
                joint("hy", Prismatic, 1, Pose::identity(), Vec3::y(), 1, 1.0),
                joint("hz", Prismatic, 2, Pose::identity(), Vec3::z(), 2, 1.0),
            ],
            dofs: vec![
                dof("hx", -0.1, 0.5, 1.0, 4.0),
                dof("hy", -0.95, 0.0, 1.0, 4.0),
                dof("hz", -0.03, 0.3, 1.0, 4.0),
            ],
        },
        bodies: vec![body(3, Shape::Sphere { radius: 0.02 }, Pose::identity())],
        may_touch: BTreeSet::new(),
        arms: vec![Arm {
            name: "right".into(),
            base_link: 0,
            tip_link: 3,
            X_LT: Pose::identity(),
            dofs: vec![0, 1, 2],
            gripper: None,
            hand_links: vec![3],
        }],
        camera: Some(Camera {
            link: 0,
            X_LC: pose_xyz_rpy([0.0, 0.0, 0.5], [0.0, 0.5, -std::f64::consts::FRAC_PI_2]),
            horizontal: 2.0,
            vertical: 1.5,
            range: 3.0,
        }),
        postures: IndexMap::new(),
        base: sgap::world::BaseKind::Fixed,
        base_limits: Default::default(),
        manner: Default::default(),
    }
}

fn cube(id: &str) -> Object {
    Object {
        id: id.into(),
        ty: None,
        parts: vec![Part {
            shape: boxed(HALF, HALF, HALF),
            X_OS: Pose::identity(),
        }],
        movable: true,
        supports: vec![],
        stable: vec![Stable {
            name: "up".into(),
            X_QO: at(0.0, 0.0, HALF),
            footprint: vec![[-HALF, -HALF], [HALF, -HALF], [HALF, HALF], [-HALF, HALF]],
        }],
        grasps: vec![Grasp {
            name: "top".into(),
            X_OT: down(),
            width: 2.0 * HALF,
        }],
        containers: vec![],
        mass: 0.2,
        color: [1.0, 0.0, 0.0, 1.0],
    }
}

fn table() -> Object {
    Object {
        id: "TABLE".into(),
        ty: None,
        parts: vec![Part {
            shape: boxed(0.6, 0.4, 0.025),
            X_OS: Pose::identity(),
        }],
        movable: false,
        supports: vec![Support {
            name: "top".into(),
            X_OF: at(0.0, 0.0, 0.025),
            half: [0.6, 0.4],
        }],
        stable: vec![],
        grasps: vec![],
        containers: vec![],
        mass: 20.0,
        color: [0.6, 0.4, 0.2, 1.0],
    }
}

pub fn world() -> World {
    let free = |pose: Pose| ObjectState { X_WO: pose, held: None };
    World {
        scene: Scene {
            agents: vec![gantry(), human()],
            objects: vec![cube("RED"), cube("BLUE"), table()],
            virtuals: vec![],
            human_aware: Default::default(),
        },
        start: State {
            agents: vec![
                AgentState {
                    X_WB: at(0.0, 0.0, BASE),
                    q: HOME.to_vec(),
                },
                AgentState {
                    X_WB: at(0.0, 0.9, TOP + 0.05),
                    q: vec![0.0, 0.0, 0.0],
                },
            ],
            objects: vec![
                free(at(RED[0], RED[1], TOP + HALF)),
                free(at(BLUE[0], BLUE[1], TOP + HALF)),
                free(at(0.0, 0.0, TOP - 0.025)),
            ],
        },
        task: None,
        shared: vec![],
        values: vec![],
        spans: vec![],
    }
}
