//! `loadtests http`: the service under many clients, beside runs that step on all cores.

mod load;
mod probe;
mod report;
mod tally;

pub use load::{Options, run};
