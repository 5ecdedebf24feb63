//! From the engine's plan to the plan document: causal links, streams and the earliest schedule.
//!
//! Links are the transitive reduction of four relations: an action needs an attribute that an earlier one set; an action
//! overwrites what an earlier one read or set; the domain orders their subtasks; motions are planned one after the other.
//! Starts are the longest paths over links and streams: one action at a time per agent (thesis 4.3.2).

use indexmap::IndexMap;
use std::collections::BTreeMap;

use super::explain::slot_name;
use super::outcome::{Found, Tree};
use super::reasoner::GasRef;
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
    let links = reduce(&dependencies(found, domain), &ordered_before(found, domain));
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
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Scalars(_) => Vec::new(),
        };
        for agent in members {
            if !agents.contains(&agent) {
                agents.push(agent);
            }
        }
    }
    agents
}

/// Reasons by (before, after), but for the domain's order.
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
    all
}

/// A set of steps, one bit each.
#[derive(Debug, Clone)]
struct Steps(Vec<u64>);

impl Steps {
    fn none(n: usize) -> Self {
        Steps(vec![0; n.div_ceil(64)])
    }

    fn insert(&mut self, step: usize) {
        self.0[step / 64] |= 1 << (step % 64);
    }

    fn contains(&self, step: usize) -> bool {
        self.0[step / 64] >> (step % 64) & 1 == 1
    }

    fn extend(&mut self, more: &Steps) {
        for (word, more) in self.0.iter_mut().zip(&more.0) {
            *word |= more;
        }
    }

    /// Returns the latest step that is not in `others`.
    fn last_outside(&self, others: &Steps) -> Option<usize> {
        let words = self.0.iter().zip(&others.0).enumerate().rev();
        words
            .map(|(i, (word, other))| (i, word & !other))
            .find(|(_, rest)| *rest != 0)
            .map(|(i, rest)| 64 * i + 63 - rest.leading_zeros() as usize)
    }
}

/// Returns for each step the steps that the domain orders before it: their ancestors are ordered subtasks of one
/// decomposition.
///
/// The pairs of a long chain are too many to be listed; a node has what its parent has and what its own order adds.
fn ordered_before(found: &Found, domain: &Domain) -> Vec<Steps> {
    let (Tree(nodes), n) = (&found.tree, found.steps.len());
    // One past the last node of each subtree: nodes stand after their parents.
    let mut end: Vec<usize> = (1..=nodes.len()).collect();
    for i in (0..nodes.len()).rev() {
        if let Some(parent) = nodes[i].parent {
            end[parent] = end[parent].max(end[i]);
        }
    }
    // Steps stand in the order of their leaves.
    let first_step = |node: usize| found.steps.partition_point(|step| step.node < node);
    let mut node_of: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let mut before: Vec<Steps> = Vec::with_capacity(nodes.len());
    for (i, node) in nodes.iter().enumerate() {
        let mut own = Steps::none(n);
        if let Some(parent) = node.parent {
            own.extend(&before[parent]);
            node_of.insert((parent, node.subtask), i);
            if let (TaskId::Method(method), Some(decomposition)) = (nodes[parent].task, nodes[parent].decomposition) {
                let subtasks = &domain.methods[method.index()].decompositions[decomposition].subtasks;
                for sibling in subtasks[node.subtask]
                    .after
                    .iter()
                    .filter_map(|s| node_of.get(&(parent, *s)))
                {
                    // What comes before a subtask that needs no action comes before its successors all the same.
                    own.extend(&before[*sibling]);
                    (first_step(*sibling)..first_step(end[*sibling])).for_each(|step| own.insert(step));
                }
            }
        }
        before.push(own);
    }
    found.steps.iter().map(|step| before[step.node].clone()).collect()
}

/// Keeps the links that no chain of others implies, with their reasons.
fn reduce(dependencies: &Dependencies, ordered: &[Steps]) -> Vec<Link> {
    let n = ordered.len();
    let mut direct = ordered.to_vec();
    for (before, after) in dependencies.keys() {
        direct[*after].insert(*before);
    }
    let mut ancestors: Vec<Steps> = Vec::with_capacity(n);
    let mut links = Vec::new();
    for (after, direct) in direct.iter().enumerate() {
        let mut known = Steps::none(n);
        // Latest first: an earlier one that is an ancestor of a later one is implied.
        while let Some(before) = direct.last_outside(&known) {
            known.insert(before);
            known.extend(&ancestors[before]);
            let mut reasons = dependencies.get(&(before, after)).cloned().unwrap_or_default();
            if ordered[after].contains(before) {
                reasons.push(LinkReason::Order);
            }
            links.push(Link { before, after, reasons });
        }
        ancestors.push(known);
    }
    links.sort_by_key(|link| (link.before, link.after));
    links
}

/// Returns the tree's nodes, in their order.
fn decomposition(found: &Found, domain: &Domain) -> Vec<Node> {
    let Tree(nodes) = &found.tree;
    let mut action_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (index, step) in found.steps.iter().enumerate() {
        action_of.insert(step.node, index);
    }
    nodes
        .iter()
        .enumerate()
        .map(|(i, n)| Node {
            task: domain.task_name(n.task).to_owned(),
            arguments: show_all(domain, &n.args),
            parent: n.parent,
            decomposition: n.decomposition,
            action: action_of.get(&i).copied(),
        })
        .collect()
}
