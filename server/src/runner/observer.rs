//! Who sees a run while it is stepped.

use swarm::run::{Progress, Run};

/// Sees a run between two blocks of steps. It cannot change the run, and what it asks for changes
/// no result, only where blocks end.
pub trait Observer {
    /// Before the first block.
    ///
    /// # Errors
    /// Why the run should not be stepped at all.
    fn begin(&mut self, run: &Run) -> Result<(), Stop> {
        let _ = run;
        Ok(())
    }

    /// The next step of the arena, after `step`, that it must see: the block ends there at the
    /// latest. `None` when any will do.
    fn next_step_wanted(&self, step: u64) -> Option<u64> {
        let _ = step;
        None
    }

    /// After each block.
    ///
    /// # Errors
    /// Why the run should not be stepped on.
    fn after_block(&mut self, run: &Run, progress: &Progress) -> Result<(), Stop>;

    /// After the last block, whatever it was that ended the stepping.
    fn end(&mut self, run: &Run, ended: &Ended) {
        let _ = (run, ended);
    }
}

/// Nobody sees as much as an observer that could not be had.
impl<O: Observer> Observer for Option<O> {
    fn begin(&mut self, run: &Run) -> Result<(), Stop> {
        self.as_mut().map_or(Ok(()), |observer| observer.begin(run))
    }

    fn next_step_wanted(&self, step: u64) -> Option<u64> {
        self.as_ref()?.next_step_wanted(step)
    }

    fn after_block(&mut self, run: &Run, progress: &Progress) -> Result<(), Stop> {
        self.as_mut()
            .map_or(Ok(()), |observer| observer.after_block(run, progress))
    }

    fn end(&mut self, run: &Run, ended: &Ended) {
        if let Some(observer) = self {
            observer.end(run, ended);
        }
    }
}

/// Why an observer wants no more blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stop {
    /// Enough for now: the run can go on later.
    LetGo,
    /// The run cannot go on, for this reason.
    Fail(String),
}

/// How stepping ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The run is done.
    Done,
    /// Someone asked for it; the run can go on from where it is.
    Stopped,
    /// The run cannot go on, for this reason.
    Failed(String),
}

impl From<Stop> for Ended {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::LetGo => Ended::Stopped,
            Stop::Fail(reason) => Ended::Failed(reason),
        }
    }
}
