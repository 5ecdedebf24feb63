//! World files, model files and URDF: what loads, what is computed, and where each fault is shown.
//!
//! A new case is one file in `tests/suite/world/ok` or `bad`; a `.urdf` there is loaded as a robot's URDF. Snapshots lie beside their case.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "tests may unwrap")]

#[path = "world/lowest.rs"]
mod lowest;
#[path = "world/models.rs"]
mod models;
#[path = "world/random.rs"]
mod random;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use sgap::diag::{Problems, render};
use sgap::geom::kinematics::{Chain, Tree};
use sgap::geom::{Pose, Vec3, collide, ik, pose_xyz_rpy, shape::Shape};
use sgap::source::{Files, Sources};
use sgap::world::{self, EntityRef, World, contacts};

/// Files of the package, and some in memory that come first.
#[derive(Default)]
struct CaseFiles(BTreeMap<String, String>);

impl Files for CaseFiles {
    fn read(&self, path: &str) -> Result<String, String> {
        if let Some(text) = self.0.get(path) {
            return Ok(text.clone());
        }
        if Path::new(path).is_dir() {
            return Err("it is a folder".into());
        }
        let bytes = std::fs::read(path).map_err(|_| "no such file".to_string())?;
        String::from_utf8(bytes).map_err(|_| "not UTF-8 text".into())
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        std::fs::read(path).map_err(|_| "no such file".to_string())
    }
}

fn load(path: &str) -> (Option<World>, Problems, Sources) {
    load_with(path, &CaseFiles::default())
}

fn load_with(path: &str, files: &CaseFiles) -> (Option<World>, Problems, Sources) {
    let mut sources = Sources::default();
    let (world, problems) = world::load(path, &mut sources, files);
    assert_eq!(world.is_none(), problems.has_errors(), "{problems:?}");
    (world, problems, sources)
}

/// Loads a file that must have no problem at all.
fn world(path: &str) -> World {
    let (world, problems, sources) = load(path);
    assert!(problems.0.is_empty(), "{}", render::render(&problems, &sources, false));
    world.unwrap()
}

fn world_of(text: &str) -> World {
    let files = CaseFiles(BTreeMap::from([("w.toml".to_string(), text.to_string())]));
    let (world, problems, sources) = load_with("w.toml", &files);
    world.unwrap_or_else(|| panic!("{}", render::render(&problems, &sources, false)))
}

fn cases(folder: &str) -> Vec<String> {
    let mut paths: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml" || e == "urdf"))
        .map(|path| path.to_str().unwrap().to_string())
        .collect();
    paths.sort();
    assert!(!paths.is_empty());
    paths
}

/// Loads a case; a URDF as that of a robot whose world and model are in memory.
fn load_case(path: &str) -> (Option<World>, Problems, Sources) {
    let Some(name) = path.strip_suffix(".urdf") else {
        return load(path);
    };
    let (folder, stem) = name.rsplit_once('/').unwrap();
    let files = CaseFiles(BTreeMap::from([
        (
            format!("{folder}/world.toml"),
            "[robots.R]\nmodel = \"model.toml\"\n".to_string(),
        ),
        (format!("{folder}/model.toml"), format!("urdf = \"{stem}.urdf\"\n")),
    ]));
    load_with(&format!("{folder}/world.toml"), &files)
}

fn snapshot(path: &str, text: &str) {
    let path = Path::new(path);
    let settings = {
        let mut settings = insta::Settings::new();
        settings.set_snapshot_path(std::path::absolute(path.parent().unwrap()).unwrap());
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings
    };
    settings.bind(|| insta::assert_snapshot!(path.file_name().unwrap().to_str().unwrap(), text));
}

#[test]
fn bad_cases_are_refused_at_the_right_place() {
    for path in cases("tests/suite/world/bad") {
        let (_, problems, sources) = load_case(&path);
        assert!(problems.has_errors(), "{path} has no error");
        for label in problems.0.iter().filter_map(|p| p.primary.as_ref()) {
            assert!(sources.get(label.span.file).text.get(label.span.range()).is_some());
        }
        assert!(
            problems.0.iter().all(|p| p.primary.is_some()),
            "{path}: a problem without a place"
        );
        snapshot(&path, &render::render(&problems, &sources, false));
    }
}

