//! The checker of whole configurations against every pair by the exact test, and covers against points of what they cover.

use std::sync::Arc;

use proptest::prelude::*;
use sgap::geom::checker::{Body, Checker, Item, LANES, Obstacle, Rig};
use sgap::geom::collide::{Solid, distance, within};
use sgap::geom::cover::Form;
use sgap::geom::kinematics::{Dof, Drive, Joint, JointKind, Tree};
use sgap::geom::{Pose, Vec3};

use super::collide::{poses, shapes};

/// A joint with a kind, a parent before it (as a share of those), its frame and its axis.
fn joints() -> impl Strategy<Value = Vec<(u8, f64, Pose, Vec3, f64)>> {
    let axis = prop_oneof![
        Just(Vec3::x()),
        Just(Vec3::y()),
        Just(-Vec3::z()),
        Just(Vec3::z()),
        [-1.0f64..1.0, -1.0f64..1.0, 0.1f64..1.0].prop_map(|v| Vec3::from(v).normalize()),
    ];
    proptest::collection::vec((0u8..6, 0.0f64..1.0, poses(0.3), axis, -1.0f64..1.0), 1..10)
}

/// A robot: one dof for each moving joint, but the last one follows the first.
fn tree(joints: &[(u8, f64, Pose, Vec3, f64)]) -> Tree {
    let mut tree = Tree {
        links: vec!["root".to_owned()],
        ..Tree::default()
    };
    for (k, (kind, parent, X_PJ, axis, offset)) in joints.iter().enumerate() {
        let kind = match kind {
            0 => JointKind::Fixed,
            1 => JointKind::Prismatic,
            _ => JointKind::Revolute,
        };
        let mimics = k + 1 == joints.len() && !tree.dofs.is_empty();
        let drive = (kind != JointKind::Fixed).then(|| {
            if mimics {
                return Drive {
                    dof: 0,
                    scale: -0.7,
                    offset: *offset,
                };
            }
            tree.dofs.push(Dof {
                name: format!("j{k}"),
                lower: -3.0,
                upper: 3.0,
                max_velocity: 1.0,
                max_acceleration: 1.0,
                max_jerk: 10.0,
            });
            Drive {
                dof: tree.dofs.len() - 1,
                scale: 1.0,
                offset: 0.0,
            }
        });
        tree.links.push(format!("l{k}"));
        // Mostly chains: the parent is one of the last three.
        let back = 1 + (parent * parent * 3.0) as usize;
        tree.joints.push(Joint {
            name: format!("j{k}"),
            kind,
            parent: (k + 1).saturating_sub(back),
            X_PJ: *X_PJ,
            axis: *axis,
            drive,
        });
    }
    tree
}

