//! Why a branch of the search failed: typed, with numbers; the report turns it into sentences.
//!
//! A refusal is not a problem of the user's text (`diag::Problem`): the domain and the world are fine, this branch is not.

use std::collections::BTreeSet;
use std::fmt;

use indexmap::IndexMap;

/// Why one branch failed.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// A literal of a precondition was false.
    Precondition {
        /// The task with its arguments: `Pick(PR2, RED_CUBE)`.
        task: String,
        /// The literal as the language writes it.
        literal: String,
        /// The values it met: `RED_CUBE.isReachable is []`.
        met: String,
        /// The literal as the domain has it: `O.isReachable >> A`.
        rule: String,
    },
    /// No entity passed a SELECT.
    NoBinding {
        task: String,
        variable: String,
        candidates: usize,
        /// What it had to pass; empty where anything does.
        filter: String,
        /// The same as the domain has it.
        rule: String,
    },
    /// A subtask's argument, or one of an action's projection, was NULL when it was reached.
    NullArgument {
        /// Whose argument.
        task: String,
        position: usize,
        /// With variables replaced by their values: `ROBOT.station`.
        argument: String,
        /// As the domain has it: `A.station`.
        rule: String,
    },
    /// A cost or a duration was negative, or had no value.
    BadNumber {
        task: String,
        what: &'static str,
        /// `None` where it has no value in the state met.
        value: Option<f64>,
    },
    /// The least duration is above the most.
    DurationOrder { task: String, least: f64, most: f64 },
    /// Geometry found no (further) solution.
    Geometry(ActionRefusal),
    /// The plan would cost at least as much as the best one known: so much up to here, and so much to come.
    TooCostly { cost: f64, rest: f64, bound: f64 },
    /// Methods inside methods, more than the limit; `chain` are the last tasks down to this one.
    TooDeep {
        task: String,
        depth: usize,
        chain: Vec<String>,
    },
    /// A literal that a task still to be done needs is false, and nothing that comes before it can change that.
    LookAhead {
        task: String,
        literal: String,
        met: String,
        /// The literal as the domain has it.
        rule: String,
    },
    /// A task came back to itself, with the same arguments in the same state: `chain` goes from the one to the other.
    Cycle { chain: Vec<String> },
    /// A plan has to begin with actions of an earlier one, and this action is not the next of them; without a task: the
    /// branch would end before it.
    NotKept {
        task: Option<String>,
        /// Position of the next one.
        index: usize,
        kept: String,
    },
}

/// Why a geometric action has no further solution.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionRefusal {
    /// `pick(PR2, RED_CUBE)`.
    pub call: String,
    /// Solutions already given for this call in this world state; 0 means that it is not feasible at all.
    pub found_before: u32,
    /// Whether every choice was tried; else the budget of candidates ended it.
    pub exhausted: bool,
    /// Candidates tried in all.
    pub tried: u32,
    /// What stopped them, most frequent first.
    pub causes: Vec<CauseCount>,
}

impl ActionRefusal {
    /// Returns the refusal of a call that its arguments or the world state rule out, with the sentence that says why.
    pub fn not_applicable(call: String, why: String) -> Self {
        ActionRefusal {
            call,
            found_before: 0,
            exhausted: true,
            tried: 0,
            causes: vec![CauseCount {
                sub_action: String::new(),
                cause: Cause::NotApplicable(why),
                count: 1,
            }],
        }
    }
}

/// How many candidates failed for one cause.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseCount {
    /// The sub-action that failed; empty for a condition of the whole action.
    pub sub_action: String,
    pub cause: Cause,
    pub count: u32,
}

