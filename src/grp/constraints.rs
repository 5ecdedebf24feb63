//! What must hold in the world that an action leads to (thesis 3.3.4.4, 4.3.3, 4.4.2): constraints that the domain adds to the
//! description's own final constraints.
//!
//! The conditions that follow from where the things stand are tested as soon as a placement is known, the others once the
//! end states of a candidate are known and before any motion is planned; the cheap ones first.

use super::requests::{Answer, Question};
use crate::engine::{Formula, Term};
use crate::ir::{ArithmeticOp, CompareOp, Domain, RequestId, Value};
use crate::world::{EntityRef, Scene};

/// A formula about questions that this room can answer.
#[derive(Debug, Clone)]
enum Condition {
    All(Vec<Condition>),
    Any(Vec<Condition>),
    Not(Box<Condition>),
    Holds(Asked),
    Compare { op: CompareOp, left: Side, right: Side },
}

#[derive(Debug, Clone)]
enum Side {
    Value(Value),
    Asked(Asked),
    Arithmetic {
        op: ArithmeticOp,
        left: Box<Side>,
        right: Box<Side>,
    },
}

/// A question; `None` where it makes no sense for its arguments, so that nothing about it holds.
type Asked = Option<Question>;

/// One of the conditions that must all hold.
#[derive(Debug, Clone)]
struct Constraint {
    /// As messages show it: `isReachable(RED_CUBE, BOB)`.
    text: String,
    condition: Condition,
    /// From when on the answer is known.
    from: Which,
    effort: u32,
}

/// All constraints of a call, the cheapest first.
#[derive(Debug, Clone, Default)]
pub(super) struct Constraints(Vec<Constraint>);

/// Which constraints to test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Which {
    /// Those that ask nothing: the symbols have decided them.
    Decided,
    /// Those, and what follows from where the things are.
    AboutThings,
    All,
}

