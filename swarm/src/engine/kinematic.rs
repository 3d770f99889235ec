//! Kinematic contact: a disc is pushed out of walls, with Coulomb friction along them.
//!
//! Sources: robot specification (contact law), Gauss-Seidel projection. Invariant: a disc that
//! began a step at most [`TOLERANCE_M`] inside a wall ends it so, whatever the command; where the
//! projection does not settle the disc stays where it was.

use arenas::index::WallIndex;

use crate::bodies::Body;
use crate::robot::RobotModel;

/// Deepest penetration of a wall that is left standing, metres, in arenas up to a few metres.
pub const TOLERANCE_M: f32 = 1e-5;

/// Most sweeps of the projection.
const SWEEPS: usize = 8;

/// Contact constants of a robot in an arena.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Body radius, metres.
    pub radius_m: f32,
    /// Coulomb friction.
    pub friction: f32,
    /// Restitution.
    pub bounce: f32,
    /// Penetration that does not count as contact, metres.
    pub slop_m: f32,
    /// Penetration that may be left standing, metres.
    pub tolerance_m: f32,
    /// Longest way of a step at top speed, metres.
    pub max_step_m: f32,
}

impl Contact {
    /// The constants of a robot in an arena whose larger side is `size_m`.
    pub fn new(model: &RobotModel, size_m: f64) -> Self {
        let p = &model.parameters;
        // Coordinates are rounded to size * 2^-24; contacts cannot be finer than a few of those.
        let grain = (size_m * f64::from(f32::EPSILON)) as f32;
        Self {
            radius_m: p.body_radius_m as f32,
            friction: p.contact_friction as f32,
            bounce: p.contact_bounce as f32,
            slop_m: 2e-6 + 2.0 * grain,
            tolerance_m: TOLERANCE_M + 4.0 * grain,
            max_step_m: model.max_step_m() as f32,
        }
    }

    /// Distance from a wall within which the index must list it as touchable, metres.
    pub fn wall_margin_m(model: &RobotModel) -> f64 {
        model.parameters.body_radius_m + 3.0 * model.max_step_m() + 1e-3
    }

    /// Moves a body from a place free of walls (`from_m`) to where it wants to be (`x_m`, `y_m`).
    #[inline(always)]
    pub fn move_body(&self, index: &WallIndex, body: &mut Body) {
        let walls = index.touchable(body.x_m, body.y_m);
        body.touched = self.touches(index, walls, body.x_m, body.y_m);
        if body.touched {
            [body.x_m, body.y_m] = self.push_out(index, walls, body.from_m, [body.x_m, body.y_m]);
        }
    }

    /// Where a body ends that goes from a place free of walls to another place. For those that are
    /// pushed: `move_body` does not go by it, as the detour of places through pairs costs a robot-step
    /// some nanoseconds.
    #[inline(always)]
    pub fn free_of_walls(
        &self,
        index: &WallIndex,
        from_m: [f32; 2],
        [x_m, y_m]: [f32; 2],
    ) -> [f32; 2] {
        let walls = index.touchable(x_m, y_m);
        if self.touches(index, walls, x_m, y_m) {
            self.push_out(index, walls, from_m, [x_m, y_m])
        } else {
            [x_m, y_m]
        }
    }

    /// Whether a disc at (x, y) touches any of these walls.
    #[inline(always)]
    fn touches(&self, index: &WallIndex, walls: &[u32], x_m: f32, y_m: f32) -> bool {
        let reach = self.radius_m - self.slop_m;
        let mut closest2 = f32::INFINITY;
        for &number in walls {
            let (_, _, d2) = index.wall(number).nearest(x_m, y_m);
            closest2 = if d2 < closest2 { d2 } else { closest2 };
        }
        closest2 < reach * reach
    }

    /// The part of both that runs only in contact.
    #[inline(never)]
    fn push_out(&self, index: &WallIndex, walls: &[u32], from: [f32; 2], to: [f32; 2]) -> [f32; 2] {
        let [mut x, mut y] = to;
        let reach = self.radius_m - self.slop_m;
        for sweep in 0..SWEEPS {
            let mut deepest = 0.0_f32;
            for &number in walls {
                let (dx, dy, d2) = index.wall(number).nearest(x, y);
                if d2 >= reach * reach {
                    continue;
                }
                let distance = d2.sqrt();
                if distance < 1e-6 {
                    // The centre is on the wall: no normal to push along.
                    return from;
                }
                let depth = self.radius_m - distance;
                deepest = deepest.max(depth);
                let (nx, ny) = (-dx / distance, -dy / distance);
                let push = if sweep == 0 {
                    depth * (1.0 + self.bounce)
                } else {
                    depth
                };
                x += nx * push;
                y += ny * push;
                // Coulomb: the slip of this step along the wall shrinks by friction * depth.
                let slip = (y - from[1]) * nx - (x - from[0]) * ny;
                let brake = slip.abs().min(self.friction * depth).copysign(slip);
                x += ny * brake;
                y -= nx * brake;
            }
            if deepest <= self.slop_m {
                return [x, y];
            }
        }
        let limit = self.radius_m - self.tolerance_m;
        let settled = walls
            .iter()
            .all(|&number| index.wall(number).nearest(x, y).2 >= limit * limit);
        if settled && x.is_finite() && y.is_finite() {
            [x, y]
        } else {
            from
        }
    }
}
