//! The earliest schedule, step by step: the same starts and links as `links`, `order` and `document` find at the end.
//!
//! Kept per slot: its last writer and its readers since; per agent, when it is free; per node of the tree, the last steps that
//! the domain orders before it. Each step knows what it has changed.

use std::rc::Rc;

use super::Touched;
use crate::engine::order::Family;
use crate::engine::outcome::{Charge, NONE, Step, Tree};
use crate::engine::reduction::Reduction;
use crate::ir::{Domain, EntityId, RuleKind};

/// A schedule under way.
#[derive(Debug)]
pub(super) struct Schedule {
    /// Whether anybody asks for times or links.
    is_asked: bool,
    /// By rule about links: how many there are; and the agents that it is about, as bits by entity.
    links: Vec<(usize, Vec<bool>, u64)>,
    reduction: Reduction,
    /// By slot: its last writer, and the first of its readers since in `readers`.
    slots: Vec<(u32, u32)>,
    /// A reader, and the next one.
    readers: Vec<(u32, u32)>,
    slots_before: Vec<(u32, (u32, u32))>,
    last_motion: u32,
    /// By agent.
    agents: Vec<Agent>,
    agents_before: Vec<(EntityId, Agent)>,
    /// Agents of the steps, one after the other.
    of_steps: Vec<EntityId>,
    counted: Vec<u32>,
    steps: Vec<Mark>,
    tree: Branches,
}

#[derive(Debug, Clone, Copy, Default)]
struct Agent {
    has_acted: bool,
    free_at: f64,
    wasted: f64,
}

/// Where a step's own begins, and when it ends.
#[derive(Debug, Clone, Copy)]
struct Mark {
    slots_before: u32,
    readers: u32,
    agents_before: u32,
    of_steps: u32,
    counted: u32,
    acted: u32,
    node: u32,
    last_motion: u32,
    end: f64,
    makespan: f64,
}

impl Schedule {
    pub fn new(domain: &Domain) -> Self {
        let mut is_timed = domain.settings.cost.makespan != 0.0;
        let mut links = Vec::new();
        for (number, rule) in domain.social.iter().enumerate() {
            match &rule.kind {
                RuleKind::WastedTime { .. } => is_timed = true,
                RuleKind::IntricateLinks { agents } => {
                    let mut bits = vec![false; domain.entities.len()];
                    agents.iter().for_each(|a| bits[a.index()] = true);
                    links.push((number, bits, 0));
                }
                RuleKind::State { .. } | RuleKind::Sequence { .. } | RuleKind::EffortBalance { .. } => {}
            }
        }
        Schedule {
            is_asked: is_timed || !links.is_empty(),
            links,
            reduction: Reduction::default(),
            slots: vec![(NONE, NONE); domain.slots.len()],
            readers: Vec::new(),
            slots_before: Vec::new(),
            last_motion: NONE,
            agents: vec![Agent::default(); domain.entities.len()],
            agents_before: Vec::new(),
            of_steps: Vec::new(),
            counted: Vec::new(),
            steps: Vec::new(),
            tree: Branches::default(),
        }
    }

    /// Returns when the last action ends [s].
    pub fn makespan(&self) -> f64 {
        self.steps.last().map_or(0.0, |s| s.makespan)
    }

    /// Returns how long an agent has waited between its actions [s].
    pub fn wasted(&self, agent: EntityId) -> f64 {
        self.agents[agent.index()].wasted
    }

    /// Returns the links that rule number `rule` counts.
    pub fn n_links(&self, rule: usize) -> u64 {
        let of_rule = self.links.iter().find(|(number, ..)| *number == rule);
        of_rule.map_or(0, |(.., n)| *n)
    }

    /// Adds a step.
    pub fn push(
        &mut self,
        domain: &Domain,
        tree: &Tree,
        (step, charge): (&Step, &Charge),
        agents: &[EntityId],
        touched: Touched<'_>,
    ) {
        if !self.is_asked {
            return;
        }
        let this = self.steps.len() as u32;
        let mut mark = Mark {
            slots_before: self.slots_before.len() as u32,
            readers: self.readers.len() as u32,
            agents_before: self.agents_before.len() as u32,
            of_steps: self.of_steps.len() as u32,
            counted: self.counted.len() as u32,
            acted: self.tree.acted.len() as u32,
            node: step.node,
            last_motion: self.last_motion,
            end: 0.0,
            makespan: self.makespan(),
        };
        self.tree.grow(domain, tree, step.node);
        let mut needs = self.touch(this, touched);
        if charge.gas.is_some() {
            let before = std::mem::replace(&mut self.last_motion, this);
            if before != NONE {
                needs.push(before);
            }
        }
        needs.extend_from_slice(&self.tree.before[step.node as usize]);
        self.tree.act(tree, step.node, this);
        let free = agents.iter().map(|a| self.agents[a.index()].free_at);
        let ends = needs.iter().map(|before| self.steps[*before as usize].end);
        let start = free.chain(ends).fold(0.0, f64::max);
        mark.end = start + charge.duration.0;
        mark.makespan = mark.makespan.max(mark.end);
        for agent in agents {
            let state = &mut self.agents[agent.index()];
            self.agents_before.push((*agent, *state));
            let wasted = if state.has_acted { start - state.free_at } else { 0.0 };
            *state = Agent {
                has_acted: true,
                free_at: mark.end,
                wasted: state.wasted + wasted,
            };
        }
        self.of_steps.extend_from_slice(agents);
        self.steps.push(mark);
        if !self.links.is_empty() {
            for before in self.reduction.add(&mut needs) {
                self.count_link(before, agents);
            }
        }
    }

