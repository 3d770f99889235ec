//! Walls along the axes, collected in pieces and merged where pieces meet end to end.

use nalgebra::Point2;

use crate::segment::Segment;
use crate::validate::MIN_WALL_LENGTH_M;

/// Pieces as (place across, from, to).
#[derive(Default)]
pub(super) struct AxisWalls {
    horizontal: Vec<[f64; 3]>,
    vertical: Vec<[f64; 3]>,
}

impl AxisWalls {
    pub fn horizontal(&mut self, y_m: f64, [from_m, to_m]: [f64; 2]) {
        self.horizontal.push([y_m, from_m, to_m]);
    }

    pub fn vertical(&mut self, x_m: f64, [from_m, to_m]: [f64; 2]) {
        self.vertical.push([x_m, from_m, to_m]);
    }

    /// The merged walls: horizontal ones from the lowest up, then vertical ones from the left.
    pub fn merged(self) -> Vec<Segment> {
        let horizontal = merged(self.horizontal)
            .into_iter()
            .map(|[y, from, to]| Segment::new(Point2::new(from, y), Point2::new(to, y)));
        let vertical = merged(self.vertical)
            .into_iter()
            .map(|[x, from, to]| Segment::new(Point2::new(x, from), Point2::new(x, to)));
        horizontal.chain(vertical).collect()
    }
}

/// Pieces that meet have bit-equal ends, because both come from the same formula.
fn merged(mut pieces: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    pieces.retain(|[_, from, to]| to - from >= MIN_WALL_LENGTH_M);
    pieces.sort_by(|one, other| {
        one[0]
            .total_cmp(&other[0])
            .then(one[1].total_cmp(&other[1]))
    });
    let mut walls: Vec<[f64; 3]> = Vec::new();
    for piece in pieces {
        match walls.last_mut() {
            Some(last) if last[0] == piece[0] && piece[1] <= last[2] => {
                last[2] = last[2].max(piece[2])
            }
            _ => walls.push(piece),
        }
    }
    walls
}
