//! Model files: what a URDF lacks about a robot or a human: arms, grippers ([`arms`]), camera, postures, speeds, accelerations.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

mod arms;

use indexmap::IndexMap;
use std::collections::BTreeSet;

use super::mesh::Meshes;
use super::srdf::{self, Srdf};
use super::table::{self, Name, Table};
use super::{Arm, BaseKind, Body, Camera, may_touch, navigation, pose, problems, urdf};
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::{Dof, Tree};
use crate::geom::navigation::timing::Limits;
use crate::source::{FileId, Files, Sources, Span};

/// A robot or a human before it has a name and a place.
#[derive(Debug, Clone)]
pub struct Model {
    pub tree: Tree,
    pub bodies: Vec<Body>,
    pub may_touch: BTreeSet<(usize, usize)>,
    pub arms: Vec<Arm>,
    pub camera: Option<Camera>,
    pub postures: IndexMap<String, Vec<f64>>,
    pub base: BaseKind,
    pub base_limits: Limits,
}

const KEYS: [&str; 16] = [
    "urdf",
    "srdf",
    "packages",
    "meshes",
    "without_shape",
    "base",
    "navigation",
    "speeds",
    "acceleration",
    "accelerations",
    "jerk",
    "jerks",
    "arms",
    "camera",
    "postures",
    "may_touch",
];

/// Joints without a value of their own get this acceleration limit [rad/s^2] or [m/s^2].
/// HEURISTIC: a tenth of what the motors of a light arm give; a model file says better.
const ACCELERATION: f64 = 1.0;

/// Joints without a jerk limit of their own come to their full acceleration in this time [s].
/// HEURISTIC: about what people and the drives of robots beside people take.
const TIME_TO_ACCELERATE: f64 = 0.1;

/// Reads a model file and its URDF; `path` as `files` understands it.
pub fn read(path: &str, sources: &mut Sources, files: &dyn Files) -> (Option<Model>, Problems) {
    let mut problems = Problems::default();
    let text = match files.read(path) {
        Ok(text) => text,
        Err(reason) => {
            problems.push(Problem::unplaced(
                "world::unreadable-file",
                format!("can't read the model file `{path}`: {reason}"),
            ));
            return (None, problems);
        }
    };
    let file = sources.add(path, text.clone());
    if text.trim_start().starts_with('<') {
        let message = format!("`{path}` is no model file: it is XML");
        let help = format!(
            "write a model file in TOML beside it, with `urdf = \"{}\"`: see docs/worlds.md",
            path.rsplit('/').next().unwrap_or(path)
        );
        problems.push(Problem::error("world::not-toml", message, Span::new(file, 0, 0), "").help(help));
        return (None, problems);
    }
    let Some(toml) = table::parse(&text, file, &mut problems) else {
        return (None, problems);
    };
    let root = Table::root(&toml, file, "the model file");
    root.only(&KEYS, &mut problems);
    let wanted = meshes(&root, path, &mut problems);
    let robot = root
        .needed_text("urdf", "urdf = \"robot.urdf\"", &mut problems)
        .and_then(|name| read_urdf(path, name, &wanted, sources, files, &mut problems));
    if let (Some((_, robot)), InParts::Of(names)) = (&robot, &wanted.in_parts) {
        for name in names {
            find_link(&robot.tree, *name, "`parts` of `[meshes]`", &mut problems);
        }
    }
    let model = robot.map(|(urdf, robot)| {
        let srdf = match root.text("srdf", &mut problems) {
            Some(name) => read_srdf(path, name, &wanted.packages, &robot.tree, sources, files, &mut problems),
            None => srdf::read_first(&srdf::beside(&urdf), &robot.tree, sources, files, &mut problems),
        };
        fill(&root, robot, &srdf, file, &mut problems)
    });
    (model.filter(|_| !problems.has_errors()), problems)
}

/// Reads the SRDF that the model file names.
fn read_srdf(
    path: &str,
    name: Name<'_>,
    packages: &[String],
    tree: &Tree,
    sources: &mut Sources,
    files: &dyn Files,
    problems: &mut Problems,
) -> Srdf {
    match find("SRDF", path, name, packages, files) {
        Ok((path, text)) => {
            let file = sources.add(path, text.clone());
            srdf::read(&text, file, tree, problems)
        }
        Err(problem) => {
            problems.push(*problem);
            Srdf::default()
        }
    }
}

/// What `packages` and `[meshes]` say.
struct MeshesWanted<'a> {
    packages: Vec<String>,
    in_parts: InParts<'a>,
    is_cached: bool,
}

/// Which links' meshes become several convex parts.
enum InParts<'a> {
    None,
    All,
    Of(Vec<Name<'a>>),
}

