//! AST back to text, in one layout: what `parse` reads from it is the same again, apart from places.
//!
//! Comments, `factdatabase`'s place among the items and optional marks are not kept; old words come out new
//! (`operator` as `action`).

use super::ast::*;

/// Returns the file as text. Items that only a prelude has (`fact`, `geometric`) keep their form.
pub fn print(file: &File) -> String {
    let mut p = Printer {
        out: String::new(),
        depth: 0,
    };
    for item in &file.items {
        p.item(item);
    }
    p.out
}

struct Printer {
    out: String,
    depth: usize,
}

impl Printer {
    fn line(&mut self, text: &str) {
        for _ in 0..self.depth {
            self.out.push_str("  ");
        }
        self.out.push_str(text);
        self.out.push('\n');
    }

    /// Writes `head {`, what `inside` writes, and `}`.
    fn block(&mut self, head: &str, inside: impl FnOnce(&mut Self)) {
        self.line(&format!("{head}{{"));
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.line("}");
    }

    fn item(&mut self, item: &Item) {
        match item {
            Item::EntityType(t) => {
                let parent = t.parent.as_ref().map_or(String::new(), |p| format!(" : {}", p.text));
                self.block("factdatabase ", |p| {
                    p.line(&format!("define entityType {}{parent};", t.name.text))
                });
            }
            Item::Attributes(block) => self.block("factdatabase ", |p| {
                p.block(&format!("define entityAttributes {} ", block.owner.text), |p| {
                    for a in &block.attributes {
                        let change = if a.is_static { "static" } else { "dynamic" };
                        let size = if a.is_set { "set" } else { "atom" };
                        let fact = a.fact.as_ref().map_or(String::new(), |f| format!(" = fact {}", f.text));
                        p.line(&format!("{change} {size} {} {}{fact};", a.base.text, a.name.text));
                    }
                });
            }),
            Item::Entity(e) => {
                self.block("factdatabase ", |p| {
                    p.line(&format!("{} = new {};", e.name.text, e.ty.text))
                });
            }
            Item::Initial(a) => self.block("factdatabase ", |p| p.assignment(a)),
            Item::Action(a) => self.block(&format!("action {}{} ", a.name.text, params(&a.params)), |p| {
                a.clauses.iter().for_each(|c| p.clause(c));
            }),
            Item::Method(m) => self.block(&format!("method {}{} ", m.name.text, params(&m.params)), |p| {
                for (tests, _) in &m.goals {
                    p.block("goal ", |p| p.tests(tests));
                }
                m.decompositions.iter().for_each(|d| p.decomposition(d));
            }),
            Item::Function(f) => {
                let head = format!("function {} {}{}", f.result.text, f.name.text, params(&f.params));
                let body = f.body.as_ref().map_or(";".into(), |b| format!(" {{ {} }}", expr(b)));
                self.line(&format!("{head}{body}"));
            }
            Item::Geometric(g) => self.line(&format!("geometric {}{};", g.name.text, params(&g.params))),
            Item::Fact(f) => {
                let head = format!("fact {}{}", f.name.text, params(&f.params));
                match &f.body {
                    Some(tests) => self.block(&format!("{head} "), |p| p.tests(tests)),
                    None => self.line(&format!("{head};")),
                }
            }
            Item::Request(r) => self.line(&format!(
                "request {} {}{};",
                r.result.text,
                r.name.text,
                params(&r.params)
            )),
            Item::Settings(s) => self.block("settings ", |p| {
                for setting in &s.settings {
                    p.line(&format!("{} = {};", setting.name.text, expr(&setting.value)));
                }
            }),
            Item::TimePart(_) => self.line("timePart { }"),
            Item::Import(i) => self.line(&format!("import {:?};", i.path)),
        }
    }

    fn clause(&mut self, clause: &Clause) {
        match clause {
            Clause::Preconditions(tests, _) => self.block("preconditions ", |p| p.tests(tests)),
            Clause::Projects(c, _) => self.line(&format!("projects {{ {} }}", call(c))),
            Clause::Constraints(tests, _) => self.block("constraints ", |p| p.tests(tests)),
            Clause::Alternatives(e, _) => self.line(&format!("alternatives {{ {} }}", expr(e))),
            Clause::Effects(effects, _) => self.block("effects ", |p| p.effects(effects)),
            Clause::Cost(e, _) => self.line(&format!("cost {{ {} }}", expr(e))),
            Clause::Duration(e, _) => self.line(&format!("duration {{ {} }}", expr(e))),
        }
    }

    fn decomposition(&mut self, decomposition: &Decomposition) {
        self.block("", |p| {
            p.block("preconditions ", |p| p.tests(&decomposition.preconditions));
            p.block("subtasks ", |p| decomposition.steps.iter().for_each(|s| p.step(s)));
        });
    }

