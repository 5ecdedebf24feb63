//! `in_hand_of`: an object that an agent holds at the start, with the hand closed on it.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use crate::diag::{Problem, Problems};
use crate::world::agents::Agents;
use crate::world::objects::Written;
use crate::world::table::Name;
use crate::world::{Agent, Arm, Grasp, Held, ObjectState, problems};

/// Returns the object in the hand that the file names, else in the first one that is empty, held by the grasp that the file names,
/// else by the first for which the hand is wide enough. `taken` are the hands that hold something already.
pub(super) fn in_hand_of(
    object: &Written<'_>,
    name: Name<'_>,
    taken: &[Held],
    agents: &mut Agents,
    problems: &mut Problems,
) -> Option<ObjectState> {
    let place = &object.table.place;
    let Some(agent) = agents.agents.iter().position(|a| a.id == name.text) else {
        if agents.written.iter().any(|id| id == name.text) {
            // What is wrong with that agent is told already.
            return None;
        }
        let known = agents.written.iter().map(String::as_str);
        problems.push(problems::unknown_name(
            "world::unknown-agent",
            "agent",
            name.text,
            &format!("`in_hand_of` of {place}"),
            known,
            name.span,
        ));
        return None;
    };
    let body = &agents.agents[agent];
    let arm = which_arm(object, name, body, agent, taken, problems)?;
    let grasp = which_grasp(object, name, body, &body.arms[arm], problems)?;
    let stands = &mut agents.states[agent];
    if let Some(gripper) = &body.arms[arm].gripper {
        for (dof, value) in gripper.dofs.iter().zip(gripper.at_gap(grasp.width)) {
            stands.q[*dof] = value;
        }
    }
    let X_WL = body.tree.link_poses(&stands.X_WB, &stands.q);
    let X_TO = grasp.X_OT.inverse();
    Some(ObjectState {
        X_WO: X_WL[body.arms[arm].tip_link] * body.arms[arm].X_LT * X_TO,
        held: Some(Held { agent, arm, X_TO }),
    })
}

fn which_arm(
    object: &Written<'_>,
    name: Name<'_>,
    body: &Agent,
    agent: usize,
    taken: &[Held],
    problems: &mut Problems,
) -> Option<usize> {
    let is_empty = |arm: usize| !taken.iter().any(|h| h.agent == agent && h.arm == arm);
    let (arm, span) = match object.table.text("arm", problems) {
        None if object.table.has("arm") => return None,
        None => {
            let mut empty = (0..body.arms.len()).filter(|arm| is_empty(*arm));
            let preferred = body.manner.handedness.filter(|arm| is_empty(*arm));
            (preferred.or_else(|| empty.next()), name.span)
        }
        Some(wanted) => {
            let found = body.arms.iter().position(|arm| arm.name == wanted.text);
            if found.is_none() {
                let known = body.arms.iter().map(|arm| arm.name.as_str());
                let place = format!("`arm` of {}", object.table.place);
                let code = "world::unknown-arm";
                problems.push(problems::unknown_name(
                    code,
                    "arm",
                    wanted.text,
                    &place,
                    known,
                    wanted.span,
                ));
                return None;
            }
            (found.filter(|arm| is_empty(*arm)), wanted.span)
        }
    };
    if arm.is_none() {
        let message = format!("{} is in a hand of `{}` that is full", object.table.place, body.id);
        let help = "a hand holds one object: name another `arm`, or place it with `on` or `xyz`";
        problems.push(problems::bad_value(message, span, "", help));
    }
    arm
}

fn which_grasp<'o>(
    object: &'o Written<'_>,
    name: Name<'_>,
    body: &Agent,
    arm: &Arm,
    problems: &mut Problems,
) -> Option<&'o Grasp> {
    let (table, grasps) = (&object.table, &object.object.grasps);
    let holds = |g: &Grasp| {
        let gripper = arm.gripper.as_ref();
        gripper.is_none_or(|hand| hand.gap_closed <= g.width && g.width < hand.gap_open)
    };
    let no_grasp = |message: String, span| {
        let help = "give it `grasps = [{ name = \"..\", xyz = [..], rpy = [..], width = 0.05 }]`, or another place";
        Problem::error("world::no-grasp", message, span, "").help(help)
    };
    match table.text("grasp", problems) {
        None if table.has("grasp") => None,
        None => {
            let found = grasps.iter().find(|g| holds(g));
            if found.is_none() {
                let message = format!(
                    "no grasp of {} fits the {} hand of `{}`",
                    table.place, arm.name, body.id
                );
                problems.push(no_grasp(message, name.span));
            }
            found
        }
        Some(wanted) => {
            let found = grasps.iter().find(|g| g.name == wanted.text);
            match found {
                Some(grasp) if holds(grasp) => return found,
                Some(grasp) => {
                    let message = format!(
                        "grasp `{}` of {} is {} m wide, and the {} hand of `{}` does not close on that",
                        grasp.name, table.place, grasp.width, arm.name, body.id
                    );
                    problems.push(no_grasp(message, wanted.span));
                }
                None => {
                    let known = grasps.iter().map(|g| g.name.as_str());
                    let code = "world::unknown-grasp";
                    problems.push(problems::unknown_name(
                        code,
                        "grasp",
                        wanted.text,
                        &table.place,
                        known,
                        wanted.span,
                    ));
                }
            }
            None
        }
    }
}
