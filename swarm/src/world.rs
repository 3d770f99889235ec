//! Robots in one arena: state as struct of arrays, and the phases of a step.
//!
//! Phases: decide, drive, collide, account, sense, learn. [`WorldState`] is what a snapshot holds;
//! everything else in [`World`] is derived from the spec or is scratch.

use std::sync::Arc;

use arenas::Arena;
use arenas::index::WallIndex;
use serde::{Deserialize, Serialize};

use crate::drive::Drive;
use crate::engine::Motor;
use crate::engine::crowd::Crowd;
use crate::engine::kinematic::Contact;
use crate::lanes::F8;
use crate::pilot::Pilot;
use crate::random::{Purpose, Site, mix64, stream_key, unit};
use crate::robot::RobotModel;
use crate::sense::Optics;
use crate::spec::EngineKind;

/// A start pose as the step loop wants it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartPose {
    /// Metres.
    pub x_m: f32,
    /// Metres.
    pub y_m: f32,
    /// Cosine of the heading.
    pub cos: f32,
    /// Sine of the heading.
    pub sin: f32,
}

/// Saved state of all robots of an arena; index is the robot's number.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WorldState {
    /// Steps since the world was made.
    pub step: u64,
    /// Times that sensors were read, the counter of their noise.
    readings: u64,
    /// Robot-steps in contact with a wall or robot while visits were counted.
    pub collisions: u64,
    pub(crate) x_m: Vec<f32>,
    pub(crate) y_m: Vec<f32>,
    pub(crate) cos: Vec<f32>,
    pub(crate) sin: Vec<f32>,
    /// Wheel speeds, left and right, rad/s.
    wheels_rad_s: Vec<[f32; 2]>,
    pub(crate) commands: Vec<[f32; 2]>,
    pub(crate) sensors: Vec<[f32; 8]>,
    square: Vec<u32>,
    /// Entries and steps spent, a square.
    visits: Vec<[u32; 2]>,
}

/// Which instructions the step loop is compiled for. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The baseline of the target.
    Portable,
    /// 256-bit vectors.
    Avx2,
}

impl Backend {
    /// The best that this machine has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            return Backend::Avx2;
        }
        Backend::Portable
    }
}

/// Robots in one arena.
pub struct World {
    state: WorldState,
    motor: Motor,
    backend: Backend,
    /// Whether visits are counted in this stage.
    counting: bool,
    index: Arc<WallIndex>,
    optics: Optics,
    drive: Drive,
    contact: Contact,
    starts: Vec<StartPose>,
    squares_per_side: u32,
    squares_per_m: [f32; 2],
    noise_keys: Vec<u64>,
    slip_keys: Vec<u64>,
    crowd: Option<Crowd>,
    from_x_m: Vec<f32>,
    from_y_m: Vec<f32>,
    way_x_m: Vec<f32>,
    way_y_m: Vec<f32>,
    touched: Vec<bool>,
}

/// What every world of one arena and robot shares: built once, read by all.
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
        let index =
            WallIndex::new(&arena, Contact::wall_margin_m(model), model.sensor_reach_m() + 1e-4);
        Self { arena, index: Arc::new(index) }
    }
}

impl World {
    /// Robots at their start poses, sensors read once.
    pub fn new(
        ground: &Ground,
        model: &RobotModel,
        engine: EngineKind,
        starts: Vec<StartPose>,
        seed: u64,
        site: Site,
    ) -> Self {
        let n = starts.len();
        let squares = ground.arena.squares();
        let state = WorldState {
            step: 0,
            readings: 0,
            collisions: 0,
            x_m: vec![0.0; n],
            y_m: vec![0.0; n],
            cos: vec![1.0; n],
            sin: vec![0.0; n],
            wheels_rad_s: vec![[0.0; 2]; n],
            commands: vec![[0.0; 2]; n],
            sensors: vec![[0.0; 8]; n],
            square: vec![0; n],
            visits: vec![[0; 2]; (squares * squares) as usize],
        };
        let motor = Motor::new(engine, &ground.arena, model, &starts);
        let mut world = Self::assemble(ground, model, state, motor, starts, seed, site);
        world.reset();
        world
    }

