//! A pair as HATP text.
//!
//! | HDDL | HATP |
//! |---|---|
//! | type, object | entity type, entity |
//! | `(p)` | a bool of the entity `WORLD` |
//! | `(p ?x)` | a bool of `x`, set or `NULL`: what never held and what holds no more are the same state |
//! | `(p ?x ?y)`, `(p ?x ?y ?z)` | a set of `x`: `y >> x.p`, `z >> x.p(y)` |
//! | a method's variables | `SELECT`s, in the order of `binding` |
//! | initial network, goal | the methods `Problem()`, `Goal()` |

mod effects;
mod facts;
mod limits;
mod tests;

use std::fmt::Write;

use std::cell::RefCell;

use indexmap::{IndexMap, IndexSet};

use super::ast::{Action, Cost, Formula, Kinds, OBJECT, Pair, Scope, TaskRef, Term, TypeId};
use super::binding::{Bindings, Counts, bindings};
use super::bodies::{Bodies, Body, bodies};
use super::formulas::visit;
use super::names::{MethodName, Namer, Names, TaskName, plain};
use super::problems::Problems;
use tests::Tests;

/// What is written everywhere: the names, and where attributes live.
struct Writer<'p> {
    pair: &'p Pair,
    bodies: Bodies,
    out: String,
    types: Vec<String>,
    objects: Vec<String>,
    predicates: Vec<String>,
    functions: Vec<String>,
    actions: Vec<String>,
    tasks: Vec<String>,
    entity_names: Namer,
    /// Names of tasks and actions given so far.
    late_names: RefCell<Namer>,
    /// The type and the entity that have what speaks of no object.
    world: (String, String),
    /// The type of each position of each predicate: wide enough for every use.
    positions: Vec<Vec<TypeId>>,
    function_positions: Vec<Vec<TypeId>>,
    /// The bool that says that an entity is of the type, where an `either` asks.
    is_attributes: IndexMap<TypeId, String>,
    /// The copy of a predicate that an action's conditions read after it has changed.
    before_attributes: IndexMap<usize, String>,
}

/// Writes a pair without errors; says if it is larger than HATP may be.
pub(super) fn write(pair: &Pair, problems: &mut Problems) -> (String, Names) {
    let mut writer = Writer::new(pair);
    problems.extend(writer.too_many_values());
    if problems.has_errors() {
        return (String::new(), Names::default());
    }
    let (problem, goal) = {
        let mut tasks = Namer::default();
        let none = |_: &str| false;
        writer.actions = pair.actions.iter().map(|a| tasks.fresh(&a.name.text, &none)).collect();
        writer.tasks = pair.tasks.iter().map(|t| tasks.fresh(&t.name.text, &none)).collect();
        let has_goal = !matches!(&pair.goal, Formula::And(all) if all.is_empty());
        let problem = tasks.fresh("Problem", &none);
        let goal = has_goal.then(|| tasks.fresh("Goal", &none));
        writer.late_names = RefCell::new(tasks);
        (problem, goal)
    };
    writer.header(&problem);
    writer.facts();
    let names = writer.network(problem, goal);
    problems.extend(writer.too_many_words());
    (writer.out, names)
}

