//! Geometric actions as data (thesis 3.2.3 and 3.3.2, formulas 3.3, 3.4, 3.8).
//!
//! An action is: what is to be chosen, then sub-actions, each *(pre-conditions; search space; final constraints)*. One solver runs
//! them all (`solve`). Not here: descriptions written by users in the language itself.

/// What an argument of the action stands for; its position is the argument's position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The agent that acts.
    Agent,
    /// The object that is handled.
    Object,
    /// The entity on which it is put.
    Support,
    /// The agent for whom it is done.
    Receiver,
}

/// What the solver has to choose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// An arm whose hand is empty, and a grasp of the object that its gripper can do.
    ArmAndGrasp,
    /// The arm is the one that holds the object, the grasp is the one it is held by. A support face of the support, a stable
    /// orientation, a position (x, y) on the face and a yaw.
    Placement,
}

/// Which degrees of freedom may move (thesis: search spaces); everything else is fixed, a held object moves with its hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    /// The arm's joints, anywhere (thesis: Fix_h, OFix_h).
    Arm,
    /// The arm's joints such that the tool follows a straight line.
    ArmStraight,
    /// The fingers (thesis: EEFix_h).
    Gripper,
}

/// What must hold when the sub-action starts (thesis: geometric pre-conditions).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// The hand is empty (thesis: HFree_h).
    HandFree,
    /// The object is in the hand (thesis: HFull_h).
    HandFull,
}

/// Where the sub-action ends (thesis: final constraints).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Until {
    /// The tool stands [`APPROACH`] before the grasp, against its direction (thesis: HApp).
    BeforeGrasp,
    /// The tool is at the grasp (thesis: HGrasp).
    AtGrasp,
    /// The fingers are as wide as they can be (thesis: EEO).
    GripperOpen,
    /// The fingers hold the object at the grasp's width (thesis: EEC).
    GripperClosed,
    /// The object is [`APPROACH`] above where it was (thesis: OFree).
    Lifted,
    /// The object is [`APPROACH`] above its placement (thesis: HAppr).
    AbovePlacement,
    /// The object is at its placement (thesis: HRel).
    AtPlacement,
    /// The tool stands [`APPROACH`] back from the object, against the grasp's direction (thesis: EEFree).
    AwayFromObject,
}

/// What changes hands when the motion is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    Attach,
    Detach,
}

/// A fact about the handled object that must hold for the receiver in the action's final state (thesis: AReachO).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Required {
    ReachableByReceiver,
}

/// One sub-action (thesis: SAD).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SubAction {
    pub name: &'static str,
    pub when: &'static [Condition],
    pub space: Space,
    pub until: Until,
    pub change: Option<Change>,
}

/// A geometric action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// Names under which domains project onto it; the first is ours, others are the thesis's.
    pub names: &'static [&'static str],
    pub roles: &'static [Role],
    pub choice: Choice,
    /// Tested as soon as the placement is known, before any motion, and again in the final state.
    pub required: &'static [Required],
    pub sub_actions: &'static [SubAction],
}

/// Distance of approach, lift and retreat [m] (thesis 3.3.2, footnote 3).
pub const APPROACH: f64 = 0.10;

const fn sub(
    name: &'static str,
    when: &'static [Condition],
    space: Space,
    until: Until,
    change: Option<Change>,
) -> SubAction {
    SubAction {
        name,
        when,
        space,
        until,
        change,
    }
}

/// Formula 3.3. `open` is not in it: the thesis's pre-condition EEOpen is brought about instead of refused; it is skipped
/// where the fingers are open already.
const PICK: Description = Description {
    names: &["pick"],
    roles: &[Role::Agent, Role::Object],
    choice: Choice::ArmAndGrasp,
    required: &[],
    sub_actions: &[
        sub("open", &[Condition::HandFree], Space::Gripper, Until::GripperOpen, None),
        sub("approach", &[Condition::HandFree], Space::Arm, Until::BeforeGrasp, None),
        sub("engage", &[], Space::ArmStraight, Until::AtGrasp, None),
        sub("grasp", &[], Space::Gripper, Until::GripperClosed, Some(Change::Attach)),
        sub(
            "disengage",
            &[Condition::HandFull],
            Space::ArmStraight,
            Until::Lifted,
            None,
        ),
    ],
};

/// The sub-actions of formulas 3.4 and 3.8.
const PUT_DOWN: &[SubAction] = &[
    sub(
        "approach",
        &[Condition::HandFull],
        Space::Arm,
        Until::AbovePlacement,
        None,
    ),
    sub("place", &[], Space::ArmStraight, Until::AtPlacement, None),
    sub("release", &[], Space::Gripper, Until::GripperOpen, Some(Change::Detach)),
    sub(
        "retract",
        &[Condition::HandFree],
        Space::ArmStraight,
        Until::AwayFromObject,
        None,
    ),
];

/// Formula 3.4.
const PLACE: Description = Description {
    names: &["place"],
    roles: &[Role::Agent, Role::Object, Role::Support],
    choice: Choice::Placement,
    required: &[],
    sub_actions: PUT_DOWN,
};

/// Formula 3.8. The fact is asked for where the object is put, which is what the formula's approach constraint is for.
const PLACE_REACHABLE: Description = Description {
    names: &["placeReachable", "placeR"],
    roles: &[Role::Agent, Role::Object, Role::Support, Role::Receiver],
    choice: Choice::Placement,
    required: &[Required::ReachableByReceiver],
    sub_actions: PUT_DOWN,
};

/// Every geometric action there is.
pub const ACTIONS: &[Description] = &[PICK, PLACE, PLACE_REACHABLE];

/// Returns the action of that name.
pub fn find(name: &str) -> Option<&'static Description> {
    ACTIONS.iter().find(|d| d.names.contains(&name))
}
