//! pest's pairs to AST nodes; corrects forms that tempt but are wrong (`=` in a test) with a problem and goes on.

use pest::iterators::{Pair, Pairs};

use super::belief::belief;
use super::parts::parts;
use super::{Place, Rule};
use crate::diag::{Problem, Problems};
use crate::source::Span;
use crate::syntax::ast::*;

/// Operators of one expression with all within it. HEURISTIC: trees are walked by recursion; a sum of 200 terms is no formula
/// that a person wrote.
const MAX_OPERATORS: usize = 200;
/// Steps of one path; each is a level of recursion.
const MAX_STEPS: usize = 32;

/// Reads pairs of a part of a file.
pub(super) struct Builder<'p> {
    place: &'p Place<'p>,
    /// Where the part starts in the text that the grammar sees [bytes].
    start: usize,
    pub(super) problems: &'p mut Problems,
    /// Within an expression, and how many operators it has had so far.
    is_inside: bool,
    n_operators: usize,
}

impl<'p> Builder<'p> {
    pub(super) fn new(place: &'p Place<'p>, start: usize, problems: &'p mut Problems) -> Self {
        Builder {
            place,
            start,
            problems,
            is_inside: false,
            n_operators: 0,
        }
    }

    pub(super) fn span(&self, pair: &Pair<'_, Rule>) -> Span {
        let span = pair.as_span();
        // pest counts the white space before a missing optional part as the rule's own.
        let end = span.start() + pair.as_str().trim_end().len();
        self.place.span_of(self.start + span.start(), self.start + end)
    }

    pub(super) fn name(&self, pair: Pair<'_, Rule>) -> Name {
        Name {
            text: pair.as_str().to_owned(),
            span: self.span(&pair),
        }
    }

    /// Returns all items of a `file` or a `lone` piece, out of their blocks.
    pub(super) fn items(&mut self, pairs: Pairs<'_, Rule>) -> Vec<Item> {
        let mut items = Vec::new();
        for pair in pairs {
            self.item(pair, &mut items);
        }
        items
    }

    /// Returns the tasks of a network.
    pub(super) fn network(&mut self, pairs: Pairs<'_, Rule>) -> Vec<Subtask> {
        let tasks = pairs.into_iter().flat_map(parts);
        tasks.map(|task| self.subtask(task)).collect()
    }

    fn item(&mut self, pair: Pair<'_, Rule>, items: &mut Vec<Item>) {
        let span = self.span(&pair);
        let item = match pair.as_rule() {
            Rule::file | Rule::lone | Rule::fact_database | Rule::htn => {
                for inner in parts(pair) {
                    self.item(inner, items);
                }
                return;
            }
            Rule::entity_type => {
                let mut p = parts(pair);
                Item::EntityType(EntityType {
                    name: self.name(p.want()),
                    parent: p.next().map(|n| self.name(n)),
                    span,
                })
            }
            Rule::attributes => {
                let mut p = parts(pair);
                Item::Attributes(Attributes {
                    owner: self.name(p.want()),
                    attributes: p.map(|a| self.attribute(a)).collect(),
                    span,
                })
            }
            Rule::entity => {
                // The word `=` is a part of its own; it carries nothing here.
                let mut names = parts(pair).filter(|p| p.as_rule() == Rule::ident);
                match (names.next(), names.next()) {
                    (Some(name), Some(ty)) => Item::Entity(Entity {
                        name: self.name(name),
                        ty: self.name(ty),
                        span,
                    }),
                    _ => unreachable!("builder: an entity has a name and a type"),
                }
            }
            Rule::initial => Item::Initial(self.assignment(pair)),
            Rule::told => match self.told(pair) {
                Some(told) => Item::Initial(told),
                None => return,
            },
            Rule::action => {
                let mut p = parts(pair);
                Item::Action(Action {
                    name: self.name(p.want()),
                    params: self.params(p.want()),
                    clauses: p.map(|c| self.clause(c)).collect(),
                    span,
                })
            }
            Rule::method => Item::Method(self.method(pair)),
            Rule::function => {
                let mut p = parts(pair);
                Item::Function(Function {
                    result: self.name(p.want()),
                    name: self.name(p.want()),
                    params: self.params(p.want()),
                    body: p.next().map(|body| self.expr(parts(body).want())),
                    span,
                })
            }
            Rule::geometric => {
                let mut p = parts(pair);
                Item::Geometric(Geometric {
                    name: self.name(p.want()),
                    params: self.params(p.want()),
                    body: p
                        .next()
                        .map(|body| parts(body).map(|p| self.geometric_part(p)).collect()),
                    span,
                })
            }
            Rule::fact => {
                let mut p = parts(pair);
                Item::Fact(Fact {
                    name: self.name(p.want()),
                    params: self.params(p.want()),
                    body: p.next().map(|block| self.tests(block)),
                    span,
                })
            }
            Rule::request => {
                let mut p = parts(pair);
                Item::Request(Request {
                    result: self.name(p.want()),
                    name: self.name(p.want()),
                    params: self.params(p.want()),
                    span,
                })
            }
            Rule::settings => {
                let settings = parts(pair).map(|s| self.setting(s)).collect();
                Item::Settings(Settings { settings, span })
            }
            Rule::social => {
                let rules = parts(pair).map(|r| self.rule(r)).collect();
                Item::Social(Social { rules, span })
            }
            Rule::time_part => Item::TimePart(span),
            Rule::import => {
                let path = parts(pair).want();
                Item::Import(Import {
                    path: unescaped(path.as_str()),
                    path_span: self.span(&path),
                    span,
                })
            }
            other => unreachable!("builder: {other:?} is no item"),
        };
        items.push(item);
    }

