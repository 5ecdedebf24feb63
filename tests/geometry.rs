//! Geometry against an independent tool's numbers, against slower ways to the same answer, and against properties that hold always.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

#[path = "geometry/collide.rs"]
mod collide;
#[path = "geometry/kinematics.rs"]
mod kinematics;
