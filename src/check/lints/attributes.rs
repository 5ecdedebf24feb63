//! Attributes that no test reads, and attributes that are read and that nothing sets.
//!
//! Both are off unless asked for: a domain may declare what another file of the project uses, and a world may set it.

use std::collections::BTreeSet;

use super::Linted;
use super::read::Read;
use crate::diag::{Problem, Problems};
use crate::ir::{Attribute, AttributeId, Binder, RuleKind, SelectOrder, Value};
use crate::source::Span;

pub(super) fn lint(linted: &Linted<'_>, problems: &mut Problems) {
    let domain = linted.domain;
    let (mut read, mut set) = (Read::default(), BTreeSet::new());
    for action in &domain.actions {
        read.test(&action.preconditions);
        read.test(&action.constraints);
        let projected = action.projects.iter().flat_map(|p| &p.args);
        projected.for_each(|a| read.expr(a));
        read.effects(&action.effects, &mut set);
        read.expr(&action.cost);
        read.expr(&action.duration.0);
        read.expr(&action.duration.1);
    }
    let observes = domain.beliefs.iter().filter_map(|b| b.observes.as_ref());
    observes.for_each(|o| read.test(&o.body));
    for fact in &domain.facts {
        read.test(&fact.body);
    }
    for rule in &domain.social {
        if let RuleKind::State { test, .. } = &rule.kind {
            read.test(test);
        }
    }
    for method in &domain.methods {
        method.goal.iter().for_each(|goal| read.test(goal));
        for decomposition in &method.decompositions {
            read.test(&decomposition.preconditions);
            for binder in &decomposition.binders {
                match binder {
                    Binder::Let { value, .. } => read.expr(value),
                    Binder::Select { filter, order, .. } => {
                        read.test(filter);
                        if let SelectOrder::Sorted { key, .. } = order {
                            read.expr(key);
                        }
                    }
                }
            }
            let args = decomposition.subtasks.iter().flat_map(|s| &s.args);
            args.for_each(|a| read.expr(a));
        }
    }
    for (slot, value) in domain.slots.iter().zip(&domain.initial) {
        let is_unset = match value {
            Value::Null => true,
            Value::Set(set) => set.is_empty(),
            Value::Scalars(set) => set.is_empty(),
            Value::Unknown | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Entity(_) => false,
        };
        if !is_unset {
            set.insert(slot.attribute);
        }
    }
    for (i, (attribute, span)) in domain.attributes.iter().zip(linted.attribute_spans).enumerate() {
        if linted.main.is_some_and(|main| span.file != main) {
            continue;
        }
        let id = AttributeId(i as u32);
        let owner = domain.types.get(attribute.owner.index());
        let owner = owner.map_or("?", |t| t.name.as_str());
        if !read.attributes.contains(&id) {
            problems.push(never_read(owner, attribute, *span));
        } else if attribute.fact.is_none() && !set.contains(&id) {
            problems.push(never_set(owner, attribute, *span));
        }
    }
}

fn never_read(owner: &str, attribute: &Attribute, span: Span) -> Problem {
    let message = format!("no test reads `{owner}.{}`", attribute.name);
    Problem::warning("hatp::never-read", message, span, "never read")
        .help("remove it, unless another file or a reader of the plan wants it")
}

fn never_set(owner: &str, attribute: &Attribute, span: Span) -> Problem {
    let message = format!("nothing sets `{owner}.{}`, and tests read it", attribute.name);
    let of_kind = if attribute.is_set { "an empty set" } else { "`NULL`" };
    Problem::warning("hatp::never-set", message, span, format!("always {of_kind}"))
        .help("set it in `factdatabase`, in the world file or in an effect, or share it: `= fact isOn`")
}
