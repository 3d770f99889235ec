//! `GET /v1/workers`: the threads that step runs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Progress;

/// The threads that step runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Workers {
    /// How many there are.
    pub threads: u64,
    /// Runs that wait for one of them.
    pub queued: u64,
    /// Those that have a run; the others wait for one.
    pub items: Vec<Worker>,
}

/// A thread that has a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Worker {
    /// Id of the run; null where it was deleted this moment.
    pub run: Option<String>,
    /// Id of the first job that has the run.
    pub job_id: Option<String>,
    /// Seconds since it took the run.
    pub seconds: f64,
    /// How far the run is; null while it is set up.
    pub progress: Option<Progress>,
}
