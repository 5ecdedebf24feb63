//! What a trace says, as text of 100 columns and as JSON.

use std::fmt::Write;

use crate::trace::{Failure, Group, Summary, TaskCounts};

/// Columns of a line.
const WIDTH: usize = 100;
/// Columns of a task in a table.
const TASK: usize = 54;
/// Failures shown below a task, and texts or causes below a failure.
const MOST_BELOW: usize = 3;
/// Failures of the list, unless it is all that is wanted.
const MOST_FAILURES: usize = 10;
/// Actions shown at both ends of the deepest branch.
const MOST_AT_ENDS: usize = 8;

/// Returns all that a trace says; groups deeper than `depth` are left out.
pub fn summary(summary: &Summary, depth: usize) -> String {
    let mut out = head(summary);
    tree(summary, depth, &mut out);
    statistics(summary, &mut out);
    list(summary, MOST_FAILURES, &mut out);
    deepest(summary, &mut out);
    out
}

/// Returns what ended the branches, all of it.
pub fn failures(summary: &Summary) -> String {
    let mut out = head(summary);
    list(summary, usize::MAX, &mut out);
    out
}

/// Returns the summary as JSON, indented.
pub fn json(summary: &Summary) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string_pretty(summary)? + "\n")
}

fn head(summary: &Summary) -> String {
    let header = &summary.header;
    let mut out = format!("trace of {}\n", header.task);
    let _ = write!(out, "  {}", header.domain);
    if let Some(world) = &header.world {
        let _ = write!(out, ", {world}");
    }
    let _ = writeln!(out, ", seed {}; {} lines", header.seed, summary.lines);
    match &summary.end {
        Some(end) => {
            let how = match end.ending.as_str() {
                "found" => "ended with as many plans as were asked for",
                "exhausted" => "ended: every choice was tried",
                "truncated" => "ended: every choice was tried, but some were cut short",
                "budget" => "ended: its budget was spent",
                "interrupted" => "was interrupted",
                other => other,
            };
            let _ = writeln!(
                out,
                "  the search {how}\n  {}, {}, {}",
                count(end.plans, "plan", "plans"),
                count(end.expansions, "task taken up", "tasks taken up"),
                count(end.backtracks, "choice taken back", "choices taken back"),
            );
        }
        None => out.push_str("  the file ends before the search did\n"),
    }
    if summary.is_cut {
        out.push_str("  its last line is cut short, and was left out\n");
    }
    if summary.groups.is_empty() {
        out.push_str("\nno such task was taken up\n");
    }
    out
}

fn count(n: u64, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Returns a text of at most `width` characters; what is left out shows.
fn clip(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(width.saturating_sub(3)).collect();
    short.push_str("...");
    short
}

fn numbers_head(summary: &Summary) -> String {
    let times = if summary.has_times { " time [ms]    geom" } else { "" };
    format!("{:>8}{:>8}{:>8}{:>9}{times}", "tried", "failed", "back", "geometry")
}

fn numbers(summary: &Summary, counts: &TaskCounts) -> String {
    let dash = |n: u64| if n == 0 { "-".to_owned() } else { n.to_string() };
    let asked = counts.projections + counts.alternatives;
    let mut text = format!(
        "{:>8}{:>8}{:>8}{:>9}",
        counts.tried,
        dash(counts.failed),
        dash(counts.backtracks),
        dash(asked),
    );
    if summary.has_times {
        let ms = |us: u64| us as f64 / 1e3;
        let _ = write!(text, "{:>10.1}{:>8.1}", ms(counts.time), ms(counts.geometry_time));
    }
    text
}

/// Columns of a task beside its numbers.
fn task_width(summary: &Summary) -> usize {
    if summary.has_times { TASK - 6 } else { TASK }
}

fn shown(group: &Group) -> String {
    let args: Vec<&str> = group.arguments.iter().map(|a| a.as_deref().unwrap_or("*")).collect();
    let again = if group.is_recursive {
        " (again below itself)"
    } else {
        ""
    };
    format!("{}({}){again}", group.task, args.join(", "))
}

fn tree(summary: &Summary, depth: usize, out: &mut String) {
    let groups = &summary.groups;
    if groups.is_empty() {
        return;
    }
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); groups.len()];
    let mut left = Vec::new();
    for (i, group) in groups.iter().enumerate().rev() {
        match group.parent {
            Some(parent) => below[parent].push(i),
            None => left.push(i),
        }
    }
    let width = task_width(summary);
    let _ = writeln!(
        out,
        "\n{:width$}{}",
        "tasks (* stands for several)",
        numbers_head(summary)
    );
    let mut n_hidden = 0;
    while let Some(i) = left.pop() {
        let group = &groups[i];
        left.extend(&below[i]);
        if group.depth > depth {
            n_hidden += 1;
            continue;
        }
        let indent = 2 * group.depth.min(12);
        let name = clip(&format!("{:indent$}{}", "", shown(group)), width - 1);
        let _ = writeln!(out, "{name:width$}{}", numbers(summary, &group.counts));
        for (number, count, text) in group.failures.iter().take(MOST_BELOW) {
            let failure = &summary.failures[*number];
            // One branch, or the same each time: with the values met.
            let same = failure.texts.len() == 1 && failure.others == 0;
            let text = if *count == 1 || same { text } else { &failure.rule };
            let line = format!("{:indent$}    {count} x {}", "", without_task(text, &group.task));
            let _ = writeln!(out, "{}", clip(&line, WIDTH));
        }
        let rest: u64 = group.failures.iter().skip(MOST_BELOW).map(|(_, n, _)| n).sum();
        if rest > 0 {
            let _ = writeln!(out, "{:indent$}    {rest} x other reasons", "");
        }
    }
    if n_hidden > 0 {
        let _ = writeln!(
            out,
            "{} below (a larger --depth shows them)",
            count(n_hidden, "group of tasks is", "groups of tasks are")
        );
    }
}

