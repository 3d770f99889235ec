//! Recordings of runs: taken while a run is stepped, live or later from its beginning again, and
//! read back in slices and in other formats. The format itself is the crate `recording`.

mod answers;
mod explained;
mod film;
mod kept;
mod limits;
mod maker;
mod making;
mod mcap_file;
mod open;
mod origin;
mod paths;
mod play;
mod recorder;
mod room;
mod rows;
mod sink;
mod slice;
mod start;
mod subject;
#[cfg(test)]
mod tests;
mod wish;

pub use answers::{Answers, AnswersError};
pub use explained::known_explanation;
pub use film::Film;
pub use kept::Keeper;
pub use limits::Limits;
pub use maker::{AskError, Explained, Maker, Settings, live_state};
pub use mcap_file::write_mcap;
pub use open::OpenError;
pub use origin::{begin_at_origin, first_whole_epoch};
pub use paths::{Paths, Stage, remove};
pub use play::{View, lines};
pub use recorder::{Recorder, SharedRecorder, Tail};
pub use rows::write_rows;
pub use slice::{Moments, SliceError, SliceQuery, epoch_of, head, slice, step_of};
pub use start::{Begun, begin, finish};
pub use subject::header;
pub use wish::Wish;
