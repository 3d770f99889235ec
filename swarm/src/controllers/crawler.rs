//! Phase 1: a perceptron drives while its sensori-motor data are clustered.

use serde::{Deserialize, Serialize};

use super::command_levels::CommandLevels;
use super::controller::Controller;
use super::scaling::{Scaling, sensori_motor};
use super::watch::Watch;
use crate::bodies::Reading;
use crate::caps::MemoryPlan;
use crate::dimensions::{SENSORI_MOTOR, WHEELS};
use crate::learn::archive::Archive;
use crate::learn::are_sound;
use crate::learn::epsilon_clustering::EpsilonClustering;
use crate::learn::evolution::Evolution;
use crate::learn::objective::{curiosity, discovery};
use crate::learn::perceptron::{MOST_SLOPE, Perceptron, WEIGHTS};
use crate::random::Stream;
use crate::spec::{ControllerParameters, Objective, SensorScale};

/// A robot in phase 1, or of an evolved baseline.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Crawler {
    objective: Objective,
    slope: f64,
    scaling: Scaling,
    perceptron: Perceptron,
    evolution: Evolution,
    /// Clusters that sensori-motor objectives are computed over.
    sensori_motor: EpsilonClustering<SENSORI_MOTOR>,
    /// Clusters that actuator objectives are computed over, where `watch` has none.
    actuators: EpsilonClustering<WHEELS>,
    /// Present where a phase 2 follows.
    watch: Option<Watch>,
    /// Genomes evaluated, where a phase 2 follows.
    archive: Option<Archive>,
    /// The fittest genome that other robots told in this trajectory; empty where none can.
    heard: Vec<f32>,
    /// Its fitness, minus infinity while there is none.
    heard_fitness: f64,
    /// Whether this epoch is only a demonstration, from which nothing is learnt.
    showing: bool,
    /// Of the spec, no state: [`Crawler::set_up`] gives it back to one that was saved.
    #[serde(skip)]
    settings: Settings,
}

/// What a crawler does with sensor values and commands; small, as it stands where padding was.
#[derive(Clone, Copy, Debug, Default)]
struct Settings {
    /// The interval in which clusters see sensor values, where it is not the perceptron's.
    clusters_see: Option<SensorScale>,
    levels: CommandLevels,
}

impl Crawler {
    /// A robot that has not moved yet. With a `watch` a phase 2 follows; `hears` other robots'
    /// genomes where they share them.
    pub fn new(
        objective: Objective,
        p: &ControllerParameters,
        plan: &MemoryPlan,
        evolution: Stream,
        watch: Option<Watch>,
        hears: bool,
    ) -> Self {
        let (sensori_motor, actuators) = Self::caps(objective, plan, watch.is_some());
        let mut crawler = Self {
            objective,
            slope: p.slope,
            scaling: Scaling::new(p.sensor_scale),
            perceptron: Perceptron::new(),
            evolution: Evolution::new(p, evolution),
            sensori_motor: EpsilonClustering::new(
                p.cluster_radius(p.epsilon_sensori_motor),
                sensori_motor,
            ),
            actuators: EpsilonClustering::new(p.cluster_radius(p.epsilon_actuator), actuators),
            archive: watch.is_some().then(|| Archive::new(plan.genomes)),
            watch,
            heard: if hears {
                vec![0.0; WEIGHTS]
            } else {
                Vec::new()
            },
            heard_fitness: f64::NEG_INFINITY,
            showing: false,
            settings: Settings::default(),
        };
        crawler.set_up(p);
        crawler.load_candidate();
        crawler
    }

    /// Caps of the sensori-motor and actuator clusters, one where they are never used.
    fn caps(objective: Objective, plan: &MemoryPlan, watching: bool) -> (u32, u32) {
        let over_sensori_motor = objective.over_sensori_motor();
        let own_actuators = !over_sensori_motor && !watching;
        (
            if over_sensori_motor {
                plan.sensori_motor_clusters
            } else {
                1
            },
            if own_actuators {
                plan.actuator_clusters
            } else {
                1
            },
        )
    }

    /// Whether other robots' genomes can be told to it.
    pub fn hears(&self) -> bool {
        !self.heard.is_empty()
    }

