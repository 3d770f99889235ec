//! Reports, which are dear to make and asked for again.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hashlink::LruCache;

use crate::reproduce::Report;
use crate::store::JobKey;

/// Reports kept, of some megabytes each.
const REPORTS: usize = 4;

/// Of jobs that are done, with so many runs: more come and some go, but of a job with a report it is
/// known which. No job's number is used again.
type Reports = LruCache<(JobKey, u64), Arc<Report>>;

/// The latest; the least recently used give way.
pub struct Kept(Mutex<Reports>);

impl Default for Kept {
    fn default() -> Self {
        Self(Mutex::new(LruCache::new(REPORTS)))
    }
}

impl Kept {
    /// The report of this job with so many runs, made only if it is not kept, and kept only if it can
    /// be made: without the lock, at worst twice at a time.
    pub fn report<E>(
        &self,
        job: (JobKey, u64),
        make: impl FnOnce() -> Result<Report, E>,
    ) -> Result<Arc<Report>, E> {
        if let Some(report) = self.reports().get(&job) {
            return Ok(Arc::clone(report));
        }
        let report = Arc::new(make()?);
        self.reports().insert(job, Arc::clone(&report));
        Ok(report)
    }

    fn reports(&self) -> MutexGuard<'_, Reports> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
