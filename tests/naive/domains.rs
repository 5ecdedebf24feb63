//! Random domains for the naive planner, and the same in the language.

use crate::planner::{
    Action, Binder, Cost, Decomposition, Domain, Effect, Level, Method, OBJECTS, Object, SetArg, State, Subtask, Test,
};

/// Choices still to be used; 0, the simplest, when they are used up.
struct Choices<'a>(std::slice::Iter<'a, u16>);

impl Choices<'_> {
    fn below(&mut self, n: usize) -> usize {
        self.0.next().map_or(0, |c| usize::from(*c) % n)
    }

    fn is(&mut self, of: usize) -> bool {
        self.below(of) == of - 1
    }

    fn name(&mut self, of: &[String]) -> String {
        of[self.below(of.len())].clone()
    }
}

/// Names of variables that are never NULL, and of those that may be.
#[derive(Clone)]
struct Scope {
    sure: Vec<String>,
    maybe: Vec<String>,
    in_method: bool,
    nest: usize,
}

fn of_task(in_method: bool) -> Scope {
    Scope {
        sure: vec!["O".into()],
        maybe: Vec::new(),
        in_method,
        nest: 2,
    }
}

impl Scope {
    fn deeper(&self) -> (String, Scope) {
        let var = format!("Q{}", self.nest);
        let mut inner = self.clone();
        inner.sure.push(var.clone());
        inner.nest -= 1;
        (var, inner)
    }
}

fn agent(c: &mut Choices<'_>) -> String {
    ["A", "A", "R", "H"][c.below(4)].into()
}

fn object(s: &Scope, c: &mut Choices<'_>) -> Object {
    let names = [s.sure.clone(), s.maybe.clone()].concat();
    match c.below(10) {
        0..=2 => Object::Var(c.name(&names)),
        3 | 4 => Object::Const(c.below(3)),
        5 => Object::Next(Box::new(Object::Var(c.name(&names)))),
        6 => Object::Held(agent(c)),
        7 => Object::With(agent(c), Box::new(Object::Var(c.name(&names)))),
        8 => Object::With(agent(c), Box::new(Object::Held(agent(c)))),
        _ => Object::Next(Box::new(Object::Held(agent(c)))),
    }
}

fn tests(s: &Scope, c: &mut Choices<'_>, most: usize) -> Vec<Test> {
    (0..c.below(most + 1)).map(|_| test(s, c)).collect()
}

fn test(s: &Scope, c: &mut Choices<'_>) -> Test {
    match c.below(if s.nest > 0 { 15 } else { 11 }) {
        0 => Test::Same(object(s, c), object(s, c), false),
        1 => Test::Done(object(s, c), false),
        2 => Test::Same(object(s, c), object(s, c), true),
        3 => Test::Done(object(s, c), true),
        4 => Test::IsNull(object(s, c)),
        5 => Test::Count(agent(c), ["<", ">"][c.below(2)], c.below(3) as i64),
        6 => Test::Uses(agent(c), c.name(&s.sure), c.is(2)),
        7 if s.in_method && c.is(2) => Test::Level(["<", ">"][c.below(2)], c.below(2) as i64),
        7 if s.in_method => Test::In(c.name(&s.sure), c.is(2)),
        7 | 8 => Test::Users(c.name(&s.sure), c.below(3) as i64),
        9 => Test::Near(object(s, c), object(s, c), agent(c), c.is(8)),
        10 => Test::Saw(agent(c), object(s, c), object(s, c), c.is(8)),
        11 => Test::Or(vec![test(s, c)], vec![test(s, c)]),
        12 => Test::Not(vec![test(s, c)]),
        13 => {
            let (var, inner) = s.deeper();
            Test::All(var, tests(&inner, c, 1), vec![test(&inner, c)])
        }
        _ => {
            let (var, inner) = s.deeper();
            Test::Some(var, vec![test(&inner, c)])
        }
    }
}

