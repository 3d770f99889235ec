//! Rigid bodies of rapier2d: discs with mass, friction and bounce that push walls and each other.
//!
//! Wheels and headings are integrated elsewhere; here rotation is locked and each step turns the
//! displacement that a robot wants into a velocity. Settings were tuned for 64 ms steps.

mod objects;
mod settings;

use arenas::{Arena, Segment};
use rapier2d::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bodies::ObjectPose;
use crate::robot::RobotModel;
use objects::{Objects, Part};
use settings::Settings;

/// Deviations that are rounding and no contact: metres, and units in the last place of the
/// coordinate (one and a half for the target and the body, half a unit for each solver substep).
const ROUNDING_M: f32 = 1e-6;
const ROUNDING_ULPS: f32 = 3.0;

/// Rigid bodies for all robots of one arena.
///
/// Robots come first among the bodies and walls first among the colliders; whatever else is to be
/// pushed around goes behind them.
///
/// Serialised, it holds everything that the future depends on, contacts included: a restored
/// engine goes on bit for bit. Equal engines give equal bytes.
#[derive(Serialize, Deserialize)]
pub struct RapierEngine {
    settings: Settings,
    /// Ends of all walls, the boundary first: x1, y1, x2, y2 in metres.
    walls_m: Vec<[f32; 4]>,
    world: PhysicsWorld,
    /// The body of each robot, by the robot's number.
    robots: Vec<RigidBodyHandle>,
    objects: Objects,
    #[serde(skip)]
    scratch: Scratch,
}

/// Buffers that live within one step.
#[derive(Default)]
struct Scratch {
    /// What contacts added to each robot's way.
    pushes_m: Vec<Vector>,
    /// How far each robot bounces back, along x and y.
    rebound_m: [Vec<f32>; 2],
}

impl RapierEngine {
    /// The engine of an arena with one robot of the model at each (x, y), metres.
    pub fn new(arena: &Arena, model: &RobotModel, x_m: &[f32], y_m: &[f32]) -> Self {
        let ends_m = |s: &Segment| [s.a.x, s.a.y, s.b.x, s.b.y].map(|v| v as f32);
        let mut engine = Self {
            settings: Settings::new(model),
            walls_m: arena
                .boundary()
                .iter()
                .chain(arena.walls())
                .map(ends_m)
                .collect(),
            world: PhysicsWorld::new(),
            robots: Vec::new(),
            objects: Objects::new(arena),
            scratch: Scratch::default(),
        };
        engine.place(x_m, y_m);
        engine
    }

    /// Whether it has a body for each of so many robots, as what was read back might not.
    pub fn fits(&self, robots: usize) -> bool {
        let known = |robot: &RigidBodyHandle| self.world.bodies.contains(*robot);
        self.robots.len() == robots && self.robots.iter().all(known)
    }

    /// An engine that is the same, by what is saved of it.
    pub fn copy(&self) -> Option<Self> {
        let saved = postcard::to_stdvec(self).ok()?;
        postcard::from_bytes(&saved).ok()
    }

