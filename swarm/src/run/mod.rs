//! A run: a spec brought to life, as a state machine stepped in blocks, saved and restored.

mod continued;
mod coverage;
mod findings;
mod learners;
mod learnt;
mod machine;
mod metrics;
mod model;
mod outcome;
mod plan;
mod position;
mod robot_memory;
mod saved_rows;
mod seen;
mod snapshot;
#[cfg(test)]
mod tests;
mod tracks;
mod venue;

pub use continued::CHANGEABLE;
pub use coverage::{CurveRow, counts_within};
pub use learnt::Learnt;
pub use machine::{Run, Witness};
pub use metrics::{MetricsLog, MetricsRow, RobotMetrics};
pub use outcome::{ObjectOutcome, Outcome, Progress, RestoreError};
pub use plan::{Decision, EpochKind, Place, StagePlan};
pub use robot_memory::RobotMemory;
pub use tracks::{Moment, ObjectSample, TrackParts, Tracks};
pub use venue::check_placement;

pub use crate::stages::Phase;
