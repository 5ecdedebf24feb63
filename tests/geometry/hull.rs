//! Hulls contain what they were made around, and exceed it by no more than they say.

use proptest::prelude::*;
use sgap::geom::Vec3;
use sgap::geom::hull::Hull;
use sgap::geom::mesh::Mesh;

fn points() -> impl Strategy<Value = Vec<Vec3>> {
    let point = |x: f64, y: f64, z: f64| [-x..x, -y..y, -z..z].prop_map(Vec3::from);
    let cloud = |x, y, z| proptest::collection::vec(point(x, y, z), 4..200);
    let on_a_ball = proptest::collection::vec(point(1.0, 1.0, 1.0), 50..500).prop_map(|all| {
        all.iter()
            .filter_map(|p| p.try_normalize(0.1))
            .map(|p| p * 0.2)
            .collect()
    });
    // A plate and a rod, turned.
    let turned = |all: Vec<Vec3>| {
        all.iter()
            .map(|p| nalgebra::Rotation3::from_euler_angles(0.3, 0.7, -1.0) * p)
            .collect()
    };
    prop_oneof![
        cloud(0.3, 0.2, 0.5),
        cloud(0.3, 0.2, 1e-7).prop_map(turned),
        cloud(0.3, 1e-4, 1e-4).prop_map(turned),
        cloud(20.0, 30.0, 10.0),
        on_a_ball,
    ]
}

/// Directions on a spiral over the sphere.
fn directions(n: u32) -> impl Iterator<Item = Vec3> {
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (sin, cos) = (f64::from(i) * 2.399963).sin_cos();
        Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
    })
}

