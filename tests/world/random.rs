//! A thousand random worlds, sound ones and damaged ones: each loads or is refused at a place, and nothing panics.
//!
//! A case draws a world file, a model file, a URDF, an SRDF and meshes of several formats, and damages some of them: a value of the
//! wrong kind or size, a key misspelt or left out, a word of another place, bytes turned over, cut off or doubled. The case number is the seed.

use std::collections::{BTreeMap, BTreeSet};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sgap::diag::render;
use sgap::source::{Files, Sources};
use sgap::world::{self, World, contacts};

const CASES: u64 = 1000;

/// Files in memory, and those of the package.
struct Memory(BTreeMap<String, Vec<u8>>);

impl Files for Memory {
    fn read(&self, path: &str) -> Result<String, String> {
        String::from_utf8(self.read_bytes(path)?).map_err(|_| "not UTF-8 text".into())
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        match self.0.get(path) {
            Some(bytes) => Ok(bytes.clone()),
            None => std::fs::read(path).map_err(|_| "no such file".into()),
        }
    }
}

/// A stream of choices.
struct Draw {
    rng: ChaCha8Rng,
    /// How often something is damaged, of a hundred.
    damage: u32,
}

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.rng.random_range(0..n)
    }

    fn percent(&mut self, n: u32) -> bool {
        self.rng.random_range(0..100) < n
    }

    fn is_damaged(&mut self) -> bool {
        let damage = self.damage;
        self.percent(damage)
    }

    fn of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len())]
    }

    /// Returns a number within the limits, or what can't be right.
    fn number(&mut self, low: f64, high: f64) -> String {
        if self.is_damaged() {
            let odd = [
                "0",
                "-1",
                "600",
                "1e300",
                "-1e300",
                "1e-300",
                "nan",
                "inf",
                "-inf",
                "\"1\"",
                "[1]",
                "true",
                "{}",
                "1e999",
                "90",
                "9223372036854775807",
            ];
            return self.of(&odd).to_string();
        }
        format!("{:.3}", self.rng.random_range(low..high))
    }

    fn numbers(&mut self, n: usize, low: f64, high: f64) -> String {
        let n = if self.is_damaged() { self.below(5) } else { n };
        let all: Vec<String> = (0..n).map(|_| self.number(low, high)).collect();
        format!("[{}]", all.join(", "))
    }

    /// Returns a key, or a wrong one.
    fn key(&mut self, key: &str) -> String {
        if !self.is_damaged() {
            return key.to_string();
        }
        match self.below(3) {
            0 => format!("{key}s"),
            1 => key.chars().rev().collect(),
            _ => self
                .of(&["on", "xyz", "mesh", "base", "type", "size", "joints"])
                .to_string(),
        }
    }

    /// Returns a line `key = value`; now and then none, or none at all for what need not be there.
    fn line(&mut self, key: &str, value: String) -> String {
        if self.is_damaged() && self.percent(30) {
            return String::new();
        }
        format!("{} = {value}\n", self.key(key))
    }

    fn name(&mut self, all: &[&str]) -> String {
        if self.is_damaged() {
            return self
                .of(&["", "nobody", "TABEL", "A B", "ünïcode", "base_link"])
                .to_string();
        }
        self.of(all).to_string()
    }

    fn shape(&mut self) -> String {
        match self.below(6) {
            0 | 1 => format!("box = {}", self.numbers(3, 0.02, 0.5)),
            2 => format!(
                "cylinder = {{ radius = {}, length = {} }}",
                self.number(0.01, 0.1),
                self.number(0.02, 0.3)
            ),
            3 => format!("sphere = {{ radius = {} }}", self.number(0.01, 0.1)),
            4 => format!(
                "capsule = {{ radius = {}, length = {} }}",
                self.number(0.01, 0.1),
                self.number(0.02, 0.3)
            ),
            _ => {
                let file = self.name(&["a.stl", "b.stl", "c.obj", "d.dae"]);
                let scale = self.number(0.5, 1.5);
                let parts = if self.percent(8) { "true" } else { "false" };
                format!("mesh = {{ file = \"{file}\", scale = {scale}, parts = {parts} }}")
            }
        }
    }

    /// Something to stand on, and in.
    fn table(&mut self) -> String {
        let mut out = "[objects.TABLE]\n".to_string();
        let sides = self.numbers(3, 1.99, 2.01);
        out += &self.line("box", sides);
        out += &self.line("xyz", "[0, 0, -1]".to_string());
        out += &self.line("movable", "false".to_string());
        let hollow = "[{ name = \"hollow\", xyz = [0.5, 0, 0.25], size = [0.8, 1.8, 0.5] }]".to_string();
        out += &self.line("containers", hollow);
        out
    }

    fn object(&mut self, id: &str, ids: &[&str], n: usize) -> String {
        let mut out = format!("[objects.{id}]\n");
        // Where others are not.
        let (at, far) = (n as f64 * 0.3 - 0.9, n as f64 * 3.0);
        let ground = self.below(10);
        if ground < 5 && !self.is_damaged() {
            // It stands, and a hand holds it.
            let (side, height) = (self.number(0.02, 0.06), self.number(0.05, 0.15));
            out += &self.line("box", format!("[{side}, {side}, {height}]"));
        } else if self.percent(20) {
            let n = 1 + self.below(3);
            let parts: Vec<String> = (0..n)
                .map(|_| format!("{{ {}, xyz = {} }}", self.shape(), self.numbers(3, -0.3, 0.3)))
                .collect();
            let value = format!("[{}]", parts.join(", "));
            out += &self.line("parts", value);
        } else {
            out += &self.shape();
            out.push('\n');
        }
        match ground {
            0..=2 => {
                let below = if self.percent(80) {
                    "TABLE".to_string()
                } else {
                    self.name(ids)
                };
                let below = if below == "TABLE" || self.is_damaged() {
                    below
                } else {
                    "TABLE".to_string()
                };
                out += &self.line("on", format!("\"{below}\""));
                let y = self.number(at, at + 0.1);
                out += &self.line("at", format!("[-0.5, {y}]"));
            }
            3 => {
                let around = self.name(&["TABLE"]);
                out += &self.line("in", format!("\"{around}\""));
                let y = self.number(at, at + 0.1);
                out += &self.line("at", format!("[0.1, {y}]"));
            }
            4 => {
                let agent = self.name(&["R"]);
                out += &self.line("in_hand_of", format!("\"{agent}\""));
                if self.percent(30) {
                    let arm = self.name(&["right"]);
                    out += &self.line("arm", format!("\"{arm}\""));
                }
            }
            _ => {
                let (x, z) = (self.number(far, far + 0.5), self.number(1.0, 2.0));
                out += &self.line("xyz", format!("[{x}, 6, {z}]"));
                let rpy = self.numbers(3, -3.0, 3.0);
                if self.percent(40) {
                    out += &self.line("rpy", rpy);
                }
            }
        }
        let movable = if ground < 5 {
            "true"
        } else {
            self.of(&["true", "false"])
        };
        out += &self.line("movable", movable.to_string());
        if self.percent(20) {
            let color = self.name(&["red", "blue", "wood"]);
            out += &self.line("color", format!("\"{color}\""));
        }
        if self.percent(20) {
            let mass = self.number(0.01, 5.0);
            out += &self.line("mass", mass);
        }
        if self.percent(15) {
            let (name, xyz, size) = (
                self.name(&["top", "side"]),
                self.numbers(3, -0.2, 0.2),
                self.numbers(2, 0.05, 0.5),
            );
            out += &self.line(
                "supports",
                format!("[{{ name = \"{name}\", xyz = {xyz}, size = {size} }}]"),
            );
        }
        if self.percent(15) {
            let (name, size) = (self.name(&["hollow"]), self.numbers(3, 0.1, 0.5));
            out += &self.line("containers", format!("[{{ name = \"{name}\", size = {size} }}]"));
        }
        if self.percent(15) {
            let (name, rpy, width) = (
                self.name(&["above"]),
                self.numbers(3, -3.0, 3.0),
                self.number(0.01, 0.07),
            );
            out += &self.line(
                "grasps",
                format!("[{{ name = \"{name}\", rpy = {rpy}, width = {width} }}]"),
            );
        }
        if ground < 5 && self.percent(20) {
            let (name, turn) = (self.name(&["lying"]), self.number(-3.0, 3.0));
            out += &self.line("stable", format!("[{{ name = \"{name}\", rpy = [0, 0, {turn}] }}]"));
        }
        out
    }

    fn world(&mut self) -> String {
        let mut out = String::new();
        if self.percent(50) {
            let task = self.name(&["Do(R, CUBE)", "Do(R); Go(H) > 1"]);
            out += &self.line("task", format!("\"{task}\""));
        }
        let ours = self.percent(3);
        let model = self.name(&["model.toml"]);
        out += &format!("[robots.R]\nmodel = \"{model}\"\n");
        let (x, y, yaw) = (
            self.number(-19.0, -9.0),
            self.number(-9.0, -5.0),
            self.number(-3.0, 3.0),
        );
        out += &self.line("base", format!("{{ x = {x}, y = {y}, yaw = {yaw} }}"));
        if self.percent(30) {
            let posture = self.name(&["rest", "up"]);
            out += &self.line("posture", format!("\"{posture}\""));
        }
        if self.percent(30) {
            let (joint, value) = (self.name(&["j1", "j2", "j3"]), self.number(-0.5, 0.5));
            out += &self.line("joints", format!("{{ \"{joint}\" = {value} }}"));
        }
        if self.percent(30) {
            let of = if ours { "worlds/models/human.toml" } else { "model.toml" };
            out += &format!("[humans.H]\nmodel = \"{of}\"\nbase = {{ x = 20 }}\n");
            for key in ["mobility", "availability"] {
                let value = self.number(0.0, 1.0);
                out += &self.line(key, value);
            }
            let side = self.name(&["right"]);
            out += &self.line("handedness", format!("\"{side}\""));
            let sits = self.of(&["true", "false"]).to_string();
            out += &self.line("sitting", sits);
        }
        if ours {
            out += "[robots.PR2]\nmodel = \"worlds/models/pr2.toml\"\nbase = { y = -20 }\n";
        }
        out += &self.table();
        let ids = ["CUBE", "BOX", "CUP", "R", "LAST"];
        let n = 1 + self.below(ids.len() - 1);
        for (i, id) in ids[..n].iter().enumerate() {
            // An id of a robot is one too many.
            if *id != "R" || self.is_damaged() {
                out += &self.object(id, &ids, i);
            }
        }
        if self.percent(20) {
            let sides = self.numbers(3, 0.1, 0.5);
            out += &format!("[virtual.V]\nbox = {sides}\n");
        }
        if self.percent(20) {
            let fact = self.name(&["isOn", "isReachable"]);
            out += &format!("[facts]\n\"Object.on\" = \"{fact}\"\n");
        }
        if self.percent(20) {
            let value = self.number(0.0, 1.0);
            let key = self.name(&["CUBE.painted", "R.type"]);
            out += &format!("[state]\n\"{key}\" = {value}\n");
        }
        out
    }

    fn model(&mut self) -> String {
        let mut out = self.line("urdf", "\"robot.urdf\"".to_string());
        let base = self.name(&["fixed", "planar", "flying"]);
        out += &self.line("base", format!("\"{base}\""));
        let acceleration = self.number(0.1, 5.0);
        out += &self.line("acceleration", acceleration);
        if self.percent(30) {
            let (a, b) = (self.name(&["l1", "l2"]), self.name(&["l3", "root"]));
            out += &self.line("may_touch", format!("[[\"{a}\", \"{b}\"]]"));
        }
        for (table, low, high) in [
            ("speeds", 0.1, 3.0),
            ("accelerations", 0.1, 3.0),
            ("postures.rest", -0.4, 0.4),
            ("postures.up", -0.4, 0.4),
            ("postures.sitting", -0.4, 0.4),
        ] {
            if table.starts_with("postures") || self.percent(40) {
                let (joint, value) = (self.name(&["j1", "j2"]), self.number(low, high));
                out += &format!("[{table}]\n\"{joint}\" = {value}\n");
            }
        }
        let n = if self.is_damaged() {
            self.below(4)
        } else {
            1 + self.below(2)
        };
        for arm in ["right", "left", "third"].iter().take(n) {
            out += &format!("[arms.{arm}]\n");
            if self.percent(80) {
                let (base, tip) = (self.name(&["root"]), self.name(&["l1", "l2"]));
                out += &self.line("base_link", format!("\"{base}\""));
                out += &self.line("tip_link", format!("\"{tip}\""));
            } else {
                let group = self.name(&["arm"]);
                out += &self.line("group", format!("\"{group}\""));
            }
            if self.percent(20) {
                out += &self.line("end_effector", "\"hand\"".to_string());
            }
            let xyz = self.numbers(3, -0.2, 0.2);
            out += &self.line("tool", format!("{{ xyz = {xyz} }}"));
            if self.percent(60) {
                let (joint, open, closed) = (self.name(&["j1", "j2"]), self.number(0.0, 0.4), self.number(-0.4, 0.0));
                let gap = self.number(0.02, 0.1);
                out += &format!(
                    "[arms.{arm}.gripper]\njoints = {{ \"{joint}\" = {{ open = {open}, closed = {closed} }} }}\n"
                );
                out += &self.line("gap_open", gap);
            }
        }
        if self.percent(40) {
            let (link, angle, range) = (self.name(&["l1", "root"]), self.number(0.5, 2.0), self.number(1.0, 9.0));
            out += &format!("[camera]\nlink = \"{link}\"\nhorizontal = {angle}\nvertical = {angle}\n");
            out += &self.line("range", range);
        }
        out
    }

    /// Returns numbers for an attribute of XML.
    fn xml_numbers(&mut self, n: usize, low: f64, high: f64) -> String {
        let list = self.numbers(n, low, high);
        list.chars().filter(|c| !"[],\"{}".contains(*c)).collect()
    }

    fn urdf(&mut self) -> String {
        let mut out = "<?xml version=\"1.0\"?>\n<robot name=\"r\">\n".to_string();
        let n = 4 + self.below(4);
        for l in 0..n {
            let name = if l == 0 { "root".to_string() } else { format!("l{l}") };
            out += &format!("  <link name=\"{name}\">\n");
            for _ in 0..self.below(3) {
                let (size, xyz) = (self.xml_numbers(3, 0.02, 0.06), self.xml_numbers(3, -0.03, 0.03));
                let (radius, length) = (self.xml_numbers(1, 0.01, 0.03), self.xml_numbers(1, 0.02, 0.06));
                let geometry = match self.below(6) {
                    0 => format!("<box size=\"{size}\"/>"),
                    1 => format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"),
                    2 => format!("<sphere radius=\"{radius}\"/>"),
                    3 => format!("<capsule radius=\"{radius}\" length=\"{length}\"/>"),
                    4 => format!(
                        "<mesh filename=\"{}\" scale=\"0.2 0.2 0.2\"/>",
                        self.name(&["a.stl", "c.obj", "d.dae"])
                    ),
                    _ => format!("<{} size=\"{size}\"/>", self.key("box")),
                };
                let tag = self.of(&["collision", "visual"]);
                out += &format!("    <{tag}><origin xyz=\"{xyz}\"/><geometry>{geometry}</geometry></{tag}>\n");
            }
            out += "  </link>\n";
            if l == 0 {
                continue;
            }
            let parent = if l == 1 {
                "root".to_string()
            } else {
                format!("l{}", 1 + self.below(l - 1))
            };
            let parent = if self.is_damaged() {
                self.name(&["l1", "l2", "l3"])
            } else {
                parent
            };
            let kind = if self.is_damaged() {
                self.of(&["spherical", "floating", "planar", "hinge", ""])
            } else {
                self.of(&["revolute", "revolute", "continuous", "prismatic", "fixed"])
            };
            // The first two joints move, so that most models have an arm.
            let kind = if l < 3 && kind == "fixed" { "revolute" } else { kind };
            let (xyz, axis) = (self.xml_numbers(3, 0.1, 0.4), self.xml_numbers(3, -1.0, 1.0));
            let (low, high, speed) = (
                self.xml_numbers(1, -2.0, -0.5),
                self.xml_numbers(1, 0.5, 2.0),
                self.xml_numbers(1, 0.5, 2.0),
            );
            let mimic = if l > 2 && kind != "fixed" && self.percent(20) {
                format!(
                    "<mimic joint=\"j{}\" multiplier=\"{}\"/>",
                    1 + self.below(2),
                    self.xml_numbers(1, -1.0, 1.0)
                )
            } else {
                String::new()
            };
            out += &format!(
                "  <joint name=\"j{l}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"l{l}\"/><origin xyz=\"{xyz}\" rpy=\"{xyz}\"/>\
                 <axis xyz=\"{axis}\"/><limit lower=\"{low}\" upper=\"{high}\" effort=\"1\" velocity=\"{speed}\"/>{mimic}</joint>\n"
            );
        }
        out + "</robot>\n"
    }

    fn srdf(&mut self) -> String {
        let mut out = "<robot name=\"r\">\n".to_string();
        let (a, b) = (self.name(&["l1", "l2"]), self.name(&["l1", "root"]));
        out += &format!("<disable_collisions link1=\"{a}\" link2=\"{b}\"/>\n");
        let sub = self.name(&["arm", "fingers"]);
        out += "<group name=\"arm\"><joint name=\"j1\"/><joint name=\"j2\"/></group>\n<group name=\"fingers\"><link name=\"l2\"/></group>\n";
        out += &format!("<group name=\"both\"><group name=\"{sub}\"/><group name=\"both\"/></group>\n");
        out += &format!("<end_effector name=\"hand\" parent_link=\"{a}\" group=\"{sub}\"/>\n");
        let (joint, value) = (self.name(&["j1", "j2"]), self.xml_numbers(1, -0.4, 0.4));
        out += &format!(
            "<group_state name=\"up\" group=\"arm\"><joint name=\"{joint}\" value=\"{value}\"/></group_state>\n"
        );
        out + "</robot>\n"
    }

    /// Corners of a random box, some of them moved.
    fn corners(&mut self) -> Vec<[f32; 3]> {
        let half: [f32; 3] = std::array::from_fn(|_| self.rng.random_range(0.01..0.2));
        (0..8)
            .map(|i| {
                std::array::from_fn(
                    |k| if i >> k & 1 == 0 { -half[k] } else { half[k] } + self.rng.random_range(-0.005..0.005),
                )
            })
            .collect()
    }

    fn stl(&mut self, is_binary: bool) -> Vec<u8> {
        let c = self.corners();
        let triangles: Vec<[[f32; 3]; 3]> = TRIANGLES.iter().map(|t| t.map(|i| c[i])).collect();
        if is_binary {
            let mut bytes = vec![b' '; 80];
            bytes.extend((triangles.len() as u32).to_le_bytes());
            for triangle in triangles {
                bytes.extend([0; 12]);
                bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
                bytes.extend([0; 2]);
            }
            return bytes;
        }
        let mut out = "solid s\n".to_string();
        for t in triangles {
            out += "facet normal 0 0 1\nouter loop\n";
            for [x, y, z] in t {
                out += &format!("vertex {x} {y} {z}\n");
            }
            out += "endloop\nendfacet\n";
        }
        (out + "endsolid s\n").into_bytes()
    }

    fn obj(&mut self) -> Vec<u8> {
        let mut out = String::new();
        for [x, y, z] in self.corners() {
            out += &format!("v {x} {y} {z}\n");
        }
        for t in TRIANGLES {
            out += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
        }
        out.into_bytes()
    }

    /// Turns over, cuts off, doubles or swaps some bytes.
    fn damaged(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for _ in 0..1 + self.below(3) {
            if bytes.is_empty() {
                break;
            }
            let (a, b) = (self.below(bytes.len()), self.below(bytes.len()));
            let end = bytes.len().min(a + 1 + self.below(20));
            match self.below(5) {
                0 => bytes[a] ^= 1 << self.below(8),
                1 => bytes.truncate(a),
                2 => drop(bytes.drain(a..end)),
                3 => {
                    let piece = bytes[a..end].to_vec();
                    bytes.splice(b..b, piece);
                }
                _ => bytes.swap(a, b),
            }
        }
        bytes
    }

    fn files(&mut self) -> BTreeMap<String, Vec<u8>> {
        let dae = std::fs::read("tests/suite/world/meshes/two.dae").unwrap();
        let files = [
            ("world.toml", self.world().into_bytes()),
            ("model.toml", self.model().into_bytes()),
            ("robot.urdf", self.urdf().into_bytes()),
            ("robot.srdf", self.srdf().into_bytes()),
            ("a.stl", self.stl(true)),
            ("b.stl", self.stl(false)),
            ("c.obj", self.obj()),
            ("d.dae", dae),
        ];
        let is_torn = self.is_damaged();
        files
            .into_iter()
            .map(|(name, bytes)| {
                let torn = is_torn && self.percent(40);
                (name.to_string(), if torn { self.damaged(bytes) } else { bytes })
            })
            .collect()
    }
}

