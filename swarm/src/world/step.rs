//! The phases of a step: decide and drive, collide, account, sense, learn.
//!
//! Every phase takes each robot by itself, from state that no other robot changes in that phase, so
//! the order of robots cannot matter. They are taken in the order in which they are stored, which
//! is put in the order of cells now and then, so that what is read together stays in the cache.

use super::{Backend, World, WorldState};
use crate::controllers::{Controller, Controllers};
use crate::engine::EngineState;
use crate::random::{mix64, unit};

/// Odd, close to 2^64 / golden ratio: spreads counters over all words.
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// How many robots ahead learners are told that their turn comes.
const AHEAD: usize = 4;

/// Steps after which robots are stored in the order of their cells again: by then the fastest are
/// some rows of cells away from those that they are stored with.
const SETTLED_STEPS: u32 = 256;

impl World {
    /// Moves every robot `steps` times; `controllers` has one entry a robot.
    pub fn advance<P: Controller>(&mut self, controllers: &mut [P], steps: u64) {
        self.advance_all(controllers, steps);
    }

    /// As [`World::advance`], with robots that may have to do with each other.
    pub fn advance_all<C: Controllers + ?Sized>(&mut self, controllers: &mut C, steps: u64) {
        assert_eq!(controllers.len(), self.robots(), "one controller a robot");
        match self.backend {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Avx2` is only ever set after detection.
            Backend::Avx2 => unsafe { advance_avx2(self, controllers, steps) },
            _ => self.steps(controllers, steps),
        }
    }

    /// Reads all sensors where robots stand.
    pub(super) fn sense_all(&mut self) {
        match self.backend {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Avx2` is only ever set after detection.
            Backend::Avx2 => unsafe { sense_avx2(self) },
            _ => self.sense(),
        }
    }

    #[inline(always)]
    fn steps<C: Controllers + ?Sized>(&mut self, controllers: &mut C, steps: u64) {
        for _ in 0..steps {
            self.decide_and_drive(controllers);
            self.collide();
            self.account();
            self.sense();
            self.learn(controllers);
            controllers.end_step(self.state.step, &self.state.bodies);
            self.state.step += 1;
        }
    }

    #[inline(always)]
    fn decide_and_drive<C: Controllers + ?Sized>(&mut self, controllers: &mut C) {
        let step = self.state.step;
        let drive = &self.drive;
        let alone = matches!((&self.engine, &self.crowd), (EngineState::Kinematic, None));
        let (bodies, numbers) = self.state.bodies.stored_mut();
        for (i, body) in bodies.iter_mut().enumerate() {
            if i + AHEAD < numbers.len() {
                controllers.expect_acting(numbers[i + AHEAD] as usize);
            }
            let command = controllers.act(numbers[i] as usize, step, &body.reading);
            body.command = command;
            let left = drive.accelerate(body.wheels_rad_s[0], command[0]);
            let right = drive.accelerate(body.wheels_rad_s[1], command[1]);
            body.wheels_rad_s = [left, right];
            let (mut ground_left, mut ground_right) = (left, right);
            if drive.slips() {
                let word = mix64(self.slip_keys[i].wrapping_add(mix64(step)));
                ground_left = drive.slipped(left, unit(word as u32));
                ground_right = drive.slipped(right, unit((word >> 32) as u32));
            }
            let motion = drive.step(ground_left, ground_right, body.cos, body.sin);
            body.from_m = [body.x_m, body.y_m];
            body.x_m += motion.dx_m;
            body.y_m += motion.dy_m;
            body.cos = motion.cos;
            body.sin = motion.sin;
            if alone {
                self.contact.move_body(&self.index, body);
            }
        }
    }

    #[inline(always)]
    fn learn<C: Controllers + ?Sized>(&mut self, controllers: &mut C) {
        let (bodies, numbers) = self.state.bodies.stored_mut();
        for (i, body) in bodies.iter().enumerate() {
            if i + AHEAD < numbers.len() {
                controllers.expect_learning(numbers[i + AHEAD] as usize);
            }
            controllers.learn(numbers[i] as usize, &body.reading);
        }
    }

