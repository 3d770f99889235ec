//! What listeners to all jobs, a job or a run hear: server-sent events, each with a name and a JSON document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::job::{Job, RunSummary};
use crate::result::{CurveRow, MetricsRow};
use crate::state::{Progress, State};

/// An event of `/v1/events`, `/v1/jobs/{id}/events` or `/v1/runs/{id}/events`. Its tag is the event's
/// name.
///
/// Every change of state comes, in order, with an id, and so does the deletion of a job: a listener
/// that comes back with `Last-Event-ID` misses none. The others show the latest, at most twice a second, and have no id;
/// a listener that is slow misses some of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "event", content = "data", rename_all = "snake_case")]
pub enum Event {
    /// A run's state changed.
    State(StateChange),
    /// The job as it is: at first, and whenever it has changed. Of all jobs these are the newest 500
    /// and, of older ones, up to 500 that are not over.
    Job(Box<Job>),
    /// A job was deleted; heard by listeners to all. A stream of a job or a run ends when it is
    /// deleted, and cannot be opened again.
    Gone(JobGone),
    /// The run as it is: at first, whenever it begins or ends to wait for another program, and
    /// whenever older changes of state are not kept any more.
    Run(Box<RunSummary>),
    /// How far the run is.
    Progress(Progress),
    /// The newest row of the run's curve.
    Coverage(CurveRow),
    /// The newest row of the run's metrics.
    Metrics(MetricsRow),
}

/// A run's state changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StateChange {
    /// Id of the run.
    pub run_id: String,
    /// Its place in the job that is listened to; 0 where a run is, or where all are.
    pub index: u64,
    /// What it became.
    pub state: State,
}

/// A job was deleted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct JobGone {
    /// Id that it had.
    pub job_id: String,
}

impl Event {
    /// The event's name.
    pub const fn name(&self) -> &'static str {
        match self {
            Event::State(_) => "state",
            Event::Job(_) => "job",
            Event::Gone(_) => "gone",
            Event::Run(_) => "run",
            Event::Progress(_) => "progress",
            Event::Coverage(_) => "coverage",
            Event::Metrics(_) => "metrics",
        }
    }
}