#[test]
fn every_problem_has_a_case() {
    let mut met: BTreeSet<&str> = BTreeSet::new();
    for path in cases("tests/suite/world/bad") {
        met.extend(load_case(&path).1.0.iter().map(|p| p.code));
    }
    let mut written = BTreeSet::new();
    let mut folders = vec![std::path::PathBuf::from("src/world")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = std::fs::read_to_string(path).unwrap();
            let codes = text.split('"').filter(|s| {
                ["world::", "urdf::", "mesh::", "srdf::"]
                    .iter()
                    .any(|room| s.starts_with(room))
            });
            written.extend(codes.map(str::to_string));
        }
    }
    let unmet: Vec<&String> = written.iter().filter(|c| !met.contains(c.as_str())).collect();
    assert!(unmet.is_empty(), "no case in tests/suite/world/bad for {unmet:?}");
}

#[test]
fn good_cases_have_no_problem() {
    for path in cases("tests/suite/world/ok") {
        let world = world(&path);
        snapshot(&path, &outline(&world));
    }
}

/// What a world is, in a few lines.
fn outline(world: &World) -> String {
    let mut out = String::new();
    for (agent, state) in world.scene.agents.iter().zip(&world.start.agents) {
        let arms: Vec<&str> = agent.arms.iter().map(|a| a.name.as_str()).collect();
        out += &format!(
            "{:?} {} {:?} at {} arms {arms:?}\n",
            agent.kind,
            agent.id,
            agent.ty,
            pose(&state.X_WB)
        );
        let q: Vec<String> = agent
            .tree
            .dofs
            .iter()
            .zip(&state.q)
            .filter(|(_, v)| **v != 0.0)
            .map(|(d, v)| format!("{}={v}", d.name))
            .collect();
        out += &format!("  {}\n", q.join(" "));
    }
    for (object, state) in world.scene.objects.iter().zip(&world.start.objects) {
        let list = |names: Vec<&str>| names.join(", ");
        out += &format!(
            "{} {:?} at {} {:.3} kg\n",
            object.id,
            object.ty,
            pose(&state.X_WO),
            object.mass
        );
        out += &format!(
            "  supports: {}\n",
            list(object.supports.iter().map(|s| s.name.as_str()).collect())
        );
        out += &format!(
            "  stands: {}\n",
            list(object.stable.iter().map(|s| s.name.as_str()).collect())
        );
        out += &format!(
            "  grasps: {}\n",
            list(object.grasps.iter().map(|g| g.name.as_str()).collect())
        );
        for container in &object.containers {
            let (at, half) = (pose(&container.X_OC), container.half);
            out += &format!("  container {} at {at}, half {half:?}\n", container.name);
        }
    }
    for thing in &world.scene.virtuals {
        let shape = |shape: &Shape| match shape {
            Shape::Hull(hull) => format!("Hull of {} corners", hull.vertices.len()),
            other => format!("{other:?}"),
        };
        let parts = thing
            .parts
            .iter()
            .map(|p| shape(&p.shape))
            .collect::<Vec<_>>()
            .join(", ");
        let stable: Vec<&str> = thing.stable.iter().map(|s| s.name.as_str()).collect();
        out += &format!(
            "virtual {} {:?} [{parts}]\n  stands: {}\n",
            thing.id,
            thing.ty,
            stable.join(", ")
        );
    }
    let shared: Vec<_> = world.shared.iter().map(|(a, f, _)| (a, f)).collect();
    let values: Vec<_> = world
        .values
        .iter()
        .map(|v| (&v.entity, &v.attribute, &v.values))
        .collect();
    out + &format!("{:?}\n{shared:?}\n{values:?}\n", world.task.as_ref().map(|t| &t.0))
}

fn pose(X: &Pose) -> String {
    let (r, p, y) = X.rotation.euler_angles();
    let numbers = [X.translation.x, X.translation.y, X.translation.z, r, p, y];
    numbers
        .map(|n| format!("{:.4}", if n.abs() < 5e-5 { 0.0 } else { n }))
        .join(" ")
}