    fn assemble(
        ground: &Ground,
        model: &RobotModel,
        state: WorldState,
        motor: Motor,
        starts: Vec<StartPose>,
        seed: u64,
        site: Site,
    ) -> Self {
        let n = starts.len();
        let arena = &ground.arena;
        let squares = arena.squares();
        let contact = Contact::new(model, arena.width_m().max(arena.height_m()));
        let reach_m = model.sensor_reach_m() + model.parameters.body_radius_m;
        let keys = |purpose| {
            (0..n as u64).map(|robot| stream_key(seed, site, robot, purpose)).collect::<Vec<_>>()
        };
        let ways = if matches!(motor, Motor::Rapier(_)) { n } else { 0 };
        let crowd = (n > 1)
            .then(|| Crowd::new(n, arena.width_m(), arena.height_m(), &contact, reach_m));
        Self {
            state,
            motor,
            backend: Backend::detect(),
            counting: false,
            index: Arc::clone(&ground.index),
            optics: Optics::new(model),
            drive: Drive::new(model),
            contact,
            starts,
            squares_per_side: squares,
            squares_per_m: [
                (f64::from(squares) / arena.width_m()) as f32,
                (f64::from(squares) / arena.height_m()) as f32,
            ],
            noise_keys: keys(Purpose::SensorNoise),
            slip_keys: keys(Purpose::WheelSlip),
            crowd,
            from_x_m: vec![0.0; n],
            from_y_m: vec![0.0; n],
            way_x_m: vec![0.0; ways],
            way_y_m: vec![0.0; ways],
            touched: vec![false; n],
        }
    }

    /// A world that goes on from saved state, to the same bits as the one that was saved.
    pub fn restore(
        ground: &Ground,
        model: &RobotModel,
        state: WorldState,
        motor: Motor,
        starts: Vec<StartPose>,
        seed: u64,
        site: Site,
    ) -> Option<Self> {
        let n = starts.len();
        let squares = (ground.arena.squares() * ground.arena.squares()) as usize;
        let fits = [
            state.x_m.len(),
            state.y_m.len(),
            state.cos.len(),
            state.sin.len(),
            state.wheels_rad_s.len(),
            state.commands.len(),
            state.sensors.len(),
            state.square.len(),
        ]
        .iter()
        .all(|&length| length == n)
            && state.visits.len() == squares
            && state.square.iter().all(|&s| (s as usize) < squares);
        if !fits {
            return None;
        }
        let mut world = Self::assemble(ground, model, state, motor, starts, seed, site);
        world.find_neighbours();
        Some(world)
    }

    /// The saved part.
    pub fn state(&self) -> &WorldState {
        &self.state
    }

    /// The engine, for snapshots.
    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// Robots.
    pub fn robots(&self) -> usize {
        self.starts.len()
    }

    /// Runs the step loop with other instructions than the best; results stay the same.
    pub fn set_backend(&mut self, backend: Backend) {
        self.backend = match backend {
            Backend::Avx2 => Backend::detect(),
            Backend::Portable => Backend::Portable,
        };
    }

    /// Whether visits and collisions count from now on.
    pub fn set_counting(&mut self, counting: bool) {
        self.counting = counting;
    }

    /// Entries of each square, row 0 lowest.
    pub fn visits(&self) -> Vec<u32> {
        self.state.visits.iter().map(|v| v[0]).collect()
    }

    /// Steps spent in each square, row 0 lowest.
    pub fn dwell(&self) -> Vec<u32> {
        self.state.visits.iter().map(|v| v[1]).collect()
    }

    /// Squares entered at least 1, 2, 5 and 10 times.
    pub fn coverage(&self) -> [u32; 4] {
        let mut counts = [0; 4];
        for visit in &self.state.visits {
            for (count, least) in counts.iter_mut().zip([1, 2, 5, 10]) {
                *count += u32::from(visit[0] >= least);
            }
        }
        counts
    }

