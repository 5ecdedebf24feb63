//! Geometry against an independent tool's numbers, against slower ways to the same answer, and against properties that hold always.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a test that fails stops here")]
#![expect(
    clippy::disallowed_methods,
    reason = "the platform's own functions are the independent opinion"
)]

#[path = "geometry/checker.rs"]
mod checker;
#[path = "geometry/closed_form.rs"]
mod closed_form;
#[path = "geometry/collide.rs"]
mod collide;
#[path = "geometry/collisions.rs"]
mod collisions;
#[path = "geometry/hull.rs"]
mod hull;
#[path = "geometry/ik.rs"]
mod ik;
#[path = "geometry/kinematics.rs"]
mod kinematics;
#[path = "geometry/motion.rs"]
mod motion;
#[path = "geometry/navigation.rs"]
mod navigation;
