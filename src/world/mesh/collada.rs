//! COLLADA 1.4 and 1.5: the triangles of a scene's geometries, where its nodes put them, in metres.
//!
//! `<unit meter>` counts. `<up_axis>` does not, as everywhere in robotics: the file's axes are those of the URDF. A file without a
//! scene gives each geometry once, as it is. Not here: curves and surfaces (`<brep>`, `<spline>`), morphs and animations; a skin is
//! taken in the pose in which it was bound. `<skew>` and `<lookat>` are refused, since no mesh that was met has them.

#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use indexmap::IndexMap;
use nalgebra::{Matrix4, Rotation3, Unit};
use roxmltree::{Document, Node};

use super::{add_polygon, number};
use crate::geom::Vec3;
use crate::geom::mesh::Mesh;

/// Elements nest at most this deep, nodes that name nodes included.
const DEEPEST: usize = 64;
/// Nodes of a scene, counted as often as they are named.
const MOST_NODES: usize = 100_000;

/// Reads a COLLADA file, or says what is wrong with it.
pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let text =
        std::str::from_utf8(bytes).map_err(|e| format!("it is not text: byte {} is not UTF-8", e.valid_up_to()))?;
    let options = roxmltree::ParsingOptions {
        allow_dtd: false,
        ..roxmltree::ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options).map_err(|e| format!("it is not XML: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!(
            "it is no COLLADA file: its root element is `{}`",
            root.tag_name().name()
        ));
    }
    let elements = root.descendants().filter(Node::is_element);
    let ids = elements.filter_map(|n| Some((n.attribute("id")?, n))).collect();
    let mut file = File {
        ids,
        mesh: Mesh::default(),
        n_nodes: 0,
    };
    let unit = child(root, "asset")
        .and_then(|a| child(a, "unit"))
        .and_then(|u| u.attribute("meter"));
    let unit = match unit {
        Some(word) => number(word)
            .filter(|u| *u > 0.0)
            .ok_or("its unit is no length above zero")?,
        None => 1.0,
    };
    let to_metres = Matrix4::new_scaling(unit);
    let scene = child(root, "scene").and_then(|s| child(s, "instance_visual_scene"));
    match scene {
        Some(instance) => {
            let scene = file.named(instance, "url")?;
            file.nodes(scene, to_metres)?;
        }
        None => {
            let all = root.descendants().filter(|n| n.has_tag_name_any("geometry"));
            for geometry in all {
                file.geometry(geometry, &to_metres)?;
            }
        }
    }
    Ok(file.mesh)
}

/// Elements by local name: files differ in their namespace.
trait Named {
    fn has_tag_name_any(&self, name: &str) -> bool;
}

impl Named for Node<'_, '_> {
    fn has_tag_name_any(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|c| c.has_tag_name_any(name))
}

/// Says which element is meant, with its line.
fn at(node: Node<'_, '_>) -> String {
    let line = node.document().text_pos_at(node.range().start).row;
    format!("`<{}>` in line {line}", node.tag_name().name())
}

/// Returns the finite numbers of an element's text.
fn numbers(node: Node<'_, '_>) -> Result<Vec<f64>, String> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    let all: Option<Vec<f64>> = words.map(number).collect();
    all.ok_or_else(|| format!("{} holds something else than finite numbers", at(node)))
}

/// Returns the indices of an element's text.
fn indices(node: Node<'_, '_>) -> Result<Vec<usize>, String> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    let all: Option<Vec<usize>> = words.map(|w| w.parse().ok()).collect();
    all.ok_or_else(|| format!("{} holds something else than indices", at(node)))
}

struct File<'a, 'i> {
    ids: IndexMap<&'a str, Node<'a, 'i>>,
    mesh: Mesh,
    n_nodes: usize,
}

impl<'a, 'i> File<'a, 'i> {
    /// Returns the element whose id an attribute names, `#id`.
    fn named(&self, node: Node<'a, 'i>, attribute: &str) -> Result<Node<'a, 'i>, String> {
        let url = node.attribute(attribute).unwrap_or_default();
        let found = url.strip_prefix('#').and_then(|id| self.ids.get(id));
        found
            .copied()
            .ok_or_else(|| format!("{} names `{url}`, which is not in the file", at(node)))
    }