/// Returns a reason without the task that it begins with, which stands above it.
fn without_task<'a>(text: &'a str, task: &str) -> &'a str {
    let rest = text.strip_prefix(task).filter(|r| r.starts_with(['(', ':']));
    rest.and_then(|r| r.split_once(": ")).map_or(text, |(_, rest)| rest)
}

fn statistics(summary: &Summary, out: &mut String) {
    let (width, tasks) = (task_width(summary), summary.tasks());
    // Where every task has one place only, the tree has said it.
    if tasks.len() < summary.groups.len() {
        let title = "each task, wherever it stands";
        let _ = writeln!(out, "\n{title:width$}{}", numbers_head(summary));
        for (task, counts) in tasks {
            let _ = writeln!(out, "{:width$}{}", clip(task, width - 1), numbers(summary, &counts));
        }
    }
    let all = summary.groups.iter().fold([0; 3], |[p, a, g], group| {
        let c = &group.counts;
        [p + c.projections, a + c.alternatives, g + c.goal_held]
    });
    let [projections, alternatives, goals] = all;
    if projections + alternatives > 0 {
        let _ = writeln!(
            out,
            "of the questions to geometry {projections} were for a first solution and {alternatives} for another one"
        );
    }
    if goals > 0 {
        let _ = writeln!(
            out,
            "{}",
            count(
                goals,
                "time nothing was to be done: the goal held",
                "times nothing was to be done: the goal held"
            )
        );
    }
}

fn list(summary: &Summary, most: usize, out: &mut String) {
    if summary.failures.is_empty() && summary.repeated == 0 {
        if !summary.groups.is_empty() {
            out.push_str("\nno branch failed\n");
        }
        return;
    }
    out.push_str("\nwhat ended branches, the most frequent first\n");
    for failure in summary.failures.iter().take(most) {
        one(failure, out);
    }
    let rest: u64 = summary.failures.iter().skip(most).map(|f| f.count).sum();
    if rest > 0 {
        let _ = writeln!(out, "{rest:>8} x other reasons (--failures shows all)");
    }
    if summary.repeated > 0 {
        let _ = writeln!(
            out,
            "{:>8} x the same state with the same tasks to do was met before",
            summary.repeated
        );
    }
}

fn one(failure: &Failure, out: &mut String) {
    let mut texts = failure.texts.as_slice();
    let mut line = format!("{:>8} x {}", failure.count, failure.rule);
    if let [(text, _)] = texts
        && failure.others == 0
    {
        line = format!("{:>8} x {text}", failure.count);
        texts = &[];
    }
    if failure.tried > 0 {
        let more = if failure.is_cut { "; more were not tried" } else { "" };
        let _ = write!(line, " among {}{more}", count(failure.tried, "candidate", "candidates"));
    }
    let _ = writeln!(out, "{}", clip(&line, WIDTH));
    let below = texts.iter().take(MOST_BELOW);
    for (text, n) in below.chain(failure.causes.iter().take(MOST_BELOW)) {
        let _ = writeln!(out, "{}", clip(&format!("           {n:>6} {text}"), WIDTH));
    }
    let others = |all: &[(String, u64)]| all.iter().skip(MOST_BELOW).map(|(_, n)| n).sum::<u64>();
    let rest = others(texts) + failure.others;
    if rest > 0 {
        let _ = writeln!(out, "           {rest:>6} with other arguments or values");
    }
    let rest = others(&failure.causes);
    if rest > 0 {
        let _ = writeln!(out, "           {rest:>6} candidates for other causes");
    }
}

fn deepest(summary: &Summary, out: &mut String) {
    let n = summary.deepest.len();
    if n == 0 {
        return;
    }
    let _ = writeln!(out, "\nthe deepest branch: {}", count(n as u64, "action", "actions"));
    for (i, action) in summary.deepest.iter().enumerate() {
        if n <= 2 * MOST_AT_ENDS + 1 || i < MOST_AT_ENDS || i >= n - MOST_AT_ENDS {
            let _ = writeln!(out, "  {}", clip(action, WIDTH - 2));
        } else if i == MOST_AT_ENDS {
            let _ = writeln!(out, "  ... {} more ...", n - 2 * MOST_AT_ENDS);
        }
    }
    if let Some(text) = &summary.stuck {
        let _ = writeln!(out, "{}", clip(&format!("  then: {text}"), WIDTH));
    }
}
