//! Arms of every family that has a closed form, and arms that have none.

use nalgebra::UnitQuaternion;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::ik::{Settings, Target, solutions, solve, solve_numerically};
use sgap::geom::kinematics::{Chain, Dof, Drive, Joint, JointKind, Tree};
use sgap::geom::{Pose, Vec3};

use crate::kinematics::references;

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// Joints as (offset from the joint before, axis, lower, upper), all frames parallel at zero.
fn arm(joints: &[([f64; 3], [f64; 3], f64, f64)], tool: [f64; 3]) -> Chain {
    let mut tree = Tree {
        links: vec!["base".into()],
        ..Tree::default()
    };
    for (i, (p, axis, lower, upper)) in joints.iter().enumerate() {
        tree.links.push(format!("l{i}"));
        tree.joints.push(Joint {
            name: format!("j{i}"),
            kind: JointKind::Revolute,
            parent: i,
            X_PJ: Pose::translation(p[0], p[1], p[2]),
            axis: Vec3::from(*axis).normalize(),
            drive: Some(Drive {
                dof: i,
                scale: 1.0,
                offset: 0.0,
            }),
        });
        tree.dofs.push(Dof {
            name: format!("j{i}"),
            lower: *lower,
            upper: *upper,
            max_velocity: 1.0,
            max_acceleration: 1.0,
            max_jerk: 10.0,
        });
    }
    Chain::new(&tree, 0, joints.len(), &Pose::translation(tool[0], tool[1], tool[2])).unwrap()
}

/// Name, chain, how many joints are held.
pub fn arms() -> Vec<(&'static str, Chain, usize)> {
    let minus = |a: [f64; 3]| a.map(|v| -v);
    let mut arms = vec![
        (
            "spherical wrist, shoulder axes meet",
            arm(
                &[
                    ([0.0, 0.0, 0.67], Z, -2.7, 2.7),
                    ([0.0, 0.14, 0.0], Y, -2.0, 2.0),
                    ([0.43, 0.0, 0.0], Y, -2.5, 2.5),
                    ([0.02, 0.0, 0.43], Z, -3.0, 3.0),
                    ([0.0; 3], Y, -1.9, 1.9),
                    ([0.0; 3], Z, -4.0, 4.0),
                ],
                [0.05, 0.0, 0.1],
            ),
            0,
        ),
        (
            "spherical wrist, shoulder with an offset",
            arm(
                &[
                    ([0.0, 0.0, 0.4], Z, -2.9, 2.9),
                    ([0.15, 0.0, 0.0], Y, -2.2, 1.5),
                    ([0.0, 0.03, 0.6], Y, -2.0, 2.6),
                    ([0.1, 0.0, 0.12], X, -3.1, 3.1),
                    ([0.6, 0.0, 0.0], Y, -2.1, 2.1),
                    ([0.1, 0.0, 0.0], X, -6.2, 6.2),
                ],
                [0.1, 0.0, 0.0],
            ),
            0,
        ),
        (
            "spherical wrist, axes askew",
            arm(
                &[
                    ([0.0, 0.0, 0.3], [0.1, 0.2, 1.0], -3.0, 3.0),
                    ([0.15, 0.1, 0.0], [0.3, 1.0, -0.2], -3.0, 3.0),
                    ([0.1, -0.2, 0.4], [1.0, 0.2, 0.4], -3.0, 3.0),
                    ([0.1, 0.3, 0.2], [0.2, 0.1, 1.0], -3.0, 3.0),
                    ([0.0; 3], [1.0, 0.3, 0.2], -3.0, 3.0),
                    ([0.0; 3], [0.1, 1.0, 0.3], -3.0, 3.0),
                ],
                [0.05, 0.02, 0.1],
            ),
            0,
        ),
        (
            "spherical shoulder",
            arm(
                &[
                    ([0.0, 0.0, 0.3], Z, -2.5, 2.5),
                    ([0.0; 3], Y, -1.7, 1.7),
                    ([0.0, 0.0, 0.3], Z, -2.8, 2.8),
                    ([0.08, 0.0, 0.1], Y, -2.6, 2.6),
                    ([0.05, 0.0, 0.4], X, -3.0, 3.0),
                    ([0.1, 0.1, 0.0], Y, -2.0, 2.0),
                ],
                [0.0, 0.0, 0.1],
            ),
            0,
        ),
        (
            "three parallel axes",
            arm(
                &[
                    ([0.0, 0.0, 0.089], Z, -6.2, 6.2),
                    ([0.0, 0.136, 0.0], Y, -6.2, 6.2),
                    ([0.425, -0.12, 0.0], Y, -3.1, 3.1),
                    ([0.392, 0.0, 0.0], minus(Y), -6.2, 6.2),
                    ([0.0, 0.093, 0.0], minus(Z), -6.2, 6.2),
                    ([0.0, 0.0, -0.095], Y, -6.2, 6.2),
                ],
                [0.0, 0.08, 0.0],
            ),
            0,
        ),
        (
            "spherical shoulder, elbow, spherical wrist",
            arm(
                &[
                    ([0.0, 0.0, 0.36], Z, -2.96, 2.96),
                    ([0.0; 3], Y, -2.09, 2.09),
                    ([0.0; 3], Z, -2.96, 2.96),
                    ([0.0, 0.0, 0.42], minus(Y), -2.09, 2.09),
                    ([0.0; 3], Z, -2.96, 2.96),
                    ([0.0, 0.0, 0.4], Y, -2.09, 2.09),
                    ([0.0; 3], Z, -3.05, 3.05),
                ],
                [0.0, 0.0, 0.126],
            ),
            1,
        ),
        (
            "panda",
            arm(
                &[
                    ([0.0, 0.0, 0.333], Z, -2.8973, 2.8973),
                    ([0.0; 3], Y, -1.7628, 1.7628),
                    ([0.0, 0.0, 0.316], Z, -2.8973, 2.8973),
                    ([0.0825, 0.0, 0.0], minus(Y), -3.0718, -0.0698),
                    ([-0.0825, 0.0, 0.384], Z, -2.8973, 2.8973),
                    ([0.0; 3], minus(Y), -0.0175, 3.7525),
                    ([0.088, 0.0, 0.0], minus(Z), -2.8973, 2.8973),
                ],
                [0.0, 0.0, -0.107],
            ),
            1,
        ),
    ];
    // Shoulder with an offset, elbow, spherical wrist; two of its joints turn without limits.
    arms.push(("pr2", references().swap_remove(0).chain, 1));
    arms
}

