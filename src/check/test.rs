//! Tests: preconditions, goals, filters and guards.

use super::expr::Walk;
use super::kinds::Kind;
use super::problems;
use crate::diag::Problem;
use crate::ir::{CompareOp, Expr, Test};
use crate::syntax::ast::{self, TestKind, TestOp};

impl Walk<'_> {
    /// Returns the conjunction of `tests`.
    pub(super) fn tests(&mut self, tests: &[ast::Test]) -> Test {
        let wanted = std::mem::replace(&mut self.wanted, "bool");
        let mut all: Vec<Test> = tests.iter().map(|t| self.test(t)).collect();
        self.wanted = wanted;
        match (all.len(), all.pop()) {
            (1, Some(only)) => only,
            (_, Some(last)) => {
                all.push(last);
                Test::And(all)
            }
            (_, None) => Test::always(),
        }
    }

    pub(super) fn test(&mut self, test: &ast::Test) -> Test {
        match &test.kind {
            TestKind::Or(blocks) => Test::Or(blocks.iter().map(|b| self.tests(b)).collect()),
            TestKind::Not(tests) => Test::Not(Box::new(self.tests(tests))),
            TestKind::Forall { ty, var, guard, body } | TestKind::Exist { ty, var, guard, body } => {
                let inside = |walk: &mut Self| (walk.tests(guard), walk.tests(body));
                let (var, ty, (guard, body)) = self.quantified(ty, var, inside);
                let Some(ty) = ty else { return Test::always() };
                let (guard, body) = (Box::new(guard), Box::new(body));
                if matches!(test.kind, TestKind::Forall { .. }) {
                    Test::Forall { var, ty, guard, body }
                } else {
                    Test::Exist { var, ty, guard, body }
                }
            }
            TestKind::Holds(expr) => Test::Holds(self.expect(expr, Kind::Bool)),
            TestKind::Believes(agent, inner) => self.believes(agent, inner),
            TestKind::Compare { op, left, right } => self.compare(*op, left, right),
        }
    }

    fn compare(&mut self, op: TestOp, left: &ast::Expr, right: &ast::Expr) -> Test {
        let op = match op {
            TestOp::Equal => return self.equality(CompareOp::Equal, left, right),
            TestOp::NotEqual => return self.equality(CompareOp::NotEqual, left, right),
            TestOp::Member => return self.member(left, right),
            TestOp::NotMember => return Test::Not(Box::new(self.member(left, right))),
            TestOp::Less => CompareOp::Less,
            TestOp::LessEqual => CompareOp::LessEqual,
            TestOp::Greater => CompareOp::Greater,
            TestOp::GreaterEqual => CompareOp::GreaterEqual,
        };
        self.wanted = "number";
        let left = self.expect(left, Kind::Number);
        let right = self.expect(right, Kind::Number);
        self.wanted = "bool";
        Test::Compare { op, left, right }
    }

    fn equality(&mut self, op: CompareOp, left: &ast::Expr, right: &ast::Expr) -> Test {
        let is_bool = |e: &ast::Expr| matches!(e.kind, ast::ExprKind::Bool(_));
        self.wanted = if is_bool(left) || is_bool(right) {
            "bool"
        } else {
            "number"
        };
        let (l, left_kind) = self.single(left);
        let (r, right_kind) = self.single(right);
        self.wanted = "bool";
        if !left_kind.comparable(right_kind, &self.names.domain) {
            let (one, other) = (self.words(left_kind), self.words(right_kind));
            let message = format!("can't compare {one} with {other}");
            let mut problem = Problem::error("hatp::wrong-type", message, right.span, format!("this is {other}"))
                .note(left.span, format!("this is {one}"));
            if matches!((left_kind, right_kind), (Kind::Set(_), _) | (_, Kind::Set(_))) {
                problem = problem.help("ask whether it is a member with `element >> set`, or for `size(set) == 0`");
            }
            self.problems.push(problem);
        }
        Test::Compare { op, left: l, right: r }
    }

    fn member(&mut self, element: &ast::Expr, set: &ast::Expr) -> Test {
        let (e, element_kind) = self.single(element);
        let (s, set_kind) = self.single(set);
        match (element_kind, set_kind) {
            (_, Kind::Unknown | Kind::Set(None)) | (Kind::Unknown, Kind::Set(_)) => {}
            (_, Kind::Set(of)) => {
                let domain = &self.names.domain;
                let wanted = Kind::element(of);
                if !(element_kind.fits(wanted, domain) || wanted.fits(element_kind, domain)) {
                    let wanted = self.words(wanted);
                    let problem = self.mismatch(element.span, &wanted, element_kind);
                    self.problems
                        .push(problem.help("`>>` has the element on its left and the set on its right"));
                }
            }
            (_, other) => {
                let words = self.words(other);
                let problem = problems::wrong_type(set.span, "a set", &words);
                self.problems.push(match other {
                    Kind::Number => problem.help("`>>` asks for a member; to compare numbers write `>`"),
                    _ => problem.help("`>>` has the element on its left and the set on its right"),
                });
            }
        }
        Test::Member { element: e, set: s }
    }

    /// Returns an expression for a bare number, `wanted` being restored after.
    pub(super) fn number(&mut self, expr: &ast::Expr) -> Expr {
        let wanted = std::mem::replace(&mut self.wanted, "number");
        let out = self.expect(expr, Kind::Number);
        self.wanted = wanted;
        out
    }
}
