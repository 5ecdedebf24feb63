//! URDF text to links, joints and shapes, each fault at its place.
//!
//! Two crates read the text. [`look`] walks the XML (`roxmltree` keeps byte positions) and finds all that is wrong with it; then
//! `urdf-rs`, which has no positions and stops at the first fault, reads the robot. Every number, name and pose of the robot is
//! urdf-rs's; the look hands on nothing but places. The versions 1.1 and 1.2 of the format are therefore what urdf-rs makes of them.
//!
//! Collision shapes first; a link without any takes its visual ones. Elements that are not read (`gazebo`, `transmission`, `inertial`,
//! `texture`, sensors) are taken out before urdf-rs sees them, since it refuses some that vendors write.
//!
//! Not here: spherical joints and xacro (located errors), floating and planar joints as degrees of freedom (fixed at zero, with a
//! warning: decision 28), accelerations (the model file has them).

mod assemble;
mod look;

use super::Body;
use super::mesh::Meshes;
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::Tree;
use crate::source::{FileId, Span};
use look::Places;
pub use look::offset;

/// What a URDF says.
#[derive(Debug, Clone)]
pub struct Robot {
    /// `max_acceleration` and `max_jerk` are infinite: the model file tells them.
    pub tree: Tree,
    pub bodies: Vec<Body>,
}

/// Where a URDF's meshes come from, and what is made of them.
pub struct Solids<'m, 'f> {
    pub meshes: &'m mut Meshes<'f>,
    /// The URDF's path: names of meshes are relative to it.
    pub path: &'m str,
    /// Says whether a link's meshes become several convex parts instead of a hull each.
    pub in_parts: &'m dyn Fn(&str) -> bool,
}

/// Returns the robot of a URDF, or `None` when there is an error.
pub fn read(text: &str, file: FileId, solids: &mut Solids<'_, '_>) -> (Option<Robot>, Problems) {
    let (places, mut problems) = look::look(text, file);
    let Some(places) = places else {
        return (None, problems);
    };
    let text = &without(text, &places);
    let robot = match urdf_rs::read_from_string(text) {
        Ok(robot) => assemble::assemble(&robot, &places, solids, &mut problems),
        Err(error) => {
            refused(text, &places, &error, &mut problems);
            None
        }
    };
    (robot.filter(|_| !problems.has_errors()), problems)
}

/// Returns the text with blanks for the elements that nobody reads; all others stay where they are.
fn without(text: &str, places: &Places) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for unread in &places.unread {
        for byte in bytes.get_mut(unread.range()).into_iter().flatten() {
            *byte = b' ';
        }
    }
    // Whole elements are blanked, hence whole characters.
    String::from_utf8(bytes).unwrap_or_else(|_| text.to_string())
}

/// Places what `urdf-rs` refuses though the look found nothing wrong: it gives no place, so it is asked about each element alone.
fn refused(text: &str, places: &Places, error: &urdf_rs::UrdfError, problems: &mut Problems) {
    let of = |span: Span| text.get(span.range()).unwrap_or_default();
    let alone = |part: &str| urdf_rs::read_from_string(&format!("{}{part}</robot>", of(places.robot))).err();
    let found: Vec<Problem> = match alone("") {
        Some(_) => Vec::new(),
        None => places
            .parts
            .iter()
            .filter_map(|(head, whole)| Some(unreadable(&alone(of(*whole))?, *head)))
            .collect(),
    };
    if found.is_empty() {
        problems.push(unreadable(error, places.robot));
    }
    problems.0.extend(found);
}

fn unreadable(error: &urdf_rs::UrdfError, span: Span) -> Problem {
    let text = error.to_string();
    let text = text.trim_end_matches('.');
    Problem::error("urdf::unreadable", format!("can't be read as URDF: {text}"), span, "")
        .help("what the format asks of each element stands in the URDF reference of ROS")
}
