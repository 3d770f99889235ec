//! A grid of cells and the passages between neighbours: what mazes, rooms and corridors share.

use super::random::Random;

/// Passages of a grid, cells numbered row by row from the lower left.
pub(super) struct Cells {
    pub columns: usize,
    pub rows: usize,
    /// Whether each cell is open to its right, and to its upper neighbour.
    east: Vec<bool>,
    north: Vec<bool>,
}

impl Cells {
    /// Every cell joined to every other in exactly one way, by a depth-first walk from the lower
    /// left: long winding passages with few branches.
    pub fn spanning_tree(columns: usize, rows: usize, random: &mut Random) -> Self {
        let mut cells = Self {
            columns,
            rows,
            east: vec![false; columns * rows],
            north: vec![false; columns * rows],
        };
        let mut seen = vec![false; columns * rows];
        seen[0] = true;
        let mut path = vec![0];
        while let Some(&cell) = path.last() {
            let fresh: Vec<usize> = cells.neighbours(cell).filter(|&next| !seen[next]).collect();
            if fresh.is_empty() {
                path.pop();
            } else {
                let next = fresh[random.below(fresh.len())];
                seen[next] = true;
                cells.open(cell, next);
                path.push(next);
            }
        }
        cells
    }

    /// Opens each dead end to one more neighbour with this probability.
    pub fn open_dead_ends(&mut self, probability: f64, random: &mut Random) {
        for cell in 0..self.columns * self.rows {
            let closed: Vec<usize> = self
                .neighbours(cell)
                .filter(|&next| !self.is_open(cell, next))
                .collect();
            let dead_end = self.neighbours(cell).count() == closed.len() + 1;
            if dead_end && !closed.is_empty() && random.chance(probability) {
                self.open(cell, closed[random.below(closed.len())]);
            }
        }
    }

    /// Opens each closed passage with this probability.
    pub fn open_more(&mut self, probability: f64, random: &mut Random) {
        for cell in 0..self.columns * self.rows {
            if self.has_east(cell) && !self.east[cell] {
                self.east[cell] = random.chance(probability);
            }
            if self.has_north(cell) && !self.north[cell] {
                self.north[cell] = random.chance(probability);
            }
        }
    }

    /// Whether there is a cell to the right.
    pub fn has_east(&self, cell: usize) -> bool {
        cell % self.columns + 1 < self.columns
    }

    /// Whether there is a cell above.
    pub fn has_north(&self, cell: usize) -> bool {
        cell / self.columns + 1 < self.rows
    }

    /// Whether the passage to the right is open.
    pub fn east(&self, cell: usize) -> bool {
        self.east[cell]
    }

    /// Whether the passage to the cell above is open.
    pub fn north(&self, cell: usize) -> bool {
        self.north[cell]
    }

    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, row) = (cell % self.columns, cell / self.columns);
        let east = self.has_east(cell).then_some(cell + 1);
        let north = self.has_north(cell).then_some(cell + self.columns);
        let west = (column > 0).then(|| cell - 1);
        let south = (row > 0).then(|| cell - self.columns);
        [east, north, west, south].into_iter().flatten()
    }

    fn is_open(&self, one: usize, other: usize) -> bool {
        let lower = one.min(other);
        if one.abs_diff(other) == self.columns {
            self.north[lower]
        } else {
            self.east[lower]
        }
    }

    fn open(&mut self, one: usize, other: usize) {
        let lower = one.min(other);
        // In a grid one column wide, the neighbour at distance one is the one above.
        if one.abs_diff(other) == self.columns {
            self.north[lower] = true;
        } else {
            self.east[lower] = true;
        }
    }
}
