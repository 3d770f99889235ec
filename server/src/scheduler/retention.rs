//! Jobs that have ended and are kept no longer: too old, or too large together. Off unless asked for.

use super::Scheduler;
use crate::store::{JobKey, StoreError};

/// What is kept of jobs that have ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// Days since a job was first seen to have ended; for ever when not given.
    pub days: Option<u64>,
    /// Bytes that what ended jobs found takes together, about; the oldest go first.
    pub bytes: Option<u64>,
}

impl Keep {
    /// Whether anything is ever deleted.
    pub fn is_limited(&self) -> bool {
        self.days.is_some() || self.bytes.is_some()
    }
}

impl Scheduler {
    /// Deletes what is kept no longer, and says so in the log. A job with a run that waits or runs
    /// has not ended. Returns the jobs that are gone.
    ///
    /// # Errors
    /// When the store fails; what is deleted till then is.
    pub fn retain(&self, keep: &Keep) -> Result<Vec<JobKey>, StoreError> {
        let store = &self.shared.store;
        let ended = store.ended_jobs()?;
        let mut bytes: u64 = ended.iter().map(|job| job.bytes).sum();
        let mut gone = Vec::new();
        for job in ended {
            let too_old = keep.days.is_some_and(|days| job.days >= days as f64);
            let too_large = keep.bytes.is_some_and(|most| bytes > most);
            if !too_old && !too_large {
                continue;
            }
            let _changing = self.changing.begin(job.seq);
            // It may have been tried again or extended since it was looked at.
            if !store.has_ended(job.seq)? {
                continue;
            }
            self.delete_changing(job.seq)?;
            bytes = bytes.saturating_sub(job.bytes);
            let why = if too_old {
                "it is too old"
            } else {
                "there are too many bytes"
            };
            tracing::info!(
                job = %job.seq,
                name = job.name,
                runs = job.runs,
                bytes = job.bytes,
                ended_days_ago = job.days,
                why,
                "a job that has ended was deleted, as the settings of the server ask for"
            );
            gone.push(job.seq);
        }
        Ok(gone)
    }
}
