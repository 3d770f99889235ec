//! A run: a spec brought to life, as a state machine stepped in blocks.

use std::sync::{Arc, OnceLock};

use arenas::{Arena, Reachable};

use super::coverage::CurveRow;
use super::learners::Learners;
use super::metrics::{MetricsRow, has_row, next_within};
use super::outcome::Progress;
use super::position::RunPosition;
use super::robot_memory::RobotMemory;
use super::tracks::{MOST_SAMPLES, Time, Tracks};
use super::venue::{TARGET, TRAINING, Venue, sites};
use crate::bodies::Bodies;
use crate::caps::MemoryPlan;
use crate::crew::Crew;
use crate::dimensions::WHEELS;
use crate::kept;
use crate::methods::Explores;
use crate::random::Site;
use crate::spec::{FieldError, RunSpec};
use crate::stages::{Phase, Stage, arena_epochs};
use crate::validate::ValidSpec;
use crate::world::Backend;

/// A run in progress.
pub struct Run {
    pub(super) spec: RunSpec,
    pub(super) stages: Vec<Stage>,
    /// The target arena and, where the method trains elsewhere first, the training arena.
    pub(super) venues: Vec<Venue>,
    pub(super) position: RunPosition,
    pub(super) memory: MemoryPlan,
    pub(super) learners: Learners,
    pub(super) curve: Vec<CurveRow>,
    pub(super) metrics: Vec<MetricsRow>,
    pub(super) tracks: Tracks,
    /// Squares in reach, found when first asked for.
    pub(super) reachable: OnceLock<Arc<Reachable>>,
    /// Threads that work may be spread over.
    pub(super) crew: Crew,
    /// Sensori-motor clusters that phase 1 ended with.
    pub(super) sensori_motor_clusters: u32,
}

/// Sees the steps 0, n, 2n, ... of each epoch: 0 is where robots begin, before the first move, and
/// the last is seen before robots are put back. It sees no step twice, in however many calls a run
/// is stepped, interrupted or not.
pub trait Witness {
    /// Steps between two looks.
    fn every_steps(&self) -> u32;

    /// Looks at the run.
    fn see(&mut self, run: &Run);
}

impl Run {
    /// Sets a run up.
    ///
    /// # Errors
    /// When the robots do not fit into the arenas; says how many do.
    pub fn new(spec: ValidSpec) -> Result<Self, Vec<FieldError>> {
        let (spec, memory, stages) = spec.into_parts();
        let venues = sites(&spec, &stages)
            .map(|(arena, site)| Venue::new(&spec, &memory, arena, site))
            .collect::<Result<_, _>>()
            .map_err(|error| vec![error])?;
        let crew = Crew::default();
        let mut run = Self {
            reachable: OnceLock::new(),
            learners: Learners::begin(None, &stages[0], &spec, &memory, &crew),
            position: RunPosition::default(),
            curve: Vec::new(),
            metrics: Vec::new(),
            tracks: Tracks::default(),
            sensori_motor_clusters: 0,
            crew,
            memory,
            spec,
            stages,
            venues,
        };
        run.enter_stage();
        Ok(run)
    }

    /// Steps the run on by at most `max_steps` steps of its arena (each moves every robot once).
    pub fn advance(&mut self, max_steps: u64) -> Progress {
        self.advance_before(max_steps, None)
    }

    /// As [`Run::advance`], before the eyes of a witness, who changes nothing.
    pub fn advance_before(
        &mut self,
        max_steps: u64,
        mut witness: Option<&mut dyn Witness>,
    ) -> Progress {
        let mut left = max_steps;
        while left > 0 && self.stage().is_some() {
            let row = self.next_row();
            let rest = u64::from(row - self.position.step);
            let steps = rest.min(left);
            match &mut witness {
                None => self.step_on(steps as u32),
                Some(witness) => self.step_on_before(&mut **witness, steps as u32),
            }
            left -= steps;
            if self.position.step == self.spec.steps_per_epoch {
                self.end_epoch();
            } else if self.position.step == row {
                self.add_row();
            }
        }
        self.progress()
    }