    /// Whether saved parts fit together, under these caps.
    pub fn is_sound(&self, plan: &MemoryPlan) -> bool {
        let (sensori_motor, actuators) = Self::caps(self.objective, plan, self.watches());
        let archive = self.archive.as_ref();
        self.slope.abs() <= MOST_SLOPE
            && self.perceptron.is_sound()
            && self.evolution.is_sound()
            && self.sensori_motor.is_sound(sensori_motor)
            && self.actuators.is_sound(actuators)
            && archive.is_some() == self.watches()
            && archive.is_none_or(|archive| archive.is_sound(plan.genomes))
            && self.watch.as_ref().is_none_or(|watch| watch.is_sound(plan))
            && [0, WEIGHTS].contains(&self.heard.len())
            && are_sound(&self.heard)
    }

    /// Takes from the parameters what is not saved.
    pub fn set_up(&mut self, p: &ControllerParameters) {
        self.settings = Settings {
            clusters_see: Some(p.clusters_see()).filter(|scale| *scale != p.sensor_scale),
            levels: CommandLevels::new(p.command_levels),
        };
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
        }
        if let Some(archive) = &mut self.archive {
            archive.offer(self.evolution.candidate(), fitness);
        }
        self.sensori_motor.end_trajectory();
        self.actuators.end_trajectory();
        self.evolution.tell(fitness);
        if self.heard_fitness > f64::NEG_INFINITY {
            self.evolution.adopt(&self.heard, self.heard_fitness);
            self.heard_fitness = f64::NEG_INFINITY;
        }
    }

    /// What it tells other robots: its parent's genome and fitness, once it was evaluated.
    pub fn tells(&self) -> Option<(&[f32], f64)> {
        self.evolution.parent()
    }

    /// Takes in another robot's genome; the fittest of a trajectory is kept.
    pub fn hear(&mut self, genome: &[f32], fitness: f64) {
        if fitness > self.heard_fitness && !self.showing {
            self.heard.copy_from_slice(genome);
            self.heard_fitness = fitness;
        }
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

    /// Clusters of sensor vectors, where a phase 2 follows.
    pub fn sensor_clusters(&self) -> u32 {
        self.watch.as_ref().map_or(0, |watch| watch.sensors.len())
    }

    /// Clusters of commands.
    pub fn actuator_clusters(&self) -> u32 {
        self.watch
            .as_ref()
            .map_or(self.actuators.len(), |watch| watch.actuators.len())
    }

    /// Vectors that found no room for a cluster of their own.
    pub fn clusters_saturated(&self) -> u64 {
        self.sensori_motor.saturated()
            + self.actuators.saturated()
            + self.watch.as_ref().map_or(0, Watch::saturated)
    }

    /// Whether it keeps what a phase 2 needs.
    pub fn watches(&self) -> bool {
        self.watch.is_some() && self.archive.is_some()
    }

    /// What phase 2 needs, where one follows: the watch and the archive of genomes.
    pub fn finish(self) -> Option<(Watch, Archive)> {
        self.watch.zip(self.archive)
    }

    /// Most bytes held.
    pub fn bytes_for(objective: Objective, plan: &MemoryPlan, watching: bool, hears: bool) -> u64 {
        let (sensori_motor, actuators) = Self::caps(objective, plan, watching);
        let watched = Watch::heap_bytes_for(plan) + Archive::heap_bytes_for(plan.genomes);
        size_of::<Self>() as u64
            + Evolution::HEAP_BYTES
            + EpsilonClustering::<SENSORI_MOTOR>::heap_bytes_for(sensori_motor)
            + EpsilonClustering::<WHEELS>::heap_bytes_for(actuators)
            + if watching { watched } else { 0 }
            + if hears {
                (WEIGHTS * size_of::<f32>()) as u64
            } else {
                0
            }
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> u64 {
        size_of::<Self>() as u64
            + Evolution::HEAP_BYTES
            + self.sensori_motor.heap_bytes()
            + self.actuators.heap_bytes()
            + self.watch.as_ref().map_or(0, Watch::heap_bytes)
            + self.archive.as_ref().map_or(0, Archive::heap_bytes)
            + size_of_val(&self.heard[..]) as u64
    }
}

impl Controller for Crawler {
    #[inline(always)]
    fn act(&mut self, _step: u64, reading: &Reading) -> [f32; WHEELS] {
        let sensors = self.scaling.apply(reading);
        let command = self.settings.levels.round(self.perceptron.act(&sensors));
        if !self.showing {
            let sensors = match self.settings.clusters_see {
                None => sensors,
                Some(scale) => Scaling::new(scale).apply(reading),
            };
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
    fn learn(&mut self, _reading: &Reading) {}
}
