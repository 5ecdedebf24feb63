//! Hit or free in 10,000 configurations of two robots: coal's answers. `collisions.json`, written by `make_collisions.py`, names its version.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::Arc;

use serde_json::Value;
use sgap::geom::Pose;
use sgap::geom::Vec3;
use sgap::geom::checker::{Body, Checker, Item, Obstacle, Rig};
use sgap::geom::collide::{Solid, distance, penetration, touch};
use sgap::geom::cover::Form;
use sgap::geom::hull::Hull;
use sgap::geom::kinematics::Tree;
use sgap::geom::shape::Shape;

use super::kinematics::{numbers, pose, read_tree, text};

/// A robot on the spot among obstacles, with its configurations and their answers.
pub struct Robot {
    pub name: String,
    pub tree: Tree,
    pub bodies: Vec<Body>,
    pub obstacles: Vec<Obstacle>,
    /// Of bodies, then of a body and an obstacle (counted after the bodies).
    pub pairs: BTreeSet<(usize, usize)>,
    pub configurations: Vec<Vec<f64>>,
    pub hits: Vec<bool>,
}

fn form(v: &Value) -> Arc<Form> {
    let (kind, of) = v.as_object().unwrap().iter().next().unwrap();
    let shape = if kind == "planes" {
        let planes = of.as_array().unwrap().iter().flat_map(numbers);
        let numbers: Vec<f64> = std::iter::once(0.0).chain(planes).collect();
        Shape::Hull(Arc::new(Hull::from_numbers(&numbers).unwrap()))
    } else {
        let n = numbers(of);
        match kind.as_str() {
            "box" => Shape::Box {
                half: Vec3::new(n[0], n[1], n[2]),
            },
            "cylinder" => Shape::Cylinder {
                radius: n[0],
                half_length: n[1],
            },
            "sphere" => Shape::Sphere { radius: n[0] },
            "capsule" => Shape::Capsule {
                radius: n[0],
                half_length: n[1],
            },
            other => panic!("shape {other}"),
        }
    };
    Arc::new(Form::new(Solid::new(&shape)))
}

pub fn robots() -> Vec<Robot> {
    let json: Value = serde_json::from_str(include_str!("collisions.json")).unwrap();
    json["robots"].as_array().unwrap().iter().map(robot).collect()
}

fn robot(v: &Value) -> Robot {
    let tree = read_tree(&v["tree"]);
    let bodies: Vec<Body> = v["bodies"]
        .as_array()
        .unwrap()
        .iter()
        .map(|b| Body {
            link: tree.links.iter().position(|l| *l == text(&b["link"])).unwrap(),
            X_LS: pose(&b["X_LS"]),
            form: form(&b["shape"]),
        })
        .collect();
    let obstacles: Vec<Obstacle> = v["objects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|o| Obstacle {
            X_WS: pose(&o["X_WS"]),
            form: form(&o["shape"]),
        })
        .collect();
    let own = v["pairs"].as_array().unwrap().iter().map(|p| {
        let p = numbers(p);
        (p[0] as usize, p[1] as usize)
    });
    let moved = tree.links_moved_by(&(0..tree.n_dofs()).collect::<Vec<_>>());
    let others = (0..bodies.len())
        .filter(|i| moved.contains(&bodies[*i].link))
        .flat_map(|i| (0..obstacles.len()).map(move |j| (i, j)));
    let pairs = own.chain(others.map(|(i, j)| (i, bodies.len() + j))).collect();
    let mut state: u64 = text(&v["state"]).parse().unwrap();
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let hits: Vec<bool> = text(&v["hits"])
        .chars()
        .flat_map(|c| (0..4).map(move |k| c.to_digit(16).unwrap() >> k & 1 == 1))
        .collect();
    let mut draw = || {
        let finite = |v: f64| if v.is_finite() { v } else { v.signum() * PI };
        let mut of = |lower: f64, upper: f64| lower + random() * (upper - lower);
        tree.dofs.iter().map(|d| of(finite(d.lower), finite(d.upper))).collect()
    };
    let configurations = (0..hits.len()).map(|_| draw()).collect();
    Robot {
        name: text(&v["name"]),
        bodies,
        obstacles,
        pairs,
        configurations,
        hits,
        tree,
    }
}