/// What stopped a candidate of a geometric action.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The arguments do not allow the action at all: a sentence says why.
    NotApplicable(String),
    /// The arm has no configuration with the tool there.
    OutOfReach { arm: String },
    /// Two bodies overlap in the end state.
    Collision { a: String, b: String },
    /// The tool can't follow the straight line.
    NoStraightMotion { arm: String },
    /// The motion planner found no path within its samples.
    NoPath { arm: String, samples: u32 },
    /// The arms found no motion into a posture within the planner's samples.
    NoPosture { posture: String, samples: u32 },
    /// The base found no way there.
    NoWay { looked: usize },
    /// A required fact does not hold in the end state: `isReachable(RED_CUBE, BOB)`.
    Fact(String),
    /// A constraint of the domain's operator does not hold in the end state.
    Constraint(String),
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::NotApplicable(why) => write!(f, "{why}"),
            Cause::OutOfReach { arm } => write!(f, "out of reach of the {arm} arm"),
            Cause::Collision { a, b } => write!(f, "{a} collides with {b}"),
            Cause::NoStraightMotion { arm } => write!(f, "no straight motion of the {arm} arm"),
            Cause::NoPath { arm, samples } => write!(f, "no path for the {arm} arm within {samples} samples"),
            Cause::NoPosture { posture, samples } => {
                write!(
                    f,
                    "no motion of the arms into the posture {posture} within {samples} samples"
                )
            }
            Cause::NoWay { looked } => write!(f, "no way for the base, {looked} places looked at"),
            Cause::Fact(fact) => write!(f, "{fact} would not hold"),
            Cause::Constraint(constraint) => write!(f, "the constraint {constraint} would not hold"),
        }
    }
}

impl fmt::Display for CauseCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.sub_action.is_empty() {
            write!(f, "{}: ", self.sub_action)?;
        }
        write!(f, "{}", self.cause)
    }
}

/// The headline: without how many candidates were tried, and what stopped them.
impl fmt::Display for ActionRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let further = if self.found_before > 0 { "further " } else { "" };
        write!(f, "{}: no {further}solution", self.call)?;
        // Nothing was tried: what the arguments do not allow is the whole reason.
        if self.tried == 0
            && let Some(first) = self.causes.first()
        {
            write!(f, ": {first}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Precondition { task, literal, met, .. } => {
                write!(f, "{task}: {literal} is false")?;
                if met.is_empty() { Ok(()) } else { write!(f, " ({met})") }
            }
            Refusal::NoBinding {
                task,
                variable,
                candidates,
                filter,
                ..
            } => {
                let colon = if filter.is_empty() { "" } else { ": " };
                write!(
                    f,
                    "{task}: none of {candidates} entities can be {variable}{colon}{filter}"
                )
            }
            Refusal::NullArgument {
                task,
                position,
                argument,
                ..
            } => write!(f, "{task}: its argument {}, {argument}, is NULL", position + 1),
            Refusal::BadNumber {
                task,
                what,
                value: Some(value),
            } => write!(f, "{task}: its {what} is {value}, and must be 0 or more"),
            Refusal::BadNumber {
                task,
                what,
                value: None,
            } => {
                write!(
                    f,
                    "{task}: its {what} has no value: something in it is NULL, or not finite"
                )
            }
            Refusal::DurationOrder { task, least, most } => {
                write!(f, "{task}: its least duration {least} is above its most {most}")
            }
            Refusal::Geometry(refusal) => write!(f, "{refusal}"),
            Refusal::TooCostly { cost, rest, bound } if *rest > 0.0 => write!(
                f,
                "a cost of {cost:.4} and at least {rest:.4} to come are not below the best plan's {bound:.4}"
            ),
            Refusal::TooCostly { cost, bound, .. } => {
                write!(f, "a cost of {cost:.4} is not below the best plan's {bound:.4}")
            }
            Refusal::TooDeep { task, depth, chain } => {
                let chain_text = chain.join(" > ");
                match chain.first() {
                    Some(first) if chain.len() > 1 && name(first) == name(task) => write!(
                        f,
                        "{} goes on below itself, more than {depth} methods deep: {chain_text}",
                        name(task)
                    ),
                    _ => write!(f, "{task}: more than {depth} methods deep, at last {chain_text}"),
                }
            }
            Refusal::NotKept {
                task: Some(task),
                index,
                kept,
            } => write!(f, "{task} is not the next kept action, {index} {kept}"),
            Refusal::NotKept {
                task: None,
                index,
                kept,
            } => write!(f, "nothing is left to do before the kept action {index} {kept}"),
            Refusal::LookAhead { task, literal, met, .. } => {
                write!(f, "{task} can't be done any more: {literal} is false")?;
                if !met.is_empty() {
                    write!(f, " ({met})")?;
                }
                Ok(())
            }
            Refusal::Cycle { chain } => {
                let task = chain.first().map_or("", String::as_str);
                write!(f, "{task} comes back to itself in the same state")?;
                if chain.len() > 2 {
                    write!(f, ": {}", chain.join(" > "))?;
                }
                Ok(())
            }
        }
    }
}