    fn setting(&mut self, pair: Pair<'_, Rule>) -> Setting {
        let span = self.span(&pair);
        let mut p = parts(pair);
        let name = self.name(p.want());
        p.take_if(Rule::assign);
        Setting {
            name,
            value: self.expr(p.want()),
            span,
        }
    }

    fn attribute(&mut self, pair: Pair<'_, Rule>) -> Attribute {
        let span = self.span(&pair);
        let mut p = parts(pair);
        let is_static = p.want().as_rule() == Rule::kw_static;
        let is_set = p.want().as_rule() == Rule::kw_set;
        let base = self.name(p.want());
        let name = self.name(p.want());
        let params = p.take_if(Rule::attribute_params);
        let params = params.map_or_else(Vec::new, |params| {
            parts(params).map(|param| self.attribute_param(param)).collect()
        });
        let per_agent = p.take_if(Rule::per_agent).map(|per_agent| self.span(&per_agent));
        let fact = p.find(|f| f.as_rule() == Rule::ident).map(|f| self.name(f));
        Attribute {
            is_static,
            is_set,
            base,
            name,
            params,
            per_agent,
            fact,
            span,
        }
    }

    fn attribute_param(&mut self, pair: Pair<'_, Rule>) -> AttributeParam {
        let span = self.span(&pair);
        let mut p = parts(pair);
        AttributeParam {
            ty: self.name(p.want()),
            name: p.next().map(|n| self.name(n)),
            span,
        }
    }

    pub(super) fn params(&mut self, pair: Pair<'_, Rule>) -> Vec<Param> {
        let mut params = Vec::new();
        for param in parts(pair) {
            let span = self.span(&param);
            let mut p = parts(param);
            params.push(Param {
                is_set: p.take_if(Rule::kw_set).is_some(),
                ty: self.name(p.want()),
                name: self.name(p.want()),
                span,
            });
        }
        params
    }

    fn clause(&mut self, pair: Pair<'_, Rule>) -> Clause {
        let span = self.span(&pair);
        let rule = pair.as_rule();
        let mut p = parts(pair);
        match rule {
            Rule::preconditions => Clause::Preconditions(self.tests(p.want()), span),
            Rule::projects => Clause::Projects(self.geometric_call(&mut p), span),
            Rule::constraints => Clause::Constraints(self.tests(p.want()), span),
            Rule::alternatives => Clause::Alternatives(self.expr(p.want()), span),
            Rule::effects => Clause::Effects(self.effects(p.want()), span),
            Rule::cost => Clause::Cost(self.expr(p.want()), span),
            Rule::duration => Clause::Duration(self.expr(p.want()), span),
            other => unreachable!("builder: {other:?} is no clause"),
        }
    }

