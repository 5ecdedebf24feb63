//! Random small domains as texts that compile, and random answers of geometry.
//!
//! A list of numbers makes the choices, one after the other, and 0 is always the simplest: a list that is shortened or
//! lowered gives a simpler domain, so proptest finds small examples.

use crate::reasoner::{Scripted, solution};

/// Choices still to be used; 0 when they are used up.
struct Choices<'a> {
    left: std::slice::Iter<'a, u16>,
    kind: Kind,
}

/// Which domains to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Symbolic,
    /// Some actions are projected and some attributes shared.
    Geometric,
    /// The same, and the precondition of every action reads all shared attributes without asking anything of them.
    Eager,
}

impl Choices<'_> {
    fn below(&mut self, n: usize) -> usize {
        self.left.next().map_or(0, |c| usize::from(*c) % n)
    }

    fn one<'t>(&mut self, of: &[&'t str]) -> &'t str {
        of[self.below(of.len())]
    }

    fn some(&mut self, most: usize, mut make: impl FnMut(&mut Self) -> String) -> String {
        let n = self.below(most + 1);
        (0..n).map(|_| make(self)).collect()
    }
}

/// Names that may be used, by type.
#[derive(Clone)]
struct Scope {
    agents: Vec<String>,
    objects: Vec<String>,
    /// How deep tests and effects may still nest.
    nest: usize,
    /// Number of the next quantified variable.
    next: usize,
}

impl Scope {
    fn of_task() -> Self {
        Scope {
            agents: ["A", "R", "H", "A", "H", "A.helper"].map(String::from).to_vec(),
            objects: [
                "O",
                "CUP",
                "BOX",
                "O",
                "BOX",
                "O",
                "A.holds",
                "A.helper.holds",
                "A.with(O)",
                "H.with(A.with(CUP))",
            ]
            .map(String::from)
            .to_vec(),
            nest: 2,
            next: 0,
        }
    }

    /// Returns the scope with a quantified object.
    fn deeper(&self) -> (String, Self) {
        let var = format!("Q{}", self.next);
        let mut inner = self.clone();
        inner.objects.insert(0, var.clone());
        inner.nest -= 1;
        inner.next += 1;
        (var, inner)
    }

    fn agent(&self, c: &mut Choices<'_>) -> String {
        self.agents[c.below(self.agents.len())].clone()
    }

    fn object(&self, c: &mut Choices<'_>) -> String {
        self.objects[c.below(self.objects.len())].clone()
    }

    fn place(&self, c: &mut Choices<'_>) -> String {
        match c.below(3) {
            0 => "TABLE".into(),
            1 => "SHELF".into(),
            _ => format!("{}.at", self.object(c)),
        }
    }

    fn set(&self, c: &mut Choices<'_>) -> String {
        let (object, agent) = (self.object(c), self.agent(c));
        match c.below(5) {
            4 => format!("{object}.seen({}, {})", self.object(c), self.place(c)),
            0 => format!("{object}.users"),
            1 => format!("[{agent}]"),
            2 => format!("{object}.users + {agent}"),
            _ => format!("{object}.users - {agent}"),
        }
    }

    fn number(&self, c: &mut Choices<'_>) -> String {
        match c.below(if c.kind == Kind::Symbolic { 6 } else { 8 }) {
            6 | 7 => "GetGRPCost()".into(),
            0 => "1".into(),
            1 => format!("{}.count", self.agent(c)),
            2 => format!("{}.weight", self.object(c)),
            3 => format!("size({})", self.set(c)),
            4 => format!("({}.count + {}.weight)", self.agent(c), self.object(c)),
            _ => format!("1 / {}.count", self.agent(c)),
        }
    }

    fn test(&self, c: &mut Choices<'_>) -> String {
        let kinds = if self.nest > 0 { 13 } else { 9 };
        match c.below(kinds) {
            6 => format!(
                "{}.believes({}.kept {} {}); ",
                self.agent(c),
                self.object(c),
                c.one(&["!=", "=="]),
                match c.below(3) {
                    0 => "unknown".into(),
                    1 => "NULL".into(),
                    _ => self.place(c),
                }
            ),
            7 => format!(
                "NOT{{ {}.believes({} !>> {}.fans); }}; ",
                self.agent(c),
                self.agent(c),
                self.object(c)
            ),
            8 => format!(
                "{}.believes({}.kept == {}.kept); ",
                self.agent(c),
                self.object(c),
                self.object(c)
            ),
            0 => format!("{} != {}; ", self.object(c), self.object(c)),
            1 => format!("{}.at {} {}; ", self.object(c), c.one(&["!=", "=="]), self.place(c)),
            2 => format!("{} {} {}; ", self.number(c), c.one(&["<=", ">", "!="]), self.number(c)),
            3 => format!("{} {} {}; ", self.agent(c), c.one(&["!>>", ">>"]), self.set(c)),
            4 => format!("{}.done != true; ", self.object(c)),
            5 => format!("{}.holds == {}; ", self.agent(c), c.one(&["NULL", "CUP"])),
            9 => format!("NOT{{ {} }}; ", self.test(c)),
            10 => {
                let inner = Scope {
                    nest: self.nest - 1,
                    ..self.clone()
                };
                format!("OR{{ {} }}{{ {} }}; ", inner.test(c), inner.test(c))
            }
            kind => {
                let (var, inner) = self.deeper();
                let word = if kind == 11 { "FORALL" } else { "EXIST" };
                format!(
                    "{word}(Object {var}, {{ {} }}, {{ {} }}); ",
                    inner.test(c),
                    inner.test(c)
                )
            }
        }
    }

