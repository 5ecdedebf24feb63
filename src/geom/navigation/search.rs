//! A path over the floor: any-angle where there is room, among headings where there is not.
//!
//! Theta* (Daniel, Nash, Koenig, Felner, *Theta\*: Any-Angle Path Planning on Grids*, JAIR 39, 2010, doi:10.1613/jair.2994) on the cells of a
//! [`Grid`]. Differs from the paper: a metre has a cost that depends on the place, so a line of sight is taken where its integral is
//! the cheaper one; a cell in which the agent can't turn freely has a node for each of eight headings, that the drive moves among, and no
//! lines of sight; weighted A* where any path will do (`greed`). Tight moves are looked at finely only along a path that was found, and the
//! search goes on without those that were not free.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::f64::consts::FRAC_PI_4;

use super::grid::Grid;
use super::path::{self, Way};
use super::{BasePose, Drive, Floor, Place, apart, wrapped};

/// Budgets and taste. No `Default`: the caller knows how good a path has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    pub drive: Drive,
    /// Nodes looked at before a search gives up.
    pub max_nodes: usize,
    /// How much more the way that is left counts than the way that was gone; 1 finds a cheapest path of the grid (Pohl 1970,
    /// doi:10.1016/0004-3702(70)90007-X).
    pub greed: f64,
}

/// Where the base could end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    pub place: Place,
    /// Column and row.
    pub cell: [i32; 2],
    /// `None` where every heading is free.
    pub heading: Option<f64>,
    /// Of the way there.
    pub cost: f64,
}

/// Where to go.
pub trait Goal {
    /// Returns how many metres are left at least.
    fn metres_left(&self, place: Place) -> f64;
    /// Returns the heading to end with, if this is where to; within half a lattice turn of `at.heading`, if it has one.
    fn accepts(&mut self, at: &Arrival) -> Option<f64>;
    /// Hears that the way to what it accepted last was not free, so that it may be accepted again by another one.
    fn take_back(&mut self) {}
    /// Returns whether nothing will be accepted any more.
    fn is_over(&self) -> bool;
}

/// Why there is no path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPath {
    /// Everything that can be reached was looked at, or the goal gave up.
    Exhausted { looked: usize },
    /// The budget ended it.
    Budget { looked: usize },
}

/// A path.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Free all along, with the margin of the floor.
    pub ways: Vec<Way>,
    pub looked: usize,
}

/// Half the number of headings of a tight cell, and all of them.
const HALF: u8 = 4;
const HEADINGS: u8 = 8;
/// Stands for every heading.
const ANY: u8 = 8;
const DIRECTIONS: [[i32; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
/// What a turn by 45 degrees costs in a tight place, in metres; and how much more a metre backward is.
const TURN: f64 = 0.05;
const BACKWARD: f64 = 0.5;
/// Poses looked at between two nodes while searching: of a move, of a turn.
const BETWEEN: [u32; 2] = [2, 4];
/// A line of sight has so many cells at most: what is longer gains nothing.
const LONGEST: f64 = 80.0;
/// A line of sight may be dearer than the last step by this share of it: costs are sampled.
const SAME: f64 = 0.02;
/// Searches that go on after a move that was not free.
const MAX_REPAIRS: usize = 40;

/// A place and heading that was reached.
#[derive(Debug, Clone, Copy)]
struct Node {
    cell: u32,
    heading: u8,
    parent: u32,
    cost: f64,
    is_closed: bool,
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Unknown,
    Roomy,
    Tight,
}

/// What is known of a heading in a tight cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Free {
    Unknown,
    Yes,
    No,
}

/// A move between two headings of cells.
type Move = (u32, u8, u32, u8);

struct Search<'a> {
    grid: &'a Grid,
    floor: &'a mut dyn Floor,
    settings: Settings,
    kinds: Vec<Kind>,
    /// By cell; NaN where it was not asked.
    costs: Vec<f64>,
    /// By cell and heading.
    free: Vec<Free>,
    blocked: BTreeSet<Move>,
    /// Where a last turn was not free: cell and heading.
    refused: BTreeSet<(u32, u8)>,
    nodes: Vec<Node>,
    /// By cell and heading, one more than the node's position; a roomy cell has its only node at heading 0.
    by_cell: Vec<u32>,
    looked: usize,
}

