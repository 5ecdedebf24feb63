//! A planner by the definition alone: copies everything, tries everything, remembers nothing. Shares no code with `engine`.

use std::collections::BTreeMap;

pub const OBJECTS: [&str; 3] = ["CUP", "BOX", "PEN"];
pub const AGENTS: [&str; 2] = ["R", "H"];

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    Null,
    Object(usize),
    Agent(usize),
    Number(i64),
    /// Objects, as bits.
    Set(u8),
}

#[derive(Debug, Clone, PartialEq)]
pub struct State {
    pub count: [i64; 2],
    pub holds: [Option<usize>; 2],
    pub done: [bool; 3],
    pub next: [Option<usize>; 3],
    /// Agents, as bits.
    pub users: [u8; 3],
    pub weight: [i64; 3],
    /// By agent and object.
    pub with: [[Option<usize>; 3]; 2],
    /// By object, object and agent.
    pub near: [[[bool; 2]; 3]; 3],
    /// Agents as bits, by two objects.
    pub saw: [[u8; 3]; 3],
}

/// Variables by name.
pub type Frame = BTreeMap<String, Value>;

/// A path to an object; `None` where a step goes through NULL.
#[derive(Debug, Clone)]
pub enum Object {
    Var(String),
    Const(usize),
    Next(Box<Object>),
    /// What the agent of a variable holds.
    Held(String),
    /// An attribute of the agent with an argument.
    With(String, Box<Object>),
}

