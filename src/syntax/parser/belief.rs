//! `B.believes(O.isOn == T)`: a test, or with `=`, `<<=` or `=>>` an effect that tells an agent something.
//!
//! The grammar reads both as a path whose last step has an operator between its brackets, so that no text is read twice; here
//! they become what they mean. A belief that stands where neither a test nor an effect does is refused.

use pest::iterators::Pair;

use super::Rule;
use super::build::Builder;
use super::parts::parts;
use crate::diag::Problem;
use crate::source::Span;
use crate::syntax::ast::*;

/// The word of the last step.
const BELIEVES: &str = "believes";

/// The words of `B.helper`, and what stands between the brackets.
pub(super) struct Belief<'i> {
    believer: Vec<Pair<'i, Rule>>,
    parts: Vec<Pair<'i, Rule>>,
}

/// Returns the parts of an expression or path that is `B.believes(...)` alone.
pub(super) fn belief<'i>(pair: &Pair<'i, Rule>) -> Option<Belief<'i>> {
    let mut words: Vec<Pair<'i, Rule>> = match pair.as_rule() {
        Rule::expr => {
            let mut operands = parts(pair.clone());
            let named = operands.next().filter(|p| p.as_rule() == Rule::named)?;
            if operands.next().is_some() {
                return None;
            }
            parts(named).collect()
        }
        _ => parts(pair.clone()).collect(),
    };
    let args = words.pop().filter(|p| p.as_rule() == Rule::step_args)?;
    let is_belief = words.len() > 1 && words.pop()?.as_str() == BELIEVES;
    let parts: Vec<Pair<'i, Rule>> = parts(args).collect();
    // Several arguments are an attribute's, whose name happens to be the same.
    let is_one = parts.len() == 1 || parts.get(1).is_some_and(|op| op.as_rule() == Rule::belief_op);
    (is_belief && is_one).then_some(Belief { believer: words, parts })
}

impl Builder<'_> {
    /// Returns the agent and what stands between the brackets.
    fn believer<'i>(&mut self, belief: Belief<'i>) -> Option<(Path, std::vec::IntoIter<Pair<'i, Rule>>)> {
        let (first, last) = (belief.believer.first()?, belief.believer.last()?);
        let span = self.span(first).to(self.span(last));
        let path = self.path_of(belief.believer.into_iter(), span);
        Some((path, belief.parts.into_iter()))
    }

    /// Returns the test that `belief` is.
    pub(super) fn believed(&mut self, belief: Belief<'_>, span: Span) -> Test {
        let Some((believer, mut parts)) = self.believer(belief) else {
            unreachable!("builder: a belief has a believer")
        };
        let left = parts.next().map(|left| self.expr(left));
        let (op, right) = (parts.next(), parts.next());
        let (left, inner) = match (left, op, right) {
            (Some(left), Some(op), Some(right)) => {
                let op = self.belief_test_op(&op);
                let right = self.expr(right);
                let inner = left.span.to(right.span);
                (TestKind::Compare { op, left, right }, inner)
            }
            (Some(left), ..) => {
                let inner = left.span;
                (TestKind::Holds(left), inner)
            }
            (None, ..) => unreachable!("builder: something stands between the brackets"),
        };
        let inner = Test {
            kind: left,
            span: inner,
        };
        Test {
            kind: TestKind::Believes(believer, Box::new(inner)),
            span,
        }
    }

    fn belief_test_op(&mut self, op: &Pair<'_, Rule>) -> TestOp {
        match op.as_str() {
            "<<=" | "=>>" => {
                let message = format!("`{}` changes a set, and this is a test", op.as_str());
                let problem = Problem::error("hatp::assign-in-test", message, self.span(op), "this sets a value");
                self.problems.push(problem.help("write `>>` to ask for a member"));
                TestOp::Equal
            }
            _ => self.test_op(op),
        }
    }

    /// Returns what an effect or an initial value tells an agent.
    pub(super) fn told(&mut self, pair: Pair<'_, Rule>) -> Option<Assignment> {
        let span = self.span(&pair);
        let Some(path) = parts(pair).next() else {
            unreachable!("builder: the grammar promises a path")
        };
        let whole = self.span(&path);
        let Some((believer, mut parts)) = belief(&path).and_then(|b| self.believer(b)) else {
            let problem = Problem::error("hatp::syntax", "expected `=`, found `;`", span, "nothing is set here");
            self.problems.push(problem.help("write `A.attribute = value;`"));
            return None;
        };
        let (target, op, value) = (parts.next(), parts.next(), parts.next());
        let (Some(target), Some(op), Some(value)) = (target, op, value) else {
            return self.nothing_told(whole);
        };
        let Some(target) = self.told_path(target) else {
            return self.nothing_told(whole);
        };
        if !matches!(op.as_str(), "=" | "==" | "<<=" | "=>>") {
            return self.nothing_told(whole);
        }
        let (op, op_span) = self.assign_op(&op);
        Some(Assignment {
            believer: Some(believer),
            target,
            op,
            op_span,
            value: self.expr(value),
            span,
        })
    }

    fn told_path(&mut self, expr: Pair<'_, Rule>) -> Option<Path> {
        match self.expr(expr).kind {
            ExprKind::Path(path) => Some(path),
            _ => None,
        }
    }

    fn nothing_told(&mut self, span: Span) -> Option<Assignment> {
        let problem = Problem::error(
            "hatp::syntax",
            "expected what the agent is told",
            span,
            "this tells it nothing",
        );
        let help = "write `B.believes(A.attribute = value);`";
        self.problems.push(problem.help(help));
        None
    }

    /// Reports an operator between the brackets of a step where no belief can stand.
    pub(super) fn stray_belief(&mut self, op: &Pair<'_, Rule>) {
        let message = format!("`{}` does not stand between arguments", op.as_str());
        let problem = Problem::error("hatp::syntax", message, self.span(op), "expected `,` or `)`");
        let help = "a belief, `B.believes(O.isOn == T);`, stands alone as a test or an effect";
        self.problems.push(problem.help(help));
    }
}
