//! Words of sub-actions with their arguments, as the tables of `words` have them.

use super::*;

impl<'c> Compiler<'c> {
    /// Returns the word that is called, of those in `table`, and its arguments; or says what is wrong with it.
    pub(super) fn call(
        &mut self,
        table: &'static [Word],
        what: &str,
        call: &ast::Call,
    ) -> Option<(&'static Word, Vec<Argument>)> {
        let name = &call.name.text;
        let named: Vec<&'static Word> = table.iter().filter(|w| w.name == name).collect();
        if named.is_empty() {
            let known: BTreeSet<&str> = table.iter().map(|w| w.name).collect();
            let mut problem = problems::unknown("hatp::unknown-geometric-word", what, name, call.name.span, known);
            if let Some(other) = words::place_of(name).filter(|other| *other != what) {
                problem = problem.help(format!("`{name}` is a {other}"));
            }
            self.problems.push(problem);
            self.is_whole = false;
            return None;
        }
        // Words of two meanings differ in their first argument.
        let first = call.args.first().and_then(|a| self.kind_of(a));
        let word = named
            .iter()
            .find(|w| first.is_some_and(|f| w.args.first().is_some_and(|a| f.fits(*a))))
            .or(named.first())?;
        if call.args.len() < word.n_required || call.args.len() > word.args.len() {
            let wanted: Vec<String> = word.args.iter().map(|a| a.example().to_owned()).collect();
            self.problems.push(problems::wrong_words_count(
                what,
                &call.name,
                &wanted,
                word.n_required,
                call.args.len(),
            ));
            self.is_whole = false;
            return None;
        }
        let mut args = Vec::new();
        for (arg, wanted) in call.args.iter().zip(word.args) {
            args.push(self.argument(arg, *wanted));
        }
        let args: Option<Vec<Argument>> = args.into_iter().collect();
        self.is_whole &= args.is_some();
        args.map(|args| (*word, args))
    }

    /// Returns what kind of thing an argument is, without saying anything.
    pub(super) fn kind_of(&self, arg: &ast::Expr) -> Option<Thing> {
        match &arg.kind {
            ExprKind::Number(_) => Some(Thing::Length),
            ExprKind::Path(path) if path.steps.is_empty() => self.named(&path.root.text).map(|(_, thing)| thing),
            _ => None,
        }
    }

    pub(super) fn named(&self, name: &str) -> Option<(Argument, Thing)> {
        if let Some(i) = self.chosen.iter().position(|c| c.is_some_and(|c| c.text == name)) {
            let from = self.out.choices.get(i)?.from;
            return Some((Argument::Choice(ChoiceId(i as u32)), Thing::chosen(from)));
        }
        let i = self.out.params.iter().position(|p| p.name == name)?;
        let thing = match self.out.params.get(i)?.role {
            Role::Agent => Thing::Agent,
            Role::Thing => Thing::Object,
            Role::Entity => Thing::Entity,
        };
        Some((Argument::Param(ParamId(i as u32)), thing))
    }

    pub(super) fn listed(&self) -> Vec<String> {
        let params = self.out.params.iter().map(|p| p.name.clone());
        params
            .chain(self.chosen.iter().flatten().map(|c| c.text.clone()))
            .collect()
    }

    pub(super) fn argument(&mut self, arg: &ast::Expr, wanted: Thing) -> Option<Argument> {
        let found = match &arg.kind {
            ExprKind::Number(x) => Some((Argument::Number(*x), Thing::Length)),
            ExprKind::Path(path) if path.steps.is_empty() => {
                let found = self.named(&path.root.text);
                if found.is_none() {
                    self.problems
                        .push(problems::unknown_in_geometric(&path.root, self.listed()));
                    return None;
                }
                found
            }
            _ => None,
        };
        let Some((argument, thing)) = found else {
            let found = "an expression";
            let problem = problems::wrong_type(arg.span, wanted.words(), found);
            self.problems
                .push(problem.help("write a parameter, a choice or a number of metres"));
            return None;
        };
        if let Argument::Choice(choice) = argument {
            self.used.insert(choice);
            if !self.is_whole && thing == Thing::Angle {
                // A choice from something unknown may be of any kind.
                return Some(argument);
            }
        }
        if !thing.fits(wanted) {
            let problem = problems::wrong_type(arg.span, wanted.words(), thing.words());
            let help = (thing == Thing::Entity && wanted == Thing::Agent)
                .then(|| "declare the parameter as an `Agent`".to_owned());
            self.problems.push(problem.maybe_help(help));
            return None;
        }
        if let (Argument::Param(param), Thing::Object | Thing::Agent) = (argument, wanted)
            && let Some(param) = self.out.params.get_mut(param.index())
            && param.role == Role::Entity
        {
            // From now on it is known what it has to be.
            param.role = Role::Thing;
        }
        if let Argument::Number(x) = argument
            && !(x.is_finite() && (0.0..=10.0).contains(&x))
        {
            self.problems.push(problems::bad_sub_action(
                format!("{x} m is no distance of an approach"),
                arg.span,
                "from 0 to 10 m",
                "distances are in metres",
            ));
            return None;
        }
        Some(argument)
    }

    // ---- Other actions ----
}
