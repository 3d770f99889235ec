//! Separate walls or boxes at random places and angles, with room to pass between them.

use std::f64::consts::{FRAC_PI_4, SQRT_2};

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

use super::generated::Generated;
use super::random::Random;
use crate::arena::Pose;
use crate::error::ArenaError;
use crate::segment::Segment;
use crate::validate::MAX_WALLS;

/// Places tried for one obstacle before the arena counts as full.
const TRIES: usize = 500;
/// About the most buckets of an arena.
const MAX_BUCKETS: f64 = 262_144.0;

/// Outline of an obstacle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleShape {
    /// A single wall.
    #[default]
    Wall,
    /// A closed square.
    Box,
}

/// Obstacles are convex, and each is more than `gap_m` from every other and from the boundary. So
/// for a disc of a lesser diameter, the obstacles grown by its radius do not touch: what is left
/// of the rectangle is connected.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RandomObstacles {
    pub density_per_m2: f64,
    pub wall_length_m: f64,
    pub gap_m: f64,
    pub clear_m: f64,
    pub shape: ObstacleShape,
}

impl RandomObstacles {
    fn count(&self, [width_m, height_m]: [f64; 2]) -> f64 {
        (self.density_per_m2 * width_m * height_m).round()
    }

    fn walls_each(&self) -> usize {
        match self.shape {
            ObstacleShape::Wall => 1,
            ObstacleShape::Box => 4,
        }
    }

    /// Farthest point of an obstacle from its centre, metres.
    fn extent_m(&self) -> f64 {
        match self.shape {
            ObstacleShape::Wall => 0.5 * self.wall_length_m,
            ObstacleShape::Box => 0.5 * SQRT_2 * self.wall_length_m,
        }
    }

    pub fn check(&self, size_m: [f64; 2]) -> Vec<ArenaError> {
        let mut errors = Vec::new();
        let most = (MAX_WALLS / self.walls_each()) as f64;
        let count = self.count(size_m);
        if count > most {
            errors.push(ArenaError::new(
                "/generate/density_per_m2",
                format!("makes {count} obstacles"),
                format!("at most {:.3}", most / (size_m[0] * size_m[1])),
            ));
        }
        let most_m = 0.5 * size_m[0].min(size_m[1]);
        if self.clear_m > most_m {
            errors.push(ArenaError::new(
                "/generate/clear_m",
                format!("{} m around a start does not fit the arena", self.clear_m),
                format!("at most {most_m}"),
            ));
        }
        errors
    }

    pub fn generate(
        &self,
        size_m: [f64; 2],
        starts: Option<&[Pose]>,
        random: &mut Random,
    ) -> Result<Generated, ArenaError> {
        let start = Pose {
            x_m: self.clear_m,
            y_m: self.clear_m,
            heading_rad: FRAC_PI_4,
        };
        let keep_clear: Vec<Point2<f64>> = starts
            .unwrap_or(&[start])
            .iter()
            .map(Pose::position)
            .collect();
        let reach_m = self.extent_m() + f64::max(self.extent_m() + self.gap_m, self.clear_m);
        let mut starts = Buckets::new(size_m, reach_m);
        for (index, &place) in (0..).zip(&keep_clear) {
            starts.put(place, index);
        }
        let mut placed = Buckets::new(size_m, reach_m);
        let mut obstacles: Vec<Obstacle> = Vec::new();
        let count = self.count(size_m) as usize;
        while obstacles.len() < count {
            let fits = (0..TRIES).find_map(|_| {
                let obstacle = self.draw(size_m, random);
                let fits = obstacle.walls().all(|wall| self.inside(wall, size_m))
                    && starts.near(obstacle.centre).all(|start| {
                        let start = keep_clear[start as usize];
                        obstacle.distance_squared_m2(start) >= self.clear_m * self.clear_m
                    })
                    && (self.gap_m == 0.0
                        || placed.near(obstacle.centre).all(|other| {
                            obstacle.is_apart(&obstacles[other as usize], self.gap_m)
                        }));
                fits.then_some(obstacle)
            });
            let Some(obstacle) = fits else {
                return Err(ArenaError::new(
                    "/generate/density_per_m2",
                    format!("only {} of {count} obstacles found room", obstacles.len()),
                    "a lower density, or less wall_length_m, gap_m or clear_m",
                ));
            };
            placed.put(obstacle.centre, obstacles.len() as u32);
            obstacles.push(obstacle);
        }
        let walls = obstacles.iter().flat_map(Obstacle::walls).collect();
        Ok(Generated { walls, start })
    }

