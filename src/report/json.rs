//! Plan documents to JSON and back. The form is described in `docs/json.md`.

use std::io::{self, Write};

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::ser::{CompactFormatter, Formatter, Serializer};

use crate::plan::{Plan, VERSION};

/// Writes the document as JSON, indented, with a newline at its end; a list whose first member is a number or a text stays
/// on one line. Nothing is held back: the text of a long plan is larger than the plan.
///
/// Numbers are rounded to nine digits after the point: far below any tolerance.
///
/// # Errors
/// Those of `out`.
pub fn write_to(plan: &Plan, out: &mut dyn Write) -> io::Result<()> {
    write_object(plan, out)?;
    out.write_all(b"\n")
}

/// Writes several documents as a JSON array, each as [`write_to`] has it.
///
/// # Errors
/// Those of `out`.
pub fn write_all_to(plans: &[Plan], out: &mut dyn Write) -> io::Result<()> {
    out.write_all(b"[\n")?;
    for (i, plan) in plans.iter().enumerate() {
        if i > 0 {
            out.write_all(b",\n")?;
        }
        write_object(plan, out)?;
    }
    out.write_all(b"\n]\n")
}

fn write_object(plan: &Plan, out: &mut dyn Write) -> io::Result<()> {
    let layout = Layout {
        depth: 0,
        lists: Vec::new(),
    };
    plan.serialize(&mut Serializer::with_formatter(out, layout))?;
    Ok(())
}

/// Returns what [`write_to`] writes.
///
/// # Errors
/// None that a plan could cause.
pub fn write(plan: &Plan) -> io::Result<String> {
    let mut text = Vec::new();
    write_to(plan, &mut text)?;
    String::from_utf8(text).map_err(io::Error::other)
}

/// Reads a document; the error is a sentence with line and column.
pub fn read(text: &str) -> Result<Plan, String> {
    if text.trim().is_empty() {
        return Err("it is empty".into());
    }
    let is_object = text.trim_start().starts_with('{');
    let head = match is_object {
        true => serde_json::from_str(text),
        false => serde_json::from_str::<IgnoredAny>(text).map(|_| Head::default()),
    };
    let head: Head = head.map_err(|e| format!("not JSON: {e}"))?;
    match head.format.as_ref().and_then(|f| f.as_str()) {
        Some("sgap-plan") => {}
        Some(other) => return Err(format!("its `format` is `{other}`, not `sgap-plan`")),
        None => return Err("it has no `format`: not a plan of `sgap plan --json`".into()),
    }
    match head.version.as_ref().and_then(serde_json::Value::as_u64) {
        Some(v) if v == u64::from(VERSION) => {}
        Some(v) => return Err(format!("its version is {v}; this program reads version {VERSION}")),
        None => return Err("it has no `version`".into()),
    }
    serde_json::from_str(text).map_err(|e| e.to_string())
}

/// What tells a plan from other JSON; the rest is skipped.
#[derive(Default, Deserialize)]
struct Head {
    format: Option<serde_json::Value>,
    version: Option<serde_json::Value>,
}

/// Digits after the point.
const DIGITS: f64 = 1e9;

/// Line breaks and rounding.
struct Layout {
    depth: usize,
    /// Of each list that is open, whether its members have lines of their own; `None` until the first one has come.
    lists: Vec<Option<bool>>,
}

impl Layout {
    fn new_line<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        const PADS: &[u8] = b"\n                                                                ";
        let width = 2 * self.depth;
        if width < PADS.len() {
            return out.write_all(&PADS[..=width]);
        }
        out.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| out.write_all(b"  "))
    }

    /// A list or an object begins: the first in a list gives each member of that list a line.
    fn open<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if let Some(has_lines @ None) = self.lists.last_mut() {
            *has_lines = Some(true);
            self.depth += 1;
            self.new_line(out)?;
        }
        Ok(())
    }
}

impl Formatter for Layout {
    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, x: f64) -> io::Result<()> {
        // Adding 0 turns a negative zero into a zero.
        let rounded = (x * DIGITS).round() / DIGITS + 0.0;
        if rounded.is_finite() {
            CompactFormatter.write_f64(out, rounded)
        } else {
            CompactFormatter.write_f64(out, x)
        }
    }

    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out)?;
        self.lists.push(None);
        out.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.lists.pop() == Some(Some(true)) {
            self.depth -= 1;
            self.new_line(out)?;
        }
        out.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if first {
            return Ok(());
        }
        out.write_all(b",")?;
        match self.lists.last_mut() {
            Some(Some(true)) => self.new_line(out),
            Some(has_lines @ None) => {
                *has_lines = Some(false);
                Ok(())
            }
            Some(Some(false)) | None => Ok(()),
        }
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out)?;
        // Inside, a list of a member is no list of ours.
        self.lists.push(Some(false));
        self.depth += 1;
        out.write_all(b"{")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if let Some(has_members) = self.lists.last_mut() {
            *has_members = Some(true);
        }
        out.write_all(if first { b"" } else { b"," })?;
        self.new_line(out)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if self.lists.pop() == Some(Some(true)) {
            self.new_line(out)?;
        }
        out.write_all(b"}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// What stands on a line of its own depends on the first member of a list alone.
    #[test]
    fn lists_of_numbers_stay_on_a_line_and_lists_of_lists_do_not() {
        let value = json!({
            "none": [], "numbers": [1, 2.5, "x"], "rows": [[1], [], [2, 3]],
            "objects": [{"a": {}}, {"b": [true]}], "mixed": ["x", 1, null],
        });
        let mut text = Vec::new();
        let layout = Layout {
            depth: 0,
            lists: Vec::new(),
        };
        let written = value.serialize(&mut Serializer::with_formatter(&mut text, layout));
        assert!(written.is_ok());
        let expected = [
            "{",
            r#"  "none": [],"#,
            r#"  "numbers": [1,2.5,"x"],"#,
            r#"  "rows": ["#,
            "    [1],",
            "    [],",
            "    [2,3]",
            "  ],",
            r#"  "objects": ["#,
            "    {",
            r#"      "a": {}"#,
            "    },",
            "    {",
            r#"      "b": [true]"#,
            "    }",
            "  ],",
            r#"  "mixed": ["x",1,null]"#,
            "}",
        ];
        let text = String::from_utf8_lossy(&text);
        assert_eq!(text.lines().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn numbers_are_rounded_and_no_zero_is_negative() {
        for (x, expected) in [(0.1 + 0.2, "0.3"), (-1e-12, "0.0"), (2.0, "2.0"), (1e300, "1e+300")] {
            let mut text = Vec::new();
            let layout = Layout {
                depth: 0,
                lists: Vec::new(),
            };
            let written = x.serialize(&mut Serializer::with_formatter(&mut text, layout));
            assert!(written.is_ok());
            assert_eq!(String::from_utf8_lossy(&text), expected);
        }
    }
}
