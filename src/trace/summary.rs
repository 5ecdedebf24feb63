//! Counts what a trace says: a tree of tasks, folded, and what ended branches.
//!
//! Tasks of one name below the same tasks are one *group*, whatever their arguments; a task that comes back below itself belongs
//! to the group above. So the tree has at most as many groups as there are ways down through the domain's tasks without a circle, and
//! a recursion of a million tasks is one line.

use indexmap::IndexMap;
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::record::{Candidates, Header, Record};

/// HEURISTIC: groups told apart; further ones count for the group above.
const MOST_GROUPS: usize = 10_000;
/// HEURISTIC: texts kept of one failure; more are counted.
const MOST_TEXTS: usize = 64;
/// Above what a writer remembers, so that a number that is still used is never dropped.
const MOST_REASONS: usize = 1 << 18;

/// All that a trace says, put together.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    pub header: Header,
    /// Lines read.
    pub lines: u64,
    /// The last line was not whole.
    pub is_cut: bool,
    /// How the search ended, as the last line says; `None` if the file ends before.
    pub end: Option<End>,
    /// Whether the file has times.
    pub has_times: bool,
    /// The folded tree; a group stands after the one it is below.
    pub groups: Vec<Group>,
    /// What ended branches, by rule, most frequent first.
    pub failures: Vec<Failure>,
    /// Branches that were left because they were known to fail.
    pub repeated: u64,
    /// The longest sequence of actions.
    pub deepest: Vec<String>,
    /// What ended the longest branch first.
    pub stuck: Option<String>,
}

/// The last line of a trace.
#[derive(Debug, Clone, Serialize)]
pub struct End {
    pub ending: String,
    pub expansions: u64,
    pub backtracks: u64,
    pub repeated: u64,
    pub plans: u64,
}

/// Tasks of one name at one place of the tree.
#[derive(Debug, Clone, Serialize)]
pub struct Group {
    pub task: String,
    /// `None` where not all had the same.
    pub arguments: Vec<Option<String>>,
    pub parent: Option<usize>,
    pub depth: usize,
    /// Whether some stood below others of this group.
    pub is_recursive: bool,
    #[serde(flatten)]
    pub counts: TaskCounts,
    /// What ended branches here: number in [`Summary::failures`], how often, and the first one in full.
    pub failures: Vec<(usize, u64, String)>,
}

/// How often things happened to tasks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct TaskCounts {
    /// Times taken up.
    pub tried: u64,
    /// Times the goal held already.
    pub goal_held: u64,
    /// Times applied, for an action; several for one that has alternatives.
    pub applied: u64,
    /// Branches that ended here.
    pub failed: u64,
    /// Choices of this task taken back.
    pub backtracks: u64,
    /// Questions to geometry: first solutions.
    pub projections: u64,
    /// Questions to geometry: further solutions.
    pub alternatives: u64,
    /// Time in the task itself, not in those below [us].
    pub time: u64,
    /// That part of it in which geometry was computed [us].
    pub geometry_time: u64,
}

impl TaskCounts {
    fn add(&mut self, other: &TaskCounts) {
        self.tried += other.tried;
        self.goal_held += other.goal_held;
        self.applied += other.applied;
        self.failed += other.failed;
        self.backtracks += other.backtracks;
        self.projections += other.projections;
        self.alternatives += other.alternatives;
        self.time += other.time;
        self.geometry_time += other.geometry_time;
    }
}

/// Why branches ended.
#[derive(Debug, Clone, Serialize)]
pub struct Failure {
    pub kind: String,
    /// As the domain has it.
    pub rule: String,
    pub count: u64,
    /// With the arguments and values met, and how often each; most frequent first.
    pub texts: Vec<(String, u64)>,
    /// Branches with other texts.
    pub others: u64,
    /// Candidates of geometric actions that were tried.
    pub tried: u64,
    /// Whether others were left untried.
    pub is_cut: bool,
    /// What stopped candidates, most frequent first.
    pub causes: Vec<(String, u64)>,
}

