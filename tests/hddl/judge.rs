//! A second opinion on plans in the competition's format: reads the HDDL files and the plan with code of its own, executes
//! the actions, and finds each method's variables by trial. Slow and plain on purpose; shares nothing with the importer.

use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug, Clone, PartialEq)]
enum S {
    Word(String),
    List(Vec<S>),
}

impl S {
    fn word(&self) -> &str {
        match self {
            S::Word(w) => w,
            S::List(l) => panic!("a word, not {l:?}"),
        }
    }

    fn list(&self) -> &[S] {
        match self {
            S::List(l) => l,
            S::Word(w) => panic!("a list, not {w}"),
        }
    }
}

fn parse(text: &str) -> S {
    let text: String = text
        .lines()
        .map(|l| l.split(';').next().unwrap().to_lowercase() + " ")
        .collect();
    let text = text.replace('(', " ( ").replace(')', " ) ");
    let mut stack: Vec<Vec<S>> = vec![Vec::new()];
    for token in text.split_whitespace() {
        match token {
            "(" => stack.push(Vec::new()),
            ")" => {
                let list = stack.pop().unwrap();
                stack.last_mut().unwrap().push(S::List(list));
            }
            word => stack.last_mut().unwrap().push(S::Word(word.into())),
        }
    }
    stack.remove(0).remove(0)
}

/// Names with their types; `either` has several.
fn typed(list: &[S]) -> Vec<(String, Vec<String>)> {
    let mut out: Vec<(String, Vec<String>)> = Vec::new();
    let mut from = 0;
    let mut i = 0;
    while i < list.len() {
        if list[i] == S::Word("-".into()) {
            let types = match &list[i + 1] {
                S::Word(t) => vec![t.clone()],
                S::List(l) => l[1..].iter().map(|t| t.word().to_owned()).collect(),
            };
            out[from..].iter_mut().for_each(|(_, t)| *t = types.clone());
            from = out.len();
            i += 2;
        } else {
            out.push((list[i].word().into(), vec!["object".into()]));
            i += 1;
        }
    }
    out
}

type Atom = Vec<String>;
type State = BTreeSet<Atom>;
type Binding = BTreeMap<String, String>;

struct Action {
    params: Vec<(String, Vec<String>)>,
    precondition: S,
    effect: S,
}

struct Method {
    task: Vec<String>,
    params: Vec<(String, Vec<String>)>,
    precondition: S,
    constraints: S,
    /// Label, task and its arguments.
    steps: Vec<(String, Vec<String>)>,
    before: Vec<(usize, usize)>,
}

pub struct Pair {
    parents: BTreeMap<String, String>,
    objects: BTreeMap<String, String>,
    actions: BTreeMap<String, Action>,
    tasks: BTreeMap<String, Vec<(String, Vec<String>)>>,
    /// By task and name.
    methods: BTreeMap<(String, String), Method>,
    init: State,
    values: BTreeMap<Atom, f64>,
    goal: S,
    start: Method,
}

fn nothing() -> S {
    S::List(vec![S::Word("and".into())])
}

fn clause<'a>(parts: &'a [S], names: &[&str]) -> Option<&'a S> {
    let at = parts
        .iter()
        .position(|p| matches!(p, S::Word(w) if names.contains(&w.as_str())));
    at.map(|at| &parts[at + 1])
}

fn conjuncts(s: Option<&S>) -> Vec<S> {
    match s.map(S::list) {
        None | Some([]) => Vec::new(),
        Some([S::Word(and), rest @ ..]) if and == "and" => rest.to_vec(),
        Some(_) => vec![s.unwrap().clone()],
    }
}

fn method(parts: &[S]) -> Method {
    let ordered = clause(parts, &[":ordered-subtasks", ":ordered-tasks"]);
    let listed = conjuncts(ordered.or(clause(parts, &[":subtasks", ":tasks"])));
    let words = |s: &S| -> Vec<String> { s.list().iter().map(|w| w.word().to_owned()).collect() };
    let steps: Vec<(String, Vec<String>)> = listed
        .iter()
        .map(|step| match step.list() {
            [S::Word(label), task @ S::List(_)] => (label.clone(), words(task)),
            _ => (String::new(), words(step)),
        })
        .collect();
    let mut before: Vec<(usize, usize)> = Vec::new();
    if ordered.is_some() {
        before.extend((1..steps.len()).map(|i| (i - 1, i)));
    }
    for order in conjuncts(clause(parts, &[":ordering"])) {
        let place = |s: &S| steps.iter().position(|(label, _)| label == s.word()).unwrap();
        before.push((place(&order.list()[1]), place(&order.list()[2])));
    }
    Method {
        task: clause(parts, &[":task"]).map_or(Vec::new(), words),
        params: clause(parts, &[":parameters"]).map_or(Vec::new(), |p| typed(p.list())),
        precondition: clause(parts, &[":precondition"]).cloned().unwrap_or(nothing()),
        constraints: clause(parts, &[":constraints"]).cloned().unwrap_or(nothing()),
        steps,
        before,
    }
}