    fn method(&mut self, pair: Pair<'_, Rule>) -> Method {
        let span = self.span(&pair);
        let mut p = parts(pair);
        let name = self.name(p.want());
        let params = self.params(p.want());
        let (mut goals, mut decompositions) = (Vec::new(), Vec::new());
        for part in p {
            let span = self.span(&part);
            let is_goal = part.as_rule() == Rule::goal;
            let mut inner = parts(part);
            if is_goal {
                goals.push((self.tests(inner.want()), span));
                continue;
            }
            let (mut preconditions, mut steps) = (Vec::new(), Vec::new());
            for block in inner {
                if block.as_rule() == Rule::preconditions {
                    preconditions.extend(self.tests(parts(block).want()));
                } else {
                    steps.extend(parts(block).map(|s| self.step(s)));
                }
            }
            decompositions.push(Decomposition {
                preconditions,
                steps,
                span,
            });
        }
        Method {
            name,
            params,
            goals,
            decompositions,
            span,
        }
    }

    fn step(&mut self, pair: Pair<'_, Rule>) -> Step {
        let span = self.span(&pair);
        if pair.as_rule() == Rule::subtask {
            return Step::Subtask(self.subtask(pair));
        }
        let rule = pair.as_rule();
        let mut p = parts(pair);
        match rule {
            Rule::select => {
                let name = self.name(p.want());
                p.take_if(Rule::assign);
                let kind = p.want();
                let kind_span = self.span(&kind);
                let kind = match kind.as_str() {
                    "SELECTORDERED" => SelectKind::Ordered,
                    "SELECTONCE" => SelectKind::Once,
                    _ => SelectKind::Select,
                };
                let ty = self.name(p.want());
                let filter = self.tests(p.want());
                let key = p.next().map(|key| {
                    let key = self.expr(key);
                    (key, p.next().is_some_and(|d| d.as_str() == ">"))
                });
                Step::Select(Select {
                    name,
                    kind,
                    kind_span,
                    ty,
                    filter,
                    key,
                    span,
                })
            }
            Rule::let_binding => {
                let name = self.name(p.want());
                p.take_if(Rule::assign);
                Step::Let(Let {
                    name,
                    value: self.expr(p.want()),
                    span,
                })
            }
            other => unreachable!("builder: {other:?} is no step"),
        }
    }

    fn subtask(&mut self, pair: Pair<'_, Rule>) -> Subtask {
        let span = self.span(&pair);
        let mut p = parts(pair);
        Subtask {
            label: p.take_if(Rule::label).map(|l| self.name(l)),
            call: self.call(p.want()),
            after: match p.next() {
                Some(order) => parts(order).map(|l| self.name(l)).collect(),
                None => Vec::new(),
            },
            span,
        }
    }

    pub(super) fn tests(&mut self, block: Pair<'_, Rule>) -> Vec<Test> {
        parts(block).map(|t| self.test(parts(t).want())).collect()
    }

    fn test(&mut self, pair: Pair<'_, Rule>) -> Test {
        let span = self.span(&pair);
        let rule = pair.as_rule();
        let mut p = parts(pair);
        let kind = match rule {
            Rule::or_test => TestKind::Or(p.map(|b| self.tests(b)).collect()),
            Rule::not_test => TestKind::Not(self.tests(p.want())),
            Rule::forall_test | Rule::exist_test => {
                let (ty, var) = (self.name(p.want()), self.name(p.want()));
                let guard = self.tests(p.want());
                let body = p.next().map_or_else(Vec::new, |b| self.tests(b));
                if rule == Rule::forall_test {
                    TestKind::Forall { ty, var, guard, body }
                } else {
                    TestKind::Exist { ty, var, guard, body }
                }
            }
            Rule::comparison => {
                let left = p.want();
                if let Some(belief) = belief(&left).filter(|_| p.is_last()) {
                    return self.believed(belief, span);
                }
                let left = self.expr(left);
                match p.next() {
                    None => TestKind::Holds(left),
                    Some(op) => TestKind::Compare {
                        op: self.test_op(&op),
                        left,
                        right: self.expr(p.want()),
                    },
                }
            }
            other => unreachable!("builder: {other:?} is no test"),
        };
        Test { kind, span }
    }

    pub(super) fn test_op(&mut self, pair: &Pair<'_, Rule>) -> TestOp {
        match pair.as_str() {
            "==" => TestOp::Equal,
            "!=" => TestOp::NotEqual,
            "<" => TestOp::Less,
            "<=" => TestOp::LessEqual,
            ">" => TestOp::Greater,
            ">=" => TestOp::GreaterEqual,
            ">>" => TestOp::Member,
            "!>>" => TestOp::NotMember,
            "=" => {
                let message = "`=` assigns, and this is a test";
                let problem = Problem::error("hatp::assign-in-test", message, self.span(pair), "this sets a value");
                self.problems.push(problem.help("write `==` to compare"));
                TestOp::Equal
            }
            other => unreachable!("builder: `{other}` is no comparison"),
        }
    }

