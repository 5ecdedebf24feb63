//! URDF text to links, joints and shapes, each fault at its place.
//!
//! Two crates read the text. [`look`] walks the XML (`roxmltree` keeps byte positions) and finds all that is wrong with it; then
//! `urdf-rs`, which has no positions and stops at the first fault, reads the robot. Every number, name and pose of the robot is
//! urdf-rs's; the look hands on nothing but places. The versions 1.1 and 1.2 of the format are therefore what urdf-rs makes of them.
//!
//! Collision shapes first; a link without any takes its visual ones. Unknown elements (`gazebo`, `transmission`, sensors) are
//! skipped, so vendors' files load when their shapes are primitives.
//!
//! Not here: meshes, floating, planar and spherical joints (located errors), accelerations (the model file has them).

mod assemble;
mod look;

use super::Body;
use crate::diag::{Problem, Problems};
use crate::geom::kinematics::Tree;
use crate::source::{FileId, Span};
use look::Places;

/// What a URDF says.
#[derive(Debug, Clone)]
pub struct Robot {
    /// `max_acceleration` is infinite: the model file tells it.
    pub tree: Tree,
    pub bodies: Vec<Body>,
}

/// Returns the robot of a URDF, or `None` when there is an error.
pub fn read(text: &str, file: FileId) -> (Option<Robot>, Problems) {
    let (places, mut problems) = look::look(text, file);
    let Some(places) = places else {
        return (None, problems);
    };
    let robot = match urdf_rs::read_from_string(text) {
        Ok(robot) => assemble::assemble(&robot, &places, &mut problems),
        Err(error) => {
            refused(text, &places, &error, &mut problems);
            None
        }
    };
    (robot.filter(|_| !problems.has_errors()), problems)
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
