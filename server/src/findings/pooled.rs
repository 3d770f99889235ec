//! What is pooled of a job's finished runs, and what was covered by one that is done: made once for
//! all who ask the same while no other run has finished.

use bytes::Bytes;

use super::{Assembler, FindingsError};
use crate::store::JobView;

impl Assembler {
    /// What is asked of a job's finished runs, as bytes, made only where nobody has made it since
    /// the last of them finished.
    ///
    /// # Errors
    /// When the store fails, another makes it for too long, or it cannot be made.
    pub fn pooled<E: From<FindingsError>>(
        &self,
        job: &JobView,
        asked: &str,
        make: impl FnOnce() -> Result<Vec<u8>, E>,
    ) -> Result<Bytes, E> {
        let done = self.store.done_runs_sha256(job.seq);
        let done = hex::encode(done.map_err(FindingsError::from)?);
        let key = format!("{asked} of job {} {done}", job.seq);
        self.once(&key, || make().map(Bytes::from))
    }

    /// What this key names, made only where nobody has made it.
    pub(super) fn once<E: From<FindingsError>>(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<Bytes, E>,
    ) -> Result<Bytes, E> {
        let made = self.once.get(key, make);
        made.unwrap_or_else(|| Err(FindingsError::BeingMade.into()))
    }
}