fn effect(s: &Scope, c: &mut Choices<'_>) -> Effect {
    match c.below(if s.nest > 0 { 13 } else { 11 }) {
        0 | 1 => Effect::Done(c.name(&s.sure), c.below(3) != 2),
        2 | 3 => {
            let to = if c.is(2) { None } else { Some(object(s, c)) };
            Effect::Hold(agent(c), to)
        }
        4 => {
            let to = if c.is(2) { None } else { Some(object(s, c)) };
            Effect::Next(c.name(&s.sure), to)
        }
        5 => Effect::Count(agent(c)),
        6 | 7 => Effect::Use(c.name(&s.sure), agent(c), c.below(3) != 2),
        8 => {
            let to = if c.is(3) { None } else { Some(object(s, c)) };
            Effect::With(agent(c), object(s, c), to)
        }
        9 => Effect::Near(object(s, c), object(s, c), agent(c), c.below(3) != 2),
        10 => Effect::Saw(object(s, c), object(s, c), agent(c), c.below(3) != 2),
        11 => {
            let mut inner = s.clone();
            inner.nest -= 1;
            Effect::If(vec![test(&inner, c)], vec![effect(&inner, c)], vec![effect(&inner, c)])
        }
        _ => {
            let (var, inner) = s.deeper();
            Effect::All(var, tests(&inner, c, 1), vec![effect(&inner, c)])
        }
    }
}

const N_METHODS: usize = 3;
const N_ACTIONS: usize = 4;

fn decomposition(i: usize, c: &mut Choices<'_>, loops: bool) -> Decomposition {
    let mut s = of_task(true);
    let mut before = if c.is(6) { vec![test(&s, c)] } else { Vec::new() };
    let mut binders = Vec::new();
    for var in ["S", "T"].iter().take(c.below(3)) {
        let mut inner = s.clone();
        inner.sure.push((*var).into());
        let name = (*var).to_string();
        if c.is(4) {
            binders.push(Binder::Let(name.clone(), object(&s, c)));
            s.maybe.push(name);
            continue;
        }
        let filter = if c.is(2) { tests(&inner, c, 2) } else { Vec::new() };
        binders.push(match c.below(3) {
            0 => Binder::Select(name.clone(), filter),
            1 => Binder::Ordered(name.clone(), filter, c.is(2)),
            _ => Binder::Once(name.clone(), filter),
        });
        s.sure.push(name);
    }
    let mut subtasks = Vec::new();
    for label in 0..c.below(3) + usize::from(!c.is(6)) {
        let call = match c.below(7) {
            0..=3 => Ok(c.below(N_ACTIONS)),
            n => {
                let goes_down = i + 1 < N_METHODS && n != 4;
                let method = if goes_down {
                    i + 1 + c.below(N_METHODS - i - 1)
                } else {
                    c.below(N_METHODS)
                };
                let level = if goes_down || (loops && c.is(2)) {
                    Level::Same
                } else {
                    Level::Less
                };
                if matches!(level, Level::Less) {
                    before.insert(0, Test::Level(">", 0));
                }
                let set = match c.below(4) {
                    0 => SetArg::Same,
                    1 => SetArg::Without(object(&s, c)),
                    2 => SetArg::With(object(&s, c)),
                    _ => SetArg::List(c.below(3), c.below(3)),
                };
                Err((method, level, set))
            }
        };
        subtasks.push(Subtask {
            agent: agent(c),
            object: object(&s, c),
            call,
            after: (0..label).filter(|_| c.is(3)).collect(),
        });
    }
    Decomposition {
        before,
        binders,
        subtasks,
    }
}