/// Returns `Pick` of `Pick(PR2, CUP)`.
fn name(task: &str) -> &str {
    task.split_once('(').map_or(task, |(name, _)| name)
}

impl Refusal {
    /// Returns the kind in one word, as traces have it.
    pub fn kind(&self) -> &'static str {
        match self {
            Refusal::Precondition { .. } => "precondition",
            Refusal::NoBinding { .. } => "no-binding",
            Refusal::NullArgument { .. } => "null-argument",
            Refusal::BadNumber { .. } | Refusal::DurationOrder { .. } => "number",
            Refusal::Geometry(_) => "geometry",
            Refusal::TooCostly { .. } => "too-costly",
            Refusal::TooDeep { .. } => "too-deep",
            Refusal::LookAhead { .. } => "look-ahead",
            Refusal::Cycle { .. } => "cycle",
            Refusal::NotKept { .. } => "not-kept",
        }
    }

    /// Returns what the domain's author can change: the refusal without the arguments and values of this branch.
    pub fn rule(&self) -> String {
        match self {
            Refusal::Precondition { task, rule, .. } => format!("{}: {rule} is false", name(task)),
            Refusal::NoBinding {
                task, variable, rule, ..
            } => {
                let colon = if rule.is_empty() { "" } else { ": " };
                format!("{}: no entity can be {variable}{colon}{rule}", name(task))
            }
            Refusal::NullArgument {
                task, position, rule, ..
            } => format!("{}: its argument {}, {rule}, is NULL", name(task), position + 1),
            Refusal::BadNumber { task, what, value } => {
                let why = if value.is_some() { "is below 0" } else { "has no value" };
                format!("{}: its {what} {why}", name(task))
            }
            Refusal::DurationOrder { task, .. } => format!("{}: its least duration is above its most", name(task)),
            Refusal::Geometry(refusal) => {
                let further = if refusal.found_before > 0 { "further " } else { "" };
                format!("{}: no {further}solution", name(&refusal.call))
            }
            Refusal::TooCostly { .. } => "a plan that begins so can't be cheaper than the best one".into(),
            Refusal::TooDeep { task, depth, .. } => {
                format!("{} goes on below itself, more than {depth} methods deep", name(task))
            }
            Refusal::NotKept { task, .. } => match task {
                Some(task) => format!("{} is not the next of the kept actions", name(task)),
                None => "nothing is left to do before all kept actions are done".into(),
            },
            Refusal::LookAhead { task, rule, .. } => format!("{}: {rule} can't be made true any more", name(task)),
            Refusal::Cycle { chain } => {
                let task = chain.first().map_or("", |t| name(t));
                format!("{task} comes back to itself in the same state")
            }
        }
    }
}

impl Refusal {
    /// Returns what tells this refusal from others of its [`Refusal::rule`]: the arguments and values met.
    fn instance(&self) -> String {
        match self {
            Refusal::Precondition { task, met, .. } | Refusal::LookAhead { task, met, .. } if !met.is_empty() => {
                format!("{task} ({met})")
            }
            Refusal::Precondition { task, literal, .. } | Refusal::LookAhead { task, literal, .. } => {
                format!("{task}: {literal}")
            }
            Refusal::NoBinding { task, filter, .. } => {
                let colon = if filter.is_empty() { "" } else { ": " };
                format!("{task}{colon}{filter}")
            }
            Refusal::NullArgument { argument, .. } => argument.clone(),
            Refusal::DurationOrder { task, .. } => task.clone(),
            Refusal::BadNumber { task, value, .. } => match value {
                Some(value) => format!("{task}: {value}"),
                None => task.clone(),
            },
            Refusal::Geometry(refusal) => refusal.call.clone(),
            Refusal::TooDeep { chain, .. } | Refusal::Cycle { chain } => chain.join(" > "),
            Refusal::TooCostly { .. } | Refusal::NotKept { .. } => self.to_string(),
        }
    }
}

