//! The validator says no: a plan of scenario S1, as the planner found it, damaged in one place at a time. Each damage is
//! refused for its own reason. (`tests/validate.rs` has many more, on a small world computed by hand.)

#[expect(dead_code, reason = "the suite uses more of it")]
mod planning;

use std::collections::BTreeMap;
use std::sync::Arc;

use planning::Case;
use sgap::geom::Pose;
use sgap::ir::geometric::Target;
use sgap::plan::{AttachmentChange, Plan, SubAction};
use sgap::validate::Fault;
use sgap::world::{BaseKind, Object, ObjectState, Part, World};

/// Two of the three objects: four actions show as much as six.
fn two_objects() -> Case<'static> {
    Case {
        task: Some("MoveObjs(PR2, [RED_CUBE, GREY_BOOK], SIDE_TABLE, TABLE, BOB)"),
        ..Case::new("domains/three_objects.hatp", "worlds/three_objects.toml")
    }
}

fn sub_action<'a>(plan: &'a mut Plan, action: usize, name: &str) -> &'a mut SubAction {
    let geometry = plan.actions[action].geometry.as_mut().expect("the action is projected");
    geometry
        .sub_actions
        .iter_mut()
        .find(|s| s.name == name)
        .expect("the sub-action is there")
}

/// A change that makes a right plan wrong, the code of the fault that it is, and the action where it is found.
type Damage = (&'static str, fn(&mut Plan), &'static str, Option<usize>);

const DAMAGES: &[Damage] = &[
    (
        "a joint jumps in the middle of a motion",
        |plan| {
            let trajectory = &mut sub_action(plan, 1, "approach").trajectory;
            let middle = trajectory.positions.len() / 2;
            trajectory.positions[middle][3] += 0.2;
        },
        "speed",
        Some(1),
    ),
    (
        "a motion starts where the arm is not",
        |plan| sub_action(plan, 0, "approach").trajectory.positions[0][0] += 0.01,
        "configuration-jump",
        Some(0),
    ),
    (
        "a motion is twice as fast",
        |plan| {
            sub_action(plan, 2, "approach")
                .trajectory
                .times
                .iter_mut()
                .for_each(|t| *t /= 2.0)
        },
        "acceleration",
        Some(2),
    ),
    (
        "a motion is a tenth faster",
        |plan| {
            let times = &mut sub_action(plan, 0, "approach").trajectory.times;
            times.iter_mut().for_each(|t| *t /= 1.1);
        },
        "acceleration",
        Some(0),
    ),
    (
        "the object is let go of in the air",
        |plan| {
            let geometry = plan.actions[1].geometry.as_mut().expect("projected");
            geometry.sub_actions.retain(|s| s.name != "place");
        },
        "object-jump",
        Some(1),
    ),
    (
        "the object is said to stand elsewhere than the hand left it",
        |plan| {
            if let Some(AttachmentChange::Detach { object_in_world, .. }) = &mut sub_action(plan, 1, "release").change {
                object_in_world.position[0] += 0.05;
            }
        },
        "object-jump",
        Some(1),
    ),
    (
        "the object hovers above the table",
        |plan| {
            if let Some(AttachmentChange::Detach { object_in_world, .. }) = &mut sub_action(plan, 1, "release").change {
                object_in_world.position[2] += 0.05;
            }
        },
        "object-jump",
        Some(1),
    ),
    (
        "the fingers do not close",
        |plan| {
            let trajectory = &mut sub_action(plan, 0, "grasp").trajectory;
            let first = trajectory.positions[0].clone();
            trajectory.positions.iter_mut().for_each(|row| row.clone_from(&first));
        },
        "fingers-open",
        Some(0),
    ),
    (
        "another grasp is named than the hand has",
        |plan| plan.actions[0].geometry.as_mut().expect("projected").grasp = "-z/y".into(),
        "grasp-missed",
        Some(0),
    ),
    (
        "the object is never taken",
        |plan| sub_action(plan, 0, "grasp").change = None,
        "handling",
        Some(0),
    ),
    (
        "an action is left out",
        |plan| {
            plan.actions.remove(2);
            for (index, action) in plan.actions.iter_mut().enumerate() {
                action.index = index;
            }
        },
        "precondition",
        Some(2),
    ),
    (
        "two actions change places",
        |plan| plan.actions.swap(0, 1),
        "index",
        Some(0),
    ),
    (
        "the placement is said to be elsewhere",
        |plan| {
            let geometry = plan.actions[3].geometry.as_mut().expect("projected");
            geometry.placement.as_mut().expect("placed").x += 0.1;
        },
        "placement",
        Some(3),
    ),
    (
        "a change is left out",
        |plan| {
            plan.actions[1].changes.remove("RED_CUBE.isOn");
        },
        "fact-contradicted",
        Some(1),
    ),
    (
        "an object is said to be reachable that is not",
        |plan| {
            plan.actions[0]
                .changes
                .insert("RED_CUBE.isReachable".into(), "[BOB]".into());
        },
        "fact-unconfirmed",
        Some(0),
    ),
    (
        "an action costs less than it does",
        |plan| plan.actions[2].cost -= 0.5,
        "cost",
        Some(2),
    ),
    ("the total is wrong", |plan| plan.cost += 1.0, "cost-total", None),
    (
        "an action starts before the one it needs is over",
        |plan| plan.actions[1].start -= 0.5,
        "start",
        Some(1),
    ),
    (
        "a link is missing",
        |plan| {
            plan.links.remove(0);
        },
        "link-missing",
        Some(1),
    ),
    (
        "a stream lacks an action",
        |plan| {
            plan.streams.get_mut("PR2").expect("its stream").pop();
        },
        "stream",
        None,
    ),
    (
        "the tree applies a decomposition that does not exist",
        |plan| plan.decomposition[0].decomposition = Some(7),
        "no-such-decomposition",
        None,
    ),
];

