//! A validated arena: a rectangle with walls of no thickness, start poses and a grid of squares.
//! The only way to one is through [`crate::ArenaFormat`], so holding an `Arena` means it is valid.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};

use crate::objects::Movable;
use crate::segment::Segment;

/// A start pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Metres from the left wall.
    pub x_m: f64,
    /// Metres from the bottom wall.
    pub y_m: f64,
    /// Counter-clockwise from the x axis.
    pub heading_rad: f64,
}

impl Pose {
    /// The place without the heading.
    pub fn position(&self) -> Point2<f64> {
        Point2::new(self.x_m, self.y_m)
    }
}

/// A rectangle with walls and start poses; always valid.
#[derive(Clone, Debug, PartialEq)]
pub struct Arena {
    name: String,
    width_m: f64,
    height_m: f64,
    walls: Vec<Segment>,
    starts: Vec<Pose>,
    squares: [u32; 2],
    objects: Vec<Movable>,
}

impl Arena {
    /// Takes parts that the format has checked. Negative zeros become zeros, so that equal arenas
    /// have equal [content keys](Self::content_key).
    pub(crate) fn from_checked(
        name: String,
        [width_m, height_m]: [f64; 2],
        mut walls: Vec<Segment>,
        mut starts: Vec<Pose>,
        squares: [u32; 2],
        objects: Vec<Movable>,
    ) -> Self {
        for wall in &mut walls {
            for point in [&mut wall.a, &mut wall.b] {
                point.x += 0.0;
                point.y += 0.0;
            }
        }
        for start in &mut starts {
            start.x_m += 0.0;
            start.y_m += 0.0;
            start.heading_rad += 0.0;
        }
        Self {
            name,
            width_m,
            height_m,
            walls,
            starts,
            squares,
            objects,
        }
    }

    /// Name: 1 to 64 characters of `a-z 0-9 . _ -`, the first a letter or a digit.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Extent along x, metres.
    pub fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Extent along y, metres.
    pub fn height_m(&self) -> f64 {
        self.height_m
    }

    /// Inner walls, in the order of the file; the four outer ones are [`Self::boundary`].
    pub fn walls(&self) -> &[Segment] {
        &self.walls
    }

    /// Outer walls, counter-clockwise: bottom, right, top, left.
    pub fn boundary(&self) -> [Segment; 4] {
        let [south_west, south_east, north_east, north_west] = [
            Point2::origin(),
            Point2::new(self.width_m, 0.0),
            Point2::new(self.width_m, self.height_m),
            Point2::new(0.0, self.height_m),
        ];
        [
            Segment::new(south_west, south_east),
            Segment::new(south_east, north_east),
            Segment::new(north_east, north_west),
            Segment::new(north_west, south_west),
        ]
    }

    /// Start poses, at least one.
    pub fn starts(&self) -> &[Pose] {
        &self.starts
    }

    /// The same arena with another first start pose, of finite numbers; whether a robot fits there is
    /// for [`Self::check_starts`] to say.
    #[must_use]
    pub fn with_first_start(mut self, start: Pose) -> Self {
        // Negative zeros become zeros, as in every arena.
        self.starts[0] = Pose {
            x_m: start.x_m + 0.0,
            y_m: start.y_m + 0.0,
            heading_rad: start.heading_rad + 0.0,
        };
        self
    }

    /// Movable objects, where they begin.
    pub fn objects(&self) -> &[Movable] {
        &self.objects
    }

    /// Columns and rows of the grid of squares over the whole rectangle.
    pub fn squares(&self) -> [u32; 2] {
        self.squares
    }

    /// What the arena *is*, as bytes to hash: two arenas have equal keys exactly when a run in one
    /// is a run in the other. The name does not take part; the order of the walls and starts does,
    /// because it decides the order of sums and which robot starts where.
    ///
    /// Layout, little endian: the tag `evswarm-arena-1` and the squares along each side (u32) or,
    /// where they differ, `evswarm-arena-2` and columns and rows (u32), then width and height (f64), the number of walls (u64) and x1, y1, x2, y2 of each (f64), the number of starts
    /// (u64) and x, y, heading of each (f64), then of each object x, y, heading, sides (0 and the
    /// diameter for a disc), mass and friction (f64).
    pub fn content_key(&self) -> Vec<u8> {
        let mut key = Vec::with_capacity(64 + 32 * self.walls.len() + 24 * self.starts.len());
        let put = |key: &mut Vec<u8>, values: &[f64]| {
            for value in values {
                key.extend_from_slice(&value.to_le_bytes());
            }
        };
        let [columns, rows] = self.squares;
        if columns == rows {
            key.extend_from_slice(b"evswarm-arena-1");
        } else {
            key.extend_from_slice(b"evswarm-arena-2");
            key.extend_from_slice(&columns.to_le_bytes());
        }
        key.extend_from_slice(&rows.to_le_bytes());
        put(&mut key, &[self.width_m, self.height_m]);
        key.extend_from_slice(&(self.walls.len() as u64).to_le_bytes());
        for wall in &self.walls {
            put(&mut key, &[wall.a.x, wall.a.y, wall.b.x, wall.b.y]);
        }
        key.extend_from_slice(&(self.starts.len() as u64).to_le_bytes());
        for start in &self.starts {
            put(&mut key, &[start.x_m, start.y_m, start.heading_rad]);
        }
        for object in &self.objects {
            put(&mut key, &object.figures());
        }
        key
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn arena(name: &str, wall_x_m: &str) -> Arena {
        Arena::from_json(&format!(
            r#"{{"name": "{name}", "width_m": 1, "height_m": 2, "walls_m": [[{wall_x_m}, 0, 0.5, 1]],
                "starts": [{{"x_m": 0.9, "y_m": 0.5, "heading_rad": 0}}]}}"#
        ))
        .unwrap()
    }

    #[test]
    fn key_tells_arenas_apart_by_content_alone() {
        assert_eq!(
            arena("a", "0.5").content_key(),
            arena("b", "0.5").content_key()
        );
        assert_eq!(
            arena("a", "0.0").content_key(),
            arena("a", "-0.0").content_key()
        );
        assert_ne!(
            arena("a", "0.5").content_key(),
            arena("a", "0.25").content_key()
        );
    }

    #[test]
    fn boundary_is_closed_and_counter_clockwise() {
        let sides = arena("a", "0.5").boundary();
        for (side, next) in sides.iter().zip(sides.iter().cycle().skip(1)) {
            assert_eq!(side.b, next.a);
            assert!((side.b - side.a).perp(&(next.b - next.a)) > 0.0);
        }
    }
}
