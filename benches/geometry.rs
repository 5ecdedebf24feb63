//! Forward and inverse kinematics, contact and motion of a PR2's right arm (`tests/geometry/kinematics.json`).
//!
//! `cargo bench --bench geometry`; compare figures of one run with each other, since machines drift.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a benchmark that fails stops here")]

#[path = "../tests/geometry/kinematics.rs"]
#[expect(dead_code, unused_imports, reason = "the tests of that file are not run here")]
mod kinematics;

#[path = "../tests/geometry/collisions.rs"]
#[expect(dead_code, reason = "the tests of that file are not run here")]
mod collisions;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::UnitQuaternion;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::checker::{Checker, LANES};
use sgap::geom::collide::{Solid, distance, ray, touch};
use sgap::geom::ik::{self, Target, solve};
use sgap::geom::kinematics::batch::{Batch, X8};
use sgap::geom::kinematics::{Chain, Dof, JointKind, Tree};
use sgap::geom::motion::rrt_connect::{self, rrt_connect};
use sgap::geom::motion::shortcut::{self, shortcut};
use sgap::geom::motion::timing::{self, time};
use sgap::geom::motion::{Path, Space};
use sgap::geom::shape::Shape;
use sgap::geom::{Pose, Vec3};

fn main() {
    divan::main();
}

/// So many different inputs are gone through in turn.
const N: usize = 512;

fn pr2() -> (Tree, Chain) {
    let arm = kinematics::references().swap_remove(0);
    (arm.tree, arm.chain)
}

fn configurations(dofs: &[Dof], seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || {
        let u: Vec<f64> = dofs.iter().map(|_| rng.random()).collect();
        kinematics::at(dofs, &u)
    };
    (0..N).map(|_| one()).collect()
}

/// Goes through `0..N` for ever.
fn counter() -> impl FnMut() -> usize {
    let mut i = 0;
    move || {
        i = (i + 1) % N;
        i
    }
}

#[divan::bench]
fn fk_all_links(bencher: Bencher) {
    let (tree, _) = pr2();
    let q = configurations(&tree.dofs, 1);
    let (mut X_WL, mut next) = (Vec::new(), counter());
    bencher.bench_local(|| tree.link_poses_into(&Pose::identity(), black_box(&q[next()]), &mut X_WL));
}

/// What one writes first: library rotations, and a product for each transform.
#[divan::bench]
fn fk_all_links_naive(bencher: Bencher) {
    let (tree, _) = pr2();
    let q = configurations(&tree.dofs, 1);
    let (mut X_WL, mut next) = (Vec::new(), counter());
    bencher.bench_local(|| {
        X_WL.clear();
        X_WL.push(Pose::identity());
        let q = black_box(&q[next()]);
        for joint in &tree.joints {
            let v = joint.value(q);
            let moved = match joint.kind {
                JointKind::Fixed => Pose::identity(),
                JointKind::Revolute => Pose::new(Vec3::zeros(), joint.axis * v),
                JointKind::Prismatic => Pose::new(joint.axis * v, Vec3::zeros()),
            };
            X_WL.push(X_WL[joint.parent] * joint.X_PJ * moved);
        }
    });
}

/// Eight configurations a call.
#[divan::bench(counters = [divan::counter::ItemsCount::new(8_u32)])]
fn fk_all_links_x8(bencher: Bencher) {
    let (tree, _) = pr2();
    let q = configurations(&tree.dofs, 1);
    let eights: Vec<Vec<X8>> = q
        .chunks_exact(8)
        .map(|c| {
            (0..tree.n_dofs())
                .map(|d| std::array::from_fn(|lane| c[lane][d]))
                .collect()
        })
        .collect();
    let all: Vec<usize> = (0..tree.links.len()).collect();
    let dofs: Vec<usize> = (0..tree.n_dofs()).collect();
    let batch = Batch::new(&tree, &dofs, &all);
    let X_WL = tree.link_poses(&Pose::identity(), &q[0]);
    let (mut scratch, mut poses, mut next) = (Vec::new(), Vec::new(), counter());
    bencher.bench_local(|| {
        batch.link_poses(
            black_box(&eights[next() % eights.len()]),
            &X_WL,
            &mut scratch,
            &mut poses,
        )
    });
}

#[divan::bench]
fn fk_tool(bencher: Bencher) {
    let (_, chain) = pr2();
    let q = configurations(chain.dofs(), 1);
    let mut next = counter();
    bencher.bench_local(|| chain.tool_pose(black_box(&q[next()])));
}

