//! What is still to be done: a linked list of open decompositions, of which going back to a choice point keeps the old.
//!
//! In blocks, the first cell is at work and the others wait for it; a cell ends when its last subtask is taken up, so that
//! a method which ends with itself does not make the list longer. Interleaved, every cell offers its ready subtasks, the
//! latest decomposition's first; a subtask is *begun* when it is taken up and *done* when all below it is.

use super::hash::Print;
use super::outcome::NONE;
use super::prepare::{Order, Prepared};

/// An open decomposition.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// The cell after it, or [`NONE`].
    pub next: u32,
    /// Whose decomposition it is.
    pub node: u32,
    /// The decomposition's number among all of the domain.
    pub order: u32,
    /// The subtasks begun and done: in a chain their number; else bits, or where many of them lie in the store.
    begun: u64,
    done: u64,
    /// Fingerprint of this cell and all after it; `None` until it is asked for.
    print: Option<Print>,
}

/// Lengths to go back to.
#[derive(Debug, Clone, Copy)]
pub(super) struct AgendaMark {
    head: u32,
    cells: u32,
    store: u32,
}

impl AgendaMark {
    /// Returns the number of cells that belong to it.
    pub fn n_cells(&self) -> u32 {
        self.cells
    }
}

/// The cells, and the first of those that are open.
#[derive(Debug)]
pub(super) struct Agenda {
    cells: Vec<Cell>,
    /// Bits of decompositions with more than 64 subtasks.
    store: Vec<u64>,
    pub head: u32,
    interleave: bool,
    /// Interleaved: what ends with a node, by node; the root, which is nobody's subtask, is left out.
    joins: Vec<Join>,
}

/// Which subtask of which node's decomposition is done when some node is.
#[derive(Debug, Clone, Copy)]
struct Join {
    /// [`NONE`] where nothing waits.
    node: u32,
    subtask: u32,
    /// Fingerprint of the way down to it, which does not depend on the order in which tasks were taken up.
    path: Print,
}

impl Agenda {
    pub fn new(interleave: bool) -> Self {
        Agenda {
            cells: Vec::new(),
            store: Vec::new(),
            head: NONE,
            interleave,
            joins: Vec::new(),
        }
    }

    pub fn mark(&self) -> AgendaMark {
        AgendaMark {
            head: self.head,
            cells: self.cells.len() as u32,
            store: self.store.len() as u32,
        }
    }

    /// Goes back to a mark; `nodes` is the number of nodes that are left.
    pub fn restore(&mut self, mark: AgendaMark, nodes: usize) {
        self.head = mark.head;
        self.cells.truncate(mark.cells as usize);
        self.store.truncate(mark.store as usize);
        self.joins.truncate(nodes.saturating_sub(1));
    }

    pub fn cell(&self, cell: u32) -> &Cell {
        &self.cells[cell as usize]
    }

    fn is_counted(&self, order: &Order) -> bool {
        !self.interleave && order.chain.is_some()
    }

    fn has(&self, order: &Order, bits: u64, subtask: usize) -> bool {
        if order.n_subtasks <= 64 {
            bits >> subtask & 1 == 1
        } else {
            self.store[bits as usize + subtask / 64] >> (subtask % 64) & 1 == 1
        }
    }

    fn with(&mut self, order: &Order, bits: u64, subtask: usize) -> u64 {
        if order.n_subtasks <= 64 {
            return bits | 1 << subtask;
        }
        let (from, words) = (bits as usize, order.n_subtasks.div_ceil(64));
        let at = self.store.len();
        self.store.extend_from_within(from..from + words);
        self.store[at + subtask / 64] |= 1 << (subtask % 64);
        at as u64
    }

    fn is_full(&self, order: &Order, bits: u64) -> bool {
        let n = order.n_subtasks;
        if n <= 64 {
            return bits.count_ones() as usize == n;
        }
        let words = &self.store[bits as usize..bits as usize + n.div_ceil(64)];
        words.iter().map(|w| w.count_ones() as usize).sum::<usize>() == n
    }

