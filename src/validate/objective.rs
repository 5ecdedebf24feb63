//! Computes what a plan costs where that is more than its actions' costs, from actions, states, links and times.
//!
//! Everything is counted over the whole plan, as decision 18 says it and not as the planner does it: states from the replay,
//! sequences by trying actions from the last pattern back, waits and links from the schedule, which is checked before.

use super::{
    Settings,
    evaluate::View,
    fault::{Checked, Kind},
    history::History,
    sets,
};
use crate::ir::{Base, Domain, Effort, EntityId, Goal, Param, Pattern, PatternArg, RuleKind, TaskId, TypeId, Value};
use crate::plan::{CostPart, Plan, Text};

/// Checks the plan's cost and its parts; `states` are those before each action, and the last one.
pub(super) fn check(
    plan: &Plan,
    domain: &Domain,
    actions: &[Goal],
    states: &History,
    settings: &Settings,
) -> Checked<()> {
    let differ = |a: f64, b: f64| (a - b).abs() > settings.time_tolerance * a.abs().max(1.0);
    let sum: f64 = plan.actions.iter().map(|a| a.cost).sum();
    let formula = domain.settings.cost;
    let is_plain = domain.social.is_empty() && formula.sum == 1.0 && formula.makespan == 0.0;
    if is_plain && differ(sum, plan.cost) {
        return Err(Kind::CostTotal {
            expected: sum,
            found: plan.cost,
        }
        .into());
    }
    let mut expected: Vec<CostPart> = Vec::new();
    let mut add = |name: &str, kind: &str, amount: f64, weight: f64| {
        expected.push(CostPart {
            name: name.to_owned(),
            kind: kind.to_owned(),
            amount,
            weight,
            cost: weight * amount,
        });
    };
    if !is_plain {
        for (name, amount, weight) in [("sum", sum, formula.sum), ("makespan", plan.makespan, formula.makespan)] {
            if weight != 0.0 {
                add(name, name, amount, weight);
            }
        }
        let counter = Counter {
            plan,
            domain,
            settings,
            actions,
            states,
            agents: plan.actions.iter().map(|a| agents_of(domain, &a.agents)).collect(),
        };
        for rule in &domain.social {
            let amount = counter.amount(&rule.name, &rule.kind)?;
            add(&rule.name, rule.kind.word(), amount, rule.weight);
        }
    }
    let names = |parts: &[CostPart]| {
        let all: Vec<String> = parts.iter().map(|p| format!("{} ({})", p.name, p.kind)).collect();
        format!("[{}]", all.join(", "))
    };
    let (wanted, found) = (names(&expected), names(&plan.cost_parts));
    if wanted != found {
        return Err(Kind::CostParts {
            expected: wanted,
            found,
        }
        .into());
    }
    for (wanted, found) in expected.iter().zip(&plan.cost_parts) {
        let numbers = [
            ("amount", wanted.amount, found.amount),
            ("weight", wanted.weight, found.weight),
            ("cost", wanted.cost, found.cost),
        ];
        if let Some((what, expected, found)) = numbers.into_iter().find(|(_, a, b)| differ(*a, *b)) {
            return Err(Kind::CostPart {
                part: wanted.name.clone(),
                what,
                expected,
                found,
            }
            .into());
        }
    }
    let whole: f64 = expected.iter().map(|p| p.cost).sum();
    if !is_plain && differ(whole, plan.cost) {
        return Err(Kind::CostWhole {
            expected: whole,
            found: plan.cost,
        }
        .into());
    }
    Ok(())
}

fn agents_of(domain: &Domain, names: &[Text]) -> Vec<EntityId> {
    names.iter().filter_map(|name| domain.entity(name)).collect()
}

struct Counter<'a> {
    plan: &'a Plan,
    domain: &'a Domain,
    settings: &'a Settings,
    actions: &'a [Goal],
    states: &'a History,
    /// Of each action.
    agents: Vec<Vec<EntityId>>,
}

