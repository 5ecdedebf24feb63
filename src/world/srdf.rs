//! SRDF: what the makers of a robot say beside its URDF: groups of joints, named postures, pairs of links that may touch.
//!
//! Read where the model file names it, or where one lies beside the URDF: `robot.srdf` in its folder or in `../srdf`. Names that the
//! URDF lacks are warnings: one SRDF often serves several variants of a robot. Postures of the model file count more than those of the
//! same name here. Not here: virtual and passive joints, end effectors, subgroups of a group (a group that is an arm is a chain, or a
//! list of joints), sphere approximations.

use indexmap::IndexMap;
use roxmltree::{Document, Node};

use super::problems;
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::Tree;
use crate::source::{FileId, Files, Sources, Span};

/// What an SRDF says of a robot.
#[derive(Debug, Clone, Default)]
pub struct Srdf {
    /// Base link and tip link of each group that is a chain.
    pub chains: IndexMap<String, (usize, usize)>,
    /// Names of all groups.
    pub groups: Vec<String>,
    /// Values by dof, those that a named posture has.
    pub postures: IndexMap<String, Vec<(usize, f64)>>,
    /// Links that may touch, the smaller index first.
    pub may_touch: Vec<(usize, usize)>,
}

/// Returns where an SRDF of the URDF at `path` may lie.
pub fn beside(path: &str) -> Vec<String> {
    let (folder, name) = path
        .rsplit_once('/')
        .map_or(("", path), |(folder, name)| (folder, name));
    let stem = name.strip_suffix(".urdf").unwrap_or(name);
    let slash = if folder.is_empty() { "" } else { "/" };
    vec![
        format!("{folder}{slash}{stem}.srdf"),
        format!("{folder}{slash}../srdf/{stem}.srdf"),
    ]
}

/// Reads the first of `paths` that is there; nothing where none is.
pub fn read_first(
    paths: &[String],
    tree: &Tree,
    sources: &mut Sources,
    files: &dyn Files,
    problems: &mut Problems,
) -> Srdf {
    let found = paths.iter().find_map(|path| Some((path, files.read(path).ok()?)));
    let Some((path, text)) = found else {
        return Srdf::default();
    };
    let file = sources.add(path.clone(), text.clone());
    read(&text, file, tree, problems)
}

/// Reads an SRDF of the robot `tree`.
pub fn read(text: &str, file: FileId, tree: &Tree, problems: &mut Problems) -> Srdf {
    let document = match Document::parse(text) {
        Ok(document) if document.root_element().has_tag_name("robot") => document,
        Ok(document) => {
            let name = document.root_element().tag_name().name().to_string();
            let message = format!("not an SRDF: the root element is `{name}`");
            let help = "an SRDF's root element is `<robot name=\"..\">`";
            problems.push(Problem::error("srdf::unreadable", message, Span::new(file, 0, 0), "").help(help));
            return Srdf::default();
        }
        Err(error) => {
            let at = super::urdf::offset(text, error.pos());
            let message = format!("not XML: {error}");
            problems.push(Problem::error("srdf::unreadable", message, Span::new(file, at, at), ""));
            return Srdf::default();
        }
    };
    let virtual_joints = document.descendants().filter(|n| n.has_tag_name("virtual_joint"));
    let mut reader = Reader {
        file,
        tree,
        problems,
        virtual_joints: virtual_joints.filter_map(|n| n.attribute("name")).collect(),
    };
    let mut srdf = Srdf::default();
    for node in document.root_element().children().filter(Node::is_element) {
        match node.tag_name().name() {
            "group" => reader.group(node, &mut srdf),
            "group_state" => reader.posture(node, &mut srdf),
            "disable_collisions" | "disable_default_collisions" => srdf.may_touch.extend(reader.pair(node)),
            _ => {}
        }
    }
    srdf
}

struct Reader<'a> {
    file: FileId,
    tree: &'a Tree,
    problems: &'a mut Problems,
    /// Of the robot's base in the world: the world file says where that is.
    virtual_joints: Vec<&'a str>,
}

