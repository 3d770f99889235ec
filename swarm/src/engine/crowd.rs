//! Robots against each other in the kinematic engine, and the grid that finds neighbours.
//!
//! Overlaps are pushed apart half and half by Jacobi iterations, in which every robot reads only
//! the last iteration's positions, so that order and thread count cannot matter. Whoever still
//! overlaps goes back to where the step began, together with whoever that blocks: positions before
//! the step were free of overlap, so this ends, and no overlap above [`OVERLAP_M`] survives a step.

use std::f64::consts::PI;

use arenas::axis::GridAxis;
use arenas::index::WallIndex;

use super::kinematic::Contact;
use crate::bodies::Body;

/// Deepest overlap of two robots that is left standing, metres.
pub const OVERLAP_M: f32 = 5e-5;

/// Most neighbours kept for contact: 18 discs of radius R fit with their centres within 4 R.
const MOST_NEIGHBOURS: usize = 20;

const ITERATIONS: usize = 8;

/// A robot in a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    x_m: f32,
    y_m: f32,
    slot: u32,
}

/// Cells at least as wide as robots see.
#[derive(Clone, Copy, Debug)]
struct Grid {
    across: GridAxis,
    up: GridAxis,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// Column and row of a place.
    #[inline(always)]
    fn cell(&self, x_m: f32, y_m: f32) -> [usize; 2] {
        [self.across.cell(x_m), self.up.cell(y_m)]
    }
}

