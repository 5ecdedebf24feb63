//! A plan for the gantry, computed by hand: motions along lines of the joint space, with smooth starts and stops.

use indexmap::IndexMap;
use sgap::geom::Pose;
use sgap::plan::*;

use super::world::{BASE, HALF, HOME, RED, TOOL, TOP, at, down};

/// Joint values x, y, z, yaw.
pub type Q = [f64; 4];

/// What may be done differently; [`Recipe::right`] is a plan without fault.
#[derive(Clone)]
pub struct Recipe {
    /// Between home and the place above RED.
    pub to_pick: Vec<Q>,
    /// Where the engage motion ends.
    pub grasp: Q,
    /// Finger joint when RED is taken.
    pub grip: f64,
    /// Between the place above RED and that above the placement.
    pub to_place: Vec<Q>,
    /// Placement on the table: x, y, yaw.
    pub place: [f64; 3],
    /// How far above the table it is let go.
    pub drop: f64,
}

/// z joint when the tool is at height `h` above a cube's centre on the table.
pub fn z_above(h: f64) -> f64 {
    TOP + HALF + TOOL + h - BASE
}

impl Recipe {
    pub fn right() -> Self {
        Recipe {
            to_pick: vec![],
            grasp: [RED[0], RED[1], z_above(0.0), 0.0],
            grip: HALF,
            to_place: vec![],
            place: [0.25, 0.2, 0.3],
            drop: 0.0,
        }
    }
}

/// Speed and acceleration limits of x, y, z, yaw, finger.
const LIMITS: [(f64, f64); 5] = [(1.0, 4.0), (1.0, 4.0), (1.0, 4.0), (2.0, 8.0), (0.2, 2.0)];
/// The jerk limit of each joint is so many times its limit of acceleration.
const JERK_PER_ACCELERATION: f64 = 100.0;
const NAMES: [&str; 5] = ["x", "y", "z", "yaw", "finger"];
const SAMPLES: usize = 25;

/// Moves some joints along lines through the points, stopping at each.
fn motion(joints: std::ops::Range<usize>, points: &[Vec<f64>]) -> Trajectory {
    let mut times = vec![0.0];
    let mut positions = vec![points[0].clone()];
    for pair in points.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let needed = joints.clone().zip(a.iter().zip(b)).map(|(j, (a, b))| {
            let way = (b - a).abs();
            // 10 s^3 - 15 s^4 + 6 s^5 has at most speed 1.875, acceleration 5.78 and jerk 60.
            let jerk = JERK_PER_ACCELERATION * LIMITS[j].1;
            let by_acceleration = (6.5 * way / LIMITS[j].1).sqrt();
            (2.0 * way / LIMITS[j].0)
                .max(by_acceleration)
                .max((65.0 * way / jerk).cbrt())
        });
        let length = needed.fold(0.0, f64::max);
        if length == 0.0 {
            continue;
        }
        let begin = *times.last().unwrap();
        for k in 1..=SAMPLES {
            let s = k as f64 / SAMPLES as f64;
            let t = s * s * s * (10.0 + s * (6.0 * s - 15.0));
            times.push(begin + s * length);
            positions.push(a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect());
        }
    }
    Trajectory {
        joints: NAMES[joints].iter().map(|n| n.to_string()).collect(),
        times,
        positions,
    }
}

pub fn arm(name: &str, motion_kind: Motion, points: &[Q]) -> SubAction {
    let points: Vec<Vec<f64>> = points.iter().map(|q| q.to_vec()).collect();
    SubAction {
        name: name.into(),
        motion: motion_kind,
        trajectory: motion(0..4, &points),
        change: None,
    }
}

pub fn fingers(name: &str, from: f64, to: f64, change: Option<AttachmentChange>) -> SubAction {
    let trajectory = motion(4..5, &[vec![from], vec![to]]);
    SubAction {
        name: name.into(),
        motion: Motion::Gripper,
        trajectory,
        change,
    }
}

fn tool(q: Q) -> Pose {
    at(q[0], q[1], BASE + q[2] - TOOL) * Pose::rotation(sgap::geom::Vec3::z() * q[3]) * down()
}

