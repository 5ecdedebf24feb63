//! Toy spaces, where the truth is known: discs on a plane, and an arm among boxes.

use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sgap::geom::collide::{Solid, touch};
use sgap::geom::kinematics::{Dof, Tree};
use sgap::geom::motion::rrt_connect::{self, NoPath, rrt_connect};
use sgap::geom::motion::shortcut::{self, shortcut};
use sgap::geom::motion::straight::{self, Cause, straight};
use sgap::geom::motion::timing::{self, Timed, time};
use sgap::geom::motion::{Path, Space, edge_is_free, length};
use sgap::geom::shape::Shape;
use sgap::geom::{Pose, Vec3};

use crate::kinematics::{Reference, at, references};

fn dof(lower: f64, upper: f64) -> Dof {
    Dof {
        name: "d".into(),
        lower,
        upper,
        max_velocity: 1.5,
        max_acceleration: 4.0,
        max_jerk: 40.0,
    }
}

/// A point among discs (x, y, radius), each padded.
struct Plane {
    dofs: Vec<Dof>,
    discs: Vec<(f64, f64, f64)>,
    padding: f64,
}

impl Space for Plane {
    fn dofs(&self) -> &[Dof] {
        &self.dofs
    }
    fn is_free(&mut self, q: &[f64]) -> bool {
        let inside = q.iter().zip(&self.dofs).all(|(v, d)| *v >= d.lower && *v <= d.upper);
        inside
            && self
                .discs
                .iter()
                .all(|(x, y, r)| (q[0] - x).powi(2) + (q[1] - y).powi(2) > (r + self.padding).powi(2))
    }
}

fn plane(discs: Vec<(f64, f64, f64)>, padding: f64) -> Plane {
    Plane {
        dofs: vec![dof(-2.0, 2.0), dof(-2.0, 2.0)],
        discs,
        padding,
    }
}

/// The PR2's arm as capsules, among boxes.
struct Arm {
    tree: Tree,
    dofs: Vec<Dof>,
    indices: Vec<usize>,
    bodies: Vec<(usize, Solid)>,
    boxes: Vec<(Solid, Pose)>,
    q: Vec<f64>,
    X_WL: Vec<Pose>,
}

fn arm(padding: f64) -> Arm {
    let Reference { tree, chain, .. } = references().swap_remove(0);
    let link = |name: &str| tree.links.iter().position(|l| l == name).unwrap();
    let ball = |radius| Solid::padded(&Shape::Sphere { radius }, padding);
    let bodies = vec![
        (link("r_elbow_flex_link"), ball(0.1)),
        (link("r_forearm_link"), ball(0.08)),
        (link("r_wrist_flex_link"), ball(0.07)),
        (
            link("r_gripper_tool_frame"),
            Solid::padded(
                &Shape::Capsule {
                    radius: 0.04,
                    half_length: 0.05,
                },
                padding,
            ),
        ),
    ];
    let boxes = vec![
        (
            Solid::new(&Shape::Box {
                half: Vec3::new(0.3, 0.5, 0.02),
            }),
            Pose::translation(0.7, -0.3, 0.75),
        ),
        (
            Solid::new(&Shape::Box {
                half: Vec3::new(0.05, 0.05, 0.3),
            }),
            Pose::translation(0.6, -0.4, 1.05),
        ),
    ];
    let q = at(&tree.dofs, &[0.5]);
    let X_WL = tree.link_poses(&Pose::identity(), &q);
    Arm {
        dofs: chain.dofs().to_vec(),
        indices: chain.dof_indices().to_vec(),
        bodies,
        boxes,
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
        self.tree.link_poses_into(&Pose::identity(), &self.q, &mut self.X_WL);
        self.bodies
            .iter()
            .all(|(l, body)| self.boxes.iter().all(|(b, X_WO)| !touch(body, &self.X_WL[*l], b, X_WO)))
    }
}

const PLANE: rrt_connect::Settings = rrt_connect::Settings {
    step: 0.5,
    resolution: 0.02,
    max_samples: 4000,
};

