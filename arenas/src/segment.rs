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

    /// The shortest way to another segment: its ends on this one and on the other, both the
    /// crossing where the two cross.
    pub fn shortest_way_to(&self, other: &Self) -> Self {
        if let Some(crossing) = self.crossing(other) {
            return Self::new(crossing, crossing);
        }
        let ways = [
            Self::new(self.a, other.nearest_to(self.a)),
            Self::new(self.b, other.nearest_to(self.b)),
            Self::new(self.nearest_to(other.a), other.a),
            Self::new(self.nearest_to(other.b), other.b),
        ];
        let length = |way: &Self| (way.b - way.a).norm_squared();
        let mut shortest = ways[0];
        for way in &ways[1..] {
            if length(way) < length(&shortest) {
                shortest = *way;
            }
        }
        shortest
    }

    /// Where the insides of two segments cross.
    fn crossing(&self, other: &Self) -> Option<Point2<f64>> {
        let (mine, theirs) = (self.b - self.a, other.b - other.a);
        let [from, to] = [other.a, other.b].map(|point| mine.perp(&(point - self.a)));
        let [first, last] = [self.a, self.b].map(|point| theirs.perp(&(point - other.a)));
        let cross = from * to < 0.0 && first * last < 0.0;
        cross.then(|| other.a + theirs * (from / (from - to)))
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

    #[test]
    fn shortest_ways_between_segments() {
        let segment =
            |[ax, ay, bx, by]: [f64; 4]| Segment::new(Point2::new(ax, ay), Point2::new(bx, by));
        let wall = segment([0.0, 0.0, 2.0, 0.0]);
        for (other, way) in [
            ([1.0, -1.0, 1.0, 1.0], [1.0, 0.0, 1.0, 0.0]),
            ([1.0, 0.5, 5.0, 4.0], [1.0, 0.0, 1.0, 0.5]),
            ([3.0, -1.0, 3.0, 1.0], [2.0, 0.0, 3.0, 0.0]),
            ([3.0, 0.0, 4.0, 0.0], [2.0, 0.0, 3.0, 0.0]),
            ([2.0, 0.0, 4.0, 1.0], [2.0, 0.0, 2.0, 0.0]),
        ] {
            assert_eq!(
                wall.shortest_way_to(&segment(other)),
                segment(way),
                "{other:?}"
            );
        }
    }
}
