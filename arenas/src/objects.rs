//! Movable objects: boxes and discs that stand in an arena until something pushes them.

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

use crate::error::ArenaError;
use crate::segment::Segment;

/// Most objects of one arena.
pub const MAX_OBJECTS: usize = 1_000;
/// Smallest and largest side of a box, and diameter of a disc, metres.
pub const OBJECT_SIZE_RANGE_M: [f64; 2] = [0.01, 1.0];
/// Range of masses, kilograms. Robots sink into what is much lighter than they are.
pub const OBJECT_MASS_RANGE_KG: [f64; 2] = [0.02, 10.0];
/// Range of friction coefficients.
pub const OBJECT_FRICTION_RANGE: [f64; 2] = [0.0, 10.0];

/// Range of centres, metres.
pub const OBJECT_PLACE_RANGE_M: [f64; 2] = [0.0, 1000.0];
/// Range of headings.
pub const OBJECT_HEADING_RANGE_RAD: [f64; 2] = [-1000.0, 1000.0];
/// Mass if left out, kilograms.
pub const DEFAULT_OBJECT_MASS_KG: f64 = 0.05;
/// Friction coefficient if left out.
pub const DEFAULT_OBJECT_FRICTION: f64 = 0.3;

fn default_mass_kg() -> f64 {
    DEFAULT_OBJECT_MASS_KG
}

fn default_friction() -> f64 {
    DEFAULT_OBJECT_FRICTION
}

/// An object at its start pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Movable {
    /// A box, `width_m` along its heading and `height_m` across.
    Box {
        /// Centre, metres.
        x_m: f64,
        /// Centre, metres.
        y_m: f64,
        /// Counter-clockwise from the x axis; 0 if left out.
        #[serde(default)]
        heading_rad: f64,
        /// Along the heading, metres.
        width_m: f64,
        /// Across the heading, metres.
        height_m: f64,
        /// Kilograms; 0.05 if left out.
        #[serde(default = "default_mass_kg")]
        mass_kg: f64,
        /// Coefficient of friction with the floor; 0.3 if left out.
        #[serde(default = "default_friction")]
        friction: f64,
    },
    /// A disc.
    Disc {
        /// Centre, metres.
        x_m: f64,
        /// Centre, metres.
        y_m: f64,
        /// Metres.
        radius_m: f64,
        /// Kilograms; 0.05 if left out.
        #[serde(default = "default_mass_kg")]
        mass_kg: f64,
        /// Coefficient of friction with the floor; 0.3 if left out.
        #[serde(default = "default_friction")]
        friction: f64,
    },
}

