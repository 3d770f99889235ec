//! Parameters of the learners: one table, and the choices in it.

use crate::parameters::Domain::{Choice, Real, Whole};
use crate::parameters::{named_choice, parameter_table};

named_choice! {
    /// When a state's information counts as insufficient (phase 3).
    Insufficiency {
        /// While some action of the state was tried fewer than `lambda` times (Alg. 5).
        EveryAction = "every-action",
        /// While all actions of the state together were tried fewer than `lambda_total` times.
        StateTotal = "state-total",
    }
}

named_choice! {
    /// Which action is taken of several with the same highest score (phase 3).
    Ties {
        /// The first, in order of the actuator clusters, which are sorted by their left command.
        First = "first",
        /// Any of them, at random.
        Random = "random",
        /// The last action again if it is one of them, else any at random.
        Keep = "keep",
    }
}

named_choice! {
    /// Where `im` takes its clusters from.
    StatesFrom {
        /// From its own random commands in the target arena.
        Babbling = "babbling",
        /// From an evolved phase 1 in the training arena.
        Phase1 = "phase-1",
    }
}

named_choice! {
    /// Interval that a raw sensor value of 0 to 4096 is mapped to.
    SensorScale {
        /// To `[-1, 1]`.
        Signed = "signed",
        /// To `[0, 1]`.
        Unsigned = "unsigned",
    }
}

named_choice! {
    /// Interval of sensor values in which clusters measure distances.
    ClusterScale {
        /// That of `sensor_scale`.
        AsSensed = "as-sensed",
        /// `[-1, 1]`.
        Signed = "signed",
        /// `[0, 1]`.
        Unsigned = "unsigned",
    }
}

named_choice! {
    /// What the three epsilons are of a cluster.
    EpsilonIs {
        /// A vector joins a centre within epsilon.
        Radius = "radius",
        /// A vector joins a centre within half of epsilon.
        Diameter = "diameter",
    }
}

named_choice! {
    /// A named set of values that stand where a spec gives none.
    ControllerPreset {
        /// The defaults.
        Default = "default",
        /// What a search over all open settings found with every printed value kept: the defaults.
        Printed = "printed",
        /// What it found with the printed values free too.
        Free = "free",
        /// What one change at a time had found: the defaults up to version 2 of results.
        Stepwise = "stepwise",
    }
}