impl<'p> Writer<'p> {
    fn new(pair: &'p Pair) -> Self {
        let none = |_: &str| false;
        let (mut types, mut attributes, mut entity_names) = (Namer::default(), Namer::default(), Namer::default());
        let named = |namer: &mut Namer, names: &mut dyn Iterator<Item = &'p str>| -> Vec<String> {
            names.map(|n| namer.fresh(n, &none)).collect()
        };
        let type_names = named(&mut types, &mut pair.types.iter().map(|t| t.name.text.as_str()));
        let objects = named(
            &mut entity_names,
            &mut pair.objects.iter().map(|o| o.name.text.as_str()),
        );
        let predicates = named(
            &mut attributes,
            &mut pair.predicates.iter().map(|p| p.name.text.as_str()),
        );
        let functions = named(
            &mut attributes,
            &mut pair.functions.iter().map(|f| f.name.text.as_str()),
        );
        let bodies = bodies(pair);
        let mut writer = Writer {
            pair,
            out: String::new(),
            types: type_names,
            objects,
            predicates,
            functions,
            actions: Vec::new(),
            tasks: Vec::new(),
            late_names: RefCell::default(),
            world: (types.fresh("World", &none), entity_names.fresh("WORLD", &none)),
            entity_names,
            positions: positions(pair, &bodies),
            function_positions: function_positions(pair),
            is_attributes: IndexMap::new(),
            before_attributes: IndexMap::new(),
            bodies,
        };
        for ty in asked_types(pair, &writer.bodies) {
            let name = attributes.fresh(&format!("is_{}", writer.types[ty]), &none);
            writer.is_attributes.insert(ty, name);
        }
        for predicate in effects::read_late(pair) {
            let name = attributes.fresh(&format!("{}_before", writer.predicates[predicate]), &none);
            writer.before_attributes.insert(predicate, name);
        }
        writer
    }

    fn line(&mut self, text: &str) {
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn header(&mut self, problem: &str) {
        let (domain, name) = (plain(&self.pair.domain), plain(&self.pair.problem));
        self.line(&format!(
            "// Imported from HDDL: domain {domain}, problem {name}. The task to plan: --task '{problem}()'"
        ));
        self.line(
            "// A letter that HATP has not in names is written `_`; a comment says what else is called otherwise in HDDL.",
        );
        // What is said twice, never used or without an end is said so in HDDL.
        self.line(
            "// sgap: allow-file(no-agent, unused-parameter, unused-variable, unreached-task, never-applies, endless-recursion)",
        );
        self.line("");
        if self.bodies.interleaves {
            self.line("settings { interleave = true; }");
            self.line("");
        }
    }

    /// Writes actions, tasks, the problem and its goal.
    fn network(&mut self, problem: String, goal: Option<String>) -> Names {
        self.line("HTN {");
        for (at, action) in self.pair.actions.iter().enumerate() {
            self.action(at, action);
        }
        let counts = Counts::new(self.pair);
        let mut names = Names {
            objects: self.names_of(&self.objects, self.pair.objects.iter().map(|o| &o.name.text)),
            actions: self.names_of(&self.actions, self.pair.actions.iter().map(|a| &a.name.text)),
            tasks: IndexMap::new(),
            problem,
            late: IndexSet::new(),
            goal,
            start: self.called(&self.bodies.start),
        };
        for at in 0..self.pair.tasks.len() {
            let methods = self.task(at, &counts, &mut names.late);
            let name = self.pair.tasks[at].name.text.clone();
            names.tasks.insert(self.tasks[at].clone(), TaskName { name, methods });
        }
        self.start(&mut names, &counts);
        self.line("}");
        names
    }

    fn names_of<'a>(&self, hatp: &[String], hddl: impl Iterator<Item = &'a String>) -> IndexMap<String, String> {
        hatp.iter().cloned().zip(hddl.cloned()).collect()
    }

    /// Returns the subtasks of a method by name.
    fn called(&self, body: &Body) -> Vec<String> {
        let name = |task: TaskRef| match task {
            TaskRef::Action(a) => self.actions[a].clone(),
            TaskRef::Task(t) => self.tasks[t].clone(),
        };
        body.network.steps.iter().map(|s| name(s.task)).collect()
    }

    /// Gives the variables of a scope names that no entity has.
    fn variables(&self, scope: &Scope) -> Vec<String> {
        let mut namer = Namer::default();
        let taken = |name: &str| self.entity_names.has(name);
        scope.0.iter().map(|v| namer.fresh(&v.name.text, &taken)).collect()
    }

    fn params(&self, scope: &Scope, n: usize, vars: &[String]) -> String {
        let params = scope.0.iter().take(n).zip(vars);
        let params = params.map(|(v, name)| format!("{} {name}", self.types[self.pair.joined(&v.kinds)]));
        params.collect::<Vec<_>>().join(", ")
    }

    /// Returns ` // name` where nobody would guess what HDDL calls it.
    fn called_otherwise(&self, hatp: &str, hddl: &str) -> String {
        if hatp == plain(hddl) {
            return String::new();
        }
        format!(" // {hddl}")
    }

    fn action(&mut self, at: usize, action: &Action) {
        let vars = self.variables(&action.scope);
        let (name, params) = (
            self.actions[at].clone(),
            self.params(&action.scope, action.n_params, &vars),
        );
        let comment = self.called_otherwise(&name, &action.name.text);
        self.line(&format!("action {name}({params}) {{{comment}"));
        let mut tests = Tests::new(self, &action.scope, &vars);
        for (v, variable) in action.scope.0.iter().take(action.n_params).enumerate() {
            if variable.kinds.0.len() > 1 {
                tests.test(&Formula::Is(Term::Var(v), variable.kinds.clone()));
            }
        }
        tests.test(&action.precondition);
        let preconditions = tests.out;
        if !preconditions.is_empty() {
            self.line(&format!("preconditions {{\n{preconditions}}};"));
        }
        let effects = self.effects(action, &vars);
        if !effects.is_empty() {
            self.line(&format!("effects {{\n{effects}}};"));
        }
        if self.pair.has_costs {
            let parts: Vec<String> = action.costs.iter().map(|c| self.cost(c, &vars)).collect();
            let cost = if parts.is_empty() {
                "0".to_owned()
            } else {
                parts.join(" + ")
            };
            self.line(&format!("cost {{ {cost} }};"));
        }
        self.line("}\n");
    }

    fn cost(&self, cost: &Cost, vars: &[String]) -> String {
        match cost {
            Cost::Number(x) => x.to_string(),
            Cost::Function(function, args) => {
                let args: Vec<&str> = args.iter().map(|t| self.term(*t, vars)).collect();
                self.attribute(&self.functions[*function], &args)
            }
        }
    }

    fn term<'a>(&'a self, term: Term, vars: &'a [String]) -> &'a str {
        match term {
            Term::Var(v) => &vars[v],
            Term::Object(o) => &self.objects[o],
        }
    }

    /// Returns `x.name(y, z)` for the arguments x, y, z.
    fn attribute(&self, name: &str, args: &[&str]) -> String {
        match args {
            [] => format!("{}.{name}", self.world.1),
            [owner] => format!("{owner}.{name}"),
            [owner, rest @ ..] => format!("{owner}.{name}({})", rest.join(", ")),
        }
    }

    /// Writes a task with its methods.
    fn task(&mut self, at: usize, counts: &Counts, late: &mut IndexSet<String>) -> Vec<MethodName> {
        let task = &self.pair.tasks[at];
        let vars = self.variables(&task.params);
        let params = self.params(&task.params, task.params.0.len(), &vars);
        let name = self.tasks[at].clone();
        let comment = self.called_otherwise(&name, &task.name.text);
        self.line(&format!("method {name}({params}) {{{comment}"));
        let (mut names, mut own) = (Vec::new(), String::new());
        for (m, method) in self.pair.methods.iter().enumerate() {
            if method.task != at {
                continue;
            }
            let body = &self.bodies.methods[m];
            let bound = bindings(self.pair, body, &self.bodies.is_dynamic, counts);
            let called = self.late_tasks(body, &method.name.text, counts, &mut own);
            let text = self.decomposition(body, &bound, &called, None);
            late.extend(called);
            names.push(MethodName {
                name: method.name.text.clone(),
                subtasks: self.called(body),
            });
            self.line(&format!("{{ // {}\n{text}}}", method.name.text));
        }
        self.line("}\n");
        self.out.push_str(&own);
        names
    }

    /// Writes the tasks that bind variables when their turn comes; returns their names.
    fn late_tasks(&self, body: &Body, method: &str, counts: &Counts, out: &mut String) -> Vec<String> {
        let mut called = Vec::new();
        for late in &body.late {
            let name = self.late_names.borrow_mut().fresh(method, &|_| false);
            let vars = self.variables(&late.body.scope);
            let params = self.params(&late.body.scope, late.body.n_params, &vars);
            let bound = bindings(self.pair, &late.body, &self.bodies.is_dynamic, counts);
            let text = self.decomposition(&late.body, &bound, &[], None);
            let _ = writeln!(
                out,
                "method {name}({params}) {{ // a subtask of {method}\n{{\n{text}}}\n}}\n"
            );
            called.push(name);
        }
        called
    }

    /// Writes one way to do a task; `late` are the names of its subtasks that bind variables, and `last` comes after all.
    fn decomposition(&self, body: &Body, bound: &Bindings, late: &[String], last: Option<&str>) -> String {
        let vars = self.variables(&body.scope);
        let tests = |formulas: &[Formula]| {
            let mut tests = Tests::new(self, &body.scope, &vars);
            formulas.iter().for_each(|f| tests.test(f));
            tests.out
        };
        let mut out = String::new();
        let preconditions = tests(&bound.preconditions);
        if !preconditions.is_empty() {
            let _ = writeln!(out, "preconditions {{\n{preconditions}}};");
        }
        let mut steps = String::new();
        for select in &bound.selects {
            let ty = &self.types[self.pair.joined(&body.scope.0[select.var].kinds)];
            let filter = tests(&select.filter).replace('\n', " ");
            let var = &vars[select.var];
            let _ = writeln!(steps, "{var} = SELECT({ty}, {{{}}});", filter.trim_end());
        }
        let called = self.called(body);
        let network = &body.network;
        for (at, name) in called.iter().enumerate() {
            let is_late = body.late.iter().zip(late).find(|(l, _)| l.step == at);
            let name = is_late.map_or(name, |(_, name)| name);
            let args = body.args(at);
            let args: Vec<&str> = args.iter().map(|t| self.term(*t, &vars)).collect();
            let order = order(network.after[at].iter().copied());
            let _ = writeln!(steps, "{}: {name}({}){order};", at + 1, args.join(", "));
        }
        if let Some(last) = last {
            let n = network.steps.len();
            let is_last = |step: &usize| !network.after.iter().any(|after| after.contains(step));
            let order = order((0..n).filter(is_last));
            let _ = writeln!(steps, "{}: {last}(){order};", n + 1);
        }
        if !steps.is_empty() {
            let _ = writeln!(out, "subtasks {{\n{steps}}};");
        }
        out
    }

    /// Writes the problem and its goal as methods.
    fn start(&mut self, names: &mut Names, counts: &Counts) {
        let body = &self.bodies.start;
        let bound = bindings(self.pair, body, &self.bodies.is_dynamic, counts);
        let mut own = String::new();
        let called = self.late_tasks(body, &names.problem, counts, &mut own);
        let text = self.decomposition(body, &bound, &called, names.goal.as_deref());
        names.late.extend(called);
        self.out.push_str(&own);
        self.line(&format!("method {}() {{\n{{\n{text}}}\n}}", names.problem));
        if let Some(goal) = &names.goal {
            let vars = self.variables(&self.pair.goal_scope);
            let mut tests = Tests::new(self, &self.pair.goal_scope, &vars);
            tests.test(&self.pair.goal);
            let text = tests.out;
            self.line(&format!(
                "\nmethod {goal}() {{\n{{\npreconditions {{\n{text}}};\n}}\n}}"
            ));
        }
    }
}

