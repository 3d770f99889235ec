//! Jobs of which store and queue are being changed together, each by one request at a time, so that
//! both see changes in one order.

use std::collections::BTreeSet;
use std::sync::{Condvar, Mutex, PoisonError};

use crate::store::JobKey;

/// The jobs that are being changed.
#[derive(Default)]
pub struct Changing {
    jobs: Mutex<BTreeSet<JobKey>>,
    changed_one: Condvar,
}

/// While it lives, a job is changed by whoever has it alone.
pub struct Change<'a> {
    changing: &'a Changing,
    job: JobKey,
}

impl Changing {
    /// Waits until nobody else changes the job.
    pub fn begin(&self, job: JobKey) -> Change<'_> {
        let jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        let is_changed = |jobs: &mut BTreeSet<JobKey>| jobs.contains(&job);
        let mut jobs = self
            .changed_one
            .wait_while(jobs, is_changed)
            .unwrap_or_else(PoisonError::into_inner);
        jobs.insert(job);
        Change {
            changing: self,
            job,
        }
    }
}

impl Drop for Change<'_> {
    fn drop(&mut self) {
        let jobs = &self.changing.jobs;
        let mut jobs = jobs.lock().unwrap_or_else(PoisonError::into_inner);
        jobs.remove(&self.job);
        drop(jobs);
        self.changing.changed_one.notify_all();
    }
}
