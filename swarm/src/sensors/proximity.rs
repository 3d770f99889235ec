//! Proximity sensors: eight rays as eight lanes against the walls in reach and the robots near by.

use arenas::index::WallIndex;

use super::noise::normals;
use crate::bodies::{ObjectPose, Shape};
use crate::dimensions::PROXIMITY_SENSORS;
use crate::lanes::{F8, LANES};
use crate::robot::RobotModel;
use crate::robot::response::MAX_ROWS;

const _: () = assert!(PROXIMITY_SENSORS == LANES, "a ray a lane");

/// Largest raw value of the 12-bit sensors.
pub const RAW_MAX: f32 = 4095.0;

/// Ends of walls reach this far (relative to their length) beyond their coordinates, so that no ray
/// slips through the joint of two walls for rounding.
const JOINT: f32 = 1e-5;

/// A piece of the response: linear in distance from `from_m` on. Each figure stands in all lanes,
/// so that choosing a piece is a choice between vectors in memory.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    from_m: F8,
    value: F8,
    value_per_m: F8,
    sd: F8,
    sd_per_m: F8,
}

/// The sensors of a robot model in the layout of the step loop.
#[derive(Clone, Debug)]
pub struct Optics {
    x_m: F8,
    y_m: F8,
    cos: F8,
    sin: F8,
    /// Over the ground.
    range_m: f32,
    ray_stretch: f32,
    body_radius_m: f32,
    sight_m: f64,
    gain: f32,
    noise: f32,
    pieces: [Piece; MAX_ROWS],
    piece_count: usize,
}

/// Eight rays in the arena's frame.
#[derive(Clone, Copy, Debug)]
pub struct Rays {
    /// Origins, metres.
    pub x_m: F8,
    /// Origins, metres.
    pub y_m: F8,
    /// Unit directions.
    pub dx: F8,
    /// Unit directions.
    pub dy: F8,
}

impl Optics {
    /// The sensors of a robot.
    pub fn new(model: &RobotModel) -> Self {
        let lanes = |f: fn(&crate::robot::SensorMount) -> f64| {
            let mut out = [0.0; LANES];
            for (o, mount) in out.iter_mut().zip(&model.mounts) {
                *o = f(mount) as f32;
            }
            F8(out)
        };
        let rows = model.response.rows();
        let mut pieces = [Piece::default(); MAX_ROWS];
        for (k, row) in rows.iter().enumerate() {
            let slope = |figure: fn(&crate::robot::response::ResponseRow) -> f64| {
                rows.get(k + 1).map_or(0.0, |next| {
                    (figure(next) - figure(row)) / (next.distance_m - row.distance_m)
                })
            };
            let (value_per_m, sd_per_m) = (slope(|r| r.value), slope(|r| r.relative_sd));
            pieces[k] = Piece {
                from_m: F8::splat(row.distance_m as f32),
                value: F8::splat((row.value - value_per_m * row.distance_m) as f32),
                value_per_m: F8::splat(value_per_m as f32),
                sd: F8::splat((row.relative_sd - sd_per_m * row.distance_m) as f32),
                sd_per_m: F8::splat(sd_per_m as f32),
            };
        }
        Self {
            x_m: lanes(|m| m.x_m),
            y_m: lanes(|m| m.y_m),
            cos: lanes(|m| libm::cos(m.heading_rad)),
            sin: lanes(|m| libm::sin(m.heading_rad)),
            range_m: (model.response.range_m() / model.parameters.ray_stretch) as f32,
            ray_stretch: model.parameters.ray_stretch as f32,
            body_radius_m: model.parameters.body_radius_m as f32,
            sight_m: (model.sensor_reach_m() + model.parameters.body_radius_m)
                .max(2.0 * model.parameters.body_radius_m + 4.0 * model.max_step_m()),
            gain: model.parameters.sensor_gain as f32,
            noise: model.parameters.sensor_noise as f32,
            pieces,
            piece_count: rows.len(),
        }
    }

    /// Distance between centres beyond which no ray can reach another robot, metres.
    pub fn sight_m(&self) -> f64 {
        self.sight_m
    }

    /// The rays of a robot at a pose.
    #[inline(always)]
    pub fn rays(&self, x_m: f32, y_m: f32, cos: f32, sin: f32) -> Rays {
        let (c, s) = (F8::splat(cos), F8::splat(sin));
        Rays {
            x_m: F8::splat(x_m) + (c * self.x_m - s * self.y_m),
            y_m: F8::splat(y_m) + (s * self.x_m + c * self.y_m),
            dx: c * self.cos - s * self.sin,
            dy: s * self.cos + c * self.sin,
        }
    }

    /// Distance of every ray to the first wall among those listed, at most the range.
    #[inline(always)]
    pub fn to_walls(&self, rays: &Rays, index: &WallIndex, x_m: f32, y_m: f32) -> F8 {
        let mut best = F8::splat(self.range_m);
        for &number in index.visible(x_m, y_m) {
            let wall = index.wall(number);
            best = to_line(rays, [wall.px_m, wall.py_m], [wall.ex_m, wall.ey_m], best);
        }
        best
    }