fn geometry(action: &str, gas: u32, placement: Option<Placement>, sub_actions: Vec<SubAction>) -> Geometry {
    Geometry {
        action: action.into(),
        gas,
        alternative: 0,
        agent: "GANTRY".into(),
        arm: "main".into(),
        object: "RED".into(),
        grasp: "top".into(),
        stand: None,
        placement,
        cost_parts: IndexMap::from([("length".to_owned(), 0.25), ("proximity".to_owned(), 0.5)]),
        sub_actions,
    }
}

fn action(index: usize, name: &str, arguments: &[&str], agents: &[&str], changes: &[(&str, &str)]) -> Action {
    let owned = |all: &[&str]| all.iter().map(|s| (*s).into()).collect();
    Action {
        index,
        name: name.into(),
        arguments: owned(arguments),
        agents: owned(agents),
        cost: 2.0,
        duration: [1.0, 3.0],
        start: 0.0,
        end: 1.0,
        geometry: None,
        changes: changes.iter().map(|(k, v)| ((*k).into(), (*v).into())).collect(),
    }
}

fn node(
    task: &str,
    arguments: &[&str],
    parent: Option<usize>,
    decomposition: Option<usize>,
    action: Option<usize>,
) -> Node {
    let arguments = arguments.iter().map(|s| (*s).into()).collect();
    Node {
        task: task.into(),
        arguments,
        parent,
        decomposition,
        action,
    }
}

/// Index of each action of [`plan`].
pub const PAINT_BLUE: usize = 0;
pub const PICK: usize = 1;
pub const PLACE: usize = 2;
pub const PAINT_RED: usize = 3;

/// Index of each node of its tree; `Move(BLUE)` has nothing to do.
pub const SERVE: usize = 0;
pub const PAINT_BLUE_LEAF: usize = 1;
pub const MOVE_BLUE: usize = 2;
pub const MOVE_RED: usize = 3;
pub const PICK_LEAF: usize = 4;
pub const PLACE_LEAF: usize = 5;

