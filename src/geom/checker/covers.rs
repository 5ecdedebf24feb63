//! What the covers of two forms say of them.

use super::lanes::{Fixed, Lanes, Points};
use crate::geom::collide::Core;
use crate::geom::cover::{Form, GROUP};

/// A cover decides when it is sure by as much [m]: more than what the exact test and the poses are rounded by.
pub const SURE: f64 = 1e-6;

/// What a cover says of two forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Said {
    Free,
    Hit,
    /// The exact test has to say.
    Unsure,
}

/// Tests the balls of `a` against the shape of `b`, grown by `margin` [m]; `centre` is that of the ball around `a`, in the world.
#[inline(always)]
pub fn say(a: &Form, at_a: &impl Fn() -> Fixed, centre: &[f64; 3], b: &Form, at_b: &Fixed, margin: f64) -> Said {
    let whole = a.whole();
    let [x, y, z] = at_b.inverse_of(centre);
    let one = [Lanes([x]), Lanes([y]), Lanes([z])];
    let (maybe, hit) = balls_say(&one, &Lanes([whole.radius]), &Lanes([whole.within]), b, margin);
    if hit || !maybe || a.balls().len() < 2 {
        return said(maybe, hit);
    }
    let between = at_b.inverse_times(&at_a());
    let mut any = false;
    for group in a.groups() {
        let p: Points<GROUP> = between.of(&[Lanes(group.p[0]), Lanes(group.p[1]), Lanes(group.p[2])]);
        let (maybe, hit) = balls_say(&p, &Lanes(group.radius), &Lanes(group.within), b, margin);
        if hit {
            return Said::Hit;
        }
        any |= maybe;
    }
    said(any, false)
}

fn said(maybe: bool, hit: bool) -> Said {
    if hit {
        Said::Hit
    } else if maybe {
        Said::Unsure
    } else {
        Said::Free
    }
}

/// Balls, their centres measured in the frame of `b`, against its shape: whether one may come near, and whether one surely touches.
#[inline(always)]
fn balls_say<const N: usize>(
    p: &Points<N>,
    radius: &Lanes<N>,
    within: &Lanes<N>,
    b: &Form,
    margin: f64,
) -> (bool, bool) {
    let shape = b.solid();
    let grown = shape.round + margin;
    let far = *radius + (grown + SURE);
    // Balls that are not within their solid say nothing.
    let near = within.map(|w| if w >= 0.0 { (w + grown - SURE).max(0.0) } else { 0.0 });
    let beyond = |v: Lanes<N>, half: f64| (v.abs() + -half).at_least(0.0);
    let half = shape.half;
    let (x, y, z) = (beyond(p[0], half.x), beyond(p[1], half.y), beyond(p[2], half.z));
    let to_box = x * x + y * y + z * z;
    let apart2 = match shape.core {
        Core::Point | Core::Segment { .. } | Core::Box { .. } => to_box,
        Core::Cylinder { radius, half_length } => {
            let across = ((p[0] * p[0] + p[1] * p[1]).sqrt() + -radius).at_least(0.0);
            let along = beyond(p[2], half_length);
            across * across + along * along
        }
        Core::Hull(ref hull) => {
            if !to_box.any_not_above(far * far) {
                return (false, false);
            }
            // Beyond a face by as much means apart by at least as much; behind all of them is inside.
            let mut outside = Lanes::all(f64::NEG_INFINITY);
            for face in &hull.faces {
                let n = face.normal;
                outside = outside.max(p[0] * n.x + p[1] * n.y + p[2] * n.z + -face.offset);
            }
            let inside = outside.with(*within, |o, w| if w >= 0.0 { o } else { 0.0 });
            return (outside.any_not_above(far), inside.any_below(Lanes::all(-SURE)));
        }
    };
    (apart2.any_not_above(far * far), apart2.any_below(near * near))
}
