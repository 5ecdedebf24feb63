//! A second opinion on a plan: replays it from the start and names the first thing that is wrong.
//!
//! Reads the compiled domain, the world and the plan document, and nothing of how the plan was made: no engine, no action
//! solver, no motion planner. Evaluation of tests, facts, inverse kinematics and every rule about plans are written a
//! second time here; forward kinematics and the exact tests of two shapes (`geom::kinematics`, `geom::collide`) are the
//! only geometry in common, and have tests of their own against other tools.
//!
//! Checked in this order: document, then action by action symbols and motions, then the decomposition, then links and
//! times, then the plan's cost. Does not judge whether a plan is good: costs are added up, the parts that geometry computed are believed.
//! `docs/validate.md` lists the codes and the tolerances.

mod bases;
mod beliefs;
mod bodies;
mod decomposition;
mod evaluate;
mod facts;
mod fault;
mod geometric;
mod handling;
mod history;
mod motion;
mod navigation;
mod network;
mod notation;
mod objective;
mod ordered;
mod places;
mod precedence;
mod reach;
mod replay;
mod requests;
mod schedule;
mod sets;
mod shared;

pub use fault::{Fault, Kind, Place};

use std::fmt;

use crate::ir;
use crate::plan::{Plan, VERSION};
use crate::world::World;
use decomposition::Replayed;
use fault::Checked;

/// How finely to look.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Longest change of any joint between two configurations that are looked at [rad or m].
    pub step: f64,
    /// Overlap of two bodies that is still no collision [m].
    pub tolerance: f64,
    /// Rounding allowed in times and costs [s, or cost].
    pub time_tolerance: f64,
    /// Configurations looked at before a plan is refused as too long.
    pub max_configurations: u64,
    /// Choices of a decomposition's variables tried for one task.
    pub max_bindings: usize,
    /// Actions tried to count one undesirable sequence.
    pub max_tries: u64,
    /// Restarts of the inverse kinematics before a claimed reachability counts as unconfirmed.
    pub reach_restarts: usize,
    /// Restarts spent on contradicting a denied reachability, and the share of them that must succeed.
    pub contradiction_restarts: usize,
    pub contradiction_share: f64,
    /// Clearance that such a success must have [m].
    pub reach_margin: f64,
    /// Share of an object's surface that must be seen for it to be visible, and how near to it is too near to call.
    pub visible_share: f64,
    pub visible_margin: f64,
}

impl Settings {
    /// The settings of the command line: half of the planner's resolution.
    pub const STANDARD: Settings = Settings {
        step: 0.005,
        tolerance: 1e-3,
        time_tolerance: 1e-6,
        max_configurations: 2_000_000,
        max_bindings: 100_000,
        max_tries: 20_000_000,
        reach_restarts: 1000,
        contradiction_restarts: 24,
        contradiction_share: 0.25,
        reach_margin: 0.005,
        visible_share: 0.3,
        visible_margin: 0.1,
    };
}

/// How much was checked in a plan that is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Verdict {
    pub actions: usize,
    /// Nodes of the decomposition tree.
    pub tasks: usize,
    pub trajectories: usize,
    pub configurations: u64,
    /// Pairs of bodies looked at.
    pub pairs: u64,
    /// Objects taken or let go.
    pub attachments: usize,
    /// Geometric facts compared.
    pub facts: usize,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} actions, {} tasks, {} trajectories, {} configurations, {} pairs of bodies, {} grips, {} facts",
            self.actions, self.tasks, self.trajectories, self.configurations, self.pairs, self.attachments, self.facts
        )
    }
}

/// Replays the plan and returns how much was checked.
///
/// # Errors
/// The first fault, in the order of the module's head comment.
pub fn replay(
    plan: &Plan,
    domain: &ir::Domain,
    goal: &ir::Goal,
    world: &World,
    settings: &Settings,
) -> Result<Verdict, Fault> {
    let actions = document(plan, domain, goal)?;
    let mut verdict = Verdict::default();
    let bodies = bodies::Bodies::new(&world.scene);
    let replayed = replay::run(plan, domain, world, &bodies, settings, &actions, &mut verdict)?;
    let links = schedule::by_links(plan);
    let unordered = decomposition::check(
        &Replayed {
            domain,
            states: &replayed.states,
            worlds: &replayed.worlds,
            actions: &actions,
            interleaved: plan.interleaved,
            links: links.as_deref(),
            settings,
        },
        &plan.decomposition,
        goal,
    )?;
    verdict.tasks = plan.decomposition.len();
    let (first, last) = (replayed.states.state(0), replayed.states.state(actions.len()));
    schedule::check(
        plan,
        domain,
        settings,
        &replayed.done,
        &replayed.worlds,
        (&first, &last),
    )?;
    if let Some(fault) = unordered {
        return Err(fault);
    }
    objective::check(plan, domain, &actions, &replayed.states, settings)?;
    Ok(verdict)
}