pub fn draw(chain: &Chain, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let one = |d: &Dof| {
        let (lower, upper) = if d.lower.is_finite() {
            (d.lower, d.upper)
        } else {
            (-3.1, 3.1)
        };
        rng.random_range(lower..upper)
    };
    chain.dofs().iter().map(one).collect()
}

/// Distance [m] and angle [rad] of two poses; the angle by the sine, which tells small ones.
fn off(a: &Pose, b: &Pose) -> (f64, f64) {
    let turn = (a.rotation.inverse() * b.rotation).imag().norm();
    ((a.translation.vector - b.translation.vector).norm(), 2.0 * turn)
}

fn assert_exact(chain: &Chain, target: &Pose, q: &[f64], what: &str) {
    let (p, r) = off(&chain.tool_pose(q), target);
    assert!(p < 1e-9 && r < 1e-9, "{what}: off by {p} m, {r} rad at {q:?}");
    for (v, dof) in q.iter().zip(chain.dofs()) {
        assert!(*v >= dof.lower && *v <= dof.upper, "{what}: {} at {v}", dof.name);
    }
}

#[test]
fn all_solutions_are_exact_within_limits_and_one_is_where_the_arm_was() {
    for (name, chain, n_held) in arms() {
        let form = chain
            .closed_form()
            .unwrap_or_else(|| panic!("{name} has no closed form"));
        assert_eq!(form.held().len(), n_held, "{name}");
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut n = 0;
        for _ in 0..1000 {
            let q = draw(&chain, &mut rng);
            let X_KT = chain.tool_pose(&q);
            let found = form.solve(&chain, &X_KT, &q);
            n += found.len();
            let nearest = found.first().unwrap_or_else(|| panic!("{name}: nothing at {q:?}"));
            assert!(
                nearest.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-6),
                "{name}: {nearest:?} is not {q:?}"
            );
            for (i, s) in found.iter().enumerate() {
                assert_exact(&chain, &X_KT, s, name);
                assert!(form.held().iter().all(|h| s[*h] == q[*h]));
                let again = |o: &&Vec<f64>| o.iter().zip(s).all(|(a, b)| (a - b).abs() < 1e-7);
                assert_eq!(found[..i].iter().filter(again).count(), 0, "{name}: twice {s:?}");
            }
        }
        assert!(n > 1300, "{name}: {n} solutions of 1000 poses");
    }
}

#[test]
fn singular_poses_are_reached() {
    for (name, chain, n_held) in arms() {
        let form = chain.closed_form().unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for k in 0..chain.dofs().len() {
            for _ in 0..50 {
                // Joints at zero stretch elbows and straighten wrists.
                let mut q = draw(&chain, &mut rng);
                for (i, v) in q.iter_mut().enumerate() {
                    let dof = &chain.dofs()[i];
                    if i == k || rng.random::<f64>() < 0.3 {
                        *v = 0.0_f64.max(dof.lower).min(dof.upper);
                    }
                }
                let X_KT = chain.tool_pose(&q);
                let found = form.solve(&chain, &X_KT, &q);
                // A stretched elbow wants one value of the held joint to the last bit: then the descent finds the pose.
                let settings = Settings {
                    max_iterations: 100,
                    restarts: 30,
                    position_tolerance: 1e-5,
                    rotation_tolerance: 1e-4,
                };
                let reached = || {
                    solve(
                        &chain,
                        &Target::Pose(X_KT),
                        &q,
                        &settings,
                        &mut rng.clone(),
                        &mut |_| true,
                    )
                    .is_ok()
                };
                assert!(!found.is_empty() || (n_held > 0 && reached()), "{name}: {q:?}");
                for s in &found {
                    assert_exact(&chain, &X_KT, s, name);
                }
                // Whose stretched elbow wants one value of the held joint, of all that there are.
                if n_held > 0 {
                    continue;
                }
                let settings = Settings {
                    max_iterations: 60,
                    restarts: 100,
                    position_tolerance: 1e-5,
                    rotation_tolerance: 1e-4,
                };
                let start = draw(&chain, &mut rng);
                let found = solve(&chain, &Target::Pose(X_KT), &start, &settings, &mut rng, &mut |_| true);
                assert!(found.is_ok(), "{name}: {q:?} from {start:?}");
            }
        }
    }
}

