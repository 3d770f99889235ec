//! What a run found: `result.json`, rows of `curve.csv`, coverage as JSON.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Number;

/// Coverage after an epoch: squares entered at least 1, 2, 5 and 10 times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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

/// Squares with at least 1, 2, 5 and 10 of what is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Levels {
    /// At least one.
    pub p1: u32,
    /// At least two.
    pub p2: u32,
    /// At least five.
    pub p5: u32,
    /// At least ten.
    pub p10: u32,
}

impl From<[u32; 4]> for Levels {
    fn from([p1, p2, p5, p10]: [u32; 4]) -> Self {
        Self { p1, p2, p5, p10 }
    }
}

/// Clusters of the first robot's learner; 0 where the method has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelAccuracy {
    /// Kullback-Leibler divergence in nats, summed over the pairs of state and action that the table
    /// knows.
    pub divergence_nats: f64,
    /// Number of those pairs: compare tables by the divergence a pair.
    pub pairs: u32,
}

/// What each robot's learner may hold: caps of everything that grows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

/// Swarm metrics by name, in the order of the table in `docs/metrics.md`, which has their units and
/// formulas. Null where a metric is not defined; one that the program which ran had not is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MetricValues(pub IndexMap<String, Option<Number>>);

impl MetricValues {
    /// A metric by name, where it is there and defined.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name)?.as_ref()?.as_f64()
    }
}

/// The swarm after some counted steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MetricsRow {
    /// Counted steps of the arena that are done.
    pub steps: u64,
    /// The same in simulated seconds.
    pub time_s: f64,
    /// Counted epochs that are complete.
    pub epoch: u32,
    /// Shares of the reachable squares that were entered at least 1, 2, 5 and 10 times.
    pub fractions: Fractions,
    /// The metrics that show over time.
    #[serde(flatten)]
    pub metrics: MetricValues,
}

/// The metrics of a run over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Metrics {
    /// Version of this format.
    pub schema: u32,
    /// Squares that a robot of this size can reach from the first start pose.
    pub reachable: u32,
    /// In order of time.
    pub rows: Vec<MetricsRow>,
}

/// What became of a movable object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectResult {
    /// `box` or `disc`.
    pub kind: String,
    /// Where its centre is at the end, metres.
    pub x_m: f64,
    /// Where its centre is at the end, metres.
    pub y_m: f64,
    /// Cosine of its heading at the end.
    pub cos: f64,
    /// Sine of its heading at the end.
    pub sin: f64,
    /// Way that it was moved while visits counted, metres.
    pub moved_m: f64,
    /// How far it is at the end from where it began, metres; objects go back when an epoch begins,
    /// unless episodes continue.
    pub displaced_m: f64,
}

/// `result.json`: what a finished run has to say; nothing about time or machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Squares by the steps spent in them, where `p1` to `p10` go by entries; absent in results of
    /// versions that did not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dwell: Option<Levels>,
    /// Swarm metrics at the end; null in results of versions that had none.
    #[serde(default)]
    pub metrics: Option<MetricValues>,
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
    /// What the robots' learners held.
    pub memory: Memory,
    /// What became of the arena's movable objects, in their order; absent where it has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectResult>,
    /// SHA-256 of the final snapshot, in hex.
    pub state_sha256: String,
}

/// How many squares an arena has: one number where rows and columns are as many, else
/// `[columns, rows]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Squares {
    /// As many in a row as in a column.
    Side(u32),
    /// Columns and rows.
    Sides([u32; 2]),
}

impl From<[u32; 2]> for Squares {
    fn from(sides: [u32; 2]) -> Self {
        if sides[0] == sides[1] {
            Self::Side(sides[0])
        } else {
            Self::Sides(sides)
        }
    }
}

/// Coverage as JSON: entries counted a square.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Coverage {
    /// Version of this format.
    pub schema: u32,
    /// Name of the arena.
    pub arena: String,
    /// Metres from left to right.
    pub width_m: f64,
    /// Metres from bottom to top.
    pub height_m: f64,
    /// Columns and rows.
    pub squares: Squares,
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