pub fn plan(recipe: &Recipe) -> Plan {
    let [hx, hy, hz, hyaw, open] = HOME;
    let home = [hx, hy, hz, hyaw];
    let above = |q: Q, h: f64| [q[0], q[1], q[2] + h, q[3]];
    let grasp = recipe.grasp;
    let before = [RED[0], RED[1], z_above(0.1), 0.0];
    let object_in_tool = tool(grasp).inverse() * at(RED[0], RED[1], TOP + HALF);
    let attach = AttachmentChange::Attach {
        object: "RED".into(),
        object_in_tool: object_in_tool.into(),
    };
    let to_pick: Vec<Q> = [home]
        .into_iter()
        .chain(recipe.to_pick.clone())
        .chain([before])
        .collect();
    let lifted = above(grasp, 0.1);
    let mut pick = action(
        PICK,
        "Pick",
        &["GANTRY", "RED"],
        &["GANTRY"],
        &[
            ("GANTRY.hasInHand", "RED"),
            ("RED.isOn", "NULL"),
            ("RED.isReachable", "[]"),
            ("BLUE.isReachable", "[HUMAN]"),
        ],
    );
    pick.geometry = Some(Box::new(geometry(
        "pick",
        0,
        None,
        vec![
            arm("approach", Motion::Free, &to_pick),
            arm("engage", Motion::Straight, &[before, grasp]),
            fingers("grasp", open, recipe.grip, Some(attach)),
            arm("disengage", Motion::Straight, &[grasp, lifted]),
        ],
    )));

    let [x, y, yaw] = recipe.place;
    let down_there = [x, y, z_above(recipe.drop), yaw];
    let over = [x, y, z_above(0.1), yaw];
    let to_place: Vec<Q> = [lifted]
        .into_iter()
        .chain(recipe.to_place.clone())
        .chain([over])
        .collect();
    let pose: PoseDocument = (tool(down_there) * object_in_tool).into();
    let placement = Placement {
        on: "TABLE".into(),
        support: "top".into(),
        stable: "up".into(),
        x,
        y,
        yaw,
        pose,
    };
    let detach = AttachmentChange::Detach {
        object: "RED".into(),
        object_in_world: pose,
    };
    let mut place = action(
        PLACE,
        "Place",
        &["GANTRY", "RED", "TABLE", "HUMAN"],
        &["GANTRY", "HUMAN"],
        &[
            ("GANTRY.hasInHand", "NULL"),
            ("RED.isOn", "TABLE"),
            ("RED.isReachable", "[GANTRY, HUMAN]"),
            ("BLUE.isReachable", "[GANTRY, HUMAN]"),
        ],
    );
    place.geometry = Some(Box::new(geometry(
        "placeReachable",
        1,
        Some(placement),
        vec![
            arm("approach", Motion::Free, &to_place),
            arm("place", Motion::Straight, &[over, down_there]),
            fingers("release", recipe.grip, open, Some(detach)),
            arm("retract", Motion::Straight, &[down_there, above(down_there, 0.1)]),
        ],
    )));
    let serve = Some(SERVE);
    let decomposition = vec![
        node("Serve", &["GANTRY", "HUMAN"], None, Some(0), None),
        node("Paint", &["HUMAN", "BLUE"], serve, None, Some(PAINT_BLUE)),
        node("Move", &["GANTRY", "BLUE", "HUMAN"], serve, None, None),
        node("Move", &["GANTRY", "RED", "HUMAN"], serve, Some(0), None),
        node("Pick", &["GANTRY", "RED"], Some(MOVE_RED), None, Some(PICK)),
        node(
            "Place",
            &["GANTRY", "RED", "TABLE", "HUMAN"],
            Some(MOVE_RED),
            None,
            Some(PLACE),
        ),
        node("Paint", &["HUMAN", "RED"], serve, None, Some(PAINT_RED)),
    ];
    let attribute = |name: &str| vec![LinkReason::Attribute(name.into())];
    let mut plan = Plan {
        format: "sgap-plan".into(),
        version: VERSION,
        task: "Serve(GANTRY, HUMAN)".into(),
        seed: 0,
        cost: 0.0,
        cost_parts: Vec::new(),
        makespan: 0.0,
        interleaved: false,
        actions: vec![
            action(
                PAINT_BLUE,
                "Paint",
                &["HUMAN", "BLUE"],
                &["HUMAN"],
                &[("BLUE.painted", "true")],
            ),
            pick,
            place,
            action(
                PAINT_RED,
                "Paint",
                &["HUMAN", "RED"],
                &["HUMAN"],
                &[("RED.painted", "true")],
            ),
        ],
        streams: IndexMap::from([
            ("HUMAN".to_owned(), vec![PAINT_BLUE, PLACE, PAINT_RED]),
            ("GANTRY".to_owned(), vec![PICK, PLACE]),
        ]),
        links: vec![
            Link {
                before: PICK,
                after: PLACE,
                reasons: attribute("GANTRY.hasInHand"),
            },
            Link {
                before: PLACE,
                after: PAINT_RED,
                reasons: attribute("RED.isReachable"),
            },
        ],
        decomposition,
    };
    reckon(&mut plan);
    plan
}

/// Writes costs, durations and times that fit the motions.
pub fn reckon(plan: &mut Plan) {
    for i in 0..plan.actions.len() {
        if let Some(geometry) = &plan.actions[i].geometry {
            let length: f64 = geometry.sub_actions.iter().map(|s| s.trajectory.duration()).sum();
            let most = if plan.actions[i].name == "Pick" {
                length
            } else {
                length.max(20.0)
            };
            plan.actions[i].cost = 1.75;
            plan.actions[i].duration = [length, most];
        }
        let before = |k: &usize| plan.actions[*k].end;
        let linked = plan.links.iter().filter(|l| l.after == i).map(|l| before(&l.before));
        let own = plan.streams.values().filter_map(|s| {
            let at = s.iter().position(|k| *k == i)?;
            Some(before(s.get(at.checked_sub(1)?)?))
        });
        let start = linked.chain(own).fold(0.0, f64::max);
        plan.actions[i].start = start;
        plan.actions[i].end = start + plan.actions[i].duration[0];
    }
    plan.cost = plan.actions.iter().map(|a| a.cost).sum();
    plan.makespan = plan.actions.iter().map(|a| a.end).fold(0.0, f64::max);
}
