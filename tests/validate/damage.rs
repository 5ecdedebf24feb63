//! Damaged plans: what was done to the plan, and for what it must be refused.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use sgap::geom::{Vec3, shape::Shape};
use sgap::ir::{AttributeId, CompareOp, Domain, Effect, EntityId, Expr, Test, Value, Var};
use sgap::plan::*;
use sgap::validate::Settings;
use sgap::world::{Held, Object, Part, Support, World};

use super::domain::domain;
use super::plan::{PAINT_BLUE, PAINT_RED, PICK, PLACE, Q, Recipe, arm, fingers, plan, reckon, z_above};
use super::world::{HALF, HOME, RED, at, world};

/// One damaged plan.
pub struct Damage {
    pub what: &'static str,
    /// Code of the fault.
    pub code: &'static str,
    /// Index of the action that is blamed.
    pub action: Option<usize>,
    /// Sub-action that is blamed, where the fault is in a motion.
    pub sub_action: Option<&'static str>,
    /// Words that the sentence must have: names of links, joints, objects, attributes.
    pub words: &'static [&'static str],
    pub plan: Plan,
    pub domain: Domain,
    pub world: World,
    pub settings: Settings,
}

impl Damage {
    fn domain(mut self, change: impl FnOnce(&mut Domain)) -> Self {
        change(&mut self.domain);
        self
    }

    fn world(mut self, change: impl FnOnce(&mut World)) -> Self {
        change(&mut self.world);
        self
    }

    fn settings(mut self, change: impl FnOnce(&mut Settings)) -> Self {
        change(&mut self.settings);
        self
    }
}

fn damage(
    what: &'static str,
    code: &'static str,
    blamed: (Option<usize>, Option<&'static str>),
    words: &'static [&'static str],
    plan: Plan,
) -> Damage {
    Damage {
        what,
        code,
        action: blamed.0,
        sub_action: blamed.1,
        words,
        plan,
        domain: domain(),
        world: world(),
        settings: super::settings(),
    }
}

fn right(change: impl FnOnce(&mut Plan)) -> Plan {
    let mut plan = plan(&Recipe::right());
    change(&mut plan);
    plan
}

fn recipe(change: impl FnOnce(&mut Recipe)) -> Plan {
    let mut recipe = Recipe::right();
    change(&mut recipe);
    plan(&recipe)
}

fn geometry(plan: &mut Plan, action: usize) -> &mut Geometry {
    plan.actions[action].geometry.as_mut().unwrap()
}

fn sub_action(plan: &mut Plan, action: usize, index: usize) -> &mut SubAction {
    &mut geometry(plan, action).sub_actions[index]
}

fn scale_times(sub_action: &mut SubAction, factor: f64) {
    for t in &mut sub_action.trajectory.times {
        *t *= factor;
    }
}

/// A straight motion with a bow of `depth` to the side, that starts and stops as smoothly.
fn bow(sub_action: &mut SubAction, depth: f64) {
    let n = sub_action.trajectory.positions.len() - 1;
    for (i, row) in sub_action.trajectory.positions.iter_mut().enumerate() {
        let s = i as f64 / n as f64;
        let t = s * s * (3.0 - 2.0 * s);
        row[1] += depth * 4.0 * t * (1.0 - t);
    }
    scale_times(sub_action, 2.0);
}

