//! Plans whose motions or grips are damaged.

use sgap::plan::*;

use super::damage::{Damage, damage, geometry, recipe, right, sub_action};
use super::plan::{PICK, PLACE, Q, Recipe, arm, fingers, z_above};
use super::world::{HALF, HOME, RED};

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
            pick("grasp"),
            &["demands that it is taken"],
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