#[test]
fn the_shipped_worlds_load() {
    assert_eq!(world("worlds/virtual_place_a.toml").scene.virtuals.len(), 1);
    for path in ["worlds/three_objects.toml", "worlds/ramification.toml"] {
        let world = world(path);
        assert_eq!(world.scene.agents.len(), 2);
        assert_eq!(world.scene.objects.len(), 5);
        assert!(contacts(&world.scene, &world.start, 1e-6).is_empty());
        let (task, span) = world.task.unwrap();
        assert_eq!(&std::fs::read_to_string(path).unwrap()[span.range()], task);
    }
}

#[test]
fn unreadable_files_are_told() {
    let message = |path: &str| {
        let (_, problems, sources) = load(path);
        render::render_concise(&problems, &sources)
    };
    insta::assert_snapshot!(message("worlds/none.toml"), @"error[world::unreadable-file]: can't read the world file `worlds/none.toml`: no such file");
    insta::assert_snapshot!(message("worlds"), @"error[world::unreadable-file]: can't read the world file `worlds`: it is a folder");
}

/// Compares the link poses of a tree with those of a reference file, by joint and link name.
fn compare(file: &str, tree: &Tree) {
    let text = std::fs::read_to_string(Path::new("tests/world").join(file)).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let cases = reference["cases"].as_array().unwrap();
    assert!(!cases.is_empty());
    for case in cases {
        let mut q = vec![0.0; tree.dofs.len()];
        for (joint, value) in case["q"].as_object().unwrap() {
            q[tree.dofs.iter().position(|d| d.name == *joint).unwrap()] = value.as_f64().unwrap();
        }
        let X_BL = tree.link_poses(&Pose::identity(), &q);
        for (link, numbers) in case["links"].as_object().unwrap() {
            let n: Vec<f64> = numbers
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap())
                .collect();
            let wanted = Pose::from_parts(
                Vec3::new(n[0], n[1], n[2]).into(),
                nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(n[6], n[3], n[4], n[5])),
            );
            let found = X_BL[tree.links.iter().position(|l| l == link).unwrap()];
            let off = wanted.inv_mul(&found);
            assert!(off.translation.vector.norm() < 1e-9, "{file}: {link} is {off} off");
            assert!(off.rotation.angle() < 1e-7, "{file}: {link} is {off} off");
        }
    }
}

#[test]
fn forward_kinematics_agree_with_pinocchio() {
    let world = world("worlds/three_objects.toml");
    compare("pr2_fk.json", &world.scene.agents[0].tree);
    compare("human_fk.json", &world.scene.agents[1].tree);
    for (world_name, file) in [
        ("arm", "arm7_fk.json"),
        ("quadrotor", "quadrotor_fk.json"),
        ("humanoid", "humanoid_fk.json"),
    ] {
        compare(
            file,
            &self::world(&format!("worlds/{world_name}.toml")).scene.agents[0].tree,
        );
    }
}

#[test]
fn the_pr2_has_the_link_lengths_that_its_maker_publishes() {
    let world = world("worlds/three_objects.toml");
    compare("pr2_published.json", &world.scene.agents[0].tree);
}

#[test]
fn closing_a_gripper_keeps_its_fingers_symmetric_about_the_tool() {
    let world = world("worlds/three_objects.toml");
    let agent = &world.scene.agents[0];
    for arm in &agent.arms {
        let gripper = arm.gripper.as_ref().unwrap();
        for gap in [0.086, 0.06, 0.031, 0.0] {
            let mut q = world.start.agents[0].q.clone();
            for (dof, value) in gripper.dofs.iter().zip(gripper.at_gap(gap)) {
                q[*dof] = value;
            }
            let X_WL = agent.tree.link_poses(&Pose::identity(), &q);
            let X_TW = (X_WL[arm.tip_link] * arm.X_LT).inverse();
            // The inner face of a finger lies in its frame's xz plane.
            let fingers: Vec<f64> = arm.hand_links[1..]
                .iter()
                .map(|l| (X_TW * X_WL[*l]).translation.y)
                .collect();
            assert_eq!(fingers.len(), 2);
            assert!((fingers[0] + fingers[1]).abs() < 1e-12);
            assert!(((fingers[0] - fingers[1]).abs() - gap).abs() < 1e-12);
        }
    }
}

