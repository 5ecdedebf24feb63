//! A world, or a plan in its world, as glTF 2.0 (Khronos, ISO/IEC 12113:2022): the scene graph of links and objects, and one animation.
//!
//! One self-contained file: numbers in a buffer inside of it. glTF has y up and metres: the root node turns our z up into it. A joint's
//! values lie linearly between samples, and so does its rotation about a fixed axis (spherical linear interpolation), hence joints
//! have their own samples; objects in a hand and bases have one every thirtieth of a second besides. What is drawn are the
//! collision shapes, as on the page.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use serde_json::{Value, json};

use super::base64::base64;
use super::playback::Playback;
use super::surface::Surface;
use crate::geom::Pose;
use crate::geom::shape::Shape;
use crate::plan::Plan;
use crate::world::{Scene, State};

/// Between two samples of what does not move linearly [s].
const FRAME: f64 = 1.0 / 30.0;
/// An animation has at most so many samples; a longer one gets fewer a second.
const MOST_SAMPLES: f64 = 100_000.0;
/// Turns z up into y up: a quarter turn about x.
const Y_UP: [f64; 4] = [
    -std::f64::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
    std::f64::consts::FRAC_1_SQRT_2,
];

/// glTF's numbers for what buffers hold.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Returns the text of a `.gltf` file: the scene from `start` on, moved by the plan if there is one. Of a plan that does not fit the
/// world, what fits.
pub fn write(scene: &Scene, start: &State, plan: Option<&Plan>) -> String {
    let mut file = File::default();
    let root = file.node(json!({ "name": "world", "rotation": Y_UP, "children": [] }));
    let links: Vec<Vec<usize>> = (0..scene.agents.len())
        .map(|agent| file.agent(scene, start, agent, root))
        .collect();
    let objects: Vec<usize> = (0..scene.objects.len())
        .map(|object| file.object(scene, start, object, root))
        .collect();
    if let Some(plan) = plan {
        let playback = Playback::new(scene, start, Some(plan));
        file.animate(scene, start, &playback, &links, &objects);
    }
    file.text(root)
}

/// A file in the making.
#[derive(Debug, Default)]
struct File {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    /// Shapes that have their accessors already (positions, normals, indices): models use the same ones often.
    shapes: Vec<(Shape, [usize; 3])>,
    /// By colour, the material.
    colors: Vec<[f32; 4]>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
}

impl File {
    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    fn adopt(&mut self, parent: usize, child: usize) {
        let node = &mut self.nodes[parent];
        match node.get_mut("children").and_then(Value::as_array_mut) {
            Some(children) => children.push(json!(child)),
            // An empty list of children is against the schema, so that none is there before the first child.
            None => node["children"] = json!([child]),
        }
    }

    /// Adds an agent; returns the nodes of its links.
    fn agent(&mut self, scene: &Scene, start: &State, agent: usize, root: usize) -> Vec<usize> {
        let (body, at) = (&scene.agents[agent], &start.agents[agent]);
        let mut links = vec![self.node(placed(&body.id, &at.X_WB))];
        self.adopt(root, links[0]);
        for (joint, name) in body.tree.joints.iter().zip(body.tree.links.iter().skip(1)) {
            let name = format!("{}.{name}", body.id);
            let link = self.node(placed(&name, &joint.pose_at(joint.value(&at.q))));
            self.adopt(links[joint.parent], link);
            links.push(link);
        }
        for part in &body.bodies {
            let mesh = self.mesh(&part.shape, part.color);
            self.part(links[part.link], mesh, &part.X_LS);
        }
        links
    }

    fn object(&mut self, scene: &Scene, start: &State, object: usize, root: usize) -> usize {
        let thing = &scene.objects[object];
        let node = self.node(placed(&thing.id, &start.objects[object].X_WO));
        self.adopt(root, node);
        for part in &thing.parts {
            let mesh = self.mesh(&part.shape, thing.color);
            self.part(node, mesh, &part.X_OS);
        }
        node
    }

    fn part(&mut self, parent: usize, mesh: usize, X: &Pose) {
        let mut node = placed("", X);
        node["mesh"] = json!(mesh);
        if let Some(node) = node.as_object_mut() {
            node.shift_remove("name");
        }
        let child = self.node(node);
        self.adopt(parent, child);
    }

