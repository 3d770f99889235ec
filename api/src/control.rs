//! Control of jobs and runs: what is posted to `extend`, `step` and `priority`, and a run's log.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Most seeds that a job is extended by at once.
pub const MAX_MORE_SEEDS: u32 = 10_000;
/// Most epochs that a run is extended or stepped by at once.
pub const MAX_MORE_EPOCHS: u32 = 1_000_000;
/// Largest priority, and the smallest below 0.
pub const MAX_PRIORITY: i32 = 1_000;

/// `POST /v1/jobs/{id}/extend`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtendJob {
    /// Seeds more, in each combination.
    #[schemars(range(min = 1, max = MAX_MORE_SEEDS))]
    pub seeds: u32,
}

/// `POST /v1/runs/{id}/extend` and `/step`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Epochs {
    /// Epochs more.
    #[schemars(range(min = 1, max = MAX_MORE_EPOCHS))]
    pub epochs: u32,
}

/// `POST /v1/jobs/{id}/priority`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Priority {
    /// Jobs of higher priority come first; 0 unless it was changed.
    #[schemars(range(min = -MAX_PRIORITY, max = MAX_PRIORITY))]
    pub priority: i32,
}

/// What was changed of a run, and when.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RunLogEntry {
    /// RFC 3339 in UTC.
    pub at: String,
    /// Where the run stood; null while it was being stepped.
    pub robot_steps_done: Option<u64>,
    /// In words.
    pub what: String,
}

/// `GET /v1/runs/{id}/log`: oldest first; a long log loses its beginning.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RunLog {
    /// Its entries.
    pub items: Vec<RunLogEntry>,
}

/// `POST /v1/runs/{id}/fork`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fork {
    /// The counted epochs that the state must have complete; any when it is not given.
    #[schemars(range(max = MAX_MORE_EPOCHS))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epoch: Option<u32>,
    /// What is changed: dotted paths into the run spec, and values.
    #[serde(default)]
    pub changes: BTreeMap<String, Value>,
}

/// `POST /v1/runs/{id}/checkpoint`: what is kept of a run to go on from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct CheckpointInfo {
    /// Id of the run.
    pub run: String,
    /// SHA-256 of its state, in hex.
    pub checkpoint_sha256: String,
    /// Bytes of the state.
    pub bytes: u64,
    /// Counted epochs that are complete.
    pub epochs_done: u32,
}
