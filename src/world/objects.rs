//! `[objects.ID]`: shapes, supports, stable orientations, grasps, containers, mass and color; where they stand is `placement`'s.
//! `[virtual.ID]`: a shape and its stable orientations.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

pub mod placement;

use toml::de::DeValue;

use super::mesh::{Meshes, Wanted};
use super::table::{Name, Table, Value};
use super::{Container, Grasp, Object, Part, Stable, Support, VirtualObject, grasps, pose, problems, stable, supports};
use crate::diag::{Problem, Problems};
use crate::geom::shape::Shape;
use crate::geom::{Pose, Vec3};
use crate::source::Span;

const KEYS: [&str; 26] = [
    "type",
    "mesh",
    "box",
    "cylinder",
    "sphere",
    "capsule",
    "parts",
    "xyz",
    "rpy",
    "yaw",
    "on",
    "support",
    "in",
    "container",
    "at",
    "stands",
    "in_hand_of",
    "arm",
    "grasp",
    "movable",
    "supports",
    "grasps",
    "stable",
    "containers",
    "mass",
    "color",
];
const VIRTUAL_KEYS: [&str; 8] = [
    "type", "mesh", "box", "cylinder", "sphere", "capsule", "parts", "stable",
];
const PRIMITIVES: [&str; 4] = ["box", "cylinder", "sphere", "capsule"];
const SHAPES: [&str; 5] = ["box", "cylinder", "sphere", "capsule", "mesh"];
/// No hand is wider [m].
const WIDEST_GRASP: f64 = 1.0;
/// No agent moves what is heavier [kg].
const HEAVIEST: f64 = 1000.0;
/// Nothing smaller can be handled or seen [m].
const SMALLEST: f64 = 5e-4;
/// Of light wood [kg/m^3]: what an object weighs when the file does not say.
const DENSITY: f64 = 500.0;

/// An object as the file has it, before it is placed.
#[derive(Debug)]
pub struct Written<'a> {
    pub name: Name<'a>,
    pub table: Table<'a>,
    pub object: Object,
}

/// Where the meshes of a world file come from.
pub struct Solids<'m, 'f> {
    pub meshes: &'m mut Meshes<'f>,
    /// The world file's path: names of meshes are relative to it.
    pub path: &'m str,
}

/// Reads all objects that have a shape; problems tell of the others.
pub fn read<'a>(root: &Table<'a>, solids: &mut Solids<'_, '_>, problems: &mut Problems) -> Vec<Written<'a>> {
    let mut all = Vec::new();
    for (name, table) in root.named_tables("objects", "object", problems) {
        table.only(&KEYS, problems);
        if let Some(object) = object(name, &table, solids, problems) {
            all.push(Written { name, table, object });
        }
    }
    all
}

/// Returns the ids of all objects, also of those that a problem tells of.
pub fn ids<'a>(root: &Table<'a>) -> Vec<&'a str> {
    let tables = root.named_tables("objects", "object", &mut Problems::default());
    tables.iter().map(|(name, _)| name.text).collect()
}

/// Reads all virtual objects that have a shape, with the places of their names; problems tell of the others.
pub fn read_virtual(
    root: &Table<'_>,
    solids: &mut Solids<'_, '_>,
    problems: &mut Problems,
) -> Vec<(VirtualObject, Span)> {
    let mut all = Vec::new();
    for (name, table) in root.named_tables("virtual", "virtual object", problems) {
        table.only(&VIRTUAL_KEYS, problems);
        let ty = table.text("type", problems).map(|t| t.text.to_string());
        let Some(parts) = parts(&table, solids, problems) else {
            continue;
        };
        let listed = listed(&table, "stable", problems, |t, problems| {
            given_stable(t, &parts, problems)
        });
        let stable = listed.unwrap_or_else(|| stable::stable_orientations(&parts));
        if stable.is_empty() {
            let message = format!("{} does not stand in any orientation", table.place);
            let help = "a virtual object is there to be put somewhere: give it a flat face, or list `stable`";
            problems.push(Problem::error("world::not-stable", message, name.span, "").help(help));
        }
        let id = name.text.to_string();
        all.push((VirtualObject { id, ty, parts, stable }, name.span));
    }
    all
}