    /// Where the movable objects are, in the order of the arena's.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = ObjectPose> + '_ {
        self.objects.poses(&self.world)
    }

    /// Puts one robot at each (x, y), metres, in place of those that were there, and movable
    /// objects where they begin.
    ///
    /// All bodies are made anew, so that nothing of the past is left: the same places have the same
    /// future, bit for bit.
    pub fn place(&mut self, x_m: &[f32], y_m: &[f32]) {
        let settings = &self.settings;
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters = settings.integration();
        for &[x1, y1, x2, y2] in &self.walls_m {
            let wall = ColliderBuilder::segment(Vector::new(x1, y1), Vector::new(x2, y2));
            world.insert_collider(settings.surface(wall), None);
        }
        self.robots.clear();
        for (&x, &y) in x_m.iter().zip(y_m) {
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(x, y))
                .lock_rotations()
                .can_sleep(false);
            let disc = ColliderBuilder::ball(settings.radius_m).mass(settings.mass_kg);
            let (robot, _) = world.insert(body, settings.surface(disc));
            self.robots.push(robot);
        }
        self.objects.place(&mut world, settings);
        self.world = world;
    }

    /// One control step: robot `i` wants to go by (`dx_m[i]`, `dy_m[i]`) from (`x_m[i]`, `y_m[i]`),
    /// where the last step or [`Self::place`] left it.
    ///
    /// Writes where each robot ended and whether something was in its way or pushed it. Without
    /// contact that is exactly the f32 sum of place and displacement (of parts of the displacement
    /// where the robot covers more than half its radius in a step). A displacement that is not
    /// finite or beyond the model's top speed by far is not made; it counts as touched.
    ///
    /// # Panics
    /// If a slice has another length than the number of robots.
    pub fn step(
        &mut self,
        x_m: &mut [f32],
        y_m: &mut [f32],
        dx_m: &[f32],
        dy_m: &[f32],
        touched: &mut [bool],
    ) {
        let robots = self.robots.len();
        let lengths = [x_m.len(), y_m.len(), dx_m.len(), dy_m.len(), touched.len()];
        assert_eq!(lengths, [robots; 5], "one entry a robot");
        touched.fill(false);
        // Part of the scratch that a restored world begins anew, hence not once and for all.
        self.world.physics_pipeline.counters.disable();
        let share = 1.0 / self.settings.parts as f32;
        for _ in 0..self.settings.parts {
            let part_s = self.settings.part_s;
            self.part(
                x_m,
                y_m,
                dx_m,
                dy_m,
                (Part::Timed { part_s }, share),
                touched,
            );
            if self.settings.bounce > 0.0 && self.rebound() {
                let [back_x_m, back_y_m] = std::mem::take(&mut self.scratch.rebound_m);
                self.part(
                    x_m,
                    y_m,
                    &back_x_m,
                    &back_y_m,
                    (Part::Timeless, 1.0),
                    touched,
                );
                self.scratch.rebound_m = [back_x_m, back_y_m];
            }
        }
    }

    /// Puts one robot elsewhere at once, without speed.
    pub fn put(&mut self, robot: usize, [x_m, y_m]: [f32; 2]) {
        restore(
            &mut self.world.bodies[self.robots[robot]],
            Vector::new(x_m, y_m),
        );
    }

    /// Finds how far each robot bounces off what just pushed it, and whether any does.
    ///
    /// Restitution as in the kinematic engine: the push along the normal counts `1 + bounce` times.
    /// rapier's own restitution acts on the velocity that a step ends with, and the next step's
    /// command would overwrite that unseen.
    fn rebound(&mut self) -> bool {
        let [back_x_m, back_y_m] = &mut self.scratch.rebound_m;
        back_x_m.clear();
        back_y_m.clear();
        let mut any = false;
        for (&robot, &push) in self.robots.iter().zip(&self.scratch.pushes_m) {
            let mut back = Vector::ZERO;
            if push != Vector::ZERO {
                let normal = contact_normal(&self.world, robot);
                back = normal * (self.settings.bounce * push.dot(normal).max(0.0));
                any |= back != Vector::ZERO;
            }
            back_x_m.push(back.x);
            back_y_m.push(back.y);
        }
        any
    }

    /// Moves the bodies by `share` of the displacements.
    fn part(
        &mut self,
        x_m: &mut [f32],
        y_m: &mut [f32],
        dx_m: &[f32],
        dy_m: &[f32],
        (part, share): (Part, f32),
        touched: &mut [bool],
    ) {
        let parts_per_s = 1.0 / self.settings.part_s;
        let limit2 = self.settings.travel_limit_m * self.settings.travel_limit_m;
        let sound = |way: Vector| way.length_squared() <= limit2; // False for NaN.

        for (i, &robot) in self.robots.iter().enumerate() {
            let body = &mut self.world.bodies[robot];
            let target = Vector::new(x_m[i] + share * dx_m[i], y_m[i] + share * dy_m[i]);
            // The body may lie a rounding error beside its robot; that is made good here.
            let way = target - body.translation();
            let way = if sound(way) { way } else { Vector::ZERO };
            body.set_linvel(way * parts_per_s, false);
        }
        self.objects.before_step(&mut self.world, part);
        self.world.step();
        self.objects
            .after_step(&mut self.world, part, &self.walls_m);

        self.scratch.pushes_m.clear();
        for (i, &robot) in self.robots.iter().enumerate() {
            let body = &self.world.bodies[robot];
            let start = Vector::new(x_m[i], y_m[i]);
            let target = start + share * Vector::new(dx_m[i], dy_m[i]);
            let end = body.translation();
            let rounding_m = ROUNDING_M + ROUNDING_ULPS * f32::EPSILON * target.abs().max_element();
            let off = (end - target).abs();
            let place = if off.x <= rounding_m && off.y <= rounding_m && sound(target - start) {
                target
            } else if sound(end - start) && body.is_enabled() {
                touched[i] = true;
                end
            } else {
                touched[i] = true;
                restore(&mut self.world.bodies[robot], start);
                start
            };
            self.scratch.pushes_m.push(place - target);
            (x_m[i], y_m[i]) = (place.x, place.y);
        }
    }
}

/// The direction in which the contacts of the last step pushed a robot, friction left out; zero
/// without contact.
fn contact_normal(world: &PhysicsWorld, robot: RigidBodyHandle) -> Vector {
    let mut impulse = Vector::ZERO;
    for &disc in world.bodies[robot].colliders() {
        for pair in world.narrow_phase.contact_pairs_with(disc) {
            // What the second collider feels; the first feels the opposite.
            let of_pair = pair.total_impulse();
            impulse += if pair.collider2 == disc {
                of_pair
            } else {
                -of_pair
            };
        }
    }
    impulse.normalize_or_zero()
}

/// Puts a body back that went too far, or that rapier disabled because it was no longer finite.
fn restore(body: &mut RigidBody, place: Vector) {
    body.set_enabled(true);
    body.set_translation(place, false);
    body.set_linvel(Vector::ZERO, false);
}

#[cfg(test)]
mod tests;