    /// Opens the decomposition of a node. One without subtasks is done at once.
    pub fn open(&mut self, prepared: &Prepared, node: u32, number: u32) {
        let order = prepared.order(number);
        if order.n_subtasks == 0 {
            return;
        }
        let (mut begun, mut done) = (0, 0);
        if order.n_subtasks > 64 && !self.is_counted(order) {
            let words = order.n_subtasks.div_ceil(64);
            begun = self.store.len() as u64;
            self.store.resize(self.store.len() + words, 0);
            done = begun;
        }
        self.cells.push(Cell {
            next: self.head,
            node,
            order: number,
            begun,
            done,
            print: None,
        });
        self.head = self.cells.len() as u32 - 1;
    }

    /// Returns the subtask that comes next, with its cell, where the order of the first cell says at once that there is no other.
    #[inline]
    pub fn only_ready(&self, prepared: &Prepared) -> Option<(u32, u32)> {
        if self.interleave {
            return None;
        }
        let cell = self.cells.get(self.head as usize)?;
        let chain = prepared.order(cell.order).chain.as_ref()?;
        chain.get(cell.begun as usize).map(|subtask| (self.head, *subtask))
    }

    /// Returns the first ready subtask from `subtask` of `cell` on, with its cell.
    pub fn ready(&self, prepared: &Prepared, cell: u32, subtask: u32) -> Option<(u32, u32)> {
        let (mut at, mut from) = (cell, subtask as usize);
        while at != NONE {
            let cell = &self.cells[at as usize];
            let order = prepared.order(cell.order);
            if self.is_counted(order) {
                // The only one: it is the first and there is none after it.
                let subtask = order.chain.as_ref().and_then(|c| c.get(cell.begun as usize))?;
                return (from as u32 <= *subtask).then_some((at, *subtask));
            }
            let found = (from..order.n_subtasks).find(|i| {
                !self.has(order, cell.begun, *i) && order.after[*i].iter().all(|a| self.has(order, cell.done, *a))
            });
            match found {
                Some(i) => return Some((at, i as u32)),
                None if self.interleave => (at, from) = (cell.next, 0),
                None => return None,
            }
        }
        None
    }

    /// Returns the subtasks of a cell that have not been begun, as bits; `None` where there are too many for that.
    pub fn left(&self, prepared: &Prepared, cell: u32) -> Option<u64> {
        let cell = &self.cells[cell as usize];
        let order = prepared.order(cell.order);
        if order.n_subtasks > 64 {
            return None;
        }
        let all = u64::MAX.checked_shr(64 - order.n_subtasks as u32).unwrap_or(0);
        let begun = match &order.chain {
            Some(chain) if !self.interleave => chain.iter().take(cell.begun as usize).fold(0, |all, i| all | 1 << i),
            _ => cell.begun,
        };
        Some(all & !begun)
    }

    /// Takes up a subtask. Cells below `guard` belong to a choice point and are kept as they are.
    pub fn begin(&mut self, prepared: &Prepared, cell: u32, subtask: u32, guard: u32) {
        let Cell { node, order, .. } = self.cells[cell as usize];
        let order = prepared.order(order);
        if self.interleave {
            return self.begin_interleaved(order, cell, subtask, guard, node);
        }
        let old = self.cells[cell as usize];
        let (begun, is_last) = if self.is_counted(order) {
            (old.begun + 1, old.begun as usize + 1 == order.n_subtasks)
        } else {
            let begun = self.with(order, old.begun, subtask as usize);
            (begun, self.is_full(order, begun))
        };
        if is_last {
            self.head = old.next;
            if cell >= guard && cell as usize + 1 == self.cells.len() {
                self.cells.pop();
            }
            return;
        }
        let new = Cell {
            begun,
            done: begun,
            print: None,
            ..old
        };
        if cell >= guard {
            self.cells[cell as usize] = new;
        } else {
            self.cells.push(new);
            self.head = self.cells.len() as u32 - 1;
        }
    }

