//! The closed forms and the rounded cores against parry's own shapes and queries.

use std::sync::Arc;

use nalgebra::UnitQuaternion;
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, Cylinder, Shape as ParryShape};
use proptest::prelude::*;
use sgap::geom::collide::{Solid, distance, penetration, ray, touch};
use sgap::geom::hull::Hull;
use sgap::geom::shape::Shape;
use sgap::geom::{Pose, Vec3};

pub fn shapes() -> impl Strategy<Value = Shape> {
    let size = 0.02f64..0.5;
    prop_oneof![
        (size.clone(), size.clone(), size.clone()).prop_map(|(x, y, z)| Shape::Box {
            half: Vec3::new(x, y, z)
        }),
        (size.clone(), size.clone()).prop_map(|(radius, half_length)| Shape::Cylinder { radius, half_length }),
        size.clone().prop_map(|radius| Shape::Sphere { radius }),
        (size.clone(), size).prop_map(|(radius, half_length)| Shape::Capsule { radius, half_length }),
        hulls().prop_map(|hull| Shape::Hull(Arc::new(hull))),
    ]
}

/// Hulls around a dozen points or so.
fn hulls() -> impl Strategy<Value = Hull> {
    let point = [-0.4f64..0.4, -0.3f64..0.3, -0.5f64..0.5].prop_map(Vec3::from);
    proptest::collection::vec(point, 5..30).prop_filter_map("no body", |points| Some(Hull::around(&points)?.0))
}

/// Poses within `far` of the origin; some of them turned by right angles, where edges and faces are parallel.
pub fn poses(far: f64) -> impl Strategy<Value = Pose> {
    let turn = prop_oneof![
        3 => (-3.0f64..3.0, -1.5f64..1.5, -3.0f64..3.0),
        1 => (0i32..4, 0i32..4, 0i32..4).prop_map(|(a, b, c)| {
            let right = std::f64::consts::FRAC_PI_2;
            (a as f64 * right, b as f64 * right, c as f64 * right)
        }),
    ];
    ([-far..far, -far..far, -far..far], turn)
        .prop_map(|(p, (r, q, y))| Pose::from_parts(Vec3::from(p).into(), UnitQuaternion::from_euler_angles(r, q, y)))
}

/// Parry's own shape, and how its frame lies in ours (parry's cylinders and capsules lie along y).
fn parry(shape: &Shape, X: &Pose) -> (Box<dyn ParryShape>, ParryPose) {
    let upright = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
    let (s, r): (Box<dyn ParryShape>, _) = match *shape {
        Shape::Box { half } => (Box::new(Cuboid::new(Vector::new(half.x, half.y, half.z))), X.rotation),
        Shape::Sphere { radius } => (Box::new(Ball::new(radius)), X.rotation),
        Shape::Cylinder { radius, half_length } => (Box::new(Cylinder::new(half_length, radius)), X.rotation * upright),
        Shape::Capsule { radius, half_length } => (Box::new(Capsule::new_y(half_length, radius)), X.rotation * upright),
        Shape::Hull(ref hull) => {
            let corners: Vec<Vector> = hull.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
            (
                Box::new(ConvexPolyhedron::from_convex_hull(&corners).unwrap()),
                X.rotation,
            )
        }
    };
    let (p, q) = (X.translation.vector, r.coords);
    (
        s,
        ParryPose::from_parts(Vector::new(p.x, p.y, p.z), Rotation::from_xyzw(q.x, q.y, q.z, q.w)),
    )
}

/// Parry's answers: intersect, and signed distance where they are near (`None` when apart by more than 10 m).
fn brute_force(a: &Shape, X_WA: &Pose, b: &Shape, X_WB: &Pose) -> (bool, f64) {
    let ((s, X), (t, Y)) = (parry(a, X_WA), parry(b, X_WB));
    let meet = query::intersection_test(&X, &*s, &Y, &*t).unwrap().intersecting;
    (meet, query::distance(&X, &*s, &Y, &*t).unwrap().distance)
}

