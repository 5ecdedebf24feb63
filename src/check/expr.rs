//! Expressions: checked and written in ids in one walk. Functions are written out where they are called.

use super::functions::{self, Functions, Value};
use super::kinds::Kind;
use super::names::{Asks, Names};
use super::problems;
use crate::diag::suggest::nearest;
use crate::diag::{Problem, Problems};
use crate::ir::{self, ArithmeticOp, AttributeId, Base, Expr, Var};
use crate::source::Span;
use crate::syntax::ast::{self, ExprKind, Name};

/// A name that has a value within a task.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    pub name: Name,
    pub var: Var,
    pub kind: Kind,
}

/// The variables of a task, and where new ones go in its frame.
#[derive(Debug, Default)]
pub(super) struct Scope {
    pub bound: Vec<Bound>,
    /// Variables that a later line of the same decomposition binds.
    pub later: Vec<Name>,
    /// Where the next quantified variable goes. INVARIANT: behind every SELECT and `let` variable of the decomposition,
    /// so that a filter that is evaluated again later overwrites no binding.
    pub next_quantified: u32,
    /// Frame size so far.
    pub n_vars: u32,
    /// Within `B.believes(...)`: the agent, in whose view attributes are read that are `per agent`.
    pub believer: Option<Expr>,
    /// What has been read so, those first that others rest on.
    pub believed: Vec<Expr>,
}

impl Scope {
    /// Returns a scope with the parameters of a task or function.
    pub(super) fn of_params(params: &[ast::Param], kinds: &[(String, Kind)]) -> Self {
        let bound = params
            .iter()
            .zip(kinds)
            .enumerate()
            .map(|(i, (param, (_, kind)))| Bound {
                name: param.name.clone(),
                var: Var(i as u32),
                kind: *kind,
            });
        let n = params.len() as u32;
        Scope {
            bound: bound.collect(),
            later: Vec::new(),
            next_quantified: n,
            n_vars: n,
            believer: None,
            believed: Vec::new(),
        }
    }
}

/// What a walk carries: the names, the task's variables, and the problems found.
pub(super) struct Walk<'a> {
    pub names: &'a mut Names,
    pub functions: &'a Functions,
    pub problems: &'a mut Problems,
    pub scope: Scope,
    /// What the value is for, to propose the definition of a function that is missing: `number`, `bool`, `duration`.
    pub wanted: &'static str,
}

/// An attribute of an entity, with its arguments.
pub(super) struct Place {
    pub entity: Expr,
    pub attribute: AttributeId,
    pub args: Box<[Expr]>,
    /// What it holds.
    pub kind: Kind,
}

/// An expression that stands where something went wrong; never reaches a `Domain`.
fn nothing() -> Expr {
    Expr::Const(ir::Value::Null)
}

