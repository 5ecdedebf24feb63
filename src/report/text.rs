//! Plans, reasons and facts as text for people.

use std::fmt::Write;
use std::io;

use crate::engine::{Ending, FallBackEnd, Statistics, Truncated};
use crate::plan::{Action, Plan, ReasonGroup, WhyNot};

/// Returns what [`write_plan`] writes.
pub fn plan(plan: &Plan) -> String {
    let mut out = Vec::new();
    // INVARIANT: writing to memory does not fail, and only text is written.
    let _ = write_plan(plan, &mut out);
    String::from_utf8(out).unwrap_or_default()
}

/// Writes the plan as a table with its schedule, then the streams of the agents.
///
/// # Errors
/// Those of `out`.
pub fn write_plan(plan: &Plan, out: &mut dyn io::Write) -> io::Result<()> {
    let n = plan.actions.len();
    let actions = if n == 1 { "action" } else { "actions" };
    writeln!(out, "plan of {}", plan.task)?;
    if n == 0 {
        return writeln!(out, "no action is needed");
    }
    writeln!(out, "{n} {actions}, cost {:.4}, {:.2} s\n", plan.cost, plan.makespan)?;
    table(&plan.actions, out)?;
    let mut parts = String::new();
    cost_parts(plan, &mut parts);
    out.write_all(parts.as_bytes())?;
    if !plan.streams.is_empty() {
        writeln!(out, "\nstreams")?;
        let widest = plan.streams.keys().map(|k| k.chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        for (agent, stream) in &plan.streams {
            write!(out, "  {agent:widest$}  ")?;
            let steps = stream.iter().filter_map(|i| plan.actions.get(*i));
            for (i, a) in steps.enumerate() {
                text.clear();
                text.push_str(if i > 0 { " | " } else { "" });
                whole(a.index as u64, &mut text);
                text.push(' ');
                text.push_str(&a.name);
                text.push(' ');
                fixed::<2>(a.start, &mut text);
                text.push('-');
                fixed::<2>(a.end, &mut text);
                out.write_all(text.as_bytes())?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

/// Writes what the plan's cost consists of, where it is more than its actions' costs.
fn cost_parts(plan: &Plan, out: &mut String) {
    if plan.cost_parts.is_empty() {
        return;
    }
    let mut rows = vec![["", "amount", "weight", "cost", ""].map(str::to_owned)];
    for part in &plan.cost_parts {
        rows.push([
            part.name.clone(),
            format!("{:.2}", part.amount),
            part.weight.to_string(),
            format!("{:.4}", part.cost),
            // What it is, where the name does not say it.
            if part.kind == part.name {
                String::new()
            } else {
                part.kind.clone()
            },
        ]);
    }
    out.push_str("\ncost\n");
    small_table(&rows, &[false, true, true, true, false], out);
}

/// Writes rows as columns; columns that are empty but for their heading are left out.
fn small_table<const N: usize>(rows: &[[String; N]], right: &[bool; N], out: &mut String) {
    let widths: [usize; N] = std::array::from_fn(|c| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0));
    let shown: Vec<usize> = (0..N)
        .filter(|c| rows.iter().skip(1).any(|r| !r[*c].is_empty()))
        .collect();
    for row in rows {
        let mut line = String::new();
        for c in &shown {
            let (cell, pad) = (&row[*c], widths[*c] - row[*c].chars().count());
            let (before, after) = if right[*c] { (pad, 0) } else { (0, pad) };
            let _ = write!(line, "  {}{cell}{}", " ".repeat(before), " ".repeat(after));
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
}

const HEADINGS: [&str; 8] = [
    "",
    "start [s]",
    "end [s]",
    "action",
    "arm",
    "grasp",
    "placement",
    "cost",
];
/// Numbers to the right, words to the left.
const RIGHT: [bool; 8] = [true, true, true, false, false, false, false, true];

/// Writes a number with `D` digits after the point. Whole ones, as most are in a domain without geometry, take no long
/// division.
fn fixed<const D: usize>(x: f64, out: &mut String) {
    /// Up to here every whole number is one.
    const MOST: f64 = 9_007_199_254_740_992.0;
    if D <= 8 && x.fract() == 0.0 && x.is_sign_positive() && x < MOST {
        whole(x as u64, out);
        out.push('.');
        out.push_str(&"00000000"[..D]);
    } else {
        let _ = write!(out, "{x:.D$}");
    }
}

/// Writes a whole number. Most of a long plan's table is that, and the standard library's formatter asks first for widths,
/// signs and blanks.
fn whole(mut x: u64, out: &mut String) {
    let mut digits = [b'0'; 20];
    let mut from = digits.len();
    loop {
        from -= 1;
        digits[from] = b'0' + (x % 10) as u8;
        x /= 10;
        if x == 0 {
            break;
        }
    }
    // INVARIANT: digits are text.
    out.push_str(std::str::from_utf8(&digits[from..]).unwrap_or_default());
}

/// Writes one cell of an action's row.
fn cell(action: &Action, column: usize, out: &mut String) {
    let _ = match (column, action.geometry.as_ref()) {
        (0, _) => {
            whole(action.index as u64, out);
            Ok(())
        }
        (1, _) => {
            fixed::<2>(action.start, out);
            Ok(())
        }
        (2, _) => {
            fixed::<2>(action.end, out);
            Ok(())
        }
        (3, _) => {
            out.push_str(&action.name);
            out.push('(');
            for (i, argument) in action.arguments.iter().enumerate() {
                out.push_str(if i > 0 { ", " } else { "" });
                out.push_str(argument);
            }
            out.push(')');
            Ok(())
        }
        (7, _) => {
            fixed::<4>(action.cost, out);
            Ok(())
        }
        (4, Some(g)) => write!(out, "{}", g.arm),
        (5, Some(g)) => write!(out, "{}", g.grasp),
        (6, Some(g)) => g.placement.as_ref().map_or(Ok(()), |p| {
            let (x, y, degrees) = (p.x + 0.0, p.y + 0.0, p.yaw.to_degrees());
            write!(
                out,
                "{}.{} ({x:.3}, {y:.3}) {degrees:.0}° {}",
                p.on, p.support, p.stable
            )
        }),
        _ => Ok(()),
    };
}

/// Returns how many characters a text has: to count bytes is quicker, and most texts have nothing else.
fn n_chars(text: &str) -> usize {
    if text.is_ascii() {
        text.len()
    } else {
        text.chars().count()
    }
}

fn blanks(mut n: usize, out: &mut String) {
    const SOME: &str = "                ";
    while n > 0 {
        let now = n.min(SOME.len());
        out.push_str(&SOME[..now]);
        n -= now;
    }
}

/// Writes the actions as rows; columns that are empty but for their heading are left out. Widths are found first, so that
/// no row has to wait for the longest one.
fn table(actions: &[Action], out: &mut dyn io::Write) -> io::Result<()> {
    let mut widths = [0; 8];
    let mut text = String::new();
    let mut measure = |column: usize, action: &Action| {
        text.clear();
        cell(action, column, &mut text);
        n_chars(&text)
    };
    for (column, width) in widths.iter_mut().enumerate() {
        // Of numbers the greatest is the widest, and there is none below 0.
        let number: Option<fn(&Action) -> f64> = match column {
            0 => Some(|a| a.index as f64),
            1 => Some(|a| a.start),
            2 => Some(|a| a.end),
            7 => Some(|a| a.cost),
            _ => None,
        };
        *width = match number {
            Some(number) => {
                let greatest = actions.iter().max_by(|a, b| number(a).total_cmp(&number(b)));
                greatest.map_or(0, |action| measure(column, action))
            }
            None => actions.iter().map(|action| measure(column, action)).max().unwrap_or(0),
        };
    }
    let shown: Vec<usize> = (0..8).filter(|c| widths[*c] > 0).collect();
    let mut line = String::new();
    let mut row = |write_cell: &dyn Fn(usize, &mut String)| {
        line.clear();
        for column in &shown {
            text.clear();
            write_cell(*column, &mut text);
            let pad = widths[*column].max(HEADINGS[*column].chars().count()) - n_chars(&text);
            let (before, after) = if RIGHT[*column] { (pad, 0) } else { (0, pad) };
            blanks(2 + before, &mut line);
            line.push_str(&text);
            blanks(after, &mut line);
        }
        line.truncate(line.trim_end().len());
        line.push('\n');
        out.write_all(line.as_bytes())
    };
    row(&|column, line| line.push_str(HEADINGS[column]))?;
    actions
        .iter()
        .try_for_each(|action| row(&|column, line| cell(action, column, line)))
}

/// Returns how a search without a plan ended, the deepest point that it reached, and the grouped reasons.
pub fn no_plan(ending: Ending, statistics: &Statistics, why: &WhyNot) -> String {
    let headline = match ending {
        Ending::FirstPlan | Ending::Exhausted => "no plan exists: every choice was tried".to_owned(),
        Ending::ExhaustedTruncated(cut) => format!("no plan found: {}{}", truncated(cut), fall_back(statistics)),
        Ending::BudgetSpent => format!("no plan found within {} expansions", statistics.expansions),
        Ending::Interrupted => "no plan found before the search was interrupted".to_owned(),
    };
    format!("{headline}\n{}", reasons(why))
}

/// Says that the search was made again without its unsafe cuts, and how far that went; nothing where it was not.
pub fn fall_back(statistics: &Statistics) -> String {
    let times = match statistics.returns {
        0 => return String::new(),
        1 => "once".to_owned(),
        n => format!("up to {n} times"),
    };
    let end = match statistics.fall_back {
        FallBackEnd::None => String::new(),
        FallBackEnd::Expansions(n) => format!(", within {n} expansions (--max-fall-back gives it more)"),
        FallBackEnd::Projections(n) => format!(", within {n} geometric actions (--max-fall-back gives it more)"),
        FallBackEnd::Budget => ", until the budget was spent (--max-expansions gives more)".to_owned(),
    };
    format!("; searched again with tasks let come back to themselves {times}{end}")
}

/// Returns the deepest point that a search without a plan reached, and what ended its branches.
pub fn reasons(why: &WhyNot) -> String {
    let mut out = String::new();
    if why.deepest.is_empty() {
        out.push_str("\nno branch got as far as one action\n");
        stuck(why, &mut out);
    } else {
        let _ = writeln!(out, "\nthe deepest branch did");
        let n = why.deepest.len();
        for (i, action) in why.deepest.iter().enumerate() {
            // Of a recursion that never ends, the first and the last actions say all.
            if n <= 2 * MOST_AT_ENDS + 1 || i < MOST_AT_ENDS || i >= n - MOST_AT_ENDS {
                let _ = writeln!(out, "  {action}");
            } else if i == MOST_AT_ENDS {
                let _ = writeln!(out, "  ... {} more ...", n - 2 * MOST_AT_ENDS);
            }
        }
        stuck(why, &mut out);
    }
    let groups = why.groups();
    if !groups.is_empty() {
        out.push_str("\nwhat ended the branches\n");
        for group in groups.iter().take(MOST_REASONS) {
            reason_group(group, &mut out);
        }
        let rest = groups
            .iter()
            .skip(MOST_REASONS)
            .map(|g| g.total.n_branches)
            .sum::<u64>()
            + why.not_kept;
        if rest > 0 {
            let _ = writeln!(out, "  {rest:>6} x other reasons");
        }
    }
    out
}

/// Writes what the deepest branch failed at, unless it is the only reason, which comes next anyway.
fn stuck(why: &WhyNot, out: &mut String) {
    if let Some(text) = &why.stuck
        && why.reasons().len() > 1
    {
        let what = if why.deepest.is_empty() {
            "the first failure"
        } else {
            "and failed at"
        };
        let _ = writeln!(out, "{what}\n  {text}");
    }
}

/// Writes what one rule has ended: the sentence if there is one only, else the rule with its instances.
fn reason_group(group: &ReasonGroup<'_>, out: &mut String) {
    let (total, mut instances) = (&group.total, group.reasons.as_slice());
    let _ = match instances {
        [(text, _)] => write!(out, "  {:>6} x {text}", total.n_branches),
        _ => write!(out, "  {:>6} x {}", total.n_branches, group.rule),
    };
    if instances.len() == 1 {
        instances = &[];
    }
    if total.tried > 0 {
        let candidates = if total.tried == 1 { "candidate" } else { "candidates" };
        let (all, rest) = if total.is_cut {
            ("", "; more were not tried")
        } else {
            ("all ", "")
        };
        let _ = write!(out, " among {all}{} {candidates}{rest}", total.tried);
    }
    out.push('\n');
    let named = instances.iter().filter(|(_, r)| !r.instance.is_empty());
    let mut shown = 0;
    for (_, reason) in named.take(MOST_INSTANCES) {
        let _ = writeln!(out, "           {:>6} {}", reason.n_branches, reason.instance);
        shown += reason.n_branches;
    }
    if !instances.is_empty() && total.n_branches > shown {
        let rest = total.n_branches - shown;
        let _ = writeln!(out, "           {rest:>6} with other arguments or values");
    }
    let causes = total.causes();
    if !instances.is_empty() && !causes.is_empty() {
        out.push_str("         of the candidates\n");
    }
    // What was asked for by name is never summed up: it is what the domain can change.
    let is_shown = |(i, (cause, _)): &(usize, &(&str, u64))| *i < MOST_CAUSES || total.is_asked(cause);
    let shown: Vec<&(&str, u64)> = causes.iter().enumerate().filter(is_shown).map(|(_, c)| c).collect();
    for (cause, count) in shown.iter().take(MOST_ASKED) {
        let _ = writeln!(out, "           {count:>6} {cause}");
    }
    let n_others = causes.len() - shown.len().min(MOST_ASKED);
    if n_others > 0 {
        let told: u64 = shown.iter().take(MOST_ASKED).map(|(_, n)| n).sum();
        let rest = causes.iter().map(|(_, n)| n).sum::<u64>() - told;
        let causes = if n_others == 1 { "cause" } else { "causes" };
        let _ = writeln!(out, "           {rest:>6} for {n_others} other {causes}");
    }
}

/// Actions shown at both ends of the deepest branch.
const MOST_AT_ENDS: usize = 6;
/// Reasons shown; the rest is summed up.
const MOST_REASONS: usize = 12;
const MOST_CAUSES: usize = 4;
/// Causes shown at most, if they were asked for by name.
const MOST_ASKED: usize = 12;
/// Arguments and values shown of one reason.
const MOST_INSTANCES: usize = 3;

/// Returns what was cut short, in words.
pub fn truncated(cut: Truncated) -> String {
    let mut parts = Vec::new();
    let mut add = |n: u64, one: &str, many: &str| {
        if n > 0 {
            parts.push(format!("{n} {}", if n == 1 { one } else { many }));
        }
    };
    add(
        cut.alternatives,
        "action stopped at its branching factor (try a larger --branching)",
        "actions stopped at their branching factor (try a larger --branching)",
    );
    add(
        cut.geometry,
        "geometric action ended with choices untried (try more --placements)",
        "geometric actions ended with choices untried (try more --placements)",
    );
    add(
        cut.depth,
        "branch was too deep (a recursion without end, or --max-depth is too small)",
        "branches were too deep (a recursion without end, or --max-depth is too small)",
    );
    add(
        cut.cycles,
        "branch came back to its own task in the same state (--no-cuts follows it)",
        "branches came back to their own task in the same state (--no-cuts follows them)",
    );
    parts.join(", ")
}
