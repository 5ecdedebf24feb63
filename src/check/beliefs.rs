//! What agents believe: attributes `per agent`, `B.believes(O.isOn == T)` as a test and with `=` as an effect, and the fact
//! `observes` (decision 15).
//!
//! A belief is about one comparison or truth value; what is known is settled here: every attribute read in the view of an
//! agent must have a value other than `unknown`, else the whole is false. So the tests that come out need no third truth value.
//! Beliefs about beliefs are not there, nor beliefs about attributes that are read from geometry.

use indexmap::IndexSet;

use super::expr::{Place, Scope, Walk};
use super::functions::Functions;
use super::kinds::Kind;
use super::names::Names;
use super::{PRELUDE, problems};
use crate::diag::{Problem, Problems};
use crate::ir::{self, AttributeId, CompareOp, Expr, Test, Value};
use crate::source::Span;
use crate::syntax::ast::{self, AssignOp, ExprKind, Item, TestKind, TestOp};

/// The fact that says who learns of a change.
pub(super) const OBSERVES: &str = "observes";

/// Sets every belief to what is true.
pub(super) fn of_truth(domain: &mut ir::Domain) {
    let Some(beliefs) = &domain.beliefs else { return };
    let agents = domain
        .types
        .get(beliefs.agents.index())
        .map_or(&[][..], |t| &t.entities);
    let mut known = Vec::new();
    for (i, attribute) in domain.attributes.iter().enumerate() {
        if attribute.believer.is_none() {
            continue;
        }
        for value in domain.slots_of(AttributeId(i as u32)) {
            known.extend(
                agents
                    .iter()
                    .filter_map(|agent| Some((value, domain.belief(value, *agent)?))),
            );
        }
    }
    for (value, belief) in known {
        let truth = domain.initial.get(value.index()).cloned();
        if let (Some(belief), Some(truth)) = (domain.initial.get_mut(belief.index()), truth) {
            *belief = truth;
        }
    }
}

/// Says whether there are beliefs, and compiles `observes`.
pub(super) fn compile(items: &[&Item], names: &mut Names, functions: &Functions, problems: &mut Problems) {
    let is_per_agent = names.domain.attributes.iter().any(|a| a.believer.is_some());
    if let Some((agents, _)) = names.types.get("Agent").filter(|_| is_per_agent) {
        names.domain.beliefs = Some(ir::Beliefs {
            agents: *agents,
            observes: None,
        });
    }
    let mut first: Option<Span> = None;
    for item in items {
        let Item::Fact(fact) = item else { continue };
        let Some(body) = fact
            .body
            .as_ref()
            .filter(|_| fact.name.text == OBSERVES && fact.span.file != PRELUDE)
        else {
            continue;
        };
        if let Some(first) = first {
            problems.push(problems::duplicate("fact", OBSERVES, fact.name.span, Some(first)));
            continue;
        }
        first = Some(fact.name.span);
        if !is_per_agent {
            let message = "`observes` says who learns of a change, and no attribute is per agent";
            problems.push(problems::not_per_agent(message, fact.name.span, None, None));
        }
        let signature = names.signature_with(&fact.params, fact.name.span, true, problems);
        let of = match signature.params.as_slice() {
            [(_, Kind::Entity(agent)), (_, of)] if Some(*agent) == names.types.get("Agent").map(|t| t.0) => match of {
                Kind::Entity(ty) => Some(Some(*ty)),
                Kind::Any => Some(None),
                Kind::Unknown => continue,
                _ => None,
            },
            _ => None,
        };
        let Some(ty) = of else {
            let message = "`observes` is about an agent and what has changed";
            let problem = Problem::error("hatp::wrong-fact", message, fact.name.span, "two parameters wanted");
            problems
                .push(problem.help("write `fact observes(Agent B, any O) { ... }`, or a type of entities for `any`"));
            continue;
        };
        let mut walk = Walk {
            names,
            functions,
            problems,
            scope: Scope::of_params(&fact.params, &signature.params),
            wanted: "bool",
        };
        let tests: Vec<Test> = body.iter().map(|test| walk.sight(test)).collect();
        let observes = ir::Observes {
            ty,
            params: signature.params.iter().map(|p| p.0.clone()).collect(),
            n_vars: walk.scope.n_vars as usize,
            body: Test::And(tests),
        };
        if let Some(beliefs) = &mut names.domain.beliefs {
            beliefs.observes = Some(observes);
        }
    }
}

