//! What the thesis ran, and what came out there.

use super::Name;
use super::measure::Thesis;

/// A table of the thesis.
pub(super) struct Table {
    pub name: Name,
    pub title: &'static str,
    /// As many as the thesis made.
    pub runs: u32,
    pub experiments: &'static [Experiment],
}

/// A row.
pub(super) struct Experiment {
    pub label: &'static str,
    /// Of [`FILES`].
    pub domain: &'static str,
    pub world: &'static str,
    /// Instead of the world's.
    pub task: Option<&'static str>,
    pub branching: u32,
    pub thesis: Option<Thesis>,
}

macro_rules! files {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_str!(concat!("../../../", $path)))),*]
    };
}

/// The files that experiments read, as they lie in this project.
pub(super) const FILES: [(&str, &str); 11] = files![
    "domains/three_objects.hatp",
    "worlds/three_objects.toml",
    "domains/constraints_common.hatp",
    "domains/constraints_place.hatp",
    "domains/constraints_placer.hatp",
    "domains/constraints_placerc.hatp",
    "worlds/constraints.toml",
    "worlds/models/pr2.toml",
    "worlds/models/pr2.urdf",
    "worlds/models/human.toml",
    "worlds/models/human.urdf",
];

const NOT_GIVEN: Thesis = Thesis {
    time: None,
    time_deviation: None,
    success: None,
    alternatives: None,
    computed: None,
    actions: None,
};

/// A column of the thesis's Table 4.3; the plan has 6 actions.
const fn table_4_3(time: f64, success: f64, alternatives: f64, computed: f64) -> Option<Thesis> {
    Some(Thesis {
        time: Some(time),
        success: Some(success),
        alternatives: Some(alternatives),
        computed: Some(computed),
        actions: Some(6.0),
        ..NOT_GIVEN
    })
}

const fn three_objects(label: &'static str, branching: u32, thesis: Option<Thesis>) -> Experiment {
    Experiment {
        label,
        domain: "domains/three_objects.hatp",
        world: "worlds/three_objects.toml",
        task: None,
        branching,
        thesis,
    }
}

const fn constraints(label: &'static str, domain: &'static str) -> Experiment {
    Experiment {
        label,
        domain,
        world: "worlds/constraints.toml",
        task: None,
        branching: 3,
        thesis: None,
    }
}

/// In the order of the thesis.
pub(super) const TABLES: &[Table] = &[
    Table {
        name: Name::T4_3,
        title: "Table 4.3: three objects within a human's reach, by branching factor",
        runs: 30,
        experiments: &[
            three_objects("1", 1, table_4_3(5.0, 10.0, 0.0, 5.6)),
            three_objects("2", 2, table_4_3(19.0, 80.0, 9.4, 31.6)),
            three_objects("3", 3, table_4_3(19.0, 100.0, 14.5, 41.0)),
            three_objects("4", 4, table_4_3(27.0, 100.0, 24.7, 62.8)),
            three_objects("5", 5, table_4_3(31.0, 96.6, 32.7, 78.7)),
            three_objects("6", 6, table_4_3(31.0, 100.0, 36.6, 85.8)),
        ],
    },
    Table {
        name: Name::T4_4_2,
        title: "4.4.2: three ways to put objects down so that all stay within reach",
        runs: 30,
        experiments: &[
            constraints("Place", "domains/constraints_place.hatp"),
            constraints("PlaceR", "domains/constraints_placer.hatp"),
            constraints("PlaceRC", "domains/constraints_placerc.hatp"),
        ],
    },
];
