//! World files and URDF to a scene, its start state, and the task.

mod scene;

pub use scene::*;
