//! When a run takes rows of metrics, and all that it tells of them. The metrics themselves stand in
//! `metrics/`, their formulas in `docs/metrics.md` too.

use arenas::Reachable;
use serde::{Deserialize, Serialize};

use super::robot_memory::RobotMemory;
use crate::metrics::{Counted, RowValues, Value};
use crate::world::World;

/// Epochs in which there are rows within the epoch too, and rows an epoch then.
const EARLY_EPOCHS: u32 = 4;
const ROWS_AN_EPOCH: u32 = 10;
/// Epochs up to which each has a row; after them at most as many rows a doubling of time.
const EVERY_EPOCH_UP_TO: u32 = 64;

/// The swarm after some counted steps. Squares are those within reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "SavedRow", into = "SavedRow")]
pub struct MetricsRow {
    /// Counted steps of the arena that are done.
    pub steps: u64,
    /// Counted epochs that are complete.
    pub epoch: u32,
    /// Squares within reach that were entered at least 1, 2, 5 and 10 times.
    pub entered: [u32; 4],
    /// What the table of metrics shows over time.
    pub values: RowValues,
}

impl MetricsRow {
    /// The row of a world at this moment.
    pub(super) fn now(world: &World, reachable: &Reachable, epoch: u32) -> Self {
        let counted = Counted::new(world, reachable);
        Self {
            steps: counted.tally().steps(),
            epoch,
            entered: counted.entered,
            values: RowValues::of(&counted),
        }
    }
}

/// A row as the state of a run has it: the metrics of its first version, whose bytes no later one
/// changes.
#[derive(Serialize, Deserialize)]
struct SavedRow {
    steps: u64,
    epoch: u32,
    entered: [u32; 4],
    entropy: f64,
    overlap: Option<f64>,
    contribution_max: f64,
    collisions: u64,
    distance_m: f64,
}

/// The metrics of a [`SavedRow`].
pub(super) const IN_STATE: [&str; 5] = [
    "entropy",
    "overlap",
    "contribution_max",
    "collisions",
    "distance_m",
];

impl From<MetricsRow> for SavedRow {
    fn from(row: MetricsRow) -> Self {
        let [entropy, overlap, contribution_max, collisions, distance_m] =
            IN_STATE.map(|name| row.values.get(name));
        let real = |value| match value {
            Some(Value::Real(value)) => Some(value),
            Some(Value::Count(_)) | None => None,
        };
        Self {
            steps: row.steps,
            epoch: row.epoch,
            entered: row.entered,
            entropy: real(entropy).unwrap_or_default(),
            overlap: real(overlap),
            contribution_max: real(contribution_max).unwrap_or_default(),
            collisions: match collisions {
                Some(Value::Count(count)) => count,
                Some(Value::Real(_)) | None => 0,
            },
            distance_m: real(distance_m).unwrap_or_default(),
        }
    }
}

impl From<SavedRow> for MetricsRow {
    fn from(row: SavedRow) -> Self {
        Self {
            steps: row.steps,
            epoch: row.epoch,
            entered: row.entered,
            values: RowValues::from_names(|name| row.get(name)),
        }
    }
}

impl SavedRow {
    fn get(&self, name: &str) -> Option<Value> {
        match name {
            "entropy" => Some(Value::Real(self.entropy)),
            "overlap" => self.overlap.map(Value::Real),
            "contribution_max" => Some(Value::Real(self.contribution_max)),
            "collisions" => Some(Value::Count(self.collisions)),
            "distance_m" => Some(Value::Real(self.distance_m)),
            _ => None,
        }
    }
}

/// What one robot did while visits counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotMetrics {
    /// Squares that it was the first to enter.
    pub first_entries: u32,
    /// Way driven, metres.
    pub distance_m: f64,
    /// What its learner holds.
    pub memory: RobotMemory,
}

/// All that there is to know of a run's metrics at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MetricsLog {
    /// Squares within reach.
    pub reachable: u32,
    /// Rows so far: tenths of the first epochs, then epochs, ever fewer a doubling.
    pub rows: Vec<MetricsRow>,
    /// What each robot did; index is the robot's number.
    pub robots: Vec<RobotMetrics>,
    /// For each square within reach 1 + the counted steps after which it was first entered, 0 for
    /// never and for squares out of reach; row 0 is the lowest y. Empty before visits count.
    pub first_entry: Vec<u64>,
}

/// The step of an early epoch, after `step`, that the next row within it follows.
pub(super) fn next_within(epoch: u32, step: u32, steps_per_epoch: u32) -> Option<u32> {
    if epoch >= EARLY_EPOCHS {
        return None;
    }
    let steps = u64::from(steps_per_epoch);
    (1..u64::from(ROWS_AN_EPOCH))
        .map(|part| (part * steps / u64::from(ROWS_AN_EPOCH)) as u32)
        .find(|&due| due > step)
        .filter(|&due| due < steps_per_epoch)
}

/// Whether there is a row after so many of all counted epochs.
pub(super) fn has_row(epoch: u32, epochs: u32) -> bool {
    let spacing = epoch.div_ceil(EVERY_EPOCH_UP_TO).next_power_of_two();
    epoch == epochs || epoch.is_multiple_of(spacing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_in_tenths_then_epochs_then_fewer() {
        let mut dues = vec![0];
        while let Some(due) = next_within(3, *dues.last().unwrap_or(&0), 2_000) {
            dues.push(due);
        }
        assert_eq!(
            dues[1..],
            [200, 400, 600, 800, 1000, 1200, 1400, 1600, 1800]
        );
        assert_eq!(next_within(0, 0, 3), Some(1));
        assert_eq!(next_within(0, 2, 3), None);
        assert_eq!(
            (next_within(0, 0, 1), next_within(4, 0, 2_000)),
            (None, None)
        );
        let rows = |from: u32, to: u32| (from..=to).filter(|&e| has_row(e, 1_000_000)).count();
        assert_eq!((rows(1, 64), rows(65, 128), rows(129, 256)), (64, 32, 32));
        assert!(has_row(77, 77) && !has_row(77, 78));
        assert!(rows(1, 1_000_000) < 600);
    }
}
