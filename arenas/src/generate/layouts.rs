//! Mazes, rooms and corridors: walls around the passages of a grid of cells.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::axis_walls::AxisWalls;
use super::cells::Cells;
use super::generated::Generated;
use super::random::Random;
use crate::arena::Pose;
use crate::error::ArenaError;

/// Most cells of one arena.
const MAX_CELLS: f64 = 250_000.0;
/// What must remain of a room's wall beside its gate, and of a block between corridors, metres.
const LEAST_WALL_M: f64 = 1e-3;

/// Cells are corridors: thin walls wherever two cells are not joined.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Maze {
    pub cell_m: f64,
    pub braid: f64,
}

/// Cells are rooms: two joined rooms have a gate at a random place of their common wall.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rooms {
    pub room_m: f64,
    pub gate_m: f64,
    pub loops: f64,
}

/// Cells are crossings: corridors join them, what is between is solid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Corridors {
    pub cell_m: f64,
    pub corridor_m: f64,
    pub loops: f64,
}

impl Maze {
    pub fn check(&self, size_m: [f64; 2]) -> Vec<ArenaError> {
        check_cells("cell_m", self.cell_m, size_m)
    }

    pub fn generate(&self, size_m: [f64; 2], random: &mut Random) -> Generated {
        let grid = Grid::new(size_m, self.cell_m);
        let mut cells = Cells::spanning_tree(grid.columns, grid.rows, random);
        cells.open_dead_ends(self.braid, random);
        let mut walls = AxisWalls::default();
        for cell in 0..grid.columns * grid.rows {
            if cells.has_east(cell) && !cells.east(cell) {
                walls.vertical(grid.right(cell), grid.rows_of(cell));
            }
            if cells.has_north(cell) && !cells.north(cell) {
                walls.horizontal(grid.top(cell), grid.columns_of(cell));
            }
        }
        Generated {
            walls: walls.merged(),
            start: grid.start(&cells),
        }
    }
}

impl Rooms {
    pub fn check(&self, size_m: [f64; 2]) -> Vec<ArenaError> {
        let errors = check_cells("room_m", self.room_m, size_m);
        if !errors.is_empty() {
            return errors;
        }
        let widest_m = Grid::new(size_m, self.room_m).least_side_m() - LEAST_WALL_M;
        check_at_most("gate_m", self.gate_m, widest_m)
    }

    pub fn generate(&self, size_m: [f64; 2], random: &mut Random) -> Generated {
        let grid = Grid::new(size_m, self.room_m);
        let mut cells = Cells::spanning_tree(grid.columns, grid.rows, random);
        cells.open_more(self.loops, random);
        let mut gate = |[from_m, to_m]: [f64; 2]| {
            let opens_m = from_m + (to_m - from_m - self.gate_m) * random.unit();
            [[from_m, opens_m], [opens_m + self.gate_m, to_m]]
        };
        let mut walls = AxisWalls::default();
        for cell in 0..grid.columns * grid.rows {
            let (across, along) = (grid.right(cell), grid.rows_of(cell));
            if cells.east(cell) {
                gate(along)
                    .into_iter()
                    .for_each(|piece| walls.vertical(across, piece));
            } else if cells.has_east(cell) {
                walls.vertical(across, along);
            }
            let (across, along) = (grid.top(cell), grid.columns_of(cell));
            if cells.north(cell) {
                gate(along)
                    .into_iter()
                    .for_each(|piece| walls.horizontal(across, piece));
            } else if cells.has_north(cell) {
                walls.horizontal(across, along);
            }
        }
        let start = Pose {
            heading_rad: FRAC_PI_4,
            ..grid.start(&cells)
        };
        Generated {
            walls: walls.merged(),
            start,
        }
    }
}

impl Corridors {
    pub fn check(&self, size_m: [f64; 2]) -> Vec<ArenaError> {
        let errors = check_cells("cell_m", self.cell_m, size_m);
        if !errors.is_empty() {
            return errors;
        }
        let widest_m = Grid::new(size_m, self.cell_m).least_side_m() - LEAST_WALL_M;
        check_at_most("corridor_m", self.corridor_m, widest_m)
    }

