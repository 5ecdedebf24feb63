//! Causal links: what must be over before what, and why.
//!
//! Links are the transitive reduction of four relations: an action needs an attribute that an earlier one set; an action
//! overwrites what an earlier one read or set; the domain orders their subtasks; motions are planned one after the other.

use super::names::Names;
use super::order::right_before;
use super::outcome::{Changed, Found, NONE};
use super::reduction::Reduction;
use crate::ir::{Domain, SlotId};
use crate::plan::{Link, LinkReason};

/// Why one step comes before another, but for the domain's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Why {
    Attribute(SlotId),
    Threat(SlotId),
    Motion,
}

/// Returns the links with their reasons.
pub(super) fn links(found: &Found, changed: &Changed, domain: &Domain, names: &mut Names<'_>) -> Vec<Link> {
    let ordered = right_before(found, domain);
    let mut dependencies = Dependencies {
        last_writer: vec![NONE; domain.slots.len()],
        readers: vec![Vec::new(); domain.slots.len()],
        last_motion: NONE,
        writes: Vec::new(),
    };
    let mut reduction = Reduction::default();
    let mut links = Vec::new();
    let (mut needs, mut candidates, mut reasons) = (Vec::new(), Vec::new(), Vec::new());
    for after in 0..found.steps.len() {
        let ordered = ordered.of(after);
        dependencies.of_step(found, changed, after, &mut needs);
        candidates.clear();
        candidates.extend(needs.iter().map(|(before, _)| *before));
        candidates.extend_from_slice(ordered);
        for before in reduction.add(&mut candidates) {
            reasons.clear();
            for (_, why) in needs.iter().filter(|(b, _)| *b == before) {
                let reason = match why {
                    Why::Attribute(slot) => LinkReason::Attribute(names.slot(*slot)),
                    Why::Threat(slot) => LinkReason::Threat(names.slot(*slot)),
                    Why::Motion => LinkReason::Motion,
                };
                if !reasons.contains(&reason) {
                    reasons.push(reason);
                }
            }
            // What the domain orders further back is implied by what it orders right before.
            if ordered.contains(&before) {
                reasons.push(LinkReason::Order);
            }
            links.push(Link {
                before: before as usize,
                after,
                reasons: reasons.clone(),
            });
        }
    }
    // No pair is there twice.
    links.sort_unstable_by_key(|link| (link.before, link.after));
    links
}

/// Who has last read and written what.
struct Dependencies {
    /// By slot.
    last_writer: Vec<u32>,
    /// By slot: those that have read it since it was written.
    readers: Vec<Vec<u32>>,
    last_motion: u32,
    /// Room for what a step writes.
    writes: Vec<SlotId>,
}

impl Dependencies {
    /// Lists the earlier steps that a step must come after.
    fn of_step(&mut self, found: &Found, changed: &Changed, index: usize, needs: &mut Vec<(u32, Why)>) {
        needs.clear();
        let (step, this) = (&found.steps[index], index as u32);
        let is_projected = found.charge(step).gas.is_some();
        for slot in found.reads(step) {
            let writer = self.last_writer[slot.index()];
            if writer != NONE {
                needs.push((writer, Why::Attribute(*slot)));
            }
        }
        let writes = &mut self.writes;
        writes.clear();
        writes.extend_from_slice(found.writes(step));
        writes.extend(changed.by(index).map(|(slot, _)| slot));
        if is_projected {
            writes.extend(&found.overruled);
        }
        writes.sort_unstable();
        writes.dedup();
        for slot in writes.iter().copied() {
            let readers = self.readers[slot.index()].drain(..);
            needs.extend(readers.map(|reader| (reader, Why::Threat(slot))));
            let writer = std::mem::replace(&mut self.last_writer[slot.index()], this);
            if writer != NONE {
                needs.push((writer, Why::Threat(slot)));
            }
        }
        for slot in found.reads(step) {
            if self.last_writer[slot.index()] != this {
                self.readers[slot.index()].push(this);
            }
        }
        if is_projected {
            let before = std::mem::replace(&mut self.last_motion, this);
            if before != NONE {
                needs.push((before, Why::Motion));
            }
        }
    }
}
