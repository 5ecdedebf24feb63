//! Actions: preconditions, projection, effects, cost and duration (thesis 4.3.3, listing 4.2).

use super::expr::{Place, Scope, Walk};
use super::functions::{Functions, Value, constant_number};
use super::kinds::Kind;
use super::names::Names;
use super::problems;
use crate::diag::{Problem, Problems};
use crate::ir::geometric::ChoiceSet;
use crate::ir::{self, Base, Effect, Expr, Test};
use crate::source::Span;
use crate::syntax::ast::{self, AssignOp, Clause};

/// Returns the parameters; a faulty one gets any base, since its domain is never used.
pub(super) fn params(params: &[ast::Param], kinds: &[(String, Kind)]) -> Vec<ir::Param> {
    let base = |kind: Kind| match kind {
        Kind::Set(Some(base)) => base,
        kind => kind.base().unwrap_or(Base::String),
    };
    let params = params.iter().zip(kinds);
    params
        .map(|(param, (_, kind))| ir::Param {
            name: param.name.text.clone(),
            base: base(*kind),
            is_set: param.is_set,
        })
        .collect()
}

/// Returns the kinds of a task's parameters; those of its own declaration when another has taken its name.
pub(super) fn kinds_of(params: &[ast::Param], names: &Names) -> Vec<(String, Kind)> {
    let mut ignored = Problems::default();
    let kind = |param: &ast::Param| match names.base_named(&param.ty, &mut ignored) {
        Some(base) => Kind::of(base, param.is_set),
        None => Kind::Unknown,
    };
    let mut kind = kind;
    params.iter().map(|p| (p.name.text.clone(), kind(p))).collect()
}

/// Compiles an action.
pub(super) fn action(
    action: &ast::Action,
    names: &mut Names,
    functions: &Functions,
    problems: &mut Problems,
) -> ir::Action {
    let kinds = kinds_of(&action.params, names);
    let agent = names.agent();
    // The members of a set of agents take part, each as a parameter of its own would.
    let is_agent = |kind: &Kind| matches!(kind, Kind::Entity(t) | Kind::Set(Some(Base::Entity(t))) if names.domain.is_subtype(*t, agent));
    let agents: Vec<usize> = kinds
        .iter()
        .enumerate()
        .filter(|(_, (_, kind))| is_agent(kind))
        .map(|(i, _)| i)
        .collect();
    let mut walk = Walk {
        names,
        functions,
        problems,
        scope: Scope::of_params(&action.params, &kinds),
        wanted: "number",
    };
    let mut out = ir::Action {
        name: action.name.text.clone(),
        params: params(&action.params, &kinds),
        n_vars: 0,
        preconditions: Test::always(),
        projects: None,
        constraints: ir::Test::always(),
        alternatives: None,
        effects: Vec::new(),
        cost: Expr::Const(ir::Value::Number(1.0)),
        duration: (Expr::Const(ir::Value::Number(0.0)), Expr::Const(ir::Value::Number(0.0))),
        agents,
    };
    let mut seen: Vec<(&str, Span)> = Vec::new();
    for clause in &action.clauses {
        let (word, span) = clause_word(clause);
        if let Some((_, first)) = seen.iter().find(|(seen, _)| *seen == word) {
            walk.problems
                .push(problems::repeated_block(word, &action.name.text, span, *first));
        }
        seen.push((word, span));
        match clause {
            Clause::Preconditions(tests, _) => out.preconditions = walk.tests(tests),
            Clause::Projects(call, _) => out.projects = walk.projection(call),
            Clause::Constraints(tests, _) => out.constraints = walk.tests(tests),
            Clause::Alternatives(expr, _) => out.alternatives = walk.alternatives(expr),
            Clause::Effects(effects, _) => out.effects = walk.effects(effects),
            Clause::Cost(expr, _) => out.cost = walk.cost(expr),
            Clause::Duration(expr, _) => out.duration = walk.duration(expr),
        }
    }
    let constraints = action.clauses.iter().find_map(|c| match c {
        Clause::Constraints(_, span) => Some(*span),
        _ => None,
    });
    if let Some(span) = constraints.filter(|_| !seen.iter().any(|(w, _)| *w == "projects")) {
        walk.problems.push(problems::not_projected(&action.name, span));
    }
    if out.projects.is_some() {
        if !seen.iter().any(|(w, _)| *w == "cost") {
            out.cost = Expr::GeometricCost;
        }
        if !seen.iter().any(|(w, _)| *w == "duration") {
            out.duration = (Expr::GeometricDuration, Expr::GeometricDuration);
        }
    }
    out.n_vars = walk.scope.n_vars as usize;
    out
}

/// Says whether the number may be a cost or a time: finite, and not below 0.
fn is_amount(x: f64) -> bool {
    x.is_finite() && x >= 0.0
}

