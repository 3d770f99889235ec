//! Why something that was found cannot be shown.

use api::State;

use crate::store::{CheckpointError, JobKey, StoreError};
use crate::summary::comparison::ComparisonError;
use crate::summary::curves::MOST_RUNS;
use crate::turns::Busy;

/// Why there is nothing to show.
#[derive(Debug, thiserror::Error)]
pub enum FindingsError {
    /// What the run covered went with it.
    #[error("the run is {0}; what it covered is not kept")]
    NotKept(State),
    /// Only the newest last states are kept.
    #[error("the run is done; its last state is not kept any more")]
    StateNotKept,
    /// It was deleted meanwhile.
    #[error("there is no run \"{0}\"")]
    RunGone(String),
    /// The job is not one that the report is about.
    #[error(
        "job {0} has no report: its runs are not those of the template chapter-5, with epochs, \
         steps, arenas and seeds from 1 on of your choice, nothing else changed and none deleted"
    )]
    NoReport(JobKey),
    /// The report needs all runs.
    #[error("{done} of {total} runs are done; the report is made of all of them")]
    Unfinished {
        /// Runs that are done.
        done: u64,
        /// Runs in all.
        total: u64,
    },
    /// It cannot be compared as was asked.
    #[error(transparent)]
    Comparison(#[from] ComparisonError),
    /// Curves are pooled of fewer.
    #[error("the job has {0} finished runs; curves are pooled of at most {MOST_RUNS}")]
    TooManyRuns(usize),
    /// It is much work, and others wait for that already.
    #[error(transparent)]
    Busy(#[from] Busy),
    /// Somebody else who asks the same has it made, for long already.
    #[error("it is being made for another request, which takes long")]
    BeingMade,
    /// Nobody waits for it any more.
    #[error("the client is gone")]
    GivenUp,
    /// What is stored does not fit together.
    #[error("stored data of {what} cannot be used: {why}")]
    Broken {
        /// The job or run.
        what: String,
        /// What is wrong with it.
        why: String,
    },
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A checkpoint cannot be read.
    #[error("the run's checkpoint cannot be read: {0}")]
    Checkpoint(#[from] CheckpointError),
}

impl FindingsError {
    /// Stored data of a job or run that cannot be used.
    pub fn broken(what: impl ToString, why: impl ToString) -> Self {
        Self::Broken {
            what: what.to_string(),
            why: why.to_string(),
        }
    }
}