#[derive(Debug, Clone)]
pub enum Test {
    Same(Object, Object, bool),
    IsNull(Object),
    Done(Object, bool),
    Count(String, &'static str, i64),
    Uses(String, String, bool),
    In(String, bool),
    Level(&'static str, i64),
    Users(String, i64),
    Near(Object, Object, String, bool),
    Saw(String, Object, Object, bool),
    Or(Vec<Test>, Vec<Test>),
    Not(Vec<Test>),
    All(String, Vec<Test>, Vec<Test>),
    Some(String, Vec<Test>),
}

#[derive(Debug, Clone)]
pub enum Effect {
    Done(String, bool),
    Hold(String, Option<Object>),
    Next(String, Option<Object>),
    Count(String),
    Use(String, String, bool),
    With(String, Object, Option<Object>),
    Near(Object, Object, String, bool),
    Saw(Object, Object, String, bool),
    If(Vec<Test>, Vec<Effect>, Vec<Effect>),
    All(String, Vec<Test>, Vec<Effect>),
}

#[derive(Debug, Clone, Copy)]
pub enum Cost {
    Const(i64),
    Weight,
    WeightAndCount,
    Users,
}

#[derive(Debug, Clone)]
pub struct Action {
    pub before: Vec<Test>,
    pub effects: Vec<Effect>,
    pub cost: Cost,
}

#[derive(Debug, Clone)]
pub enum Binder {
    Select(String, Vec<Test>),
    Ordered(String, Vec<Test>, bool),
    Once(String, Vec<Test>),
    Let(String, Object),
}

#[derive(Debug, Clone, Copy)]
pub enum Level {
    Same,
    Less,
}

#[derive(Debug, Clone)]
pub enum SetArg {
    Same,
    Without(Object),
    With(Object),
    List(usize, usize),
}

#[derive(Debug, Clone)]
pub struct Subtask {
    pub agent: String,
    pub object: Object,
    /// An action's number, or a method's with its further arguments.
    pub call: Result<usize, (usize, Level, SetArg)>,
    pub after: Vec<usize>,
}

#[derive(Debug, Clone)]
pub struct Decomposition {
    pub before: Vec<Test>,
    pub binders: Vec<Binder>,
    pub subtasks: Vec<Subtask>,
}

#[derive(Debug, Clone)]
pub struct Method {
    pub goal: Option<Vec<Test>>,
    pub decompositions: Vec<Decomposition>,
}

#[derive(Debug, Clone)]
pub struct Domain {
    pub start: State,
    pub actions: Vec<Action>,
    pub methods: Vec<Method>,
}

fn object(s: &State, f: &Frame, path: &Object) -> Option<Value> {
    let through = |v: Option<usize>| v.map_or(Value::Null, Value::Object);
    match path {
        Object::Var(v) => Some(f[v]),
        Object::Const(o) => Some(Value::Object(*o)),
        Object::Next(p) => match object(s, f, p)? {
            Value::Object(o) => Some(through(s.next[o])),
            _ => None,
        },
        Object::Held(v) => agent(f, v).map(|a| through(s.holds[a])),
        Object::With(v, arg) => match object(s, f, arg)? {
            Value::Object(o) => agent(f, v).map(|a| through(s.with[a][o])),
            _ => None,
        },
    }
}

fn agent(f: &Frame, var: &str) -> Option<usize> {
    match f.get(var) {
        Some(Value::Agent(a)) => Some(*a),
        _ => AGENTS.iter().position(|a| *a == var),
    }
}

/// Returns the object at the end of a path, if there is one.
fn there(s: &State, f: &Frame, path: &Object) -> Option<usize> {
    match object(s, f, path) {
        Some(Value::Object(o)) => Some(o),
        _ => None,
    }
}

fn variable(f: &Frame, var: &str) -> Option<usize> {
    match f[var] {
        Value::Object(o) => Some(o),
        _ => None,
    }
}

fn compare(a: i64, op: &str, b: i64) -> bool {
    match op {
        "<" => a < b,
        ">" => a > b,
        _ => a == b,
    }
}

fn all(s: &State, f: &Frame, tests: &[Test]) -> bool {
    tests.iter().all(|t| holds(s, f, t))
}

fn with(f: &Frame, var: &str, o: usize) -> Frame {
    let mut inner = f.clone();
    inner.insert(var.into(), Value::Object(o));
    inner
}

fn holds(s: &State, f: &Frame, test: &Test) -> bool {
    match test {
        Test::Same(a, b, same) => match (object(s, f, a), object(s, f, b)) {
            (Some(a), Some(b)) => (a == b) == *same,
            _ => !same,
        },
        Test::IsNull(o) => object(s, f, o) == Some(Value::Null),
        Test::Done(o, done) => match object(s, f, o) {
            Some(Value::Object(o)) => s.done[o] == *done,
            // A step through NULL; "not done" is written with `!=`.
            _ => !done,
        },
        Test::Count(a, op, n) => agent(f, a).is_some_and(|a| compare(s.count[a], op, *n)),
        Test::Uses(a, o, wanted) => {
            let (a, o) = (agent(f, a).unwrap(), variable(f, o).unwrap());
            (s.users[o] >> a & 1 == 1) == *wanted
        }
        Test::In(o, wanted) => match (f["Os"], variable(f, o)) {
            (Value::Set(set), Some(o)) => (set >> o & 1 == 1) == *wanted,
            _ => unreachable!(),
        },
        Test::Level(op, n) => matches!(f["N"], Value::Number(level) if compare(level, op, *n)),
        Test::Users(o, n) => i64::from(s.users[variable(f, o).unwrap()].count_ones()) >= *n,
        Test::Near(o, p, a, wanted) => match (there(s, f, o), there(s, f, p)) {
            (Some(o), Some(p)) => s.near[o][p][agent(f, a).unwrap()] == *wanted,
            // As above.
            _ => !wanted,
        },
        Test::Saw(a, o, p, wanted) => match (there(s, f, o), there(s, f, p)) {
            (Some(o), Some(p)) => (s.saw[o][p] >> agent(f, a).unwrap() & 1 == 1) == *wanted,
            _ => !wanted,
        },
        Test::Or(a, b) => all(s, f, a) || all(s, f, b),
        Test::Not(a) => !all(s, f, a),
        Test::All(v, guard, body) => (0..3)
            .map(|o| with(f, v, o))
            .all(|f| !all(s, &f, guard) || all(s, &f, body)),
        Test::Some(v, guard) => (0..3).map(|o| with(f, v, o)).any(|f| all(s, &f, guard)),
    }
}

fn apply(s: &mut State, f: &Frame, effects: &[Effect]) {
    // NULL is a value like others; a value behind a step through NULL is none, and the effect changes nothing.
    let value = |s: &State, o: &Option<Object>| match o.as_ref().map(|o| object(s, f, o)) {
        Some(None) => None,
        Some(Some(Value::Object(o))) => Some(Some(o)),
        _ => Some(None),
    };
    for effect in effects {
        match effect {
            Effect::Done(o, done) => s.done[variable(f, o).unwrap()] = *done,
            Effect::Hold(a, o) => {
                if let Some(new) = value(s, o) {
                    s.holds[agent(f, a).unwrap()] = new;
                }
            }
            Effect::Next(o, to) => {
                if let Some(new) = value(s, to) {
                    s.next[variable(f, o).unwrap()] = new;
                }
            }
            Effect::Count(a) => s.count[agent(f, a).unwrap()] += 1,
            Effect::Use(o, a, adds) => {
                let (o, bit) = (variable(f, o).unwrap(), 1 << agent(f, a).unwrap());
                s.users[o] = if *adds { s.users[o] | bit } else { s.users[o] & !bit };
            }
            Effect::With(a, arg, to) => {
                if let (Some(arg), Some(new)) = (there(s, f, arg), value(s, to)) {
                    s.with[agent(f, a).unwrap()][arg] = new;
                }
            }
            Effect::Near(o, p, a, near) => {
                if let (Some(o), Some(p)) = (there(s, f, o), there(s, f, p)) {
                    s.near[o][p][agent(f, a).unwrap()] = *near;
                }
            }
            Effect::Saw(o, p, a, adds) => {
                if let (Some(o), Some(p)) = (there(s, f, o), there(s, f, p)) {
                    let bit = 1 << agent(f, a).unwrap();
                    s.saw[o][p] = if *adds { s.saw[o][p] | bit } else { s.saw[o][p] & !bit };
                }
            }
            Effect::If(tests, yes, no) => {
                let chosen = if all(s, f, tests) { yes } else { no };
                apply(s, f, chosen);
            }
            Effect::All(v, guard, body) => {
                for o in 0..3 {
                    let f = with(f, v, o);
                    if all(s, &f, guard) {
                        apply(s, &f, body);
                    }
                }
            }
        }
    }
}

/// A decomposition at work.
#[derive(Debug, Clone)]
struct Open {
    of: (usize, usize),
    frame: Frame,
    depth: usize,
    children: Vec<Child>,
}

#[derive(Debug, Clone)]
enum Child {
    Waits,
    Works(Box<Open>),
    Done,
}

/// All plans, each with its cost.
#[derive(Debug, Default)]
pub struct Plans {
    pub plans: BTreeMap<String, i64>,
    /// Whether a limit has kept it from trying all.
    pub is_cut: bool,
    work: usize,
}

pub struct Limits {
    pub interleave: bool,
    pub depth: usize,
    pub work: usize,
}

/// Returns the plans of `Do0(R, CUP, level, [CUP, BOX])`.
pub fn plans(domain: &Domain, level: i64, limits: &Limits) -> Plans {
    let mut found = Plans::default();
    let args = [Value::Agent(0), Value::Object(0), Value::Number(level), Value::Set(3)];
    for root in decompositions(domain, &domain.start, 0, &args, 0) {
        go(domain, limits, &domain.start, root, &mut Vec::new(), 0, &mut found);
    }
    found
}

/// Returns every way to take up a method: nothing to do, or an open decomposition.
fn decompositions(domain: &Domain, s: &State, method: usize, args: &[Value; 4], depth: usize) -> Vec<Child> {
    let names = ["A", "O", "N", "Os"].map(String::from);
    let frame: Frame = names.into_iter().zip(*args).collect();
    let rule = &domain.methods[method];
    if rule.goal.as_ref().is_some_and(|g| all(s, &frame, g)) {
        return vec![Child::Done];
    }
    let mut ways = Vec::new();
    for (i, d) in rule
        .decompositions
        .iter()
        .enumerate()
        .filter(|(_, d)| all(s, &frame, &d.before))
    {
        let mut frames = vec![frame.clone()];
        for binder in &d.binders {
            let passing = |f: &Frame, v: &str, t: &[Test]| -> Vec<Frame> {
                (0..3).map(|o| with(f, v, o)).filter(|f| all(s, f, t)).collect()
            };
            let bind = |f: Frame| match binder {
                Binder::Select(v, t) | Binder::Ordered(v, t, _) => passing(&f, v, t),
                Binder::Once(v, t) => passing(&f, v, t).into_iter().take(1).collect(),
                Binder::Let(v, o) => {
                    let value = object(s, &f, o).unwrap_or(Value::Null);
                    let mut f = f;
                    f.insert(v.clone(), value);
                    vec![f]
                }
            };
            frames = frames.into_iter().flat_map(bind).collect();
        }
        let children = vec![Child::Waits; d.subtasks.len()];
        ways.extend(frames.into_iter().map(|frame| {
            let children = children.clone();
            Child::Works(Box::new(Open {
                of: (method, i),
                frame,
                depth,
                children,
            }))
        }));
    }
    ways
}

/// Lists the ways down to the subtasks that may be next.
fn ready(domain: &Domain, open: &Open, interleave: bool, way: &mut Vec<usize>, found: &mut Vec<Vec<usize>>) {
    let at_work = open.children.iter().any(|c| matches!(c, Child::Works(_)));
    let subtasks = &domain.methods[open.of.0].decompositions[open.of.1].subtasks;
    for (i, child) in open.children.iter().enumerate() {
        way.push(i);
        match child {
            Child::Works(inner) => ready(domain, inner, interleave, way, found),
            Child::Waits if interleave || !at_work => {
                if subtasks[i]
                    .after
                    .iter()
                    .all(|a| matches!(open.children[*a], Child::Done))
                {
                    found.push(way.clone());
                }
            }
            Child::Waits | Child::Done => {}
        }
        way.pop();
    }
}

fn place<'a>(root: &'a mut Child, way: &[usize]) -> &'a mut Child {
    way.iter().fold(root, |child, i| match child {
        Child::Works(open) => &mut open.children[*i],
        _ => unreachable!(),
    })
}