fn path_is_free(space: &mut dyn Space, path: &Path, resolution: f64) -> bool {
    path.windows(2).all(|w| edge_is_free(space, &w[0], &w[1], resolution))
}

fn path_length(path: &Path) -> f64 {
    path.windows(2).map(|w| length(&w[0], &w[1])).sum()
}

/// The rule of `timing`'s head comment, written down a second time.
fn assert_within_limits(dofs: &[Dof], timed: &Timed) {
    let Timed { times, positions } = timed;
    assert_eq!(times.len(), positions.len());
    assert_eq!(times[0], 0.0);
    let n = times.len();
    for (j, dof) in dofs.iter().enumerate() {
        let v: Vec<f64> = (1..n)
            .map(|k| (positions[k][j] - positions[k - 1][j]) / (times[k] - times[k - 1]))
            .collect();
        let dt: Vec<f64> = (1..n).map(|k| times[k] - times[k - 1]).collect();
        for k in 0..v.len() {
            assert!(dt[k] > 0.0);
            assert!(v[k].abs() <= dof.max_velocity * (1.0 + 1e-6), "speed {}", v[k]);
            let a = if k == 0 {
                v[0] / (0.5 * dt[0])
            } else {
                (v[k] - v[k - 1]) / (0.5 * (dt[k] + dt[k - 1]))
            };
            assert!(
                a.abs() <= dof.max_acceleration * (1.0 + 1e-6),
                "acceleration {a} at {k} of {n}"
            );
        }
        if let (Some(v), Some(dt)) = (v.last(), dt.last()) {
            assert!((v / (0.5 * dt)).abs() <= dof.max_acceleration * (1.0 + 1e-6));
        }
        if n < 2 {
            continue;
        }
        // Newton's divided differences, with two samples at rest beyond each end.
        let (first, last) = (dt[0], dt[n - 2]);
        let mut t = vec![times[0] - 2.0 * first, times[0] - first];
        t.extend(times);
        t.extend([times[n - 1] + last, times[n - 1] + 2.0 * last]);
        let mut difference = vec![positions[0][j]; 2];
        difference.extend(positions.iter().map(|q| q[j]));
        difference.extend([positions[n - 1][j]; 2]);
        for order in 1..=3 {
            difference = (order..t.len())
                .map(|k| (difference[k - order + 1] - difference[k - order]) / (t[k] - t[k - order]))
                .collect();
        }
        for (k, d) in difference.iter().enumerate() {
            let jerk = 6.0 * d;
            assert!(jerk.abs() <= dof.max_jerk * (1.0 + 1e-6), "jerk {jerk} at {k} of {n}");
        }
    }
}

fn discs() -> impl Strategy<Value = Vec<(f64, f64, f64)>> {
    prop::collection::vec((-1.5f64..1.5, -1.5f64..1.5, 0.1f64..0.5), 0..8)
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [-2.0f64..2.0, -2.0f64..2.0]
}

