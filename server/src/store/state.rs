//! Life cycle of runs and intent of jobs, as the database holds them.

use api::{RunCounts, RunResult, State};

use super::StoreError;

/// What its owner wants of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Intent {
    /// Run it.
    Active,
    /// Hold it, to go on later.
    Paused,
    /// Never run what is left of it.
    Cancelled,
}

impl Intent {
    /// The name in the database.
    pub const fn name(self) -> &'static str {
        match self {
            Intent::Active => "active",
            Intent::Paused => "paused",
            Intent::Cancelled => "cancelled",
        }
    }

    /// The intent of this name.
    ///
    /// # Errors
    /// `Unreadable` when there is none.
    pub fn from_name(name: &str) -> Result<Self, StoreError> {
        [Intent::Active, Intent::Paused, Intent::Cancelled]
            .into_iter()
            .find(|intent| intent.name() == name)
            .ok_or_else(|| StoreError::unreadable("intent", name))
    }

    /// The state of a job with this intent and these runs.
    pub fn job_state(self, runs: &RunCounts) -> State {
        let ended = runs.done + runs.failed + runs.cancelled;
        match self {
            Intent::Cancelled => State::Cancelled,
            _ if ended == runs.total && runs.failed > 0 => State::Failed,
            _ if ended == runs.total && runs.cancelled > 0 => State::Cancelled,
            _ if ended == runs.total => State::Done,
            Intent::Paused => State::Paused,
            // What is left of it is held, run by run.
            Intent::Active if runs.paused > 0 && runs.paused + ended == runs.total => State::Paused,
            Intent::Active if runs.running > 0 || ended > 0 => State::Running,
            Intent::Active => State::Queued,
        }
    }
}

/// How far a run was when it last stopped, ended or was stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Position {
    /// Phase by its name.
    pub phase: String,
    /// Counted epochs that are complete.
    pub epochs_done: u32,
    /// Robot-steps done.
    pub robot_steps_done: u64,
}

/// Where a run is in its life, with what only that state has.
#[derive(Clone, Debug, PartialEq)]
pub enum RunState {
    /// Waits for a worker; `Some` when it was stopped on the way.
    Queued(Option<Position>),
    /// Held by a worker.
    Running,
    /// Stopped on request; `Some` when it had started.
    Paused(Option<Position>),
    /// Finished, with its result.
    Done(Box<RunResult>),
    /// Ended by an error.
    Failed {
        /// What went wrong.
        reason: String,
    },
    /// Stopped on request for good.
    Cancelled,
    /// What is stored of it cannot be read.
    Damaged {
        /// Why not.
        reason: String,
    },
}

impl RunState {
    /// The state from its columns.
    ///
    /// # Errors
    /// `Unreadable` when the name is unknown or a column that the state needs is null.
    pub fn from_columns(
        name: &str,
        position: Option<Position>,
        reason: Option<String>,
        result: Option<RunResult>,
    ) -> Result<Self, StoreError> {
        Ok(match State::from_name(name) {
            Some(State::Queued) => Self::Queued(position),
            Some(State::Running) => Self::Running,
            Some(State::Paused) => Self::Paused(position),
            Some(State::Done) => {
                let result =
                    result.ok_or_else(|| StoreError::unreadable("run", "done without a result"))?;
                Self::Done(Box::new(result))
            }
            Some(State::Failed) => Self::Failed {
                reason: reason
                    .ok_or_else(|| StoreError::unreadable("run", "failed for no reason"))?,
            },
            Some(State::Cancelled) => Self::Cancelled,
            None => return Err(StoreError::unreadable("run state", name)),
        })
    }

    /// The state's name alone.
    pub fn state(&self) -> State {
        match self {
            Self::Queued(_) => State::Queued,
            Self::Running => State::Running,
            Self::Paused(_) => State::Paused,
            Self::Done(_) => State::Done,
            Self::Failed { .. } | Self::Damaged { .. } => State::Failed,
            Self::Cancelled => State::Cancelled,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(queued: u64, running: u64, done: u64, failed: u64, cancelled: u64) -> RunCounts {
        let total = queued + running + done + failed + cancelled;
        RunCounts {
            total,
            queued,
            running,
            paused: 0,
            done,
            failed,
            cancelled,
        }
    }

    #[test]
    fn a_job_is_what_its_runs_and_its_owner_make_it() {
        let cases = [
            (Intent::Active, counts(3, 0, 0, 0, 0), State::Queued),
            (Intent::Active, counts(2, 1, 0, 0, 0), State::Running),
            (Intent::Active, counts(2, 0, 1, 0, 0), State::Running),
            (Intent::Active, counts(0, 0, 3, 0, 0), State::Done),
            (Intent::Active, counts(0, 0, 2, 1, 1), State::Failed),
            (Intent::Active, counts(0, 0, 2, 0, 1), State::Cancelled),
            (Intent::Paused, counts(1, 0, 2, 0, 0), State::Paused),
            (Intent::Paused, counts(0, 0, 3, 0, 0), State::Done),
            (Intent::Cancelled, counts(0, 1, 2, 0, 0), State::Cancelled),
        ];
        for (intent, runs, state) in cases {
            assert_eq!(intent.job_state(&runs), state, "{intent:?} {runs:?}");
        }
    }
}