    #[inline(always)]
    fn collide(&mut self) {
        let bodies = &mut self.state.bodies;
        match (&mut self.engine, &mut self.crowd) {
            // Moved as soon as it was driven.
            (EngineState::Kinematic, None) => {}
            (EngineState::Kinematic, Some(crowd)) => {
                let (bodies, _) = bodies.stored_mut();
                for body in bodies.iter_mut() {
                    self.contact.move_body(&self.index, body);
                }
                crowd.separate(&self.contact, &self.index, bodies);
            }
            (EngineState::Rapier(engine), crowd) => {
                engine.step(bodies);
                if let Some(crowd) = crowd {
                    // rapier's contacts are soft: what is left of an overlap is parted here.
                    crowd.separate(&self.contact, &self.index, bodies.stored_mut().0);
                    engine.correct(bodies);
                }
                let objects = &mut self.state.objects;
                if !objects.poses.is_empty() {
                    objects.follow(engine.objects(), self.counting);
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn square_of(&self, x_m: f32, y_m: f32) -> u32 {
        self.grid.square_of(x_m, y_m)
    }

    #[inline(always)]
    fn account(&mut self) {
        if !self.counting {
            return;
        }
        let grid = self.grid;
        let WorldState {
            bodies,
            visits,
            tally,
            collisions,
            ..
        } = &mut self.state;
        tally.step();
        self.arrivals.clear();
        let (stored, _) = bodies.stored_mut();
        for (slot, body) in stored.iter_mut().enumerate() {
            let square = grid.square_of(body.x_m, body.y_m);
            let entered = square != body.square;
            let (dx_m, dy_m) = (body.x_m - body.from_m[0], body.y_m - body.from_m[1]);
            *collisions += u64::from(body.touched);
            body.square = square;
            body.distance_m += f64::from((dx_m * dx_m + dy_m * dy_m).sqrt());
            let visit = &mut visits[square as usize];
            visit[0] = visit[0].saturating_add(u32::from(entered));
            // One test for both: the first step in the square, and the last that can be counted.
            let steps = visit[1].wrapping_add(1);
            if steps <= 1 {
                self.arrivals.push(slot as u32);
            } else {
                visit[1] = steps;
            }
        }
        tally.see(bodies);
        if !self.arrivals.is_empty() {
            self.count_arrivals();
        }
    }

    /// Counts the step of robots in squares that have none so far, or as many as can be counted. Of
    /// several robots the one with the lowest number is the first in its square.
    #[cold]
    #[inline(never)]
    fn count_arrivals(&mut self) {
        let (stored, numbers) = self.state.bodies.stored_mut();
        self.arrivals
            .sort_unstable_by_key(|&slot| numbers[slot as usize]);
        for &slot in &self.arrivals {
            let body = &mut stored[slot as usize];
            let steps = &mut self.state.visits[body.square as usize][1];
            self.state.tally.enter(body.square, body);
            *steps = steps.saturating_add(1);
        }
    }

    /// Sorts robots into cells, and now and then stores them in that order.
    #[inline(always)]
    fn sort(&mut self) {
        if let Some(crowd) = &mut self.crowd {
            crowd.sort(self.state.bodies.stored());
            if self.settled_steps == 0 {
                self.settled_steps = SETTLED_STEPS;
                self.store_by_cell();
            }
            self.settled_steps -= 1;
        }
    }

    #[inline(always)]
    fn sense(&mut self) {
        self.sort();
        let (optics, index) = (&self.optics, &*self.index);
        let poses = &self.state.objects.poses[..];
        self.object_grid.update(poses);
        let objects = &self.object_grid;
        let counter = self.state.readings.wrapping_mul(SPREAD);
        self.state.readings += 1;
        let (bodies, numbers) = self.state.bodies.stored_mut();
        match &mut self.crowd {
            None => {
                for (body, key) in bodies.iter_mut().zip(&self.noise_keys) {
                    let rays = optics.rays(body.x_m, body.y_m, body.cos, body.sin);
                    let mut distance_m = optics.to_walls(&rays, index, body.x_m, body.y_m);
                    if !poses.is_empty() {
                        distance_m =
                            objects.see(optics, poses, &rays, (body.x_m, body.y_m), distance_m);
                    }
                    body.reading.proximity = optics
                        .respond(distance_m, mix64(key.wrapping_add(counter)))
                        .0;
                }
            }
            Some(crowd) => {
                for (slot, body) in bodies.iter_mut().enumerate() {
                    let (x_m, y_m) = (body.x_m, body.y_m);
                    // Before the walls: who is in sight is not known at once, and needed after them.
                    let robots = crowd.look_around(slot, x_m, y_m, numbers);
                    let rays = optics.rays(x_m, y_m, body.cos, body.sin);
                    let mut distance_m = optics.to_walls(&rays, index, x_m, y_m);
                    for &[ox_m, oy_m] in robots {
                        distance_m = optics.to_robot(&rays, ox_m, oy_m, distance_m);
                    }
                    if !poses.is_empty() {
                        distance_m = objects.see(optics, poses, &rays, (x_m, y_m), distance_m);
                    }
                    let word = mix64(self.noise_keys[slot].wrapping_add(counter));
                    body.reading.proximity = optics.respond(distance_m, word).0;
                }
            }
        }
    }

    /// Rebuilds the scratch that depends on positions.
    pub(super) fn find_neighbours(&mut self) {
        if let Some(crowd) = &mut self.crowd {
            let (bodies, numbers) = self.state.bodies.stored_mut();
            crowd.sort(bodies);
            for (slot, body) in bodies.iter().enumerate() {
                crowd.look_around(slot, body.x_m, body.y_m, numbers);
            }
        }
    }

    /// Stores robots in the order of the cells into which they have just been sorted.
    #[inline(never)]
    fn store_by_cell(&mut self) {
        let Some(crowd) = &mut self.crowd else { return };
        crowd.settle(|a, b| {
            self.state.bodies.swap(a, b);
            self.noise_keys.swap(a, b);
            if !self.slip_keys.is_empty() {
                self.slip_keys.swap(a, b);
            }
        });
        self.state.bodies.renumber();
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn advance_avx2<C: Controllers + ?Sized>(world: &mut World, controllers: &mut C, steps: u64) {
    world.steps(controllers, steps);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn sense_avx2(world: &mut World) {
    world.sense();
}