    fn draw(&self, [width_m, height_m]: [f64; 2], random: &mut Random) -> Obstacle {
        let centre = Point2::new(width_m * random.unit(), height_m * random.unit());
        let [cos, sin] = random.direction();
        let along = Vector2::new(cos, sin) * (0.5 * self.wall_length_m);
        let across = Vector2::new(-along.y, along.x);
        let corners = match self.shape {
            ObstacleShape::Wall => vec![centre - along, centre + along],
            ObstacleShape::Box => vec![
                centre - along - across,
                centre + along - across,
                centre + along + across,
                centre - along + across,
            ],
        };
        Obstacle { centre, corners }
    }

    fn inside(&self, wall: Segment, size_m: [f64; 2]) -> bool {
        [wall.a, wall.b].iter().all(|point| {
            (self.gap_m..=size_m[0] - self.gap_m).contains(&point.x)
                && (self.gap_m..=size_m[1] - self.gap_m).contains(&point.y)
        })
    }
}

/// A wall (two corners) or a convex outline (more).
struct Obstacle {
    centre: Point2<f64>,
    corners: Vec<Point2<f64>>,
}

impl Obstacle {
    fn walls(&self) -> impl Iterator<Item = Segment> {
        let count = self.corners.len();
        let walls = if count == 2 { 1 } else { count };
        (0..walls).map(move |corner| {
            Segment::new(self.corners[corner], self.corners[(corner + 1) % count])
        })
    }

    /// To a point: zero inside an outline.
    fn distance_squared_m2(&self, point: Point2<f64>) -> f64 {
        let inside = self.corners.len() > 2
            && self
                .walls()
                .all(|wall| (wall.b - wall.a).perp(&(point - wall.a)) >= 0.0);
        if inside {
            return 0.0;
        }
        self.walls()
            .map(|wall| wall.distance_squared_m2(point))
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether more than `gap_m` lies between two obstacles. Those of one size cannot contain each
    /// other, so that holds if no walls cross and every corner is far from the other's walls.
    fn is_apart(&self, other: &Self, gap_m: f64) -> bool {
        let far = |one: &Self, other: &Self| {
            one.corners
                .iter()
                .all(|&corner| other.distance_squared_m2(corner) > gap_m * gap_m)
        };
        far(self, other)
            && far(other, self)
            && !self
                .walls()
                .any(|wall| other.walls().any(|their| cross(wall, their)))
    }
}

fn cross(one: Segment, other: Segment) -> bool {
    let splits = |line: Segment, segment: Segment| {
        let along = line.b - line.a;
        let (a, b) = (
            along.perp(&(segment.a - line.a)),
            along.perp(&(segment.b - line.a)),
        );
        (a <= 0.0 && b >= 0.0) || (a >= 0.0 && b <= 0.0)
    };
    splits(one, other) && splits(other, one)
}

/// Indices by place: what lies within `reach_m` of a place is in its bucket or the eight around.
struct Buckets {
    side_m: [f64; 2],
    columns: usize,
    rows: usize,
    buckets: Vec<Vec<u32>>,
}

impl Buckets {
    fn new(size_m: [f64; 2], reach_m: f64) -> Self {
        let least_m = reach_m.max((size_m[0] * size_m[1] / MAX_BUCKETS).sqrt());
        let [columns, rows] =
            size_m.map(|side_m| (side_m / least_m).floor().clamp(1.0, MAX_BUCKETS) as usize);
        Self {
            side_m: [size_m[0] / columns as f64, size_m[1] / rows as f64],
            columns,
            rows,
            buckets: vec![Vec::new(); columns * rows],
        }
    }

    fn place(&self, point: Point2<f64>) -> [usize; 2] {
        [
            ((point.x / self.side_m[0]) as usize).min(self.columns - 1),
            ((point.y / self.side_m[1]) as usize).min(self.rows - 1),
        ]
    }

    fn put(&mut self, point: Point2<f64>, index: u32) {
        let [column, row] = self.place(point);
        self.buckets[row * self.columns + column].push(index);
    }

    fn near(&self, point: Point2<f64>) -> impl Iterator<Item = u32> {
        let [column, row] = self.place(point);
        let columns = column.saturating_sub(1)..=(column + 1).min(self.columns - 1);
        let rows = row.saturating_sub(1)..=(row + 1).min(self.rows - 1);
        rows.flat_map(move |row| {
            columns
                .clone()
                .map(move |column| row * self.columns + column)
        })
        .flat_map(|bucket| self.buckets[bucket].iter().copied())
    }
}
