//! Statistics of small samples, shared by the report on chapter 5 and the summaries of jobs.

pub mod bootstrap;
mod interval;
mod paired;
mod redraws;
mod samples;
#[cfg(test)]
mod simulation_tests;

pub use interval::*;
pub use paired::*;
pub use samples::*;
