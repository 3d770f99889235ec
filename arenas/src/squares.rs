//! The grid of equal squares over an arena in which visits are counted.

use nalgebra::Point2;

use crate::arena::Arena;

/// `columns` x `rows` equal squares (rectangles, if the arena's sides are not in that proportion)
/// over a rectangle. A square is named by its index, row by row from the lowest y, each row from the
/// lowest x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squares {
    columns: u32,
    rows: u32,
    width_m: f64,
    height_m: f64,
    columns_per_m: f64,
    rows_per_m: f64,
}

impl Squares {
    /// The grid of `arena`.
    pub fn of(arena: &Arena) -> Self {
        let [columns, rows] = arena.squares();
        Self {
            columns,
            rows,
            width_m: arena.width_m(),
            height_m: arena.height_m(),
            columns_per_m: f64::from(columns) / arena.width_m(),
            rows_per_m: f64::from(rows) / arena.height_m(),
        }
    }

    /// Squares in a row.
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Squares in a column.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Squares in all.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Extent of one square along x and y, metres.
    pub fn size_m(&self) -> [f64; 2] {
        [
            self.width_m / f64::from(self.columns),
            self.height_m / f64::from(self.rows),
        ]
    }

    /// Index of the square that holds a point, metres. A point on a line between two squares is in
    /// the right or upper one; a point outside is in the nearest square of the rim.
    #[inline]
    pub fn square_of(&self, x_m: f64, y_m: f64) -> usize {
        // A cast of a negative number, or of none, gives 0.
        let column = ((x_m * self.columns_per_m) as u32).min(self.columns - 1);
        let row = ((y_m * self.rows_per_m) as u32).min(self.rows - 1);
        row as usize * self.columns as usize + column as usize
    }

    /// Centre of a square, metres.
    pub fn centre_of(&self, square: usize) -> Point2<f64> {
        let [low, high] = self.corners(square);
        nalgebra::center(&low, &high)
    }

    /// Lower left and upper right corner of a square, metres.
    pub fn corners(&self, square: usize) -> [Point2<f64>; 2] {
        let (columns, rows) = (self.columns as usize, self.rows as usize);
        let corner = |column: usize, row: usize| {
            Point2::new(
                self.width_m * column as f64 / columns as f64,
                self.height_m * row as f64 / rows as f64,
            )
        };
        let (column, row) = (square % columns, square / columns);
        [corner(column, row), corner(column + 1, row + 1)]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn squares() -> Squares {
        Squares::of(
            &Arena::from_json(
                r#"{"name": "a", "width_m": 2, "height_m": 1, "squares": 10, "walls_m": [],
                    "starts": [{"x_m": 0.9, "y_m": 0.5, "heading_rad": 0}]}"#,
            )
            .unwrap(),
        )
    }

    #[test]
    fn centre_is_in_its_square_and_between_its_corners() {
        let squares = squares();
        for square in 0..squares.count() {
            let centre = squares.centre_of(square);
            let [low, high] = squares.corners(square);
            assert_eq!(squares.square_of(centre.x, centre.y), square);
            assert!(low.x < centre.x && centre.x < high.x && low.y < centre.y && centre.y < high.y);
        }
        assert_eq!(squares.size_m(), [0.2, 0.1]);
    }

    #[test]
    fn points_outside_are_in_the_rim() {
        let squares = squares();
        assert_eq!(squares.square_of(-1.0, -1.0), 0);
        assert_eq!(squares.square_of(2.0, 1.0), 99);
        assert_eq!(squares.square_of(9.0, 0.15), 19);
        assert_eq!(squares.square_of(f64::NAN, 0.0), 0);
    }
}
