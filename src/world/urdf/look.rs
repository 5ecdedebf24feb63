//! The located look at a URDF's XML: all that is wrong with its elements at once, each at its place, before the robot is read.
//!
//! Numbers are judged here and forgotten: what leaves this file are places. What the graph of links and joints may not be is
//! judged in [`super::assemble`], once it is read.

use indexmap::IndexMap;
use roxmltree::{Document, Node};

use crate::diag::{Problem, Problems};
use crate::source::{FileId, Span};
use crate::world::problems;

/// Elements nest this deep at most: readers of XML recurse. URDF itself needs six levels.
const DEEPEST: usize = 64;

/// No link is longer; a length beyond it is in millimetres [m].
const LARGEST: f64 = 50.0;

/// The velocity limit of a joint without one [rad/s] or [m/s]. HEURISTIC: slow enough for whatever moves.
pub const SLOW: f64 = 0.2;

/// Elements whose values are attributes alone. INVARIANT: urdf-rs would take them from elements within, too, which are not judged.
const LEAVES: [&str; 12] = [
    "origin", "axis", "limit", "mimic", "parent", "child", "color", "box", "cylinder", "sphere", "capsule", "mesh",
];

/// Where things stand in a text without problems.
pub struct Places {
    /// The start tag of `<robot>`.
    pub robot: Span,
    /// Name attributes of the links, by name, in the order of the file.
    pub links: IndexMap<String, Span>,
    /// In the order of the file.
    pub joints: Vec<JointPlace>,
    /// The start tags of the meshes that count, in the order of the file.
    pub meshes: Vec<Span>,
    /// Elements that are of no use here.
    pub unread: Vec<Span>,
    /// Start tag and whole of each element below `<robot>`.
    pub parts: Vec<(Span, Span)>,
}

/// A joint's names as they stand in the text, and where.
pub struct JointPlace {
    pub name: String,
    /// The start tag of `<joint>`.
    pub head: Span,
    pub parent: String,
    pub child: String,
    pub child_span: Span,
    /// The start tag of `<limit>`, or of the joint where there is none.
    pub limit: Span,
    /// What `<mimic>` names, or the start tag of the joint where there is none.
    pub leader: Span,
}

/// Returns the places of a URDF, or `None` when there is an error.
pub fn look(text: &str, file: FileId) -> (Option<Places>, Problems) {
    let mut problems = Problems::default();
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error) => {
            // A text that ends too early is wrong at its end; the parser has no place for that.
            let is_cut_off = matches!(error, roxmltree::Error::UnexpectedEndOfStream);
            let at = if is_cut_off {
                text.trim_end().len()
            } else {
                offset(text, error.pos())
            };
            let help = if is_cut_off {
                "the file may be cut off: copy or export it again"
            } else {
                "each `<tag>` has its `</tag>` or ends with `/>`, and values stand in quotes"
            };
            let message = format!("not XML: {error}");
            problems.push(Problem::error("urdf::not-xml", message, Span::new(file, at, at), "").help(help));
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
    if let Some(node) = root.descendants().find(|n| n.ancestors().nth(DEEPEST).is_some()) {
        let message = format!("elements nest deeper than {DEEPEST} levels");
        problems.push(Problem::error("urdf::too-deep", message, head(node, file), ""));
        return (None, problems);
    }
    if let Some(problem) = xacro(root, file) {
        problems.push(problem);
        return (None, problems);
    }
    let mut look = Look {
        file,
        problems,
        meshes: Vec::new(),
    };
    look.leaves(root);
    let links = look.links(root);
    look.shapes(root, &links);
    let joints = look.joints(root, &links);
    let Look {
        mut problems, meshes, ..
    } = look;
    if links.is_empty() {
        problems.push(
            Problem::error("urdf::empty-robot", "the robot has no links", head(root, file), "")
                .help("add at least one `<link name=\"base\"/>`"),
        );
    }
    let whole = |node: Node<'_, '_>| Span::new(file, node.range().start, node.range().end);
    let places = Places {
        robot: head(root, file),
        links,
        joints,
        meshes,
        unread: unread(root).map(whole).collect(),
        parts: root
            .children()
            .filter(Node::is_element)
            .map(|n| (head(n, file), whole(n)))
            .collect(),
    };
    ((!problems.has_errors()).then_some(places), problems)
}

