//! The experiments of the thesis's chapter 5 as one command: which runs, and a report of them.
//!
//! Everything here is a function of stored results; who has the runs stepped is `cli`'s and
//! `http`'s concern.

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

pub use claims::Claims;
pub use plan::{Plan, Settings};
pub use report::{Report, replace};
