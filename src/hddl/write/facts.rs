//! Types, attributes, entities and their values.

use std::fmt::Write;

use indexmap::IndexMap;

use super::super::ast::{OBJECT, TypeId};
use super::Writer;

impl Writer<'_> {
    pub(super) fn facts(&mut self) {
        self.line("factdatabase {");
        self.declare_types();
        self.declare_attributes();
        self.declare_entities();
        self.initial();
        self.line("}\n");
    }

    fn has_world(&self) -> bool {
        let is_empty = |positions: &Vec<TypeId>| positions.is_empty();
        self.positions.iter().chain(&self.function_positions).any(is_empty)
    }

    /// Writes supertypes before what is below them.
    fn declare_types(&mut self) {
        let pair = self.pair;
        if self.has_world() {
            self.line(&format!("define entityType {};", self.world.0));
        }
        let mut below: Vec<Vec<TypeId>> = vec![Vec::new(); pair.types.len()];
        for (ty, declared) in pair.types.iter().enumerate() {
            if let Some(parent) = declared.parent {
                below[parent].push(ty);
            }
        }
        let mut open = vec![OBJECT];
        while let Some(ty) = open.pop() {
            open.extend(below[ty].iter().rev());
            let (name, declared) = (&self.types[ty], &pair.types[ty]);
            let above = declared.parent.map(|p| format!(" : {}", self.types[p]));
            let comment = self.called_otherwise(name, &declared.name.text);
            let text = format!("define entityType {name}{};{comment}", above.unwrap_or_default());
            self.line(&text);
        }
        self.line("");
    }

    fn declare_attributes(&mut self) {
        let mut of: IndexMap<&str, String> = IndexMap::new();
        // In the order of the types, what speaks of no object first.
        of.insert(&self.world.0, String::new());
        self.types.iter().for_each(|t| {
            of.insert(t, String::new());
        });
        let owner = |positions: &[TypeId]| positions.first().map_or(&self.world.0, |t| &self.types[*t]);
        let set = |name: &str, positions: &[TypeId]| match positions {
            [] | [_] => format!("atom bool {name}"),
            [_, keys @ .., value] => {
                let keys: Vec<&str> = keys.iter().map(|t| self.types[*t].as_str()).collect();
                let keys = if keys.is_empty() {
                    String::new()
                } else {
                    format!("({})", keys.join(", "))
                };
                format!("set {} {name}{keys}", self.types[*value])
            }
        };
        for (predicate, positions) in self.positions.iter().enumerate() {
            let name = &self.predicates[predicate];
            let changes = if self.bodies.is_dynamic[predicate] {
                "dynamic"
            } else {
                "static"
            };
            let comment = self.called_otherwise(name, &self.pair.predicates[predicate].name.text);
            let block = of.entry(owner(positions)).or_default();
            let _ = writeln!(block, "{changes} {};{comment}", set(name, positions));
            if let Some(copy) = self.before_attributes.get(&predicate) {
                let _ = writeln!(
                    block,
                    "dynamic {}; // of `{name}`, while an action has its effects",
                    set(copy, positions)
                );
            }
        }
        for (function, positions) in self.function_positions.iter().enumerate() {
            // That one is the sum of the plan.
            if self.is_total_cost(function) {
                continue;
            }
            let name = &self.functions[function];
            let keys: Vec<&str> = positions.iter().skip(1).map(|t| self.types[*t].as_str()).collect();
            let keys = if keys.is_empty() {
                String::new()
            } else {
                format!("({})", keys.join(", "))
            };
            let block = of.entry(owner(positions)).or_default();
            let _ = writeln!(block, "static atom number {name}{keys};");
        }
        for name in self.is_attributes.values() {
            let block = of.entry(&self.types[OBJECT]).or_default();
            let _ = writeln!(block, "static atom bool {name};");
        }
        let blocks: Vec<String> = of
            .iter()
            .filter(|(_, block)| !block.is_empty())
            .map(|(ty, block)| format!("define entityAttributes {ty} {{\n{block}}}\n"))
            .collect();
        blocks.iter().for_each(|block| self.line(block));
    }

    fn is_total_cost(&self, function: usize) -> bool {
        let function = &self.pair.functions[function];
        function.params.is_empty() && function.name.text.eq_ignore_ascii_case("total-cost")
    }

    fn declare_entities(&mut self) {
        if self.has_world() {
            self.line(&format!("{} = new {};", self.world.1, self.world.0));
        }
        let pair = self.pair;
        for (object, declared) in pair.objects.iter().enumerate() {
            let name = &self.objects[object];
            let comment = self.called_otherwise(name, &declared.name.text);
            let text = format!("{name} = new {};{comment}", self.types[declared.ty]);
            self.line(&text);
        }
        self.line("");
    }

    /// Writes the values of the start; all members of a set in one line.
    fn initial(&mut self) {
        let pair = self.pair;
        let mut sets: IndexMap<String, Vec<&str>> = IndexMap::new();
        let mut out = String::new();
        for fact in &pair.facts {
            let name = &self.predicates[fact.predicate];
            let args: Vec<&str> = fact.args.iter().map(|o| self.objects[*o].as_str()).collect();
            match &args[..] {
                [] | [_] => {
                    let _ = writeln!(out, "{} = true;", self.attribute(name, &args));
                }
                [owner @ .., value] => sets.entry(self.attribute(name, owner)).or_default().push(value),
            }
        }
        for (path, values) in &sets {
            let _ = writeln!(out, "{path} = [{}];", values.join(", "));
        }
        let mut numbers: IndexMap<String, f64> = IndexMap::new();
        for value in &pair.values {
            if !self.is_total_cost(value.function) {
                let args: Vec<&str> = value.args.iter().map(|o| self.objects[*o].as_str()).collect();
                numbers.insert(self.attribute(&self.functions[value.function], &args), value.number);
            }
        }
        for (path, number) in &numbers {
            let _ = writeln!(out, "{path} = {number};");
        }
        for (ty, name) in &self.is_attributes {
            for (object, declared) in pair.objects.iter().enumerate() {
                if pair.is_subtype(declared.ty, *ty) {
                    let _ = writeln!(out, "{}.{name} = true;", self.objects[object]);
                }
            }
        }
        self.out.push_str(&out);
    }
}
