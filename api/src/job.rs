//! Jobs and runs as the service shows them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::result::RunResult;
use crate::state::{Progress, State, WaitsFor};

/// How many runs of a job are in each state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RunCounts {
    /// All of them.
    pub total: u64,
    /// Waiting.
    pub queued: u64,
    /// Being stepped.
    pub running: u64,
    /// Stopped on request, can go on.
    #[serde(default)]
    pub paused: u64,
    /// Finished.
    pub done: u64,
    /// Ended by an error.
    pub failed: u64,
    /// Stopped for good.
    pub cancelled: u64,
}

/// A job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Job {
    /// Id, as in `/v1/jobs/{id}`.
    pub id: String,
    /// Text given by who posted it; empty when none was.
    pub name: String,
    /// Where it is in its life.
    pub state: State,
    /// Jobs of higher priority come first.
    #[serde(default)]
    pub priority: i32,
    /// When it was accepted, RFC 3339 in UTC.
    pub created_at: String,
    /// Its runs by state.
    pub runs: RunCounts,
    /// Share of the work done, 0 to 1, over all runs.
    pub progress: f64,
    /// Seconds left at the present pace; null until it is known.
    pub eta_s: Option<f64>,
    /// Robot-steps a second of its running runs together; null when none runs.
    #[serde(default)]
    pub robot_steps_per_s: Option<f64>,
}

/// A run in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunSummary {
    /// Id, as in `/v1/runs/{id}`: SHA-256 of spec, arenas and code version, in hex.
    pub id: String,
    /// Id of the job that it belongs to.
    pub job_id: String,
    /// Place in the job, from 0.
    pub index: u64,
    /// Seed.
    pub seed: u64,
    /// Name of the target arena.
    pub arena: String,
    /// Name of the method.
    pub method: String,
    /// What of the job's matrix it has, such as `alpha 0.5`: runs with the same differ in their seed
    /// alone. Empty when nothing varies.
    #[serde(default)]
    pub label: String,
    /// Version of the simulation that it was or will be made by; one that is not finished when the
    /// server is replaced by one of another version starts again.
    #[serde(default)]
    pub results_version: u32,
    /// Where it is in its life.
    pub state: State,
    /// Whom it waits for, for 0.3 s or longer, while a worker holds it; null otherwise.
    #[serde(default)]
    pub waits_for: Option<WaitsFor>,
    /// Seconds that it has waited; null where it does not wait.
    #[serde(default)]
    pub waited_s: Option<f64>,
    /// How far it is; null before it starts.
    pub progress: Option<Progress>,
    /// What it found; null until it is done.
    pub result: Option<RunResult>,
    /// Processor time a robot-step, nanoseconds, of the last time that a worker held it: tells of
    /// the machine, not of what it found. Null until it is done.
    #[serde(default)]
    pub cpu_ns_per_robot_step: Option<f64>,
    /// Why it failed, or what it waits for where it paused by itself; null otherwise.
    pub error: Option<String>,
    /// The state of another run that it goes on from; null where it starts at its beginning. Its id
    /// is then made of its spec and of the digest of that state.
    #[serde(default)]
    pub origin: Option<RunOrigin>,
}

/// A state that a run goes on from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RunOrigin {
    /// Id of the run that the state is of.
    pub run: String,
    /// SHA-256 of the state, in hex.
    pub checkpoint_sha256: String,
    /// Counted epochs that were complete.
    pub epochs_done: u32,
    /// Robot-steps that were done.
    pub robot_steps_done: u64,
    /// Whether the state was uploaded, so that this server has not made it.
    pub uploaded: bool,
}

/// A page of jobs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JobPage {
    /// Newest first.
    pub items: Vec<Job>,
    /// Cursor of the next page; null on the last.
    pub next: Option<String>,
}

/// A page of a job's runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunPage {
    /// In order of `index`.
    pub items: Vec<RunSummary>,
    /// Cursor of the next page; null on the last.
    pub next: Option<String>,
}
