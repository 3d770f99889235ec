//! A run that is to stop at a certain step, exactly.

use swarm::run::{Progress, Run};

use super::observer::{Observer, Stop};

/// Lets go of a run at a step of its arena.
#[derive(Clone, Copy, Debug)]
pub struct PauseAt(pub u64);

impl PauseAt {
    /// Whether the run has come there.
    pub fn is_reached(self, run: &Run) -> bool {
        run.step() >= self.0
    }

    fn check(self, run: &Run) -> Result<(), Stop> {
        if self.is_reached(run) {
            Err(Stop::LetGo)
        } else {
            Ok(())
        }
    }
}

impl Observer for PauseAt {
    fn begin(&mut self, run: &Run) -> Result<(), Stop> {
        self.check(run)
    }

    fn next_step_wanted(&self, _: u64) -> Option<u64> {
        Some(self.0)
    }

    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.check(run)
    }
}