/// The faces of a box whose corner i is on the upper side of axis k where bit k of i is set.
const TRIANGLES: [[usize; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// What holds of every world that loads.
fn is_sound(world: &World) {
    for (agent, stands) in world.scene.agents.iter().zip(&world.start.agents) {
        assert_eq!(stands.q.len(), agent.tree.dofs.len());
        assert!((1..=2).contains(&agent.arms.len()));
        for (dof, value) in agent.tree.dofs.iter().zip(&stands.q) {
            assert!(dof.lower <= *value && *value <= dof.upper, "{} is {value}", dof.name);
            assert!(dof.max_velocity > 0.0 && dof.max_acceleration > 0.0 && dof.max_acceleration.is_finite());
        }
        for pose in agent.tree.link_poses(&stands.X_WB, &stands.q) {
            assert!(pose.translation.vector.iter().all(|x| x.is_finite()));
        }
    }
    for (object, stands) in world.scene.objects.iter().zip(&world.start.objects) {
        assert!(
            stands.X_WO.translation.vector.iter().all(|x| x.is_finite()),
            "{}",
            object.id
        );
        assert!(object.mass.is_finite() && object.mass > 0.0, "{}", object.id);
    }
    assert!(contacts(&world.scene, &world.start, 1e-3).is_empty());
    assert_eq!(
        world.spans.len(),
        world.scene.agents.len() + world.scene.objects.len() + world.scene.virtuals.len()
    );
}

#[test]
fn a_thousand_random_worlds_load_or_are_refused() {
    let (mut loaded, mut refused, mut codes) = (0, 0, BTreeSet::new());
    for case in 0..CASES {
        let mut draw = Draw {
            rng: ChaCha8Rng::seed_from_u64(case),
            damage: [0, 0, 1, 5][case as usize % 4],
        };
        let files = Memory(draw.files());
        let mut sources = Sources::default();
        let (world, problems) = world::load("world.toml", &mut sources, &files);
        assert_eq!(world.is_none(), problems.has_errors(), "case {case}");
        for problem in &problems.0 {
            codes.insert(problem.code);
            for label in problem.primary.iter().chain(&problem.notes) {
                let text = &sources.get(label.span.file).text;
                assert!(text.get(label.span.range()).is_some(), "case {case}: {problem:?}");
            }
            let is_told = problem.primary.is_some() || problem.code == "world::unreadable-file";
            assert!(is_told && !problem.message.is_empty(), "case {case}: {problem:?}");
        }
        let shown = render::render(&problems, &sources, false);
        if case % 10 == 2 {
            let mut again = Sources::default();
            let (_, second) = world::load("world.toml", &mut again, &files);
            assert_eq!(shown, render::render(&second, &again, false), "case {case}");
        }
        match &world {
            Some(world) => {
                is_sound(world);
                loaded += 1;
            }
            None => refused += 1,
        }
    }
    // Enough of both, or the generator says nothing.
    assert!(loaded >= 200 && refused >= 200, "{loaded} loaded, {refused} refused");
    assert!(codes.len() >= 35, "{} kinds of problems: {codes:?}", codes.len());
}
