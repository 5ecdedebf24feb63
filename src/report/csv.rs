//! Trajectories of a plan as comma-separated values (RFC 4180): one row for each joint at each sample.

use std::fmt::Write;

use crate::plan::Plan;

/// Returns the table, with a head: `time` is that of the plan [s], `position` in radians or metres. Actions that move nothing have no rows.
pub fn write(plan: &Plan) -> String {
    let mut out = String::from("time,action,task,sub_action,agent,joint,position\n");
    for action in &plan.actions {
        let Some(geometry) = &action.geometry else { continue };
        let (task, agent) = (field(&action.name), field(&geometry.agent));
        let mut start = action.start;
        for sub in &geometry.sub_actions {
            let trajectory = &sub.trajectory;
            let name = field(&sub.name);
            for (t, row) in trajectory.times.iter().zip(&trajectory.positions) {
                for (joint, value) in trajectory.joints.iter().zip(row) {
                    let (time, joint) = (start + t, field(joint));
                    // A String takes every text.
                    let _ = writeln!(
                        out,
                        "{time:.6},{},{task},{name},{agent},{joint},{value:.9}",
                        action.index
                    );
                }
            }
            start += trajectory.duration();
        }
    }
    out
}

/// Returns the text as a field: in quotes where it needs them.
fn field(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn fields_are_quoted_where_they_must_be() {
        assert_eq!(super::field("left"), "left");
        assert_eq!(super::field("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
