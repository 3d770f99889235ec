//! One axis of a grid of equal cells: which column (or row) a coordinate lies in, without a division
//! and without a branch, for any coordinate at all.

/// Most cells of an axis: every whole number up to this one is an `f32`.
const MOST_CELLS: usize = 1 << 24;

/// The columns, or the rows, of a grid that begins at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridAxis {
    cells_per_m: f32,
    /// The highest cell: a whole number from 0 to 2^24 - 1.
    last: f32,
}

impl GridAxis {
    /// An axis of so many cells, at least 1 and at most 2^24.
    pub fn new(cells: usize, cells_per_m: f32) -> Self {
        Self {
            cells_per_m,
            last: (cells.clamp(1, MOST_CELLS) - 1) as f32,
        }
    }

    /// The cell that a coordinate lies in: the first for what lies before it or is not a number,
    /// the last for what lies beyond it.
    #[inline(always)]
    pub fn cell(&self, position_m: f32) -> usize {
        let place = position_m * self.cells_per_m;
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < self.last { place } else { self.last };
        // SAFETY: the comparison above holds for 0 <= place < last alone, also where `place` was not
        // a number, and `last` is at most 2^24 by construction: an i32 holds it.
        let whole: i32 = unsafe { place.to_int_unchecked() };
        whole as usize
    }
}

#[cfg(test)]
mod tests {
    use proptest::num::f32;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn any_coordinate_is_in_a_cell(
            position_m in f32::ANY,
            cells_per_m in f32::ANY,
            cells in any::<usize>(),
        ) {
            let cell = GridAxis::new(cells, cells_per_m).cell(position_m);
            prop_assert!(cell < cells.clamp(1, MOST_CELLS));
            // The plain way, in which `as` takes what is no number for 0.
            let plain = (position_m * cells_per_m) as usize;
            prop_assert_eq!(cell, plain.min(cells.clamp(1, MOST_CELLS) - 1));
        }
    }

    #[test]
    fn what_is_beyond_the_grid_is_in_its_outermost_cells() {
        let axis = GridAxis::new(10, 5.0);
        let nan = std::primitive::f32::NAN;
        let infinity = std::primitive::f32::INFINITY;
        for (position_m, cell) in [
            (0.0, 0),
            (-0.0, 0),
            (0.19, 0),
            (0.21, 1),
            (1.99, 9),
            (2.0, 9),
            (1e30, 9),
            (infinity, 9),
            (-1.0, 0),
            (-infinity, 0),
            (nan, 0),
        ] {
            assert_eq!(axis.cell(position_m), cell, "{position_m}");
        }
        assert_eq!(GridAxis::new(0, nan).cell(1.0), 0);
    }
}
