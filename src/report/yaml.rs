//! The little of YAML 1.2 that messages need.

/// Returns the text in double quotes: a JSON string is one of YAML, too.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
