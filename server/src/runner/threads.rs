//! How many threads a run is stepped on: asked before each block, as others may need them then.

use swarm::run::{Progress, Run};

use super::observer::{Observer, Stop};
use crate::artifacts::thread_cpu_s;

/// Allows threads, and measures what those besides the run's own have done.
pub struct Threads<Allowed> {
    allowed: Allowed,
    cpu_s: f64,
}

impl<Allowed: Fn() -> usize> Threads<Allowed> {
    /// As many as `allowed` says, the run's own included.
    pub fn new(allowed: Allowed) -> Self {
        Self {
            allowed,
            cpu_s: 0.0,
        }
    }

    /// Processor time of the threads besides the run's own, seconds.
    pub fn cpu_s(&self) -> f64 {
        self.cpu_s
    }
}

impl<Allowed: Fn() -> usize> Observer for Threads<Allowed> {
    fn threads_allowed(&self) -> Option<usize> {
        Some((self.allowed)())
    }

    fn after_block(&mut self, _: &Run, _: &Progress) -> Result<(), Stop> {
        Ok(())
    }

    fn crew_leaves(&mut self, run: &Run) {
        self.cpu_s += run.crew().each_thread(thread_cpu_s).iter().sum::<f64>();
    }
}
