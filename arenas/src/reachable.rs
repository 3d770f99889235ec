//! The squares that a disc's centre can reach from a start: the denominator of coverage.

use crate::arena::{Arena, Pose};
use crate::free_space::FreeSpace;
use crate::squares::Squares;

/// A square counts if one of this many points along each of its sides, squared, is reached.
const POINTS_PER_SIDE: u32 = 6;
/// Most meetings of lines with walls, less than a second's work.
const MOST_CROSSINGS: f64 = 8e6;

/// What a robot can reach in an arena.
#[derive(Clone, Debug, PartialEq)]
pub struct Reachable {
    /// Whether each square can be reached, row by row, row 0 the lowest y.
    pub mask: Vec<bool>,
    /// Squares that can be reached.
    pub count: u32,
}

/// Squares into which the centre of a disc of `body_radius_m` can move from `start` without
/// overlapping a wall. A square counts if one of 6 x 6 evenly spaced points in it can be reached
/// (with 100 squares that is the protocol's grid of 600 x 600), so slivers narrower than a sixth
/// of a square at a wall may not. A robot can touch such a square all the same: visits are to be
/// compared inside the mask.
///
/// Which passages are wide enough is decided by geometry and does not depend on where the points
/// lie; one exactly as wide as the body is open. If the start overlaps a wall, nothing is
/// reachable. In an arena of so many walls that their rows of points are too much work, squares
/// have fewer rows of points, or some rows of squares have them in common.
pub fn reachable(arena: &Arena, start: Pose, body_radius_m: f64) -> Reachable {
    let squares = Squares::of(arena);
    let mut mask = vec![false; squares.count()];
    let rows = SampleRows::new(arena, &squares, body_radius_m);
    let y_m = rows.with_lines([0.0, start.y_m, arena.height_m()]);
    if let Some(mut space) = FreeSpace::new(arena, body_radius_m, y_m.iter().copied())
        && let Some(gap) = space.gap_at(start.position())
    {
        let set = space.set_of(gap);
        rows.mark(&mut space, set, &squares, &mut mask);
    }
    let count = mask.iter().filter(|&&reached| reached).count() as u32;
    Reachable { mask, count }
}

/// Rows of points along which squares are sampled.
struct SampleRows {
    /// Rows of points in a row of squares ...
    per_square: u32,
    /// ... or rows of squares that have one row of points in common.
    squares_per_row: u32,
    rows_of_squares: u32,
    row_m: f64,
}

impl SampleRows {
    /// As many as the walls allow.
    fn new(arena: &Arena, squares: &Squares, radius_m: f64) -> Self {
        let row_m = squares.size_m()[1];
        let height_m: f64 = arena
            .walls()
            .iter()
            .chain(&arena.boundary())
            .map(|wall| (wall.b.y - wall.a.y).abs() + 2.0 * radius_m)
            .sum();
        let fits = |rows_per_square: f64| height_m * rows_per_square / row_m <= MOST_CROSSINGS;
        let per_square = [POINTS_PER_SIDE, 3, 2, 1];
        let per_square = per_square.into_iter().find(|&rows| fits(f64::from(rows)));
        let mut squares_per_row = 1;
        while per_square.is_none()
            && squares_per_row < squares.rows()
            && !fits(1.0 / f64::from(squares_per_row))
        {
            squares_per_row *= 2;
        }
        Self {
            per_square: per_square.unwrap_or(1),
            squares_per_row,
            rows_of_squares: squares.rows(),
            row_m,
        }
    }

    fn count(&self) -> u32 {
        self.rows_of_squares.div_ceil(self.squares_per_row) * self.per_square
    }

    /// Rows of squares that a row of points stands for.
    fn squares_of(&self, row: u32) -> std::ops::Range<u32> {
        let first = row / self.per_square * self.squares_per_row;
        first..(first + self.squares_per_row).min(self.rows_of_squares)
    }

    fn y_m(&self, row: u32) -> f64 {
        let squares = self.squares_of(row);
        let part = (f64::from(row % self.per_square) + 0.5) / f64::from(self.per_square);
        (f64::from(squares.start) + f64::from(squares.end - squares.start) * part) * self.row_m
    }

    /// Places of all rows and of some lines more, in rising order, each once.
    fn with_lines(&self, more: [f64; 3]) -> Vec<f64> {
        let mut y_m: Vec<f64> = (0..self.count()).map(|row| self.y_m(row)).collect();
        y_m.extend(more);
        y_m.sort_by(f64::total_cmp);
        y_m.dedup();
        y_m
    }

    /// Marks squares with a point in a set of gaps.
    fn mark(&self, space: &mut FreeSpace, set: u32, squares: &Squares, mask: &mut [bool]) {
        let columns = squares.columns();
        let points_per_m = f64::from(POINTS_PER_SIDE) / squares.size_m()[0];
        let last = columns * POINTS_PER_SIDE - 1;
        let mut line = 0;
        for row in 0..self.count() {
            let y_m = self.y_m(row);
            while space.y_m(line) < y_m {
                line += 1;
            }
            for gap in space.gaps_of(line, set) {
                // Casts of negative numbers give 0.
                let first = (gap.from_m * points_per_m - 0.5).ceil() as u32;
                let end = (gap.to_m * points_per_m - 0.5).floor();
                if end < f64::from(first) {
                    continue;
                }
                let end = (end as u32).min(last) / POINTS_PER_SIDE;
                let first = first / POINTS_PER_SIDE;
                for row in self.squares_of(row) {
                    let start = (row * columns) as usize;
                    mask[start + first as usize..=start + end as usize].fill(true);
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "reachable_tests.rs"]
mod tests;
