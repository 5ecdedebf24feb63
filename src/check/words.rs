//! The words of geometric actions: what may be chosen, demanded, moved, reached and changed, each with its arguments.

use crate::ir::geometric::ChoiceSet;
use crate::ir::{ChoiceId, ParamId};

/// A word with its arguments, of which the last ones may be left out.
#[derive(Debug, PartialEq)]
pub(super) struct Word {
    pub name: &'static str,
    pub args: &'static [Thing],
    pub n_required: usize,
}

/// What an argument is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Thing {
    Agent,
    Object,
    /// Either.
    Entity,
    Arm,
    Grasp,
    Face,
    Orientation,
    Point,
    Angle,
    Stand,
    /// [m]
    Length,
}

impl Thing {
    /// Returns what is chosen from a set.
    pub(super) fn chosen(from: ChoiceSet) -> Thing {
        match from {
            ChoiceSet::Arms(_) => Thing::Arm,
            ChoiceSet::Grasps(_) => Thing::Grasp,
            ChoiceSet::Supports(_) => Thing::Face,
            ChoiceSet::Stable(_) => Thing::Orientation,
            ChoiceSet::Points(_) | ChoiceSet::Centre(_) => Thing::Point,
            ChoiceSet::Angles => Thing::Angle,
            ChoiceSet::Stands { .. } => Thing::Stand,
        }
    }

    /// Says whether it may stand where `wanted` is asked; a parameter of any type may turn out to be an object.
    pub(super) fn fits(self, wanted: Thing) -> bool {
        match wanted {
            Thing::Entity => matches!(self, Thing::Agent | Thing::Object | Thing::Entity),
            Thing::Object => matches!(self, Thing::Object | Thing::Entity),
            Thing::Agent
            | Thing::Arm
            | Thing::Grasp
            | Thing::Face
            | Thing::Orientation
            | Thing::Point
            | Thing::Angle
            | Thing::Stand
            | Thing::Length => self == wanted,
        }
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Thing::Agent => "an agent",
            Thing::Object => "an object",
            Thing::Entity => "an entity",
            Thing::Arm => "an arm",
            Thing::Grasp => "a grasp",
            Thing::Face => "a support face",
            Thing::Orientation => "a stable orientation",
            Thing::Point => "a point of a face",
            Thing::Angle => "an angle",
            Thing::Stand => "a stand",
            Thing::Length => "a distance",
        }
    }

    /// Returns how it is often called.
    pub(super) fn example(self) -> &'static str {
        match self {
            Thing::Agent => "A",
            Thing::Object | Thing::Entity => "O",
            Thing::Arm => "hand",
            Thing::Grasp => "grasp",
            Thing::Face => "face",
            Thing::Orientation => "side",
            Thing::Point => "xy",
            Thing::Angle => "yaw",
            Thing::Stand => "stand",
            Thing::Length => "0.10",
        }
    }
}

/// An argument that fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Argument {
    Param(ParamId),
    Choice(ChoiceId),
    Number(f64),
}

const fn word(name: &'static str, args: &'static [Thing], n_required: usize) -> Word {
    Word { name, args, n_required }
}

/// Behind `in`.
pub(super) const CHOICES: &[Word] = &[
    word("arms", &[Thing::Agent], 1),
    word("grasps", &[Thing::Object], 1),
    word("supports", &[Thing::Object], 1),
    word("stable", &[Thing::Object], 1),
    word("points", &[Thing::Face], 1),
    word("centre", &[Thing::Face], 1),
    word("angles", &[], 0),
    word("stands", &[Thing::Agent, Thing::Entity], 2),
];

/// Behind `when`, beside facts.
pub(super) const CONDITIONS: &[Word] = &[
    word("free", &[Thing::Arm], 1),
    word("holds", &[Thing::Arm, Thing::Object], 2),
];

/// Behind `moving`.
pub(super) const SPACES: &[Word] = &[
    word("arm", &[Thing::Arm], 1),
    word("gripper", &[Thing::Arm], 1),
    word("body", &[Thing::Agent], 1),
    word("base", &[Thing::Agent], 1),
];

const PLACE: &[Thing] = &[
    Thing::Object,
    Thing::Face,
    Thing::Orientation,
    Thing::Point,
    Thing::Angle,
];
const ABOVE: &[Thing] = &[
    Thing::Object,
    Thing::Face,
    Thing::Orientation,
    Thing::Point,
    Thing::Angle,
    Thing::Length,
];

/// Behind `until`, beside facts.
pub(super) const TARGETS: &[Word] = &[
    word("open", &[Thing::Arm], 1),
    word("closed", &[Thing::Arm, Thing::Grasp], 1),
    word("before", &[Thing::Arm, Thing::Grasp, Thing::Length], 2),
    word("at", &[Thing::Arm, Thing::Grasp], 2),
    word("at", PLACE, 5),
    word("above", ABOVE, 5),
    word("up", &[Thing::Arm, Thing::Length], 1),
    word("back", &[Thing::Arm, Thing::Length], 1),
    word("posture", &[Thing::Agent], 1),
    word("at", &[Thing::Stand], 1),
];

/// Behind `then`.
pub(super) const CHANGES: &[Word] = &[
    word("attach", &[Thing::Object, Thing::Arm], 2),
    word("detach", &[Thing::Object, Thing::Arm], 2),
];

/// Returns where a word may stand.
pub(super) fn place_of(name: &str) -> Option<&'static str> {
    let tables: [(&[Word], &str); 5] = [
        (CHOICES, "set of choices"),
        (CONDITIONS, "pre-condition"),
        (SPACES, "search space"),
        (TARGETS, "final constraint"),
        (CHANGES, "change"),
    ];
    let mut found = tables.iter().filter(|(table, _)| table.iter().any(|w| w.name == name));
    found.next().map(|(_, what)| *what)
}
