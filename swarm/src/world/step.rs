//! A step: decide and drive, collide, account, sense, learn.
//!
//! Robots are taken in the order in which they are stored, which is put in the order of cells now
//! and then, and in chunks, so that what is read together stays in the cache. What a robot does at
//! the end of a step and at the beginning of the next needs no other robot, and is done in one go.

use super::phases::{ByNumber, Moves, Phases};
use super::{World, WorldState};
use crate::backend::Compiled;
use crate::bodies::{Bodies, Body};
use crate::controllers::{Controller, Controllers};
use crate::engine::EngineState;
use crate::engine::cells::{Cells, Place};
use crate::engine::crowd::{LARGE, locate};
use crate::engine::near::{CHUNK, Near};

/// Odd, close to 2^64 / golden ratio: spreads counters over all words.
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// Steps after which robots are stored in the order of their cells again: by then the fastest are
/// some rows of cells away from those that they are stored with.
const SETTLED_STEPS: u32 = 256;

/// What is done of a step's parts on the way through all robots.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Pass {
    /// Account, sense and learn: the end of a step.
    pub ends: bool,
    /// Decide, drive and move: the beginning of this step.
    pub begins: Option<u64>,
}

impl Pass {
    /// The way through all robots at the end of the step before `step`.
    pub fn ending<C: Controllers + ?Sized>(step: u64, left: u64) -> Self {
        Self {
            ends: true,
            begins: (left > 0 && !C::ENDS_STEPS).then_some(step),
        }
    }

    pub const fn beginning(step: u64) -> Self {
        Self {
            ends: false,
            begins: Some(step),
        }
    }
}

impl World {
    /// Moves every robot `steps` times; `controllers` has one entry a robot.
    pub fn advance<P: Controller>(&mut self, controllers: &mut [P], steps: u64) {
        self.advance_all(controllers, steps);
    }

    /// As [`World::advance`], with robots that may have to do with each other.
    pub fn advance_all<C: Controllers + ?Sized>(&mut self, controllers: &mut C, steps: u64) {
        let robots = self.robots();
        assert_eq!(
            controllers.parts().0.len(),
            robots,
            "one controller a robot"
        );
        match self.crew.for_world(robots) {
            Some(pool) => pool.install(|| self.steps_shared(controllers, steps)),
            None => self.backend.run(Alone {
                world: self,
                controllers,
                steps,
            }),
        }
    }

    /// Reads all sensors where robots stand.
    pub(super) fn sense_all(&mut self) {
        self.backend.run(Sense(self));
    }

    #[inline(always)]
    fn steps<C: Controllers + ?Sized>(&mut self, controllers: &mut C, steps: u64) {
        for left in (0..steps).rev() {
            if left + 1 == steps || C::ENDS_STEPS {
                self.pass(controllers, Pass::beginning(self.state.step));
            }
            self.collide(false);
            self.before_sensing(false, |_, _| {});
            self.pass(controllers, Pass::ending::<C>(self.state.step + 1, left));
            self.after_accounting();
            controllers.end_step(self.state.step, &self.state.bodies);
            self.state.step += 1;
        }
    }

