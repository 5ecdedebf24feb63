//! Motions of a plan as ROS 2 messages `trajectory_msgs/JointTrajectory` in YAML: one document for each sub-action, in the order of
//! the plan.
//!
//! The stamp is 0, which a controller reads as "now": when a motion begins in the plan is told by the comment above it, together with
//! what the hand takes or lets go of when it is over, which is no trajectory.

use std::fmt::Write;

use super::yaml::quoted;
use crate::plan::{AttachmentChange, Plan, SubAction};

/// Returns the documents; a comment alone if nothing moves.
pub fn write(plan: &Plan) -> String {
    let mut out = format!("# {}\n", one_line(&plan.task));
    for action in &plan.actions {
        let Some(geometry) = &action.geometry else { continue };
        let mut start = action.start;
        for sub in &geometry.sub_actions {
            let call = format!("{}({})", action.name, action.arguments.join(", "));
            // A String takes every text.
            let _ = writeln!(
                out,
                "---\n# action {} {}, {} of {}: from {start:.3} s on",
                action.index,
                one_line(&call),
                sub.name,
                geometry.agent
            );
            message(&mut out, sub);
            start += sub.trajectory.duration();
        }
    }
    out
}

fn message(out: &mut String, sub: &SubAction) {
    match &sub.change {
        Some(AttachmentChange::Attach { object, .. }) => *out += &format!("# then the hand holds {object}\n"),
        Some(AttachmentChange::Detach { object, .. }) => *out += &format!("# then the hand lets go of {object}\n"),
        None => {}
    }
    let trajectory = &sub.trajectory;
    let joints: Vec<String> = trajectory.joints.iter().map(|j| quoted(j)).collect();
    *out += "header:\n  stamp: {sec: 0, nanosec: 0}\n  frame_id: \"\"\n";
    *out += &format!("joint_names: [{}]\npoints:", joints.join(", "));
    if trajectory.times.is_empty() {
        *out += " []";
    }
    *out += "\n";
    for (t, row) in trajectory.times.iter().zip(&trajectory.positions) {
        let row: Vec<String> = row.iter().map(|v| format!("{v:.9}")).collect();
        // Times in a plan are not negative.
        let nanoseconds = (t.max(0.0) * 1e9).round() as u64;
        let (sec, nanosec) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
        *out += &format!(
            "- positions: [{}]\n  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}\n",
            row.join(", ")
        );
    }
}

/// A comment ends with its line.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}