    fn mesh(&mut self, shape: &Shape, color: [f32; 4]) -> usize {
        let known = self.shapes.iter().find(|(s, _)| s == shape).map(|(_, a)| *a);
        let [positions, normals, indices] = known.unwrap_or_else(|| {
            let accessors = self.surface(&Surface::of(shape));
            self.shapes.push((shape.clone(), accessors));
            accessors
        });
        let material = self.material(color);
        self.meshes.push(json!({ "primitives": [{
            "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices, "material": material,
        }] }));
        self.meshes.len() - 1
    }

    fn material(&mut self, color: [f32; 4]) -> usize {
        if let Some(known) = self.colors.iter().position(|c| *c == color) {
            return known;
        }
        // Colours of world and robot files are sRGB, those of glTF are linear.
        let [r, g, b, a] = color;
        let linear = [linear(r), linear(g), linear(b), a];
        let mut material = json!({
            "pbrMetallicRoughness": { "baseColorFactor": linear, "metallicFactor": 0.0, "roughnessFactor": 0.8 },
        });
        if a < 1.0 {
            material["alphaMode"] = json!("BLEND");
        }
        self.materials.push(material);
        self.colors.push(color);
        self.colors.len() - 1
    }

    fn surface(&mut self, surface: &Surface) -> [usize; 3] {
        let floats = |of: &[crate::geom::Vec3]| -> Vec<f32> {
            of.iter().flat_map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect()
        };
        let indices: Vec<u8> = surface
            .triangles
            .iter()
            .flatten()
            .flat_map(|i| i.to_le_bytes())
            .collect();
        let positions = self.floats(&floats(&surface.positions), "VEC3", Some(ARRAY_BUFFER));
        let normals = self.floats(&floats(&surface.normals), "VEC3", Some(ARRAY_BUFFER));
        let count = 3 * surface.triangles.len();
        let view = self.view(&indices, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors
            .push(json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR" }));
        [positions, normals, self.accessors.len() - 1]
    }

    /// Adds numbers to the buffer; `kind` says how many make an element. The least and the most are told, which positions and times must have.
    fn floats(&mut self, values: &[f32], kind: &str, target: Option<u32>) -> usize {
        let width = match kind {
            "VEC4" => 4,
            "VEC3" => 3,
            _ => 1,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let fold = |start: f32, of: fn(f32, f32) -> f32| -> Vec<f32> {
            let column = |i: usize| values.iter().skip(i).step_by(width).copied().fold(start, of);
            (0..width).map(column).collect()
        };
        let (min, max) = (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max));
        let view = self.view(&bytes, target);
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / width, "type": kind, "min": min, "max": max,
        }));
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.buffer.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds the motion of what moves.
    fn animate(
        &mut self,
        scene: &Scene,
        start: &State,
        playback: &Playback<'_>,
        links: &[Vec<usize>],
        objects: &[usize],
    ) {
        let frame = FRAME.max(playback.duration / MOST_SAMPLES);
        let n = (playback.duration / frame).ceil() as u32;
        let frames = (0..=n).map(|i| (f64::from(i) * frame).min(playback.duration));
        let knots = playback.segments.iter().flat_map(|s| {
            let times = s.trajectory.times.iter();
            times.map(move |t| t + s.start)
        });
        let mut times: Vec<f64> = frames.chain(knots).collect();
        times.sort_by(f64::total_cmp);
        // Times that single precision can't tell apart are one: glTF asks for times that ascend strictly.
        times.dedup_by_key(|t| *t as f32);
        let mut moving = Moving::new(scene, start);
        playback.visit(&times, &mut |state, _| moving.see(scene, state));
        let seconds: Vec<f32> = times.iter().map(|t| *t as f32).collect();
        let mut input = None;
        for (agent, (bases, joints)) in moving.agents.iter().enumerate() {
            self.track(&mut input, &seconds, links[agent][0], bases);
            for (joint, track) in joints.iter().enumerate() {
                self.track(&mut input, &seconds, links[agent][joint + 1], track);
            }
        }
        for (object, track) in moving.objects.iter().enumerate() {
            self.track(&mut input, &seconds, objects[object], track);
        }
    }

