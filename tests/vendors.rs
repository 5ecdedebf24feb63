//! Robots as their makers describe them: what loads, where their links are and that they stand on the floor, and a Pick with each of six.
//! And a human whose description has Y up and visual meshes alone.
//!
//! The descriptions are the package `example-robot-data` (PyPI, 131 MB), which is no part of this one: the folder that holds it is
//! named by ROS_PACKAGE_PATH. Without it these tests say that they were skipped. `.ci/run` installs it where it can.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]
#![expect(clippy::print_stderr, reason = "a test that is skipped says so")]

#[path = "world/lowest.rs"]
mod lowest;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use lowest::lowest;
use nalgebra::{Quaternion, UnitQuaternion};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;
use sgap::diag::{Problems, Severity, render};
use sgap::geom::kinematics::{Chain, Dof};
use sgap::geom::{Pose, Vec3, ik, shape::Shape};
use sgap::source::{Files, Sources};
use sgap::world::{self, World};

const PACKAGE: &str = "example-robot-data";
const ROBOTS: [&str; 6] = ["panda", "ur5", "pr2", "tiago", "tiago_pro", "talos"];

/// Returns the folder that holds the package, or says that a test is skipped.
fn packages() -> Option<PathBuf> {
    let value = std::env::var_os("ROS_PACKAGE_PATH").unwrap_or_default();
    let found = std::env::split_paths(&value).find(|folder| folder.join(PACKAGE).is_dir());
    if found.is_none() {
        eprintln!("skipped: no folder of ROS_PACKAGE_PATH holds {PACKAGE} (pip install example-robot-data)");
    }
    found
}

/// The disk, and some files in memory that come first.
struct Described {
    packages: PathBuf,
    texts: BTreeMap<String, String>,
}

impl Files for Described {
    fn read(&self, path: &str) -> Result<String, String> {
        if let Some(text) = self.texts.get(path) {
            return Ok(text.clone());
        }
        std::fs::read_to_string(path).map_err(|_| "no such file".to_string())
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        std::fs::read(path).map_err(|_| "no such file".to_string())
    }

    fn packages(&self) -> Vec<String> {
        vec![self.packages.to_str().unwrap().to_string()]
    }
}

fn load(path: &str, packages: &Path, texts: &[(&str, String)]) -> (Option<World>, Problems, Sources) {
    let files = Described {
        packages: packages.to_path_buf(),
        texts: texts.iter().map(|(p, t)| ((*p).to_string(), t.clone())).collect(),
    };
    let mut sources = Sources::default();
    let (world, problems) = world::load(path, &mut sources, &files);
    (world, problems, sources)
}

/// Returns the URDFs below a folder, sorted.
fn urdfs(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut open) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "urdf") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Returns links and joints of a URDF with which any joint that moves is an arm: its parent and its child.
fn some_arm(urdf: &str) -> Option<(String, String)> {
    let document = roxmltree::Document::parse(urdf).ok()?;
    let joints = document.root_element().children().filter(|n| n.has_tag_name("joint"));
    let moves = |n: &roxmltree::Node<'_, '_>| {
        ["revolute", "continuous", "prismatic"].contains(&n.attribute("type").unwrap_or_default())
            && !n.children().any(|c| c.has_tag_name("mimic"))
    };
    let joint = joints.into_iter().find(moves)?;
    let link = |tag| joint.children().find(|c| c.has_tag_name(tag))?.attribute("link");
    Some((link("parent")?.to_string(), link("child")?.to_string()))
}

