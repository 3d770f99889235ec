//! How many squares were entered how often.

use serde::{Deserialize, Serialize};

use crate::world::COVERAGE_LEVELS;

/// Coverage after an epoch: squares entered at least 1, 2, 5 and 10 times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

/// Squares of a mask entered at least 1, 2, 5 and 10 times.
pub fn counts_within(visits: &[u32], mask: &[bool]) -> [u32; 4] {
    COVERAGE_LEVELS.map(|level| {
        let entered = visits
            .iter()
            .zip(mask)
            .filter(|&(&entries, &inside)| inside && entries >= level);
        // An arena has at most 1,000 x 1,000 squares.
        entered.count() as u32
    })
}

/// Squares with at least 1, 2, 5 and 10 of what was counted.
pub fn counts_over(counted: &[u32]) -> [u32; 4] {
    // An arena has at most 1,000 x 1,000 squares.
    COVERAGE_LEVELS.map(|level| counted.iter().filter(|&&count| count >= level).count() as u32)
}