/// Returns what is wrong with a file that is a program for a URDF.
///
/// The namespace alone says nothing: it stays in what the program writes.
fn xacro(root: Node<'_, '_>, file: FileId) -> Option<Problem> {
    let is_xacro = |n: &Node<'_, '_>| n.tag_name().namespace().is_some_and(|space| space.contains("xacro"));
    let has_expression = |n: &Node<'_, '_>| {
        n.attributes()
            .any(|a| a.value().contains("${") || a.value().contains("$("))
    };
    // Not what a file carries for a simulator.
    let ours = |n: &Node<'_, '_>| {
        !n.ancestors()
            .any(|a| a.has_tag_name("gazebo") || a.has_tag_name("transmission"))
    };
    let node = root
        .descendants()
        .filter(Node::is_element)
        .find(|n| (is_xacro(n) || has_expression(n)) && ours(n))?;
    let problem = Problem::error(
        "urdf::xacro",
        "this is a xacro file, from which a URDF is yet to be made",
        head(node, file),
        "",
    );
    Some(
        problem
            .help("run `xacro robot.urdf.xacro > robot.urdf` (of ROS, or `pip install xacro`), and name the new file"),
    )
}

/// Returns the elements that say nothing about shapes and joints.
fn unread<'a, 'i>(root: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let is_read = |n: &Node<'_, '_>| {
        let known: &[&str] = match n.parent_element().map(|p| p.tag_name().name()) {
            Some("robot") => &["link", "joint", "material"],
            Some("link") => &["visual", "collision"],
            Some("joint") => &["origin", "parent", "child", "axis", "limit", "mimic"],
            Some("material") => &["color"],
            _ => return true,
        };
        known.contains(&n.tag_name().name())
    };
    root.descendants()
        .filter(move |n| n.is_element() && *n != root && !is_read(n))
}

/// Returns what is wrong with a joint whose lower limit is above its upper one.
pub fn upside_down(joint: &str, lower: f64, upper: f64, span: Span) -> Problem {
    let message = format!("joint `{joint}` has a lower limit {lower} above its upper limit {upper}");
    Problem::error("urdf::bad-limit", message, span, "").help("exchange the two")
}

/// Collects what is wrong with elements.
struct Look {
    file: FileId,
    problems: Problems,
    meshes: Vec<Span>,
}