pub fn documents() -> Vec<Damage> {
    let none = (None, None);
    let pick = (Some(PICK), None);
    vec![
        damage(
            "another format",
            "format",
            none,
            &["sgap-plan"],
            right(|p| p.format = "hatp".into()),
        ),
        damage(
            "a later version",
            "version",
            none,
            &["2"],
            right(|p| p.version = VERSION + 1),
        ),
        damage(
            "two actions swapped in the list",
            "index",
            (Some(1), None),
            &["position 1"],
            right(|p| p.actions.swap(PICK, PLACE)),
        ),
        damage(
            "an object that is not there",
            "argument",
            pick,
            &["GREEN", "Object"],
            right(|p| p.actions[PICK].arguments[1] = "GREEN".into()),
        ),
        damage(
            "an argument of another type",
            "argument",
            pick,
            &["TABLE", "Object"],
            right(|p| p.actions[PICK].arguments[1] = "TABLE".into()),
        ),
        damage(
            "an argument too many",
            "argument-count",
            pick,
            &["Pick"],
            right(|p| p.actions[PICK].arguments.push("RED".into())),
        ),
        damage(
            "an action that the domain lacks",
            "unknown-name",
            pick,
            &["Throw"],
            right(|p| p.actions[PICK].name = "Throw".into()),
        ),
        damage(
            "another agent takes part",
            "agents",
            pick,
            &["HUMAN"],
            right(|p| p.actions[PICK].agents.push("HUMAN".into())),
        ),
        damage(
            "a cost that is no number",
            "not-finite",
            pick,
            &[],
            right(|p| p.actions[PICK].cost = f64::NAN),
        ),
        damage(
            "a quaternion of another length",
            "quaternion",
            (Some(PLACE), None),
            &["placement"],
            right(|p| geometry(p, PLACE).placement.as_mut().unwrap().pose.quaternion = [0.0, 0.0, 0.0, 2.0]),
        ),
        damage(
            "a plan for another task",
            "task",
            none,
            &["Serve(HUMAN, GANTRY)"],
            right(|p| p.task = "Serve(HUMAN, GANTRY)".into()),
        ),
    ]
}

pub fn symbols() -> Vec<Damage> {
    let pick = (Some(PICK), None);
    let place = (Some(PLACE), None);
    vec![
        damage(
            "an action removed",
            "precondition",
            (Some(1), None),
            &["GANTRY.hasInHand"],
            {
                right(|p| {
                    p.actions.remove(PICK);
                    for (i, a) in p.actions.iter_mut().enumerate() {
                        a.index = i;
                    }
                })
            },
        ),
        damage(
            "an action done twice",
            "precondition",
            (Some(4), None),
            &["RED.painted"],
            right(|p| {
                let mut again = p.actions[PAINT_RED].clone();
                again.index = 4;
                p.actions.push(again);
            }),
        ),
        damage(
            "a change not mentioned",
            "changes",
            (Some(PAINT_RED), None),
            &["RED.painted", "unchanged"],
            right(|p| p.actions[PAINT_RED].changes.clear()),
        ),
        damage(
            "a change made up",
            "changes",
            (Some(PAINT_RED), None),
            &["BLUE.isOn", "unchanged"],
            right(|p| {
                p.actions[PAINT_RED].changes.insert("BLUE.isOn".into(), "NULL".into());
            }),
        ),
        damage(
            "a change of nothing",
            "changes",
            (Some(PAINT_RED), None),
            &["GREEN.painted"],
            right(|p| {
                p.actions[PAINT_RED]
                    .changes
                    .insert("GREEN.painted".into(), "true".into());
            }),
        ),
        damage(
            "an action made cheaper",
            "cost",
            pick,
            &["1.75", "1.5"],
            right(|p| p.actions[PICK].cost = 1.5),
        ),
        damage(
            "a part of the geometric cost that pays",
            "cost-negative",
            pick,
            &["-1"],
            right(|p| {
                geometry(p, PICK).cost_parts.insert("length".into(), -2.5);
            }),
        ),
        damage(
            "a cheaper total",
            "cost-total",
            (None, None),
            &[],
            right(|p| p.cost -= 1.0),
        ),
        damage(
            "an action shorter than its motions",
            "duration",
            place,
            &[],
            right(|p| p.actions[PLACE].duration = [1.0, 20.0]),
        ),
        damage(
            "motions taken away",
            "geometry-missing",
            pick,
            &["pick"],
            right(|p| p.actions[PICK].geometry = None),
        ),
        damage(
            "motions where there are none",
            "geometry-unexpected",
            (Some(PAINT_BLUE), None),
            &[],
            right(|p| p.actions[PAINT_BLUE].geometry = p.actions[PICK].geometry.clone()),
        ),
        damage(
            "motions of another object",
            "geometry-mismatch",
            pick,
            &["RED", "BLUE"],
            right(|p| geometry(p, PICK).object = "BLUE".into()),
        ),
        damage(
            "a fact claimed: the human can't reach what the gantry has lifted",
            "fact-unconfirmed",
            pick,
            &["isReachable(RED, HUMAN)"],
            right(|p| {
                p.actions[PICK]
                    .changes
                    .insert("RED.isReachable".into(), "[HUMAN]".into());
            }),
        ),
        damage(
            "a fact denied: the human reaches what stands before him",
            "fact-contradicted",
            place,
            &["isReachable(RED, HUMAN)"],
            right(|p| {
                p.actions[PLACE]
                    .changes
                    .insert("RED.isReachable".into(), "[GANTRY]".into());
            }),
        ),
        damage(
            "a fact that stays, listed as a change",
            "changes",
            place,
            &["BLUE.isVisible"],
            right(|p| {
                p.actions[PLACE]
                    .changes
                    .insert("BLUE.isVisible".into(), "[HUMAN]".into());
            }),
        ),
        damage(
            "held and yet on the table",
            "fact-unconfirmed",
            pick,
            &["isOn(RED, TABLE)"],
            right(|p| {
                p.actions[PICK].changes.shift_remove("RED.isOn");
            }),
        ),
        damage(
            "placed reachable, out of the human's reach",
            "fact-unconfirmed",
            place,
            &["isReachable(RED, HUMAN)"],
            recipe(|r| r.place = [-0.4, 0.2, 0.0]),
        ),
    ]
}