    /// Adds the geometries of a scene's nodes; an explicit stack, since they nest as the file likes.
    fn nodes(&mut self, scene: Node<'a, 'i>, to_metres: Matrix4<f64>) -> Result<(), String> {
        let mut open = vec![(scene, to_metres, 0)];
        while let Some((node, above, depth)) = open.pop() {
            self.n_nodes += 1;
            if depth > DEEPEST || self.n_nodes > MOST_NODES {
                return Err(format!("its nodes nest too deep, or without end: {}", at(node)));
            }
            let X = above * transform(node)?;
            let mut below = Vec::new();
            for part in node.children().filter(Node::is_element) {
                match part.tag_name().name() {
                    "node" => below.push((part, X, depth + 1)),
                    "instance_node" => below.push((self.named(part, "url")?, X, depth + 1)),
                    "instance_geometry" => self.geometry(self.named(part, "url")?, &X)?,
                    "instance_controller" => self.skin(part, &X)?,
                    _ => {}
                }
            }
            open.extend(below.into_iter().rev());
        }
        Ok(())
    }

    /// Adds the geometry of a skin in the pose in which it was bound.
    fn skin(&mut self, instance: Node<'a, 'i>, X: &Matrix4<f64>) -> Result<(), String> {
        let controller = self.named(instance, "url")?;
        let Some(skin) = child(controller, "skin") else {
            return Err(format!("{} is no skin", at(controller)));
        };
        let bound = match child(skin, "bind_shape_matrix") {
            Some(matrix) => matrix4(matrix)?,
            None => Matrix4::identity(),
        };
        self.geometry(self.named(skin, "source")?, &(X * bound))
    }

