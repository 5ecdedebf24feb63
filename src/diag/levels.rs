//! Which warnings are given, and which count as errors: by what the user asked for and by comments in the files.
//!
//! `// sgap: allow(unused-variable)` keeps a warning quiet on its line, or on the next one if it stands alone;
//! `// sgap: allow-file(unused-variable)` at the top of a file in all of it. In a `.toml` file the comment begins with `#`.
//! Errors can't be silenced. A comment inside `/* */` counts, too: nothing here knows the language.

use super::pages::{self, PAGES, Page};
use super::suggest::did_you_mean;
use super::{Problem, Problems, Severity};
use crate::source::{FileId, Sources, Span};

/// What becomes of a warning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    Allow,
    Warn,
    /// It counts as an error.
    Deny,
}

/// What the user asks for, by code; of several the narrower wins, then the milder, then what a file says.
#[derive(Debug, Clone, Default)]
pub struct Levels {
    /// Codes and their levels.
    pub of: Vec<(String, Level)>,
    /// Whether every other warning counts as an error.
    pub deny_all: bool,
}

/// Returns the codes of the warnings that a user may mean by `name`, or what to write instead.
pub fn warnings_called(name: &str) -> Result<Vec<String>, String> {
    let found: Vec<&Page> = pages::called(name).collect();
    let warnings: Vec<String> = found
        .iter()
        .filter(|p| p.warning().is_some())
        .map(|p| p.code())
        .collect();
    if !warnings.is_empty() {
        return Ok(warnings);
    }
    if !found.is_empty() {
        return Err("it is an error, and only warnings can be turned on and off".into());
    }
    let all = PAGES.iter().filter(|p| p.warning().is_some());
    let names: Vec<&str> = all.filter_map(|p| p.name.split_once('-')).map(|(_, n)| n).collect();
    let short = name.rsplit_once("::").map_or(name, |(_, short)| short);
    Err(did_you_mean(short, names.iter().copied()).unwrap_or_else(|| format!("there are `{}`", names.join("`, `"))))
}

impl Levels {
    fn level(&self, code: &str) -> Level {
        let asked = self.of.iter().filter(|(of, _)| of == code).map(|(_, level)| *level);
        let mildest = asked.min_by_key(|level| *level as u8);
        let given = || match pages::called(code).find_map(Page::warning) {
            Some(Level::Allow) => Level::Allow,
            _ if self.deny_all => Level::Deny,
            other => other.unwrap_or(Level::Warn),
        };
        mildest.unwrap_or_else(given)
    }

    /// Returns the problems without the warnings that nobody wants, and those that are denied as errors.
    ///
    /// Comments that ask for what is not there are warnings of their own. Sorted.
    pub fn apply(&self, problems: Problems, sources: &Sources) -> Problems {
        let mut out = Problems::default();
        let files: Vec<(FileId, Allowed)> = sources
            .ids()
            .map(|file| (file, allowed(file, sources, &mut out)))
            .collect();
        out.extend(problems);
        let is_allowed = |problem: &Problem| {
            let place = problem.primary.as_ref().map(|l| l.span);
            place.is_some_and(|span| {
                let text = &sources.get(span.file).text;
                let line = line_of(text, span.start as usize);
                let of = files.iter().find(|(file, _)| *file == span.file);
                of.is_some_and(|(_, allowed)| allowed.has(problem.code, line))
            })
        };
        out.0.retain_mut(|problem| {
            if problem.severity == Severity::Error {
                return true;
            }
            let level = self.level(problem.code);
            if level == Level::Deny {
                problem.severity = Severity::Error;
            }
            level != Level::Allow && !is_allowed(problem)
        });
        out.sorted()
    }
}

/// What a file's comments allow.
#[derive(Debug, Default)]
struct Allowed {
    everywhere: Vec<String>,
    /// Lines from 0, and codes.
    at: Vec<(usize, String)>,
}

impl Allowed {
    fn has(&self, code: &str, line: usize) -> bool {
        let here = self.at.iter().any(|(at, of)| *at == line && of == code);
        here || self.everywhere.iter().any(|of| of == code)
    }
}

/// Returns the line of a byte, from 0.
fn line_of(text: &str, at: usize) -> usize {
    let before = text.as_bytes().get(..at.min(text.len())).unwrap_or_default();
    before.iter().filter(|b| **b == b'\n').count()
}

/// Reads the comments of a file.
fn allowed(file: FileId, sources: &Sources, problems: &mut Problems) -> Allowed {
    let source = sources.get(file);
    let mark = if source.path.ends_with(".toml") { "#" } else { "//" };
    let mut out = Allowed::default();
    // Codes of comments that stand alone, waiting for the line that they are about.
    let mut waiting: Vec<String> = Vec::new();
    let (mut start, mut is_top) = (0, true);
    for (number, line) in source.text.split_inclusive('\n').enumerate() {
        let (code, comment) = split(line, mark);
        let is_alone = code.trim_start_matches('\u{FEFF}').trim().is_empty();
        is_top &= is_alone;
        if !is_alone {
            out.at.extend(waiting.drain(..).map(|c| (number, c)));
        }
        if let Some(asked) = comment.and_then(instruction) {
            let place = |part: &str| {
                // `part` is a piece of `line`.
                let from = start + (part.as_ptr() as usize - line.as_ptr() as usize);
                Span::new(file, from, from + part.len())
            };
            match asked {
                Ok((word, names)) => {
                    let mut codes = Vec::new();
                    for name in names.split(',').map(str::trim) {
                        match warnings_called(name) {
                            Ok(found) => codes.extend(found),
                            Err(help) => problems.push(unknown(name, place(name), help)),
                        }
                    }
                    match word {
                        "allow-file" if is_top => out.everywhere.extend(codes),
                        "allow-file" => problems.push(late(place(word))),
                        _ if is_alone => waiting.extend(codes),
                        _ => out.at.extend(codes.into_iter().map(|c| (number, c))),
                    }
                }
                Err(text) => problems.push(unclear(place(text), text, mark)),
            }
        }
        start += line.len();
    }
    out
}

