//! What one geometric action takes over from another.

use super::*;

impl<'c> Compiler<'c> {
    /// Writes out another action: its choices and sub-actions, with own parameters for its own.
    pub(super) fn taken_over(&mut self, source: &'c ast::GeometricCall) {
        let call = &source.call;
        let Some(other) = self.known.get(call.name.text.as_str()).map(Arc::clone) else {
            self.is_whole = false;
            if !self.names.geometrics.contains_key(&call.name.text) {
                let known = self.names.geometrics.keys().map(String::as_str);
                let problem = problems::unknown(
                    "hatp::unknown-geometric",
                    "geometric action",
                    &call.name.text,
                    call.name.span,
                    known,
                );
                self.problems.push(problem);
            }
            return;
        };
        if other.params.len() != call.args.len() {
            let wanted: Vec<String> = other.params.iter().map(|p| p.name.clone()).collect();
            let declared = self.names.geometrics.get(&call.name.text).map_or(call.span, |s| s.span);
            let problem = problems::wrong_count("geometric action", &call.name, &wanted, call.args.len(), declared);
            self.problems.push(problem);
            self.is_whole = false;
            return;
        }
        let mut params = Vec::new();
        for (arg, param) in call.args.iter().zip(&other.params) {
            let wanted = match param.role {
                Role::Agent => Thing::Agent,
                Role::Thing => Thing::Object,
                Role::Entity => Thing::Entity,
            };
            match self.argument(arg, wanted) {
                Some(Argument::Param(p)) => params.push(p),
                _ => self.is_whole = false,
            }
        }
        let given = self.given(source, &other);
        if !self.is_whole {
            return;
        }
        let mut choices: Vec<ChoiceId> = Vec::new();
        for (i, choice) in other.choices.iter().enumerate() {
            if let Some((_, own)) = given.iter().find(|(theirs, _)| theirs.index() == i) {
                choices.push(*own);
                continue;
            }
            let id = ChoiceId(self.out.choices.len() as u32);
            let from = choice.from.renamed(&params, &choices);
            self.out.choices.push(Choice {
                name: choice.name.clone(),
                from,
            });
            self.chosen.push(None);
            choices.push(id);
        }
        for sub_action in &other.sub_actions {
            self.add(sub_action.renamed(&params, &choices), call.span);
        }
    }

    /// Returns which choices of another action are made by choices of this one.
    pub(super) fn given(&mut self, source: &ast::GeometricCall, other: &Geometric) -> Vec<(ChoiceId, ChoiceId)> {
        let mut out = Vec::new();
        for binding in &source.given {
            let Some(theirs) = other.choices.iter().position(|c| c.name == binding.name.text) else {
                let known = other.choices.iter().map(|c| c.name.as_str());
                let name = &binding.name;
                self.problems.push(problems::unknown(
                    "hatp::unknown-choice",
                    "choice",
                    &name.text,
                    name.span,
                    known,
                ));
                self.is_whole = false;
                continue;
            };
            let wanted = Thing::chosen(other.choices[theirs].from);
            match self.argument(&binding.value, wanted) {
                Some(Argument::Choice(own)) => out.push((ChoiceId(theirs as u32), own)),
                _ => self.is_whole = false,
            }
        }
        out
    }
}
