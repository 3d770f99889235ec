//! What a job of the template `chapter-5` says of the thesis's claims.

use std::sync::Arc;

use super::{Assembler, FindingsError};
use crate::reproduce::{Plan, Report};
use crate::store::JobView;

impl Assembler {
    /// The report on a job, which must be done.
    ///
    /// # Errors
    /// When the job is of another kind, not done, or its runs cannot be read.
    pub fn report(&self, job: &JobView) -> Result<Arc<Report>, FindingsError> {
        let (seq, counts) = (job.seq, job.counts);
        self.kept.report((seq, counts.total), || {
            let failed = |error: anyhow::Error| {
                FindingsError::broken(format!("job {seq}"), format!("{error:#}"))
            };
            let runs = self.store.all_runs(seq)?;
            let Some(plan) = Plan::of_job(seq, &runs, &self.store).map_err(failed)? else {
                return Err(FindingsError::NoReport(seq));
            };
            if counts.done < counts.total {
                return Err(FindingsError::Unfinished {
                    done: counts.done,
                    total: counts.total,
                });
            }
            Report::new(&plan, &self.store).map_err(failed)
        })
    }
}
