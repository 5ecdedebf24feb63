//! Right plans that are wrong in another world, or by another domain.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use sgap::geom::{Vec3, shape::Shape};
use sgap::ir::{AttributeId, Base, CompareOp, Domain, Effect, EntityId, Expr, Request, RequestId, Test, Value, Var};
use sgap::plan::*;
use sgap::world::{Held, Object, Part, Support, World};

use super::damage::{Damage, damage, geometry, right, sub_action};
use super::plan::{PAINT_BLUE, PICK, PLACE, Recipe, arm, reckon};
use super::world::{HALF, RED, at};

/// A question about arguments of an action.
pub fn request(domain: &mut Domain, name: &str, args: &[Var]) -> Expr {
    let args = args.iter().map(|v| Expr::Var(*v)).collect();
    let result = if name == "distance" { Base::Number } else { Base::Bool };
    let name = name.to_owned();
    domain.requests.push(Request { name, result });
    let request = RequestId(domain.requests.len() as u32 - 1);
    Expr::Request { request, args }
}

/// `distance(a, b) < than`.
pub fn nearer(domain: &mut Domain, a: Var, b: Var, than: f64) -> Test {
    Test::Compare {
        op: CompareOp::Less,
        left: request(domain, "distance", &[a, b]),
        right: Expr::Const(Value::Number(than)),
    }
}

/// `GANTRY.hasInHand op NULL`.
fn gantry_hand(op: CompareOp) -> Test {
    Test::Compare {
        op,
        left: Expr::Attribute {
            base: Box::new(Expr::Const(Value::Entity(EntityId(0)))),
            attribute: AttributeId(0),
            args: Box::default(),
        },
        right: Expr::Const(Value::Null),
    }
}

const PICKS: usize = 0;
const PLACES: usize = 1;
const PAINTS: usize = 2;

/// `O.painted` of an action's second parameter: no number.
fn painted() -> Expr {
    Expr::Attribute {
        base: Box::new(Expr::Var(Var(1))),
        attribute: AttributeId(4),
        args: Box::default(),
    }
}

fn anybody_paints(domain: &mut Domain) {
    domain.actions[PAINTS].preconditions = Test::always();
}

