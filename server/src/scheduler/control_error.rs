//! Why something that was asked of a job or a run is not done.

use api::State as Life;

use crate::store::{CheckpointError, CreateJobError, JobKey, StoreError};

/// Why something is not done.
#[derive(Debug, thiserror::Error)]
pub enum ControlError {
    /// The run was deleted meanwhile.
    #[error("there is no run {0:?}")]
    RunGone(String),
    /// The job was deleted meanwhile.
    #[error("there is no job \"{0}\"")]
    JobGone(JobKey),
    /// It has ended, so that nothing is left to do so with.
    #[error("the {0} is {1} already")]
    Ended(&'static str, Life),
    /// It has not ended yet.
    #[error("the {0} is {1}")]
    NotEnded(&'static str, Life),
    /// It runs; it must be paused first.
    #[error("the run is running: pause it first")]
    Running,
    /// None of its jobs wants it to run.
    #[error("the run's job is {0}: resume or retry the job")]
    NotWanted(Life),
    /// The job was stored by a version that did not keep it, or was made by a command.
    #[error("the job's document was not kept")]
    NoDocument,
    /// What it would become is not valid.
    #[error("the result would not be valid")]
    Invalid(Vec<api::FieldError>),
    /// It would not fit.
    #[error(transparent)]
    NoRoom(CreateJobError),
    /// No state of it is kept to go on from.
    #[error("no state of the run is kept: it is {0}")]
    NoCheckpoint(Life),
    /// What is kept cannot be read.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl From<CreateJobError> for ControlError {
    fn from(error: CreateJobError) -> Self {
        match error {
            CreateJobError::Store(error) => Self::Store(error),
            error => Self::NoRoom(error),
        }
    }
}
