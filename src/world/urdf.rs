//! URDF text to links, joints and shapes, each fault at its place.
//!
//! Reads the XML itself (`roxmltree`, which keeps byte positions): `urdf-rs` has no positions and stops at the first fault; the tests
//! compare the two. Collision shapes first; a link without any takes its visual ones. Unknown elements
//! (`gazebo`, `transmission`, `inertial`, sensors) are skipped, so vendors' files load when their shapes are primitives.
//!
//! Not here: meshes, floating, planar and spherical joints (located errors), accelerations (the model file has them).
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

mod assemble;

use indexmap::IndexMap;
use roxmltree::{Document, Node};

use super::problems;
use super::{Body, pose};
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::{JointKind, Tree};
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3, pose_xyz_rpy};
use crate::source::{FileId, Span};

/// What a URDF says.
#[derive(Debug, Clone)]
pub struct Robot {
    /// `max_acceleration` is infinite: URDF does not tell it.
    pub tree: Tree,
    pub bodies: Vec<Body>,
}

/// Returns the robot of a URDF, or `None` when there is an error.
pub fn read(text: &str, file: FileId) -> (Option<Robot>, Problems) {
    let mut problems = Problems::default();
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error) => {
            let at = offset(text, error.pos());
            problems.push(Problem::error(
                "urdf::not-xml",
                format!("not XML: {error}"),
                Span::new(file, at, at),
                "",
            ));
            return (None, problems);
        }
    };
    let root = document.root_element();
    if !root.has_tag_name("robot") {
        problems.push(
            Problem::error(
                "urdf::no-robot",
                format!("not a URDF: the root element is `{}`", root.tag_name().name()),
                head(root, file),
                "",
            )
            .help("a URDF's root element is `<robot name=\"..\">`"),
        );
        return (None, problems);
    }
    let mut xml = Xml { file, problems };
    let links = xml.links(root);
    let bodies = xml.bodies(root, &links);
    let joints = xml.joints(root, &links);
    let mut problems = xml.problems;
    if links.is_empty() {
        problems.push(
            Problem::error("urdf::empty-robot", "the robot has no links", head(root, file), "")
                .help("add at least one `<link name=\"base\"/>`"),
        );
    }
    if problems.has_errors() {
        return (None, problems);
    }
    let robot = assemble::assemble(&links, joints, bodies, &mut problems);
    (robot.filter(|_| !problems.has_errors()), problems)
}

/// A joint as written.
struct RawJoint {
    name: String,
    span: Span,
    kind: JointKind,
    parent: String,
    child: String,
    child_span: Span,
    X_PJ: Pose,
    axis: Vec3,
    lower: f64,
    upper: f64,
    velocity: f64,
    mimic: Option<RawMimic>,
}

/// `<mimic joint="leader" multiplier=".." offset=".."/>`.
struct RawMimic {
    leader: String,
    span: Span,
    scale: f64,
    offset: f64,
}

/// A shape as written, on the link named.
struct RawBody {
    link: String,
    shape: Shape,
    X_LS: Pose,
    color: [f32; 4],
}

/// Reads elements and collects what is wrong with them.
struct Xml {
    file: FileId,
    problems: Problems,
}

/// Returns the byte offset of a row and column, both counted from 1, columns in characters.
fn offset(text: &str, pos: roxmltree::TextPos) -> usize {
    let mut rest = text;
    let mut at = 0;
    for _ in 1..pos.row {
        let Some(newline) = rest.find('\n') else {
            return text.len();
        };
        at += newline + 1;
        rest = &rest[newline + 1..];
    }
    let column = rest.chars().take(pos.col.saturating_sub(1) as usize);
    (at + column.map(char::len_utf8).sum::<usize>()).min(text.len())
}

/// Returns the place of an element's start tag, `<joint name="a">`, without its content.
fn head(node: Node<'_, '_>, file: FileId) -> Span {
    let range = node.range();
    let end = node.first_child().map_or(range.end, |c| c.range().start);
    Span::new(file, range.start, end.max(range.start))
}

fn elements<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |c| c.has_tag_name(tag))
}

fn element<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    elements(node, tag).next()
}

impl Xml {
    fn error(&mut self, code: &'static str, message: String, span: Span, help: &str) {
        let problem = Problem::error(code, message, span, "");
        self.problems
            .push(problem.maybe_help((!help.is_empty()).then(|| help.to_string())));
    }

