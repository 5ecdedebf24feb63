//! What a file says, with the place of every part; names are text, nothing is resolved.
//!
//! `factdatabase { }` and `HTN { }` only group: their items stand in [`File::items`] in the order of the file.

use crate::source::Span;

/// A word of the user's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    pub text: String,
    pub span: Span,
}

/// One file.
#[derive(Debug, Clone, PartialEq)]
pub struct File {
    pub items: Vec<Item>,
    /// What stands in the text and not in `items`.
    pub unread: Unread,
    pub span: Span,
}

/// What a text may declare in its parts that can't be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Unread {
    /// Actions and methods.
    pub tasks: bool,
    /// Functions, facts and requests.
    pub functions: bool,
    /// Types that have attributes there.
    pub attributes_of: Vec<String>,
    /// Anything at all.
    pub anything: bool,
}

impl Unread {
    /// Says whether all is read.
    pub fn is_empty(&self) -> bool {
        *self == Unread::default()
    }

    /// Adds what another part may declare.
    pub fn extend(&mut self, other: &Unread) {
        self.tasks |= other.tasks;
        self.functions |= other.functions;
        self.attributes_of.extend_from_slice(&other.attributes_of);
        self.anything |= other.anything;
    }
}

/// A declaration.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    EntityType(EntityType),
    Attributes(Attributes),
    Entity(Entity),
    Initial(Assignment),
    Action(Action),
    Method(Method),
    Function(Function),
    Geometric(Geometric),
    Fact(Fact),
    Request(Request),
    Settings(Settings),
    Social(Social),
    /// `timePart { }` of old files.
    TimePart(Span),
    /// `import "file.hatp";`
    Import(Import),
}

/// `import "file.hatp";`
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// As written, without the quotes.
    pub path: String,
    pub path_span: Span,
    pub span: Span,
}

/// `settings { interleave = true; }`
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub settings: Vec<Setting>,
    pub span: Span,
}

/// `interleave = true;`
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    pub name: Name,
    pub value: Expr,
    pub span: Span,
}

/// `social { wasted time weight 0.5; }`
#[derive(Debug, Clone, PartialEq)]
pub struct Social {
    pub rules: Vec<Rule>,
    pub span: Span,
}

/// A social rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// `undesirable` rules have one; the others may.
    pub name: Option<Name>,
    pub params: Vec<Param>,
    pub kind: RuleKind,
    /// Agents or types of agents; empty for all.
    pub among: Vec<Name>,
    pub weight: Expr,
    pub span: Span,
}

/// What a social rule counts.
#[derive(Debug, Clone, PartialEq)]
pub enum RuleKind {
    /// `undesirable state N(Table T) weight 5 { size(T.carries) > 3; }`
    State(Vec<Test>),
    /// `undesirable sequence N(Agent A) weight 2 { Place(A, _); Pick(A, _) immediate; }`
    Sequence(Vec<Pattern>),
    /// `effort balance weight 1;`
    EffortBalance(Effort),
    /// `wasted time weight 1;`
    WastedTime,
    /// `intricate links weight 1;`
    IntricateLinks,
}

/// What counts as effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    Cost,
    Duration,
}

/// `Pick(B, O) immediate;`
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    pub call: Call,
    pub is_immediate: bool,
    pub span: Span,
}

/// `define entityType Cup : Object;`
#[derive(Debug, Clone, PartialEq)]
pub struct EntityType {
    pub name: Name,
    pub parent: Option<Name>,
    pub span: Span,
}

/// `define entityAttributes T { ... }`
#[derive(Debug, Clone, PartialEq)]
pub struct Attributes {
    pub owner: Name,
    pub attributes: Vec<Attribute>,
    pub span: Span,
}

/// `dynamic set Agent isReachable = fact isReachable;`
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    pub is_static: bool,
    pub is_set: bool,
    pub base: Name,
    pub name: Name,
    /// Of `have_image(Objective)`; none for most.
    pub params: Vec<AttributeParam>,
    /// Place of `per agent`: each agent has a belief of its own.
    pub per_agent: Option<Span>,
    pub fact: Option<Name>,
    pub span: Span,
}

