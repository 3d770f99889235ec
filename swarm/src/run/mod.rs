//! A run: a spec brought to life, as a state machine stepped in blocks, saved and restored.

mod learners;
mod metrics;
mod model;
mod plan;
mod snapshot;
#[cfg(test)]
mod tests;
mod tracks;
mod types;

use std::sync::{Arc, OnceLock};

use arenas::{Arena, Reachable};
use sha2::{Digest, Sha256};

pub use metrics::{Metrics, MetricsLog, MetricsRow, RobotMetrics, time_to_cover};
pub use tracks::{Moment, ObjectSample, Tracks};
pub use types::{CurveRow, ObjectOutcome, Outcome, Phase, Progress, RestoreError, RobotMemory};

use crate::memory::MemoryPlan;
use crate::placement::place;
use crate::random::{Purpose, Site, stream_key};
use crate::sharing::Sharing;
use crate::sharing::radio::Radio;
use crate::spec::{Episodes, FieldError, RunSpec};
use crate::world::{Backend, Bodies, Ground, StartPose, World};
use learners::Learners;
use plan::{Stage, arena_epochs};
pub(crate) use plan::{StageKind, stages};

/// Most epochs of a run.
pub const MAX_EPOCHS: u32 = 1_000_000;
/// Most steps of an epoch.
pub const MAX_STEPS_PER_EPOCH: u32 = 1_000_000;
/// Most robots of a run.
pub const MAX_ROBOTS: u32 = 100_000;

/// Entries from which on a square counts for p1, p2, p5 and p10.
const COVERAGE_LEVELS: [u32; 4] = [1, 2, 5, 10];

/// A run in progress.
pub struct Run {
    spec: RunSpec,
    stages: Vec<Stage>,
    /// The target arena and, where the method trains elsewhere first, the training arena.
    venues: Vec<Venue>,
    place: Place,
    memory: MemoryPlan,
    learners: Learners,
    curve: Vec<CurveRow>,
    metrics: Vec<MetricsRow>,
    tracks: Tracks,
    /// Squares in reach, found when first asked for.
    reachable: OnceLock<Reachable>,
    /// Sensori-motor clusters that phase 1 ended with.
    sensori_motor_clusters: u32,
}

const TARGET: usize = 0;
const TRAINING: usize = 1;