/// Every URDF of the package loads, or is refused where something is wrong with it: `table.txt` says which.
#[test]
fn every_description_loads_or_is_refused_for_a_reason() {
    let Some(packages) = packages() else { return };
    let root = packages.join(PACKAGE).join("robots");
    let mut table = String::new();
    for path in urdfs(&root) {
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let arm = some_arm(&text).map_or(String::new(), |(base, tip)| {
            format!("[arms.some]\nbase_link = \"{base}\"\ntip_link = \"{tip}\"\n")
        });
        let (world, problems, sources) = load(
            "w.toml",
            &packages,
            &[
                ("w.toml", "[robots.R]\nmodel = \"m.toml\"\n".to_string()),
                ("m.toml", format!("urdf = \"package://{PACKAGE}/robots/{name}\"\n{arm}")),
            ],
        );
        assert_eq!(world.is_none(), problems.has_errors());
        for problem in &problems.0 {
            let span = problem.primary.as_ref().unwrap().span;
            assert!(sources.get(span.file).text.get(span.range()).is_some(), "{name}");
        }
        let mut codes: BTreeMap<(bool, &str), usize> = BTreeMap::new();
        for problem in &problems.0 {
            *codes
                .entry((problem.severity != Severity::Error, problem.code))
                .or_default() += 1;
        }
        let what = match &world {
            Some(world) => {
                let agent = &world.scene.agents[0];
                let hulls = agent
                    .bodies
                    .iter()
                    .filter(|b| matches!(b.shape, Shape::Hull(_)))
                    .count();
                let (links, dofs, shapes) = (agent.tree.links.len(), agent.tree.dofs.len(), agent.bodies.len());
                format!("{links} links, {dofs} joints, {shapes} shapes of which {hulls} hulls")
            }
            // Of the description nothing is wrong: its zero is no posture to start in, or it has nothing to reach with.
            None if problems
                .0
                .iter()
                .all(|p| p.severity != Severity::Error || p.code.starts_with("world::")) =>
            {
                "read".to_string()
            }
            None => "refused".to_string(),
        };
        let said: Vec<String> = codes.iter().map(|((_, code), n)| format!("{n} {code}")).collect();
        table += format!("{name:60} {what:55} {}", said.join(", ")).trim_end();
        table.push('\n');
    }
    insta::with_settings!({ snapshot_path => "vendors", prepend_module_to_snapshot => false, omit_expression => true }, {
        insta::assert_snapshot!("table", table);
    });
}

#[test]
fn links_are_where_pinocchio_puts_them() {
    let Some(packages) = packages() else { return };
    // Pinocchio refuses Talos: it has joints that mimic fixed ones.
    for robot in ROBOTS.into_iter().filter(|r| *r != "talos") {
        let (world, problems, sources) = load(&format!("tests/vendors/{robot}_pick.toml"), &packages, &[]);
        let world = world.unwrap_or_else(|| panic!("{}", render::render(&problems, &sources, false)));
        let tree = &world.scene.agents[0].tree;
        let text = std::fs::read_to_string(format!("tests/vendors/{robot}_fk.json")).unwrap();
        let reference: Value = serde_json::from_str(&text).unwrap();
        let mut compared = 0;
        for case in reference["cases"].as_array().unwrap() {
            let mut q = vec![0.0; tree.dofs.len()];
            for (joint, value) in case["q"].as_object().unwrap() {
                q[tree.dofs.iter().position(|d| d.name == *joint).unwrap()] = value.as_f64().unwrap();
            }
            let X_BL = tree.link_poses(&Pose::identity(), &q);
            for (link, numbers) in case["links"].as_object().unwrap() {
                let numbers = numbers.as_array().unwrap();
                let n: Vec<f64> = numbers.iter().map(|v| v.as_f64().unwrap()).collect();
                let turn = UnitQuaternion::from_quaternion(Quaternion::new(n[6], n[3], n[4], n[5]));
                let wanted = Pose::from_parts(Vec3::new(n[0], n[1], n[2]).into(), turn);
                let found = X_BL[tree.links.iter().position(|l| l == link).unwrap()];
                let off = wanted.inv_mul(&found);
                assert!(off.translation.vector.norm() < 1e-9, "{robot}: {link} is {off} off");
                // Half the angle's sine: it tells small angles, which the cosine does not.
                assert!(off.rotation.imag().norm() < 1e-9, "{robot}: {link} is {off} off");
                compared += 1;
            }
        }
        assert!(compared >= 3 * tree.links.len() / 2, "{robot}: {compared}");
    }
}

#[test]
fn they_stand_on_the_floor() {
    let Some(packages) = packages() else { return };
    for robot in ROBOTS {
        let (world, problems, sources) = load(&format!("tests/vendors/{robot}_pick.toml"), &packages, &[]);
        let world = world.unwrap_or_else(|| panic!("{}", render::render(&problems, &sources, false)));
        let lowest = lowest(&world, 0);
        assert!(lowest.abs() < 0.02, "{robot} stands at {lowest}");
    }
}