fn object(name: Name<'_>, table: &Table<'_>, solids: &mut Solids<'_, '_>, problems: &mut Problems) -> Option<Object> {
    let ty = table.text("type", problems).map(|t| t.text.to_string());
    let color = pose::color(table, problems).unwrap_or(pose::GREY);
    let movable = table.truth("movable", problems).unwrap_or(true);
    let mass = table.number("mass", problems);
    if let Some((mass, span)) = mass.filter(|(m, _)| *m <= 0.0) {
        let message = format!("{} weighs {mass} kg", table.place);
        problems.push(problems::bad_value(message, span, "", "write a mass above zero, in kg"));
    } else if let Some((mass, span)) = mass.filter(|(m, _)| movable && *m > HEAVIEST) {
        let message = format!("{} weighs {mass} kg, and is to be moved", table.place);
        let help = format!(
            "masses are in kilograms: {mass} g are {}; or it is fixed, `movable = false`",
            mass / 1000.0
        );
        problems.push(problems::bad_value(message, span, "", help));
    }
    let listed_supports = listed(table, "supports", problems, support);
    let listed_grasps = listed(table, "grasps", problems, grasp);
    let containers = listed(table, "containers", problems, container).unwrap_or_default();
    let parts = parts(table, solids, problems)?;
    let listed_stable = listed(table, "stable", problems, |t, problems| {
        given_stable(t, &parts, problems)
    });
    // What is given is taken as it is; what is not is computed. A fixed object is not grasped, and put down here only.
    let stable = listed_stable.unwrap_or_else(|| {
        if movable || table.has("on") || table.has("in") {
            stable::stable_orientations(&parts)
        } else {
            Vec::new()
        }
    });
    let grasps = listed_grasps.unwrap_or_else(|| if movable { grasps::grasps(&parts) } else { Vec::new() });
    let supports = listed_supports.unwrap_or_else(|| {
        let all_boxes = parts.iter().all(|p| matches!(p.shape, Shape::Box { .. }));
        if !movable || all_boxes {
            supports::supports(&parts)
        } else {
            Vec::new()
        }
    });
    let volume: f64 = parts.iter().map(|p| p.shape.volume()).sum();
    Some(Object {
        id: name.text.to_string(),
        ty,
        parts,
        movable,
        supports,
        stable,
        grasps,
        containers,
        mass: mass.map_or(volume * DENSITY, |(m, _)| m),
        color,
    })
}

/// Returns the parts: the object's own shape, or those of `parts`.
fn parts(table: &Table<'_>, solids: &mut Solids<'_, '_>, problems: &mut Problems) -> Option<Vec<Part>> {
    let own: Vec<&str> = SHAPES.iter().copied().filter(|s| table.has(s)).collect();
    let listed = table.array("parts", problems);
    if own.is_empty() && !table.has("parts") {
        problems.push(
            Problem::error(
                "world::no-shape",
                format!("{} has no shape", table.place),
                table.span,
                "no shape here",
            )
            .help(
                "add `box = [length, width, height]`, `cylinder`, `sphere`, `capsule`, `mesh`, or several as `parts`",
            ),
        );
        return None;
    }
    if own.len() + usize::from(table.has("parts")) > 1 {
        problems.push(
            Problem::error(
                "world::bad-value",
                format!("{} has more than one shape", table.place),
                table.span,
                "",
            )
            .help("keep one, or put them into `parts = [{ box = .. }, ..]`"),
        );
        return None;
    }
    if !own.is_empty() {
        return placed(table, &Pose::identity(), solids, problems);
    }
    let listed = listed?;
    let mut parts = Vec::new();
    let mut ok = true;
    for (n, value) in listed.iter().enumerate() {
        let place = format!("part {} of {}", n + 1, table.place);
        let part = value.table(value.span, &place, problems).and_then(|t| {
            t.only(&[&SHAPES[..], &pose::KEYS[..]].concat(), problems);
            if SHAPES.iter().filter(|s| t.has(s)).count() != 1 {
                let help = "give it one of `box`, `cylinder`, `sphere`, `capsule` and `mesh`";
                let message = format!("{place} has not exactly one shape");
                problems.push(Problem::error("world::no-shape", message, t.span, "").help(help));
                return None;
            }
            let X_OP = pose::read_in_frame(&t, problems);
            placed(&t, &X_OP, solids, problems)
        });
        ok &= part.is_some();
        parts.extend(part.into_iter().flatten());
    }
    if parts.is_empty() && ok {
        let message = format!("{} has no parts", table.place);
        problems.push(Problem::error("world::no-shape", message, table.span, "").help("list at least one part"));
    }
    (ok && !parts.is_empty()).then_some(parts)
}

