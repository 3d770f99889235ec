//! Most bytes that a run may hold, looked at now and then, so that one run does not take the
//! process and all other runs with it.

use std::num::NonZeroUsize;

use swarm::run::{Progress, Run};

use super::observer::{Observer, Stop};
use super::pace::Pace;

/// Three quarters of the machine's memory, shared by the runs that are stepped at a time.
pub fn default_run_memory_bytes(workers: NonZeroUsize) -> u64 {
    let info = rustix::system::sysinfo();
    let total = info.totalram as u64 * u64::from(info.mem_unit);
    total / 4 * 3 / workers.get() as u64
}

/// Fails a run that holds more than it may.
pub struct MemoryBound {
    most: u64,
    pace: Pace,
}

impl MemoryBound {
    /// A run may hold so many bytes.
    pub fn new(most: u64) -> Self {
        Self {
            most,
            pace: Pace::every_second(),
        }
    }
}

fn check(run: &Run, most: u64) -> Result<(), Stop> {
    let bytes = run.bytes();
    if bytes <= most {
        return Ok(());
    }
    Err(Stop::Fail(format!(
        "the run holds {bytes} bytes and may hold {most} (--run-memory-bytes): \
         give it a memory_budget_bytes, fewer robots or smaller caps of its learners"
    )))
}

impl Observer for MemoryBound {
    fn begin(&mut self, run: &Run) -> Result<(), Stop> {
        check(run, self.most)
    }

    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        let mut checked = Ok(());
        self.pace.when_due(|| checked = check(run, self.most));
        checked
    }
}