#[divan::bench]
fn jacobian(bencher: Bencher) {
    let (_, chain) = pr2();
    let q = configurations(chain.dofs(), 1);
    let (mut columns, mut next) = (Vec::new(), counter());
    bencher.bench_local(|| chain.jacobian_into(black_box(&q[next()]), &mut columns));
}

const IK: ik::Settings = ik::Settings {
    max_iterations: 60,
    restarts: 20,
    position_tolerance: 1e-5,
    rotation_tolerance: 1e-4,
};

/// Random poses that can be reached, from random seeds.
#[divan::bench]
fn ik_far(bencher: Bencher) {
    let (_, chain) = pr2();
    let targets: Vec<Target> = configurations(chain.dofs(), 2)
        .iter()
        .map(|q| Target::Pose(chain.tool_pose(q)))
        .collect();
    let seeds = configurations(chain.dofs(), 3);
    let (mut rng, mut next) = (ChaCha8Rng::seed_from_u64(4), counter());
    bencher.bench_local(|| {
        let i = next();
        solve(&chain, &targets[i], &seeds[i], &IK, &mut rng, &mut |_| true).is_ok()
    });
}

/// The same from seeds within 0.2 rad.
#[divan::bench]
fn ik_near(bencher: Bencher) {
    let (_, chain) = pr2();
    let seeds = configurations(chain.dofs(), 2);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut beside = |q: &Vec<f64>| q.iter().map(|v| v + rng.random_range(-0.2..0.2)).collect::<Vec<f64>>();
    let targets: Vec<Target> = seeds
        .iter()
        .map(|q| Target::Pose(chain.tool_pose(&beside(q))))
        .collect();
    let mut next = counter();
    bencher.bench_local(|| {
        let i = next();
        solve(&chain, &targets[i], &seeds[i], &IK, &mut rng, &mut |_| true).is_ok()
    });
}

const KINDS: [&str; 4] = ["box", "cylinder", "sphere", "capsule"];

fn shape(kind: &str, rng: &mut ChaCha8Rng) -> Shape {
    let mut size = || rng.random_range(0.05..0.3);
    match kind {
        "box" => Shape::Box {
            half: Vec3::new(size(), size(), size()),
        },
        "cylinder" => Shape::Cylinder {
            radius: size(),
            half_length: size(),
        },
        "sphere" => Shape::Sphere { radius: size() },
        _ => Shape::Capsule {
            radius: size(),
            half_length: size(),
        },
    }
}

fn pose(rng: &mut ChaCha8Rng, far: f64) -> Pose {
    let mut v = |m: f64| {
        Vec3::new(
            rng.random_range(-m..m),
            rng.random_range(-m..m),
            rng.random_range(-m..m),
        )
    };
    Pose::from_parts(v(far).into(), UnitQuaternion::from_scaled_axis(v(2.0)))
}

type Pair = (Solid, Pose, Solid, Pose);

fn pairs(a: &str, b: &str) -> Vec<Pair> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut one = || {
        let (s, t) = (Solid::new(&shape(a, &mut rng)), Solid::new(&shape(b, &mut rng)));
        (s, pose(&mut rng, 0.3), t, pose(&mut rng, 0.3))
    };
    (0..N).map(|_| one()).collect()
}

/// About half of the pairs touch, and most of the others are near.
#[divan::bench(args = ["box box", "box cylinder", "box sphere", "box capsule", "cylinder cylinder", "cylinder capsule", "capsule capsule"])]
fn touch_near(bencher: Bencher, kinds: &str) {
    let (a, b) = kinds.split_once(' ').unwrap();
    let pairs = pairs(a, b);
    let mut next = counter();
    bencher.bench_local(|| {
        let (s, X, t, Y) = black_box(&pairs[next()]);
        touch(s, X, t, Y)
    });
}

#[divan::bench(args = ["box box", "box cylinder", "box capsule", "capsule capsule"])]
fn distance_near(bencher: Bencher, kinds: &str) {
    let (a, b) = kinds.split_once(' ').unwrap();
    let pairs = pairs(a, b);
    let mut next = counter();
    bencher.bench_local(|| {
        let (s, X, t, Y) = black_box(&pairs[next()]);
        distance(s, X, t, Y)
    });
}

#[divan::bench(args = KINDS)]
fn ray_near(bencher: Bencher, kind: &str) {
    let pairs = pairs(kind, "sphere");
    let mut next = counter();
    bencher.bench_local(|| {
        let (s, X, _, Y) = black_box(&pairs[next()]);
        let p = Y.translation.vector + Vec3::new(1.0, 0.0, 0.0);
        ray(s, X, &p, &-Vec3::x(), 3.0)
    });
}

