//! What a run found: `result.json`, rows of `curve.csv`, coverage as JSON.

use serde::{Deserialize, Serialize};

/// Coverage after an epoch: squares entered at least 1, 2, 5 and 10 times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CurveRow {
    /// Counted epochs that are complete, from 1.
    pub epoch: u32,
    /// Squares entered at least once.
    pub p1: u32,
    /// At least twice.
    pub p2: u32,
    /// At least five times.
    pub p5: u32,
    /// At least ten times.
    pub p10: u32,
}

/// Coverage as shares of the reachable squares: only squares among them count, so no share is above
/// 1; all are 0 where no square is reachable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fractions {
    /// Squares entered at least once.
    pub p1: f64,
    /// At least twice.
    pub p2: f64,
    /// At least five times.
    pub p5: f64,
    /// At least ten times.
    pub p10: f64,
}

/// Clusters of the first robot's learner; 0 where the method has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClusterCounts {
    /// Of sensor vectors.
    pub sensor: u32,
    /// Of actuator vectors.
    pub actuator: u32,
    /// Of sensori-motor vectors, in phase 1.
    pub sensori_motor: u32,
}

/// How far the first robot's transition table is from a reference that random actions in the target
/// arena give (section 4.3.4 of the thesis).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelAccuracy {
    /// Kullback-Leibler divergence in nats, summed over the pairs of state and action that the table
    /// knows.
    pub divergence_nats: f64,
    /// Number of those pairs: compare tables by the divergence a pair.
    pub pairs: u32,
}

/// `result.json`: what a finished run has to say; nothing about time or machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Version of this format.
    pub schema: u32,
    /// Squares entered at least once.
    pub p1: u32,
    /// At least twice.
    pub p2: u32,
    /// At least five times.
    pub p5: u32,
    /// At least ten times.
    pub p10: u32,
    /// Squares that a robot of this size can reach from the first start pose.
    pub reachable: u32,
    /// The four counts inside the reachable squares, as shares of `reachable`.
    pub fractions: Fractions,
    /// Robot-steps, uncounted phases included.
    pub steps: u64,
    /// Robot-steps of the counted epochs that touched a wall or a robot.
    pub collisions: u64,
    /// Clusters of the first robot.
    pub clusters: ClusterCounts,
    /// Of the first robot's table at the end; null where the method has none.
    #[serde(default)]
    pub model: Option<ModelAccuracy>,
    /// Bytes that the run holds, exactly counted.
    pub bytes: u64,
    /// SHA-256 of the final snapshot, in hex.
    pub state_sha256: String,
}

/// Coverage as JSON: entries counted a square.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Version of this format.
    pub schema: u32,
    /// Name of the arena.
    pub arena: String,
    /// Metres from left to right.
    pub width_m: f64,
    /// Metres from bottom to top.
    pub height_m: f64,
    /// Rows, and columns.
    pub squares: u32,
    /// Squares entered at least once.
    pub p1: u32,
    /// At least twice.
    pub p2: u32,
    /// At least five times.
    pub p5: u32,
    /// At least ten times.
    pub p10: u32,
    /// Squares that a robot of this size can reach from the first start pose.
    pub reachable: u32,
    /// The four counts inside the reachable squares, as shares of `reachable`.
    pub fractions: Fractions,
    /// Entries counted, row by row; the first row is the lowest y.
    pub visits: Vec<Vec<u32>>,
}
