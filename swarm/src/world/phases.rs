//! The phases of a step for some robots that are stored one after the other: account, sense, learn,
//! decide, move. Each takes every robot by itself and reads nothing that another robot changes in
//! it, so neither the order of robots nor the number of threads can matter.

use arenas::index::WallIndex;

use super::grid::Grid;
use super::object_grid::ObjectGrid;
use crate::bodies::{Body, ObjectPose};
use crate::controllers::Controllers;
use crate::engine::cells::{Cells, MOST_SEEN, Seen};
use crate::engine::drive::Drive;
use crate::engine::kinematic::Contact;
use crate::engine::near::NearChunk;
use crate::prefetch::prefetch;
use crate::random::{mix64, unit};
use crate::sensors::proximity::Optics;

/// How many robots ahead learners are told that their turn comes.
const AHEAD: usize = 4;

/// How many robots ahead what a learner consists of is asked for, so that it can be told.
const FAR: usize = 10;

/// What the phases read, the same for all robots.
#[derive(Clone, Copy)]
pub struct Phases<'a> {
    pub optics: &'a Optics,
    pub index: &'a WallIndex,
    pub drive: &'a Drive,
    pub contact: &'a Contact,
    pub grid: Grid,
    pub objects: &'a ObjectGrid,
    pub poses: &'a [ObjectPose],
    pub noise_keys: &'a [u64],
    pub slip_keys: &'a [u64],
    /// Robots' numbers by slot.
    pub numbers: &'a [u32],
    /// Counter of the sensors' noise.
    pub noise: u64,
    /// Whether what robots need of the arena comes from far.
    pub is_large: bool,
}

/// Controllers of robots that are stored one after the other, reached by their places.
pub trait Steered<C: Controllers + ?Sized> {
    /// What the robot of a place has.
    fn robot(&mut self, place: usize) -> &mut C::Robot;

    /// The same of a robot whose turn comes, as far as it can be told.
    fn ahead(&self, place: usize) -> Option<&C::Robot>;

    /// The same of one whose turn comes later.
    fn far(&self, place: usize) -> Option<&C::Robot>;
}

/// All controllers by number, and the numbers of the robots from the first on.
pub struct ByNumber<'a, R> {
    pub robots: &'a mut [R],
    pub numbers: &'a [u32],
}

impl<C: Controllers + ?Sized> Steered<C> for ByNumber<'_, C::Robot> {
    #[inline(always)]
    fn robot(&mut self, place: usize) -> &mut C::Robot {
        &mut self.robots[self.numbers[place] as usize]
    }

    #[inline(always)]
    fn ahead(&self, place: usize) -> Option<&C::Robot> {
        let number = *self.numbers.get(place + AHEAD)?;
        Some(&self.robots[number as usize])
    }

    #[inline(always)]
    fn far(&self, place: usize) -> Option<&C::Robot> {
        let number = *self.numbers.get(place + FAR)?;
        Some(&self.robots[number as usize])
    }
}

/// Controllers in the order of slots, for threads that have some each.
pub struct BySlot<'a, 'b, R>(pub &'a mut [Option<&'b mut R>]);

impl<C: Controllers + ?Sized> Steered<C> for BySlot<'_, '_, C::Robot> {
    #[inline(always)]
    fn robot(&mut self, place: usize) -> &mut C::Robot {
        match &mut self.0[place] {
            Some(robot) => robot,
            None => unreachable!("a robot without a controller"),
        }
    }

    #[inline(always)]
    fn ahead(&self, place: usize) -> Option<&C::Robot> {
        self.0.get(place + AHEAD)?.as_deref()
    }

    #[inline(always)]
    fn far(&self, place: usize) -> Option<&C::Robot> {
        self.0.get(place + FAR)?.as_deref()
    }
}

