//! Spatial index of walls for rays and contacts: a grid of cells, each with the walls that a robot
//! whose centre is in the cell can touch (first) or see (after them), nearest first.
//!
//! Everything is `f32` and read-only, so that any number of runs share one index.

use nalgebra::Point2;

use crate::arena::Arena;
use crate::axis::GridAxis;
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

/// From which x to which the part of a wall goes that is within `far_m` of the line at `y_m`.
fn x_near_row(wall: &Segment, y_m: f64, far_m: f64) -> [f64; 2] {
    let along = wall.b - wall.a;
    let at = |y_m: f64| (y_m - wall.a.y) / along.y;
    let (mut from, mut to) = (0.0, 1.0);
    if along.y != 0.0 {
        // A little more, for rounding.
        let (one, other) = (at(y_m - far_m), at(y_m + far_m));
        from = (one.min(other) - 1e-6).clamp(0.0, 1.0);
        to = (one.max(other) + 1e-6).clamp(0.0, 1.0);
    }
    let (one, other) = (wall.a.x + along.x * from, wall.a.x + along.x * to);
    [one.min(other), one.max(other)]
}

/// The walls of a cell, as places in a list.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cell {
    start: u32,
    near: u32,
    all: u32,
}

/// The index of one arena for one body size and sensor reach.
#[derive(Clone, Debug)]
pub struct WallIndex {
    across: GridAxis,
    up: GridAxis,
    columns: usize,
    cells: Vec<Cell>,
    listing: Vec<u32>,
    walls: Vec<IndexedWall>,
}

/// Cells aimed at; small enough for the second-level cache.
const CELLS: f64 = 4_096.0;
const SMALLEST_CELL_M: f64 = 0.012;
const LARGEST_CELL_M: f64 = 0.1;
/// Most cells, and most walls listed in all of them, some 100 MB: beyond, cells grow.
const MOST_CELLS: f64 = 1e6;
const MOST_LISTED: f64 = 2e7;

/// Side of a cell for an arena, as small as the limits allow.
fn cell_m(arena: &Arena, reach_m: f64) -> f64 {
    let area_m2 = arena.width_m() * arena.height_m();
    let mut cell_m = (area_m2 / CELLS)
        .sqrt()
        .clamp(SMALLEST_CELL_M, LARGEST_CELL_M)
        .max((area_m2 / MOST_CELLS).sqrt());
    let walls = arena.walls();
    let listed = |cell_m: f64| -> f64 {
        // Cells about within reach, at most those along the wall times those across.
        let wide = 2.0 * reach_m / cell_m + 2.0;
        walls
            .iter()
            .map(|wall| (wall.length_m() / cell_m + wide) * wide)
            .sum()
    };
    let longest_m = arena.width_m().max(arena.height_m());
    while listed(cell_m) > MOST_LISTED && cell_m < longest_m {
        cell_m *= 2.0;
    }
    cell_m
}

impl WallIndex {
    /// Indexes inner walls and boundary for robots whose centre comes within `contact_m` of a wall
    /// they touch during a step, and sees walls up to `reach_m` from its centre.
    pub fn new(arena: &Arena, contact_m: f64, reach_m: f64) -> Self {
        let (width, height) = (arena.width_m(), arena.height_m());
        let cell_m = cell_m(arena, reach_m.max(contact_m));
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
                let [low, high] = x_near_row(wall, centre(row, 0).y, far_m);
                for column in span(low, high, columns) {
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
            across: GridAxis::new(columns, (1.0 / cell_m) as f32),
            up: GridAxis::new(rows, (1.0 / cell_m) as f32),
            columns,
            cells,
            listing,
            walls,
        }
    }

    /// What is looked at first of a robot at (x, y), to be asked for in time.
    #[inline(always)]
    pub fn cell(&self, x_m: f32, y_m: f32) -> &Cell {
        &self.cells[self.up.cell(y_m) * self.columns + self.across.cell(x_m)]
    }

    /// What is looked at next.
    #[inline(always)]
    pub fn list(&self, x_m: f32, y_m: f32) -> Option<&u32> {
        self.listing.get(self.cell(x_m, y_m).start as usize)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::{ArenaFormat, GenerateFormat, GeneratorKind};

    fn index(format: ArenaFormat) -> (Arena, WallIndex) {
        let arena = format.build().unwrap();
        let index = WallIndex::new(&arena, 0.04, 0.08);
        (arena, index)
    }

    #[test]
    fn every_wall_within_reach_is_listed() {
        let (arena, index) = index(ArenaFormat {
            width_m: Some(2.0),
            height_m: Some(1.5),
            generate: Some(GenerateFormat::new(GeneratorKind::RandomObstacles, 3)),
            ..ArenaFormat::default()
        });
        for place in 0..3_000 {
            let (x, y) = (f64::from(place % 60) / 30.0, f64::from(place / 60) / 34.0);
            let point = Point2::new(x, y);
            let near = |within_m: f64| {
                let boundary = arena.boundary();
                let walls = arena.walls().iter().chain(&boundary);
                walls
                    .copied()
                    .filter(|wall| wall.distance_squared_m2(point) < within_m * within_m)
                    .map(|wall| IndexedWall::new(&wall))
                    .collect::<Vec<_>>()
            };
            let [x, y] = [x as f32, y as f32];
            for (numbers, within_m) in [(index.touchable(x, y), 0.04), (index.visible(x, y), 0.08)]
            {
                let listed: Vec<_> = numbers.iter().map(|&number| *index.wall(number)).collect();
                assert!(
                    near(within_m).iter().all(|wall| listed.contains(wall)),
                    "{point}"
                );
            }
        }
    }

    #[test]
    fn the_largest_arenas_take_bounded_memory() {
        let largest = |walls_m: Vec<[f64; 4]>| {
            let (_, index) = index(ArenaFormat {
                name: Some("large".to_owned()),
                width_m: Some(1_000.0),
                height_m: Some(1_000.0),
                walls_m: Some(walls_m),
                starts: Some(vec![crate::Pose {
                    x_m: 1.0,
                    y_m: 1.0,
                    heading_rad: 0.0,
                }]),
                ..ArenaFormat::default()
            });
            index.bytes()
        };
        assert!(largest(Vec::new()) < 20_000_000);
        let diagonals = (0..20_000).map(|wall| [0.0, 0.05 * f64::from(wall), 1_000.0, 1_000.0]);
        let began = std::time::Instant::now();
        assert!(largest(diagonals.collect()) < 200_000_000);
        assert!(
            began.elapsed().as_secs_f64() < 20.0,
            "{:?}",
            began.elapsed()
        );
    }
}