proptest! {
    /// Between two free checks at most r apart, nothing padded by r / 2 is hit: so the path is free at any finer step without the padding.
    #[test]
    fn plane_paths_are_free(discs in discs(), a in point(), b in point(), seed in 0u64..100) {
        let mut padded = plane(discs.clone(), 0.5 * PLANE.resolution);
        let mut bare = plane(discs, 0.0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        match rrt_connect(&mut padded, &a, &b, &PLANE, &mut rng) {
            Err(NoPath::Start) => prop_assert!(!padded.is_free(&a)),
            Err(NoPath::Goal) => prop_assert!(!padded.is_free(&b)),
            Err(NoPath::OutOfSamples { drawn }) => prop_assert_eq!(drawn, PLANE.max_samples),
            Ok(path) => {
                prop_assert_eq!(&path[0], &a.to_vec());
                prop_assert_eq!(path.last().unwrap(), &b.to_vec());
                prop_assert!(path_is_free(&mut padded, &path, PLANE.resolution));
                prop_assert!(path_is_free(&mut bare, &path, 0.5 * PLANE.resolution));
                if path.len() > 2 {
                    for w in path.windows(2) {
                        prop_assert!(length(&w[0], &w[1]) <= PLANE.step * (1.0 + 1e-9));
                    }
                }
                let settings = shortcut::Settings { rounds: 50, resolution: PLANE.resolution };
                let shorter = shortcut(&mut padded, path.clone(), &settings, &mut rng);
                prop_assert!(path_length(&shorter) <= path_length(&path) + 1e-9);
                prop_assert!(path_is_free(&mut bare, &shorter, 0.5 * PLANE.resolution));
                prop_assert_eq!(&shorter[0], &path[0]);
                prop_assert_eq!(shorter.last(), path.last());

                let settings = timing::Settings { sample_period: 0.05, max_deviation: 0.1, resolution: PLANE.resolution };
                let timed = time(&mut padded, &shorter, &settings);
                assert_within_limits(&padded.dofs, &timed);
                prop_assert!(path_is_free(&mut bare, &timed.positions, 0.5 * PLANE.resolution));
                prop_assert_eq!(timed.positions.first(), path.first());
                prop_assert_eq!(timed.positions.last(), path.last());
            }
        }
    }

    /// Any zigzag, with edges long and short, repeated vertices and reversals.
    #[test]
    fn any_path_is_timed_within_limits(
        steps in prop::collection::vec((prop::collection::vec(-1.0f64..1.0, 7), prop_oneof![Just(0.0), Just(1e-9), Just(1e-4), Just(0.05), Just(1.0)], any::<bool>()), 1..30),
        deviation in prop_oneof![Just(0.0), 0.001f64..0.3],
        period in 0.005f64..0.2,
    ) {
        let mut q = vec![0.0; 7];
        let mut path = vec![q.clone()];
        let mut last = vec![0.0; 7];
        for (way, scale, back) in steps {
            // Back over the same line, or almost on, or anywhere.
            let way: Vec<f64> = if back { last.iter().zip(&way).map(|(l, w)| -l + 1e-7 * w).collect() } else { way.iter().map(|w| w * scale).collect() };
            q = q.iter().zip(&way).map(|(q, w)| q + w).collect();
            path.push(q.clone());
            last = way;
        }
        let mut space = Plane { dofs: (0..7).map(|i| Dof { max_velocity: 0.5 + i as f64, max_acceleration: 9.0 - i as f64, ..dof(-1e3, 1e3) }).collect(), discs: Vec::new(), padding: 0.0 };
        let timed = time(&mut space, &path, &timing::Settings { sample_period: period, max_deviation: deviation, resolution: 0.05 });
        assert_within_limits(&space.dofs, &timed);
        prop_assert_eq!(timed.positions.first(), path.first());
        if timed.positions.len() > 1 {
            prop_assert_eq!(timed.positions.last(), path.last());
        }
    }

    #[test]
    fn arm_paths_are_free(u in prop::collection::vec(0.1f64..0.9, 7), v in prop::collection::vec(0.1f64..0.9, 7), seed in 0u64..10) {
        // No body of the arm moves more than about 1 m per radian of the joint vector.
        let settings = rrt_connect::Settings { step: 1.0, resolution: 0.03, max_samples: 3000 };
        let (mut padded, mut bare) = (arm(0.02), arm(0.0));
        let (a, b) = (at(&padded.dofs, &u), at(&padded.dofs, &v));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        match rrt_connect(&mut padded, &a, &b, &settings, &mut rng) {
            Ok(path) => {
                prop_assert!(path_is_free(&mut bare, &path, 0.5 * settings.resolution));
                let shorter = shortcut(&mut padded, path, &shortcut::Settings { rounds: 40, resolution: 0.03 }, &mut rng);
                prop_assert!(path_is_free(&mut bare, &shorter, 0.5 * settings.resolution));
                let timed = time(&mut padded, &shorter, &timing::Settings { sample_period: 0.05, max_deviation: 0.1, resolution: 0.03 });
                assert_within_limits(&padded.dofs, &timed);
                prop_assert!(path_is_free(&mut bare, &timed.positions, 0.5 * settings.resolution));
            }
            Err(NoPath::Start) => prop_assert!(!padded.is_free(&a)),
            Err(NoPath::Goal) => prop_assert!(!padded.is_free(&b)),
            Err(NoPath::OutOfSamples { .. }) => {}
        }
    }

    #[test]
    fn the_tool_stays_on_its_line(u in prop::collection::vec(0.25f64..0.75, 7), way in [-0.1f64..0.1, -0.1f64..0.1, -0.1f64..0.1], turn in [-0.3f64..0.3, -0.3f64..0.3, -0.3f64..0.3]) {
        let Reference { chain, .. } = references().swap_remove(0);
        let q = at(chain.dofs(), &u);
        let X_KT_start = chain.tool_pose(&q);
        let turned = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::from(turn)) * X_KT_start.rotation;
        let X_KT_end = Pose::from_parts((X_KT_start.translation.vector + Vec3::from(way)).into(), turned);
        match straight(&chain, &X_KT_end, &q, &LINE, &mut |_| true) {
            Ok(path) => {
                prop_assert_eq!(&path[0], &q);
                let end = chain.tool_pose(path.last().unwrap());
                prop_assert!((end.translation.vector - X_KT_end.translation.vector).norm() < 1e-5);
                prop_assert!(end.rotation.angle_to(&X_KT_end.rotation) < 1e-4);
                for w in path.windows(2) {
                    let middle: Vec<f64> = w[0].iter().zip(&w[1]).map(|(a, b)| 0.5 * (a + b)).collect();
                    for q in [&w[1], &middle] {
                        let p = chain.tool_pose(q).translation.vector - X_KT_start.translation.vector;
                        let line = Vec3::from(way);
                        let off = p - line * (p.dot(&line) / line.norm_squared());
                        prop_assert!(off.norm() < 2e-3, "{} m off the line", off.norm());
                    }
                    for (a, b) in w[0].iter().zip(&w[1]) {
                        prop_assert!((a - b).abs() <= LINE.max_joint_step);
                    }
                }
                let mut space = arm(0.0);
                space.boxes.clear();
                let timed = time(&mut space, &path, &timing::Settings { sample_period: 0.05, max_deviation: 0.005, resolution: 0.03 });
                assert_within_limits(chain.dofs(), &timed);
            }
            Err(no) => prop_assert!((0.0..1.0).contains(&no.fraction)),
        }
    }
}

