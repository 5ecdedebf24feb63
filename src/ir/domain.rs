//! The compiled domain: flat tables indexed by ids.
//!
//! INVARIANT: every id in a `Domain` indexes the table it names; every [`Var`] lies inside its task's frame;
//! `check` has passed, so evaluation never meets a type error.

use super::value::Value;

macro_rules! id {
    ($($(#[$doc:meta])* $name:ident),*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);
        impl $name {
            /// Returns the id as an index of its table.
            pub fn index(self) -> usize { self.0 as usize }
        }
    )*};
}
id!(
    /// Indexes [`Domain::types`].
    TypeId,
    /// Indexes [`Domain::entities`].
    EntityId,
    /// Indexes [`Domain::attributes`].
    AttributeId,
    /// Indexes [`Domain::slots`], [`Domain::initial`] and a state's values: one attribute of one entity, with its arguments.
    SlotId,
    /// Indexes [`Domain::requests`].
    RequestId,
    /// Indexes [`Domain::facts`].
    FactId,
    /// Indexes [`super::geometric::Geometric::params`].
    ParamId,
    /// Indexes [`super::geometric::Geometric::choices`].
    ChoiceId,
    /// Indexes [`Domain::strings`].
    StringId,
    /// Indexes [`Domain::actions`].
    ActionId,
    /// Indexes [`Domain::methods`].
    MethodId,
    /// Indexes a task instance's frame: parameters first, then SELECT and `let` variables, then quantified ones.
    Var
);

/// What an attribute or variable may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Base {
    Number,
    Bool,
    String,
    Entity(TypeId),
}

/// A declared type of entities; `Agent` is always there.
#[derive(Debug, Clone)]
pub struct Type {
    pub name: String,
    /// The supertype, if declared with one.
    pub parent: Option<TypeId>,
    /// Entities of this type or of a subtype, in declaration order.
    pub entities: Vec<EntityId>,
}

/// A declared entity.
#[derive(Debug, Clone)]
pub struct Entity {
    pub name: String,
    pub ty: TypeId,
}

/// An attribute of a type.
#[derive(Debug, Clone)]
pub struct Attribute {
    pub name: String,
    pub owner: TypeId,
    pub is_static: bool,
    pub is_set: bool,
    pub base: Base,
    /// The geometric fact it is read from (`isReachable` ...): then it is a *shared* attribute (thesis 4.3.3).
    pub fact: Option<String>,
    /// What it asks for beside its entity: `can_traverse(Waypoint, Waypoint)` has two. None for most.
    pub arguments: Vec<Argument>,
    /// Declared `per agent`: each agent believes something of its own. Read and written as one argument more, the last; its
    /// offsets lead from a value to what the agent believes of it. `None` for most.
    pub believer: Option<Argument>,
    /// The slot of each entity, by [`EntityId`]; `None` where the entity's type lacks the attribute. With arguments or
    /// beliefs, the first of the entity's slots, which lie behind one another ([`Attribute::slot`]).
    pub slots: Vec<Option<SlotId>>,
}

/// An argument of an attribute.
#[derive(Debug, Clone)]
pub struct Argument {
    pub ty: TypeId,
    /// How far behind the first slot each entity, by [`EntityId`], moves the slot; `None` where it is not of the type.
    /// INVARIANT: the last argument runs fastest, over its type's entities in declaration order; beliefs lie behind all values.
    pub offsets: Vec<Option<u32>>,
}

impl Attribute {
    /// Returns the slot of an entity with these arguments, behind which a believer may stand; `None` where there is none.
    pub fn slot(&self, entity: EntityId, args: &[EntityId]) -> Option<SlotId> {
        if args.len() < self.arguments.len() {
            return None;
        }
        let mut at = (*self.slots.get(entity.index())?)?;
        for (argument, arg) in self.arguments.iter().chain(&self.believer).zip(args) {
            at.0 = at.0.checked_add((*argument.offsets.get(arg.index())?)?)?;
        }
        Some(at)
    }
}