    fn geometry(&mut self, geometry: Node<'a, 'i>, X: &Matrix4<f64>) -> Result<(), String> {
        let Some(mesh) = child(geometry, "mesh") else {
            return Ok(());
        };
        for primitive in mesh.children().filter(Node::is_element) {
            match primitive.tag_name().name() {
                "triangles" | "polylist" | "polygons" | "tristrips" | "trifans" => self.primitive(primitive, X)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: Node<'a, 'i>, X: &Matrix4<f64>) -> Result<(), String> {
        let inputs: Vec<Node<'a, 'i>> = primitive.children().filter(|c| c.has_tag_name_any("input")).collect();
        let offset = |n: &Node<'a, 'i>| {
            n.attribute("offset")
                .map_or(Some(0), |o| o.parse::<usize>().ok().filter(|o| *o < 64))
        };
        let offsets: Option<Vec<usize>> = inputs.iter().map(offset).collect();
        let offsets = offsets.ok_or_else(|| format!("{} has an offset that is no small number", at(primitive)))?;
        let stride = offsets.iter().max().map_or(1, |most| most + 1);
        let vertex = inputs
            .iter()
            .zip(&offsets)
            .find(|(n, _)| n.attribute("semantic") == Some("VERTEX"));
        let Some((vertex, offset)) = vertex else {
            return Err(format!("{} has no input `VERTEX`", at(primitive)));
        };
        let vertices = self.named(*vertex, "source")?;
        let position = vertices
            .children()
            .find(|n| n.attribute("semantic") == Some("POSITION"));
        let position = position.ok_or_else(|| format!("{} has no input `POSITION`", at(vertices)))?;
        let first = self.points(self.named(position, "source")?, X)?;
        let n_points = self.mesh.points.len() - first;
        let is_list = primitive.tag_name().name() == "polylist";
        let counts = match child(primitive, "vcount") {
            Some(counts) if is_list => indices(counts)?,
            _ => Vec::new(),
        };
        for p in primitive.descendants().filter(|c| c.has_tag_name_any("p")) {
            let all = indices(p)?;
            let corners: Vec<usize> = all
                .chunks_exact(stride)
                .filter_map(|c| c.get(*offset).copied())
                .collect();
            if corners.iter().any(|c| *c >= n_points) {
                return Err(format!("{} names a vertex that the file lacks", at(p)));
            }
            let corners: Vec<u32> = corners
                .iter()
                .map(|c| u32::try_from(first + c).unwrap_or(u32::MAX))
                .collect();
            let mut rest = corners.as_slice();
            match primitive.tag_name().name() {
                "triangles" => corners
                    .chunks_exact(3)
                    .try_for_each(|c| add_polygon(&mut self.mesh, c))?,
                "tristrips" => corners.windows(3).try_for_each(|c| add_polygon(&mut self.mesh, c))?,
                "polylist" => {
                    for n in &counts {
                        let (polygon, after) = rest
                            .split_at_checked(*n)
                            .ok_or_else(|| format!("{} has fewer vertices than `<vcount>` says", at(p)))?;
                        add_polygon(&mut self.mesh, polygon)?;
                        rest = after;
                    }
                }
                // A polygon, or a fan, which is cut in the same way.
                _ => add_polygon(&mut self.mesh, &corners)?,
            }
        }
        Ok(())
    }

    /// Adds the points of a `<source>`, and returns the index of the first.
    fn points(&mut self, source: Node<'a, 'i>, X: &Matrix4<f64>) -> Result<usize, String> {
        let array = child(source, "float_array").ok_or_else(|| format!("{} has no `<float_array>`", at(source)))?;
        let numbers = numbers(array)?;
        let accessor = source.descendants().find(|n| n.has_tag_name_any("accessor"));
        let of = |name: &str, default: usize| {
            let word = accessor.and_then(|a| a.attribute(name));
            word.map_or(Some(default), |w| w.parse::<usize>().ok())
        };
        let (Some(stride @ 3..), Some(start)) = (of("stride", 3), of("offset", 0)) else {
            return Err(format!(
                "the `<accessor>` of {} does not read three numbers at a time",
                at(source)
            ));
        };
        let first = self.mesh.points.len();
        let read = numbers
            .get(start..)
            .unwrap_or_default()
            .chunks(stride)
            .filter(|c| c.len() >= 3);
        self.mesh
            .points
            .extend(read.map(|c| X.transform_point(&nalgebra::Point3::new(c[0], c[1], c[2])).coords));
        if self.mesh.points[first..].iter().any(|p: &Vec3| !p.sum().is_finite()) {
            return Err(format!("{} has points that its nodes move to infinity", at(source)));
        }
        Ok(first)
    }
}

/// Returns the transform of a node: the product of its elements, in their order.
fn transform(node: Node<'_, '_>) -> Result<Matrix4<f64>, String> {
    let mut X = Matrix4::identity();
    for part in node.children().filter(Node::is_element) {
        X *= match part.tag_name().name() {
            "matrix" => matrix4(part)?,
            "translate" => Matrix4::new_translation(&vector(part)?),
            "scale" => Matrix4::new_nonuniform_scaling(&vector(part)?),
            "rotate" => match numbers(part)?[..] {
                // An axis without length turns nothing.
                [x, y, z, degrees] => Unit::try_new(Vec3::new(x, y, z), 1e-12).map_or(Matrix4::identity(), |axis| {
                    Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
                }),
                _ => return Err(format!("{} has not four numbers", at(part))),
            },
            "skew" | "lookat" => {
                return Err(format!(
                    "{} is not supported: apply the transforms and export again",
                    at(part)
                ));
            }
            _ => continue,
        };
    }
    Ok(X)
}

fn vector(node: Node<'_, '_>) -> Result<Vec3, String> {
    match numbers(node)?[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("{} has not three numbers", at(node))),
    }
}

fn matrix4(node: Node<'_, '_>) -> Result<Matrix4<f64>, String> {
    let numbers = numbers(node)?;
    if numbers.len() != 16 {
        return Err(format!("{} has not 16 numbers", at(node)));
    }
    let matrix = Matrix4::from_row_slice(&numbers);
    if matrix.row(3) != nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0) {
        return Err(format!(
            "{} is no affine transform: its last row is not 0 0 0 1",
            at(node)
        ));
    }
    Ok(matrix)
}
