//! Undesirable sequences: how many actions end one.
//!
//! What has been done of a sequence is kept with the values of its variables, each once: so there are as many as there are
//! choices of values, however long the plan is. Where the next action has to come immediately, only what the agents' last
//! actions have left is looked at.

use rustc_hash::FxHashSet;

use crate::engine::hash::Print;
use crate::engine::sets;
use crate::ir::{ActionId, Base, Domain, EntityId, Param, PatternArg, RuleKind, Value};

/// Stands for whoever acts in an action without agents.
const NOBODY: usize = 0;

/// The sequences begun.
#[derive(Debug)]
pub(super) struct Sequences<'d> {
    domain: &'d Domain,
    rules: Vec<Rule<'d>>,
    /// Values of the variables of what was begun, one after the other.
    values: Vec<Option<Value>>,
    /// By rule and position: what waits for that pattern anywhere later, as where its values begin.
    waiting: Vec<Vec<Vec<u32>>>,
    known: FxHashSet<u128>,
    /// What has been added to `waiting`: rule, position, fingerprint.
    added: Vec<(u32, u32, u128)>,
    /// What waits for its next pattern at once: rule, position, where its values begin.
    fresh: Vec<(u32, u32, u32)>,
    /// By agent, behind `NOBODY`: the last step that it took part in.
    last: Vec<Option<u32>>,
    last_before: Vec<(usize, Option<u32>)>,
    steps: Vec<Mark>,
}

#[derive(Debug)]
struct Rule<'d> {
    number: u32,
    vars: &'d [Param],
    patterns: &'d [crate::ir::Pattern],
}

/// Where a step's own begins.
#[derive(Debug, Clone, Copy)]
struct Mark {
    values: u32,
    added: u32,
    fresh: u32,
    last_before: u32,
}

impl<'d> Sequences<'d> {
    pub fn new(domain: &'d Domain) -> Self {
        let mut rules = Vec::new();
        for (number, rule) in domain.social.iter().enumerate() {
            if let RuleKind::Sequence { vars, patterns } = &rule.kind {
                rules.push(Rule {
                    number: number as u32,
                    vars,
                    patterns,
                });
            }
        }
        Sequences {
            domain,
            waiting: rules.iter().map(|rule| vec![Vec::new(); rule.patterns.len()]).collect(),
            rules,
            values: Vec::new(),
            known: FxHashSet::default(),
            added: Vec::new(),
            fresh: Vec::new(),
            last: vec![None; domain.entities.len() + 1],
            last_before: Vec::new(),
            steps: Vec::new(),
        }
    }

    /// Adds a step; adds to `counted` the rules of which it ends a sequence.
    pub fn push(&mut self, action: ActionId, args: &[Value], agents: &[EntityId], counted: &mut Vec<u32>) {
        let this = self.steps.len() as u32;
        self.steps.push(Mark {
            values: self.values.len() as u32,
            added: self.added.len() as u32,
            fresh: self.fresh.len() as u32,
            last_before: self.last_before.len() as u32,
        });
        if self.rules.is_empty() {
            return;
        }
        let who = who(agents);
        let before = self.right_before(&who);
        for rule in 0..self.rules.len() {
            let mut ends = false;
            // The last pattern first, so that what this step begins is not taken for done before it.
            for position in (0..self.rules[rule].patterns.len()).rev() {
                if self.rules[rule].patterns[position].action == action {
                    ends |= self.advance(rule, position, args, &before);
                }
            }
            if ends {
                counted.push(self.rules[rule].number);
            }
        }
        for agent in who {
            self.last_before.push((agent, self.last[agent]));
            self.last[agent] = Some(this);
        }
    }

    /// Takes back the last step.
    pub fn pop(&mut self) {
        let Some(mark) = self.steps.pop() else { return };
        for (rule, position, print) in self.added.drain(mark.added as usize..) {
            self.waiting[rule as usize][position as usize].pop();
            self.known.remove(&print);
        }
        while self.last_before.len() > mark.last_before as usize {
            if let Some((agent, before)) = self.last_before.pop() {
                self.last[agent] = before;
            }
        }
        self.values.truncate(mark.values as usize);
        self.fresh.truncate(mark.fresh as usize);
    }

