//! The wording of what can be wrong with a world, a model or a URDF: problems that several files of this room raise.
//!
//! A problem that one place alone raises is worded there.

use super::mesh::{NoMesh, Wanted};
use crate::diag::{Problem, suggest};
use crate::source::Span;

/// Returns "did you mean ..", or else the list of what there is.
pub fn did_you_mean<'a>(
    name: &str,
    kind: &str,
    candidates: impl IntoIterator<Item = &'a str> + Clone,
) -> Option<String> {
    if let Some(near) = suggest::did_you_mean(name, candidates.clone()) {
        return Some(near);
    }
    let all: Vec<&str> = candidates.into_iter().collect();
    match all.len() {
        0 => None,
        1..=16 => Some(format!("{kind}: `{}`", all.join("`, `"))),
        n => Some(format!("{kind}: `{}`, and {} more", all[..12].join("`, `"), n - 12)),
    }
}

/// A key that the format does not have.
pub fn unknown_key(key: &str, place: &str, known: &[&str], span: Span) -> Problem {
    Problem::error(
        "world::unknown-key",
        format!("unknown key `{key}` in {place}"),
        span,
        "not a key of this table",
    )
    .maybe_help(did_you_mean(key, "the keys here are", known.iter().copied()))
}

/// A key that must be there.
pub fn missing_key(key: &str, place: &str, example: &str, span: Span) -> Problem {
    Problem::error(
        "world::missing-key",
        format!("{place} lacks `{key}`"),
        span,
        format!("no `{key}` here"),
    )
    .help(format!("add `{example}`"))
}

/// A value of another type than the key wants.
pub fn wrong_type(what: &str, wanted: &str, found: &str, span: Span) -> Problem {
    Problem::error(
        "world::wrong-type",
        format!("{what} must be {wanted}, not {found}"),
        span,
        format!("{found} here"),
    )
    .maybe_help(how_to_write(what, wanted))
}

/// Returns how a value of the wanted type is written.
fn how_to_write(what: &str, wanted: &str) -> Option<String> {
    const EXAMPLES: [(&str, &str); 7] = [
        ("`cylinder`", "cylinder = { radius = 0.03, length = 0.1 }"),
        ("`capsule`", "capsule = { radius = 0.03, length = 0.1 }"),
        ("`sphere`", "sphere = { radius = 0.03 }"),
        ("`base`", "base = { x = 0, y = 0, yaw = 0 }"),
        ("`joints`", "joints = { elbow_joint = 0.5 }"),
        ("`tool`", "tool = { xyz = [0, 0, 0.1] }"),
        ("`task`", "task = \"Fetch(CUP)\""),
    ];
    let known = EXAMPLES.iter().find(|(key, _)| what.starts_with(key));
    let text = match (known, wanted) {
        (Some((_, example)), _) => format!("write `{example}`"),
        (None, "a text") => "texts stand in quotes, `\"red\"`".to_string(),
        (None, "a number") => "write a number without quotes, `0.5`".to_string(),
        (None, "`true` or `false`") => "write the word without quotes".to_string(),
        (None, "a table") => "write `[name]` on a line of its own, or `{ key = value }`".to_string(),
        (None, "an array") => "write it in brackets, `[..]`, with commas".to_string(),
        (None, _) if wanted.ends_with(" numbers") => {
            "write numbers in brackets with commas between, a point within, `[0.9, 0, 0.35]`".to_string()
        }
        (None, _) => return None,
    };
    Some(text)
}

/// A value of the right type that can't be right.
pub fn bad_value(message: impl Into<String>, span: Span, label: impl Into<String>, help: impl Into<String>) -> Problem {
    Problem::error("world::bad-value", message, span, label).help(help)
}

/// A length that nobody means.
pub fn bad_size(message: impl Into<String>, span: Span, help: impl Into<String>) -> Problem {
    Problem::error("world::bad-size", message, span, "this length [m]").help(help)
}

/// A mesh that can't be read, named at `span`.
pub fn no_mesh(wanted: &Wanted<'_>, no_mesh: &NoMesh, span: Span) -> Problem {
    let name = wanted.name;
    match no_mesh {
        NoMesh::NotFound { tried } => {
            let reasons: Vec<String> = tried.iter().map(|(path, why)| format!("`{path}`: {why}")).collect();
            let tried = reasons.join("; ");
            let help = if name.starts_with("package:") || name.starts_with("model:") {
                format!(
                    "name the folder that holds the package in `packages` of the model file, or in ROS_PACKAGE_PATH; tried {tried}"
                )
            } else {
                format!("a path is relative to the folder of the file that names it; tried {tried}")
            };
            let message = format!("there is no mesh `{name}`");
            Problem::error("mesh::not-found", message, span, "").help(help)
        }
        NoMesh::Format => {
            let message = format!("mesh `{name}` is of a format that is not read");
            Problem::error("mesh::unreadable", message, span, "").help("convert it to STL, OBJ or COLLADA (`.dae`)")
        }
        NoMesh::Unreadable { path, why } => {
            let message = format!("mesh `{name}` can't be read: {why}");
            Problem::error("mesh::unreadable", message, span, "").help(format!("it is `{path}`: export it again"))
        }
    }
}

/// A name that nothing bears.
pub fn unknown_name<'a>(
    code: &'static str,
    kind: &str,
    name: &str,
    place: &str,
    candidates: impl IntoIterator<Item = &'a str> + Clone,
    span: Span,
) -> Problem {
    Problem::error(
        code,
        format!("unknown {kind} `{name}` in {place}"),
        span,
        "no such name",
    )
    .maybe_help(did_you_mean(name, "there are", candidates))
}