    /// Takes all robots through some phases, chunk by chunk.
    #[inline(always)]
    fn pass<C: Controllers + ?Sized>(&mut self, controllers: &mut C, pass: Pass) {
        let moves = self.moves();
        let counting = self.counting && pass.ends;
        let Parts {
            phases,
            bodies,
            crowd,
            counts,
        } = Parts::of(self);
        let WorldCounts {
            visits,
            collisions,
            arrivals,
        } = counts;
        let mut account = |first, bodies: &mut [Body]| {
            *collisions += phases.account(first, bodies, |slot, square, entered| {
                if count_visit(visits, square, entered) {
                    arrivals.push(slot as u32);
                }
            });
        };
        let (robots, common) = controllers.parts();
        let Some((cells, near, places)) = crowd else {
            let numbers = phases.numbers;
            let mut steered = ByNumber { robots, numbers };
            if counting {
                account(0, bodies);
            }
            if pass.ends {
                phases.sense_alone(bodies);
                phases.learn::<C>(common, bodies, &mut steered);
            }
            if let Some(step) = pass.begins {
                phases.decide_and_drive::<C>(common, step, 0, bodies, &mut steered, moves);
            }
            return;
        };
        let chunks = bodies.chunks_mut(CHUNK).zip(near.chunks_mut());
        let chunks = chunks.zip(places.chunks_mut(CHUNK));
        for (chunk, ((bodies, mut near), places)) in chunks.enumerate() {
            let first = chunk * CHUNK;
            let numbers = &phases.numbers[first..];
            let mut steered = ByNumber { robots, numbers };
            if counting {
                account(first, bodies);
            }
            if pass.ends {
                phases.sense(cells, first, bodies, &mut near);
                phases.learn::<C>(common, bodies, &mut steered);
            }
            if let Some(step) = pass.begins {
                phases.decide_and_drive::<C>(common, step, first, bodies, &mut steered, moves);
                locate(bodies, places);
            }
        }
    }

    /// When robots meet the walls.
    #[inline(always)]
    pub(super) fn moves(&self) -> Moves {
        match (&self.engine, &self.crowd) {
            (EngineState::Kinematic, None) => Moves::AtOnce,
            (EngineState::Kinematic, Some(_)) => Moves::AfterAll,
            (EngineState::Rapier(_), _) => Moves::Elsewhere,
        }
    }

