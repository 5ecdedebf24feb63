//! From the engine's plan to the plan document: links, streams and the earliest schedule.
//!
//! Starts are the longest paths over links and streams: one action at a time per agent (thesis 4.3.2).

use indexmap::IndexMap;

use super::links::links;
use super::names::Names;
use super::outcome::{Found, NONE};
use super::reasoner::GasRef;
use crate::ir::{ActionId, Domain, EntityId, Goal, TaskId, Value};
use crate::plan::{Action, CostPart, Geometry, Node, Plan, VERSION};

/// Returns the document of a found plan; `geometry` tells the choices and motions of a projection.
pub fn document(
    found: &Found,
    domain: &Domain,
    goal: &Goal,
    seed: u64,
    geometry: &dyn Fn(GasRef) -> Option<Geometry>,
) -> Plan {
    let mut plan = schedule(found, domain, goal, seed, geometry);
    plan.decomposition = decomposition(found, domain, &mut Names::new(domain));
    plan
}

/// As [`document`], with an empty decomposition: for who shows the actions alone. Of a long plan it is a
/// quarter of all memory.
pub fn schedule(
    found: &Found,
    domain: &Domain,
    goal: &Goal,
    seed: u64,
    geometry: &dyn Fn(GasRef) -> Option<Geometry>,
) -> Plan {
    let mut names = Names::new(domain);
    let changed = found.changed(domain);
    let links = links(found, &changed, domain, &mut names);
    let mut streams: IndexMap<EntityId, Vec<usize>> = IndexMap::new();
    let mut free_at: Vec<f64> = vec![0.0; domain.entities.len()];
    let mut ready_at: Vec<f64> = vec![0.0; found.steps.len()];
    let mut next_link = 0;
    let mut acting = Vec::new();
    let mut actions: Vec<Action> = Vec::with_capacity(found.steps.len());
    for (index, step) in found.steps.iter().enumerate() {
        list_agents(domain, step.action, found.args(domain, step), &mut acting);
        let start = acting
            .iter()
            .map(|a| free_at[a.index()])
            .fold(ready_at[index], f64::max);
        let charge = found.charge(step);
        let end = start + charge.duration.0;
        for agent in &acting {
            free_at[agent.index()] = end;
            streams.entry(*agent).or_default().push(index);
        }
        // Links are sorted by the action that comes first.
        while let Some(link) = links.get(next_link).filter(|l| l.before == index) {
            ready_at[link.after] = ready_at[link.after].max(end);
            next_link += 1;
        }
        let changes = changed.by(index);
        actions.push(Action {
            index,
            name: names.task(TaskId::Action(step.action)),
            arguments: names.values(found.args(domain, step)),
            agents: acting.iter().map(|a| names.value(&Value::Entity(*a))).collect(),
            cost: charge.cost,
            duration: [charge.duration.0, charge.duration.1],
            start,
            end,
            geometry: charge.gas.and_then(geometry).map(Box::new),
            changes: changes
                .map(|(slot, value)| (names.slot(slot), names.value(value)))
                .collect(),
        });
    }
    Plan {
        format: "sgap-plan".into(),
        version: VERSION,
        task: domain.show_task(goal.task, &goal.args),
        seed,
        cost: found.cost,
        cost_parts: cost_parts(found, domain),
        makespan: actions.iter().map(|a| a.end).fold(0.0, f64::max),
        interleaved: found.interleaved,
        actions,
        streams: streams
            .into_iter()
            .map(|(agent, stream)| (domain.entities[agent.index()].name.clone(), stream))
            .collect(),
        links,
        decomposition: Vec::new(),
    }
}

/// Returns what the plan's cost consists of; nothing where it is the sum of the actions' costs.
fn cost_parts(found: &Found, domain: &Domain) -> Vec<CostPart> {
    let formula = domain.settings.cost;
    let own = [("sum", formula.sum), ("makespan", formula.makespan)];
    let own = own.into_iter().map(|(name, weight)| (name, name, weight));
    let rules = domain.social.iter().map(|r| (r.name.as_str(), r.kind.word(), r.weight));
    let parts = own.chain(rules).zip(&found.amounts);
    // What the formula leaves out is no part; a rule is, whatever its weight.
    let is_part = |kind: &str, weight: f64| weight != 0.0 || !["sum", "makespan"].contains(&kind);
    parts
        .filter(|((_, kind, weight), _)| is_part(kind, *weight))
        .map(|((name, kind, weight), amount)| CostPart {
            name: name.to_owned(),
            kind: kind.to_owned(),
            amount: *amount,
            weight,
            cost: weight * amount,
        })
        .collect()
}

/// Returns the agents of an action, each once, the acting one first.
pub(super) fn agents_of(domain: &Domain, action: ActionId, args: &[Value]) -> Vec<EntityId> {
    let mut agents = Vec::new();
    list_agents(domain, action, args, &mut agents);
    agents
}

fn list_agents(domain: &Domain, action: ActionId, args: &[Value], agents: &mut Vec<EntityId>) {
    agents.clear();
    let mut add = |agent| {
        if !agents.contains(&agent) {
            agents.push(agent);
        }
    };
    for position in &domain.actions[action.index()].agents {
        match &args[*position] {
            Value::Entity(e) => add(*e),
            Value::Set(set) => set.iter().for_each(&mut add),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Scalars(_) | Value::Unknown => {
            }
        }
    }
}

/// Returns the tree's nodes, in their order.
fn decomposition(found: &Found, domain: &Domain, names: &mut Names<'_>) -> Vec<Node> {
    let nodes = &found.tree.nodes;
    let mut action_of = vec![NONE; nodes.len()];
    for (index, step) in found.steps.iter().enumerate() {
        action_of[step.node as usize] = index as u32;
    }
    let known = |x: u32| Some(x as usize).filter(|_| x != NONE);
    let node = |i: usize| Node {
        task: names.task(nodes[i].task()),
        arguments: names.values(found.tree.args(domain, i as u32)),
        parent: known(nodes[i].parent),
        decomposition: known(found.tree.decomposition(i as u32)),
        action: known(action_of[i]),
    };
    (0..nodes.len()).map(node).collect()
}
