//! The one loop that steps a run: in blocks sized by the clock, until it is done, stopped or failed.
//! Whoever wants to see a run on the way is an [`Observer`]; no result depends on one.

mod block;
mod checkpoints;
mod memory;
mod pace;
#[cfg(test)]
mod tests;

use swarm::run::{Phase, Progress, Run};

use block::Block;
pub use checkpoints::Checkpoints;
pub use memory::{MemoryBound, default_run_memory_bytes};
pub use pace::Pace;

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

/// Steps a run to its end, until `is_stopping` says so between two blocks, or until an observer
/// stops it. Observers are asked in their order.
pub fn step(
    run: &mut Run,
    is_stopping: &dyn Fn() -> bool,
    observers: &mut [&mut dyn Observer],
) -> Ended {
    let ended = match blocks(run, is_stopping, observers) {
        Ok(ended) => ended,
        Err(stop) => stop.into(),
    };
    for observer in observers {
        observer.end(run, &ended);
    }
    ended
}

fn blocks(
    run: &mut Run,
    is_stopping: &dyn Fn() -> bool,
    observers: &mut [&mut dyn Observer],
) -> Result<Ended, Stop> {
    for observer in observers.iter_mut() {
        observer.begin(run)?;
    }
    let mut block = Block::default();
    let mut progress = run.progress();
    loop {
        if progress.phase == Phase::Done {
            return Ok(Ended::Done);
        }
        if is_stopping() {
            return Ok(Ended::Stopped);
        }
        let step = run.step();
        let wanted = observers
            .iter()
            .filter_map(|observer| observer.next_step_wanted(step))
            .min();
        let most = wanted.map_or(u64::MAX, |wanted| wanted.saturating_sub(step).max(1));
        progress = block.advance(run, most);
        for observer in observers.iter_mut() {
            observer.after_block(run, &progress)?;
        }
    }
}