/// Says whether the first `n` actions of an earlier plan can still be done in this world with the motions that they have,
/// and returns them. For a plan that begins with them (`engine::repair`).
///
/// Checked as in a replay are the document, the motions and what they touch, and constraints. What changes with the domain is
/// not held against the plan: its preconditions, costs and times, and the attributes that it says to change.
///
/// # Errors
/// The first fault.
pub fn prefix(
    plan: &Plan,
    n: usize,
    domain: &ir::Domain,
    world: &World,
    settings: &Settings,
) -> Result<Vec<ir::Goal>, Fault> {
    form(plan)?;
    let kept = plan.actions.get(..n).unwrap_or(&plan.actions);
    let actions = actions(kept, domain)?;
    let bodies = bodies::Bodies::new(&world.scene);
    replay::play(kept, domain, world, &bodies, settings, &actions)?;
    Ok(actions)
}

/// Checks that the document is one of ours.
fn form(plan: &Plan) -> Checked<()> {
    if plan.format != "sgap-plan" {
        return Err(Kind::Format {
            found: plan.format.clone(),
        }
        .into());
    }
    if plan.version != VERSION {
        return Err(Kind::Version {
            found: plan.version,
            known: VERSION,
        }
        .into());
    }
    Ok(())
}

fn finite(what: &str, numbers: &[f64]) -> Checked<()> {
    match numbers.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => Err(Kind::NotFinite { what: what.to_owned() }.into()),
    }
}

/// Checks names, types and numbers, and returns the actions with their arguments.
fn document(plan: &Plan, domain: &ir::Domain, goal: &ir::Goal) -> Checked<Vec<ir::Goal>> {
    form(plan)?;
    finite("the plan's cost or makespan", &[plan.cost, plan.makespan])?;
    for part in &plan.cost_parts {
        finite("a part of the plan's cost", &[part.amount, part.weight, part.cost])?;
    }
    if !network::is_goal(domain, &plan.task, goal)? {
        return Err(Kind::Task {
            expected: notation::show_task(domain, goal.task, &goal.args),
            found: plan.task.clone(),
        }
        .into());
    }
    actions(&plan.actions, domain)
}

/// Checks names, types and numbers of actions, and returns them with their arguments.
fn actions(written: &[crate::plan::Action], domain: &ir::Domain) -> Checked<Vec<ir::Goal>> {
    let mut actions = Vec::with_capacity(written.len());
    for (position, action) in written.iter().enumerate() {
        let text = format!("{}({})", action.name, action.arguments.join(", "));
        let goal = (|| {
            if action.index != position {
                return Err(Kind::Index {
                    position,
                    index: action.index,
                }
                .into());
            }
            let [least, most] = action.duration;
            finite(
                "cost, duration, start or end",
                &[action.cost, least, most, action.start, action.end],
            )?;
            if let Some(geometry) = &action.geometry {
                geometry_numbers(geometry)?;
            }
            let goal = notation::task(domain, &action.name, &action.arguments)?;
            let ir::TaskId::Action(id) = goal.task else {
                return Err(Kind::UnknownName {
                    what: "action",
                    name: action.name.to_string(),
                }
                .into());
            };
            agents(domain, &domain.actions[id.index()], &goal, &action.agents)?;
            Ok(goal)
        })();
        actions.push(goal.map_err(|f: Fault| f.in_action(position, &text))?);
    }
    Ok(actions)
}

fn geometry_numbers(geometry: &crate::plan::Geometry) -> Checked<()> {
    let parts: Vec<f64> = geometry.cost_parts.values().copied().collect();
    finite("a part of the geometric cost", &parts)?;
    let pose = |what: &str, pose: &crate::plan::PoseDocument| {
        finite(what, &pose.position)?;
        finite(what, &pose.quaternion)?;
        let norm: f64 = pose.quaternion.iter().map(|x| x * x).sum();
        if (norm - 1.0).abs() > 1e-6 {
            return Err(Fault::from(Kind::Quaternion {
                what: what.to_owned(),
                length: norm.sqrt(),
            }));
        }
        Ok(())
    };
    if let Some(placement) = &geometry.placement {
        finite("a number of the placement", &[placement.x, placement.y, placement.yaw])?;
        pose("the placement's pose", &placement.pose)?;
    }
    for sub_action in &geometry.sub_actions {
        match &sub_action.change {
            Some(crate::plan::AttachmentChange::Attach { object_in_tool, .. }) => {
                pose("the pose of the object in the tool", object_in_tool)?;
            }
            Some(crate::plan::AttachmentChange::Detach { object_in_world, .. }) => {
                pose("the pose of the object in the world", object_in_world)?;
            }
            None => {}
        }
    }
    Ok(())
}

/// Checks who takes part: the arguments of type Agent, each once.
fn agents(domain: &ir::Domain, action: &ir::Action, goal: &ir::Goal, found: &[crate::plan::Text]) -> Checked<()> {
    let mut expected: Vec<&str> = Vec::new();
    for position in &action.agents {
        let members: Vec<ir::EntityId> = match goal.args.get(*position) {
            Some(ir::Value::Entity(e)) => vec![*e],
            Some(ir::Value::Set(s)) => s.iter().collect(),
            _ => Vec::new(),
        };
        for e in members {
            let name = domain.entities[e.index()].name.as_str();
            if !expected.contains(&name) {
                expected.push(name);
            }
        }
    }
    if !expected.iter().copied().eq(found.iter().map(|name| &**name)) {
        return Err(Kind::Agents {
            expected: format!("[{}]", expected.join(", ")),
            found: format!("[{}]", found.join(", ")),
        }
        .into());
    }
    Ok(())
}
