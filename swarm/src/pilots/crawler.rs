//! Phase 1: a perceptron drives while its sensori-motor data are clustered.

use serde::{Deserialize, Serialize};

use super::{Scaling, sensori_motor};
use crate::lanes::F8;
use crate::learn::epsilon_clustering::EpsilonClustering;
use crate::learn::evolution::Evolution;
use crate::learn::objective::{curiosity, discovery};
use crate::learn::perceptron::Perceptron;
use crate::learn::reservoir::Reservoir;
use crate::pilot::Pilot;
use crate::random::Stream;
use crate::spec::{ControllerParameters, Objective};

/// What phase 1 keeps for phase 2.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Watch {
    /// Clusters of sensor vectors; their number becomes that of the states.
    pub sensors: EpsilonClustering<8>,
    /// Clusters of commands; their number becomes that of the actions.
    pub actuators: EpsilonClustering<2>,
    /// A uniform sample of the sensori-motor vectors.
    pub sample: Reservoir<10>,
}

impl Watch {
    /// Nothing seen yet.
    pub fn new(p: &ControllerParameters, sampling: Stream) -> Self {
        Self {
            sensors: EpsilonClustering::new(p.epsilon_sensor, p.max_clusters),
            actuators: EpsilonClustering::new(p.epsilon_actuator, p.max_clusters),
            sample: Reservoir::new(p.sample, sampling),
        }
    }

    /// Takes in a sensor vector and the command given in answer to it.
    #[inline(always)]
    pub fn observe(&mut self, sensors: &[f32; 8], command: [f32; 2]) {
        self.sensors.observe(sensors);
        self.actuators.observe(&command);
        self.sample.offer(&sensori_motor(sensors, command));
    }

    /// Bytes held by its parts.
    pub fn bytes(&self) -> usize {
        self.sensors.bytes() + self.actuators.bytes() + self.sample.bytes()
    }
}

/// A robot in phase 1, or of an evolved baseline.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Crawler {
    objective: Objective,
    slope: f64,
    scaling: Scaling,
    perceptron: Perceptron,
    evolution: Evolution,
    /// Clusters that sensori-motor objectives are computed over.
    sensori_motor: EpsilonClustering<10>,
    /// Clusters that actuator objectives are computed over, where `watch` has none.
    actuators: EpsilonClustering<2>,
    /// Present where a phase 2 follows.
    watch: Option<Watch>,
    /// Every genome evaluated, in order, where a phase 2 follows.
    archive: Vec<f32>,
    /// Whether this epoch is only a demonstration, from which nothing is learnt.
    showing: bool,
}

impl Crawler {
    /// A robot that has not moved yet.
    pub fn new(
        objective: Objective,
        p: &ControllerParameters,
        evolution: Stream,
        watch: Option<Watch>,
    ) -> Self {
        let mut crawler = Self {
            objective,
            slope: p.slope,
            scaling: Scaling::new(p.sensor_scale),
            perceptron: Perceptron::new(),
            evolution: Evolution::new(p, evolution),
            sensori_motor: EpsilonClustering::new(p.epsilon_sensori_motor, p.max_clusters),
            actuators: EpsilonClustering::new(p.epsilon_actuator, p.max_clusters),
            watch,
            archive: Vec::new(),
            showing: false,
        };
        crawler.load_candidate();
        crawler
    }

    fn load_candidate(&mut self) {
        self.perceptron.load(self.evolution.candidate(), self.slope);
    }

    /// Whether the next epoch only shows the current candidate.
    pub fn set_showing(&mut self, showing: bool) {
        self.showing = showing;
    }

    /// Ends a trajectory: computes the candidate's fitness and notes its genome.
    pub fn end_trajectory(&mut self) {
        let fitness = self.fitness();
        if let Some(watch) = &mut self.watch {
            watch.sensors.end_trajectory();
            watch.actuators.end_trajectory();
            self.archive.extend_from_slice(self.evolution.candidate());
        }
        self.sensori_motor.end_trajectory();
        self.actuators.end_trajectory();
        self.evolution.tell(fitness);
    }

    /// Loads the next candidate: after [`Crawler::end_trajectory`] and a showing, if any.
    pub fn next_candidate(&mut self) {
        self.load_candidate();
    }

    fn fitness(&self) -> f64 {
        let sm = &self.sensori_motor;
        let a = self
            .watch
            .as_ref()
            .map_or(&self.actuators, |watch| &watch.actuators);
        match self.objective {
            Objective::Curiosity => curiosity(sm.trajectory_counts()),
            Objective::Discovery => discovery(sm.trajectory_counts(), sm.archive_counts()),
            Objective::CuriosityA => curiosity(a.trajectory_counts()),
            Objective::DiscoveryA => discovery(a.trajectory_counts(), a.archive_counts()),
        }
    }

    /// Clusters of sensori-motor data.
    pub fn sensori_motor_clusters(&self) -> u32 {
        self.sensori_motor.len()
    }

    /// Clusters of commands.
    pub fn actuator_clusters(&self) -> u32 {
        self.watch
            .as_ref()
            .map_or(self.actuators.len(), |watch| watch.actuators.len())
    }

    /// What phase 2 needs: the watch and the archive of genomes.
    pub fn finish(self) -> (Option<Watch>, Vec<f32>) {
        (self.watch, self.archive)
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.sensori_motor.bytes()
            + self.actuators.bytes()
            + self.watch.as_ref().map_or(0, Watch::bytes)
            + size_of_val(&self.archive[..])
    }
}

impl Pilot for Crawler {
    #[inline(always)]
    fn act(&mut self, _step: u64, raw: &F8) -> [f32; 2] {
        let sensors = self.scaling.apply(raw);
        let command = self.perceptron.act(&sensors);
        if !self.showing {
            if self.objective.over_sensori_motor() {
                self.sensori_motor
                    .observe(&sensori_motor(&sensors, command));
            }
            match &mut self.watch {
                Some(watch) => watch.observe(&sensors, command),
                None if !self.objective.over_sensori_motor() => {
                    self.actuators.observe(&command);
                }
                None => {}
            }
        }
        command
    }

    #[inline(always)]
    fn learn(&mut self, _raw: &F8) {}
}