parameter_table! {
    /// Parameters of the learner (`controller` of a run spec).
    ControllerParameters {
        slope: f64 = 3.538, Real { min: 0.01, max: 100.0 }, "1", "Slope of the perceptron's sigmoid", "eq. 4.7, open in the thesis; docs/reproduction.md";
        initial_weight_variance: f64 = 0.1, Real { min: 0.0, max: 100.0 }, "1", "Variance of a fresh parent's weights", "section 5.2.5";
        sigma: f64 = 0.2, Real { min: 1e-6, max: 100.0 }, "1", "Initial mutation step of the (1+1)-ES", "section 5.2.5";
        sigma_factor: f64 = 1.22, Real { min: 1.0, max: 10.0 }, "1", "Factor of the one-fifth rule", "chapter 2";
        success_window: u32 = 40, Whole { min: 1, max: 10_000 }, "evaluations", "Window of the one-fifth rule", "open in the thesis";
        restart_after: u32 = 30, Whole { min: 1, max: 1_000_000 }, "evaluations", "Evaluations without improvement before a fresh parent", "section 5.2.5";
        epsilon_sensori_motor: f64 = 1.8, Real { min: 0.05, max: 20.0 }, "1", "Radius of sensori-motor clusters", "table 5.2";
        epsilon_actuator: f64 = 0.6, Real { min: 0.05, max: 20.0 }, "1", "Radius of actuator clusters", "table 5.2";
        epsilon_sensor: f64 = 1.0, Real { min: 0.05, max: 20.0 }, "1", "Radius of sensor clusters", "table 5.2";
        sensor_scale: SensorScale = SensorScale::Signed, Choice { names: SensorScale::NAMES }, "", "Interval that raw sensor values are mapped to", "open in the thesis";
        cluster_scale: ClusterScale = ClusterScale::Unsigned, Choice { names: ClusterScale::NAMES }, "", "Interval of sensor values in which clusters measure distances, whatever the perceptron sees", "open in the thesis: section 5.2.1 scales commands only";
        epsilon_is: EpsilonIs = EpsilonIs::Radius, Choice { names: EpsilonIs::NAMES }, "", "What the three epsilons are of a cluster", "table 5.2 (radius) against section 4.2.3.1 and Alg. 4 (diameter)";
        command_levels: u32 = 3, Whole { min: 0, max: 2_001 }, "levels", "Levels of a wheel's command, evenly from -1 to 1, that learners and random walks use; below 2: every tick", "open in the thesis: section 5.2.1 tells ticks, 3 levels are nine actions";
        max_clusters: u32 = 250, Whole { min: 2, max: 4_000 }, "clusters", "Cap of each clustering; at the cap a vector joins the nearest cluster", "bounded memory";
        kmeans_restarts: u32 = 5, Whole { min: 1, max: 100 }, "restarts", "Independent k-means; least distortion is kept", "section 4.3.2 (P open)";
        kmeans_iterations: u32 = 100, Whole { min: 1, max: 10_000 }, "iterations", "Most Lloyd iterations a restart", "bounded time";
        sample: u32 = 8_192, Whole { min: 16, max: 1_000_000 }, "vectors", "Uniform sample of phase 1 that k-means runs over", "bounded memory";
        actuator_sample: u32 = 1, Whole { min: 1, max: 65_535 }, "vectors", "Actuator vectors kept for each actuator cluster", "bounded memory";
        replay_genomes: u32 = 1_000_000, Whole { min: 1, max: 1_000_000 }, "genomes", "Genomes of phase 1 that are replayed into the repository: all, or the fittest", "chapter 5 (all) against chapter 4 (the best)";
        lambda: u32 = 60, Whole { min: 1, max: 1_000 }, "transitions", "Length of each list S(i, j)", "table 5.2";
        lambda_total: u32 = 500, Whole { min: 1, max: 1_000_000 }, "transitions", "Threshold of the `state-total` rule", "table 5.2";
        insufficiency: Insufficiency = Insufficiency::StateTotal, Choice { names: Insufficiency::NAMES }, "", "When a state's information is insufficient", "Alg. 5 against section 4.3.3";
        eta: f64 = 0.05, Real { min: 0.0, max: 1.0 }, "1", "Probability of a uniformly random action", "table 5.2";
        alpha: f64 = 0.7, Real { min: 0.0, max: 1.0 }, "1", "Weight of leaving the state against transition entropy", "eq. 4.9";
        ties: Ties = Ties::Keep, Choice { names: Ties::NAMES }, "", "Which action is taken of several with the same highest score", "open in the thesis";
        action_hold_steps: u32 = 2, Whole { min: 1, max: 1_000 }, "steps", "Steps that a phase-3 action is held", "docs/reproduction.md";
        states_from: StatesFrom = StatesFrom::Babbling, Choice { names: StatesFrom::NAMES }, "", "Where `im` takes its clusters from", "open in the thesis";
        babbling_epochs: u32 = 20, Whole { min: 1, max: 100_000 }, "epochs", "Epochs of random commands before `im` clusters (not counted as visits)", "docs/reproduction.md";
    }
}

impl ControllerParameters {
    /// The values of a preset (`docs/reproduction.md` says how they were found).
    pub fn preset(preset: ControllerPreset) -> Self {
        let defaults = Self::default();
        match preset {
            ControllerPreset::Default | ControllerPreset::Printed => defaults,
            ControllerPreset::Free => Self {
                slope: 1.615,
                epsilon_sensor: 1.026,
                epsilon_actuator: 0.408,
                epsilon_sensori_motor: 1.805,
                command_levels: 0,
                lambda: 120,
                insufficiency: Insufficiency::EveryAction,
                eta: 0.032,
                alpha: 0.314,
                action_hold_steps: 4,
                replay_genomes: 20,
                ..defaults
            },
            ControllerPreset::Stepwise => Self {
                slope: 2.0,
                success_window: 10,
                cluster_scale: ClusterScale::AsSensed,
                epsilon_sensor: 1.5,
                command_levels: 0,
                actuator_sample: 64,
                insufficiency: Insufficiency::EveryAction,
                ties: Ties::First,
                action_hold_steps: 1,
                babbling_epochs: 5,
                ..defaults
            },
        }
    }

    /// The scale in which clusters see sensor values.
    pub fn clusters_see(&self) -> SensorScale {
        match self.cluster_scale {
            ClusterScale::AsSensed => self.sensor_scale,
            ClusterScale::Signed => SensorScale::Signed,
            ClusterScale::Unsigned => SensorScale::Unsigned,
        }
    }

    /// Distance from a centre within which a vector joins it, for one of the epsilons.
    pub fn cluster_radius(&self, epsilon: f64) -> f64 {
        match self.epsilon_is {
            EpsilonIs::Radius => epsilon,
            EpsilonIs::Diameter => 0.5 * epsilon,
        }
    }
}