pub fn motions() -> Vec<Damage> {
    let pick = |name: &'static str| (Some(PICK), Some(name));
    let place = |name: &'static str| (Some(PLACE), Some(name));
    vec![
        damage(
            "a joint jumped",
            "speed",
            pick("approach"),
            &["`yaw`"],
            right(|p| sub_action(p, PICK, 0).trajectory.positions[12][3] += 0.5),
        ),
        damage(
            "a motion that starts elsewhere",
            "configuration-jump",
            place("approach"),
            &["`z`"],
            right(|p| sub_action(p, PLACE, 0).trajectory.positions[0][2] += 0.02),
        ),
        damage(
            "a motion cut out",
            "configuration-jump",
            pick("grasp"),
            &["`finger`"],
            {
                right(|p| {
                    let mut jumped = fingers("grasp", 0.04, HALF, None);
                    jumped.change = sub_action(p, PICK, 2).change.clone();
                    *sub_action(p, PICK, 2) = jumped;
                })
            },
        ),
        damage(
            "a joint beyond its limit",
            "joint-limit",
            pick("open"),
            &["`finger`", "0.05"],
            right(|p| {
                geometry(p, PICK)
                    .sub_actions
                    .insert(0, fingers("open", HOME[4], 0.052, None))
            }),
        ),
        damage(
            "a motion in less time",
            "acceleration",
            pick("engage"),
            &["`z`"],
            right(|p| scale_times(sub_action(p, PICK, 1), 0.75)),
        ),
        damage(
            "time runs backwards",
            "time-order",
            pick("approach"),
            &["time 3"],
            right(|p| sub_action(p, PICK, 0).trajectory.times[3] = 0.0),
        ),
        damage(
            "a row cut short",
            "trajectory-shape",
            pick("approach"),
            &["row 7"],
            right(|p| sub_action(p, PICK, 0).trajectory.positions[7].truncate(2)),
        ),
        damage(
            "a position that is no number",
            "not-finite",
            pick("approach"),
            &[],
            right(|p| sub_action(p, PICK, 0).trajectory.positions[7][0] = f64::NAN),
        ),
        damage(
            "a joint that is not there",
            "unknown-name",
            pick("approach"),
            &["elbow"],
            right(|p| sub_action(p, PICK, 0).trajectory.joints[0] = "elbow".into()),
        ),
        damage(
            "an arm that moves while only the fingers should",
            "joint-foreign",
            pick("grasp"),
            &["`x`", "GANTRY"],
            right(|p| {
                let moved = arm(
                    "grasp",
                    Motion::Gripper,
                    &[Recipe::right().grasp, Recipe::right().grasp],
                );
                sub_action(p, PICK, 2).trajectory = moved.trajectory;
            }),
        ),
        damage(
            "fingers that open while they carry",
            "joint-foreign",
            place("approach"),
            &["`finger`"],
            right(|p| {
                let t = &mut sub_action(p, PLACE, 0).trajectory;
                t.joints.push("finger".into());
                t.positions.iter_mut().for_each(|row| row.push(HALF));
            }),
        ),
        damage(
            "a straight motion with a bow",
            "not-straight",
            pick("disengage"),
            &[],
            right(|p| bow(sub_action(p, PICK, 3), 0.02)),
        ),
        damage(
            "a trajectory through the table",
            "collision",
            pick("engage"),
            &["GANTRY/finger_", "TABLE"],
            recipe(|r| r.grasp = [RED[0], RED[1], -0.93, 0.0]),
        ),
        damage(
            "the hand through a cube that it does not handle",
            "collision",
            pick("approach"),
            &["GANTRY/finger_", "BLUE"],
            recipe(|r| r.to_pick = vec![[0.3, 0.045, z_above(0.0), 0.0], [0.3, 0.045, z_above(0.1), 0.0]]),
        ),
        damage(
            "the hand against the cube that it will handle, in a free motion",
            "collision",
            pick("approach"),
            &["GANTRY/finger_", "RED"],
            recipe(|r| {
                let low: Q = [RED[0], RED[1] + 0.045, z_above(0.0), 0.0];
                r.to_pick = vec![
                    [low[0], low[1], z_above(0.1), 0.0],
                    low,
                    [low[0], low[1], z_above(0.1), 0.0],
                ];
            }),
        ),
        damage(
            "the held cube through another",
            "collision",
            place("approach"),
            &["RED", "BLUE"],
            recipe(|r| r.to_place = vec![[0.3, 0.0, z_above(0.04), 0.0]]),
        ),
        damage(
            "set down into the table",
            "collision",
            place("place"),
            &["RED", "TABLE"],
            recipe(|r| r.drop = -0.004),
        ),
    ]
}

