//! `social { ... }`: rules on what a plan costs beyond its actions.
//!
//! A rule's tests read attributes, shared ones too; they ask no request, so that counting is no geometric work of its own.

use super::expr::{Scope, Walk};
use super::functions::{Functions, constant_number};
use super::kinds::Kind;
use super::names::Names;
use super::{problems, tasks};
use crate::diag::{Problem, Problems};
use crate::ir::{self, EntityId, Expr, PatternArg, RuleKind, SocialRule, TaskId, TypeId};
use crate::source::Span;
use crate::syntax::ast::{self, ExprKind, Item, Name};

/// Choices of a rule's parameters, each tested in every state. HEURISTIC: far above real domains.
const MAX_CHOICES: usize = 10_000;
/// What a plan's cost consists of without any rule.
const OWN_PARTS: [&str; 2] = ["sum", "makespan"];

/// Fills `names.domain.social`.
pub(super) fn fill(items: &[&Item], names: &mut Names, functions: &Functions, problems: &mut Problems) {
    let mut seen: Vec<(String, Span)> = Vec::new();
    let blocks = items.iter().filter_map(|item| match item {
        Item::Social(block) => Some(block),
        _ => None,
    });
    for rule in blocks.flat_map(|block| &block.rules) {
        let kinds = tasks::kinds_of(&rule.params, names);
        let mut walk = Walk {
            names: &mut *names,
            functions,
            problems: &mut *problems,
            scope: Scope::of_params(&rule.params, &kinds),
            wanted: "number",
        };
        let weight = walk.weight(&rule.weight);
        walk.parameters(&rule.params);
        let kind = walk.kind(rule, &kinds);
        let name = match &rule.name {
            Some(name) => name.text.clone(),
            None => kind.word().to_owned(),
        };
        let span = rule.name.as_ref().map_or(rule.span, |n| n.span);
        if OWN_PARTS.contains(&name.as_str()) {
            problems.push(problems::part_of_cost(&name, span));
        } else if let Some((_, first)) = seen.iter().find(|(seen, _)| *seen == name) {
            let problem = problems::duplicate("social rule", &name, span, Some(*first));
            problems.push(match rule.name {
                Some(_) => problem,
                None => problem.help("give one of them a name: `wasted time of_bob among BOB weight 1;`"),
            });
        }
        seen.push((name.clone(), span));
        names.domain.social.push(SocialRule { name, weight, kind });
    }
}

