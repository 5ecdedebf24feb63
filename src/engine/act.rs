//! Applies actions: precondition, projection onto geometry, effects, cost and duration.

use super::ground;
use super::objective::Touched;
use super::observe::Event;
use super::outcome::{Charge, Step};
use super::reasoner::{Call, GasNum, Projection};
use super::refusals::Kind;
use super::search::{Flow, Point, Search};
use crate::ir::{ActionId, SlotId, TaskId, Value};
use crate::plan::Refusal;

/// HEURISTIC: charges looked at for one that is the same.
const NEAR_CHARGES: usize = 4;

impl Search<'_> {
    /// Tests an action's precondition, projects it, and applies it.
    pub fn try_action(&mut self, node: u32, id: ActionId) -> Flow {
        let domain = self.context.domain;
        let action = &domain.actions[id.index()];
        if let Some(flow) = self.refuse_unlike_kept(node, id) {
            return flow;
        }
        let frame = self.extend(node, id);
        let prepared = self.prepared.action(id);
        if !self.passes((&action.preconditions, &prepared.preconditions), node, frame, 0) {
            return Flow::Back;
        }
        let Some(projection) = &action.projects else {
            return self.apply_action(node, None);
        };
        let mut args = Vec::with_capacity(projection.args.len());
        for (position, arg) in projection.args.iter().enumerate() {
            match self.context.value(arg, &mut self.tree.values[frame..]) {
                Some(value) if value != Value::Null => args.push(value),
                _ => {
                    return self.refuse(Kind::NullArgument, node, &[position as u64], |search| {
                        search.null_argument(node, search.show(node), position, arg)
                    });
                }
            }
        }
        let constraints = ground::formula(&mut self.context, &action.constraints, &mut self.tree.values[frame..]);
        self.tree.values.truncate(frame + action.params.len());
        let point = self.point();
        let call = Call {
            name: &projection.name,
            args: &args,
            given: &projection.given,
            constraints: &constraints,
        };
        if self.observer.is_some() {
            self.tell_projecting(node, &call);
        }
        if let Some(next) = self.kept.get(self.steps.len()) {
            return match self
                .context
                .reasoner
                .adopt(domain, &call, next.written.geometry.as_deref())
            {
                Ok(solution) => self.apply_action(node, Some((point, solution))),
                Err(refusal) => self.refuse_geometry(node, refusal),
            };
        }
        self.statistics.projections += 1;
        match self.context.reasoner.project(domain, &call) {
            Ok(solution) => {
                let limit = self.limit(id);
                self.push_alternatives(point, node, solution, limit, 0);
                self.apply_action(node, Some((point, solution)))
            }
            Err(refusal) => self.refuse_geometry(node, refusal),
        }
    }

    /// Asks for another geometric solution of an action, and applies it.
    pub fn try_alternative(
        &mut self,
        point: Point,
        node: u32,
        gas: GasNum,
        tried: u32,
        limit: u32,
        best: usize,
    ) -> Flow {
        self.statistics.projections += 1;
        self.statistics.alternatives += 1;
        self.read_before(node);
        self.tell(|_| Event::Alternative { node, tried });
        match self.context.reasoner.find_alternative(gas, tried) {
            Ok(projection) => {
                self.push_alternatives(point, node, projection, limit, best);
                self.apply_action(node, Some((point, projection)))
            }
            Err(refusal) => self.refuse_geometry(node, refusal),
        }
    }

    fn refuse_geometry(&mut self, node: u32, refusal: crate::plan::ActionRefusal) -> Flow {
        self.truncated.geometry += u64::from(!refusal.exhausted);
        let refusal = Refusal::Geometry(refusal);
        self.reasons.add_geometry(&refusal);
        self.tell_refused(node, 0, Some(&refusal));
        Flow::Back
    }

    /// Makes room for an action's quantified variables behind its arguments; returns where its frame begins.
    fn extend(&mut self, node: u32, id: ActionId) -> usize {
        let action = &self.context.domain.actions[id.index()];
        let frame = self.tree.nodes[node as usize].frame as usize;
        for _ in self.tree.values.len()..frame + action.n_vars {
            self.tree.values.push(Value::Null);
        }
        frame
    }

    /// Notes what an action's precondition, the arguments of its projection and its constraints read, in the world state
    /// before the action.
    fn read_before(&mut self, node: u32) {
        let TaskId::Action(id) = self.tree.task(node) else {
            return;
        };
        let action = &self.context.domain.actions[id.index()];
        let frame = self.extend(node, id);
        self.context.reads.clear();
        let values = &mut self.tree.values[frame..];
        self.context.holds(&action.preconditions, values);
        if let Some(projection) = &action.projects {
            for arg in &projection.args {
                self.context.value(arg, values);
            }
            ground::formula(&mut self.context, &action.constraints, values);
        }
        self.tree.values.truncate(frame + action.params.len());
    }

    /// Applies the effects; after a projection all shared attributes are read anew from geometry (thesis 4.3.5).
    /// `projected` is the point before the projection, and what it gave. What the action has read so far is noted.
    fn apply_action(&mut self, node: u32, projected: Option<(Point, Projection)>) -> Flow {
        let TaskId::Action(id) = self.tree.task(node) else {
            return Flow::Back;
        };
        let action = &self.context.domain.actions[id.index()];
        let geometric = projected.map_or((0.0, 0.0), |(_, p)| (p.cost, p.duration));
        let n_reads = self.context.reads.len();
        let frame = self.extend(node, id);
        let numbers = loop {
            self.context.reads.truncate(n_reads);
            (self.context.projection, self.context.is_late) = (geometric, projected.is_some());
            let values = &mut self.tree.values[frame..];
            let numbers = match self.prepared.action(id).numbers {
                Some(numbers) => numbers.map(Some),
                None => [&action.cost, &action.duration.0, &action.duration.1].map(|e| self.context.number(e, values)),
            };
            self.written.clear();
            self.context.apply(&action.effects, values, &mut self.written);
            (self.context.projection, self.context.is_late) = ((0.0, 0.0), false);
            match projected {
                // All this looks at the world state before the projection, and what it looks at may depend on what the
                // projection gave. INVARIANT: every round knows an answer more, so there is a last one.
                Some((point, projection)) if !self.context.missed.is_empty() => {
                    let missed = std::mem::take(&mut self.context.missed);
                    self.context.state.restore(point.trail);
                    self.context.reasoner.restore(point.world);
                    self.context.catch_up(missed);
                    self.context.reasoner.replay(projection.gas);
                }
                _ => break numbers,
            }
        };
        self.context.answers.clear();
        self.tree.values.truncate(frame + action.params.len());
        let (cost, least, most) = match numbers {
            [Some(c), Some(l), Some(m)] if c >= 0.0 && l >= 0.0 && m >= l => (c, l, m),
            numbers => return self.refuse_numbers(node, numbers),
        };
        if projected.is_some() {
            for slot in self.shared {
                self.context.state.forget(*slot);
            }
        }
        let args = &self.tree.values[frame..];
        self.context.learn(action, args, &mut self.written);
        self.cost += cost;
        let slots = self.note_slots();
        let charge = self.charge(Charge {
            gas: projected.map(|(_, p)| p.gas),
            geometric,
            cost,
            duration: (least.max(geometric.1), most.max(geometric.1)),
        });
        self.steps.push(Step {
            action: id,
            node,
            charge,
            slots,
        });
        self.tell(|search| Event::Applied {
            node,
            cost,
            gas: projected.map(|(_, p)| p.gas),
            n_actions: search.steps.len(),
        });
        if let (Some(objective), Some(step)) = (&mut self.objective, self.steps.last()) {
            let [from, to, end] = slots.map(|at| at as usize);
            let touched = Touched {
                reads: &self.slots[from..to],
                writes: &self.slots[to..end],
            };
            let charge = &self.charges[charge as usize];
            objective.push(&mut self.context, &self.tree, (step, charge), touched);
        }
        let guard = self.guard();
        self.agenda.finish(self.prepared, node, guard);
        self.too_costly().unwrap_or(Flow::Forward)
    }

    /// Returns where what a step costs is written down: where one of the last steps cost the same, it is there.
    fn charge(&mut self, charge: Charge) -> u32 {
        let near = self.charges.len().saturating_sub(NEAR_CHARGES);
        if let Some(at) = self.charges[near..].iter().rposition(|c| *c == charge) {
            return (near + at) as u32;
        }
        self.charges.push(charge);
        self.charges.len() as u32 - 1
    }

    /// Writes down what the action at hand has read of what may change, and what it has written, each slot once; returns
    /// where.
    fn note_slots(&mut self) -> [u32; 3] {
        self.note_reads();
        let is_fixed = &self.prepared.is_fixed;
        let mut ends = [self.slots.len() as u32; 3];
        for slot in self.context.reads.drain(..).filter(|slot| !is_fixed[slot.index()]) {
            insert(&mut self.slots, ends[0] as usize, slot);
        }
        ends[1] = self.slots.len() as u32;
        for slot in self.written.drain(..) {
            insert(&mut self.slots, ends[1] as usize, slot);
        }
        ends[2] = self.slots.len() as u32;
        if self.shared.is_empty() {
            for slot in &self.slots[ends[1] as usize..] {
                let value = self.context.state.get(*slot).cloned().unwrap_or_default();
                self.news.push(value);
            }
        }
        ends
    }

    fn refuse_numbers(&mut self, node: u32, numbers: [Option<f64>; 3]) -> Flow {
        let [c, l, m] = numbers;
        let bad = |x: &Option<f64>| x.is_none_or(|x| x < 0.0);
        let (what, value) = match (l, m) {
            _ if bad(&c) => ("cost", c),
            _ if bad(&l) => ("least duration", l),
            (Some(least), Some(most)) if most >= 0.0 => {
                let print = [least.to_bits(), most.to_bits()];
                return self.refuse(Kind::Number, node, &print, |search| Refusal::DurationOrder {
                    task: search.show(node),
                    least,
                    most,
                });
            }
            _ => ("most duration", m),
        };
        let number = value.map_or([0, 0], |x| [1, x.to_bits()]);
        let print = [what.len() as u64, number[0], number[1]];
        self.refuse(Kind::Number, node, &print, |search| Refusal::BadNumber {
            task: search.show(node),
            what,
            value,
        })
    }
}

/// Puts a slot where it belongs in the list, in order, that begins at `from`, unless it is there.
#[inline]
fn insert(slots: &mut Vec<SlotId>, from: usize, slot: SlotId) {
    match slots[from..].last() {
        Some(last) if slot <= *last => {
            if let Err(at) = slots[from..].binary_search(&slot) {
                slots.insert(from + at, slot);
            }
        }
        _ => slots.push(slot),
    }
}