impl Summary {
    /// Returns the counts of each task, in the order of the tree.
    pub fn tasks(&self) -> IndexMap<&str, TaskCounts> {
        let mut tasks: IndexMap<&str, TaskCounts> = IndexMap::new();
        for group in &self.groups {
            tasks.entry(&group.task).or_default().add(&group.counts);
        }
        tasks
    }
}

/// A task that stands.
struct Open {
    id: u64,
    group: Option<usize>,
    task: Box<str>,
}

#[derive(Default)]
struct Rule {
    kind: String,
    count: u64,
    texts: IndexMap<String, u64>,
    others: u64,
    tried: u64,
    is_cut: bool,
    causes: IndexMap<String, u64>,
}

/// A summary that grows line by line.
pub(super) struct Builder {
    header: Header,
    /// Only what is in such tasks counts.
    wanted: Option<String>,
    open: Vec<Open>,
    groups: Vec<Group>,
    by_name: FxHashMap<(Option<usize>, String), usize>,
    rules: IndexMap<String, Rule>,
    /// Number of the rule, and the text, by the number of the reason.
    reasons: FxHashMap<u64, (usize, Box<str>)>,
    repeated: u64,
    actions: Vec<Box<str>>,
    deepest: Vec<Box<str>>,
    /// How many of the deepest branch's actions are also the first ones of the branch at hand.
    common: usize,
    stuck: Option<String>,
    end: Option<End>,
    is_cut: bool,
    /// The last time [us], and what it goes to: a group, and whether geometry is at work.
    time: Option<u64>,
    at: Option<(usize, bool)>,
}

impl Builder {
    pub fn new(header: Header, task: Option<&str>) -> Self {
        Builder {
            header,
            wanted: task.map(|t| t.split_whitespace().collect()),
            open: Vec::new(),
            groups: Vec::new(),
            by_name: FxHashMap::default(),
            rules: IndexMap::new(),
            reasons: FxHashMap::default(),
            repeated: 0,
            actions: Vec::new(),
            deepest: Vec::new(),
            common: 0,
            stuck: None,
            end: None,
            is_cut: false,
            time: None,
            at: None,
        }
    }

    pub fn cut(&mut self) {
        self.is_cut = true;
    }

    /// Counts a line.
    ///
    /// # Errors
    ///
    /// The line speaks of a task that does not stand, or of a reason that was not told.
    pub fn add(&mut self, record: &Record<'_>) -> Result<(), String> {
        match record {
            Record::Task { id, parent, task, .. } => {
                let parent = parent.map(|p| self.find(p)).transpose()?;
                let group = self.group(parent.and_then(|p| self.open[p].group), task);
                self.count(group, |c| c.tried += 1);
                self.open.push(Open {
                    id: *id,
                    group,
                    task: task.as_ref().into(),
                });
            }
            Record::Goal { id } => self.count_at(*id, |c| c.goal_held += 1)?,
            Record::Try { id, .. } | Record::Bind { id, .. } => self.count_at(*id, |_| {})?,
            Record::Ask { id, after, .. } => {
                self.count_at(*id, |c| match after {
                    None => c.projections += 1,
                    Some(_) => c.alternatives += 1,
                })?;
                self.at = self.at.map(|(group, _)| (group, true));
            }
            Record::Act { id, actions, .. } => {
                self.count_at(*id, |c| c.applied += 1)?;
                let at = self.find(*id)?;
                let task = self.open[at].task.clone();
                self.shorten(actions.saturating_sub(1));
                self.actions.push(task);
            }
            Record::Reason { n, kind, rule, text } => {
                let entry = self.rules.entry(rule.to_string());
                let number = entry.index();
                entry.or_default().kind = kind.to_string();
                if self.reasons.len() >= MOST_REASONS {
                    let oldest = n.saturating_sub(MOST_REASONS as u64 / 2);
                    self.reasons.retain(|n, _| *n >= oldest);
                }
                self.reasons.insert(*n, (number, text.as_ref().into()));
            }
            Record::Refuse { id, why, geometry } => self.refuse(*id, *why, geometry.as_ref())?,
            Record::Repeat { id } => {
                self.count_at(*id, |c| c.failed += 1)?;
                self.repeated += u64::from(self.at.is_some());
                self.note_deepest();
            }
            Record::Back { id, from, actions, .. } => {
                self.count_at(*id, |c| c.backtracks += 1)?;
                self.note_deepest();
                while self.open.last().is_some_and(|o| o.id >= *from) {
                    self.open.pop();
                }
                self.shorten(*actions);
            }
            Record::Plan { .. } => {
                self.note_deepest();
            }
            Record::Time { us } => {
                if let (Some(before), Some((group, in_geometry))) = (self.time, self.at) {
                    let passed = us.saturating_sub(before);
                    let counts = &mut self.groups[group].counts;
                    counts.time += passed;
                    if in_geometry {
                        counts.geometry_time += passed;
                    }
                }
                self.time = Some(*us);
            }
            Record::End {
                ending,
                expansions,
                backtracks,
                repeated,
                plans,
                ..
            } => {
                self.note_deepest();
                self.end = Some(End {
                    ending: ending.to_string(),
                    expansions: *expansions,
                    backtracks: *backtracks,
                    repeated: *repeated,
                    plans: *plans,
                });
            }
        }
        Ok(())
    }