    /// Says what robots that are steered from outside (`external`) do from the next step on: a
    /// command for each, left and right in [-1, 1], by their numbers. Robots of other methods go
    /// their own way.
    pub fn steer(&mut self, commands: &[[f32; WHEELS]]) {
        self.learners.steer(commands);
    }

    /// Epoch of the present stage that the run is in, and its step within it, both from 0.
    pub fn epoch_and_step(&self) -> (u32, u32) {
        (self.position.epoch, self.position.step)
    }

    /// Moves every robot so many times, within an epoch.
    fn step_on(&mut self, steps: u32) {
        let venue = self.venue();
        let Venue { world, radio, .. } = &mut self.venues[venue];
        self.learners
            .advance(world, radio.as_mut(), u64::from(steps));
        self.position.step += steps;
        self.position.steps += u64::from(steps);
    }

    /// As [`Run::step_on`], with a look at the beginning of the epoch and every so many steps of it.
    fn step_on_before(&mut self, witness: &mut dyn Witness, steps: u32) {
        if self.position.step == 0 {
            witness.see(self);
        }
        let every = witness.every_steps().max(1);
        let end = self.position.step + steps;
        let mut look = u64::from(self.position.step / every) * u64::from(every);
        while self.position.step < end {
            look += u64::from(every);
            let until = look.min(u64::from(end)) as u32;
            self.step_on(until - self.position.step);
            if u64::from(until) == look {
                witness.see(self);
            }
        }
    }

    pub(super) fn stage(&self) -> Option<Stage> {
        self.stages.get(self.position.stage as usize).copied()
    }

    /// Index of the arena that robots are in.
    pub(super) fn venue(&self) -> usize {
        let training = self
            .stage()
            .is_some_and(|stage| stage.site == Site::Training);
        if training && !self.position.showing {
            TRAINING
        } else {
            TARGET
        }
    }

    /// Makes the learners of the stage that the run has come to from those of the last.
    fn begin_stage(&mut self) {
        let Some(stage) = self.stage() else { return };
        // Nobody for a moment: the learners of a stage are made of those of the last.
        let learners = std::mem::replace(&mut self.learners, Learners::nobody());
        if let Some(clusters) = learners.sensori_motor_clusters() {
            self.sensori_motor_clusters = clusters;
        }
        let (spec, plan) = (&self.spec, &self.memory);
        self.learners = Learners::begin(Some(learners), &stage, spec, plan, &self.crew);
        self.enter_stage();
    }

    /// Sets the arena up for the stage that the run has come to.
    fn enter_stage(&mut self) {
        let Some(stage) = self.stage() else { return };
        if stage.phase == Phase::Repository && stage.site == Site::Training {
            // The replay gives the trajectories of phase 1 back, so it must meet the same noise.
            self.venues[TRAINING].begin_again(&self.spec, &self.crew);
        }
        if stage.counts() {
            self.resume_counting();
            if !self.resets(stage.phase) {
                self.venues[TARGET].world.enter_squares();
            }
        }
        self.begin_epoch();
        if stage.counts() {
            self.track_objects();
        }
    }

    /// Whether robots of a phase go back to their start poses between epochs.
    fn resets(&self, phase: Phase) -> bool {
        let evolving = match phase {
            Phase::Evolution | Phase::Repository => true,
            Phase::Babbling | Phase::Done => false,
            Phase::Exploration => {
                let method = self.spec.controller.method.definition();
                method.explores == Explores::Evolving
            }
        };
        self.spec.episodes.reset(evolving)
    }

    /// Lets visits count where the stage says so.
    pub(super) fn resume_counting(&mut self) {
        let counts = self.stage().is_some_and(|stage| stage.counts());
        self.venues[TARGET].world.set_counting(counts);
    }

