//! Why a run did what it did: `GET /v1/runs/{id}/explain`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A way of staying where one is, over all counted steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Behaviour {
    /// `resting`, `wedged`, `spinning`, `standing`, `wall dancing` or `circling`.
    pub name: String,
    /// Share of the counted robot-steps.
    pub share: f64,
    /// Counted epochs in which a robot did so.
    pub epochs: u64,
}

/// A state or an action, and in how many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Tried {
    /// Its number.
    pub number: u32,
    /// Steps.
    pub steps: u64,
}

/// What an action was worth in a state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ActionScore {
    /// The action.
    pub action: u32,
    /// Its score; the highest is chosen.
    pub score: f64,
    /// How often its outcomes are remembered.
    pub tries: u32,
}

/// A stretch in which a robot stayed within a small place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StayedFor {
    /// The robot.
    pub robot: u32,
    /// What it did there.
    pub behaviour: String,
    /// Where.
    pub x_m: f64,
    /// Where.
    pub y_m: f64,
    /// First step, counted over all phases.
    pub from_step: u64,
    /// Its epoch, counted from 0 over all phases.
    pub epoch: u64,
    /// The same, counted from 1 over the epochs in which visits count.
    pub counted_epoch: u64,
    /// The step within it.
    pub epoch_step: u32,
    /// How many steps.
    pub steps: u64,
    /// Way driven, metres.
    pub driven_m: f64,
    /// Turns, in either direction.
    pub turns: f64,
    /// States it was in, the most frequent first.
    pub states: Vec<Tried>,
    /// Actions it chose, the most frequent first.
    pub actions: Vec<Tried>,
    /// How often the action was another than the one before.
    pub action_changes: u64,
    /// The state that scores are of.
    pub scored_state: Option<u32>,
    /// What its actions were worth, in the middle of the stretch; empty where the method has none.
    pub scores: Vec<ActionScore>,
}

/// `GET /v1/runs/{id}/explain`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Explanation {
    /// In words.
    pub sentence: String,
    /// Whether robots stayed where they were for a quarter of the counted steps or more.
    pub is_odd: bool,
    /// How they stayed, and for how long.
    pub behaviours: Vec<Behaviour>,
    /// The longest stretches within 1 mm.
    pub standing: Vec<StayedFor>,
    /// The longest stretches within 5 cm in which the robot moved.
    pub confined: Vec<StayedFor>,
    /// Counted epochs.
    pub epochs: u64,
    /// Robots that were watched, the first so many.
    pub robots_watched: u64,
    /// Robots of the run.
    pub robots: u32,
    /// Robot-steps that were simulated to find this.
    pub simulated_robot_steps: u64,
}

/// While an explanation is being found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExplanationPending {
    /// Robot-steps that are simulated for it.
    pub robot_steps: u64,
    /// Share of them that is done; 0 while it waits.
    pub progress: f64,
}