impl Walk<'_> {
    fn weight(&mut self, expr: &ast::Expr) -> f64 {
        let n_before = self.problems.0.len();
        let value = self.number(expr);
        if self.problems.0.len() > n_before {
            return 0.0;
        }
        match constant_number(&value) {
            Some(weight) if weight >= 0.0 && weight.is_finite() => weight,
            weight => {
                self.problems.push(problems::bad_weight(weight, expr.span));
                0.0
            }
        }
    }

    /// Reports parameters that have no type, and those of one name.
    fn parameters(&mut self, params: &[ast::Param]) {
        for (i, param) in params.iter().enumerate() {
            self.names.base_named(&param.ty, self.problems);
            if let Some(first) = params[..i].iter().find(|p| p.name.text == param.name.text) {
                let name = &param.name;
                let problem = problems::duplicate("variable", &name.text, name.span, Some(first.name.span));
                self.problems.push(problem);
            }
        }
    }

    fn kind(&mut self, rule: &ast::Rule, kinds: &[(String, Kind)]) -> RuleKind {
        match &rule.kind {
            ast::RuleKind::State(tests) => self.state(rule, tests, kinds),
            ast::RuleKind::Sequence(patterns) => {
                if patterns.is_empty() {
                    let span = rule.name.as_ref().map_or(rule.span, |n| n.span);
                    self.problems.push(problems::empty_sequence(span));
                }
                let patterns = patterns.iter().enumerate();
                RuleKind::Sequence {
                    patterns: patterns.filter_map(|(i, p)| self.pattern(p, i == 0)).collect(),
                    vars: tasks::params(&rule.params, kinds),
                }
            }
            ast::RuleKind::EffortBalance(effort) => RuleKind::EffortBalance {
                effort: match effort {
                    ast::Effort::Cost => ir::Effort::Cost,
                    ast::Effort::Duration => ir::Effort::Duration,
                },
                agents: self.among(&rule.among),
            },
            ast::RuleKind::WastedTime => RuleKind::WastedTime {
                agents: self.among(&rule.among),
            },
            ast::RuleKind::IntricateLinks => RuleKind::IntricateLinks {
                agents: self.among(&rule.among),
            },
        }
    }

    fn state(&mut self, rule: &ast::Rule, tests: &[ast::Test], kinds: &[(String, Kind)]) -> RuleKind {
        let mut params: Vec<TypeId> = Vec::new();
        for (param, (_, kind)) in rule.params.iter().zip(kinds) {
            match kind {
                Kind::Entity(ty) => params.push(*ty),
                Kind::Unknown => {}
                other => {
                    let problem = self.mismatch(param.span, "a type of entities", *other);
                    let help = "a state is tested for every entity of its parameters' types";
                    self.problems.push(problem.help(help));
                }
            }
        }
        let sizes = params.iter().filter_map(|ty| self.names.domain.types.get(ty.index()));
        let n_choices = sizes.fold(1_usize, |n, ty| n.saturating_mul(ty.entities.len()));
        if n_choices > MAX_CHOICES {
            let span = rule.name.as_ref().map_or(rule.span, |n| n.span);
            self.problems
                .push(problems::too_many_choices(n_choices, MAX_CHOICES, span));
        }
        for test in tests {
            // One by one, so that what asks geometry has its place.
            let n_vars = self.scope.n_vars;
            let compiled = self.quietly(|walk| walk.tests(std::slice::from_ref(test)));
            self.scope.n_vars = n_vars;
            if compiled.any(&mut |e| matches!(e, Expr::Request { .. } | Expr::Fact { .. })) {
                let message = "a social rule can't ask geometry yet";
                let help = "read an attribute, perhaps a shared one: `dynamic atom Table isOn = fact isOn;`";
                self.problems.push(problems::not_supported(message, test.span, help));
            }
        }
        let test = self.tests(tests);
        RuleKind::State {
            params,
            n_vars: self.scope.n_vars as usize,
            test,
        }
    }

    /// Runs `inside` without its problems: they are told by another walk over the same.
    fn quietly<T>(&mut self, inside: impl FnOnce(&mut Self) -> T) -> T {
        let n_before = self.problems.0.len();
        let out = inside(self);
        self.problems.0.truncate(n_before);
        out
    }

    fn pattern(&mut self, pattern: &ast::Pattern, is_first: bool) -> Option<ir::Pattern> {
        let call = &pattern.call;
        if pattern.is_immediate && is_first {
            self.problems.push(problems::immediate_first(pattern.span));
        }
        let action = match self.names.tasks.get(&call.name.text) {
            Some((TaskId::Action(action), signature)) => Some((*action, signature.clone())),
            Some((TaskId::Method(_), signature)) => {
                let problem = problems::not_an_action(&call.name, signature.span);
                self.problems.push(problem);
                None
            }
            None => {
                let actions = self.names.tasks.iter().filter_map(|(name, (id, _))| match id {
                    TaskId::Action(_) => Some(name.as_str()),
                    TaskId::Method(_) => None,
                });
                let problem =
                    problems::unknown("hatp::unknown-task", "action", &call.name.text, call.name.span, actions);
                self.problems.push(problem);
                None
            }
        };
        let (action, signature) = action?;
        if call.args.len() != signature.params.len() {
            let wanted: Vec<String> = signature.params.iter().map(|p| p.0.clone()).collect();
            let problem = problems::wrong_count("action", &call.name, &wanted, call.args.len(), signature.span);
            self.problems.push(problem);
            return None;
        }
        let args = call.args.iter().zip(&signature.params);
        let args = args.map(|(arg, (_, kind))| self.pattern_arg(arg, *kind)).collect();
        Some(ir::Pattern {
            action,
            args,
            is_immediate: pattern.is_immediate,
        })
    }

    fn pattern_arg(&mut self, arg: &ast::Expr, wanted: Kind) -> PatternArg {
        if matches!(&arg.kind, ExprKind::Path(path) if path.root.text == "_" && path.steps.is_empty()) {
            return PatternArg::Any;
        }
        let n_before = self.problems.0.len();
        let (value, found) = self.single(arg);
        if self.problems.0.len() > n_before {
            return PatternArg::Any;
        }
        // One may be of a narrower type than the other: then fewer actions fit.
        if !found.comparable(wanted, &self.names.domain) && !matches!((found, wanted), (Kind::Set(_), Kind::Set(_))) {
            let words = self.words(wanted);
            let problem = self.mismatch(arg.span, &words, found);
            self.problems.push(problem);
            return PatternArg::Any;
        }
        match (&value, ir::constant(&value)) {
            (Expr::Var(var), _) => PatternArg::Var(var.index()),
            (_, Some(value)) => PatternArg::Is(value),
            (_, None) => {
                let message = "an argument of a sequence must be a variable or a constant";
                let help = "declare a variable for it: `undesirable sequence NAME(Object O) weight 1 { ... }`, or write `_` for anything";
                self.problems.push(problems::not_constant(arg.span, message, help));
                PatternArg::Any
            }
        }
    }

    /// Returns the agents that a rule is about: all, unless it names some or their types.
    fn among(&mut self, names: &[Name]) -> Vec<EntityId> {
        let agent = self.names.agent();
        let all = |walk: &Self, ty: TypeId| walk.names.domain.types.get(ty.index()).map(|t| t.entities.clone());
        if names.is_empty() {
            return all(self, agent).unwrap_or_default();
        }
        let mut out: Vec<EntityId> = Vec::new();
        for name in names {
            let entity = self.names.entities.get(&name.text).map(|e| e.0);
            let ty = self.names.types.get(&name.text).map(|t| t.0);
            let (of, agents) = match (entity, ty) {
                (Some(e), _) => (self.names.domain.entities.get(e.index()).map(|e| e.ty), vec![e]),
                (None, Some(ty)) => (Some(ty), all(self, ty).unwrap_or_default()),
                (None, None) => {
                    let entities = self.names.entities.keys().chain(self.names.types.keys());
                    let what = "agent or type of agents";
                    let known = entities.map(String::as_str);
                    let problem = problems::unknown("hatp::unknown-name", what, &name.text, name.span, known);
                    self.problems.push(problem);
                    continue;
                }
            };
            if !of.is_some_and(|ty| self.names.domain.is_subtype(ty, agent)) {
                let problem = self.mismatch(name.span, "an agent", of.map_or(Kind::Unknown, Kind::Entity));
                self.problems.push(problem);
            }
            out.extend(agents);
        }
        out.sort();
        out.dedup();
        out
    }
}