/// Returns the folders of `packages`, each relative to that of the file.
pub fn packages(root: &Table<'_>, path: &str, problems: &mut Problems) -> Vec<String> {
    let folders = root.array("packages", problems).unwrap_or_default();
    let names = folders
        .iter()
        .filter_map(|v| v.text("an entry of `packages`", problems));
    names.map(|name| beside(path, name.text)).collect()
}

fn meshes<'a>(root: &Table<'a>, path: &str, problems: &mut Problems) -> MeshesWanted<'a> {
    let mut wanted = MeshesWanted {
        packages: packages(root, path, problems),
        in_parts: InParts::None,
        is_cached: true,
    };
    let Some(table) = root.table("meshes", "`[meshes]`", problems) else {
        return wanted;
    };
    table.only(&["parts", "cache"], problems);
    wanted.is_cached = table.truth("cache", problems).unwrap_or(true);
    wanted.in_parts = match table.get("parts") {
        None => InParts::None,
        Some(value) if matches!(value.value, toml::de::DeValue::Array(_)) => {
            let names = table.array("parts", problems).unwrap_or_default();
            let names = names.iter().filter_map(|v| v.text("an entry of `parts`", problems));
            InParts::Of(names.collect())
        }
        Some(_) => match table.truth("parts", problems) {
            Some(true) => InParts::All,
            Some(false) | None => InParts::None,
        },
    };
    wanted
}

/// Returns the robot, and the path at which its URDF was found.
fn read_urdf(
    model_path: &str,
    name: Name<'_>,
    wanted: &MeshesWanted<'_>,
    sources: &mut Sources,
    files: &dyn Files,
    problems: &mut Problems,
) -> Option<(String, urdf::Robot)> {
    match find("URDF", model_path, name, &wanted.packages, files) {
        Ok((path, text)) => {
            let mut meshes = Meshes::new(files, wanted.packages.clone(), wanted.is_cached);
            let file = sources.add(path.clone(), text.clone());
            let in_parts = |link: &str| match &wanted.in_parts {
                InParts::None => false,
                InParts::All => true,
                InParts::Of(names) => names.iter().any(|n| n.text == link),
            };
            let mut solids = urdf::Solids {
                meshes: &mut meshes,
                path: &path,
                in_parts: &in_parts,
            };
            let (robot, found) = urdf::read(&text, file, &mut solids);
            problems.extend(found);
            robot.map(|robot| (path, robot))
        }
        Err(problem) => {
            problems.push(*problem);
            None
        }
    }
}

/// Returns the path and the text of the file that the model file names: a path, or `package://`.
fn find(
    what: &str,
    model_path: &str,
    name: Name<'_>,
    packages: &[String],
    files: &dyn Files,
) -> Result<(String, String), Box<Problem>> {
    let mut tried = Vec::new();
    for path in Meshes::new(files, packages.to_vec(), false).paths(model_path, name.text) {
        match files.read(&path) {
            Ok(text) => return Ok((path, text)),
            Err(why) => tried.push(format!("`{path}`: {why}")),
        }
    }
    let (message, help) = if name.text.starts_with("package:") {
        let tried = tried.join("; ");
        (
            format!("there is no {what} `{}`", name.text),
            format!("name the folder that holds the package in `packages`, or in ROS_PACKAGE_PATH; tried {tried}"),
        )
    } else {
        (
            format!("can't read the {what} {}", tried.join("; ")),
            "the path is relative to this file's folder".to_string(),
        )
    };
    Err(Box::new(
        Problem::error("world::unreadable-file", message, name.span, "").help(help),
    ))
}

/// Returns `path` relative to the folder of `file`; an absolute path stays.
pub fn beside(file: &str, path: &str) -> String {
    if path.starts_with('/') {
        return path.to_string();
    }
    match file.rfind('/') {
        Some(slash) => format!("{}/{path}", &file[..slash]),
        None => path.to_string(),
    }
}

