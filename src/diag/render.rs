//! Problems to text: the only user of `miette`.
//!
//! miette knows one source per report: labels in the file of the primary label are drawn there, labels in other files
//! follow as reports of their own.

mod excerpt;

use std::borrow::Cow;
use std::collections::BTreeMap;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, ThemeCharacters, ThemeStyles};

use excerpt::{CONTEXT, Excerpt};

use super::{Label, Problem, Problems, Severity};
use crate::source::{FileId, Lines, Sources, Span};

/// Width of a report [columns].
const WIDTH: usize = 100;

/// Reports shown at once; the rest is counted. Nobody reads more, and each is searched for in the whole text.
const MAX_REPORTS: usize = 100;

/// Longest message, help line and label [characters]: a name can be as long as its file.
const MAX_MESSAGE: usize = 600;
const MAX_HELP: usize = 2000;
const MAX_LABEL: usize = 120;

/// Returns a report with the source's lines for each problem, in the order of `problems`. No character of the user's
/// steers a terminal.
pub fn render(problems: &Problems, sources: &Sources, color: bool) -> String {
    let sources = &harmless(sources);
    let styles = if color {
        ThemeStyles::ansi()
    } else {
        ThemeStyles::none()
    };
    let theme = GraphicalTheme {
        characters: ThemeCharacters::unicode(),
        styles,
    };
    let handler = GraphicalReportHandler::new_themed(theme)
        .with_links(false)
        .with_context_lines(CONTEXT)
        .with_width(WIDTH);
    let mut out = String::new();
    for problem in problems.0.iter().take(MAX_REPORTS) {
        // Only a writer that fails or a span outside of the text can make miette fail; then the plain line is still there.
        let mut report = String::new();
        if handler
            .render_report(&mut report, &Report::new(problem, sources))
            .is_err()
        {
            report = concise(problem, sources, &mut BTreeMap::new());
        }
        for line in report.trim_end().lines() {
            out.push_str(line.trim_end());
            out.push('\n');
        }
        out.push('\n');
    }
    let n_more = problems.0.len().saturating_sub(MAX_REPORTS);
    if n_more > 0 {
        out.push_str(&format!("and {n_more} more\n"));
    }
    out
}

/// Returns `file:line:column: severity[code]: message (help)` for each problem; columns count characters from 1.
pub fn render_concise(problems: &Problems, sources: &Sources) -> String {
    let mut lines = BTreeMap::new();
    problems.0.iter().map(|p| concise(p, sources, &mut lines)).collect()
}

fn concise(problem: &Problem, sources: &Sources, lines: &mut BTreeMap<FileId, Lines>) -> String {
    // One line for each problem, whatever the user's names hold.
    let on_one_line = |text: &str, most| fitted(text, most).replace('\n', " ");
    let place = match &problem.primary {
        Some(label) => {
            let file = sources.get(label.span.file);
            let lines = lines.entry(label.span.file).or_insert_with(|| Lines::new(&file.text));
            let (line, column) = lines.line_column(&file.text, label.span.start as usize);
            format!("{}:{line}:{column}: ", on_one_line(&file.path, MAX_MESSAGE))
        }
        None => String::new(),
    };
    let help = problem.help.as_deref().map(|help| on_one_line(help, MAX_HELP));
    let help = help.map_or_else(String::new, |help| format!(" ({help})"));
    let severity = super::json::word(problem.severity);
    let message = on_one_line(&problem.message, MAX_MESSAGE);
    format!("{place}{severity}[{}]: {message}{help}\n", problem.code)
}

/// Returns the text for a terminal: control characters escaped, and without its middle if it has more than `most`
/// characters.
pub fn fitted(text: &str, most: usize) -> Cow<'_, str> {
    let is_plain = |c: char| matches!(c, '\n' | '\t') || !steers(c);
    if text.len() <= most && text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let escaped = |out: &mut String, c: char| match is_plain(c) {
        true => out.push(c),
        false => out.extend(c.escape_unicode()),
    };
    let mut out = String::new();
    let n = text.chars().count();
    if n <= most {
        text.chars().for_each(|c| escaped(&mut out, c));
    } else {
        text.chars().take(most / 2).for_each(|c| escaped(&mut out, c));
        out.push_str(" … ");
        text.chars().skip(n - most / 2).for_each(|c| escaped(&mut out, c));
    }
    Cow::Owned(out)
}