/// The arm as four solids, among five boxes and cylinders.
struct Arm {
    tree: Tree,
    dofs: Vec<Dof>,
    indices: Vec<usize>,
    moved: Vec<usize>,
    bodies: Vec<(usize, Solid)>,
    things: Vec<(Solid, Pose)>,
    q: Vec<f64>,
    X_WL: Vec<Pose>,
}

fn arm() -> Arm {
    let (tree, chain) = pr2();
    let link = |name: &str| tree.links.iter().position(|l| l == name).unwrap();
    let solid = |shape: Shape| Solid::padded(&shape, 0.01);
    let bodies = vec![
        (link("r_elbow_flex_link"), solid(Shape::Sphere { radius: 0.1 })),
        (
            link("r_forearm_link"),
            solid(Shape::Capsule {
                radius: 0.07,
                half_length: 0.05,
            }),
        ),
        (
            link("r_wrist_flex_link"),
            solid(Shape::Cylinder {
                radius: 0.05,
                half_length: 0.05,
            }),
        ),
        (
            link("r_gripper_tool_frame"),
            solid(Shape::Box {
                half: Vec3::new(0.05, 0.05, 0.03),
            }),
        ),
    ];
    let thing = |shape: Shape, x: f64, y: f64, z: f64| (Solid::new(&shape), Pose::translation(x, y, z));
    let can = Shape::Cylinder {
        radius: 0.04,
        half_length: 0.1,
    };
    let things = vec![
        thing(
            Shape::Box {
                half: Vec3::new(0.3, 0.5, 0.02),
            },
            0.7,
            -0.3,
            0.75,
        ),
        thing(
            Shape::Box {
                half: Vec3::new(0.05, 0.05, 0.3),
            },
            0.6,
            -0.4,
            1.05,
        ),
        thing(
            Shape::Box {
                half: Vec3::new(0.3, 0.5, 0.02),
            },
            0.7,
            -0.3,
            1.3,
        ),
        thing(can.clone(), 0.6, -0.1, 0.87),
        thing(can, 0.6, -0.7, 0.87),
    ];
    let indices = chain.dof_indices().to_vec();
    let q = kinematics::at(&tree.dofs, &[0.5]);
    let X_WL = tree.link_poses(&Pose::identity(), &q);
    Arm {
        dofs: chain.dofs().to_vec(),
        moved: tree.links_moved_by(&indices),
        indices,
        bodies,
        things,
        q,
        X_WL,
        tree,
    }
}

impl Space for Arm {
    fn dofs(&self) -> &[Dof] {
        &self.dofs
    }
    fn is_free(&mut self, q: &[f64]) -> bool {
        for (v, i) in q.iter().zip(&self.indices) {
            self.q[*i] = *v;
        }
        self.tree.update_links(&self.moved, &self.q, &mut self.X_WL);
        let X_WL = &self.X_WL;
        self.bodies
            .iter()
            .all(|(l, body)| self.things.iter().all(|(s, X)| !touch(body, &X_WL[*l], s, X)))
    }
}

/// Pairs of free configurations, for motions between them.
fn problems(arm: &mut Arm) -> Vec<(Vec<f64>, Vec<f64>)> {
    let free: Vec<Vec<f64>> = configurations(&arm.dofs.clone(), 6)
        .into_iter()
        .filter(|q| arm.is_free(q))
        .collect();
    free.chunks_exact(2).map(|c| (c[0].clone(), c[1].clone())).collect()
}

const RRT: rrt_connect::Settings = rrt_connect::Settings {
    step: 1.0,
    resolution: 1.0 / 32.0,
    max_samples: 5000,
};

#[divan::bench]
fn is_free_arm(bencher: Bencher) {
    let mut arm = arm();
    let q = configurations(&arm.dofs, 7);
    let mut next = counter();
    bencher.bench_local(|| arm.is_free(black_box(&q[next()])));
}

#[divan::bench]
fn rrt_arm(bencher: Bencher) {
    let mut arm = arm();
    let problems = problems(&mut arm);
    let (mut rng, mut next) = (ChaCha8Rng::seed_from_u64(8), counter());
    bencher.bench_local(|| {
        let (a, b) = &problems[next() % problems.len()];
        rrt_connect(&mut arm, a, b, &RRT, &mut rng).is_ok()
    });
}