impl Reader<'_> {
    /// Returns an attribute and its place.
    fn attribute<'n>(&self, node: Node<'n, '_>, name: &str) -> Option<(&'n str, Span)> {
        let found = node.attribute_node(name)?;
        let range = found.range_value();
        Some((found.value(), Span::new(self.file, range.start, range.end)))
    }

    /// Warns of a name that the URDF lacks.
    fn unknown<'k>(&mut self, kind: &str, name: &str, span: Span, known: impl Iterator<Item = &'k str> + Clone) {
        let message = format!("the URDF has no {kind} `{name}`");
        let problem = Problem::warning("srdf::unknown-name", message, span, "what is said of it is left out");
        self.problems
            .push(problem.maybe_help(problems::did_you_mean(name, "there are", known)));
    }

    fn link(&mut self, node: Node<'_, '_>, attribute: &str) -> Option<usize> {
        let (name, span) = self.attribute(node, attribute)?;
        let found = self.tree.links.iter().position(|l| l == name);
        if found.is_none() {
            self.unknown("link", name, span, self.tree.links.iter().map(String::as_str));
        }
        found
    }

    fn pair(&mut self, node: Node<'_, '_>) -> Option<(usize, usize)> {
        let (a, b) = (self.link(node, "link1"), self.link(node, "link2"));
        let (a, b) = (a?, b?);
        (a != b).then_some((a.min(b), a.max(b)))
    }

    /// A group that is a chain of links, or joints each of which moves what the next one hangs on.
    fn group(&mut self, node: Node<'_, '_>, srdf: &mut Srdf) {
        let Some((name, _)) = self.attribute(node, "name") else {
            return;
        };
        srdf.groups.push(name.to_string());
        if let Some(chain) = node.children().find(|c| c.has_tag_name("chain")) {
            if let (Some(base), Some(tip)) = (self.link(chain, "base_link"), self.link(chain, "tip_link")) {
                srdf.chains.insert(name.to_string(), (base, tip));
            }
            return;
        }
        let names = node.children().filter(|c| c.has_tag_name("joint"));
        let mut joints = Vec::new();
        for joint in names {
            let Some((name, span)) = self.attribute(joint, "name") else {
                continue;
            };
            match self.tree.joints.iter().position(|j| j.name == name) {
                Some(j) => joints.push(j),
                None if self.virtual_joints.contains(&name) => {}
                None => self.unknown("joint", name, span, self.tree.joints.iter().map(|j| j.name.as_str())),
            }
        }
        // Joint j moves link j + 1, and parents have smaller indices.
        joints.sort_unstable();
        let hangs_on = |below: usize, above: usize| {
            let mut link = self.tree.joints[below].parent;
            while link > above + 1 {
                link = self.tree.joints[link - 1].parent;
            }
            link == above + 1
        };
        if let (Some(first), Some(last)) = (joints.first(), joints.last())
            && joints.windows(2).all(|w| hangs_on(w[1], w[0]))
        {
            let base = self.tree.joints[*first].parent;
            srdf.chains.insert(name.to_string(), (base, last + 1));
        }
    }

    fn posture(&mut self, node: Node<'_, '_>, srdf: &mut Srdf) {
        let Some((name, _)) = self.attribute(node, "name") else {
            return;
        };
        let mut values = Vec::new();
        for joint in node.children().filter(|c| c.has_tag_name("joint")) {
            let Some(((joint, joint_span), (word, value_span))) =
                self.attribute(joint, "name").zip(self.attribute(joint, "value"))
            else {
                continue;
            };
            // Where a floating base stands is for the world file to say.
            let mut words = word.split_ascii_whitespace();
            if words.clone().count() > 1 && words.all(|w| w.parse::<f64>().is_ok()) {
                continue;
            }
            let dof = self.tree.dofs.iter().position(|d| d.name == joint);
            let Some(dof) = dof else {
                if !self.virtual_joints.contains(&joint) && !self.tree.joints.iter().any(|j| j.name == joint) {
                    self.unknown(
                        "joint",
                        joint,
                        joint_span,
                        self.tree.dofs.iter().map(|d| d.name.as_str()),
                    );
                }
                continue;
            };
            let Some(value) = word.trim().parse::<f64>().ok().filter(|v| v.is_finite()) else {
                let message = format!("the value of joint `{joint}` is `{word}`");
                let problem = Problem::error("srdf::bad-value", message, value_span, "not a finite number");
                self.problems.push(problem.help("write radians or metres"));
                continue;
            };
            let limits = &self.tree.dofs[dof];
            let inside = value.clamp(limits.lower, limits.upper);
            // Makers round: half a degree beyond is the limit.
            if (value - inside).abs() > ROUNDED {
                let (lower, upper) = (limits.lower, limits.upper);
                let message =
                    format!("joint `{joint}` of posture `{name}` is {value}, outside its limits {lower} to {upper}");
                let problem = Problem::warning("srdf::joint-limit", message, value_span, "beyond a joint limit");
                self.problems.push(problem.help(format!("it is taken for {inside}")));
            }
            values.push((dof, inside));
        }
        srdf.postures.entry(name.to_string()).or_default().extend(values);
    }
}

/// Values beyond a limit by less are taken for the limit, without a word [rad] or [m].
const ROUNDED: f64 = 0.01;