/// Returns ` > 1, > 2` for the subtasks 0 and 1.
fn order(after: impl Iterator<Item = usize>) -> String {
    let marks: Vec<String> = after.map(|s| format!("> {}", s + 1)).collect();
    match marks.is_empty() {
        true => String::new(),
        false => format!(" {}", marks.join(", ")),
    }
}

/// All formulas of a pair with their scopes: those of the methods as they are written.
fn formulas<'a>(pair: &'a Pair, bodies: &'a Bodies, seen: &mut dyn FnMut(&'a Formula, &'a Scope)) {
    for action in &pair.actions {
        seen(&action.precondition, &action.scope);
        action.effects.iter().for_each(|e| seen(&e.condition, &action.scope));
    }
    for body in bodies.methods.iter().chain([&bodies.start]) {
        body.literals.iter().for_each(|f| seen(f, &body.scope));
        for late in &body.late {
            late.body.literals.iter().for_each(|f| seen(f, &late.body.scope));
        }
    }
    seen(&pair.goal, &pair.goal_scope);
}

/// Returns the type of each position of each predicate, as wide as its uses.
fn positions(pair: &Pair, bodies: &Bodies) -> Vec<Vec<TypeId>> {
    let mut positions: Vec<Vec<TypeId>> = Vec::new();
    for predicate in &pair.predicates {
        positions.push(predicate.params.iter().map(|k| pair.joined(k)).collect());
    }
    let mut widen = |predicate: usize, args: &[Term], scope: &Scope| {
        for (position, arg) in args.iter().enumerate() {
            let used = pair.joined(&pair.kinds_of(*arg, scope));
            let position = &mut positions[predicate][position];
            *position = pair.joined(&Kinds(vec![*position, used]));
        }
    };
    formulas(pair, bodies, &mut |formula, scope| {
        visit(formula, &mut |part| {
            if let Formula::Atom(predicate, args) = part {
                widen(*predicate, args, scope);
            }
        });
    });
    for action in &pair.actions {
        for effect in &action.effects {
            widen(effect.predicate, &effect.args, &action.scope);
        }
    }
    positions
}