impl Pair {
    pub fn read(domain: &str, problem: &str) -> Pair {
        let (domain, problem) = (parse(domain), parse(problem));
        let mut pair = Pair {
            parents: BTreeMap::new(),
            objects: BTreeMap::new(),
            actions: BTreeMap::new(),
            tasks: BTreeMap::new(),
            methods: BTreeMap::new(),
            init: State::new(),
            values: BTreeMap::new(),
            goal: nothing(),
            start: method(&[]),
        };
        for section in domain.list().iter().chain(problem.list()) {
            let S::List(section) = section else { continue };
            let rest = &section[1..];
            match section[0].word() {
                ":types" => pair
                    .parents
                    .extend(typed(rest).into_iter().map(|(n, t)| (n, t[0].clone()))),
                ":constants" | ":objects" => {
                    pair.objects
                        .extend(typed(rest).into_iter().map(|(n, t)| (n, t[0].clone())));
                }
                ":task" => {
                    let params = clause(rest, &[":parameters"]).map_or(Vec::new(), |p| typed(p.list()));
                    pair.tasks.insert(rest[0].word().into(), params);
                }
                ":action" => {
                    let action = Action {
                        params: clause(rest, &[":parameters"]).map_or(Vec::new(), |p| typed(p.list())),
                        precondition: clause(rest, &[":precondition"]).cloned().unwrap_or(nothing()),
                        effect: clause(rest, &[":effect"]).cloned().unwrap_or(nothing()),
                    };
                    pair.actions.insert(rest[0].word().into(), action);
                }
                ":method" => {
                    let method = method(rest);
                    pair.methods
                        .insert((method.task[0].clone(), rest[0].word().into()), method);
                }
                ":init" => {
                    for fact in rest {
                        match fact.list() {
                            [S::Word(not), _] if not == "not" => {}
                            [S::Word(eq), function, S::Word(x)] if eq == "=" => {
                                let function = function.list().iter().map(|w| w.word().into()).collect();
                                pair.values.insert(function, x.parse().unwrap());
                            }
                            atom => {
                                pair.init.insert(atom.iter().map(|w| w.word().into()).collect());
                            }
                        }
                    }
                }
                ":goal" => pair.goal = rest[0].clone(),
                ":htn" => pair.start = method(rest),
                _ => {}
            }
        }
        pair
    }

    fn is_of(&self, object: &str, types: &[String]) -> bool {
        let Some(ty) = self.objects.get(object) else {
            return false;
        };
        let mut ty = ty.as_str();
        loop {
            if types.iter().any(|t| t == ty || t == "object") {
                return true;
            }
            match self.parents.get(ty) {
                Some(parent) if parent != ty => ty = parent,
                _ => return false,
            }
        }
    }

    fn ground(&self, atom: &[S], binding: &Binding) -> Atom {
        atom.iter()
            .map(|w| binding.get(w.word()).cloned().unwrap_or(w.word().into()))
            .collect()
    }

    /// All ways to give the variables objects of their types.
    fn all(&self, vars: &[(String, Vec<String>)], binding: &Binding, found: &mut dyn FnMut(&Binding) -> bool) -> bool {
        let Some(((name, types), rest)) = vars.split_first() else {
            return found(binding);
        };
        self.objects.keys().filter(|o| self.is_of(o, types)).any(|object| {
            let mut binding = binding.clone();
            binding.insert(name.clone(), object.clone());
            self.all(rest, &binding, found)
        })
    }

    fn holds(&self, s: &S, state: &State, binding: &Binding) -> bool {
        let [head, rest @ ..] = s.list() else { return true };
        match head.word() {
            "and" => rest.iter().all(|s| self.holds(s, state, binding)),
            "or" => rest.iter().any(|s| self.holds(s, state, binding)),
            "not" => !self.holds(&rest[0], state, binding),
            "imply" => !self.holds(&rest[0], state, binding) || self.holds(&rest[1], state, binding),
            "forall" => !self.all(&typed(rest[0].list()), binding, &mut |b| {
                !self.holds(&rest[1], state, b)
            }),
            "exists" => self.all(&typed(rest[0].list()), binding, &mut |b| self.holds(&rest[1], state, b)),
            "=" => {
                let pair = self.ground(rest, binding);
                pair[0] == pair[1]
            }
            _ => state.contains(&self.ground(s.list(), binding)),
        }
    }

