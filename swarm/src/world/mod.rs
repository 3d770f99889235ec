//! Robots in one arena: their state, and the phases of a step (`step.rs`,
//! `phases.rs`; on several threads `shared.rs`).
//!
//! [`WorldState`] is what a snapshot holds; everything else in [`World`] is derived from the spec
//! or is scratch. A robot's state lies together in two cache lines: eight lanes are the eight rays
//! of one robot, so nothing is gained by an array for each quantity, and neighbours are met at
//! random.

mod grid;
mod object_grid;
mod phases;
mod shared;
mod step;
mod tally;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use arenas::index::WallIndex;
use arenas::{Arena, Squares};
use serde::{Deserialize, Serialize};

use grid::Grid;
use object_grid::ObjectGrid;
pub use tally::{SAMPLED_ROBOTS, Tally};

pub use crate::backend::Backend;
pub use crate::bodies::{Bodies, Body, ObjectPose, Objects, StartPose};
use crate::crew::Crew;
use crate::engine::EngineState;
use crate::engine::crowd::Crowd;
use crate::engine::drive::Drive;
use crate::engine::kinematic::Contact;
use crate::kept::wall_index;
use crate::random::{Purpose, Site, stream_key};
use crate::robot::RobotModel;
use crate::sensors::proximity::Optics;
use crate::spec::EngineKind;

/// Saved state of all robots of an arena.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WorldState {
    /// Steps since the world was made.
    pub step: u64,
    /// Times that sensors were read, the counter of their noise.
    readings: u64,
    /// Robot-steps in contact with a wall or robot while visits were counted.
    pub collisions: u64,
    /// The robots; index is the robot's number.
    pub bodies: Bodies,
    /// Entries and steps spent, a square.
    visits: Vec<[u32; 2]>,
    /// When squares were first entered, and by how many robots.
    pub tally: Tally,
    /// Movable objects.
    pub objects: Objects,
}

/// Entries from which on a square counts for p1, p2, p5 and p10.
pub const COVERAGE_LEVELS: [u32; 4] = [1, 2, 5, 10];

/// Robots in one arena.
pub struct World {
    state: WorldState,
    engine: EngineState,
    backend: Backend,
    /// Whether visits are counted in this stage.
    counting: bool,
    index: Arc<WallIndex>,
    optics: Optics,
    drive: Drive,
    contact: Contact,
    starts: Vec<StartPose>,
    grid: Grid,
    /// By slot, like the bodies as they are stored.
    noise_keys: Vec<u64>,
    /// By slot; empty where wheels do not slip.
    slip_keys: Vec<u64>,
    crowd: Option<Crowd>,
    object_grid: ObjectGrid,
    /// Steps for which robots stay stored as they are; 0 has them put in order when sensors are read.
    settled_steps: u32,
    /// Slots of the robots in squares in which no step has been counted so far.
    arrivals: Vec<u32>,
    /// Counter of the noise of the sensors that are being read.
    noise: u64,
    /// Threads that steps may be spread over.
    crew: Crew,
    /// Squares by slot, with a mark where they were entered; only while several threads step.
    squares: Vec<u32>,
}

/// What every world of one arena and robot shares: built once as long as it is kept, read by all.
#[derive(Clone)]
pub struct Ground {
    /// The arena.
    pub arena: Arc<Arena>,
    /// Its walls, indexed for the robot.
    pub index: Arc<WallIndex>,
}

impl Ground {
    /// Indexes an arena for a robot.
    pub fn new(arena: Arc<Arena>, model: &RobotModel) -> Self {
        let (contact_m, reach_m) = (Contact::wall_margin_m(model), model.sensor_reach_m() + 1e-4);
        let index = wall_index(&arena, contact_m, reach_m);
        Self { arena, index }
    }
}

impl World {
    /// Robots at their start poses, sensors read once.
    pub fn new(
        ground: &Ground,
        model: &RobotModel,
        kind: EngineKind,
        starts: Vec<StartPose>,
        seed: u64,
        site: Site,
    ) -> Self {
        let squares = Squares::of(&ground.arena).count();
        let state = WorldState {
            step: 0,
            readings: 0,
            collisions: 0,
            bodies: starts.iter().map(Body::at_rest).collect::<Vec<_>>().into(),
            visits: vec![[0; 2]; squares],
            tally: Tally::default(),
            objects: Objects::new(&ground.arena),
        };
        let engine = EngineState::new(kind, &ground.arena, model, &starts);
        let mut world = Self::assemble(ground, model, state, engine, starts, seed, site);
        world.reset();
        world
    }

    fn assemble(
        ground: &Ground,
        model: &RobotModel,
        state: WorldState,
        engine: EngineState,
        starts: Vec<StartPose>,
        seed: u64,
        site: Site,
    ) -> Self {
        let n = starts.len();
        let arena = &ground.arena;
        let contact = Contact::new(model, arena.width_m().max(arena.height_m()));
        let optics = Optics::new(model);
        let object_grid = ObjectGrid::new(arena, optics.sight_m());
        let keys = |purpose| {
            (0..n as u64)
                .map(|robot| stream_key(seed, site, robot, purpose))
                .collect::<Vec<_>>()
        };
        let drive = Drive::new(model);
        let crowd = (n > 1).then(|| {
            Crowd::new(
                n,
                arena.width_m(),
                arena.height_m(),
                &contact,
                optics.sight_m(),
            )
        });
        Self {
            state,
            engine,
            backend: Backend::detect(),
            counting: false,
            index: Arc::clone(&ground.index),
            optics,
            contact,
            starts,
            grid: Grid::of(arena),
            object_grid,
            noise_keys: keys(Purpose::SensorNoise),
            slip_keys: if drive.slips() {
                keys(Purpose::WheelSlip)
            } else {
                Vec::new()
            },
            drive,
            crowd,
            settled_steps: 0,
            arrivals: Vec::with_capacity(n),
            noise: 0,
            crew: Crew::default(),
            squares: Vec::new(),
        }
    }