/// An arena with its robots and what is needed to make them anew.
struct Venue {
    ground: Ground,
    starts: Vec<StartPose>,
    site: Site,
    world: World,
    /// Where robots share by radio.
    radio: Option<Radio>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
struct Place {
    stage: u32,
    /// Epochs of the stage that are complete.
    epoch: u32,
    /// In an epoch that shows in the target arena what was evaluated in the training arena.
    showing: bool,
    /// Steps of the epoch that are done.
    step: u32,
    /// Arena steps done in all.
    steps: u64,
}

/// The arenas that robots are put into.
fn sites<'a>(
    spec: &'a RunSpec,
    stages: &[Stage],
) -> impl Iterator<Item = (&'a Arc<Arena>, Site)> + use<'a> {
    let trains = stages.iter().any(|stage| stage.site == Site::Training);
    let training = spec.controller.training.as_ref().filter(|_| trains);
    let training = training.map(|training| (&training.arena, Site::Training));
    std::iter::once((&spec.arena, Site::Target)).chain(training)
}

fn starts(spec: &RunSpec, ground: &Ground, site: Site) -> Result<Vec<StartPose>, FieldError> {
    place(
        &ground.arena,
        &spec.robot,
        &ground.index,
        spec.placement,
        spec.robots,
        spec.seed,
        site,
    )
    .map_err(|error| match site {
        Site::Target => error,
        Site::Training => FieldError {
            message: format!("{} (training arena)", error.message),
            ..error
        },
    })
}

/// Whether the robots of a valid spec can be put into its arenas. Fewer robots always fit where
/// more do, and only random placement depends on the seed.
///
/// # Errors
/// When they cannot; says how many can.
pub fn check_placement(spec: &RunSpec) -> Result<(), FieldError> {
    let stages = MemoryPlan::of(spec).map_or_else(|_| Vec::new(), |plan| stages(spec, &plan));
    sites(spec, &stages).try_for_each(|(arena, site)| {
        let ground = Ground::new(Arc::clone(arena), &spec.robot);
        starts(spec, &ground, site).map(drop)
    })
}

impl Venue {
    fn new(
        spec: &RunSpec,
        memory: &MemoryPlan,
        arena: &Arc<Arena>,
        site: Site,
    ) -> Result<Self, FieldError> {
        let ground = Ground::new(Arc::clone(arena), &spec.robot);
        let starts = starts(spec, &ground, site)?;
        let world = World::new(
            &ground,
            &spec.robot,
            spec.engine,
            starts.clone(),
            spec.seed,
            site,
        );
        let radio = match &spec.sharing {
            Sharing::Radio(link) => Some(Radio::new(
                link,
                memory,
                spec.robots as usize,
                (arena.width_m(), arena.height_m()),
                stream_key(spec.seed, site, 0, Purpose::Radio),
            )),
            Sharing::None | Sharing::Arena => None,
        };
        Ok(Self {
            ground,
            starts,
            site,
            world,
            radio,
        })
    }

    /// Starts over, noise and all, as if the arena had never been used.
    fn begin_again(&mut self, spec: &RunSpec) {
        let starts = self.starts.clone();
        self.world = World::new(
            &self.ground,
            &spec.robot,
            spec.engine,
            starts,
            spec.seed,
            self.site,
        );
    }
}

impl Run {
    /// Checks the spec and sets the run up.
    ///
    /// # Errors
    /// Every field of the spec that cannot be used.
    pub fn new(spec: RunSpec) -> Result<Self, Vec<FieldError>> {
        let errors = spec.validate();
        if !errors.is_empty() {
            return Err(errors);
        }
        let memory = MemoryPlan::of(&spec).map_err(|_| spec.validate())?;
        let stages = stages(&spec, &memory);
        let venues = sites(&spec, &stages)
            .map(|(arena, site)| Venue::new(&spec, &memory, arena, site))
            .collect::<Result<_, _>>()
            .map_err(|e| vec![e])?;
        let mut run = Self {
            reachable: OnceLock::new(),
            learners: Learners::Idle,
            place: Place {
                stage: 0,
                epoch: 0,
                showing: false,
                step: 0,
                steps: 0,
            },
            curve: Vec::new(),
            metrics: Vec::new(),
            tracks: Tracks::default(),
            sensori_motor_clusters: 0,
            memory,
            spec,
            stages,
            venues,
        };
        run.begin_stage();
        Ok(run)
    }

    /// A run that goes on from [`Run::snapshot`], to the same bits as one never interrupted.
    ///
    /// # Errors
    /// When the bytes are damaged, of another version or of another spec.
    pub fn restore(spec: RunSpec, bytes: &[u8]) -> Result<Self, RestoreError> {
        snapshot::restore(spec, bytes)
    }

    /// Everything needed to go on, at any step, in the middle of an epoch too. Same state, same
    /// bytes.
    pub fn snapshot(&self) -> Vec<u8> {
        snapshot::save(self)
    }

    /// Steps the run on by at most `max_steps` steps of its arena (each moves every robot once).
    pub fn advance(&mut self, max_steps: u64) -> Progress {
        let mut left = max_steps;
        while left > 0 && self.stage().is_some() {
            let until = self.next_row();
            let rest = u64::from(until - self.place.step);
            let steps = rest.min(left);
            let venue = self.venue();
            let Venue { world, radio, .. } = &mut self.venues[venue];
            self.learners.advance(world, radio.as_mut(), steps);
            self.place.step += steps as u32;
            self.place.steps += steps;
            left -= steps;
            if self.place.step == self.spec.steps_per_epoch {
                self.end_epoch();
            } else if self.place.step == until {
                self.add_row();
            }
        }
        self.progress()
    }

    fn stage(&self) -> Option<Stage> {
        self.stages.get(self.place.stage as usize).copied()
    }

    /// Index of the arena that robots are in.
    fn venue(&self) -> usize {
        let training = self
            .stage()
            .is_some_and(|stage| stage.site == Site::Training);
        if training && !self.place.showing {
            TRAINING
        } else {
            TARGET
        }
    }

    /// Sets learners and arena up for the stage that the run has come to.
    fn begin_stage(&mut self) {
        let Some(stage) = self.stage() else { return };
        let learners = std::mem::replace(&mut self.learners, Learners::Idle);
        if let Some(clusters) = learners.sensori_motor_clusters() {
            self.sensori_motor_clusters = clusters;
        }
        self.learners = learners.begin(stage.kind, &self.spec, &self.memory);
        if stage.kind == StageKind::Replay && stage.site == Site::Training {
            // The replay gives the trajectories of phase 1 back, so it must meet the same noise.
            self.venues[TRAINING].begin_again(&self.spec);
        }
        if stage.kind.counts() {
            self.resume_counting();
            if self.spec.episodes == Episodes::Continue {
                self.venues[TARGET].world.enter_squares();
            }
        }
        self.begin_epoch();
        if stage.kind.counts() {
            self.track_objects();
        }
    }

    /// Lets visits count where the stage says so.
    fn resume_counting(&mut self) {
        let counts = self.stage().is_some_and(|stage| stage.kind.counts());
        self.venues[TARGET].world.set_counting(counts);
    }

    fn begin_epoch(&mut self) {
        self.place.step = 0;
        let venue = self.venue();
        let world = &mut self.venues[venue].world;
        if self.spec.episodes == Episodes::Reset {
            world.reset();
        }
        self.learners.begin_trajectory(world.state());
    }

    fn end_epoch(&mut self) {
        let Some(stage) = self.stage() else { return };
        if self.place.showing {
            self.place.showing = false;
            self.learners.set_showing(false);
            self.learners.next_candidates();
        } else {
            self.learners.end_trajectory();
            if stage.kind == StageKind::EvolveAndShow {
                self.place.showing = true;
                self.learners.set_showing(true);
                self.begin_epoch();
                return;
            }
            self.learners.next_candidates();
        }
        self.place.epoch += 1;
        if stage.kind.counts() {
            self.curve.push(self.curve_row(self.place.epoch));
            self.row_after_epoch();
        }
        if self.place.epoch < stage.epochs {
            self.begin_epoch();
        } else {
            self.place.stage += 1;
            self.place.epoch = 0;
            self.place.step = 0;
            self.begin_stage();
        }
    }

    fn curve_row(&self, epoch: u32) -> CurveRow {
        let [p1, p2, p5, p10] = self.venues[TARGET].world.coverage();
        CurveRow {
            epoch,
            p1,
            p2,
            p5,
            p10,
        }
    }

    /// How far the run is.
    pub fn progress(&self) -> Progress {
        let robots = u64::from(self.spec.robots);
        Progress {
            phase: self.stage().map_or(Phase::Done, |stage| stage.kind.phase()),
            epochs_done: self.curve.len() as u32,
            epochs_total: self.spec.epochs,
            robot_steps_done: self.place.steps * robots,
            robot_steps_total: arena_epochs(&self.stages)
                * u64::from(self.spec.steps_per_epoch)
                * robots,
        }
    }

    /// What the run was made from.
    pub fn spec(&self) -> &RunSpec {
        &self.spec
    }

    /// One row a completed counted epoch.
    pub fn curve(&self) -> &[CurveRow] {
        &self.curve
    }

    /// Entries counted a square of the target arena; row 0 is the lowest y.
    pub fn visits(&self) -> Vec<u32> {
        self.venues[TARGET].world.visits()
    }

    /// Steps spent a square of the target arena; row 0 is the lowest y.
    pub fn dwell(&self) -> Vec<u32> {
        self.venues[TARGET].world.dwell()
    }

    /// Squares of the target arena that a robot of this size can reach from the first start pose.
    pub fn reachable(&self) -> &Reachable {
        let (arena, radius_m) = (&self.spec.arena, self.spec.robot.parameters.body_radius_m);
        self.reachable
            .get_or_init(|| arenas::reachable(arena, arena.starts()[0], radius_m))
    }

    /// Arena steps so far, all stages together: the number of the current frame.
    pub fn step(&self) -> u64 {
        self.place.steps
    }

    /// The arena that robots are in right now.
    pub fn arena(&self) -> &Arc<Arena> {
        &self.venues[self.venue()].ground.arena
    }

    /// All robots, in the arena that they are in right now; index is the robot's number.
    pub fn robots(&self) -> &Bodies {
        &self.venues[self.venue()].world.state().bodies
    }

    /// Bytes that robots, learners and squares hold, exactly counted.
    pub fn bytes(&self) -> u64 {
        let worlds: usize = self.venues.iter().map(|venue| venue.world.bytes()).sum();
        worlds as u64 + self.learners.bytes()
    }

    /// What each robot's learner may hold.
    pub fn memory_plan(&self) -> &MemoryPlan {
        &self.memory
    }

    /// What each robot's learner holds right now; index is the robot's number.
    pub fn memory(&self) -> Vec<RobotMemory> {
        self.learners.memory(&self.memory, &self.spec.sharing)
    }

    /// Steps with other instructions than the machine's best; results stay the same.
    pub fn set_backend(&mut self, backend: Backend) {
        for venue in &mut self.venues {
            venue.world.set_backend(backend);
        }
    }

    /// What the run has to say, once all epochs are done.
    pub fn outcome(&self) -> Option<Outcome> {
        if self.stage().is_some() {
            return None;
        }
        let (sensor_clusters, actuator_clusters) = self.learners.clusters();
        let reachable = self.reachable();
        Some(Outcome {
            coverage: self.curve_row(self.spec.epochs),
            reachable: reachable.count,
            metrics: self.final_metrics(),
            coverage_reachable: counts_within(&self.visits(), &reachable.mask),
            robot_steps: self.progress().robot_steps_done,
            collisions: self.venues[TARGET].world.state().collisions,
            sensor_clusters,
            actuator_clusters,
            sensori_motor_clusters: self
                .learners
                .sensori_motor_clusters()
                .unwrap_or(self.sensori_motor_clusters),
            model: self.model_accuracy(),
            bytes: self.bytes(),
            memory_plan: self.memory.clone(),
            memory: self.memory(),
            objects: self.objects(),
            state_sha256: hex(&Sha256::digest(self.snapshot())),
        })
    }
}

/// Squares of a mask entered at least 1, 2, 5 and 10 times.
pub fn counts_within(visits: &[u32], mask: &[bool]) -> [u32; 4] {
    COVERAGE_LEVELS.map(|level| {
        let entered = visits
            .iter()
            .zip(mask)
            .filter(|&(&entries, &inside)| inside && entries >= level);
        // An arena has at most 1,000 x 1,000 squares.
        entered.count() as u32
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