    /// Adds the channels of a node; none for what stays as it was.
    fn track(&mut self, input: &mut Option<usize>, seconds: &[f32], node: usize, track: &[Pose]) {
        let Some(first) = track.first() else { return };
        if track.iter().any(|X| X.translation != first.translation) {
            let values = track.iter().flat_map(|X| {
                let p = X.translation;
                [p.x as f32, p.y as f32, p.z as f32]
            });
            self.channel(input, seconds, node, "translation", "VEC3", &values.collect::<Vec<_>>());
        }
        if track.iter().any(|X| X.rotation != first.rotation) {
            let mut values = Vec::with_capacity(4 * track.len());
            let mut before = first.rotation.coords;
            for X in track {
                // A quaternion and its negative are the same turn; the one nearer to the one before is the short way.
                let mut q = X.rotation.coords;
                if q.dot(&before) < 0.0 {
                    q = -q;
                }
                before = q;
                values.extend([q.x as f32, q.y as f32, q.z as f32, q.w as f32]);
            }
            self.channel(input, seconds, node, "rotation", "VEC4", &values);
        }
    }

    fn channel(
        &mut self,
        input: &mut Option<usize>,
        seconds: &[f32],
        node: usize,
        path: &str,
        kind: &str,
        values: &[f32],
    ) {
        let input = *input.get_or_insert_with(|| self.floats(seconds, "SCALAR", None));
        let output = self.floats(values, kind, None);
        self.samplers
            .push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        let sampler = self.samplers.len() - 1;
        self.channels
            .push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }

    fn text(mut self, root: usize) -> String {
        if let Some(node) = self.nodes[root].as_object_mut()
            && node["children"].as_array().is_some_and(Vec::is_empty)
        {
            node.shift_remove("children");
        }
        let mut file = json!({
            "asset": { "version": "2.0", "generator": concat!("sgap ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": [root] }],
            "nodes": self.nodes,
        });
        // Empty lists are against the schema.
        for (name, list) in [
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
        ] {
            if !list.is_empty() {
                file[name] = Value::Array(list);
            }
        }
        if !self.buffer.is_empty() {
            let uri = format!("data:application/octet-stream;base64,{}", base64(&self.buffer));
            file["buffers"] = json!([{ "byteLength": self.buffer.len(), "uri": uri }]);
        }
        if !self.channels.is_empty() {
            file["animations"] = json!([{ "name": "plan", "samplers": self.samplers, "channels": self.channels }]);
        }
        let mut text = file.to_string();
        text.push('\n');
        text
    }
}

/// A node that stands at a pose in its parent's frame.
fn placed(name: &str, X: &Pose) -> Value {
    let (p, r) = (X.translation.vector, X.rotation.coords);
    json!({ "name": name, "translation": [p.x, p.y, p.z], "rotation": [r.x, r.y, r.z, r.w] })
}

/// The transfer function of sRGB (IEC 61966-2-1).
fn linear(c: f32) -> f32 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        let base = (f64::from(c) + 0.055) / 1.055;
        nalgebra::ComplexField::powf(base, 2.4) as f32
    }
}

/// Poses over time, each in its parent's frame; empty for what never moves.
#[derive(Debug)]
struct Moving {
    /// Base, and the child link of each joint.
    agents: Vec<(Vec<Pose>, Vec<Vec<Pose>>)>,
    objects: Vec<Vec<Pose>>,
    /// Number of times seen.
    n: usize,
    start: State,
}

impl Moving {
    fn new(scene: &Scene, start: &State) -> Self {
        let agents = scene.agents.iter();
        Moving {
            agents: agents
                .map(|a| (Vec::new(), vec![Vec::new(); a.tree.joints.len()]))
                .collect(),
            objects: vec![Vec::new(); scene.objects.len()],
            n: 0,
            start: start.clone(),
        }
    }

    fn see(&mut self, scene: &Scene, state: &State) {
        for (agent, (base, joints)) in self.agents.iter_mut().enumerate() {
            let (was, is) = (&self.start.agents[agent], &state.agents[agent]);
            follow(base, self.n, was.X_WB, is.X_WB);
            for (track, joint) in joints.iter_mut().zip(&scene.agents[agent].tree.joints) {
                let (was, is) = (joint.value(&was.q), joint.value(&is.q));
                if !track.is_empty() || was != is {
                    follow(track, self.n, joint.pose_at(was), joint.pose_at(is));
                }
            }
        }
        for (object, track) in self.objects.iter_mut().enumerate() {
            follow(
                track,
                self.n,
                self.start.objects[object].X_WO,
                state.objects[object].X_WO,
            );
        }
        self.n += 1;
    }
}

/// Adds a pose to what moves; what has not moved before stood as at the start.
fn follow(track: &mut Vec<Pose>, n: usize, was: Pose, is: Pose) {
    if track.is_empty() && was == is {
        return;
    }
    if track.is_empty() {
        track.resize(n, was);
    }
    track.push(is);
}