/// Returns the shape of a table at `X_OP`; a mesh may be several.
fn placed(table: &Table<'_>, X_OP: &Pose, solids: &mut Solids<'_, '_>, problems: &mut Problems) -> Option<Vec<Part>> {
    if !table.has("mesh") {
        let shape = shape(table, problems)?;
        return Some(vec![Part { shape, X_OS: *X_OP }]);
    }
    let shapes = mesh(table, solids, problems)?;
    let part = |(shape, p_PS): (Shape, Vec3)| Part {
        shape,
        X_OS: X_OP * nalgebra::Translation3::from(p_PS),
    };
    Some(shapes.into_iter().map(part).collect())
}

/// Reads `mesh = "mug.stl"` or `mesh = { file = "mug.stl", scale = 0.001, parts = true }`.
fn mesh(table: &Table<'_>, solids: &mut Solids<'_, '_>, problems: &mut Problems) -> Option<Vec<(Shape, Vec3)>> {
    let value = table.get("mesh")?;
    let place = format!("`mesh` of {}", table.place);
    let (name, scale, in_parts) = if matches!(value.value, DeValue::Table(_)) {
        let given = value.table(value.span, &place, problems)?;
        given.only(&["file", "scale", "parts"], problems);
        let scale = match given.get("scale").map(|s| s.value) {
            None => Some([1.0; 3]),
            Some(DeValue::Array(_)) => given.vector::<3>("scale", problems).map(|(s, _)| s),
            Some(_) => given.number("scale", problems).map(|(s, _)| [s; 3]),
        };
        if scale.is_some_and(|s| s.contains(&0.0)) {
            let message = format!("{place} is scaled to nothing");
            problems.push(problems::bad_size(
                message,
                given.span,
                "a negative factor mirrors; zero is none",
            ));
            return None;
        }
        let in_parts = given.truth("parts", problems).unwrap_or(false);
        (
            given.needed_text("file", "file = \"mug.stl\"", problems)?,
            scale?,
            in_parts,
        )
    } else {
        (value.text(&place, problems)?, [1.0; 3], false)
    };
    let wanted = Wanted {
        name: name.text,
        scale,
        in_parts,
    };
    match solids.meshes.shapes(solids.path, &wanted) {
        Ok(shapes) => {
            // The longest half side, wherever the mesh lies.
            let longest = shapes
                .iter()
                .map(|(shape, _)| shape.half_extents().max())
                .fold(0.0, f64::max);
            let message = format!("mesh `{}` of {} is {:.3} m long", name.text, table.place, 2.0 * longest);
            if 2.0 * longest > pose::LARGEST {
                let help =
                    "lengths are in metres: for a mesh in millimetres write `mesh = { file = .., scale = 0.001 }`";
                problems.push(problems::bad_size(message, name.span, help));
                return None;
            }
            if 2.0 * longest < SMALLEST {
                let help = "lengths are in metres: is the factor `scale` applied twice?";
                let message = format!(
                    "mesh `{}` of {} is {:.1e} m long",
                    name.text,
                    table.place,
                    2.0 * longest
                );
                problems.push(problems::bad_size(message, name.span, help));
                return None;
            }
            Some(shapes)
        }
        Err(no_mesh) => {
            problems.push(problems::no_mesh(&wanted, &no_mesh, name.span));
            None
        }
    }
}

fn shape(table: &Table<'_>, problems: &mut Problems) -> Option<Shape> {
    let place = &table.place;
    if let Some(value) = table.get("box") {
        let sides = value.vector::<3>(&format!("`box` of {place}"), problems)?;
        return sides
            .iter()
            .all(|side| size(*side, "wide", place, value.span, problems))
            .then(|| Shape::Box {
                half: Vec3::from(sides) / 2.0,
            });
    }
    let (key, round) = PRIMITIVES[1..]
        .iter()
        .find_map(|key| Some((*key, table.table(key, &format!("`{key}` of {place}"), problems)?)))?;
    let known: &[&str] = if key == "sphere" {
        &["radius"]
    } else {
        &["radius", "length"]
    };
    round.only(known, problems);
    let radius = round
        .needed_number("radius", "radius = 0.03", problems)
        .filter(|(r, span)| size(*r, "in radius", place, *span, problems));
    if key == "sphere" {
        return Some(Shape::Sphere { radius: radius?.0 });
    }
    let length = round
        .needed_number("length", "length = 0.1", problems)
        .filter(|(l, span)| size(*l, "long", place, *span, problems));
    let (radius, half_length) = (radius?.0, length?.0 / 2.0);
    Some(if key == "cylinder" {
        Shape::Cylinder { radius, half_length }
    } else {
        Shape::Capsule { radius, half_length }
    })
}