impl Cause {
    /// Says whether the domain or the action asks for it by name; all other causes are bodies and motions.
    fn is_asked(&self) -> bool {
        matches!(self, Cause::Fact(_) | Cause::Constraint(_))
    }
}

/// The failures of a whole search, grouped, and the deepest point reached.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WhyNot {
    /// The longest sequence of actions that a branch reached: `Pick(PR2, RED_CUBE)`.
    pub deepest: Vec<String>,
    /// What ended that branch.
    pub stuck: Option<String>,
    /// By refusal as a sentence, in the order met.
    reasons: IndexMap<String, Reason>,
    rules: BTreeSet<String>,
    /// Refusals not kept because there were too many different ones.
    pub not_kept: u64,
}

/// What ended some branches.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reason {
    /// Branches ended.
    pub n_branches: u64,
    /// Candidates of a geometric action tried in all of them; 0 where geometry is not the reason.
    pub tried: u64,
    /// Whether some of these branches left candidates untried.
    pub is_cut: bool,
    /// What the domain's author can change.
    rule: String,
    /// Arguments and values; empty where there were too many different ones.
    pub instance: String,
    /// What stopped the candidates, how many, and whether it was asked for by name.
    causes: IndexMap<String, (u64, bool)>,
}

impl Reason {
    /// Returns what stopped candidates and how many of them, most frequent first; ties in the order met.
    pub fn causes(&self) -> Vec<(&str, u64)> {
        let mut all: Vec<(&str, u64)> = self.causes.iter().map(|(k, (n, _))| (k.as_str(), *n)).collect();
        all.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        all
    }

    /// Says whether the domain or the action asks by name for what this cause says does not hold.
    pub fn is_asked(&self, cause: &str) -> bool {
        self.causes.get(cause).is_some_and(|(_, asked)| *asked)
    }

    /// Adds another reason's branches to this one.
    fn join(&mut self, other: &Reason) {
        self.n_branches += other.n_branches;
        self.tried += other.tried;
        self.is_cut |= other.is_cut;
        for (cause, (n, asked)) in &other.causes {
            let entry = self.causes.entry(cause.clone()).or_default();
            *entry = (entry.0 + n, *asked);
        }
    }
}

/// Reasons of one rule.
#[derive(Debug, Clone, PartialEq)]
pub struct ReasonGroup<'a> {
    /// What the domain's author can change: `Pick: O.isReachable >> A is false`.
    pub rule: &'a str,
    /// All together.
    pub total: Reason,
    /// Each as a sentence; those that ended most branches first, ties in the order met.
    pub reasons: Vec<(&'a str, &'a Reason)>,
}

/// Different refusals kept; a search with more has its reasons on top long before.
const MAX_REASONS: usize = 2000;