    pub(super) fn begin_epoch(&mut self) {
        self.position.step = 0;
        let venue = self.venue();
        let resets = self.stage().is_none_or(|stage| self.resets(stage.phase));
        let world = &mut self.venues[venue].world;
        if resets {
            world.reset();
        }
        self.learners.begin_trajectory(world.state());
    }

    fn end_epoch(&mut self) {
        let Some(stage) = self.stage() else { return };
        if self.position.showing {
            self.position.showing = false;
            self.learners.set_showing(false);
            self.learners.next_candidates();
        } else {
            self.learners.end_trajectory();
            if stage.shows {
                self.position.showing = true;
                self.learners.set_showing(true);
                self.begin_epoch();
                return;
            }
            self.learners.next_candidates();
        }
        self.position.epoch += 1;
        if stage.counts() {
            self.curve.push(self.curve_row(self.position.epoch));
            self.row_after_epoch();
        }
        if self.position.epoch < stage.epochs {
            self.begin_epoch();
        } else {
            self.position.stage += 1;
            self.position.epoch = 0;
            self.position.step = 0;
            self.begin_stage();
        }
    }

    /// The step of the present epoch up to which the run goes on without a row of metrics.
    fn next_row(&self) -> u32 {
        let RunPosition { epoch, step, .. } = self.position;
        let steps = self.spec.steps_per_epoch;
        let within = self
            .is_counting()
            .then(|| next_within(epoch, step, steps))
            .flatten();
        within.unwrap_or(steps)
    }

    /// Adds a row of metrics after a counted epoch, where one is kept.
    fn row_after_epoch(&mut self) {
        if has_row(self.position.epoch, self.spec.epochs) {
            self.add_row();
        }
    }

    /// Adds a row of metrics, and the objects of the same moment.
    fn add_row(&mut self) {
        let row = self.metrics_now();
        self.metrics.push(row);
        self.track_objects();
    }

    /// Whether visits count in the epoch that the run is in.
    fn is_counting(&self) -> bool {
        self.stage().is_some_and(|stage| stage.counts()) && self.venue() == TARGET
    }

    fn metrics_now(&self) -> MetricsRow {
        let world = &self.venues[TARGET].world;
        MetricsRow::now(world, self.reachable(), self.position.epoch)
    }

    pub(super) fn time(&self) -> Time {
        Time {
            steps: self.venues[TARGET].world.state().tally.steps(),
            epoch: self.curve.len() as u32,
        }
    }

    /// Takes the present moment into the tracks of objects.
    fn track_objects(&mut self) {
        let time = self.time();
        let objects = &self.venues[TARGET].world.state().objects;
        self.tracks.offer(time, objects, MOST_SAMPLES);
    }

    pub(super) fn curve_row(&self, epoch: u32) -> CurveRow {
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
            phase: self.stage().map_or(Phase::Done, |stage| stage.phase),
            epochs_done: self.curve.len() as u32,
            epochs_total: self.spec.epochs,
            robot_steps_done: self.position.steps * robots,
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

    /// Squares of the target arena that the robots can reach from where they start, one or another.
    pub fn reachable(&self) -> &Reachable {
        self.reachable.get_or_init(|| {
            let radius_m = self.spec.robot.parameters.body_radius_m;
            let starts = self.venues[TARGET].start_positions(&self.spec);
            kept::reachable_from(&self.spec.arena, &starts, radius_m)
        })
    }

    /// Arena steps so far, all stages together: the number of the current frame.
    pub fn step(&self) -> u64 {
        self.position.steps
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

    /// Spreads the work on over these threads, where there is enough of it; results stay the same.
    pub fn set_crew(&mut self, crew: Crew) {
        for venue in &mut self.venues {
            venue.world.set_crew(&crew);
        }
        self.crew = crew;
    }

    /// The threads that work may be spread over.
    pub fn crew(&self) -> &Crew {
        &self.crew
    }

    /// Steps with other instructions than the machine's best; results stay the same.
    pub fn set_backend(&mut self, backend: Backend) {
        for venue in &mut self.venues {
            venue.world.set_backend(backend);
        }
    }
}
