//! The squares of an arena as the step loop wants them: in `f32`, without divisions.

use arenas::Arena;
use arenas::axis::GridAxis;

/// Finds the square that a place is in.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    columns: u32,
    across: GridAxis,
    up: GridAxis,
}

impl Grid {
    /// The squares of an arena.
    pub fn of(arena: &Arena) -> Self {
        let [columns, rows] = arena.squares();
        let per_m = |count: u32, side_m: f64| (f64::from(count) / side_m) as f32;
        Self {
            columns,
            across: GridAxis::new(columns as usize, per_m(columns, arena.width_m())),
            up: GridAxis::new(rows as usize, per_m(rows, arena.height_m())),
        }
    }

    /// Index of the square, row by row from the lowest y.
    #[inline(always)]
    pub fn square_of(&self, x_m: f32, y_m: f32) -> u32 {
        self.up.cell(y_m) as u32 * self.columns + self.across.cell(x_m) as u32
    }
}
