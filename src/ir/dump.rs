//! A compiled domain as text, for the tests' snapshots: every table, with names for ids and `$i` for `Var(i)`.

use std::fmt::Write as _;

use super::*;

/// Returns the domain as text; the same domain gives the same bytes.
pub fn dump(domain: &Domain) -> String {
    let mut out = String::new();
    let dump = Dump { domain };
    for ty in &domain.types {
        let parent = ty.parent.map_or(String::new(), |p| format!(" : {}", dump.ty(p)));
        let entities: Vec<&str> = ty.entities.iter().map(|e| dump.entity(*e)).collect();
        line(
            &mut out,
            0,
            &format!("type {}{parent} [{}]", ty.name, entities.join(", ")),
        );
    }
    for a in &domain.attributes {
        let change = if a.is_static { "static" } else { "dynamic" };
        let fact = a.fact.as_ref().map_or(String::new(), |f| format!(" = fact {f}"));
        let per_agent = if a.believer.is_some() { " per agent" } else { "" };
        let types: Vec<&str> = a.arguments.iter().map(|a| dump.ty(a.ty)).collect();
        let arguments = if types.is_empty() {
            String::new()
        } else {
            format!("({})", types.join(", "))
        };
        let text = format!(
            "{change} {}{} {}.{}{arguments}{per_agent}{fact}",
            set_word(a.is_set),
            dump.base(a.base),
            dump.ty(a.owner),
            a.name
        );
        line(&mut out, 0, &text);
    }
    for (i, value) in domain.initial.iter().enumerate() {
        let name = domain.slot_name(SlotId(i as u32));
        line(&mut out, 0, &format!("{name} = {}", domain.show(value)));
    }
    if domain.settings.interleave {
        line(&mut out, 0, "interleave");
    }
    if domain.settings.cost != CostFormula::default() {
        let CostFormula { sum, makespan } = domain.settings.cost;
        line(&mut out, 0, &format!("cost {sum} * sum + {makespan} * makespan"));
    }
    domain.social.iter().for_each(|rule| dump.rule(&mut out, rule));
    for fact in &domain.facts {
        let head = format!("fact {}({}) vars {}", fact.name, fact.params.join(", "), fact.n_vars);
        line(&mut out, 0, &format!("{head} if {}", dump.test(&fact.body)));
    }
    if let Some(observes) = domain.beliefs.as_ref().and_then(|b| b.observes.as_ref()) {
        let of = observes.ty.map_or("any", |ty| dump.ty(ty));
        let head = format!(
            "observes({}) of {of} vars {}",
            observes.params.join(", "),
            observes.n_vars
        );
        line(&mut out, 0, &format!("{head} if {}", dump.test(&observes.body)));
    }
    domain.actions.iter().for_each(|a| dump.action(&mut out, a));
    domain.methods.iter().for_each(|m| dump.method(&mut out, m));
    out
}

fn line(out: &mut String, depth: usize, text: &str) {
    // Writing to a String can't fail.
    let _ = writeln!(out, "{:indent$}{text}", "", indent = depth * 2);
}

fn set_word(is_set: bool) -> &'static str {
    if is_set { "set " } else { "" }
}

struct Dump<'a> {
    domain: &'a Domain,
}

