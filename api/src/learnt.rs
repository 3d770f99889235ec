//! What robots have learnt at a moment: `GET /v1/runs/{id}/learnt` of one, with its table, and
//! `GET /v1/runs/{id}/learning` of all.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::result::{ClusterCounts, Memory, ModelAccuracy};

/// A robot's learner at a moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Learnt {
    /// Number of the robot, from 0.
    pub robot: u32,
    /// Whether this is the present moment of a run that is being stepped; else it is that of its last
    /// checkpoint.
    pub is_live: bool,
    /// What the run is doing.
    pub phase: String,
    /// Steps of the arena since the run began, all phases.
    pub arena_step: u64,
    /// Clusters of sensor vectors so far; states, where there is a table.
    pub sensor_clusters: u32,
    /// Clusters of commands so far; actions, where there is a table.
    pub actuator_clusters: u32,
    /// Clusters of sensori-motor vectors so far, where an objective is over them.
    pub sensori_motor_clusters: Option<u32>,
    /// Fitness of the parent genome, once it was evaluated; in evolution alone.
    pub fitness: Option<f64>,
    /// Bytes that the learner holds.
    pub bytes: u64,
    /// Most bytes that it may hold at any moment.
    pub most_bytes: u64,
    /// The spec's bound on them, where it has one.
    pub budget_bytes: Option<u64>,
    /// Vectors that found no room for a cluster of their own.
    pub clusters_saturated: u64,
    /// The transition table; none before the robot has one.
    pub table: Option<LearntTable>,
}

/// A transition table. Lists of lists have a list for each state, with a value for each action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearntTable {
    /// States in all; of a large table lists hold the first alone, as many as make 250,000 values.
    pub states_total: u32,
    /// The state that the robot is in.
    pub state: u32,
    /// The action that it chose last.
    pub action: u32,
    /// Tries of an action in a state that are remembered.
    pub counts: Vec<Vec<u32>>,
    /// Q: entropy of what followed, nats.
    pub entropy: Vec<Vec<f64>>,
    /// What actions are chosen by (equation 4.9); none for an action never tried.
    pub score: Vec<Vec<Option<f64>>>,
    /// Sensor values of each state, as the learner sees them.
    pub states: Vec<Vec<f32>>,
    /// Commands of each action, left and right.
    pub actions: Vec<Vec<f32>>,
}

/// How far the robots of a run have learnt, at a moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Learning {
    /// Id of the run.
    pub run_id: String,
    /// Whether this is the present moment of a run that is being stepped; else it is that of its last
    /// checkpoint or of its end.
    pub is_live: bool,
    /// What the run is doing.
    pub phase: String,
    /// Counted epochs that are complete.
    pub epochs_done: u32,
    /// Counted epochs in all.
    pub epochs_total: u32,
    /// Steps of the arena since the run began, all phases; null where of a run that is done its
    /// result is kept and its last state is not.
    pub arena_step: Option<u64>,
    /// Robots of the run.
    pub robots: u32,
    /// The spec's bound on what a learner holds, where it has one.
    pub budget_bytes: Option<u64>,
    /// What the learners hold, and may hold at most.
    pub memory: Memory,
    /// Clusters of the first robot.
    pub clusters: ClusterCounts,
    /// Of the first robot's table, once the run is done; null where the method has none.
    pub model: Option<ModelAccuracy>,
    /// In order of their numbers; none where the run's last state is not kept.
    pub items: Vec<RobotLearning>,
    /// Cursor of the next page; null on the last.
    pub next: Option<String>,
}

/// How far a robot has learnt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RobotLearning {
    /// Its number, from 0.
    pub robot: u32,
    /// Clusters of sensor vectors so far; states, where there is a table.
    pub sensor_clusters: u32,
    /// Clusters of commands so far; actions, where there is a table.
    pub actuator_clusters: u32,
    /// Clusters of sensori-motor vectors so far, where an objective is over them.
    pub sensori_motor_clusters: Option<u32>,
    /// Fitness of the parent genome, once it was evaluated; in evolution alone.
    pub fitness: Option<f64>,
    /// Bytes that its learner holds.
    pub bytes: u64,
    /// Vectors that found no room for a cluster of their own.
    pub clusters_saturated: u64,
}