    /// Returns an attribute and its place, or complains that it is missing.
    fn attribute<'a>(&mut self, node: Node<'a, '_>, name: &str) -> Option<(&'a str, Span)> {
        let found = node.attribute_node(name);
        if found.is_none() {
            let tag = node.tag_name().name();
            let message = format!("`<{tag}>` lacks the attribute `{name}`");
            let span = head(node, self.file);
            self.error("urdf::missing-attribute", message, span, "");
        }
        found.map(|a| {
            (
                a.value(),
                Span::new(self.file, a.range_value().start, a.range_value().end),
            )
        })
    }

    /// Returns the `N` finite numbers of an attribute; complains if they are something else.
    fn numbers<const N: usize>(&mut self, node: Node<'_, '_>, name: &str) -> Option<[f64; N]> {
        let (text, span) = self.attribute(node, name)?;
        let mut out = [0.0; N];
        let mut n = 0;
        for word in text.split_whitespace() {
            match (word.parse::<f64>(), out.get_mut(n)) {
                (Ok(value), Some(slot)) if value.is_finite() => *slot = value,
                _ => n = N + 1,
            }
            n += 1;
        }
        if n == N {
            return Some(out);
        }
        let wanted = if N == 1 {
            "a number".into()
        } else {
            format!("{N} numbers")
        };
        let message = format!("`{name}` must be {wanted}, not `{text}`");
        self.error("urdf::bad-number", message, span, "");
        None
    }

    fn number(&mut self, node: Node<'_, '_>, name: &str) -> Option<f64> {
        self.numbers::<1>(node, name).map(|[n]| n)
    }

    fn links(&mut self, root: Node<'_, '_>) -> IndexMap<String, Span> {
        let mut links: IndexMap<String, Span> = IndexMap::new();
        for node in elements(root, "link") {
            if let Some((name, span)) = self.attribute(node, "name") {
                self.name_once(&mut links, "link", name, span);
            }
        }
        links
    }

    fn name_once(&mut self, names: &mut IndexMap<String, Span>, kind: &str, name: &str, span: Span) {
        match names.get(name) {
            Some(first) => self.problems.push(
                Problem::error(
                    "urdf::duplicate-name",
                    format!("two {kind}s are named `{name}`"),
                    span,
                    "again here",
                )
                .note(*first, "first here"),
            ),
            None => {
                names.insert(name.to_string(), span);
            }
        }
    }

    fn bodies(&mut self, root: Node<'_, '_>, links: &IndexMap<String, Span>) -> Vec<RawBody> {
        let mut materials: IndexMap<String, [f32; 4]> = IndexMap::new();
        for node in elements(root, "material") {
            if let (Some(name), Some(rgba)) = (node.attribute("name"), self.rgba(node)) {
                materials.insert(name.to_string(), rgba);
            }
        }
        let mut bodies = Vec::new();
        for node in elements(root, "link") {
            let Some(link) = node.attribute("name").filter(|n| links.contains_key(*n)) else {
                continue;
            };
            let material = elements(node, "visual").find_map(|v| element(v, "material"));
            let named = material
                .and_then(|m| m.attribute("name"))
                .and_then(|n| materials.get(n).copied());
            let color = match material {
                Some(m) => self.rgba(m).or(named),
                None => None,
            }
            .unwrap_or(pose::GREY);
            let solid = if element(node, "collision").is_some() {
                "collision"
            } else {
                "visual"
            };
            for shape_node in elements(node, solid) {
                let X_LS = self.origin(shape_node);
                if let Some(shape) = self.shape(shape_node, link) {
                    bodies.push(RawBody {
                        link: link.to_string(),
                        shape,
                        X_LS,
                        color,
                    });
                }
            }
        }
        bodies
    }

    fn rgba(&mut self, material: Node<'_, '_>) -> Option<[f32; 4]> {
        let color = element(material, "color")?;
        let rgba = self.numbers::<4>(color, "rgba")?;
        Some(rgba.map(|c| c.clamp(0.0, 1.0) as f32))
    }

    /// Returns the pose of `<origin xyz rpy>`; each part is zero when absent.
    fn origin(&mut self, node: Node<'_, '_>) -> Pose {
        let Some(origin) = element(node, "origin") else {
            return Pose::identity();
        };
        let part = |this: &mut Self, name: &str| {
            let given = origin.has_attribute(name);
            given.then(|| this.numbers::<3>(origin, name)).flatten()
        };
        let xyz = part(self, "xyz").unwrap_or_default();
        let rpy = part(self, "rpy").unwrap_or_default();
        pose_xyz_rpy(xyz, rpy)
    }

    fn shape(&mut self, node: Node<'_, '_>, link: &str) -> Option<Shape> {
        let geometry = element(node, "geometry").and_then(|g| g.children().find(Node::is_element));
        let Some(geometry) = geometry else {
            let message = format!("link `{link}` has a shape without `<geometry>`");
            let span = head(node, self.file);
            self.error(
                "urdf::no-geometry",
                message,
                span,
                "put a box, cylinder, sphere or capsule into `<geometry>`",
            );
            return None;
        };
        let span = head(geometry, self.file);
        let shape = match geometry.tag_name().name() {
            "box" => {
                let [x, y, z] = self.numbers::<3>(geometry, "size")?;
                Shape::Box {
                    half: Vec3::new(x, y, z) / 2.0,
                }
            }
            "sphere" => Shape::Sphere {
                radius: self.number(geometry, "radius")?,
            },
            tag @ ("cylinder" | "capsule") => {
                let (radius, length) = (self.number(geometry, "radius"), self.number(geometry, "length"));
                let (radius, half_length) = (radius?, length? / 2.0);
                if tag == "cylinder" {
                    Shape::Cylinder { radius, half_length }
                } else {
                    Shape::Capsule { radius, half_length }
                }
            }
            "mesh" => {
                let message = format!("link `{link}` has a mesh; meshes are not supported yet");
                let help = "replace it by boxes, cylinders, spheres or capsules in `<collision>` elements; where a link has \
                            collision shapes its visual meshes are not read";
                self.error("urdf::mesh-not-supported", message, span, help);
                return None;
            }
            other => {
                let message = format!("link `{link}` has the unknown shape `{other}`");
                let help = "shapes are `box`, `cylinder`, `sphere` and `capsule`";
                self.error("urdf::unknown-shape", message, span, help);
                return None;
            }
        };
        let positive = match &shape {
            Shape::Box { half } => half.iter().all(|h| *h > 0.0),
            Shape::Sphere { radius } => *radius > 0.0,
            Shape::Cylinder { radius, half_length } => *radius > 0.0 && *half_length > 0.0,
            Shape::Capsule { radius, half_length } => *radius > 0.0 && *half_length >= 0.0,
        };
        if !positive {
            let message = format!("link `{link}` has a shape without extent");
            self.error("urdf::bad-size", message, span, "lengths are positive, in metres");
            return None;
        }
        Some(shape)
    }

    fn joints(&mut self, root: Node<'_, '_>, links: &IndexMap<String, Span>) -> Vec<RawJoint> {
        let mut names = IndexMap::new();
        let mut joints = Vec::new();
        for node in elements(root, "joint") {
            if let Some((name, span)) = self.attribute(node, "name") {
                self.name_once(&mut names, "joint", name, span);
                joints.extend(self.joint(node, name, links));
            }
        }
        joints
    }

    fn joint(&mut self, node: Node<'_, '_>, name: &str, links: &IndexMap<String, Span>) -> Option<RawJoint> {
        let parent = self.end(node, name, "parent", links);
        let child = self.end(node, name, "child", links);
        let X_PJ = self.origin(node);
        let (kind, continuous) = self.kind(node, name)?;
        let moves = kind != JointKind::Fixed;
        let axis = self.axis(node, name, moves);
        let mimic = element(node, "mimic").and_then(|m| self.mimic(m));
        let limits = if moves {
            self.limits(node, name, continuous)
        } else {
            Some((0.0, 0.0, 0.0))
        };
        let ((parent, _), (child, child_span), (lower, upper, velocity)) = (parent?, child?, limits?);
        Some(RawJoint {
            name: name.to_string(),
            span: head(node, self.file),
            kind,
            parent,
            child,
            child_span,
            X_PJ,
            axis: axis?,
            lower,
            upper,
            velocity,
            mimic,
        })
    }

    /// Returns the link that a joint's `<parent>` or `<child>` names.
    fn end(
        &mut self,
        node: Node<'_, '_>,
        joint: &str,
        tag: &'static str,
        links: &IndexMap<String, Span>,
    ) -> Option<(String, Span)> {
        let Some(end) = element(node, tag) else {
            let message = format!("joint `{joint}` has no `<{tag}>`");
            let span = head(node, self.file);
            self.error(
                "urdf::missing-element",
                message,
                span,
                &format!("add `<{tag} link=\"..\"/>`"),
            );
            return None;
        };
        let (link, span) = self.attribute(end, "link")?;
        if !links.contains_key(link) {
            let place = format!("joint `{joint}`");
            let known = links.keys().map(String::as_str);
            self.problems.push(problems::unknown_name(
                "urdf::unknown-link",
                "link",
                link,
                &place,
                known,
                span,
            ));
            return None;
        }
        Some((link.to_string(), span))
    }

    /// Returns the joint's kind and whether it is continuous.
    fn kind(&mut self, node: Node<'_, '_>, joint: &str) -> Option<(JointKind, bool)> {
        let (kind, span) = self.attribute(node, "type")?;
        match kind {
            "fixed" => Some((JointKind::Fixed, false)),
            "revolute" => Some((JointKind::Revolute, false)),
            "continuous" => Some((JointKind::Revolute, true)),
            "prismatic" => Some((JointKind::Prismatic, false)),
            "floating" | "planar" | "spherical" => {
                let message = format!("joint `{joint}` is `{kind}`, which is not supported");
                let help =
                    "the base of a robot is placed by the world file; elsewhere, chain revolute and prismatic joints";
                self.error("urdf::joint-not-supported", message, span, help);
                None
            }
            _ => {
                let message = format!("joint `{joint}` has the unknown type `{kind}`");
                let kinds = ["fixed", "revolute", "continuous", "prismatic"];
                let help = problems::did_you_mean(kind, "types are", kinds).unwrap_or_default();
                self.error("urdf::unknown-joint-type", message, span, &help);
                None
            }
        }
    }

    /// Returns the unit axis; x when the file gives none, as the format has it.
    fn axis(&mut self, node: Node<'_, '_>, joint: &str, moves: bool) -> Option<Vec3> {
        let Some(axis) = element(node, "axis").filter(|_| moves) else {
            return Some(Vec3::x());
        };
        let [x, y, z] = self.numbers::<3>(axis, "xyz")?;
        let unit = Vec3::new(x, y, z).try_normalize(1e-9);
        if unit.is_none() {
            let message = format!("joint `{joint}` turns about nothing: its axis has no length");
            let span = head(axis, self.file);
            self.error("urdf::bad-axis", message, span, "for example `<axis xyz=\"0 0 1\"/>`");
        }
        unit
    }

    /// Returns the lower and upper limit and the greatest velocity of a joint that moves.
    fn limits(&mut self, node: Node<'_, '_>, joint: &str, continuous: bool) -> Option<(f64, f64, f64)> {
        let Some(limit) = element(node, "limit") else {
            let message = format!("joint `{joint}` moves, but has no `<limit>`");
            let span = head(node, self.file);
            let help = "add `<limit lower=\"..\" upper=\"..\" effort=\"..\" velocity=\"..\"/>`";
            self.error("urdf::missing-limit", message, span, help);
            return None;
        };
        let span = head(limit, self.file);
        let velocity = if limit.has_attribute("velocity") {
            self.number(limit, "velocity")?
        } else {
            0.0
        };
        if velocity <= 0.0 {
            let message = format!("joint `{joint}` has no velocity limit above zero");
            let help = "add `velocity=\"..\"` in rad/s or m/s: without it no motion has a duration";
            self.error("urdf::no-velocity", message, span, help);
        }
        if continuous {
            return Some((f64::NEG_INFINITY, f64::INFINITY, velocity));
        }
        let part = |this: &mut Self, name: &str| {
            let given = limit.has_attribute(name);
            if given { this.number(limit, name) } else { Some(0.0) }
        };
        let (lower, upper) = (part(self, "lower")?, part(self, "upper")?);
        if lower > upper {
            let message = format!("joint `{joint}` has a lower limit {lower} above its upper limit {upper}");
            self.error("urdf::bad-limit", message, span, "exchange the two");
        }
        Some((lower, upper, velocity))
    }

    fn mimic(&mut self, node: Node<'_, '_>) -> Option<RawMimic> {
        let (leader, span) = self.attribute(node, "joint")?;
        let part = |this: &mut Self, name: &str, or: f64| {
            let given = node.has_attribute(name);
            if given { this.number(node, name) } else { Some(or) }
        };
        Some(RawMimic {
            leader: leader.to_string(),
            span,
            scale: part(self, "multiplier", 1.0)?,
            offset: part(self, "offset", 0.0)?,
        })
    }
}