fn goes_downhill(chain: &Chain, X_KT: &Pose, restarts: u32, rng: &mut ChaCha8Rng) -> bool {
    let settings = Settings {
        max_iterations: 100,
        restarts,
        position_tolerance: 1e-7,
        rotation_tolerance: 1e-7,
    };
    let seed = draw(chain, rng);
    solve_numerically(chain, &Target::Pose(*X_KT), &seed, &settings, rng, &mut |_| true).is_ok()
}

#[test]
fn the_closed_form_and_the_numeric_way_agree_on_what_can_be_reached() {
    for (name, chain, n_held) in arms() {
        if n_held > 0 {
            continue;
        }
        let form = chain.closed_form().unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut reached, mut missed) = (0, 0);
        for _ in 0..150 {
            // Some of them out of reach.
            let mut v = |far: f64| Vec3::from_fn(|_, _| rng.random_range(-far..far));
            let X_KT = Pose::from_parts(v(0.9).into(), UnitQuaternion::from_scaled_axis(v(2.0)));
            let exact = form.solve(&chain, &X_KT, &[0.0; 6]);
            let downhill = goes_downhill(&chain, &X_KT, 15, &mut rng);
            assert!(!downhill || !exact.is_empty(), "{name}: {X_KT:?} can be reached");
            reached += usize::from(!exact.is_empty());
            missed += usize::from(!exact.is_empty() && !downhill);
        }
        assert!((10..=145).contains(&reached), "{name}: {reached} of 150");
        assert!(
            missed * 5 <= reached,
            "{name}: {missed} of {reached} are none, downhill"
        );
    }
}

#[test]
fn solutions_are_distinct_and_the_nearest_come_first() {
    let settings = Settings {
        max_iterations: 60,
        restarts: 20,
        position_tolerance: 1e-5,
        rotation_tolerance: 1e-4,
    };
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    for (name, chain, n_held) in arms() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for _ in 0..30 {
            let (q, seed) = (draw(&chain, &mut rng), draw(&chain, &mut rng));
            let target = Target::Pose(chain.tool_pose(&q));
            let go = |limit: usize, accept: &mut dyn FnMut(&[f64]) -> bool| {
                let mut rng = ChaCha8Rng::seed_from_u64(5);
                solutions(&chain, &target, &seed, &settings, limit, &mut rng, accept)
            };
            let all = go(usize::MAX, &mut |_| true);
            assert!(n_held > 0 || !all.is_empty(), "{name}");
            for (i, s) in all.iter().enumerate() {
                let (p, r) = off(&chain.tool_pose(s), &chain.tool_pose(&q));
                assert!(p <= 1e-5 && r <= 1e-4, "{name}: off by {p} m, {r} rad");
                assert!(all[..i].iter().all(|o| apart(o, s) > 0.05), "{name}");
                assert!(i == 0 || apart(&all[i - 1], &seed) <= apart(s, &seed), "{name}");
            }
            assert_eq!(go(2, &mut |_| true), all[..all.len().min(2)]);
            let mut offered = 0;
            let odd = go(usize::MAX, &mut |_| {
                offered += 1;
                offered % 2 == 1
            });
            assert_eq!(odd, all.iter().step_by(2).cloned().collect::<Vec<_>>(), "{name}");
        }
    }
}

#[test]
fn arms_of_no_family_are_left_to_the_numeric_way() {
    // Five joints; six joints whose wrist does not meet; joints that are driven together.
    assert!(references()[1].chain.closed_form().is_none());
    let bent = arm(
        &[
            ([0.0, 0.0, 0.4], Z, -3.0, 3.0),
            ([0.1, 0.0, 0.0], Y, -3.0, 3.0),
            ([0.0, 0.03, 0.5], X, -3.0, 3.0),
            ([0.1, 0.0, 0.1], Z, -3.0, 3.0),
            ([0.05, 0.0, 0.2], Y, -3.0, 3.0),
            ([0.05, 0.0, 0.0], X, -3.0, 3.0),
        ],
        [0.1, 0.0, 0.0],
    );
    assert!(bent.closed_form().is_none());
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let q = draw(&bent, &mut rng);
    assert!(goes_downhill(&bent, &bent.tool_pose(&q), 50, &mut rng));
}
