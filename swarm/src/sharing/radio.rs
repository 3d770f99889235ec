//! Messages between robots in range, delivered within the step in which they are told.
//!
//! Phase 1: every robot tells its parent's genome and fitness over and over, a complete one every
//! so many steps; who is in range then has it, and adopts the fittest of a trajectory where it
//! beats its own parent. As in mEDEA genomes travel by encounters; unlike there, by fitness.
//!
//! Phase 3: every robot tells its newest transition, which who hears it takes as its own, and
//! earlier ones drawn from its table, which are taken only by robots that know less of that state
//! and action than the teller. So no echo of a transition can outgrow what was really seen.
//!
//! All tell what they knew before any message of the step arrived, and hear in an order that
//! depends on robot and step alone.

use super::told::{MOST_HEARD, Told, told_transitions};
use crate::bodies::{Bodies, Reading};
use crate::caps::MemoryPlan;
use crate::controllers::{Controller, Controllers, Crawler, Explorer};
use crate::dimensions::WHEELS;
use crate::learn::perceptron::WEIGHTS;
use crate::learn::transition::Transition;
use crate::random::{below, draw};
use crate::spec::RadioLink;

/// Bytes of a genome and its fitness.
const GENOME_BYTES: u32 = (WEIGHTS * size_of::<f32>() + size_of::<f64>()) as u32;
/// Most cells a side of the grid in which robots in range are found.
const MOST_CELLS: f32 = 512.0;

/// Who hears whom. Scratch: nothing in here outlives a step.
pub struct Radio {
    /// Squared range, infinity for no limit.
    range_squared_m2: f32,
    cell_m: f32,
    columns: usize,
    rows: usize,
    /// First place of each cell's robots in `robots`; one more for the end.
    first: Vec<u32>,
    /// Robots by cell, in order of their numbers within one.
    robots: Vec<u32>,
    cell_of: Vec<u32>,
    /// Earlier transitions that each robot tells.
    earlier: u32,
    told: Vec<Told>,
    key: u64,
    /// Steps that a genome takes.
    genome_steps: u64,
}

impl Radio {
    /// The radios of `robots` robots in an arena of this size; `key` is that of its random numbers.
    pub fn new(
        link: &RadioLink,
        plan: &MemoryPlan,
        robots: usize,
        (width_m, height_m): (f64, f64),
        key: u64,
    ) -> Self {
        let range_m = link.range_m.map_or(f32::INFINITY, |range| range as f32);
        let (width_m, height_m) = (width_m as f32, height_m as f32);
        let cell_m = range_m
            .max(width_m.max(height_m) / MOST_CELLS)
            .min(width_m.max(height_m) * 2.0);
        let (columns, rows) = (cells(width_m, cell_m), cells(height_m, cell_m));
        let earlier = told_transitions(link, plan).earlier;
        Self {
            range_squared_m2: range_m * range_m,
            cell_m,
            columns,
            rows,
            first: vec![0; columns * rows + 1],
            robots: vec![0; robots],
            cell_of: vec![0; robots],
            earlier,
            told: vec![Told::default(); robots * earlier as usize],
            key,
            genome_steps: u64::from(GENOME_BYTES.div_ceil(link.bytes_per_step)),
        }
    }

    /// Sorts robots into cells.
    fn locate(&mut self, bodies: &Bodies) {
        self.first.fill(0);
        for (cell, body) in self.cell_of.iter_mut().zip(bodies.iter()) {
            let column = ((body.x_m / self.cell_m) as usize).min(self.columns - 1);
            let row = ((body.y_m / self.cell_m) as usize).min(self.rows - 1);
            *cell = (row * self.columns + column) as u32;
            self.first[*cell as usize + 1] += 1;
        }
        for cell in 1..self.first.len() {
            self.first[cell] += self.first[cell - 1];
        }
        // Backwards, so that `first` ends as the beginnings and numbers rise within a cell.
        for (robot, cell) in self.cell_of.iter().enumerate().rev() {
            let end = &mut self.first[*cell as usize + 1];
            *end -= 1;
            self.robots[*end as usize] = robot as u32;
        }
        // Every end was moved down to its own cell's beginning: shift them back into place.
        for cell in 1..self.first.len() - 1 {
            self.first[cell] = self.first[cell + 1];
        }
        let last = self.first.len() - 1;
        self.first[0] = 0;
        self.first[last] = bodies.len() as u32;
    }

    /// Calls `hear` with up to [`MOST_HEARD`] robots in range of a robot. Where more are, those that
    /// come first from a place that depends on robot and step.
    fn each_heard(&self, robot: usize, step: u64, bodies: &Bodies, mut hear: impl FnMut(usize)) {
        let cell = self.cell_of[robot] as usize;
        let (column, row) = (cell % self.columns, cell / self.columns);
        let (left, right) = (column.saturating_sub(1), (column + 1).min(self.columns - 1));
        let mut runs = [(0, 0); 3];
        let mut candidates = 0;
        for (run, row) in runs
            .iter_mut()
            .zip(row.saturating_sub(1)..=(row + 1).min(self.rows - 1))
        {
            let first = self.first[row * self.columns + left] as usize;
            let end = self.first[row * self.columns + right + 1] as usize;
            *run = (first, end - first);
            candidates += end - first;
        }
        let bits = draw(self.key ^ robot as u64, step) as u32;
        let offset = below(bits, candidates as u32) as usize;
        let here = &bodies[robot];
        let mut heard = 0;
        for n in 0..candidates {
            let mut place = (offset + n) % candidates;
            let mut other = robot;
            for (first, len) in runs {
                if place < len {
                    other = self.robots[first + place] as usize;
                    break;
                }
                place -= len;
            }
            let (dx, dy) = (bodies[other].x_m - here.x_m, bodies[other].y_m - here.y_m);
            if other != robot && dx * dx + dy * dy <= self.range_squared_m2 {
                hear(other);
                heard += 1;
                if heard == MOST_HEARD {
                    return;
                }
            }
        }
    }