impl Phases<'_> {
    /// Notes way, contact and square of each robot, and tells `count` of slot, square and whether it
    /// was entered. Gives the robots in contact.
    #[inline(always)]
    pub fn account(
        &self,
        first: usize,
        bodies: &mut [Body],
        mut count: impl FnMut(usize, u32, bool),
    ) -> u64 {
        let mut touched = 0;
        for (place, body) in bodies.iter_mut().enumerate() {
            let square = self.grid.square_of(body.x_m, body.y_m);
            let entered = square != body.square;
            let (dx_m, dy_m) = (body.x_m - body.from_m[0], body.y_m - body.from_m[1]);
            touched += u64::from(body.touched);
            body.square = square;
            body.distance_m += f64::from((dx_m * dx_m + dy_m * dy_m).sqrt());
            count(first + place, square, entered);
        }
        touched
    }

    /// Reads the sensors of a robot that is alone.
    #[inline(always)]
    pub fn sense_alone(&self, bodies: &mut [Body]) {
        let (optics, poses) = (self.optics, self.poses);
        for (body, key) in bodies.iter_mut().zip(self.noise_keys) {
            let (x_m, y_m) = (body.x_m, body.y_m);
            let rays = optics.rays(x_m, y_m, body.cos, body.sin);
            let mut distance_m = optics.to_walls(&rays, self.index, x_m, y_m);
            if !poses.is_empty() {
                distance_m = self
                    .objects
                    .see(optics, poses, &rays, (x_m, y_m), distance_m);
            }
            let word = mix64(key.wrapping_add(self.noise));
            body.reading.proximity = optics.respond(distance_m, word).0;
        }
    }

    /// Reads all sensors where robots stand, and notes whom they may touch.
    #[inline(always)]
    pub fn sense(&self, cells: &Cells, first: usize, bodies: &mut [Body], near: &mut NearChunk) {
        let (optics, poses) = (self.optics, self.poses);
        let mut seen: Seen = [[0.0; 2]; MOST_SEEN];
        if self.is_large {
            for body in &*bodies {
                prefetch(self.index.cell(body.x_m, body.y_m));
            }
            for list in bodies.iter().filter_map(|b| self.index.list(b.x_m, b.y_m)) {
                prefetch(list);
            }
        }
        for (place, body) in bodies.iter_mut().enumerate() {
            let slot = first + place;
            let (x_m, y_m) = (body.x_m, body.y_m);
            // Before the walls: who is in sight is not known at once, and needed after them.
            let count = cells.look_around(slot, (x_m, y_m), self.numbers, near, &mut seen);
            let rays = optics.rays(x_m, y_m, body.cos, body.sin);
            let mut distance_m = optics.to_walls(&rays, self.index, x_m, y_m);
            if count < MOST_SEEN {
                for &[ox_m, oy_m] in &seen[..count] {
                    distance_m = optics.to_robot(&rays, ox_m, oy_m, distance_m);
                }
            } else {
                cells.each_in_sight(slot, (x_m, y_m), &mut |ox_m, oy_m| {
                    distance_m = optics.to_robot(&rays, ox_m, oy_m, distance_m);
                });
            }
            if !poses.is_empty() {
                distance_m = self
                    .objects
                    .see(optics, poses, &rays, (x_m, y_m), distance_m);
            }
            let word = mix64(self.noise_keys[slot].wrapping_add(self.noise));
            body.reading.proximity = optics.respond(distance_m, word).0;
        }
    }

    /// Lets controllers see what the move brought.
    #[inline(always)]
    pub fn learn<C: Controllers + ?Sized>(
        &self,
        common: &C::Common,
        bodies: &[Body],
        steered: &mut impl Steered<C>,
    ) {
        for (place, body) in bodies.iter().enumerate() {
            if C::ARE_LARGE
                && let Some(robot) = steered.far(place)
            {
                prefetch(robot);
            }
            if let Some(robot) = steered.ahead(place) {
                C::expect_learning(robot);
            }
            C::learn(common, steered.robot(place), &body.reading);
        }
    }

    /// Asks controllers for commands and notes where they would take the robots.
    #[inline(always)]
    pub fn decide_and_drive<C: Controllers + ?Sized>(
        &self,
        common: &C::Common,
        step: u64,
        first: usize,
        bodies: &mut [Body],
        steered: &mut impl Steered<C>,
        moves: Moves,
    ) {
        let drive = self.drive;
        if C::ARE_LARGE {
            for (place, body) in bodies.iter().enumerate() {
                if let Some(robot) = steered.ahead(place) {
                    C::expect_acting(robot);
                }
                C::choose(common, steered.robot(place), step, &body.reading);
            }
        }
        for (place, body) in bodies.iter_mut().enumerate() {
            if !C::ARE_LARGE {
                if let Some(robot) = steered.ahead(place) {
                    C::expect_acting(robot);
                }
                C::choose(common, steered.robot(place), step, &body.reading);
            }
            let command = C::act(common, steered.robot(place), step, &body.reading);
            body.command = command;
            let left = drive.accelerate(body.wheels_rad_s[0], command[0]);
            let right = drive.accelerate(body.wheels_rad_s[1], command[1]);
            body.wheels_rad_s = [left, right];
            let (mut ground_left, mut ground_right) = (left, right);
            if drive.slips() {
                let word = mix64(self.slip_keys[first + place].wrapping_add(mix64(step)));
                ground_left = drive.slipped(left, unit(word as u32));
                ground_right = drive.slipped(right, unit((word >> 32) as u32));
            }
            let motion = drive.step(ground_left, ground_right, body.cos, body.sin);
            body.from_m = [body.x_m, body.y_m];
            body.x_m += motion.dx_m;
            body.y_m += motion.dy_m;
            body.cos = motion.cos;
            body.sin = motion.sin;
            if moves == Moves::AtOnce {
                self.contact.move_body(self.index, body);
            }
        }
        if moves == Moves::AfterAll {
            for body in bodies {
                self.contact.move_body(self.index, body);
            }
        }
    }
}

/// When robots that were driven meet the walls.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Moves {
    /// As soon as each was driven.
    AtOnce,
    /// Once those that are taken together were driven: faster for many.
    AfterAll,
    /// In the engine.
    Elsewhere,
}