fn fill(root: &Table<'_>, robot: urdf::Robot, srdf: &Srdf, file: FileId, problems: &mut Problems) -> Model {
    let urdf::Robot { mut tree, mut bodies } = robot;
    for name in root.array("without_shape", problems).unwrap_or_default() {
        let name = name.text("an entry of `without_shape`", problems);
        let link = name.and_then(|name| find_link(&tree, name, "`without_shape`", problems));
        bodies.retain(|body| Some(body.link) != link);
    }
    speeds(root, &mut tree, problems);
    rates(root, &mut tree, problems);
    let arms = arms::read(root, &tree, srdf, problems);
    let base = base_kind(root, problems);
    let base_limits = navigation::limits(root, problems);
    let camera = root
        .table("camera", "`[camera]`", problems)
        .and_then(|t| camera(&t, &tree, problems));
    let mut postures = IndexMap::new();
    for (name, values) in &srdf.postures {
        let mut q = neutral(&tree);
        for (dof, value) in values {
            q[*dof] = *value;
        }
        postures.insert(name.clone(), q);
    }
    for (name, table) in root.named_tables("postures", "posture", problems) {
        let mut q = neutral(&tree);
        set_joints(&table, &tree, &mut q, problems);
        postures.insert(name.text.to_string(), q);
    }
    let mut allowed: BTreeSet<(usize, usize)> = srdf.may_touch.iter().copied().collect();
    for pair in root.array("may_touch", problems).unwrap_or_default() {
        let what = "an entry of `may_touch`";
        let Some(names) = pair.array(file, what, problems) else {
            continue;
        };
        let [a, b] = names.as_slice() else {
            problems.push(problems::wrong_type(
                what,
                "an array of 2 links",
                "another array",
                pair.span,
            ));
            continue;
        };
        let link = |value: &table::Value<'_>, problems: &mut Problems| {
            let name = value.text("a link of `may_touch`", problems)?;
            find_link(&tree, name, "`may_touch`", problems)
        };
        if let (Some(a), Some(b)) = (link(a, problems), link(b, problems)) {
            allowed.insert((a.min(b), a.max(b)));
        }
    }
    let rest = postures.get("rest").cloned().unwrap_or_else(|| neutral(&tree));
    let may_touch = may_touch::pairs(&tree, &bodies, &rest, &allowed);
    Model {
        tree,
        bodies,
        may_touch,
        arms,
        camera,
        postures,
        base,
        base_limits,
    }
}

/// Returns what `base` says; a robot that nobody said can move does not.
fn base_kind(root: &Table<'_>, problems: &mut Problems) -> BaseKind {
    const KINDS: [(&str, BaseKind); 4] = [
        ("fixed", BaseKind::Fixed),
        ("planar", BaseKind::Planar),
        ("differential", BaseKind::Differential),
        ("flying", BaseKind::Flying),
    ];
    let Some(written) = root.text("base", problems) else {
        return BaseKind::default();
    };
    if let Some((_, kind)) = KINDS.iter().find(|(name, _)| *name == written.text) {
        return *kind;
    }
    let known = KINDS.iter().map(|(name, _)| *name);
    let help = problems::did_you_mean(written.text, "a base is", known).unwrap_or_default();
    let message = format!("`base` of {} is `{}`", root.place, written.text);
    problems.push(problems::bad_value(message, written.span, "no such kind of base", help));
    BaseKind::default()
}

/// Returns the configuration with every joint at its limit or value nearest to zero.
pub fn neutral(tree: &Tree) -> Vec<f64> {
    tree.dofs.iter().map(|d| 0.0_f64.max(d.lower).min(d.upper)).collect()
}

/// Sets the joints that a table names (`joint = value`); complains about strangers and values beyond the limits.
pub fn set_joints(table: &Table<'_>, tree: &Tree, q: &mut [f64], problems: &mut Problems) {
    for (name, value) in table.entries() {
        let what = format!("`{}` of {}", name.text, table.place);
        let dof = find_dof(tree, name, &table.place, problems);
        let number = value.number(&what, problems);
        let (Some(dof), Some(number)) = (dof, number) else {
            continue;
        };
        let limits = &tree.dofs[dof];
        if number < limits.lower || number > limits.upper {
            problems.push(
                Problem::error(
                    "world::joint-limit",
                    format!(
                        "{what} is {number}, outside its limits {} to {}",
                        limits.lower, limits.upper
                    ),
                    value.span,
                    "beyond a joint limit",
                )
                .help(degrees_help(number, limits.lower, limits.upper)),
            );
        } else if let Some(slot) = q.get_mut(dof) {
            *slot = number;
        }
    }
}

fn degrees_help(value: f64, lower: f64, upper: f64) -> String {
    let radians = value.to_radians();
    if value.abs() > 7.0 && (lower..=upper).contains(&radians) {
        return format!("angles are in radians: {value} degrees are {radians:.4}");
    }
    format!("the nearest value it can have is {}", value.clamp(lower, upper))
}

fn find_link(tree: &Tree, name: Name<'_>, place: &str, problems: &mut Problems) -> Option<usize> {
    let found = tree.links.iter().position(|l| l == name.text);
    if found.is_none() {
        let known = tree.links.iter().map(String::as_str);
        problems.push(problems::unknown_name(
            "world::unknown-link",
            "link",
            name.text,
            place,
            known,
            name.span,
        ));
    }
    found
}