/// Right plans in another world, or by another domain.
pub fn surroundings() -> Vec<Damage> {
    let none = (None, None);
    let plain = || right(|_| {});
    let paint = (Some(PAINT_BLUE), None);
    vec![
        damage("a cost without a value", "cost-undefined", paint, &[], plain())
            .domain(|d| d.actions[PAINTS].cost = painted()),
        damage("a duration without a value", "duration-undefined", paint, &[], plain())
            .domain(|d| d.actions[PAINTS].duration.1 = painted()),
        damage(
            "a geometric action that nobody checks",
            "geometry-unchecked",
            (Some(PICK), None),
            &["throw"],
            right(|p| geometry(p, PICK).action = "throw".into()),
        )
        .domain(|d| d.actions[PICKS].projects.as_mut().unwrap().name = "throw".into()),
        damage(
            "a fact that nobody checks",
            "fact-unchecked",
            none,
            &["RED.isOn", "isUnder"],
            plain(),
        )
        .domain(|d| d.attributes[1].fact = Some("isUnder".into())),
        damage(
            "a constraint that the world afterwards breaks",
            "constraint",
            (Some(PLACE), None),
            &["distance(RED, HUMAN) < 0", "it is 0."],
            plain(),
        )
        .domain(|d| d.actions[PLACES].constraints = nearer(d, Var(1), Var(3), 0.0)),
        damage(
            "a constraint about a relation that is not there",
            "constraint",
            (Some(PLACE), None),
            &["isIn(RED, TABLE)"],
            plain(),
        )
        .domain(|d| d.actions[PLACES].constraints = Test::Holds(request(d, "isIn", &[Var(1), Var(2)]))),
        damage(
            "a request that is answered with no",
            "precondition",
            (Some(PICK), None),
            &["virtualPlace(RED, RED)"],
            plain(),
        )
        .domain(|d| d.actions[PICKS].preconditions = Test::Holds(request(d, "virtualPlace", &[Var(1), Var(1)]))),
        damage(
            "room that is denied and plainly there",
            "precondition",
            (Some(PLACE), None),
            &["not `virtualPlace(RED, TABLE)`"],
            plain(),
        )
        .domain(|d| {
            let fits = Test::Holds(request(d, "virtualPlace", &[Var(1), Var(2)]));
            d.actions[PLACES].preconditions = Test::Not(Box::new(fits));
        }),
        damage(
            "a decomposition that does not apply",
            "decomposition-precondition",
            none,
            &["GANTRY.hasInHand"],
            plain(),
        )
        .domain(|d| d.methods[0].decompositions[0].preconditions = gantry_hand(CompareOp::NotEqual)),
        damage(
            "subtasks in an order that the domain forbids",
            "subtasks",
            none,
            &["Paint(HUMAN, BLUE)"],
            plain(),
        )
        .domain(|d| d.methods[1].decompositions[0].subtasks[0].after = vec![1]),
        damage(
            "no link says what the domain orders",
            "order-missing",
            none,
            &["action 0", "action 1"],
            plain(),
        )
        .domain(|d| d.methods[1].decompositions[0].subtasks[2].after = vec![0]),
        damage(
            "a choice that the filter forbids",
            "subtasks",
            none,
            &["Pick(GANTRY, RED)"],
            plain(),
        )
        .domain(|d| match &mut d.methods[0].decompositions[0].binders[0] {
            sgap::ir::Binder::Select { filter, .. } => *filter = Test::Not(Box::new(Test::always())),
            sgap::ir::Binder::Let { .. } => unreachable!("a SELECT"),
        }),
        damage(
            "too many choices to try",
            "subtasks-undecided",
            none,
            &["0 choices"],
            plain(),
        )
        .settings(|s| s.max_bindings = 0),
        damage(
            "a plan too long to check",
            "too-long",
            (Some(PICK), Some("approach")),
            &["20"],
            plain(),
        )
        .settings(|s| s.max_configurations = 20),
        damage(
            "motions of two streams without a link",
            "motion-order",
            (Some(PLACE), None),
            &["1"],
            right(|p| {
                p.actions[PLACE].agents = vec!["HUMAN".into()];
                p.streams["GANTRY"] = vec![PICK];
                p.links.remove(0);
                reckon(p);
            }),
        )
        .domain(|d| d.actions[PLACES].agents = vec![3]),
        damage(
            "no link keeps the paint before the pick",
            "link-race",
            paint,
            &["GANTRY.hasInHand"],
            plain(),
        )
        .domain(|d| d.actions[PAINTS].preconditions = gantry_hand(CompareOp::Equal)),
        damage(
            "no link says who writes last",
            "outcome-race",
            paint,
            &["BLUE.painted"],
            right(|p| {
                p.actions[PICK].changes.insert("BLUE.painted".into(), "false".into());
            }),
        )
        .domain(|d| {
            d.actions[PICKS].effects.push(Effect::Assign {
                entity: Expr::Const(Value::Entity(EntityId(3))),
                attribute: AttributeId(4),
                args: Box::default(),
                value: Expr::Const(Value::Bool(false)),
            });
        }),
        damage(
            "put down what was never taken",
            "not-held",
            (Some(1), None),
            &["`RED`", "GANTRY's main hand"],
            right(|p| {
                p.actions.remove(PICK);
                for (i, a) in p.actions.iter_mut().enumerate() {
                    a.index = i;
                }
            }),
        )
        .domain(|d| d.actions[PLACES].preconditions = Test::always()),
        damage(
            "taken with a full hand",
            "hand-occupied",
            (Some(PICK), Some("grasp")),
            &["`BLUE`"],
            plain(),
        )
        .domain(anybody_paints)
        .domain(|d| d.actions[PICKS].preconditions = Test::always())
        .world(|w| {
            w.start.objects[1].held = Some(Held {
                agent: 0,
                arm: 0,
                X_TO: at(-0.2, 0.4, 0.0),
            })
        }),
        damage(
            "the ground taken from under another",
            "in-the-air",
            (Some(PICK), None),
            &["`BLUE`"],
            right(|p| {
                let from = Recipe::right().grasp;
                let aside = [from[0], from[1] + 0.1, from[2], from[3]];
                *sub_action(p, PICK, 3) = arm("disengage", Motion::Straight, &[from, aside]);
            }),
        )
        .domain(anybody_paints)
        .world(|w| {
            // RED has a ledge on its left side, and BLUE stands on it.
            let shape = Shape::Box {
                half: Vec3::new(0.04, 0.03, 0.005),
            };
            w.scene.objects[0].parts.push(Part {
                shape,
                X_OS: at(-0.1, 0.0, 0.0),
            });
            let X_OF = at(-0.1, 0.0, 0.005);
            w.scene.objects[0].supports.push(Support {
                name: "ledge".into(),
                X_OF,
                half: [0.04, 0.03],
            });
            w.start.objects[1].X_WO = w.start.objects[0].X_WO * at(-0.1, 0.0, 0.005 + HALF);
        }),
        damage(
            "a human's hand in the way",
            "collision",
            (Some(PICK), Some("approach")),
            &["GANTRY/", "HUMAN/palm"],
            plain(),
        )
        .domain(anybody_paints)
        .world(|w| w.start.agents[1].X_WB = at(RED[0], RED[1] + 0.05, 0.75)),
        damage(
            "an obstacle in the way",
            "collision",
            (Some(PLACE), Some("approach")),
            &["RED", "WALL"],
            plain(),
        )
        .world(|w| wall(w, [0.0, 0.1, 0.6], [0.01, 0.1, 0.05])),
        damage(
            "seen through a wall",
            "fact-unconfirmed",
            (Some(PLACE), None),
            &["isVisible(RED, HUMAN)"],
            plain(),
        )
        .world(|w| wall(w, [0.3, 0.37, 0.8], [0.25, 0.005, 0.2])),
        damage(
            "not seen in plain sight",
            "fact-contradicted",
            (Some(PICK), None),
            &["isVisible(BLUE, HUMAN)"],
            right(|p| {
                p.actions[PICK].changes.insert("BLUE.isVisible".into(), "[]".into());
            }),
        ),
        damage(
            "a narrower joint",
            "joint-limit",
            (Some(PICK), Some("approach")),
            &["`x`", "-0.2"],
            plain(),
        )
        .world(|w| w.scene.agents[0].tree.dofs[0].lower = -0.2),
        damage(
            "a heavier joint",
            "acceleration",
            (Some(PICK), Some("approach")),
            &["`x`"],
            plain(),
        )
        .world(|w| w.scene.agents[0].tree.dofs[0].max_acceleration = 1.0),
        damage(
            "a gentler joint",
            "jerk",
            (Some(PICK), Some("approach")),
            &["`x`", "limit is 5.0"],
            plain(),
        )
        .world(|w| w.scene.agents[0].tree.dofs[0].max_jerk = 5.0),
    ]
}

fn wall(world: &mut World, centre: [f64; 3], half: [f64; 3]) {
    let shape = Shape::Box { half: Vec3::from(half) };
    let table = world.scene.objects[2].clone();
    let parts = vec![Part {
        shape,
        X_OS: at(0.0, 0.0, 0.0),
    }];
    world.scene.objects.push(Object {
        id: "WALL".into(),
        parts,
        supports: vec![],
        ..table
    });
    let mut state = world.start.objects[2].clone();
    state.X_WO = at(centre[0], centre[1], centre[2]);
    world.start.objects.push(state);
}
