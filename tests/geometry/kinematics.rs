//! `kinematics.json`, written by `make_vectors.py`, names the tool and its version.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use proptest::prelude::*;
use serde_json::Value;
use sgap::geom::kinematics::batch::{Batch, X8};
use sgap::geom::kinematics::{Chain, Dof, Drive, Joint, JointKind, Tree};
use sgap::geom::{Pose, Vec3};

pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn pose(v: &Value) -> Pose {
    let n = numbers(v);
    let q = UnitQuaternion::from_quaternion(Quaternion::new(n[6], n[3], n[4], n[5]));
    Pose::from_parts(Translation3::new(n[0], n[1], n[2]), q)
}

pub fn text(v: &Value) -> String {
    v.as_str().unwrap().to_string()
}

pub fn read_tree(v: &Value) -> Tree {
    let joint = |j: &Value| Joint {
        name: text(&j["name"]),
        kind: match j["kind"].as_str().unwrap() {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute,
            "prismatic" => JointKind::Prismatic,
            other => panic!("kind {other}"),
        },
        parent: j["parent"].as_u64().unwrap() as usize,
        X_PJ: pose(&j["X_PJ"]),
        axis: Vec3::from_column_slice(&numbers(&j["axis"])),
        drive: j["drive"].as_array().map(|d| Drive {
            dof: d[0].as_u64().unwrap() as usize,
            scale: d[1].as_f64().unwrap(),
            offset: d[2].as_f64().unwrap(),
        }),
    };
    let dof = |d: &Value| Dof {
        name: text(&d["name"]),
        lower: d["lower"].as_f64().unwrap_or(f64::NEG_INFINITY),
        upper: d["upper"].as_f64().unwrap_or(f64::INFINITY),
        max_velocity: d["max_velocity"].as_f64().unwrap(),
        max_acceleration: 2.0,
        max_jerk: 20.0,
    };
    Tree {
        links: v["links"].as_array().unwrap().iter().map(text).collect(),
        joints: v["joints"].as_array().unwrap().iter().map(joint).collect(),
        dofs: v["dofs"].as_array().unwrap().iter().map(dof).collect(),
    }
}

/// A tree with the chain that the vectors were made for.
pub struct Reference {
    pub name: String,
    pub tree: Tree,
    pub chain: Chain,
    cases: Vec<Value>,
}

pub fn references() -> Vec<Reference> {
    let json: Value = serde_json::from_str(include_str!("kinematics.json")).unwrap();
    let reference = |v: &Value| {
        let tree = read_tree(&v["tree"]);
        let link = |name: &Value| tree.links.iter().position(|l| l == name.as_str().unwrap()).unwrap();
        let c = &v["chain"];
        let chain = Chain::new(&tree, link(&c["base"]), link(&c["tip"]), &pose(&c["X_LT"])).unwrap();
        let columns: Vec<usize> = c["columns"]
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_u64().unwrap() as usize)
            .collect();
        assert_eq!(chain.dof_indices(), columns);
        Reference {
            name: text(&v["name"]),
            tree,
            chain,
            cases: c["cases"].as_array().unwrap().clone(),
        }
    };
    json["trees"].as_array().unwrap().iter().map(reference).collect()
}

fn assert_close(found: &Pose, expected: &Pose, what: &str) {
    let p = (found.translation.vector - expected.translation.vector).norm();
    let r = found.rotation.angle_to(&expected.rotation);
    // An angle near 0 is an arc cosine near 1: 1e-8 is what a double can tell.
    assert!(p < 1e-9 && r < 5e-8, "{what}: off by {p} m, {r} rad");
    let m = (found.rotation.to_rotation_matrix().matrix() - expected.rotation.to_rotation_matrix().matrix())
        .abs()
        .max();
    assert!(m < 1e-9, "{what}: rotation off by {m}");
}

#[test]
fn link_poses_are_those_of_another_tool() {
    for Reference { name, tree, cases, .. } in references() {
        assert!(!cases.is_empty());
        for case in &cases {
            let found = tree.link_poses(&Pose::identity(), &numbers(&case["q"]));
            let expected = case["X_BL"].as_array().unwrap();
            assert_eq!(found.len(), expected.len());
            for (l, X) in found.iter().enumerate() {
                assert_close(X, &pose(&expected[l]), &format!("{name}, {}", tree.links[l]));
            }
        }
    }
}

#[test]
fn tool_poses_and_jacobians_are_those_of_another_tool() {
    for Reference { name, chain, cases, .. } in references() {
        for case in &cases {
            let full = numbers(&case["q"]);
            let q: Vec<f64> = chain.dof_indices().iter().map(|&d| full[d]).collect();
            let (X_KT, J_KT) = chain.jacobian(&q);
            assert_close(&X_KT, &pose(&case["X_KT"]), &name);
            assert_close(&chain.tool_pose(&q), &pose(&case["X_KT"]), &name);
            for (i, column) in case["J_KT"].as_array().unwrap().iter().enumerate() {
                for (row, v) in numbers(column).into_iter().enumerate() {
                    assert!(
                        (J_KT[(row, i)] - v).abs() < 1e-9,
                        "{name}: J[{row}, {i}] is {}, not {v}",
                        J_KT[(row, i)]
                    );
                }
            }
        }
    }
}

