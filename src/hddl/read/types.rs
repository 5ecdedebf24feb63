//! Types, objects, predicates, functions, and lists of typed variables.

use super::super::ast::{Kinds, Name, OBJECT, Object, Relation, Scope, Type, VarId, Variable};
use super::super::problems;
use super::super::tree::Tree;
use super::{Reader, key, name_of};

/// HATP has 32 supertypes above one another at most, and `object` is one.
const MAX_SUPERTYPES: usize = 30;

/// A name of a typed list, and what stands behind its `-`.
type Typed<'a, 't> = (&'a Tree<'t>, Option<&'a Tree<'t>>);

impl Reader<'_> {
    /// Splits `a b - t c`.
    fn typed<'a, 't>(&mut self, parts: &'a [Tree<'t>]) -> Vec<Typed<'a, 't>> {
        let mut found: Vec<Typed<'a, 't>> = Vec::new();
        let mut n_typed = 0;
        let mut rest = parts;
        while let Some((part, more)) = rest.split_first() {
            rest = more;
            match part.word() {
                Some("-") => match more.split_first() {
                    Some((ty, more)) => {
                        rest = more;
                        if n_typed == found.len() {
                            self.problems
                                .push(problems::expected("a name before the `-`", part.span));
                        }
                        found[n_typed..].iter_mut().for_each(|(_, t)| *t = Some(ty));
                        n_typed = found.len();
                    }
                    None => self
                        .problems
                        .push(problems::expected("a type behind the `-`", part.span)),
                },
                Some(word) if word.starts_with('-') => self.problems.push(problems::glued(word, part.span)),
                Some(_) => found.push((part, None)),
                None => self.problems.push(problems::expected("a name", part.span)),
            }
        }
        found
    }

    pub(super) fn read_types(&mut self, parts: &[Tree<'_>]) {
        let typed = self.typed(parts);
        let mut parents = Vec::new();
        for (name, parent) in &typed {
            let name = name_of(name);
            if key(&name.text) == "object" {
                continue;
            }
            match self.types.get(&key(&name.text)) {
                Some(first) => {
                    let first = self.pair.types[*first].name.span;
                    self.problems
                        .push(problems::duplicate("type", &name.text, name.span, first));
                }
                None => {
                    parents.push((self.pair.types.len(), *parent));
                    self.add_type(name);
                }
            }
        }
        for (ty, parent) in parents {
            let Some(parent) = parent else { continue };
            match parent.word() {
                // Some domains name a supertype only here.
                Some(word) if !self.types.contains_key(&key(word)) => {
                    self.pair.types[ty].parent = Some(self.pair.types.len());
                    self.add_type(name_of(parent));
                }
                Some(_) => self.pair.types[ty].parent = self.type_called(parent),
                None => {
                    let help = "give it one supertype, and let the others be predicates";
                    let problem = problems::not_supported("a type with several supertypes is", parent.span, help);
                    self.problems.push(problem);
                }
            }
        }
        self.cut_circles();
    }

    /// Adds a type below `object`.
    fn add_type(&mut self, name: Name) {
        self.types.insert(key(&name.text), self.pair.types.len());
        self.pair.types.push(Type {
            name,
            parent: Some(OBJECT),
        });
    }

    /// Says which types are above themselves, and puts them below `object`.
    fn cut_circles(&mut self) {
        for ty in 1..self.pair.types.len() {
            let n = self.pair.types.len();
            let above: Vec<usize> = self.pair.lineage(ty).skip(1).take(n).collect();
            let span = self.pair.types[ty].name.span;
            if above.contains(&ty) {
                let name = self.pair.types[ty].name.text.clone();
                self.problems.push(problems::type_cycle(&name, span));
                self.pair.types[ty].parent = Some(OBJECT);
            } else if above.len() > MAX_SUPERTYPES && above.len() < n {
                self.problems.push(problems::type_depth(span));
                self.pair.types[ty].parent = Some(OBJECT);
            }
        }
    }

    fn type_called(&mut self, tree: &Tree<'_>) -> Option<usize> {
        let Some(word) = tree.word() else {
            self.problems.push(problems::expected("a type", tree.span));
            return Some(OBJECT);
        };
        let found = self.types.get(&key(word)).copied();
        if found.is_none() {
            let known = self.pair.types.iter().map(|t| t.name.text.as_str());
            self.problems.push(problems::unknown_type(word, tree.span, known));
        }
        Some(found.unwrap_or(OBJECT))
    }

    /// Reads a type, or `(either a b)`.
    pub(super) fn kinds(&mut self, tree: Option<&Tree<'_>>) -> Kinds {
        let Some(tree) = tree else { return Kinds(vec![OBJECT]) };
        let mut found = Vec::new();
        match tree.headed() {
            Some((head, types)) if head.is("either") && !types.is_empty() => {
                for ty in types {
                    found.extend(self.type_called(ty));
                }
            }
            Some((head, _)) => self
                .problems
                .push(problems::expected("a type, or `(either A B)`", head.span)),
            None => found.extend(self.type_called(tree)),
        }
        // A type below another one of the list adds nothing.
        let all = found.clone();
        let mut kept: Vec<usize> = Vec::new();
        for ty in found {
            let is_below = all.iter().any(|other| *other != ty && self.pair.is_subtype(ty, *other));
            if !is_below && !kept.contains(&ty) {
                kept.push(ty);
            }
        }
        if kept.is_empty() {
            kept.push(OBJECT);
        }
        Kinds(kept)
    }

    pub(super) fn read_objects(&mut self, parts: &[Tree<'_>]) {
        for (name, ty) in self.typed(parts) {
            let kinds = self.kinds(ty);
            if let (Some(ty), [_, _, ..]) = (ty, &kinds.0[..]) {
                let help = "give the object one type";
                self.problems
                    .push(problems::not_supported("an object of several types is", ty.span, help));
            }
            let (name, ty) = (name_of(name), kinds.0[0]);
            match self.objects.get(&key(&name.text)).map(|o| &self.pair.objects[*o]) {
                // A problem may repeat a constant of its domain.
                Some(first) if first.ty == ty && first.name.span.file != name.span.file => {}
                Some(first) => {
                    let first = first.name.span;
                    self.problems
                        .push(problems::duplicate("object", &name.text, name.span, first));
                }
                None => {
                    self.objects.insert(key(&name.text), self.pair.objects.len());
                    self.pair.objects.push(Object { name, ty });
                }
            }
        }
    }

    /// Reads `?a - t ?b` behind the variables of a scope and makes their names visible; returns the new ones.
    pub(super) fn variables(
        &mut self,
        parts: &[Tree<'_>],
        scope: &mut Scope,
        visible: &mut Vec<(String, VarId)>,
    ) -> Vec<VarId> {
        let mut new: Vec<VarId> = Vec::new();
        for (name, ty) in self.typed(parts) {
            let kinds = self.kinds(ty);
            let name = name_of(name);
            if !name.text.starts_with('?') {
                self.problems
                    .push(problems::expected("a variable, which begins with `?`", name.span));
                continue;
            }
            let names = new.iter().map(|v| &scope.0[*v].name);
            let first = names.clone().find(|n| key(&n.text) == key(&name.text));
            if let Some(first) = first {
                self.problems
                    .push(problems::duplicate("variable", &name.text, name.span, first.span));
                continue;
            }
            visible.push((key(&name.text), scope.0.len()));
            new.push(scope.0.len());
            scope.0.push(Variable { name, kinds });
        }
        new
    }

    pub(super) fn read_predicates(&mut self, parts: &[Tree<'_>]) {
        for part in parts {
            let Some((name, params)) = part.headed() else {
                self.problems.push(problems::expected(
                    "a predicate such as `(at ?x - thing ?y - place)`",
                    part.span,
                ));
                continue;
            };
            let (name, scope) = self.signature(name, params);
            if let Some(first) = self.predicates.get(&key(&name.text)) {
                let first = self.pair.predicates[*first].name.span;
                self.problems
                    .push(problems::duplicate("predicate", &name.text, name.span, first));
                continue;
            }
            self.predicates.insert(key(&name.text), self.pair.predicates.len());
            self.pair.predicates.push(relation(name, scope));
        }
    }

    pub(super) fn read_functions(&mut self, parts: &[Tree<'_>]) {
        let mut rest = parts;
        while let Some((part, more)) = rest.split_first() {
            rest = more;
            if part.is("-") {
                let Some((ty, more)) = more.split_first() else { continue };
                rest = more;
                if !ty.is("number") {
                    let help = "a function gives a number, for the total cost";
                    self.problems.push(problems::not_supported(
                        "a function that gives an object is",
                        ty.span,
                        help,
                    ));
                }
                continue;
            }
            let Some((name, params)) = part.headed() else {
                self.problems.push(problems::expected(
                    "a function such as `(length ?x ?y - place)`",
                    part.span,
                ));
                continue;
            };
            let (name, scope) = self.signature(name, params);
            if let Some(first) = self.functions.get(&key(&name.text)) {
                let first = self.pair.functions[*first].name.span;
                self.problems
                    .push(problems::duplicate("function", &name.text, name.span, first));
                continue;
            }
            self.functions.insert(key(&name.text), self.pair.functions.len());
            self.pair.functions.push(relation(name, scope));
        }
    }
}

fn relation(name: Name, scope: Scope) -> Relation {
    Relation {
        name,
        params: scope.0.into_iter().map(|v| v.kinds).collect(),
    }
}
