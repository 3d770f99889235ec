//! What a robot's learner may hold, as plain data; `memory.rs` fits it to a budget.

use serde::{Deserialize, Serialize};

/// Caps of a robot's learner.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryPlan {
    /// States; beyond them a vector joins the nearest.
    pub sensor_clusters: u32,
    /// Actions.
    pub actuator_clusters: u32,
    /// Clusters that sensori-motor objectives are computed over.
    pub sensori_motor_clusters: u32,
    /// Vectors of the sample that k-means runs over.
    pub sample: u32,
    /// Commands kept for each action.
    pub actuator_sample: u32,
    /// Length of each list S(i, j).
    pub lambda: u32,
    /// Genomes of phase 1 that are kept for phase 2.
    pub genomes: u32,
    /// Most bytes that a robot holds at any moment under these caps.
    pub bytes: u64,
}

#[cfg(test)]
impl MemoryPlan {
    /// A small plan.
    pub(crate) fn small() -> Self {
        Self {
            sensor_clusters: 9,
            actuator_clusters: 9,
            sensori_motor_clusters: 9,
            sample: 20,
            actuator_sample: 4,
            lambda: 10,
            genomes: 1,
            bytes: 0,
        }
    }
}
