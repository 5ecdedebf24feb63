//! Plans in the format of the hierarchical planning competition of 2020 (HTN IPC), which public verifiers read.
//!
//! ```text
//! ==>
//! 3 drive truck-1 a b
//! root 1
//! 1 deliver box b -> m-deliver 2 3 4
//! <==
//! ```
//!
//! Numbers are those of the plan's decomposition tree. Names are those of the HDDL files, with their capitals and dashes.

use std::fmt::Write;

use super::names::Names;
use crate::plan::{Node, Plan};

/// Returns the plan in the competition's format; `None` if it was not made from the pair that the names belong to.
pub fn ipc(plan: &Plan, names: &Names) -> Option<String> {
    let nodes = &plan.decomposition;
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut of_action = vec![None; plan.actions.len()];
    let is_late = |at: usize| nodes.get(at).is_some_and(|n| names.late.contains(n.task.as_str()));
    for (at, node) in nodes.iter().enumerate() {
        // What is below a task around a subtask stands in its place.
        let parent = node.parent.map(|p| if is_late(p) { nodes[p].parent } else { Some(p) });
        if let Some(parent) = parent.filter(|_| !is_late(at)) {
            below.get_mut(parent?)?.push(at);
        }
        if let Some(action) = node.action {
            *of_action.get_mut(action)? = Some(at);
        }
    }
    let mut out = String::from("==>\n");
    for node in of_action {
        let node = node?;
        let name = names.actions.get(nodes[node].task.as_str())?;
        let _ = writeln!(out, "{node} {name}{}", arguments(&nodes[node], names)?);
    }
    let is_goal = |at: &usize| names.goal.as_deref() == Some(nodes[*at].task.as_str());
    if nodes.first()?.task != names.problem {
        return None;
    }
    below[0].retain(|at| !is_goal(at));
    let _ = writeln!(out, "root{}", ids(&in_order(&below[0], nodes, &names.start)));
    for (at, node) in nodes.iter().enumerate().skip(1) {
        if node.action.is_some() || is_goal(&at) || is_late(at) {
            continue;
        }
        let task = names.tasks.get(node.task.as_str())?;
        let method = task.methods.get(node.decomposition?)?;
        let subtasks = ids(&in_order(&below[at], nodes, &method.subtasks));
        let arguments = arguments(node, names)?;
        let _ = writeln!(out, "{at} {}{arguments} -> {}{subtasks}", task.name, method.name);
    }
    out.push_str("<==\n");
    Some(out)
}

fn arguments(node: &Node, names: &Names) -> Option<String> {
    let mut out = String::new();
    for argument in &node.arguments {
        out.push(' ');
        out.push_str(names.objects.get(argument.as_str())?);
    }
    Some(out)
}

fn ids(nodes: &[usize]) -> String {
    nodes.iter().map(|id| format!(" {id}")).collect()
}

/// Returns nodes in the order in which their method lists its subtasks; they were taken up in another one where it leaves that
/// open.
fn in_order(taken_up: &[usize], nodes: &[Node], listed: &[String]) -> Vec<usize> {
    let mut left: Vec<usize> = taken_up.to_vec();
    let mut found = Vec::with_capacity(left.len());
    for task in listed {
        if let Some(at) = left.iter().position(|id| nodes[*id].task == *task) {
            found.push(left.remove(at));
        }
    }
    found.extend(left);
    found
}
