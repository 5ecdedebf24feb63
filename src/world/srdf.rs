//! SRDF: what the makers of a robot say beside its URDF: groups of joints, named postures, pairs of links that may touch.
//!
//! Read where the model file names it, or where one lies beside the URDF: `robot.srdf` in its folder or in `../srdf`. Names that the
//! URDF lacks are warnings: one SRDF often serves several variants of a robot. Postures of the model file count more than those of the
//! same name here. A group that is an arm is a chain, or joints on one chain, its subgroups' among them. Not here: virtual and passive
//! joints, sphere approximations.

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
    /// Hands.
    pub end_effectors: IndexMap<String, EndEffector>,
    /// Links that may touch, the smaller index first.
    pub may_touch: Vec<(usize, usize)>,
}

/// A hand, and the link that it is fixed to.
#[derive(Debug, Clone)]
pub struct EndEffector {
    pub parent_link: usize,
    /// Links of its group, ascending.
    pub links: Vec<usize>,
}

/// What a group lists, before its subgroups are joined to it.
#[derive(Debug, Default)]
struct Listed {
    chain: Option<(usize, usize)>,
    joints: Vec<usize>,
    links: Vec<usize>,
    subgroups: Vec<String>,
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
    let nodes = || document.root_element().children().filter(Node::is_element);
    // A group may name one that comes later.
    let mut listed: IndexMap<String, Listed> = IndexMap::new();
    for node in nodes().filter(|n| n.has_tag_name("group")) {
        if let Some((name, _)) = reader.attribute(node, "name") {
            listed.insert(name.to_string(), reader.group(node));
        }
    }
    reader.subgroups_exist(nodes(), &listed);
    for name in listed.keys() {
        srdf.groups.push(name.clone());
        let chain = chain_of(tree, &listed, name);
        srdf.chains.extend(chain.map(|chain| (name.clone(), chain)));
    }
    for node in nodes() {
        match node.tag_name().name() {
            "end_effector" => reader.end_effector(node, &listed, &mut srdf),
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

    /// What a group lists of its own.
    fn group(&mut self, node: Node<'_, '_>) -> Listed {
        let mut listed = Listed::default();
        for child in node.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "chain" => {
                    let ends = (self.link(child, "base_link"), self.link(child, "tip_link"));
                    listed.chain = ends.0.zip(ends.1).or(listed.chain);
                }
                "link" => listed.links.extend(self.link(child, "name")),
                "joint" => listed.joints.extend(self.joint(child)),
                "group" => listed
                    .subgroups
                    .extend(self.attribute(child, "name").map(|(name, _)| name.to_string())),
                _ => {}
            }
        }
        listed
    }

    fn joint(&mut self, node: Node<'_, '_>) -> Option<usize> {
        let (name, span) = self.attribute(node, "name")?;
        let found = self.tree.joints.iter().position(|j| j.name == name);
        if found.is_none() && !self.virtual_joints.contains(&name) {
            self.unknown("joint", name, span, self.tree.joints.iter().map(|j| j.name.as_str()));
        }
        found
    }

    /// Warns of groups that are named by others and are not there.
    fn subgroups_exist<'n, 'i: 'n>(
        &mut self,
        nodes: impl Iterator<Item = Node<'n, 'i>>,
        listed: &IndexMap<String, Listed>,
    ) {
        let named = nodes.flat_map(|node| match node.tag_name().name() {
            "group" => node
                .children()
                .filter(|c| c.has_tag_name("group"))
                .map(|c| (c, "name"))
                .collect(),
            "end_effector" => vec![(node, "group")],
            _ => Vec::new(),
        });
        for (node, key) in named {
            if let Some((name, span)) = self.attribute(node, key)
                && !listed.contains_key(name)
            {
                let message = format!("there is no group `{name}`");
                let problem = Problem::warning("srdf::unknown-name", message, span, "what is said of it is left out");
                let known = listed.keys().map(String::as_str);
                let help = problems::did_you_mean(name, "there are", known);
                self.problems.push(problem.maybe_help(help));
            }
        }
    }

    fn end_effector(&mut self, node: Node<'_, '_>, listed: &IndexMap<String, Listed>, srdf: &mut Srdf) {
        let (Some((name, _)), Some(parent_link), Some((group, _))) = (
            self.attribute(node, "name"),
            self.link(node, "parent_link"),
            self.attribute(node, "group"),
        ) else {
            return;
        };
        let mut links: Vec<usize> = with_subgroups(listed, group)
            .iter()
            .flat_map(|g| {
                // Joint j moves link j + 1.
                let moved = g.joints.iter().map(|j| j + 1);
                let chain = g.chain.map(|(base, tip)| way(self.tree, base, tip)).unwrap_or_default();
                g.links
                    .iter()
                    .copied()
                    .chain(moved)
                    .chain(chain)
                    .collect::<Vec<usize>>()
            })
            .collect();
        links.sort_unstable();
        links.dedup();
        let end_effector = EndEffector { parent_link, links };
        srdf.end_effectors.insert(name.to_string(), end_effector);
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

/// Returns a group and all that it contains; each once, so that groups in a circle end.
fn with_subgroups<'l>(listed: &'l IndexMap<String, Listed>, name: &str) -> Vec<&'l Listed> {
    let mut found: Vec<usize> = listed.get_index_of(name).into_iter().collect();
    let mut at = 0;
    while let Some((_, group)) = found.get(at).and_then(|g| listed.get_index(*g)) {
        for name in &group.subgroups {
            let index = listed.get_index_of(name.as_str());
            found.extend(index.filter(|i| !found.contains(i)));
        }
        at += 1;
    }
    found
        .iter()
        .filter_map(|g| listed.get_index(*g))
        .map(|(_, g)| g)
        .collect()
}

/// Returns the links below `base` down to `tip`; none where there is no way.
fn way(tree: &Tree, base: usize, tip: usize) -> Vec<usize> {
    let mut links = Vec::new();
    let mut link = tip;
    while link != base {
        links.push(link);
        let Some(joint) = link.checked_sub(1).and_then(|j| tree.joints.get(j)) else {
            return Vec::new();
        };
        link = joint.parent;
    }
    links
}

/// Returns the two ends of a group that is a chain: as it says, or since each of its joints moves what the next one hangs on.
fn chain_of(tree: &Tree, listed: &IndexMap<String, Listed>, name: &str) -> Option<(usize, usize)> {
    let groups = with_subgroups(listed, name);
    if let [alone] = groups.as_slice()
        && alone.chain.is_some()
    {
        return alone.chain;
    }
    // Joint j moves link j + 1, and parents have smaller indices.
    let mut joints: Vec<usize> = groups.iter().flat_map(|g| g.joints.iter().copied()).collect();
    for (base, tip) in groups.iter().filter_map(|g| g.chain) {
        joints.extend(way(tree, base, tip).iter().map(|link| link - 1));
    }
    joints.sort_unstable();
    joints.dedup();
    let hangs_on = |below: usize, above: usize| {
        let mut link = tree.joints[below].parent;
        while link > above + 1 {
            link = tree.joints[link - 1].parent;
        }
        link == above + 1
    };
    let (first, last) = (joints.first()?, joints.last()?);
    joints
        .windows(2)
        .all(|w| hangs_on(w[1], w[0]))
        .then(|| (tree.joints[*first].parent, last + 1))
}

/// Values beyond a limit by less are taken for the limit, without a word [rad] or [m].
const ROUNDED: f64 = 0.01;