fn function_positions(pair: &Pair) -> Vec<Vec<TypeId>> {
    let mut positions: Vec<Vec<TypeId>> = Vec::new();
    for function in &pair.functions {
        positions.push(function.params.iter().map(|k| pair.joined(k)).collect());
    }
    for action in &pair.actions {
        for cost in &action.costs {
            if let Cost::Function(function, args) = cost {
                for (position, arg) in args.iter().enumerate() {
                    let used = pair.joined(&pair.kinds_of(*arg, &action.scope));
                    let position = &mut positions[*function][position];
                    *position = pair.joined(&Kinds(vec![*position, used]));
                }
            }
        }
    }
    positions
}

/// Returns the types that some variable has beside another one.
fn asked_types(pair: &Pair, bodies: &Bodies) -> Vec<TypeId> {
    let mut found: Vec<TypeId> = Vec::new();
    let mut ask = |kinds: &Kinds| {
        if kinds.0.len() > 1 {
            found.extend(&kinds.0);
        }
    };
    for scope in pair.actions.iter().map(|a| &a.scope).chain([&pair.goal_scope]) {
        scope.0.iter().for_each(|v| ask(&v.kinds));
    }
    for body in bodies.methods.iter().chain([&bodies.start]) {
        body.scope.0.iter().for_each(|v| ask(&v.kinds));
    }
    formulas(pair, bodies, &mut |formula, _| {
        visit(formula, &mut |part| {
            if let Formula::Is(_, kinds) = part {
                found.extend(&kinds.0);
            }
        });
    });
    found.retain(|t| *t != OBJECT);
    found.sort_unstable();
    found.dedup();
    found
}