    /// Bytes held for robots and squares, index excluded.
    pub fn bytes(&self) -> usize {
        let robot = size_of::<StartPose>() + 4 * 6 + 8 + 8 + 32 + 4 + 8 + 8 + 1;
        self.robots() * robot
            + size_of_val(&self.state.visits[..])
            + self.crowd.as_ref().map_or(0, Crowd::bytes)
    }

    /// Puts every robot back to its start pose at rest and reads the sensors.
    pub fn reset(&mut self) {
        let state = &mut self.state;
        for (i, start) in self.starts.iter().enumerate() {
            state.x_m[i] = start.x_m;
            state.y_m[i] = start.y_m;
            state.cos[i] = start.cos;
            state.sin[i] = start.sin;
            state.wheels_rad_s[i] = [0.0; 2];
            state.commands[i] = [0.0; 2];
        }
        self.motor.place(&state.x_m, &state.y_m);
        self.enter_squares();
        match self.backend {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Avx2` is only ever set after detection.
            Backend::Avx2 => unsafe { sense_avx2(self) },
            _ => self.sense(),
        }
    }

    /// Counts the squares that robots stand in as entered: called where visits begin to count.
    pub fn enter_squares(&mut self) {
        for i in 0..self.starts.len() {
            let square = self.square_of(self.state.x_m[i], self.state.y_m[i]);
            self.state.square[i] = square;
            if self.counting {
                self.state.visits[square as usize][0] += 1;
            }
        }
    }

    /// Moves every robot `steps` times; `pilots` has one entry a robot.
    pub fn advance<P: Pilot>(&mut self, pilots: &mut [P], steps: u64) {
        assert_eq!(pilots.len(), self.robots(), "one pilot a robot");
        match self.backend {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Avx2` is only ever set after detection.
            Backend::Avx2 => unsafe { advance_avx2(self, pilots, steps) },
            _ => self.steps(pilots, steps),
        }
    }

    #[inline(always)]
    fn steps<P: Pilot>(&mut self, pilots: &mut [P], steps: u64) {
        for _ in 0..steps {
            self.decide_and_drive(pilots);
            self.collide();
            self.account();
            self.sense();
            for (pilot, raw) in pilots.iter_mut().zip(&self.state.sensors) {
                pilot.learn(&F8(*raw));
            }
            self.state.step += 1;
        }
    }

    #[inline(always)]
    fn decide_and_drive<P: Pilot>(&mut self, pilots: &mut [P]) {
        let state = &mut self.state;
        let slips = self.drive.slips();
        for (i, pilot) in pilots.iter_mut().enumerate() {
            let command = pilot.act(state.step, &F8(state.sensors[i]));
            state.commands[i] = command;
            let [left, right] = state.wheels_rad_s[i];
            let left = self.drive.accelerate(left, command[0]);
            let right = self.drive.accelerate(right, command[1]);
            state.wheels_rad_s[i] = [left, right];
            let (mut ground_left, mut ground_right) = (left, right);
            if slips {
                let word = mix64(self.slip_keys[i].wrapping_add(mix64(state.step)));
                ground_left = self.drive.slipped(left, unit(word as u32));
                ground_right = self.drive.slipped(right, unit((word >> 32) as u32));
            }
            let motion =
                self.drive.step(ground_left, ground_right, state.cos[i], state.sin[i]);
            self.from_x_m[i] = state.x_m[i];
            self.from_y_m[i] = state.y_m[i];
            state.x_m[i] += motion.dx_m;
            state.y_m[i] += motion.dy_m;
            state.cos[i] = motion.cos;
            state.sin[i] = motion.sin;
        }
    }

