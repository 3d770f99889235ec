//! Robots against each other in the kinematic engine, and the grid that finds neighbours.
//!
//! Overlaps are pushed apart half and half by Jacobi iterations, in which every robot reads only
//! the last iteration's positions, so that order and thread count cannot matter. Whoever still
//! overlaps goes back to where the step began, together with whoever that blocks: positions before
//! the step were free of overlap, so this ends, and no overlap above [`OVERLAP_M`] survives a step.

use arenas::index::WallIndex;

use super::kinematic::Contact;

/// Deepest overlap of two robots that is left standing, metres.
pub const OVERLAP_M: f32 = 5e-5;

/// Most neighbours kept for contact: discs of one size that fit around one within reach.
const NEIGHBOURS: usize = 16;

const ITERATIONS: usize = 8;

/// Contact candidates of one robot.
#[derive(Clone, Copy, Debug)]
struct Neighbours {
    count: u32,
    number: [u32; NEIGHBOURS],
}

const NOBODY: Neighbours = Neighbours { count: 0, number: [0; NEIGHBOURS] };

impl Neighbours {
    #[inline(always)]
    fn list(&self) -> &[u32] {
        &self.number[..self.count as usize]
    }
}

/// Scratch of an arena with several robots; can be rebuilt from positions at any time.
#[derive(Clone, Debug)]
pub struct Crowd {
    inverse_cell_m: f32,
    columns: i32,
    rows: i32,
    /// Start of each cell in `sorted`, one more than there are cells.
    starts: Vec<u32>,
    cell_of: Vec<u32>,
    /// Robots by cell, then by number.
    sorted: Vec<(f32, f32, u32)>,
    near: Vec<Neighbours>,
    candidate_m2: f32,
    active: Vec<u32>,
    moved: Vec<(u32, f32, f32)>,
    stamp: Vec<u32>,
    round: u32,
}

impl Crowd {
    /// Scratch for `robots` robots in an arena, seeing each other up to `reach_m` between centres.
    pub fn new(
        robots: usize,
        width_m: f64,
        height_m: f64,
        contact: &Contact,
        reach_m: f64,
    ) -> Self {
        let candidate_m = 2.0 * contact.radius_m + 4.0 * contact.max_step_m;
        let spread_m = (width_m * height_m / robots.max(64) as f64).sqrt();
        let cell_m = reach_m.max(f64::from(candidate_m)).max(spread_m * 0.5) * 1.000_1;
        let columns = (width_m / cell_m).ceil().max(1.0) as i32;
        let rows = (height_m / cell_m).ceil().max(1.0) as i32;
        Self {
            inverse_cell_m: (1.0 / cell_m) as f32,
            columns,
            rows,
            starts: vec![0; (columns * rows) as usize + 1],
            cell_of: vec![0; robots],
            sorted: vec![(0.0, 0.0, 0); robots],
            near: vec![NOBODY; robots],
            candidate_m2: candidate_m * candidate_m,
            active: Vec::with_capacity(robots),
            moved: Vec::with_capacity(robots),
            stamp: vec![0; robots],
            round: 0,
        }
    }