impl Movable {
    /// `box` or `disc`.
    pub fn kind(&self) -> &'static str {
        match self {
            Movable::Box { .. } => "box",
            Movable::Disc { .. } => "disc",
        }
    }

    /// Centre, metres.
    pub fn centre(&self) -> Point2<f64> {
        match *self {
            Movable::Box { x_m, y_m, .. } | Movable::Disc { x_m, y_m, .. } => Point2::new(x_m, y_m),
        }
    }

    /// Heading, radians; 0 for a disc.
    pub fn heading_rad(&self) -> f64 {
        match *self {
            Movable::Box { heading_rad, .. } => heading_rad,
            Movable::Disc { .. } => 0.0,
        }
    }

    /// Kilograms.
    pub fn mass_kg(&self) -> f64 {
        match *self {
            Movable::Box { mass_kg, .. } | Movable::Disc { mass_kg, .. } => mass_kg,
        }
    }

    /// Coefficient of friction with the floor.
    pub fn friction(&self) -> f64 {
        match *self {
            Movable::Box { friction, .. } | Movable::Disc { friction, .. } => friction,
        }
    }

    /// Half the sides of a box, `None` for a disc.
    pub fn half_sides_m(&self) -> Option<[f64; 2]> {
        match *self {
            Movable::Box {
                width_m, height_m, ..
            } => Some([0.5 * width_m, 0.5 * height_m]),
            Movable::Disc { .. } => None,
        }
    }

    /// Farthest that any part is from the centre, metres.
    pub fn reach_m(&self) -> f64 {
        match *self {
            Movable::Box {
                width_m, height_m, ..
            } => 0.5 * width_m.hypot(height_m),
            Movable::Disc { radius_m, .. } => radius_m,
        }
    }

    /// The same object with its centre elsewhere.
    #[must_use]
    pub fn moved_to(&self, place: Point2<f64>) -> Self {
        let mut moved = *self;
        match &mut moved {
            Movable::Box { x_m, y_m, .. } | Movable::Disc { x_m, y_m, .. } => {
                (*x_m, *y_m) = (place.x, place.y);
            }
        }
        moved
    }

    /// Corners of a box, counter-clockwise; `None` for a disc.
    pub fn corners(&self) -> Option<[Point2<f64>; 4]> {
        let [half_width, half_height] = self.half_sides_m()?;
        let along = self.along();
        let across = Vector2::new(-along.y, along.x);
        let corner =
            |x: f64, y: f64| self.centre() + along * (x * half_width) + across * (y * half_height);
        Some([
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ])
    }

    /// Distance from a point to the object, metres; 0 inside.
    pub fn distance_m(&self, point: Point2<f64>) -> f64 {
        let place = self.in_frame(point);
        match self.half_sides_m() {
            Some([half_width, half_height]) => {
                let beyond_x = (place.x.abs() - half_width).max(0.0);
                let beyond_y = (place.y.abs() - half_height).max(0.0);
                beyond_x.hypot(beyond_y)
            }
            None => (place.norm() - self.reach_m()).max(0.0),
        }
    }

    /// Whether a wall runs through the object.
    pub fn meets_wall(&self, wall: &Segment) -> bool {
        let Some(half) = self.half_sides_m() else {
            let reach_m = self.reach_m();
            return wall.distance_squared_m2(self.centre()) < reach_m * reach_m;
        };
        let (a, b) = (self.in_frame(wall.a), self.in_frame(wall.b));
        // What of the segment lies between both pairs of sides.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (start, end, half) in [(a.x, b.x, half[0]), (a.y, b.y, half[1])] {
            let way = end - start;
            if way == 0.0 {
                if start.abs() >= half {
                    return false;
                }
                continue;
            }
            let (first, last) = ((-half - start) / way, (half - start) / way);
            from = from.max(first.min(last));
            to = to.min(first.max(last));
        }
        from < to
    }

    /// Whether two objects overlap.
    pub fn overlaps(&self, other: &Movable) -> bool {
        match (self.corners(), other.corners()) {
            (None, _) => other.distance_m(self.centre()) < self.reach_m(),
            (_, None) => self.distance_m(other.centre()) < other.reach_m(),
            (Some(mine), Some(theirs)) => {
                // Two convex shapes are apart exactly when they are along the normal of some side.
                let axes = [self.along(), other.along()];
                let apart = axes.iter().any(|along| {
                    [*along, Vector2::new(-along.y, along.x)]
                        .iter()
                        .any(|axis| {
                            let (low, high) = extent(&mine, axis);
                            let (other_low, other_high) = extent(&theirs, axis);
                            high <= other_low || other_high <= low
                        })
                });
                !apart
            }
        }
    }

    fn along(&self) -> Vector2<f64> {
        let heading_rad = self.heading_rad();
        Vector2::new(libm::cos(heading_rad), libm::sin(heading_rad))
    }

    /// A point as seen from the centre, x along the heading.
    fn in_frame(&self, point: Point2<f64>) -> Vector2<f64> {
        let (way, along) = (point - self.centre(), self.along());
        Vector2::new(way.dot(&along), along.perp(&way))
    }

    /// All that decides what a run does with it, for content keys.
    pub(crate) fn figures(&self) -> [f64; 7] {
        let [width_m, height_m] = match self.half_sides_m() {
            Some(half) => half.map(|half| 2.0 * half),
            // No box has a side of zero.
            None => [0.0, 2.0 * self.reach_m()],
        };
        let centre = self.centre();
        [
            centre.x + 0.0,
            centre.y + 0.0,
            self.heading_rad() + 0.0,
            width_m,
            height_m,
            self.mass_kg(),
            self.friction(),
        ]
    }
}

