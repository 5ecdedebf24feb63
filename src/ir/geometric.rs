//! Geometric actions as data (thesis 3.2.3 and 3.3.2, formulas 3.3, 3.4, 3.8): what is to be chosen, then sub-actions, each
//! *(pre-conditions; search space; final constraints)*.
//!
//! `check` makes them of the language's `geometric` items, those of the prelude among them; one solver runs them all, and
//! the validator looks at the same data with code of its own.

use super::{ChoiceId, ParamId, RequestId};

/// Distance of approach, lift and retreat where none is written [m] (thesis 3.3.2, footnote 3).
pub const APPROACH: f64 = 0.10;

/// A geometric action (thesis: geometric action description).
#[derive(Debug, Clone, PartialEq)]
pub struct Geometric {
    /// As plans name it.
    pub name: String,
    pub params: Vec<GeometricParam>,
    pub choices: Vec<Choice>,
    /// In the order in which they are done; there is one at least.
    pub sub_actions: Vec<SubAction>,
}

/// A parameter; all of them are entities of the world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GeometricParam {
    pub name: String,
    pub role: Role,
}

/// What an argument has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Agent,
    /// An object of the world.
    Thing,
    /// Any entity: only facts speak of it.
    Entity,
}

/// A variable that the solver gives a value.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub name: String,
    pub from: ChoiceSet,
}

/// What a choice is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChoiceSet {
    /// The arms of an agent.
    Arms(ParamId),
    /// The grasps of an object.
    Grasps(ParamId),
    /// The level support faces of an object.
    Supports(ParamId),
    /// The orientations in which an object stands by itself.
    Stable(ParamId),
    /// The points (x, y) of a support face.
    Points(ChoiceId),
    /// The middle of a support face alone.
    Centre(ChoiceId),
    /// The angles about the vertical.
    Angles,
    /// The places on the floor from which an agent reaches an entity, with a heading each (thesis: OnTarget).
    Stands { agent: ParamId, entity: ParamId },
}

/// One sub-action (thesis: SAD).
#[derive(Debug, Clone, PartialEq)]
pub struct SubAction {
    pub name: String,
    pub when: Vec<Condition>,
    pub space: Space,
    pub until: Target,
    /// Facts that hold when it is over.
    pub facts: Vec<FactOf>,
    pub change: Option<Change>,
}

/// What must hold when a sub-action starts (thesis: geometric pre-conditions).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Condition {
    /// The hand is empty (thesis: HFree_h).
    Free(ChoiceId),
    /// The object is in the hand (thesis: HFull_h).
    Holds(ChoiceId, ParamId),
    Fact(FactOf),
}

/// A fact or request of the prelude about entities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactOf {
    pub request: RequestId,
    pub args: Vec<ParamId>,
}

/// Which degrees of freedom may move (thesis: search spaces); everything else is fixed, what is held moves with its hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    /// The joints of an arm, anywhere (thesis: Fix_h, OFix_h).
    Arm(ChoiceId),
    /// The joints of an arm such that its tool follows a straight line.
    ArmStraight(ChoiceId),
    /// The fingers (thesis: EEFix_h).
    Gripper(ChoiceId),
    /// The joints of all arms of an agent (thesis: UpperBody).
    Body(ParamId),
    /// The base of an agent (thesis: UpFix).
    Base(ParamId),
}

impl Space {
    /// Returns the arm that moves, or whose fingers do; `None` where that is no choice.
    pub fn arm(self) -> Option<ChoiceId> {
        match self {
            Space::Arm(arm) | Space::ArmStraight(arm) | Space::Gripper(arm) => Some(arm),
            Space::Body(_) | Space::Base(_) => None,
        }
    }
}

/// Where a sub-action ends (thesis: final constraints). The arm is that of the search space; distances in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The fingers are as wide as they can be (thesis: EEO).
    Open,
    /// The fingers hold an object at the grasp's width (thesis: EEC); without one they are as narrow as they can be.
    Closed(Option<ChoiceId>),
    /// The tool is so far before the grasp, against its direction (thesis: HApp; at 0 HGrasp).
    Grasp { grasp: ChoiceId, before: f64 },
    /// The tool is so far above where it was (thesis: OFree).
    Up(f64),
    /// The tool is so far back from where it was, against its direction (thesis: EEFree).
    Back(f64),
    /// The object in the hand is so far above its placement (thesis: HAppr; at 0 HRel).
    Placement { place: Place, above: f64 },
    /// The arms are in their agent's posture for going (thesis: NavPos).
    Posture,
    /// The base is at its stand (thesis: OnTarget).
    Stand(ChoiceId),
}