/// Returns the byte offset of a row and column, both counted from 1, columns in characters.
pub fn offset(text: &str, pos: roxmltree::TextPos) -> usize {
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

impl Look {
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

    /// Returns the `N` finite numbers of an attribute, for a judgement; complains if they are something else.
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
        let help = if N == 1 {
            "write it with a point and without a unit, `0.25`"
        } else {
            "write them with points and blanks between them, `0 0 0.25`"
        };
        self.error("urdf::bad-number", message, span, help);
        None
    }

    fn number(&mut self, node: Node<'_, '_>, name: &str) -> Option<f64> {
        self.numbers::<1>(node, name).map(|[n]| n)
    }

    /// Like [`Look::number`], but the attribute may be absent.
    fn number_if_there(&mut self, node: Node<'_, '_>, name: &str) -> Option<f64> {
        node.has_attribute(name).then(|| self.number(node, name)).flatten()
    }

    /// Judges that the elements of [`LEAVES`] hold none.
    fn leaves(&mut self, root: Node<'_, '_>) {
        let parts = root
            .children()
            .filter(|n| ["link", "joint", "material"].contains(&n.tag_name().name()));
        for node in parts.flat_map(|part| part.descendants()) {
            let tag = node.tag_name().name();
            if LEAVES.contains(&tag)
                && let Some(inner) = node.children().find(Node::is_element)
            {
                let message = format!("`<{tag}>` holds `<{}>`", inner.tag_name().name());
                let span = head(inner, self.file);
                let help = format!("the values of `<{tag}>` are attributes, as in `<{tag} name=\"value\"/>`");
                self.error("urdf::not-empty", message, span, &help);
            }
        }
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

    fn shapes(&mut self, root: Node<'_, '_>, links: &IndexMap<String, Span>) {
        for node in elements(root, "material") {
            self.material(node);
        }
        for node in elements(root, "link") {
            let Some(link) = node.attribute("name").filter(|n| links.contains_key(*n)) else {
                continue;
            };
            let has_collision = element(node, "collision").is_some();
            for visual in elements(node, "visual") {
                if let Some(material) = element(visual, "material") {
                    self.material(material);
                }
                self.origin(visual);
                self.shape(visual, link, !has_collision);
            }
            for collision in elements(node, "collision") {
                self.origin(collision);
                self.shape(collision, link, true);
            }
        }
    }

    fn material(&mut self, node: Node<'_, '_>) {
        self.attribute(node, "name");
        if let Some(color) = element(node, "color") {
            self.numbers::<4>(color, "rgba");
        }
    }

    /// Complains about places that nobody means: those in millimetres, and angles in degrees.
    fn is_plausible(&mut self, origin: Node<'_, '_>, name: &str, numbers: &[f64; 3]) {
        let Some((_, span)) = self.attribute(origin, name) else {
            return;
        };
        let most = numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if name == "xyz" && most > LARGEST {
            let message = format!("an origin is {most} m away from its link");
            let help = format!("lengths are in metres: {most} mm are {}", most / 1000.0);
            self.error("urdf::bad-size", message, span, &help);
        } else if name == "rpy" && most > 4.0 * std::f64::consts::PI {
            let message = format!("an origin is turned by {most} rad");
            let help = format!("angles are in radians: {most} degrees are {:.4}", most.to_radians());
            self.error("urdf::bad-number", message, span, &help);
        }
    }

    /// Judges `<origin xyz rpy>`; each part may be absent.
    fn origin(&mut self, node: Node<'_, '_>) {
        let Some(origin) = element(node, "origin") else {
            return;
        };
        for name in ["xyz", "rpy"] {
            if origin.has_attribute(name)
                && let Some(numbers) = self.numbers::<3>(origin, name)
            {
                self.is_plausible(origin, name, &numbers);
            }
        }
        if origin.has_attribute("quat_xyzw") {
            self.numbers::<4>(origin, "quat_xyzw");
        }
    }

    /// Judges the shape of a `<visual>` or `<collision>`; meshes may be where they are not `used`.
    fn shape(&mut self, node: Node<'_, '_>, link: &str, used: bool) {
        let geometry = element(node, "geometry").and_then(|g| g.children().find(Node::is_element));
        let Some(geometry) = geometry else {
            let message = format!("link `{link}` has a shape without `<geometry>`");
            let span = head(node, self.file);
            self.error(
                "urdf::no-geometry",
                message,
                span,
                "put a box, cylinder, sphere, capsule or mesh into `<geometry>`",
            );
            return;
        };
        let span = head(geometry, self.file);
        let (extents, length) = match geometry.tag_name().name() {
            "box" => (self.numbers::<3>(geometry, "size"), Some(1.0)),
            "sphere" => (self.number(geometry, "radius").map(|r| [r; 3]), Some(1.0)),
            "cylinder" | "capsule" => {
                let radius = self.number(geometry, "radius").map(|r| [r; 3]);
                (radius, self.number(geometry, "length"))
            }
            "mesh" => {
                self.attribute(geometry, "filename");
                let scale = geometry
                    .has_attribute("scale")
                    .then(|| self.numbers::<3>(geometry, "scale"));
                if used && scale.flatten().is_some_and(|s| s.contains(&0.0)) {
                    let message = format!("link `{link}` has a mesh that is scaled to nothing");
                    self.error(
                        "urdf::bad-size",
                        message,
                        span,
                        "a negative factor mirrors; zero is none",
                    );
                }
                if used {
                    self.meshes.push(span);
                }
                return;
            }
            other => {
                let message = format!("link `{link}` has the unknown shape `{other}`");
                let help = "shapes are `box`, `cylinder`, `sphere`, `capsule` and `mesh`";
                return self.error("urdf::unknown-shape", message, span, help);
            }
        };
        let (Some(extents), Some(length)) = (extents, length) else {
            return;
        };
        // A capsule without length is a ball.
        let ball = length == 0.0 && geometry.has_tag_name("capsule");
        if extents.iter().any(|e| *e <= 0.0) || !(length > 0.0 || ball) {
            let message = format!("link `{link}` has a shape without extent");
            self.error("urdf::bad-size", message, span, "lengths are positive, in metres");
            return;
        }
        let most = extents.iter().fold(length, |most, e| most.max(*e));
        if most > LARGEST {
            let message = format!("link `{link}` has a shape of {most} m");
            let help = format!("lengths are in metres: {most} mm are {}", most / 1000.0);
            self.error("urdf::bad-size", message, span, &help);
        }
    }

    fn joints(&mut self, root: Node<'_, '_>, links: &IndexMap<String, Span>) -> Vec<JointPlace> {
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

    fn joint(&mut self, node: Node<'_, '_>, name: &str, links: &IndexMap<String, Span>) -> Option<JointPlace> {
        let parent = self.end(node, name, "parent", links);
        let child = self.end(node, name, "child", links);
        self.origin(node);
        let kind = self.kind(node, name)?;
        let moves = kind != "fixed";
        self.axis(node, name, moves);
        let leader = element(node, "mimic").and_then(|m| self.mimic(m));
        if moves {
            self.limits(node, name, kind == "continuous");
        }
        let head_span = head(node, self.file);
        let ((parent, _), (child, child_span)) = (parent?, child?);
        Some(JointPlace {
            name: name.to_string(),
            head: head_span,
            parent,
            child,
            child_span,
            limit: element(node, "limit").map_or(head_span, |l| head(l, self.file)),
            leader: leader.unwrap_or(head_span),
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

    /// Returns the joint's type, one of the four that are supported.
    fn kind<'a>(&mut self, node: Node<'a, '_>, joint: &str) -> Option<&'a str> {
        let (kind, span) = self.attribute(node, "type")?;
        match kind {
            "fixed" | "revolute" | "continuous" | "prismatic" => return Some(kind),
            "floating" | "planar" => {
                let message = format!("joint `{joint}` is `{kind}`: it is held at zero");
                let help =
                    "the base of a robot is placed by the world file; elsewhere, chain revolute and prismatic joints";
                self.problems
                    .push(Problem::warning("urdf::held-joint", message, span, "").help(help));
                return Some("fixed");
            }
            "spherical" => {
                let message = format!("joint `{joint}` is `{kind}`, which is not supported");
                let help = "chain three revolute joints whose axes meet";
                self.error("urdf::joint-not-supported", message, span, help);
            }
            _ => {
                let message = format!("joint `{joint}` has the unknown type `{kind}`");
                let kinds = ["fixed", "revolute", "continuous", "prismatic", "floating", "planar"];
                let help = problems::did_you_mean(kind, "types are", kinds).unwrap_or_default();
                self.error("urdf::unknown-joint-type", message, span, &help);
            }
        }
        None
    }

    fn axis(&mut self, node: Node<'_, '_>, joint: &str, moves: bool) {
        let Some(axis) = element(node, "axis") else {
            return;
        };
        let Some(xyz) = self.numbers::<3>(axis, "xyz") else {
            return;
        };
        if moves && super::assemble::unit(xyz).is_none() {
            let message = format!("joint `{joint}` turns about nothing: its axis has no length");
            let span = head(axis, self.file);
            self.error("urdf::bad-axis", message, span, "for example `<axis xyz=\"0 0 1\"/>`");
        }
    }

    /// Judges the limits of a joint that moves.
    fn limits(&mut self, node: Node<'_, '_>, joint: &str, continuous: bool) {
        let Some(limit) = element(node, "limit") else {
            let span = head(node, self.file);
            if continuous {
                // URDF asks for limits of joints that have an end alone.
                return self.slow(joint, span);
            }
            let message = format!("joint `{joint}` moves, but has no `<limit>`");
            let help = "add `<limit lower=\"..\" upper=\"..\" effort=\"..\" velocity=\"..\"/>`";
            self.error("urdf::missing-limit", message, span, help);
            return;
        };
        let span = head(limit, self.file);
        let velocity = if limit.has_attribute("velocity") {
            self.number(limit, "velocity")
        } else {
            Some(0.0)
        };
        if velocity.is_some_and(|v| v <= 0.0) {
            self.slow(joint, span);
        }
        if continuous {
            return;
        }
        let lower = self.number_if_there(limit, "lower");
        let upper = self.number_if_there(limit, "upper");
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            self.problems.push(upside_down(joint, lower, upper, span));
        }
    }

    /// Warns of a joint whose velocity limit is ours.
    fn slow(&mut self, joint: &str, span: Span) {
        let message = format!("joint `{joint}` has no velocity limit above zero: taken for {SLOW} rad/s or m/s");
        let help = "add `velocity=\"..\"` in rad/s or m/s to its `<limit>`: without one no motion has a duration";
        self.problems
            .push(Problem::warning("urdf::no-velocity", message, span, "").help(help));
    }

    /// Returns the place of the leader's name.
    fn mimic(&mut self, node: Node<'_, '_>) -> Option<Span> {
        self.number_if_there(node, "multiplier");
        self.number_if_there(node, "offset");
        self.attribute(node, "joint").map(|(_, span)| span)
    }
}
