//! Problems for programs: one JSON object on each line. `docs/json.md` has the keys.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::{Label, Problems, Severity};
use crate::source::{FileId, Lines, Sources, Span};

/// Returns one object and a line end for each problem, in the order of `problems`.
pub fn lines(problems: &Problems, sources: &Sources) -> String {
    let mut out = String::new();
    let mut places = BTreeMap::new();
    for problem in &problems.0 {
        let mut object = Map::new();
        object.insert("code".into(), json!(problem.code));
        object.insert("severity".into(), json!(word(problem.severity)));
        object.insert("message".into(), json!(problem.message));
        if let Some(label) = &problem.primary {
            place(&mut object, label, sources, &mut places);
        }
        if let Some(help) = &problem.help {
            object.insert("help".into(), json!(help));
        }
        let mut note = |label: &Label| {
            let mut object = Map::new();
            place(&mut object, label, sources, &mut places);
            Value::Object(object)
        };
        let notes: Vec<Value> = problem.notes.iter().map(&mut note).collect();
        object.insert("notes".into(), Value::Array(notes));
        out += &Value::Object(object).to_string();
        out.push('\n');
    }
    out
}

/// Returns the word for it, the same in every form of output.
pub(super) fn word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

/// Adds file, first and last place, bytes and words of a label.
fn place(object: &mut Map<String, Value>, label: &Label, sources: &Sources, places: &mut BTreeMap<FileId, Lines>) {
    let Span { file, start, end } = label.span;
    let (id, file) = (file, sources.get(file));
    let lines = places.entry(id).or_insert_with(|| Lines::new(&file.text));
    let (line, column) = lines.line_column(&file.text, start as usize);
    let (end_line, end_column) = lines.line_column(&file.text, end as usize);
    object.insert("file".into(), json!(file.path));
    object.insert("line".into(), json!(line));
    object.insert("column".into(), json!(column));
    object.insert("end".into(), json!({"line": end_line, "column": end_column}));
    object.insert("bytes".into(), json!([start, end]));
    if !label.text.is_empty() {
        object.insert("label".into(), json!(label.text));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Problem;

    #[test]
    fn a_problem_is_one_line() {
        let mut sources = Sources::default();
        let file = sources.add("a.hatp", "é = 1;\nB = 2;\n");
        let problem = Problem::error("hatp::x", "wrong `B`", Span::new(file, 8, 9), "here")
            .note(Span::new(file, 0, 2), "")
            .help("do\nbetter");
        let problems = Problems(vec![problem, Problem::unplaced("hatp::y", "no file")]);
        assert_eq!(
            lines(&problems, &sources),
            concat!(
                r#"{"code":"hatp::x","severity":"error","message":"wrong `B`","file":"a.hatp","line":2,"column":1,"#,
                r#""end":{"line":2,"column":2},"bytes":[8,9],"label":"here","help":"do\nbetter","#,
                r#""notes":[{"file":"a.hatp","line":1,"column":1,"end":{"line":1,"column":2},"bytes":[0,2]}]}"#,
                "\n",
                r#"{"code":"hatp::y","severity":"error","message":"no file","notes":[]}"#,
                "\n"
            )
        );
    }
}
