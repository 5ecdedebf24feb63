//! Cells of the floor around a base: a square lattice in the frame of the pose that it starts from.
//!
//! The lattice lies along the base's heading, so that a base that moves along its heading alone can leave a tight place on it.

use super::{BasePose, Place};

/// More cells than this are not made, whatever is to be covered.
const MAX_CELLS: f64 = 4e6;

/// Cells by column i and row j; cell (0, 0) has the origin in its middle.
#[derive(Debug, Clone)]
pub struct Grid {
    origin: BasePose,
    /// Of the origin's heading.
    cos: f64,
    sin: f64,
    /// Side of a cell [m].
    pub cell: f64,
    /// Lowest column and row.
    low: [i32; 2],
    columns: i32,
    rows: i32,
}

impl Grid {
    /// Returns the cells with sides of `cell` [m] that cover all of `places` and the origin; around what would be too many, only
    /// those near the origin.
    pub fn new(origin: BasePose, cell: f64, places: &[Place]) -> Grid {
        let (sin, cos) = nalgebra::ComplexField::sin_cos(origin[2]);
        let mut grid = Grid {
            origin,
            cos,
            sin,
            cell,
            low: [0, 0],
            columns: 1,
            rows: 1,
        };
        let most = MAX_CELLS.sqrt() / 2.0 - 1.0;
        let (mut low, mut high) = ([0.0_f64; 2], [0.0_f64; 2]);
        for place in places {
            let at = grid.in_cells(*place);
            for axis in 0..2 {
                low[axis] = low[axis].min(at[axis].round().max(-most));
                high[axis] = high[axis].max(at[axis].round().min(most));
            }
        }
        grid.low = [low[0] as i32, low[1] as i32];
        grid.columns = high[0] as i32 - grid.low[0] + 1;
        grid.rows = high[1] as i32 - grid.low[1] + 1;
        grid
    }

    /// Returns the place in the lattice's own frame, in cells.
    fn in_cells(&self, [x, y]: Place) -> [f64; 2] {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        [
            (self.cos * dx + self.sin * dy) / self.cell,
            (self.cos * dy - self.sin * dx) / self.cell,
        ]
    }

    /// Returns how many cells there are.
    pub fn len(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Returns whether there are none: never, the origin has one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of the cell at (i, j).
    pub fn index(&self, [i, j]: [i32; 2]) -> Option<usize> {
        let (column, row) = (i - self.low[0], j - self.low[1]);
        let is_inside = (0..self.columns).contains(&column) && (0..self.rows).contains(&row);
        is_inside.then(|| row as usize * self.columns as usize + column as usize)
    }

    /// Returns column and row of a cell.
    pub fn position(&self, index: usize) -> [i32; 2] {
        let columns = self.columns as usize;
        [
            (index % columns) as i32 + self.low[0],
            (index / columns) as i32 + self.low[1],
        ]
    }

    /// Returns the middle of the cell.
    pub fn place(&self, [i, j]: [i32; 2]) -> Place {
        let (x, y) = (f64::from(i) * self.cell, f64::from(j) * self.cell);
        [
            self.origin[0] + self.cos * x - self.sin * y,
            self.origin[1] + self.sin * x + self.cos * y,
        ]
    }

    /// Returns column and row of the cell that holds the place.
    pub fn around(&self, place: Place) -> [i32; 2] {
        self.in_cells(place).map(|c| c.round().clamp(-1e9, 1e9) as i32)
    }

    /// Returns the heading of the lattice's x axis in W [rad].
    pub fn heading(&self) -> f64 {
        self.origin[2]
    }
}
