//! Plan documents to JSON and back. The form is described in `docs/json.md`.

use crate::plan::{Plan, VERSION};

/// Returns the document as JSON, indented, with a newline at its end; long rows of numbers stay on one line.
///
/// Numbers are rounded to nine digits after the point: far below any tolerance.
pub fn write(plan: &Plan) -> Result<String, serde_json::Error> {
    let mut value = serde_json::to_value(plan)?;
    round(&mut value);
    let mut text = String::new();
    indent(&value, 0, &mut text);
    text.push('\n');
    Ok(text)
}

/// Returns several documents as a JSON array, each as [`write`] has it.
pub fn write_all(plans: &[Plan]) -> Result<String, serde_json::Error> {
    let texts: Result<Vec<String>, serde_json::Error> = plans.iter().map(write).collect();
    let texts: Vec<String> = texts?.iter().map(|t| t.trim_end().to_owned()).collect();
    Ok(format!("[\n{}\n]\n", texts.join(",\n")))
}

/// Reads a document; the error is a sentence with line and column.
pub fn read(text: &str) -> Result<Plan, String> {
    if text.trim().is_empty() {
        return Err("it is empty".into());
    }
    let value: serde_json::Value = serde_json::from_str(text).map_err(|e| format!("not JSON: {e}"))?;
    match value.get("format").and_then(|f| f.as_str()) {
        Some("sgap-plan") => {}
        Some(other) => return Err(format!("its `format` is `{other}`, not `sgap-plan`")),
        None => return Err("it has no `format`: not a plan of `sgap plan --json`".into()),
    }
    match value.get("version").and_then(serde_json::Value::as_u64) {
        Some(v) if v == u64::from(VERSION) => {}
        Some(v) => return Err(format!("its version is {v}; this program reads version {VERSION}")),
        None => return Err("it has no `version`".into()),
    }
    serde_json::from_str(text).map_err(|e| e.to_string())
}

/// Digits after the point.
const DIGITS: f64 = 1e9;

fn round(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Number(n) => {
            if let Some(x) = n.as_f64().filter(|_| n.is_f64()) {
                // Adding 0 turns a negative zero into a zero.
                let rounded = (x * DIGITS).round() / DIGITS + 0.0;
                if let Some(n) = serde_json::Number::from_f64(rounded) {
                    *value = serde_json::Value::Number(n);
                }
            }
        }
        serde_json::Value::Array(all) => all.iter_mut().for_each(round),
        serde_json::Value::Object(all) => all.values_mut().for_each(round),
        serde_json::Value::Null | serde_json::Value::Bool(_) | serde_json::Value::String(_) => {}
    }
}

/// Writes a value; arrays without arrays or objects in them stay on one line.
fn indent(value: &serde_json::Value, depth: usize, out: &mut String) {
    let pad = |out: &mut String, depth: usize| {
        out.push('\n');
        out.extend(std::iter::repeat_n("  ", depth));
    };
    match value {
        serde_json::Value::Array(all) if all.iter().any(|v| v.is_array() || v.is_object()) => {
            out.push('[');
            for (i, v) in all.iter().enumerate() {
                out.push_str(if i > 0 { "," } else { "" });
                pad(out, depth + 1);
                indent(v, depth + 1, out);
            }
            pad(out, depth);
            out.push(']');
        }
        serde_json::Value::Object(all) if !all.is_empty() => {
            out.push('{');
            for (i, (key, v)) in all.iter().enumerate() {
                out.push_str(if i > 0 { "," } else { "" });
                pad(out, depth + 1);
                out.push_str(&serde_json::Value::String(key.clone()).to_string());
                out.push_str(": ");
                indent(v, depth + 1, out);
            }
            pad(out, depth);
            out.push('}');
        }
        other => out.push_str(&other.to_string()),
    }
}