const LINE: straight::Settings = straight::Settings {
    spacing: 0.01,
    turn_spacing: 0.05,
    max_joint_step: 0.2,
    resolution: 0.03,
    position_tolerance: 1e-6,
    rotation_tolerance: 1e-5,
};

#[test]
fn most_short_lines_can_be_followed() {
    let Reference { chain, .. } = references().swap_remove(0);
    let q = at(chain.dofs(), &[0.5]);
    let X_KT = chain.tool_pose(&q);
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        for d in [-0.1, 0.1] {
            let end = Pose::from_parts((X_KT.translation.vector + axis * d).into(), X_KT.rotation);
            let path = straight(&chain, &end, &q, &LINE, &mut |_| true).unwrap();
            assert_eq!(path.len(), 11);
        }
    }
}

#[test]
fn a_line_says_where_it_ends_and_why() {
    let Reference { chain, .. } = references().swap_remove(0);
    let q = at(chain.dofs(), &[0.5]);
    let X_KT = chain.tool_pose(&q);
    let to = |d: f64| Pose::from_parts((X_KT.translation.vector + Vec3::x() * d).into(), X_KT.rotation);
    let far = straight(&chain, &to(2.0), &q, &LINE, &mut |_| true).unwrap_err();
    assert!(far.fraction > 0.05 && far.fraction < 0.6, "{far:?}");
    assert!(!matches!(far.cause, Cause::Refused));
    let wall = |q: &[f64]| chain.tool_pose(q).translation.x < X_KT.translation.x + 0.055;
    let refused = straight(&chain, &to(0.1), &q, &LINE, &mut |q| wall(q)).unwrap_err();
    assert_eq!(refused.cause, Cause::Refused);
    assert!((refused.fraction - 0.5).abs() < 1e-9);
    let still = straight(&chain, &X_KT, &q, &LINE, &mut |_| true).unwrap();
    assert_eq!(length(&still[0], still.last().unwrap()), 0.0);
}

