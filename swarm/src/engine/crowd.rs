//! Robots against each other in the kinematic engine.
//!
//! Overlaps are pushed apart half and half by Jacobi iterations, in which every robot reads only
//! the last iteration's positions, so that order and thread count cannot matter. Whoever still
//! overlaps goes back to where the step began, together with whoever that blocks: positions before
//! the step were free of overlap, so this ends, and no overlap above [`OVERLAP_M`] survives a step.

use arenas::index::WallIndex;
use rayon::prelude::*;

use super::cells::{Cells, MOST_SEEN, Place};
use super::kinematic::Contact;
use super::near::{CHUNK, Near};
use crate::bodies::Body;
use crate::prefetch::prefetch;

/// Deepest overlap of two robots that is left standing, metres.
pub const OVERLAP_M: f32 = 5e-5;

const ITERATIONS: usize = 8;

/// Robots from which on what they need comes from far, and is asked for in time.
pub const LARGE: usize = 32_768;

/// Fewest robots to be pushed that several threads share.
const SHARED: usize = 512;

/// A robot that goes elsewhere, and where to.
type Move = (u32, f32, f32);

/// Stands for no move.
const STAYS: Move = (u32::MAX, 0.0, 0.0);

/// Scratch of an arena with several robots; can be rebuilt from positions at any time. Robots are
/// known by their slots, the places in which their bodies are stored.
#[derive(Clone, Debug)]
pub struct Crowd {
    /// Who is where.
    pub cells: Cells,
    /// Who may touch whom in the next step.
    pub near: Near,
    /// Where robots are while they are parted and sorted, by slot: a copy, as bodies are too far
    /// apart for those that look at all of them.
    pub places: Vec<Place>,
    /// Robots that may overlap, in its first `active_count` places.
    active: Vec<u32>,
    active_count: usize,
    /// Robots found in each chunk; only while several threads look.
    found: Vec<u32>,
    /// Robots that go elsewhere, in its first `moved_count` places.
    moved: Vec<Move>,
    moved_count: usize,
    stamp: Vec<u32>,
    round: u32,
}

impl Crowd {
    /// Scratch for `robots` robots in an arena, seeing each other up to `sight_m` between centres.
    pub fn new(
        robots: usize,
        width_m: f64,
        height_m: f64,
        contact: &Contact,
        sight_m: f64,
    ) -> Self {
        let candidate_m = 2.0 * contact.radius_m + 4.0 * contact.max_step_m;
        let apart_m = f64::from(2.0 * (contact.radius_m - OVERLAP_M));
        Self {
            cells: Cells::new(robots, (width_m, height_m), sight_m, candidate_m),
            near: Near::new(robots, f64::from(candidate_m), apart_m),
            places: vec![[0.0; 2]; robots],
            active: vec![0; robots],
            active_count: 0,
            found: Vec::new(),
            moved: vec![STAYS; robots],
            moved_count: 0,
            stamp: vec![0; robots],
            round: 0,
        }
    }

    /// Notes where robots are.
    pub fn locate(&mut self, bodies: &[Body]) {
        locate(bodies, &mut self.places);
    }

    /// Notes contact candidates of robots that were sorted into cells.
    pub fn note_candidates(&mut self, bodies: &[Body], numbers: &[u32]) {
        let mut seen = [[0.0; 2]; MOST_SEEN];
        let chunks = self.near.chunks_mut().zip(bodies.chunks(CHUNK));
        for (number, (mut chunk, bodies)) in chunks.enumerate() {
            for (place, body) in bodies.iter().enumerate() {
                let (slot, at_m) = (number * CHUNK + place, (body.x_m, body.y_m));
                (self.cells).look_around(slot, at_m, numbers, &mut chunk, &mut seen);
            }
        }
    }

    /// Resolves overlaps of bodies that are free of walls, where `places` says, and were free of
    /// overlaps before the step; on the threads of the present pool where `shared`.
    #[inline(always)]
    pub fn separate(
        &mut self,
        contact: &Contact,
        index: &WallIndex,
        bodies: &mut [Body],
        shared: bool,
    ) {
        let diameter_m = 2.0 * contact.radius_m;
        let limit_m = diameter_m - 0.5 * OVERLAP_M;
        for iteration in 0..ITERATIONS {
            match (iteration, shared) {
                (0, true) => {
                    self.push_overlapping(contact, index, limit_m * limit_m, bodies);
                }
                (0, false) => {
                    self.activate_overlapping(limit_m * limit_m);
                    self.push_all(contact, index, bodies, false);
                }
                _ => self.push_all(contact, index, bodies, shared),
            }
            if self.moved_count == 0 {
                return;
            }
            for &(i, x_m, y_m) in &self.moved[..self.moved_count] {
                let body = &mut bodies[i as usize];
                (body.x_m, body.y_m) = (x_m, y_m);
                body.touched = true;
                self.places[i as usize] = [x_m, y_m];
            }
            self.activate_moved();
        }
        self.send_back(diameter_m, bodies);
    }