/// One attribute of one entity. Its arguments are in its place among the entity's slots ([`Domain::slot_arguments`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slot {
    pub entity: EntityId,
    pub attribute: AttributeId,
}

/// The compiled domain with its entities and initial state.
#[derive(Debug, Clone, Default)]
pub struct Domain {
    pub types: Vec<Type>,
    pub entities: Vec<Entity>,
    pub attributes: Vec<Attribute>,
    pub slots: Vec<Slot>,
    /// Value of each slot at the start, by [`SlotId`]; set attributes start as an empty set, the others as `Null`.
    pub initial: Vec<Value>,
    /// Interned string constants.
    pub strings: Vec<String>,
    pub actions: Vec<Action>,
    pub methods: Vec<Method>,
    /// What [`Expr::Request`] may ask of geometry: the prelude's requests, and its facts as questions.
    pub requests: Vec<Request>,
    /// Facts whose meaning the domain gives itself.
    pub facts: Vec<Fact>,
    /// What `projects` may call: the prelude's geometric actions, then the domain's own.
    pub geometrics: Vec<NamedGeometric>,
    pub settings: Settings,
    /// The method whose decomposition is the task network to plan, if the goal is one. Its name is the network's text,
    /// which no file could write as a name.
    pub network: Option<MethodId>,
    pub social: Vec<super::SocialRule>,
    /// How beliefs change; `None` where no attribute is `per agent`.
    pub beliefs: Option<Beliefs>,
}

/// A geometric action by one of its names.
#[derive(Debug, Clone)]
pub struct NamedGeometric {
    /// As domains call it.
    pub name: String,
    /// Shared by its names.
    pub action: std::sync::Arc<super::geometric::Geometric>,
    pub is_built_in: bool,
}

/// Who learns of what an action has changed, beside those who take part in it.
#[derive(Debug, Clone)]
pub struct Beliefs {
    /// The type of those who believe.
    pub agents: TypeId,
    pub observes: Option<Observes>,
}

/// `fact observes(Agent B, Object O) { ... }`: whether B sees a change of O, in the state after it.
#[derive(Debug, Clone)]
pub struct Observes {
    /// Of the second parameter; `None` for `any`.
    pub ty: Option<TypeId>,
    /// Names of the two parameters.
    pub params: Vec<String>,
    /// Frame size: parameters and quantified variables.
    pub n_vars: usize,
    /// Asks no geometry.
    pub body: Test,
}

/// What a domain says of how it wants to be planned; the command line wins over it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Settings {
    /// Subtasks with no order between them may mix step by step instead of one block after the other.
    pub interleave: bool,
    pub cost: super::CostFormula,
}

/// A question to geometry about the world as it is (thesis 4.4.1).
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    pub name: String,
    /// [`Base::Bool`] or [`Base::Number`].
    pub result: Base,
}

/// A fact that the domain defines: `fact isClose(any A, any B) { distance(A, B) < 0.5; }`.
#[derive(Debug, Clone)]
pub struct Fact {
    pub name: String,
    /// Names of the parameters; `check` has seen to their types.
    pub params: Vec<String>,
    /// Frame size: parameters and quantified variables.
    pub n_vars: usize,
    /// Asks requests and static attributes only.
    pub body: Test,
}

impl Domain {
    /// Returns the entity of that name.
    pub fn entity(&self, name: &str) -> Option<EntityId> {
        self.entities
            .iter()
            .position(|e| e.name == name)
            .map(|i| EntityId(i as u32))
    }

    /// Returns the geometric action of that name.
    pub fn geometric(&self, name: &str) -> Option<&std::sync::Arc<super::geometric::Geometric>> {
        self.geometrics.iter().find(|g| g.name == name).map(|g| &g.action)
    }

    /// Says whether `sub` is `ty` or one of its subtypes.
    pub fn is_subtype(&self, sub: TypeId, ty: TypeId) -> bool {
        let mut at = Some(sub);
        while let Some(t) = at {
            if t == ty {
                return true;
            }
            at = self.types[t.index()].parent;
        }
        false
    }

