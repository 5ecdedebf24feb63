//! From the engine's plan to the plan document: causal links, streams and the earliest schedule.
//!
//! Links are the transitive reduction of four relations: an action needs an attribute that an earlier one set; an action
//! overwrites what an earlier one read or set; the domain orders their subtasks; motions are planned one after the other.
//! Starts are the longest paths over links and streams: one action at a time per agent (thesis 4.3.2).

use indexmap::IndexMap;
use std::collections::{BTreeMap, BTreeSet};

use super::explain::slot_name;
use super::reasoner::GasRef;
use super::search::{Found, Tree};
use crate::ir::{Domain, EntityId, Goal, SlotId, TaskId, Value};
use crate::plan::{Action, Geometry, Link, LinkReason, Node, Plan, VERSION};

/// Returns the document of a found plan; `geometry` tells the choices and motions of a projection.
pub fn document(
    found: &Found,
    domain: &Domain,
    goal: &Goal,
    seed: u64,
    geometry: &dyn Fn(GasRef) -> Option<Geometry>,
) -> Plan {
    let links = reduce(found.steps.len(), dependencies(found, domain));
    let agents: Vec<Vec<EntityId>> = (0..found.steps.len()).map(|i| agents(found, domain, i)).collect();
    let mut streams: IndexMap<String, Vec<usize>> = IndexMap::new();
    let mut free_at: BTreeMap<EntityId, f64> = BTreeMap::new();
    let mut actions: Vec<Action> = Vec::with_capacity(found.steps.len());
    let mut links_of = vec![Vec::new(); found.steps.len()];
    for link in &links {
        links_of[link.after].push(link.before);
    }
    for (index, step) in found.steps.iter().enumerate() {
        let busy = agents[index].iter().map(|a| free_at.get(a).copied().unwrap_or(0.0));
        let linked = links_of[index].iter().map(|before| actions[*before].end);
        let start = busy.chain(linked).fold(0.0, f64::max);
        let end = start + step.duration.0;
        for agent in &agents[index] {
            free_at.insert(*agent, end);
            streams
                .entry(domain.entities[agent.index()].name.clone())
                .or_default()
                .push(index);
        }
        let changes = found.changes[index]
            .iter()
            .map(|(slot, v)| (slot_name(domain, *slot), domain.show(v)))
            .collect();
        actions.push(Action {
            index,
            name: domain.actions[step.action.index()].name.clone(),
            arguments: show_all(domain, &step.args),
            agents: agents[index]
                .iter()
                .map(|a| domain.entities[a.index()].name.clone())
                .collect(),
            cost: step.cost,
            duration: [step.duration.0, step.duration.1],
            start,
            end,
            geometry: step.gas.and_then(geometry),
            changes,
        });
    }
    let task = format!(
        "{}({})",
        domain.task_name(goal.task),
        show_all(domain, &goal.args).join(", ")
    );
    Plan {
        format: "sgap-plan".into(),
        version: VERSION,
        task,
        seed,
        cost: found.cost,
        makespan: actions.iter().map(|a| a.end).fold(0.0, f64::max),
        actions,
        streams,
        links,
        decomposition: decomposition(found, domain),
    }
}

fn show_all(domain: &Domain, values: &[Value]) -> Vec<String> {
    values.iter().map(|v| domain.show(v)).collect()
}

/// Returns the agents of a step, each once, the acting one first.
fn agents(found: &Found, domain: &Domain, index: usize) -> Vec<EntityId> {
    let step = &found.steps[index];
    let mut agents = Vec::new();
    for position in &domain.actions[step.action.index()].agents {
        let members: Vec<EntityId> = match &step.args[*position] {
            Value::Entity(e) => vec![*e],
            Value::Set(set) => set.iter().collect(),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => Vec::new(),
        };
        for agent in members {
            if !agents.contains(&agent) {
                agents.push(agent);
            }
        }
    }
    agents
}

/// Reasons by (before, after).
type Dependencies = BTreeMap<(usize, usize), Vec<LinkReason>>;