fn clause_word(clause: &Clause) -> (&'static str, Span) {
    match clause {
        Clause::Preconditions(_, span) => ("preconditions", *span),
        Clause::Projects(_, span) => ("projects", *span),
        Clause::Constraints(_, span) => ("constraints", *span),
        Clause::Alternatives(_, span) => ("alternatives", *span),
        Clause::Effects(_, span) => ("effects", *span),
        Clause::Cost(_, span) => ("cost", *span),
        Clause::Duration(_, span) => ("duration", *span),
    }
}

impl Walk<'_> {
    fn projection(&mut self, source: &ast::GeometricCall) -> Option<ir::Projection> {
        let call = &source.call;
        let name = &call.name;
        let Some(signature) = self.names.geometrics.get(&name.text).cloned() else {
            let candidates = self.names.geometrics.keys().map(String::as_str);
            let what = "geometric action";
            let mut problem = problems::unknown(
                "hatp::unknown-geometric",
                what,
                &name.text,
                name.span,
                candidates.clone(),
            );
            if problem.help.is_none() {
                let known: Vec<String> = candidates.map(|c| format!("`{c}`")).collect();
                problem = problem.help(format!("there are {}", known.join(", ")));
            }
            self.problems.push(problem);
            return None;
        };
        let mut args = self.arguments("geometric action", call, &signature.params, signature.span);
        let given = self.given(source, &mut args);
        Some(ir::Projection {
            name: name.text.clone(),
            args,
            given,
        })
    }

    /// Returns the choices that the call makes, and adds their values to its arguments.
    fn given(&mut self, source: &ast::GeometricCall, args: &mut Vec<Expr>) -> Vec<ir::ChoiceId> {
        let mut given: Vec<ir::ChoiceId> = Vec::new();
        // One with errors has its own.
        let Some(action) = self.names.domain.geometric(&source.call.name.text).cloned() else {
            return given;
        };
        for binding in &source.given {
            let name = &binding.name;
            // A middle is no choice; where an agent stands is not to be given yet.
            let free = |c: &&ir::geometric::Choice| !matches!(c.from, ChoiceSet::Centre(_) | ChoiceSet::Stands { .. });
            let Some(at) = action.choices.iter().position(|c| c.name == name.text && free(&c)) else {
                let known = action.choices.iter().filter(free).map(|c| c.name.as_str());
                let problem = problems::unknown("hatp::unknown-choice", "choice", &name.text, name.span, known);
                self.problems.push(problem);
                continue;
            };
            let choice = ir::ChoiceId(at as u32);
            if given.contains(&choice) {
                let first = source
                    .given
                    .iter()
                    .find(|b| b.name.text == name.text)
                    .map(|b| b.name.span);
                self.problems
                    .push(problems::duplicate("choice", &name.text, name.span, first));
                continue;
            }
            let value = &binding.value;
            match action.choices[at].from {
                ChoiceSet::Arms(_) | ChoiceSet::Grasps(_) | ChoiceSet::Supports(_) | ChoiceSet::Stable(_) => {
                    args.push(self.expect(value, Kind::String));
                    given.push(choice);
                }
                ChoiceSet::Angles => {
                    args.push(self.number(value));
                    given.push(choice);
                }
                ChoiceSet::Points(_) | ChoiceSet::Centre(_) | ChoiceSet::Stands { .. } => match &value.kind {
                    ast::ExprKind::Pair(x, y) => {
                        args.extend([self.number(x), self.number(y)]);
                        given.extend([choice, choice]);
                    }
                    _ => {
                        let problem = problems::wrong_type(value.span, "a point `(x, y)`", "one value");
                        self.problems
                            .push(problem.help("write both in parentheses, in metres: `xy = (0.1, 0)`"));
                    }
                },
            }
        }
        given
    }

    fn alternatives(&mut self, expr: &ast::Expr) -> Option<u32> {
        let value = self.number(expr);
        let number = constant_number(&value);
        let whole = number.filter(|n| *n >= 1.0 && *n <= f64::from(u32::MAX) && n.fract() == 0.0);
        if whole.is_none() {
            let message = "the number of alternatives must be a whole number from 1";
            let problem = problems::not_constant(expr.span, message, "write it as `alternatives { 3 };`");
            self.problems.push(problem);
        }
        whole.map(|n| n as u32)
    }

    fn cost(&mut self, expr: &ast::Expr) -> Expr {
        let cost = self.number(expr);
        if let Some(value) = constant_number(&cost).filter(|c| !is_amount(*c)) {
            self.problems.push(problems::negative_cost(value, expr.span));
        }
        cost
    }

    fn duration(&mut self, expr: &ast::Expr) -> (Expr, Expr) {
        self.wanted = "duration";
        let value = self.value(expr);
        self.wanted = "number";
        match value {
            (Value::Pair(least, most), _) => {
                let (l, m) = (constant_number(&least), constant_number(&most));
                let one_wrong = [l, m].into_iter().flatten().any(|x| !is_amount(x));
                if one_wrong || l.zip(m).is_some_and(|(l, m)| l > m) {
                    let (l, m) = (l.unwrap_or(0.0), m.unwrap_or(0.0));
                    self.problems.push(problems::bad_duration(l, m, expr.span));
                }
                (least, most)
            }
            (Value::One(value), kind) => {
                if kind != Kind::Unknown {
                    let words = self.words(Kind::Duration);
                    let problem = self.mismatch(expr.span, &words, kind);
                    self.problems
                        .push(problem.help("write the least and the most seconds: `(1, 3)`"));
                }
                (value.clone(), value)
            }
        }
    }

    pub(super) fn effects(&mut self, effects: &[ast::Effect]) -> Vec<Effect> {
        effects.iter().filter_map(|e| self.effect(e)).collect()
    }

    fn effect(&mut self, effect: &ast::Effect) -> Option<Effect> {
        match effect {
            ast::Effect::Assign(assignment) => self.assignment(assignment),
            ast::Effect::Forall {
                ty,
                var,
                guard,
                effects,
                ..
            } => {
                let inside = |walk: &mut Self| (walk.tests(guard), walk.effects(effects));
                let (var, ty, (guard, effects)) = self.quantified(ty, var, inside);
                Some(Effect::Forall {
                    var,
                    ty: ty?,
                    guard,
                    effects,
                })
            }
            ast::Effect::If {
                test, then, otherwise, ..
            } => Some(Effect::If {
                test: self.tests(test),
                then: self.effects(then),
                otherwise: self.effects(otherwise),
            }),
        }
    }

    fn assignment(&mut self, assignment: &ast::Assignment) -> Option<Effect> {
        let target = self.told_place(assignment);
        let Some(Place {
            entity,
            attribute,
            args,
            kind,
        }) = target
        else {
            // The value's own problems are told all the same.
            self.single(&assignment.value);
            return None;
        };
        let declared = self.names.domain.attributes.get(attribute.index())?;
        let owner = self
            .names
            .domain
            .types
            .get(declared.owner.index())
            .map_or("?", |t| t.name.as_str());
        if declared.is_static {
            let span = self.names.attribute_spans.get(attribute.index()).copied();
            let name = &assignment.target.steps.last()?.name;
            let problem = problems::static_assigned(owner, name, span.unwrap_or(name.span));
            self.problems.push(problem);
        }
        let value = self.told_value(assignment, attribute, kind);
        Some(match assignment.op {
            AssignOp::Set => Effect::Assign {
                entity,
                attribute,
                args,
                value,
            },
            AssignOp::Add => Effect::Add {
                entity,
                attribute,
                args,
                element: value,
            },
            AssignOp::Remove => Effect::Remove {
                entity,
                attribute,
                args,
                element: value,
            },
        })
    }

    /// Returns what is assigned to, added to or removed from the attribute, which is of kind `kind`.
    pub(super) fn new_value(&mut self, assignment: &ast::Assignment, attribute: ir::AttributeId, kind: Kind) -> Expr {
        let declared = self.names.attribute_spans.get(attribute.index()).copied();
        let wanted = match (assignment.op, kind) {
            (AssignOp::Set, _) => kind,
            (_, Kind::Set(of)) => Kind::element(of),
            (_, other) => {
                let (value, _) = self.single(&assignment.value);
                let mark = if assignment.op == AssignOp::Add { "<<=" } else { "=>>" };
                let message = format!("`{mark}` changes a set, and this attribute holds {}", self.words(other));
                let problem = Problem::error("hatp::wrong-type", message, assignment.op_span, "for sets only");
                let problem = problems::noted(problem, declared, "declared here");
                self.problems.push(problem.help("write `=` to set the value"));
                return value;
            }
        };
        if matches!((&assignment.value.kind, wanted), (ast::ExprKind::List(_), Kind::Set(_))) {
            return self.expect(&assignment.value, wanted);
        }
        let (value, found) = self.single(&assignment.value);
        let may_be_null = assignment.op == AssignOp::Set && !matches!(kind, Kind::Set(_));
        let misfit = self.misfit(&assignment.value, found, wanted);
        if let Some(problem) = misfit.filter(|_| !(may_be_null && found == Kind::Null)) {
            let problem = match (kind, found, assignment.op) {
                (Kind::Set(of), found, AssignOp::Set) if found.fits(Kind::element(of), &self.names.domain) => {
                    problem.help("write `<<=` to add it to the set")
                }
                (Kind::Set(_), Kind::Null, AssignOp::Set) => problem.help("an empty set is written `[]`"),
                _ => problem,
            };
            self.problems.push(problems::noted(problem, declared, "declared here"));
        }
        value
    }
}