/// Finds a path from the grid's origin to the goal.
///
/// # Errors
///
/// Says whether everything was looked at.
pub fn search(grid: &Grid, floor: &mut dyn Floor, goal: &mut dyn Goal, settings: Settings) -> Result<Found, NoPath> {
    let n = grid.len();
    let mut search = Search {
        grid,
        floor,
        settings,
        kinds: vec![Kind::Unknown; n],
        costs: vec![f64::NAN; n],
        free: vec![Free::Unknown; n * usize::from(HEADINGS)],
        blocked: BTreeSet::new(),
        refused: BTreeSet::new(),
        nodes: Vec::new(),
        by_cell: vec![0; n * usize::from(HEADINGS)],
        looked: 0,
    };
    for _ in 0..MAX_REPAIRS {
        let (end, heading) = search.run(goal)?;
        match search.confirm(end, heading) {
            Ok(ways) => {
                return Ok(Found {
                    ways,
                    looked: search.looked,
                });
            }
            Err(Wrong::Move(a)) => {
                search.blocked.insert(a);
                goal.take_back();
            }
            Err(Wrong::Arrival(a)) => {
                search.refused.insert(a);
            }
        }
    }
    Err(NoPath::Budget { looked: search.looked })
}

/// What was not free when it was looked at finely.
enum Wrong {
    Move(Move),
    Arrival((u32, u8)),
}

