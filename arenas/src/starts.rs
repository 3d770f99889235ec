//! Which starts stand too near to a wall for a body of a given size.

use nalgebra::Point2;

use crate::arena::Arena;
use crate::error::ArenaError;
use crate::segment::Segment;

/// Overlap that rounded decimals may cause, metres.
const TOLERANCE_M: f64 = 1e-9;
/// A part of the arena with this few starts or walls is searched one by one.
const FEW: usize = 8;
/// Deepest subdivision: starts in the same place cannot be told apart.
const MAX_DEPTH: u32 = 20;

impl Arena {
    /// Starts whose body, a disc of `body_radius_m`, would overlap a wall or the boundary: one
    /// error each, pointing at `/starts/i`, in order. Empty if all starts are clear.
    pub fn check_starts(&self, body_radius_m: f64) -> Vec<ArenaError> {
        let positions: Vec<Point2<f64>> =
            self.starts().iter().map(|start| start.position()).collect();
        let needed_m = body_radius_m - TOLERANCE_M;
        let mut search = Search {
            walls: self.walls(),
            positions: &positions,
            needed_m,
            nearest: vec![None; positions.len()],
        };
        search.part(
            [0.0, 0.0, self.width_m(), self.height_m()],
            &(0..positions.len() as u32).collect::<Vec<_>>(),
            &(0..self.walls().len() as u32).collect::<Vec<_>>(),
            0,
        );

        let mut errors = Vec::new();
        for (index, (position, nearest)) in positions.iter().zip(&search.nearest).enumerate() {
            let to_boundary_m = [
                position.x,
                position.y,
                self.width_m() - position.x,
                self.height_m() - position.y,
            ]
            .into_iter()
            .fold(f64::INFINITY, f64::min);
            let (distance_m, what) = match *nearest {
                Some((squared_m2, wall)) if squared_m2.sqrt() < to_boundary_m => {
                    (squared_m2.sqrt(), format!("wall {wall}"))
                }
                _ if to_boundary_m < needed_m => (to_boundary_m, "the boundary".to_owned()),
                _ => continue,
            };
            errors.push(ArenaError::new(
                format!("/starts/{index}"),
                format!("the start is {distance_m:.6} m from {what}"),
                format!("at least the body radius, {body_radius_m} m"),
            ));
        }
        for (index, position) in positions.iter().enumerate() {
            let near = self.objects().iter().position(|object| {
                let reach_m = object.reach_m() + needed_m;
                (object.centre() - position).norm_squared() < reach_m * reach_m
                    && object.distance_m(*position) < needed_m
            });
            if let Some(object) = near {
                errors.push(ArenaError::new(
                    format!("/starts/{index}"),
                    format!("the start is too near to object {object}"),
                    format!("at least the body radius, {body_radius_m} m"),
                ));
            }
        }
        errors
    }
}

/// Divide and conquer over the rectangle: each part keeps only its starts and the walls near it,
/// so the cost follows the number of near pairs, whatever the lengths of the walls.
struct Search<'a> {
    walls: &'a [Segment],
    positions: &'a [Point2<f64>],
    needed_m: f64,
    /// Squared distance and index of the nearest wall that is too near, for each start.
    nearest: Vec<Option<(f64, u32)>>,
}

impl Search<'_> {
    fn part(&mut self, [x0, y0, x1, y1]: [f64; 4], starts: &[u32], walls: &[u32], depth: u32) {
        if starts.len() <= FEW || walls.len() <= FEW || depth == MAX_DEPTH {
            self.one_by_one(starts, walls);
            return;
        }
        let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
        for (quarter, corners) in [
            [x0, y0, x, y],
            [x, y0, x1, y],
            [x0, y, x, y1],
            [x, y, x1, y1],
        ]
        .into_iter()
        .enumerate()
        {
            let [right, upper] = [quarter % 2 == 1, quarter / 2 == 1];
            let starts: Vec<u32> = starts
                .iter()
                .copied()
                .filter(|&start| {
                    let place = self.positions[start as usize];
                    (place.x >= x) == right && (place.y >= y) == upper
                })
                .collect();
            if starts.is_empty() {
                continue;
            }
            let low = Point2::new(corners[0], corners[1]);
            let centre = nalgebra::center(&low, &Point2::new(corners[2], corners[3]));
            let reach_m = self.needed_m + (centre - low).norm() + TOLERANCE_M;
            let near: Vec<u32> = walls
                .iter()
                .copied()
                .filter(|&wall| {
                    self.walls[wall as usize].distance_squared_m2(centre) <= reach_m * reach_m
                })
                .collect();
            self.part(corners, &starts, &near, depth + 1);
        }
    }

    fn one_by_one(&mut self, starts: &[u32], walls: &[u32]) {
        let needed_m2 = self.needed_m * self.needed_m;
        for &start in starts {
            let position = self.positions[start as usize];
            self.nearest[start as usize] = walls
                .iter()
                .map(|&wall| {
                    (
                        self.walls[wall as usize].distance_squared_m2(position),
                        wall,
                    )
                })
                .filter(|&(squared_m2, _)| squared_m2 < needed_m2)
                .min_by(|one, other| one.0.total_cmp(&other.0));
        }
    }
}