    fn find(&self, id: u64) -> Result<usize, String> {
        let found = self.open.binary_search_by_key(&id, |o| o.id);
        found.map_err(|_| format!("speaks of the task {id}, which is not there"))
    }

    fn count(&mut self, group: Option<usize>, change: impl FnOnce(&mut TaskCounts)) {
        self.at = group.map(|group| (group, false));
        if let Some(group) = group {
            change(&mut self.groups[group].counts);
        }
    }

    fn count_at(&mut self, id: u64, change: impl FnOnce(&mut TaskCounts)) -> Result<(), String> {
        let at = self.find(id)?;
        self.count(self.open[at].group, change);
        Ok(())
    }

    /// Returns the group of a task below another one's; `None` if it is not wanted.
    fn group(&mut self, above: Option<usize>, task: &str) -> Option<usize> {
        let (name, args) = parts(task);
        if above.is_none()
            && let Some(wanted) = &self.wanted
        {
            let same: String = task.split_whitespace().collect();
            if *wanted != name && *wanted != same {
                return None;
            }
        }
        let mut at = above;
        while let Some(group) = at {
            if self.groups[group].task == name {
                self.groups[group].is_recursive = true;
                self.widen(group, &args);
                return at;
            }
            at = self.groups[group].parent;
        }
        let key = (above, name.to_owned());
        if let Some(group) = self.by_name.get(&key).copied() {
            self.widen(group, &args);
            return Some(group);
        }
        if self.groups.len() >= MOST_GROUPS && above.is_some() {
            return above;
        }
        self.groups.push(Group {
            task: name.to_owned(),
            arguments: args.iter().map(|a| Some((*a).to_owned())).collect(),
            parent: above,
            depth: above.map_or(0, |a| self.groups[a].depth + 1),
            is_recursive: false,
            counts: TaskCounts::default(),
            failures: Vec::new(),
        });
        self.by_name.insert(key, self.groups.len() - 1);
        Some(self.groups.len() - 1)
    }

    /// Forgets the arguments that a further task of the group does not share.
    fn widen(&mut self, group: usize, args: &[&str]) {
        for (known, arg) in self.groups[group].arguments.iter_mut().zip(args) {
            if known.as_deref() != Some(*arg) {
                *known = None;
            }
        }
    }

    fn refuse(&mut self, id: u64, why: u64, geometry: Option<&Candidates<'_>>) -> Result<(), String> {
        self.count_at(id, |c| c.failed += 1)?;
        let known = self.reasons.get(&why);
        let (rule, text) = known.ok_or_else(|| format!("speaks of the reason {why}, which was not told"))?;
        let number = *rule;
        if let Some((group, _)) = self.at {
            let failures = &mut self.groups[group].failures;
            match failures.iter_mut().find(|(n, ..)| *n == number) {
                Some((_, count, _)) => *count += 1,
                None => failures.push((number, 1, text.to_string())),
            }
            let (_, rule) = self.rules.get_index_mut(number).ok_or("has no rule")?;
            rule.count += 1;
            if let Some(count) = rule.texts.get_mut(text.as_ref()) {
                *count += 1;
            } else if rule.texts.len() < MOST_TEXTS {
                rule.texts.insert(text.to_string(), 1);
            } else {
                rule.others += 1;
            }
            if let Some(candidates) = geometry {
                rule.tried += u64::from(candidates.tried);
                rule.is_cut |= !candidates.exhausted;
                for (cause, count) in &candidates.causes {
                    *rule.causes.entry(cause.to_string()).or_default() += u64::from(*count);
                }
            }
            let text = text.to_string();
            if self.note_deepest() {
                self.stuck = Some(text);
            }
        }
        Ok(())
    }

