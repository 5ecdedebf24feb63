//! A table of a TOML file read key by key: every wrong value becomes a problem at its place, and reading goes on.
//! Only a file that is not TOML ends at its first fault.
//!
//! Walks `toml`'s spanned tree by hand, because its serde door stops at the first fault.

use toml::de::{DeTable, DeValue};

use super::problems;
use crate::diag::{Problem, Problems};
use crate::source::{FileId, Span};

/// A table and what messages call it.
#[derive(Debug, Clone)]
pub struct Table<'a> {
    pub file: FileId,
    /// Where the table's name or value stands.
    pub span: Span,
    /// "object `CUBE`".
    pub place: String,
    table: &'a DeTable<'a>,
}

/// A value and where it stands.
#[derive(Debug, Clone, Copy)]
pub struct Value<'a> {
    pub span: Span,
    pub value: &'a DeValue<'a>,
}

/// A name and where it stands.
#[derive(Debug, Clone, Copy)]
pub struct Name<'a> {
    pub text: &'a str,
    pub span: Span,
}

/// Parses a file; the first syntax error becomes a problem, since what follows one is guesswork.
pub fn parse<'a>(text: &'a str, file: FileId, problems: &mut Problems) -> Option<DeTable<'a>> {
    let error = match DeTable::parse(text) {
        Ok(table) => return Some(table.into_inner()),
        Err(error) => error,
    };
    let mut range = error.span().unwrap_or(0..0);
    if range.is_empty() {
        // Something is missing here: best shown at the end of what stands before.
        let before = text.get(..range.start).unwrap_or_default().trim_end();
        range = before.len() - before.chars().next_back().map_or(0, char::len_utf8)..before.len();
    }
    let message = error.message().lines().next().unwrap_or_default();
    let help = if message.contains("duplicate") {
        "a key stands once in its table: rename or remove one"
    } else if message.contains("comma") || message.contains("unclosed") {
        "close the bracket that is open here, or add the comma"
    } else {
        "texts go in quotes, numbers and names of keys do not, lists are `[1, 2]`; see toml.io"
    };
    problems.push(
        Problem::error(
            "world::not-toml",
            format!("not TOML: {message}"),
            Span::new(file, range.start, range.end),
            "",
        )
        .help(help),
    );
    None
}

/// Returns what a message calls the type of a value.
fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "a truth value",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

impl<'a> Table<'a> {
    /// Returns the whole file as a table.
    pub fn root(table: &'a DeTable<'a>, file: FileId, place: &str) -> Self {
        Table {
            file,
            span: Span::new(file, 0, 0),
            place: place.to_string(),
            table,
        }
    }

    /// Returns its entries in the order of the file.
    pub fn entries(&self) -> impl Iterator<Item = (Name<'a>, Value<'a>)> + use<'a> {
        let file = self.file;
        self.table.iter().map(move |(k, v)| {
            (
                Name {
                    text: k.get_ref(),
                    span: Span::new(file, k.span().start, k.span().end),
                },
                Value {
                    span: Span::new(file, v.span().start, v.span().end),
                    value: v.get_ref(),
                },
            )
        })
    }

    /// Complains about every key that is not in `known`.
    pub fn only(&self, known: &[&str], problems: &mut Problems) {
        for (key, _) in self.entries() {
            if !known.contains(&key.text) {
                problems.push(problems::unknown_key(key.text, &self.place, known, key.span));
            }
        }
    }

    /// Returns the value of a key.
    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        self.entries().find(|(k, _)| k.text == key).map(|(_, v)| v)
    }

    /// Says whether there is such a key.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    fn what(&self, key: &str) -> String {
        format!("`{key}` of {}", self.place)
    }

    /// Returns a text and its place.
    pub fn text(&self, key: &str, problems: &mut Problems) -> Option<Name<'a>> {
        self.get(key)?.text(&self.what(key), problems)
    }

    /// Like [`Table::text`], for a key that must be there.
    pub fn needed_text(&self, key: &str, example: &str, problems: &mut Problems) -> Option<Name<'a>> {
        if !self.has(key) {
            problems.push(problems::missing_key(key, &self.place, example, self.span));
        }
        self.text(key, problems)
    }

    /// Returns a finite number and its place.
    pub fn number(&self, key: &str, problems: &mut Problems) -> Option<(f64, Span)> {
        let value = self.get(key)?;
        Some((value.number(&self.what(key), problems)?, value.span))
    }

    /// Like [`Table::number`], for a key that must be there.
    pub fn needed_number(&self, key: &str, example: &str, problems: &mut Problems) -> Option<(f64, Span)> {
        if !self.has(key) {
            problems.push(problems::missing_key(key, &self.place, example, self.span));
        }
        self.number(key, problems)
    }

    /// Returns a truth value.
    pub fn truth(&self, key: &str, problems: &mut Problems) -> Option<bool> {
        let value = self.get(key)?;
        match value.value {
            DeValue::Boolean(b) => Some(*b),
            other => {
                problems.push(problems::wrong_type(
                    &self.what(key),
                    "`true` or `false`",
                    kind(other),
                    value.span,
                ));
                None
            }
        }
    }

    /// Returns `N` finite numbers and their place.
    pub fn vector<const N: usize>(&self, key: &str, problems: &mut Problems) -> Option<([f64; N], Span)> {
        let value = self.get(key)?;
        Some((value.vector(&self.what(key), problems)?, value.span))
    }

    /// Returns a table within.
    pub fn table(&self, key: &str, place: &str, problems: &mut Problems) -> Option<Table<'a>> {
        let (name, value) = self.entries().find(|(k, _)| k.text == key)?;
        value.table(name.span, place, problems)
    }

    /// Returns the values of an array.
    pub fn array(&self, key: &str, problems: &mut Problems) -> Option<Vec<Value<'a>>> {
        self.get(key)?.array(self.file, &self.what(key), problems)
    }

    /// Returns the tables of a table of tables, each named by `kind` and its key.
    pub fn named_tables(&self, key: &str, kind: &str, problems: &mut Problems) -> Vec<(Name<'a>, Table<'a>)> {
        let Some(all) = self.table(key, &format!("`[{key}]`"), problems) else {
            return Vec::new();
        };
        all.entries()
            .filter_map(|(name, value)| {
                let place = format!("{kind} `{}`", name.text);
                Some((name, value.table(name.span, &place, problems)?))
            })
            .collect()
    }
}