    /// Returns the steps after which one of `who` comes immediately: none of its agents nor of theirs has acted since.
    fn right_before(&self, who: &[usize]) -> Vec<u32> {
        let latest = who.iter().filter_map(|a| self.last[*a]).max();
        let mut steps: Vec<u32> = self.last.iter().flatten().copied().collect();
        steps.sort_unstable();
        steps.dedup();
        // The agents of the step itself: their last one must be this one, so no later step may have changed it.
        steps.retain(|step| latest.is_none_or(|latest| *step >= latest) && self.is_last_of_all(*step));
        steps
    }

    fn is_last_of_all(&self, step: u32) -> bool {
        let from = self.steps[step as usize].last_before as usize;
        let to = match self.steps.get(step as usize + 1) {
            Some(next) => next.last_before as usize,
            None => self.last_before.len(),
        };
        self.last_before[from..to]
            .iter()
            .all(|(agent, _)| self.last[*agent] == Some(step))
    }

    /// Fits an action into all that waits for a pattern; says whether it ends a sequence.
    fn advance(&mut self, rule: usize, position: usize, args: &[Value], before: &[u32]) -> bool {
        let Rule { vars, patterns, .. } = self.rules[rule];
        let pattern = &patterns[position];
        let is_last = position + 1 == patterns.len();
        let mut begun: Vec<Option<u32>> = Vec::new();
        if position == 0 {
            begun.push(None);
        } else if pattern.is_immediate {
            for step in before {
                let from = self.steps[*step as usize].fresh as usize;
                let to = self.steps[*step as usize + 1].fresh as usize;
                let of_rule = self.fresh[from..to]
                    .iter()
                    .filter(|(r, p, _)| (*r as usize, *p as usize) == (rule, position));
                begun.extend(of_rule.map(|(.., values)| Some(*values)));
            }
        } else {
            begun.extend(self.waiting[rule][position].iter().map(|values| Some(*values)));
        }
        let mut bound: Vec<Option<Value>> = Vec::new();
        for values in begun {
            bound.clear();
            match values {
                Some(from) => bound.extend_from_slice(&self.values[from as usize..from as usize + vars.len()]),
                None => bound.resize(vars.len(), None),
            }
            if !fits(self.domain, vars, &pattern.args, args, &mut bound) {
                continue;
            }
            if is_last {
                return true;
            }
            self.begin(rule, position + 1, &bound);
        }
        false
    }

    /// Notes what waits for the pattern at `position`.
    fn begin(&mut self, rule: usize, position: usize, bound: &[Option<Value>]) {
        let (number, at) = (rule as u32, position as u32);
        let values = self.values.len() as u32;
        if self.rules[rule].patterns[position].is_immediate {
            self.fresh.push((number, at, values));
        } else {
            let head = Print::of(u64::from(number)).number(u64::from(at));
            let print = bound.iter().fold(head, |print, value| match value {
                Some(value) => print.number(1).value(value),
                None => print.number(0),
            });
            if !self.known.insert(print.key()) {
                return;
            }
            self.waiting[rule][position].push(values);
            self.added.push((number, at, print.key()));
        }
        self.values.extend_from_slice(bound);
    }
}

/// Returns the places of the agents in `Sequences::last`.
fn who(agents: &[EntityId]) -> Vec<usize> {
    match agents {
        [] => vec![NOBODY],
        agents => agents.iter().map(|a| a.index() + 1).collect(),
    }
}

/// Says whether an action's arguments are those of a pattern; gives variables their values.
fn fits(domain: &Domain, vars: &[Param], pattern: &[PatternArg], args: &[Value], bound: &mut [Option<Value>]) -> bool {
    pattern.iter().zip(args).all(|(pattern, arg)| match pattern {
        PatternArg::Any => true,
        PatternArg::Is(value) => sets::equal(value, arg),
        PatternArg::Var(var) => match &bound[*var] {
            Some(value) => sets::equal(value, arg),
            None => {
                let is_one = is_of_type(domain, &vars[*var], arg);
                bound[*var] = Some(arg.clone());
                is_one
            }
        },
    })
}

fn is_of_type(domain: &Domain, var: &Param, value: &Value) -> bool {
    let Base::Entity(ty) = var.base else { return true };
    let is_one = |e: EntityId| domain.is_subtype(domain.entities[e.index()].ty, ty);
    match value {
        Value::Entity(e) => is_one(*e),
        Value::Set(set) => set.iter().all(is_one),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Scalars(_) | Value::Unknown => true,
    }
}