    fn begin_interleaved(&mut self, order: &Order, cell: u32, subtask: u32, guard: u32, node: u32) {
        let old = self.cells[cell as usize];
        let begun = self.with(order, old.begun, subtask as usize);
        let all_done = self.with(order, old.done, subtask as usize);
        if self.is_full(order, all_done) {
            // Nobody else is waited for: what this node's end would end, the subtask's does.
            let join = self.join(node);
            self.replace(cell, None, guard);
            self.joins.push(join);
        } else {
            let path = self.join(node).path.number(u64::from(subtask));
            self.replace(cell, Some((begun, old.done)), guard);
            self.joins.push(Join { node, subtask, path });
        }
    }

    fn join(&self, node: u32) -> Join {
        let known = node.checked_sub(1).and_then(|i| self.joins.get(i as usize));
        known.copied().unwrap_or(Join {
            node: NONE,
            subtask: 0,
            path: Print::default(),
        })
    }

    /// Notes that all below a node is done. In blocks the list says so by itself.
    pub fn finish(&mut self, prepared: &Prepared, node: u32, guard: u32) {
        if !self.interleave {
            return;
        }
        let mut join = self.join(node);
        while join.node != NONE {
            let mut at = self.head;
            while at != NONE && self.cells[at as usize].node != join.node {
                at = self.cells[at as usize].next;
            }
            // INVARIANT: what is waited for has an open cell.
            if at == NONE {
                return;
            }
            let old = self.cells[at as usize];
            let order = prepared.order(old.order);
            let done = self.with(order, old.done, join.subtask as usize);
            if !self.is_full(order, done) {
                self.replace(at, Some((old.begun, done)), guard);
                return;
            }
            self.replace(at, None, guard);
            join = self.join(join.node);
        }
    }

    /// Changes a cell's bits, or takes it out of the list; cells before it that belong to a choice point are copied.
    fn replace(&mut self, cell: u32, bits: Option<(u64, u64)>, guard: u32) {
        let mut before = Vec::new();
        let mut at = self.head;
        while at != cell && at != NONE {
            before.push(at);
            at = self.cells[at as usize].next;
        }
        let old = self.cells[cell as usize];
        let mut next = match bits {
            None => old.next,
            Some((begun, done)) => {
                let new = Cell {
                    begun,
                    done,
                    print: None,
                    ..old
                };
                self.put(cell, new, guard)
            }
        };
        while let Some(at) = before.pop() {
            let new = Cell {
                next,
                print: None,
                ..self.cells[at as usize]
            };
            next = self.put(at, new, guard);
        }
        self.head = next;
    }

    fn put(&mut self, at: u32, cell: Cell, guard: u32) -> u32 {
        if at >= guard {
            self.cells[at as usize] = cell;
            return at;
        }
        self.cells.push(cell);
        self.cells.len() as u32 - 1
    }

    /// Returns the fingerprint of all that is still to be done; `of_frame` gives that of a cell's decomposition with its
    /// variables.
    pub fn print(&mut self, prepared: &Prepared, of_frame: &dyn Fn(&Cell) -> Print) -> Print {
        let mut without = Vec::new();
        let mut at = self.head;
        let mut print = Print::default();
        while at != NONE {
            let cell = &self.cells[at as usize];
            if let Some(known) = cell.print {
                print = known;
                break;
            }
            without.push(at);
            at = cell.next;
        }
        while let Some(at) = without.pop() {
            let cell = &self.cells[at as usize];
            let order = prepared.order(cell.order);
            let mut own = of_frame(cell);
            for bits in [cell.begun, cell.done] {
                if order.n_subtasks <= 64 || self.is_counted(order) {
                    own = own.number(bits);
                } else {
                    let words = &self.store[bits as usize..bits as usize + order.n_subtasks.div_ceil(64)];
                    own = words.iter().fold(own, |own, word| own.number(*word));
                }
            }
            // Interleaved, all cells are at work, in no order.
            print = if self.interleave {
                print.with(own.print(self.join(cell.node).path))
            } else {
                own.print(print)
            };
            self.cells[at as usize].print = Some(print);
        }
        print
    }

    /// Adds to a fingerprint what ends with a node, where that is not clear from the list.
    pub fn print_of_join(&self, print: Print, node: u32) -> Print {
        if self.interleave {
            print.print(self.join(node).path)
        } else {
            print
        }
    }
}
