//! Gates about as wide as a body: where a little decides whether it can pass.

use std::ops::ControlFlow;

use nalgebra::Point2;

use crate::arena::Arena;
use crate::free_space::TOLERANCE_M;
use crate::near_pairs::near_pairs;
use crate::segment::Segment;

/// Most gates looked at.
const MOST_GATES: usize = 1_000;

/// A narrowest place between two walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// Its middle, metres.
    pub at: Point2<f64>,
    /// How far the walls are apart, metres.
    pub width_m: f64,
    /// Whether a body passes: see [`reachable`](crate::reachable()).
    pub open: bool,
}

/// The gates whose width differs from that of a body of `body_radius_m` by at most `within_m`, from
/// the narrowest. Between two parallel walls one place stands for all; of the first 1,000 that are met.
pub fn gates_at_the_limit(arena: &Arena, body_radius_m: f64, within_m: f64) -> Vec<Gate> {
    let walls: Vec<Segment> = arena
        .boundary()
        .iter()
        .chain(arena.walls())
        .copied()
        .collect();
    let body_m = 2.0 * body_radius_m;
    let mut ways: Vec<Segment> = Vec::new();
    near_pairs(&walls, body_m + within_m, |_, way| {
        let width_m = way.length_m();
        if width_m > 0.0 && width_m >= body_m - within_m {
            ways.push(way);
        }
        if ways.len() < MOST_GATES {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    });
    let mut gates: Vec<Gate> = ways
        .iter()
        .map(|way| {
            let width_m = way.length_m();
            Gate {
                at: nalgebra::center(&way.a, &way.b),
                width_m,
                open: width_m >= body_m - TOLERANCE_M,
            }
        })
        // Where a third wall is nearer, the narrow place is between it and one of the two.
        .filter(|gate| {
            let clear_m = 0.5 * gate.width_m - TOLERANCE_M;
            walls
                .iter()
                .all(|wall| wall.distance_squared_m2(gate.at) >= clear_m * clear_m)
        })
        .collect();
    gates.sort_by(|one, other| {
        one.width_m
            .total_cmp(&other.width_m)
            .then(one.at.x.total_cmp(&other.at.x))
            .then(one.at.y.total_cmp(&other.at.y))
    });
    // Walls that meet at the gate's end each have it.
    gates.dedup_by(|one, other| (one.at - other.at).norm() < TOLERANCE_M);
    gates
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn a_gate_at_the_limit_is_told_once_with_its_width() {
        // The upper wall turns a corner at the gate; a third gate is far from the limit.
        let arena = Arena::from_json(
            r#"{"name": "a", "width_m": 2, "height_m": 2, "walls_m": [[1, 0, 1, 0.96275],
                [1, 1.03725, 1, 1.5], [1, 1.03725, 1.2, 1.03725], [1, 1.6, 1, 2]],
                "starts": [{"x_m": 0.5, "y_m": 1, "heading_rad": 0}]}"#,
        )
        .unwrap();
        let gates = gates_at_the_limit(&arena, 0.037, 1e-3);
        assert_eq!(gates.len(), 1, "{gates:?}");
        assert!((gates[0].width_m - 0.0745).abs() < 1e-12 && gates[0].open);
        assert!((gates[0].at - Point2::new(1.0, 1.0)).norm() < 1e-9);
        let narrow = gates_at_the_limit(&arena, 0.0375, 1e-3);
        assert!(narrow.len() == 1 && !narrow[0].open);
        let exact = gates_at_the_limit(&arena, 0.5 * 0.0745, 1e-3);
        assert!(exact.len() == 1 && exact[0].open);
        assert_eq!(gates_at_the_limit(&arena, 0.03, 1e-3), []);
    }
}
