//! Statistics of small samples, shared by the report on chapter 5 and the summaries of jobs.

pub mod bootstrap;
mod samples;

pub use samples::*;