fn paths(arm: &mut Arm) -> Vec<Path> {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let problems = problems(arm);
    problems
        .iter()
        .filter_map(|(a, b)| rrt_connect(arm, a, b, &RRT, &mut rng).ok())
        .filter(|p| p.len() > 2)
        .collect()
}

#[divan::bench]
fn shortcut_arm(bencher: Bencher) {
    let mut arm = arm();
    let paths = paths(&mut arm);
    let settings = shortcut::Settings {
        rounds: 50,
        resolution: RRT.resolution,
    };
    let (mut rng, mut next) = (ChaCha8Rng::seed_from_u64(10), counter());
    bencher.bench_local(|| shortcut(&mut arm, paths[next() % paths.len()].clone(), &settings, &mut rng));
}

#[divan::bench]
fn timing_arm(bencher: Bencher) {
    let mut arm = arm();
    let paths = paths(&mut arm);
    let settings = timing::Settings {
        sample_period: 0.05,
        max_deviation: 0.1,
        resolution: RRT.resolution,
    };
    let mut next = counter();
    bencher.bench_local(|| time(&mut arm, &paths[next() % paths.len()], &settings));
}

/// A robot of `tests/geometry/collisions.json` among 20 objects, and what of it moves: all joints, or those of an arm.
struct Crowd {
    robot: collisions::Robot,
    dofs: Vec<usize>,
    rest: Vec<f64>,
    checker: Checker,
}

const CROWDS: [&str; 3] = ["Panda", "PR2, one arm", "PR2, all joints"];

fn crowd(what: &str) -> Crowd {
    let mut robots = collisions::robots();
    let robot = robots.swap_remove(usize::from(what != "Panda"));
    let is_meant = |name: &str| what != "PR2, one arm" || (name.starts_with("r_") && !name.contains("finger"));
    let dofs: Vec<usize> = (0..robot.tree.n_dofs())
        .filter(|d| is_meant(&robot.tree.dofs[*d].name))
        .collect();
    let rest = vec![0.0; robot.tree.n_dofs()];
    Crowd {
        checker: robot.checker(&dofs, &rest),
        robot,
        dofs,
        rest,
    }
}

/// Hit or free: every pair in turn by the exact test, whose bounding spheres come first; N configurations.
#[divan::bench(args = CROWDS)]
fn collision_every_pair(bencher: Bencher, what: &str) {
    let Crowd { robot, dofs, rest, .. } = crowd(what);
    let links = robot.tree.links_moved_by(&dofs);
    let moves: Vec<bool> = robot.bodies.iter().map(|b| links.contains(&b.link)).collect();
    let (mut q, mut X_WL) = (rest.clone(), robot.tree.link_poses(&Pose::identity(), &rest));
    bencher.counter(ItemsCount::new(N)).bench_local(|| {
        let is_free = |all: &&Vec<f64>| {
            dofs.iter().for_each(|d| q[*d] = all[*d]);
            robot.tree.update_links(&links, &q, &mut X_WL);
            robot.is_free_by_pairs(&X_WL, &moves)
        };
        robot.configurations.iter().take(N).filter(is_free).count()
    });
}

/// The same by the checker, one by one.
#[divan::bench(args = CROWDS)]
fn collision_one(bencher: Bencher, what: &str) {
    let Crowd {
        robot,
        dofs,
        mut checker,
        ..
    } = crowd(what);
    let of = |all: &Vec<f64>| dofs.iter().map(|d| all[*d]).collect::<Vec<f64>>();
    let qs: Vec<Vec<f64>> = robot.configurations.iter().take(N).map(of).collect();
    bencher
        .counter(ItemsCount::new(N))
        .bench_local(|| qs.iter().filter(|q| checker.is_free(q)).count());
}

/// The same, eight at a time.
#[divan::bench(args = CROWDS)]
fn collision_eight(bencher: Bencher, what: &str) {
    let Crowd {
        robot,
        dofs,
        mut checker,
        ..
    } = crowd(what);
    let columns = |some: &[Vec<f64>]| dofs.iter().map(|d| std::array::from_fn(|k| some[k][*d])).collect();
    let eights: Vec<Vec<[f64; LANES]>> = robot.configurations[..N].chunks(LANES).map(columns).collect();
    bencher.counter(ItemsCount::new(N)).bench_local(|| {
        let free = |eight: &Vec<[f64; LANES]>| checker.are_free(eight).iter().filter(|f| **f).count();
        eights.iter().map(free).sum::<usize>()
    });
}