    /// Collects what an effect deletes and adds in a state, and what it costs.
    fn effect(&self, s: &S, state: &State, binding: &Binding, out: &mut (Vec<Atom>, Vec<Atom>, f64)) {
        let [head, rest @ ..] = s.list() else { return };
        match head.word() {
            "and" => rest.iter().for_each(|s| self.effect(s, state, binding, out)),
            "not" => out.0.push(self.ground(rest[0].list(), binding)),
            "when" if self.holds(&rest[0], state, binding) => self.effect(&rest[1], state, binding, out),
            "when" => {}
            "forall" => {
                self.all(&typed(rest[0].list()), binding, &mut |b| {
                    self.effect(&rest[1], state, b, out);
                    false
                });
            }
            "increase" => {
                out.2 += match &rest[1] {
                    S::Word(x) => x.parse().unwrap(),
                    S::List(function) => self.values[&self.ground(function, binding)],
                }
            }
            _ => out.1.push(self.ground(s.list(), binding)),
        }
    }
}

/// A line behind `root`.
struct Node {
    task: Vec<String>,
    method: String,
    below: Vec<usize>,
}

pub struct Judged {
    pub actions: usize,
    pub cost: f64,
}

/// Says what is wrong with a plan.
pub fn judge(pair: &Pair, plan: &str) -> Result<Judged, String> {
    let lines: Vec<Vec<String>> = plan
        .to_lowercase()
        .lines()
        .map(|l| l.split_whitespace().map(str::to_owned).collect())
        .collect();
    let root = lines.iter().position(|l| l.first().is_some_and(|w| w == "root"));
    let root = root.ok_or("no root")?;
    if lines[0] != ["==>"] || lines.last().ok_or("empty")? != &["<=="] {
        return Err("no frame".into());
    }
    let id = |w: &String| w.parse::<usize>().map_err(|e| format!("{w}: {e}"));
    // The actions, with every state.
    let mut states = vec![pair.init.clone()];
    let mut action_ids: Vec<usize> = Vec::new();
    let mut tasks: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    let mut cost = 0.0;
    for line in &lines[1..root] {
        let action = pair.actions.get(&line[1]).ok_or(format!("no action {}", line[1]))?;
        if action.params.len() != line.len() - 2 {
            return Err(format!("arguments of {line:?}"));
        }
        let mut binding = Binding::new();
        for ((name, types), object) in action.params.iter().zip(&line[2..]) {
            if !pair.is_of(object, types) {
                return Err(format!("{object} in {line:?} is no {types:?}"));
            }
            binding.insert(name.clone(), object.clone());
        }
        let state = states.last().unwrap();
        if !pair.holds(&action.precondition, state, &binding) {
            return Err(format!("precondition of {line:?}"));
        }
        let mut out = (Vec::new(), Vec::new(), 0.0);
        pair.effect(&action.effect, state, &binding, &mut out);
        let mut next = state.clone();
        out.0.iter().for_each(|a| {
            next.remove(a);
        });
        next.extend(out.1);
        cost += out.2;
        states.push(next);
        action_ids.push(id(&line[0])?);
        if tasks.insert(id(&line[0])?, line[1..].to_vec()).is_some() {
            return Err(format!("{} twice", line[0]));
        }
    }
    if !pair.holds(&pair.goal, states.last().unwrap(), &Binding::new()) {
        return Err("goal".into());
    }
    let mut nodes: BTreeMap<usize, Node> = BTreeMap::new();
    for line in &lines[root + 1..lines.len() - 1] {
        let arrow = line.iter().position(|w| w == "->").ok_or("no arrow")?;
        let below = line[arrow + 2..].iter().map(id).collect::<Result<Vec<_>, _>>()?;
        let task = line[1..arrow].to_vec();
        let params = pair.tasks.get(&task[0]).ok_or(format!("no task {}", task[0]))?;
        if params.len() + 1 != task.len() {
            return Err(format!("arguments of {task:?}"));
        }
        if let Some(((_, types), object)) = params.iter().zip(&task[1..]).find(|((_, t), o)| !pair.is_of(o, t)) {
            return Err(format!("{object} in {task:?} is no {types:?}"));
        }
        let node = Node {
            task: task.clone(),
            method: line[arrow + 1].clone(),
            below,
        };
        if tasks.insert(id(&line[0])?, task).is_some() {
            return Err(format!("{} twice", line[0]));
        }
        nodes.insert(id(&line[0])?, node);
    }
    let roots = lines[root][1..].iter().map(id).collect::<Result<Vec<_>, _>>()?;
    // Every task is below one other, or a root.
    let mut seen: BTreeSet<usize> = BTreeSet::new();
    for below in nodes.values().flat_map(|n| &n.below).chain(&roots) {
        if !seen.insert(*below) {
            return Err(format!("{below} has two parents"));
        }
    }
    if seen.into_iter().collect::<Vec<_>>() != tasks.keys().copied().collect::<Vec<_>>() {
        return Err("tasks without a parent, or parents without a task".into());
    }
    let judge = Judge {
        pair,
        nodes: &nodes,
        tasks: &tasks,
        places: action_ids.iter().enumerate().map(|(at, id)| (*id, at)).collect(),
        states: &states,
    };
    judge.network(&pair.start, &roots, &Binding::new(), (0, action_ids.len()))?;
    Ok(Judged {
        actions: action_ids.len(),
        cost,
    })
}

