//! Control of jobs and runs: what is posted to `extend`, `step` and `priority`, and a run's log.

use serde::{Deserialize, Serialize};

/// `POST /v1/jobs/{id}/extend`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExtendJob {
    /// Seeds more, in each combination.
    pub seeds: u32,
}

/// `POST /v1/runs/{id}/extend` and `/step`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Epochs {
    /// Epochs more.
    pub epochs: u32,
}

/// `POST /v1/jobs/{id}/priority`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Priority {
    /// Jobs of higher priority come first; 0 unless it was changed.
    pub priority: i32,
}

/// What was changed of a run, and when.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunLogEntry {
    /// RFC 3339 in UTC.
    pub at: String,
    /// Where the run stood; null while it was being stepped.
    pub robot_steps_done: Option<u64>,
    /// In words.
    pub what: String,
}

/// `GET /v1/runs/{id}/log`: oldest first; a long log loses its beginning.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunLog {
    /// Its entries.
    pub items: Vec<RunLogEntry>,
}
