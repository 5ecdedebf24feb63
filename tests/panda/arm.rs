//! The maker's Panda and the problems, and the arm's joint space among a problem's obstacles.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use sgap::geom::checker::{Body, Checker, Item, Obstacle, Rig};
use sgap::geom::collide::{Solid, touch};
use sgap::geom::cover::Form;
use sgap::geom::kinematics::{Dof, Tree};
use sgap::geom::motion::rrt_connect::{self, NoPath};
use sgap::geom::motion::{Path, Space, edge_is_free, shortcut};
use sgap::geom::shape::Shape;
use sgap::geom::{Pose, Vec3};
use sgap::source::{Files, Sources};

const PACKAGE: &str = "example-robot-data";

/// One problem: from `start` to `goal` among `obstacles`, which stand in the frame of the robot's base.
pub struct Problem {
    pub name: String,
    pub set: String,
    pub start: Vec<f64>,
    pub goal: Vec<f64>,
    pub obstacles: Vec<(Shape, Pose)>,
}

/// Returns the problems, set by set.
pub fn problems() -> Vec<Problem> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/panda/problems.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    let sets = document["problems"].as_object().unwrap();
    let of_set = |(set, problems): (&String, &Value)| {
        let one = |p: &Value| Problem {
            name: format!("{set} {}", p["index"]),
            set: set.clone(),
            start: numbers(&p["start"]),
            goal: numbers(&p["goals"][0]),
            obstacles: obstacles(p),
        };
        problems.as_array().unwrap().iter().map(one).collect::<Vec<_>>()
    };
    sets.iter().flat_map(of_set).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn obstacles(problem: &Value) -> Vec<(Shape, Pose)> {
    let mut all = Vec::new();
    for (kind, things) in problem.as_object().unwrap() {
        let shape = |t: &Value| match kind.as_str() {
            "boxes" => Some(Shape::Box {
                half: Vec3::from_row_slice(&numbers(&t["half_extents"])),
            }),
            "cylinders" => Some(Shape::Cylinder {
                radius: t["radius"].as_f64().unwrap(),
                half_length: t["length"].as_f64().unwrap() / 2.0,
            }),
            "spheres" => Some(Shape::Sphere {
                radius: t["radius"].as_f64().unwrap(),
            }),
            _ => None,
        };
        for thing in things.as_array().into_iter().flatten() {
            let Some(shape) = shape(thing) else { continue };
            let p = Vec3::from_row_slice(&numbers(&thing["position"]));
            let turn = thing.get("quat_xyzw").map_or(UnitQuaternion::identity(), |q| {
                let q = numbers(q);
                UnitQuaternion::from_quaternion(Quaternion::new(q[3], q[0], q[1], q[2]))
            });
            all.push((shape, Pose::from_parts(p.into(), turn)));
        }
    }
    all
}

/// The robot, its base at the world's origin.
pub struct Panda {
    pub tree: Tree,
    /// All of it.
    pub q: Vec<f64>,
    /// The arm's degrees of freedom, and their indices into `q`.
    pub dofs: Vec<Dof>,
    pub indices: Vec<usize>,
    /// Link, its shape, and the pose of the shape in the link's frame.
    pub bodies: Vec<(usize, Shape, Pose)>,
    /// Indices of the bodies that may not touch each other.
    pub pairs: Vec<(usize, usize)>,
    pub rig: Arc<Rig>,
}

struct Disk {
    packages: PathBuf,
}

impl Files for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            "panda_world.toml" => Ok("[robots.R]\nmodel = \"tests/vendors/panda.toml\"\nposture = \"rest\"\n".into()),
            _ => {
                let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
                Ok(if path.ends_with("panda.urdf") {
                    with_fingers_of_mesh(&text)
                } else {
                    text
                })
            }
        }
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        std::fs::read(path).map_err(|e| e.to_string())
    }

    fn packages(&self) -> Vec<String> {
        vec![self.packages.to_str().unwrap().to_string()]
    }
}