impl Names {
    /// Returns what stands for the believer in an attribute that is declared `per agent`; `Err` if it can't be.
    pub(super) fn believer(
        &self,
        attribute: &ast::Attribute,
        problems: &mut Problems,
    ) -> Result<Option<ir::Argument>, ()> {
        let Some(span) = attribute.per_agent else {
            return Ok(None);
        };
        if attribute.is_static {
            let message = format!(
                "static attribute `{}` can't be per agent: what never changes is known",
                attribute.name.text
            );
            let problem = Problem::error("hatp::not-per-agent", message, span, "never changes");
            problems.push(problem.help("declare it `dynamic`"));
            return Err(());
        }
        let agents = self.types.get("Agent").map(|t| t.0);
        Ok(agents.map(|ty| ir::Argument {
            ty,
            offsets: Vec::new(),
        }))
    }

    /// Says whether no attribute has that name.
    pub(super) fn is_no_attribute(&self, name: &str) -> bool {
        self.domain.attributes.iter().all(|a| a.name != name)
    }
}

impl Walk<'_> {
    /// Returns a test of `observes`.
    fn sight(&mut self, test: &ast::Test) -> Test {
        let compiled = self.tests(std::slice::from_ref(test));
        let asks = compiled.any(&mut |expr| match expr {
            Expr::Request { .. } | Expr::Fact { .. } | Expr::GeometricCost | Expr::GeometricDuration => true,
            Expr::Const(_)
            | Expr::Var(_)
            | Expr::Attribute { .. }
            | Expr::Size(_)
            | Expr::List(_)
            | Expr::Arithmetic { .. }
            | Expr::Negate(_)
            | Expr::SetWith { .. }
            | Expr::SetWithout { .. } => false,
        });
        if asks {
            let message = "`observes` reads attributes, and asks geometry nothing";
            let problem = Problem::error("hatp::not-supported", message, test.span, "asks geometry");
            let help = "read a shared attribute: `dynamic set Agent seenBy = fact isVisible;`, `B >> O.seenBy;`";
            self.problems.push(problem.help(help));
        }
        compiled
    }

    /// Returns an attribute's value, or what the agent whose view is taken believes of it.
    pub(super) fn as_believed(&mut self, base: Box<Expr>, attribute: AttributeId, args: Box<[Expr]>) -> Expr {
        let per_agent = self.names.domain.attributes.get(attribute.index());
        let per_agent = per_agent.is_some_and(|a| a.believer.is_some());
        let Some(believer) = self.scope.believer.clone().filter(|_| per_agent) else {
            return Expr::Attribute { base, attribute, args };
        };
        let args = args.into_vec().into_iter().chain([believer]).collect();
        let read = Expr::Attribute { base, attribute, args };
        if !self.scope.believed.contains(&read) {
            self.scope.believed.push(read.clone());
        }
        read
    }

    /// Returns the agent that believes.
    fn agent(&mut self, path: &ast::Path) -> Expr {
        let (agent, kind) = self.path(path);
        let wanted = self
            .names
            .types
            .get("Agent")
            .map_or(Kind::Unknown, |t| Kind::Entity(t.0));
        if !kind.fits(wanted, &self.names.domain) {
            let wanted = self.words(wanted);
            let problem = self.mismatch(path.span, &wanted, kind);
            self.problems.push(problem.help("only agents believe"));
        }
        agent
    }

    /// Says whether it is the word `unknown`.
    fn is_unknown(&self, expr: &ast::Expr) -> bool {
        let ExprKind::Path(path) = &expr.kind else { return false };
        let name = &path.root.text;
        let is_bound = self.scope.bound.iter().any(|b| b.name.text == *name) || self.names.entities.contains_key(name);
        name == "unknown" && path.steps.is_empty() && !is_bound
    }

    /// Returns the test of what an agent believes.
    pub(super) fn believes(&mut self, agent: &ast::Path, inner: &ast::Test) -> Test {
        let n_before = self.problems.0.len();
        let agent = self.agent(agent);
        let outer = (
            self.scope.believer.replace(agent),
            std::mem::take(&mut self.scope.believed),
        );
        let (said, is_unknown) = match &inner.kind {
            TestKind::Compare {
                op: TestOp::Equal,
                left,
                right,
            } if self.is_unknown(right) => (self.unknown(left, CompareOp::Equal), true),
            TestKind::Compare {
                op: TestOp::NotEqual,
                left,
                right,
            } if self.is_unknown(right) => (self.unknown(left, CompareOp::NotEqual), false),
            _ => (self.test(inner), false),
        };
        self.scope.believer = outer.0;
        let mut believed = std::mem::replace(&mut self.scope.believed, outer.1);
        if self.problems.0.len() > n_before {
            return Test::always();
        }
        self.seen_by_agent(&said, believed.is_empty(), inner.span);
        if is_unknown {
            believed.pop();
        }
        let mut tests: Vec<Test> = believed.into_iter().flat_map(known).collect();
        tests.push(said);
        Test::And(tests)
    }

    /// Reports a belief about what is no belief.
    fn seen_by_agent(&mut self, said: &Test, is_nobodys: bool, span: Span) {
        let domain = &self.names.domain;
        let attribute = |expr: &Expr| match expr {
            Expr::Attribute { attribute, args, .. } => Some((*attribute, args.len())),
            _ => None,
        };
        let (mut truths, mut others) = (IndexSet::new(), IndexSet::new());
        said.any(&mut |expr| {
            if let Some((id, n_args)) = attribute(expr)
                && let Some(declared) = domain.attributes.get(id.index())
            {
                match &declared.believer {
                    Some(_) if n_args == declared.arguments.len() => truths.insert(id),
                    Some(_) => true,
                    None => others.insert(id),
                };
            }
            false
        });
        let name = |id: &AttributeId| domain.attributes.get(id.index()).map(|a| a.name.clone());
        if let Some(name) = truths.first().and_then(name) {
            // Nothing but a function brings one here that is not read in the agent's view.
            let message = format!("a function reads `{name}` as it is, not as the agent believes");
            let problem = Problem::error("hatp::not-per-agent", message, span, "within this");
            self.problems.push(problem.help("write out what the function says"));
        } else if is_nobodys {
            let other = others.first();
            let (name, declared) = (
                other.and_then(name),
                other.and_then(|id| self.names.attribute_spans.get(id.index())),
            );
            let message = match &name {
                Some(name) => format!("`{name}` is not per agent: nobody has a view of it"),
                None => "nothing in this is per agent: nobody has a view of it".into(),
            };
            let problem = problems::not_per_agent(&message, span, declared.copied(), name.as_deref());
            self.problems.push(problem);
        }
    }

    /// Returns the test that compares something with `unknown`.
    fn unknown(&mut self, left: &ast::Expr, op: CompareOp) -> Test {
        let (value, _) = self.single(left);
        let is_belief = self.scope.believed.last() == Some(&value);
        if !is_belief && !matches!(value, Expr::Const(Value::Null)) {
            let message = "only an attribute that is per agent can be `unknown`";
            self.problems
                .push(problems::not_per_agent(message, left.span, None, None));
        }
        Test::Compare {
            op,
            left: value,
            right: Expr::Const(Value::Unknown),
        }
    }

    /// Returns the place that is set: of a belief, if an agent is told something.
    pub(super) fn told_place(&mut self, assignment: &ast::Assignment) -> Option<Place> {
        let agent = assignment.believer.as_ref().map(|b| self.agent(b));
        let place = self.target(&assignment.target)?;
        let Some(agent) = agent else { return Some(place) };
        let declared = self.names.domain.attributes.get(place.attribute.index())?;
        if declared.believer.is_none() {
            let name = declared.name.clone();
            let message = format!("`{name}` is not per agent: nobody has a view of it");
            let declared = self.names.attribute_spans.get(place.attribute.index()).copied();
            let problem = problems::not_per_agent(&message, assignment.target.span, declared, Some(&name));
            self.problems.push(problem);
            return None;
        }
        let args = place.args.into_vec().into_iter().chain([agent]).collect();
        Some(Place { args, ..place })
    }

    /// Returns the new value; `unknown` may be one of a belief.
    pub(super) fn told_value(&mut self, assignment: &ast::Assignment, attribute: AttributeId, kind: Kind) -> Expr {
        let is_unknown = assignment.believer.is_some() && self.is_unknown(&assignment.value);
        match assignment.op {
            AssignOp::Set if is_unknown => Expr::Const(Value::Unknown),
            AssignOp::Set | AssignOp::Add | AssignOp::Remove => self.new_value(assignment, attribute, kind),
        }
    }
}

/// Returns that a belief has a value, and that it is not `unknown`.
fn known(belief: Expr) -> Vec<Test> {
    let is_sure = match &belief {
        Expr::Attribute { base, args, .. } => {
            let is_entity = |e: &Expr| matches!(e, Expr::Const(Value::Entity(_)));
            is_entity(base) && args.iter().all(is_entity)
        }
        _ => false,
    };
    let mut tests = vec![Test::Compare {
        op: CompareOp::NotEqual,
        left: belief.clone(),
        right: Expr::Const(Value::Unknown),
    }];
    // A step through NULL has no value, which equals nothing, not even itself.
    tests.extend((!is_sure).then(|| Test::Compare {
        op: CompareOp::Equal,
        left: belief.clone(),
        right: belief,
    }));
    tests
}
