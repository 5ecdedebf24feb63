//! What a domain and its problem say, with every name resolved to a number.

use crate::source::Span;

/// Indexes [`Pair::types`]; 0 is `object`.
pub(super) type TypeId = usize;
/// Indexes [`Pair::objects`].
pub(super) type ObjectId = usize;
/// Indexes [`Pair::predicates`].
pub(super) type PredicateId = usize;
/// Indexes a [`Scope`].
pub(super) type VarId = usize;

/// A name as the file spells it where it is declared.
#[derive(Debug, Clone)]
pub(super) struct Name {
    pub text: String,
    pub span: Span,
}

/// The root of all types.
pub(super) const OBJECT: TypeId = 0;

/// A domain and a problem.
#[derive(Debug, Default)]
pub(super) struct Pair {
    pub domain: String,
    pub problem: String,
    pub types: Vec<Type>,
    /// Constants first.
    pub objects: Vec<Object>,
    pub predicates: Vec<Relation>,
    pub functions: Vec<Relation>,
    pub tasks: Vec<Task>,
    pub actions: Vec<Action>,
    pub methods: Vec<Method>,
    /// Without repeats.
    pub facts: Vec<Fact>,
    /// Values of functions; a later one wins.
    pub values: Vec<Value>,
    /// The initial task network with its variables.
    pub start: Network,
    pub start_scope: Scope,
    pub goal: Formula,
    pub goal_scope: Scope,
    /// Whether some action says what it costs: then one that does not is free.
    pub has_costs: bool,
}

#[derive(Debug)]
pub(super) struct Type {
    pub name: Name,
    /// `None` for `object` alone.
    pub parent: Option<TypeId>,
}

#[derive(Debug)]
pub(super) struct Object {
    pub name: Name,
    pub ty: TypeId,
}

/// The types that a variable may have: one, or those of an `either`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Kinds(pub Vec<TypeId>);

/// A predicate or a function: what it is about.
#[derive(Debug)]
pub(super) struct Relation {
    pub name: Name,
    pub params: Vec<Kinds>,
}

#[derive(Debug, Clone)]
pub(super) struct Variable {
    pub name: Name,
    pub kinds: Kinds,
}

/// All variables of an action, a method or a goal: the parameters first, then those of quantifiers.
#[derive(Debug, Clone, Default)]
pub(super) struct Scope(pub Vec<Variable>);

#[derive(Debug)]
pub(super) struct Task {
    pub name: Name,
    pub params: Scope,
}

#[derive(Debug)]
pub(super) struct Action {
    pub name: Name,
    pub scope: Scope,
    pub n_params: usize,
    pub precondition: Formula,
    pub effects: Vec<Effect>,
    /// What is added to the total cost.
    pub costs: Vec<Cost>,
}

#[derive(Debug)]
pub(super) enum Cost {
    Number(f64),
    Function(usize, Vec<Term>),
}

/// One literal of an effect, with what it is under.
#[derive(Debug)]
pub(super) struct Effect {
    /// Goes through all objects.
    pub forall: Vec<VarId>,
    pub condition: Formula,
    /// Whether it adds; else it deletes.
    pub adds: bool,
    pub predicate: PredicateId,
    pub args: Vec<Term>,
}

#[derive(Debug)]
pub(super) struct Method {
    pub name: Name,
    /// Indexes [`Pair::tasks`].
    pub task: usize,
    pub task_args: Vec<Term>,
    pub scope: Scope,
    pub n_params: usize,
    pub precondition: Formula,
    pub network: Network,
}

/// Subtasks and which comes before which.
#[derive(Debug, Default)]
pub(super) struct Network {
    pub steps: Vec<Step>,
    /// For each step, those that come directly before it.
    pub after: Vec<Vec<usize>>,
    pub constraints: Formula,
}

