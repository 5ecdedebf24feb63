//! `[facts]` and `[state]`: which fact an attribute is read from, and what symbols are at the start.

use toml::de::DeValue;

use super::problems;
use super::table::{Name, Table, Value};
use super::{InitialValue, Literal};
use crate::diag::{Problem, Problems};
use crate::source::Span;

/// The facts that the geometry of a state gives.
pub const FACTS: [&str; 8] = [
    "isOn",
    "isIn",
    "isNextTo",
    "isBigger",
    "isSmaller",
    "hasInHand",
    "isReachable",
    "isVisible",
];

/// Reads `[facts]`: `"Type.attribute" = "isOn"`, or `attribute = "isOn"`.
pub fn facts(root: &Table<'_>, problems: &mut Problems) -> Vec<(String, String, Span)> {
    let Some(table) = root.table("facts", "`[facts]`", problems) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (attribute, key, value) in dotted(&table) {
        let Some(fact) = value.text(&format!("`{attribute}` of `[facts]`"), problems) else {
            continue;
        };
        if FACTS.contains(&fact.text) {
            found.push((attribute, fact.text.to_string(), key.span));
        } else {
            problems.push(problems::unknown_name(
                "world::unknown-fact",
                "fact",
                fact.text,
                "`[facts]`",
                FACTS,
                fact.span,
            ));
        }
    }
    found
}

/// Reads `[state]`: `"PR2.type" = "ROBOT"`, or `PR2.type = "ROBOT"`, or a table for each entity.
pub fn state(root: &Table<'_>, problems: &mut Problems) -> Vec<InitialValue> {
    let Some(table) = root.table("state", "`[state]`", problems) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (path, key, value) in dotted(&table) {
        let Some((entity, attribute)) = path.split_once('.') else {
            problems.push(
                Problem::error(
                    "world::bad-value",
                    format!("`{path}` of `[state]` names no attribute of an entity"),
                    key.span,
                    "",
                )
                .help("write `\"PR2.type\" = \"ROBOT\"`, or `PR2.type = \"ROBOT\"`"),
            );
            continue;
        };
        let is_list = matches!(value.value, DeValue::Array(_));
        let entries = if is_list {
            value
                .array(root.file, "a value of `[state]`", problems)
                .unwrap_or_default()
        } else {
            vec![value]
        };
        let values = entries.iter().filter_map(|v| literal(v, &path, problems)).collect();
        found.push(InitialValue {
            entity: entity.to_string(),
            attribute: attribute.to_string(),
            values,
            is_list,
            is_implied: false,
            span: Span::new(root.file, key.span.range().start, value.span.range().end),
        });
    }
    found
}

/// Returns the entries of a table, those of tables within it as `outer.inner`.
fn dotted<'a>(table: &Table<'a>) -> Vec<(String, Name<'a>, Value<'a>)> {
    let mut found = Vec::new();
    for (outer, value) in table.entries() {
        match value.value {
            DeValue::Table(_) => {
                let inner = value.table(outer.span, outer.text, &mut Problems::default());
                for (name, value) in inner.iter().flat_map(Table::entries) {
                    found.push((format!("{}.{}", outer.text, name.text), name, value));
                }
            }
            _ => found.push((outer.text.to_string(), outer, value)),
        }
    }
    found
}

fn literal(value: &Value<'_>, path: &str, problems: &mut Problems) -> Option<Literal> {
    match value.value {
        DeValue::Boolean(b) => Some(Literal::Bool(*b)),
        DeValue::String(text) => Some(Literal::Text(text.to_string())),
        DeValue::Integer(_) | DeValue::Float(_) => value.number(&format!("`{path}`"), problems).map(Literal::Number),
        DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => {
            let wanted = "a text, a number, a truth value, or an array of these";
            problems.push(problems::wrong_type(
                &format!("`{path}`"),
                wanted,
                "something else",
                value.span,
            ));
            None
        }
    }
}