    /// Makes the robots that overlap others the active ones.
    #[inline(always)]
    fn activate_overlapping(&mut self, limit_m2: f32) {
        let (near, at_m) = (&self.near, &self.places[..]);
        self.active_count = 0;
        for chunk in 0..at_m.len().div_ceil(CHUNK) {
            let slots = &mut self.active[self.active_count..];
            self.active_count += overlapping(near, chunk, limit_m2, at_m, slots);
        }
    }

    /// Finds where the robots that overlap others go, on the threads of the present pool.
    fn push_overlapping(
        &mut self,
        contact: &Contact,
        index: &WallIndex,
        limit_m2: f32,
        bodies: &[Body],
    ) {
        let (near, at_m) = (&self.near, &self.places[..]);
        let chunks = at_m.len().div_ceil(CHUNK);
        self.found.resize(chunks, 0);
        self.active
            .par_chunks_mut(CHUNK)
            .zip(self.moved.par_chunks_mut(CHUNK))
            .zip(&mut self.found)
            .enumerate()
            .with_min_len(4)
            .for_each(|(chunk, ((slots, moved), found))| {
                let overlapping = overlapping(near, chunk, limit_m2, at_m, slots);
                *found = 0;
                for &i in &slots[..overlapping] {
                    if let Some(aim) = push(i, near, contact, index, at_m, bodies) {
                        moved[*found as usize] = aim;
                        *found += 1;
                    }
                }
            });
        self.moved_count = 0;
        for (chunk, &found) in self.found.iter().enumerate() {
            let (from, found) = (chunk * CHUNK, found as usize);
            self.moved.copy_within(from..from + found, self.moved_count);
            self.moved_count += found;
        }
    }

    /// Finds where the active robots go when every overlap they have is pushed apart.
    #[inline(always)]
    fn push_all(&mut self, contact: &Contact, index: &WallIndex, bodies: &[Body], shared: bool) {
        let (near, active) = (&self.near, &self.active[..self.active_count]);
        let places = &self.places[..];
        let push = |i: u32| push(i, near, contact, index, places, bodies);
        let mut count = 0;
        if shared && active.len() >= SHARED {
            let moved = &mut self.moved[..active.len()];
            moved
                .par_iter_mut()
                .zip(active)
                .with_min_len(SHARED / 4)
                .for_each(|(moved, &i)| *moved = push(i).unwrap_or(STAYS));
            for place in 0..moved.len() {
                moved[count] = moved[place];
                count += usize::from(moved[place].0 != STAYS.0);
            }
        } else {
            let is_large = bodies.len() >= LARGE;
            for (place, &i) in active.iter().enumerate() {
                if is_large && let Some(&later) = active.get(place + 8) {
                    prefetch(&bodies[later as usize].from_m);
                    let [x_m, y_m] = places[later as usize];
                    prefetch(index.cell(x_m, y_m));
                }
                if let Some(moved) = push(i) {
                    self.moved[count] = moved;
                    count += 1;
                }
            }
        }
        self.moved_count = count;
    }

    /// Makes the robots that moved, and their neighbours, the active ones.
    fn activate_moved(&mut self) {
        self.round = self.round.wrapping_add(1);
        self.active_count = 0;
        for &(i, _, _) in &self.moved[..self.moved_count] {
            let near = self.near.of(i as usize);
            for who in std::iter::once(i).chain(near.iter().map(|pair| pair.other())) {
                if self.stamp[who as usize] != self.round {
                    self.stamp[who as usize] = self.round;
                    self.active[self.active_count] = who;
                    self.active_count += 1;
                }
            }
        }
    }