/// Returns the description with the maker's mesh for each finger, as the problems' authors had it: newer descriptions have boxes in
/// its place.
fn with_fingers_of_mesh(urdf: &str) -> String {
    let mut text = urdf.to_string();
    for (link, yaw) in [("panda_leftfinger", "0"), ("panda_rightfinger", "3.141592653589793")] {
        let start = text.find(&format!("<link name=\"{link}\">")).unwrap();
        let end = start + text[start..].find("</link>").unwrap();
        let mesh = format!("package://{PACKAGE}/robots/panda_description/meshes/collision/finger.stl");
        let shape =
            format!("<origin rpy=\"0 0 {yaw}\" xyz=\"0 0 0\"/><geometry><mesh filename=\"{mesh}\"/></geometry>");
        text.replace_range(
            start..end,
            &format!("<link name=\"{link}\"><collision>{shape}</collision>"),
        );
    }
    text
}

/// Returns the robot; `None`, and a line that says so, where its package is not installed.
pub fn panda() -> Option<Panda> {
    let value = std::env::var_os("ROS_PACKAGE_PATH").unwrap_or_default();
    let Some(packages) = std::env::split_paths(&value).find(|folder| folder.join(PACKAGE).is_dir()) else {
        eprintln!("skipped: no folder of ROS_PACKAGE_PATH holds {PACKAGE} (pip install example-robot-data)");
        return None;
    };
    let mut sources = Sources::default();
    let (world, problems) = sgap::world::load("panda_world.toml", &mut sources, &Disk { packages });
    let world = world.unwrap_or_else(|| panic!("{}", sgap::diag::render::render(&problems, &sources, false)));
    let agent = &world.scene.agents[0];
    let indices = agent.arms[0].dofs.clone();
    let bodies: Vec<(usize, Shape, Pose)> = agent.bodies.iter().map(|b| (b.link, b.shape.clone(), b.X_LS)).collect();
    let mut pairs = Vec::new();
    for (i, (a, ..)) in bodies.iter().enumerate() {
        for (j, (b, ..)) in bodies.iter().enumerate().skip(i + 1) {
            if a != b && !agent.may_touch.contains(&(*a.min(b), *a.max(b))) {
                pairs.push((i, j));
            }
        }
    }
    let body = |(link, shape, X_LS): &(usize, Shape, Pose)| Body {
        link: *link,
        X_LS: *X_LS,
        form: Arc::new(Form::new(Solid::new(shape))),
    };
    let rig = Rig::new(&agent.tree, &indices, &[], bodies.iter().map(body).collect());
    // As far out as in the model that the problems were made with, beyond what the real fingers can do.
    let mut q = world.start.agents[0].q.clone();
    for (dof, v) in agent.tree.dofs.iter().zip(&mut q) {
        if dof.name.contains("finger") {
            *v = 0.065;
        }
    }
    Some(Panda {
        rig: Arc::new(rig),
        tree: agent.tree.clone(),
        q,
        dofs: indices.iter().map(|d| agent.tree.dofs[*d].clone()).collect(),
        indices,
        bodies,
        pairs,
    })
}

/// Every pair with the exact shapes, one configuration at a time: what judges a path.
pub struct Naive<'a> {
    panda: &'a Panda,
    solids: Vec<Solid>,
    obstacles: Vec<(Solid, Pose)>,
    q: Vec<f64>,
    X_WL: Vec<Pose>,
    pub checks: u64,
}