    /// Shortens `best` by a segment between two points.
    #[inline(always)]
    pub fn to_segment(&self, rays: &Rays, a: [f32; 2], b: [f32; 2], best: F8) -> F8 {
        to_line(rays, a, [b[0] - a[0], b[1] - a[1]], best)
    }

    /// Shortens `best` by another robot's body centred at (x, y).
    #[inline(always)]
    pub fn to_robot(&self, rays: &Rays, x_m: f32, y_m: f32, best: F8) -> F8 {
        self.to_disc(rays, (x_m, y_m), self.body_radius_m, best)
    }

    /// Shortens `best` by a disc centred at (x, y).
    #[inline(always)]
    pub fn to_disc(&self, rays: &Rays, (x_m, y_m): (f32, f32), radius_m: f32, best: F8) -> F8 {
        let (rx, ry) = (F8::splat(x_m) - rays.x_m, F8::splat(y_m) - rays.y_m);
        let along = rx * rays.dx + ry * rays.dy;
        let across = rx * rays.dy - ry * rays.dx;
        let r2 = F8::splat(radius_m * radius_m);
        let zero = F8::splat(0.0);
        let half = (r2 - across * across).max(zero).sqrt();
        // A ray that starts inside the other body sees it at distance 0.
        let t = (along - half).max(zero);
        let hit = (across * across)
            .lt(r2)
            .and(zero.lt(along + half))
            .and(t.lt(best));
        hit.select(t, best)
    }

    /// Shortens `best` by a movable object, if a robot at (x, y) can see it.
    #[inline(always)]
    pub fn to_object(
        &self,
        shape: &Shape,
        pose: &ObjectPose,
        sight_m: f32,
        rays: &Rays,
        (x_m, y_m): (f32, f32),
        mut best: F8,
    ) -> F8 {
        let (dx_m, dy_m) = (pose.x_m - x_m, pose.y_m - y_m);
        if dx_m * dx_m + dy_m * dy_m > sight_m * sight_m {
            return best;
        }
        let Some([along, across]) = shape.half_sides_m else {
            return self.to_disc(rays, (pose.x_m, pose.y_m), shape.reach_m, best);
        };
        let (ax, ay) = (along * pose.cos, along * pose.sin);
        let (bx, by) = (-across * pose.sin, across * pose.cos);
        let (x_m, y_m) = (pose.x_m, pose.y_m);
        let corners = [
            [x_m - ax - bx, y_m - ay - by],
            [x_m + ax - bx, y_m + ay - by],
            [x_m + ax + bx, y_m + ay + by],
            [x_m - ax + bx, y_m - ay + by],
        ];
        for side in 0..4 {
            best = self.to_segment(rays, corners[side], corners[(side + 1) % 4], best);
        }
        best
    }

    /// Raw values for distances over the ground, with noise from a word unique to this robot and step.
    #[inline(always)]
    pub fn respond(&self, distance_m: F8, noise_word: u64) -> F8 {
        let splat = F8::splat;
        let distance_m = distance_m * splat(self.ray_stretch);
        let first = &self.pieces[0];
        let (mut value, mut value_per_m) = (first.value, first.value_per_m);
        let (mut sd, mut sd_per_m) = (first.sd, first.sd_per_m);
        for piece in &self.pieces[1..self.piece_count] {
            let beyond = piece.from_m.le(distance_m);
            value = beyond.select(piece.value, value);
            value_per_m = beyond.select(piece.value_per_m, value_per_m);
            sd = beyond.select(piece.sd, sd);
            sd_per_m = beyond.select(piece.sd_per_m, sd_per_m);
        }
        let mean = (value + value_per_m * distance_m) * splat(self.gain);
        let relative = (sd + sd_per_m * distance_m) * splat(self.noise);
        let raw = mean * (splat(1.0) + relative * normals(noise_word));
        raw.max(splat(0.0)).min(splat(RAW_MAX))
    }
}

/// Shortens `best` by the segment from `p` to `p + e`, metres.
#[inline(always)]
fn to_line(rays: &Rays, p: [f32; 2], e: [f32; 2], best: F8) -> F8 {
    let (ex, ey) = (F8::splat(e[0]), F8::splat(e[1]));
    let wx = F8::splat(p[0]) - rays.x_m;
    let wy = F8::splat(p[1]) - rays.y_m;
    // origin + t d = p + u e; parallel rays give infinities or NaN, which compare false.
    let inverse = F8::splat(1.0) / (rays.dx * ey - rays.dy * ex);
    let t = (wx * ey - wy * ex) * inverse;
    let u = (wx * rays.dy - wy * rays.dx) * inverse;
    let along = F8::splat(-JOINT).le(u).and(u.le(F8::splat(1.0 + JOINT)));
    let hit = F8::splat(0.0).le(t).and(t.lt(best)).and(along);
    hit.select(t, best)
}
