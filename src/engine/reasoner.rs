//! What the engine asks of geometry. The engine owns this trait, so HTN logic is tested with exact, scripted answers.

use crate::ir::{ArithmeticOp, AttributeId, Base, ChoiceId, CompareOp, Domain, EntityId, RequestId, Value};
use crate::plan::{ActionRefusal, Geometry};

/// Identifies a geometric action in a run (thesis 3.3.1: gasNum).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GasNum(pub u32);

/// Which solution of which geometric action (thesis: gasNum, gasAltNum).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GasRef {
    pub gas: GasNum,
    /// 0 for the first solution.
    pub alternative: u32,
}

/// A call of a geometric action with its arguments evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Call<'a> {
    /// Name as the domain writes it: `pick`.
    pub name: &'a str,
    /// One for each parameter; behind them the values of `given`.
    pub args: &'a [Value],
    /// The choices that the arguments behind the parameters make: `with hand = "right"`.
    pub given: &'a [ChoiceId],
    /// What must hold in the world that the action leads to.
    pub constraints: &'a Formula,
}

/// A question about a world state, with its arguments evaluated: a geometric request or a fact (`isReachable(CUP, BOB)`).
#[derive(Debug, Clone, PartialEq)]
pub struct Request<'a> {
    pub name: &'a str,
    pub args: &'a [Value],
}

/// The constraints of an operator (thesis 4.3.3) with all evaluated that reads the symbolic state; what is left are
/// questions to the world that the action leads to.
#[derive(Debug, Clone, PartialEq)]
pub enum Formula {
    /// All hold; empty means true.
    And(Vec<Formula>),
    /// One holds; empty means false.
    Or(Vec<Formula>),
    Not(Box<Formula>),
    /// A request that is answered `true`.
    Holds {
        request: RequestId,
        args: Vec<Value>,
    },
    Compare {
        op: CompareOp,
        left: Term,
        right: Term,
    },
}

impl Formula {
    /// What always holds.
    pub const TRUE: Formula = Formula::And(Vec::new());
}

/// A side of a comparison in a [`Formula`].
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    Value(Value),
    Request {
        request: RequestId,
        args: Vec<Value>,
    },
    Arithmetic {
        op: ArithmeticOp,
        left: Box<Term>,
        right: Box<Term>,
    },
}

/// A solution, as far as the engine needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    pub gas: GasRef,
    /// >= 0.
    pub cost: f64,
    /// Length in time of its trajectories [s].
    pub duration: f64,
}

/// A point in the history of the reasoner's world state, to come back to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark(pub usize);

