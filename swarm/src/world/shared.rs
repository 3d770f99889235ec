//! The same steps as in `step.rs` on the threads of a pool, to the same bits: chunks of robots are
//! taken side by side, and what concerns all of them is done between two ways through the robots.

use rayon::prelude::*;

use super::phases::{BySlot, Moves, Phases};
use super::step::{Parts, Pass, count_visit};
use super::{World, WorldState};
use crate::backend::Compiled;
use crate::bodies::Body;
use crate::controllers::Controllers;
use crate::engine::EngineState;
use crate::engine::cells::{Cells, Place};
use crate::engine::crowd::locate;
use crate::engine::near::{CHUNK, NearChunk};

/// Fewest chunks that a thread takes at once.
const CHUNKS: usize = 2;

/// In a note of a robot's square: it was entered in this step.
const ENTERED: u32 = 1 << 31;

impl World {
    /// Moves every robot `steps` times, on the threads of the present pool.
    pub(super) fn steps_shared<C: Controllers + ?Sized>(
        &mut self,
        controllers: &mut C,
        steps: u64,
    ) {
        // Robots that tell each other something are put in order again in every step.
        let at_once = if C::ENDS_STEPS { 1 } else { steps };
        let mut left = steps;
        while left > 0 {
            let steps = left.min(at_once);
            let (robots, common) = controllers.parts();
            let mut by_slot: Vec<Option<&mut C::Robot>> = Vec::new();
            by_slot.resize_with(robots.len(), || None);
            for (robot, &slot) in robots.iter_mut().zip(self.state.bodies.slots()) {
                by_slot[slot as usize] = Some(robot);
            }
            let mut uncounted = false;
            for left in (0..steps).rev() {
                if left + 1 == steps {
                    let pass = Pass::beginning(self.state.step);
                    self.pass_shared::<C>(common, &mut by_slot, pass);
                }
                if uncounted {
                    self.collide_and_count();
                } else {
                    self.collide(true);
                }
                self.before_sensing(true, |a, b| by_slot.swap(a, b));
                let pass = Pass::ending::<C>(self.state.step + 1, left);
                self.pass_shared::<C>(common, &mut by_slot, pass);
                uncounted = self.counting;
                self.state.step += 1;
            }
            drop(by_slot);
            if uncounted {
                let Self {
                    state,
                    arrivals,
                    squares,
                    ..
                } = self;
                count(&mut state.visits, squares, arrivals);
                self.after_accounting();
            }
            if C::ENDS_STEPS {
                controllers.end_step(self.state.step - 1, &self.state.bodies);
            }
            left -= steps;
        }
    }

    /// Takes all robots through some phases.
    fn pass_shared<C: Controllers + ?Sized>(
        &mut self,
        common: &C::Common,
        by_slot: &mut [Option<&mut C::Robot>],
        pass: Pass,
    ) {
        let (moves, backend) = (self.moves(), self.backend);
        let counting = self.counting && pass.ends;
        let mut squares = std::mem::take(&mut self.squares);
        squares.resize(by_slot.len(), 0);
        let parts = Parts::of(self);
        let Some((cells, near, places)) = parts.crowd else {
            unreachable!("a crowd of one")
        };
        let (phases, numbers) = (parts.phases, parts.phases.numbers.len());
        debug_assert_eq!(numbers, by_slot.len());
        let touched: u64 = parts
            .bodies
            .par_chunks_mut(CHUNK)
            .zip(near.par_chunks_mut())
            .zip(by_slot.par_chunks_mut(CHUNK))
            .zip(squares.par_chunks_mut(CHUNK))
            .zip(places.par_chunks_mut(CHUNK))
            .enumerate()
            .with_min_len(CHUNKS)
            .map(|(chunk, ((((bodies, near), by_slot), squares), places))| {
                backend.run(Chunk::<C> {
                    phases,
                    cells,
                    common,
                    first: chunk * CHUNK,
                    bodies,
                    near,
                    places,
                    by_slot,
                    squares: counting.then_some(squares),
                    pass,
                    moves,
                })
            })
            .sum();
        if counting {
            *parts.counts.collisions += touched;
        }
        self.squares = squares;
    }

    /// Lets robots that were driven meet each other, while the squares in which they ended the step
    /// before are counted.
    fn collide_and_count(&mut self) {
        let Self {
            state: WorldState { bodies, visits, .. },
            engine,
            crowd,
            contact,
            index,
            arrivals,
            squares,
            ..
        } = self;
        match (engine, crowd) {
            (EngineState::Kinematic, Some(crowd)) => {
                let (bodies, _) = bodies.stored_mut();
                rayon::join(
                    || count(visits, squares, arrivals),
                    || crowd.separate(contact, index, bodies, true),
                );
            }
            _ => {
                count(visits, squares, arrivals);
                self.collide(true);
            }
        }
        self.after_accounting();
    }
}

/// Counts a step in each of the squares that robots have noted by slot.
fn count(visits: &mut [[u32; 2]], squares: &[u32], arrivals: &mut Vec<u32>) {
    for (slot, &square) in squares.iter().enumerate() {
        if count_visit(visits, square & !ENTERED, square & ENTERED != 0) {
            arrivals.push(slot as u32);
        }
    }
}

/// The phases of some robots.
struct Chunk<'a, 'b, C: Controllers + ?Sized> {
    phases: Phases<'a>,
    cells: &'a Cells,
    common: &'a C::Common,
    first: usize,
    bodies: &'a mut [Body],
    near: NearChunk<'a>,
    places: &'a mut [Place],
    by_slot: &'a mut [Option<&'b mut C::Robot>],
    /// Where the robots' squares are noted, if they count.
    squares: Option<&'a mut [u32]>,
    pass: Pass,
    moves: Moves,
}

impl<C: Controllers + ?Sized> Compiled for Chunk<'_, '_, C> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let Self {
            phases,
            common,
            first,
            bodies,
            by_slot,
            ..
        } = self;
        let mut steered = BySlot(by_slot);
        let mut touched = 0;
        if let Some(squares) = self.squares {
            touched = phases.account(0, bodies, |place, square, entered| {
                squares[place] = square | if entered { ENTERED } else { 0 };
            });
        }
        if self.pass.ends {
            let mut near = self.near;
            phases.sense(self.cells, first, bodies, &mut near);
            phases.learn::<C>(common, bodies, &mut steered);
        }
        if let Some(step) = self.pass.begins {
            phases.decide_and_drive::<C>(common, step, first, bodies, &mut steered, self.moves);
            locate(bodies, self.places);
        }
        touched
    }
}