#[test]
fn around_a_wall_with_a_gap() {
    // Discs in a row along x = 0, from y = -2 to 1.4: the way is over the top.
    let wall = (0..18).map(|i| (0.0, -2.0 + 0.2 * i as f64, 0.15)).collect();
    let mut space = plane(wall, 0.01);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let path = rrt_connect(&mut space, &[-1.0, -1.0], &[1.0, -1.0], &PLANE, &mut rng).unwrap();
    let found = path_length(&path);
    let path = shortcut(
        &mut space,
        path,
        &shortcut::Settings {
            rounds: 300,
            resolution: 0.02,
        },
        &mut rng,
    );
    // A string around the last disc, at (0, 1.4), padded to 0.16: two tangents and an arc.
    let (far, r) = ((1.0f64 + 2.4 * 2.4).sqrt(), 0.16f64);
    let arc = 2.0 * (std::f64::consts::PI - (1.0f64 / 2.4).atan() - (r / far).acos());
    let best = 2.0 * (far * far - r * r).sqrt() + r * arc;
    assert!(
        path_length(&path) < 1.02 * best && found > path_length(&path),
        "{} {best}",
        path_length(&path)
    );
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let go = || {
        let mut space = plane(vec![(0.0, 0.0, 0.8), (1.0, 1.2, 0.4)], 0.01);
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let path = rrt_connect(&mut space, &[-1.5, -0.5], &[1.5, 0.5], &PLANE, &mut rng).unwrap();
        shortcut(
            &mut space,
            path,
            &shortcut::Settings {
                rounds: 30,
                resolution: 0.02,
            },
            &mut rng,
        )
    };
    assert_eq!(go(), go());
}

#[test]
fn a_closed_goal_is_out_of_samples() {
    let ring = (0..40)
        .map(|i| (0.5 * (i as f64 * 0.157).cos(), 0.5 * (i as f64 * 0.157).sin(), 0.1))
        .collect();
    let mut space = plane(ring, 0.01);
    let settings = rrt_connect::Settings {
        max_samples: 300,
        ..PLANE
    };
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let no = rrt_connect(&mut space, &[-1.5, 0.0], &[0.0, 0.0], &settings, &mut rng);
    assert_eq!(no, Err(NoPath::OutOfSamples { drawn: 300 }));
}

const TIMING: timing::Settings = timing::Settings {
    sample_period: 0.05,
    max_deviation: 0.05,
    resolution: 0.02,
};

#[test]
fn one_line_takes_the_time_of_the_book() {
    let mut space = plane(Vec::new(), 0.0);
    // Speed 1.5, acceleration 4, jerk 40. The double S takes 0.1 s to its full acceleration; the short line never cruises, and its
    // acceleration turns into braking at once, which the moving average makes slower than it has to be.
    let short = {
        let half: f64 = 0.05 + (0.05f64 * 0.05 + 0.1 / 4.0).sqrt();
        2.0 * half
    };
    for (far, book, at_most) in [(0.1, short, 1.25), (2.0, 2.0 / 1.5 + 1.5 / 4.0 + 0.1, 1.01)] {
        let timed = time(&mut space, &vec![vec![0.0, 0.0], vec![far, 0.0]], &TIMING);
        assert_within_limits(&space.dofs, &timed);
        // Samples show a little less jerk than there is, so that a motion may be a little faster.
        assert!(timed.duration() >= 0.99 * book, "{} {book}", timed.duration());
        assert!(timed.duration() < at_most * book, "{} {book}", timed.duration());
        let longest = timed.times.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!(longest < 0.0501);
    }
}