    /// Phase 1: genomes.
    fn exchange_genomes(&mut self, crawlers: &mut [Crawler], step: u64, bodies: &Bodies) {
        if !(step + 1).is_multiple_of(self.genome_steps) {
            return;
        }
        self.locate(bodies);
        for robot in 0..crawlers.len() {
            let mut fittest: Option<(usize, f64)> = None;
            self.each_heard(robot, step, bodies, |other| {
                if let Some((_, fitness)) = crawlers[other].tells()
                    && fittest.is_none_or(|(_, best)| fitness > best)
                {
                    fittest = Some((other, fitness));
                }
            });
            let Some((other, fitness)) = fittest else {
                continue;
            };
            let mut genome = [0.0; WEIGHTS];
            if let Some((told, _)) = crawlers[other].tells() {
                genome.copy_from_slice(told);
            }
            crawlers[robot].hear(&genome, fitness);
        }
    }

    /// Phase 3: transitions.
    fn exchange_transitions(&mut self, explorers: &mut [Explorer], step: u64, bodies: &Bodies) {
        self.locate(bodies);
        let earlier = self.earlier as usize;
        for (robot, explorer) in explorers.iter().enumerate() {
            for (n, told) in self.told[robot * earlier..][..earlier]
                .iter_mut()
                .enumerate()
            {
                let counter = step * u64::from(self.earlier) + n as u64;
                *told = draw_from_table(
                    explorer,
                    draw(self.key.rotate_left(32) ^ robot as u64, counter),
                );
            }
        }
        // What is heard changes tables alone; what is told was all taken before.
        for robot in 0..explorers.len() {
            let mut heard = [0; MOST_HEARD];
            let mut count = 0;
            self.each_heard(robot, step, bodies, |other| {
                heard[count] = other;
                count += 1;
            });
            for &other in &heard[..count] {
                let newest = explorers[other].decider().last();
                explorers[robot].record(newest);
                for told in &self.told[other * earlier..][..earlier] {
                    let Transition { state, action, .. } = told.transition;
                    if explorers[robot].repository().count(state, action) < told.recorded {
                        explorers[robot].record(told.transition);
                    }
                }
            }
        }
    }
}

/// An entry of a list of the table, of a state and action drawn uniformly; nothing of the list is
/// empty.
fn draw_from_table(explorer: &Explorer, bits: u64) -> Told {
    let table = explorer.repository();
    let state = below((bits as u32) << 8, table.states());
    let action = below((bits >> 16) as u32 & !0xFF, table.actions());
    let recorded = table.count(state, action);
    if recorded == 0 {
        return Told::default();
    }
    let place = below((bits >> 32) as u32 & !0xFF, recorded);
    Told {
        transition: Transition {
            state,
            action,
            next: table.entry(state, action, place),
        },
        recorded,
    }
}

fn cells(length_m: f32, cell_m: f32) -> usize {
    ((length_m / cell_m).ceil() as usize).max(1)
}

/// Controllers that have something to tell by radio.
pub trait Tell: Controller + Sized {
    /// Lets all robots of a step hear what those in range tell.
    fn exchange(radio: &mut Radio, controllers: &mut [Self], step: u64, bodies: &Bodies);
}

impl Tell for Crawler {
    fn exchange(radio: &mut Radio, controllers: &mut [Self], step: u64, bodies: &Bodies) {
        radio.exchange_genomes(controllers, step, bodies);
    }
}

impl Tell for Explorer {
    fn exchange(radio: &mut Radio, controllers: &mut [Self], step: u64, bodies: &Bodies) {
        radio.exchange_transitions(controllers, step, bodies);
    }
}

/// Robots with radios.
pub struct RadioControllers<'a, P> {
    /// The robots.
    pub controllers: &'a mut [P],
    /// Their radios.
    pub radio: &'a mut Radio,
}

impl<P: Tell> Controllers for RadioControllers<'_, P> {
    type Robot = P;
    type Common = ();
    const ARE_LARGE: bool = P::IS_LARGE;
    const ENDS_STEPS: bool = true;

    #[inline(always)]
    fn parts(&mut self) -> (&mut [P], &()) {
        (self.controllers, &())
    }

    #[inline(always)]
    fn choose((): &(), robot: &mut P, step: u64, reading: &Reading) {
        robot.choose(step, reading);
    }

    #[inline(always)]
    fn act((): &(), robot: &mut P, step: u64, reading: &Reading) -> [f32; WHEELS] {
        robot.act(step, reading)
    }

    #[inline(always)]
    fn learn((): &(), robot: &mut P, reading: &Reading) {
        robot.learn(reading);
    }

    #[inline(always)]
    fn expect_acting(robot: &P) {
        robot.expect_acting();
    }

    #[inline(always)]
    fn expect_learning(robot: &P) {
        robot.expect_learning();
    }

    fn end_step(&mut self, step: u64, bodies: &Bodies) {
        P::exchange(self.radio, self.controllers, step, bodies);
    }
}

#[cfg(test)]
#[path = "radio_tests.rs"]
mod tests;
