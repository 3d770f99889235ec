//! The squares that a disc's centre can reach from a start: the denominator of coverage.

use nalgebra::Point2;

use crate::arena::{Arena, Pose};
use crate::free_space::FreeSpace;
use crate::squares::Squares;

/// A square counts if one of this many points along each of its sides, squared, is reached.
const POINTS_PER_SIDE: u32 = 6;
/// Most meetings of lines with walls, less than a second's work.
const MOST_CROSSINGS: f64 = 8e6;
/// Most starts that have a line of their own.
const MOST_START_LINES: usize = 1_000;

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
    reachable_from(arena, &[start.position()], body_radius_m)
}

/// As [`reachable`], into which one disc or another can move from several starts.
pub fn reachable_from(arena: &Arena, starts: &[Point2<f64>], body_radius_m: f64) -> Reachable {
    let squares = Squares::of(arena);
    let mut mask = vec![false; squares.count()];
    let rows = SampleRows::new(arena, &squares, body_radius_m);
    // A line through each start, as far as that is bounded work: else the line nearest to it.
    let walls = arena.walls().len() + arena.boundary().len();
    let exact = MOST_START_LINES.min(MOST_CROSSINGS as usize / walls);
    let through = starts.iter().take(exact.max(1)).map(|start| start.y);
    let y_m = rows.with_lines(through.chain([0.0, arena.height_m()]));
    if let Some(mut space) = FreeSpace::new(arena, body_radius_m, y_m.iter().copied()) {
        let reached = space.reached_from(starts.iter().copied());
        rows.mark(&space, &reached, &squares, &mut mask);
    }
    let count = mask.iter().filter(|&&reached| reached).count() as u32;
    Reachable { mask, count }
}

/// Where the centre of a disc can come to, for asking about many places.
#[derive(Debug)]
pub struct WithinReach {
    space: Option<FreeSpace>,
    reached: Vec<bool>,
}

impl WithinReach {
    /// Where a disc of `body_radius_m` can come to from one of the arena's start poses, for places
    /// that have at least `room_m` more than the radius around them.
    pub fn new(arena: &Arena, body_radius_m: f64, room_m: f64) -> Self {
        // No place is farther from a line than the room around it, unless that is too much work.
        let height_m = arena.height_m();
        let crossings = crossings_of_a_metre(arena, body_radius_m) + height_m;
        let spacing_m = (2.0 * room_m).max(crossings / MOST_CROSSINGS);
        let lines = (height_m / spacing_m).ceil();
        let regular = (0..=lines as u32).map(|line| height_m * f64::from(line) / lines);
        let starts = || arena.starts().iter().take(MOST_START_LINES);
        let mut y_m: Vec<f64> = regular.chain(starts().map(|start| start.y_m)).collect();
        y_m.sort_by(f64::total_cmp);
        y_m.dedup();
        let mut space = FreeSpace::new(arena, body_radius_m, y_m.into_iter());
        let reached = space.as_mut().map_or_else(Vec::new, |space| {
            let reached = space.reached_from(arena.starts().iter().map(Pose::position));
            space.forget_sets();
            reached
        });
        Self { space, reached }
    }

    /// Whether a disc can come to this place, which is clear of walls.
    pub fn holds(&self, x_m: f64, y_m: f64) -> bool {
        let gap = self
            .space
            .as_ref()
            .and_then(|space| space.gap_at(Point2::new(x_m, y_m)));
        gap.is_some_and(|gap| self.reached[gap])
    }
}

/// Meetings of walls with lines, if there were one a metre.
fn crossings_of_a_metre(arena: &Arena, radius_m: f64) -> f64 {
    let boundary = arena.boundary();
    let walls = arena.walls().iter().chain(&boundary);
    walls
        .map(|wall| (wall.b.y - wall.a.y).abs() + 2.0 * radius_m)
        .sum()
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
        let crossings = crossings_of_a_metre(arena, radius_m);
        let fits = |rows_per_square: f64| crossings * rows_per_square / row_m <= MOST_CROSSINGS;
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
    fn with_lines(&self, more: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut y_m: Vec<f64> = (0..self.count()).map(|row| self.y_m(row)).collect();
        y_m.extend(more);
        y_m.sort_by(f64::total_cmp);
        y_m.dedup();
        y_m
    }

    /// Marks squares with a point in a gap that is reached.
    fn mark(&self, space: &FreeSpace, reached: &[bool], squares: &Squares, mask: &mut [bool]) {
        let columns = squares.columns();
        let points_per_m = f64::from(POINTS_PER_SIDE) / squares.size_m()[0];
        let last = columns * POINTS_PER_SIDE - 1;
        let mut line = 0;
        for row in 0..self.count() {
            let y_m = self.y_m(row);
            while space.y_m(line) < y_m {
                line += 1;
            }
            for gap in space.reached_on(line, reached) {
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
