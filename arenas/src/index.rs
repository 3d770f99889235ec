//! Spatial index of walls for rays and contacts: a grid of cells, each with the walls that a robot
//! whose centre is in the cell can touch (first) or see (after them), nearest first.
//!
//! Everything is `f32` and read-only, so that any number of runs share one index.

use nalgebra::Point2;

use crate::arena::Arena;
use crate::segment::Segment;

/// A wall as the step loop wants it: one end, the vector to the other, and 1 / length squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct IndexedWall {
    /// x of one end, metres.
    pub px_m: f32,
    /// y of that end, metres.
    pub py_m: f32,
    /// x of the vector to the other end, metres.
    pub ex_m: f32,
    /// y of that vector, metres.
    pub ey_m: f32,
    /// 1 / (ex^2 + ey^2), 1 / square metre.
    pub inverse_length2_m2: f32,
}

impl IndexedWall {
    fn new(wall: &Segment) -> Self {
        let e = wall.b - wall.a;
        Self {
            px_m: wall.a.x as f32,
            py_m: wall.a.y as f32,
            ex_m: e.x as f32,
            ey_m: e.y as f32,
            inverse_length2_m2: (1.0 / e.norm_squared()) as f32,
        }
    }

    /// The vector from (x, y) to the nearest point of the wall, and its length squared.
    #[inline(always)]
    pub fn nearest(&self, x_m: f32, y_m: f32) -> (f32, f32, f32) {
        let (wx, wy) = (x_m - self.px_m, y_m - self.py_m);
        let t = (wx * self.ex_m + wy * self.ey_m) * self.inverse_length2_m2;
        let t = if t > 0.0 { t } else { 0.0 };
        let t = if t < 1.0 { t } else { 1.0 };
        let (dx, dy) = (t * self.ex_m - wx, t * self.ey_m - wy);
        (dx, dy, dx * dx + dy * dy)
    }
}

/// The column (or row) of a grid that a coordinate lies in; 0 for what is not a number.
///
/// `last`, the highest, must be a whole number from 0 to 2^24.
#[inline(always)]
pub fn grid_coordinate(position_m: f32, inverse_cell_m: f32, last: f32) -> usize {
    let place = position_m * inverse_cell_m;
    let place = if place > 0.0 { place } else { 0.0 };
    let place = if place < last { place } else { last };
    debug_assert!((0.0..=16_777_216.0).contains(&place));
    // SAFETY: 0 <= place <= last <= 2^24, which an i32 holds.
    let whole: i32 = unsafe { place.to_int_unchecked() };
    whole as usize
}

#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    start: u32,
    near: u32,
    all: u32,
}

/// The index of one arena for one body size and sensor reach.
#[derive(Clone, Debug)]
pub struct WallIndex {
    inverse_cell_m: f32,
    last_column: f32,
    last_row: f32,
    columns: usize,
    cells: Vec<Cell>,
    listing: Vec<u32>,
    walls: Vec<IndexedWall>,
}

/// Cells aimed at; small enough for the second-level cache.
const CELLS: f64 = 4_096.0;
const SMALLEST_CELL_M: f64 = 0.012;
const LARGEST_CELL_M: f64 = 0.1;

impl WallIndex {
    /// Indexes inner walls and boundary for robots whose centre comes within `contact_m` of a wall
    /// they touch during a step, and sees walls up to `reach_m` from its centre.
    pub fn new(arena: &Arena, contact_m: f64, reach_m: f64) -> Self {
        let (width, height) = (arena.width_m(), arena.height_m());
        let cell_m = (width * height / CELLS)
            .sqrt()
            .clamp(SMALLEST_CELL_M, LARGEST_CELL_M);
        let columns = (width / cell_m).ceil() as usize;
        let rows = (height / cell_m).ceil() as usize;
        let half_diagonal = cell_m * std::f64::consts::FRAC_1_SQRT_2 + 1e-6;
        let (near_m, far_m) = (
            contact_m + half_diagonal,
            reach_m.max(contact_m) + half_diagonal,
        );

        let segments: Vec<Segment> = arena
            .boundary()
            .iter()
            .chain(arena.walls())
            .copied()
            .collect();
        let centre = |row: usize, column: usize| {
            Point2::new((column as f64 + 0.5) * cell_m, (row as f64 + 0.5) * cell_m)
        };
        let mut found: Vec<Vec<u32>> = vec![Vec::new(); columns * rows];
        for (number, wall) in segments.iter().enumerate() {
            let span = |low: f64, high: f64, count: usize| {
                let first = ((low - far_m) / cell_m).floor().max(0.0) as usize;
                let last = ((high + far_m) / cell_m).floor().max(0.0) as usize;
                first..(last + 1).min(count)
            };
            for row in span(wall.a.y.min(wall.b.y), wall.a.y.max(wall.b.y), rows) {
                for column in span(wall.a.x.min(wall.b.x), wall.a.x.max(wall.b.x), columns) {
                    if wall.distance_squared_m2(centre(row, column)) <= far_m * far_m {
                        found[row * columns + column].push(number as u32);
                    }
                }
            }
        }
        let mut cells = Vec::with_capacity(found.len());
        let mut listing = Vec::new();
        for (place, mut list) in found.into_iter().enumerate() {
            let here = centre(place / columns, place % columns);
            let distance = |number: &u32| segments[*number as usize].distance_squared_m2(here);
            list.sort_by_cached_key(|number| (distance(number).to_bits(), *number));
            let near = list.partition_point(|number| distance(number) <= near_m * near_m);
            cells.push(Cell {
                start: listing.len() as u32,
                near: near as u32,
                all: list.len() as u32,
            });
            listing.append(&mut list);
        }
        // Walls get new numbers in the order in which cells list them: what is near each other lies
        // together, in whatever order the arena names its walls.
        let mut walls = Vec::with_capacity(segments.len());
        let mut places = vec![None; segments.len()];
        for number in &mut listing {
            let old = *number as usize;
            *number = *places[old].get_or_insert_with(|| {
                walls.push(IndexedWall::new(&segments[old]));
                walls.len() as u32 - 1
            });
        }
        Self {
            inverse_cell_m: (1.0 / cell_m) as f32,
            last_column: (columns - 1) as f32,
            last_row: (rows - 1) as f32,
            columns,
            cells,
            listing,
            walls,
        }
    }

    #[inline(always)]
    fn cell(&self, x_m: f32, y_m: f32) -> Cell {
        let column = grid_coordinate(x_m, self.inverse_cell_m, self.last_column);
        let row = grid_coordinate(y_m, self.inverse_cell_m, self.last_row);
        self.cells[row * self.columns + column]
    }

    /// Numbers of the walls that a robot near (x, y) can touch.
    #[inline(always)]
    pub fn touchable(&self, x_m: f32, y_m: f32) -> &[u32] {
        let cell = self.cell(x_m, y_m);
        &self.listing[cell.start as usize..][..cell.near as usize]
    }

    /// Numbers of the walls that a robot at (x, y) can see.
    #[inline(always)]
    pub fn visible(&self, x_m: f32, y_m: f32) -> &[u32] {
        let cell = self.cell(x_m, y_m);
        &self.listing[cell.start as usize..][..cell.all as usize]
    }

    /// A wall by its number.
    #[inline(always)]
    pub fn wall(&self, number: u32) -> &IndexedWall {
        &self.walls[number as usize]
    }

    /// Mean number of visible walls a cell, for reports on cost.
    pub fn mean_visible(&self) -> f64 {
        self.listing.len() as f64 / self.cells.len() as f64
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cells[..]) + size_of_val(&self.listing[..]) + size_of_val(&self.walls[..])
    }
}