/// With `loops`, a method may come back with the same arguments.
pub fn domain(choices: &[u16], loops: bool) -> Domain {
    let c = &mut Choices(choices.iter());
    let methods = (0..N_METHODS).map(|i| Method {
        goal: c.is(5).then(|| vec![test(&of_task(true), c)]),
        decompositions: (0..1 + c.below(3)).map(|_| decomposition(i, c, loops)).collect(),
    });
    let methods = methods.collect();
    let actions = (0..N_ACTIONS).map(|_| Action {
        before: if c.is(4) {
            vec![test(&of_task(false), c)]
        } else {
            Vec::new()
        },
        effects: (0..c.below(4)).map(|_| effect(&of_task(false), c)).collect(),
        cost: match c.below(6) {
            0 => Cost::Weight,
            1 => Cost::WeightAndCount,
            2 => Cost::Users,
            n => Cost::Const(n as i64 - 3),
        },
    });
    let actions = actions.collect();
    let mut maybe = |n: usize| c.below(n + 1).checked_sub(1);
    let start = State {
        holds: [maybe(3), maybe(3)],
        next: [maybe(3), maybe(3), maybe(3)],
        count: [c.below(3) as i64, c.below(3) as i64],
        done: [c.is(2), c.is(2), c.is(2)],
        users: [c.below(4) as u8, c.below(4) as u8, c.below(4) as u8],
        weight: [c.below(3) as i64, 1, 2],
        with: std::array::from_fn(|_| std::array::from_fn(|_| c.below(4).checked_sub(1))),
        near: std::array::from_fn(|_| std::array::from_fn(|_| std::array::from_fn(|_| c.is(2)))),
        saw: std::array::from_fn(|_| std::array::from_fn(|_| c.below(4) as u8)),
    };
    Domain {
        start,
        actions,
        methods,
    }
}

/// Several tasks in a row that know nothing of each other, with choices inside, and then actions that may fail: what a search
/// may jump back over.
pub fn row(choices: &[u16]) -> Domain {
    let mut domain = domain(choices, false);
    let mut reversed: Vec<u16> = choices.to_vec();
    reversed.reverse();
    let c = &mut Choices(reversed.iter());
    let n = 3 + c.below(2);
    let subtasks = (0..n).map(|label| Subtask {
        agent: agent(c),
        object: Object::Const(c.below(3)),
        call: match label + 1 == n || c.is(5) {
            true => Ok(c.below(N_ACTIONS)),
            false => Err((1 + c.below(N_METHODS - 1), Level::Same, SetArg::Same)),
        },
        after: (label > 0).then(|| label - 1).into_iter().collect(),
    });
    domain.methods[0] = Method {
        goal: None,
        decompositions: vec![Decomposition {
            before: Vec::new(),
            binders: Vec::new(),
            subtasks: subtasks.collect(),
        }],
    };
    // Two tasks that choose, each of which changes one attribute, and a last action that fails often.
    for action in 0..2 {
        let sure = "O".to_owned();
        domain.actions[action].effects = vec![match (action, c.below(2)) {
            (0, 0) => Effect::Use(sure, agent(c), c.is(2)),
            (0, _) => Effect::Done(sure, c.is(2)),
            (_, 0) => Effect::Hold(agent(c), Some(Object::Var(sure))),
            _ => Effect::Next(sure, Some(Object::Const(c.below(3)))),
        }];
        let mut inner = of_task(true);
        inner.sure.push("S".into());
        domain.methods[1 + action].goal = None;
        domain.methods[1 + action].decompositions[0] = Decomposition {
            before: Vec::new(),
            binders: vec![Binder::Select("S".into(), tests(&inner, c, 1))],
            subtasks: vec![Subtask {
                agent: "A".into(),
                object: Object::Var("S".into()),
                call: Ok(action),
                after: Vec::new(),
            }],
        };
    }
    let last = 2 + c.below(N_ACTIONS - 2);
    if let Some(subtask) = domain.methods[0].decompositions[0].subtasks.last_mut() {
        subtask.call = Ok(last);
    }
    domain.actions[last].before = (0..1 + c.below(2)).map(|_| test(&of_task(false), c)).collect();
    domain
}

fn path(o: &Object) -> String {
    match o {
        Object::Var(v) => v.clone(),
        Object::Const(o) => OBJECTS[*o].into(),
        Object::Next(p) => format!("{}.next", path(p)),
        Object::Held(a) => format!("{a}.holds"),
        Object::With(a, arg) => format!("{a}.with({})", path(arg)),
    }
}

fn show(tests: &[Test]) -> String {
    tests.iter().map(show_test).collect()
}

