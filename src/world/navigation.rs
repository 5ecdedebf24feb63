//! What files say about going: `[navigation]` of a model file, `[human_aware]` of a world file.

use std::f64::consts::TAU;

use super::problems;
use super::table::Table;
use crate::diag::Problems;
use crate::geom::navigation::{comfort::Weights, timing::Limits};

/// Reads how fast a base can go; what is not given is that of a careful robot.
pub fn limits(root: &Table<'_>, problems: &mut Problems) -> Limits {
    let mut limits = Limits::default();
    let Some(table) = root.table("navigation", "`[navigation]`", problems) else {
        return limits;
    };
    table.only(&["speed", "turn_rate", "acceleration", "turn_acceleration"], problems);
    for (key, slot, most) in [
        ("speed", &mut limits.speed, 100.0),
        ("turn_rate", &mut limits.turn_rate, 100.0),
        ("acceleration", &mut limits.acceleration, 1000.0),
        ("turn_acceleration", &mut limits.turn_acceleration, 1000.0),
    ] {
        if let Some(value) = between(&table, key, (0.0, most), false, problems) {
            *slot = value;
        }
    }
    limits
}

/// Reads what people mind; what is not given has its default.
pub fn human_aware(root: &Table<'_>, problems: &mut Problems) -> Weights {
    let mut weights = Weights::default();
    let Some(table) = root.table("human_aware", "`[human_aware]`", problems) else {
        return weights;
    };
    let keys = [
        "length",
        "distance",
        "visibility",
        "hidden",
        "standing",
        "sitting",
        "field_of_view",
    ];
    table.only(&keys, problems);
    for (key, slot, most, may_be_zero) in [
        ("length", &mut weights.length, 1e6, false),
        ("distance", &mut weights.distance, 1e6, true),
        ("visibility", &mut weights.visibility, 1e6, true),
        ("hidden", &mut weights.hidden, 1e6, true),
        ("standing", &mut weights.standing, 50.0, false),
        ("sitting", &mut weights.sitting, 50.0, false),
        ("field_of_view", &mut weights.field_of_view, TAU, false),
    ] {
        if let Some(value) = between(&table, key, (0.0, most), may_be_zero, problems) {
            *slot = value;
        }
    }
    weights
}

/// Returns the number of a key, if it is between two numbers.
fn between(
    table: &Table<'_>,
    key: &str,
    (least, most): (f64, f64),
    may_be_least: bool,
    problems: &mut Problems,
) -> Option<f64> {
    let (value, span) = table.number(key, problems)?;
    let is_above = value > least || (may_be_least && value == least);
    if is_above && value <= most {
        return Some(value);
    }
    let message = format!("`{key}` of {} is {value}", table.place);
    let from = if may_be_least { "from" } else { "above" };
    let help = format!("write a number {from} {least}, up to {most:.4}");
    problems.push(problems::bad_value(message, span, "", help));
    None
}
