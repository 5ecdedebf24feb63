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
pub(super) const FILES: [(&str, &str); 18] = files![
    "domains/three_objects.hatp",
    "worlds/three_objects.toml",
    "domains/constraints_common.hatp",
    "domains/constraints_place.hatp",
    "domains/constraints_placer.hatp",
    "domains/constraints_placerc.hatp",
    "worlds/constraints.toml",
    "domains/virtual_place_common.hatp",
    "domains/virtual_place.hatp",
    "domains/virtual_place_without.hatp",
    "worlds/virtual_place_a.toml",
    "worlds/virtual_place_b.toml",
    "worlds/virtual_place_c.toml",
    "worlds/virtual_place_d.toml",
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

const WITH: &str = "domains/virtual_place.hatp";
const WITHOUT: &str = "domains/virtual_place_without.hatp";

const fn virtual_place(
    label: &'static str,
    domain: &'static str,
    world: &'static str,
    thesis: Option<Thesis>,
) -> Experiment {
    Experiment {
        label,
        domain,
        world,
        task: None,
        branching: 3,
        thesis,
    }
}

/// A column of the thesis's Table 4.4.
const fn table_4_4(time: f64, deviation: f64, alternatives: f64, computed: f64, actions: f64) -> Option<Thesis> {
    Some(Thesis {
        time: Some(time),
        time_deviation: Some(deviation),
        alternatives: Some(alternatives),
        computed: Some(computed),
        actions: Some(actions),
        ..NOT_GIVEN
    })
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
        name: Name::T4_4,
        title: "Table 4.4: a cluttered table, without the request virtualPlace and with it (Fig. 4.7 a to d)",
        runs: 30,
        experiments: &[
            virtual_place(
                "a without",
                WITHOUT,
                "worlds/virtual_place_a.toml",
                table_4_4(191.2, 8.6, 62.9, 162.6, 8.0),
            ),
            virtual_place(
                "a with",
                WITH,
                "worlds/virtual_place_a.toml",
                table_4_4(21.7, 1.45, 0.3, 12.6, 8.0),
            ),
            virtual_place(
                "b without",
                WITHOUT,
                "worlds/virtual_place_b.toml",
                table_4_4(16.9, 1.64, 0.2, 6.4, 6.0),
            ),
            virtual_place(
                "b with",
                WITH,
                "worlds/virtual_place_b.toml",
                table_4_4(20.2, 1.34, 0.2, 8.6, 8.0),
            ),
            virtual_place("c without", WITHOUT, "worlds/virtual_place_c.toml", None),
            virtual_place("c with", WITH, "worlds/virtual_place_c.toml", None),
            virtual_place("d without", WITHOUT, "worlds/virtual_place_d.toml", None),
            virtual_place("d with", WITH, "worlds/virtual_place_d.toml", None),
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
