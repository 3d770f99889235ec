//! The simulation: robots, physics, sensing, the Ev-ITER learner, worlds, runs and snapshots.
//!
//! Nothing here knows of files, clocks or HTTP. A [`run::Run`] is a state machine that is stepped,
//! saved and restored; the same spec and seed give the same bits on every machine and on any number
//! of threads ([`crew`]).
//!
//! ```
//! use std::sync::Arc;
//!
//! use swarm::run::Run;
//! use swarm::spec::{Method, RunSpec};
//!
//! let arena = Arc::new(arenas::builtin("maze").expect("an arena that comes with the program"));
//! let mut spec = RunSpec::new(Method::Brownian, arena);
//! (spec.epochs, spec.steps_per_epoch) = (3, 200);
//! let mut run = Run::new(spec.validate().expect("a valid spec")).expect("room for the robot");
//! run.advance(100);
//! let saved = run.snapshot();
//! run.advance(u64::MAX);
//! let outcome = run.outcome().expect("all epochs are done");
//! assert_eq!(outcome.coverage.epoch, 3);
//!
//! let mut again = Run::restore(run.spec().clone().validate().expect("as before"), &saved)?;
//! again.advance(u64::MAX);
//! assert_eq!(again.outcome(), Some(outcome));
//! # Ok::<(), swarm::run::RestoreError>(())
//! ```
//!
//! # Rooms
//!
//! No file imports one above it, and none imports another in a circle. From the ground up:
//!
//! - Numbers: [`dimensions`], [`lanes`] (eight at a time), `backend` (which instructions), [`random`]
//!   (a number for each seed, site, robot, purpose and counter), [`crew`] (threads), [`saved_bytes`].
//! - Plain data: [`parameters`] (tables that document themselves), [`robot`] (body, wheels, sensors),
//!   [`spec`] (what a run is made from), [`bodies`] (robots and objects, and what sensors read),
//!   [`caps`] (what a learner may hold), `stages` (what a stage of a run is).
//! - [`kept`]: what follows from arena and body alone, for the next run.
//! - The physical side: [`sensors`], [`engine`] (what moves a robot), [`placement`] (where robots
//!   start).
//! - Learning: [`learn`] (the algorithms, each alone), [`controllers`] (what a robot can be doing),
//!   [`sharing`] (what robots tell each other), [`methods`] (what each method is: its stages, its
//!   parameters, its walk), [`memory`] (fits caps to a budget).
//! - [`world`] puts robots, sensors, engine and controllers together, step by step; `validate` makes
//!   a [`ValidSpec`] of a spec; [`metrics`] measures what was counted; [`run`] takes a spec through
//!   its stages.

mod backend;
pub mod bodies;
pub mod caps;
pub mod controllers;
pub mod crew;
pub mod dimensions;
pub mod engine;
pub mod kept;
pub mod lanes;
pub mod learn;
pub mod memory;
pub mod methods;
pub mod metrics;
pub mod parameters;
pub mod placement;
mod prefetch;
pub mod random;
pub mod robot;
pub mod run;
pub mod saved_bytes;
pub mod sensors;
pub mod sharing;
pub mod spec;
mod stages;
mod validate;
pub mod world;

pub use validate::ValidSpec;

/// Version of what runs find: raised, with a line in the changelog, whenever a spec and a seed give
/// other results than before. It is part of every run's id.
pub const RESULTS_VERSION: u32 = 3;
