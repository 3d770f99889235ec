//! The squares of an arena as the step loop wants them: in `f32`, without divisions.

use arenas::Arena;
use arenas::index::grid_coordinate;

/// Finds the square that a place is in.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    columns: u32,
    /// Greatest column and row.
    last: [f32; 2],
    /// Columns and rows a metre.
    per_m: [f32; 2],
}

impl Grid {
    /// The squares of an arena.
    pub fn of(arena: &Arena) -> Self {
        let [columns, rows] = arena.squares();
        Self {
            columns,
            last: [(columns - 1) as f32, (rows - 1) as f32],
            per_m: [
                (f64::from(columns) / arena.width_m()) as f32,
                (f64::from(rows) / arena.height_m()) as f32,
            ],
        }
    }

    /// Index of the square, row by row from the lowest y.
    #[inline(always)]
    pub fn square_of(&self, x_m: f32, y_m: f32) -> u32 {
        let column = grid_coordinate(x_m, self.per_m[0], self.last[0]);
        let row = grid_coordinate(y_m, self.per_m[1], self.last[1]);
        row as u32 * self.columns + column as u32
    }
}
