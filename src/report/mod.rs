//! Plans and facts as text, JSON and pages.

pub mod html;
