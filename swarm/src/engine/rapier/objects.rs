//! Movable objects among the rigid bodies: boxes and discs that slow down by friction with the floor.
//!
//! The floor takes friction * g of speed a second, and of turning what follows from the same
//! friction under the whole of a disc of equal area. It acts before each solver step; what a robot
//! then pushes gets its share of the robot's momentum, so heavy objects move less than light ones.

use arenas::{Arena, Movable};
use rapier2d::prelude::*;
use serde::{Deserialize, Serialize};

use super::settings::Settings;
use crate::bodies::ObjectPose;

/// Metres a second squared.
const GRAVITY_M_S2: f64 = 9.81;

/// What an object is made of, and where it begins.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Made {
    start: ObjectPose,
    heading_rad: f32,
    /// Half the sides of a box, none for a disc.
    half_sides_m: Option<[f32; 2]>,
    radius_m: f32,
    mass_kg: f32,
    /// Speed that the floor takes in a second, m/s.
    brake_m_s2: f32,
    /// Turning that the floor takes in a second, rad/s.
    brake_rad_s2: f32,
}

impl Made {
    fn new(object: &Movable) -> Self {
        let area_radius_m = match object.half_sides_m() {
            Some([a, b]) => (4.0 * a * b / std::f64::consts::PI).sqrt(),
            None => object.reach_m(),
        };
        let brake_m_s2 = object.friction() * GRAVITY_M_S2;
        Self {
            start: ObjectPose::of(object),
            heading_rad: object.heading_rad() as f32,
            half_sides_m: object.half_sides_m().map(|half| half.map(|m| m as f32)),
            radius_m: object.reach_m() as f32,
            mass_kg: object.mass_kg() as f32,
            brake_m_s2: brake_m_s2 as f32,
            // Friction under a disc turns it back by 2/3 mu m g r; its inertia is m r^2 / 2.
            brake_rad_s2: (4.0 / 3.0 * brake_m_s2 / area_radius_m) as f32,
        }
    }

    /// What friction with the floor leaves of velocities after a time.
    fn braked(&self, way: Vector, turn: f32, part_s: f32) -> (Vector, f32) {
        let (speed, lost) = (way.length(), self.brake_m_s2 * part_s);
        let kept = if speed > lost {
            (speed - lost) / speed
        } else {
            0.0
        };
        let left = (turn.abs() - self.brake_rad_s2 * part_s).max(0.0);
        (way * kept, if turn < 0.0 { -left } else { left })
    }
}

/// A step of the solver, as objects meet it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    /// Time passes.
    Timed {
        /// How much, seconds.
        part_s: f32,
    },
    /// Robots bounce, and everything else stands still.
    Timeless,
}

/// All movable objects of an arena.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Objects {
    made: Vec<Made>,
    bodies: Vec<RigidBodyHandle>,
    size_m: [f32; 2],
    #[serde(skip)]
    before: Vec<Pose>,
    /// Velocities before the step.
    #[serde(skip)]
    held: Vec<(Vector, f32)>,
}

impl Objects {
    pub fn new(arena: &Arena) -> Self {
        Self {
            made: arena.objects().iter().map(Made::new).collect(),
            bodies: Vec::new(),
            size_m: [arena.width_m() as f32, arena.height_m() as f32],
            before: Vec::new(),
            held: Vec::new(),
        }
    }

    /// Puts them where they begin; called when bodies are made anew, after the robots.
    pub fn place(&mut self, world: &mut PhysicsWorld, settings: &Settings) {
        self.bodies.clear();
        for made in &self.made {
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(made.start.x_m, made.start.y_m))
                .rotation(made.heading_rad)
                .can_sleep(false);
            let shape = match made.half_sides_m {
                Some([along, across]) => ColliderBuilder::cuboid(along, across),
                None => ColliderBuilder::ball(made.radius_m),
            };
            let (body, _) = world.insert(body, settings.surface(shape.mass(made.mass_kg)));
            self.bodies.push(body);
        }
    }

    /// Readies objects for a step of the solver.
    ///
    /// Bodies are touched only where something changes, as rapier looks again at those that are.
    pub fn before_step(&mut self, world: &mut PhysicsWorld, part: Part) {
        self.before.clear();
        self.held.clear();
        for (made, &handle) in self.made.iter().zip(&self.bodies) {
            let body = &world.bodies[handle];
            self.before.push(*body.position());
            let (way, turn) = (body.linvel(), body.angvel());
            self.held.push((way, turn));
            let slowed = match part {
                Part::Timed { part_s } => made.braked(way, turn, part_s),
                Part::Timeless => (Vector::ZERO, 0.0),
            };
            if slowed != (way, turn) {
                set_velocity(&mut world.bodies[handle], slowed);
            }
        }
    }

    /// After the step: puts back what went through a wall, left the arena or is no longer finite,
    /// and gives velocities back where no time passed.
    pub fn after_step(&mut self, world: &mut PhysicsWorld, part: Part, walls_m: &[[f32; 4]]) {
        let known = self.before.iter().zip(&self.held);
        for (&handle, (&before, &held)) in self.bodies.iter().zip(known) {
            let body = &world.bodies[handle];
            let (from, to) = (before.translation, body.translation());
            // False for NaN.
            let inside = to.x > 0.0 && to.y > 0.0 && to.x < self.size_m[0] && to.y < self.size_m[1];
            let rotation = body.rotation();
            let sound = inside && rotation.re.is_finite() && body.is_enabled();
            if !sound || (from != to && walls_m.iter().any(|wall| crosses(from, to, wall))) {
                let body = &mut world.bodies[handle];
                body.set_enabled(true);
                body.set_position(before, false);
                set_velocity(body, (Vector::ZERO, 0.0));
            }
            let body = &world.bodies[handle];
            if part == Part::Timeless && (body.linvel(), body.angvel()) != held {
                set_velocity(&mut world.bodies[handle], held);
            }
        }
    }

    /// Where they are.
    pub fn poses<'a>(
        &'a self,
        world: &'a PhysicsWorld,
    ) -> impl ExactSizeIterator<Item = ObjectPose> + 'a {
        self.bodies.iter().map(|&handle| {
            let body = &world.bodies[handle];
            let (place, rotation) = (body.translation(), body.rotation());
            ObjectPose {
                x_m: place.x,
                y_m: place.y,
                cos: rotation.re,
                sin: rotation.im,
            }
        })
    }
}

fn set_velocity(body: &mut RigidBody, (way, turn): (Vector, f32)) {
    body.set_linvel(way, false);
    body.set_angvel(turn, false);
}

/// Whether the way of a centre runs through a wall.
fn crosses(from: Vector, to: Vector, &[x1, y1, x2, y2]: &[f32; 4]) -> bool {
    let side = |a: [f32; 2], b: [f32; 2], c: [f32; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let (f, t, a, b) = ([from.x, from.y], [to.x, to.y], [x1, y1], [x2, y2]);
    side(a, b, f) * side(a, b, t) < 0.0 && side(f, t, a) * side(f, t, b) < 0.0
}