    fn shorten(&mut self, n: usize) {
        self.actions.truncate(n);
        self.common = self.common.min(n);
    }

    /// Remembers the branch at hand if none was longer, and says so.
    fn note_deepest(&mut self) -> bool {
        let is_first = self.stuck.is_none() && self.deepest.is_empty() && self.actions.is_empty();
        if self.actions.len() <= self.deepest.len() {
            return is_first;
        }
        self.deepest.truncate(self.common);
        self.deepest.extend_from_slice(&self.actions[self.common..]);
        self.common = self.actions.len();
        self.stuck = None;
        true
    }

    pub fn finish(mut self, lines: u64) -> Summary {
        self.note_deepest();
        let mut order: Vec<usize> = (0..self.rules.len()).collect();
        order.sort_by_key(|i| std::cmp::Reverse(self.rules[*i].count));
        let mut place = vec![0; order.len()];
        for (new, old) in order.iter().enumerate() {
            place[*old] = new;
        }
        for group in &mut self.groups {
            for (number, ..) in &mut group.failures {
                *number = place[*number];
            }
            group.failures.sort_by_key(|(_, count, _)| std::cmp::Reverse(*count));
        }
        // A rule is known from its line on; what ended no branch of the tasks wanted is left out, and these come last.
        order.retain(|i| self.rules[*i].count > 0);
        let sorted = |counts: &IndexMap<String, u64>| {
            let mut all: Vec<(String, u64)> = counts.iter().map(|(k, n)| (k.clone(), *n)).collect();
            all.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
            all
        };
        let failure = |i: &usize| {
            let (rule, of) = self.rules.get_index(*i)?;
            Some(Failure {
                kind: of.kind.clone(),
                rule: rule.clone(),
                count: of.count,
                texts: sorted(&of.texts),
                others: of.others,
                tried: of.tried,
                is_cut: of.is_cut,
                causes: sorted(&of.causes),
            })
        };
        Summary {
            lines,
            is_cut: self.is_cut,
            end: self.end,
            has_times: self.time.is_some(),
            failures: order.iter().filter_map(failure).collect(),
            repeated: self.repeated,
            deepest: self.deepest.iter().map(ToString::to_string).collect(),
            stuck: self.stuck,
            groups: self.groups,
            header: self.header,
        }
    }
}

/// Returns name and arguments of `Put(PR2, [CUP, BOX], "a, b")`.
fn parts(task: &str) -> (&str, Vec<&str>) {
    let Some((name, rest)) = task.split_once('(') else {
        return (task, Vec::new());
    };
    let rest = rest.strip_suffix(')').unwrap_or(rest);
    let mut args = Vec::new();
    let (mut from, mut depth, mut in_text, mut escaped) = (0, 0, false, false);
    for (at, c) in rest.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' if in_text => escaped = true,
            '"' => in_text = !in_text,
            _ if in_text => {}
            '[' => depth += 1,
            ']' => depth -= 1,
            ',' if depth == 0 => {
                args.push(rest[from..at].trim());
                from = at + 1;
            }
            _ => {}
        }
    }
    if !rest[from..].trim().is_empty() {
        args.push(rest[from..].trim());
    }
    (name, args)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_told_apart_at_their_own_commas() {
        assert_eq!(parts("Go()"), ("Go", vec![]));
        assert_eq!(
            parts(r#"Put(PR2, [CUP, BOX], "a, \"b]")"#),
            ("Put", vec!["PR2", "[CUP, BOX]", r#""a, \"b]""#])
        );
    }
}
