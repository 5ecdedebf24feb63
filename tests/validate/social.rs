//! Plans of a domain with a social rule, whose cost is wrong.

use sgap::ir::{ActionId, Domain, Pattern, PatternArg, RuleKind, SocialRule};
use sgap::plan::*;

use super::damage::{Damage, damage, right};

const PAINTS: u32 = 2;

/// Counts who paints after somebody has painted: the right plan does it once.
fn add_rule(domain: &mut Domain) {
    let paints = || Pattern {
        action: ActionId(PAINTS),
        args: vec![PatternArg::Any, PatternArg::Any],
        is_immediate: false,
    };
    domain.social.push(SocialRule {
        name: "painted_twice".into(),
        weight: 2.0,
        kind: RuleKind::Sequence {
            vars: Vec::new(),
            patterns: vec![paints(), paints()],
        },
    });
}

fn with_parts(plan: &mut Plan) {
    let part = |name: &str, kind: &str, amount: f64, weight: f64| CostPart {
        name: name.into(),
        kind: kind.into(),
        amount,
        weight,
        cost: amount * weight,
    };
    plan.cost_parts = vec![
        part("sum", "sum", plan.cost, 1.0),
        part("painted_twice", "undesirable sequence", 1.0, 2.0),
    ];
    plan.cost += 2.0;
}

/// The right plan with its cost and its parts, and the domain that wants them.
pub fn right_costs() -> Damage {
    damage("nothing", "", (None, None), &[], right(with_parts)).domain(add_rule)
}

/// Damaged costs.
pub fn costs() -> Vec<Damage> {
    let none = (None, None);
    let damaged = |what, code, words, change: fn(&mut Plan)| {
        let plan = right(|p| {
            with_parts(p);
            change(p);
        });
        damage(what, code, none, words, plan).domain(add_rule)
    };
    vec![
        damaged("no parts", "cost-parts", &["painted_twice"], |p| p.cost_parts.clear()),
        damaged("a rule of another name", "cost-parts", &["painted_once"], |p| {
            p.cost_parts[1].name = "painted_once".into();
        }),
        damaged("a rule of another kind", "cost-parts", &["wasted time"], |p| {
            p.cost_parts[1].kind = "wasted time".into();
        }),
        damage(
            "parts where the cost is a sum",
            "cost-parts",
            none,
            &["painted_twice"],
            right(|p| {
                with_parts(p);
                p.cost -= 2.0;
            }),
        ),
        damaged(
            "an event left out",
            "cost-part",
            &["amount", "`painted_twice` is 1"],
            |p| {
                p.cost_parts[1].amount = 0.0;
            },
        ),
        damaged(
            "another weight",
            "cost-part",
            &["weight", "`painted_twice` is 2"],
            |p| {
                p.cost_parts[1].weight = 1.0;
            },
        ),
        damaged("a cheaper part", "cost-part", &["cost", "`painted_twice` is 2"], |p| {
            p.cost_parts[1].cost = 0.0;
        }),
        damaged("a cheaper sum", "cost-part", &["`sum`"], |p| {
            p.cost_parts[0].amount -= 1.0
        }),
        damaged("a cheaper whole", "cost-whole", &[], |p| p.cost -= 2.0),
        damaged("no time to count", "sequence-undecided", &["painted_twice"], |_| {}).settings(|s| s.max_tries = 3),
    ]
}