impl Counter<'_> {
    fn amount(&self, name: &str, kind: &RuleKind) -> Checked<f64> {
        Ok(match kind {
            RuleKind::State { params, n_vars, test } => self.entered(params, *n_vars, &|view, frame| {
                let mut frame = frame.to_vec();
                view.holds(test, &mut frame)
            }),
            RuleKind::Sequence { vars, patterns } => self.sequences(name, vars, patterns)?,
            RuleKind::EffortBalance { effort, agents } => self.imbalance(*effort, agents),
            RuleKind::WastedTime { agents } => agents.iter().map(|a| self.wasted(*a)).sum(),
            RuleKind::IntricateLinks { agents } => self.links(agents),
        })
    }

    /// Counts, for every choice of the parameters, the actions after which the test holds and before which it does not.
    fn entered(&self, params: &[TypeId], n_vars: usize, holds: &dyn Fn(View<'_>, &[Value]) -> bool) -> f64 {
        let mut frames = vec![Vec::new()];
        for ty in params {
            let entities = &self.domain.types[ty.index()].entities;
            let longer = |frame: &Vec<Value>| {
                let frame = frame.clone();
                entities
                    .iter()
                    .map(move |e| [frame.as_slice(), &[Value::Entity(*e)]].concat())
            };
            frames = frames.iter().flat_map(longer).collect();
        }
        let mut n = 0_u64;
        for mut frame in frames {
            frame.resize(n_vars.max(frame.len()), Value::Null);
            let states = (0..=self.actions.len()).map(|at| View::past(self.domain, (self.states, at), None));
            let held: Vec<bool> = states.map(|view| holds(view, &frame)).collect();
            n += held.windows(2).filter(|pair| !pair[0] && pair[1]).count() as u64;
        }
        n as f64
    }

    /// Counts the actions that end a sequence.
    fn sequences(&self, name: &str, vars: &[Param], patterns: &[Pattern]) -> Checked<f64> {
        let mut tries = self.settings.max_tries;
        let mut n = 0_u64;
        for end in 0..self.actions.len() {
            let unbound = vec![None; vars.len()];
            match self.ends_at(end, vars, patterns, &unbound, &mut tries) {
                Some(true) => n += 1,
                Some(false) => {}
                None => {
                    return Err(Kind::SequenceUndecided {
                        rule: name.to_owned(),
                        budget: self.settings.max_tries,
                    }
                    .into());
                }
            }
        }
        Ok(n as f64)
    }

    /// Says whether the patterns can end with that action; `None` when there are no tries left.
    fn ends_at(
        &self,
        end: usize,
        vars: &[Param],
        patterns: &[Pattern],
        bound: &[Option<Value>],
        tries: &mut u64,
    ) -> Option<bool> {
        let Some((last, before)) = patterns.split_last() else {
            return Some(true);
        };
        *tries = tries.checked_sub(1)?;
        let Some(bound) = self.bind(end, vars, last, bound) else {
            return Some(false);
        };
        if before.is_empty() {
            return Some(true);
        }
        for earlier in (0..end).rev() {
            if last.is_immediate && !self.is_right_after(earlier, end) {
                continue;
            }
            if self.ends_at(earlier, vars, before, &bound, tries)? {
                return Some(true);
            }
        }
        Some(false)
    }

    /// Returns the variables with what the action gives them, if it is one that the pattern means.
    fn bind(
        &self,
        index: usize,
        vars: &[Param],
        pattern: &Pattern,
        bound: &[Option<Value>],
    ) -> Option<Vec<Option<Value>>> {
        let Goal { task, args } = &self.actions[index];
        if *task != TaskId::Action(pattern.action) {
            return None;
        }
        let mut out = bound.to_vec();
        for (wanted, arg) in pattern.args.iter().zip(args) {
            let is_same = match wanted {
                PatternArg::Any => true,
                PatternArg::Is(value) => sets::equal(value, arg),
                PatternArg::Var(var) => {
                    let is_same = out[*var].as_ref().is_none_or(|value| sets::equal(value, arg));
                    out[*var] = Some(arg.clone());
                    is_same && self.may_be(&vars[*var], arg)
                }
            };
            if !is_same {
                return None;
            }
        }
        Some(out)
    }

    fn may_be(&self, var: &Param, value: &Value) -> bool {
        let Base::Entity(ty) = var.base else { return true };
        let of_type = |e: &EntityId| self.domain.types[ty.index()].entities.contains(e);
        match value {
            Value::Entity(e) => of_type(e),
            Value::Set(set) => set.iter().all(|e| of_type(&e)),
            Value::Null | Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Scalars(_) => {
                true
            }
        }
    }

    /// Says whether no action between the two has an agent of one of them; those without agents share nobody.
    fn is_right_after(&self, earlier: usize, later: usize) -> bool {
        let (one, other) = (&self.agents[earlier], &self.agents[later]);
        let shares = |a: &[EntityId], b: &[EntityId]| a.is_empty() && b.is_empty() || a.iter().any(|e| b.contains(e));
        let mut between = self.agents[earlier + 1..later].iter();
        !between.any(|agents| shares(agents, one) || shares(agents, other))
    }

    fn imbalance(&self, effort: Effort, agents: &[EntityId]) -> f64 {
        let efforts: Vec<f64> = agents
            .iter()
            .map(|agent| {
                let own = self.plan.actions.iter().zip(&self.agents);
                let own = own.filter(|(_, agents)| agents.contains(agent));
                own.map(|(action, _)| match effort {
                    Effort::Cost => action.cost,
                    Effort::Duration => action.duration[0],
                })
                .sum()
            })
            .collect();
        let most = efforts.iter().copied().reduce(f64::max);
        let least = efforts.iter().copied().reduce(f64::min);
        most.zip(least).map_or(0.0, |(most, least)| most - least)
    }

    /// Returns the seconds between the end of an action of the agent and the start of its next.
    fn wasted(&self, agent: EntityId) -> f64 {
        let own = self.plan.actions.iter().zip(&self.agents);
        let own: Vec<(f64, f64)> = own
            .filter(|(_, agents)| agents.contains(&agent))
            .map(|(action, _)| (action.start, action.end))
            .collect();
        own.windows(2).map(|pair| pair[1].0 - pair[0].1).sum()
    }

    fn links(&self, among: &[EntityId]) -> f64 {
        let is_about = |agents: &[EntityId]| agents.iter().any(|a| among.contains(a));
        let links = self.plan.links.iter().filter(|link| {
            let (before, after) = (&self.agents[link.before], &self.agents[link.after]);
            is_about(before) && is_about(after) && !before.iter().any(|a| after.contains(a))
        });
        links.count() as f64
    }
}