/// Where an object is to stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    pub object: ParamId,
    pub face: ChoiceId,
    pub stable: ChoiceId,
    pub point: ChoiceId,
    pub yaw: ChoiceId,
}

/// What changes hands when the motion is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The hand of the search space holds the object from now on.
    Attach(ParamId),
    /// It lets go of it.
    Detach(ParamId),
}

impl Change {
    /// Returns the object.
    pub fn object(self) -> ParamId {
        match self {
            Change::Attach(object) | Change::Detach(object) => object,
        }
    }
}

impl Geometric {
    /// Returns who goes and where to, if that is what the action is.
    pub fn goes(&self) -> Option<(ParamId, ParamId)> {
        self.choices.iter().find_map(|c| match c.from {
            ChoiceSet::Stands { agent, entity } => Some((agent, entity)),
            _ => None,
        })
    }
}

impl ChoiceSet {
    /// Returns the set with `params` and `choices` in place of its own, which both must cover: an action that takes over
    /// another one.
    pub fn renamed(self, params: &[ParamId], choices: &[ChoiceId]) -> ChoiceSet {
        match self {
            ChoiceSet::Arms(agent) => ChoiceSet::Arms(params[agent.index()]),
            ChoiceSet::Grasps(object) => ChoiceSet::Grasps(params[object.index()]),
            ChoiceSet::Supports(object) => ChoiceSet::Supports(params[object.index()]),
            ChoiceSet::Stable(object) => ChoiceSet::Stable(params[object.index()]),
            ChoiceSet::Points(face) => ChoiceSet::Points(choices[face.index()]),
            ChoiceSet::Centre(face) => ChoiceSet::Centre(choices[face.index()]),
            ChoiceSet::Angles => ChoiceSet::Angles,
            ChoiceSet::Stands { agent, entity } => ChoiceSet::Stands {
                agent: params[agent.index()],
                entity: params[entity.index()],
            },
        }
    }
}

impl SubAction {
    /// Returns the sub-action with `params` and `choices` in place of its own, which both must cover.
    pub fn renamed(&self, params: &[ParamId], choices: &[ChoiceId]) -> SubAction {
        let param = |p: ParamId| params[p.index()];
        let choice = |c: ChoiceId| choices[c.index()];
        let fact = |fact: &FactOf| FactOf {
            request: fact.request,
            args: fact.args.iter().map(|p| param(*p)).collect(),
        };
        SubAction {
            name: self.name.clone(),
            when: self
                .when
                .iter()
                .map(|condition| match condition {
                    Condition::Free(arm) => Condition::Free(choice(*arm)),
                    Condition::Holds(arm, object) => Condition::Holds(choice(*arm), param(*object)),
                    Condition::Fact(of) => Condition::Fact(fact(of)),
                })
                .collect(),
            space: match self.space {
                Space::Arm(arm) => Space::Arm(choice(arm)),
                Space::ArmStraight(arm) => Space::ArmStraight(choice(arm)),
                Space::Gripper(arm) => Space::Gripper(choice(arm)),
                Space::Body(agent) => Space::Body(param(agent)),
                Space::Base(agent) => Space::Base(param(agent)),
            },
            until: match self.until {
                Target::Open => Target::Open,
                Target::Closed(grasp) => Target::Closed(grasp.map(choice)),
                Target::Grasp { grasp, before } => Target::Grasp {
                    grasp: choice(grasp),
                    before,
                },
                Target::Posture => Target::Posture,
                Target::Stand(stand) => Target::Stand(choice(stand)),
                Target::Up(d) => Target::Up(d),
                Target::Back(d) => Target::Back(d),
                Target::Placement { place, above } => Target::Placement {
                    place: Place {
                        object: param(place.object),
                        face: choice(place.face),
                        stable: choice(place.stable),
                        point: choice(place.point),
                        yaw: choice(place.yaw),
                    },
                    above,
                },
            },
            facts: self.facts.iter().map(fact).collect(),
            change: self.change.map(|change| match change {
                Change::Attach(object) => Change::Attach(param(object)),
                Change::Detach(object) => Change::Detach(param(object)),
            }),
        }
    }
}
