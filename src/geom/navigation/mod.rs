//! Where a base goes on the floor, and how: paths of an agent that moves as one rigid thing.
//!
//! [`search`] finds a path on a [`grid`], any-angle where there is room, with every heading of its own where there is not; [`path`]
//! makes it shorter and checks it; [`comfort`] says what a metre costs near people; [`timing`] gives it times.
//! What is free is the caller's to say ([`Floor`]). Not here: moving people, steps and slopes, cars (whoever can't turn on the spot), arms
//! that move meanwhile.

pub mod comfort;
pub mod grid;
pub mod path;
pub mod search;
pub mod timing;

/// A point on the floor: x, y in W [m].
pub type Place = [f64; 2];
/// A base on its floor: x, y in W [m], and the heading [rad].
pub type BasePose = [f64; 3];

/// How a base can move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// In every direction, turning meanwhile.
    Holonomic,
    /// Along its heading, forward or backward; it turns on the spot.
    Differential,
}

/// What is free, and what a metre costs.
pub trait Floor {
    /// Returns whether the agent is free, at every heading and with the margin of [`Floor::is_free`], wherever its base is within `spare` [m]
    /// of the place. May say no where that is so; then poses are looked at one by one.
    fn is_roomy(&mut self, place: Place, spare: f64) -> bool;
    /// Returns whether the agent's true shape, grown by [`Floor::margin`], is free there.
    fn is_free(&mut self, pose: &BasePose) -> bool;
    /// Returns the margin that [`Floor::is_free`] keeps [m].
    fn margin(&self) -> f64;
    /// Returns what a metre costs there, at least [`Floor::least_cost`].
    fn cost(&mut self, place: Place) -> f64;
    /// Returns what a metre costs at least, above zero.
    fn least_cost(&self) -> f64;
    /// Returns how far the agent's shape reaches from its base's axis at most [m].
    fn radius(&self) -> f64;
}

/// Returns the distance between two places [m].
pub fn apart(a: Place, b: Place) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    (dx * dx + dy * dy).sqrt()
}

/// Returns the angle in (-pi, pi] that is the same but for whole turns [rad].
pub fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let turned = angle - TAU * (angle / TAU).round();
    if turned <= -PI { turned + TAU } else { turned }
}

/// Returns the direction from one place to another [rad].
pub fn direction(from: Place, to: Place) -> f64 {
    nalgebra::RealField::atan2(to[1] - from[1], to[0] - from[0])
}
