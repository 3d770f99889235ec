//! The experiments of the thesis's chapter 5 as one command: which runs, and a report of them.
//!
//! Everything here is a function of result directories; whoever runs them is `cli`'s concern.

mod claims;
mod curves;
mod document;
mod engines;
mod far_chamber;
mod maps;
mod plan;
mod published;
mod report;
mod results;
mod sections;

pub use plan::{Plan, PlannedRun, Settings};
pub use report::{replace, write_report};