#[derive(Debug)]
pub(super) struct Step {
    pub task: TaskRef,
    pub args: Vec<Term>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TaskRef {
    Action(usize),
    Task(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Term {
    Var(VarId),
    Object(ObjectId),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Formula {
    And(Vec<Formula>),
    Or(Vec<Formula>),
    Not(Box<Formula>),
    Imply(Box<Formula>, Box<Formula>),
    Forall(Vec<VarId>, Box<Formula>),
    Exists(Vec<VarId>, Box<Formula>),
    Atom(PredicateId, Vec<Term>),
    Equal(Term, Term),
    /// The object is of one of these types: written for a variable of an `either`.
    Is(Term, Kinds),
}

impl Default for Formula {
    /// What always holds.
    fn default() -> Self {
        Formula::And(Vec::new())
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Fact {
    pub predicate: PredicateId,
    pub args: Vec<ObjectId>,
}

#[derive(Debug)]
pub(super) struct Value {
    pub function: usize,
    pub args: Vec<ObjectId>,
    pub number: f64,
}

impl Pair {
    /// Says whether every object of `sub` is one of `above`.
    pub fn is_subtype(&self, sub: TypeId, above: TypeId) -> bool {
        self.lineage(sub).any(|t| t == above)
    }

    /// Returns a type and all above it. Circles are cut when the types are read.
    pub fn lineage(&self, ty: TypeId) -> impl Iterator<Item = TypeId> + '_ {
        std::iter::successors(Some(ty), |t| self.types.get(*t).and_then(|t| t.parent))
    }

    /// Returns the narrowest type that has all of these below it.
    pub fn joined(&self, kinds: &Kinds) -> TypeId {
        let Some((first, rest)) = kinds.0.split_first() else {
            return OBJECT;
        };
        let covers = |t: &TypeId| rest.iter().all(|other| self.is_subtype(*other, *t));
        self.lineage(*first).find(covers).unwrap_or(OBJECT)
    }

    /// Says whether everything of the one is of the other, too.
    pub fn is_within(&self, inner: &Kinds, outer: &Kinds) -> bool {
        let is_in = |t: &TypeId| outer.0.iter().any(|o| self.is_subtype(*t, *o));
        inner.0.iter().all(is_in)
    }

    /// Says whether something may be of both.
    pub fn overlap(&self, one: &Kinds, other: &Kinds) -> bool {
        let meets = |a: TypeId, b: TypeId| self.is_subtype(a, b) || self.is_subtype(b, a);
        one.0.iter().any(|a| other.0.iter().any(|b| meets(*a, *b)))
    }

    /// Returns the types of a term.
    pub fn kinds_of(&self, term: Term, scope: &Scope) -> Kinds {
        match term {
            Term::Var(v) => scope.0[v].kinds.clone(),
            Term::Object(o) => Kinds(vec![self.objects[o].ty]),
        }
    }
}

impl Network {
    /// Returns the steps in an order that they may have, and whether it is the only one; fewer of them where some wait for
    /// each other in a circle.
    pub fn order(&self) -> (Vec<usize>, bool) {
        let mut waits: Vec<usize> = self.after.iter().map(Vec::len).collect();
        let mut followers: Vec<Vec<usize>> = vec![Vec::new(); self.steps.len()];
        for (step, after) in self.after.iter().enumerate() {
            after.iter().for_each(|before| followers[*before].push(step));
        }
        let mut ready: Vec<usize> = (0..self.steps.len()).filter(|s| waits[*s] == 0).collect();
        let (mut order, mut is_only) = (Vec::with_capacity(self.steps.len()), true);
        while let Some(step) = ready.pop() {
            is_only &= ready.is_empty();
            order.push(step);
            for follower in &followers[step] {
                waits[*follower] -= 1;
                if waits[*follower] == 0 {
                    ready.push(*follower);
                }
            }
        }
        (order, is_only)
    }

    /// Returns the steps in their order, if there is only one.
    pub fn chain(&self) -> Option<Vec<usize>> {
        let (order, is_only) = self.order();
        is_only.then_some(order)
    }
}