fn show_test(t: &Test) -> String {
    match t {
        Test::Same(a, b, same) => format!("{} {} {}; ", path(a), if *same { "==" } else { "!=" }, path(b)),
        Test::IsNull(o) => format!("{} == NULL; ", path(o)),
        Test::Done(o, done) => format!("{}.done {} true; ", path(o), if *done { "==" } else { "!=" }),
        Test::Count(a, op, n) => format!("{a}.count {op} {n}; "),
        Test::Uses(a, o, yes) => format!("{a} {} {o}.users; ", if *yes { ">>" } else { "!>>" }),
        Test::In(o, yes) => format!("{o} {} Os; ", if *yes { ">>" } else { "!>>" }),
        Test::Level(op, n) => format!("N {op} {n}; "),
        Test::Users(o, n) => format!("size({o}.users) >= {n}; "),
        Test::Near(o, p, a, near) => {
            let sign = if *near { "==" } else { "!=" };
            format!("{}.near({}, {a}) {sign} true; ", path(o), path(p))
        }
        Test::Saw(a, o, p, yes) => format!("{a} {} {}.saw({}); ", if *yes { ">>" } else { "!>>" }, path(o), path(p)),
        Test::Or(a, b) => format!("OR{{ {}}}{{ {}}}; ", show(a), show(b)),
        Test::Not(a) => format!("NOT{{ {}}}; ", show(a)),
        Test::All(v, guard, body) => format!("FORALL(Object {v}, {{ {}}}, {{ {}}}); ", show(guard), show(body)),
        Test::Some(v, guard) => format!("EXIST(Object {v}, {{ {}}}); ", show(guard)),
    }
}

fn show_effect(e: &Effect) -> String {
    let effects = |all: &[Effect]| all.iter().map(show_effect).collect::<String>();
    let or_null = |o: &Option<Object>| o.as_ref().map_or("NULL".into(), path);
    match e {
        Effect::Done(o, true) => format!("{o}.done = true; "),
        Effect::Done(o, false) => format!("{o}.done = NULL; "),
        Effect::Hold(a, o) => format!("{a}.holds = {}; ", or_null(o)),
        Effect::Next(o, to) => format!("{o}.next = {}; ", or_null(to)),
        Effect::Count(a) => format!("{a}.count = {a}.count + 1; "),
        Effect::Use(o, a, true) => format!("{o}.users <<= {a}; "),
        Effect::Use(o, a, false) => format!("{o}.users =>> {a}; "),
        Effect::With(a, arg, to) => format!("{a}.with({}) = {}; ", path(arg), or_null(to)),
        Effect::Near(o, p, a, near) => {
            let value = if *near { "true" } else { "NULL" };
            format!("{}.near({}, {a}) = {value}; ", path(o), path(p))
        }
        Effect::Saw(o, p, a, true) => format!("{}.saw({}) <<= {a}; ", path(o), path(p)),
        Effect::Saw(o, p, a, false) => format!("{}.saw({}) =>> {a}; ", path(o), path(p)),
        Effect::If(t, yes, no) => format!("IF{{ {}}}{{ {}}}ELSE{{ {}}}; ", show(t), effects(yes), effects(no)),
        Effect::All(v, guard, body) => format!("FORALL(Object {v}, {{ {}}}, {{ {}}}); ", show(guard), effects(body)),
    }
}

fn show_decomposition(d: &Decomposition) -> String {
    let mut steps = String::new();
    for binder in &d.binders {
        steps += &match binder {
            Binder::Select(v, t) => format!("{v} = SELECT(Object, {{ {}}}); ", show(t)),
            Binder::Ordered(v, t, down) => {
                let sign = if *down { ">" } else { "<" };
                format!("{v} = SELECTORDERED(Object, {{ {}}}, {v}.weight, {sign}); ", show(t))
            }
            Binder::Once(v, t) => format!("{v} = SELECTONCE(Object, {{ {}}}); ", show(t)),
            Binder::Let(v, o) => format!("let {v} = {}; ", path(o)),
        };
    }
    for (label, s) in d.subtasks.iter().enumerate() {
        let (a, o) = (&s.agent, path(&s.object));
        let call = match &s.call {
            Ok(n) => format!("Act{n}({a}, {o})"),
            Err((n, level, set)) => {
                let level = if matches!(level, Level::Same) { "N" } else { "N - 1" };
                let set = match set {
                    SetArg::Same => "Os".into(),
                    SetArg::Without(o) => format!("Os - {}", path(o)),
                    SetArg::With(o) => format!("Os + {}", path(o)),
                    SetArg::List(a, b) => format!("[{}, {}]", OBJECTS[*a], OBJECTS[*b]),
                };
                format!("Do{n}({a}, {o}, {level}, {set})")
            }
        };
        let after: Vec<String> = s.after.iter().map(|l| format!("> {l}")).collect();
        steps += &format!("{label}: {call} {}; ", after.join(", "));
    }
    format!(
        "\n    {{ preconditions {{ {}}}; subtasks {{ {steps}}}; }}",
        show(&d.before)
    )
}