    fn effects(&mut self, block: Pair<'_, Rule>) -> Vec<Effect> {
        let effects: Vec<Option<Effect>> = parts(block).map(|e| self.effect(parts(e).want())).collect();
        effects.into_iter().flatten().collect()
    }

    /// Returns the effect; `None` where nothing is set, which has been reported.
    fn effect(&mut self, pair: Pair<'_, Rule>) -> Option<Effect> {
        let span = self.span(&pair);
        Some(match pair.as_rule() {
            Rule::assignment => Effect::Assign(self.assignment(pair)),
            Rule::told => Effect::Assign(self.told(pair)?),
            Rule::forall_effect => {
                let mut p = parts(pair);
                Effect::Forall {
                    ty: self.name(p.want()),
                    var: self.name(p.want()),
                    guard: self.tests(p.want()),
                    effects: self.effects(p.want()),
                    span,
                }
            }
            Rule::if_effect => {
                let mut p = parts(pair);
                Effect::If {
                    test: self.tests(p.want()),
                    then: self.effects(p.want()),
                    otherwise: p.next().map_or_else(Vec::new, |b| self.effects(b)),
                    span,
                }
            }
            other => unreachable!("builder: {other:?} is no effect"),
        })
    }

    fn assignment(&mut self, pair: Pair<'_, Rule>) -> Assignment {
        let span = self.span(&pair);
        let mut p = parts(pair);
        let target = self.path(p.want());
        let (op, op_span) = self.assign_op(&p.want());
        Assignment {
            believer: None,
            target,
            op,
            op_span,
            value: self.expr(p.want()),
            span,
        }
    }

    pub(super) fn assign_op(&mut self, op: &Pair<'_, Rule>) -> (AssignOp, Span) {
        let op_span = self.span(op);
        let op = match op.as_str() {
            "<<=" => AssignOp::Add,
            "=>>" => AssignOp::Remove,
            "==" => {
                let message = "`==` compares, and this sets a value";
                let problem = Problem::error("hatp::compare-in-effect", message, op_span, "this compares");
                self.problems.push(problem.help("write `=` to set the value"));
                AssignOp::Set
            }
            _ => AssignOp::Set,
        };
        (op, op_span)
    }

    pub(super) fn path(&mut self, pair: Pair<'_, Rule>) -> Path {
        let span = self.span(&pair);
        let path = self.path_of(parts(pair), span);
        if path.steps.len() > MAX_STEPS {
            let message = format!("a path has more than {MAX_STEPS} steps");
            let problem = Problem::error("hatp::too-large", message, span, "this path");
            self.problems.push(problem.help("name a part of it with `let`"));
        }
        path
    }