pub fn grips() -> Vec<Damage> {
    let pick = |name: &'static str| (Some(PICK), Some(name));
    let place = |name: &'static str| (Some(PLACE), Some(name));
    vec![
        damage(
            "taken from a distance",
            "grasp-missed",
            pick("grasp"),
            &["`top`", "0.0150 m"],
            recipe(|r| r.grasp = [RED[0], RED[1], z_above(0.015), 0.0]),
        ),
        damage(
            "taken askew",
            "grasp-missed",
            pick("grasp"),
            &["0.0500 rad"],
            recipe(|r| r.grasp = [RED[0], RED[1], z_above(0.0), 0.05]),
        ),
        damage(
            "taken with open fingers",
            "fingers-open",
            pick("grasp"),
            &["`finger`", "0.0800", "0.0600"],
            recipe(|r| r.grip = 0.04),
        ),
        damage(
            "a grasp that the object lacks",
            "unknown-name",
            pick("grasp"),
            &["side"],
            right(|p| geometry(p, PICK).grasp = "side".into()),
        ),
        damage(
            "it jumps into the hand",
            "object-jump",
            pick("grasp"),
            &["`RED`"],
            right(|p| match &mut sub_action(p, PICK, 2).change {
                Some(AttachmentChange::Attach { object_in_tool, .. }) => object_in_tool.position[0] += 0.02,
                _ => unreachable!("the grasp attaches"),
            }),
        ),
        damage(
            "never taken",
            "handling",
            pick_without_sub_action(),
            &["takes 1"],
            right(|p| sub_action(p, PICK, 2).change = None),
        ),
        damage(
            "held twice",
            "held-already",
            pick("disengage"),
            &["`RED`", "GANTRY"],
            right(|p| sub_action(p, PICK, 3).change = sub_action(p, PICK, 2).change.clone()),
        ),
        damage(
            "it jumps when let go",
            "object-jump",
            place("release"),
            &["`RED`"],
            right(|p| match &mut sub_action(p, PLACE, 2).change {
                Some(AttachmentChange::Detach { object_in_world, .. }) => object_in_world.position[0] += 0.02,
                _ => unreachable!("the release detaches"),
            }),
        ),
        damage(
            "left in the air",
            "not-standing",
            place("release"),
            &["`RED`", "`TABLE`", "0.0100 m above"],
            recipe(|r| r.drop = 0.01),
        ),
        damage(
            "put over the edge",
            "not-standing",
            place("release"),
            &["over the edge"],
            recipe(|r| r.place = [0.59, 0.2, 0.0]),
        ),
        damage(
            "let go with closed fingers",
            "fingers-closed",
            place("release"),
            &["`finger`"],
            right(|p| {
                let mut still = fingers("release", HALF, HALF, None);
                still.change = sub_action(p, PLACE, 2).change.clone();
                *sub_action(p, PLACE, 2) = still;
            }),
        ),
        damage(
            "placed elsewhere than said",
            "placement",
            place("release"),
            &["x, y and yaw"],
            right(|p| geometry(p, PLACE).placement.as_mut().unwrap().yaw += 0.1),
        ),
        damage(
            "a pose elsewhere than said",
            "placement",
            place("release"),
            &["pose"],
            right(|p| geometry(p, PLACE).placement.as_mut().unwrap().pose.position[1] += 0.01),
        ),
    ]
}

