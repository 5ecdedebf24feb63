//! What other people's tools read: each form is read back by a reader that is not ours.
//!
//! `dot` of Graphviz judges the graph where it is installed; else that test says that it is skipped.
#![expect(clippy::unwrap_used, reason = "a test says by a panic what is wrong")]
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

#[path = "view/small_world.rs"]
#[expect(dead_code, reason = "tests/view.rs needs the rest")]
mod small_world;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::Value;
use sgap::plan::{AttachmentChange, Plan};
use sgap::report::{csv, dot, gltf, moveit, ros, svg};
use small_world::{FOREARM, pick_and_place, placed_box, small_world};

/// The numbers of an accessor, by element.
fn numbers(document: &::gltf::Document, buffer: &[u8], index: usize) -> Vec<Vec<f32>> {
    let accessor = document.accessors().nth(index).unwrap();
    let view = accessor.view().unwrap();
    let width = accessor.dimensions().multiplicity();
    let bytes = &buffer[view.offset()..view.offset() + view.length()];
    let all: Vec<f32> = bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
        .collect();
    assert_eq!(all.len(), width * accessor.count());
    all.chunks_exact(width).map(<[f32]>::to_vec).collect()
}

fn read_gltf(text: &str) -> (::gltf::Document, Vec<u8>) {
    // Reads and validates.
    let file = ::gltf::Gltf::from_slice(text.as_bytes()).unwrap();
    let buffer = file.document.buffers().next().unwrap();
    let ::gltf::buffer::Source::Uri(uri) = buffer.source() else {
        panic!("a buffer inside of the file")
    };
    let bytes = STANDARD
        .decode(uri.strip_prefix("data:application/octet-stream;base64,").unwrap())
        .unwrap();
    assert_eq!(bytes.len(), buffer.length());
    (file.document, bytes)
}

#[test]
fn gltf_moves_objects_to_where_the_plan_puts_them() {
    let (scene, start) = small_world();
    let text = gltf::write(&scene, &start, Some(&pick_and_place()));
    let (document, buffer) = read_gltf(&text);
    let animation = document.animations().next().unwrap();
    let mut seen = Vec::new();
    for channel in animation.channels() {
        let node = channel.target().node().name().unwrap().to_owned();
        let property = channel.target().property();
        let times = numbers(&document, &buffer, channel.sampler().input().index());
        let values = numbers(&document, &buffer, channel.sampler().output().index());
        assert_eq!(times.len(), values.len());
        assert!(times.windows(2).all(|w| w[0][0] < w[1][0]), "times ascend");
        let name = format!("{node} {property:?}");
        if name == "BOX Translation" {
            let end = placed_box().translation.vector;
            let last = values.last().unwrap();
            for (a, b) in last.iter().zip(end.iter()) {
                assert!((f64::from(*a) - b).abs() < 1e-6, "{last:?} {end}");
            }
        }
        seen.push(name);
    }
    assert!(seen.contains(&"BOX Translation".to_owned()), "{seen:?}");
    assert!(
        seen.iter().any(|s| s.contains("forearm") && s.ends_with("Rotation")),
        "{seen:?}"
    );
}

#[test]
fn gltf_of_a_world_alone_stands_still_where_kinematics_say() {
    let (scene, start) = small_world();
    let (document, _) = read_gltf(&gltf::write(&scene, &start, None));
    assert_eq!(document.animations().count(), 0);
    // The root turns z up into y up.
    let root = document.default_scene().unwrap().nodes().next().unwrap();
    let mut found = None;
    let mut open = vec![(root, nalgebra::Matrix4::<f32>::identity())];
    while let Some((node, X)) = open.pop() {
        let local = nalgebra::Matrix4::from_iterator(node.transform().matrix().into_iter().flatten());
        let X = X * local;
        if node.name().is_some_and(|n| n.ends_with(".forearm")) {
            found = Some(X);
        }
        open.extend(node.children().map(|child| (child, X)));
    }
    let q = &start.agents[0].q;
    let X_WL = scene.agents[0].tree.link_poses(&start.agents[0].X_WB, q)[FOREARM];
    let p = X_WL.translation.vector;
    let X = found.unwrap();
    for (is, wanted) in [(X[(0, 3)], p.x), (X[(1, 3)], p.z), (X[(2, 3)], -p.y)] {
        assert!((f64::from(is) - wanted).abs() < 1e-6, "{X} {p}");
    }
}

/// The plan's samples: (time, joint, position).
fn samples(plan: &Plan) -> Vec<(f64, String, f64)> {
    let mut all = Vec::new();
    for action in &plan.actions {
        let mut start = action.start;
        for sub in action.geometry.iter().flat_map(|g| &g.sub_actions) {
            for (t, row) in sub.trajectory.times.iter().zip(&sub.trajectory.positions) {
                all.extend(
                    sub.trajectory
                        .joints
                        .iter()
                        .zip(row)
                        .map(|(j, v)| (start + t, j.clone(), *v)),
                );
            }
            start += sub.trajectory.duration();
        }
    }
    all
}

#[test]
fn the_table_has_every_sample() {
    let plan = pick_and_place();
    let text = csv::write(&plan);
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    let rows: Vec<(f64, usize, String, String, String, String, f64)> =
        reader.deserialize().map(Result::unwrap).collect();
    let expected = samples(&plan);
    assert_eq!(rows.len(), expected.len());
    for (row, (time, joint, position)) in rows.iter().zip(expected) {
        assert!(
            (row.0 - time).abs() < 1e-6 && row.5 == joint && (row.6 - position).abs() < 1e-9,
            "{row:?}"
        );
    }
}