const SHAPES: &str = r#"
[objects.BOX]
box = [0.05, 0.12, 0.20]
xyz = [0, 0, 1]
[objects.CAN]
cylinder = { radius = 0.03, length = 0.16 }
xyz = [1, 0, 1]
[objects.PUCK]
cylinder = { radius = 0.035, length = 0.04 }
xyz = [2, 0, 1]
[objects.BALL]
sphere = { radius = 0.03 }
xyz = [3, 0, 1]
[objects.STICK]
capsule = { radius = 0.02, length = 0.2 }
xyz = [4, 0, 1]
[objects.L]
parts = [{ box = [0.2, 0.06, 0.06] }, { box = [0.06, 0.06, 0.2], xyz = [0.07, 0, 0.13] }]
xyz = [5, 0, 1]
"#;

/// A slab whose upper face is z = `top`.
fn floor(top: f64) -> (collide::Solid, Pose) {
    let slab = Shape::Box {
        half: Vec3::new(5.0, 5.0, 0.5),
    };
    (collide::Solid::new(&slab), Pose::translation(0.0, 0.0, top - 0.5))
}

#[test]
fn stable_orientations_stand_on_the_plane() {
    let world = world_of(SHAPES);
    let counts: Vec<usize> = world.scene.objects.iter().map(|o| o.stable.len()).collect();
    // An L of boxes can't stand with its foot's end up or down, where its middle is beside the bottom.
    assert_eq!(counts[..5], [6, 2, 2, 0, 0]);
    assert!((2..6).contains(&counts[5]), "{counts:?}");
    for object in &world.scene.objects {
        for stable in &object.stable {
            let lowest_hit = |top: f64| {
                let (slab, X_QF) = floor(top);
                object.parts.iter().any(|part| {
                    let solid = collide::Solid::new(&part.shape);
                    collide::touch(&solid, &(stable.X_QO * part.X_OS), &slab, &X_QF)
                })
            };
            assert!(lowest_hit(1e-5) && !lowest_hit(-1e-5), "{} {}", object.id, stable.name);
            let area: f64 = (0..stable.footprint.len())
                .map(|i| (stable.footprint[i], stable.footprint[(i + 1) % stable.footprint.len()]))
                .map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) / 2.0)
                .sum();
            assert!(
                area > 1e-4,
                "{} {}: not counter-clockwise, or no face",
                object.id,
                stable.name
            );
        }
    }
}

#[test]
fn grasps_close_on_the_object_and_keep_the_palm_out() {
    let world = world_of(SHAPES);
    let names: Vec<usize> = world.scene.objects.iter().map(|o| o.grasps.len()).collect();
    // The upright of the L covers one of the faces of its foot.
    assert_eq!(names, [4, 4 * 2 + 8 * 3, 4 * 2 + 8 + 8, 12, 4 * 2 + 8 * 3, 16 - 1]);
    for object in &world.scene.objects {
        for grasp in &object.grasps {
            assert!(grasp.width <= 0.08);
            let hits = |from: Vec3, direction: Vec3, length: f64| {
                let ray_from = grasp.X_OT * nalgebra::Point3::from(from);
                let ray_along = grasp.X_OT.rotation * direction;
                object
                    .parts
                    .iter()
                    .filter_map(|part| {
                        let solid = collide::Solid::new(&part.shape);
                        collide::ray(&solid, &part.X_OS, &ray_from.coords, &ray_along, length)
                    })
                    .fold(None, |best: Option<f64>, hit| Some(best.map_or(hit, |b| b.min(hit))))
            };
            // From each finger, opened by a centimetre, to the other: the object begins where the finger closes.
            for sign in [1.0, -1.0] {
                let start = Vec3::new(0.0, sign * (grasp.width / 2.0 + 0.01), 0.0);
                let hit = hits(start, Vec3::new(0.0, -sign, 0.0), 0.2).unwrap_or(f64::NAN);
                // Off the middle of a round shape, fingers meet it a little later.
                assert!((0.0099..0.015).contains(&hit), "{} {}: {hit}", object.id, grasp.name);
            }
            // The palm stays 0.03 m behind the tool at least (with a PR2's, 0.06 m before its palm).
            let behind = Vec3::new(-0.2, 0.0, 0.0);
            let hit = hits(behind, Vec3::x(), 0.3).unwrap_or(f64::NAN);
            assert!(
                hit >= 0.2 - 0.03 - 1e-9 || object.parts.len() > 1,
                "{} {}: {hit}",
                object.id,
                grasp.name
            );
        }
    }
}