    /// Lets robots that were driven meet each other; on the threads of the present pool where `shared`.
    #[inline(always)]
    pub(super) fn collide(&mut self, shared: bool) {
        let bodies = &mut self.state.bodies;
        match (&mut self.engine, &mut self.crowd) {
            (EngineState::Kinematic, None) => {}
            (EngineState::Kinematic, Some(crowd)) => {
                let (bodies, _) = bodies.stored_mut();
                crowd.separate(&self.contact, &self.index, bodies, shared);
            }
            (EngineState::Rapier(engine), crowd) => {
                engine.step(bodies);
                if let Some(crowd) = crowd {
                    // rapier's contacts are soft: what is left of an overlap is parted here.
                    let (stored, _) = bodies.stored_mut();
                    crowd.locate(stored);
                    crowd.separate(&self.contact, &self.index, stored, shared);
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

    /// Sorts robots into cells, and now and then stores them in that order; then `swapped` is told
    /// which slots exchanged what they hold.
    #[inline(always)]
    pub(super) fn before_sensing(&mut self, shared: bool, swapped: impl FnMut(usize, usize)) {
        if let Some(crowd) = &mut self.crowd {
            if shared {
                crowd.cells.sort_in_strips(&crowd.places);
            } else {
                crowd.cells.sort(&crowd.places);
            }
            if self.settled_steps == 0 {
                self.settled_steps = SETTLED_STEPS;
                self.store_by_cell(swapped);
            }
            self.settled_steps -= 1;
        }
        self.object_grid.update(&self.state.objects.poses);
        self.noise = self.state.readings.wrapping_mul(SPREAD);
        self.state.readings += 1;
        if self.counting {
            self.state.tally.step();
            self.arrivals.clear();
        }
    }

    /// Takes in which squares were entered first, and by whom.
    #[inline(always)]
    pub(super) fn after_accounting(&mut self) {
        if self.counting {
            self.state.tally.see(&self.state.bodies);
            if !self.arrivals.is_empty() {
                self.count_arrivals();
            }
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

    #[inline(always)]
    fn sense(&mut self) {
        let counting = std::mem::replace(&mut self.counting, false);
        if let Some(crowd) = &mut self.crowd {
            crowd.locate(self.state.bodies.stored());
        }
        self.before_sensing(false, |_, _| {});
        self.counting = counting;
        let Parts {
            phases,
            bodies,
            crowd,
            ..
        } = Parts::of(self);
        let Some((cells, near, _)) = crowd else {
            phases.sense_alone(bodies);
            return;
        };
        let chunks = bodies.chunks_mut(CHUNK).zip(near.chunks_mut());
        for (chunk, (bodies, mut near)) in chunks.enumerate() {
            phases.sense(cells, chunk * CHUNK, bodies, &mut near);
        }
    }

    /// Rebuilds the scratch that depends on positions.
    pub(super) fn find_neighbours(&mut self) {
        let Some(crowd) = &mut self.crowd else { return };
        let (bodies, numbers) = self.state.bodies.stored_mut();
        crowd.locate(bodies);
        crowd.cells.sort(&crowd.places);
        crowd.note_candidates(bodies, numbers);
    }

    /// Stores robots in the order of the cells into which they have just been sorted.
    #[inline(never)]
    fn store_by_cell(&mut self, mut swapped: impl FnMut(usize, usize)) {
        let Some(crowd) = &mut self.crowd else { return };
        crowd.cells.settle(|a, b| {
            self.state.bodies.swap(a, b);
            self.noise_keys.swap(a, b);
            if !self.slip_keys.is_empty() {
                self.slip_keys.swap(a, b);
            }
            swapped(a, b);
        });
        self.state.bodies.renumber();
    }
}

/// Counts a step in a square. Whether it has to be looked at again: the first step in the square, or
/// as many as can be counted.
#[inline(always)]
pub(super) fn count_visit(visits: &mut [[u32; 2]], square: u32, entered: bool) -> bool {
    let visit = &mut visits[square as usize];
    visit[0] = visit[0].saturating_add(u32::from(entered));
    // One test for both.
    let steps = visit[1].wrapping_add(1);
    if steps <= 1 {
        return true;
    }
    visit[1] = steps;
    false
}

/// A world taken apart for a way through all robots.
pub(super) struct Parts<'a> {
    pub phases: Phases<'a>,
    pub bodies: &'a mut [Body],
    /// Where there are several robots.
    pub crowd: Option<(&'a Cells, &'a mut Near, &'a mut [Place])>,
    pub counts: WorldCounts<'a>,
}

/// What is counted of all robots together.
pub(super) struct WorldCounts<'a> {
    pub visits: &'a mut [[u32; 2]],
    pub collisions: &'a mut u64,
    pub arrivals: &'a mut Vec<u32>,
}

impl<'a> Parts<'a> {
    #[inline(always)]
    pub fn of(world: &'a mut World) -> Self {
        let WorldState {
            bodies,
            visits,
            collisions,
            objects,
            ..
        } = &mut world.state;
        let (bodies, numbers) = Bodies::stored_mut(bodies);
        let crowd = world.crowd.as_mut();
        Self {
            phases: Phases {
                optics: &world.optics,
                index: &world.index,
                drive: &world.drive,
                contact: &world.contact,
                grid: world.grid,
                objects: &world.object_grid,
                poses: &objects.poses,
                noise_keys: &world.noise_keys,
                slip_keys: &world.slip_keys,
                numbers,
                noise: world.noise,
                is_large: numbers.len() >= LARGE,
            },
            bodies,
            crowd: crowd.map(|crowd| (&crowd.cells, &mut crowd.near, &mut crowd.places[..])),
            counts: WorldCounts {
                visits,
                collisions,
                arrivals: &mut world.arrivals,
            },
        }
    }
}

/// Steps on the thread that asks for them.
struct Alone<'a, C: ?Sized> {
    world: &'a mut World,
    controllers: &'a mut C,
    steps: u64,
}

impl<C: Controllers + ?Sized> Compiled for Alone<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.world.steps(self.controllers, self.steps);
    }
}

struct Sense<'a>(&'a mut World);

impl Compiled for Sense<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.sense();
    }
}
