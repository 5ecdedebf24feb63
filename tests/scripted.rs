//! The engine with a scripted reasoner: geometry's answers are exact by definition, so only the search is judged.
#![expect(clippy::unwrap_used, reason = "a test that can't go on should stop")]

#[path = "scripted/best.rs"]
mod best;
#[path = "scripted/cuts.rs"]
mod cuts;
#[path = "scripted/document.rs"]
mod document;
#[path = "scripted/domain.rs"]
mod domain;
#[path = "scripted/geometry.rs"]
mod geometry;
#[path = "scripted/interleave.rs"]
mod interleave;
#[path = "scripted/kept.rs"]
mod kept;
#[path = "scripted/look_ahead.rs"]
mod look_ahead;
#[path = "scripted/reasoner.rs"]
mod reasoner;
#[path = "scripted/run.rs"]
mod run;
#[path = "scripted/search.rs"]
mod search;
#[path = "scripted/second_opinion.rs"]
mod second_opinion;
#[path = "scripted/strategies.rs"]
mod strategies;
#[path = "scripted/values.rs"]
mod values;