/// Says whether a length can be meant, and complains if not.
fn size(value: f64, word: &str, place: &str, span: Span, problems: &mut Problems) -> bool {
    let help = if value > pose::LARGEST {
        format!("lengths are in metres: {value} mm are {}", value / 1000.0)
    } else if value < SMALLEST {
        "lengths are positive, in metres".to_string()
    } else {
        return true;
    };
    problems.push(problems::bad_size(format!("{place} is {value} m {word}"), span, help));
    false
}

/// Reads an array of tables with `read_one`; `None` when the key is absent.
fn listed<'a, T>(
    table: &Table<'a>,
    key: &str,
    problems: &mut Problems,
    mut read_one: impl FnMut(&Table<'a>, &mut Problems) -> Option<T>,
) -> Option<Vec<T>> {
    let values: Vec<Value<'a>> = table.array(key, problems)?;
    let mut found = Vec::new();
    for (n, value) in values.iter().enumerate() {
        let place = format!("entry {} of `{key}` of {}", n + 1, table.place);
        let entry = value.table(value.span, &place, problems);
        found.extend(entry.and_then(|t| read_one(&t, problems)));
    }
    Some(found)
}

fn entry_name(table: &Table<'_>, problems: &mut Problems) -> Option<String> {
    let name = table.needed_text("name", "name = \"..\"", problems)?;
    Some(name.text.to_string())
}

fn support(table: &Table<'_>, problems: &mut Problems) -> Option<Support> {
    table.only(&["name", "xyz", "rpy", "yaw", "size"], problems);
    let name = entry_name(table, problems);
    let X_OF = pose::read_in_frame(table, problems);
    if !table.has("size") {
        problems.push(problems::missing_key(
            "size",
            &table.place,
            "size = [0.6, 0.4]",
            table.span,
        ));
    }
    let (sides, span) = table.vector::<2>("size", problems)?;
    let place = &table.place;
    let ok = sides.iter().all(|side| size(*side, "wide", place, span, problems));
    ok.then_some(Support {
        name: name?,
        X_OF,
        half: sides.map(|s| s / 2.0),
    })
}

fn container(table: &Table<'_>, problems: &mut Problems) -> Option<Container> {
    table.only(&["name", "xyz", "rpy", "yaw", "size"], problems);
    let name = entry_name(table, problems);
    let X_OC = pose::read_in_frame(table, problems);
    if !table.has("size") {
        problems.push(problems::missing_key(
            "size",
            &table.place,
            "size = [0.3, 0.2, 0.15]",
            table.span,
        ));
    }
    let (sides, span) = table.vector::<3>("size", problems)?;
    let place = &table.place;
    let ok = sides.iter().all(|side| size(*side, "wide", place, span, problems));
    ok.then_some(Container {
        name: name?,
        X_OC,
        half: sides.map(|s| s / 2.0),
    })
}

fn grasp(table: &Table<'_>, problems: &mut Problems) -> Option<Grasp> {
    table.only(&["name", "xyz", "rpy", "yaw", "width"], problems);
    let name = entry_name(table, problems);
    let X_OT = pose::read_in_frame(table, problems);
    let width = table
        .needed_number("width", "width = 0.05", problems)
        .filter(|(w, span)| size(*w, "wide", &table.place, *span, problems))
        .filter(|(w, span)| {
            if *w > WIDEST_GRASP {
                let help = format!("lengths are in metres: {w} mm are {}", w / 1000.0);
                problems.push(problems::bad_size(
                    format!("{} is {w} m wide", table.place),
                    *span,
                    help,
                ));
            }
            *w <= WIDEST_GRASP
        });
    Some(Grasp {
        name: name?,
        X_OT,
        width: width?.0,
    })
}

fn given_stable(table: &Table<'_>, parts: &[Part], problems: &mut Problems) -> Option<Stable> {
    table.only(&["name", "rpy"], problems);
    let name = entry_name(table, problems)?;
    let R_QO = pose::read_in_frame(table, problems).rotation;
    let stands = stable::stand(&name, parts, R_QO);
    if stands.is_none() {
        let message = format!("{} would tip or roll", table.place);
        let help = "turn a flat face down, with the middle of the object above it";
        problems.push(Problem::error("world::not-stable", message, table.span, "").help(help));
    }
    stands
}
