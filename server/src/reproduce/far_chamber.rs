//! The farthest chamber of an arena: where the way from the start is longest.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use arenas::{Arena, Squares};

/// How far the chamber reaches back along the way, metres: the side of a cell of the maze.
pub const DEPTH_M: f64 = 0.7 / 6.0;

/// Squares of the chamber: those in reach whose way from the first start is longer than the longest
/// less [`DEPTH_M`]. Ways lead from reachable square to reachable square over sides and corners
/// (over a corner only if both squares beside it can be reached), their length measured between
/// centres.
pub fn far_chamber(arena: &Arena, body_radius_m: f64) -> Vec<bool> {
    let squares = Squares::of(arena);
    let Some(start) = arena.starts().first() else {
        return vec![false; squares.count()];
    };
    let mask = arenas::reachable(arena, *start, body_radius_m).mask;
    let ways_m = ways_m(&squares, &mask, squares.square_of(start.x_m, start.y_m));
    let longest_m = ways_m.iter().flatten().copied().fold(0.0, f64::max);
    ways_m
        .iter()
        .map(|way_m| way_m.is_some_and(|way_m| way_m > longest_m - DEPTH_M))
        .collect()
}

/// Length of the shortest way from `start` to each square; `None` where there is none (Dijkstra).
fn ways_m(squares: &Squares, mask: &[bool], start: usize) -> Vec<Option<f64>> {
    let (columns, rows) = (i64::from(squares.columns()), i64::from(squares.rows()));
    let [width_m, height_m] = squares.size_m();
    let mut ways_m: Vec<Option<f64>> = vec![None; mask.len()];
    // Lengths are not negative, so their bits are in their order.
    let mut heap = BinaryHeap::from([Reverse((0u64, start))]);
    while let Some(Reverse((bits, square))) = heap.pop() {
        if ways_m[square].is_some() {
            continue;
        }
        let way_m = f64::from_bits(bits);
        ways_m[square] = Some(way_m);
        let (column, row) = (square as i64 % columns, square as i64 / columns);
        let open = |dx: i64, dy: i64| {
            let (x, y) = (column + dx, row + dy);
            let inside = (0..columns).contains(&x) && (0..rows).contains(&y);
            let square = (y * columns + x) as usize;
            (inside && mask[square]).then_some(square)
        };
        for (dx, dy) in [
            (-1, -1),
            (0, -1),
            (1, -1),
            (-1, 0),
            (1, 0),
            (-1, 1),
            (0, 1),
            (1, 1),
        ] {
            let passes = dx == 0 || dy == 0 || (open(dx, 0).is_some() && open(0, dy).is_some());
            if let Some(next) = open(dx, dy).filter(|_| passes) {
                let (dx_m, dy_m) = (dx as f64 * width_m, dy as f64 * height_m);
                let next_m = way_m + (dx_m * dx_m + dy_m * dy_m).sqrt();
                heap.push(Reverse((next_m.to_bits(), next)));
            }
        }
    }
    ways_m
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn the_chamber_is_at_the_end_of_the_way_not_of_the_line() {
        // Two rooms beside each other, joined at the top: the far end is the second room's bottom.
        let arena = Arena::from_json(
            r#"{"name": "u", "width_m": 0.4, "height_m": 0.6, "walls_m": [[0.2, 0, 0.2, 0.45]],
                "starts": [{"x_m": 0.1, "y_m": 0.05, "heading_rad": 0}]}"#,
        )
        .unwrap();
        let chamber = far_chamber(&arena, 0.037);
        let squares = Squares::of(&arena);
        assert!(chamber[squares.square_of(0.3, 0.05)]);
        assert!(!chamber[squares.square_of(0.1, 0.05)] && !chamber[squares.square_of(0.3, 0.3)]);
        for square in (0..squares.count()).filter(|&square| chamber[square]) {
            let centre = squares.centre_of(square);
            assert!(centre.x > 0.2 && centre.y < 0.25, "{centre}");
        }
    }

    #[test]
    fn the_maze_has_one() {
        let arena = arenas::builtin("maze").unwrap();
        let count = far_chamber(&arena, 0.037)
            .into_iter()
            .filter(|&far| far)
            .count();
        assert!((50..600).contains(&count), "{count} squares");
    }
}