impl Attribute {
    /// Returns `(Location, Location To)`; nothing for an attribute without arguments.
    pub fn params_as_written(&self) -> String {
        let param = |p: &AttributeParam| match &p.name {
            Some(name) => format!("{} {}", p.ty.text, name.text),
            None => p.ty.text.clone(),
        };
        let params: Vec<String> = self.params.iter().map(param).collect();
        match params.is_empty() {
            true => String::new(),
            false => format!("({})", params.join(", ")),
        }
    }
}

/// `Location`, `Location To`: an argument that an attribute asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct AttributeParam {
    pub ty: Name,
    /// For the reader alone.
    pub name: Option<Name>,
    pub span: Span,
}

/// `CUP = new Object;`
#[derive(Debug, Clone, PartialEq)]
pub struct Entity {
    pub name: Name,
    pub ty: Name,
    pub span: Span,
}

/// An action (thesis: operator).
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    pub name: Name,
    pub params: Vec<Param>,
    /// In the order of the file; `check` finds those that come twice.
    pub clauses: Vec<Clause>,
    pub span: Span,
}

/// A part of an action.
#[derive(Debug, Clone, PartialEq)]
pub enum Clause {
    Preconditions(Vec<Test>, Span),
    Projects(GeometricCall, Span),
    Constraints(Vec<Test>, Span),
    Alternatives(Expr, Span),
    Effects(Vec<Effect>, Span),
    Cost(Expr, Span),
    Duration(Expr, Span),
}

/// `set Object Os`
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    pub is_set: bool,
    pub ty: Name,
    pub name: Name,
    pub span: Span,
}

/// A method (old files: task).
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    pub name: Name,
    pub params: Vec<Param>,
    /// More than one is for `check` to refuse.
    pub goals: Vec<(Vec<Test>, Span)>,
    pub decompositions: Vec<Decomposition>,
    pub span: Span,
}

/// One way to do a method.
#[derive(Debug, Clone, PartialEq)]
pub struct Decomposition {
    /// All `preconditions` blocks together.
    pub preconditions: Vec<Test>,
    /// All `subtasks` blocks together.
    pub steps: Vec<Step>,
    pub span: Span,
}

/// A line of `subtasks { }`.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    Select(Select),
    Let(Let),
    Subtask(Subtask),
}

/// How the entities of a SELECT are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SelectKind {
    Select,
    Ordered,
    Once,
}

/// `B = SELECT(Agent, { filter });`
#[derive(Debug, Clone, PartialEq)]
pub struct Select {
    pub name: Name,
    pub kind: SelectKind,
    /// Place of the word SELECT, SELECTORDERED or SELECTONCE.
    pub kind_span: Span,
    pub ty: Name,
    pub filter: Vec<Test>,
    /// The number to sort by, and whether the greatest comes first.
    pub key: Option<(Expr, bool)>,
    pub span: Span,
}

/// `let X = O.isOn;`
#[derive(Debug, Clone, PartialEq)]
pub struct Let {
    pub name: Name,
    pub value: Expr,
    pub span: Span,
}

/// `2: Give(B, O, A) > 1;`
#[derive(Debug, Clone, PartialEq)]
pub struct Subtask {
    pub label: Option<Name>,
    pub call: Call,
    /// Labels of those that come before.
    pub after: Vec<Name>,
    pub span: Span,
}

/// `function number f(number c) { c }`; without a body it is declared only.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    pub result: Name,
    pub name: Name,
    pub params: Vec<Param>,
    pub body: Option<Expr>,
    pub span: Span,
}

/// `geometric pick(Agent A, any O) { ... }` (thesis: geometric action description)
#[derive(Debug, Clone, PartialEq)]
pub struct Geometric {
    pub name: Name,
    pub params: Vec<Param>,
    /// `None` where it is declared only, which is for `check` to refuse.
    pub body: Option<Vec<GeometricPart>>,
    pub span: Span,
}

/// A line of a geometric action.
#[derive(Debug, Clone, PartialEq)]
pub enum GeometricPart {
    /// `exists hand in arms(A), grasp in grasps(O);`
    Choices(Vec<Choice>),
    SubAction(SubAction),
    /// `until isReachable(O, B);`: facts that hold when all is done.
    InTheEnd(Vec<Call>),
    /// `pick(A, O) with hand = hand;`: all of another geometric action.
    Call(GeometricCall),
}

