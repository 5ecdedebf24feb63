//! What people mind about a robot that passes: a cost for each metre of its way.
//!
//! After Sisbot, Marin-Urias, Alami, Simeon, *A Human Aware Mobile Robot Motion Planner*, IEEE T-RO 23(5), 2007,
//! doi:10.1109/TRO.2007.904911 (thesis 3.2.5.1, Fig. 3.3). Three criteria, each between 0 and 1, none beyond a distance from the human:
//!
//! - *distance* (the paper's safety): `(1 - d/r)^2`, where `r` is larger around who sits and can't step aside;
//! - *visibility*: `(1 - d/r)` times how far he would have to turn his gaze to have the robot in his field of view, as a share of the most;
//! - *hidden*: `(1 - d/r)^2` where something stands between his eyes and the robot, which would appear suddenly.
//!
//! Differs from the paper: its curves are given as pictures, so the formulas and their numbers are ours; a path's cost is the integral along it,
//! its length counted with a weight of its own; of several people the one who minds most counts, criterion by criterion. Who moves, talks to
//! another or is the robot's partner is not known here.

use std::f64::consts::PI;

use super::{Place, apart, direction, wrapped};

/// Somebody on the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Human {
    /// Where his head is.
    pub place: Place,
    /// Where he looks [rad].
    pub gaze: f64,
    pub is_sitting: bool,
}

/// What the criteria cost, per metre; distances in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Of each metre, whoever is near.
    pub length: f64,
    pub distance: f64,
    pub visibility: f64,
    pub hidden: f64,
    /// Beyond so far, nobody who stands minds; the same for who sits.
    pub standing: f64,
    pub sitting: f64,
    /// The full angle in which people see without turning their head [rad].
    pub field_of_view: f64,
}

impl Default for Weights {
    /// Set such that three placements like those of the thesis's Fig. 3.3 cost about as much as there: 3.7, 6.4, 8.9.
    fn default() -> Self {
        Weights {
            length: 1.0,
            distance: 3.0,
            visibility: 2.0,
            hidden: 2.0,
            standing: 3.0,
            sitting: 3.5,
            field_of_view: 2.0 * PI / 3.0,
        }
    }
}

/// What a metre costs at a place, by criterion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    pub length: f64,
    pub distance: f64,
    pub visibility: f64,
    pub hidden: f64,
}

impl Cost {
    /// Returns the sum.
    pub fn total(&self) -> f64 {
        self.length + self.distance + self.visibility + self.hidden
    }

    /// Adds so many metres of another place's cost.
    pub fn add(&mut self, other: &Cost, metres: f64) {
        self.length += other.length * metres;
        self.distance += other.distance * metres;
        self.visibility += other.visibility * metres;
        self.hidden += other.hidden * metres;
    }
}

impl Weights {
    /// Returns beyond which distance this human minds nothing [m].
    pub fn reach(&self, human: &Human) -> f64 {
        if human.is_sitting { self.sitting } else { self.standing }
    }

    /// Returns what a metre costs at `place`. `is_hidden(h, place)` says whether something stands between human `h` and the robot
    /// there; it is asked only where that counts.
    pub fn at(&self, humans: &[Human], place: Place, is_hidden: &mut dyn FnMut(usize, Place) -> bool) -> Cost {
        let mut cost = Cost {
            length: self.length,
            ..Cost::default()
        };
        for (h, human) in humans.iter().enumerate() {
            let nearness = 1.0 - apart(human.place, place) / self.reach(human);
            // A NaN minds nothing.
            if nearness > 0.0 {
                let squared = nearness * nearness;
                cost.distance = cost.distance.max(self.distance * squared);
                let turn = self.turn(human, place);
                cost.visibility = cost.visibility.max(self.visibility * nearness * turn);
                if self.hidden * squared > cost.hidden && is_hidden(h, place) {
                    cost.hidden = self.hidden * squared;
                }
            }
        }
        cost
    }

    /// Returns how far the human would have to turn to see the place, as a share of the most; 0 within his field of view.
    fn turn(&self, human: &Human, place: Place) -> f64 {
        let off = wrapped(direction(human.place, place) - human.gaze).abs();
        let half = (0.5 * self.field_of_view).clamp(0.0, PI - 1e-6);
        ((off - half) / (PI - half)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEEN: fn(usize, Place) -> bool = |_, _| false;

    #[test]
    fn before_behind_and_far_away() {
        let weights = Weights::default();
        let bob = Human {
            place: [0.0, 0.0],
            gaze: 0.0,
            is_sitting: false,
        };
        let at = |x: f64, y: f64| weights.at(&[bob], [x, y], &mut SEEN.clone());
        assert_eq!(at(3.0, 0.0).total(), weights.length, "nobody minds from afar");
        assert_eq!(at(1.0, 0.0).visibility, 0.0, "he sees what is before him");
        assert_eq!(at(1.0, 1.0).visibility, 0.0, "45 degrees aside, too");
        assert!(
            at(0.0, 1.0).visibility < at(-1.0, 0.0).visibility,
            "he minds most what is behind"
        );
        assert!((at(-1.0, 0.0).visibility - weights.visibility * 2.0 / 3.0).abs() < 1e-12);
        assert!(at(1.0, 0.0).distance < at(0.5, 0.0).distance);
    }

    #[test]
    fn who_sits_minds_more_and_who_is_hidden_from_as_well() {
        let weights = Weights::default();
        let bob = |is_sitting| Human {
            place: [0.0, 0.0],
            gaze: 0.0,
            is_sitting,
        };
        let at = |human, hidden| weights.at(&[human], [1.5, 0.0], &mut |_, _| hidden);
        assert!(at(bob(true), false).total() > at(bob(false), false).total());
        assert!(at(bob(false), true).total() > at(bob(false), false).total());
    }

    #[test]
    fn of_two_people_the_one_who_minds_more_counts() {
        let weights = Weights::default();
        let human = |x: f64| Human {
            place: [x, 0.0],
            gaze: 0.0,
            is_sitting: false,
        };
        let at = |humans: &[Human]| weights.at(humans, [0.0, 0.5], &mut SEEN.clone());
        assert_eq!(at(&[human(0.3), human(2.0)]), at(&[human(0.3)]));
    }
}