fn reach(points: &[Vec3], d: &Vec3) -> f64 {
    points.iter().map(|p| p.dot(d)).fold(f64::NEG_INFINITY, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn contains_its_points_and_says_by_how_much_it_exceeds_them(points in points()) {
        let Some((hull, origin)) = Hull::around(&points) else {
            return Err(TestCaseError::reject("no body"));
        };
        let inside: Vec<Vec3> = points.iter().map(|p| p - origin).collect();
        for p in &inside {
            prop_assert!(hull.contains(p), "{p} is outside");
        }
        for d in directions(200).chain(hull.faces.iter().map(|f| f.normal)) {
            let beyond = hull.support(&d).dot(&d) - reach(&inside, &d);
            // Corners are rounded where planes are almost parallel.
            prop_assert!(beyond > -1e-7 && beyond < hull.excess + 1e-6, "{beyond}, said {}", hull.excess);
        }
        prop_assert!(hull.faces.len() <= 64);
        let (low, high) = hull.vertices.iter().fold((hull.vertices[0], hull.vertices[0]), |(l, h), v| (l.inf(v), h.sup(v)));
        let sides = high - low;
        prop_assert!(hull.volume() > 0.0 && hull.volume() <= sides.x * sides.y * sides.z * (1.0 + 1e-9));
        prop_assert!(hull.contains(&hull.centre()));
    }

    #[test]
    fn is_the_same_from_its_numbers(points in points()) {
        if let Some((hull, _)) = Hull::around(&points) {
            let again = Hull::from_numbers(&hull.as_numbers()).unwrap();
            prop_assert_eq!(again.as_numbers(), Hull::from_numbers(&again.as_numbers()).unwrap().as_numbers());
            for d in directions(50) {
                prop_assert!((again.support(&d).dot(&d) - hull.support(&d).dot(&d)).abs() < 1e-6);
            }
        }
    }

    /// A point that is in the smaller hull may be moved by as much without leaving the larger one.
    #[test]
    fn moving_the_faces_in_leaves_room(points in points(), by in 1e-3f64..0.1) {
        if let Some(smaller) = Hull::around(&points).and_then(|(hull, _)| Some((hull.moved_in(|_| by)?, hull))) {
            let (smaller, hull) = smaller;
            for v in &smaller.vertices {
                for d in directions(20) {
                    prop_assert!(hull.contains(&(v + d * (by - 1e-6))));
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    /// Boxes that overlap or not, some of them inside others: nothing of their surface is outside of all parts.
    #[test]
    fn parts_contain_the_mesh(boxes in proptest::collection::vec(([-0.2f64..0.2, -0.2f64..0.2, -0.2f64..0.2], [0.01f64..0.2, 0.01f64..0.2, 0.01f64..0.2]), 1..4)) {
        let mut mesh = Mesh::default();
        for (middle, half) in &boxes {
            add_box(&mut mesh, Vec3::from(*middle), Vec3::from(*half));
        }
        let parts = mesh.parts();
        let (hull, _) = mesh.hull().unwrap();
        prop_assert!(!parts.is_empty() && parts.len() <= 16);
        let volume: f64 = parts.iter().map(|(p, _)| p.volume()).sum();
        prop_assert!(volume < hull.volume() * (1.0 + 1e-3));
        for [a, b, c] in &mesh.triangles {
            let corners = [a, b, c].map(|i| mesh.points[*i as usize]);
            for (s, t) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.3, 0.3), (0.5, 0.5), (0.1, 0.6)] {
                let p = corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t;
                prop_assert!(parts.iter().any(|(part, origin)| part.contains(&(p - origin))), "{p} is in no part");
            }
        }
        for (middle, _) in &boxes {
            let middle = Vec3::from(*middle);
            prop_assert!(parts.iter().any(|(part, origin)| part.contains(&(middle - origin))), "hollow at {middle}");
        }
    }
}

fn add_box(mesh: &mut Mesh, middle: Vec3, half: Vec3) {
    let first = u32::try_from(mesh.points.len()).unwrap();
    for corner in 0..8 {
        let side = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
        mesh.points
            .push(middle + Vec3::new(side(1), side(2), side(4)).component_mul(&half));
    }
    for [a, b, c, d] in [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ] {
        mesh.triangles.push([first + a, first + b, first + c]);
        mesh.triangles.push([first + a, first + c, first + d]);
    }
}

#[test]
fn a_turned_box_is_a_box() {
    let mut mesh = Mesh::default();
    add_box(&mut mesh, Vec3::zeros(), Vec3::new(0.1, 0.2, 0.3));
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.3, 1.1);
    for p in &mut mesh.points {
        *p = turn * *p + Vec3::new(3.0, 2.0, 1.0);
    }
    let (hull, origin) = mesh.hull().unwrap();
    assert!((origin - Vec3::new(3.0, 2.0, 1.0)).norm() < 1e-9);
    assert!((hull.volume() - 0.048).abs() < 1e-3, "{}", hull.volume());
    assert!(hull.excess < 6e-4, "{}", hull.excess);
    assert!(hull.centre().norm() < 1e-3);
}

#[test]
fn an_l_comes_apart() {
    let mut mesh = Mesh::default();
    add_box(&mut mesh, Vec3::new(0.0, 0.0, 0.03), Vec3::new(0.1, 0.03, 0.03));
    add_box(&mut mesh, Vec3::new(0.07, 0.0, 0.13), Vec3::new(0.03, 0.03, 0.07));
    let volume: f64 = mesh.parts().iter().map(|(part, _)| part.volume()).sum();
    // The foot's inner faces and the upright's bottom lie in the same plane, which one of the planes tried comes near to.
    assert!((volume - 0.001224).abs() < 0.05 * 0.001224, "{volume}");
}

#[test]
fn points_without_extent_are_no_body() {
    let p = Vec3::new(1.0, 2.0, 3.0);
    assert!(Hull::around(&[]).is_none());
    assert!(Hull::around(&[p]).is_none());
    assert!(Hull::around(&[p, p, p, p + Vec3::repeat(1e-7)]).is_none());
    assert!(Hull::around(&[p, Vec3::new(f64::NAN, 0.0, 0.0)]).is_none());
    // A flat thing is as thick as its skin.
    let plate = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 0.0)];
    let (hull, _) = Hull::around(&plate).unwrap();
    assert!(hull.volume() > 0.0 && hull.volume() < 1e-5);
}