#[test]
fn a_chain_needs_a_tip_that_descends_from_the_base() {
    let tree = &references()[1].tree;
    assert!(Chain::new(tree, 8, 1, &Pose::identity()).is_none());
    assert!(Chain::new(tree, 8, 9, &Pose::identity()).is_none(), "L9 hangs on L3");
    assert!(Chain::new(tree, 99, 99, &Pose::identity()).is_none());
    assert!(Chain::new(tree, 0, 99, &Pose::identity()).is_none());
    let still = Chain::new(tree, 3, 3, &Pose::translation(0.0, 0.0, 0.1)).unwrap();
    assert_eq!(still.dofs().len(), 0);
    assert_eq!(still.jacobian(&[]).1.ncols(), 0);
    assert_eq!(still.tool_pose(&[]), Pose::translation(0.0, 0.0, 0.1));
}

proptest! {
    #[test]
    fn jacobians_are_finite_differences(which in 0usize..2, u in prop::collection::vec(0.05f64..0.95, 12)) {
        let Reference { chain, .. } = references().swap_remove(which);
        let q = at(chain.dofs(), &u);
        let (X_KT, J_KT) = chain.jacobian(&q);
        let h = 1e-6;
        for i in 0..q.len() {
            let mut ahead = q.clone();
            let mut behind = q.clone();
            ahead[i] += h;
            behind[i] -= h;
            let (X, Y) = (chain.tool_pose(&ahead), chain.tool_pose(&behind));
            let v = (X.translation.vector - Y.translation.vector) / (2.0 * h);
            let w = (X.rotation * Y.rotation.inverse()).scaled_axis() / (2.0 * h);
            for row in 0..3 {
                prop_assert!((J_KT[(row, i)] - v[row]).abs() < 1e-7);
                prop_assert!((J_KT[(row + 3, i)] - w[row]).abs() < 1e-7);
            }
        }
        prop_assert!((X_KT.rotation.norm() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn moved_links_are_enough(which in 0usize..2, u in prop::collection::vec(0.0f64..1.0, 24), picks in prop::collection::vec(0usize..24, 0..4)) {
        let Reference { tree, .. } = references().swap_remove(which);
        let q = at(&tree.dofs, &u);
        let dofs: Vec<usize> = picks.into_iter().map(|p| p % tree.n_dofs()).collect();
        let mut q2 = q.clone();
        for &d in &dofs {
            q2[d] += 0.3;
        }
        let X_WB = Pose::translation(1.0, 2.0, 0.5);
        let links = tree.links_moved_by(&dofs);
        let before = tree.link_poses(&X_WB, &q);
        let after = tree.link_poses(&X_WB, &q2);
        let mut updated = before.clone();
        tree.update_links(&links, &q2, &mut updated);
        prop_assert_eq!(&updated, &after);
        for l in 0..before.len() {
            prop_assert!(links.contains(&l) || before[l] == after[l]);
        }
    }
}

proptest! {
    #[test]
    fn eight_at_a_time_are_eight_times_one(which in 0usize..2, u in prop::collection::vec(prop::collection::vec(-0.5f64..1.5, 24), 8), picks in prop::collection::vec(0usize..24, 1..12)) {
        let Reference { tree, .. } = references().swap_remove(which);
        let dofs: Vec<usize> = picks.iter().map(|p| p % tree.n_dofs()).collect();
        let wanted: Vec<usize> = picks.iter().map(|p| p % tree.links.len()).collect();
        // Angles far beyond what the fast sine takes are among them.
        let mut qs = vec![at(&tree.dofs, &[0.3]); 8];
        for (lane, q) in qs.iter_mut().enumerate() {
            let drawn = at(&tree.dofs, &u[lane]);
            for d in &dofs {
                q[*d] = if lane == 7 { drawn[*d] * 1e7 } else { drawn[*d] };
            }
        }
        let q_x8: Vec<X8> = (0..tree.n_dofs()).map(|d| std::array::from_fn(|lane| qs[lane][d])).collect();
        let X_WB = Pose::translation(1.0, 2.0, 0.5);
        let stand = tree.link_poses(&X_WB, &qs[0]);
        let batch = Batch::new(&tree, &dofs, &wanted);
        let moved = tree.links_moved_by(&dofs);
        prop_assert_eq!(batch.links().to_vec(), wanted.into_iter().filter(|l| moved.contains(l)).collect::<Vec<_>>());
        let (mut scratch, mut poses) = (Vec::new(), Vec::new());
        batch.link_poses(&q_x8, &stand, &mut scratch, &mut poses);
        prop_assert_eq!(poses.len(), batch.links().len());
        for (lane, q) in qs.iter().enumerate() {
            let single = tree.link_poses(&X_WB, q);
            for (X, l) in poses.iter().zip(batch.links()) {
                prop_assert_eq!(X.lane(lane), single[*l]);
                let m = X.rotations();
                let expected = single[*l].rotation.to_rotation_matrix();
                for (row, column) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    prop_assert!((m[row][column][lane] - expected[(row, column)]).abs() < 1e-12);
                }
            }
        }
    }
}

/// A configuration at the fractions `u` of the limits (of one turn, where there are none).
pub fn at(dofs: &[Dof], u: &[f64]) -> Vec<f64> {
    dofs.iter()
        .zip(u.iter().cycle())
        .map(|(d, u)| {
            let (lower, upper) = if d.upper.is_finite() {
                (d.lower, d.upper)
            } else {
                (-std::f64::consts::PI, std::f64::consts::PI)
            };
            lower + u * (upper - lower)
        })
        .collect()
}
