//! Phase 2: the trajectories of phase 1 happen again, now read through the final clusters into the
//! repository. Noise is a function of robot and step, so a trajectory needs no storage: its genome
//! and the arena give it back to the bit, where robots begin again as they began. Under a memory
//! budget, or on line, the genomes that were kept simply drive once more.

use serde::{Deserialize, Serialize};

use super::command_levels::CommandLevels;
use super::controller::Controller;
use super::explorer::Explorer;
use super::scaling::Scaling;
use crate::bodies::Reading;
use crate::caps::MemoryPlan;
use crate::dimensions::WHEELS;
use crate::learn::archive::Archive;
use crate::learn::perceptron::{MOST_SLOPE, Perceptron};
use crate::spec::ControllerParameters;

/// A robot in phase 2.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Replayer {
    slope: f64,
    scaling: Scaling,
    perceptron: Perceptron,
    archive: Archive,
    /// Genome of the archive that drives.
    place: u32,
    /// The phase-3 learner that is being filled.
    explorer: Explorer,
    /// Of the spec, no state: [`Replayer::set_up`] gives it back to one that was saved.
    #[serde(skip)]
    levels: CommandLevels,
}

impl Replayer {
    /// A robot about to replay an archive of genomes into an explorer's repository.
    pub fn new(p: &ControllerParameters, archive: Archive, explorer: Explorer) -> Self {
        let mut replayer = Self {
            slope: p.slope,
            scaling: Scaling::new(p.sensor_scale),
            perceptron: Perceptron::new(),
            archive,
            place: 0,
            explorer,
            levels: CommandLevels::default(),
        };
        replayer.set_up(p);
        replayer.load();
        replayer
    }

    /// Takes from the parameters what is not saved.
    pub fn set_up(&mut self, p: &ControllerParameters) {
        self.levels = CommandLevels::new(p.command_levels);
    }

    /// Whether saved parts fit together, under these caps.
    pub fn is_sound(&self, plan: &MemoryPlan) -> bool {
        self.slope.abs() <= MOST_SLOPE
            && self.perceptron.is_sound()
            && self.archive.is_sound(plan.genomes)
            && self.explorer.is_sound()
    }

    fn load(&mut self) {
        if let Some(genome) = self.archive.genome(self.place) {
            self.perceptron.load(genome, self.slope);
        }
    }

    /// Takes the parameters of later decisions from another set.
    pub fn retune(&mut self, p: &ControllerParameters) {
        self.explorer.retune(p);
    }

    /// Starts a trajectory from the sensors read at its beginning.
    pub fn begin_trajectory(&mut self, reading: &Reading) {
        self.explorer.begin_trajectory(reading);
    }

    /// Ends a trajectory and takes the next genome.
    pub fn end_trajectory(&mut self) {
        self.place += 1;
        self.load();
    }

    /// The filled learner.
    pub fn finish(self) -> Explorer {
        self.explorer
    }

    /// The learner as it stands.
    pub fn explorer(&self) -> &Explorer {
        &self.explorer
    }

    /// Most bytes held.
    pub fn bytes_for(plan: &MemoryPlan) -> u64 {
        let without_explorer = size_of::<Self>() - size_of::<Explorer>();
        without_explorer as u64 + Archive::heap_bytes_for(plan.genomes) + Explorer::bytes_for(plan)
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> u64 {
        let without_explorer = size_of::<Self>() - size_of::<Explorer>();
        without_explorer as u64 + self.archive.heap_bytes() + self.explorer.bytes()
    }
}

impl Controller for Replayer {
    #[inline(always)]
    fn act(&mut self, _step: u64, reading: &Reading) -> [f32; WHEELS] {
        let command = self.perceptron.act(&self.scaling.apply(reading));
        let command = self.levels.round(command);
        self.explorer.watch_action(command);
        command
    }

    #[inline(always)]
    fn learn(&mut self, reading: &Reading) {
        self.explorer.arrive(reading);
    }
}