#[test]
fn the_human_of_the_package_stands_sees_and_reaches() {
    let Some(packages) = packages() else { return };
    let path = "tests/vendors/human_sees.toml";
    let (world, problems, sources) = load(path, &packages, &[]);
    let world = world.unwrap_or_else(|| panic!("{}", render::render(&problems, &sources, false)));
    let human = &world.scene.agents[0];
    assert_eq!(human.tree.dofs.len(), 36);
    assert!(human.bodies.iter().all(|b| matches!(b.shape, Shape::Hull(_))));
    let lowest = lowest(&world, 0);
    assert!(lowest.abs() < 0.005, "stands at {lowest}");
    let facts = sgap(&packages, &["facts", path]);
    let said = String::from_utf8_lossy(&facts.stdout).into_owned();
    for fact in ["isReachable(CUP, H)", "isVisible(CUP, H)"] {
        assert!(said.contains(fact), "{fact}:\n{said}");
    }
}

/// How many joints of its arm are held while the others are solved for in closed form. TIAGo Pro's description has the errors of
/// calibration in its axes: none of them meet or are parallel.
const HELD: [(&str, Option<usize>); 5] = [
    ("panda", Some(1)),
    ("pr2", Some(1)),
    ("ur5", Some(0)),
    ("tiago", Some(1)),
    ("tiago_pro", None),
];

#[test]
fn their_arms_are_solved() {
    let Some(packages) = packages() else { return };
    let settings = ik::Settings {
        max_iterations: 60,
        restarts: 60,
        position_tolerance: 1e-5,
        rotation_tolerance: 1e-4,
    };
    for (robot, held) in HELD {
        let (world, problems, sources) = load(&format!("tests/vendors/{robot}_pick.toml"), &packages, &[]);
        let world = world.unwrap_or_else(|| panic!("{}", render::render(&problems, &sources, false)));
        let agent = &world.scene.agents[0];
        for arm in &agent.arms {
            let chain = Chain::new(&agent.tree, arm.base_link, arm.tip_link, &arm.X_LT).unwrap();
            let form = chain.closed_form();
            assert_eq!(form.map(|f| f.held().len()), held, "{robot}, {}", arm.name);
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut draw = || -> Vec<f64> {
                let one = |d: &Dof| rng.random_range(d.lower.max(-3.1)..d.upper.min(3.1));
                chain.dofs().iter().map(one).collect()
            };
            let poses: Vec<(Vec<f64>, Vec<f64>)> = (0..500).map(|_| (draw(), draw())).collect();
            let mut rng = ChaCha8Rng::seed_from_u64(2);
            for (q, seed) in poses {
                let X_KT = chain.tool_pose(&q);
                let again = form.map_or_else(Vec::new, |form| form.solve(&chain, &X_KT, &q));
                if let Some(first) = again.first() {
                    assert!(
                        first.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-6),
                        "{robot}: {q:?}"
                    );
                }
                assert_eq!(again.is_empty(), form.is_none(), "{robot}: {q:?}");
                for s in &again {
                    let off = X_KT.inv_mul(&chain.tool_pose(s));
                    assert!(off.translation.vector.norm() < 1e-9 && off.rotation.imag().norm() < 1e-9);
                }
                let found = ik::solve(&chain, &ik::Target::Pose(X_KT), &seed, &settings, &mut rng, &mut |_| {
                    true
                });
                let off =
                    X_KT.inv_mul(&chain.tool_pose(&found.unwrap_or_else(|no| panic!("{robot}: {no:?} at {q:?}"))));
                assert!(off.translation.vector.norm() < 1e-4 && off.rotation.angle() < 1e-3);
            }
        }
    }
}

fn sgap(packages: &Path, arguments: &[&str]) -> std::process::Output {
    let cache = tempfile::tempdir().unwrap();
    Command::cargo_bin("sgap")
        .unwrap()
        .args(arguments)
        .env("ROS_PACKAGE_PATH", packages)
        .env("SGAP_CACHE", cache.path())
        .output()
        .unwrap()
}

/// The plans are valid.
#[test]
fn each_of_them_takes_a_cup() {
    let Some(packages) = packages() else { return };
    for robot in ROBOTS {
        let world = format!("tests/vendors/{robot}_pick.toml");
        let plan = sgap(&packages, &["plan", "tests/vendors/pick.hatp", &world, "--json"]);
        assert!(
            plan.status.success(),
            "{robot}: {}",
            String::from_utf8_lossy(&plan.stderr)
        );
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plan.json");
        std::fs::write(&file, &plan.stdout).unwrap();
        let judged = sgap(
            &packages,
            &["validate", "tests/vendors/pick.hatp", &world, file.to_str().unwrap()],
        );
        let said = String::from_utf8_lossy(&judged.stdout).into_owned() + &String::from_utf8_lossy(&judged.stderr);
        assert!(judged.status.success(), "{robot}: {said}");
    }
}
