//! The domain of the tests, built by hand: what `lower` would make of
//!
//! ```hatp
//! action Pick(Agent A, Object O)
//!   { preconditions { A.hasInHand == NULL; } projects { pick(A, O) } effects { A.hasInHand = O; O.isOn = NULL; }
//!     cost { 1 + GetGRPCost() } duration { (GetGRPDuration(), GetGRPDuration()) } }
//! action Place(Agent A, Object O, Table S, Agent B)
//!   { preconditions { A.hasInHand == O; } projects { placeReachable(A, O, S, B) } effects { A.hasInHand = NULL; O.isOn = S; } ... }
//! action Paint(Agent B, Object O)
//!   { preconditions { B >> O.isReachable; O.painted != true; } effects { O.painted = true; } cost { 2 } duration { (1, 3) } }
//! method Move(Agent A, Object O, Agent B)
//!   { goal { B >> O.isReachable; }
//!     { preconditions { A.hasInHand == NULL; } subtasks { S = SELECT(Table, {O.isOn == S;}); 1: Pick(A, O); 2: Place(A, O, S, B) > 1; } } }
//! method Serve(Agent A, Agent B)
//!   { { subtasks { O = SELECT(Object, {B !>> O.isReachable;}); P = SELECT(Object, {P != O;});
//!                  1: Paint(B, P); 2: Move(A, P, B); 3: Move(A, O, B); 4: Paint(B, O) > 3; } } }
//! ```

use sgap::ir::*;

const AGENT: TypeId = TypeId(0);
const OBJECT: TypeId = TypeId(1);
const TABLE: TypeId = TypeId(2);
const HAS_IN_HAND: AttributeId = AttributeId(0);
const IS_ON: AttributeId = AttributeId(1);
const IS_REACHABLE: AttributeId = AttributeId(2);
const PAINTED: AttributeId = AttributeId(4);

fn var(i: u32) -> Expr {
    Expr::Var(Var(i))
}

fn of(base: Expr, attribute: AttributeId) -> Expr {
    Expr::Attribute {
        base: Box::new(base),
        attribute,
        args: Box::default(),
    }
}

fn compare(op: CompareOp, left: Expr, right: Expr) -> Test {
    Test::Compare { op, left, right }
}

fn equal(left: Expr, right: Expr) -> Test {
    compare(CompareOp::Equal, left, right)
}

fn null() -> Expr {
    Expr::Const(Value::Null)
}

fn number(x: f64) -> Expr {
    Expr::Const(Value::Number(x))
}

fn param(name: &str, ty: TypeId) -> Param {
    Param {
        name: name.into(),
        base: Base::Entity(ty),
        is_set: false,
    }
}

fn set(entity: Expr, attribute: AttributeId, value: Expr) -> Effect {
    Effect::Assign {
        entity,
        args: Box::default(),
        attribute,
        value,
    }
}

fn reachable(agent: Expr, object: Expr) -> Test {
    Test::Member {
        element: agent,
        set: of(object, IS_REACHABLE),
    }
}

fn projected_cost() -> Expr {
    Expr::Arithmetic {
        op: ArithmeticOp::Add,
        left: Box::new(number(1.0)),
        right: Box::new(Expr::GeometricCost),
    }
}

fn subtask(task: TaskId, args: &[u32], after: &[usize]) -> Subtask {
    Subtask {
        task,
        args: args.iter().map(|v| var(*v)).collect(),
        after: after.to_vec(),
    }
}

