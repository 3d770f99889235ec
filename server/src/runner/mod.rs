//! The one loop that steps a run: in blocks sized by the clock, until it is done, stopped or failed.
//! Whoever wants to see a run on the way is an [`Observer`]; no result depends on one.

mod block;
mod checkpoints;
mod memory;
mod observer;
mod pace;
mod pause;
mod pilot;
#[cfg(test)]
mod tests;
mod threads;
mod waiting;

use swarm::crew::Crew;
use swarm::run::{Phase, Run};

use block::Block;
pub use checkpoints::Checkpoints;
pub use memory::{MemoryBound, default_run_memory_bytes};
pub use observer::{Ended, Observer, Stop, Waits};
pub use pace::Pace;
pub use pause::PauseAt;
pub use pilot::Pilot;
pub use threads::Threads;
pub use waiting::{Attendant, Wait};

/// Steps a run to its end, until `is_stopping` says so between two blocks, or until an observer
/// stops it. Observers are asked in their order.
pub fn step(
    run: &mut Run,
    is_stopping: &dyn Fn() -> bool,
    observers: &mut [&mut dyn Observer],
) -> Ended {
    step_by(run, None, is_stopping, observers)
}

/// As [`step`], with a pilot that steers the robots.
pub fn step_by(
    run: &mut Run,
    pilot: Option<&mut dyn Pilot>,
    is_stopping: &dyn Fn() -> bool,
    observers: &mut [&mut dyn Observer],
) -> Ended {
    let ended = match blocks(run, pilot, is_stopping, observers) {
        Ok(ended) => ended,
        Err(stop) => stop.into(),
    };
    for observer in observers {
        observer.crew_leaves(run);
        observer.end(run, &ended);
    }
    ended
}

fn blocks(
    run: &mut Run,
    mut pilot: Option<&mut dyn Pilot>,
    is_stopping: &dyn Fn() -> bool,
    observers: &mut [&mut dyn Observer],
) -> Result<Ended, Stop> {
    for observer in observers.iter_mut() {
        observer.begin(run)?;
    }
    let mut block = Block::default();
    let mut progress = run.progress();
    let mut threads = 1;
    loop {
        if progress.phase == Phase::Done {
            return Ok(Ended::Done);
        }
        if is_stopping() {
            return Ok(Ended::Stopped);
        }
        let allowed = observers
            .iter()
            .filter_map(|observer| observer.threads_allowed())
            .min();
        let allowed = allowed.unwrap_or(1).min(run.spec().robots as usize);
        if threads != allowed {
            for observer in observers.iter_mut() {
                observer.crew_leaves(run);
            }
            run.set_crew(Crew::new(allowed));
            threads = allowed;
        }
        let step = run.step();
        let wanted = observers
            .iter()
            .filter_map(|observer| observer.next_step_wanted(step))
            .min();
        let most = wanted.map_or(u64::MAX, |wanted| wanted.saturating_sub(step).max(1));
        let witness = observers.iter_mut().find_map(|observer| observer.witness());
        progress = match &mut pilot {
            None => block.advance(run, most, witness),
            Some(pilot) => block.fly(run, most, *pilot, witness)?,
        };
        for observer in observers.iter_mut() {
            observer.after_block(run, &progress)?;
        }
    }
}