#[test]
fn ros_messages_have_every_sample() {
    let plan = pick_and_place();
    let documents: Vec<Value> = serde_saphyr::from_multiple(&ros::write(&plan)).unwrap();
    let sub_actions: Vec<_> = plan
        .actions
        .iter()
        .flat_map(|a| a.geometry.iter().flat_map(|g| &g.sub_actions))
        .collect();
    assert_eq!(documents.len(), sub_actions.len());
    for (message, sub) in documents.iter().zip(sub_actions) {
        let names: Vec<String> = Deserialize::deserialize(&message["joint_names"]).unwrap();
        assert_eq!(names, sub.trajectory.joints);
        let points = message["points"].as_array().unwrap();
        assert_eq!(points.len(), sub.trajectory.times.len());
        for ((point, t), row) in points.iter().zip(&sub.trajectory.times).zip(&sub.trajectory.positions) {
            let at = &point["time_from_start"];
            let seconds = at["sec"].as_f64().unwrap() + 1e-9 * at["nanosec"].as_f64().unwrap();
            assert!((seconds - t).abs() < 1e-8);
            let positions: Vec<f64> = Deserialize::deserialize(&point["positions"]).unwrap();
            for (a, b) in positions.iter().zip(row) {
                assert!((a - b).abs() < 1e-8);
            }
        }
    }
}

#[test]
fn the_planning_scene_has_what_is_around_the_robot() {
    let (scene, start) = small_world();
    let text = moveit::write(&scene, &start, "small").unwrap();
    let message: Value = serde_saphyr::from_str(&text).unwrap();
    let around = message["world"]["collision_objects"].as_array().unwrap();
    let ids: Vec<&str> = around.iter().map(|o| o["id"].as_str().unwrap()).collect();
    let expected: Vec<&str> = scene.objects.iter().map(|o| o.id.as_str()).collect();
    assert_eq!(ids[..expected.len()], expected);
    for object in around {
        assert_eq!(
            object["primitives"].as_array().map(Vec::len),
            object["primitive_poses"].as_array().map(Vec::len)
        );
    }
    let joints = message["robot_state"]["joint_state"]["name"].as_array().unwrap();
    assert_eq!(joints.len(), scene.agents[0].tree.dofs.len());
}

#[test]
fn a_held_object_is_attached_in_the_planning_scene() {
    let (scene, mut start) = small_world();
    let plan = pick_and_place();
    let subs = plan
        .actions
        .iter()
        .flat_map(|a| a.geometry.iter().flat_map(|g| &g.sub_actions));
    let attach = subs.filter_map(|s| s.change.as_ref()).find_map(|change| match change {
        AttachmentChange::Attach { object_in_tool, .. } => Some(object_in_tool.pose()),
        AttachmentChange::Detach { .. } => None,
    });
    let held = sgap::world::Held {
        agent: 0,
        arm: 0,
        X_TO: attach.unwrap(),
    };
    let box_ = scene.objects.iter().position(|o| o.id == "BOX").unwrap();
    start.objects[box_].held = Some(held);
    let message: Value = serde_saphyr::from_str(&moveit::write(&scene, &start, "small").unwrap()).unwrap();
    let attached = &message["robot_state"]["attached_collision_objects"][0];
    assert_eq!(attached["object"]["id"], "BOX");
    assert!(!attached["touch_links"].as_array().unwrap().is_empty());
}

#[test]
fn graphviz_takes_the_graph() {
    let text = dot::write(&pick_and_place());
    let found = std::process::Command::new("dot")
        .arg("-Tsvg")
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn();
    let Ok(mut child) = found else {
        #[expect(clippy::print_stderr, reason = "a skipped test says so")]
        {
            eprintln!("skipped: no dot of Graphviz in the PATH");
        }
        return;
    };
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), text.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let picture = String::from_utf8(output.stdout).unwrap();
    for action in &pick_and_place().actions {
        assert!(
            picture.contains(&format!("{} {}(", action.index, action.name)),
            "{picture}"
        );
    }
}

#[test]
fn the_picture_is_xml_with_everything_in_it() {
    let (scene, start) = small_world();
    let plan = pick_and_place();
    let text = svg::write(&scene, &start, Some(&plan), "a < b & c");
    let document = roxmltree::Document::parse(&text).unwrap();
    let words: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
    assert!(words.contains(&"a < b & c"));
    for id in scene
        .objects
        .iter()
        .map(|o| &o.id)
        .chain(scene.agents.iter().map(|a| &a.id))
    {
        assert!(words.contains(&id.as_str()), "{id}");
    }
    let bars = document.descendants().filter(|n| n.has_tag_name("title")).count();
    let in_streams: usize = plan.streams.values().map(Vec::len).sum();
    assert_eq!(bars, in_streams);
    // Nothing lies outside of the picture.
    let root = document.root_element();
    let size = |name| root.attribute(name).unwrap().parse::<f64>().unwrap();
    let (width, height) = (size("width"), size("height"));
    for points in document.descendants().filter_map(|n| n.attribute("points")) {
        for point in points.split_whitespace() {
            let (x, y) = point.split_once(',').unwrap();
            let (x, y) = (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap());
            assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y), "{point}");
        }
    }
}