/// Says whether a terminal obeys the character instead of drawing it: control characters, and those that turn the direction
/// of writing (Unicode, UAX 9), by which a line may read as another than it is.
fn steers(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns
}

/// Returns the files with a mark as long for each character that steers a terminal: spans stay right. Tabs and ends of
/// lines are miette's own matter.
fn harmless(sources: &Sources) -> Cow<'_, Sources> {
    let is_harmless = |text: &str| !text.chars().any(|c| steers(c) && !matches!(c, '\t' | '\n'));
    let is_well = |id| is_harmless(&sources.get(id).path) && is_harmless(&sources.get(id).text);
    if sources.ids().all(is_well) {
        return Cow::Borrowed(sources);
    }
    let mut out = Sources::default();
    for id in sources.ids() {
        let file = sources.get(id);
        let marked = |(at, c): (usize, char)| match c.len_utf8() {
            _ if !steers(c) || matches!(c, '\t' | '\n') => c,
            1 if c == '\r' && file.text[at..].starts_with("\r\n") => c,
            1 => '?',
            2 => '¿',
            _ => char::REPLACEMENT_CHARACTER,
        };
        let text: String = file.text.char_indices().map(marked).collect();
        out.add(fitted(&file.path, MAX_MESSAGE), text);
    }
    Cow::Owned(out)
}

/// A problem as miette wants it.
#[derive(Debug)]
struct Report<'a> {
    head: MietteDiagnostic,
    source: Option<Excerpt<'a>>,
    related: Vec<Report<'a>>,
}

impl<'a> Report<'a> {
    fn new(problem: &Problem, sources: &'a Sources) -> Self {
        let file = problem.primary.as_ref().map(|l| l.span.file);
        // Two marks in a line that is shown in part may have no part in common.
        let is_wide = |label: &Label| {
            let (start, len) = clipped(label.span, sources);
            excerpt(label.span.file, sources).is_wide(start, start + len)
        };
        let apart = problem.primary.iter().chain(&problem.notes).any(is_wide);
        let (here, elsewhere): (Vec<&Label>, Vec<&Label>) =
            problem.notes.iter().partition(|n| Some(n.span.file) == file && !apart);
        let labels = problem.primary.iter().map(|l| labelled(l, sources, true));
        let labels: Vec<LabeledSpan> = labels.chain(here.iter().map(|l| labelled(l, sources, false))).collect();
        let mut head = MietteDiagnostic::new(fitted(&problem.message, MAX_MESSAGE))
            .with_code(problem.code)
            .with_severity(match problem.severity {
                Severity::Error => miette::Severity::Error,
                Severity::Warning => miette::Severity::Warning,
            })
            .with_labels(labels);
        if let Some(help) = &problem.help {
            head = head.with_help(fitted(help, MAX_HELP));
        }
        Report {
            head,
            source: file.map(|f| excerpt(f, sources)),
            related: elsewhere.iter().map(|l| Report::note(l, sources)).collect(),
        }
    }

    fn note(label: &Label, sources: &'a Sources) -> Self {
        let mark = LabeledSpan::new_with_span(None, shown(label.span, sources));
        let head = MietteDiagnostic::new(fitted(&label.text, MAX_LABEL)).with_severity(miette::Severity::Advice);
        Report {
            head: head.with_labels([mark]),
            source: Some(excerpt(label.span.file, sources)),
            related: Vec::new(),
        }
    }
}

fn excerpt(file: FileId, sources: &Sources) -> Excerpt<'_> {
    let file = sources.get(file);
    Excerpt {
        path: &file.path,
        text: &file.text,
    }
}

fn labelled(label: &Label, sources: &Sources, primary: bool) -> LabeledSpan {
    let text = (!label.text.is_empty()).then(|| fitted(&label.text, MAX_LABEL).into_owned());
    let span = shown(label.span, sources);
    if primary {
        LabeledSpan::new_primary_with_span(text, span)
    } else {
        LabeledSpan::new_with_span(text, span)
    }
}

