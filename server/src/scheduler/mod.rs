//! Runs on worker threads, one run a thread at a time; jobs take turns.
//!
//! What is wanted of a run stands in the store; a worker that holds the run is told to look there.

mod arenas;
mod attempt;
mod changing;
mod config;
mod control;
mod control_error;
#[cfg(test)]
mod control_tests;
mod controllers;
mod counters;
#[cfg(test)]
mod fork_tests;
mod forks;
mod live;
mod onlookers;
mod progress;
mod queue;
mod retention;
mod spread;
mod submission;
#[cfg(test)]
mod tests;
mod workers;

pub use arenas::StoredArenas;
pub use config::SchedulerConfig;
pub use control_error::ControlError;
pub use counters::Counters;
pub use live::{View, findings_of};
pub use progress::share;
pub use retention::Keep;
pub use submission::{new_job, step_cost};
use workers::Shared;
pub use workers::{Busy, Scheduler};