#[test]
fn supports_are_the_free_upward_faces() {
    let world = world_of(
        r#"
        [objects.SHELF]
        movable = false
        xyz = [0, 0, 0]
        parts = [
            { box = [0.4, 1.0, 0.02], xyz = [0, 0, 0.3] },
            { box = [0.4, 1.0, 0.02], xyz = [0, 0, 0.8], rpy = [3.141592653589793, 0, 0] },
            { box = [0.4, 0.02, 0.79], xyz = [0, 0.49, 0.395] },
            { cylinder = { radius = 0.1, length = 0.2 }, xyz = [0, 0, 1.1] },
        ]
        "#,
    );
    let found: Vec<_> = world.scene.objects[0]
        .supports
        .iter()
        .map(|s| {
            let up = s.X_OF.rotation * Vec3::z();
            assert!(up.z > 0.999_999);
            (
                s.name.as_str(),
                (s.X_OF.translation.z * 1000.0).round(),
                s.half[0].min(s.half[1]),
            )
        })
        .collect();
    assert_eq!(found.len(), 3);
    assert_eq!((found[0].0, found[0].1), ("top", 1200.0));
    assert!((found[0].2 - 0.1 * std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12);
    assert_eq!((found[1].0, found[1].1), ("top 2", 810.0));
    assert_eq!((found[2].0, found[2].1), ("top 3", 310.0));
}

#[test]
fn an_object_on_a_support_stands_where_the_file_says() {
    let world = world_of(
        r#"
        [objects.TABLE]
        box = [1.0, 1.0, 0.7]
        movable = false
        xyz = [2, 1, 0.35]
        yaw = 1.5707963267948966
        [objects.BOOK]
        box = [0.04, 0.15, 0.20]
        on = "TABLE"
        at = [0.3, 0.0]
        stands = "+x"
        "#,
    );
    // The table is turned by a quarter: its x is the world's y. The book lies: half of its 0.04 m is above the table.
    let p_WO = world.start.objects[1].X_WO.translation.vector;
    assert!((p_WO - Vec3::new(2.0, 1.3, 0.72)).norm() < 1e-9, "{p_WO}");
    let up = world.start.objects[1].X_WO.rotation * Vec3::x();
    assert!((up - Vec3::z()).norm() < 1e-9);
}

#[test]
fn a_held_object_may_touch_its_holders_hand_alone() {
    let mut world = world("worlds/three_objects.toml");
    let cube = world.scene.objects.iter().position(|o| o.id == "RED_CUBE").unwrap();
    let agent = &world.scene.agents[0];
    let stands = &world.start.agents[0];
    let X_WL = agent.tree.link_poses(&stands.X_WB, &stands.q);
    let touching = |world: &World| {
        let all = contacts(&world.scene, &world.start, 1e-4);
        all.iter().filter(|c| c.b.entity == EntityRef::Object(cube)).count()
    };
    // In the palm of the right hand: free when held by it, a collision when held by the left one.
    let X_WT = X_WL[agent.arms[0].tip_link] * agent.arms[0].X_LT;
    let deep = Pose::translation(-0.05, 0.0, 0.0);
    world.start.objects[cube].X_WO = X_WT * deep;
    assert!(touching(&world) > 0);
    for (arm, free) in [(0, true), (1, false)] {
        world.start.objects[cube].held = Some(world::Held {
            agent: 0,
            arm,
            X_TO: deep,
        });
        assert_eq!(touching(&world) == 0, free);
    }
}

#[test]
fn the_same_file_gives_the_same_world() {
    let text = |_| format!("{:?}", world("worlds/three_objects.toml").scene);
    assert_eq!(text(0), text(1));
}

/// Says whether one of the agent's arms can bring its tool to `X_WT` (or to that point) without a collision.
fn reaches(world: &World, agent: usize, arm: usize, X_WT: &Pose, whole_pose: bool, grasped: Option<usize>) -> bool {
    let (body, stands) = (&world.scene.agents[agent], &world.start.agents[agent]);
    let arm = &body.arms[arm];
    let X_WL = body.tree.link_poses(&stands.X_WB, &stands.q);
    let X_KT = X_WL[arm.base_link].inv_mul(X_WT);
    let target = if whole_pose {
        ik::Target::Pose(X_KT)
    } else {
        ik::Target::Point(X_KT.translation.vector)
    };
    let chain = Chain::new(&body.tree, arm.base_link, arm.tip_link, &arm.X_LT).unwrap();
    let settings = ik::Settings {
        max_iterations: 60,
        restarts: 15,
        position_tolerance: 1e-3,
        rotation_tolerance: 1e-2,
    };
    let seed: Vec<f64> = arm.dofs.iter().map(|d| stands.q[*d]).collect();
    let mut state = world.start.clone();
    let hand: Vec<&String> = arm.hand_links.iter().map(|l| &body.tree.links[*l]).collect();
    let mut free = |q: &[f64]| {
        for (dof, value) in arm.dofs.iter().zip(q) {
            state.agents[agent].q[*dof] = *value;
        }
        contacts(&world.scene, &state, 1e-3)
            .iter()
            .all(|c| grasped.is_some_and(|o| c.b.entity == EntityRef::Object(o)) && hand.contains(&&c.a.part))
    };
    ik::solve(
        &chain,
        &target,
        &seed,
        &settings,
        &mut ChaCha8Rng::seed_from_u64(1),
        &mut free,
    )
    .is_ok()
}

/// What scenarios S1 and S2 rest on: the robot can take each object, the human can't reach any, and there is room for all three
/// where the robot's right arm and the human meet.
#[test]
fn robot_and_human_share_a_part_of_the_table_and_not_the_side_table() {
    for (path, least) in [("worlds/three_objects.toml", 15), ("worlds/ramification.toml", 8)] {
        let world = world(path);
        for (o, object) in world.scene.objects.iter().enumerate().filter(|(_, o)| o.movable) {
            let X_WO = world.start.objects[o].X_WO;
            let taken = |X_OT: &Pose| {
                let X_WT = X_WO * X_OT;
                let before = X_WT * Pose::translation(-0.1, 0.0, 0.0);
                reaches(&world, 0, 0, &X_WT, true, Some(o)) && reaches(&world, 0, 0, &before, true, None)
            };
            assert!(object.grasps.iter().any(|g| taken(&g.X_OT)), "{path}: {}", object.id);
            assert!(
                (0..2).all(|arm| !reaches(&world, 1, arm, &X_WO, false, Some(o))),
                "{path}: {}",
                object.id
            );
        }
        let support = &world.scene.objects[0].supports[0];
        let X_WF = world.start.objects[0].X_WO * support.X_OF;
        let cell = 0.08;
        let steps = |half: f64| {
            (-20..=20)
                .map(|i| f64::from(i) * cell)
                .filter(move |v| v.abs() <= half - cell / 2.0)
        };
        let mut shared = 0;
        for x in steps(support.half[0]) {
            for y in steps(support.half[1]) {
                // A tool that points down, and a palm a little above.
                let down = X_WF * pose_xyz_rpy([x, y, 0.04], [0.0, std::f64::consts::FRAC_PI_2, 0.0]);
                let palm = X_WF * Pose::translation(x, y, 0.07);
                let human = (0..2).any(|arm| reaches(&world, 1, arm, &palm, false, None));
                shared += usize::from(human && reaches(&world, 0, 0, &down, true, None));
            }
        }
        assert!(shared >= least, "{path}: {shared} cells of {cell} m");
    }
}

#[test]
fn the_example_of_the_manual_loads() {
    let manual = std::fs::read_to_string("docs/worlds.md").unwrap();
    let example = manual.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let files = CaseFiles(BTreeMap::from([(
        "worlds/manual.toml".to_string(),
        example.to_string(),
    )]));
    let (world, problems, sources) = load_with("worlds/manual.toml", &files);
    assert!(problems.0.is_empty(), "{}", render::render(&problems, &sources, false));
    assert_eq!(world.unwrap().scene.objects.len(), 2);
}

/// Files without one of their lines, or cut off: problems or a world, never a panic; and places that lie within the text.
#[test]
fn damaged_files_never_panic() {
    for (path, world) in [
        ("worlds/three_objects.toml", "worlds/three_objects.toml"),
        ("worlds/models/pr2.toml", "worlds/three_objects.toml"),
        ("worlds/models/human.urdf", "worlds/three_objects.toml"),
        (
            "tests/suite/world/ok/everything.toml",
            "tests/suite/world/ok/everything.toml",
        ),
    ] {
        let text = std::fs::read_to_string(path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let without = (0..lines.len()).map(|n| [&lines[..n], &lines[n + 1..]].concat().join("\n"));
        let cut = (0..text.len())
            .step_by(97)
            .filter_map(|n| Some(text.get(..n)?.to_string()));
        for damaged in without.chain(cut) {
            let files = CaseFiles(BTreeMap::from([(path.to_string(), damaged)]));
            let (_, problems, sources) = load_with(world, &files);
            for label in problems.0.iter().filter_map(|p| p.primary.as_ref()) {
                assert!(sources.get(label.span.file).text.get(label.span.range()).is_some());
            }
        }
    }
}

#[test]
fn deep_nesting_is_a_problem_and_not_a_crash() {
    let deep = |open: &str, n: usize| open.repeat(n);
    for (path, text) in [
        ("w.toml", format!("task = {}", deep("[", 100_000))),
        ("m.toml", format!("urdf = {}", deep("{a=", 100_000))),
        ("r.urdf", format!("<robot>{}", deep("<a>", 100_000))),
        (
            "r.urdf",
            format!("<robot>{}{}</robot>", deep("<a>", 100_000), deep("</a>", 100_000)),
        ),
    ] {
        let mut files = BTreeMap::from([
            ("w.toml".to_string(), "[robots.R]\nmodel = \"m.toml\"".to_string()),
            ("m.toml".to_string(), "urdf = \"r.urdf\"".to_string()),
        ]);
        files.insert(path.to_string(), text);
        assert!(load_with("w.toml", &CaseFiles(files)).1.has_errors());
    }
}

/// What the SRDFs of error pages speak of.
const ONE_JOINT: &str = r#"<robot name="r"><link name="base"/><link name="upper_arm"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper_arm"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;

/// The first example of an error page gives the problem that the page tells of, and the second does not.
#[test]
fn the_examples_of_the_error_pages_are_true() {
    let mut n_pages = 0;
    for entry in std::fs::read_dir("docs/errors").unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let is_ours = ["world-", "urdf-", "mesh-", "srdf-"]
            .iter()
            .any(|room| name.starts_with(room));
        if !is_ours || text.contains("```text") {
            continue;
        }
        n_pages += 1;
        let code = name.replacen('-', "::", 1);
        let blocks: Vec<&str> = text.split("```").skip(1).step_by(2).collect();
        assert_eq!(blocks.len(), 2, "{name}");
        for (block, wrong) in blocks.iter().zip([true, false]) {
            let (kind, example) = block.split_once('\n').unwrap();
            assert_eq!(kind.ends_with(",wrong"), wrong, "{name}: `{kind}`");
            let file = match kind.trim_end_matches(",wrong") {
                "xml" => "worlds/models/page.urdf",
                "srdf" => "worlds/models/page.srdf",
                "toml,model" => "worlds/models/page.toml",
                _ => "worlds/page.toml",
            };
            let files = CaseFiles(BTreeMap::from(
                [
                    ("worlds/models/page.toml", "urdf = \"page.urdf\"\n"),
                    ("worlds/models/page.urdf", ONE_JOINT),
                    ("worlds/page.toml", "[robots.R]\nmodel = \"models/page.toml\"\n"),
                    (file, example),
                ]
                .map(|(path, text)| (path.to_string(), text.to_string())),
            ));
            let (_, problems, sources) = load_with("worlds/page.toml", &files);
            let shown = render::render(&problems, &sources, false);
            let told = problems.0.iter().any(|p| p.code == code);
            assert_eq!(told, wrong, "{name}, {kind}:\n{example}\n{shown}");
            // A robot of an example may lack an arm; nothing else may be wrong with the right one.
            let more = problems.0.iter().find(|p| p.code != "world::no-arm");
            assert!(wrong || more.is_none(), "{name}:\n{shown}");
        }
    }
    assert!(n_pages > 40, "{n_pages}");
}