/// Returns the line before its comment, and the comment without its mark; quotes hide a mark.
fn split<'a>(line: &'a str, mark: &str) -> (&'a str, Option<&'a str>) {
    let mut is_quoted = false;
    for (at, c) in line.char_indices() {
        if c == '"' {
            is_quoted = !is_quoted;
        } else if !is_quoted && line[at..].starts_with(mark) {
            return (&line[..at], Some(&line[at + mark.len()..]));
        }
    }
    (line, None)
}

/// Returns word and names of a comment that speaks to sgap, or what it says instead.
fn instruction(comment: &str) -> Option<Result<(&str, &str), &str>> {
    let text = comment.trim().strip_prefix("sgap:")?.trim();
    let parts = text.split_once('(').and_then(|(word, rest)| {
        let (names, _) = rest.split_once(')')?;
        let word = word.trim();
        (word == "allow" || word == "allow-file").then_some((word, names))
    });
    Some(parts.ok_or(text))
}

fn unknown(name: &str, span: Span, help: String) -> Problem {
    let message = format!("no warning is called `{name}`");
    Problem::warning("hatp::bad-allow", message, span, "has no effect").help(help)
}

fn late(span: Span) -> Problem {
    let message = "`allow-file` does not stand at the top of the file";
    Problem::warning("hatp::bad-allow", message, span, "has no effect")
        .help("move it above the first declaration, or write `allow` for one line")
}

fn unclear(span: Span, text: &str, mark: &str) -> Problem {
    let message = format!("this comment asks sgap for something unknown: `{text}`");
    Problem::warning("hatp::bad-allow", message, span, "has no effect").help(format!(
        "write `{mark} sgap: allow(NAME)` or `{mark} sgap: allow-file(NAME)`"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNUSED: &str = "hatp::unused-variable";

    /// Returns the codes and severities that are left of one warning at each `X`.
    fn left(path: &str, text: &str, levels: &Levels) -> Vec<(&'static str, Severity)> {
        let mut sources = Sources::default();
        let file = sources.add(path, text);
        let at = |(i, _): (usize, &str)| Problem::warning(UNUSED, "x", Span::new(file, i, i + 1), "");
        let problems = Problems(text.match_indices('X').map(at).collect());
        let left = levels.apply(problems, &sources);
        left.0.iter().map(|p| (p.code, p.severity)).collect()
    }

    #[test]
    fn a_comment_silences_its_line_or_the_next() {
        let levels = Levels::default();
        let warning = (UNUSED, Severity::Warning);
        let n = |text: &str| left("a.hatp", text, &levels);
        assert_eq!(n("X\n"), [warning]);
        assert_eq!(n("X // sgap: allow(unused-variable)\nX"), [warning]);
        assert_eq!(
            n("// sgap: allow(no-agent, hatp::unused-variable): why\n\n// more\nX\n"),
            []
        );
        assert_eq!(n("// sgap: allow(unused-variable)\n;\nX\n"), [warning]);
        assert_eq!(n("\u{FEFF}// sgap: allow-file(unused-variable)\nX\nX"), []);
        assert_eq!(n("X \"// sgap: allow(unused-variable)\""), [warning]);
        assert_eq!(left("a.toml", "X # sgap: allow(unused-variable)", &levels), []);
    }

    #[test]
    fn a_comment_that_asks_for_nothing_is_told() {
        for text in [
            "// sgap: allow(unused-varible)",
            "// sgap: allow(unknown-task)",
            "// sgap: alow(unused-variable)",
            "; // sgap: allow-file(unused-variable)",
        ] {
            let codes = left("a.hatp", text, &Levels::default());
            assert_eq!(codes, [("hatp::bad-allow", Severity::Warning)], "{text}");
        }
    }

    #[test]
    fn a_warning_can_be_an_error() {
        let mut levels = Levels {
            deny_all: true,
            ..Levels::default()
        };
        assert_eq!(left("a.hatp", "X", &levels), [(UNUSED, Severity::Error)]);
        assert_eq!(left("a.hatp", "X // sgap: allow(unused-variable)", &levels), []);
        levels.of.push((UNUSED.into(), Level::Warn));
        assert_eq!(left("a.hatp", "X", &levels), [(UNUSED, Severity::Warning)]);
        levels.of.push((UNUSED.into(), Level::Allow));
        assert_eq!(left("a.hatp", "X", &levels), []);
    }
}