fn pick_without_sub_action() -> (Option<usize>, Option<&'static str>) {
    (Some(PICK), None)
}

pub fn trees() -> Vec<Damage> {
    let none = (None, None);
    fn third(plan: &mut Plan) -> &mut Node {
        &mut plan.decomposition.children[2]
    }
    vec![
        damage(
            "a tree of another task",
            "task",
            none,
            &["Move(GANTRY, RED, HUMAN)"],
            right(|p| p.decomposition = third(p).clone()),
        ),
        damage(
            "a decomposition that the task lacks",
            "no-such-decomposition",
            none,
            &["1"],
            right(|p| third(p).decomposition = Some(1)),
        ),
        damage(
            "leaves out of order",
            "leaves",
            none,
            &["action 2"],
            right(|p| third(p).children.swap(0, 1)),
        ),
        damage(
            "a leaf that is another action",
            "leaf-mismatch",
            none,
            &["Paint(HUMAN, RED)", "Paint(HUMAN, BLUE)"],
            right(|p| p.decomposition.children[0].arguments[1] = "RED".into()),
        ),
        damage(
            "an action that no task asks for",
            "leaves",
            none,
            &["missing"],
            right(|p| {
                let there = [0.25, 0.2, z_above(0.0), 0.3];
                let over = [0.25, 0.2, z_above(0.1), 0.3];
                let mut again = p.actions[PICK].clone();
                again.index = 4;
                let motions = &mut again.geometry.as_mut().unwrap().sub_actions;
                motions.remove(0);
                motions[0] = arm("engage", Motion::Straight, &[over, there]);
                motions[2] = arm("disengage", Motion::Straight, &[there, over]);
                p.actions.push(again);
                reckon(p);
            }),
        ),
        damage(
            "skipped though its goal does not hold",
            "goal-not-held",
            none,
            &["RED.isReachable"],
            right(|p| {
                third(p).decomposition = None;
                third(p).children.clear();
            }),
        ),
        damage(
            "done though its goal holds",
            "goal-held-already",
            none,
            &[],
            right(|p| p.decomposition.children[1].decomposition = Some(0)),
        ),
        damage(
            "children but no decomposition",
            "node-shape",
            none,
            &[],
            right(|p| third(p).decomposition = None),
        ),
        damage(
            "a subtask too few",
            "subtasks",
            none,
            &["Paint(HUMAN, BLUE)"],
            right(|p| {
                p.decomposition.children.remove(1);
            }),
        ),
        damage(
            "a subtask that no choice of the variables gives",
            "subtasks",
            none,
            &["Move(GANTRY, BLUE, GANTRY)"],
            right(|p| p.decomposition.children[1].arguments[2] = "GANTRY".into()),
        ),
        damage(
            "one subtask twice, another not at all",
            "subtasks",
            none,
            &["Move(GANTRY, RED, HUMAN), Paint(HUMAN, RED)"],
            right(|p| {
                let children = &mut p.decomposition.children;
                children[1] = children[2].clone();
                children[2].children.clear();
                children[2].decomposition = None;
            }),
        ),
    ]
}