    /// Returns how many values an attribute has for one entity, beliefs apart.
    fn n_values(&self, attribute: &Attribute) -> u32 {
        let sizes = attribute.arguments.iter();
        sizes.map(|a| self.types[a.ty.index()].entities.len() as u32).product()
    }

    /// Returns how far a slot is behind the first one of its entity.
    fn offset(&self, slot: SlotId) -> u32 {
        let Slot { entity, attribute } = self.slots[slot.index()];
        let first = self.attributes[attribute.index()].slots[entity.index()];
        slot.0 - first.map_or(slot.0, |first| first.0)
    }

    /// Returns the agent whose belief a slot holds; `None` for a slot that holds what is true.
    pub fn believer(&self, slot: SlotId) -> Option<EntityId> {
        let attribute = &self.attributes[self.slots[slot.index()].attribute.index()];
        let believers = &self.types[attribute.believer.as_ref()?.ty.index()].entities;
        let who = (self.offset(slot) / self.n_values(attribute)).checked_sub(1)?;
        believers.get(who as usize).copied()
    }

    /// Returns the slot of what an agent believes of a value; `None` if there is no such belief.
    pub fn belief(&self, value: SlotId, agent: EntityId) -> Option<SlotId> {
        let attribute = &self.attributes[self.slots[value.index()].attribute.index()];
        let offset = attribute.believer.as_ref()?.offsets[agent.index()]?;
        Some(SlotId(value.0 + offset))
    }

    /// Returns the arguments that a slot stands for, without a believer.
    pub fn slot_arguments(&self, slot: SlotId) -> Vec<EntityId> {
        let attribute = &self.attributes[self.slots[slot.index()].attribute.index()];
        let mut offset = (self.offset(slot) % self.n_values(attribute).max(1)) as usize;
        let mut arguments = Vec::with_capacity(attribute.arguments.len());
        for argument in attribute.arguments.iter().rev() {
            let of_type = &self.types[argument.ty.index()].entities;
            arguments.push(of_type[offset % of_type.len()]);
            offset /= of_type.len();
        }
        arguments.reverse();
        arguments
    }

    /// Returns the slots of an attribute without beliefs: of each entity in turn, with all arguments.
    pub fn slots_of(&self, attribute: AttributeId) -> impl Iterator<Item = SlotId> + '_ {
        let attribute = &self.attributes[attribute.index()];
        let n = self.n_values(attribute);
        let firsts = attribute.slots.iter().flatten();
        firsts.flat_map(move |first| (first.0..first.0 + n).map(SlotId))
    }

    /// Returns a slot as the language writes it: `CUP.isOn`, `ROVER.have_image(ROCK)`, `BOB.believes(CUP.isOn)`.
    pub fn slot_name(&self, slot: SlotId) -> String {
        let Slot { entity, attribute } = self.slots[slot.index()];
        let name = |e: &EntityId| self.entities[e.index()].name.as_str();
        let (entity, attribute) = (name(&entity), &self.attributes[attribute.index()].name);
        let arguments = self.slot_arguments(slot);
        let arguments: Vec<&str> = arguments.iter().map(name).collect();
        let value = match arguments.is_empty() {
            true => format!("{entity}.{attribute}"),
            false => format!("{entity}.{attribute}({})", arguments.join(", ")),
        };
        match self.believer(slot) {
            Some(agent) => format!("{}.believes({value})", name(&agent)),
            None => value,
        }
    }

    /// Returns the task's name.
    pub fn task_name(&self, task: TaskId) -> &str {
        match task {
            TaskId::Action(a) => &self.actions[a.index()].name,
            TaskId::Method(m) => &self.methods[m.index()].name,
        }
    }

    /// Returns the task's parameters.
    pub fn task_params(&self, task: TaskId) -> &[Param] {
        match task {
            TaskId::Action(a) => &self.actions[a.index()].params,
            TaskId::Method(m) => &self.methods[m.index()].params,
        }
    }

    /// Returns the task of that name.
    pub fn task(&self, name: &str) -> Option<TaskId> {
        let action = self
            .actions
            .iter()
            .position(|a| a.name == name)
            .map(|i| TaskId::Action(ActionId(i as u32)));
        action.or_else(|| {
            self.methods
                .iter()
                .position(|m| m.name == name)
                .map(|i| TaskId::Method(MethodId(i as u32)))
        })
    }

    /// Returns a task with its arguments as the language writes it: `Pick(PR2, CUP)`; of a task network its text.
    pub fn show_task(&self, task: TaskId, args: &[Value]) -> String {
        let name = self.task_name(task);
        if self.network.is_some_and(|network| task == TaskId::Method(network)) {
            return name.to_owned();
        }
        let args: Vec<String> = args.iter().map(|v| self.show(v)).collect();
        format!("{name}({})", args.join(", "))
    }

    /// Returns the value as the language writes it: `NULL`, `3`, `"red"`, `CUP`, `[CUP, BOX]`.
    pub fn show(&self, value: &Value) -> String {
        match value {
            Value::Null => "NULL".into(),
            Value::Unknown => "unknown".into(),
            Value::Bool(b) => b.to_string(),
            Value::Number(x) => x.to_string(),
            Value::String(s) => format!("{:?}", self.strings[s.index()]),
            Value::Entity(e) => self.entities[e.index()].name.clone(),
            Value::Set(s) => {
                let names: Vec<&str> = s.iter().map(|e| self.entities[e.index()].name.as_str()).collect();
                format!("[{}]", names.join(", "))
            }
            Value::Scalars(s) => {
                let values: Vec<String> = s.iter().map(|v| self.show(v)).collect();
                format!("[{}]", values.join(", "))
            }
        }
    }
}