fn dependencies(found: &Found, domain: &Domain) -> Dependencies {
    let mut all = Dependencies::new();
    let mut add = |before: usize, after: usize, reason: LinkReason| {
        let reasons = all.entry((before, after)).or_default();
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    };
    let mut last_writer: BTreeMap<SlotId, usize> = BTreeMap::new();
    let mut readers: BTreeMap<SlotId, Vec<usize>> = BTreeMap::new();
    let mut last_motion = None;
    for (index, step) in found.steps.iter().enumerate() {
        for slot in &step.reads {
            if let Some(writer) = last_writer.get(slot) {
                add(*writer, index, LinkReason::Attribute(slot_name(domain, *slot)));
            }
        }
        let mut writes = step.writes.clone();
        writes.extend(found.changes[index].iter().map(|(slot, _)| *slot));
        writes.sort();
        writes.dedup();
        for slot in writes {
            for reader in readers.remove(&slot).unwrap_or_default() {
                add(reader, index, LinkReason::Threat(slot_name(domain, slot)));
            }
            if let Some(writer) = last_writer.insert(slot, index) {
                add(writer, index, LinkReason::Threat(slot_name(domain, slot)));
            }
        }
        for slot in &step.reads {
            if last_writer.get(slot) != Some(&index) {
                readers.entry(*slot).or_default().push(index);
            }
        }
        if step.gas.is_some()
            && let Some(before) = last_motion.replace(index)
        {
            add(before, index, LinkReason::Motion);
        }
    }
    for (before, after) in ordered_leaves(found, domain) {
        add(before, after, LinkReason::Order);
    }
    all
}

/// Returns the pairs of steps that the domain orders: their ancestors are ordered subtasks of one decomposition.
fn ordered_leaves(found: &Found, domain: &Domain) -> Vec<(usize, usize)> {
    let nodes = &found.tree.0;
    // Steps under each child of each node, in order of execution.
    let mut under: BTreeMap<usize, BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
    for (index, step) in found.steps.iter().enumerate() {
        let mut node = step.node;
        while let Some(parent) = nodes[node].parent {
            under
                .entry(parent)
                .or_default()
                .entry(nodes[node].subtask)
                .or_default()
                .push(index);
            node = parent;
        }
    }
    let mut pairs = Vec::new();
    for (node, by_subtask) in under {
        let (TaskId::Method(method), Some(decomposition)) = (nodes[node].task, nodes[node].decomposition) else {
            continue;
        };
        let subtasks = &domain.methods[method.index()].decompositions[decomposition].subtasks;
        // What comes before a subtask that needs no action comes before its successors all the same.
        let all_before = |subtask: usize| {
            let (mut found, mut open) = (BTreeSet::new(), subtasks[subtask].after.clone());
            while let Some(before) = open.pop() {
                if found.insert(before) {
                    open.extend(&subtasks[before].after);
                }
            }
            found
        };
        for (after, steps_after) in &by_subtask {
            for before in &all_before(*after) {
                let steps_before = by_subtask.get(before).map_or(&[][..], Vec::as_slice);
                pairs.extend(
                    steps_before
                        .iter()
                        .flat_map(|b| steps_after.iter().map(move |a| (*b, *a))),
                );
            }
        }
    }
    pairs
}

/// Keeps the links that no chain of others implies.
fn reduce(n: usize, all: Dependencies) -> Vec<Link> {
    let mut before: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (b, a) in all.keys() {
        before[*a].push(*b);
    }
    let words = n.div_ceil(64);
    let mut ancestors: Vec<Vec<u64>> = Vec::with_capacity(n);
    let mut keep = Vec::new();
    for (after, direct) in before.iter_mut().enumerate() {
        let mut known = vec![0u64; words];
        // Latest first: an earlier one that is an ancestor of a later one is implied.
        direct.sort_by_key(|b| std::cmp::Reverse(*b));
        for b in direct.iter() {
            if known[b / 64] >> (b % 64) & 1 == 0 {
                keep.push((*b, after));
            }
            known[b / 64] |= 1 << (b % 64);
            for (word, more) in known.iter_mut().zip(&ancestors[*b]) {
                *word |= more;
            }
        }
        ancestors.push(known);
    }
    keep.sort();
    keep.into_iter()
        .map(|(before, after)| Link {
            before,
            after,
            reasons: all.get(&(before, after)).cloned().unwrap_or_default(),
        })
        .collect()
}

/// Returns the tree with children in the order of execution. Bottom up: nodes come after their parents in the arena.
fn decomposition(found: &Found, domain: &Domain) -> Node {
    let Tree(nodes) = &found.tree;
    let mut action_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (index, step) in found.steps.iter().enumerate() {
        action_of.insert(step.node, index);
    }
    let mut built: Vec<Option<Node>> = nodes
        .iter()
        .enumerate()
        .map(|(i, n)| {
            Some(Node {
                task: domain.task_name(n.task).to_owned(),
                arguments: show_all(domain, &n.args),
                decomposition: n.decomposition,
                action: action_of.get(&i).copied(),
                children: Vec::new(),
            })
        })
        .collect();
    for i in (1..nodes.len()).rev() {
        let child = built[i].take();
        if let (Some(child), Some(parent)) = (child, nodes[i].parent)
            && let Some(parent) = &mut built[parent]
        {
            parent.children.insert(0, child);
        }
    }
    built[0].take().unwrap_or(Node {
        task: String::new(),
        arguments: Vec::new(),
        decomposition: None,
        action: None,
        children: Vec::new(),
    })
}