fn extent(corners: &[Point2<f64>; 4], axis: &Vector2<f64>) -> (f64, f64) {
    let along = corners.map(|corner| corner.coords.dot(axis));
    (
        along.iter().copied().fold(f64::INFINITY, f64::min),
        along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    )
}

/// Checks objects of an arena of this size with these inner walls.
pub(crate) fn check(
    objects: &[Movable],
    [width_m, height_m]: [f64; 2],
    walls: &[Segment],
    errors: &mut Vec<ArenaError>,
) {
    if objects.len() > MAX_OBJECTS {
        errors.push(ArenaError::new(
            "/objects",
            format!("{} objects", objects.len()),
            format!("at most {MAX_OBJECTS} objects"),
        ));
        return;
    }
    let before = errors.len();
    for (index, object) in objects.iter().enumerate() {
        figures(object, &format!("/objects/{index}"), errors);
    }
    if errors.len() > before {
        return;
    }
    for (index, object) in objects.iter().enumerate() {
        let mut refuse = |message: String, allowed: &str| {
            errors.push(ArenaError::new(
                format!("/objects/{index}"),
                message,
                allowed,
            ));
        };
        let (centre, reach_m) = (object.centre(), object.reach_m());
        let corners = object.corners();
        let inside = match &corners {
            Some(corners) => corners
                .iter()
                .all(|c| (0.0..=width_m).contains(&c.x) && (0.0..=height_m).contains(&c.y)),
            None => {
                (reach_m..=width_m - reach_m).contains(&centre.x)
                    && (reach_m..=height_m - reach_m).contains(&centre.y)
            }
        };
        if !inside {
            refuse(
                "the object leaves the arena".to_owned(),
                "an object that lies inside the arena",
            );
        } else if let Some(wall) = walls.iter().position(|wall| object.meets_wall(wall)) {
            refuse(
                format!("wall {wall} runs through the object"),
                "an object that no wall runs through",
            );
        } else if let Some(other) = objects[..index].iter().position(|o| o.overlaps(object)) {
            refuse(
                format!("the object overlaps object {other}"),
                "objects that do not overlap",
            );
        }
    }
}

fn figures(object: &Movable, pointer: &str, errors: &mut Vec<ArenaError>) {
    let mut range = |field: &str, value: f64, [least, most]: [f64; 2]| {
        if !(least..=most).contains(&value) {
            errors.push(ArenaError::new(
                format!("{pointer}/{field}"),
                format!("{value} is out of range"),
                format!("{least} to {most}"),
            ));
        }
    };
    let centre = object.centre();
    range("x_m", centre.x, OBJECT_PLACE_RANGE_M);
    range("y_m", centre.y, OBJECT_PLACE_RANGE_M);
    range("mass_kg", object.mass_kg(), OBJECT_MASS_RANGE_KG);
    range("friction", object.friction(), OBJECT_FRICTION_RANGE);
    match *object {
        Movable::Box {
            width_m,
            height_m,
            heading_rad,
            ..
        } => {
            range("width_m", width_m, OBJECT_SIZE_RANGE_M);
            range("height_m", height_m, OBJECT_SIZE_RANGE_M);
            range("heading_rad", heading_rad, OBJECT_HEADING_RANGE_RAD);
        }
        Movable::Disc { radius_m, .. } => {
            range(
                "radius_m",
                radius_m,
                OBJECT_SIZE_RANGE_M.map(|size_m| 0.5 * size_m),
            );
        }
    }
}

#[cfg(test)]
#[path = "objects_tests.rs"]
mod tests;
