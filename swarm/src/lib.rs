//! The simulation: robots, physics, sensing, the Ev-ITER learner, worlds, runs and snapshots.
//!
//! Nothing here knows of files, clocks, threads or HTTP. A [`run::Run`] is a state machine that is
//! stepped, saved and restored; the same spec and seed give the same bits on every machine.

pub mod bodies;
pub mod caps;
pub mod controllers;
pub mod engine;
pub mod lanes;
pub mod learn;
pub mod memory;
pub mod parameters;
pub mod placement;
mod prefetch;
pub mod random;
pub mod robot;
pub mod run;
pub mod sensors;
pub mod sharing;
pub mod spec;
mod stages;
mod validate;
pub mod world;

/// Version of what runs find: raised, with a line in the changelog, whenever a spec and a seed give
/// other results than before. It is part of every run's id.
pub const RESULTS_VERSION: u32 = 2;