/// Returns start and length of the span as it is drawn: in a line that is shown in part, a piece of it.
fn shown(span: Span, sources: &Sources) -> (usize, usize) {
    let (start, len) = clipped(span, sources);
    let excerpt = excerpt(span.file, sources);
    if excerpt.is_wide(start, start + len) {
        (start, excerpt.mark_end(start, start + len) - start)
    } else {
        (start, len)
    }
}

/// Returns the span as miette counts, inside of the text and of whole characters.
fn clipped(span: Span, sources: &Sources) -> (usize, usize) {
    let text = &sources.get(span.file).text;
    let boundary = |at: u32| {
        let mut at = (at as usize).min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let (start, end) = (boundary(span.start), boundary(span.end));
    (start, end.saturating_sub(start))
}

impl std::fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.head.fmt(f)
    }
}

impl std::error::Error for Report<'_> {}

impl miette::Diagnostic for Report<'_> {
    fn code<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        self.head.code()
    }
    fn severity(&self) -> Option<miette::Severity> {
        self.head.severity()
    }
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        self.head.help()
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.head.labels()
    }
    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        self.source.as_ref().map(|s| s as &dyn miette::SourceCode)
    }
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn miette::Diagnostic> + 'a>> {
        if self.related.is_empty() {
            return None;
        }
        Some(Box::new(self.related.iter().map(|r| r as &dyn miette::Diagnostic)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_of_two_files_shows_both() {
        let mut sources = Sources::default();
        let a = sources.add("a.hatp", "one\nB = 2;\n");
        let b = sources.add("b.toml", "x = 1\n");
        let problem =
            Problem::error("hatp::x", "wrong `B`", Span::new(a, 4, 5), "here").note(Span::new(b, 0, 1), "and here");
        let problems = Problems(vec![problem.help("do better")]);
        let text = render(&problems, &sources, false);
        for part in ["hatp::x", "a.hatp:2:1", "b.toml:1:1", "and here", "do better"] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert_eq!(
            render_concise(&problems, &sources),
            "a.hatp:2:1: error[hatp::x]: wrong `B` (do better)\n"
        );
    }

    #[test]
    fn of_an_endless_line_a_piece_is_shown() {
        let mut sources = Sources::default();
        let line = format!("{}X{}", "é".repeat(100_000), "-".repeat(100_000));
        let a = sources.add("a.hatp", format!("first\n{line}\nlast\n"));
        let at = 6 + 200_000;
        let problem = Problem::error("hatp::x", "wrong", Span::new(a, at, at + 90_000), "here")
            .note(Span::new(a, 6, 8), "and here")
            .help("y".repeat(10_000));
        let text = render(&Problems(vec![problem]), &sources, false);
        for part in ["a.hatp:2:", "éX---", "╰── here", "a.hatp:2:1]", "and here"] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert!(text.len() < 8000, "{text}");
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let steering = "\u{0}\u{7}\u{8}\u{b}\r\u{1b}\u{7f}\u{9b}\u{61c}\u{200f}\u{202e}\u{2066}";
        let mut sources = Sources::default();
        let a = sources.add(format!("a{steering}.hatp"), format!("B = \"{steering}é\";\r\nC\r\n"));
        let at = 5 + steering.len();
        let problem = Problem::error("hatp::x", format!("`{steering}`"), Span::new(a, at, at + 2), steering)
            .note(Span::new(a, at + 6, at + 7), steering)
            .help(steering);
        let problems = Problems(vec![problem]);
        for text in [render(&problems, &sources, false), render_concise(&problems, &sources)] {
            assert!(!text.chars().any(|c| steers(c) && c != '\n'), "{text:?}");
            assert!(text.contains("\\u{1b}\\u{7f}"), "{text:?}");
        }
        // The mark stands below what it marks.
        let text = render(&problems, &sources, false);
        let lines: Vec<&str> = text.lines().collect();
        let column = |part: &str| {
            lines
                .iter()
                .find_map(|l| l.find(part).map(|at| l[..at].chars().count()))
        };
        assert_eq!(column("┬"), column("é"), "{text}");
    }

    #[test]
    fn a_span_outside_of_the_text_is_clipped() {
        let mut sources = Sources::default();
        let a = sources.add("a.hatp", "é");
        let problem = Problem::error("hatp::x", "far", Span::new(a, 1, 90), "");
        assert!(render(&Problems(vec![problem]), &sources, false).contains("far"));
    }
}