    /// Notes what a step reads and writes; returns the steps that it comes after for that.
    fn touch(&mut self, this: u32, touched: Touched<'_>) -> Vec<u32> {
        let mut needs = Vec::new();
        for slot in touched.reads {
            let (writer, _) = self.slots[slot.index()];
            if writer != NONE {
                needs.push(writer);
            }
        }
        for slot in touched.writes {
            let (writer, mut reader) = self.slots[slot.index()];
            self.slots_before.push((slot.0, (writer, reader)));
            while reader != NONE {
                let (step, next) = self.readers[reader as usize];
                needs.push(step);
                reader = next;
            }
            if writer != NONE {
                needs.push(writer);
            }
            self.slots[slot.index()] = (this, NONE);
        }
        for slot in touched.reads {
            let (writer, reader) = self.slots[slot.index()];
            if writer != this {
                self.slots_before.push((slot.0, (writer, reader)));
                self.readers.push((this, reader));
                self.slots[slot.index()] = (writer, self.readers.len() as u32 - 1);
            }
        }
        needs
    }

    fn count_link(&mut self, before: u32, agents: &[EntityId]) {
        let from = self.steps[before as usize].of_steps as usize;
        let to = self.steps[before as usize + 1].of_steps as usize;
        let others = &self.of_steps[from..to];
        if agents.iter().any(|a| others.contains(a)) {
            return;
        }
        for (number, (_, about, n)) in self.links.iter_mut().enumerate() {
            let is_about = |agents: &[EntityId]| agents.iter().any(|a| about[a.index()]);
            if is_about(agents) && is_about(others) {
                *n += 1;
                self.counted.push(number as u32);
            }
        }
    }

    /// Takes back the last step.
    pub fn pop(&mut self) {
        if !self.is_asked {
            return;
        }
        let Some(mark) = self.steps.pop() else { return };
        while self.slots_before.len() > mark.slots_before as usize {
            if let Some((slot, before)) = self.slots_before.pop() {
                self.slots[slot as usize] = before;
            }
        }
        self.readers.truncate(mark.readers as usize);
        while self.agents_before.len() > mark.agents_before as usize {
            if let Some((agent, before)) = self.agents_before.pop() {
                self.agents[agent.index()] = before;
            }
        }
        self.of_steps.truncate(mark.of_steps as usize);
        for number in self.counted.drain(mark.counted as usize..) {
            self.links[number as usize].2 -= 1;
        }
        self.last_motion = mark.last_motion;
        if !self.links.is_empty() {
            self.reduction.pop();
        }
        self.tree.take_back(mark.node, mark.acted as usize);
    }

    /// Forgets all but the first `nodes` nodes of the tree.
    pub fn forget_nodes(&mut self, nodes: usize) {
        self.tree.shorten(nodes);
    }
}

/// The decomposition tree as far as it has been looked at, by node.
#[derive(Debug, Default)]
struct Branches {
    parent: Vec<u32>,
    /// The step of a leaf, or [`NONE`].
    step: Vec<u32>,
    /// Whether there is an action at or below it.
    acts: Vec<bool>,
    last_child: Vec<u32>,
    /// The sibling taken up before it.
    previous: Vec<u32>,
    /// The steps that come right before all below it by the order of the domain.
    before: Vec<Rc<[u32]>>,
    /// Nodes below which there is an action, in the order in which that came to be.
    acted: Vec<u32>,
}

impl Branches {
    /// Looks at the nodes up to `node`. What comes before a node is done when it is taken up.
    fn grow(&mut self, domain: &Domain, tree: &Tree, node: u32) {
        while self.parent.len() <= node as usize {
            let i = self.parent.len() as u32;
            let new = &tree.nodes[i as usize];
            self.parent.push(new.parent);
            self.step.push(NONE);
            self.acts.push(false);
            self.last_child.push(NONE);
            if new.parent == NONE {
                self.previous.push(NONE);
                self.before.push(Rc::new([]));
                continue;
            }
            let last = std::mem::replace(&mut self.last_child[new.parent as usize], i);
            self.previous.push(last);
            let (mut siblings, mut passed, mut all) = (Vec::new(), Vec::new(), Vec::new());
            let family = self.family(domain, tree);
            family.siblings_before(i, &mut siblings, &mut passed);
            siblings.iter().for_each(|s| family.last_steps(*s, &mut all));
            let before = match siblings.is_empty() {
                true => Rc::clone(&self.before[new.parent as usize]),
                false => all.into(),
            };
            self.before.push(before);
        }
    }

    fn shorten(&mut self, nodes: usize) {
        while self.parent.len() > nodes {
            self.step.pop();
            self.acts.pop();
            self.last_child.pop();
            self.before.pop();
            if let (Some(parent), Some(previous)) = (self.parent.pop(), self.previous.pop())
                && parent != NONE
            {
                self.last_child[parent as usize] = previous;
            }
        }
    }

    /// Notes a step, and that all above it have an action below.
    fn act(&mut self, tree: &Tree, node: u32, step: u32) {
        self.step[node as usize] = step;
        let mut at = node;
        while at != NONE && !self.acts[at as usize] {
            self.acts[at as usize] = true;
            self.acted.push(at);
            at = tree.nodes[at as usize].parent;
        }
    }

    fn take_back(&mut self, node: u32, acted: usize) {
        if let Some(step) = self.step.get_mut(node as usize) {
            *step = NONE;
        }
        for node in self.acted.drain(acted..) {
            if let Some(acts) = self.acts.get_mut(node as usize) {
                *acts = false;
            }
        }
    }

    fn family<'a>(&'a self, domain: &'a Domain, tree: &'a Tree) -> Family<'a> {
        Family {
            domain,
            tree,
            step: &self.step,
            acts: &self.acts,
            last_child: &self.last_child,
            previous: &self.previous,
        }
    }
}