    /// Returns the path that these words and arguments are.
    pub(super) fn path_of<'i>(&mut self, words: impl Iterator<Item = Pair<'i, Rule>>, span: Span) -> Path {
        let mut words = words.peekable();
        let root = words.next().map(|root| self.name(root));
        let mut steps: Vec<PathStep> = Vec::new();
        while let Some(word) = words.next() {
            let name = self.name(word);
            let (mut args, mut span) = (Vec::new(), name.span);
            if let Some(pair) = words.next_if(|p| p.as_rule() == Rule::step_args) {
                span = span.to(self.span(&pair));
                args = self.step_args(pair);
            }
            if steps.len() < MAX_STEPS + 1 {
                steps.push(PathStep { name, args, span });
            }
        }
        let root = root.unwrap_or_else(|| unreachable!("builder: a path has a first word"));
        Path { root, steps, span }
    }

    fn step_args(&mut self, pair: Pair<'_, Rule>) -> Vec<Expr> {
        let mut args = Vec::new();
        for part in parts(pair) {
            if part.as_rule() == Rule::belief_op {
                self.stray_belief(&part);
            } else {
                args.push(self.expr(part));
            }
        }
        args
    }

    pub(super) fn call(&mut self, pair: Pair<'_, Rule>) -> Call {
        let span = self.span(&pair);
        let mut p = parts(pair);
        Call {
            name: self.name(p.want()),
            args: parts(p.want()).map(|a| self.expr(a)).collect(),
            span,
        }
    }

    /// Reads an expression; the outermost one counts the operators of all within.
    pub(super) fn expr(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let outer = (self.is_inside, self.n_operators);
        if !self.is_inside {
            (self.is_inside, self.n_operators) = (true, 0);
        }
        let expr = self.operands(pair);
        if !outer.0 {
            (self.is_inside, self.n_operators) = outer;
        }
        expr
    }

    /// Reads operands with operators between them, from left to right; `*` and `/` bind tighter than `+` and `-`.
    fn operands(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut p = parts(pair);
        let mut sum: Option<(Expr, ArithmeticOp)> = None;
        let mut product = self.operand(p.want());
        while let Some(op) = p.next() {
            self.n_operators += 1;
            if self.n_operators > MAX_OPERATORS {
                let message = format!("an expression has more than {MAX_OPERATORS} operators");
                let problem = Problem::error("hatp::too-large", message, self.span(&op), "one too many");
                self.problems.push(problem.help("name parts of it with functions"));
                break;
            }
            let op = match op.as_str() {
                "+" => ArithmeticOp::Add,
                "-" => ArithmeticOp::Subtract,
                "*" => ArithmeticOp::Multiply,
                _ => ArithmeticOp::Divide,
            };
            let right = self.operand(p.want());
            if matches!(op, ArithmeticOp::Multiply | ArithmeticOp::Divide) {
                product = arithmetic(product, op, right);
            } else {
                sum = Some((added(sum, product), op));
                product = right;
            }
        }
        added(sum, product)
    }

    fn operand(&mut self, pair: Pair<'_, Rule>) -> Expr {
        if pair.as_rule() != Rule::negated {
            return self.primary(pair);
        }
        let span = self.span(&pair);
        let inner = self.primary(parts(pair).want());
        Expr {
            kind: ExprKind::Negate(Box::new(inner)),
            span,
        }
    }

    fn primary(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::number => {
                let number = pair.as_str().parse::<f64>().ok().filter(|x| x.is_finite());
                if number.is_none() {
                    let message = format!("`{}` is too large for a number", pair.as_str());
                    let problem = Problem::error("hatp::syntax", message, span, "beyond 1.7e308");
                    self.problems.push(problem);
                }
                ExprKind::Number(number.unwrap_or(0.0))
            }
            Rule::string => ExprKind::String(unescaped(pair.as_str())),
            Rule::boolean => ExprKind::Bool(pair.as_str() == "true"),
            Rule::null => ExprKind::Null,
            Rule::compat_null => {
                let message = format!("a missing value is written `NULL`, not `{}`", pair.as_str());
                let problem = Problem::error("hatp::null-spelling", message, span, "");
                self.problems.push(problem.help("write `NULL`"));
                ExprKind::Null
            }
            Rule::list => ExprKind::List(parts(pair).map(|e| self.expr(e)).collect()),
            Rule::tuple => {
                let mut p = parts(pair);
                let first = self.expr(p.want());
                match p.next() {
                    None => return Expr { span, ..first },
                    Some(second) => {
                        let second = self.expr(second);
                        ExprKind::Pair(Box::new(first), Box::new(second))
                    }
                }
            }
            Rule::named => {
                let is_call = pair.clone().into_inner().any(|p| p.as_rule() == Rule::args);
                if is_call {
                    ExprKind::Call(self.call(pair))
                } else {
                    ExprKind::Path(self.path(pair))
                }
            }
            other => unreachable!("builder: {other:?} is no value"),
        };
        Expr { kind, span }
    }
}

fn added(sum: Option<(Expr, ArithmeticOp)>, product: Expr) -> Expr {
    match sum {
        Some((left, op)) => arithmetic(left, op, product),
        None => product,
    }
}

fn arithmetic(left: Expr, op: ArithmeticOp, right: Expr) -> Expr {
    let span = left.span.to(right.span);
    Expr {
        kind: ExprKind::Arithmetic {
            op,
            left: Box::new(left),
            right: Box::new(right),
        },
        span,
    }
}

/// Returns a string literal's text: without quotes, with its escapes replaced.
fn unescaped(literal: &str) -> String {
    let inner = literal.strip_prefix('"').and_then(|s| s.strip_suffix('"'));
    let mut out = String::new();
    let mut chars = inner.unwrap_or(literal).chars();
    while let Some(c) = chars.next() {
        match (c, c == '\\') {
            (_, true) => match chars.next() {
                Some('n') => out.push('\n'),
                Some('t') => out.push('\t'),
                Some(other) => out.push(other),
                None => {}
            },
            (c, false) => out.push(c),
        }
    }
    out
}