/// Every pair by the exact test, at the tree's own poses; also how near the nearest was to the other answer [m].
fn brute_force(
    tree: &Tree,
    X_WB: &Pose,
    q: &[f64],
    bodies: &[Body],
    obstacles: &[Obstacle],
    margin: &dyn Fn(Item, Item) -> Option<f64>,
    moves: &dyn Fn(usize) -> bool,
) -> (Vec<(Item, Item)>, f64) {
    let X_WL = tree.link_poses(X_WB, q);
    let at = |i: usize| X_WL[bodies[i].link] * bodies[i].X_LS;
    let (mut hits, mut tie) = (Vec::new(), f64::INFINITY);
    let mut test = |a: Item, s: &Solid, X: &Pose, b: Item, t: &Solid, Y: &Pose| {
        let Some(m) = margin(a, b) else { return };
        if within(s, X, t, Y, m) {
            hits.push((a, b));
        }
        let d = distance(s, X, t, Y);
        let depth = sgap::geom::collide::penetration(s, X, t, Y).unwrap_or(0.0);
        tie = tie.min((d - depth - m).abs());
    };
    for i in 0..bodies.len() {
        if !moves(bodies[i].link) {
            continue;
        }
        for j in 0..bodies.len() {
            if !moves(bodies[j].link) {
                test(
                    Item::Body(i),
                    bodies[i].form.solid(),
                    &at(i),
                    Item::Body(j),
                    bodies[j].form.solid(),
                    &at(j),
                );
            }
        }
        for (j, o) in obstacles.iter().enumerate() {
            test(
                Item::Body(i),
                bodies[i].form.solid(),
                &at(i),
                Item::Obstacle(j),
                o.form.solid(),
                &o.X_WS,
            );
        }
    }
    for i in (0..bodies.len()).filter(|i| moves(bodies[*i].link)) {
        for j in (i + 1..bodies.len()).filter(|j| moves(bodies[*j].link)) {
            test(
                Item::Body(i),
                bodies[i].form.solid(),
                &at(i),
                Item::Body(j),
                bodies[j].form.solid(),
                &at(j),
            );
        }
    }
    (hits, tie)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn verdicts_are_those_of_every_pair(
        joints in joints(),
        shape in proptest::collection::vec((0.0f64..1.0, shapes(), poses(0.2), -0.002f64..0.0), 1..12),
        things in proptest::collection::vec((shapes(), poses(1.5)), 0..90),
        X_WB in poses(1.0),
        values in proptest::collection::vec(proptest::array::uniform8(-4.0f64..4.0), 10),
        kept in 0.0f64..1.0,
        seed in 0u64..1000,
    ) {
        let tree = tree(&joints);
        let form = |solid| Arc::new(Form::new(solid));
        let bodies: Vec<Body> = shape.iter().map(|(l, s, X_LS, shrunk)| Body {
            link: (l * tree.links.len() as f64) as usize,
            X_LS: *X_LS,
            form: form(Solid::padded(s, if *l < 0.2 { *shrunk } else { 0.0 })),
        }).collect();
        let obstacles: Vec<Obstacle> = things.iter().map(|(s, X_WS)| Obstacle { X_WS: *X_WS, form: form(Solid::new(s)) }).collect();
        // Some pairs may touch, others keep apart by more or less.
        let margin = |a: Item, b: Item| {
            let n = |i: Item| match i { Item::Body(i) => i as u64, Item::Obstacle(i) => 100 + i as u64 };
            let mixed = (n(a) * 7919 + n(b) * 104_729 + seed * 31).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
            match mixed % 7 { 0 => None, 1 | 2 => Some(0.005), 3 => Some(0.05), _ => Some(0.0) }
        };
        // The last dof is not checked: it stands where it is.
        let n = tree.n_dofs();
        let checked: Vec<usize> = (0..n).filter(|d| *d + 1 < n || kept < 0.5).rev().collect();
        let rest: Vec<f64> = (0..n).map(|d| values[d][0] * 0.3).collect();
        let others: &[usize] = if kept < 0.25 || n == 0 { &[] } else { &[n - 1] };
        let rig = Arc::new(Rig::new(&tree, &checked, others, bodies.clone()));
        let X_WL = tree.link_poses(&X_WB, &rest);
        let (carried, own) = (bodies.len() / 4, bodies.len() - bodies.len() / 4);
        let part = Arc::new(Rig::new(&tree, &checked, others, bodies[..own].to_vec()));
        let mut checkers = [
            Checker::new(&rig, &X_WL, &rest, &[], &obstacles, &margin),
            Checker::new(&part, &X_WL, &rest, &bodies[own..], &obstacles, &margin),
        ];
        prop_assert_eq!(own + carried, bodies.len());
        let columns: Vec<[f64; LANES]> = checked.iter().map(|d| values[*d]).collect();
        let mut free = [true; LANES];
        for k in 0..LANES {
            let mut q = rest.clone();
            checked.iter().for_each(|d| q[*d] = values[*d][k]);
            let (hits, tie) = brute_force(&tree, &X_WB, &q, &bodies, &obstacles, &margin, &|l| rig.moves(l));
            let one: Vec<f64> = columns.iter().map(|c| c[k]).collect();
            free[k] = checkers[0].is_free(&one);
            for checker in &mut checkers {
                prop_assert_eq!(checker.is_free(&one), free[k]);
                // Two ways of computing a pose differ by a rounding.
                if tie > 1e-6 {
                    prop_assert_eq!(&checker.hits(&one), &hits);
                }
                prop_assert_eq!(checker.first_hit(&one), checker.hits(&one).first().copied());
                prop_assert_eq!(free[k], checker.first_hit(&one).is_none());
            }
        }
        let rows: Vec<f64> = (0..LANES).flat_map(|k| columns.iter().map(move |c| c[k])).collect();
        for checker in &mut checkers {
            prop_assert_eq!(checker.all_free(&rows[..3 * columns.len()]), columns.is_empty() && free[0] || free[..3] == [true; 3]);
            prop_assert_eq!(checker.are_free(&columns), free);
            prop_assert_eq!(checker.all_free(&rows), free == [true; LANES]);
        }
        // What is no number hits whatever it can.
        if n > 1 && let Some(first) = columns.first() {
            let mut bad = columns.clone();
            bad[0] = [f64::NAN; LANES];
            let moved = tree.links_moved_by(&checked[..1]);
            let has_pair = bodies.iter().enumerate().any(|(i, b)| moved.contains(&b.link) && (0..obstacles.len()).any(|j| margin(Item::Body(i), Item::Obstacle(j)).is_some()));
            if has_pair {
                prop_assert_eq!(checkers[0].are_free(&bad), [false; LANES]);
            }
            prop_assert_eq!(first.len(), LANES);
        }
    }

    #[test]
    fn a_margin_that_is_changed_counts(things in proptest::collection::vec((shapes(), poses(0.8)), 1..70), s in shapes(), q in -1.0f64..1.0) {
        let tree = tree(&[(1, 0.0, Pose::identity(), Vec3::x(), 0.0)]);
        let body = Body { link: 1, X_LS: Pose::identity(), form: Arc::new(Form::new(Solid::new(&s))) };
        let rig = Arc::new(Rig::new(&tree, &[0], &[], vec![body]));
        let obstacles: Vec<Obstacle> = things.iter().map(|(s, X_WS)| Obstacle { X_WS: *X_WS, form: Arc::new(Form::new(Solid::new(s))) }).collect();
        let X_WL = tree.link_poses(&Pose::identity(), &[0.0]);
        let mut all = Checker::new(&rig, &X_WL, &[0.0], &[], &obstacles, &|_, _| Some(0.01));
        let hits = all.hits(&[q]);
        for (a, b) in &hits {
            prop_assert_eq!(*a, Item::Body(0));
            all.set_margin(*b, *a, None);
        }
        prop_assert!(all.is_free(&[q]));
        for (a, b) in &hits {
            all.set_margin(*a, *b, Some(0.01));
        }
        prop_assert_eq!(all.hits(&[q]), hits);
    }

    /// Points of the solid lie in a ball of its cover; balls within lie in the solid.
    #[test]
    fn covers_contain_and_are_contained(s in shapes(), m in -0.01f64..0.05, at in proptest::collection::vec(proptest::array::uniform3(-1.0f64..1.0), 60)) {
        let form = Form::new(Solid::padded(&s, m));
        let point = Solid::new(&sgap::geom::shape::Shape::Sphere { radius: 0.0 });
        let is_in = |p: Vec3, more: f64| within(form.solid(), &Pose::identity(), &point, &Pose::translation(p.x, p.y, p.z), more);
        prop_assert!(!form.balls().is_empty() && form.balls().len() <= 16);
        for d in at.iter().map(|d| Vec3::from(*d)) {
            let p = d * form.solid().radius();
            if is_in(p, 0.0) {
                prop_assert!((p - form.whole().centre).norm() <= form.whole().radius + 1e-9);
                prop_assert!(form.balls().iter().any(|b| (p - b.centre).norm() <= b.radius + 1e-9), "{p} is in no ball");
            }
            for b in form.balls().iter().chain([form.whole()]).filter(|b| b.within >= 0.0) {
                prop_assert!(is_in(b.centre + d.normalize() * b.within, 1e-6));
                prop_assert!(b.within <= b.radius + 1e-9);
            }
        }
    }
}