/// Closer than this to a bare contact, two ways of computing may differ.
const TIE: f64 = 1e-6;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn agrees_with_parry(a in shapes(), b in shapes(), X_WA in poses(0.6), X_WB in poses(0.6)) {
        let (s, t) = (Solid::new(&a), Solid::new(&b));
        let (meet, apart) = brute_force(&a, &X_WA, &b, &X_WB);
        let d = distance(&s, &X_WA, &t, &X_WB);
        // Parry's search ends early now and then, with a distance between two points that are not quite the nearest.
        prop_assert!(d < apart + 1e-5 && d > apart - 1e-3, "distance {d}, parry {apart}");
        let depth = penetration(&s, &X_WA, &t, &X_WB);
        if d > TIE || depth.is_some_and(|p| p > TIE) {
            prop_assert_eq!(touch(&s, &X_WA, &t, &X_WB), meet);
            prop_assert_eq!(meet, d == 0.0);
            prop_assert_eq!(meet, depth.is_some());
        }
    }

    #[test]
    fn symmetric_and_the_same_everywhere(a in shapes(), b in shapes(), X_WA in poses(0.6), X_WB in poses(0.6), X_VW in poses(5.0), m in 0.0f64..0.1) {
        let (s, t) = (Solid::new(&a), Solid::padded(&b, m));
        let d = distance(&s, &X_WA, &t, &X_WB);
        prop_assert!((d - distance(&t, &X_WB, &s, &X_WA)).abs() < TIE);
        prop_assert!((d - distance(&s, &(X_VW * X_WA), &t, &(X_VW * X_WB))).abs() < TIE);
        let depth = penetration(&s, &X_WA, &t, &X_WB).unwrap_or(0.0);
        prop_assert!((depth - penetration(&t, &X_WB, &s, &X_WA).unwrap_or(0.0)).abs() < 1e-3 * (1.0 + depth));
        if d > TIE || depth > TIE {
            prop_assert_eq!(touch(&s, &X_WA, &t, &X_WB), touch(&t, &(X_VW * X_WB), &s, &(X_VW * X_WA)));
            prop_assert_eq!(touch(&s, &X_WA, &t, &X_WB), d == 0.0);
        }
    }

    #[test]
    fn padding_adds_its_margin(a in shapes(), b in shapes(), X_WA in poses(0.8), X_WB in poses(0.8), m in 0.0f64..0.2) {
        let (s, t, padded) = (Solid::new(&a), Solid::new(&b), Solid::padded(&a, m));
        prop_assert!((padded.radius() - s.radius() - m).abs() < 1e-12);
        let d = distance(&s, &X_WA, &t, &X_WB);
        prop_assert!((distance(&padded, &X_WA, &t, &X_WB) - (d - m).max(0.0)).abs() < TIE);
        if (d - m).abs() > TIE {
            prop_assert_eq!(touch(&padded, &X_WA, &t, &X_WB), d < m || touch(&s, &X_WA, &t, &X_WB));
        }
    }

    #[test]
    fn shrinking_undoes_contact(a in shapes(), b in shapes(), X_WA in poses(0.4), X_WB in poses(0.4), m in 0.0f64..0.1) {
        let (s, t, less) = (Solid::new(&a), Solid::new(&b), Solid::padded(&a, -m));
        prop_assert!(less.radius() <= s.radius() + 1e-12);
        prop_assert!(distance(&less, &X_WA, &t, &X_WB) >= distance(&s, &X_WA, &t, &X_WB) - TIE);
    }

    /// Moving B away by the depth in the right direction parts them; a lattice of directions finds none that needs much less.
    #[test]
    fn depth_is_the_least_way_out(a in shapes(), b in shapes(), X_WA in poses(0.3), X_WB in poses(0.3)) {
        let (s, t) = (Solid::new(&a), Solid::new(&b));
        if let Some(depth) = penetration(&s, &X_WA, &t, &X_WB) {
            let n = 60;
            for i in 0..n {
                // Spiral over the sphere.
                let z = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
                let (sin, cos) = (i as f64 * 2.399963).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let way = Vec3::new(r * cos, r * sin, z) * (depth * 0.98 - TIE).max(0.0);
                let moved = Pose::from_parts((X_WB.translation.vector + way).into(), X_WB.rotation);
                prop_assert!(touch(&s, &X_WA, &t, &moved), "parted by less than {depth}");
            }
        }
    }

    #[test]
    fn rays_agree_with_parry(a in shapes(), X_WS in poses(0.5), p in [-1.5f64..1.5, -1.5f64..1.5, -1.5f64..1.5], X in poses(0.3)) {
        let p_WR = Vec3::from(p);
        let direction = (X.translation.vector - p_WR).normalize();
        let (s, Y) = parry(&a, &X_WS);
        let parry_ray = query::Ray::new(Vector::new(p[0], p[1], p[2]), Vector::new(direction.x, direction.y, direction.z));
        let expected = s.cast_ray(&Y, &parry_ray, 2.0, true);
        let found = ray(&Solid::new(&a), &X_WS, &p_WR, &direction, 2.0);
        match (expected, found) {
            (Some(x), Some(y)) => prop_assert!((x - y).abs() < 1e-4, "{x} {y}"),
            (None, None) => {}
            _ => {
                // A ray that grazes: the shape made a little smaller or larger must give the other answer.
                let other = ray(&Solid::padded(&a, if found.is_some() { -1e-4 } else { 1e-4 }), &X_WS, &p_WR, &direction, 2.0);
                prop_assert!(other.is_some() != found.is_some(), "parry {expected:?}, here {found:?}");
            }
        }
    }
}