/// Scratch of an arena with several robots; can be rebuilt from positions at any time. Robots are
/// known by their slots, the places in which their bodies are stored.
#[derive(Clone, Debug)]
pub struct Crowd {
    grid: Grid,
    /// Start of each cell in `sorted`, one more than there are cells.
    starts: Vec<u32>,
    /// By slot.
    cell_of: Vec<u32>,
    /// Robots by cell, then by slot.
    sorted: Vec<Entry>,
    /// Robots and their contact candidates, by slot, then by cell and number of the candidate; valid
    /// up to the last of `near_ends`.
    pairs: Vec<[u32; 2]>,
    /// End of each robot's pairs, by slot, after a 0.
    near_ends: Vec<u32>,
    /// Most contact candidates of a robot.
    near_most: usize,
    candidate_m2: f32,
    sight_m2: f32,
    seen: Vec<[f32; 2]>,
    active: Vec<u32>,
    moved: Vec<(u32, f32, f32)>,
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
        let spread_m = (width_m * height_m / robots.max(64) as f64).sqrt();
        let cell_m = sight_m.max(f64::from(candidate_m)).max(spread_m * 0.5) * 1.000_1;
        let columns = (width_m / cell_m).ceil().max(1.0) as usize;
        let rows = (height_m / cell_m).ceil().max(1.0) as usize;
        let cells_per_m = (1.0 / cell_m) as f32;
        let apart_m = f64::from(2.0 * (contact.radius_m - OVERLAP_M));
        let near_most = most_neighbours(f64::from(candidate_m), apart_m);
        Self {
            starts: vec![0; columns * rows + 1],
            grid: Grid {
                across: GridAxis::new(columns, cells_per_m),
                up: GridAxis::new(rows, cells_per_m),
                columns,
                rows,
            },
            cell_of: vec![0; robots],
            sorted: vec![Entry::default(); robots],
            pairs: vec![[0; 2]; robots * near_most + 1],
            near_most,
            near_ends: vec![0; robots + 1],
            candidate_m2: candidate_m * candidate_m,
            sight_m2: (sight_m * sight_m) as f32,
            seen: vec![[0.0; 2]; robots],
            active: Vec::with_capacity(robots),
            moved: Vec::with_capacity(robots),
            stamp: vec![0; robots],
            round: 0,
        }
    }

    /// Sorts robots into cells.
    #[inline(always)]
    pub fn sort(&mut self, bodies: &[Body]) {
        self.starts.fill(0);
        for (body, cell_of) in bodies.iter().zip(&mut self.cell_of) {
            let [column, row] = self.grid.cell(body.x_m, body.y_m);
            *cell_of = (row * self.grid.columns + column) as u32;
            self.starts[*cell_of as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // From the last robot to the first, so that slots rise within a cell.
        for (slot, body) in bodies.iter().enumerate().rev() {
            let place = &mut self.starts[self.cell_of[slot] as usize];
            *place -= 1;
            self.sorted[*place as usize] = Entry {
                x_m: body.x_m,
                y_m: body.y_m,
                slot: slot as u32,
            };
        }
    }

    /// Gives robots the slots in whose order they are sorted; `swap` exchanges what two slots hold.
    pub fn settle(&mut self, mut swap: impl FnMut(usize, usize)) {
        // Cycle by cycle of the permutation; a slot that has its robot is entered as its own.
        for first in 0..self.sorted.len() {
            let mut to = first;
            loop {
                let from = self.sorted[to].slot as usize;
                self.sorted[to].slot = to as u32;
                if from == first {
                    break;
                }
                swap(to, from);
                self.cell_of.swap(to, from);
                to = from;
            }
        }
    }

    /// Centres of the robots in sight of a robot. Notes contact candidates for the next step; slots
    /// have to be asked in their order. `numbers` are the robots' numbers by slot.
    #[inline(always)]
    pub fn look_around(&mut self, slot: usize, x_m: f32, y_m: f32, numbers: &[u32]) -> &[[f32; 2]] {
        let [column, row] = self.grid.cell(x_m, y_m);
        let (columns, rows) = (self.grid.columns, self.grid.rows);
        let (first, last) = (column.saturating_sub(1), (column + 1).min(columns - 1));
        let pairs_begin = self.near_ends[slot] as usize;
        let (pairs, seen) = (&mut self.pairs[pairs_begin..], &mut self.seen[..]);
        let (mut near_count, mut seen_count) = (0, 0);
        for row in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
            let begin = self.starts[row * columns + first] as usize;
            let end = self.starts[row * columns + last + 1] as usize;
            for entry in &self.sorted[begin..end] {
                let (dx, dy) = (entry.x_m - x_m, entry.y_m - y_m);
                let d2 = dx * dx + dy * dy;
                // Nobody can foresee who is near: all are noted, and those who are not, overwritten.
                let in_sight = (d2 < self.sight_m2) & (entry.slot as usize != slot);
                seen[seen_count] = [entry.x_m, entry.y_m];
                seen_count += usize::from(in_sight);
                pairs[near_count] = [slot as u32, entry.slot];
                near_count += usize::from(in_sight & (d2 < self.candidate_m2));
                near_count = near_count.min(self.near_most);
            }
        }
        let near = &mut pairs[..near_count];
        // Sums of pushes must not depend on slots.
        let key = |pair: [u32; 2]| (self.cell_of[pair[1] as usize], numbers[pair[1] as usize]);
        for sorted in 1..near_count {
            let mut at = sorted;
            while at > 0 && key(near[at]) < key(near[at - 1]) {
                near.swap(at, at - 1);
                at -= 1;
            }
        }
        self.near_ends[slot + 1] = (pairs_begin + near_count) as u32;
        &self.seen[..seen_count]
    }

    /// A robot and its contact candidates, pair by pair.
    #[inline(always)]
    fn near(&self, slot: usize) -> &[[u32; 2]] {
        &self.pairs[self.near_ends[slot] as usize..self.near_ends[slot + 1] as usize]
    }

    /// Resolves overlaps of bodies that are free of walls and were free of overlaps before the step.
    #[inline(always)]
    pub fn separate(&mut self, contact: &Contact, index: &WallIndex, bodies: &mut [Body]) {
        let diameter_m = 2.0 * contact.radius_m;
        let limit = diameter_m - 0.5 * OVERLAP_M;
        self.active.clear();
        let all = self.near_ends[bodies.len()] as usize;
        for &[i, other] in &self.pairs[..all] {
            let (body, other) = (&bodies[i as usize], &bodies[other as usize]);
            let (dx, dy) = (body.x_m - other.x_m, body.y_m - other.y_m);
            if dx * dx + dy * dy < limit * limit && self.active.last() != Some(&i) {
                self.active.push(i);
            }
        }
        for _ in 0..ITERATIONS {
            self.moved.clear();
            for &i in &self.active {
                let push = self.push(i as usize, contact, diameter_m, bodies);
                if let Some((x_m, y_m)) = push {
                    self.moved.push((i, x_m, y_m));
                }
            }
            if self.moved.is_empty() {
                return;
            }
            for &(i, x_m, y_m) in &self.moved {
                let body = &mut bodies[i as usize];
                (body.x_m, body.y_m) = (x_m, y_m);
                contact.move_body(index, body);
                body.touched = true;
            }
            self.activate_moved();
        }
        self.send_back(diameter_m, bodies);
    }

    /// Where robot `i` goes when every overlap it has is pushed apart, or `None` without overlap.
    #[inline(always)]
    fn push(
        &self,
        i: usize,
        contact: &Contact,
        diameter_m: f32,
        bodies: &[Body],
    ) -> Option<(f32, f32)> {
        let body = &bodies[i];
        let (x, y, [from_x, from_y]) = (body.x_m, body.y_m, body.from_m);
        let limit = diameter_m - 0.5 * OVERLAP_M;
        let (mut px, mut py, mut overlaps) = (0.0, 0.0, false);
        for &[_, other] in self.near(i) {
            let other = &bodies[other as usize];
            let (dx, dy) = (x - other.x_m, y - other.y_m);
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
            let sx = (x - from_x) - (other.x_m - other.from_m[0]);
            let sy = (y - from_y) - (other.y_m - other.from_m[1]);
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
        Some((from_x + way_x, from_y + way_y))
    }

    /// Makes the robots that moved, and their neighbours, the active ones.
    fn activate_moved(&mut self) {
        self.round = self.round.wrapping_add(1);
        self.active.clear();
        for &(i, _, _) in &self.moved {
            let i = i as usize;
            let near = &self.pairs[self.near_ends[i] as usize..self.near_ends[i + 1] as usize];
            for &who in std::iter::once(&(i as u32)).chain(near.iter().map(|[_, other]| other)) {
                if self.stamp[who as usize] != self.round {
                    self.stamp[who as usize] = self.round;
                    self.active.push(who);
                }
            }
        }
    }

    /// Puts every robot that still overlaps back to where it was, until nobody does.
    #[inline(never)]
    fn send_back(&mut self, diameter_m: f32, bodies: &mut [Body]) {
        let limit = diameter_m - OVERLAP_M;
        loop {
            self.moved.clear();
            for &i in &self.active {
                let body = &bodies[i as usize];
                if [body.x_m, body.y_m] == body.from_m {
                    continue;
                }
                let clash = self.near(i as usize).iter().any(|&[_, j]| {
                    let other = &bodies[j as usize];
                    let (dx, dy) = (body.x_m - other.x_m, body.y_m - other.y_m);
                    dx * dx + dy * dy < limit * limit
                });
                if clash {
                    self.moved.push((i, body.from_m[0], body.from_m[1]));
                }
            }
            if self.moved.is_empty() {
                return;
            }
            for &(i, x_m, y_m) in &self.moved {
                (bodies[i as usize].x_m, bodies[i as usize].y_m) = (x_m, y_m);
            }
            self.activate_moved();
        }
    }

    /// Bytes set aside. No list outgrows its capacity, one entry a robot.
    pub fn bytes(&self) -> usize {
        let lists = size_of::<[f32; 2]>() + size_of::<u32>() + size_of::<(u32, f32, f32)>();
        size_of_val(&self.starts[..])
            + size_of_val(&self.cell_of[..])
            + size_of_val(&self.sorted[..])
            + size_of_val(&self.pairs[..])
            + size_of_val(&self.near_ends[..])
            + size_of_val(&self.stamp[..])
            + self.stamp.len() * lists
    }
}

/// Most points, each at least `apart_m` from the others, that lie within `radius_m` of one of them
/// (Oler's inequality for a disc).
fn most_neighbours(radius_m: f64, apart_m: f64) -> usize {
    let ratio = radius_m / apart_m;
    let others = 2.0 / 3.0_f64.sqrt() * PI * ratio * ratio + PI * ratio;
    (others as usize).min(MOST_NEIGHBOURS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_every_neighbour() {
        // Six touch one; 18 fit within two diameters, as in a hexagonal grid.
        assert!((6..=10).contains(&most_neighbours(1.0, 1.0)));
        assert!((18..=MOST_NEIGHBOURS).contains(&most_neighbours(2.0, 1.0)));
        assert_eq!(most_neighbours(10.0, 1.0), MOST_NEIGHBOURS);
    }
}