fn find_dof(tree: &Tree, name: Name<'_>, place: &str, problems: &mut Problems) -> Option<usize> {
    let found = tree.dofs.iter().position(|d| d.name == name.text);
    if found.is_some() {
        return found;
    }
    if let Some(joint) = tree.joints.iter().find(|j| j.name == name.text) {
        let leader = joint.drive.and_then(|d| tree.dofs.get(d.dof));
        let help = match leader {
            Some(leader) => format!("it follows `{}`: name that one", leader.name),
            None => "a fixed joint has no value".to_string(),
        };
        problems.push(
            Problem::error(
                "world::unknown-joint",
                format!("joint `{}` in {place} does not move on its own", name.text),
                name.span,
                "",
            )
            .help(help),
        );
        return None;
    }
    let known = tree.dofs.iter().map(|d| d.name.as_str());
    problems.push(problems::unknown_name(
        "world::unknown-joint",
        "joint",
        name.text,
        place,
        known,
        name.span,
    ));
    None
}

/// `[speeds]`: joints that are to move slower than their URDF lets them, or have no limit there.
fn speeds(root: &Table<'_>, tree: &mut Tree, problems: &mut Problems) {
    let Some(table) = root.table("speeds", "`[speeds]`", problems) else {
        return;
    };
    for (name, value) in table.entries() {
        let what = format!("the speed of `{}`", name.text);
        let dof = find_dof(tree, name, &table.place, problems);
        let Some(number) = value.number(&what, problems) else {
            continue;
        };
        if number <= 0.0 {
            let message = format!("{what} is {number}, which is no speed limit");
            problems.push(problems::bad_value(
                message,
                value.span,
                "",
                "write a number above zero",
            ));
        } else if let Some(dof) = dof.and_then(|d| tree.dofs.get_mut(d)) {
            dof.max_velocity = number;
        }
    }
}

/// Reads the limits of acceleration and jerk of all joints, then those of single ones.
fn rates(root: &Table<'_>, tree: &mut Tree, problems: &mut Problems) {
    for dof in &mut tree.dofs {
        dof.max_acceleration = ACCELERATION;
    }
    limit(
        root,
        ("acceleration", "accelerations"),
        tree,
        |d| &mut d.max_acceleration,
        problems,
    );
    for dof in &mut tree.dofs {
        dof.max_jerk = dof.max_acceleration / TIME_TO_ACCELERATE;
    }
    limit(root, ("jerk", "jerks"), tree, |d| &mut d.max_jerk, problems);
}

/// Reads `one` limit for all joints, and the table of those that have their own.
fn limit(
    root: &Table<'_>,
    (one, own): (&str, &str),
    tree: &mut Tree,
    of: fn(&mut Dof) -> &mut f64,
    problems: &mut Problems,
) {
    let positive = |what: &str, value: f64, span: Span, problems: &mut Problems| {
        if value <= 0.0 {
            let message = format!("{what} is {value}, which is no {one} limit");
            problems.push(problems::bad_value(message, span, "", "write a number above zero"));
        }
        value > 0.0
    };
    if let Some((value, span)) = root.number(one, problems)
        && positive(&format!("`{one}`"), value, span, problems)
    {
        for dof in &mut tree.dofs {
            *of(dof) = value;
        }
    }
    let Some(table) = root.table(own, &format!("`[{own}]`"), problems) else {
        return;
    };
    for (name, value) in table.entries() {
        let what = format!("the {one} of `{}`", name.text);
        let dof = find_dof(tree, name, &table.place, problems);
        let number = value
            .number(&what, problems)
            .filter(|n| positive(&what, *n, value.span, problems));
        if let (Some(dof), Some(number)) = (dof.and_then(|d| tree.dofs.get_mut(d)), number) {
            *of(dof) = number;
        }
    }
}

fn camera(table: &Table<'_>, tree: &Tree, problems: &mut Problems) -> Option<Camera> {
    table.only(
        &["link", "xyz", "rpy", "yaw", "horizontal", "vertical", "range"],
        problems,
    );
    let link = table
        .needed_text("link", "link = \"head\"", problems)
        .and_then(|n| find_link(tree, n, &table.place, problems));
    let X_LC = pose::read_in_frame(table, problems);
    let mut positive = |key: &str, example: &str, most: f64| {
        let (value, span) = table.needed_number(key, example, problems)?;
        if value <= 0.0 || value >= most {
            let help = if key != "range" && value > most && value < most.to_degrees() {
                format!("angles are in radians: {value} degrees are {:.4}", value.to_radians())
            } else {
                format!("write a number between 0 and {most:.4}")
            };
            let message = format!("`{key}` of {} is {value}", table.place);
            problems.push(problems::bad_value(message, span, "", help));
            return None;
        }
        Some(value)
    };
    let pi = std::f64::consts::PI;
    let horizontal = positive("horizontal", "horizontal = 1.57", pi);
    let vertical = positive("vertical", "vertical = 1.2", pi);
    let range = positive("range", "range = 5.0", pose::FARTHEST);
    Some(Camera {
        link: link?,
        X_LC,
        horizontal: horizontal?,
        vertical: vertical?,
        range: range?,
    })
}