    /// Sorts robots into cells, for [`Crowd::visit`].
    #[inline(always)]
    pub fn sort(&mut self, x_m: &[f32], y_m: &[f32]) {
        self.starts.fill(0);
        for (i, cell_of) in self.cell_of.iter_mut().enumerate() {
            let column = ((x_m[i] * self.inverse_cell_m) as i32).clamp(0, self.columns - 1);
            let row = ((y_m[i] * self.inverse_cell_m) as i32).clamp(0, self.rows - 1);
            let cell = (row * self.columns + column) as u32;
            *cell_of = cell;
            self.starts[cell as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // From the last robot to the first, so that numbers rise within a cell.
        for i in (0..x_m.len()).rev() {
            let place = &mut self.starts[self.cell_of[i] as usize];
            *place -= 1;
            self.sorted[*place as usize] = (x_m[i], y_m[i], i as u32);
        }
    }

    /// Calls `see` with the centre of every other robot in the 3 x 3 cells around robot `i`, in the
    /// order of cells and numbers, and notes contact candidates for the next step.
    #[inline(always)]
    pub fn visit(&mut self, i: usize, x_m: f32, y_m: f32, mut see: impl FnMut(f32, f32)) {
        let cell = self.cell_of[i] as i32;
        let (column, row) = (cell % self.columns, cell / self.columns);
        let (first, last) = ((column - 1).max(0), (column + 1).min(self.columns - 1));
        let mut near = NOBODY;
        for row in (row - 1).max(0)..=(row + 1).min(self.rows - 1) {
            let begin = self.starts[(row * self.columns + first) as usize] as usize;
            let end = self.starts[(row * self.columns + last) as usize + 1] as usize;
            for &(ox, oy, other) in &self.sorted[begin..end] {
                if other as usize == i {
                    continue;
                }
                let (dx, dy) = (ox - x_m, oy - y_m);
                if dx * dx + dy * dy < self.candidate_m2 && (near.count as usize) < NEIGHBOURS {
                    near.number[near.count as usize] = other;
                    near.count += 1;
                }
                see(ox, oy);
            }
        }
        self.near[i] = near;
    }

    /// Resolves overlaps. `x_m`, `y_m` hold positions free of walls; `from` positions before the
    /// step, free of walls and overlaps.
    #[inline(always)]
    pub fn separate(
        &mut self,
        contact: &Contact,
        index: &WallIndex,
        from: (&[f32], &[f32]),
        x_m: &mut [f32],
        y_m: &mut [f32],
        touched: &mut [bool],
    ) {
        self.active.clear();
        for (i, near) in self.near.iter().enumerate() {
            if near.count > 0 {
                self.active.push(i as u32);
            }
        }
        let diameter = 2.0 * contact.radius_m;
        for _ in 0..ITERATIONS {
            self.moved.clear();
            for &i in &self.active {
                let push = self.push(i as usize, contact, diameter, from, x_m, y_m);
                if let Some((px, py)) = push {
                    self.moved.push((i, px, py));
                }
            }
            if self.moved.is_empty() {
                return;
            }
            for &(i, px, py) in &self.moved {
                let i = i as usize;
                let origin = (from.0[i], from.1[i]);
                let placed = contact.move_to(index, origin, (px, py));
                (x_m[i], y_m[i], touched[i]) = (placed.x_m, placed.y_m, true);
            }
            self.activate_moved();
        }
        self.send_back(diameter, from, x_m, y_m);
    }

    /// Where robot `i` goes when every overlap it has is pushed apart, or `None` without overlap.
    #[inline(always)]
    fn push(
        &self,
        i: usize,
        contact: &Contact,
        diameter: f32,
        from: (&[f32], &[f32]),
        x_m: &[f32],
        y_m: &[f32],
    ) -> Option<(f32, f32)> {
        let (x, y) = (x_m[i], y_m[i]);
        let limit = diameter - 0.5 * OVERLAP_M;
        let (mut px, mut py, mut overlaps) = (0.0, 0.0, false);
        for &other in self.near[i].list() {
            let j = other as usize;
            let (dx, dy) = (x - x_m[j], y - y_m[j]);
            let d2 = dx * dx + dy * dy;
            if d2 >= limit * limit {
                continue;
            }
            overlaps = true;
            let distance = d2.sqrt();
            if distance < 1e-6 {
                continue;
            }
            let depth = diameter - distance;
            let (nx, ny) = (dx / distance, dy / distance);
            let half = 0.5 * depth * (1.0 + contact.bounce);
            let (sx, sy) = (
                (x - from.0[i]) - (x_m[j] - from.0[j]),
                (y - from.1[i]) - (y_m[j] - from.1[j]),
            );
            let slip = sy * nx - sx * ny;
            let brake = 0.5 * slip.abs().min(contact.friction * depth).copysign(slip);
            px += nx * half + ny * brake;
            py += ny * half - nx * brake;
        }
        if !overlaps {
            return None;
        }
        // Nobody leaves the circle within which contact candidates were collected.
        let (mut wx, mut wy) = (x + px - from.0[i], y + py - from.1[i]);
        let way = (wx * wx + wy * wy).sqrt();
        let longest = 1.5 * contact.max_step_m;
        if way > longest {
            wx *= longest / way;
            wy *= longest / way;
        }
        Some((from.0[i] + wx, from.1[i] + wy))
    }

    /// Makes the robots that moved, and their neighbours, the active ones.
    fn activate_moved(&mut self) {
        self.round = self.round.wrapping_add(1);
        self.active.clear();
        for &(i, _, _) in &self.moved {
            for &who in std::iter::once(&i).chain(self.near[i as usize].list()) {
                if self.stamp[who as usize] != self.round {
                    self.stamp[who as usize] = self.round;
                    self.active.push(who);
                }
            }
        }
    }

    /// Puts every robot that still overlaps back to where it was, until nobody does.
    #[inline(never)]
    fn send_back(
        &mut self,
        diameter: f32,
        from: (&[f32], &[f32]),
        x_m: &mut [f32],
        y_m: &mut [f32],
    ) {
        let limit = diameter - OVERLAP_M;
        loop {
            self.moved.clear();
            for &i in &self.active {
                let i = i as usize;
                if (x_m[i], y_m[i]) == (from.0[i], from.1[i]) {
                    continue;
                }
                let clash = self.near[i].list().iter().any(|&j| {
                    let (dx, dy) = (x_m[i] - x_m[j as usize], y_m[i] - y_m[j as usize]);
                    dx * dx + dy * dy < limit * limit
                });
                if clash {
                    self.moved.push((i as u32, 0.0, 0.0));
                }
            }
            if self.moved.is_empty() {
                return;
            }
            for &(i, _, _) in &self.moved {
                (x_m[i as usize], y_m[i as usize]) = (from.0[i as usize], from.1[i as usize]);
            }
            self.activate_moved();
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..])
            + size_of_val(&self.cell_of[..])
            + size_of_val(&self.sorted[..])
            + size_of_val(&self.near[..])
            + size_of_val(&self.stamp[..])
            + self.active.capacity() * 4
            + self.moved.capacity() * 12
    }
}