    #[inline(always)]
    fn collide(&mut self) {
        let state = &mut self.state;
        let from = (&self.from_x_m[..], &self.from_y_m[..]);
        match &mut self.motor {
            Motor::Kinematic => {
                for i in 0..self.starts.len() {
                    let placed = self.contact.move_to(
                        &self.index,
                        (from.0[i], from.1[i]),
                        (state.x_m[i], state.y_m[i]),
                    );
                    (state.x_m[i], state.y_m[i]) = (placed.x_m, placed.y_m);
                    self.touched[i] = placed.touched;
                }
                if let Some(crowd) = &mut self.crowd {
                    crowd.separate(
                        &self.contact,
                        &self.index,
                        from,
                        &mut state.x_m,
                        &mut state.y_m,
                        &mut self.touched,
                    );
                }
            }
            Motor::Rapier(engine) => {
                // The engine takes places before the step and ways; it writes places after it.
                for i in 0..self.starts.len() {
                    self.way_x_m[i] = state.x_m[i] - from.0[i];
                    self.way_y_m[i] = state.y_m[i] - from.1[i];
                }
                state.x_m.copy_from_slice(from.0);
                state.y_m.copy_from_slice(from.1);
                engine.step(
                    &mut state.x_m,
                    &mut state.y_m,
                    &self.way_x_m,
                    &self.way_y_m,
                    &mut self.touched,
                );
            }
        }
    }

    #[inline(always)]
    fn square_of(&self, x_m: f32, y_m: f32) -> u32 {
        let last = self.squares_per_side as i32 - 1;
        let column = ((x_m * self.squares_per_m[0]) as i32).clamp(0, last);
        let row = ((y_m * self.squares_per_m[1]) as i32).clamp(0, last);
        row as u32 * self.squares_per_side + column as u32
    }

    #[inline(always)]
    fn account(&mut self) {
        if !self.counting {
            return;
        }
        for i in 0..self.starts.len() {
            let square = self.square_of(self.state.x_m[i], self.state.y_m[i]);
            let entered = u32::from(square != self.state.square[i]);
            self.state.square[i] = square;
            let visit = &mut self.state.visits[square as usize];
            visit[0] = visit[0].saturating_add(entered);
            visit[1] = visit[1].saturating_add(1);
            self.state.collisions += u64::from(self.touched[i]);
        }
    }

    #[inline(always)]
    fn sense(&mut self) {
        let state = &mut self.state;
        let (optics, index) = (&self.optics, &*self.index);
        let counter = state.readings.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        state.readings += 1;
        match &mut self.crowd {
            None => {
                let (x, y) = (state.x_m[0], state.y_m[0]);
                let rays = optics.rays(x, y, state.cos[0], state.sin[0]);
                let distance = optics.to_walls(&rays, index, x, y);
                let word = mix64(self.noise_keys[0].wrapping_add(counter));
                state.sensors[0] = optics.respond(distance, word).0;
            }
            Some(crowd) => {
                crowd.sort(&state.x_m, &state.y_m);
                let see2 = optics.sight_m2();
                for i in 0..self.starts.len() {
                    let (x, y) = (state.x_m[i], state.y_m[i]);
                    let rays = optics.rays(x, y, state.cos[i], state.sin[i]);
                    let mut distance = optics.to_walls(&rays, index, x, y);
                    crowd.visit(i, x, y, |ox, oy| {
                        let (dx, dy) = (ox - x, oy - y);
                        if dx * dx + dy * dy < see2 {
                            distance = optics.to_robot(&rays, ox, oy, distance);
                        }
                    });
                    let word = mix64(self.noise_keys[i].wrapping_add(counter));
                    state.sensors[i] = optics.respond(distance, word).0;
                }
            }
        }
    }

    /// Rebuilds the scratch that depends on positions.
    fn find_neighbours(&mut self) {
        if let Some(crowd) = &mut self.crowd {
            crowd.sort(&self.state.x_m, &self.state.y_m);
            for i in 0..self.starts.len() {
                crowd.visit(i, self.state.x_m[i], self.state.y_m[i], |_, _| {});
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn advance_avx2<P: Pilot>(world: &mut World, pilots: &mut [P], steps: u64) {
    world.steps(pilots, steps);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn sense_avx2(world: &mut World) {
    world.sense();
}

#[cfg(test)]
mod tests;