impl Dump<'_> {
    fn ty(&self, id: TypeId) -> &str {
        &self.domain.types[id.index()].name
    }

    fn entity(&self, id: EntityId) -> &str {
        &self.domain.entities[id.index()].name
    }

    fn base(&self, base: Base) -> String {
        match base {
            Base::Number => "number".into(),
            Base::Bool => "bool".into(),
            Base::String => "string".into(),
            Base::Entity(t) => self.ty(t).into(),
        }
    }

    fn given(&self, projects: &Projection) -> String {
        let n_params = projects.args.len() - projects.given.len();
        let values = projects.args.iter().skip(n_params);
        let action = self.domain.geometric(&projects.name);
        let name = |choice: ChoiceId| action.map_or("?", |a| a.choices[choice.index()].name.as_str());
        let given = projects.given.iter().zip(values);
        let given: Vec<String> = given
            .map(|(choice, value)| format!("{} = {}", name(*choice), self.exprs(std::slice::from_ref(value))))
            .collect();
        match given.is_empty() {
            true => String::new(),
            false => format!(" with {}", given.join(", ")),
        }
    }

    fn params(&self, params: &[Param]) -> String {
        let param = |p: &Param| format!("{}{} {}", set_word(p.is_set), self.base(p.base), p.name);
        params.iter().map(param).collect::<Vec<_>>().join(", ")
    }

    fn rule(&self, out: &mut String, rule: &SocialRule) {
        let names = |agents: &[EntityId]| agents.iter().map(|a| self.entity(*a)).collect::<Vec<_>>().join(", ");
        let tail = match &rule.kind {
            RuleKind::State { params, n_vars, test } => {
                let params: Vec<&str> = params.iter().map(|ty| self.ty(*ty)).collect();
                format!("({}) vars {n_vars} if {}", params.join(", "), self.test(test))
            }
            RuleKind::Sequence { vars, .. } => format!("({})", self.params(vars)),
            RuleKind::EffortBalance { effort, agents } => format!(" of {effort:?} among {}", names(agents)),
            RuleKind::WastedTime { agents } | RuleKind::IntricateLinks { agents } => {
                format!(" among {}", names(agents))
            }
        };
        let head = format!("{} `{}` weight {}", rule.kind.word(), rule.name, rule.weight);
        line(out, 0, &format!("{head}{tail}"));
        if let RuleKind::Sequence { patterns, .. } = &rule.kind {
            for pattern in patterns {
                let arg = |arg: &PatternArg| match arg {
                    PatternArg::Any => "_".to_owned(),
                    PatternArg::Var(var) => format!("${var}"),
                    PatternArg::Is(value) => self.domain.show(value),
                };
                let args: Vec<String> = pattern.args.iter().map(arg).collect();
                let name = &self.domain.actions[pattern.action.index()].name;
                let mark = if pattern.is_immediate { " immediate" } else { "" };
                line(out, 1, &format!("{name}({}){mark}", args.join(", ")));
            }
        }
    }

    fn action(&self, out: &mut String, action: &Action) {
        let head = format!(
            "action {}({}) vars {} agents {:?}",
            action.name,
            self.params(&action.params),
            action.n_vars,
            action.agents
        );
        line(out, 0, &head);
        line(out, 1, &format!("if {}", self.test(&action.preconditions)));
        if let Some(projects) = &action.projects {
            let args = projects.args.get(..projects.args.len() - projects.given.len());
            let args = args.unwrap_or_default();
            line(
                out,
                1,
                &format!(
                    "projects {}({}){}",
                    projects.name,
                    self.exprs(args),
                    self.given(projects)
                ),
            );
        }
        if !matches!(&action.constraints, Test::And(parts) if parts.is_empty()) {
            line(out, 1, &format!("then {}", self.test(&action.constraints)));
        }
        if let Some(alternatives) = action.alternatives {
            line(out, 1, &format!("alternatives {alternatives}"));
        }
        action.effects.iter().for_each(|e| self.effect(out, 1, e));
        line(out, 1, &format!("cost {}", self.expr(&action.cost)));
        let (least, most) = &action.duration;
        line(out, 1, &format!("duration ({}, {})", self.expr(least), self.expr(most)));
    }

    fn method(&self, out: &mut String, method: &Method) {
        line(
            out,
            0,
            &format!(
                "method {}({}) vars {}",
                method.name,
                self.params(&method.params),
                method.n_vars
            ),
        );
        if let Some(goal) = &method.goal {
            line(out, 1, &format!("goal {}", self.test(goal)));
        }
        for decomposition in &method.decompositions {
            line(out, 1, &format!("if {}", self.test(&decomposition.preconditions)));
            for binder in &decomposition.binders {
                line(out, 2, &self.binder(binder));
            }
            for (i, subtask) in decomposition.subtasks.iter().enumerate() {
                let name = self.domain.task_name(subtask.task);
                let after = if subtask.after.is_empty() {
                    String::new()
                } else {
                    format!(" after {:?}", subtask.after)
                };
                line(out, 2, &format!("{i}: {name}({}){after}", self.exprs(&subtask.args)));
            }
        }
    }

    fn binder(&self, binder: &Binder) -> String {
        match binder {
            Binder::Let { var, var_name, value } => format!("${} {var_name} = {}", var.0, self.expr(value)),
            Binder::Select {
                var,
                var_name,
                ty,
                filter,
                order,
            } => {
                let order = match order {
                    SelectOrder::Declared => String::new(),
                    SelectOrder::Once => " once".into(),
                    SelectOrder::Sorted { key, descending } => {
                        format!(" by {} {}", self.expr(key), if *descending { ">" } else { "<" })
                    }
                };
                format!(
                    "${} {var_name} in {} if {}{order}",
                    var.0,
                    self.ty(*ty),
                    self.test(filter)
                )
            }
        }
    }

    fn effect(&self, out: &mut String, depth: usize, effect: &Effect) {
        let target = |entity: &Expr, attribute: &AttributeId, args: &[Expr]| {
            self.expr(&Expr::Attribute {
                base: Box::new(entity.clone()),
                attribute: *attribute,
                args: args.into(),
            })
        };
        match effect {
            Effect::Assign {
                entity,
                attribute,
                args,
                value,
            } => line(
                out,
                depth,
                &format!("{} = {}", target(entity, attribute, args), self.expr(value)),
            ),
            Effect::Add {
                entity,
                attribute,
                args,
                element,
            } => line(
                out,
                depth,
                &format!("{} <<= {}", target(entity, attribute, args), self.expr(element)),
            ),
            Effect::Remove {
                entity,
                attribute,
                args,
                element,
            } => line(
                out,
                depth,
                &format!("{} =>> {}", target(entity, attribute, args), self.expr(element)),
            ),
            Effect::Forall {
                var,
                ty,
                guard,
                effects,
            } => {
                line(
                    out,
                    depth,
                    &format!("for all ${} in {} if {}", var.0, self.ty(*ty), self.test(guard)),
                );
                effects.iter().for_each(|e| self.effect(out, depth + 1, e));
            }
            Effect::If { test, then, otherwise } => {
                line(out, depth, &format!("when {}", self.test(test)));
                then.iter().for_each(|e| self.effect(out, depth + 1, e));
                if !otherwise.is_empty() {
                    line(out, depth, "else");
                    otherwise.iter().for_each(|e| self.effect(out, depth + 1, e));
                }
            }
        }
    }

    fn test(&self, test: &Test) -> String {
        let joined = |tests: &[Test], word: &str| {
            let all: Vec<String> = tests.iter().map(|t| self.test(t)).collect();
            format!("({})", all.join(word))
        };
        match test {
            Test::And(tests) if tests.is_empty() => "true".into(),
            Test::And(tests) => joined(tests, " and "),
            Test::Or(tests) => joined(tests, " or "),
            Test::Not(inner) => format!("not {}", self.test(inner)),
            Test::Compare { op, left, right } => {
                format!("{} {} {}", self.expr(left), op.symbol(), self.expr(right))
            }
            Test::Member { element, set } => format!("{} >> {}", self.expr(element), self.expr(set)),
            Test::Forall { var, ty, guard, body } => {
                let (guard, body) = (self.test(guard), self.test(body));
                format!("(all ${} in {} if {guard}: {body})", var.0, self.ty(*ty))
            }
            Test::Exist { var, ty, guard, body } => {
                let (guard, body) = (self.test(guard), self.test(body));
                format!("(some ${} in {} if {guard}: {body})", var.0, self.ty(*ty))
            }
            Test::Holds(expr) => self.expr(expr),
        }
    }

    fn exprs(&self, exprs: &[Expr]) -> String {
        exprs.iter().map(|e| self.expr(e)).collect::<Vec<_>>().join(", ")
    }

    fn expr(&self, expr: &Expr) -> String {
        show_expr(self.domain, expr, &|var| format!("${}", var.0))
    }
}