/// A parameter of a task; its [`Var`] is its position.
#[derive(Debug, Clone)]
pub struct Param {
    pub name: String,
    pub base: Base,
    pub is_set: bool,
}

/// An action or a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TaskId {
    Action(ActionId),
    Method(MethodId),
}

/// An operator (thesis 4.3.3: pre-conditions, geometric action, effects).
#[derive(Debug, Clone)]
pub struct Action {
    pub name: String,
    pub params: Vec<Param>,
    /// Frame size: parameters and quantified variables.
    pub n_vars: usize,
    pub preconditions: Test,
    /// The geometric action it projects onto; `None` is purely symbolic.
    pub projects: Option<Projection>,
    /// Must hold in the world that the projection leads to: requests ask that world, all else reads the state before.
    pub constraints: Test,
    /// Branching factor of this action, if it sets its own.
    pub alternatives: Option<u32>,
    pub effects: Vec<Effect>,
    /// A number >= 0 (checked when evaluated).
    pub cost: Expr,
    /// (least, most) in seconds.
    pub duration: (Expr, Expr),
    /// Positions of the parameters of type Agent, alone or in a set; the first parameter acts, the others take part.
    pub agents: Vec<usize>,
}

/// A call of a geometric action: `placeReachable(A, O, S, AT)`.
#[derive(Debug, Clone)]
pub struct Projection {
    pub name: String,
    /// One for each parameter; behind them the values of `given`.
    pub args: Vec<Expr>,
    /// Choices that are made already: the choice of each further argument. A point has two, x and y.
    pub given: Vec<ChoiceId>,
}

/// A compound task.
#[derive(Debug, Clone)]
pub struct Method {
    pub name: String,
    pub params: Vec<Param>,
    /// Nothing is to be done when it holds; `None` when there is no goal block.
    pub goal: Option<Test>,
    pub decompositions: Vec<Decomposition>,
    /// Frame size: parameters, the widest decomposition's variables, quantified ones.
    pub n_vars: usize,
}

/// One way to do a method.
#[derive(Debug, Clone)]
pub struct Decomposition {
    pub preconditions: Test,
    /// SELECTs and lets, in the order of the file.
    pub binders: Vec<Binder>,
    pub subtasks: Vec<Subtask>,
}

/// Gives a variable its value when a method is decomposed.
#[derive(Debug, Clone)]
pub enum Binder {
    /// A choice point over the entities that pass.
    Select {
        var: Var,
        var_name: String,
        ty: TypeId,
        filter: Test,
        order: SelectOrder,
    },
    /// A name for a value; no choice point.
    Let { var: Var, var_name: String, value: Expr },
}

