//! What a robot's learner holds at a moment.

use serde::{Deserialize, Serialize};

/// What one robot's learner holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotMemory {
    /// Bytes, exactly counted; with a table in common, what a copy of it takes.
    pub bytes: u64,
    /// Vectors that found no room for a cluster of their own and joined the nearest.
    pub clusters_saturated: u64,
}