/// Returns the cost formula of `settings { cost = ...; }`: `sum`, `makespan`, or both with factors.
pub(super) fn formula(expr: &ast::Expr, problems: &mut Problems) -> ir::CostFormula {
    let Some([sum, makespan, constant]) = linear(expr, problems) else {
        return ir::CostFormula::default();
    };
    if [sum, makespan].iter().any(|x| *x < 0.0 || !x.is_finite()) {
        let least = sum.min(makespan);
        problems.push(problems::bad_weight(Some(least), expr.span));
    } else if constant != 0.0 || sum == 0.0 && makespan == 0.0 {
        problems.push(no_formula(expr.span));
    }
    ir::CostFormula { sum, makespan }
}

fn no_formula(span: Span) -> Problem {
    let message = "the cost of a plan is a weighted sum of `sum` and `makespan`";
    problems::not_constant(
        span,
        message,
        "write `cost = makespan;` or `cost = 1 * sum + 0.2 * makespan;`",
    )
}

/// Returns the factors of `sum`, of `makespan`, and what stands alone; `None` if it was refused.
fn linear(expr: &ast::Expr, problems: &mut Problems) -> Option<[f64; 3]> {
    let scaled = |all: [f64; 3], by: f64| all.map(|x| x * by);
    match &expr.kind {
        ExprKind::Number(x) => Some([0.0, 0.0, *x]),
        ExprKind::Path(path) if path.steps.is_empty() => match path.root.text.as_str() {
            "sum" => Some([1.0, 0.0, 0.0]),
            "makespan" => Some([0.0, 1.0, 0.0]),
            name => {
                let what = "part of the cost";
                problems.push(problems::unknown(
                    "hatp::unknown-name",
                    what,
                    name,
                    path.span,
                    OWN_PARTS,
                ));
                None
            }
        },
        ExprKind::Negate(inner) => linear(inner, problems).map(|all| scaled(all, -1.0)),
        ExprKind::Arithmetic { op, left, right } => {
            let (l, r) = (linear(left, problems)?, linear(right, problems)?);
            let is_number = |all: [f64; 3]| all[0] == 0.0 && all[1] == 0.0;
            let add = |by: f64| Some(std::array::from_fn(|i| l[i] + by * r[i]));
            match op {
                ast::ArithmeticOp::Add => add(1.0),
                ast::ArithmeticOp::Subtract => add(-1.0),
                ast::ArithmeticOp::Multiply if is_number(l) => Some(scaled(r, l[2])),
                ast::ArithmeticOp::Multiply if is_number(r) => Some(scaled(l, r[2])),
                ast::ArithmeticOp::Divide if is_number(r) && r[2] != 0.0 => Some(scaled(l, 1.0 / r[2])),
                ast::ArithmeticOp::Multiply | ast::ArithmeticOp::Divide => {
                    problems.push(no_formula(expr.span));
                    None
                }
            }
        }
        ExprKind::Path(_)
        | ExprKind::String(_)
        | ExprKind::Bool(_)
        | ExprKind::Null
        | ExprKind::Call(_)
        | ExprKind::List(_)
        | ExprKind::Pair(..) => {
            problems.push(no_formula(expr.span));
            None
        }
    }
}