/// Turns what has nothing left to do into something done.
fn close(child: &mut Child) {
    if let Child::Works(open) = child {
        open.children.iter_mut().for_each(close);
        if open.children.iter().all(|c| matches!(c, Child::Done)) {
            *child = Child::Done;
        }
    }
}

fn go(
    domain: &Domain,
    limits: &Limits,
    s: &State,
    mut root: Child,
    steps: &mut Vec<String>,
    cost: i64,
    found: &mut Plans,
) {
    found.work += 1;
    if found.work > limits.work {
        found.is_cut = true;
        return;
    }
    close(&mut root);
    let Child::Works(open) = &root else {
        found.plans.insert(steps.join(" "), cost);
        return;
    };
    let mut ways = Vec::new();
    ready(domain, open, limits.interleave, &mut Vec::new(), &mut ways);
    for way in ways {
        let (last, above) = way.split_last().unwrap();
        let mut copy = root.clone();
        let Child::Works(parent) = place(&mut copy, above).clone() else {
            unreachable!()
        };
        let subtask = &domain.methods[parent.of.0].decompositions[parent.of.1].subtasks[*last];
        let f = &parent.frame;
        let actor = agent(f, &subtask.agent).unwrap();
        let Some(Value::Object(thing)) = object(s, f, &subtask.object) else {
            continue;
        };
        match &subtask.call {
            Ok(number) => {
                let action = &domain.actions[*number];
                let frame = Frame::from([("A".into(), Value::Agent(actor)), ("O".into(), Value::Object(thing))]);
                if !all(s, &frame, &action.before) {
                    continue;
                }
                let price = match action.cost {
                    Cost::Const(n) => n,
                    Cost::Weight => s.weight[thing],
                    Cost::WeightAndCount => s.weight[thing] + s.count[actor],
                    Cost::Users => 2 * i64::from(s.users[thing].count_ones()),
                };
                let mut s = s.clone();
                apply(&mut s, &frame, &action.effects);
                *place(&mut copy, &way) = Child::Done;
                steps.push(format!("Act{number}({},{})", AGENTS[actor], OBJECTS[thing]));
                go(domain, limits, &s, copy, steps, cost + price, found);
                steps.pop();
            }
            Err((method, level, set)) => {
                if parent.depth + 1 > limits.depth {
                    found.is_cut = true;
                    continue;
                }
                let (Value::Number(n), Value::Set(bits)) = (f["N"], f["Os"]) else {
                    unreachable!()
                };
                let n = match level {
                    Level::Same => n,
                    Level::Less => n - 1,
                };
                let bit = |o: &Object| match object(s, f, o) {
                    Some(Value::Object(o)) => Some(1 << o),
                    _ => None,
                };
                let bits = match set {
                    SetArg::Same => Some(bits),
                    SetArg::Without(o) => bit(o).map(|b: u8| bits & !b),
                    SetArg::With(o) => bit(o).map(|b| bits | b),
                    SetArg::List(a, b) => Some(1 << a | 1 << b),
                };
                let Some(bits) = bits else { continue };
                let args = [
                    Value::Agent(actor),
                    Value::Object(thing),
                    Value::Number(n),
                    Value::Set(bits),
                ];
                for child in decompositions(domain, s, *method, &args, parent.depth + 1) {
                    *place(&mut copy, &way) = child;
                    go(domain, limits, s, copy.clone(), steps, cost, found);
                }
            }
        }
    }
}

/// Does the actions, each given with its agent and object, one after the other; `None` where one's precondition fails.
pub fn execute(domain: &Domain, steps: &[(usize, usize, usize)]) -> Option<State> {
    let mut s = domain.start.clone();
    for (number, actor, thing) in steps {
        let frame = Frame::from([("A".into(), Value::Agent(*actor)), ("O".into(), Value::Object(*thing))]);
        if !all(&s, &frame, &domain.actions[*number].before) {
            return None;
        }
        apply(&mut s, &frame, &domain.actions[*number].effects);
    }
    Some(s)
}