/// Writes the domain in the language.
pub fn text(domain: &Domain) -> String {
    let mut tasks = String::new();
    for (i, a) in domain.actions.iter().enumerate() {
        let effects: String = a.effects.iter().map(show_effect).collect();
        let cost = match a.cost {
            Cost::Const(n) => n.to_string(),
            Cost::Weight => "O.weight".into(),
            Cost::WeightAndCount => "O.weight + A.count".into(),
            Cost::Users => "2 * size(O.users)".into(),
        };
        let before = show(&a.before);
        tasks += &format!(
            "  action Act{i}(Agent A, Object O) {{ preconditions {{ {before}}}; effects {{ {effects}}}; cost {{ {cost} }}; duration {{ (1 + O.weight, 9) }}; }}\n"
        );
    }
    for (i, m) in domain.methods.iter().enumerate() {
        let goal = m
            .goal
            .as_ref()
            .map_or(String::new(), |g| format!("goal {{ {}}};", show(g)));
        let all: String = m.decompositions.iter().map(show_decomposition).collect();
        tasks += &format!("  method Do{i}(Agent A, Object O, number N, set Object Os) {{ {goal}{all} }}\n");
    }
    let s = &domain.start;
    let mut facts = String::new();
    for (i, a) in crate::planner::AGENTS.iter().enumerate() {
        facts += &format!("{a}.count = {}; ", s.count[i]);
        for (object, with) in OBJECTS.iter().zip(&s.with[i]) {
            facts += &with.map_or(String::new(), |to| format!("{a}.with({object}) = {}; ", OBJECTS[to]));
        }
        facts += &s.holds[i].map_or(String::new(), |o| format!("{a}.holds = {}; ", OBJECTS[o]));
    }
    for (i, o) in OBJECTS.iter().enumerate() {
        facts += &format!("{o}.weight = {}; ", s.weight[i]);
        facts += &s.next[i].map_or(String::new(), |n| format!("{o}.next = {}; ", OBJECTS[n]));
        facts += &if s.done[i] {
            format!("{o}.done = true; ")
        } else {
            String::new()
        };
        for (j, other) in OBJECTS.iter().enumerate() {
            for (bit, a) in crate::planner::AGENTS.iter().enumerate() {
                if s.near[i][j][bit] {
                    facts += &format!("{o}.near({other}, {a}) = true; ");
                }
                if s.saw[i][j] >> bit & 1 == 1 {
                    facts += &format!("{o}.saw({other}) <<= {a}; ");
                }
            }
        }
        for (bit, a) in crate::planner::AGENTS
            .iter()
            .enumerate()
            .filter(|(bit, _)| s.users[i] >> bit & 1 == 1)
        {
            let _ = bit;
            facts += &format!("{o}.users <<= {a}; ");
        }
    }
    format!(
        "factdatabase {{
  define entityType Object;
  define entityAttributes Agent {{ dynamic atom number count; dynamic atom Object holds; dynamic atom Object with(Object); }}
  define entityAttributes Object {{ static atom number weight; dynamic atom bool done; dynamic atom Object next; dynamic set Agent users; dynamic atom bool near(Object, Agent By); dynamic set Agent saw(Object What); }}
  R = new Agent; H = new Agent; CUP = new Object; BOX = new Object; PEN = new Object;
  {facts}
}}
HTN {{
{tasks}}}
"
    )
}