    fn effect(&self, c: &mut Choices<'_>) -> String {
        let kinds = if self.nest > 0 { 14 } else { 12 };
        match c.below(kinds) {
            9 => format!("{}.kept = {}; ", self.object(c), self.place(c)),
            10 => format!("{}.fans {} {}; ", self.object(c), c.one(&["<<=", "=>>"]), self.agent(c)),
            11 => format!(
                "{}.believes({}.kept = {}); ",
                self.agent(c),
                self.object(c),
                match c.below(3) {
                    0 => "unknown".into(),
                    1 => format!("{}.kept", self.object(c)),
                    _ => self.place(c),
                }
            ),
            7 => format!("{}.with({}) = {}; ", self.agent(c), self.object(c), self.object(c)),
            8 => format!(
                "{}.seen({}, {}) {} {}; ",
                self.object(c),
                self.object(c),
                self.place(c),
                c.one(&["<<=", "=>>"]),
                self.agent(c)
            ),
            0 => format!("{}.done = true; ", self.object(c)),
            1 => format!("{}.at = {}; ", self.object(c), self.place(c)),
            2 => format!("{}.holds = {}; ", self.agent(c), self.object(c)),
            3 => format!("{}.count = {}; ", self.agent(c), self.number(c)),
            4 => format!(
                "{}.users {} {}; ",
                self.object(c),
                c.one(&["<<=", "=>>"]),
                self.agent(c)
            ),
            5 => format!("{}.users = {}; ", self.object(c), self.set(c)),
            6 => format!("{}.helper = {}; ", self.agent(c), c.one(&["NULL", "A", "H"])),
            12 => {
                let inner = Scope {
                    nest: self.nest - 1,
                    ..self.clone()
                };
                let (test, then, otherwise) = (inner.test(c), inner.effect(c), inner.effect(c));
                format!("IF{{ {test} }}{{ {then} }} ELSE {{ {otherwise} }} ")
            }
            _ => {
                let (var, inner) = self.deeper();
                format!(
                    "FORALL(Object {var}, {{ {} }}, {{ {} }}); ",
                    inner.test(c),
                    inner.effect(c)
                )
            }
        }
    }
}

const N_ACTIONS: usize = 3;
const N_METHODS: usize = 3;

fn action(i: usize, c: &mut Choices<'_>) -> String {
    let scope = Scope::of_task();
    let preconditions = if c.below(3) == 2 { scope.test(c) } else { String::new() };
    let effects = c.some(3, |c| scope.effect(c));
    let eager = "FORALL(Object E, {E.at == TABLE;}, {1 > 0;}); FORALL(Object E, {size(E.users) > 0;}, {1 > 0;});";
    let eager = if c.kind == Kind::Eager { eager } else { "" };
    let projects = match c.kind {
        Kind::Geometric | Kind::Eager if i < 2 => "projects { pick(A, O) };",
        _ => "",
    };
    let cost = c.one(&["1", "2", "O.weight", "size(O.users) + 0.5", "A.count * A.count"]);
    let duration = c.one(&["(1, 1)", "(2, 5)", "(O.weight, 9)"]);
    format!(
        "action Act{i}(Agent A, Object O{}) {{ preconditions {{ {eager} {preconditions} }}; {projects} effects {{ {effects} }}; cost {{ {cost} }}; duration {{ {duration} }}; }}\n",
        // The last one is joint.
        if i == N_ACTIONS - 1 { ", Agent B" } else { "" }
    )
}

/// The subtasks of method `i` are actions, later methods, and now and then the method itself.
fn decomposition(i: usize, c: &mut Choices<'_>) -> String {
    let mut scope = Scope::of_task();
    let preconditions = if c.below(4) == 3 { scope.test(c) } else { String::new() };
    let mut steps = String::new();
    for (n, var) in ["S", "T"].iter().enumerate().take(c.below(3)) {
        let mut inner = scope.clone();
        inner.objects.insert(0, (*var).to_owned());
        inner.next = 10 * (n + 1);
        steps += &match c.below(4) {
            0 => format!("{var} = SELECT(Object, {{ {} }}); ", c.some(1, |c| inner.test(c))),
            1 => format!(
                "{var} = SELECTORDERED(Object, {{ {} }}, {var}.weight, {}); ",
                c.some(1, |c| inner.test(c)),
                c.one(&["<", ">"])
            ),
            2 => format!("{var} = SELECTONCE(Object, {{ {} }}); ", inner.test(c)),
            _ => format!("let {var} = {}; ", scope.object(c)),
        };
        scope.objects.insert(0, (*var).to_owned());
    }
    for label in 0..1 + c.below(4) {
        let (agent, object) = (scope.agent(c), scope.object(c));
        let later = N_METHODS - 1 - i;
        let call = match c.below(2 * N_ACTIONS + 2 * later + 1) {
            n if n == N_ACTIONS - 1 => format!("Act{n}({agent}, {object}, {})", scope.agent(c)),
            n if n < 2 * N_ACTIONS => format!("Act{}({agent}, {object})", n % (N_ACTIONS - 1)),
            n if n < 2 * (N_ACTIONS + later) => format!("Do{}({agent}, {object})", i + 1 + n % later),
            _ => format!("Do{i}({agent}, {object})"),
        };
        let after: Vec<String> = (0..label)
            .filter(|_| c.below(3) == 0)
            .map(|l| format!("> {l}"))
            .collect();
        steps += &format!("{label}: {call} {}; ", after.join(", "));
    }
    format!("{{ preconditions {{ {preconditions} }}; subtasks {{ {steps} }}; }}\n")
}