impl WhyNot {
    /// Counts a refusal and returns the number of its reason, if it is kept. Those of one geometric call are one reason,
    /// whatever stopped its candidates.
    pub fn add(&mut self, refusal: &Refusal) -> Option<usize> {
        let mut text = refusal.to_string();
        let mut rule = String::new();
        if !self.reasons.contains_key(&text) {
            rule = refusal.rule();
            if !self.rules.insert(rule.clone()) && self.reasons.len() >= MAX_REASONS {
                // From here on the rules alone are told apart: there are as many as the domain has tests. The first
                // reason of each is kept with its values all the same.
                text.clone_from(&rule);
            }
            if self.reasons.len() >= 2 * MAX_REASONS && !self.reasons.contains_key(&text) {
                self.not_kept += 1;
                return None;
            }
        }
        let entry = self.reasons.entry(text);
        let (number, is_instance) = (entry.index(), *entry.key() != rule);
        let reason = entry.or_default();
        if reason.n_branches == 0 {
            reason.rule = rule;
            reason.instance = if is_instance { refusal.instance() } else { String::new() };
        }
        reason.n_branches += 1;
        if let Refusal::Geometry(geometry) = refusal
            && geometry.tried > 0
        {
            reason.tried += u64::from(geometry.tried);
            reason.is_cut |= !geometry.exhausted;
            for cause in &geometry.causes {
                let entry = reason.causes.entry(cause.to_string()).or_default();
                *entry = (entry.0 + u64::from(cause.count), cause.cause.is_asked());
            }
        }
        Some(number)
    }

    /// Counts a refusal that is the same as one before, by the number that [`WhyNot::add`] has given.
    pub fn add_again(&mut self, number: Option<usize>) {
        match number.and_then(|n| self.reasons.get_index_mut(n)) {
            Some((_, reason)) => reason.n_branches += 1,
            None => self.not_kept += 1,
        }
    }

    /// Returns the reasons, those that ended most branches first; ties in the order met.
    pub fn reasons(&self) -> Vec<(&str, &Reason)> {
        let mut all: Vec<(&str, &Reason)> = self.reasons.iter().map(|(text, r)| (text.as_str(), r)).collect();
        all.sort_by_key(|(_, r)| std::cmp::Reverse(r.n_branches));
        all
    }
}

impl WhyNot {
    /// Returns the sentence of a reason, by the number that [`WhyNot::add`] has given.
    pub fn sentence(&self, number: usize) -> Option<&str> {
        self.reasons.get_index(number).map(|(text, _)| text.as_str())
    }

    /// Returns the reasons by what the domain's author can change, what ended most branches first; ties in the order met.
    pub fn groups(&self) -> Vec<ReasonGroup<'_>> {
        let mut groups: IndexMap<&str, ReasonGroup<'_>> = IndexMap::new();
        for (text, reason) in &self.reasons {
            let group = groups.entry(&reason.rule).or_insert_with(|| ReasonGroup {
                rule: &reason.rule,
                total: Reason::default(),
                reasons: Vec::new(),
            });
            group.total.join(reason);
            group.reasons.push((text, reason));
        }
        let mut groups: Vec<ReasonGroup<'_>> = groups.into_values().collect();
        for group in &mut groups {
            group.reasons.sort_by_key(|(_, r)| std::cmp::Reverse(r.n_branches));
        }
        groups.sort_by_key(|g| std::cmp::Reverse(g.total.n_branches));
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(causes: &[(Cause, u32)], tried: u32) -> Refusal {
        let causes = causes.iter().map(|(cause, count)| CauseCount {
            sub_action: "place".into(),
            cause: cause.clone(),
            count: *count,
        });
        Refusal::Geometry(ActionRefusal {
            call: "place(PR2, CUP, TRAY)".into(),
            found_before: 0,
            exhausted: tried < 200,
            tried,
            causes: causes.collect(),
        })
    }

    #[test]
    fn refusals_of_one_call_are_one_reason() {
        let far = Cause::OutOfReach { arm: "left".into() };
        let hit = Cause::Collision {
            a: "CUP".into(),
            b: "BOX".into(),
        };
        let mut why = WhyNot::default();
        why.add(&place(&[(far.clone(), 30)], 30));
        why.add(&place(&[(hit, 120), (far, 80)], 200));
        let reasons = why.reasons();
        let [(text, reason)] = reasons.as_slice() else {
            panic!("one reason, not {reasons:?}")
        };
        assert_eq!(*text, "place(PR2, CUP, TRAY): no solution");
        assert_eq!((reason.n_branches, reason.tried, reason.is_cut), (2, 230, true));
        let causes = [
            ("place: CUP collides with BOX", 120),
            ("place: out of reach of the left arm", 110),
        ];
        assert_eq!(reason.causes(), causes);
    }
}