impl<'a> Naive<'a> {
    pub fn new(panda: &'a Panda, problem: &Problem) -> Naive<'a> {
        let solid = |(shape, X): &(Shape, Pose)| (Solid::new(shape), *X);
        Naive {
            panda,
            solids: panda.bodies.iter().map(|(_, shape, _)| Solid::new(shape)).collect(),
            obstacles: problem.obstacles.iter().map(solid).collect(),
            q: panda.q.clone(),
            X_WL: Vec::new(),
            checks: 0,
        }
    }
}

impl Space for Naive<'_> {
    fn dofs(&self) -> &[Dof] {
        &self.panda.dofs
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        self.checks += 1;
        for (index, v) in self.panda.indices.iter().zip(q) {
            self.q[*index] = *v;
        }
        self.panda
            .tree
            .link_poses_into(&Pose::identity(), &self.q, &mut self.X_WL);
        let X_WS: Vec<Pose> = self
            .panda
            .bodies
            .iter()
            .map(|(link, _, X_LS)| self.X_WL[*link] * X_LS)
            .collect();
        // The first body is the base, which nothing moves.
        let hits_obstacle = |i: usize| {
            let body = &self.solids[i];
            self.obstacles.iter().any(|(o, X_WO)| touch(body, &X_WS[i], o, X_WO))
        };
        let hits_itself = |(i, j): &(usize, usize)| touch(&self.solids[*i], &X_WS[*i], &self.solids[*j], &X_WS[*j]);
        !(1..X_WS.len()).any(hits_obstacle) && !self.panda.pairs.iter().any(hits_itself)
    }
}

/// The space that the planner is given.
pub struct Fast<'a> {
    panda: &'a Panda,
    checker: Checker,
}

impl<'a> Fast<'a> {
    pub fn new(panda: &'a Panda, problem: &Problem) -> Fast<'a> {
        let obstacle = |(shape, X_WS): &(Shape, Pose)| Obstacle {
            X_WS: *X_WS,
            form: Arc::new(Form::new(Solid::new(shape))),
        };
        let obstacles: Vec<Obstacle> = problem.obstacles.iter().map(obstacle).collect();
        let margin = |a: Item, b: Item| {
            let apart = match (a, b) {
                (Item::Body(i), Item::Body(j)) => panda.pairs.contains(&(i.min(j), i.max(j))),
                (Item::Body(i), Item::Obstacle(_)) | (Item::Obstacle(_), Item::Body(i)) => i > 0,
                (Item::Obstacle(_), Item::Obstacle(_)) => false,
            };
            apart.then_some(0.0)
        };
        let X_WL = panda.tree.link_poses(&Pose::identity(), &panda.q);
        Fast {
            panda,
            checker: Checker::new(&panda.rig, &X_WL, &panda.q, &[], &obstacles, &margin),
        }
    }

    pub fn checks(&self) -> u64 {
        self.checker.n_checks()
    }
}

impl Space for Fast<'_> {
    fn dofs(&self) -> &[Dof] {
        &self.panda.dofs
    }

    fn is_free(&mut self, q: &[f64]) -> bool {
        self.checker.is_free(q)
    }

    fn all_free(&mut self, qs: &[f64]) -> bool {
        self.checker.all_free(qs)
    }
}

/// Spacing of the checks while a path is searched; what is found is checked again at the other one [rad].
pub const SEARCH: f64 = 1.0 / 32.0;
pub const RESOLUTION: f64 = 1.0 / 64.0;

/// Searches a path that is free at a spacing.
pub fn search(space: &mut dyn Space, problem: &Problem, resolution: f64, rng: &mut ChaCha8Rng) -> Result<Path, NoPath> {
    let settings = rrt_connect::Settings {
        step: 1.0,
        resolution,
        max_samples: 100_000,
    };
    rrt_connect::rrt_connect(space, &problem.start, &problem.goal, &settings, rng)
}

/// Makes a path shorter; says whether it is free at [`RESOLUTION`].
pub fn simplify(space: &mut dyn Space, path: Path, resolution: f64, rng: &mut ChaCha8Rng) -> (Path, bool) {
    let settings = shortcut::Settings {
        rounds: 100,
        resolution,
    };
    let path = shortcut::shortcut(space, path, &settings, rng);
    let is_free = path.windows(2).all(|e| edge_is_free(space, &e[0], &e[1], RESOLUTION));
    (path, is_free)
}