pub fn schedules() -> Vec<Damage> {
    let none = (None, None);
    vec![
        damage("an action begun late", "start", (Some(PICK), None), &["0.5"], {
            right(|p| {
                p.actions[PICK].start += 0.5;
                p.actions[PICK].end += 0.5;
            })
        }),
        damage(
            "an action begun before its agent is free",
            "start",
            (Some(PAINT_RED), None),
            &[],
            right(|p| p.actions[PAINT_RED].start = 0.0),
        ),
        damage("an end that is not one", "end", (Some(PAINT_RED), None), &[], {
            right(|p| p.actions[PAINT_RED].end += 1.0)
        }),
        damage(
            "a shorter makespan",
            "makespan",
            none,
            &[],
            right(|p| p.makespan -= 1.0),
        ),
        damage(
            "a stream out of order",
            "stream",
            none,
            &["`HUMAN`"],
            right(|p| p.streams["HUMAN"].swap(0, 1)),
        ),
        damage(
            "an agent without a stream",
            "stream",
            none,
            &["`GANTRY`"],
            right(|p| {
                p.streams.shift_remove("GANTRY");
            }),
        ),
        damage(
            "a link removed",
            "link-missing",
            (Some(PAINT_RED), None),
            &["RED.isReachable"],
            right(|p| {
                p.links.pop();
                reckon(p);
            }),
        ),
        damage(
            "a link that others imply",
            "link-redundant",
            none,
            &["from 1 to 3"],
            right(|p| {
                p.links.push(Link {
                    before: PICK,
                    after: PAINT_RED,
                    reasons: vec![LinkReason::Order],
                })
            }),
        ),
        damage(
            "a link against the order",
            "link-index",
            none,
            &["from action 2 to action 1"],
            right(|p| {
                p.links.push(Link {
                    before: PLACE,
                    after: PICK,
                    reasons: vec![LinkReason::Order],
                })
            }),
        ),
    ]
}

/// `GANTRY.hasInHand op NULL`.
fn gantry_hand(op: CompareOp) -> Test {
    Test::Compare {
        op,
        left: Expr::Attribute {
            base: Box::new(Expr::Const(Value::Entity(EntityId(0)))),
            attribute: AttributeId(0),
        },
        right: Expr::Const(Value::Null),
    }
}

const PICKS: usize = 0;
const PLACES: usize = 1;
const PAINTS: usize = 2;

/// `O.painted` of an action's second parameter: no number.
fn painted() -> Expr {
    Expr::Attribute {
        base: Box::new(Expr::Var(Var(1))),
        attribute: AttributeId(4),
    }
}