    /// Puts every robot that still overlaps back to where it was, until nobody does.
    #[inline(never)]
    fn send_back(&mut self, diameter_m: f32, bodies: &mut [Body]) {
        let limit = diameter_m - OVERLAP_M;
        loop {
            self.moved_count = 0;
            for &i in &self.active[..self.active_count] {
                let body = &bodies[i as usize];
                if [body.x_m, body.y_m] == body.from_m {
                    continue;
                }
                let clash = self.near.of(i as usize).iter().any(|pair| {
                    let other = &bodies[pair.other() as usize];
                    let (dx, dy) = (body.x_m - other.x_m, body.y_m - other.y_m);
                    dx * dx + dy * dy < limit * limit
                });
                if clash {
                    self.moved[self.moved_count] = (i, body.from_m[0], body.from_m[1]);
                    self.moved_count += 1;
                }
            }
            if self.moved_count == 0 {
                return;
            }
            for &(i, x_m, y_m) in &self.moved[..self.moved_count] {
                (bodies[i as usize].x_m, bodies[i as usize].y_m) = (x_m, y_m);
                self.places[i as usize] = [x_m, y_m];
            }
            self.activate_moved();
        }
    }

    /// Bytes set aside, the same on any number of threads. No list outgrows its capacity, one entry a
    /// robot; what several threads note of robots (a square) and chunks (counts, spans) takes less
    /// than two words a robot, chunks' own entries among the pairs included.
    pub fn bytes(&self) -> usize {
        let (robots, words) = (self.stamp.len(), 2 * size_of::<u32>());
        self.cells.bytes()
            + self.near.bytes_of_robots()
            + size_of_val(&self.places[..])
            + size_of_val(&self.active[..])
            + size_of_val(&self.stamp[..])
            + robots * (size_of::<Move>() + words)
    }
}

/// Notes where bodies are.
#[inline(always)]
pub fn locate(bodies: &[Body], places: &mut [Place]) {
    for (place, body) in places.iter_mut().zip(bodies) {
        *place = [body.x_m, body.y_m];
    }
}

/// Notes which robots of a chunk overlap any of their candidates, and says how many.
#[inline(always)]
fn overlapping(
    near: &Near,
    chunk: usize,
    limit_m2: f32,
    at_m: &[Place],
    slots: &mut [u32],
) -> usize {
    let first = chunk * CHUNK;
    let (mut count, mut last) = (0, u32::MAX);
    for pair in near.of_chunk(chunk) {
        let slot = first + pair.place();
        let ([x_m, y_m], [ox_m, oy_m]) = (at_m[slot], at_m[pair.other() as usize]);
        let (dx, dy) = (x_m - ox_m, y_m - oy_m);
        let slot = slot as u32;
        if dx * dx + dy * dy < limit_m2 && slot != last {
            slots[count] = slot;
            count += 1;
            last = slot;
        }
    }
    count
}

/// Where a robot goes when every overlap it has is pushed apart, free of walls; `None` without
/// overlap.
#[inline(always)]
fn push(
    slot: u32,
    near: &Near,
    contact: &Contact,
    index: &WallIndex,
    places: &[Place],
    bodies: &[Body],
) -> Option<Move> {
    let i = slot as usize;
    let ([x, y], from_m @ [from_x, from_y]) = (places[i], bodies[i].from_m);
    let diameter_m = 2.0 * contact.radius_m;
    let limit = diameter_m - 0.5 * OVERLAP_M;
    let (mut px, mut py, mut overlaps) = (0.0, 0.0, false);
    for other in near.of(i).iter().map(|pair| pair.other()) {
        let [other_x, other_y] = places[other as usize];
        let (dx, dy) = (x - other_x, y - other_y);
        let d2 = dx * dx + dy * dy;
        if d2 >= limit * limit {
            continue;
        }
        overlaps = true;
        let distance = d2.sqrt();
        if distance < 1e-6 {
            continue;
        }
        let depth = diameter_m - distance;
        let (nx, ny) = (dx / distance, dy / distance);
        let half = 0.5 * depth * (1.0 + contact.bounce);
        let [other_from_x, other_from_y] = bodies[other as usize].from_m;
        let sx = (x - from_x) - (other_x - other_from_x);
        let sy = (y - from_y) - (other_y - other_from_y);
        let slip = sy * nx - sx * ny;
        let brake = 0.5 * slip.abs().min(contact.friction * depth).copysign(slip);
        px += nx * half + ny * brake;
        py += ny * half - nx * brake;
    }
    if !overlaps {
        return None;
    }
    // Nobody leaves the circle within which contact candidates were collected.
    let (mut way_x, mut way_y) = (x + px - from_x, y + py - from_y);
    let way = (way_x * way_x + way_y * way_y).sqrt();
    let longest = 1.5 * contact.max_step_m;
    if way > longest {
        way_x *= longest / way;
        way_y *= longest / way;
    }
    let aim_m = [from_x + way_x, from_y + way_y];
    let [x_m, y_m] = contact.free_of_walls(index, from_m, aim_m);
    Some((slot, x_m, y_m))
}
