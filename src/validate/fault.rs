//! Why a plan is refused: typed, with numbers; the words are here and nowhere else.

use std::fmt;

/// The first thing found wrong with a plan, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// What is wrong.
    pub kind: Box<Kind>,
    /// Where in the plan.
    pub place: Box<Place>,
}

/// Where in a plan something is wrong; as much of it as makes sense.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Place {
    /// Index and text of the action, `Pick(PR2, CUP)`.
    pub action: Option<(usize, String)>,
    /// Position and name of the sub-action, `engage`.
    pub sub_action: Option<(usize, String)>,
    /// Seconds from the plan's start.
    pub time: Option<f64>,
    /// Tasks from the root of the decomposition down to the node.
    pub tasks: Vec<String>,
}

/// Result of one check.
pub(super) type Checked<T> = Result<T, Fault>;

impl Fault {
    /// Returns the fault's stable name, `joint-limit`.
    pub fn code(&self) -> &'static str {
        self.kind.code()
    }

    pub(super) fn in_action(mut self, index: usize, text: &str) -> Self {
        self.place.action.get_or_insert_with(|| (index, text.to_owned()));
        self
    }

    pub(super) fn in_sub_action(mut self, index: usize, name: &str) -> Self {
        self.place.sub_action.get_or_insert_with(|| (index, name.to_owned()));
        self
    }

    pub(super) fn at_time(mut self, seconds: f64) -> Self {
        self.place.time.get_or_insert(seconds);
        self
    }

    pub(super) fn under_task(mut self, task: &str) -> Self {
        self.place.tasks.insert(0, task.to_owned());
        self
    }

    /// Shifts a time that was counted from the start of a part of the plan.
    pub(super) fn later_by(mut self, seconds: f64) -> Self {
        if let Some(t) = &mut self.place.time {
            *t += seconds;
        }
        self
    }
}

