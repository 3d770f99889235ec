//! Recordings of runs: taken while a run is stepped, live or later from its beginning again, and
//! read back in slices and in other formats. The format itself is the crate `recording`.

mod open;
mod paths;
mod recorder;
mod sink;
mod start;
mod subject;
#[cfg(test)]
mod tests;

pub use open::OpenError;
pub use paths::{Paths, Stage};
pub use recorder::{Recorder, SharedRecorder, Tail};
pub use start::{Begun, begin, finish};
pub use subject::header;
