//! What `[humans.ID]` says besides shape and place: mobility, availability, handedness, whether the human sits.
//!
//! Each key that is given is an initial value, too, of the attribute of that name, where the domain declares one.

use super::table::Table;
use super::{Arm, InitialValue, Literal, Manner, problems};
use crate::diag::Problems;
use crate::source::Span;

/// The keys that [`read`] understands.
pub const KEYS: [&str; 4] = ["mobility", "availability", "handedness", "sitting"];

/// Reads the keys of the human `id`, and what they say in symbols.
pub fn read(id: &str, table: &Table<'_>, arms: &[Arm], problems: &mut Problems) -> (Manner, Vec<InitialValue>) {
    let mut manner = Manner::default();
    let mut values = Vec::new();
    let mut say = |attribute: &str, value: Literal, span: Span| {
        values.push(InitialValue {
            entity: id.to_string(),
            attribute: attribute.to_string(),
            values: vec![value],
            is_list: false,
            is_implied: true,
            span,
        });
    };
    if let Some(is_sitting) = table.truth("sitting", problems) {
        manner.is_sitting = is_sitting;
        let span = table.get("sitting").map_or(table.span, |v| v.span);
        say("sitting", Literal::Bool(is_sitting), span);
    } else if let Some(posture) = table.text("posture", &mut Problems::default())
        && posture.text == "sitting"
    {
        manner.is_sitting = true;
        say("sitting", Literal::Bool(true), posture.span);
    }
    for (key, slot) in [
        ("mobility", &mut manner.mobility),
        ("availability", &mut manner.availability),
    ] {
        let Some((value, span)) = table.number(key, problems) else {
            continue;
        };
        if (0.0..=1.0).contains(&value) {
            *slot = value;
            say(key, Literal::Number(value), span);
        } else {
            let message = format!("`{key}` of {} is {value}", table.place);
            let help = if value > 1.0 && value <= 100.0 {
                format!("it goes from 0 to 1: {value} percent are {}", value / 100.0)
            } else {
                "it goes from 0, not at all, to 1".to_string()
            };
            problems.push(problems::bad_value(message, span, "not within 0 to 1", help));
        }
    }
    if let Some(side) = table.text("handedness", problems) {
        manner.handedness = arms.iter().position(|arm| arm.name == side.text);
        if manner.handedness.is_some() {
            say("handedness", Literal::Text(side.text.to_string()), side.span);
        } else {
            let known = arms.iter().map(|arm| arm.name.as_str());
            problems.push(problems::unknown_name(
                "world::unknown-arm",
                "arm",
                side.text,
                &format!("`handedness` of {}", table.place),
                known,
                side.span,
            ));
        }
    }
    (manner, values)
}