/// `hand in arms(A)`
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub name: Name,
    pub from: Call,
    pub span: Span,
}

/// `engage: when free(hand) moving arm(hand) straight with O until at(hand, grasp) then attach(O, hand);`
#[derive(Debug, Clone, PartialEq)]
pub struct SubAction {
    pub name: Name,
    pub when: Vec<Call>,
    pub moving: Call,
    pub is_straight: bool,
    /// What is in the hand meanwhile.
    pub carrying: Option<Name>,
    pub until: Vec<Call>,
    pub change: Option<Call>,
    pub span: Span,
}

/// `pick(A, O) with hand = hand`
#[derive(Debug, Clone, PartialEq)]
pub struct GeometricCall {
    pub call: Call,
    pub given: Vec<Binding>,
}

/// `hand = "right"`: a choice that is made already.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    pub name: Name,
    pub value: Expr,
    pub span: Span,
}

/// `fact isOn(any A, any B);`, or with its meaning: `fact isClose(any A, any B) { distance(A, B) < 0.5; }`
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    pub name: Name,
    pub params: Vec<Param>,
    /// `None` for a fact that geometry computes.
    pub body: Option<Vec<Test>>,
    pub span: Span,
}

/// `request number distance(any A, any B);`: a question about the world as it is, with no effect (thesis 4.4.1).
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    pub result: Name,
    pub name: Name,
    pub params: Vec<Param>,
    pub span: Span,
}

/// A test with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    pub kind: TestKind,
    pub span: Span,
}

/// What a test says.
#[derive(Debug, Clone, PartialEq)]
pub enum TestKind {
    Or(Vec<Vec<Test>>),
    Not(Vec<Test>),
    Forall {
        ty: Name,
        var: Name,
        guard: Vec<Test>,
        body: Vec<Test>,
    },
    Exist {
        ty: Name,
        var: Name,
        guard: Vec<Test>,
        body: Vec<Test>,
    },
    Compare {
        op: TestOp,
        left: Expr,
        right: Expr,
    },
    /// An expression alone.
    Holds(Expr),
    /// `B.believes(O.isOn == T)`: a comparison or an expression alone, as the agent believes.
    Believes(Path, Box<Test>),
}

/// Between the two sides of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestOp {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Member,
    NotMember,
}

/// An effect.
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    Assign(Assignment),
    Forall {
        ty: Name,
        var: Name,
        guard: Vec<Test>,
        effects: Vec<Effect>,
        span: Span,
    },
    If {
        test: Vec<Test>,
        then: Vec<Effect>,
        otherwise: Vec<Effect>,
        span: Span,
    },
}

/// How an attribute changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AssignOp {
    /// `=`
    Set,
    /// `<<=`
    Add,
    /// `=>>`
    Remove,
}

/// `A.hasInHand = NULL;`
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// Whose belief it is: `B` of `B.believes(O.isOn = T);`.
    pub believer: Option<Path>,
    pub target: Path,
    pub op: AssignOp,
    pub op_span: Span,
    pub value: Expr,
    pub span: Span,
}

/// `A.holding.isAt`
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    pub root: Name,
    pub steps: Vec<PathStep>,
    pub span: Span,
}

/// A step of a path: `isAt`, `road(L2)`.
#[derive(Debug, Clone, PartialEq)]
pub struct PathStep {
    pub name: Name,
    pub args: Vec<Expr>,
    pub span: Span,
}

/// `placeR(A, O, S, AT)`
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    pub name: Name,
    pub args: Vec<Expr>,
    pub span: Span,
}

/// An expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    pub kind: ExprKind,
    pub span: Span,
}

/// What an expression is.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    Number(f64),
    String(String),
    Bool(bool),
    Null,
    Path(Path),
    Call(Call),
    List(Vec<Expr>),
    /// `(least, most)`
    Pair(Box<Expr>, Box<Expr>),
    Negate(Box<Expr>),
    Arithmetic {
        op: ArithmeticOp,
        left: Box<Expr>,
        right: Box<Expr>,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArithmeticOp {
    Add,
    Subtract,
    Multiply,
    Divide,
}