#[test]
fn every_damage_is_refused_for_its_own_reason() {
    let planned = planning::plan(&two_objects());
    let right = planned.plan.clone().expect("S1 has a plan");
    let judge = |(what, damage, code, action): &Damage| {
        let mut plan = right.clone();
        damage(&mut plan);
        assert_ne!(plan, right, "{what}: the damage changes something");
        match planned.validate(&plan) {
            Ok(_) => Some(format!("{what}: accepted")),
            Err(fault) if fault.code() != *code || !is_at(&fault, *action) => Some(format!("{what}: {fault}")),
            Err(_) => None,
        }
    };
    let n_threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let parts = DAMAGES.chunks(DAMAGES.len().div_ceil(n_threads));
        let threads: Vec<_> = parts
            .map(|p| scope.spawn(|| p.iter().filter_map(judge).collect::<Vec<_>>()))
            .collect();
        threads
            .into_iter()
            .flat_map(|t| t.join().expect("no damage panics"))
            .collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn is_at(fault: &Fault, action: Option<usize>) -> bool {
    action.is_none_or(|action| fault.to_string().contains(&format!("action {action} ")))
}

/// The same plan in a world with one more object, which stands where the arm passes.
#[test]
fn a_motion_through_something_is_refused_with_its_time_and_both_names() {
    let mut planned = planning::plan(&two_objects());
    let plan = planned.plan.clone().expect("S1 has a plan");
    let added = wall(&mut planned.world, 0.85);
    let fault = planned.validate(&plan).expect_err("the arm passes through the wall");
    assert_eq!(fault.code(), "collision", "{fault}");
    let text = fault.to_string();
    assert!(
        text.contains("WALL") && text.contains("PR2/") && text.contains(" s"),
        "{text}"
    );
    // Out of the way it is nobody's business.
    planned.world.start.objects[added].X_WO = Pose::translation(0.0, 3.0, 0.3);
    planned.validate(&plan).expect("the wall is far away");
}

/// The table raised by 10 cm: what was put on it would now be inside.
#[test]
fn a_motion_through_the_table_is_refused() {
    let mut planned = planning::plan(&two_objects());
    let plan = planned.plan.clone().expect("S1 has a plan");
    let table = planned
        .world
        .scene
        .objects
        .iter()
        .position(|o| o.id == "TABLE")
        .expect("a table");
    planned.world.start.objects[table].X_WO.translation.vector.z += 0.10;
    let fault = planned.validate(&plan).expect_err("the hand goes through the table");
    assert_eq!(fault.code(), "collision", "{fault}");
    assert!(fault.to_string().contains("TABLE"), "{fault}");
}

/// Adds a fixed plate between the tables, its centre at that height [m]; returns its index.
fn wall(world: &mut World, height: f64) -> usize {
    world.scene.objects.push(Object {
        id: "WALL".into(),
        ty: None,
        parts: vec![Part {
            shape: sgap::geom::shape::Shape::Box {
                half: sgap::geom::Vec3::new(0.3, 0.01, 0.15),
            },
            X_OS: Pose::identity(),
        }],
        movable: false,
        supports: Vec::new(),
        stable: Vec::new(),
        grasps: Vec::new(),
        containers: Vec::new(),
        mass: 1.0,
        color: [0.5; 4],
    });
    world.start.objects.push(ObjectState {
        X_WO: Pose::translation(0.45, -0.5, height),
        held: None,
    });
    world.scene.objects.len() - 1
}

fn told(plan: &mut Plan, action: usize, slot: &str, value: &str) {
    plan.actions[action].changes.insert(slot.into(), value.into());
}

#[test]
fn a_plan_that_lies_about_beliefs_is_refused() {
    let case = Case {
        task: Some("Story(SALLY, ANNE, MARBLE)"),
        ..Case::symbolic("tests/suite/plan/language/beliefs.hatp")
    };
    let planned = planning::plan(&case);
    let plan = planned.plan.clone().expect("a plan");
    planned.validate(&plan).expect("the plan as it was found");
    let lies: &[Damage] = &[
        (
            "who was away is said to know",
            |plan| told(plan, 2, "SALLY.believes(MARBLE.isIn)", "BOX"),
            "changes",
            Some(2),
        ),
        (
            "who does it is said not to know",
            |plan| {
                plan.actions[2].changes.remove("ANNE.believes(MARBLE.isIn)");
            },
            "changes",
            Some(2),
        ),
        (
            "who saw it is said not to know",
            |plan| {
                plan.actions[0].changes.remove("ANNE.believes(MARBLE.isIn)");
            },
            "changes",
            Some(0),
        ),
        (
            "what is told is something else",
            |plan| told(plan, 5, "SALLY.believes(MARBLE.isIn)", "BASKET"),
            "changes",
            Some(5),
        ),
        (
            "nothing is unknown",
            |plan| told(plan, 4, "SALLY.believes(MARBLE.isIn)", "NULL"),
            "changes",
            Some(4),
        ),
        (
            "an argument is another",
            |plan| {
                plan.actions[2].changes.remove("BOX.visited(MARBLE)");
                told(plan, 2, "BASKET.visited(MARBLE)", "[SALLY, ANNE]");
            },
            "changes",
            Some(2),
        ),
        (
            "she looks where she does not believe it to be",
            |plan| plan.actions[4].arguments[2] = "BOX".into(),
            "precondition",
            Some(4),
        ),
    ];
    for (what, lie, code, action) in lies {
        let mut damaged = plan.clone();
        lie(&mut damaged);
        let fault = planned.validate(&damaged).expect_err(what);
        assert_eq!(fault.code(), *code, "{what}: {fault}");
        assert!(is_at(&fault, *action), "{what}: {fault}");
    }
}

/// A base that goes sideways, judged as one that can't.
#[test]
fn a_way_that_the_drive_can_not_go_is_refused() {
    let mut planned = planning::plan(&Case::new("domains/book.hatp", "worlds/book_alone.toml"));
    let plan = planned.plan.clone().expect("S6 has a plan");
    planned.validate(&plan).expect("the plan as it was found");
    planned.world.scene.agents[0].base = BaseKind::Differential;
    let fault = planned.validate(&plan).expect_err("it goes sideways");
    assert_eq!(fault.code(), "drive", "{fault}");
}

/// The cube is raised by 5 cm, as the domain wants it; then by another domain's word it should have been 8.
#[test]
fn a_motion_that_ends_elsewhere_than_its_description_says_is_refused() {
    let mut planned = planning::plan(&Case {
        task: Some("Present(PR2, RED_CUBE, SIDE_TABLE, GREY_BOOK, TABLE, BOB)"),
        ..Case::new("tests/suite/plan/own_action.hatp", "worlds/three_objects.toml")
    });
    let plan = planned.plan.clone().expect("a plan");
    planned.validate(&plan).expect("the plan as it was found");
    let show = planned.domain.geometrics.iter_mut().find(|g| g.name == "show");
    let action = Arc::make_mut(&mut show.expect("the domain declares it").action);
    action.sub_actions[0].until = Target::Up(0.08);
    let fault = planned.validate(&plan).expect_err("it ends too low");
    assert_eq!(fault.code(), "target-missed", "{fault}");
}

/// What no effect depends on is an order all the same, and the times follow from it.
#[test]
fn a_plan_that_drops_an_order_of_the_domain_is_refused() {
    let case = Case {
        task: Some("Day(ANN, BOB)"),
        ..Case::symbolic("tests/planning/order.hatp")
    };
    let planned = planning::plan(&case);
    let plan = planned.plan.clone().expect("a plan");
    planned.validate(&plan).expect("the plan as it was found");
    let n_links = plan.links.len();
    assert!(n_links >= 3, "{:?}", plan.links);
    for left_out in 0..n_links {
        let mut damaged = plan.clone();
        damaged.links.remove(left_out);
        reckon(&mut damaged);
        let fault = planned.validate(&damaged).expect_err("an order is missing");
        assert_eq!(fault.code(), "order-missing", "{fault}");
    }
    let mut other = plan;
    // The other one of the two equal subtasks would do as well.
    let first = other
        .links
        .iter_mut()
        .find(|l| l.after == 2)
        .expect("Work comes after one of them");
    assert!(first.before < 2);
    first.before = 1 - first.before;
    reckon(&mut other);
    planned
        .validate(&other)
        .expect("either of two equal subtasks is the one that is waited for");
}

/// Writes the times that follow from links and streams.
fn reckon(plan: &mut Plan) {
    let mut over: BTreeMap<String, f64> = BTreeMap::new();
    for i in 0..plan.actions.len() {
        let links = plan.links.iter().filter(|l| l.after == i);
        let linked = links.map(|l| plan.actions[l.before].end);
        let action = &plan.actions[i];
        let agents: Vec<String> = action.agents.iter().map(ToString::to_string).collect();
        let own = agents.iter().filter_map(|a| over.get(a)).copied();
        let start = linked.chain(own).fold(0.0, f64::max);
        let end = start + action.duration[0];
        over.extend(agents.into_iter().map(|a| (a, end)));
        (plan.actions[i].start, plan.actions[i].end) = (start, end);
    }
    plan.makespan = plan.actions.iter().map(|a| a.end).fold(0.0, f64::max);
}
