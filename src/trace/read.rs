//! Goes through a trace line by line. A line that was cut short at the end of the file is no fault: the search was ended.

use std::fmt;
use std::io::{BufRead, Read};

use super::record::{FORMAT, Header, Record, VERSION};
use super::summary::{Builder, Summary};

/// Why a file is no trace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// From 1; 0 where the file could not be read at all.
    pub line: u64,
    pub what: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => f.write_str(&self.what),
            line => write!(f, "line {line}: {}", self.what),
        }
    }
}

/// No line of a trace is longer [bytes]; what has longer ones is something else.
const LONGEST: u64 = 16 << 20;

/// Reads a trace. With `task`, only what is in tasks of that name is counted; with arguments, `Pick(PR2, CUP)`, only in those.
///
/// # Errors
///
/// The first line that is none of a trace of this version.
pub fn read(mut input: impl BufRead, task: Option<&str>) -> Result<Summary, Fault> {
    let mut line = Vec::new();
    let mut number = 0;
    let mut next = |line: &mut Vec<u8>, number: &mut u64| -> Result<bool, Fault> {
        line.clear();
        *number += 1;
        let fault = |what| Fault { line: *number, what };
        let n = input.by_ref().take(LONGEST).read_until(b'\n', line);
        let n = n.map_err(|e| fault(format!("can't be read: {e}")))?;
        if n as u64 == LONGEST {
            return Err(fault("is longer than any line of a trace".into()));
        }
        Ok(n > 0)
    };
    if !next(&mut line, &mut number)? {
        let what = "it is empty".into();
        return Err(Fault { line: 0, what });
    }
    let header = header(&line).map_err(|what| Fault { line: 1, what })?;
    let mut builder = Builder::new(header, task);
    while next(&mut line, &mut number)? {
        let fault = |what| Fault { line: number, what };
        match serde_json::from_slice::<Record<'_>>(&line) {
            Ok(record) => builder.add(&record).map_err(fault)?,
            Err(_) if !line.ends_with(b"\n") => {
                builder.cut();
                break;
            }
            Err(e) => return Err(fault(format!("is no event of a trace: {}", without_place(&e)))),
        }
    }
    Ok(builder.finish(number - 1))
}

/// Reads the first line; says what it is if it is not one.
fn header(line: &[u8]) -> Result<Header, String> {
    let none = || "is not the first line of a trace, as `sgap plan --trace FILE` writes it".to_owned();
    let value: serde_json::Value = serde_json::from_slice(line).map_err(|_| none())?;
    match value.get("format").and_then(|f| f.as_str()) {
        Some(FORMAT) => {}
        Some(other) => return Err(format!("its `format` is `{other}`, not `{FORMAT}`")),
        None => return Err(none()),
    }
    match value.get("version").and_then(serde_json::Value::as_u64) {
        Some(v) if v == u64::from(VERSION) => {}
        Some(v) => {
            let which = if v > u64::from(VERSION) { "a newer" } else { "an older" };
            return Err(format!(
                "was written by {which} program: its version is {v}, and this one reads version {VERSION}"
            ));
        }
        None => return Err("has no `version`".into()),
    }
    serde_json::from_value(value).map_err(|e| without_place(&e))
}

/// Returns the message of an error; the place within the line is of no use beside the line's number.
fn without_place(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(at) => text[..at].to_owned(),
        None => text,
    }
}
