//! What tasks may change, and what tests look at: attributes, not slots.
//!
//! A set of attributes is one word: attributes beyond the 63rd share bits with others, which makes "may change" true more
//! often, and never less. The last bit is the world state: whatever is asked of geometry looks at it, and every projection
//! changes it.

use crate::ir::{Action, AttributeId, Domain, Effect, Expr, TaskId, Test};

/// A set of attributes, and the world.
pub(super) type Attributes = u64;

/// The world state.
pub(super) const WORLD: Attributes = 1 << 63;

/// What each task may change, with all that it may be decomposed into.
#[derive(Debug)]
pub(super) struct Changes {
    actions: Vec<Attributes>,
    methods: Vec<Attributes>,
}

impl Changes {
    pub fn new(domain: &Domain) -> Self {
        let mut changes = Changes {
            actions: domain.actions.iter().map(of_action).collect(),
            methods: vec![0; domain.methods.len()],
        };
        // Sets only grow: a round without news is the last.
        loop {
            let of = |m: &crate::ir::Method| {
                let subtasks = m.decompositions.iter().flat_map(|d| &d.subtasks);
                subtasks.fold(0, |all, s| all | changes.of(s.task))
            };
            let next: Vec<Attributes> = domain.methods.iter().map(of).collect();
            if next == changes.methods {
                return changes;
            }
            changes.methods = next;
        }
    }

    /// Returns what a task may change.
    pub fn of(&self, task: TaskId) -> Attributes {
        match task {
            TaskId::Action(a) => self.actions[a.index()],
            TaskId::Method(m) => self.methods[m.index()],
        }
    }
}

pub(super) fn bit(attribute: AttributeId) -> Attributes {
    1 << (attribute.index() % 63)
}

fn of_action(action: &Action) -> Attributes {
    let world = if action.projects.is_some() { WORLD } else { 0 };
    of_effects(&action.effects) | world
}

fn of_effects(effects: &[Effect]) -> Attributes {
    effects.iter().fold(0, |all, effect| {
        all | match effect {
            // What agents believe of an attribute is kept under the same one.
            Effect::Assign { attribute, .. } | Effect::Add { attribute, .. } | Effect::Remove { attribute, .. } => {
                bit(*attribute)
            }
            Effect::Forall { effects, .. } => of_effects(effects),
            Effect::If { then, otherwise, .. } => of_effects(then) | of_effects(otherwise),
        }
    })
}

/// Returns what a test looks at.
pub(super) fn looked_at(domain: &Domain, test: &Test) -> Attributes {
    let mut all = 0;
    test.any(&mut |expr| {
        expr.any(&mut |e| {
            match e {
                Expr::Attribute { attribute, .. } => {
                    all |= bit(*attribute);
                    // A shared attribute is read from geometry.
                    if domain.attributes[attribute.index()].fact.is_some() {
                        all |= WORLD;
                    }
                }
                Expr::Request { .. } | Expr::Fact { .. } | Expr::GeometricCost | Expr::GeometricDuration => {
                    all |= WORLD;
                }
                Expr::Const(_)
                | Expr::Var(_)
                | Expr::Size(_)
                | Expr::List(_)
                | Expr::Arithmetic { .. }
                | Expr::Negate(_)
                | Expr::SetWith { .. }
                | Expr::SetWithout { .. } => {}
            }
            false
        });
        false
    });
    all
}
