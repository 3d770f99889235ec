//! Who sees a run while it is stepped.

use swarm::run::{Progress, Run, Witness};

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

    /// Who sees single steps within a block for it; of several observers the first that has one.
    fn witness(&mut self) -> Option<&mut dyn Witness> {
        None
    }

    /// Most threads that the next block may use; the least that any observer says counts, and one
    /// where none says anything.
    fn threads_allowed(&self) -> Option<usize> {
        None
    }

    /// Before the run's threads become others, or none.
    fn crew_leaves(&mut self, run: &Run) {
        let _ = run;
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

    fn witness(&mut self) -> Option<&mut dyn Witness> {
        self.as_mut()?.witness()
    }

    fn threads_allowed(&self) -> Option<usize> {
        self.as_ref()?.threads_allowed()
    }

    fn crew_leaves(&mut self, run: &Run) {
        if let Some(observer) = self {
            observer.crew_leaves(run);
        }
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
    /// Not now, for a reason that may pass or not.
    Wait(Waits),
    /// The run cannot go on, for this reason.
    Fail(String),
}

/// What a run waits for that its pilot does not steer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waits {
    /// In words.
    pub why: String,
    /// Whether it can go on as soon as its controllers are there; else somebody must say so.
    pub for_controllers: bool,
}

/// How stepping ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The run is done.
    Done,
    /// Someone asked for it; the run can go on from where it is.
    Stopped,
    /// Its pilot steers no more; the run can go on from where it is.
    Waiting(Waits),
    /// The run cannot go on, for this reason.
    Failed(String),
}

impl From<Stop> for Ended {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::LetGo => Ended::Stopped,
            Stop::Wait(waits) => Ended::Waiting(waits),
            Stop::Fail(reason) => Ended::Failed(reason),
        }
    }
}
