//! Steps a run again before a watcher.

use api::explanation::Explanation;
use swarm::run::{Phase, Progress, Run, StagePlan, Witness};
use swarm::spec::Method;

use super::watch::Watcher;
use super::words::{About, explanation};
use crate::runner::{self, Ended, Observer, Stop};

/// Why a run is neither explained nor recorded afterwards that was steered from outside.
pub const NOT_STEPPED_AGAIN: &str = "a program outside steers the run, which cannot be stepped again \
     without it: say `record` in the spec of a run that is to be recorded";

/// Why a run is not explained.
#[derive(Debug, thiserror::Error)]
pub enum ExplainError {
    /// Whoever asked gave up.
    #[error("it was given up")]
    Stopped,
    /// The run cannot be stepped.
    #[error("{0}")]
    Failed(String),
}

struct Watching(Watcher);

impl Observer for Watching {
    fn after_block(&mut self, _: &Run, _: &Progress) -> Result<(), Stop> {
        Ok(())
    }

    fn witness(&mut self) -> Option<&mut dyn Witness> {
        Some(&mut self.0)
    }
}

/// Explains a run that stands where it begins. `beside` sees it too, as for how far it is.
///
/// # Errors
/// When the run cannot be stepped to its end, or `is_stopping` says so.
pub fn explain(
    mut run: Run,
    is_stopping: &dyn Fn() -> bool,
    beside: &mut [&mut dyn Observer],
) -> Result<Explanation, ExplainError> {
    if run.spec().controller.method == Method::External {
        return Err(ExplainError::Failed(NOT_STEPPED_AGAIN.to_owned()));
    }
    let begun = run.progress().robot_steps_done;
    let mut watching = Watching(Watcher::new(&run));
    let mut observers: Vec<&mut dyn Observer> = vec![&mut watching];
    observers.extend(
        beside
            .iter_mut()
            .map(|observer| &mut **observer as &mut dyn Observer),
    );
    let ended = runner::step(&mut run, is_stopping, &mut observers);
    match ended {
        Ended::Done => {}
        Ended::Stopped => return Err(ExplainError::Stopped),
        Ended::Failed(reason) => return Err(ExplainError::Failed(reason)),
        Ended::Waiting(waits) => return Err(ExplainError::Failed(waits.why)),
    }
    let Watching(mut watcher) = watching;
    watcher.end(&run);
    let before = run.plan();
    let before = before
        .iter()
        .take_while(|stage| stage.phase != Phase::Exploration);
    let about = About {
        robots: run.spec().robots,
        steps_per_epoch: run.spec().steps_per_epoch,
        first_counted_epoch: before.map(StagePlan::arena_epochs).sum(),
        robot_steps: run.progress().robot_steps_done - begun,
    };
    Ok(explanation(&watcher, &about))
}
