//! Damaged plans: what was done to the plan, and for what it must be refused.

use sgap::ir::Domain;
use sgap::plan::*;
use sgap::validate::Settings;
use sgap::world::World;

use super::domain::domain;
use super::plan::{
    MOVE_BLUE, MOVE_RED, PAINT_BLUE, PAINT_BLUE_LEAF, PAINT_RED, PICK, PICK_LEAF, PLACE, PLACE_LEAF, Recipe, SERVE,
    arm, plan, reckon, z_above,
};
use super::world::world;

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
    pub fn domain(mut self, change: impl FnOnce(&mut Domain)) -> Self {
        change(&mut self.domain);
        self
    }

    pub fn world(mut self, change: impl FnOnce(&mut World)) -> Self {
        change(&mut self.world);
        self
    }

    pub fn settings(mut self, change: impl FnOnce(&mut Settings)) -> Self {
        change(&mut self.settings);
        self
    }
}

pub fn damage(
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

pub fn right(change: impl FnOnce(&mut Plan)) -> Plan {
    let mut plan = plan(&Recipe::right());
    change(&mut plan);
    plan
}

pub fn recipe(change: impl FnOnce(&mut Recipe)) -> Plan {
    let mut recipe = Recipe::right();
    change(&mut recipe);
    plan(&recipe)
}

pub fn geometry(plan: &mut Plan, action: usize) -> &mut Geometry {
    plan.actions[action].geometry.as_mut().unwrap()
}

pub fn sub_action(plan: &mut Plan, action: usize, index: usize) -> &mut SubAction {
    &mut geometry(plan, action).sub_actions[index]
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
                p.actions[PICK].changes.remove("RED.isOn");
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

pub fn trees() -> Vec<Damage> {
    let none = (None, None);
    /// Takes nodes out of the list; those behind them, and their parents' indices, move up.
    fn cut(plan: &mut Plan, nodes: std::ops::Range<usize>) {
        let n = nodes.len();
        plan.decomposition.drain(nodes.clone());
        for node in &mut plan.decomposition {
            node.parent = node.parent.map(|p| if p >= nodes.end { p - n } else { p });
        }
    }
    vec![
        damage(
            "a tree of another task",
            "task",
            none,
            &["Move(GANTRY, RED, HUMAN)"],
            right(|p| {
                p.decomposition.truncate(PLACE_LEAF + 1);
                cut(p, SERVE..MOVE_RED);
                p.decomposition[0].parent = None;
            }),
        ),
        damage(
            "a decomposition that the task lacks",
            "no-such-decomposition",
            none,
            &["1"],
            right(|p| p.decomposition[MOVE_RED].decomposition = Some(1)),
        ),
        damage(
            "leaves out of order",
            "leaves",
            none,
            &["action 2"],
            right(|p| p.decomposition.swap(PICK_LEAF, PLACE_LEAF)),
        ),
        damage(
            "a leaf that is another action",
            "leaf-mismatch",
            none,
            &["Paint(HUMAN, RED)", "Paint(HUMAN, BLUE)"],
            right(|p| p.decomposition[PAINT_BLUE_LEAF].arguments[1] = "RED".into()),
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
                let aside = [0.25, 0.25, z_above(0.1), 0.3];
                motions[0] = arm("approach", Motion::Free, &[over, aside, over]);
                motions[1] = arm("engage", Motion::Straight, &[over, there]);
                motions[3] = arm("disengage", Motion::Straight, &[there, over]);
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
                p.decomposition[MOVE_RED].decomposition = None;
                cut(p, PICK_LEAF..PLACE_LEAF + 1);
            }),
        ),
        damage(
            "done though its goal holds",
            "goal-held-already",
            none,
            &[],
            right(|p| p.decomposition[MOVE_BLUE].decomposition = Some(0)),
        ),
        damage(
            "children but no decomposition",
            "node-shape",
            none,
            &[],
            right(|p| p.decomposition[MOVE_RED].decomposition = None),
        ),
        damage(
            "a subtask too few",
            "subtasks",
            none,
            &["Paint(HUMAN, BLUE)"],
            right(|p| cut(p, MOVE_BLUE..MOVE_RED)),
        ),
        damage(
            "a subtask that no choice of the variables gives",
            "subtasks",
            none,
            &["Move(GANTRY, BLUE, GANTRY)"],
            right(|p| p.decomposition[MOVE_BLUE].arguments[2] = "GANTRY".into()),
        ),
        damage(
            "one subtask twice, another not at all",
            "subtasks",
            none,
            &["Move(GANTRY, RED, HUMAN), Paint(HUMAN, RED)"],
            right(|p| {
                // `Move(RED)` is done in place of `Move(BLUE)`, and skipped when its own turn comes.
                let mut skipped = p.decomposition[MOVE_RED].clone();
                skipped.decomposition = None;
                p.decomposition.insert(PLACE_LEAF + 1, skipped);
                cut(p, MOVE_BLUE..MOVE_RED);
            }),
        ),
        damage(
            "no tree at all",
            "node-shape",
            none,
            &["no nodes"],
            right(|p| p.decomposition.clear()),
        ),
        damage(
            "a root with a parent",
            "node-shape",
            none,
            &["Serve(GANTRY, HUMAN)", "root"],
            right(|p| p.decomposition[SERVE].parent = Some(SERVE)),
        ),
        damage(
            "two roots",
            "node-shape",
            none,
            &["task Serve(GANTRY, HUMAN) / Paint(HUMAN, BLUE)", "only the first node"],
            right(|p| p.decomposition[PAINT_BLUE_LEAF].parent = None),
        ),
        damage(
            "a parent that is not in the list",
            "node-shape",
            none,
            &["Move(GANTRY, RED, HUMAN) / Place(GANTRY, RED, TABLE, HUMAN)", "parent"],
            right(|p| p.decomposition[PLACE_LEAF].parent = Some(99)),
        ),
        damage(
            "a parent that is over",
            "node-shape",
            none,
            &["task Serve(GANTRY, HUMAN) / Place(GANTRY, RED, TABLE, HUMAN)", "parent"],
            right(|p| {
                // Back to `Move(RED)` after the root's last subtask.
                let mut late = p.decomposition[PLACE_LEAF].clone();
                late.action = Some(4);
                p.decomposition.push(late);
            }),
        ),
        damage(
            "a node before its parent",
            "node-shape",
            none,
            &["task Serve(GANTRY, HUMAN) / Pick(GANTRY, RED)", "parent"],
            right(|p| {
                p.decomposition.swap(MOVE_RED, PICK_LEAF);
                p.decomposition[MOVE_RED].parent = Some(PICK_LEAF);
                p.decomposition[PLACE_LEAF].parent = Some(PICK_LEAF);
            }),
        ),
        damage(
            "an action with a subtask",
            "node-shape",
            none,
            &["Pick(GANTRY, RED)", "children"],
            right(|p| p.decomposition[PLACE_LEAF].parent = Some(PICK_LEAF)),
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
            "a link that supplies nothing",
            "link-reason",
            none,
            &["never sets `NONE.such`"],
            right(|p| p.links.last_mut().unwrap().reasons = vec![LinkReason::Threat("NONE.such".into())]),
        ),
        damage(
            "a link without a reason",
            "link-reason",
            none,
            &["none is given"],
            right(|p| p.links[0].reasons.clear()),
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
