//! World files, model files and URDF to a scene, its start state, and the task.
//!
//! `docs/worlds.md` tells the format. What a file does not give (grasps, stable orientations, supports, the link pairs that may
//! touch) is computed from the shapes. All problems of all files come at once, each at its place.
//!
//! Not here: containers of another shape than a box, flights.

mod agents;
mod contact;
mod grasps;
mod load;
mod manner;
mod may_touch;
mod mesh;
mod model;
mod navigation;
mod objects;
mod pose;
mod problems;
mod scene;
mod srdf;
mod stable;
mod supports;
mod table;
mod urdf;
mod values;

pub use contact::{BodyRef, Contact, contacts};
pub use load::load;
pub use scene::*;
pub use values::FACTS;