#[test]
fn rounding_a_corner_is_faster_than_stopping_and_stays_near() {
    let mut space = plane(Vec::new(), 0.0);
    let path = vec![vec![-1.0, 0.0], vec![0.0, 0.0], vec![0.0, 1.0]];
    let round = time(&mut space, &path, &TIMING);
    let stop = time(
        &mut space,
        &path,
        &timing::Settings {
            max_deviation: 0.0,
            ..TIMING
        },
    );
    assert_within_limits(&space.dofs, &round);
    assert_within_limits(&space.dofs, &stop);
    assert!(
        round.duration() < stop.duration() - 0.1,
        "{} {}",
        round.duration(),
        stop.duration()
    );
    assert!(stop.positions.contains(&vec![0.0, 0.0]));
    let nearest = round
        .positions
        .iter()
        .map(|q| length(q, &[0.0, 0.0]))
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.08 && nearest > 0.02, "{nearest}");
}

#[test]
fn a_corner_that_is_not_free_is_a_stop() {
    // The disc lies inside the corner and just off the lines.
    let mut space = plane(vec![(-0.1, 0.1, 0.095)], 0.0);
    let path = vec![vec![-1.0, 0.0], vec![0.0, 0.0], vec![0.0, 1.0]];
    let settings = timing::Settings {
        max_deviation: 0.5,
        resolution: 0.005,
        ..TIMING
    };
    let timed = time(&mut space, &path, &settings);
    assert_within_limits(&space.dofs, &timed);
    assert!(path_is_free(&mut space, &timed.positions, 0.001));
    let mut empty = plane(Vec::new(), 0.0);
    assert!(time(&mut empty, &path, &settings).duration() < timed.duration());
}

#[test]
fn points_on_a_curve_are_not_stopped_at() {
    // A quarter of a circle in 30 pieces, as inverse kinematics gives a straight line of the tool.
    let path: Path = (0..=30)
        .map(|i| (i as f64 / 30.0 * std::f64::consts::FRAC_PI_2).sin_cos())
        .map(|(s, c)| vec![c, s])
        .collect();
    let mut space = plane(Vec::new(), 0.0);
    let timed = time(
        &mut space,
        &path,
        &timing::Settings {
            max_deviation: 0.001,
            ..TIMING
        },
    );
    assert_within_limits(&space.dofs, &timed);
    // At 1.5 m/s along an axis and 4 m/s^2; a stop at each point would take 30 * 2 * sqrt(0.052 / 4) = 6.9 s.
    assert!(timed.duration() < 1.7, "{}", timed.duration());
}

#[test]
fn nothing_to_go_is_one_sample() {
    let mut space = plane(Vec::new(), 0.0);
    let q = vec![0.3, 0.4];
    let timed = time(&mut space, &vec![q.clone(), q.clone(), q.clone()], &TIMING);
    assert_eq!((timed.times, timed.positions), (vec![0.0], vec![q.clone()]));
    let timed = time(&mut space, &vec![q, vec![0.3, 0.4 + 1e-10]], &TIMING);
    assert_eq!(timed.positions.len(), 2);
    assert_within_limits(&space.dofs, &timed);
    assert_eq!(time(&mut space, &Vec::new(), &TIMING).times.len(), 0);
}

#[test]
fn limits_that_make_no_sense_give_finite_times() {
    let path = vec![vec![0.0, 0.0], vec![0.5, 0.1], vec![1.0, 0.0]];
    for limit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let dofs = vec![
            Dof {
                max_velocity: limit,
                max_acceleration: limit,
                max_jerk: limit,
                ..dof(-2.0, 2.0)
            };
            2
        ];
        let mut space = Plane {
            dofs,
            discs: Vec::new(),
            padding: 0.0,
        };
        let timed = time(
            &mut space,
            &path,
            &timing::Settings {
                sample_period: 1.0,
                ..TIMING
            },
        );
        assert!(timed.duration().is_finite() && timed.duration() > 0.0);
        assert!(timed.positions.iter().flatten().all(|v| v.is_finite()));
    }
}
