//! The geometric reasoner through its doors: facts, actions with their alternatives, refusals, and the motions that a plan document gets.
//!
//! On the shipped worlds, and on small ones written here; expected values come from the worlds' own numbers.
#![expect(
    clippy::disallowed_methods,
    reason = "what a test expects need not be the same to the last bit everywhere"
)]
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "grp/alternatives.rs"]
mod alternatives;
#[path = "grp/case.rs"]
mod case;
#[path = "grp/constraints.rs"]
mod constraints;
#[path = "grp/facts.rs"]
mod facts;
#[path = "grp/history.rs"]
mod history;
#[path = "grp/motions.rs"]
mod motions;
#[path = "grp/navigation.rs"]
mod navigation;
#[path = "grp/refusals.rs"]
mod refusals;
#[path = "grp/relations.rs"]
mod relations;
#[path = "grp/requests.rs"]
mod requests;
