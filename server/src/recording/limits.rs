//! What recordings may take: of a run, of a job, and in all.

use api::FieldError;

use crate::documents::{MOST_RECORDING_BYTES, ResolvedRun, check_job_recordings};

/// Most bytes of recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Of those of a run.
    pub run_bytes: u64,
    /// Of those of a job's runs.
    pub job_bytes: u64,
    /// Of all.
    pub all_bytes: u64,
}

impl Limits {
    /// Unless it is said otherwise.
    pub const DEFAULT: Self = Self {
        run_bytes: 4 << 30,
        job_bytes: 8 << 30,
        all_bytes: 16 << 30,
    };

    /// Most bytes of those of a job's runs, which are among all.
    pub fn of_a_job(&self) -> u64 {
        self.job_bytes.min(self.all_bytes)
    }

    /// Most bytes of those of a run, which are among those of its jobs.
    pub fn of_a_run(&self) -> u64 {
        self.run_bytes.min(self.of_a_job())
    }

    /// Most bytes of one recording.
    pub fn of_one(&self) -> u64 {
        self.of_a_run().min(MOST_RECORDING_BYTES)
    }

    /// Whether what the runs of a job are to record of themselves fits.
    ///
    /// # Errors
    /// What would.
    pub fn check_job(&self, runs: &[ResolvedRun]) -> Result<(), Vec<FieldError>> {
        check_job_recordings(runs, self.of_a_run(), self.of_a_job()).map_err(|mut error| {
            error.pointer.insert_str(0, "/base");
            vec![error]
        })
    }
}