impl Walk<'_> {
    pub(super) fn words(&self, kind: Kind) -> String {
        kind.words(&self.names.domain)
    }

    pub(super) fn mismatch(&mut self, span: Span, wanted: &str, found: Kind) -> Problem {
        problems::wrong_type(span, wanted, &self.words(found))
    }

    /// Binds a quantified variable for as long as `inside` runs.
    pub(super) fn quantified<T>(
        &mut self,
        ty: &Name,
        name: &Name,
        inside: impl FnOnce(&mut Self) -> T,
    ) -> (Var, Option<ir::TypeId>, T) {
        let ty = self.names.type_named(ty, self.problems);
        let kind = self.unless_shadowing(name, ty.map_or(Kind::Unknown, Kind::Entity));
        let var = Var(self.scope.next_quantified);
        self.scope.next_quantified += 1;
        self.scope.n_vars = self.scope.n_vars.max(self.scope.next_quantified);
        self.scope.bound.push(Bound {
            name: name.clone(),
            var,
            kind,
        });
        let out = inside(self);
        self.scope.bound.pop();
        self.scope.next_quantified -= 1;
        (var, ty, out)
    }

    /// Returns the kind of a new variable. One that would hide another is reported, and then fits everywhere: which of the
    /// two is meant is not known.
    pub(super) fn unless_shadowing(&mut self, name: &Name, kind: Kind) -> Kind {
        let Some(first) = self.scope.bound.iter().find(|b| b.name.text == name.text) else {
            return kind;
        };
        let problem = problems::duplicate("variable", &name.text, name.span, Some(first.name.span));
        self.problems.push(problem);
        Kind::Unknown
    }

    /// Returns an expression that must be of kind `wanted`.
    pub(super) fn expect(&mut self, expr: &ast::Expr, wanted: Kind) -> Expr {
        // Each member is compared with what is wanted, not with the members before it.
        if let (ExprKind::List(elements), Kind::Set(Some(of))) = (&expr.kind, wanted) {
            let of = Kind::of(of, false);
            return Expr::List(elements.iter().map(|e| self.expect(e, of)).collect());
        }
        let (value, kind) = self.single(expr);
        let misfit = self.misfit(expr, kind, wanted);
        self.problems.0.extend(misfit);
        value
    }

    /// Returns an expression that is not a pair.
    pub(super) fn single(&mut self, expr: &ast::Expr) -> (Expr, Kind) {
        match self.value(expr) {
            (Value::One(value), kind) => (value, kind),
            (Value::Pair(..), _) => {
                let problem = self.mismatch(expr.span, "one value", Kind::Duration);
                self.problems
                    .push(problem.help("a pair belongs in `duration { }` only"));
                (nothing(), Kind::Unknown)
            }
        }
    }

    /// Returns any expression and its kind.
    pub(super) fn value(&mut self, expr: &ast::Expr) -> (Value, Kind) {
        let constant = |v, kind| (Expr::Const(v), kind);
        let (value, kind) = match &expr.kind {
            ExprKind::Number(x) => constant(ir::Value::Number(*x), Kind::Number),
            ExprKind::String(s) => constant(ir::Value::String(self.names.string(s)), Kind::String),
            ExprKind::Bool(b) => constant(ir::Value::Bool(*b), Kind::Bool),
            ExprKind::Null => constant(ir::Value::Null, Kind::Null),
            ExprKind::Path(path) => self.path(path),
            ExprKind::Call(call) => return self.call(call),
            ExprKind::List(elements) => self.list(elements),
            ExprKind::Pair(least, most) => {
                let (least, most) = (self.expect(least, Kind::Number), self.expect(most, Kind::Number));
                return (Value::Pair(least, most), Kind::Duration);
            }
            ExprKind::Negate(inner) => match self.expect(inner, Kind::Number) {
                Expr::Const(ir::Value::Number(x)) => constant(ir::Value::Number(-x), Kind::Number),
                inner => (Expr::Negate(Box::new(inner)), Kind::Number),
            },
            ExprKind::Arithmetic { op, left, right } => self.arithmetic(*op, left, right),
        };
        (Value::One(value), kind)
    }

    fn arithmetic(&mut self, op: ast::ArithmeticOp, left: &ast::Expr, right: &ast::Expr) -> (Expr, Kind) {
        let (l, left_kind) = self.single(left);
        if let Kind::Set(of) = left_kind {
            let (r, right_kind) = self.single(right);
            let (set, element) = (Box::new(l), Box::new(r));
            let value = match op {
                ast::ArithmeticOp::Add => Expr::SetWith { set, element },
                ast::ArithmeticOp::Subtract => Expr::SetWithout { set, element },
                ast::ArithmeticOp::Multiply | ast::ArithmeticOp::Divide => {
                    let problem = self.mismatch(left.span, "a number", left_kind);
                    self.problems.push(problem);
                    return (nothing(), Kind::Unknown);
                }
            };
            let element_fits = match of {
                Some(_) => right_kind.fits(Kind::element(of), &self.names.domain),
                None => right_kind == Kind::Unknown || right_kind.base().is_some(),
            };
            if !element_fits {
                let wanted = self.words(Kind::element(of));
                let problem = self.mismatch(right.span, &wanted, right_kind);
                self.problems
                    .push(problem.help("`+` and `-` add and remove one member of a set"));
            }
            let kind = match of {
                None => Kind::Set(right_kind.base()),
                Some(_) => left_kind,
            };
            return (value, kind);
        }
        if !left_kind.fits(Kind::Number, &self.names.domain) {
            let problem = self.mismatch(left.span, "a number or a set", left_kind);
            self.problems.push(problem);
        }
        let r = self.expect(right, Kind::Number);
        let op = match op {
            ast::ArithmeticOp::Add => ArithmeticOp::Add,
            ast::ArithmeticOp::Subtract => ArithmeticOp::Subtract,
            ast::ArithmeticOp::Multiply => ArithmeticOp::Multiply,
            ast::ArithmeticOp::Divide => ArithmeticOp::Divide,
        };
        let (left, right) = (Box::new(l), Box::new(r));
        (Expr::Arithmetic { op, left, right }, Kind::Number)
    }

    fn list(&mut self, elements: &[ast::Expr]) -> (Expr, Kind) {
        let mut of: Option<Base> = None;
        let mut out = Vec::new();
        let n_before = self.problems.0.len();
        for element in elements {
            let (value, kind) = self.single(element);
            out.push(value);
            of = match (kind.base(), of) {
                _ if kind == Kind::Unknown => of,
                (Some(base), None) => Some(base),
                (Some(Base::Entity(t)), Some(Base::Entity(old))) => match self.common_type(old, t) {
                    Some(common) => Some(Base::Entity(common)),
                    None => {
                        let wanted = self.words(Kind::Entity(old));
                        let problem = self.mismatch(element.span, &wanted, kind);
                        self.problems
                            .push(problem.help("the entities of a list need a common type"));
                        of
                    }
                },
                (Some(base), Some(old)) if base == old => of,
                (Some(_), Some(old)) => {
                    let wanted = self.words(Kind::of(old, false));
                    let problem = self.mismatch(element.span, &wanted, kind);
                    self.problems
                        .push(problem.help("all members of a list are of one kind"));
                    of
                }
                (None, _) => {
                    let problem = self.mismatch(element.span, "an entity, a number, a string or a bool", kind);
                    self.problems.push(problem.help("that is what a list can hold"));
                    of
                }
            };
        }
        let is_whole = self.problems.0.len() == n_before;
        let kind = if is_whole { Kind::Set(of) } else { Kind::Unknown };
        (Expr::List(out), kind)
    }

    /// Returns the nearest type that both are.
    fn common_type(&self, a: ir::TypeId, b: ir::TypeId) -> Option<ir::TypeId> {
        let mut at = Some(a);
        while let Some(t) = at {
            if self.names.domain.is_subtype(b, t) {
                return Some(t);
            }
            at = self.names.domain.types.get(t.index()).and_then(|t| t.parent);
        }
        None
    }

    /// Returns the value of a variable or an entity.
    fn root(&mut self, name: &Name) -> (Expr, Kind) {
        if let Some(bound) = self.scope.bound.iter().rev().find(|b| b.name.text == name.text) {
            return (Expr::Var(bound.var), bound.kind);
        }
        if let Some(later) = self.scope.later.iter().find(|l| l.text == name.text) {
            self.problems.push(problems::unbound(name, later.span));
            return (nothing(), Kind::Unknown);
        }
        if let Some((id, _)) = self.names.entities.get(&name.text) {
            let kind = self
                .names
                .domain
                .entities
                .get(id.index())
                .map_or(Kind::Unknown, |e| Kind::Entity(e.ty));
            return (Expr::Const(ir::Value::Entity(*id)), kind);
        }
        let variables = self.scope.bound.iter().map(|b| b.name.text.as_str());
        let entities = self.names.entities.keys().map(String::as_str);
        let what = "variable or entity";
        let mut problem = problems::unknown(
            "hatp::unknown-name",
            what,
            &name.text,
            name.span,
            variables.chain(entities),
        );
        let constants = ["true", "false", "NULL"];
        if let Some(constant) = constants.iter().find(|c| c.eq_ignore_ascii_case(&name.text)) {
            problem = problem.help(format!("write `{constant}`"));
        } else if name.text == "unknown" {
            problem = problem.help("only what an agent believes can be so: `B.believes(A.attribute == unknown);`");
        } else if problem.help.is_none() {
            problem = problem.help(format!(
                "declare the entity in `factdatabase`, `{} = new Agent;` with its type, or in the world file",
                name.text
            ));
        }
        self.problems.push(problem);
        (nothing(), Kind::Unknown)
    }

    pub(super) fn path(&mut self, path: &ast::Path) -> (Expr, Kind) {
        self.steps(&path.root, &path.steps)
    }

    fn steps(&mut self, root: &Name, steps: &[ast::PathStep]) -> (Expr, Kind) {
        let mut out = self.root(root);
        let mut span = root.span;
        for (i, step) in steps.iter().enumerate() {
            out = match self.step(out, span, step) {
                Some(Place {
                    entity,
                    attribute,
                    args,
                    kind,
                }) => {
                    let base = Box::new(entity);
                    (self.as_believed(base, attribute, args), kind)
                }
                None => {
                    // What is wrong in the arguments behind it is told all the same.
                    let behind = steps.iter().skip(i + 1).flat_map(|s| &s.args);
                    behind.for_each(|a| drop(self.single(a)));
                    return (nothing(), Kind::Unknown);
                }
            };
            span = span.to(step.span);
        }
        out
    }

    /// Returns the parts of `base.step`; `span` is that of `base`.
    fn step(&mut self, base: (Expr, Kind), span: Span, step: &ast::PathStep) -> Option<Place> {
        let found = self.attribute_at(base.1, span, &step.name);
        let Some(attribute) = found else {
            step.args.iter().for_each(|a| drop(self.single(a)));
            return None;
        };
        let declared = self.names.domain.attributes.get(attribute.index())?;
        let kind = Kind::of(declared.base, declared.is_set);
        Some(Place {
            entity: base.0,
            attribute,
            args: self.attribute_arguments(attribute, step)?,
            kind,
        })
    }

    /// Returns the attribute of that name that something of kind `base` has.
    fn attribute_at(&mut self, base: Kind, span: Span, name: &Name) -> Option<AttributeId> {
        if name.text == "believes" && self.names.is_no_attribute(&name.text) {
            self.problems.push(problems::belief_apart(name));
            return None;
        }
        let ty = match base {
            Kind::Entity(ty) => ty,
            Kind::Unknown => return None,
            Kind::Any => {
                let problem = problems::wrong_type(span, "an entity of a type", "an entity of any type");
                let help = "give the parameter its type: entities of any type have no attributes in common";
                self.problems.push(problem.help(help));
                return None;
            }
            other => {
                let problem = self.mismatch(span, "an entity", other);
                self.problems.push(problem.help("only an entity has attributes"));
                return None;
            }
        };
        self.names.attribute_named(ty, name, self.problems)
    }

    /// Returns the arguments that a step gives to its attribute, checked against what is declared.
    pub(super) fn attribute_arguments(&mut self, attribute: AttributeId, step: &ast::PathStep) -> Option<Box<[Expr]>> {
        let domain = &self.names.domain;
        let wanted: Vec<Kind> = match domain.attributes.get(attribute.index()) {
            Some(declared) => declared.arguments.iter().map(|a| Kind::Entity(a.ty)).collect(),
            None => return None,
        };
        let declared = self.names.attribute_spans.get(attribute.index()).copied();
        if wanted.len() != step.args.len() {
            let wanted: Vec<String> = wanted.iter().map(|k| k.declared(domain)).collect();
            let problem = problems::wrong_attribute_arguments(step, &wanted, declared);
            step.args.iter().for_each(|a| drop(self.single(a)));
            self.problems.push(problem);
            return None;
        }
        let mut args = Vec::with_capacity(wanted.len());
        for (arg, kind) in step.args.iter().zip(wanted) {
            let (value, found) = self.single(arg);
            // NULL is no entity: there is no such place, ever.
            let misfit = self.misfit(arg, found, kind);
            let misfit = misfit.map(|p| problems::noted(p, declared, "declared here"));
            self.problems.0.extend(misfit);
            args.push(value);
        }
        Some(args.into())
    }

    /// Returns the place of a value that is to be set.
    pub(super) fn target(&mut self, path: &ast::Path) -> Option<Place> {
        let Some((last, before)) = path.steps.split_last() else {
            let (_, kind) = self.root(&path.root);
            let problem = self.mismatch(path.span, "an attribute", kind);
            self.problems
                .push(problem.help("set an attribute of it: `A.attribute = value;`"));
            return None;
        };
        let span = before.last().map_or(path.root.span, |s| path.root.span.to(s.span));
        let base = self.steps(&path.root, before);
        self.step(base, span, last)
    }

    /// Returns the arguments of a call, checked against what is declared.
    pub(super) fn arguments(
        &mut self,
        what: &str,
        call: &ast::Call,
        params: &[(String, Kind)],
        declared: Span,
    ) -> Vec<Expr> {
        if call.args.len() != params.len() {
            for arg in &call.args {
                self.single(arg);
            }
            let wanted: Vec<String> = params.iter().map(|p| p.0.clone()).collect();
            let problem = problems::wrong_count(what, &call.name, &wanted, call.args.len(), declared);
            self.problems.push(problem);
            return Vec::new();
        }
        let signature = self.signature(&call.name.text, params);
        let mut args = Vec::new();
        for (arg, (_, kind)) in call.args.iter().zip(params) {
            let n_before = self.problems.0.len();
            args.push(self.expect(arg, *kind));
            let own = self.problems.0.split_off(n_before.min(self.problems.0.len()));
            // What is wrong inside of the argument is not about the call.
            let is_misfit = |p: &Problem| {
                let is_list = matches!(arg.kind, ExprKind::List(_));
                let inside = p.primary.as_ref().is_some_and(|l| l.span == arg.span || is_list);
                p.code == "hatp::wrong-type" && inside && p.message.starts_with("expected")
            };
            self.problems
                .0
                .extend(own.into_iter().map(|problem| match is_misfit(&problem) {
                    true => Self::declared_in(problem, declared, &signature),
                    false => problem,
                }));
        }
        args
    }

    fn call(&mut self, call: &ast::Call) -> (Value, Kind) {
        let name = &call.name.text;
        // A domain's own function comes first: files are older than the prelude's questions.
        let Some((signature, kind)) = self.names.functions.get(name).cloned() else {
            return self.question(call);
        };
        let wanted = std::mem::replace(&mut self.wanted, "number");
        let args = self.arguments("function", call, &signature.params, signature.span);
        self.wanted = wanted;
        let Some(template) = self
            .functions
            .get(name)
            .filter(|_| args.len() == signature.params.len())
        else {
            // Its own problem has been reported.
            return (Value::One(nothing()), Kind::Unknown);
        };
        let why = match functions::written_out(template, &args, &mut self.names.n_written_out) {
            Ok(value) => return (value, kind),
            Err(why) => why,
        };
        self.problems.0.extend(problems::too_large(why, call.span));
        (Value::One(nothing()), Kind::Unknown)
    }

    /// Returns a question to geometry, or to a fact of the domain.
    fn question(&mut self, call: &ast::Call) -> (Value, Kind) {
        let name = &call.name.text;
        let facts = self.names.facts.get(name).map(|q| ("fact", q));
        let asked = facts.or_else(|| self.names.requests.get(name).map(|q| ("request", q)));
        let Some((what, question)) = asked.map(|(what, q)| (what, q.clone())) else {
            return self.unknown_call(call);
        };
        let wanted = std::mem::replace(&mut self.wanted, "number");
        let args = self.arguments(what, call, &question.signature.params, question.signature.span);
        self.wanted = wanted;
        let value = match question.asks {
            Asks::Geometry(request) => Expr::Request { request, args },
            Asks::Domain(fact) => Expr::Fact { fact, args },
        };
        (Value::One(value), question.result)
    }

    /// Reports a call of something that has no value.
    fn unknown_call(&mut self, call: &ast::Call) -> (Value, Kind) {
        let name = &call.name.text;
        let wanted = std::mem::replace(&mut self.wanted, "number");
        let kinds: Vec<Kind> = call.args.iter().map(|a| self.single(a).1).collect();
        self.wanted = wanted;
        let nowhere = (Value::One(nothing()), Kind::Unknown);
        if self.names.geometrics.contains_key(name) {
            let message = format!("expected a value, found geometric action `{name}`");
            let label = "a geometric action has no value";
            let problem = Problem::error("hatp::wrong-type", message, call.name.span, label);
            self.problems.push(problem.help("it stands in `projects { }`"));
            return nowhere;
        }
        if self.names.tasks.contains_key(name) {
            let message = format!("expected a value, found task `{name}`");
            let problem = Problem::error("hatp::wrong-type", message, call.name.span, "a task has no value");
            self.problems.push(problem.help("a task stands in `subtasks { }`"));
            return nowhere;
        }
        let functions = self.names.functions.keys().chain(self.names.facts.keys());
        let known = functions.chain(self.names.requests.keys()).map(String::as_str);
        let near = nearest(name, known);
        let params: Vec<String> = kinds
            .iter()
            .enumerate()
            .map(|(i, kind)| {
                (
                    i,
                    if matches!(kind, Kind::Any | Kind::Set(None)) {
                        &Kind::Null
                    } else {
                        kind
                    },
                )
            })
            .map(|(i, kind)| format!("{} a{}", kind.declared(&self.names.domain), i + 1))
            .collect();
        let body = match self.wanted {
            "duration" => "(1, 3)",
            "bool" => "true",
            _ => "1",
        };
        let definition = format!("function {} {name}({}) {{ {body} }}", self.wanted, params.join(", "));
        self.problems
            .push(problems::unknown_function(&call.name, near, &definition));
        nowhere
    }
}