    /// A world that goes on from saved state, to the same bits as the one that was saved; `None`
    /// when the state is of another arena or number of robots.
    pub fn restore(
        ground: &Ground,
        model: &RobotModel,
        state: WorldState,
        engine: EngineState,
        starts: Vec<StartPose>,
        seed: u64,
        site: Site,
    ) -> Option<Self> {
        let squares = Squares::of(&ground.arena).count();
        let fits = state.bodies.len() == starts.len()
            && engine.fits(&state.bodies)
            && state.visits.len() == squares
            && state.tally.fits(starts.len(), squares)
            && state.objects.fits(&ground.arena)
            && state
                .bodies
                .iter()
                .all(|body| (body.square as usize) < squares);
        if !fits {
            return None;
        }
        let mut world = Self::assemble(ground, model, state, engine, starts, seed, site);
        world.find_neighbours();
        Some(world)
    }

    /// The saved part.
    pub fn state(&self) -> &WorldState {
        &self.state
    }

    /// The engine, for snapshots.
    pub fn engine(&self) -> &EngineState {
        &self.engine
    }

    /// Where robots are put by [`World::reset`]; index is the robot's number.
    pub fn starts(&self) -> &[StartPose] {
        &self.starts
    }

    /// Robots.
    pub fn robots(&self) -> usize {
        self.starts.len()
    }

    /// Runs the step loop with other instructions than the best; results stay the same.
    pub fn set_backend(&mut self, backend: Backend) {
        self.backend = backend.or_portable();
    }

    /// Spreads steps over these threads, where the world is large enough; results stay the same.
    pub fn set_crew(&mut self, crew: &Crew) {
        self.crew = crew.clone();
    }

    /// Whether visits and collisions count from now on.
    pub fn set_counting(&mut self, counting: bool) {
        self.counting = counting;
        if counting {
            let squares = self.state.visits.len();
            self.state.tally.begin(self.starts.len(), squares);
        }
    }

    /// Entries and steps spent of each square, row 0 lowest.
    pub fn visit_counts(&self) -> &[[u32; 2]] {
        &self.state.visits
    }

    /// Entries of each square, row 0 lowest.
    pub fn entries(&self) -> impl Iterator<Item = u32> {
        self.state.visits.iter().map(|visit| visit[0])
    }

    /// The same as a list.
    pub fn visits(&self) -> Vec<u32> {
        self.entries().collect()
    }

    /// Steps spent in each square, row 0 lowest.
    pub fn dwell(&self) -> Vec<u32> {
        self.state.visits.iter().map(|v| v[1]).collect()
    }

    /// Squares entered at least 1, 2, 5 and 10 times.
    pub fn coverage(&self) -> [u32; 4] {
        let mut counts = [0; 4];
        for visit in &self.state.visits {
            for (count, least) in counts.iter_mut().zip(COVERAGE_LEVELS) {
                *count += u32::from(visit[0] >= least);
            }
        }
        counts
    }

    /// Bytes held for robots and squares, index of walls excluded.
    pub fn bytes(&self) -> usize {
        self.state.bodies.bytes()
            + size_of_val(&self.starts[..])
            + size_of_val(&self.noise_keys[..])
            + size_of_val(&self.slip_keys[..])
            + self.arrivals.capacity() * size_of::<u32>()
            + size_of_val(&self.state.visits[..])
            + self.state.tally.bytes()
            + size_of_val(&self.state.objects.poses[..])
            + size_of_val(&self.state.objects.moved_m[..])
            + self.object_grid.bytes()
            + self.crowd.as_ref().map_or(0, Crowd::bytes)
    }

    /// Puts every robot back to its start pose at rest and reads the sensors.
    pub fn reset(&mut self) {
        for (number, start) in self.starts.iter().enumerate() {
            self.state.bodies.get_mut(number).put_back(start);
        }
        self.engine.place(&self.state.bodies);
        self.settled_steps = 0;
        if let EngineState::Rapier(rigid) = &self.engine {
            self.state.objects.follow(rigid.objects(), false);
        }
        self.enter_squares();
        self.sense_all();
    }

    /// Counts the squares that robots stand in as entered: called where visits begin to count.
    pub fn enter_squares(&mut self) {
        for i in 0..self.state.bodies.len() {
            let body = &self.state.bodies[i];
            let square = self.square_of(body.x_m, body.y_m);
            let body = self.state.bodies.get_mut(i);
            body.square = square;
            if self.counting {
                self.state.tally.enter(square, body);
                let entries = &mut self.state.visits[square as usize][0];
                *entries = entries.saturating_add(1);
            }
        }
        if self.counting {
            self.state.tally.see(&self.state.bodies);
        }
    }
}
