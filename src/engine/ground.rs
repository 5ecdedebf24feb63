//! The constraints of an operator, ready to be asked of the world that its projection leads to (thesis 4.3.3).
//!
//! Quantifiers are expanded and everything symbolic is read in the state before the action; what is left are requests. A fact
//! that the domain defines is expanded to its body. Where a value is missing (a path through NULL), a literal is false, and
//! `!=` is true, as in every test. An argument of a request is symbolic: a request about a request has no value.

use super::eval::{Context, compare, frame};
use super::reasoner::{Formula, Term};
use super::sets;
use crate::ir::{ArithmeticOp, CompareOp, Expr, Test, TypeId, Value, Var};

const FALSE: Formula = Formula::Or(Vec::new());

/// Returns the test as questions to another world.
pub(super) fn formula(context: &mut Context<'_>, test: &Test, frame: &mut [Value]) -> Formula {
    match test {
        Test::And(parts) => and(parts.iter().map(|t| formula(context, t, frame))),
        Test::Or(parts) => or(parts.iter().map(|t| formula(context, t, frame))),
        Test::Not(inner) => not(formula(context, inner, frame)),
        Test::Compare { op, left, right } => compared(context, *op, left, right, frame),
        Test::Member { element, set } => member(context, element, set, frame),
        Test::Forall { var, ty, guard, body } => {
            let cases = each(context, *var, *ty, frame, &mut |context, frame| {
                let guard = formula(context, guard, frame);
                if guard == FALSE {
                    return Formula::TRUE;
                }
                or([not(guard), formula(context, body, frame)])
            });
            and(cases)
        }
        Test::Exist { var, ty, guard, body } => {
            let cases = each(context, *var, *ty, frame, &mut |context, frame| {
                let guard = formula(context, guard, frame);
                if guard == FALSE {
                    return FALSE;
                }
                and([guard, formula(context, body, frame)])
            });
            or(cases)
        }
        Test::Holds(expr) => truth(context, expr, frame),
    }
}