fn anybody_paints(domain: &mut Domain) {
    domain.actions[PAINTS].preconditions = Test::always();
}

/// Right plans in another world, or by another domain.
pub fn surroundings() -> Vec<Damage> {
    let none = (None, None);
    let plain = || right(|_| {});
    let paint = (Some(PAINT_BLUE), None);
    vec![
        damage("a cost without a value", "cost-undefined", paint, &[], plain())
            .domain(|d| d.actions[PAINTS].cost = painted()),
        damage("a duration without a value", "duration-undefined", paint, &[], plain())
            .domain(|d| d.actions[PAINTS].duration.1 = painted()),
        damage(
            "a geometric action that nobody checks",
            "geometry-unchecked",
            (Some(PICK), None),
            &["throw"],
            right(|p| geometry(p, PICK).action = "throw".into()),
        )
        .domain(|d| d.actions[PICKS].projects.as_mut().unwrap().name = "throw".into()),
        damage(
            "a fact that nobody checks",
            "fact-unchecked",
            none,
            &["RED.isOn", "isIn"],
            plain(),
        )
        .domain(|d| d.attributes[1].fact = Some("isIn".into())),
        damage(
            "a decomposition that does not apply",
            "decomposition-precondition",
            none,
            &["GANTRY.hasInHand"],
            plain(),
        )
        .domain(|d| d.methods[0].decompositions[0].preconditions = gantry_hand(CompareOp::NotEqual)),
        damage(
            "subtasks in an order that the domain forbids",
            "subtasks",
            none,
            &["Paint(HUMAN, BLUE)"],
            plain(),
        )
        .domain(|d| d.methods[1].decompositions[0].subtasks[0].after = vec![1]),
        damage(
            "a choice that the filter forbids",
            "subtasks",
            none,
            &["Pick(GANTRY, RED)"],
            plain(),
        )
        .domain(|d| match &mut d.methods[0].decompositions[0].binders[0] {
            sgap::ir::Binder::Select { filter, .. } => *filter = Test::Not(Box::new(Test::always())),
            sgap::ir::Binder::Let { .. } => unreachable!("a SELECT"),
        }),
        damage(
            "too many choices to try",
            "subtasks-undecided",
            none,
            &["0 choices"],
            plain(),
        )
        .settings(|s| s.max_bindings = 0),
        damage(
            "a plan too long to check",
            "too-long",
            (Some(PICK), Some("approach")),
            &["20"],
            plain(),
        )
        .settings(|s| s.max_configurations = 20),
        damage(
            "motions of two streams without a link",
            "motion-order",
            (Some(PLACE), None),
            &["1"],
            right(|p| {
                p.actions[PLACE].agents = vec!["HUMAN".into()];
                p.streams["GANTRY"] = vec![PICK];
                p.links.remove(0);
                reckon(p);
            }),
        )
        .domain(|d| d.actions[PLACES].agents = vec![3]),
        damage(
            "no link keeps the paint before the pick",
            "link-race",
            paint,
            &["GANTRY.hasInHand"],
            plain(),
        )
        .domain(|d| d.actions[PAINTS].preconditions = gantry_hand(CompareOp::Equal)),
        damage(
            "no link says who writes last",
            "outcome-race",
            paint,
            &["BLUE.painted"],
            right(|p| {
                p.actions[PICK].changes.insert("BLUE.painted".into(), "false".into());
            }),
        )
        .domain(|d| {
            d.actions[PICKS].effects.push(Effect::Assign {
                entity: Expr::Const(Value::Entity(EntityId(3))),
                attribute: AttributeId(4),
                value: Expr::Const(Value::Bool(false)),
            });
        }),
        damage(
            "put down what was never taken",
            "not-held",
            (Some(1), None),
            &["`RED`", "GANTRY's main hand"],
            right(|p| {
                p.actions.remove(PICK);
                for (i, a) in p.actions.iter_mut().enumerate() {
                    a.index = i;
                }
            }),
        )
        .domain(|d| d.actions[PLACES].preconditions = Test::always()),
        damage(
            "taken with a full hand",
            "hand-occupied",
            (Some(PICK), Some("grasp")),
            &["`BLUE`"],
            plain(),
        )
        .domain(anybody_paints)
        .domain(|d| d.actions[PICKS].preconditions = Test::always())
        .world(|w| {
            w.start.objects[1].held = Some(Held {
                agent: 0,
                arm: 0,
                X_TO: at(-0.2, 0.4, 0.0),
            })
        }),
        damage(
            "the ground taken from under another",
            "in-the-air",
            (Some(PICK), None),
            &["`BLUE`"],
            right(|p| {
                let from = Recipe::right().grasp;
                let aside = [from[0], from[1] + 0.1, from[2], from[3]];
                *sub_action(p, PICK, 3) = arm("disengage", Motion::Straight, &[from, aside]);
            }),
        )
        .domain(anybody_paints)
        .world(|w| {
            // RED has a ledge on its left side, and BLUE stands on it.
            let shape = Shape::Box {
                half: Vec3::new(0.04, 0.03, 0.005),
            };
            w.scene.objects[0].parts.push(Part {
                shape,
                X_OS: at(-0.1, 0.0, 0.0),
            });
            let X_OF = at(-0.1, 0.0, 0.005);
            w.scene.objects[0].supports.push(Support {
                name: "ledge".into(),
                X_OF,
                half: [0.04, 0.03],
            });
            w.start.objects[1].X_WO = w.start.objects[0].X_WO * at(-0.1, 0.0, 0.005 + HALF);
        }),
        damage(
            "a human's hand in the way",
            "collision",
            (Some(PICK), Some("approach")),
            &["GANTRY/", "HUMAN/palm"],
            plain(),
        )
        .domain(anybody_paints)
        .world(|w| w.start.agents[1].X_WB = at(RED[0], RED[1] + 0.05, 0.75)),
        damage(
            "an obstacle in the way",
            "collision",
            (Some(PLACE), Some("approach")),
            &["RED", "WALL"],
            plain(),
        )
        .world(|w| wall(w, [0.0, 0.1, 0.6], [0.01, 0.1, 0.05])),
        damage(
            "seen through a wall",
            "fact-unconfirmed",
            (Some(PLACE), None),
            &["isVisible(RED, HUMAN)"],
            plain(),
        )
        .world(|w| wall(w, [0.3, 0.37, 0.8], [0.25, 0.005, 0.2])),
        damage(
            "not seen in plain sight",
            "fact-contradicted",
            (Some(PICK), None),
            &["isVisible(BLUE, HUMAN)"],
            right(|p| {
                p.actions[PICK].changes.insert("BLUE.isVisible".into(), "[]".into());
            }),
        ),
        damage(
            "a narrower joint",
            "joint-limit",
            (Some(PICK), Some("approach")),
            &["`x`", "-0.2"],
            plain(),
        )
        .world(|w| w.scene.agents[0].tree.dofs[0].lower = -0.2),
        damage(
            "a heavier joint",
            "acceleration",
            (Some(PICK), Some("approach")),
            &["`x`"],
            plain(),
        )
        .world(|w| w.scene.agents[0].tree.dofs[0].max_acceleration = 1.0),
    ]
}

fn wall(world: &mut World, centre: [f64; 3], half: [f64; 3]) {
    let shape = Shape::Box { half: Vec3::from(half) };
    let table = world.scene.objects[2].clone();
    let parts = vec![Part {
        shape,
        X_OS: at(0.0, 0.0, 0.0),
    }];
    world.scene.objects.push(Object {
        id: "WALL".into(),
        parts,
        supports: vec![],
        ..table
    });
    let mut state = world.start.objects[2].clone();
    state.X_WO = at(centre[0], centre[1], centre[2]);
    world.start.objects.push(state);
}
