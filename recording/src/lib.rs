//! The recording format: what robots did over time, quantised, delta-coded and compressed in blocks
//! that can be read one by one. Knows nothing of the simulation; `docs/recordings.md` has the layout.
//!
//! From the ground up: [`Header`] (what a recording is of), [`Layout`] (which sample stands in which
//! block: a matter of the header alone, so that the same samples give the same bytes wherever the
//! recording began), [`Raw`] (samples as they are taken) and [`Samples`] (as they are kept), blocks,
//! and files of blocks with an index at their end.

mod block;
mod columns;
mod error;
mod file;
mod header;
mod layout;
mod planes;
mod predict;
mod raw;
mod reader;
mod samples;
#[cfg(test)]
mod tests;
mod units;

pub use error::RecordingError;
pub use file::Writer;
pub use header::{Chosen, DriveModel, Fields, Header, StageMark};
pub use layout::{Layout, SamplePlace};
pub use raw::Raw;
pub use reader::{Lack, Reader};
pub use samples::{Decision, Samples};

pub use units::{SENSORS, TICKS_PER_COMMAND, TICKS_PER_M, TICKS_PER_RAD};