impl From<Kind> for Fault {
    fn from(kind: Kind) -> Self {
        Fault {
            kind: Box::new(kind),
            place: Box::default(),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((index, text)) = &self.place.action {
            write!(f, "action {index} `{text}`, ")?;
        }
        if let Some((index, name)) = &self.place.sub_action {
            write!(f, "sub-action {index} `{name}`, ")?;
        }
        if let Some(time) = self.place.time {
            write!(f, "at {time:.3} s, ")?;
        }
        if !self.place.tasks.is_empty() {
            write!(f, "task {}, ", self.place.tasks.join(" / "))?;
        }
        write!(f, "{}: {}", self.code(), self.kind)
    }
}

impl std::error::Error for Fault {}

macro_rules! kinds {
    ($($(#[doc = $doc:literal])* $name:ident { $($field:ident : $ty:ty),* $(,)? } = $code:literal, $words:literal;)*) => {
        /// What can be wrong with a plan. Metres, radians, seconds.
        #[derive(Debug, Clone, PartialEq, thiserror::Error)]
        pub enum Kind {
            $($(#[doc = $doc])* #[error($words)] $name { $($field: $ty),* },)*
        }

        impl Kind {
            /// Returns the stable name, `joint-limit`.
            pub fn code(&self) -> &'static str {
                match self { $(Kind::$name { .. } => $code,)* }
            }

            /// Every code, in the order of `docs/validate.md`.
            pub const CODES: &[&str] = &[$($code),*];
        }
    };
}

kinds! {
    // The document itself.
    Format { found: String } = "format", "the document's format is `{found}`, not `sgap-plan`";
    Version { found: u32, known: u32 } = "version", "the document has version {found}, this program reads {known}";
    NotFinite { what: String } = "not-finite", "{what} is not a finite number";
    Quaternion { what: String, length: f64 } = "quaternion", "the quaternion of {what} has length {length}, not 1";
    Index { position: usize, index: usize } = "index", "the action at position {position} says that it is action {index}";
    UnknownName { what: &'static str, name: String } = "unknown-name", "there is no {what} `{name}`";
    ArgumentCount { task: String, expected: usize, found: usize } = "argument-count",
        "`{task}` takes {expected} arguments, not {found}";
    Argument { text: String, expected: String } = "argument", "`{text}` is not {expected}";
    Agents { expected: String, found: String } = "agents", "the agents of this action are {expected}, not {found}";
    Task { expected: String, found: String } = "task", "the plan is for `{found}`, the goal is `{expected}`";

    // Symbolic replay.
    Precondition { test: String } = "precondition", "the precondition does not hold: {test}";
    Constraint { test: String } = "constraint", "the world that the action leads to breaks a constraint: {test}";
    Changes { attribute: String, expected: String, found: String } = "changes",
        "`{attribute}`: the action leaves {expected}, the document says {found}";
    CostUndefined {} = "cost-undefined", "the cost has no value in this state";
    CostNegative { cost: f64 } = "cost-negative", "the cost {cost} is negative";
    Cost { expected: f64, found: f64 } = "cost", "the action costs {expected}, the document says {found}";
    CostTotal { expected: f64, found: f64 } = "cost-total", "the actions cost {expected} together, the document says {found}";
    CostParts { expected: String, found: String } = "cost-parts", "the cost consists of {expected}, the document says {found}";
    CostPart { part: String, what: &'static str, expected: f64, found: f64 } = "cost-part",
        "the {what} of `{part}` is {expected}, the document says {found}";
    CostWhole { expected: f64, found: f64 } = "cost-whole", "the parts of the cost make {expected}, the document says {found}";
    SequenceUndecided { rule: String, budget: u64 } = "sequence-undecided",
        "{budget} actions were tried for the sequence `{rule}`, and there are more";
    DurationUndefined {} = "duration-undefined", "the duration has no value in this state";
    Duration { expected: [f64; 2], found: [f64; 2] } = "duration",
        "the action lasts {expected:?} s (least, most), the document says {found:?}";
    GeometryMissing { projection: String } = "geometry-missing", "the action projects `{projection}` but has no motions";
    GeometryUnexpected {} = "geometry-unexpected", "a purely symbolic action has motions";
    GeometryMismatch { what: &'static str, expected: String, found: String } = "geometry-mismatch",
        "the {what} should be `{expected}`, the document says `{found}`";
    /// The validator has no definition of its own for this geometric action, so it can't agree.
    GeometryUnchecked { action: String } = "geometry-unchecked", "no independent definition of the geometric action `{action}`";

    // Decomposition.
    NodeShape { what: &'static str } = "node-shape", "the node does not fit into the tree: {what}";
    NoSuchDecomposition { index: usize, count: usize } = "no-such-decomposition",
        "decomposition {index} was applied, the task has {count}";
    DecompositionPrecondition { index: usize, test: String } = "decomposition-precondition",
        "the preconditions of decomposition {index} do not hold when it is reached: {test}";
    GoalNotHeld { test: String } = "goal-not-held", "the task was skipped but its goal does not hold: {test}";
    GoalHeldAlready {} = "goal-held-already", "the task's goal holds when it is reached, so nothing was to be done";
    Subtasks { index: usize, children: String } = "subtasks",
        "no choice of the variables of decomposition {index} gives the subtasks {children} in an allowed order";
    SubtasksUndecided { index: usize, budget: usize } = "subtasks-undecided",
        "{budget} choices of the variables of decomposition {index} were tried, none fits, and there are more";
    Leaves { expected: usize, found: String } = "leaves", "the tree's next action should be {expected}, it is {found}";
    LeafMismatch { leaf: String, action: String } = "leaf-mismatch", "the tree says `{leaf}`, the plan says `{action}`";

    // Schedule.
    LinkIndex { before: usize, after: usize } = "link-index", "a link from action {before} to action {after} is not from an earlier one to a later one of the plan";
    LinkRedundant { before: usize, after: usize } = "link-redundant", "the link from {before} to {after} follows from others";
    LinkReason { before: usize, after: usize, reason: String } = "link-reason",
        "the link from {before} to {after} has no such reason: {reason}";
    LinkMissing { after: usize, condition: String } = "link-missing",
        "the links allow action {after} before the actions that it needs: {condition}";
    OrderMissing { before: usize, after: usize } = "order-missing",
        "the domain orders action {before} before action {after}, but no links say so";
    LinkRace { moved: usize, broken: usize, condition: String } = "link-race",
        "an order that the links allow, with action {moved} moved, breaks action {broken}: {condition}";
    OutcomeRace { moved: usize, attribute: String } = "outcome-race",
        "an order that the links allow, with action {moved} moved, ends with another `{attribute}`";
    MotionOrder { before: usize, after: usize } = "motion-order",
        "the motions of {after} start in the world that {before} leaves, but no link says so";
    Stream { agent: String, expected: Vec<usize>, found: Vec<usize> } = "stream",
        "the stream of `{agent}` should be {expected:?}, it is {found:?}";
    Start { expected: f64, found: f64 } = "start", "the earliest start is {expected:.6} s, the document says {found:.6} s";
    End { expected: f64, found: f64 } = "end", "the action ends at {expected:.6} s, the document says {found:.6} s";
    Makespan { expected: f64, found: f64 } = "makespan", "the last action ends at {expected:.6} s, the document says {found:.6} s";

    // Trajectories.
    TrajectoryShape { what: String } = "trajectory-shape", "the trajectory is malformed: {what}";
    JointForeign { joint: String, arm: String } = "joint-foreign", "joint `{joint}` may not move here, it is not part of {arm}";
    TimeOrder { index: usize, before: f64, time: f64 } = "time-order", "time {index} is {time}, after {before}";
    ConfigurationJump { joint: String, expected: f64, found: f64 } = "configuration-jump",
        "the trajectory starts with `{joint}` at {found:.6}, it is at {expected:.6}";
    JointLimit { joint: String, value: f64, lower: f64, upper: f64 } = "joint-limit",
        "`{joint}` is at {value:.6}, outside [{lower:.6}, {upper:.6}]";
    Speed { joint: String, speed: f64, limit: f64 } = "speed", "`{joint}` moves at {speed:.4} per second, its limit is {limit:.4}";
    Acceleration { joint: String, acceleration: f64, limit: f64 } = "acceleration",
        "`{joint}` accelerates at {acceleration:.4} per second squared, its limit is {limit:.4}";
    Jerk { joint: String, jerk: f64, limit: f64 } = "jerk",
        "`{joint}` changes its acceleration by {jerk:.4} per second cubed, its limit is {limit:.4}";
    Drive { sideways: f64, turned: f64 } = "drive",
        "a base that moves along its heading goes {sideways:.6} m sideways and turns {turned:.6} rad from one sample to the next";
    NotStraight { distance: f64, angle: f64 } = "not-straight",
        "the tool leaves the straight line by {distance:.4} m and {angle:.4} rad";
    TooLong { budget: u64 } = "too-long", "more than {budget} configurations would have to be checked";
    Collision { a: String, b: String, depth: f64 } = "collision", "`{a}` is {depth:.4} m deep in `{b}`";

    // Objects.
    HeldAlready { object: String, by: String } = "held-already", "`{object}` is already held by {by}";
    HandOccupied { arm: String, object: String } = "hand-occupied", "{arm} already holds `{object}`";
    GraspMissed { grasp: String, distance: f64, angle: f64 } = "grasp-missed",
        "the tool is {distance:.4} m and {angle:.4} rad away from grasp `{grasp}`";
    FingersOpen { finger: String, gap: f64, width: f64 } = "fingers-open",
        "the fingers are {gap:.4} m apart by `{finger}`, the grasp is {width:.4} m wide";
    TargetMissed { what: &'static str, distance: f64, angle: f64 } = "target-missed",
        "the sub-action ends {distance:.4} m and {angle:.4} rad away from {what}";
    ObjectJump { object: String, distance: f64, angle: f64 } = "object-jump", "`{object}` jumps by {distance:.4} m and {angle:.4} rad";
    NotHeld { object: String, by: String } = "not-held", "`{object}` is not held by {by}";
    FingersClosed { finger: String, gap: f64, width: f64 } = "fingers-closed",
        "the fingers let go {gap:.4} m apart by `{finger}`, the grasp is {width:.4} m wide";
    NotStanding { object: String, on: String, why: String } = "not-standing", "`{object}` does not stand on {on}: {why}";
    Placement { what: &'static str, distance: f64, angle: f64 } = "placement",
        "the placement's {what} disagrees by {distance:.4} m and {angle:.4} rad";
    InTheAir { object: String } = "in-the-air", "`{object}` is neither held nor standing on anything";
    Handling { what: String } = "handling", "{what}";

    // Facts.
    FactUnchecked { attribute: String, fact: String } = "fact-unchecked",
        "`{attribute}` is read from the fact `{fact}`, of which there is no independent definition";
    FactUnconfirmed { fact: String } = "fact-unconfirmed", "{fact} is claimed and can't be confirmed";
    FactContradicted { fact: String } = "fact-contradicted", "{fact} is denied and holds clearly";
}