fn method(i: usize, c: &mut Choices<'_>) -> String {
    let goal = if c.below(3) == 0 {
        format!(
            "goal {{ O.done == true; {} }} ",
            c.some(1, |c| Scope::of_task().test(c))
        )
    } else {
        String::new()
    };
    let decompositions: String = (0..1 + c.below(2)).map(|_| decomposition(i, c)).collect();
    format!("method Do{i}(Agent A, Object O) {{ {goal}{decompositions} }}\n")
}

fn initial(c: &mut Choices<'_>) -> String {
    let values = [
        "H.helper = R; ",
        "H.holds = CUP; ",
        "CUP.done = true; ",
        "H.count = 0; ",
        "CUP.at = TABLE; ",
        "BOX.at = SHELF; ",
        "H.with(BOX) = CUP; ",
        "BOX.users <<= H; ",
    ];
    let plain = if c.kind == Kind::Symbolic { values.len() } else { 4 };
    values[..plain].iter().filter(|_| c.below(2) == 1).copied().collect()
}

/// Returns a domain whose task is `Do0(R, CUP)`.
pub fn domain(choices: &[u16], kind: Kind) -> String {
    let c = &mut Choices {
        left: choices.iter(),
        kind,
    };
    let (on, reachable) = match kind {
        Kind::Symbolic => ("", ""),
        Kind::Geometric | Kind::Eager => ("= fact isOn", "= fact isReachable"),
    };
    let methods: String = (0..N_METHODS).map(|i| method(i, c)).collect();
    let actions: String = (0..N_ACTIONS).map(|i| action(i, c)).collect();
    let initial = initial(c);
    let sees = c.one(&[
        "B >> O.users",
        "B.helper != NULL",
        "O.at == TABLE",
        "B.believes(O.kept == TABLE)",
    ]);
    format!(
        "factdatabase {{
  define entityType Object;
  define entityType Place;
  define entityAttributes Agent {{ dynamic atom Object holds; dynamic atom Agent helper; dynamic atom number count; dynamic atom Object with(Object); }}
  define entityAttributes Object {{ dynamic atom Place at {on}; dynamic atom bool done; dynamic atom number weight; dynamic set Agent users {reachable}; dynamic set Agent seen(Object, Place At); dynamic atom Place kept per agent; dynamic set Agent fans per agent; }}
  R = new Agent; H = new Agent; CUP = new Object; BOX = new Object; TABLE = new Place; SHELF = new Place;
  CUP.weight = 2; BOX.weight = 1; R.count = 2; H.count = 3; R.helper = H; R.holds = BOX; {initial}
  CUP.kept = SHELF; H.believes(BOX.kept = TABLE); H.believes(BOX.fans = unknown);
}}
fact observes(Agent B, Object O) {{ OR{{ B.holds == O; }}{{ {sees}; }} }}
HTN {{
{actions}{methods}}}
"
    )
}

/// Returns what geometry says to each call that such a domain can make: none to three solutions, each with a cost of 0 to
/// 4 and changes of what the shared attributes read.
pub fn reasoner(choices: &[u16]) -> Scripted {
    let c = &mut Choices {
        left: choices.iter(),
        kind: Kind::Geometric,
    };
    let world = |c: &mut Choices<'_>| {
        let places = ["CUP.at = TABLE, ", "CUP.at =, ", "BOX.at = SHELF, ", "BOX.at = TABLE, "];
        let users = [
            "CUP.users = R, ",
            "CUP.users =, ",
            "BOX.users = R H, ",
            "BOX.users = H, ",
        ];
        c.some(2, |c| c.one(&places).to_owned()) + &c.some(2, |c| c.one(&users).to_owned())
    };
    let mut reasoner = Scripted::new(&world(c), &["isOn", "isReachable"]);
    for agent in ["R", "H"] {
        for object in ["CUP", "BOX"] {
            let n = 3 - c.below(4);
            let solutions = (0..n).map(|_| solution(c.below(5) as f64, c.below(3) as f64, &world(c)));
            reasoner = reasoner.with(&format!("pick({agent}, {object})"), solutions.collect());
        }
    }
    reasoner
}