/// How the entities of a SELECT are tried.
#[derive(Debug, Clone)]
pub enum SelectOrder {
    /// SELECT: declaration order.
    Declared,
    /// SELECTORDERED: by a number.
    Sorted { key: Expr, descending: bool },
    /// SELECTONCE: only the first that passes.
    Once,
}

/// A task to be done in a decomposition.
#[derive(Debug, Clone)]
pub struct Subtask {
    pub task: TaskId,
    pub args: Vec<Expr>,
    /// Positions (in [`Decomposition::subtasks`]) of those that must be done before.
    pub after: Vec<usize>,
}

/// A test (language, section 2).
#[derive(Debug, Clone, PartialEq)]
pub enum Test {
    /// All hold; empty means true.
    And(Vec<Test>),
    Or(Vec<Test>),
    Not(Box<Test>),
    Compare {
        op: CompareOp,
        left: Expr,
        right: Expr,
    },
    /// `element >> set`.
    Member {
        element: Expr,
        set: Expr,
    },
    Forall {
        var: Var,
        ty: TypeId,
        guard: Box<Test>,
        body: Box<Test>,
    },
    Exist {
        var: Var,
        ty: TypeId,
        guard: Box<Test>,
        body: Box<Test>,
    },
    /// A bare boolean expression.
    Holds(Expr),
}

impl Test {
    /// The test that always holds.
    pub fn always() -> Self {
        Test::And(Vec::new())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompareOp {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Expr {
    Const(Value),
    Var(Var),
    /// `base.attribute`, `base.attribute(args)`; without a value when the base or an argument is `Null`.
    Attribute {
        base: Box<Expr>,
        attribute: AttributeId,
        /// As many as the attribute has.
        args: Box<[Expr]>,
    },
    /// `size(set)`.
    Size(Box<Expr>),
    /// `[A, B]`: a set of entities.
    List(Vec<Expr>),
    Arithmetic {
        op: ArithmeticOp,
        left: Box<Expr>,
        right: Box<Expr>,
    },
    Negate(Box<Expr>),
    /// Set with an element added (`Os + O`) or removed (`Os - O`).
    SetWith {
        set: Box<Expr>,
        element: Box<Expr>,
    },
    SetWithout {
        set: Box<Expr>,
        element: Box<Expr>,
    },
    /// A question to geometry about the world as it is now; in constraints, about the world that the action leads to.
    Request {
        request: RequestId,
        args: Vec<Expr>,
    },
    /// Whether a fact that the domain defines holds: its body in a frame of its own.
    Fact {
        fact: FactId,
        args: Vec<Expr>,
    },
    /// `GetGRPCost()`: the cost that geometry computed for this action; 0 where nothing is projected.
    GeometricCost,
    /// `GetGRPDuration()`: the length in time of this action's trajectories [s]; 0 where nothing is projected.
    GeometricDuration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArithmeticOp {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// An effect (language, section 3); effects run in order and see the state as already changed.
#[derive(Debug, Clone)]
pub enum Effect {
    /// `entity.attribute = value`.
    Assign {
        entity: Expr,
        attribute: AttributeId,
        args: Box<[Expr]>,
        value: Expr,
    },
    /// `entity.attribute <<= element`.
    Add {
        entity: Expr,
        attribute: AttributeId,
        args: Box<[Expr]>,
        element: Expr,
    },
    /// `entity.attribute =>> element`.
    Remove {
        entity: Expr,
        attribute: AttributeId,
        args: Box<[Expr]>,
        element: Expr,
    },
    Forall {
        var: Var,
        ty: TypeId,
        guard: Test,
        effects: Vec<Effect>,
    },
    If {
        test: Test,
        then: Vec<Effect>,
        otherwise: Vec<Effect>,
    },
}

/// The task to plan with its arguments: `MoveObjs(PR2, [RED_CUBE, GREY_BOOK])`. Of several, [`Domain::network`].
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    pub task: TaskId,
    pub args: Vec<Value>,
}