impl<'a> Value<'a> {
    /// Returns the text, or complains that `what` must be one.
    pub fn text(&self, what: &str, problems: &mut Problems) -> Option<Name<'a>> {
        match self.value {
            DeValue::String(text) => Some(Name { text, span: self.span }),
            other => {
                problems.push(problems::wrong_type(what, "a text", kind(other), self.span));
                None
            }
        }
    }

    /// Returns the number if it is one and finite, or complains.
    pub fn number(&self, what: &str, problems: &mut Problems) -> Option<f64> {
        let number = match self.value {
            DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64),
            DeValue::Float(x) => x.as_str().parse::<f64>().ok(),
            other => {
                problems.push(problems::wrong_type(what, "a number", kind(other), self.span));
                return None;
            }
        };
        let finite = number.filter(|n| n.is_finite());
        if finite.is_none() {
            problems.push(problems::bad_value(
                format!("{what} is not a finite number"),
                self.span,
                "",
                "write a finite number",
            ));
        }
        finite
    }

    /// Returns `N` numbers, or complains.
    pub fn vector<const N: usize>(&self, what: &str, problems: &mut Problems) -> Option<[f64; N]> {
        let wanted = format!("an array of {N} numbers");
        let values = match self.value {
            DeValue::Array(values) if values.len() == N => values,
            DeValue::Array(values) => {
                let found = format!("an array of {}", values.len());
                problems.push(problems::wrong_type(what, &wanted, &found, self.span));
                return None;
            }
            other => {
                problems.push(problems::wrong_type(what, &wanted, kind(other), self.span));
                return None;
            }
        };
        let mut out = [0.0; N];
        let mut ok = true;
        for (slot, value) in out.iter_mut().zip(values.iter()) {
            let entry = Value {
                span: Span::new(self.span.file, value.span().start, value.span().end),
                value: value.get_ref(),
            };
            match entry.number(&format!("an entry of {what}"), problems) {
                Some(n) => *slot = n,
                None => ok = false,
            }
        }
        ok.then_some(out)
    }

    /// Returns the entries of an array, or complains.
    pub fn array(&self, file: FileId, what: &str, problems: &mut Problems) -> Option<Vec<Value<'a>>> {
        match self.value {
            DeValue::Array(values) => Some(
                values
                    .iter()
                    .map(|v| Value {
                        span: Span::new(file, v.span().start, v.span().end),
                        value: v.get_ref(),
                    })
                    .collect(),
            ),
            other => {
                problems.push(problems::wrong_type(what, "an array", kind(other), self.span));
                None
            }
        }
    }

    /// Returns the table, or complains; `span` is where messages about the whole table point.
    pub fn table(&self, span: Span, place: &str, problems: &mut Problems) -> Option<Table<'a>> {
        match self.value {
            DeValue::Table(table) => Some(Table {
                file: span.file,
                span,
                place: place.to_string(),
                table,
            }),
            other => {
                problems.push(problems::wrong_type(place, "a table", kind(other), self.span));
                None
            }
        }
    }
}