    fn step(&mut self, step: &Step) {
        match step {
            Step::Select(s) => {
                let word = match s.kind {
                    SelectKind::Select => "SELECT",
                    SelectKind::Ordered => "SELECTORDERED",
                    SelectKind::Once => "SELECTONCE",
                };
                self.line(&format!("{} = {word}({}, {{", s.name.text, s.ty.text));
                self.inner(|p| p.tests(&s.filter));
                let key = s.key.as_ref().map_or(String::new(), |(key, descending)| {
                    format!(", {}, {}", expr(key), if *descending { ">" } else { "<" })
                });
                self.line(&format!("}}{key});"));
            }
            Step::Let(l) => self.line(&format!("let {} = {};", l.name.text, expr(&l.value))),
            Step::Subtask(s) => {
                let label = s.label.as_ref().map_or(String::new(), |l| format!("{}: ", l.text));
                let after: Vec<String> = s.after.iter().map(|l| format!(" > {}", l.text)).collect();
                self.line(&format!("{label}{}{};", call(&s.call), after.join(",")));
            }
        }
    }

    fn inner(&mut self, inside: impl FnOnce(&mut Self)) {
        self.depth += 1;
        inside(self);
        self.depth -= 1;
    }

    fn tests(&mut self, tests: &[Test]) {
        for test in tests {
            match &test.kind {
                TestKind::Or(blocks) => {
                    self.line("OR");
                    blocks.iter().for_each(|b| self.block("", |p| p.tests(b)));
                }
                TestKind::Not(tests) => self.block("NOT ", |p| p.tests(tests)),
                TestKind::Forall { ty, var, guard, body } => {
                    self.quantified("FORALL", ty, var, guard, |p| p.tests(body))
                }
                TestKind::Exist { ty, var, guard, body } => self.quantified("EXIST", ty, var, guard, |p| p.tests(body)),
                TestKind::Compare { op, left, right } => {
                    let op = match op {
                        TestOp::Equal => "==",
                        TestOp::NotEqual => "!=",
                        TestOp::Less => "<",
                        TestOp::LessEqual => "<=",
                        TestOp::Greater => ">",
                        TestOp::GreaterEqual => ">=",
                        TestOp::Member => ">>",
                        TestOp::NotMember => "!>>",
                    };
                    self.line(&format!("{} {op} {};", expr(left), expr(right)));
                }
                TestKind::Holds(e) => self.line(&format!("{};", expr(e))),
            }
        }
    }

    fn quantified(&mut self, word: &str, ty: &Name, var: &Name, guard: &[Test], body: impl FnOnce(&mut Self)) {
        self.line(&format!("{word}({} {}, {{", ty.text, var.text));
        self.inner(|p| p.tests(guard));
        self.line("}, {");
        self.inner(body);
        self.line("});");
    }

    fn effects(&mut self, effects: &[Effect]) {
        for effect in effects {
            match effect {
                Effect::Assign(a) => self.assignment(a),
                Effect::Forall {
                    ty,
                    var,
                    guard,
                    effects,
                    ..
                } => self.quantified("FORALL", ty, var, guard, |p| p.effects(effects)),
                Effect::If {
                    test, then, otherwise, ..
                } => {
                    self.block("IF ", |p| p.tests(test));
                    self.block("", |p| p.effects(then));
                    if !otherwise.is_empty() {
                        self.block("ELSE ", |p| p.effects(otherwise));
                    }
                }
            }
        }
    }

    fn assignment(&mut self, a: &Assignment) {
        let op = match a.op {
            AssignOp::Set => "=",
            AssignOp::Add => "<<=",
            AssignOp::Remove => "=>>",
        };
        self.line(&format!("{} {op} {};", path(&a.target), expr(&a.value)));
    }
}

fn params(params: &[Param]) -> String {
    let param = |p: &Param| format!("{}{} {}", if p.is_set { "set " } else { "" }, p.ty.text, p.name.text);
    format!("({})", params.iter().map(param).collect::<Vec<_>>().join(", "))
}

fn path(path: &Path) -> String {
    let steps = path.steps.iter().map(|s| s.text.as_str());
    std::iter::once(path.root.text.as_str())
        .chain(steps)
        .collect::<Vec<_>>()
        .join(".")
}

fn exprs(list: &[Expr]) -> String {
    list.iter().map(expr).collect::<Vec<_>>().join(", ")
}

fn call(call: &Call) -> String {
    format!("{}({})", call.name.text, exprs(&call.args))
}

/// Returns the expression with every operation in parentheses.
fn expr(e: &Expr) -> String {
    match &e.kind {
        ExprKind::Number(x) => x.to_string(),
        ExprKind::String(s) => {
            let escaped = s
                .replace('\\', "\\\\")
                .replace('"', "\\\"")
                .replace('\n', "\\n")
                .replace('\t', "\\t");
            format!("\"{escaped}\"")
        }
        ExprKind::Bool(b) => b.to_string(),
        ExprKind::Null => "NULL".into(),
        ExprKind::Path(p) => path(p),
        ExprKind::Call(c) => call(c),
        ExprKind::List(elements) => format!("[{}]", exprs(elements)),
        ExprKind::Pair(least, most) => format!("({}, {})", expr(least), expr(most)),
        ExprKind::Negate(inner) => format!("(-{})", expr(inner)),
        ExprKind::Arithmetic { op, left, right } => {
            let op = match op {
                ArithmeticOp::Add => '+',
                ArithmeticOp::Subtract => '-',
                ArithmeticOp::Multiply => '*',
                ArithmeticOp::Divide => '/',
            };
            format!("({} {op} {})", expr(left), expr(right))
        }
    }
}