impl Robot {
    /// A checker of the robot with all its joints, or with some and the others at `rest`.
    pub fn checker(&self, dofs: &[usize], rest: &[f64]) -> Checker {
        let rig = Arc::new(Rig::new(&self.tree, dofs, &[], self.bodies.clone()));
        let place = |item| match item {
            Item::Body(i) => i,
            Item::Obstacle(j) => self.bodies.len() + j,
        };
        let margin = |a, b| {
            let (a, b) = (place(a), place(b));
            self.pairs.contains(&(a.min(b), a.max(b))).then_some(0.0)
        };
        let X_WL = self.tree.link_poses(&Pose::identity(), rest);
        Checker::new(&rig, &X_WL, rest, &[], &self.obstacles, &margin)
    }

    /// Whether one of the pairs touches, each by the exact test; only those of bodies of `moves` are looked at.
    pub fn is_free_by_pairs(&self, X_WL: &[Pose], moves: &[bool]) -> bool {
        let placed: Vec<Pose> = self.bodies.iter().map(|b| X_WL[b.link] * b.X_LS).collect();
        self.pairs.iter().all(|&(a, b)| {
            let solid = self.bodies[a].form.solid();
            match self.obstacles.get(b.wrapping_sub(self.bodies.len())) {
                Some(o) => !moves[a] || !touch(solid, &placed[a], o.form.solid(), &o.X_WS),
                None => !(moves[a] || moves[b]) || !touch(solid, &placed[a], self.bodies[b].form.solid(), &placed[b]),
            }
        })
    }

    /// How far the nearest pairs are apart, or how deep the deepest is in [m]: what two libraries could disagree by.
    fn tie(&self, q: &[f64]) -> f64 {
        let X_WL = self.tree.link_poses(&Pose::identity(), q);
        let at = |i: usize| match self.bodies.get(i) {
            Some(b) => (b.form.solid(), X_WL[b.link] * b.X_LS),
            None => {
                let o = &self.obstacles[i - self.bodies.len()];
                (o.form.solid(), o.X_WS)
            }
        };
        let signed = self.pairs.iter().map(|&(a, b)| {
            let ((s, X), (t, Y)) = (at(a), at(b));
            distance(s, &X, t, &Y) - penetration(s, &X, t, &Y).unwrap_or(0.0)
        });
        signed.fold(f64::INFINITY, f64::min).abs()
    }
}

#[test]
fn hit_or_free_as_coal_says() {
    use sgap::geom::checker::LANES;
    for robot in robots() {
        assert_eq!(robot.hits.len(), 10_000);
        let dofs: Vec<usize> = (0..robot.tree.n_dofs()).collect();
        let mut checker = robot.checker(&dofs, &vec![0.0; dofs.len()]);
        let mut differ = Vec::new();
        for (some, hits) in robot.configurations.chunks(LANES).zip(robot.hits.chunks(LANES)) {
            let columns: Vec<[f64; LANES]> = dofs.iter().map(|d| std::array::from_fn(|k| some[k][*d])).collect();
            let free = checker.are_free(&columns);
            for ((q, free), hit) in some.iter().zip(free).zip(hits) {
                assert_eq!(checker.is_free(q), free);
                if free == *hit {
                    differ.push((*hit, robot.tie(q)));
                }
            }
        }
        assert!(differ.is_empty(), "{}: hit, and by how much: {differ:?}", robot.name);
    }
}

/// The same answers as every pair by the exact test.
#[test]
fn hit_or_free_as_every_pair() {
    for robot in robots() {
        let dofs: Vec<usize> = (0..robot.tree.n_dofs()).collect();
        let mut checker = robot.checker(&dofs, &vec![0.0; dofs.len()]);
        let moves = vec![true; robot.bodies.len()];
        for q in robot.configurations.iter().take(1000) {
            let X_WL = robot.tree.link_poses(&Pose::identity(), q);
            assert_eq!(checker.is_free(q), robot.is_free_by_pairs(&X_WL, &moves), "{q:?}");
        }
    }
}
