//! The walk over all uses of names, with the variables of each block.

use indexmap::IndexMap;

use super::declare::param_text;
use super::{Index, Kind, Occurrence, Symbol, SymbolId, Value};
use crate::source::Span;
use crate::syntax::ast::*;

/// Adds the occurrences of `items`.
pub(super) fn resolve(index: &mut Index, items: &[&Item]) {
    let mut walk = Walk {
        index,
        scope: Vec::new(),
        later: Vec::new(),
    };
    for item in items {
        walk.item(item);
        walk.scope.clear();
    }
}

struct Walk<'a> {
    index: &'a mut Index,
    /// The variables that live here; the innermost last.
    scope: Vec<SymbolId>,
    /// Those that a later line of the decomposition binds: a use before is a mistake, and means them all the same.
    later: Vec<SymbolId>,
}

impl Walk<'_> {
    fn occurs(&mut self, name: &Name, symbol: SymbolId) {
        let declared = self.index.get(symbol).declared;
        self.index.occurrences.push(Occurrence {
            span: name.span,
            symbol,
            is_declaration: declared.is_some_and(|d| d.name == name.span),
            is_write: false,
        });
    }

    fn occurs_if(&mut self, name: &Name, symbol: Option<SymbolId>) {
        if let Some(symbol) = symbol {
            self.occurs(name, symbol);
        }
    }

    fn ty(&mut self, name: &Name) {
        let found = self.index.type_named(&name.text);
        self.occurs_if(name, found);
    }

    fn item(&mut self, item: &Item) {
        match item {
            Item::EntityType(t) => {
                self.ty(&t.name);
                if let Some(parent) = &t.parent {
                    self.ty(parent);
                }
            }
            Item::Attributes(block) => self.attributes(block),
            Item::Entity(e) => {
                let id = self.index.entities.get(&e.name.text).copied();
                self.occurs_if(&e.name, id);
                self.ty(&e.ty);
            }
            Item::Initial(assignment) => self.assignment(assignment),
            Item::Action(action) => {
                let id = self.index.tasks.get(&action.name.text).copied();
                self.head(&action.name, id, &action.params);
                action.clauses.iter().for_each(|c| self.clause(c));
            }
            Item::Method(method) => {
                let id = self.index.tasks.get(&method.name.text).copied();
                self.head(&method.name, id, &method.params);
                method.goals.iter().for_each(|(tests, _)| self.tests(tests));
                method.decompositions.iter().for_each(|d| self.decomposition(d));
            }
            Item::Function(f) => {
                self.ty(&f.result);
                let id = self.index.functions.get(&f.name.text).copied();
                self.head(&f.name, id, &f.params);
                f.body.iter().for_each(|body| self.expr(body));
            }
            Item::Fact(f) => {
                let id = self.index.facts.get(&f.name.text).copied();
                self.head(&f.name, id, &f.params);
                f.body.iter().for_each(|body| self.tests(body));
            }
            Item::Request(r) => {
                self.ty(&r.result);
                let id = self.index.requests.get(&r.name.text).copied();
                self.head(&r.name, id, &r.params);
            }
            Item::Geometric(g) => {
                let id = self.index.geometrics.get(&g.name.text).copied();
                self.head(&g.name, id, &g.params);
                g.body.iter().flatten().for_each(|part| self.geometric_part(part));
            }
            Item::Social(social) => {
                for rule in &social.rules {
                    self.rule(rule);
                    self.scope.clear();
                }
            }
            Item::Settings(_) | Item::TimePart(_) | Item::Import(_) => {}
        }
    }

    fn attributes(&mut self, block: &Attributes) {
        self.ty(&block.owner);
        let owner = self.index.type_named(&block.owner.text);
        for attribute in &block.attributes {
            self.ty(&attribute.base);
            let key = owner.map(|o| (o, attribute.name.text.clone()));
            let id = key.and_then(|key| self.index.attributes.get(&key).copied());
            self.occurs_if(&attribute.name, id);
            if let Some(fact) = &attribute.fact {
                let id = self.index.facts.get(&fact.text).copied();
                self.occurs_if(fact, id);
            }
        }
    }

    fn rule(&mut self, rule: &Rule) {
        if let Some(name) = &rule.name {
            self.head(name, None, &rule.params);
        }
        match &rule.kind {
            RuleKind::State(tests) => self.tests(tests),
            RuleKind::Sequence(patterns) => {
                for Pattern { call, .. } in patterns {
                    let id = self.index.tasks.get(&call.name.text).copied();
                    self.occurs_if(&call.name, id);
                    call.args.iter().for_each(|a| self.expr(a));
                }
            }
            RuleKind::EffortBalance(_) | RuleKind::WastedTime | RuleKind::IntricateLinks => {}
        }
        for name in &rule.among {
            let entity = self.index.entities.get(&name.text).copied();
            match entity {
                Some(entity) => self.occurs(name, entity),
                None => self.ty(name),
            }
        }
    }

    /// Enters the parameters of a declaration.
    fn head(&mut self, name: &Name, id: Option<SymbolId>, params: &[Param]) {
        self.occurs_if(name, id);
        for param in params {
            self.ty(&param.ty);
            let value = self.index.value_of(&param.ty.text, param.is_set);
            let symbol = self.variable(Kind::Parameter, &param.name, param.span, param_text(param), value);
            self.index.symbols[symbol.0].owner = id;
            self.scope.push(symbol);
        }
    }

    /// Adds a variable and its declaration; it lives from when it is put into the scope.
    fn variable(&mut self, kind: Kind, name: &Name, whole: Span, head: String, value: Value) -> SymbolId {
        let symbol = self.index.declared(kind, name, whole, head);
        self.index.symbols[symbol.0].value = value;
        self.occurs(name, symbol);
        symbol
    }

    /// A choice lives from its line on.
    fn geometric_part(&mut self, part: &GeometricPart) {
        match part {
            GeometricPart::Choices(choices) => {
                for choice in choices {
                    self.args(&choice.from);
                    let head = format!("{} in {}", choice.name.text, choice.from.name.text);
                    let id = self.variable(Kind::Variable, &choice.name, choice.span, head, Value::Unknown);
                    self.scope.push(id);
                }
            }
            GeometricPart::SubAction(sub_action) => {
                sub_action.when.iter().for_each(|call| self.args(call));
                self.args(&sub_action.moving);
                if let Some(name) = &sub_action.carrying {
                    let root = self.root(name);
                    self.occurs(name, root);
                }
                sub_action.until.iter().for_each(|call| self.args(call));
                sub_action.change.iter().for_each(|call| self.args(call));
            }
            GeometricPart::InTheEnd(facts) => facts.iter().for_each(|call| self.args(call)),
            GeometricPart::Call(call) => self.geometric_call(call),
        }
    }

    /// Arguments of a fact, or of a word that only geometric actions have.
    fn args(&mut self, call: &Call) {
        let maps = [&self.index.facts, &self.index.requests];
        let id = maps.iter().find_map(|m| m.get(&call.name.text).copied());
        self.occurs_if(&call.name, id);
        call.args.iter().for_each(|a| {
            self.expr(a);
        });
    }

    fn geometric_call(&mut self, GeometricCall { call, given }: &GeometricCall) {
        let id = self.index.geometrics.get(&call.name.text).copied();
        self.occurs_if(&call.name, id);
        let values = call.args.iter().chain(given.iter().map(|b| &b.value));
        values.for_each(|a| {
            self.expr(a);
        });
    }

    fn clause(&mut self, clause: &Clause) {
        match clause {
            Clause::Preconditions(tests, _) | Clause::Constraints(tests, _) => self.tests(tests),
            Clause::Projects(call, _) => self.geometric_call(call),
            Clause::Effects(effects, _) => effects.iter().for_each(|e| self.effect(e)),
            Clause::Alternatives(expr, _) | Clause::Cost(expr, _) | Clause::Duration(expr, _) => self.expr(expr),
        }
    }

    fn decomposition(&mut self, decomposition: &Decomposition) {
        let n_before = self.scope.len();
        let mut labels: IndexMap<&str, SymbolId> = IndexMap::new();
        for step in &decomposition.steps {
            match step {
                Step::Select(s) => {
                    let value = self.index.value_of(&s.ty.text, false);
                    let head = format!("{} {}", s.ty.text, s.name.text);
                    let id = self.variable(Kind::Variable, &s.name, s.span, head, value);
                    self.later.push(id);
                }
                Step::Let(l) => {
                    let id = self.variable(
                        Kind::Variable,
                        &l.name,
                        l.span,
                        format!("let {}", l.name.text),
                        Value::Unknown,
                    );
                    self.later.push(id);
                }
                Step::Subtask(s) => {
                    let Some(label) = &s.label else { continue };
                    if let Some(first) = labels.get(label.text.as_str()) {
                        self.occurs(label, *first);
                        continue;
                    }
                    let head = format!("{}: {}", label.text, s.call.name.text);
                    let id = self.variable(Kind::Label, label, s.span, head, Value::Unknown);
                    labels.insert(&label.text, id);
                }
            }
        }
        self.tests(&decomposition.preconditions);
        for step in &decomposition.steps {
            match step {
                Step::Select(s) => {
                    self.ty(&s.ty);
                    self.bind(&s.name);
                    self.tests(&s.filter);
                    s.key.iter().for_each(|(key, _)| self.expr(key));
                }
                Step::Let(l) => {
                    let value = self.value(&l.value);
                    if let Some(id) = self.bind(&l.name) {
                        let words = self.index.words(value);
                        let symbol = &mut self.index.symbols[id.0];
                        symbol.value = value;
                        symbol.head = format!("{words} {}", l.name.text);
                    }
                }
                Step::Subtask(s) => {
                    let id = self.index.tasks.get(&s.call.name.text).copied();
                    self.occurs_if(&s.call.name, id);
                    s.call.args.iter().for_each(|a| self.expr(a));
                    for after in &s.after {
                        self.occurs_if(after, labels.get(after.text.as_str()).copied());
                    }
                }
            }
        }
        self.scope.truncate(n_before);
        self.later.clear();
    }

    /// Moves the variable that is declared at `name` into the scope.
    fn bind(&mut self, name: &Name) -> Option<SymbolId> {
        let is_it = |id: &SymbolId| self.index.get(*id).declared.is_some_and(|d| d.name == name.span);
        let at = self.later.iter().position(is_it)?;
        let id = self.later.remove(at);
        self.scope.push(id);
        Some(id)
    }

    fn quantified(&mut self, ty: &Name, var: &Name, whole: Span, inside: impl FnOnce(&mut Self)) {
        self.ty(ty);
        let value = self.index.value_of(&ty.text, false);
        let head = format!("{} {}", ty.text, var.text);
        let id = self.variable(Kind::Variable, var, whole, head, value);
        self.scope.push(id);
        inside(self);
        self.scope.pop();
    }

    fn tests(&mut self, tests: &[Test]) {
        tests.iter().for_each(|t| self.test(t));
    }

    fn test(&mut self, test: &Test) {
        match &test.kind {
            TestKind::Or(blocks) => blocks.iter().for_each(|b| self.tests(b)),
            TestKind::Not(tests) => self.tests(tests),
            TestKind::Forall { ty, var, guard, body } | TestKind::Exist { ty, var, guard, body } => {
                self.quantified(ty, var, test.span, |walk| {
                    walk.tests(guard);
                    walk.tests(body);
                });
            }
            TestKind::Compare { left, right, .. } => {
                self.expr(left);
                self.expr(right);
            }
            TestKind::Holds(expr) => self.expr(expr),
            TestKind::Believes(agent, test) => {
                self.path(agent);
                self.tests(std::slice::from_ref(test));
            }
        }
    }

    fn effect(&mut self, effect: &Effect) {
        match effect {
            Effect::Assign(assignment) => self.assignment(assignment),
            Effect::Forall {
                ty,
                var,
                guard,
                effects,
                span,
            } => self.quantified(ty, var, *span, |walk| {
                walk.tests(guard);
                effects.iter().for_each(|e| walk.effect(e));
            }),
            Effect::If {
                test, then, otherwise, ..
            } => {
                self.tests(test);
                then.iter().chain(otherwise).for_each(|e| self.effect(e));
            }
        }
    }

    fn assignment(&mut self, assignment: &Assignment) {
        if let Some(believer) = &assignment.believer {
            self.path(believer);
        }
        self.path(&assignment.target);
        let last = assignment.target.steps.last().map(|s| s.name.span);
        if let Some(written) = self.index.occurrences.last_mut().filter(|o| Some(o.span) == last) {
            written.is_write = true;
        }
        self.expr(&assignment.value);
    }

    fn expr(&mut self, expr: &Expr) {
        self.value(expr);
    }

    /// Walks an expression and returns what it holds, as far as that is needed for paths.
    fn value(&mut self, expr: &Expr) -> Value {
        match &expr.kind {
            ExprKind::Number(_) => Value::Number,
            ExprKind::String(_) => Value::String,
            ExprKind::Bool(_) => Value::Bool,
            ExprKind::Null => Value::Unknown,
            ExprKind::Path(path) => self.path(path),
            ExprKind::Call(call) => self.call(call),
            ExprKind::List(elements) => {
                let values: Vec<Value> = elements.iter().map(|e| self.value(e)).collect();
                match values.first() {
                    Some(Value::Entity(ty)) => Value::Set(Some(*ty)),
                    _ => Value::Set(None),
                }
            }
            ExprKind::Pair(least, most) => {
                self.expr(least);
                self.expr(most);
                Value::Duration
            }
            ExprKind::Negate(inner) => {
                self.expr(inner);
                Value::Number
            }
            ExprKind::Arithmetic { left, right, .. } => {
                let value = self.value(left);
                self.expr(right);
                // `Os - O` is a set, everything else a number.
                if matches!(value, Value::Set(_)) {
                    value
                } else {
                    Value::Number
                }
            }
        }
    }

    fn call(&mut self, call: &Call) -> Value {
        call.args.iter().for_each(|a| self.expr(a));
        let name = call.name.text.as_str();
        let index = &self.index;
        let maps = [
            &index.functions,
            &index.requests,
            &index.facts,
            &index.geometrics,
            &index.tasks,
        ];
        let Some(id) = maps.iter().find_map(|m| m.get(name).copied()) else {
            return Value::Unknown;
        };
        self.occurs(&call.name, id);
        self.index.get(id).value
    }

    fn path(&mut self, path: &Path) -> Value {
        let root = self.root(&path.root);
        self.occurs(&path.root, root);
        let mut value = self.index.get(root).value;
        for step in &path.steps {
            step.args.iter().for_each(|a| self.expr(a));
            let step = &step.name;
            let found = match value {
                Value::Entity(ty) => self.index.attribute_of(ty, &step.text),
                // Of an entity of the world the type is not known here; most names leave no choice.
                Value::Unknown => self.index.only_attribute(&step.text),
                _ => None,
            };
            match found {
                Some(id) => {
                    self.occurs(step, id);
                    value = self.index.get(id).value;
                }
                None => {
                    self.index.unresolved_steps.push(step.clone());
                    value = Value::Unknown;
                }
            }
        }
        value
    }

    /// Returns the variable or entity; one that nobody declares here is taken for an entity of another file.
    fn root(&mut self, name: &Name) -> SymbolId {
        let is_it = |id: &&SymbolId| self.index.get(**id).name == name.text;
        let variable = self.scope.iter().rev().find(is_it);
        if let Some(id) = variable.or_else(|| self.later.iter().find(is_it)) {
            return *id;
        }
        if let Some(id) = self.index.entities.get(&name.text) {
            return *id;
        }
        let id = self.index.add(Symbol {
            kind: Kind::Entity,
            name: name.text.clone(),
            declared: None,
            head: name.text.clone(),
            value: Value::Unknown,
            params: Vec::new(),
            owner: None,
        });
        self.index.entities.insert(name.text.clone(), id);
        id
    }
}