pub fn domain() -> Domain {
    let ty = |name: &str, entities: &[u32]| Type {
        name: name.into(),
        parent: None,
        entities: entities.iter().map(|e| EntityId(*e)).collect(),
    };
    let entity = |name: &str, ty: TypeId| Entity { name: name.into(), ty };
    // What `pick` and `placeReachable` are, the prelude says.
    let (prelude, _) = sgap::check::compile(&[], &sgap::check::Given::default());
    let prelude = prelude.expect("the prelude has no errors");
    let mut domain = Domain {
        requests: prelude.requests,
        geometrics: prelude.geometrics,
        types: vec![ty("Agent", &[0, 1]), ty("Object", &[2, 3]), ty("Table", &[4])],
        entities: vec![
            entity("GANTRY", AGENT),
            entity("HUMAN", AGENT),
            entity("RED", OBJECT),
            entity("BLUE", OBJECT),
            entity("TABLE", TABLE),
        ],
        ..Domain::default()
    };
    for (name, owner, base, is_set, fact) in [
        ("hasInHand", AGENT, Base::Entity(OBJECT), false, Some("hasInHand")),
        ("isOn", OBJECT, Base::Entity(TABLE), false, Some("isOn")),
        ("isReachable", OBJECT, Base::Entity(AGENT), true, Some("isReachable")),
        ("isVisible", OBJECT, Base::Entity(AGENT), true, Some("isVisible")),
        ("painted", OBJECT, Base::Bool, false, None),
    ] {
        let attribute = AttributeId(domain.attributes.len() as u32);
        let mut slots = vec![None; domain.entities.len()];
        for e in domain.types[owner.index()].entities.clone() {
            slots[e.index()] = Some(SlotId(domain.slots.len() as u32));
            domain.slots.push(Slot { entity: e, attribute });
            domain.initial.push(if is_set {
                Value::Set(std::sync::Arc::default())
            } else {
                Value::Null
            });
        }
        domain.attributes.push(Attribute {
            name: name.into(),
            owner,
            is_static: false,
            is_set,
            base,
            fact: fact.map(String::from),
            arguments: Vec::new(),
            believer: None,
            slots,
        });
    }
    let projection = |name: &str, n: u32| {
        Some(Projection {
            name: name.into(),
            args: (0..n).map(var).collect(),
            given: Vec::new(),
        })
    };
    domain.actions = vec![
        Action {
            name: "Pick".into(),
            params: vec![param("A", AGENT), param("O", OBJECT)],
            n_vars: 2,
            preconditions: equal(of(var(0), HAS_IN_HAND), null()),
            projects: projection("pick", 2),
            constraints: Test::always(),
            alternatives: None,
            effects: vec![set(var(0), HAS_IN_HAND, var(1)), set(var(1), IS_ON, null())],
            cost: projected_cost(),
            duration: (Expr::GeometricDuration, Expr::GeometricDuration),
            agents: vec![0],
        },
        Action {
            name: "Place".into(),
            params: vec![
                param("A", AGENT),
                param("O", OBJECT),
                param("S", TABLE),
                param("B", AGENT),
            ],
            n_vars: 4,
            preconditions: equal(of(var(0), HAS_IN_HAND), var(1)),
            projects: projection("placeReachable", 4),
            constraints: Test::always(),
            alternatives: None,
            effects: vec![set(var(0), HAS_IN_HAND, null()), set(var(1), IS_ON, var(2))],
            cost: projected_cost(),
            duration: (number(0.0), number(20.0)),
            agents: vec![0, 3],
        },
        Action {
            name: "Paint".into(),
            params: vec![param("B", AGENT), param("O", OBJECT)],
            n_vars: 2,
            preconditions: Test::And(vec![
                reachable(var(0), var(1)),
                compare(CompareOp::NotEqual, of(var(1), PAINTED), Expr::Const(Value::Bool(true))),
            ]),
            projects: None,
            constraints: Test::always(),
            alternatives: None,
            effects: vec![set(var(1), PAINTED, Expr::Const(Value::Bool(true)))],
            cost: number(2.0),
            duration: (number(1.0), number(3.0)),
            agents: vec![0],
        },
    ];
    let [pick, place, paint] = [0, 1, 2].map(|i| TaskId::Action(ActionId(i)));
    let select = |var: u32, name: &str, ty: TypeId, filter: Test| Binder::Select {
        var: Var(var),
        var_name: name.into(),
        ty,
        filter,
        order: SelectOrder::Declared,
    };
    domain.methods = vec![
        Method {
            name: "Move".into(),
            params: vec![param("A", AGENT), param("O", OBJECT), param("B", AGENT)],
            goal: Some(reachable(var(2), var(1))),
            decompositions: vec![Decomposition {
                preconditions: equal(of(var(0), HAS_IN_HAND), null()),
                binders: vec![select(3, "S", TABLE, equal(of(var(1), IS_ON), var(3)))],
                subtasks: vec![subtask(pick, &[0, 1], &[]), subtask(place, &[0, 1, 3, 2], &[0])],
            }],
            n_vars: 4,
        },
        Method {
            name: "Serve".into(),
            params: vec![param("A", AGENT), param("B", AGENT)],
            goal: None,
            decompositions: vec![Decomposition {
                preconditions: Test::always(),
                binders: vec![
                    select(2, "O", OBJECT, Test::Not(Box::new(reachable(var(1), var(2))))),
                    select(3, "P", OBJECT, compare(CompareOp::NotEqual, var(3), var(2))),
                ],
                subtasks: vec![
                    subtask(paint, &[1, 3], &[]),
                    subtask(TaskId::Method(MethodId(0)), &[0, 3, 1], &[]),
                    subtask(TaskId::Method(MethodId(0)), &[0, 2, 1], &[]),
                    subtask(paint, &[1, 2], &[2]),
                ],
            }],
            n_vars: 4,
        },
    ];
    domain
}

pub fn goal() -> Goal {
    Goal {
        task: TaskId::Method(MethodId(1)),
        args: vec![Value::Entity(EntityId(0)), Value::Entity(EntityId(1))],
    }
}
