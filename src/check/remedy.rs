//! A value of the wrong type: what is said, and what helps.

use super::expr::Walk;
use super::kinds::Kind;
use super::problems;
use super::problems::noted;
use crate::diag::Problem;
use crate::source::Span;
use crate::syntax::ast::{self, ExprKind};

impl Walk<'_> {
    /// Returns what to say of an expression that is not of the kind `wanted`; `None` if it is.
    pub(super) fn misfit(&self, expr: &ast::Expr, found: Kind, wanted: Kind) -> Option<Problem> {
        let domain = &self.names.domain;
        if found.fits(wanted, domain) {
            return None;
        }
        let problem = problems::wrong_type(expr.span, &wanted.words(domain), &found.words(domain));
        Some(problem.maybe_help(self.remedy(expr, found, wanted)))
    }

    /// Returns what to write instead.
    fn remedy(&self, expr: &ast::Expr, found: Kind, wanted: Kind) -> Option<String> {
        let domain = &self.names.domain;
        match (found, wanted) {
            (Kind::String, Kind::Entity(_) | Kind::Any) => match &expr.kind {
                ExprKind::String(s) if self.names.entities.contains_key(s) => {
                    Some(format!("write `{s}` without quotes"))
                }
                _ => None,
            },
            (Kind::Number, Kind::Bool) => Some("compare it with another number: `>`, `==` ...".into()),
            (Kind::Bool, Kind::Number) => Some("a truth value is tested alone: `A.attribute;`".into()),
            (Kind::Entity(of), Kind::Number | Kind::Bool | Kind::String) => {
                // Its own attributes first, then those of the types above.
                let mut of = Some(of);
                while let Some(ty) = of {
                    let own = domain
                        .attributes
                        .iter()
                        .filter(|a| a.owner == ty && a.arguments.is_empty());
                    let mut fit = own.filter(|a| Kind::of(a.base, a.is_set).fits(wanted, domain));
                    if let Some(attribute) = fit.next() {
                        return Some(format!("did you mean its attribute `{}`?", attribute.name));
                    }
                    of = domain.types.get(ty.index()).and_then(|t| t.parent);
                }
                None
            }
            (_, Kind::Set(of @ Some(_))) if found.fits(Kind::element(of), domain) => {
                Some("a set of one is written in brackets: `[VALUE]`".into())
            }
            (Kind::Set(_), Kind::Entity(ty)) => {
                let ty = domain.types.get(ty.index()).map_or("?", |t| t.name.as_str());
                Some(format!("choose one of them: `X = SELECT({ty}, {{X >> SET;}});`"))
            }
            (Kind::Entity(wide), Kind::Entity(narrow)) if domain.is_subtype(narrow, wide) => {
                let name = |t: crate::ir::TypeId| domain.types.get(t.index()).map_or("?", |t| t.name.as_str());
                let (wide, narrow) = (name(wide), name(narrow));
                Some(format!(
                    "not every `{wide}` is a `{narrow}`: declare it as `{narrow}` where it comes from"
                ))
            }
            (Kind::Null, _) => Some("`NULL` stands for no value, and one is needed".into()),
            _ => None,
        }
    }

    /// Adds where something is declared, and how, to an error about the expression at `span`.
    pub(super) fn declared_in(problem: Problem, declared: Span, signature: &str) -> Problem {
        let has_help = problem.help.is_some();
        let problem = noted(problem, Some(declared), "declared here");
        if has_help {
            return problem;
        }
        problem.help(format!("it is declared as `{signature}`"))
    }

    /// Returns `Pick(Agent A, Object O)`.
    pub(super) fn signature(&self, name: &str, params: &[(String, Kind)]) -> String {
        let domain = &self.names.domain;
        let param = |(name, kind): &(String, Kind)| format!("{} {name}", kind.declared(domain));
        let params: Vec<String> = params.iter().map(param).collect();
        format!("{name}({})", params.join(", "))
    }
}
