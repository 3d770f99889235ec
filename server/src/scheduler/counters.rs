//! What workers have done since the process started, counted as they do it.

use std::time::Instant;

use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use swarm::run::{Progress, Run};

use crate::runner::{Observer, Stop};

/// Counts and times; clones count together.
#[derive(Clone, Debug)]
pub struct Counters {
    /// Robot-steps done.
    pub robot_steps: Counter,
    /// Seconds that it took to write a checkpoint.
    pub checkpoint_s: Histogram,
    /// Checkpoints that could not be written.
    pub checkpoints_failed: Counter,
}

impl Default for Counters {
    fn default() -> Self {
        Self {
            robot_steps: Counter::default(),
            // From a millisecond to a quarter of a minute.
            checkpoint_s: Histogram::new(exponential_buckets(0.001, 4.0, 8)),
            checkpoints_failed: Counter::default(),
        }
    }
}

impl Counters {
    /// Times a checkpoint that this writes; it says whether it could.
    pub fn time_checkpoint(&self, write: impl FnOnce() -> bool) {
        let start = Instant::now();
        if write() {
            self.checkpoint_s.observe(start.elapsed().as_secs_f64());
        } else {
            self.checkpoints_failed.inc();
        }
    }
}

/// Counts the robot-steps of a run from where it stands.
pub struct CountedSteps {
    counters: Counters,
    done: u64,
}

impl CountedSteps {
    /// Of a run that has done so many.
    pub fn new(counters: &Counters, done: u64) -> Self {
        Self {
            counters: counters.clone(),
            done,
        }
    }
}

impl Observer for CountedSteps {
    fn after_block(&mut self, _: &Run, progress: &Progress) -> Result<(), Stop> {
        let more = progress.robot_steps_done - self.done;
        self.counters.robot_steps.inc_by(more);
        self.done = progress.robot_steps_done;
        Ok(())
    }
}
