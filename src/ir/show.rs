//! Expressions as the language writes them.

use super::{ArithmeticOp, CompareOp, Domain, Expr, Var};

impl CompareOp {
    /// Returns the operator as the language writes it.
    pub fn symbol(self) -> &'static str {
        match self {
            CompareOp::Equal => "==",
            CompareOp::NotEqual => "!=",
            CompareOp::Less => "<",
            CompareOp::LessEqual => "<=",
            CompareOp::Greater => ">",
            CompareOp::GreaterEqual => ">=",
        }
    }
}

impl ArithmeticOp {
    /// Returns the operator as the language writes it.
    pub fn symbol(self) -> &'static str {
        match self {
            ArithmeticOp::Add => "+",
            ArithmeticOp::Subtract => "-",
            ArithmeticOp::Multiply => "*",
            ArithmeticOp::Divide => "/",
        }
    }
}

/// Returns the expression as the language writes it; `name` says how a variable is written: by its name or by its value.
pub fn show_expr(domain: &Domain, expr: &Expr, name: &dyn Fn(Var) -> String) -> String {
    let show = |e: &Expr| show_expr(domain, e, name);
    let list = |es: &[Expr]| es.iter().map(show).collect::<Vec<_>>().join(", ");
    match expr {
        Expr::Const(value) => domain.show(value),
        Expr::Var(var) => name(*var),
        Expr::Attribute { base, attribute, args } => {
            let attribute = &domain.attributes[attribute.index()];
            let (args, believer) = args.split_at(attribute.arguments.len().min(args.len()));
            let value = match args.is_empty() {
                true => format!("{}.{}", show(base), attribute.name),
                false => format!("{}.{}({})", show(base), attribute.name, list(args)),
            };
            match believer.first() {
                Some(agent) => format!("{}.believes({value})", show(agent)),
                None => value,
            }
        }
        Expr::Size(set) => format!("size({})", show(set)),
        Expr::List(elements) => format!("[{}]", list(elements)),
        Expr::Request { request, args } => format!("{}({})", domain.requests[request.index()].name, list(args)),
        Expr::Fact { fact, args } => format!("{}({})", domain.facts[fact.index()].name, list(args)),
        Expr::Arithmetic { op, left, right } => format!("({} {} {})", show(left), op.symbol(), show(right)),
        Expr::Negate(inner) => format!("-{}", show(inner)),
        Expr::SetWith { set, element } => format!("({} + {})", show(set), show(element)),
        Expr::SetWithout { set, element } => format!("({} - {})", show(set), show(element)),
        Expr::GeometricCost => "GetGRPCost()".into(),
        Expr::GeometricDuration => "GetGRPDuration()".into(),
    }
}
