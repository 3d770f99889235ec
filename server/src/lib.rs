//! The `evswarm` program as a library: command line, run specs, artifacts, service, channels.
//!
//! Nothing in here does simulation arithmetic; that is `swarm`'s.

pub mod artifacts;
mod asked;
pub mod break_points;
pub mod channels;
pub mod cli;
pub mod documents;
mod events;
pub mod explain;
mod exports;
mod findings;
pub mod http;
mod memory;
pub mod recording;
pub mod reproduce;
pub mod runner;
pub mod scheduler;
mod statistics;
mod stop;
pub mod store;
pub mod summary;
mod tables;
mod turns;
mod watching;