struct Judge<'a> {
    pair: &'a Pair,
    nodes: &'a BTreeMap<usize, Node>,
    tasks: &'a BTreeMap<usize, Vec<String>>,
    /// Where each action stands in the plan.
    places: BTreeMap<usize, usize>,
    states: &'a [State],
}

impl Judge<'_> {
    /// The places of all actions below a task.
    fn extent(&self, id: usize) -> BTreeSet<usize> {
        match self.nodes.get(&id) {
            Some(node) => node.below.iter().flat_map(|id| self.extent(*id)).collect(),
            None => [self.places[&id]].into(),
        }
    }

    /// `ids` are a network of a method with its variables bound so far; between `window` its preconditions must hold.
    fn network(&self, method: &Method, ids: &[usize], binding: &Binding, window: (usize, usize)) -> Result<(), String> {
        if method.steps.len() != ids.len() {
            return Err(format!("{} subtasks, not {}", ids.len(), method.steps.len()));
        }
        let mut binding = binding.clone();
        for ((_, step), id) in method.steps.iter().zip(ids) {
            let task = &self.tasks[id];
            if step[0] != task[0] || step.len() != task.len() {
                return Err(format!("{task:?} is no {step:?}"));
            }
            for (term, object) in step[1..].iter().zip(&task[1..]) {
                let known = if term.starts_with('?') {
                    binding.entry(term.clone()).or_insert(object.clone())
                } else {
                    term
                };
                if known != object {
                    return Err(format!("{term} is {known} and {object}"));
                }
            }
        }
        for (name, types) in &method.params {
            if let Some(object) = binding.get(name)
                && !self.pair.is_of(object, types)
            {
                return Err(format!("{name} is {object}, no {types:?}"));
            }
        }
        let unbound: Vec<_> = method
            .params
            .iter()
            .filter(|(n, _)| !binding.contains_key(n))
            .cloned()
            .collect();
        let extents: Vec<BTreeSet<usize>> = ids.iter().map(|id| self.extent(*id)).collect();
        let first = extents.iter().flatten().min().copied().unwrap_or(window.1);
        let states = self.states.get(window.0..=first).ok_or("no time for it")?;
        let is_met = self.pair.all(&unbound, &binding, &mut |b| {
            self.pair.holds(&method.constraints, &State::new(), b)
                && states.iter().any(|s| self.pair.holds(&method.precondition, s, b))
        });
        if !is_met {
            return Err(format!(
                "precondition of a method of {:?} with {binding:?}",
                method.task
            ));
        }
        // What comes before, through others, too.
        let n = ids.len();
        let mut before = vec![vec![false; n]; n];
        method.before.iter().for_each(|(a, b)| before[*a][*b] = true);
        for k in 0..n {
            for i in 0..n {
                for j in 0..n {
                    before[i][j] |= before[i][k] && before[k][j];
                }
            }
        }
        for (i, id) in ids.iter().enumerate() {
            let earlier = (0..n).filter(|j| before[*j][i]).flat_map(|j| &extents[j]);
            let later = (0..n).filter(|j| before[i][*j]).flat_map(|j| &extents[j]);
            let from = earlier.max().map_or(window.0, |p| (p + 1).max(window.0));
            let to = later.min().map_or(window.1, |p| (*p).min(window.1));
            let own = &extents[i];
            if own.first().is_some_and(|p| *p < from) || own.last().is_some_and(|p| *p >= to) || from > to {
                return Err(format!("{:?} is out of order", self.tasks[id]));
            }
            let Some(node) = self.nodes.get(id) else { continue };
            let key = (node.task[0].clone(), node.method.clone());
            let method = self.pair.methods.get(&key).ok_or(format!("no method {key:?}"))?;
            let mut binding = Binding::new();
            for (term, object) in method.task[1..].iter().zip(&node.task[1..]) {
                let known = if term.starts_with('?') {
                    binding.entry(term.clone()).or_insert(object.clone())
                } else {
                    term
                };
                if known != object {
                    return Err(format!("{term} is {known} and {object}"));
                }
            }
            self.network(method, &node.below, &binding, (from, to))?;
        }
        Ok(())
    }
}