#[test]
fn a_box_on_a_table_sinks_by_what_it_sinks() {
    let table = Solid::new(&Shape::Box {
        half: Vec3::new(0.5, 0.5, 0.4),
    });
    let can = Solid::new(&Shape::Cylinder {
        radius: 0.03,
        half_length: 0.06,
    });
    let X = |z: f64| Pose::translation(0.1, -0.2, z);
    let I = Pose::identity();
    assert!((penetration(&table, &I, &can, &X(0.45)).unwrap() - 0.01).abs() < 1e-6);
    assert_eq!(penetration(&table, &I, &can, &X(0.47)), None);
    assert!((distance(&table, &I, &can, &X(0.47)) - 0.01).abs() < 1e-9);
    assert!(!touch(&table, &I, &can, &X(0.461)));
    assert!(touch(&table, &I, &can, &X(0.459)));
}

#[test]
fn what_is_not_a_number_touches() {
    let s = Solid::new(&Shape::Sphere { radius: 0.1 });
    let t = Solid::new(&Shape::Cylinder {
        radius: 0.1,
        half_length: 0.1,
    });
    let X = Pose::translation(f64::NAN, 0.0, 0.0);
    assert!(touch(&s, &X, &t, &Pose::identity()));
    assert_eq!(distance(&s, &X, &t, &Pose::identity()), 0.0);
    assert_eq!(ray(&t, &X, &Vec3::zeros(), &Vec3::x(), 5.0), Some(0.0));
    assert_eq!(ray(&s, &X, &Vec3::zeros(), &Vec3::x(), 5.0), Some(0.0));
}

/// Found among three million pairs: GJK stalls 3 m apart in this order, and is right in the other.
#[test]
fn a_stalled_gjk_is_noticed() {
    let a = Solid::padded(
        &Shape::Cylinder {
            radius: 0.2,
            half_length: 0.5158055429114515,
        },
        -0.01,
    );
    let b = Solid::new(&Shape::Cylinder {
        radius: 0.15000000000000002,
        half_length: 10.0,
    });
    let pose = |q: [f64; 4], p: [f64; 3]| {
        let q = nalgebra::Quaternion::new(q[3], q[0], q[1], q[2]);
        Pose::from_parts(Vec3::from(p).into(), UnitQuaternion::new_unchecked(q))
    };
    let r = std::f64::consts::FRAC_1_SQRT_2;
    let X = pose(
        [-r, 4.329780281177467e-17, -r.next_down(), -4.329780281177466e-17],
        [0.9418021282933452, 0.8183494599094949, 1e-6],
    );
    let Y = pose(
        [
            0.206614835153672,
            -0.6418546613390861,
            0.09480904173374485,
            0.732355206998105,
        ],
        [0.5, 0.25, 0.45],
    );
    let (d, e) = (distance(&a, &X, &b, &Y), distance(&b, &Y, &a, &X));
    assert!((d - e).abs() < 1e-6 && d < 0.03, "{d} {e}");
}
