//! Poses that a chain can reach, because they are where it was.

use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::ik::{Settings, Target, solve};
use sgap::geom::kinematics::{Chain, Tree};
use sgap::geom::{Pose, Vec3};

use crate::kinematics::{Reference, at, references};

const SETTINGS: Settings = Settings {
    max_iterations: 60,
    restarts: 60,
    position_tolerance: 1e-5,
    rotation_tolerance: 1e-4,
};

proptest! {
    #[test]
    fn fk_of_ik_is_the_target(which in 0usize..2, u in prop::collection::vec(0.0f64..1.0, 12), v in prop::collection::vec(0.0f64..1.0, 12), seed in 0u64..1000) {
        let Reference { chain, .. } = references().swap_remove(which);
        let X_KT = chain.tool_pose(&at(chain.dofs(), &u));
        let start = at(chain.dofs(), &v);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut offered = 0;
        let found = solve(&chain, &Target::Pose(X_KT), &start, &SETTINGS, &mut rng, &mut |_| { offered += 1; true });
        // The synthetic chain has five dofs: a local search may miss its few solutions. What is said to be one must be one.
        prop_assert!(which == 1 || found.is_ok(), "{found:?}");
        match found {
            Ok(q) => {
                let X = chain.tool_pose(&q);
                prop_assert!((X.translation.vector - X_KT.translation.vector).norm() < 1e-4);
                prop_assert!(X.rotation.angle_to(&X_KT.rotation) < 1e-3);
                for (i, (v, dof)) in q.iter().zip(chain.dofs()).enumerate() {
                    prop_assert!(*v >= dof.lower && *v <= dof.upper);
                    if chain.is_continuous(i) {
                        prop_assert!((v - start[i]).abs() <= std::f64::consts::PI + 1e-9);
                    }
                }
                prop_assert_eq!(offered, 1);
            }
            Err(no) => {
                prop_assert_eq!(no.rejected, 0);
                prop_assert!(no.position_error > 1e-5 || no.rotation_error > 1e-4);
            }
        }
    }

    #[test]
    fn points_are_reached_in_any_orientation(u in prop::collection::vec(0.0f64..1.0, 12), seed in 0u64..1000) {
        let Reference { chain, .. } = references().swap_remove(0);
        let p_KT = chain.tool_pose(&at(chain.dofs(), &u)).translation.vector;
        let start = at(chain.dofs(), &[0.5]);
        let q = solve(&chain, &Target::Point(p_KT), &start, &SETTINGS, &mut ChaCha8Rng::seed_from_u64(seed), &mut |_| true).unwrap();
        prop_assert!((chain.tool_pose(&q).translation.vector - p_KT).norm() < 1e-4);
    }
}

#[test]
fn refused_solutions_are_counted_and_others_follow() {
    let Reference { chain, .. } = references().swap_remove(0);
    let start = at(chain.dofs(), &[0.4]);
    let target = Target::Pose(chain.tool_pose(&at(chain.dofs(), &[0.45, 0.55])));
    let mut offered: Vec<Vec<f64>> = Vec::new();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let found = solve(&chain, &target, &start, &SETTINGS, &mut rng, &mut |q| {
        offered.push(q.to_vec());
        offered.len() == 4
    });
    assert_eq!(found.as_ref(), Ok(&offered[3]));
    assert!(
        offered
            .windows(2)
            .any(|w| w[0].iter().zip(&w[1]).any(|(a, b)| (a - b).abs() > 0.1))
    );

    let no = solve(&chain, &target, &start, &SETTINGS, &mut rng, &mut |_| false).unwrap_err();
    assert!(no.rejected > 30 && no.position_error <= 1e-5, "{no:?}");
}

#[test]
fn what_is_out_of_reach_says_how_far() {
    let Reference { chain, .. } = references().swap_remove(0);
    let start = at(chain.dofs(), &[0.4]);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut error_at = |x: f64| {
        solve(
            &chain,
            &Target::Point(Vec3::new(x, -0.2, 0.0)),
            &start,
            &SETTINGS,
            &mut rng,
            &mut |_| true,
        )
        .unwrap_err()
        .position_error
    };
    let (far, farther) = (error_at(3.0), error_at(4.0));
    // The arm is stretched towards it both times.
    assert!((farther - far - 1.0).abs() < 0.05, "{far} {farther}");
}

#[test]
fn a_chain_that_cannot_move_is_answered() {
    let tree = Tree {
        links: vec!["root".into()],
        joints: Vec::new(),
        dofs: Vec::new(),
    };
    let chain = Chain::new(&tree, 0, 0, &Pose::identity()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut solve = |x: f64| {
        solve(
            &chain,
            &Target::Point(Vec3::new(x, 0.0, 0.0)),
            &[],
            &SETTINGS,
            &mut rng,
            &mut |_| true,
        )
    };
    assert_eq!(solve(0.0), Ok(Vec::new()));
    assert_eq!(solve(1.0).unwrap_err().position_error, 1.0);
}

#[test]
fn same_seed_same_solution() {
    let Reference { chain, .. } = references().swap_remove(0);
    let start = at(chain.dofs(), &[0.2, 0.7]);
    let target = Target::Pose(chain.tool_pose(&at(chain.dofs(), &[0.9, 0.3, 0.1])));
    let go = || {
        solve(
            &chain,
            &target,
            &start,
            &SETTINGS,
            &mut ChaCha8Rng::seed_from_u64(5),
            &mut |q| q[0] < 0.0,
        )
    };
    assert_eq!(go(), go());
}