impl Constraints {
    /// Makes a formula ready: one constraint for each part that must hold.
    pub(super) fn new(scene: &Scene, domain: &Domain, formula: &Formula) -> Constraints {
        let parts = match formula {
            Formula::And(parts) => parts.as_slice(),
            other => std::slice::from_ref(other),
        };
        let mut all: Vec<Constraint> = parts
            .iter()
            .map(|part| {
                let condition = condition(scene, domain, part);
                let mut questions = Vec::new();
                collect(&condition, &mut questions);
                Constraint {
                    text: show(domain, part),
                    from: if questions.is_empty() {
                        Which::Decided
                    } else if questions.iter().all(|q| q.is_about_things()) {
                        Which::AboutThings
                    } else {
                        Which::All
                    },
                    effort: questions.iter().map(|q| q.effort()).sum(),
                    condition,
                }
            })
            .collect();
        all.sort_by_key(|c| c.effort);
        Constraints(all)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the text of the first constraint that does not hold; `ask` answers questions about the state at hand.
    pub(super) fn broken(&self, which: Which, ask: &mut dyn FnMut(Question) -> Option<Answer>) -> Option<String> {
        let mut tested = self.0.iter().filter(|c| c.from <= which);
        tested.find(|c| !holds(&c.condition, ask)).map(|c| c.text.clone())
    }
}

fn asked(scene: &Scene, domain: &Domain, request: RequestId, args: &[Value]) -> Asked {
    let entities: Option<Vec<EntityRef>> = args.iter().map(|a| entity(scene, domain, a)).collect();
    Question::of(&domain.requests[request.index()].name, &entities?)
}

/// Returns the world's entity that a value names.
pub(super) fn entity(scene: &Scene, domain: &Domain, value: &Value) -> Option<EntityRef> {
    match value {
        Value::Entity(e) => scene.find(&domain.entities[e.index()].name),
        Value::Null
        | Value::Unknown
        | Value::Bool(_)
        | Value::Number(_)
        | Value::String(_)
        | Value::Set(_)
        | Value::Scalars(_) => None,
    }
}

fn condition(scene: &Scene, domain: &Domain, formula: &Formula) -> Condition {
    let all = |parts: &[Formula]| parts.iter().map(|p| condition(scene, domain, p)).collect();
    match formula {
        Formula::And(parts) => Condition::All(all(parts)),
        Formula::Or(parts) => Condition::Any(all(parts)),
        Formula::Not(inner) => Condition::Not(Box::new(condition(scene, domain, inner))),
        Formula::Holds { request, args } => Condition::Holds(asked(scene, domain, *request, args)),
        Formula::Compare { op, left, right } => Condition::Compare {
            op: *op,
            left: side(scene, domain, left),
            right: side(scene, domain, right),
        },
    }
}

fn side(scene: &Scene, domain: &Domain, term: &Term) -> Side {
    match term {
        Term::Value(value) => Side::Value(value.clone()),
        Term::Request { request, args } => Side::Asked(asked(scene, domain, *request, args)),
        Term::Arithmetic { op, left, right } => Side::Arithmetic {
            op: *op,
            left: Box::new(side(scene, domain, left)),
            right: Box::new(side(scene, domain, right)),
        },
    }
}

fn collect(condition: &Condition, questions: &mut Vec<Question>) {
    match condition {
        Condition::All(parts) | Condition::Any(parts) => parts.iter().for_each(|p| collect(p, questions)),
        Condition::Not(inner) => collect(inner, questions),
        Condition::Holds(question) => questions.extend(question),
        Condition::Compare { left, right, .. } => {
            collect_side(left, questions);
            collect_side(right, questions);
        }
    }
}

fn collect_side(side: &Side, questions: &mut Vec<Question>) {
    match side {
        Side::Value(_) => {}
        Side::Asked(question) => questions.extend(question),
        Side::Arithmetic { left, right, .. } => {
            collect_side(left, questions);
            collect_side(right, questions);
        }
    }
}

fn holds(condition: &Condition, ask: &mut dyn FnMut(Question) -> Option<Answer>) -> bool {
    match condition {
        Condition::All(parts) => parts.iter().all(|p| holds(p, ask)),
        Condition::Any(parts) => parts.iter().any(|p| holds(p, ask)),
        Condition::Not(inner) => !holds(inner, ask),
        Condition::Holds(question) => question.and_then(ask) == Some(Answer::Truth(true)),
        Condition::Compare { op, left, right } => match (value(left, ask), value(right, ask)) {
            (Some(left), Some(right)) => compare(*op, &left, &right),
            // As in every test of the language: what has no value differs from everything.
            (None, _) | (_, None) => *op == CompareOp::NotEqual,
        },
    }
}

fn value(side: &Side, ask: &mut dyn FnMut(Question) -> Option<Answer>) -> Option<Value> {
    match side {
        Side::Value(value) => Some(value.clone()),
        Side::Asked(question) => question.and_then(ask).map(Value::from),
        Side::Arithmetic { op, left, right } => {
            let (Value::Number(a), Value::Number(b)) = (value(left, ask)?, value(right, ask)?) else {
                return None;
            };
            let x = match op {
                ArithmeticOp::Add => a + b,
                ArithmeticOp::Subtract => a - b,
                ArithmeticOp::Multiply => a * b,
                ArithmeticOp::Divide => a / b,
            };
            x.is_finite().then_some(Value::Number(x))
        }
    }
}

impl From<Answer> for Value {
    fn from(answer: Answer) -> Value {
        match answer {
            Answer::Truth(b) => Value::Bool(b),
            Answer::Length(x) => Value::Number(x),
        }
    }
}

fn compare(op: CompareOp, left: &Value, right: &Value) -> bool {
    let order = match (left, right) {
        (Value::Number(a), Value::Number(b)) => a.partial_cmp(b),
        _ => None,
    };
    match op {
        CompareOp::Equal => left == right,
        CompareOp::NotEqual => left != right,
        CompareOp::Less => order.is_some_and(|o| o.is_lt()),
        CompareOp::LessEqual => order.is_some_and(|o| o.is_le()),
        CompareOp::Greater => order.is_some_and(|o| o.is_gt()),
        CompareOp::GreaterEqual => order.is_some_and(|o| o.is_ge()),
    }
}

fn show(domain: &Domain, formula: &Formula) -> String {
    let all = |parts: &[Formula], between: &str| {
        let texts: Vec<String> = parts.iter().map(|p| show(domain, p)).collect();
        texts.join(between)
    };
    match formula {
        Formula::And(parts) => all(parts, " and "),
        Formula::Or(parts) if parts.is_empty() => "false".to_owned(),
        Formula::Or(parts) => format!("({})", all(parts, " or ")),
        Formula::Not(inner) => format!("not ({})", show(domain, inner)),
        Formula::Holds { request, args } => show_request(domain, *request, args),
        Formula::Compare { op, left, right } => {
            format!(
                "{} {} {}",
                show_term(domain, left),
                op.symbol(),
                show_term(domain, right)
            )
        }
    }
}

fn show_request(domain: &Domain, request: RequestId, args: &[Value]) -> String {
    let args: Vec<String> = args.iter().map(|a| domain.show(a)).collect();
    format!("{}({})", domain.requests[request.index()].name, args.join(", "))
}

fn show_term(domain: &Domain, term: &Term) -> String {
    match term {
        Term::Value(value) => domain.show(value),
        Term::Request { request, args } => show_request(domain, *request, args),
        Term::Arithmetic { op, left, right } => {
            format!(
                "({} {} {})",
                show_term(domain, left),
                op.symbol(),
                show_term(domain, right)
            )
        }
    }
}
