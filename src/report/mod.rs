//! Plans, reasons and facts as text, JSON, pages and pictures, and in the forms of other people's tools.

mod base64;
pub mod csv;
pub mod dot;
pub mod gltf;
pub mod html;
pub mod json;
pub mod moveit;
mod playback;
pub mod ros;
mod surface;
pub mod svg;
pub mod text;
pub mod trace;
mod yaml;