/// Projects actions onto geometry and answers facts about the world state that they lead to.
///
/// **The contract.** A reasoner has a current world state, and the states that led to it. Three calls change it, and nothing
/// else may:
/// - [`Reasoner::project`] and [`Reasoner::find_alternative`] go on to a new world state if they answer `Ok`, and leave the
///   current one as it is if they answer `Err`;
/// - [`Reasoner::restore`] goes back to a mark. Marks are a stack: all later ones are forgotten, and the same mark may be gone
///   back to again and again. A mark is of the world state at [`Reasoner::save`]; it is made before the action that is to be
///   undone. How many states there are is enough of a mark where states are kept in a list (`docs/examples/own_reasoner.rs`);
/// - [`Reasoner::rewind`] and [`Reasoner::replay`] make a known way through solutions once more, to read what the facts were
///   between them.
///
/// What was *found* outlives going back: a [`GasNum`] means the same action in the same world state for the whole search.
/// Answers depend on the current world state, the question and nothing else, or the same search would not give the same plan
/// twice. Between the call and its answer the engine waits; whoever computes long looks at a stop flag of its own.
pub trait Reasoner {
    /// Starts a geometric action in the current world state and applies its first solution. Starting the same one in the same
    /// state again may give the same number again, or a new one.
    ///
    /// # Errors
    ///
    /// Why there is no solution. `exhausted` says whether there is none at all: else a search without a plan says that choices
    /// were left untried.
    fn project(&mut self, domain: &Domain, call: &Call<'_>) -> Result<Projection, ActionRefusal>;

    /// Applies the solution after the `tried` first ones of a geometric action that was started in the current world state
    /// (thesis 3.3.4.3, FindAlternative). Never a solution given before.
    ///
    /// # Errors
    ///
    /// As of [`Reasoner::project`]: there is no further one.
    fn find_alternative(&mut self, gas: GasNum, tried: u32) -> Result<Projection, ActionRefusal>;

    /// Applies a solution that is known from an earlier plan document, without looking for it: its motions as they are. The
    /// number that it gets is its own, as if it had been found here, and it has no alternatives. `None` is an action of a
    /// plan without geometry.
    ///
    /// # Errors
    ///
    /// The solution is no solution of this call in the current world state. A reasoner that can't tell refuses all.
    fn adopt(&mut self, _: &Domain, call: &Call<'_>, _: Option<&Geometry>) -> Result<Projection, ActionRefusal> {
        let why = "this reasoner takes over no solutions of earlier plans";
        Err(ActionRefusal::not_applicable(call.name.to_owned(), why.to_owned()))
    }

    /// Says whether it answers that fact about `entity`; a slot whose fact nobody answers is a plain one.
    fn knows(&self, domain: &Domain, fact: &str, entity: EntityId) -> bool;

    /// Says whether requests are answered from a world, so that facts which the domain defines are computed. Else attributes
    /// with such a fact are plain ones, as for a fact that it does not know.
    fn has_world(&self) -> bool {
        true
    }

    /// Returns the value of a shared attribute of `entity` in the current world state.
    fn fact(&mut self, domain: &Domain, attribute: AttributeId, entity: EntityId) -> Value;

    /// Answers a question about the current world state: a truth value or a number, as [`Domain::requests`] declares it.
    /// `None` where there is no answer (an entity without a place in the world): the test that asks is then false.
    fn request(&mut self, domain: &Domain, request: &Request<'_>) -> Option<Value>;

    /// Returns a number of the current world state that no other one has, the same one whenever that state comes again, or `None` where there is none such: failures in states that geometry
    /// has changed are then not remembered.
    fn state_key(&mut self) -> Option<u128> {
        None
    }

    /// Returns a mark of the current world state.
    fn save(&mut self) -> Mark;

    /// Goes back to a mark.
    fn restore(&mut self, mark: Mark);

    /// Makes the start state the current one again, without forgetting marks; for [`Reasoner::replay`].
    fn rewind(&mut self);

    /// Applies a known solution to the current world state, which is like the one that it was found in.
    fn replay(&mut self, gas: GasRef);
}

/// The reasoner of purely symbolic planning: every projection is granted at cost 0 and takes no time; it knows no fact.
#[derive(Debug, Default)]
pub struct Granted {
    next: u32,
}

impl Reasoner for Granted {
    fn project(&mut self, _: &Domain, _: &Call<'_>) -> Result<Projection, ActionRefusal> {
        let gas = GasRef {
            gas: GasNum(self.next),
            alternative: 0,
        };
        self.next += 1;
        Ok(Projection {
            gas,
            cost: 0.0,
            duration: 0.0,
        })
    }

    fn adopt(&mut self, domain: &Domain, call: &Call<'_>, _: Option<&Geometry>) -> Result<Projection, ActionRefusal> {
        self.project(domain, call)
    }

    fn find_alternative(&mut self, _: GasNum, tried: u32) -> Result<Projection, ActionRefusal> {
        // A granted projection has no geometry, hence nothing in which another solution could differ.
        Err(ActionRefusal {
            call: String::new(),
            found_before: tried,
            exhausted: true,
            tried: 0,
            causes: Vec::new(),
        })
    }

    fn knows(&self, _: &Domain, _: &str, _: EntityId) -> bool {
        false
    }

    fn has_world(&self) -> bool {
        false
    }

    fn fact(&mut self, _: &Domain, _: AttributeId, _: EntityId) -> Value {
        Value::Null
    }

    /// Granted, too: true, or a distance of 0.
    fn request(&mut self, domain: &Domain, request: &Request<'_>) -> Option<Value> {
        let declared = domain.requests.iter().find(|r| r.name == request.name)?;
        Some(match declared.result {
            Base::Number => Value::Number(0.0),
            Base::Bool | Base::String | Base::Entity(_) => Value::Bool(true),
        })
    }

    /// There is one world state only.
    fn state_key(&mut self) -> Option<u128> {
        Some(0)
    }

    fn save(&mut self) -> Mark {
        Mark(0)
    }

    fn restore(&mut self, _: Mark) {}

    fn rewind(&mut self) {}

    fn replay(&mut self, _: GasRef) {}
}