    pub fn generate(&self, size_m: [f64; 2], random: &mut Random) -> Generated {
        let grid = Grid::new(size_m, self.cell_m);
        let mut cells = Cells::spanning_tree(grid.columns, grid.rows, random);
        cells.open_more(self.loops, random);
        let half_m = 0.5 * self.corridor_m;
        let mut walls = AxisWalls::default();
        for cell in 0..grid.columns * grid.rows {
            let [x, y] = grid.centre(cell);
            let [from_x, to_x] = [x - half_m, x + half_m];
            let [from_y, to_y] = [y - half_m, y + half_m];
            if cells.east(cell) {
                let [next_x, _] = grid.centre(cell + 1);
                walls.horizontal(from_y, [to_x, next_x - half_m]);
                walls.horizontal(to_y, [to_x, next_x - half_m]);
            } else {
                walls.vertical(to_x, [from_y, to_y]);
            }
            if cells.north(cell) {
                let [_, next_y] = grid.centre(cell + grid.columns);
                walls.vertical(from_x, [to_y, next_y - half_m]);
                walls.vertical(to_x, [to_y, next_y - half_m]);
            } else {
                walls.horizontal(to_y, [from_x, to_x]);
            }
            if cell % grid.columns == 0 || !cells.east(cell - 1) {
                walls.vertical(from_x, [from_y, to_y]);
            }
            if cell < grid.columns || !cells.north(cell - grid.columns) {
                walls.horizontal(from_y, [from_x, to_x]);
            }
        }
        Generated {
            walls: walls.merged(),
            start: grid.start(&cells),
        }
    }
}

/// Where the cells lie: as many of about the wanted side as fill the arena.
struct Grid {
    columns: usize,
    rows: usize,
    size_m: [f64; 2],
}

impl Grid {
    fn new(size_m: [f64; 2], wanted_m: f64) -> Self {
        let [columns, rows] = size_m.map(|side_m| (side_m / wanted_m).round().max(1.0) as usize);
        Self {
            columns,
            rows,
            size_m,
        }
    }

    /// Place of the line at the left of a column, or right of the last.
    fn x(&self, column: usize) -> f64 {
        self.size_m[0] * column as f64 / self.columns as f64
    }

    fn y(&self, row: usize) -> f64 {
        self.size_m[1] * row as f64 / self.rows as f64
    }

    fn right(&self, cell: usize) -> f64 {
        self.x(cell % self.columns + 1)
    }

    fn top(&self, cell: usize) -> f64 {
        self.y(cell / self.columns + 1)
    }

    fn columns_of(&self, cell: usize) -> [f64; 2] {
        [self.x(cell % self.columns), self.right(cell)]
    }

    fn rows_of(&self, cell: usize) -> [f64; 2] {
        [self.y(cell / self.columns), self.top(cell)]
    }

    fn centre(&self, cell: usize) -> [f64; 2] {
        [self.columns_of(cell), self.rows_of(cell)].map(|[from, to]| 0.5 * (from + to))
    }

    fn least_side_m(&self) -> f64 {
        f64::min(
            self.size_m[0] / self.columns as f64,
            self.size_m[1] / self.rows as f64,
        )
    }

    /// The lower left cell, facing an open side.
    fn start(&self, cells: &Cells) -> Pose {
        let [x_m, y_m] = self.centre(0);
        let heading_rad = if cells.east(0) { 0.0 } else { FRAC_PI_2 };
        Pose {
            x_m,
            y_m,
            heading_rad,
        }
    }
}

fn check_cells(name: &str, cell_m: f64, [width_m, height_m]: [f64; 2]) -> Vec<ArenaError> {
    let least_m = (width_m * height_m / MAX_CELLS).sqrt();
    let most_m = width_m.min(height_m);
    let in_range = (least_m..=most_m).contains(&cell_m);
    let error = || {
        ArenaError::new(
            format!("/generate/{name}"),
            format!("{cell_m} m does not suit an arena of {width_m} m x {height_m} m"),
            format!("{least_m:.4} to {most_m} (at most {MAX_CELLS} cells, at least one)"),
        )
    };
    if in_range { Vec::new() } else { vec![error()] }
}

fn check_at_most(name: &str, value_m: f64, most_m: f64) -> Vec<ArenaError> {
    if value_m <= most_m {
        return Vec::new();
    }
    vec![ArenaError::new(
        format!("/generate/{name}"),
        format!("{value_m} m leaves no wall"),
        format!("at most {most_m:.4}"),
    )]
}