impl Search<'_> {
    fn kind(&mut self, cell: usize) -> Kind {
        if self.kinds[cell] == Kind::Unknown {
            let place = self.grid.place(self.grid.position(cell));
            // Half a diagonal, and what a line can pass beside the samples of `line`.
            let spare = self.grid.cell * (std::f64::consts::FRAC_1_SQRT_2 + 0.25);
            let is_roomy = self.floor.is_roomy(place, spare);
            self.kinds[cell] = if is_roomy { Kind::Roomy } else { Kind::Tight };
        }
        self.kinds[cell]
    }

    fn cost(&mut self, cell: usize) -> f64 {
        if self.costs[cell].is_nan() {
            let place = self.grid.place(self.grid.position(cell));
            // A cost that is no number costs the least.
            self.costs[cell] = self.floor.cost(place).max(self.floor.least_cost());
        }
        self.costs[cell]
    }

    fn heading(&self, heading: u8) -> f64 {
        wrapped(self.grid.heading() + f64::from(heading) * FRAC_PI_4)
    }

    fn pose(&self, cell: usize, heading: u8) -> BasePose {
        let [x, y] = self.grid.place(self.grid.position(cell));
        [x, y, self.heading(heading)]
    }

    fn is_free(&mut self, cell: usize, heading: u8) -> bool {
        let slot = cell * usize::from(HEADINGS) + usize::from(heading);
        if self.free[slot] == Free::Unknown {
            let pose = self.pose(cell, heading);
            self.free[slot] = if self.floor.is_free(&pose) { Free::Yes } else { Free::No };
        }
        self.free[slot] == Free::Yes
    }

    fn is_free_between(&mut self, a: BasePose, b: BasePose, parts: u32) -> bool {
        (1..parts).all(|k| {
            let at = path::between(&a, &b, f64::from(k) / f64::from(parts));
            self.floor.is_free(&at)
        })
    }

    /// Adds a way to a node, if it is better than the one known.
    fn reach(&mut self, cell: usize, heading: u8, parent: u32, cost: f64) -> Option<u32> {
        let slot = cell * usize::from(HEADINGS) + usize::from(heading % HEADINGS);
        match self.by_cell[slot] {
            0 => {
                self.nodes.push(Node {
                    cell: cell as u32,
                    heading,
                    parent,
                    cost,
                    is_closed: false,
                });
                self.by_cell[slot] = self.nodes.len() as u32;
                Some(self.by_cell[slot] - 1)
            }
            known => {
                let node = &mut self.nodes[known as usize - 1];
                if node.is_closed || node.cost <= cost {
                    return None;
                }
                (node.parent, node.cost) = (parent, cost);
                Some(known - 1)
            }
        }
    }

    /// Returns the cost of a straight line between the middles of two roomy cells; `None` where a cell on it is not roomy, or it is too
    /// long.
    fn line(&mut self, from: usize, to: usize) -> Option<f64> {
        let (a, b) = (self.grid.position(from), self.grid.position(to));
        let (di, dj) = (f64::from(b[0] - a[0]), f64::from(b[1] - a[1]));
        let cells = (di * di + dj * dj).sqrt();
        if cells > LONGEST {
            return None;
        }
        // Samples half a cell apart, in the middle of their parts of the line.
        let n = (2.0 * cells).ceil().max(1.0) as u32;
        let mut sum = 0.0;
        for k in 0..n {
            let t = (f64::from(k) + 0.5) / f64::from(n);
            let at = [
                (f64::from(a[0]) + t * di).round() as i32,
                (f64::from(a[1]) + t * dj).round() as i32,
            ];
            let cell = self.grid.index(at)?;
            if self.kind(cell) != Kind::Roomy {
                return None;
            }
            sum += self.cost(cell);
        }
        Some(sum / f64::from(n) * cells * self.grid.cell)
    }

    /// Searches until the goal accepts; returns the node and the heading to end with.
    fn run(&mut self, goal: &mut dyn Goal) -> Result<(u32, f64), NoPath> {
        self.nodes.clear();
        self.by_cell.fill(0);
        let Some(start) = self.grid.index([0, 0]) else {
            return Err(NoPath::Exhausted { looked: self.looked });
        };
        let heading = if self.kind(start) == Kind::Roomy { ANY } else { 0 };
        let mut open = BinaryHeap::new();
        self.reach(start, heading, 0, 0.0);
        open.push(Reverse((0_i64, 0_u32)));
        let mut fresh = Vec::new();
        while let Some(Reverse((_, id))) = open.pop() {
            let node = self.nodes[id as usize];
            if node.is_closed {
                continue;
            }
            self.nodes[id as usize].is_closed = true;
            self.looked += 1;
            if self.looked > self.settings.max_nodes {
                return Err(NoPath::Budget { looked: self.looked });
            }
            let cell = self.grid.position(node.cell as usize);
            let arrival = Arrival {
                place: self.grid.place(cell),
                cell,
                heading: (node.heading != ANY).then(|| self.heading(node.heading)),
                cost: node.cost,
            };
            if !self.refused.contains(&(node.cell, node.heading))
                && let Some(heading) = goal.accepts(&arrival)
            {
                return Ok((id, heading));
            }
            if goal.is_over() {
                break;
            }
            self.expand(id, &mut fresh);
            for id in fresh.drain(..) {
                let node = self.nodes[id as usize];
                let place = self.grid.place(self.grid.position(node.cell as usize));
                let left = goal.metres_left(place) * self.floor.least_cost();
                // Millionths, so that equal costs are equal and the order is total.
                let rank = ((node.cost + self.settings.greed * left) * 1e6).round() as i64;
                open.push(Reverse((rank, id)));
            }
        }
        Err(NoPath::Exhausted { looked: self.looked })
    }

    /// Puts the nodes that a node leads to, and that this made better, into `fresh`.
    fn expand(&mut self, id: u32, fresh: &mut Vec<u32>) {
        let node = self.nodes[id as usize];
        let from = node.cell as usize;
        let [i, j] = self.grid.position(from);
        for (k, [di, dj]) in (0_u8..).zip(DIRECTIONS) {
            let Some(to) = self.grid.index([i + di, j + dj]) else {
                continue;
            };
            let metres = self.grid.cell * f64::from(di * di + dj * dj).sqrt();
            let step = metres * 0.5 * (self.cost(from) + self.cost(to));
            if self.kind(to) == Kind::Roomy {
                if node.heading == ANY {
                    fresh.extend(self.roomy_step(id, to, step));
                } else if self.can_move(node.heading, k) {
                    fresh.extend(self.tight_step(id, to, node.heading, ANY, k, step));
                }
            } else {
                for heading in 0..HEADINGS {
                    let is_same = node.heading == ANY || node.heading == heading;
                    if is_same && self.can_move(heading, k) && self.is_free(to, heading) {
                        fresh.extend(self.tight_step(id, to, heading, heading, k, step));
                    }
                }
            }
        }
        if node.heading != ANY {
            for heading in [(node.heading + 1) % HEADINGS, (node.heading + HEADINGS - 1) % HEADINGS] {
                let cost = node.cost + TURN * self.cost(from);
                if self.is_free(from, heading) && !self.is_better_known(from, heading, cost) {
                    let step = (node.cell, node.heading, node.cell, heading);
                    let a = self.pose(from, node.heading);
                    let b = path::turned(&a, self.heading(heading));
                    if !self.blocked.contains(&step) && self.is_free_between(a, b, BETWEEN[1]) {
                        fresh.extend(self.reach(from, heading, id, cost));
                    }
                }
            }
        }
    }

    /// Says whether a base with that heading can move in that direction.
    fn can_move(&self, heading: u8, direction: u8) -> bool {
        match self.settings.drive {
            Drive::Holonomic => true,
            Drive::Differential => heading % HALF == direction % HALF,
        }
    }

    fn is_better_known(&self, cell: usize, heading: u8, cost: f64) -> bool {
        match self.by_cell[cell * usize::from(HEADINGS) + usize::from(heading % HEADINGS)] {
            0 => false,
            known => {
                let node = &self.nodes[known as usize - 1];
                node.is_closed || node.cost <= cost
            }
        }
    }

    /// From one roomy cell to the next: from the parent by line of sight, if that is cheaper.
    fn roomy_step(&mut self, id: u32, to: usize, step: f64) -> Option<u32> {
        let node = self.nodes[id as usize];
        let by_step = node.cost + step;
        let parent = self.nodes[node.parent as usize];
        if node.parent != id && parent.heading == ANY {
            let (a, b) = (self.grid.position(parent.cell as usize), self.grid.position(to));
            let metres = apart(a.map(f64::from), b.map(f64::from)) * self.grid.cell;
            let at_least = parent.cost + metres * self.floor.least_cost();
            if self.is_better_known(to, ANY, at_least.min(by_step)) {
                return None;
            }
            if at_least < by_step
                && let Some(line) = self.line(parent.cell as usize, to)
                && parent.cost + line <= by_step + SAME * step
            {
                return self.reach(to, ANY, node.parent, parent.cost + line);
            }
        }
        self.reach(to, ANY, id, by_step)
    }

    /// From or to a cell that is not roomy, keeping the heading.
    fn tight_step(&mut self, id: u32, to: usize, heading: u8, end: u8, direction: u8, step: f64) -> Option<u32> {
        let node = self.nodes[id as usize];
        let backward = match self.settings.drive {
            Drive::Differential if heading != direction => BACKWARD,
            Drive::Differential | Drive::Holonomic => 0.0,
        };
        let cost = node.cost + step * (1.0 + backward);
        if self.is_better_known(to, end, cost) || self.blocked.contains(&(node.cell, node.heading, to as u32, end)) {
            return None;
        }
        let (a, b) = (self.pose(node.cell as usize, heading), self.pose(to, heading));
        if !self.is_free_between(a, b, BETWEEN[0]) {
            return None;
        }
        self.reach(to, end, id, cost)
    }

    /// Returns the path to a node with a last turn to `heading`, looked at finely; or the move that is not free.
    fn confirm(&mut self, end: u32, heading: f64) -> Result<Vec<Way>, Wrong> {
        let mut ids = vec![end];
        let mut id = end;
        while id != 0 {
            id = self.nodes[id as usize].parent;
            ids.push(id);
        }
        ids.reverse();
        let nodes: Vec<Node> = ids.iter().map(|id| self.nodes[*id as usize]).collect();
        let stops: Vec<path::Stop> = nodes
            .iter()
            .map(|n| path::Stop {
                place: self.grid.place(self.grid.position(n.cell as usize)),
                heading: (n.heading != ANY).then(|| self.heading(n.heading)),
            })
            .collect();
        let start = self.pose(nodes[0].cell as usize, 0);
        let ways = path::ways(&stops, start[2], heading, self.settings.drive);
        for way in &ways {
            if way.is_roomy || path::is_free(self.floor, &way.from, &way.to) {
                continue;
            }
            let (a, b) = (nodes[way.stop], nodes.get(way.stop + 1));
            return Err(match b {
                Some(b) => Wrong::Move((a.cell, a.heading, b.cell, b.heading)),
                None => Wrong::Arrival((a.cell, a.heading)),
            });
        }
        Ok(ways)
    }
}
