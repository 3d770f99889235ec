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

/// What each robot's learner may hold: caps of everything that grows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryPlan {
    /// States.
    pub sensor_clusters: u32,
    /// Actions.
    pub actuator_clusters: u32,
    /// Clusters that sensori-motor objectives are computed over.
    pub sensori_motor_clusters: u32,
    /// Vectors of the sample that k-means runs over.
    pub sample: u32,
    /// Commands kept for each action.
    pub actuator_sample: u32,
    /// Length of each list of next states.
    pub lambda: u32,
    /// Genomes of phase 1 that are kept for phase 2.
    pub genomes: u32,
    /// Most bytes that a robot holds at any moment under these caps.
    pub bytes: u64,
}

/// What the robots' learners held when the run ended.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Memory {
    /// What each could hold; without a budget what the parameters say.
    pub plan: MemoryPlan,
    /// Bytes of the robot that held the most.
    pub most_bytes: u64,
    /// Bytes of the robot that held the least.
    pub least_bytes: u64,
    /// Vectors, of all robots, that found no room for a cluster of their own.
    pub clusters_saturated: u64,
    /// Robots with such vectors.
    pub robots_saturated: u32,
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
    /// Bytes that the run holds, exactly counted.
    pub bytes: u64,
    /// What the robots' learners held.
    pub memory: Memory,
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