fn each(
    context: &mut Context<'_>,
    var: Var,
    ty: TypeId,
    frame: &mut [Value],
    case: &mut dyn FnMut(&mut Context<'_>, &mut [Value]) -> Formula,
) -> Vec<Formula> {
    let domain = context.domain;
    let entities = domain.types[ty.index()].entities.iter();
    entities
        .map(|e| {
            frame[var.index()] = Value::Entity(*e);
            case(context, frame)
        })
        .collect()
}

fn constant(truth: bool) -> Formula {
    if truth { Formula::TRUE } else { FALSE }
}

/// Says that all hold; what is known already is left out.
fn and(parts: impl IntoIterator<Item = Formula>) -> Formula {
    let mut open = Vec::new();
    for part in parts {
        match part {
            Formula::Or(none) if none.is_empty() => return FALSE,
            Formula::And(more) => open.extend(more),
            part => open.push(part),
        }
    }
    match open.len() {
        1 => open.swap_remove(0),
        _ => Formula::And(open),
    }
}

/// Says that one holds; what is known already is left out.
fn or(parts: impl IntoIterator<Item = Formula>) -> Formula {
    let mut open = Vec::new();
    for part in parts {
        match part {
            Formula::And(all) if all.is_empty() => return Formula::TRUE,
            Formula::Or(more) => open.extend(more),
            part => open.push(part),
        }
    }
    match open.len() {
        1 => open.swap_remove(0),
        _ => Formula::Or(open),
    }
}

fn not(part: Formula) -> Formula {
    match part {
        Formula::And(all) if all.is_empty() => FALSE,
        Formula::Or(none) if none.is_empty() => Formula::TRUE,
        Formula::Not(inner) => *inner,
        part => Formula::Not(Box::new(part)),
    }
}

/// Returns what says that a truth value is true.
fn truth(context: &mut Context<'_>, expr: &Expr, frame: &mut [Value]) -> Formula {
    match expr {
        Expr::Fact { fact, args } => expanded(context, *fact, args, frame).unwrap_or(FALSE),
        _ => match term(context, expr, frame) {
            Some(Term::Request { request, args }) => Formula::Holds { request, args },
            Some(Term::Value(value)) => constant(value == Value::Bool(true)),
            Some(Term::Arithmetic { .. }) | None => FALSE,
        },
    }
}

/// Returns the body of a fact about `args`, or `None` where an argument has no value.
fn expanded(
    context: &mut Context<'_>,
    fact: crate::ir::FactId,
    args: &[Expr],
    frame_of_call: &mut [Value],
) -> Option<Formula> {
    let args = values(context, args, frame_of_call)?;
    let fact = &context.domain.facts[fact.index()];
    Some(formula(context, &fact.body, &mut frame(&args, fact.n_vars)))
}

fn values(context: &mut Context<'_>, args: &[Expr], frame: &mut [Value]) -> Option<Vec<Value>> {
    let values = args.iter().map(|a| match term(context, a, frame)? {
        Term::Value(value) => Some(value),
        Term::Request { .. } | Term::Arithmetic { .. } => None,
    });
    values.collect()
}

fn compared(context: &mut Context<'_>, op: CompareOp, left: &Expr, right: &Expr, frame: &mut [Value]) -> Formula {
    // A fact has no term: what compares it with a truth value is a formula of its own.
    if let (fact @ Expr::Fact { .. }, other) | (other, fact @ Expr::Fact { .. }) = (left, right) {
        let is_truth = match other {
            Expr::Fact { .. } => true,
            _ => matches!(
                term(context, other, frame),
                Some(Term::Request { .. } | Term::Value(Value::Bool(_)))
            ),
        };
        let equal = if is_truth {
            let (one, two) = (truth(context, fact, frame), truth(context, other, frame));
            or([and([one.clone(), two.clone()]), and([not(one), not(two)])])
        } else {
            FALSE
        };
        return match op {
            CompareOp::Equal => equal,
            CompareOp::NotEqual => not(equal),
            CompareOp::Less | CompareOp::LessEqual | CompareOp::Greater | CompareOp::GreaterEqual => FALSE,
        };
    }
    match (term(context, left, frame), term(context, right, frame)) {
        (Some(Term::Value(left)), Some(Term::Value(right))) => constant(compare(op, &left, &right)),
        (Some(left), Some(right)) => Formula::Compare { op, left, right },
        (None, _) | (_, None) => constant(op == CompareOp::NotEqual),
    }
}

fn member(context: &mut Context<'_>, element: &Expr, set: &Expr, frame: &mut [Value]) -> Formula {
    let Some(element) = term(context, element, frame) else {
        return FALSE;
    };
    let equals = |element: &Term, other: Term| match (element, &other) {
        (Term::Value(a), Term::Value(b)) => constant(sets::equal(a, b)),
        _ => Formula::Compare {
            op: CompareOp::Equal,
            left: element.clone(),
            right: other,
        },
    };
    // The members of a list may be requests, too.
    if let Expr::List(elements) = set {
        let members: Option<Vec<Term>> = elements.iter().map(|e| term(context, e, frame)).collect();
        return members.map_or(FALSE, |all| or(all.into_iter().map(|m| equals(&element, m))));
    }
    match (element, term(context, set, frame)) {
        (Term::Value(element), Some(Term::Value(set))) => constant(sets::contains(&set, &element)),
        (open, Some(Term::Value(Value::Scalars(set)))) => {
            or(set.iter().map(|member| equals(&open, Term::Value(member.clone()))))
        }
        _ => FALSE,
    }
}

/// Returns the value, or what is to be asked for it; `None` where there is none.
fn term(context: &mut Context<'_>, expr: &Expr, frame: &mut [Value]) -> Option<Term> {
    match expr {
        Expr::Request { request, args } => Some(Term::Request {
            request: *request,
            args: values(context, args, frame)?,
        }),
        Expr::Arithmetic { op, left, right } => {
            let (left, right) = (term(context, left, frame)?, term(context, right, frame)?);
            arithmetic(context, expr, frame, *op, left, right)
        }
        Expr::Negate(inner) => {
            let inner = term(context, inner, frame)?;
            arithmetic(
                context,
                expr,
                frame,
                ArithmeticOp::Subtract,
                Term::Value(Value::Number(0.0)),
                inner,
            )
        }
        // Only a truth value, and that is no term.
        Expr::Fact { .. } => None,
        Expr::Size(inner) if asks(inner) => None,
        Expr::Attribute { base, args, .. } if asks(base) || args.iter().any(asks) => None,
        Expr::SetWith { set, element } | Expr::SetWithout { set, element } if asks(set) || asks(element) => None,
        Expr::List(elements) if elements.iter().any(asks) => None,
        Expr::Const(_)
        | Expr::Var(_)
        | Expr::Attribute { .. }
        | Expr::Size(_)
        | Expr::List(_)
        | Expr::SetWith { .. }
        | Expr::SetWithout { .. }
        | Expr::GeometricCost
        | Expr::GeometricDuration => context.value(expr, frame).map(Term::Value),
    }
}

/// Returns the operation on two terms, or its value where nothing is open in it.
fn arithmetic(
    context: &mut Context<'_>,
    expr: &Expr,
    frame: &mut [Value],
    op: ArithmeticOp,
    left: Term,
    right: Term,
) -> Option<Term> {
    let is_open = |t: &Term| !matches!(t, Term::Value(_));
    if !is_open(&left) && !is_open(&right) {
        return context.value(expr, frame).map(Term::Value);
    }
    Some(Term::Arithmetic {
        op,
        left: Box::new(left),
        right: Box::new(right),
    })
}

/// Says whether the expression asks something of the world.
fn asks(expr: &Expr) -> bool {
    match expr {
        Expr::Request { .. } | Expr::Fact { .. } => true,
        Expr::Const(_) | Expr::Var(_) | Expr::GeometricCost | Expr::GeometricDuration => false,
        Expr::Attribute { base, args, .. } => asks(base) || args.iter().any(asks),
        Expr::Size(inner) | Expr::Negate(inner) => asks(inner),
        Expr::List(elements) => elements.iter().any(asks),
        Expr::Arithmetic { left, right, .. } => asks(left) || asks(right),
        Expr::SetWith { set, element } | Expr::SetWithout { set, element } => asks(set) || asks(element),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::reasoner::Granted;
    use super::super::state::State;
    use super::*;
    use crate::ir::{
        Attribute, AttributeId, Base, Domain, Entity, EntityId, Fact, FactId, Request, RequestId, Slot, SlotId, Type,
    };

    const R: EntityId = EntityId(0);
    const CUP: EntityId = EntityId(1);
    const BOX: EntityId = EntityId(2);
    const REACHABLE: RequestId = RequestId(0);
    const DISTANCE: RequestId = RequestId(1);

    /// An agent R with a set `placed`, which holds BOX, and a set of numbers `limits`; two objects; the requests
    /// `isReachable` and `distance`; the fact `isClose(a, b)`: their distance is below 0.5.
    fn domain() -> Domain {
        let name = |name: &str| name.to_owned();
        let ty = |n: &str, entities: &[EntityId]| Type {
            name: name(n),
            parent: None,
            entities: entities.to_vec(),
        };
        let entity = |n: &str, ty| Entity {
            name: name(n),
            ty: TypeId(ty),
        };
        let set = |n: &str, base, slot| Attribute {
            name: name(n),
            owner: TypeId(0),
            is_static: false,
            is_set: true,
            base,
            fact: None,
            arguments: Vec::new(),
            believer: None,
            slots: vec![Some(SlotId(slot)), None, None],
        };
        let mut limits = crate::ir::ScalarSet::default();
        limits.insert(Value::Number(1.0));
        limits.insert(Value::Number(2.0));
        Domain {
            types: vec![ty("Agent", &[R]), ty("Object", &[CUP, BOX])],
            entities: vec![entity("R", 0), entity("CUP", 1), entity("BOX", 1)],
            attributes: vec![
                set("placed", Base::Entity(TypeId(1)), 0),
                set("limits", Base::Number, 1),
            ],
            slots: [0, 1]
                .map(|a| Slot {
                    entity: R,
                    attribute: AttributeId(a),
                })
                .to_vec(),
            initial: vec![
                Value::Set(Arc::new([BOX].into_iter().collect())),
                Value::Scalars(Arc::new(limits)),
            ],
            requests: vec![
                Request {
                    name: name("isReachable"),
                    result: Base::Bool,
                },
                Request {
                    name: name("distance"),
                    result: Base::Number,
                },
            ],
            facts: vec![Fact {
                name: name("isClose"),
                params: vec![name("a"), name("b")],
                n_vars: 2,
                body: Test::Compare {
                    op: CompareOp::Less,
                    left: distance(var(0), var(1)),
                    right: number(0.5),
                },
            }],
            ..Domain::default()
        }
    }

    fn var(i: u32) -> Expr {
        Expr::Var(Var(i))
    }

    fn number(x: f64) -> Expr {
        Expr::Const(Value::Number(x))
    }

    fn distance(a: Expr, b: Expr) -> Expr {
        Expr::Request {
            request: DISTANCE,
            args: vec![a, b],
        }
    }

    fn attribute(i: u32) -> Expr {
        Expr::Attribute {
            base: Box::new(Expr::Const(Value::Entity(R))),
            attribute: AttributeId(i),
            args: Box::default(),
        }
    }

    fn is_close(a: Expr, b: Expr) -> Expr {
        Expr::Fact {
            fact: FactId(0),
            args: vec![a, b],
        }
    }

    /// Grounds a test about variable 0, which is CUP, and a free variable 1.
    fn grounded(test: &Test) -> Formula {
        let domain = domain();
        let mut state = State::new(&domain, &[]);
        let mut reasoner = Granted::default();
        let mut context = Context::new(&domain, &mut state, &mut reasoner);
        formula(&mut context, test, &mut [Value::Entity(CUP), Value::Null])
    }

    fn of(a: EntityId, b: EntityId) -> Vec<Value> {
        vec![Value::Entity(a), Value::Entity(b)]
    }

    fn over_placed(body: Test, is_all: bool) -> Test {
        let guard = Box::new(Test::Member {
            element: var(1),
            set: attribute(0),
        });
        let (var, ty, body) = (Var(1), TypeId(1), Box::new(body));
        if is_all {
            Test::Forall { var, ty, guard, body }
        } else {
            Test::Exist { var, ty, guard, body }
        }
    }

    #[test]
    fn quantifiers_are_expanded_over_what_passes_the_guard_now() {
        let reachable = |e| {
            Test::Holds(Expr::Request {
                request: REACHABLE,
                args: vec![e, Expr::Const(Value::Entity(R))],
            })
        };
        let only_box = Formula::Holds {
            request: REACHABLE,
            args: of(BOX, R),
        };
        assert_eq!(grounded(&over_placed(reachable(var(1)), true)), only_box);
        assert_eq!(grounded(&over_placed(reachable(var(1)), false)), only_box);
        let not = Test::Not(Box::new(over_placed(reachable(var(1)), true)));
        assert_eq!(grounded(&not), Formula::Not(Box::new(only_box)));
    }

    #[test]
    fn what_reads_the_symbols_alone_is_decided_at_once() {
        let placed = |e| Test::Member {
            element: Expr::Const(Value::Entity(e)),
            set: attribute(0),
        };
        assert_eq!(grounded(&Test::And(vec![placed(BOX), placed(BOX)])), Formula::TRUE);
        assert_eq!(grounded(&Test::Or(vec![placed(CUP), placed(CUP)])), FALSE);
        assert_eq!(grounded(&Test::Not(Box::new(placed(CUP)))), Formula::TRUE);
    }

    #[test]
    fn a_fact_that_the_domain_defines_is_its_body() {
        let body = Formula::Compare {
            op: CompareOp::Less,
            left: Term::Request {
                request: DISTANCE,
                args: of(CUP, BOX),
            },
            right: Term::Value(Value::Number(0.5)),
        };
        let close = || is_close(var(0), Expr::Const(Value::Entity(BOX)));
        assert_eq!(grounded(&Test::Holds(close())), body);
        let compared = |op, truth| {
            grounded(&Test::Compare {
                op,
                left: close(),
                right: Expr::Const(Value::Bool(truth)),
            })
        };
        assert_eq!(compared(CompareOp::Equal, true), body);
        assert_eq!(compared(CompareOp::NotEqual, false), body);
        assert_eq!(compared(CompareOp::Equal, false), Formula::Not(Box::new(body)));
        // An argument without a value.
        let without = is_close(
            var(0),
            Expr::Attribute {
                base: Box::new(var(1)),
                attribute: AttributeId(0),
                args: Box::default(),
            },
        );
        assert_eq!(grounded(&Test::Holds(without)), FALSE);
    }

    #[test]
    fn numbers_that_are_open_stay_open() {
        let between = || distance(var(0), Expr::Const(Value::Entity(R)));
        let open = || Term::Request {
            request: DISTANCE,
            args: of(CUP, R),
        };
        let twice = Expr::Arithmetic {
            op: ArithmeticOp::Multiply,
            left: Box::new(between()),
            right: Box::new(Expr::Arithmetic {
                op: ArithmeticOp::Add,
                left: Box::new(number(1.0)),
                right: Box::new(number(1.0)),
            }),
        };
        let test = Test::Compare {
            op: CompareOp::GreaterEqual,
            left: twice,
            right: number(3.0),
        };
        let expected = Formula::Compare {
            op: CompareOp::GreaterEqual,
            left: Term::Arithmetic {
                op: ArithmeticOp::Multiply,
                left: Box::new(open()),
                right: Box::new(Term::Value(Value::Number(2.0))),
            },
            right: Term::Value(Value::Number(3.0)),
        };
        assert_eq!(grounded(&test), expected);
        let equals = |x| Formula::Compare {
            op: CompareOp::Equal,
            left: open(),
            right: Term::Value(Value::Number(x)),
        };
        let among = grounded(&Test::Member {
            element: between(),
            set: attribute(1),
        });
        assert_eq!(among, Formula::Or(vec![equals(1.0), equals(2.0)]));
    }
}
