//! Walls are segments of no thickness.

use nalgebra::Point2;

/// A wall: a segment of no thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// One end, metres.
    pub a: Point2<f64>,
    /// The other end, metres.
    pub b: Point2<f64>,
}

impl Segment {
    /// Segment between two points, metres.
    pub const fn new(a: Point2<f64>, b: Point2<f64>) -> Self {
        Self { a, b }
    }

    /// Length, metres.
    pub fn length_m(&self) -> f64 {
        (self.b - self.a).norm()
    }

    /// The point of the segment nearest to `point`.
    pub fn nearest_to(&self, point: Point2<f64>) -> Point2<f64> {
        let along = self.b - self.a;
        let length_squared = along.norm_squared();
        if length_squared == 0.0 {
            return self.a;
        }
        let t = (point - self.a).dot(&along) / length_squared;
        self.a + along * t.clamp(0.0, 1.0)
    }

    /// Squared distance to `point`, square metres.
    pub fn distance_squared_m2(&self, point: Point2<f64>) -> f64 {
        (self.nearest_to(point) - point).norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_segment() {
        let wall = Segment::new(Point2::new(0.0, 0.0), Point2::new(2.0, 0.0));
        assert_eq!(wall.distance_squared_m2(Point2::new(1.0, 3.0)), 9.0);
        assert_eq!(wall.distance_squared_m2(Point2::new(-3.0, 4.0)), 25.0);
        assert_eq!(wall.length_m(), 2.0);
    }
}
