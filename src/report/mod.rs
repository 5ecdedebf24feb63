//! Plans, reasons and facts as text, JSON and pages.

pub mod html;
pub mod json;
pub mod text;
pub mod trace;
